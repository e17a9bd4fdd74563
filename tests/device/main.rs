//! Boards without hardware: bytes of a drive, the emulators' response to them, and the gateware.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

#[path = "../dice/mod.rs"]
#[expect(dead_code, reason = "used by other test binaries")]
mod dice;
mod field;
mod gateware;
mod native;
mod pins;
mod published;
#[path = "../requirement/mod.rs"]
mod requirement;
mod silencer;
mod wiring;

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sonoglyph::device::calibration::{Calibration, CalibrationError};
use sonoglyph::device::declaration::{Heard, Level, Strength};
use sonoglyph::device::levels::{self, Levels};
use sonoglyph::device::profile::Profile;
use sonoglyph::device::stock::{self, Modulated, Twin};
use sonoglyph::device::wiring::{Share, Wiring};
use sonoglyph::drive::Drive;
use sonoglyph::scene::{Envelope, Modulation, Sampling, Scene, Shape, Target, Turns, file};

/// Reproducible random numbers.
fn numbers(seed: u32) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(2_654_435_769) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        f64::from(state) / f64::from(u32::MAX)
    }
}

fn stock_profiles() -> impl Iterator<Item = Profile> {
    Profile::ALL.into_iter().filter(|&profile| profile != Profile::Native)
}

/// Random phases and amplitudes; one element in eight is off.
fn random_drive(elements: usize, seed: u32) -> Drive {
    let mut number = numbers(seed);
    let amplitude = |number: &mut dyn FnMut() -> f64| if number() < 0.125 { 0.0 } else { number() };
    Drive {
        amplitudes: (0..elements).map(|_| amplitude(&mut number)).collect(),
        phases: (0..elements).map(|_| TAU * (number() - 0.5)).collect(),
    }
}

fn random_levels(profile: Profile, seed: u32) -> Levels {
    Wiring::own(profile).levels(&random_drive(profile.elements(), seed), &Calibration::default()).unwrap()
}

fn hear(twin: &mut Twin, bytes: &[u8]) -> Vec<Heard> {
    bytes.iter().map(|&byte| twin.push(byte)).filter(|&heard| heard != Heard::Part).collect()
}

#[test]
fn boards_play_the_frames_sent() {
    for profile in stock_profiles() {
        let mut twin = Twin::new(profile);
        hear(&mut twin, &stock::silence(profile));
        for seed in 0..20 {
            let levels = random_levels(profile, seed);
            assert!(
                levels.channels.contains(&None)
                    && levels.channels.iter().flatten().count() > profile.elements() / 2
            );
            assert_eq!(hear(&mut twin, &stock::frame(&levels)), [Heard::Shown], "{}", profile.name());
            assert_eq!(twin.shown(), levels, "{} after frame {seed}", profile.name());
        }
    }
}

/// Of a list by another program: this one gives an element that is off no phase.
#[test]
fn an_element_with_a_phase_and_no_amplitude_is_off() {
    let profile = Profile::UltrainoSimpleFpga;
    let mut bytes = [&[254][..], &[0; 256], &[251], &[16; 256], &[253]].concat();
    bytes[1 + 256 + 1] = 0;
    let mut twin = Twin::new(profile);
    assert_eq!(hear(&mut twin, &bytes), [Heard::Shown]);
    assert_eq!(twin.shown().channels.iter().filter(|element| element.is_none()).count(), 1);
}

#[test]
fn only_a_mega64_answers_as_its_sketch_does() {
    // The branches of DriverMEGA.ino, in their order.
    let sketch = |byte: u8| match byte {
        0b0000_0000 => Some(byte),
        _ if byte & 0b0000_1111 == 1 => None,
        _ if byte & 0b0011_1111 == 0b0011_0000 => Some(byte),
        0b0001_0000 => Some(byte),
        _ => Some(byte - 1),
    };
    for profile in stock_profiles() {
        let twin = Twin::new(profile);
        for byte in 0..=255 {
            let answer = sketch(byte).filter(|_| profile == Profile::UltrainoMega64);
            assert_eq!(twin.answer(byte), answer, "{}, {byte}", profile.name());
        }
    }
}

