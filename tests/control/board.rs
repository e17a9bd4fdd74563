//! `sonoglyph serve` with a board: it plays the commanded scene, and falls silent on stop, on errors and at the end.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::sync_channel;

use rosc::OscType;
use sonoglyph::control;
use sonoglyph::control::desk::Desk;
use sonoglyph::control::edit::Edit;
use sonoglyph::control::live::Live;
use sonoglyph::device::board::{Board, Setup, Shown};
use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::link::Settings;
use sonoglyph::device::profile::Profile;
use sonoglyph::device::wiring::Wiring;
use sonoglyph::scene::{Envelope, Modulation, Scene};
use sonoglyph::solver::{self, frames};
use sonoglyph::studio::performance::Performance;

use crate::waiting::{PATIENCE, eventually};
use crate::{Udp, floats, message, scene};

const PROFILE: Profile = Profile::SonicSurface;
const SCENE: &str = "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[[target]]\nat = [-0.02, 0, 0.12]\n";

fn is_silent(board: &Board) -> bool {
    let playing = board.report().playing;
    playing.is_none_or(|playing| playing.drive().amplitudes.iter().all(|&amplitude| amplitude == 0.0))
}

/// Whether the board plays the scene's own solution at its levels.
fn plays(board: &Board, text: &str) -> bool {
    let solution = solver::solve(&scene(text)).unwrap();
    let levels = Wiring::own(PROFILE).levels(&solution.drive, &Calibration::default()).unwrap();
    board.report().playing.is_some_and(|playing| playing.drive() == levels.drive())
}

/// This program's board at a port.
fn opened(port: &Path, profile: Profile) -> control::board::Board {
    let settings = Settings { port: port.to_owned(), profile, baud: None };
    control::board::Board::open(settings, Calibration::default(), || false).unwrap().unwrap()
}

/// The program, and its OSC socket.
fn serve(folder: &Path, args: &[&str]) -> (Child, BufReader<ChildStdout>, Udp) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sonoglyph"))
        .args(["serve", "--osc", "0"])
        .args(args)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    out.read_line(&mut line).unwrap();
    let address = line.trim().strip_prefix("OSC on udp://").unwrap().to_owned();
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(address).unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    (child, out, Udp(socket))
}

/// Ends the program as the user does, and returns its messages.
fn ended(mut child: Child) -> String {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    std::io::read_to_string(child.stderr.take().unwrap()).unwrap()
}

#[test]
fn a_board_follows_falls_silent_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("two.toml"), SCENE).unwrap();
    let board = Board::start(Setup::new(PROFILE), Box::new(|_| {})).unwrap();
    let port = board.path().display().to_string();
    let (child, _out, osc) =
        serve(folder.path(), &["two.toml", "--port", &port, "--profile", PROFILE.name()]);
    osc.osc("state", &[]);
    assert_eq!(osc.heard()[0].args[4], OscType::String("ready".to_owned()));
    assert!(is_silent(&board), "silent before the first play");
    osc.osc("send", &[]);
    eventually("the scene", || plays(&board, SCENE));
    let moved = |x: f32| message("target/1/at", &floats([x, 0.0, 0.11]));
    osc.bundle(vec![moved(-0.01), moved(0.015)]);
    let text = SCENE.replace("0.01, 0.02, 0.1]", "0.015, 0, 0.11]");
    eventually("the moved focus", || plays(&board, &text));
    osc.osc("stop", &[]);
    eventually("silence", || is_silent(&board));
    osc.bundle(vec![moved(0.01)]);
    std::thread::sleep(std::time::Duration::from_millis(100));
    assert!(is_silent(&board), "an edit alone does not start sound");
    osc.osc("send", &[OscType::Bool(true)]);
    let text = SCENE.replace("0.01, 0.02, 0.1]", "0.01, 0, 0.11]");
    eventually("the scene again", || plays(&board, &text));
    // An unsolvable scene is silent, and reported.
    osc.osc("solver/method", &[OscType::String("focus".to_owned())]);
    eventually("silence", || is_silent(&board));
    osc.osc("state", &[]);
    assert!(format!("{:?}", osc.heard()[0].args[5]).contains("steers one focus"));
    osc.osc("solver/method", &[OscType::String("best".to_owned())]);
    eventually("the scene again", || plays(&board, &text));
    board.unplug(true);
    std::thread::sleep(std::time::Duration::from_millis(600));
    osc.bundle(vec![moved(0.012)]);
    board.unplug(false);
    let text = text.replace("0.01, 0, 0.11]", "0.012, 0, 0.11]");
    eventually("the newest scene after a lost connection", || plays(&board, &text));
    let said = ended(child);
    eventually("silence at the end", || is_silent(&board));
    assert!(said.contains("89 frames/s at 230400 baud\n"), "{said}");
    assert!(said.contains("looking for it\n") && said.contains("the board is back\n"), "{said}");
}

