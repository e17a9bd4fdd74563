//! The sound field of the bytes sent to a board, summed over the transducer positions that its author published.

use std::f64::consts::PI;
use std::path::Path;

use glam::{DVec2, DVec3, dvec2, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::{Aperture, Element};
use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::native::packet::Packet;
use sonoglyph::device::profile::Profile;
use sonoglyph::device::stock;
use sonoglyph::device::wiring::Wiring;
use sonoglyph::scene::{Array, Scene, Shape, Target};
use sonoglyph::solver;
use sonoglyph::studio::presets::KNOWN;

use crate::published::{Gateware, Transducer, played};

/// Off the axes, so that a mirrored or rotated order moves it.
const FOCUS: DVec3 = dvec3(0.03, -0.02, 0.1);

fn scene(profile: Profile) -> Scene {
    let preset = |title: &str| {
        let known = KNOWN.iter().find(|known| known.title == title).unwrap();
        Array { element_radius: Array::default().element_radius, ..known.array().unwrap().0 }
    };
    let array = match profile {
        Profile::SonicSurface | Profile::SonicSurfaceTactile => preset("SonicSurface, 16 x 16"),
        Profile::UltrainoMega64 => preset("Ultraino, 8 x 8"),
        Profile::Native
        | Profile::Natives(_)
        | Profile::SonicSurface2
        | Profile::UltrainoSimpleFpga
        | Profile::Acoustophoretic512 => {
            let [columns, rows] = profile.shape().unwrap_or([16, 16]);
            Array { columns, rows, pitch: 10.5e-3, ..Array::default() }
        }
    };
    Scene { array, targets: vec![Target::new(Shape::Point { at: FOCUS })], ..Scene::default() }
}

fn bytes(profile: Profile, calibration: &Calibration) -> Vec<u8> {
    let drive = solver::solve(&scene(profile)).unwrap().drive;
    let levels = Wiring::own(profile).levels(&drive, calibration).unwrap();
    if profile == Profile::Native {
        Packet::playing(&levels, 0, true).to_line()
    } else {
        stock::frame(&levels)
    }
}

/// Complex pressure at a point, Pa (peak).
fn pressure(transducers: &[Transducer], element: &Element, at: DVec3) -> Complex64 {
    let wave = |one: &Transducer| one.plays * element.transfer(at - one.place.extend(0.0));
    transducers.iter().map(wave).sum()
}

/// Position of the maximum at the focus' height, to 0.25 mm.
fn loudest(transducers: &[Transducer], element: &Element) -> DVec2 {
    let search = |about: DVec2, half: i32, step: f64| {
        let places = (-half..=half).flat_map(|i| (-half..=half).map(move |j| (f64::from(i), f64::from(j))));
        let places = places.map(|(i, j)| about + step * dvec2(i, j));
        let loudness = |place: &DVec2| pressure(transducers, element, place.extend(FOCUS.z)).norm();
        places.max_by(|a, b| loudness(a).total_cmp(&loudness(b))).unwrap()
    };
    search(search(DVec2::ZERO, 45, 2e-3), 8, 0.25e-3)
}

/// The pressure at the focus relative to that of the same pulses all in phase.
fn in_phase(transducers: &[Transducer], element: &Element) -> f64 {
    let reach = |one: &Transducer| (one.plays * element.transfer(FOCUS - one.place.extend(0.0))).norm();
    pressure(transducers, element, FOCUS).norm() / transducers.iter().map(reach).sum::<f64>()
}

fn heard(profile: Profile, calibration: &Calibration, gateware: Gateware) -> (DVec2, f64) {
    let scene = scene(profile);
    let element = Aperture::new(&scene).element;
    let transducers = played(profile, &bytes(profile, calibration), scene.array.pitch, gateware);
    (loudest(&transducers, &element), in_phase(&transducers, &element))
}

#[test]
fn a_focus_is_in_its_place_on_every_board() {
    for profile in Profile::ALL {
        let (place, part) = heard(profile, &Calibration::default(), Gateware::Published);
        assert!(place.distance(FOCUS.truncate()) < 2e-3, "{}: {:.2} mm", profile.name(), place * 1e3);
        // Rounding phases to L levels leaves sin(π/L) / (π/L) on average: 0.984 for the Mega's 10. There the common
        // phase, which is arbitrary, moves it by up to 0.01.
        let step = PI / f64::from(profile.levels());
        let expected = step.sin() / step;
        let most_off = f64::max(0.003, 0.1 / f64::from(profile.levels()));
        assert!((part - expected).abs() < most_off, "{}: {part} of in phase", profile.name());
    }
}

#[test]
fn the_tactile_boards_built_in_corrections_are_compensated() {
    let tactile =
        |calibration: &Calibration, gateware| heard(Profile::SonicSurfaceTactile, calibration, gateware).1;
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/calibrations/sonicsurface-tactile-zero-table.csv");
    let zero_table = Calibration::read(&file, &Scene::default()).unwrap();
    let plain = Calibration::default();
    for (calibration, gateware, fits) in [
        (&plain, Gateware::Published, true),
        (&plain, Gateware::Rebuilt, false),
        (&zero_table, Gateware::Published, false),
        (&zero_table, Gateware::Rebuilt, true),
    ] {
        let part = tactile(calibration, gateware);
        assert!(if fits { part > 0.98 } else { part < 0.25 }, "{part} of in phase");
    }
}