#[test]
fn frame_lengths_agree_with_the_bandwidth() {
    for profile in stock_profiles() {
        let full = Drive { amplitudes: vec![1.0; profile.elements()], phases: vec![0.3; profile.elements()] };
        let levels = Wiring::own(profile).levels(&full, &Calibration::default()).unwrap();
        assert_eq!(stock::frame(&levels).len(), profile.frame_bytes(), "{}", profile.name());
    }
    assert_eq!(Profile::SonicSurface.bandwidth(230_400), "89 frames/s at 230400 baud");
    assert_eq!(Profile::SonicSurface2.bandwidth(230_400), "44 frames/s at 230400 baud");
    assert_eq!(Profile::Native.bandwidth(3_000_000), "1111 frames/s at 3000000 baud");
    assert_eq!(Profile::Native.bandwidth(8_000_000), "2962 frames/s at 8000000 baud");
    let four = Profile::Natives(4);
    assert_eq!(four.frame_bytes(), 4 * Profile::Native.frame_bytes());
}

#[test]
fn bytes_follow_the_boards_formats() {
    let delay = |n: usize| Some(Level { delay: n as u16 % 32, amplitude: 1 });
    let levels =
        Levels { profile: Profile::SonicSurface, channels: (0..256).map(|n| delay(n / 16)).collect() };
    let frame = stock::frame(&levels);
    // Channel by channel, then a swap.
    assert_eq!(frame[..18], [&[254][..], &[0; 16], &[1]].concat());
    assert_eq!((frame[257], frame.len()), (253, 258));
    assert_eq!(stock::frame(&Levels::off(Profile::SonicSurface))[1..257], [32; 256]);
    let two = stock::frame(&Levels::off(Profile::SonicSurface2));
    assert_eq!((two[0], two[1], two[258], two[515]), (254, 192, 193, 253));
    let mega = stock::frame(&Levels::off(Profile::UltrainoMega64));
    assert_eq!(mega[..200], [0x01; 200]);
    assert_eq!(mega[200..], [0x30, 0x30, 0x30, 0x70, 0x30, 0x30, 0x30, 0x30, 0x10, 0x00]);
    let ucl = stock::frame(&Wiring::own(Profile::Acoustophoretic512).one(240));
    assert_eq!((ucl[0] & 0x80, ucl.len(), ucl[256 + 249]), (0x80, 512, 64));
    let fpga = Drive { amplitudes: vec![0.5; 256], phases: vec![0.0; 256] };
    let fpga = Wiring::own(Profile::UltrainoSimpleFpga).levels(&fpga, &Calibration::default()).unwrap();
    let fpga = stock::frame(&fpga);
    // arcsin(1/2) is a sixth of half a turn: 5 of 32.
    assert_eq!((fpga[0], fpga[257], fpga[258], fpga[514], fpga.len()), (254, 251, 5, 253, 515));
}

#[test]
fn neighbours_of_a_checkerboard_are_in_antiphase() {
    let profile = Profile::SonicSurface;
    for columns in [16, 10] {
        let wiring = Wiring::own(profile);
        let drive = wiring.drive(&wiring.checkerboard(columns).drive());
        let apart = |a: usize, b: usize| (drive.phases[a] - drive.phases[b]).cos();
        for n in 0..wiring.elements() - columns {
            assert!(apart(n, n + columns) < -0.99, "{columns}: {n} and the next row");
            assert!(
                n % columns == columns - 1 || apart(n, n + 1) < -0.99,
                "{columns}: {n} and its neighbour"
            );
        }
    }
}

