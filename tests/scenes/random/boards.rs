//! What holds of every board: it is told the nearest that it can play, and hears what it was told.

use std::f64::consts::{PI, TAU};

use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::declaration::{Heard, Strength};
use sonoglyph::device::levels::Levels;
use sonoglyph::device::native::model::Model;
use sonoglyph::device::native::packet::{Kind, Outcome, Packet, Splitter};
use sonoglyph::device::profile::Profile;
use sonoglyph::device::stock::{self, Twin};
use sonoglyph::device::wiring::Wiring;
use sonoglyph::drive::Drive;

use crate::random::tally::{count, within};

/// A drive on every board that has so many transducers; those that the array does not use are silent.
pub fn hold(drive: &Drive) {
    let elements = drive.phases.len();
    for profile in Profile::ALL {
        if profile.elements() != elements {
            assert!(
                Wiring::own(profile).levels(drive, &Calibration::default()).is_err(),
                "{}",
                profile.name()
            );
        }
        if profile.elements() < elements {
            continue;
        }
        let mut played = drive.clone();
        played.amplitudes.resize(profile.elements(), 0.0);
        played.phases.resize(profile.elements(), 0.0);
        let levels = Wiring::own(profile).levels(&played, &Calibration::default()).unwrap();
        levels_are_the_nearest(&levels, &by_channel(profile, &played));
        if profile == Profile::Native {
            the_native_device_plays(&levels);
        } else {
            a_stock_board_plays(&levels);
        }
        count(profile.name());
    }
}

/// A drive by the channels of the board's own array.
fn by_channel(profile: Profile, drive: &Drive) -> Drive {
    let (wiring, mut channels) = (Wiring::own(profile), drive.clone());
    for element in 0..profile.elements() {
        let channel = wiring.one(element).channels.iter().position(Option::is_some).unwrap();
        channels.amplitudes[channel] = drive.amplitudes[element];
        channels.phases[channel] = drive.phases[element];
    }
    channels
}

/// The nearest phase, wrapped before it is rounded, and the nearest amplitude; off where nothing is to sound.
fn levels_are_the_nearest(levels: &Levels, drive: &Drive) {
    let profile = levels.profile;
    let steps = f64::from(profile.levels());
    let sounds = levels.drive();
    for (n, level) in levels.channels.iter().enumerate() {
        let (amplitude, phase) = (drive.amplitudes[n], drive.phases[n]);
        // The smallest that sounds: half a step.
        let least = match profile.strength() {
            Strength::Fixed => 0.0,
            Strength::Linear(full) => 0.5 / f64::from(full),
            Strength::Duty(_) => (0.5 * PI / steps).sin(),
        };
        let Some(level) = level else {
            assert!(amplitude <= least * (1.0 + 1e-9), "{}: {amplitude} is left out", profile.name());
            continue;
        };
        assert!(
            amplitude >= least * (1.0 - 1e-9) && amplitude > 0.0,
            "{}: {amplitude} sounds",
            profile.name()
        );
        assert!(level.delay < profile.levels(), "{}: {level:?}", profile.name());
        let apart = ((sounds.phases[n] - phase) / TAU).rem_euclid(1.0);
        within("a phase in levels", apart.min(1.0 - apart) * steps, 0.5 + 1e-9);
        if profile.strength() == Strength::Fixed || profile == Profile::Native {
            // The contract: level = round(frac(-φ/2π) · L) mod L.
            let delay = (-phase / TAU).rem_euclid(1.0) * steps;
            let apart = (delay - f64::from(level.delay)).rem_euclid(steps);
            within("a delay in levels", apart.min(steps - apart), 0.5 + 1e-9);
        }
        match profile.strength() {
            Strength::Fixed => assert_eq!((level.amplitude, sounds.amplitudes[n]), (1, 1.0)),
            Strength::Linear(full) => {
                let off = (amplitude * f64::from(full) - f64::from(level.amplitude)).abs();
                within("an amplitude in steps", off, 0.5 + 1e-9);
            }
            Strength::Duty(full) => {
                let duty = amplitude.asin() / PI * steps;
                within("a pulse in levels", (duty - f64::from(level.amplitude)).abs(), 0.5 + 1e-9);
                assert!(level.amplitude <= full);
            }
        }
    }
}

/// decode(encode) is what was quantised.
fn a_stock_board_plays(levels: &Levels) {
    let mut twin = Twin::new(levels.profile);
    let mut hear = |bytes: &[u8]| -> Vec<Heard> {
        bytes.iter().map(|&byte| twin.push(byte)).filter(|&heard| heard != Heard::Part).collect()
    };
    hear(&stock::silence(levels.profile));
    assert_eq!(hear(&stock::frame(levels)), [Heard::Shown], "{}", levels.profile.name());
    assert_eq!(twin.shown(), *levels, "{}", levels.profile.name());
}

/// The same over packets, and the pulses of the device are as late and as long as that says.
fn the_native_device_plays(levels: &Levels) {
    const SLOT: u8 = 3;
    let sent = Packet::playing(levels, SLOT, true);
    let mut splitter = Splitter::default();
    let mut lines: Vec<_> = sent.to_line().iter().filter_map(|&byte| splitter.push(byte)).collect();
    assert_eq!(lines.len(), 1);
    let packet = Packet::of_line(&lines.remove(0)).unwrap();
    assert_eq!(packet, sent);
    let pairs: Vec<_> = match Kind::from_repr(packet.code).unwrap() {
        Kind::Phases => packet.payload.iter().map(|&phase| [phase, packet.arguments[1]]).collect(),
        Kind::Frame => packet.payload.as_chunks::<2>().0.to_vec(),
        kind => panic!("{kind:?}"),
    };
    for (pair, level) in pairs.iter().zip(&levels.channels) {
        let expected = level.map_or([0, 0], |level| [level.delay, level.amplitude]);
        let is_off = pair[1] == 0 && level.is_none();
        assert!(is_off || pair.map(u16::from) == expected, "{pair:?} is not {level:?}");
    }
    let mut model = Model::new(8);
    for packet in [Packet::silencer(0xFFFF, 0xFFFF), Packet::enable(1000), packet] {
        assert_eq!(model.apply(&packet).outcome, Outcome::Ok);
    }
    for _ in 0..3 {
        model.period();
    }
    for (pulse, level) in model.played().iter().zip(&levels.channels) {
        let Some(level) = level else {
            assert_eq!(pulse.width, 0);
            continue;
        };
        // In levels of 256: as long as the sine says, and its middle at the delay, both to half a level.
        let long = f64::from(pulse.width);
        let wanted = 256.0 / PI * (f64::from(level.amplitude) / 255.0).asin();
        within("a native pulse's length", (long - wanted).abs(), 0.5 + 1e-9);
        let middle = f64::from(pulse.rise) + long / 2.0;
        let apart = (middle - f64::from(level.delay)).rem_euclid(256.0);
        if pulse.width > 0 {
            within("a native pulse's middle", apart.min(256.0 - apart), 0.5 + 1e-9);
        }
    }
}
