//! Averages, radiation pressure and dents against f64 from the field to the surface, and what changes nothing makes nothing run.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod requirement;

use glam::{DVec2, DVec3, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::{Air, Aperture};
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{
    Average, By, Colouring, Evaluator, FieldError, Mean, Quantity, Samples, Stages, Work, reference,
};
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Liquid, Plane, Scene, Shape, Target};
use sonoglyph::solver;
use sonoglyph::surface::{Reflector, Tank};

fn evaluators() -> Vec<Evaluator> {
    let mut evaluators = vec![Evaluator::Cpu, Evaluator::Reference];
    let gpu = requirement::found("gpu", adapter::open_best(true));
    evaluators.extend(gpu.map(|gpu| Evaluator::Gpu(Box::new(gpu))));
    evaluators
}

/// All but the reference.
fn fast_evaluators() -> impl Iterator<Item = Evaluator> {
    evaluators().into_iter().filter(|evaluator| !matches!(evaluator, Evaluator::Reference))
}

/// Three foci, one after the other, over a small plane.
fn scene() -> (Scene, Vec<Drive>) {
    let plane = Plane { size: DVec2::new(0.06, 0.05), ..Plane::default() };
    let scene = Scene { plane, ..Scene::default() };
    let drive = |at: DVec3| {
        let targets = vec![Target::new(Shape::Point { at })];
        solver::solve(&Scene { targets, ..scene.clone() }).unwrap().drive
    };
    let drives = [dvec3(0.01, 0.004, 0.1), dvec3(-0.012, 0.0, 0.1), dvec3(0.02, -0.03, 0.11)].map(drive);
    (scene, drives.to_vec())
}

fn reflector(scene: &Scene) -> Reflector {
    Reflector::new(&Air::new(&scene.medium, scene.array.frequency), scene.array.frequency)
}

/// Pixels of the maps, each as large as a cell of the exact solution, and the cells beyond the plane.
const SIZE: [usize; 2] = [120, 100];
const BEYOND: usize = 80;
const STEP: f64 = 0.0005;

/// Mean |P|², radiation pressure and depth at every pixel, each in f64 with cells half as wide as a plan's or less.
fn exact(scene: &Scene, drives: &[Drive]) -> [Vec<f64>; 3] {
    /// Slopes by differences of six neighbours: 1e-5 off here.
    const DIFFERENCE: [f64; 3] = [0.75, -0.15, 1.0 / 60.0];
    let aperture = Aperture::new(scene);
    let counts = SIZE.map(|count| count + 2 * BEYOND);
    let wide = counts.map(|count| count + 6);
    let size = DVec2::from(wide.map(|count| count as f64 * STEP));
    let samples = Samples::on_plane(&Plane { size, ..scene.plane.clone() }, wide[0], wide[1]).unwrap();
    let mut squares = vec![[0.0; 2]; counts[0] * counts[1]];
    for drive in drives {
        let pressure = reference::pressure(&aperture, drive, &samples);
        for (cell, square) in squares.iter_mut().enumerate() {
            let at = (cell / counts[0] + 3) * wide[0] + cell % counts[0] + 3;
            let slope = |stride: usize| -> Complex64 {
                let pair = |i: usize| pressure[at + (i + 1) * stride] - pressure[at - (i + 1) * stride];
                (0..3).map(|i| pair(i) * DIFFERENCE[i]).sum::<Complex64>() / STEP
            };
            square[0] += pressure[at].norm_sqr() / drives.len() as f64;
            let radiation = reflector(scene).pressure(pressure[at], [slope(1), slope(wide[0])]);
            square[1] += radiation / drives.len() as f64;
        }
    }
    let pressed: Vec<_> = squares.iter().map(|[_, radiation]| *radiation).collect();
    let depth = Tank::new(counts, [STEP; 2]).dent(&scene.liquid, &pressed).depth;
    let of_pixel = |pixel: usize| (pixel / SIZE[0] + BEYOND) * counts[0] + pixel % SIZE[0] + BEYOND;
    let pixels = |value: &dyn Fn(usize) -> f64| (0..SIZE[0] * SIZE[1]).map(|i| value(of_pixel(i))).collect();
    [pixels(&|cell| squares[cell][0]), pixels(&|cell| pressed[cell]), pixels(&|cell| depth[cell])]
}

fn largest_error(got: &[f32], expected: &[f64]) -> f64 {
    let largest = expected.iter().copied().fold(0.0, f64::max);
    let off = |(got, expected): (&f32, &f64)| (f64::from(*got) - expected).abs();
    got.iter().zip(expected).map(off).fold(0.0, f64::max) / largest
}