#[test]
fn silence_is_silent_after_any_bytes() {
    for profile in stock_profiles() {
        for seed in 0..40 {
            let mut number = numbers(seed);
            let mut twin = Twin::new(profile);
            let frame = stock::frame(&random_levels(profile, seed));
            hear(&mut twin, &frame[..(number() * frame.len() as f64) as usize]);
            let noise: Vec<_> = (0..300).map(|_| (number() * 255.0) as u8).collect();
            if seed % 2 == 0 {
                hear(&mut twin, &noise);
            }
            hear(&mut twin, &stock::silence(profile));
            assert_eq!(twin.shown(), Levels::off(profile), "{} {seed}", profile.name());
            if let Some(swap) = stock::swap(profile) {
                twin.push(swap);
                assert_eq!(twin.shown(), Levels::off(profile), "{} {seed}: the other buffer", profile.name());
            }
        }
    }
}

#[test]
fn a_swap_within_a_list_shows_a_torn_frame() {
    for profile in [
        Profile::SonicSurface,
        Profile::SonicSurface2,
        Profile::SonicSurfaceTactile,
        Profile::UltrainoSimpleFpga,
    ] {
        let frame = stock::frame(&random_levels(profile, 5));
        let mut twin = Twin::new(profile);
        hear(&mut twin, &stock::silence(profile));
        // Of two boards, a list of the first or of the second.
        for cut in [100, frame.len() - 100] {
            let torn = [&frame[..cut], &frame[frame.len() - 1..]].concat();
            assert_eq!(hear(&mut twin, &torn), [Heard::Nonsense], "{} after {cut}", profile.name());
            assert_eq!(hear(&mut twin, &frame), [Heard::Shown], "{}", profile.name());
        }
    }
}

#[test]
fn boards_understand_all_commands_after_power_up() {
    for profile in stock_profiles() {
        let mut twin = Twin::new(profile);
        let sounds = twin.shown().channels.iter().any(Option::is_some);
        // In phase on all elements, until the program connects.
        let sounding = [
            Profile::SonicSurface,
            Profile::SonicSurface2,
            Profile::UltrainoSimpleFpga,
            Profile::UltrainoMega64,
        ];
        assert_eq!(sounds, sounding.contains(&profile), "{}", profile.name());
        let first = twin.shown().channels[0];
        assert!(twin.shown().channels.iter().all(|&level| level == first), "{}", profile.name());
        let mut bytes = [stock::silence(profile), stock::frame(&random_levels(profile, 3))].concat();
        let slow = Modulation { shape: Envelope::Sine, frequency: 1.0, ..Modulation::default() };
        if let Modulated::ByBoard(byte, _) = stock::modulated(profile, &slow, profile.baud()) {
            bytes.push(byte);
        }
        bytes.extend(stock::silence(profile));
        assert!(hear(&mut twin, &bytes).iter().all(|&heard| heard == Heard::Shown), "{}", profile.name());
    }
}

#[test]
fn quantised_levels_are_the_nearest() {
    for profile in Profile::ALL {
        let drive = random_drive(profile.elements(), 7);
        let wiring = Wiring::own(profile);
        let played = wiring.drive(&wiring.levels(&drive, &Calibration::default()).unwrap().drive());
        let steps = f64::from(profile.levels());
        for n in 0..profile.elements() {
            if played.amplitudes[n] == 0.0 {
                assert!(drive.amplitudes[n] < 0.2, "{}: {n} is off", profile.name());
                continue;
            }
            let off = (played.phases[n] - drive.phases[n]).rem_euclid(TAU);
            assert!(off.min(TAU - off) <= PI / steps + 1e-9, "{}: phase of {n}", profile.name());
            let error = (played.amplitudes[n] - drive.amplitudes[n]).abs();
            let allowed = match profile.strength() {
                Strength::Fixed => 1.0,
                Strength::Linear(full) => 0.5 / f64::from(full) + 1e-9,
                Strength::Duty(_) => PI / 2.0 / steps,
            };
            assert!(error <= allowed, "{}: amplitude of {n} is off by {error}", profile.name());
        }
    }
}

