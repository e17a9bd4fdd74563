//! Quantities against the model: formulae in WGSL and Rust, and maps on any plane.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, dvec3};
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::sound::{ALONG, Constants, NORMAL, PRESSURE, Sound};
use sonoglyph::field::{By, Evaluator, Map, Norm, Quantity, Request, Samples, Stages};
use sonoglyph::scene::{Board, Plane, Scene};

use crate::model;
use crate::{evaluators, fast_evaluators, gpu, own, three_foci};

/// Irregular numbers from -1 to 1.
fn numbers() -> impl Iterator<Item = f32> {
    (1u32..).map(|i| {
        (i.wrapping_mul(0x9e37_79b9) ^ (i << 13)).wrapping_mul(0x85eb_ca6b) as f32 / 2f32.powi(31) - 1.0
    })
}

#[test]
fn a_formula_is_the_same_in_wgsl_and_in_rust() {
    let Some(gpu) = gpu() else { return };
    let mut numbers = numbers();
    let mut number = || numbers.next().unwrap();
    for scale in [1e-3, 1.0, 3000.0] {
        let mut complex = || Complex32::new(scale * number(), scale * number());
        let mut sounds: Vec<_> =
            (0..999).map(|_| Sound { p: complex(), x: complex(), y: complex(), n: complex() }).collect();
        sounds.push(Sound::default());
        let constants = Constants {
            of_pressure: 1.0 + number(),
            of_gradient: 1.0 + number(),
            of_velocity: 1.0 + number(),
            turn: Complex32::cis(4.0 * number()),
        };
        for quantity in Quantity::ALL.into_iter().filter(|quantity| quantity.declaration().has_formula()) {
            let got = gpu.form(quantity, &sounds, &constants).unwrap();
            let expected: Vec<_> = sounds.iter().map(|&sound| quantity.of(sound, &constants)).collect();
            assert_eq!(got.len(), expected.len());
            let largest = expected.iter().fold(0.0f32, |most, value| most.max(value.abs()));
            assert!(largest > 0.1 * scale.min(scale * scale) || quantity == Quantity::Phase);
            for ((got, expected), sound) in got.iter().zip(&expected).zip(&sounds) {
                let off = got - expected;
                let is_same = if quantity == Quantity::Phase {
                    // At the branch cut either end is right. WGSL allows atan2 4096 ulp.
                    (off - (off / TAU as f32).round() * TAU as f32).abs() < 1e-3
                } else {
                    off.abs() < 3e-6 * largest
                };
                assert!(is_same, "{quantity:?} of {sound:?}: {got}, not {expected}");
            }
        }
    }
}

/// The expected value of a pixel.
struct Expected {
    value: f64,
    /// |P| (Pa), 0 in silence.
    modulus: f64,
}

/// The largest deviation of a map's values at every [`STRIDE`]-th pixel, relative to its peak; for phases, that of
/// phasors with these phases.
fn deviation(map: &Map, quantity: Quantity, expected: &[Expected]) -> f64 {
    let off = |(&got, &Expected { value, modulus }): (&f32, &Expected)| {
        let got = f64::from(got);
        assert!(modulus != 0.0 || got == 0.0, "{quantity:?} of silence: {got}");
        let off = if quantity == Quantity::Phase {
            modulus * (Complex64::cis(got) - Complex64::cis(value)).norm()
        } else {
            (got - value).abs()
        };
        // `max` ignores NaN.
        if off.is_nan() { f64::INFINITY } else { off }
    };
    let got = map.values.iter().step_by(STRIDE);
    assert_eq!(got.len(), expected.len());
    got.zip(expected).map(off).fold(0.0, f64::max) / f64::from(map.peak)
}
const STRIDE: usize = 37;

