//! Light refracted or reflected by a depressed surface: against counted rays in f64, and its invariances.

use std::f64::consts::PI;

use glam::DVec2;
use sonoglyph::drive::Drive;
use sonoglyph::field::{Evaluator, Quantity, Request, Stages};
use sonoglyph::scene::{Light, Plane, Scene};
use sonoglyph::surface::Tank;
use strum::VariantArray;

use crate::{evaluators, three_foci};

/// The light map of one focus on water.
fn request(size: (usize, usize)) -> Request {
    let (mut scene, mut drives) = three_foci();
    drives.truncate(1);
    scene.liquid.screen = 0.05;
    Request::new(&scene, drives, Quantity::Caustic, size)
}

/// The brightness of a map's pixels, by counting `rays` per pixel along each axis.
///
/// The slopes at the rays are those of the cosine series through the depths of the cells.
fn counted(request: &Request, tank: &Tank, depth: &[f64], rays: usize) -> Vec<f64> {
    let (columns, rows) = request.size;
    let modes = tank.modes(depth);
    let length = [0, 1].map(|axis| tank.counts[axis] as f64 * tank.step[axis]);
    let pixel = request.plane.size / DVec2::new(columns as f64, rows as f64);
    let step = pixel / rays as f64;
    let count = [0, 1].map(|axis| (length[axis] / step[axis]).floor() as usize);
    // Relative to the tank's corner.
    let place =
        |axis: usize, i: usize| length[axis] / 2.0 + (i as f64 + 0.5 - count[axis] as f64 / 2.0) * step[axis];
    let wave = |axis: usize, i: usize, mode: usize| {
        let q = PI * mode as f64 / length[axis];
        let (sin, cos) = (q * place(axis, i)).sin_cos();
        (cos, -q * sin)
    };
    // Sums over the modes along x, for every row of modes.
    let across: Vec<Vec<(f64, f64)>> = (0..count[0])
        .map(|i| {
            let waves: Vec<_> = (0..tank.counts[0]).map(|mode| wave(0, i, mode)).collect();
            modes
                .chunks(tank.counts[0])
                .map(|row| {
                    let sum = |of: &dyn Fn(&(f64, f64)) -> f64| -> f64 {
                        row.iter().zip(&waves).map(|(mode, wave)| mode * of(wave)).sum()
                    };
                    (sum(&|wave| wave.0), sum(&|wave| wave.1))
                })
                .collect()
        })
        .collect();
    let mut counts = vec![0.0; columns * rows];
    for j in 0..count[1] {
        let waves: Vec<_> = (0..tank.counts[1]).map(|mode| wave(1, j, mode)).collect();
        for (i, across) in across.iter().enumerate() {
            let pairs = across.iter().zip(&waves);
            let (x, y) = pairs
                .fold((0.0, 0.0), |(x, y), ((value, slope), wave)| (x + slope * wave.0, y + value * wave.1));
            let landing = |axis: usize, i: usize, slope: f64| {
                let from_centre = place(axis, i) - length[axis] / 2.0 - request.liquid.throw() * slope;
                ((from_centre + request.plane.size[axis] / 2.0) / pixel[axis]).floor()
            };
            let (column, row) = (landing(0, i, x), landing(1, j, y));
            if (0.0..columns as f64).contains(&column) && (0.0..rows as f64).contains(&row) {
                counts[row as usize * columns + column as usize] += 1.0 / (rays * rays) as f64;
            }
        }
    }
    counts
}

fn brightest(values: &[f32]) -> f64 {
    values.iter().copied().fold(0.0f32, f32::max).into()
}

#[test]
fn pixels_agree_with_counted_rays() {
    // The second screen is beside the focus, whose light reaches it.
    for (light, aside, screen) in
        [(Light::Through, 0.0, 0.05), (Light::Reflected, 0.0, 0.05), (Light::Through, -0.045, 2.0)]
    {
        let mut request = request((60, 50));
        (request.liquid.light, request.liquid.screen, request.plane.centre.x) = (light, screen, aside);
        let mut in_f64 = Stages::new(Evaluator::Reference);
        let (tank, dent) = in_f64.surface(&request).unwrap();
        let expected = counted(&request, tank, &dent.depth, 20);
        for evaluator in evaluators() {
            let map = Stages::new(evaluator).map(&request).unwrap().clone();
            let off = map.values.iter().zip(&expected).map(|(&value, it)| (f64::from(value) - it).abs());
            let mean = off.clone().sum::<f64>() / expected.len() as f64;
            let worst = off.fold(0.0, f64::max) / brightest(&map.values);
            assert!(mean < 0.02 && worst < 0.05, "{light:?}: {mean}, {worst} of {}", map.peak);
            assert!(
                (f64::from(map.peak) - brightest(&map.values)).abs() < 1e-6 && map.peak > 1.2,
                "{}",
                map.peak
            );
            // A depression spreads transmitted light and focuses reflected light.
            let at_focus = f64::from(map.values[29 * 60 + 40]);
            assert!(aside != 0.0 || (light == Light::Through) == (at_focus < 1.0), "{light:?}: {at_focus}");
        }
    }
}