#[test]
fn delays_wrap_and_never_mean_off() {
    // 31.6 of 32 rounds to a whole period, which is 0 rather than 32.
    let level = Profile::SonicSurface.level(1.0, -TAU * 31.6 / 32.0).unwrap();
    assert_eq!(level.delay, 0);
    assert_eq!(Profile::SonicSurface.level(1.0, -TAU / 4.0).unwrap().delay, 8, "a byte is a delay");
}

#[test]
fn other_arrays_are_refused_with_both_numbers() {
    let drive = random_drive(255, 1);
    for profile in Profile::ALL {
        let error = Wiring::own(profile).levels(&drive, &Calibration::default()).unwrap_err().to_string();
        assert!(error.contains("255") && error.contains(&profile.elements().to_string()), "{error}");
    }
}

#[test]
fn calibration_corrects_phases_and_amplitudes() {
    let rows = (0..64).map(|n| match n {
        3 => "3,180,1,0\n".to_owned(),
        4 => "4, 0, 0.5, 0\n".to_owned(),
        5 => "5,0,1,1\n".to_owned(),
        6 => "6,72,1,0\n".to_owned(),
        _ => format!("{n},0,1,0\n"),
    });
    let text = format!("element,offset,gain,off\n{}", rows.collect::<String>());
    let calibration = Calibration::parse(&text, 64).unwrap();
    let drive = Drive { amplitudes: vec![1.0; 64], phases: vec![0.0; 64] };
    let levels = Wiring::own(Profile::UltrainoMega64).levels(&drive, &calibration).unwrap();
    assert_eq!(levels.channels[0], Some(Level { delay: 0, amplitude: 5 }));
    assert_eq!(levels.channels[3], Some(Level { delay: 5, amplitude: 5 }));
    assert_eq!(levels.channels[4].unwrap().amplitude, 2);
    assert_eq!(levels.channels[5], None);
    // An element that leads by a fifth of a period is played a fifth of a period later.
    assert_eq!(levels.channels[6], Some(Level { delay: 2, amplitude: 5 }));
    let notice = levels::amplitude_notice(Profile::SonicSurface, &drive, &calibration).unwrap();
    assert!(notice.contains("sonicsurface has no amplitude control"), "{notice}");
    let notice = levels::carrier_notice(40_000.0, 25_000.0).unwrap();
    assert!(notice.contains("40000") && notice.contains("25000"), "{notice}");
}

#[test]
fn amplitudes_that_a_board_lacks_are_noticed_and_others_are_not() {
    let of = |profile: Profile, amplitude: f64, row: &str| {
        let drive = Drive { amplitudes: vec![amplitude, 1.0], phases: vec![0.0; 2] };
        let calibration =
            Calibration::parse(&format!("element,offset,gain,off\n{row}\n1,0,1,0\n"), 2).unwrap();
        usize::from(levels::amplitude_notice(profile, &drive, &calibration).is_some())
    };
    let plain = "0,0,1,0";
    assert_eq!([0.0, 0.5, 1.0].map(|amplitude| of(Profile::SonicSurface, amplitude, plain)), [0, 1, 0]);
    assert_eq!(of(Profile::Native, 0.5, plain), 0);
    assert_eq!(
        ["0,0,0.5,0", "0,0,0.5,1", "0,0,0,0"].map(|row| of(Profile::SonicSurface, 1.0, row)),
        [1, 0, 0]
    );
}

#[test]
fn elements_are_switched_off_and_on_in_a_calibration() {
    let mut calibration = Calibration::default();
    calibration.set_off(5, 8, true);
    calibration.set_off(2, 8, true);
    assert_eq!(calibration.off(), [2, 5]);
    calibration.set_off(5, 8, false);
    let text = calibration.to_csv(8);
    assert_eq!(Calibration::parse(&text, 8), Ok(calibration.clone()));
    assert_eq!(calibration.off(), [2]);
    assert_eq!(Calibration::default().to_csv(2), "element,offset,gain,off\n0,0,1,0\n1,0,1,0\n");
}

