//! Invalid drives to boards: the output is a valid level of the board, or silence.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::declaration::{Level, Strength};
use sonoglyph::device::levels::{self, Levels};
use sonoglyph::device::native::line;
use sonoglyph::device::native::model::Model;
use sonoglyph::device::native::packet::{Packet, Reply};
use sonoglyph::device::pace::Pace;
use sonoglyph::device::profile::Profile;
use sonoglyph::device::stock::{self, Twin};
use sonoglyph::device::wiring::Wiring;
use sonoglyph::drive::Drive;

use crate::poison::{POISON, SIZES, panics};

fn most(profile: Profile) -> u16 {
    match profile.strength() {
        Strength::Fixed => 1,
        Strength::Linear(most) | Strength::Duty(most) => most,
    }
}

#[test]
fn levels_are_in_range_and_invalid_values_are_silent() {
    for profile in Profile::ALL {
        for amplitude in POISON.into_iter().chain([0.0, 0.5, 1.0, 2.0]) {
            for phase in POISON.into_iter().chain([1.0]) {
                let Some(level) = profile.level(amplitude, phase) else { continue };
                assert!(amplitude > 0.0 && phase.is_finite(), "{profile:?} {amplitude} {phase}");
                assert!(level.delay < profile.levels(), "{profile:?} {amplitude} {phase}: {level:?}");
                assert!((1..=most(profile)).contains(&level.amplitude), "{profile:?} {amplitude}: {level:?}");
            }
        }
        assert_eq!(profile.level(f64::NAN, 0.0), None);
        assert_eq!(profile.level(1e300, 0.0), profile.level(1.0, 0.0));
        for (delay, amplitude) in [(0, 0), (u16::MAX, u16::MAX), (0, u16::MAX)] {
            let (sounds, phase) = profile.sounds(Level { delay, amplitude });
            assert!(sounds.is_finite() && phase.abs() <= TAU / 2.0, "{profile:?}");
        }
        assert_eq!(profile.frames_per_second(0), 0.0);
    }
}

#[test]
fn drives_of_the_wrong_length_are_refused() {
    for profile in Profile::ALL {
        let count = profile.elements();
        for (amplitudes, phases) in [(0, 0), (count, count - 1), (count - 1, count), (count + 1, count)] {
            let drive = Drive { amplitudes: vec![1.0; amplitudes], phases: vec![0.0; phases] };
            assert!(
                Wiring::own(profile).levels(&drive, &Calibration::default()).is_err(),
                "{amplitudes} and {phases}"
            );
        }
        for poison in POISON {
            let drive = Drive { amplitudes: vec![poison; count], phases: vec![poison; count] };
            let levels = Wiring::own(profile).levels(&drive, &Calibration::default()).unwrap();
            let is_level = |level: &Level| level.delay < profile.levels() && level.amplitude <= most(profile);
            assert!(levels.channels.iter().flatten().all(is_level), "{profile:?} {poison}");
            assert!(levels.drive().amplitudes.iter().all(|amplitude| (0.0..=1.0).contains(amplitude)));
            levels::amplitude_notice(profile, &drive, &Calibration::default());
        }
        for size in SIZES {
            assert!(Wiring::own(profile).one(size).channels.len() == count);
            assert!(Wiring::own(profile).checkerboard(size).channels.len() == count);
        }
        if profile == Profile::Native {
            assert!(panics(|| Twin::new(profile)) && panics(|| stock::load(&Levels::off(profile))));
        } else {
            let short = Levels { profile, channels: Vec::new() };
            assert!(panics(|| stock::load(&short)) || stock::load(&short).len() <= 1024, "{profile:?}");
        }
    }
}

#[test]
fn calibrations_are_in_range() {
    let row = |offset: &str, gain: &str| {
        Calibration::parse(&format!("element,offset,gain,off\n0,{offset},{gain},0\n"), 1)
    };
    assert!(row("10", "0.5").is_ok());
    for poison in ["nan", "inf", "-inf", "1e300", "-1e300"] {
        assert!(row(poison, "1").is_err() && row("0", poison).is_err(), "{poison}");
    }
    assert!(row("0", "-1e-300").is_err() && row("-0.0", "5e-324").is_ok());
    for text in
        ["", "element,offset,gain,off\n18446744073709551615,0,1,0\n", "element,offset,gain,off\n0,0,1,256\n"]
    {
        assert!(Calibration::parse(text, 1).is_err(), "{text}");
    }
    assert_eq!(Calibration::default().corrected(usize::MAX, 1.0, 2.0), (1.0, 2.0));
}

#[test]
fn line_coding_and_pacing_accept_any_input() {
    let now = Instant::now();
    for baud in POISON {
        let mut pace = Pace::new(baud, now);
        for bytes in [0, 1, usize::MAX] {
            assert!(pace.time_of(bytes) <= Duration::from_secs(86_400), "{baud}");
        }
        pace.sent(usize::MAX, now);
        assert!(pace.backlog(now) <= Duration::from_secs(86_400));
    }
    for length in [0, 1, 5, 600, 1 << 20] {
        for fill in [1, 0xFF] {
            let bytes = vec![fill; length];
            // Four zero bytes are an empty body and its CRC, which is not a packet.
            assert!(line::checked(&bytes).is_ok_and(|body| body.is_empty()) == (length == 5 && fill == 1));
            assert!(Packet::of_line(&bytes).is_err() && Reply::of_line(&bytes).is_err());
        }
    }
    for bits in [0, 4, 9, 255] {
        assert!(panics(|| Model::new(bits)), "{bits}");
    }
    let mut model = Model::new(5).with_carrier(0);
    assert!(model.carrier() == 0.0 && model.baud() == 0.0);
    model.period();
}