#[test]
fn averages_keep_the_tolerance() {
    let (mut scene, drives) = scene();
    let [squares, radiation, depth] = exact(&scene, &drives);
    let rms: Vec<_> = squares.iter().map(|square| (square / 2.0).sqrt()).collect();
    let reflector = reflector(&scene);
    for evaluator in evaluators() {
        // Whoever does not keep the tolerance is replaced by the CPU in f64.
        let by = match &evaluator {
            Evaluator::Reference => By::Reference,
            Evaluator::Cpu => By::Cpu,
            Evaluator::Gpu(_) => By::Gpu,
        };
        let mut stages = Stages::new(evaluator);
        for tolerance in [1e-2, 1e-3, 1e-4] {
            scene.plane.tolerance = tolerance;
            let aperture = Aperture::new(&scene);
            for (mean, expected) in [
                (Mean::Square, &rms),
                (Mean::Radiation(reflector), &radiation),
                (Mean::Dent(reflector, scene.liquid.clone()), &depth),
            ] {
                let wanted = Average {
                    aperture: &aperture,
                    plane: &scene.plane,
                    drives: &drives,
                    mean,
                    part: 1.0,
                    width: SIZE[0],
                    height: SIZE[1],
                };
                let got = stages.read_average(&wanted).unwrap();
                let map = stages.average(&wanted).unwrap();
                assert_eq!(map.by, by);
                let error = largest_error(&got, expected);
                println!(
                    "{:?} {:?} {tolerance:e}: {error:.1e}, measured {:.1e}",
                    map.by, wanted.mean, map.error
                );
                assert!(error < tolerance, "{:?} {:?}: {error}", map.by, wanted.mean);
                assert!(map.error < tolerance && error < 20.0 * map.error + 1e-5, "{error} {}", map.error);
                let largest = got.iter().copied().fold(0.0, f32::max);
                assert!((map.largest - largest).abs() <= 1e-6 * largest);
            }
        }
    }
}

#[test]
fn a_dent_displaces_what_the_force_weighs_and_follows_the_envelope() {
    let (scene, drives) = scene();
    let aperture = Aperture::new(&scene);
    for evaluator in evaluators() {
        let mut stages = Stages::new(evaluator);
        let dent = |stages: &mut Stages, part: f64, liquid: &Liquid| {
            let wanted = Average {
                aperture: &aperture,
                plane: &scene.plane,
                drives: &drives[..1],
                mean: Mean::Dent(reflector(&scene), liquid.clone()),
                part,
                width: 64,
                height: 50,
            };
            let map = stages.average(&wanted).unwrap();
            (map.by, map.force, map.largest, map.dent.clone().unwrap())
        };
        let water = Liquid::default();
        let (by, force, largest, full) = dent(&mut stages, 1.0, &water);
        let rounding = if by == By::Gpu { 1e-5 } else { 1e-12 };
        let weight = full.volume * water.density() * water.gravity;
        assert!((weight / full.force - 1.0).abs() < rounding, "{by:?}: {weight} {}", full.force);
        assert!(force > 0.3 * full.force && force < 1.2 * full.force, "{force} of {}", full.force);
        assert!((f64::from(largest) / full.deepest - 1.0).abs() < 0.05);
        let (_, force_of_sine, _, of_sine) = dent(&mut stages, 0.375, &water);
        assert!((force_of_sine / force - 0.375).abs() < 1e-9);
        assert!((of_sine.deepest / full.deepest - 0.375).abs() < rounding);
        assert!((of_sine.slope / full.slope - 0.375).abs() < rounding);
        let mut radiation = |part: f64| {
            let wanted = Average {
                aperture: &aperture,
                plane: &scene.plane,
                drives: &drives[..1],
                mean: Mean::Radiation(reflector(&scene)),
                part,
                width: 64,
                height: 50,
            };
            let map = stages.average(&wanted).unwrap();
            assert_eq!(map.by, by);
            map.largest
        };
        let largest = [radiation(1.0), radiation(0.375)];
        assert!((largest[1] / largest[0] - 0.375).abs() < 1e-5, "{largest:?}");
        let (_, _, _, of_oil) = dent(&mut stages, 1.0, &Liquid { surface_tension: Some(0.033), ..water });
        assert!(of_oil.deepest > 1.2 * full.deepest, "less tension, deeper dent");
    }
}

