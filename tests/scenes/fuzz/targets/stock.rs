//! Boards with stock firmware: after any bytes they fall silent when told, and then play correctly.

use std::f64::consts::{PI, TAU};

use sonoglyph::device::declaration::{Heard, Level};
use sonoglyph::device::levels::Levels;
use sonoglyph::device::profile::Profile;
use sonoglyph::device::stock::{self, Twin};

pub fn run(bytes: &[u8]) {
    let Some((&[board, part], bytes)) = bytes.split_first_chunk() else { return };
    let boards: Vec<_> = Profile::ALL.into_iter().filter(|&profile| profile != Profile::Native).collect();
    let profile = boards[usize::from(board) % boards.len()];
    let (noise, drive) = bytes.split_at(bytes.len() * usize::from(part) / 256);
    let mut twin = Twin::new(profile);
    for &byte in noise {
        twin.push(byte);
    }
    sounds(&twin.shown());
    for byte in stock::silence(profile) {
        twin.push(byte);
    }
    assert_eq!(twin.shown(), Levels::off(profile));
    let levels = levels(profile, drive);
    // One board reads its bytes in batches of a frame: after noise, the end of a frame waits for the next.
    let times = if profile == Profile::Acoustophoretic512 { 2 } else { 1 };
    let frames = stock::frame(&levels).repeat(times);
    let heard: Vec<_> =
        frames.iter().map(|&byte| twin.push(byte)).filter(|&heard| heard != Heard::Part).collect();
    assert_eq!(heard, vec![Heard::Shown; times]);
    assert_eq!(twin.shown(), levels);
    sounds(&levels);
}

/// Amplitudes and phases are in their ranges.
fn sounds(levels: &Levels) {
    assert_eq!(levels.channels.len(), levels.profile.elements());
    for Level { delay, .. } in levels.channels.iter().flatten() {
        assert!(*delay < levels.profile.levels(), "{delay}");
    }
    let drive = levels.drive();
    for (amplitude, phase) in drive.amplitudes.iter().zip(&drive.phases) {
        assert!((0.0..=1.0).contains(amplitude) && -PI < *phase && *phase <= PI, "{amplitude} {phase}");
    }
}

/// A byte for the phase and one for the amplitude of each element, repeated cyclically.
fn levels(profile: Profile, bytes: &[u8]) -> Levels {
    let mut bytes = bytes.iter().cycle().map(|&byte| f64::from(byte) / 255.0);
    let mut next = || bytes.next().unwrap_or(0.0);
    let channels = (0..profile.elements()).map(|_| profile.level(next(), TAU * (next() - 0.5))).collect();
    Levels { profile, channels }
}
