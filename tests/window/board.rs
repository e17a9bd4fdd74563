//! The window's Device panel with a virtual board: drags on the screen arrive over a real line.

use std::net::UdpSocket;
use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use egui::{Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use glam::DVec2;
use sonoglyph::device::board::{Board, Setup, Shown};
use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::health::State;
use sonoglyph::device::levels::Levels;
use sonoglyph::device::profile::Profile;
use sonoglyph::device::wiring::Wiring;
use sonoglyph::field::Quantity;
use sonoglyph::scene::{Envelope, LiquidName, Motion, MotionPath, Scene, Wire, Wires};
use sonoglyph::ui::board::Plays;
use sonoglyph::ui::document::Document;
use sonoglyph::ui::view::Lens;
use sonoglyph::ui::{Command, Moment, Panel};

use super::{Screen, window};

const PATIENCE: Duration = Duration::from_secs(60);
const POINT: &str = "format = 1\n[[target]]\nkind = \"point\"\nat = [0.0, 0.0, 0.1]\n";

pub fn until(screen: &mut Screen, what: &str, condition: impl Fn(&Screen) -> bool) {
    let start = Instant::now();
    while !condition(screen) {
        assert!(
            start.elapsed() < PATIENCE,
            "timed out waiting for {what}; {:?}",
            screen.state().shown().board
        );
        std::thread::sleep(Duration::from_millis(5));
        screen.step();
    }
    // Buttons move when a board is lost or found, so the layout needs further frames.
    screen.run_steps(2);
}

/// The window on one point, with its Device panel connected to a virtual board.
fn connected(profile: Profile) -> (Screen, Board, Receiver<Shown>) {
    let (sender, shown) = sync_channel(100_000);
    let watch = move |frame: &Shown| drop(sender.try_send(frame.clone()));
    let board = Board::start(Setup::new(profile), Box::new(watch)).unwrap();
    let screen = connected_to(board.path(), profile, POINT);
    (screen, board, shown)
}

/// The window on a scene, with its Device panel connected to a board at a port.
pub fn connected_to(port: &Path, profile: Profile, scene: &str) -> Screen {
    let scene = sonoglyph::scene::file::parse(scene, "point.toml".as_ref()).unwrap();
    let mut screen =
        Harness::builder().with_size(vec2(1280.0, 800.0)).build_eframe(|context| window(&context.egui_ctx));
    let editor = screen.state_mut().editor_mut();
    editor.replace(Document::new(scene, "point"));
    editor.panel = Panel::Device;
    editor.was_warned = true;
    editor.board.profile = profile;
    editor.board.port = port.display().to_string();
    screen.run_steps(4);
    screen.get_by_label("Connect").click();
    let is_ready = |screen: &Screen| {
        screen.state().shown().board.health.as_ref().is_some_and(|health| health.state == State::Ready)
    };
    until(&mut screen, "the board", is_ready);
    screen
}

/// The levels of the scene's solution for the board.
fn wanted(screen: &Screen, profile: Profile) -> Levels {
    let solution = screen.state().shown().solution.as_ref().unwrap();
    Wiring::own(profile).levels(&solution.drive, &Calibration::default()).unwrap()
}

fn place(screen: &Screen, x: f64, y: f64) -> Pos2 {
    let map = screen.state().shown().map.as_ref().unwrap();
    Lens { rect: map.rect, window: map.window }.screen(DVec2::new(x, y) * 1e-3)
}

/// Waits for a frame.
fn arrives(screen: &mut Screen, shown: &Receiver<Shown>, levels: &Levels) {
    let start = Instant::now();
    while shown.try_recv().map_or(true, |shown| shown.levels != *levels) {
        assert!(start.elapsed() < PATIENCE, "{:?}", screen.state().shown().board);
        std::thread::sleep(Duration::from_millis(2));
        screen.step();
    }
    screen.run_steps(2);
}

fn is_silent(board: &Board) -> bool {
    board.report().playing.unwrap().drive().amplitudes.iter().all(|&amplitude| amplitude == 0.0)
}

#[test]
fn what_is_felt_most_of_a_drawing_is_played() {
    let (mut screen, _board, _shown) = connected(Profile::Native);
    screen.set_size(vec2(1280.0, 1400.0));
    screen.run_steps(2);
    screen.get_by_label("Ways of playing").click();
    let is_there = |screen: &Screen| screen.query_by_label("Play what is felt most").is_some();
    until(&mut screen, "the ways", is_there);
    let best = screen.state().editor().parts.ways.newest().unwrap().as_ref().unwrap()[0].clone();
    screen.get_by_label("Play what is felt most").click();
    until(&mut screen, "the best way", |screen| {
        let felt = screen.state().editor().parts.feeling.exact();
        let level = felt.and_then(|felt| Some(felt.as_ref().ok()?.felt.level));
        screen.state().shown().board.plays != Plays::Nothing
            && level.is_some_and(|level| (level - best.felt.level).abs() < 0.01)
    });
    let scene = &screen.state().editor().document.scene;
    assert_eq!((&scene.modulation, &scene.motion), (&best.scene.modulation, &best.scene.motion));
    assert!(best.felt.level > 30.0, "{best:?}");
}

#[test]
fn a_dragged_target_is_played() {
    for profile in [Profile::Native, Profile::SonicSurface] {
        let (mut screen, board, shown) = connected(profile);
        until(&mut screen, "silence", |_| is_silent(&board));
        screen.get_by_label("Send").click();
        screen.run_steps(2);
        let first = wanted(&screen, profile);
        arrives(&mut screen, &shown, &first);
        // The point and its field follow the pointer.
        let from = place(&screen, 0.0, 0.0);
        screen.hover_at(from);
        screen.step();
        screen.drag_at(from);
        screen.step();
        for part in [0.4, 1.0] {
            let to = place(&screen, 15.0 * part, -10.0 * part);
            screen.hover_at(to);
            screen.run_steps(2);
            let now = wanted(&screen, profile);
            assert_ne!(now, first);
            arrives(&mut screen, &shown, &now);
        }
        // Unplugged during the drag: the window reports it, and continues when the board returns.
        board.unplug(true);
        let is_lost = |screen: &Screen| {
            let lost = screen.state().shown().notice.as_ref();
            lost.is_some_and(|notice| notice.is_error && notice.text.contains("lost"))
        };
        until(&mut screen, "a word", is_lost);
        for name in ["Send scene", "Single element", "Checkerboard"] {
            assert!(screen.get_by_label(name).accesskit_node().is_disabled(), "{name}: there is no board");
        }
        let to = place(&screen, 20.0, 5.0);
        screen.hover_at(to);
        screen.run_steps(2);
        screen.drop_at(to);
        screen.run_steps(2);
        let newest = wanted(&screen, profile);
        board.unplug(false);
        arrives(&mut screen, &shown, &newest);
        until(&mut screen, "sound", |_| !is_silent(&board));
        screen.get_by_label("Stop").click();
        until(&mut screen, "silence", |_| is_silent(&board));
        press(&mut screen, "Send");
        arrives(&mut screen, &shown, &newest);
        until(&mut screen, "sound", |_| !is_silent(&board));
        // A scene without targets is silent, and so is the board after the window has closed.
        let targets = std::mem::take(&mut screen.state_mut().editor_mut().document.scene.targets);
        until(&mut screen, "silence", |_| is_silent(&board));
        screen.state_mut().editor_mut().document.scene.targets = targets;
        until(&mut screen, "sound", |_| !is_silent(&board));
        drop(screen);
        let start = Instant::now();
        while !is_silent(&board) {
            assert!(start.elapsed() < PATIENCE, "the board still sounds after the window");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

#[test]
fn a_client_silences_the_board_between_two_frames() {
    let (mut screen, board, _) = connected(Profile::SonicSurface);
    screen.state_mut().editor_mut().asked_by_others.push(Command::Serve(true));
    screen.get_by_label("Send").click();
    until(&mut screen, "sound", |screen| screen.state().shown().serving.is_some() && !is_silent(&board));
    let addresses = screen.state().shown().serving.clone().unwrap().addresses;
    let client = UdpSocket::bind("127.0.0.1:0").unwrap();
    client.connect(addresses[0].strip_prefix("OSC on udp://").unwrap()).unwrap();
    client.send(b"/sonoglyph/stop\0,\0\0\0").unwrap();
    // The window draws nothing meanwhile.
    let start = Instant::now();
    while !is_silent(&board) {
        assert!(start.elapsed() < PATIENCE, "silence waits for a frame");
        std::thread::sleep(Duration::from_millis(2));
    }
    screen.run_steps(4);
    assert_eq!(screen.state().shown().board.plays, Plays::Nothing);
    assert!(is_silent(&board), "a later frame sounds");
    screen.get_by_label("Send").click();
    until(&mut screen, "sound", |_| !is_silent(&board));
}

#[test]
fn the_window_is_at_hand_while_a_scene_is_solved() {
    let (mut screen, board, _) = connected(Profile::SonicSurface);
    screen.get_by_label("Send").click();
    until(&mut screen, "sound", |_| !is_silent(&board));
    // No solver ends it in a minute.
    let slow = "format = 1\n[[target]]\nkind = \"circle\"\nat = [0, 0, 0.1]\nradius = 0.05\npoints = 100\n\
                [solver]\nmethod = \"greedy\"\niterations = 100000\n";
    let slow = sonoglyph::scene::file::parse(slow, "slow.toml".as_ref()).unwrap();
    let before = std::mem::replace(&mut screen.state_mut().editor_mut().document.scene, slow);
    screen.run_steps(3);
    screen.get_by_label("Stop").click();
    until(&mut screen, "silence", |_| is_silent(&board));
    assert!(screen.state().shown().pending.is_some(), "it is not being solved");
    screen.state_mut().editor_mut().document.scene = before;
    until(&mut screen, "the newest scene", |screen| screen.state().shown().pending.is_none());
    let shown = screen.state().shown();
    assert_eq!(shown.solution.as_ref().unwrap().foci.len(), 1);
    until(&mut screen, "the end of the other", |screen| !screen.state().is_busy());
}

#[test]
fn a_steady_scene_is_modulated_by_one_click() {
    const OFFER: &str = "Modulate at 200 Hz";
    let (mut screen, _board, _) = connected(Profile::Native);
    screen.get_by_label(OFFER).click();
    screen.run_steps(3);
    let modulation = screen.state().editor().scene().modulation.clone();
    assert_eq!((modulation.shape, modulation.frequency), (Envelope::Sine, 200.0));
    assert!(screen.query_by_label(OFFER).is_none());
    screen.state_mut().editor_mut().undo();
    screen.run_steps(3);
    assert!(screen.query_by_label(OFFER).is_some(), "undone");
    // A liquid needs steady sound: in the scene, or in view.
    screen.state_mut().editor_mut().view.quantity = Quantity::Depression;
    screen.run_steps(3);
    assert!(screen.query_by_label(OFFER).is_none());
    screen.state_mut().editor_mut().view.quantity = Quantity::Rms;
    screen.state_mut().editor_mut().document.scene.liquid.name = Some(LiquidName::Water);
    screen.run_steps(3);
    assert!(screen.query_by_label(OFFER).is_none());
}

#[test]
fn a_wired_array_is_played_and_tested_by_element() {
    let (mut screen, board, shown) = connected(Profile::SonicSurface);
    let wire = |n: u32| (n != 9).then(|| Wire { channel: 255 - 3 * n, line: u64::from(n) + 2 });
    let array = &mut screen.state_mut().editor_mut().document.scene.array;
    (array.columns, array.rows) = (8, 8);
    array.wiring = Some("w.csv".to_owned());
    array.wires = Wires::new((0..64).map(wire).collect(), false, None);
    screen.run_steps(8);
    screen.get_by_label("Send").click();
    screen.run_steps(2);
    let drive = screen.state().shown().solution.as_ref().unwrap().drive.clone();
    let mut levels = Levels::off(Profile::SonicSurface);
    for n in (0..64).filter(|&n| n != 9) {
        levels.channels[255 - 3 * n] = Profile::SonicSurface.level(1.0, drive.phases[n]);
    }
    arrives(&mut screen, &shown, &levels);
    assert_eq!(drive.amplitudes[9], 0.0, "it cannot sound");
    // The warnings of this board push the buttons down.
    screen.set_size(vec2(1280.0, 1000.0));
    screen.state_mut().editor_mut().board.element = 37;
    screen.run_steps(4);
    screen.get_by_label("Single element").click();
    screen.run_steps(2);
    arrives(&mut screen, &shown, &Levels::one(Profile::SonicSurface, 255 - 3 * 37));
    screen.get_by_label("Disconnect").click();
    until(&mut screen, "silence", |_| is_silent(&board));
}

#[test]
fn elements_are_tested_one_by_one() {
    let (mut screen, board, shown) = connected(Profile::SonicSurface);
    screen.state_mut().editor_mut().board.element = 37;
    screen.step();
    screen.get_by_label("Single element").click();
    screen.run_steps(2);
    assert_eq!(screen.state().shown().board.plays, Plays::One(37));
    arrives(&mut screen, &shown, &Wiring::own(Profile::SonicSurface).one(37));
    screen.get_by_label("Checkerboard").click();
    screen.run_steps(2);
    arrives(&mut screen, &shown, &Wiring::own(Profile::SonicSurface).checkerboard(16));
    screen.get_by_label("Disconnect").click();
    until(&mut screen, "silence", |_| is_silent(&board));
}

#[test]
fn an_array_of_another_shape_is_refused_with_a_message() {
    let (mut screen, board, _) = connected(Profile::SonicSurface);
    let array = &mut screen.state_mut().editor_mut().document.scene.array;
    (array.rows, array.columns) = (8, 32);
    screen.run_steps(4);
    screen.get_by_label("Send").click();
    let is_refused = |screen: &Screen| {
        let notice = screen.state().shown().notice.as_ref();
        notice.is_some_and(|notice| notice.is_error && notice.text.contains("SonicSurface is 16 x 16"))
    };
    until(&mut screen, "a word", is_refused);
    assert_eq!(screen.state().shown().board.plays, Plays::Nothing);
    assert!(is_silent(&board));
}

#[test]
fn a_virtual_board_is_a_port_that_is_remembered_and_reported_as_unconfirmed() {
    let folder = tempfile::tempdir().unwrap();
    let there = folder.path().to_owned();
    let open_there = || {
        let there = there.clone();
        let mut screen = Harness::builder().with_size(vec2(1280.0, 800.0)).build_eframe(move |context| {
            let mut opened = window(&context.egui_ctx);
            opened.remember_in(&there, &context.egui_ctx);
            opened
        });
        screen.run_steps(4);
        screen
    };
    let board = Board::start(Setup::new(Profile::SonicSurface), Box::new(|_| {})).unwrap();
    let name = board.path().display().to_string();
    {
        let mut screen = open_there();
        screen.get_by_label("Device").click();
        screen.run_steps(4);
        screen.get_by_label("Choose…").click();
        screen.run_steps(4);
        screen.get_by_label(&format!("{name} (virtual board, sonicsurface)")).click();
        screen.run_steps(4);
        let form = &mut screen.state_mut().editor_mut().board;
        assert_eq!((&form.port, form.profile), (&name, Profile::SonicSurface));
        form.set_baud(Some(9600));
        form.calibration = "mine.csv".to_owned();
        screen.run_steps(2);
    }
    let mut screen = open_there();
    let form = &mut screen.state_mut().editor_mut().board;
    assert_eq!((&form.port, form.profile), (&name, Profile::SonicSurface));
    assert_eq!((form.baud(), std::mem::take(&mut form.calibration)), (Some(9600), "mine.csv".to_owned()));
    form.set_baud(None);
    screen.run_steps(2);
    screen.get_by_label("Connect").click();
    let confirms_nothing = "port open, unconfirmed";
    until(&mut screen, "the port", |screen| screen.query_by_label(confirms_nothing).is_some());
    assert!(!screen.get_by_label("Send").accesskit_node().is_disabled());
    let messages = &screen.state().shown().board.messages;
    assert!(messages.iter().all(|message| !message.contains("ready")), "{messages:?}");
    assert!(
        messages.iter().any(|message| message.contains("every element sounds from power-up")),
        "{messages:?}"
    );
}

#[test]
fn a_board_can_be_emulated() {
    for profile in [Profile::Native, Profile::SonicSurface] {
        let mut screen = Harness::builder()
            .with_size(vec2(1280.0, 800.0))
            .build_eframe(|context| window(&context.egui_ctx));
        let editor = screen.state_mut().editor_mut();
        editor.panel = Panel::Device;
        (editor.was_warned, editor.board.profile) = (true, profile);
        screen.run_steps(4);
        press(&mut screen, "Try without a board");
        press(&mut screen, "Single element");
        until(&mut screen, "the element", |screen| {
            screen.state().shown().board.health.as_ref().is_some_and(|health| health.in_place)
        });
        assert!(screen.query_by_label("virtual board").is_some());
        screen.get_by_label("Disconnect").click();
        screen.run_steps(4);
        assert!(
            screen.query_by_label("virtual board").is_none() && screen.query_by_label("Connect").is_some()
        );
    }
}

/// Clicks on a button as soon as it is enabled.
pub fn press(screen: &mut Screen, name: &str) {
    until(screen, name, |screen| {
        screen.query_by_label(name).is_some_and(|node| !node.accesskit_node().is_disabled())
    });
    screen.get_by_label(name).click();
    screen.run_steps(3);
}

#[test]
fn a_board_is_brought_up_step_by_step() {
    let folder = tempfile::tempdir().unwrap();
    let (mut screen, board, _shown) = connected(Profile::Native);
    press(&mut screen, "Test a board…");
    press(&mut screen, "Next: elements");
    until(&mut screen, "element 0", |screen| screen.state().shown().board.plays == Plays::One(0));
    until(&mut screen, "sound", |_| !is_silent(&board));
    press(&mut screen, "Signal seen");
    press(&mut screen, "No signal");
    press(&mut screen, "No signal");
    press(&mut screen, "Back");
    until(&mut screen, "element 2", |screen| screen.state().shown().board.plays == Plays::One(2));
    press(&mut screen, "Signal seen");
    press(&mut screen, "Rest of row seen");
    until(&mut screen, "the next row", |screen| screen.state().shown().board.plays == Plays::One(16));
    // Esc Esc silences the board, and the test says how to go on.
    screen.key_press(egui::Key::Escape);
    screen.key_press(egui::Key::Escape);
    until(&mut screen, "silence", |_| is_silent(&board));
    screen.run_steps(3);
    assert!(is_silent(&board) && screen.query_by_label_contains("The board is silent: play again").is_some());
    for answer in ["Signal seen", "No signal", "Rest of row seen", "Back"] {
        assert!(screen.get_by_label(answer).accesskit_node().is_disabled(), "{answer}");
    }
    assert!(screen.query_by_label_contains("Plays alone").is_none());
    // Left and continued, with its results.
    press(&mut screen, "Pause test");
    assert!(screen.query_by_label_contains("16 elements tested, 1 without signal").is_some());
    press(&mut screen, "Continue test");
    until(&mut screen, "element 16", |screen| screen.state().shown().board.plays == Plays::One(16));
    press(&mut screen, "Cancel test");
    press(&mut screen, "Keep testing");
    press(&mut screen, "Skip the rest");
    until(&mut screen, "a focus", |screen| screen.state().shown().board.plays == Plays::Focus);
    until(&mut screen, "all elements", |_| {
        board.report().playing.unwrap().drive().amplitudes.iter().all(|&amplitude| amplitude > 0.0)
    });
    // A quantity and a page have this name, too.
    let named = screen.query_all_by_label("Felt");
    named.max_by(|a, b| a.rect().top().total_cmp(&b.rect().top())).unwrap().click();
    screen.run_steps(3);
    until(&mut screen, "sound", |screen| {
        !is_silent(&board) && screen.state().shown().board.health.as_ref().unwrap().in_place
    });
    board.press(true);
    until(&mut screen, "notice of the stop", |screen| {
        screen.state().shown().board.health.as_ref().unwrap().stopped
    });
    assert!(is_silent(&board));
    board.press(false);
    press(&mut screen, "Play again");
    until(&mut screen, "the report", |screen| screen.query_by_label("Copy the report").is_some());
    let run = screen.state().editor().board.bring_up.clone().unwrap();
    let report = run.report.text(Profile::Native, "here");
    for part in [
        "protocol 2",
        "FAILED  1 of 16 elements gave no signal: 1; 240 not tested",
        "a focus was felt",
        "emergency stop: silent until",
    ] {
        assert!(report.contains(part), "{part} in {report}");
    }
    let file = folder.path().join("mine.csv");
    screen.state_mut().editor_mut().board.bring_up.as_mut().unwrap().file = file.display().to_string();
    screen.run_steps(2);
    press(&mut screen, "Save");
    assert_eq!(Calibration::read(&file, &Scene::default()).unwrap().off(), [1]);
    assert_eq!(screen.state().editor().board.calibration, file.display().to_string());
    press(&mut screen, "Switch off in the scene");
    assert_eq!(screen.state().editor().scene().array.off, [1]);
    press(&mut screen, "Close");
    until(&mut screen, "silence", |_| is_silent(&board));
    assert!(screen.query_by_label("Send scene").is_some() && screen.query_by_label("Show report").is_some());
}

#[test]
fn a_tested_virtual_board_lends_its_rate_to_none() {
    let folder = tempfile::tempdir().unwrap();
    let there = folder.path().to_owned();
    let mut screen = Harness::builder().with_size(vec2(1280.0, 800.0)).build_eframe(move |context| {
        let mut opened = window(&context.egui_ctx);
        opened.remember_in(&there, &context.egui_ctx);
        opened
    });
    let editor = screen.state_mut().editor_mut();
    (editor.panel, editor.was_warned) = (Panel::Device, true);
    screen.run_steps(4);
    press(&mut screen, "Try without a board");
    press(&mut screen, "Test a board…");
    press(&mut screen, "Next: elements");
    until(&mut screen, "element 0", |screen| screen.state().shown().board.plays == Plays::One(0));
    assert!(screen.state().editor().board.baud().is_some_and(|baud| baud > 2_000_000));
    press(&mut screen, "Disconnect");
    super::pick(&mut screen, "Board", "SonicSurface");
    assert!(screen.query_by_label_contains("89 frames/s at 230400 baud").is_some());
    drop(screen);
    let settings = std::fs::read_to_string(folder.path().join("settings.toml")).unwrap();
    assert!(settings.contains("board = \"sonicsurface\"\nport = \"\"\n"), "{settings}");
    assert!(settings.trim_end().ends_with("[rates]") && !settings.contains("baud"), "{settings}");
    assert!(!folder.path().join("board-tests.toml").exists());
}

#[test]
fn send_stays_in_place_and_finds_the_known_port() {
    let board = Board::start(Setup::new(Profile::SonicSurface), Box::new(|_| {})).unwrap();
    let mut screen =
        Harness::builder().with_size(vec2(1280.0, 800.0)).build_eframe(|context| window(&context.egui_ctx));
    screen.run_steps(4);
    // Without a port it leads to the page.
    let (place, neighbour) = (screen.get_by_label("Send").rect(), screen.get_by_label("Panel").rect());
    press(&mut screen, "Send");
    assert_eq!(screen.state().editor().panel, Panel::Device);
    // A port without a board: no sound later by surprise.
    let form = &mut screen.state_mut().editor_mut().board;
    (form.profile, form.port) = (Profile::SonicSurface, "/dev/not-there".to_owned());
    press(&mut screen, "Send");
    press(&mut screen, "Start sound");
    until(&mut screen, "waiting", |screen| screen.query_by_label("Waiting for /dev/not-there").is_some());
    until(&mut screen, "no sound", |screen| screen.state().shown().board.plays == Plays::Nothing);
    assert!(screen.query_all_by_label_contains("press “Choose…”").next().is_some());
    press(&mut screen, "Disconnect");
    screen.state_mut().editor_mut().board.port = board.path().display().to_string();
    press(&mut screen, "Send");
    until(&mut screen, "sound", |_| !is_silent(&board));
    assert_eq!((screen.get_by_label("Stop").rect(), screen.get_by_label("Panel").rect()), (place, neighbour));
    screen.get_by_label("Stop").click();
    screen.run_steps(2);
    // A second click on the same place does not start the sound again.
    assert!(screen.get_by_label("Send").accesskit_node().is_disabled());
    until(&mut screen, "silence", |_| is_silent(&board));
}

#[test]
fn after_an_emergency_stop_the_scene_must_be_sent_again() {
    let (mut screen, board, _shown) = connected(Profile::Native);
    press(&mut screen, "Send");
    until(&mut screen, "sound", |screen| {
        !is_silent(&board) && screen.state().shown().board.health.as_ref().unwrap().in_place
    });
    board.press(true);
    until(&mut screen, "the stop", |screen| screen.state().shown().board.health.as_ref().unwrap().stopped);
    board.press(false);
    screen.run_steps(3);
    assert_eq!(screen.state().shown().board.plays, Plays::Nothing, "until the scene is sent again");
    press(&mut screen, "Send");
    until(&mut screen, "sound again", |_| !is_silent(&board));
}

#[test]
fn the_screen_shows_the_frames_that_the_board_plays() {
    let (mut screen, _board, _shown) = connected(Profile::Native);
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.motion = Motion { path: MotionPath::Circle, frames: 8, ..Motion::default() };
    assert_eq!(editor.playback.moment, Moment::Rest);
    until(&mut screen, "all frames", |screen| screen.state().shown().round.is_some());
    screen.get_by_label("Play motion").click();
    let is_playing = |screen: &Screen| screen.state().editor().playback.playing;
    until(&mut screen, "the motion", is_playing);
    let playback = screen.state().editor().playback;
    assert_eq!((playback.slowness, playback.loops), (1.0, true), "in real time");
    assert!(screen.query_by_label_contains("5.00 cycles/s, 40 frames/s").is_some());
    let moment = playback.moment;
    until(&mut screen, "another frame", |screen| screen.state().editor().playback.moment != moment);
    screen.get_all_by_label("Stop").last().unwrap().click();
    until(&mut screen, "rest", |screen| screen.state().editor().playback.moment == Moment::Rest);
    assert!(!screen.state().editor().playback.playing);
}