#[test]
fn what_has_not_changed_is_not_sent_again_and_a_modulation_is() {
    let board = Board::start(Setup::new(PROFILE), Box::new(|_| {})).unwrap();
    let mut own = opened(board.path(), PROFILE);
    let mut scene = scene(SCENE);
    let play = Performance::Still(Arc::new(solver::solve(&scene).unwrap()));
    own.play(&scene, play.clone()).unwrap();
    eventually("the scene", || plays(&board, SCENE) && own.report().health.in_place);
    own.play(&scene, play.clone()).unwrap();
    assert!(own.report().health.in_place, "nothing new is on its way");
    scene.modulation.shape = Envelope::Square;
    scene.modulation.frequency = 5.0;
    own.play(&scene, play).unwrap();
    for _ in 0..2 {
        eventually("silence in between", || is_silent(&board));
        eventually("sound in between", || plays(&board, SCENE));
    }
    own.stop();
    eventually("silence", || is_silent(&board));
    std::thread::sleep(std::time::Duration::from_millis(150));
    assert!(is_silent(&board), "for more than half a period");
    own.close();
}

#[test]
fn content_that_a_board_cannot_play_silences_it_until_the_next() {
    let board = Board::start(Setup::new(PROFILE), Box::new(|_| {})).unwrap();
    let mut own = opened(board.path(), PROFILE);
    let scene = scene(SCENE);
    let play = Performance::Still(Arc::new(solver::solve(&scene).unwrap()));
    let tones = Modulation { shape: Envelope::Tones, ..Modulation::default() };
    let tones = Scene { modulation: tones, ..scene.clone() };
    let mut small = scene.clone();
    small.array.rows = 8;
    for (impossible, part) in [(tones, "sonicsurface"), (small, "8 elements")] {
        own.play(&scene, play.clone()).unwrap();
        eventually("the scene", || plays(&board, SCENE));
        let why = own.play(&impossible, play.clone()).unwrap_err();
        assert!(why.contains(part), "{why}");
        eventually("silence", || is_silent(&board));
    }
    own.close();
}

#[test]
fn an_emergency_stop_lasts_until_the_next_send() {
    let board = Board::start(Setup::new(Profile::Native), Box::new(|_| {})).unwrap();
    let desk = Arc::new(Desk::new(Arc::new(scene(SCENE)), Box::new(|| {})));
    let mut live = Live::new(Arc::clone(&desk), Some(opened(board.path(), Profile::Native)));
    for _ in 0..2 {
        eventually("sound", || {
            // Sent until the board has seen the release.
            if !desk.wish().0.sends {
                desk.change(&[Edit::Send(true)]).unwrap();
            }
            live.turn();
            !is_silent(&board)
        });
        board.press(true);
        eventually("the end of sending", || {
            live.turn();
            is_silent(&board) && !desk.wish().0.sends
        });
        board.press(false);
    }
    live.close();
}

/// A scene that no solver ends in a minute.
fn slow() -> Scene {
    scene(
        "format = 1\n[[target]]\nkind = \"circle\"\nat = [0, 0, 0.1]\nradius = 0.05\npoints = 100\n\
         [solver]\nmethod = \"greedy\"\niterations = 100000\n",
    )
}

/// Closes a desk, also when a test fails.
struct End<'a>(&'a Desk);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.close();
    }
}