fn planes() -> [(&'static str, Plane); 5] {
    let plane = Plane { size: DVec2::new(0.06, 0.05), ..Plane::default() };
    let upright = Plane { y_axis: DVec3::Z, ..plane.clone() };
    [
        ("parallel", plane.clone()),
        ("tilted", Plane { x_axis: dvec3(1.0, 0.2, 0.4), y_axis: dvec3(0.0, 1.0, -0.5), ..plane.clone() }),
        ("vertical", Plane { centre: dvec3(0.003, 0.001, 0.12), ..upright.clone() }),
        ("through the array", Plane { centre: dvec3(0.0, 0.002, 0.021), ..upright }),
        ("a millimetre in front of it", Plane { centre: dvec3(0.003, 0.001, 0.001), ..plane }),
    ]
}

/// The expected maker of a map: the evaluator asked for, if f32 keeps the tolerance and the quantity is formed at
/// pixels.
fn maker(asked: By, quantity: Quantity, tolerance: f64, is_near: bool) -> Option<By> {
    let declaration = quantity.declaration();
    let by_pressure = declaration.parts == PRESSURE;
    let by_cells = declaration.is_square && !by_pressure;
    match asked {
        By::Gpu if by_pressure => Some(By::Gpu),
        // Slopes at finer tolerances need f64; slopes near the array are not formed on the GPU.
        By::Gpu if !by_cells && tolerance > 5e-4 && !is_near => Some(By::Gpu),
        By::Cpu if by_pressure => Some(By::Cpu),
        By::Cpu if tolerance > finest(quantity) && !is_near => Some(By::Cpu),
        By::Reference => Some(By::Reference),
        By::Cpu | By::CpuInF64 | By::Gpu => None,
    }
}

/// Below this tolerance slopes are computed in f64. It is coarser for squares of all parts, as potentials, whose terms
/// nearly cancel.
fn finest(quantity: Quantity) -> f64 {
    let declaration = quantity.declaration();
    if declaration.is_square && declaration.parts == PRESSURE | ALONG | NORMAL { 5e-3 } else { 5e-4 }
}

#[test]
fn every_quantity_keeps_the_tolerance_on_any_plane() {
    const MOMENT: f64 = 0.7;
    const FEW: (usize, usize) = (72, 60);
    let (scene, drives) = three_foci();
    let aperture = Aperture::new(&scene);
    let is_pointwise =
        |quantity: &Quantity| !quantity.declaration().is_pressed() && quantity.declaration().has_formula();
    let pointwise = Quantity::ALL.into_iter().filter(is_pointwise);
    let mut stages: Vec<_> = evaluators().into_iter().map(|it| (own(&it), Stages::new(it))).collect();
    for (name, plane) in planes() {
        let (x, y) = plane.axes().unwrap();
        let pixels = Samples::on_plane(&plane, FEW.0, FEW.1).unwrap();
        let points: Vec<_> = (0..pixels.len()).step_by(STRIDE).map(|i| pixels.point(i)).collect();
        let is_near = pixels.point(0).z < aperture.wavelength();
        let sounds = model::sounds(&aperture, &drives[0], [x, y, x.cross(y)], &points);
        for quantity in pointwise.clone() {
            let request = Request {
                plane: plane.clone(),
                moment: MOMENT,
                ..Request::new(&scene, vec![drives[0].clone()], quantity, FEW)
            };
            let expected = |&sound: &model::Sound| Expected {
                value: model::value(quantity, &request.air, &aperture, MOMENT, [sound].into_iter()),
                modulus: sound.p.norm(),
            };
            let expected: Vec<_> = sounds.iter().map(expected).collect();
            for (asked, stages) in &mut stages {
                for tolerance in [1e-2, 1e-3, 1e-4] {
                    let plane = Plane { tolerance, ..plane.clone() };
                    let map = stages.map(&Request { plane, ..request.clone() }).unwrap();
                    let off = deviation(map, quantity, &expected);
                    let Map { by, error, how, .. } = map;
                    let name = format!("{quantity:?}, {name}, {tolerance:e} of {asked:?} by {by:?}");
                    println!("{name}: {off:.1e}, measured {error:.1e}, {how}");
                    let most = if *asked == By::Reference { 1e-5 } else { tolerance };
                    assert!(off < most, "{name}: {off:e}, {how}");
                    assert!(
                        *error < tolerance && off < 20.0 * error + 1e-5,
                        "{name}: {off:e}, measured {error:e}"
                    );
                    let maker = maker(*asked, quantity, tolerance, is_near);
                    assert!(maker.is_none_or(|maker| maker == *by), "{name}, not by {maker:?}: {how}");
                    // Phases and instantaneous pressures are relative to the largest |P|, and pixels next to
                    // elements do not count.
                    if quantity.declaration().norm != Norm::Pressure && map.near == 0 {
                        let largest = map.values.iter().fold(0.0f32, |most, value| most.max(value.abs()));
                        assert!(
                            (map.peak - largest).abs() <= 1e-6 * largest,
                            "{name}: {} {largest}",
                            map.peak
                        );
                    }
                }
            }
        }
    }
}

/// Also in the board's plane, where neighbours for slopes would be behind it.
#[test]
fn a_scene_moved_as_a_whole_has_the_same_maps() {
    const SMALL: (usize, usize) = (24, 20);
    let (mut scene, drives) = three_foci();
    let offset = dvec3(0.03, -0.02, 0.07);
    let is_pointwise =
        |quantity: &Quantity| !quantity.declaration().is_pressed() && !quantity.declaration().of_volume;
    for height in [0.0, 2e-7, 0.003, 0.02, 0.1] {
        scene.plane.centre = DVec3::Z * height;
        let moved = Scene {
            boards: vec![Board { at: offset, ..Board::default() }],
            plane: Plane { centre: scene.plane.centre + offset, ..scene.plane.clone() },
            ..scene.clone()
        };
        for quantity in Quantity::ALL.into_iter().filter(is_pointwise) {
            for evaluator in [Evaluator::Cpu, Evaluator::Reference] {
                let mut stages = Stages::new(evaluator);
                let [here, there] = [&scene, &moved].map(|scene| {
                    let request = Request::new(scene, drives[..1].to_vec(), quantity, SMALL);
                    stages.map(&request).unwrap().clone()
                });
                let off =
                    here.values.iter().zip(&there.values).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert_eq!(here.by, there.by, "{quantity:?}, {height} m: {}, {}", here.how, there.how);
                assert!(off <= 1e-6 * here.peak, "{quantity:?}, {height} m: {off:e} of {}", here.peak);
            }
        }
    }
}
#[test]
fn contours_are_at_their_fraction_of_the_peak() {
    let (scene, drives) = three_foci();
    for evaluator in fast_evaluators() {
        let mut stages = Stages::new(evaluator);
        // Of levels a fraction says nothing.
        let has_fraction =
            |quantity: &Quantity| quantity.declaration().has_mean && !quantity.declaration().is_level();
        for quantity in Quantity::ALL.into_iter().filter(has_fraction) {
            let request = Request::new(&scene, drives.clone(), quantity, (60, 50));
            // A potential is far from 0 at its minimum.
            let part = if quantity == Quantity::Gorkov { -0.4 } else { 0.4 };
            let lines = stages.contours(&request, part).unwrap().to_vec();
            assert!(!lines.is_empty(), "{quantity:?}");
            let Map { values, peak, .. } = stages.map(&request).unwrap();
            for [x, y] in lines.into_iter().flatten() {
                // Bilinear between the centres of four pixels.
                let (column, row) = ((x - 0.5).floor().clamp(0.0, 58.0), (y - 0.5).floor().clamp(0.0, 48.0));
                let (right, up) = (x - 0.5 - column, y - 0.5 - row);
                let first = row as usize * 60 + column as usize;
                let along = |at: usize| values[at] * (1.0 - right) + values[at + 1] * right;
                let value = along(first) * (1.0 - up) + along(first + 60) * up;
                assert!((value / peak - part).abs() < 0.02, "{quantity:?}: {value} of {peak}");
            }
        }
    }
}
