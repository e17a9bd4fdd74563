//! Maps by plan: how finely planes are sampled, and by which evaluator.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::plan::{Costs, Grid};
use sonoglyph::field::{By, Evaluator, Map, Plan, Quantity, Raster, Request, Samples, Stages, reference};
use sonoglyph::scene::{Board, ElementModel, Plane, Scene, file};
use sonoglyph::solver;

use crate::space::bowl;
use crate::{STEP, gpu, scattered};

fn hit() -> (Scene, Drive) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/scenes/hit.toml");
    let scene = file::read(path.as_ref()).unwrap();
    let drive = solver::solve(&scene).unwrap().drive;
    (scene, drive)
}

/// Stages on a GPU whose buffers are limited to this size.
fn on_gpu(buffer_bytes: u64) -> Option<Stages> {
    let gpu = gpu()?.with_small_buffers(buffer_bytes);
    Some(Stages::new(Evaluator::Gpu(Box::new(gpu))))
}

/// A map with the complex pressure at its pixels, and its largest deviation over every `stride`-th pixel, relative to
/// the peak.
fn made(
    stages: &mut Stages,
    scene: &Scene,
    drive: &Drive,
    (width, height): (usize, usize),
    stride: usize,
) -> (Map, Vec<Complex32>, f64) {
    // At ωt = 0 the map shows Re{P}, a quarter of a period earlier Im{P}.
    let at = |moment: f64| Request {
        moment,
        ..Request::new(scene, vec![drive.clone()], Quantity::Instantaneous, (width, height))
    };
    let mut map = stages.map(&at(0.0)).unwrap().clone();
    let imaginary = stages.map(&at(-FRAC_PI_2)).unwrap();
    // One error estimate for both parts.
    map.error = map.error.max(imaginary.error);
    let field: Vec<_> =
        map.values.iter().zip(&imaginary.values).map(|(&re, &im)| Complex32::new(re, im)).collect();
    assert_eq!(field.len(), width * height);
    let pixels = Samples::on_plane(&scene.plane, width, height).unwrap();
    let chosen: Vec<_> = (0..pixels.len()).step_by(stride).collect();
    let points = Samples::at(chosen.iter().map(|&pixel| pixels.point(pixel)).collect());
    let expected = reference::pressure(&Aperture::new(scene), drive, &points);
    let off = |(&pixel, expected): (&usize, &Complex64)| {
        let off = (Complex64::new(field[pixel].re.into(), field[pixel].im.into()) - expected).norm();
        // Of pixels next to elements relative to themselves.
        off / f64::from(map.peak.max(expected.norm() as f32))
    };
    let error = chosen.iter().zip(&expected).map(off).fold(0.0, f64::max);
    let peak = sonoglyph::field::peak(&field);
    assert!((map.loudest - peak).abs() <= 1e-5 * peak, "{} is not {peak}: {}", map.loudest, map.how);
    (map, field, error)
}

#[test]
fn a_looser_tolerance_needs_no_more_samples_and_holds() {
    let (mut scene, drive) = hit();
    let mut stages = Stages::new(Evaluator::Cpu);
    let mut before = usize::MAX;
    for tolerance in [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
        scene.plane.tolerance = tolerance;
        let (map, _, error) = made(&mut stages, &scene, &drive, (500, 300), 37);
        assert!(map.evaluated <= before, "{tolerance:e}: {}", map.how);
        before = map.evaluated;
        let measured = map.error;
        assert!(error <= measured && measured < 10.0 * error, "{error:e} was estimated as {measured:e}");
        let most = if tolerance == 0.0 { 2e-5 } else { tolerance };
        assert!(error < most, "{tolerance:e}: {error:e}, {}", map.how);
    }
    assert!(before * 10 < 500 * 300, "{before} points");
}

fn slanted_planes() -> [Plane; 7] {
    let d = DVec3::new;
    let parallel = Plane { centre: d(0.011, -0.007, 0.09), ..Plane::default() };
    [
        Plane { y_axis: d(0.0, 1.0, 1.0), ..Plane::default() },
        Plane { y_axis: DVec3::Z, centre: d(0.0, 0.0, 0.05), ..Plane::default() },
        Plane { x_axis: DVec3::Z, y_axis: DVec3::X, centre: d(0.0, 0.02, 0.17), ..Plane::default() },
        Plane { x_axis: -DVec3::X, ..parallel.clone() },
        Plane { x_axis: DVec3::Y, y_axis: -DVec3::X, ..parallel.clone() },
        Plane { x_axis: d(1.0, 0.3, 0.0), ..parallel.clone() },
        parallel,
    ]
}

