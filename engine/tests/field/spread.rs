//! Maps of arrays whose elements differ: the mean square is that of equal elements, weakened, and a sum over elements.

use glam::{DVec2, DVec3, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::{Quantity, Request, Samples, Stages};
use sonoglyph::scene::{Array, Plane, Reflector, Scene, Spread};

use crate::{evaluators, own, scattered};

const SIZE: (usize, usize) = (61, 53);

/// The scenes: a plane across the beam, one along it down to the array, an oblique one, and one below a mirror.
fn scenes() -> Vec<Scene> {
    let plane = Plane { size: DVec2::new(0.12, 0.1), ..Plane::default() };
    let along = Plane { centre: DVec3::Z * 0.052, y_axis: DVec3::Z, ..plane.clone() };
    let oblique = Plane {
        centre: dvec3(0.01, 0.0, 0.06),
        x_axis: dvec3(1.0, 0.2, 0.4),
        y_axis: DVec3::Y,
        ..plane.clone()
    };
    let array = Array { rows: 8, columns: 8, spread: Spread { gain: 0.2, phase: 0.6 }, ..Array::default() };
    let scene = |plane: Plane, mirrors: Vec<Reflector>| Scene {
        array: array.clone(),
        plane,
        reflectors: mirrors,
        ..Scene::default()
    };
    let mirror = Reflector { point: DVec3::Z * 0.13, ..Reflector::default() };
    vec![
        scene(plane.clone(), Vec::new()),
        scene(along, Vec::new()),
        scene(oblique, Vec::new()),
        scene(plane, vec![mirror]),
    ]
}

#[test]
fn maps_with_a_spread_are_means_over_arrays() {
    for evaluator in evaluators() {
        let by = own(&evaluator);
        let mut stages = Stages::new(evaluator);
        for (number, scene) in scenes().into_iter().enumerate() {
            let aperture = Aperture::new(&scene);
            let drive = scattered(64, 0.3);
            let u = drive.excitation(&aperture.driven);
            let samples = Samples::on_plane(&scene.plane, SIZE.0, SIZE.1).unwrap();
            let points: Vec<_> = (0..samples.len()).map(|pixel| samples.point(pixel)).collect();
            let Spread { gain, phase } = scene.array.spread;
            let kept = (-phase * phase).exp();
            let mean = |row: Vec<Complex64>| {
                let sum: Complex64 = row.iter().zip(&u).map(|(h, u)| h * u).sum();
                let alone: f64 = row.iter().zip(&u).map(|(h, u)| (h * u).norm_sqr()).sum();
                (0.5 * (kept * sum.norm_sqr() + (gain * gain + 1.0 - kept) * alone)).sqrt()
            };
            let expected: Vec<_> = aperture.transfer(&points).rows().map(|row| mean(row.collect())).collect();
            let request = Request::new(&scene, vec![drive.clone()], Quantity::Rms, SIZE);
            let map = stages.map(&request).unwrap();
            let off = |(value, expected): (&f32, &f64)| {
                (f64::from(*value) - expected).abs() / expected.max(f64::from(map.peak))
            };
            let off = map.values.iter().zip(&expected).map(off).fold(0.0, f64::max);
            assert!(off < 1.5e-3 && off <= map.error.max(1e-6), "{by:?} {number}: {off} of {}", map.error);
            let equal = Request { spread: Spread::default(), ..request };
            let equal = stages.map(&equal).unwrap().values.clone();
            let change =
                equal.iter().zip(&expected).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
            assert!(
                change > 0.05 * f64::from(equal.iter().copied().fold(0.0, f32::max)),
                "{number}: {change}"
            );
        }
    }
}

#[test]
fn squares_of_slopes_have_their_scatter_too() {
    let scene = &scenes()[0];
    let drive = scattered(64, 0.3);
    for quantity in [Quantity::Velocity, Quantity::Speed, Quantity::Radiation] {
        // Gain alone, with signs by Walsh functions: uncorrelated between elements, so that this mean is exact.
        let gain = scene.array.spread.gain;
        let spread = Spread { gain, phase: 0.0 };
        let request = Request { spread, ..Request::new(scene, vec![drive.clone()], quantity, (12, 10)) };
        let mean = Stages::new(sonoglyph::field::Evaluator::Cpu).map(&request).unwrap().clone();
        let sign = |n: usize, drive: usize| {
            if ((n + 1) & drive).count_ones().is_multiple_of(2) { gain } else { -gain }
        };
        let drives = (0..128).map(|number| {
            let mut own = drive.clone();
            own.amplitudes
                .iter_mut()
                .enumerate()
                .for_each(|(n, a)| *a *= (1.0 + sign(n, number)) / (1.0 + gain));
            own
        });
        let equal = Request { spread: Spread::default(), drives: drives.collect(), ..request };
        let drawn = Stages::new(sonoglyph::field::Evaluator::Reference).map(&equal).unwrap().clone();
        let is_root = quantity.declaration().is_root;
        let times = if is_root { 1.0 + gain } else { (1.0 + gain).powi(2) } as f32;
        for (a, b) in mean.values.iter().zip(&drawn.values) {
            assert!((a - b * times).abs() < 3e-3 * mean.peak, "{quantity:?}: {a}, drawn {}", b * times);
        }
    }
}