/// The loop of the server on a thread of its own, until `work` returns.
fn while_live(board: &Board, desk: &Arc<Desk>, work: impl FnOnce()) {
    let mut live = Live::new(Arc::clone(desk), Some(opened(board.path(), PROFILE)));
    std::thread::scope(|scope| {
        let end = End(desk);
        scope.spawn(|| {
            while !desk.is_closing() {
                live.turn();
            }
            live.close()
        });
        work();
        drop(end);
    });
}

#[test]
fn stop_and_newer_scenes_wait_for_no_solver() {
    let board = Board::start(Setup::new(PROFILE), Box::new(|_| {})).unwrap();
    let desk = Arc::new(Desk::new(Arc::new(scene(SCENE)), Box::new(|| {})));
    while_live(&board, &desk, || {
        for text in [SCENE.replace("0.02, 0.1]", "0.03, 0.1]"), SCENE.to_owned()] {
            let quick = Edit::Scene(Box::new(scene(&text)));
            desk.change(&[quick.clone(), Edit::Send(true)]).unwrap();
            eventually("sound", || plays(&board, &text));
            let change = desk.change(&[Edit::Scene(Box::new(slow()))]).unwrap();
            eventually("the solver at work", || desk.report().generation >= change);
            desk.change(&[Edit::Stop]).unwrap();
            eventually("silence", || is_silent(&board));
            assert!(desk.report().is_solving && desk.report().solved < change, "it waited for the solver");
            desk.change(&[quick, Edit::Send(true)]).unwrap();
            eventually("the newest scene", || plays(&board, &text));
            desk.change(&[Edit::Stop]).unwrap();
            eventually("silence", || is_silent(&board));
            eventually("rest", || !desk.report().is_solving);
            assert!(is_silent(&board), "a drive that came later is not played");
        }
    });
}

#[test]
fn a_silenced_link_refuses_what_its_owner_plays() {
    let board = Board::start(Setup::new(PROFILE), Box::new(|_| {})).unwrap();
    let mut own = opened(board.path(), PROFILE);
    let scene = scene(SCENE);
    let [first, second] = [0, 1].map(|_| Performance::Still(Arc::new(solver::solve(&scene).unwrap())));
    own.play(&scene, first).unwrap();
    eventually("the scene", || plays(&board, SCENE));
    own.silencer()();
    // Its owner has not yet heard of it.
    own.play(&scene, second.clone()).unwrap();
    eventually("silence", || is_silent(&board));
    std::thread::sleep(std::time::Duration::from_millis(100));
    assert!(is_silent(&board));
    own.attend();
    own.play(&scene, second).unwrap();
    eventually("the scene again", || plays(&board, SCENE));
    own.close();
}

#[test]
fn a_motion_follows_its_changes_and_one_without_a_solution_is_silent() {
    let text = |size: f64, rest: &str| {
        format!(
            "format = 1\n[[target]]\nat = [0, 0.01, 0.1]\n{rest}\n[motion]\npath = \"circle\"\n\
             size = {size}\nframes = 3\nrate = 20\n"
        )
    };
    let (sender, shown) = sync_channel(100_000);
    let watch = move |frame: &Shown| drop(sender.try_send(frame.levels.clone()));
    let board = Board::start(Setup::new(PROFILE), Box::new(watch)).unwrap();
    let desk = Arc::new(Desk::new(Arc::new(scene(&text(0.01, ""))), Box::new(|| {})));
    let mut live = Live::new(Arc::clone(&desk), Some(opened(board.path(), PROFILE)));
    desk.change(&[Edit::Send(true)]).unwrap();
    for size in [0.01, 0.02] {
        let scene = scene(&text(size, ""));
        let frames = frames::follow(&scene).unwrap().frames;
        desk.change(&[Edit::Scene(Box::new(scene))]).unwrap();
        let levels =
            |frame: &frames::Frame| Wiring::own(PROFILE).levels(&frame.drive, &Calibration::default());
        let mut missing: Vec<_> = frames.iter().map(|frame| levels(frame).unwrap()).collect();
        eventually("all frames", || {
            live.turn();
            shown.try_iter().for_each(|levels| missing.retain(|frame| *frame != levels));
            missing.is_empty()
        });
        // Each motion is solved once.
        eventually("rest", || {
            live.turn();
            !desk.report().is_solving
        });
    }
    let two = text(0.02, "[[target]]\n[solver]\nmethod = \"focus\"\n");
    desk.change(&[Edit::Scene(Box::new(scene(&two)))]).unwrap();
    eventually("silence", || {
        live.turn();
        is_silent(&board)
    });
    assert!(desk.report().problem.as_ref().is_some_and(|problem| problem.contains("steers one focus")));
    assert!(live.close().is_some_and(|health| health.silenced), "the final silence is sent");
}