#[test]
fn the_gpu_follows_the_same_plan() {
    let (mut scene, drive) = hit();
    let Some(mut on_gpu) = on_gpu(u64::MAX) else { return };
    let mut on_cpu = Stages::new(Evaluator::Cpu);
    for plane in slanted_planes() {
        for tolerance in [0.0, 1e-4] {
            scene.plane = Plane { tolerance, ..plane.clone() };
            let (map, by_gpu, error) = made(&mut on_gpu, &scene, &drive, (301, 203), 97);
            assert_eq!(map.by, By::Gpu);
            let peak = sonoglyph::field::peak(&by_gpu);
            assert!((map.peak - peak).abs() < 1e-5 * peak, "{} is not {peak}: {}", map.peak, map.how);
            assert!(error < if tolerance == 0.0 { 2e-5 } else { tolerance }, "{error:e}: {}", map.how);
            let (Map { peak, .. }, by_cpu, _) = made(&mut on_cpu, &scene, &drive, (301, 203), 9999);
            for (a, b) in by_cpu.iter().zip(&by_gpu) {
                assert!((a - b).norm() < 2e-5 * peak, "{tolerance:e}: {}", map.how);
            }
        }
    }
}

#[test]
fn maps_too_large_for_the_gpu_are_made_by_the_cpu() {
    let (mut scene, drive) = hit();
    // Room for the samples but not for the pixels, and for neither.
    for buffer_bytes in [200_000, 2000] {
        let Some(mut stages) = on_gpu(buffer_bytes) else { return };
        for plane in slanted_planes() {
            scene.plane = Plane { tolerance: 1e-3, ..plane };
            let (map, _, error) = made(&mut stages, &scene, &drive, (301, 203), 97);
            assert!(error < 1e-3, "{error:e}: {}", map.how);
            assert_eq!(map.by, By::Cpu, "{}", map.how);
        }
    }
}

#[test]
fn rows_near_the_array_and_small_maps_are_evaluated_pixel_by_pixel() {
    let scene = Scene::default();
    let aperture = Aperture::new(&scene);
    let planned = |plane: &Plane, size| {
        let plan = Plan::new(&aperture, plane, Costs::CPU).unwrap();
        let raster = Raster::new(&plan, size).unwrap();
        (plan, raster)
    };
    let through = Plane { y_axis: DVec3::Z, centre: DVec3::new(0.0, 0.0, 0.05), ..Plane::default() };
    let (plan, raster) = planned(&through, (400, 400));
    assert!(raster.interpolated.start > 100 && raster.interpolated.end == 400, "{}", raster.describe(&plan));
    let lowest = plan.grid.as_ref().unwrap().samples.point(0).z;
    assert!(lowest > aperture.wavelength(), "{lowest}");
    let (plan, raster) = planned(&Plane::default(), (20, 20));
    assert_eq!((raster.interpolated.len(), raster.evaluated(&plan)), (0, 400));
    let (plan, raster) = planned(&Plane::default(), (1, 1));
    assert_eq!(raster.evaluated(&plan), 1);
    let inside = Plane { centre: DVec3::ZERO, ..Plane::default() };
    assert!(planned(&inside, (400, 400)).0.grid.is_none());
}

#[test]
fn planes_near_the_array_are_sampled_finely_enough_at_once() {
    let (mut scene, _) = hit();
    let wavelength = Aperture::new(&scene).wavelength();
    let mut stages = Stages::new(Evaluator::Cpu);
    // Along the rows of elements samples are finer, since they are shared.
    (scene.plane.x_axis, scene.plane.y_axis) = (DVec3::new(1.0, 0.3, 0.0), DVec3::new(-0.3, 1.0, 0.0));
    for model in [ElementModel::Point, ElementModel::Piston] {
        scene.array.element = model;
        for wavelengths in [1.05, 1.3, 2.0, 4.0] {
            for tolerance in [1e-2, 1e-3, 1e-4] {
                scene.plane.centre.z = wavelengths * wavelength;
                scene.plane.tolerance = tolerance;
                let (map, _, error) = made(&mut stages, &scene, &scattered(256, STEP), (500, 400), 331);
                let what = format!("{model:?}, {wavelengths} wavelengths, {tolerance:e}: {}", map.how);
                println!("{what} {error:e}");
                assert!(map.by == By::Cpu && map.how.contains("every pixel is interpolated"), "{what}");
                assert!(error < tolerance, "{what}: {error:e}");
            }
        }
    }
}

#[test]
fn maps_just_above_elements_are_right_beside_them() {
    let (mut scene, drive) = hit();
    scene.array.element = ElementModel::Point;
    let element = Aperture::new(&scene).positions[100];
    for height in [1e-3, 3e-5, 1e-5] {
        let centre = element + DVec3::new(2e-5, 1e-5, height);
        scene.plane = Plane { centre, size: DVec2::splat(0.03), tolerance: 0.0, ..Plane::default() };
        let (map, _, error) = made(&mut Stages::new(Evaluator::Cpu), &scene, &drive, (81, 81), 1);
        println!("{height}: {error:e}, measured {:e}, {:?}", map.error, map.by);
        assert!(error < 2e-5, "{height} m above: {error:e}, measured {:e}, {:?}", map.error, map.by);
    }
}