/// What presses beside a plane moves the surface within it: the walls stand so far away that they are not noticed at the finest
/// tolerance, however little of the surface is looked at.
#[test]
fn a_dent_does_not_depend_on_how_much_of_the_surface_is_shown() {
    let (mut scene, _) = scene();
    // A capillary length of 7 mm, so that the walls and not the interpolation's window decide where the cells end.
    scene.liquid.surface_tension = Some(0.5);
    scene.plane.tolerance = 1e-6;
    let beside = DVec3::new(8.0 * scene.liquid.capillary_length(), 0.0, 0.1);
    scene.targets = vec![Target::new(Shape::Point { at: beside })];
    let drives = [solver::solve(&scene).unwrap().drive];
    let aperture = Aperture::new(&scene);
    let mut stages = Stages::new(Evaluator::Reference);
    let mut depth = |size: DVec2, [width, height]: [usize; 2]| {
        let plane = Plane { size, ..scene.plane.clone() };
        let mean = Mean::Dent(reflector(&scene), scene.liquid.clone());
        let wanted =
            Average { aperture: &aperture, plane: &plane, drives: &drives, mean, part: 1.0, width, height };
        stages.read_average(&wanted).unwrap()
    };
    let near = depth(DVec2::new(0.01, 0.01), [10, 10]);
    let wide = depth(DVec2::new(0.15, 0.03), [150, 30]);
    let within: Vec<_> = (0..100).map(|i| f64::from(wide[(i / 10 + 10) * 150 + i % 10 + 70])).collect();
    let error = largest_error(&near, &within);
    assert!(error < 1e-4, "{error}");
}

#[test]
fn what_has_no_average_says_why() {
    let (scene, drives) = scene();
    let aperture = Aperture::new(&scene);
    let dent = Mean::Dent(reflector(&scene), Liquid::default());
    let mut stages = Stages::new(Evaluator::Cpu);
    let mut error = |plane: Plane, mean: &Mean| {
        let wanted = Average {
            aperture: &aperture,
            plane: &plane,
            drives: &drives,
            mean: mean.clone(),
            part: 1.0,
            width: 20,
            height: 20,
        };
        stages.average(&wanted).err()
    };
    let upright = Plane { y_axis: DVec3::Z, ..scene.plane.clone() };
    assert_eq!(error(upright.clone(), &dent), Some(FieldError::NotLevel));
    assert_eq!(error(upright, &Mean::Radiation(reflector(&scene))), None, "any plane may reflect");
    let low = Plane { centre: dvec3(0.0, 0.0, 0.008), ..scene.plane.clone() };
    assert_eq!(error(low, &dent), Some(FieldError::TooNear));
    let heavy = Liquid { gravity: 1e-3, surface_tension: Some(10.0), ..Liquid::default() };
    let endless = Mean::Dent(reflector(&scene), heavy);
    assert_eq!(error(scene.plane.clone(), &endless), Some(FieldError::TooManyCells));
    let turned = Plane { x_axis: dvec3(1.0, 2.0, 0.0), y_axis: dvec3(2.0, -1.0, 0.0), ..scene.plane };
    assert_eq!(error(turned, &dent), None, "a liquid may be looked at from any side");
}

#[test]
fn contours_of_an_average_run_where_it_is_that_part_of_its_largest() {
    let (scene, drives) = scene();
    let aperture = Aperture::new(&scene);
    for evaluator in fast_evaluators() {
        let mut stages = Stages::new(evaluator);
        for mean in [
            Mean::Square,
            Mean::Radiation(reflector(&scene)),
            Mean::Dent(reflector(&scene), scene.liquid.clone()),
        ] {
            let wanted = Average {
                aperture: &aperture,
                plane: &scene.plane,
                drives: &drives,
                mean,
                part: 1.0,
                width: 60,
                height: 50,
            };
            let lines = stages.average_contours(&wanted, 0.4).unwrap().to_vec();
            assert!(!lines.is_empty(), "{:?}", wanted.mean);
            let values = stages.read_average(&wanted).unwrap();
            let largest = stages.average(&wanted).unwrap().largest;
            for [x, y] in lines.into_iter().flatten() {
                // Between the centres of four pixels.
                let (column, row) = ((x - 0.5).floor().clamp(0.0, 58.0), (y - 0.5).floor().clamp(0.0, 48.0));
                let (right, up) = (x - 0.5 - column, y - 0.5 - row);
                let first = row as usize * 60 + column as usize;
                let along = |at: usize| values[at] * (1.0 - right) + values[at + 1] * right;
                let value = along(first) * (1.0 - up) + along(first + 60) * up;
                assert!((value / largest - 0.4).abs() < 0.02, "{:?}: {value} of {largest}", wanted.mean);
            }
        }
    }
}