#[test]
fn the_carrier_is_that_of_the_board_that_came_back() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("port");
    let plugged = |carrier_millihertz| {
        let setup = Setup { carrier_millihertz, ..Setup::new(Profile::Native) };
        let board = Board::start(setup, Box::new(|_| {})).unwrap();
        std::os::unix::fs::symlink(board.path(), &port).unwrap();
        board
    };
    let first = plugged(40_500_000);
    let mut own = opened(&port, Profile::Native);
    let carrier = |own: &mut control::board::Board| {
        let mut scene = Scene::default();
        own.tune(&mut scene);
        scene.array.frequency
    };
    assert_eq!(carrier(&mut own), 40_500.0);
    drop(first);
    std::fs::remove_file(&port).unwrap();
    let _second = plugged(39_500_000);
    eventually("the other carrier", || {
        own.attend();
        carrier(&mut own) == 39_500.0
    });
    own.close();
}

#[test]
fn scenes_are_solved_for_the_carrier_of_any_board_which_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    // With amplitudes, which the first board lacks.
    let text = |frequency: f64| {
        format!(
            "{SCENE}[array]\nfrequency = {frequency}\n[solver]\nmethod = \"pinv\"\namplitudes = \"free\"\n"
        )
    };
    std::fs::write(folder.path().join("two.toml"), text(41_000.0)).unwrap();
    let board = Board::start(Setup::new(PROFILE), Box::new(|_| {})).unwrap();
    let port = board.path().display().to_string();
    let (child, _out, osc) =
        serve(folder.path(), &["two.toml", "--port", &port, "--profile", PROFILE.name()]);
    osc.osc("send", &[]);
    eventually("the scene", || plays(&board, &text(PROFILE.carrier())));
    for x in ["0.015", "-0.01"] {
        osc.osc("target/1/at", &floats([x.parse().unwrap(), 0.02, 0.1]));
        let moved = text(PROFILE.carrier()).replace("[0.01,", &format!("[{x},"));
        eventually("the moved focus", || plays(&board, &moved));
    }
    let said = ended(child);
    for once in
        ["the board's carrier is 40000 Hz; scenes are solved for it", "sonicsurface has no amplitude control"]
    {
        assert_eq!(said.matches(once).count(), 1, "{said}");
    }

    let setup = Setup { carrier_millihertz: 40_500_000, ..Setup::new(Profile::Native) };
    let board = Board::start(setup, Box::new(|_| {})).unwrap();
    let port = board.path().display().to_string();
    let (child, _out, osc) =
        serve(folder.path(), &["two.toml", "--port", &port, "--profile", Profile::Native.name()]);
    osc.osc("send", &[]);
    eventually("a frame", || board.report().frames > 0);
    let said = ended(child);
    assert_eq!(said.matches("the board's carrier is 40500 Hz").count(), 1, "{said}");
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn bad_arguments_give_one_message() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("two.toml"), SCENE).unwrap();
    let taken = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap().port().to_string();
    for (args, part) in [
        (vec!["--osc", &taken], "port 0 takes a free one"),
        (vec!["--osc", "0", "--token", "short"], "the token must have 8 to 128"),
        (vec!["--osc", "0", "--listen", "somewhere"], "--listen"),
        (
            vec!["--osc", "0", "--port", "/dev/nothing", "--profile", "sonicsurface"],
            "there is no port /dev/nothing",
        ),
        (vec!["--osc", "0", "--port", "/dev/nothing"], "--profile"),
        (vec!["missing.toml"], "missing.toml"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_sonoglyph"))
            .arg("serve")
            .args(&args)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
        assert!(error.contains(part), "{args:?}: {error}");
    }
}