#[test]
fn a_checkerboard_begins_with_a_phase_of_zero_and_alternates() {
    for profile in Profile::ALL {
        let wiring = Wiring::own(profile);
        let board = wiring.drive(&wiring.checkerboard(8).drive()).phases;
        let [first, second] = [0.0, PI].map(|phase| profile.sounds(profile.level(1.0, phase).unwrap()).1);
        assert_eq!([board[0], board[1], board[8], board[9]], [first, second, second, first]);
    }
}

#[test]
fn boards_drive_arrays_of_their_own_shape_or_count() {
    let scene = |columns, rows| {
        let text = format!("format = 1\n[array]\ncolumns = {columns}\nrows = {rows}\n");
        file::parse(&text, "scene.toml".as_ref()).unwrap()
    };
    let fits = |profile: Profile, scene: &Scene| Wiring::of(profile, scene, Share::default()).is_ok();
    assert!(fits(Profile::SonicSurface, &scene(16, 16)) && !fits(Profile::SonicSurface, &scene(8, 32)));
    assert!(fits(Profile::UltrainoMega64, &scene(8, 8)) && !fits(Profile::UltrainoMega64, &scene(8, 9)));
    assert!(fits(Profile::Native, &scene(8, 31)) && !fits(Profile::Native, &scene(8, 33)));
    assert!(Profile::Native.answers() && Profile::Natives(8).answers() && !Profile::SonicSurface.answers());
}

#[test]
fn carriers_equal_to_a_millionth_need_no_notice() {
    for (frequency, differs) in [(40_000.03, false), (39_999.97, false), (40_000.05, true), (39_999.95, true)]
    {
        assert_eq!(levels::carrier_notice(40_000.0, frequency).is_some(), differs, "{frequency} Hz");
    }
}

#[test]
fn drives_in_turn_change_as_fast_as_the_line_and_the_transducers() {
    for (profile, baud, drives, rate) in [
        (Profile::Native, 9600, 6, 1000.0),
        (Profile::Natives(3), 9600, 6, 1000.0),
        (Profile::SonicSurface, 230_400, 3, 23_040.0 / 258.0),
        (Profile::SonicSurface, 230_400, 2, 1000.0),
        (Profile::Acoustophoretic512, 250_000, 2, 25_000.0 / 512.0),
        (Profile::SonicSurface, 100_000_000, 6, 1000.0),
    ] {
        assert_eq!(profile.turns_per_second(baud, drives), rate, "{} at {baud} baud", profile.name());
    }
}

#[test]
fn areas_have_one_drive_on_slow_boards() {
    let at = DVec3::Z * 0.1;
    let disc = Target { sampling: Sampling::Fill, ..Target::new(Shape::Circle { at, radius: 0.02 }) };
    let of = |target: &Target, frames: Turns| {
        let mut scene = Scene { targets: vec![target.clone()], ..Scene::default() };
        scene.solver.frames = frames;
        scene
    };
    for (profile, baud, is_slow) in [
        (Profile::Native, 9600, false),
        (Profile::SonicSurface, 230_400, true),
        (Profile::SonicSurface, 1_540_000, true),
        (Profile::SonicSurface, 1_550_000, false),
    ] {
        let mut scene = of(&disc, Turns::Auto);
        let word = profile.steady(&mut scene, baud);
        assert_eq!(word.is_some(), is_slow, "{word:?}");
        assert_eq!(scene.drives_in_turn(), if is_slow { 1..=1 } else { 1..=6 }, "{word:?}");
    }
    // A number is played as it is, and points have one drive anyway.
    for scene in [of(&disc, Turns::Count(4)), of(&Target::new(Shape::Point { at }), Turns::Auto)] {
        let mut played = scene.clone();
        assert_eq!(Profile::SonicSurface.steady(&mut played, 230_400), None);
        assert_eq!(played, scene);
    }
}

