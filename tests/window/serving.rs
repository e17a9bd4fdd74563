//! Edits by other programs: shown at once, undone as one step, and played on a connected board.

use std::net::UdpSocket;
use std::time::{Duration, Instant};

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use rosc::{OscMessage, OscPacket, OscType};
use sonoglyph::scene::Shape;
use sonoglyph::ui::Panel;
use sonoglyph::ui::document::Document;

use super::{Screen, window};

const PATIENCE: Duration = Duration::from_secs(60);
const TWO: &str = "format = 1\n[[target]]\nat = [-0.02, 0, 0.1]\n[[target]]\nat = [0.02, 0, 0.1]\n";

/// A serving window on two points, and a client.
fn serving() -> (Screen, UdpSocket) {
    let scene = sonoglyph::scene::file::parse(TWO, "two.toml".as_ref()).unwrap();
    let mut screen = Harness::builder()
        .with_size(egui::vec2(1280.0, 1100.0))
        .build_eframe(|context| window(&context.egui_ctx));
    screen.state_mut().editor_mut().replace(Document::new(scene, "two"));
    screen.state_mut().editor_mut().panel = Panel::Device;
    screen.run_steps(4);
    assert!(screen.state().shown().serving.is_none(), "off by default");
    screen.get_by_label("Serve other programs").click();
    screen.run_steps(4);
    let addresses = screen.state().shown().serving.clone().unwrap().addresses;
    let address = addresses[0].strip_prefix("OSC on udp://").unwrap().to_owned();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(address).unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    (screen, socket)
}

fn say(socket: &UdpSocket, address: &str, args: &[OscType]) {
    let message = OscMessage { addr: format!("/sonoglyph/{address}"), args: args.to_vec() };
    socket.send(&rosc::encoder::encode(&OscPacket::Message(message)).unwrap()).unwrap();
}

fn place(socket: &UdpSocket, number: usize, at: [f32; 3]) {
    say(socket, &format!("target/{number}/at"), &at.map(OscType::Float));
}

fn until(screen: &mut Screen, what: &str, condition: impl Fn(&Screen) -> bool) {
    let start = Instant::now();
    while !condition(screen) {
        assert!(
            start.elapsed() < PATIENCE,
            "timed out waiting for {what}; {:?}",
            screen.state().shown().serving
        );
        std::thread::sleep(Duration::from_millis(5));
        screen.step();
    }
    screen.run_steps(2);
}

fn stands(screen: &Screen, number: usize, at: [f64; 3]) -> bool {
    let target = screen.state().editor().scene().targets.get(number - 1);
    target.is_some_and(
        |target| matches!(target.shape, Shape::Point { at: own } if own == DVec3::from_array(at)),
    )
}

#[test]
fn remote_edits_are_shown_solved_and_undone_as_one_step() {
    let (mut screen, socket) = serving();
    // The user's own edit is a separate undo step.
    screen.state_mut().editor_mut().document.scene.targets[1].pressure = 2.0;
    for step in 1..=40u8 {
        place(&socket, 1, [f32::from(step) / 1000.0, 0.01, 0.1]);
        screen.step();
    }
    until(&mut screen, "the last place", |screen| stands(screen, 1, [0.04, 0.01, 0.1]));
    let foci = &screen.state().shown().solution.as_ref().unwrap().foci;
    assert_eq!(foci[0].position, DVec3::new(0.04, 0.01, 0.1));
    // After a pause, the burst is one undo step.
    std::thread::sleep(Duration::from_millis(800));
    screen.run_steps(2);
    screen.state_mut().editor_mut().undo();
    assert!(stands(&screen, 1, [-0.02, 0.0, 0.1]));
    assert_eq!(screen.state().editor().scene().targets[1].pressure, 2.0);
    screen.state_mut().editor_mut().undo();
    assert_eq!(screen.state().editor().scene().targets[1].pressure, 1.0);
    // Remote edits apply to the scene after the undo.
    screen.run_steps(2);
    screen.state_mut().editor_mut().selection = [1].into();
    say(&socket, "target/1/remove", &[]);
    until(&mut screen, "the removal", |screen| screen.state().editor().scene().targets.len() == 1);
    assert!(stands(&screen, 1, [0.02, 0.0, 0.1]));
    assert!(screen.state().editor().selection.is_empty());
    place(&socket, 2, [0.0, 0.0, 0.1]);
    let refused = |screen: &Screen| screen.state().shown().serving.as_ref().unwrap().refused == 1;
    until(&mut screen, "the count of refused packets", refused);
    screen.get_by_label("Serve other programs").click();
    screen.run_steps(3);
    assert!(screen.state().shown().serving.is_none());
    place(&socket, 1, [0.0, 0.0, 0.15]);
    screen.run_steps(5);
    assert!(stands(&screen, 1, [0.02, 0.0, 0.1]));
}

#[cfg(unix)]
#[test]
fn clients_start_and_stop_the_board_after_the_user_confirmed() {
    use sonoglyph::device::health::State;
    use sonoglyph::ui::board::Plays;

    let (mut screen, socket) = serving();
    screen.get_by_label("Try without a board").click();
    let is_ready = |screen: &Screen| {
        screen.state().shown().board.health.as_ref().is_some_and(|health| health.state == State::Ready)
    };
    until(&mut screen, "the board", is_ready);
    say(&socket, "send", &[]);
    until(&mut screen, "the question", |screen| screen.state().editor().dialog.is_some());
    assert_eq!(screen.state().shown().board.plays, Plays::Nothing);
    screen.get_by_label("Start sound").click();
    until(&mut screen, "the scene", |screen| screen.state().shown().board.plays == Plays::Scene);
    say(&socket, "stop", &[]);
    until(&mut screen, "silence", |screen| screen.state().shown().board.plays == Plays::Nothing);
    say(&socket, "send", &[OscType::Bool(true)]);
    until(&mut screen, "the scene again", |screen| screen.state().shown().board.plays == Plays::Scene);
    // The state includes the played scene.
    say(&socket, "state", &[]);
    let mut bytes = [0; 65536];
    let start = Instant::now();
    while socket.recv(&mut bytes).is_err() {
        assert!(start.elapsed() < PATIENCE);
        screen.step();
    }
    let text = String::from_utf8_lossy(&bytes);
    assert!(
        text.contains("/sonoglyph/state") && text.contains("ready") && text.contains("/sonoglyph/focus/2")
    );
}
