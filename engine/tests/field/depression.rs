//! Liquid surfaces under sound: displaced volume, invariances, errors, and moving surfaces.

use glam::{DVec2, DVec3, dvec3};
use sonoglyph::field::{By, Evaluator, FieldError, Pressed, Quantity, Request, Stages, Work};
use sonoglyph::scene::{Liquid, Plane, Shape, Target};
use sonoglyph::solver;
use sonoglyph::surface::Dent;

use crate::{evaluators, fast_evaluators, three_foci};

fn largest_difference(got: &[f32], expected: &[f64]) -> f64 {
    assert_eq!(got.len(), expected.len());
    let largest = expected.iter().copied().fold(0.0, f64::max);
    let off = |(got, expected): (&f32, &f64)| (f64::from(*got) - expected).abs();
    got.iter().zip(expected).map(off).fold(0.0, f64::max) / largest
}

#[test]
fn a_depression_displaces_the_weight_of_the_force_and_follows_the_envelope() {
    let (scene, mut drives) = three_foci();
    drives.truncate(1);
    let request = Request::new(&scene, drives, Quantity::Depression, (64, 50));
    for evaluator in evaluators() {
        let mut stages = Stages::new(evaluator);
        let mut pressed = |part: f64, liquid: &Liquid| {
            let request = Request { part, liquid: liquid.clone(), ..request.clone() };
            let peak = f64::from(stages.map(&request).unwrap().peak);
            let pressed = stages.pressed(&request).unwrap();
            let dent = stages.surface(&request).unwrap().1.clone();
            (pressed, peak, dent)
        };
        let water = Liquid::default();
        let (Pressed { size, force, depression, light: _ }, peak, whole) = pressed(1.0, &water);
        let full = depression.unwrap();
        assert_eq!(size, scene.plane.size);
        let weight = whole.volume * water.density() * water.gravity;
        assert!((weight / whole.force - 1.0).abs() < 1e-12, "{weight} {}", whole.force);
        assert!(force > 0.3 * whole.force && force < 1.2 * whole.force, "{force} of {}", whole.force);
        assert!(
            full.volume > 0.3 * whole.volume && full.volume < whole.volume,
            "{full:?} of {}",
            whole.volume
        );
        assert!(peak < full.deepest * (1.0 + 1e-6) && peak > 0.97 * full.deepest, "{peak} {full:?}");
        let (of_sine, peak_of_sine, _) = pressed(0.375, &water);
        assert!((of_sine.force / force - 0.375).abs() < 1e-9);
        assert!((peak_of_sine / peak - 0.375).abs() < 1e-5);
        let of_sine = of_sine.depression.unwrap();
        assert!((of_sine.deepest / full.deepest - 0.375).abs() < 1e-12);
        assert!((of_sine.slope / full.slope - 0.375).abs() < 1e-12);
        assert!((of_sine.volume / full.volume - 0.375).abs() < 1e-12);
        let (of_oil, ..) = pressed(1.0, &Liquid { surface_tension: Some(0.033), ..water });
        assert!(of_oil.depression.unwrap().deepest > 1.2 * full.deepest, "less tension, deeper depression");
    }
}

#[test]
fn the_surface_of_a_map_is_the_maps_own() {
    let (scene, drives) = three_foci();
    let request = Request::new(&scene, drives, Quantity::Depression, (64, 50));
    for (evaluator, tolerance, by) in [
        (Evaluator::Reference, 1e-3, By::Reference),
        (Evaluator::Cpu, 1e-3, By::Cpu),
        (Evaluator::Cpu, 1e-7, By::CpuInF64),
    ] {
        let plane = Plane { tolerance, ..scene.plane.clone() };
        let request = Request { plane, ..request.clone() };
        let mut stages = Stages::new(evaluator);
        assert_eq!(stages.map(&request).unwrap().by, by);
        let before = stages.work();
        stages.surface(&request).unwrap();
        assert_eq!(stages.work().since(before), Work::default(), "{by:?}: formed again, in other digits");
    }
}

/// On a plane whose sound is formed at cells, and on one near the array, where it is formed at pixels.
#[test]
fn radiation_pressure_and_its_force_follow_the_envelope() {
    let (scene, mut drives) = three_foci();
    drives.truncate(1);
    for z in [0.1, 0.008] {
        let plane = Plane { centre: dvec3(0.003, 0.002, z), ..scene.plane.clone() };
        let request =
            Request { plane, ..Request::new(&scene, drives.clone(), Quantity::Radiation, (64, 50)) };
        for evaluator in evaluators() {
            let mut stages = Stages::new(evaluator);
            let mut pressed = |part: f64| {
                let request = Request { part, ..request.clone() };
                let map = stages.map(&request).unwrap();
                let sum: f64 = map.values.iter().map(|&value| f64::from(value)).sum();
                let pixel = request.plane.size.x * request.plane.size.y / map.values.len() as f64;
                let peak = map.peak;
                let pressed = stages.pressed(&request).unwrap();
                assert!(pressed.depression.is_none());
                let of_peak = f64::from(peak) * request.plane.size.x * request.plane.size.y;
                assert!(
                    (pressed.force - sum * pixel).abs() < 1e-3 * of_peak,
                    "{} {}",
                    pressed.force,
                    sum * pixel
                );
                (f64::from(peak), pressed.force)
            };
            let (full, of_sine) = (pressed(1.0), pressed(0.375));
            assert!((of_sine.0 / full.0 - 0.375).abs() < 1e-5, "{z}: {full:?} {of_sine:?}");
            assert!((of_sine.1 / full.1 - 0.375).abs() < 1e-5, "{z}: {full:?} {of_sine:?}");
        }
    }
}

