//! Boards as published by their authors: transducer positions, and the gateware's response to the bytes.
//!
//! Independent of the program: positions, pins and corrections come from `tests/reference/board_places.json`.

use std::f64::consts::TAU;
use std::path::Path;

use glam::DVec2;
use num_complex::Complex64;
use serde_json::Value;
use sonoglyph::device::profile::Profile;

/// A transducer: its position (m, from the centre, x to the right and y upwards as seen from the front), and its
/// phasor, which is 1 for half a period from the period's beginning.
pub struct Transducer {
    pub place: DVec2,
    pub plays: Complex64,
}

/// Variants of a board's gateware.
#[derive(Clone, Copy, PartialEq)]
pub enum Gateware {
    Published,
    /// The tactile build with a table of zeros.
    Rebuilt,
}

fn source(board: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/board_places.json");
    let sources: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    sources[board].clone()
}

fn integers(list: &Value) -> Vec<usize> {
    list.as_array().unwrap().iter().map(|value| value.as_u64().unwrap() as usize).collect()
}

/// Positions in the source's axes, m.
fn places(source: &Value) -> Vec<DVec2> {
    let place = |place: &Value| DVec2::new(place[0].as_f64().unwrap(), place[1].as_f64().unwrap()) * 1e-3;
    source["places"].as_array().unwrap().iter().map(place).collect()
}

/// For boards with normal +y: if x is to the right, z points down.
fn seen_from_above(source: &Value) -> Vec<DVec2> {
    centred(places(source).iter().map(|place| DVec2::new(place.x, -place.y)).collect())
}

/// SonicSurface's table is 2 mm off centre.
fn centred(places: Vec<DVec2>) -> Vec<DVec2> {
    let middle = places.iter().sum::<DVec2>() / places.len() as f64;
    places.into_iter().map(|place| place - middle).collect()
}

/// For arrays of any wiring: the order of the program's scenes, with `columns` and the pitch (m).
fn wired(elements: usize, columns: usize, pitch: f64) -> Vec<DVec2> {
    centred((0..elements).map(|n| DVec2::new((n % columns) as f64, (n / columns) as f64) * pitch).collect())
}

/// The fundamental, e^{jωt}, of a pin that is high in some divisions of a period.
fn fundamental(high: &[bool]) -> Complex64 {
    let divisions = high.len() as f64;
    let turn = |division: usize| Complex64::from_polar(1.0, -TAU * division as f64 / divisions);
    let sum: Complex64 = (0..high.len()).filter(|&division| high[division]).map(turn).sum();
    // The sum over half a period of divisions is 1 / sin(π / divisions).
    sum * (TAU / 2.0 / divisions).sin()
}

fn pulse(divisions: usize, begin: usize, width: usize) -> Complex64 {
    let high: Vec<_> = (0..divisions).map(|at| (at + divisions - begin) % divisions < width).collect();
    fundamental(&high)
}

/// A byte of a list, as played by `PhaseLine.vhd`: 32 is off, other values are delays in 1/32 of a period.
fn listed(byte: u8) -> Complex64 {
    if byte == 32 { Complex64::ZERO } else { pulse(32, usize::from(byte & 0x1F), 16) }
}

/// The output of each channel after the bytes of one frame, whatever is wired to it.
pub fn channels(profile: Profile, bytes: &[u8]) -> Vec<Complex64> {
    match profile {
        Profile::Native => native(bytes),
        Profile::Natives(_) => unreachable!("each of them is sent the bytes of one"),
        Profile::UltrainoSimpleFpga | Profile::SonicSurface => {
            assert_eq!((bytes[0], bytes[257]), (254, 253));
            bytes[1..257].iter().map(|&byte| listed(byte)).collect()
        }
        Profile::SonicSurface2 => two_surfaces(bytes).1,
        Profile::SonicSurfaceTactile => tactile(&bytes[1..257], Gateware::Published),
        Profile::UltrainoMega64 => mega(bytes).1,
        Profile::Acoustophoretic512 => {
            let channel = |n: usize| pulse(128, usize::from(bytes[n] & 0x7F), usize::from(bytes[256 + n]));
            (0..256).map(channel).collect()
        }
    }
}