#[test]
fn light_is_conserved_and_the_loss_beyond_the_screen_is_stated() {
    let mut stages = Stages::new(Evaluator::Cpu);
    let mut landed = |request: &Request| {
        let map = stages.map(request).unwrap();
        let mean = map.values.iter().map(|&value| f64::from(value)).sum::<f64>() / map.values.len() as f64;
        let light = stages.pressed(request).unwrap().light.unwrap();
        assert!((light.landed - mean).abs() < 1e-6, "{light:?} {mean}");
        light
    };
    let mut request = request((200, 200));
    // With a flat edge, all light that leaves the plane lands on its screen.
    request.plane.size = DVec2::splat(0.3);
    let wide = landed(&request);
    assert!((wide.landed - 1.0).abs() < 1e-3, "{wide:?}");
    request.plane.size = DVec2::splat(0.02);
    request.plane.centre.x = 0.01;
    request.liquid.screen = 0.2;
    let narrow = landed(&request);
    assert!(narrow.landed < 0.9, "{narrow:?}");
}

#[test]
fn a_silent_drive_gives_uniform_light() {
    let mut request = request((31, 17));
    request.drives = [Drive { amplitudes: vec![0.0; 256], phases: vec![0.0; 256] }].into();
    let mut stages = Stages::new(Evaluator::Cpu);
    let map = stages.map(&request).unwrap();
    assert!(map.values.iter().all(|value| (value - 1.0).abs() < 1e-6) && map.error == 0.0, "{map:?}");
}

/// The screen's distance, the index and the depth after the envelope enter as one product.
#[test]
fn a_flatter_surface_bends_light_as_a_nearer_screen_does() {
    let mut stages = Stages::new(Evaluator::Cpu);
    let mut values = |request: &Request| stages.map(request).unwrap().values.clone();
    let near = |one: &[f32], other: &[f32]| {
        let off = one.iter().zip(other).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        off < 1e-3 * brightest(one)
    };
    let whole = request((90, 75));
    let mut half = Request { part: 0.5, ..whole.clone() };
    let halved = values(&half);
    assert!(!near(&values(&whole), &halved));
    half = Request { liquid: whole.liquid.clone(), ..whole.clone() };
    half.liquid.screen /= 2.0;
    assert!(near(&values(&half), &halved));
    half.liquid.screen = 2.0 * whole.liquid.screen;
    half.liquid.refractive_index = Some(1.0 + (whole.liquid.refractive_index() - 1.0) / 4.0);
    assert!(near(&values(&half), &halved));
    // A given surface is not scaled by the envelope.
    let depth = stages.surface(&whole).unwrap().1.depth.clone();
    let moving = Request { depth: Some(depth.iter().map(|depth| 0.5 * depth).collect()), part: 0.3, ..whole };
    assert!(near(&stages.map(&moving).unwrap().values, &halved));
}

#[test]
fn larger_pixels_are_means_of_smaller_ones() {
    let mut stages = Stages::new(Evaluator::Cpu);
    let fine = stages.map(&request((240, 200))).unwrap().values.clone();
    let coarse = stages.map(&request((60, 50))).unwrap().values.clone();
    let worst = coarse.iter().enumerate().map(|(i, value)| {
        let (column, row) = (4 * (i % 60), 4 * (i / 60));
        let sum: f32 = (0..16).map(|k| fine[(row + k / 4) * 240 + column + k % 4]).sum();
        f64::from((sum / 16.0 - value).abs())
    });
    let worst = worst.fold(0.0, f64::max);
    assert!(worst < 0.03 * brightest(&coarse), "{worst} of {}", brightest(&coarse));
}

#[test]
fn a_screen_may_be_far_away_or_at_the_surface() {
    let mut stages = Stages::new(Evaluator::Cpu);
    let scene =
        Scene { plane: Plane { size: DVec2::new(0.06, 0.05), ..Plane::default() }, ..Scene::default() };
    let drives = three_foci().1;
    for (screen, tolerance) in [(1e-9, 1e-3), (1e-3, 1.0), (1.0, 1e-5), (100.0, 1e-3)] {
        for &light in Light::VARIANTS {
            let mut request = Request::new(&scene, drives.clone(), Quantity::Caustic, (70, 60));
            (request.liquid.screen, request.liquid.light) = (screen, light);
            request.plane.tolerance = tolerance;
            let map = stages.map(&request).unwrap();
            assert!(map.values.iter().all(|value| value.is_finite() && *value >= 0.0), "{screen}");
            assert!(screen > 1e-6 || map.values.iter().all(|value| (value - 1.0).abs() < 1e-4));
        }
    }
}