/// Pressure beside a plane moves the surface within it. The tank's walls are far enough away not to show at the finest
/// tolerance, however small the plane.
#[test]
fn a_depression_does_not_depend_on_the_size_of_the_plane() {
    let (mut scene, _) = three_foci();
    // A capillary length of 7 mm: then the walls, not the interpolation window, limit the cells.
    scene.liquid.surface_tension = Some(0.5);
    scene.plane.tolerance = 1e-6;
    let beside = DVec3::new(8.0 * scene.liquid.capillary_length(), 0.0, 0.1);
    scene.targets = vec![Target::new(Shape::Point { at: beside })];
    let drives = vec![solver::solve(&scene).unwrap().drive];
    let mut stages = Stages::new(Evaluator::Reference);
    let mut depth = |size: DVec2, pixels: (usize, usize)| {
        let plane = Plane { size, ..scene.plane.clone() };
        let request = Request::new(&scene, drives.clone(), Quantity::Depression, pixels);
        stages.map(&Request { plane, ..request }).unwrap().values.clone()
    };
    let near = depth(DVec2::new(0.01, 0.01), (10, 10));
    let wide = depth(DVec2::new(0.15, 0.03), (150, 30));
    let within: Vec<_> = (0..100).map(|i| f64::from(wide[(i / 10 + 10) * 150 + i % 10 + 70])).collect();
    let error = largest_difference(&near, &within);
    assert!(error < 1e-4, "{error}");
}

#[test]
fn planes_without_a_surface_give_an_error() {
    let (scene, drives) = three_foci();
    let mut stages = Stages::new(Evaluator::Cpu);
    let mut error = |plane: Plane, quantity: Quantity, liquid: Liquid| {
        let request = Request { plane, liquid, ..Request::new(&scene, drives.clone(), quantity, (20, 20)) };
        let error = stages.map(&request).err();
        assert_eq!(stages.pressed(&request).err(), error);
        if quantity.declaration().of_liquid {
            assert_eq!(stages.surface(&request).err(), error);
        }
        error
    };
    let water = Liquid::default;
    let upright = Plane { y_axis: DVec3::Z, ..scene.plane.clone() };
    let low = Plane { centre: dvec3(0.0, 0.0, 0.008), ..scene.plane.clone() };
    let heavy = Liquid { gravity: 1e-3, surface_tension: Some(10.0), ..Liquid::default() };
    assert_eq!(error(upright.clone(), Quantity::Depression, water()), Some(FieldError::NotLevel));
    assert_eq!(error(low.clone(), Quantity::Depression, water()), Some(FieldError::TooNear));
    assert_eq!(error(scene.plane.clone(), Quantity::Depression, heavy), Some(FieldError::TooManyCells));
    for quantity in Quantity::ALL.into_iter().filter(|quantity| !quantity.declaration().is_pressed()) {
        assert_eq!(error(upright.clone(), quantity, water()), None, "{quantity:?} on an upright plane");
        assert_eq!(error(low.clone(), quantity, water()), None, "{quantity:?} near the array");
    }
    let turned = Plane { x_axis: dvec3(1.0, 2.0, 0.0), y_axis: dvec3(2.0, -1.0, 0.0), ..scene.plane.clone() };
    assert_eq!(error(turned, Quantity::Depression, water()), None, "the axes of a level plane may be turned");
}

#[test]
fn a_given_surface_is_drawn_like_a_depression() {
    let (scene, drives) = three_foci();
    let request = Request::new(&scene, drives, Quantity::Depression, (60, 50));
    for evaluator in fast_evaluators() {
        let mut stages = Stages::new(evaluator);
        // At rest, under steady sound, whatever the envelope.
        let surface = |stages: &mut Stages, part: f64| {
            let (tank, dent) = stages.surface(&Request { part, ..request.clone() }).unwrap();
            assert_eq!(dent.depth.len(), tank.count());
            dent.clone()
        };
        let dent = surface(&mut stages, 1.0);
        assert_eq!(surface(&mut stages, 0.25), dent);
        let at_rest = stages.pressed(&request).unwrap().depression.unwrap();
        let expected: Vec<_> = stages.map(&request).unwrap().values.iter().map(|&h| f64::from(h)).collect();
        let Dent { depth, .. } = dent;
        for factor in [1.0, 2.0] {
            let depth = Some(depth.iter().map(|depth| factor * depth).collect());
            // A given surface is not scaled by the envelope.
            let request = Request { depth, part: 0.25, ..request.clone() };
            let map = stages.map(&request).unwrap();
            let shown: Vec<_> = map.values.iter().map(|depth| depth / factor as f32).collect();
            let error = largest_difference(&shown, &expected);
            assert!(error < 1e-4, "{factor} times: {error}");
            let figures = stages.pressed(&request).unwrap().depression.unwrap();
            assert!(
                (figures.deepest / at_rest.deepest / factor - 1.0).abs() < 1e-9,
                "{figures:?} {at_rest:?}"
            );
            assert!((figures.slope / at_rest.slope / factor - 1.0).abs() < 1e-9, "{figures:?} {at_rest:?}");
        }
    }
}