#[test]
fn samples_are_evaluated_in_f64_if_the_elements_cancel() {
    let mut scene = Scene::default();
    scene.array.pitch = 0.004;
    scene.array.element_radius = 0.0018;
    let tolerance = 1.2e-5;
    scene.plane = Plane { centre: DVec3::new(0.0, 0.0, 0.3), tolerance, ..Plane::default() };
    // Neighbours less than λ/2 apart in antiphase radiate almost nothing, and cancellation amplifies the rounding of
    // f32.
    let phase = |n: usize| TAU / 2.0 * ((n / 16 + n) % 2) as f64;
    let drive = Drive { amplitudes: vec![1.0; 256], phases: (0..256).map(phase).collect() };
    let mut stages = Stages::new(Evaluator::Cpu);
    let (map, _, error) = made(&mut stages, &scene, &drive, (200, 200), 17);
    assert!(map.by == By::CpuInF64 && error < tolerance, "{error:e}");
    // For another drive f32 is enough.
    let (map, _, error) = made(&mut stages, &scene, &scattered(256, STEP), (200, 200), 17);
    assert!(map.by == By::Cpu && error < tolerance, "{error:e}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: RngSeed::Fixed(9), ..ProptestConfig::default() })]
}

#[test]
fn invalid_planes_have_no_plan() {
    const NAN: f64 = f64::NAN;
    let Scene { plane, .. } = Scene::default();
    let aperture = Aperture::new(&Scene::default());
    let planned = |plane: &Plane| Plan::new(&aperture, plane, Costs::CPU).is_some();
    assert!(planned(&plane));
    for centre in [DVec3::new(NAN, 0.0, 0.1), DVec3::new(0.0, f64::INFINITY, 0.1), DVec3::Z * 1.1e6] {
        assert!(!planned(&Plane { centre, ..plane.clone() }), "{centre}");
    }
    for size in [DVec2::new(NAN, 0.1), DVec2::new(0.1, f64::INFINITY), DVec2::X, DVec2::new(0.1, 1.1e6)] {
        assert!(!planned(&Plane { size, ..plane.clone() }), "{size}");
    }
    for tolerance in [NAN, -0.1, 1.1] {
        assert!(!planned(&Plane { tolerance, ..plane.clone() }), "{tolerance}");
    }
    let parallel = Plane { y_axis: plane.x_axis, ..plane };
    assert!(!planned(&parallel));
}

fn grid(scene: &Scene) -> Grid {
    Plan::new(&Aperture::new(scene), &scene.plane, Costs::CPU).unwrap().grid.unwrap()
}

/// Axes that no array's are parallel to.
fn askew() -> Plane {
    Plane { x_axis: DVec3::new(1.0, 0.3, 0.0), y_axis: DVec3::new(-0.3, 1.0, 0.0), ..Plane::default() }
}

#[test]
fn few_samples_suffice_far_away_and_more_before_wide_elements() {
    let highest = |scene: &Scene| grid(scene).highest * Aperture::new(scene).wavelength();
    // Rays from a flat board are steep nowhere on a small plane at a distance.
    let far = Plane { centre: DVec3::Z, size: DVec2::splat(0.05), ..askew() };
    let of_flat = highest(&Scene { plane: far.clone(), ..Scene::default() });
    assert!(of_flat.max_element() < 0.4, "{of_flat}");
    // A bowl is taken to send them from all sides.
    let of_bowl = highest(&Scene { plane: far, ..bowl(60).0 });
    assert!(of_bowl.min_element() >= 1.0, "{of_bowl}");
    // On the axis of a wide element, its directivity changes over the distance divided by its radius.
    let (radius, height) = (0.02, 0.012);
    let near = Plane { centre: DVec3::Z * height, tolerance: 1e-2, ..askew() };
    let mut scene = Scene { plane: near, ..Scene::default() };
    (scene.array.element_radius, scene.array.pitch) = (radius, 0.041);
    let of_wide = highest(&scene);
    assert!(of_wide.min_element() >= radius / height, "{of_wide}");
}

#[test]
fn boards_before_which_no_part_of_the_plane_lies_are_left_out() {
    let plane = Plane { centre: DVec3::Z * 0.03, size: DVec2::splat(0.05), ..Plane::default() };
    let [below, above] = [0.0, 0.06].map(|z| Board { at: DVec3::Z * z, ..Board::default() });
    let opposite = Board { normal: DVec3::NEG_Z, ..above.clone() };
    for (boards, expected) in [
        (vec![above.clone(), below.clone()], vec![1]),
        (vec![below.clone(), above], vec![0]),
        (vec![below, opposite], vec![0, 1]),
    ] {
        let grid = grid(&Scene { boards, plane: plane.clone(), ..Scene::default() });
        let heard: Vec<_> = grid.heard.iter().map(|(number, _)| *number).collect();
        assert_eq!(heard, expected);
    }
}