#[test]
fn a_shape_of_the_surface_is_shown_as_the_dent_is() {
    let (scene, drives) = scene();
    let aperture = Aperture::new(&scene);
    for evaluator in fast_evaluators() {
        let mut stages = Stages::new(evaluator);
        let wanted = Average {
            aperture: &aperture,
            plane: &scene.plane,
            drives: &drives,
            mean: Mean::Dent(reflector(&scene), scene.liquid.clone()),
            part: 1.0,
            width: 60,
            height: 50,
        };
        let dent = stages.average(&wanted).unwrap().dent.clone().unwrap();
        let expected: Vec<_> = stages.read_average(&wanted).unwrap().into_iter().map(f64::from).collect();
        let error = largest_error(&stages.read_shape(&wanted, &dent.depth).unwrap(), &expected);
        assert!(error < 1e-4, "{error}");
        let twice: Vec<_> = dent.depth.iter().map(|depth| 2.0 * depth).collect();
        let half: Vec<_> =
            stages.read_shape(&wanted, &twice).unwrap().into_iter().map(|depth| depth / 2.0).collect();
        let error = largest_error(&half, &expected);
        assert!(error < 1e-4, "another shape: {error}");
    }
}

/// Everything that an average is made from, and how it is shown.
#[derive(Clone)]
struct Shown {
    scene: Scene,
    drives: Vec<Drive>,
    part: f64,
    size: (usize, usize),
    colours: ColourMap,
    quantity: Quantity,
}

impl Shown {
    fn show(&self, stages: &mut Stages) -> Work {
        let before = stages.work();
        let aperture = Aperture::new(&self.scene);
        let reflector = reflector(&self.scene);
        let wanted = Average {
            aperture: &aperture,
            plane: &self.scene.plane,
            drives: &self.drives,
            mean: match self.quantity {
                Quantity::Dent => Mean::Dent(reflector, self.scene.liquid.clone()),
                Quantity::Radiation => Mean::Radiation(reflector),
                _ => Mean::Square,
            },
            part: self.part,
            width: self.size.0,
            height: self.size.1,
        };
        let colouring = Colouring::new(self.quantity, self.colours.table());
        assert_eq!(stages.average_colours(&wanted, &colouring).unwrap().len(), self.size.0 * self.size.1);
        stages.work().since(before)
    }
}

#[test]
fn only_what_depends_on_the_change_runs() {
    const PICTURE: Work = Work {
        plan: 0,
        transfer: 0,
        superposition: 0,
        interpolation: 0,
        squares: 0,
        dent: 0,
        picture: 1,
        contours: 0,
    };
    const PIXELS: Work = Work { interpolation: 1, ..PICTURE };
    const LIQUID: Work = Work { dent: 1, ..PIXELS };
    type Change = fn(&mut Shown);
    let changes: &[(&str, Change, Work)] = &[
        ("nothing", |_| (), Work::default()),
        ("colour map", |s| s.colours = ColourMap::Grey, PICTURE),
        ("size", |s| s.size = (77, 66), PIXELS),
        ("envelope", |s| s.part = 0.5, PIXELS),
        ("targets", |s| s.scene.targets.clear(), Work::default()),
        ("viscosity", |s| s.scene.liquid.viscosity = Some(1.0), LIQUID),
        ("a drive", |s| s.drives[0].phases[9] += 1.0, Work { superposition: 1, squares: 1, ..LIQUID }),
        (
            "plane",
            |s| s.scene.plane.centre.z = 0.11,
            Work { plan: 1, transfer: 1, superposition: 1, squares: 1, ..LIQUID },
        ),
        (
            "the mean square instead",
            |s| s.quantity = Quantity::MeanRms,
            Work { plan: 1, transfer: 1, superposition: 1, squares: 1, ..PIXELS },
        ),
    ];
    for evaluator in fast_evaluators() {
        let on_gpu = matches!(evaluator, Evaluator::Gpu(_));
        let mut stages = Stages::new(evaluator);
        let (scene, mut drives) = scene();
        drives.truncate(1);
        let mut shown = Shown {
            scene,
            drives,
            part: 1.0,
            size: (60, 50),
            colours: ColourMap::Viridis,
            quantity: Quantity::Dent,
        };
        shown.show(&mut stages);
        for (name, change, expected) in changes {
            change(&mut shown);
            let mut expected = *expected;
            if on_gpu {
                // It keeps no table, and a dent is less work than keeping it.
                expected.transfer = 0;
                expected.dent = u64::from(expected.interpolation > 0 && shown.quantity == Quantity::Dent);
            }
            assert_eq!(shown.show(&mut stages), expected, "{name}, on the GPU: {on_gpu}");
            assert_eq!(shown.show(&mut stages), Work::default(), "after {name}");
        }
    }
}
