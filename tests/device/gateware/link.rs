//! The link with the gateware simulated by Verilator, over a real pseudo-terminal.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use sonoglyph::device::board::{Board, Playing, Setup};
use sonoglyph::device::declaration::Level;
use sonoglyph::device::health::State;
use sonoglyph::device::levels::Levels;
use sonoglyph::device::link::{Content, Link, Settings};
use sonoglyph::device::profile::Profile;

const PHASE_BITS: u8 = 7;
const PATIENCE: Duration = Duration::from_secs(120);

/// The simulated device, built if necessary; `None`, with a note, without Verilator.
fn program() -> Option<PathBuf> {
    let verilator = Command::new("verilator").arg("--version").output();
    crate::requirement::found("rtl", verilator.map_err(|error| format!("verilator: {error}")))?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join(format!("target/gateware/{PHASE_BITS}"));
    let built = Command::new(root.join("gateware/sim/build"))
        .arg(PHASE_BITS.to_string())
        .arg(&folder)
        .status()
        .unwrap();
    assert!(built.success(), "the simulated device was not built");
    Some(folder.join("device"))
}

/// A frame with delays that depend on element and frame number.
fn frame(number: usize) -> Levels {
    let level = |n: usize| Level { delay: ((n * 3 + number * 16) % 256) as u16, amplitude: 255 };
    Levels { profile: Profile::Native, channels: (0..256).map(|n| Some(level(n))).collect() }
}

/// The largest deviation (of 256) of the output pulses from a frame's delays; `None` while any output is silent.
fn farthest(board: &Board, levels: &Levels) -> Option<f64> {
    let heard = board.report().playing?.drive();
    let wanted = levels.drive();
    let off = |n: usize| {
        let turns = (heard.phases[n] - wanted.phases[n]) / std::f64::consts::TAU;
        256.0 * (turns - turns.round()).abs()
    };
    let sounds = heard.amplitudes.iter().all(|&amplitude| amplitude > 0.95);
    sounds.then(|| (0..256).map(off).fold(0.0, f64::max))
}

#[test]
fn the_gateware_plays_the_frames_of_the_link() {
    let Some(program) = program() else { return };
    let setup = Setup { program: Some(program), phase_bits: PHASE_BITS, ..Setup::new(Profile::Native) };
    let board = Board::start(setup, Box::new(|_| {})).unwrap();
    // The link connects at the device's own rate, then changes it.
    let settings =
        Settings { port: board.path().to_owned(), profile: Profile::Native, baud: Some(1_000_000) };
    let link = Link::open(settings, Box::new(|| {})).unwrap();
    let wait = |what: &str, condition: &dyn Fn() -> bool| {
        let until = Instant::now() + PATIENCE;
        while !condition() {
            assert!(
                Instant::now() < until,
                "timed out waiting for {what}: {:?}, {:?}",
                link.health(),
                board.report().events
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    wait("the board", &|| link.health().state == State::Ready);
    assert!(matches!(board.report().playing, Some(Playing::Pulses { outputs_on: false, .. })));
    for number in 0..5 {
        let levels = frame(number);
        link.show(Content::Still(levels.clone()));
        // With 128 levels, half a level of delay is one of 256.
        wait("the frame", &|| farthest(&board, &levels).is_some_and(|off| off < 1.01));
    }
    wait("the count of frames", &|| board.report().frames >= 5);
    link.stop();
    let is_silent =
        || board.report().playing.unwrap().drive().amplitudes.iter().all(|&amplitude| amplitude == 0.0);
    wait("silence", &is_silent);
}