#[test]
fn invalid_calibrations_are_refused_with_their_line() {
    let parse = |rows: &str| Calibration::parse(&format!("element,offset,gain,off\n{rows}"), 3);
    let line_of = |rows: &str| match parse(rows) {
        Err(CalibrationError::Row(error)) => error.line,
        other => panic!("{rows:?} gave {other:?}"),
    };
    assert!(parse("2,0,1,0\n0,0,1,0\n1,-90,0.5,1\n").is_ok());
    for element in ["3", "9", "-1", "0.5", "-0.5"] {
        assert_eq!(line_of(&format!("2,0,1,0\n{element},0,1,0\n")), 3, "{element}");
    }
    assert_eq!(line_of("0,0,1,0\n1,nan,1,0\n"), 3);
    assert_eq!(line_of("0,1e300,1,0\n"), 2);
    assert_eq!(line_of("0,0,1.5,0\n"), 2);
    assert_eq!(line_of("0,0,nan,0\n"), 2);
    assert_eq!(line_of("0,0,1,2\n"), 2);
    assert_eq!(line_of("0,0,1,0\n0,0,1,0\n"), 3);
    assert_eq!(line_of("0,0,1\n"), 2);
    assert_eq!(line_of("0,zero,1,0\n"), 2);
    let gaps = parse("1,0,1,0\n").unwrap_err().to_string();
    assert!(gaps.contains("2 of 3") && gaps.contains("0, 2"), "{gaps}");
    assert!(Calibration::parse("", 3).is_err());
    assert!(Calibration::parse("a,b\n1,2\n", 3).is_err());
}

#[test]
fn modulation_is_by_the_board_or_by_the_host() {
    let modulation = Modulation { shape: Envelope::Sine, frequency: 200.0, ..Modulation::default() };
    let modulated = |profile: Profile, modulation| stock::modulated(profile, modulation, profile.baud());
    for profile in
        [Profile::SonicSurface, Profile::SonicSurface2, Profile::UltrainoSimpleFpga, Profile::UltrainoMega64]
    {
        assert_eq!(modulated(profile, &modulation), Modulated::FromHere(200.0), "{}", profile.name());
    }
    // 48.8 frames/s at 250000 baud, and two frames per modulation period.
    let never = modulated(Profile::Acoustophoretic512, &modulation);
    assert!(matches!(never, Modulated::Never(fastest) if (fastest - 24.4).abs() < 0.1), "{never:?}");
    let fast = stock::modulated(Profile::Acoustophoretic512, &modulation, 3_000_000);
    assert_eq!(fast, Modulated::FromHere(200.0), "fast enough on a faster line");
    // 1250 / (step + 1): 208.3 Hz is the nearest step of the tactile build.
    let tactile = |modulation| modulated(Profile::SonicSurfaceTactile, modulation);
    assert_eq!(tactile(&modulation), Modulated::ByBoard(0xA5, 1250.0 / 6.0));
    let between = Modulation { frequency: 190.0, ..modulation.clone() };
    assert_eq!(tactile(&between), Modulated::ByBoard(0xA6, 1250.0 / 7.0));
    let slow = Modulation { frequency: 1.0, ..modulation.clone() };
    assert_eq!(tactile(&slow), Modulated::ByBoard(0xBF, 1250.0 / 32.0), "its slowest step");
    let unknown = Modulation { frequency: f64::NAN, ..modulation.clone() };
    assert_eq!(tactile(&unknown), Modulated::ByBoard(0xBF, 1250.0 / 32.0), "the slowest step");
    assert_eq!(modulated(Profile::SonicSurface, &Modulation::default()), Modulated::Steady);
}