/// The board's output after the bytes of one frame.
pub fn played(profile: Profile, bytes: &[u8], pitch: f64, gateware: Gateware) -> Vec<Transducer> {
    let (places, plays): (Vec<_>, Vec<_>) = match profile {
        Profile::Native => (wired(256, 16, pitch), native(bytes)),
        Profile::Natives(_) => unreachable!("each of them is sent the bytes of one"),
        Profile::UltrainoSimpleFpga => {
            assert_eq!((bytes[0], bytes[257]), (254, 253));
            (wired(256, 16, pitch), bytes[1..257].iter().map(|&byte| listed(byte)).collect())
        }
        Profile::SonicSurface => {
            assert_eq!((bytes[0], bytes[257]), (254, 253));
            let plays = bytes[1..257].iter().map(|&byte| listed(byte)).collect();
            (seen_from_above(&source("sonicsurface")), plays)
        }
        Profile::SonicSurface2 => two_surfaces(bytes),
        Profile::SonicSurfaceTactile => {
            assert_eq!((bytes[0], bytes[257]), (254, 253));
            (seen_from_above(&source("sonicsurface")), tactile(&bytes[1..257], gateware))
        }
        Profile::UltrainoMega64 => mega(bytes),
        Profile::Acoustophoretic512 => acoustophoretic(bytes),
    };
    assert_eq!(places.len(), plays.len());
    places.into_iter().zip(plays).map(|(place, plays)| Transducer { place, plays }).collect()
}

/// By channel, in 1/256 of a period and 1/255 of the amplitude (`gateware/doc/protocol.md`): a COBS packet of code,
/// address, number, four arguments, data and a CRC of 4 bytes. PHASES has one amplitude as an argument, FRAME has pairs.
fn native(line: &[u8]) -> Vec<Complex64> {
    let packet = cobs::decode_vec(&line[..line.len() - 1]).unwrap();
    let data = &packet[7..packet.len() - 4];
    let plays = |phase: u8, amplitude: u8| pulse(256, usize::from(phase), 128) * f64::from(amplitude) / 255.0;
    match packet[0] {
        0x10 => data.iter().map(|&phase| plays(phase, packet[4])).collect(),
        _ => data.as_chunks::<2>().0.iter().map(|&[phase, amplitude]| plays(phase, amplitude)).collect(),
    }
}

/// The second board continues the rows of the first, 16 pitches further up.
fn two_surfaces(bytes: &[u8]) -> (Vec<DVec2>, Vec<Complex64>) {
    assert_eq!((bytes[0], bytes[1], bytes[258], bytes[515]), (254, 192, 193, 253));
    const UP: f64 = 16.0 * 10.5e-3;
    let one = seen_from_above(&source("sonicsurface"));
    let both = [0.0, UP].into_iter().flat_map(|up| one.iter().map(move |place| place + DVec2::new(0.0, up)));
    let lists = bytes[2..258].iter().chain(&bytes[259..515]);
    (centred(both.collect()), lists.map(|&byte| listed(byte)).collect())
}

/// `Distribute.vhd` and `PhaseLine.vhd` of the tactile build: a correction, then 16 delays, with 7 divisions high.
fn tactile(bytes: &[u8], gateware: Gateware) -> Vec<Complex64> {
    let corrections = integers(&source("sonicsurface-tactile")["phase_correction"]);
    let channel = |(&byte, correction): (&u8, usize)| {
        let added = if gateware == Gateware::Published { correction } else { 0 };
        match byte {
            32 => Complex64::ZERO,
            byte => pulse(16, ((usize::from(byte) + added) & 0x1F) >> 1, 7),
        }
    };
    bytes.iter().zip(corrections).map(channel).collect()
}

/// `DriverMEGA.ino`: ten divisions of ten ports, each byte in two halves.
fn mega(bytes: &[u8]) -> (Vec<DVec2>, Vec<Complex64>) {
    let source = source("ultraino-mega64");
    assert!(bytes[..200].iter().all(|byte| byte & 0x0F == 1));
    let ports: Vec<_> =
        bytes[..200].as_chunks::<2>().0.iter().map(|[high, low]| high & 0xF0 | low >> 4).collect();
    let pin = |bit: usize| {
        let high: Vec<_> = (0..10).map(|at| ports[10 * at + bit / 8] >> (bit % 8) & 1 == 1).collect();
        fundamental(&high)
    };
    (seen_from_above(&source), integers(&source["port_mapping"]).into_iter().map(pin).collect())
}

/// `MuxPhase.vhd`: high from the delay on for the second byte's length, in 1/128 of a period.
fn acoustophoretic(bytes: &[u8]) -> (Vec<DVec2>, Vec<Complex64>) {
    let source = source("acoustophoretic-512");
    let (places, channels) = (places(&source), integers(&source["channels"]));
    agrees_with_levitate(&places, &channels, &integers(&source["levitate_grid"]));
    let channel =
        |channel: usize| pulse(128, usize::from(bytes[channel] & 0x7F), usize::from(bytes[256 + channel]));
    (places, channels.into_iter().map(channel).collect())
}

/// Levitate lists the channels row by row from the upper left.
fn agrees_with_levitate(places: &[DVec2], channels: &[usize], grid: &[usize]) {
    for (place, &channel) in places.iter().zip(channels) {
        let from_the_corner = (DVec2::new(place.x, -place.y) + 78.75e-3) / 10.5e-3;
        let [column, row] = [from_the_corner.x, from_the_corner.y].map(|at| at.round() as usize);
        assert_eq!(grid[16 * row + column], channel, "{place}");
    }
}
