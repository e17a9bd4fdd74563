//! Maps by plan: the tolerance is kept, whatever the scene, and what need not be evaluated is not.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Plan, Samples, map, reference};
use sonoglyph::scene::{ElementModel, Plane, Scene, file};
use sonoglyph::solver;

fn hit() -> (Scene, Drive) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes/hit.toml");
    let scene = file::read(path.as_ref()).unwrap();
    let drive = solver::solve(&scene).unwrap().drive;
    (scene, drive)
}

/// The largest deviation at every `stride`-th pixel, relative to the map's peak.
fn error(plan: &Plan, aperture: &Aperture, drive: &Drive, field: &[Complex32], stride: usize) -> f64 {
    let pixels = plan.pixels();
    let chosen: Vec<_> = (0..pixels.len()).step_by(stride).collect();
    let points = Samples::at(chosen.iter().map(|&pixel| pixels.point(pixel)).collect());
    let expected = reference::pressure(aperture, drive, &points);
    let off = |(&pixel, expected): (&usize, &Complex64)| {
        let got = field[pixel];
        (Complex64::new(got.re.into(), got.im.into()) - expected).norm()
    };
    chosen.iter().zip(&expected).map(off).fold(0.0, f64::max) / f64::from(sonoglyph::field::peak(field))
}

#[test]
fn a_looser_tolerance_evaluates_less_and_is_kept() {
    let (scene, drive) = hit();
    let aperture = Aperture::new(&scene);
    let mut before = usize::MAX;
    for tolerance in [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
        let plan = Plan::new(&aperture, &scene.plane, (500, 300), tolerance).unwrap();
        assert!(plan.evaluated() < before, "{tolerance:e}: {}", plan.reason);
        before = plan.evaluated();
        let map::Map { plan, field, error: measured, .. } = map::by_cpu(plan, &aperture, &drive, tolerance);
        let error = error(&plan, &aperture, &drive, &field, 37);
        assert!(measured < 2.0 * error && error < 10.0 * measured, "{error:e} was measured as {measured:e}");
        assert!(
            error < if tolerance == 0.0 { 2e-5 } else { tolerance },
            "{tolerance:e}: {error:e}, {}",
            plan.reason
        );
    }
    assert!(before * 20 < 500 * 300, "{before} points");
}

#[test]
fn the_gpu_follows_the_same_plan() {
    let Ok(gpu) = adapter::open_best(true) else {
        let required = std::env::var("SONOGLYPH_REQUIRE").unwrap_or_default();
        assert!(!required.split(',').any(|what| what == "gpu"), "a GPU is required");
        eprintln!("NOT TESTED ON THE GPU");
        return;
    };
    let (mut scene, drive) = hit();
    let tilted = Plane { y_axis: DVec3::new(0.0, 1.0, 1.0), ..Plane::default() };
    let through = Plane { y_axis: DVec3::Z, centre: DVec3::new(0.0, 0.0, 0.05), ..Plane::default() };
    for plane in [Plane::default(), tilted, through] {
        scene.plane = plane;
        let aperture = Aperture::new(&scene);
        for tolerance in [0.0, 1e-4] {
            let plan = Plan::new(&aperture, &scene.plane, (301, 203), tolerance).unwrap();
            let on_gpu = map::by_gpu(&gpu, &plan, &aperture, &drive, tolerance).unwrap().unwrap();
            let map::Map { plan, field: on_cpu, peak, .. } = map::by_cpu(plan, &aperture, &drive, tolerance);
            let on_gpu = on_gpu.field;
            let read = on_gpu.read().unwrap();
            for (a, b) in on_cpu.iter().zip(&read) {
                assert!((a - b).norm() < 2e-5 * peak, "{tolerance:e}: {}", plan.reason);
            }
            assert_eq!(
                on_gpu.at(&[0, 301 * 203 - 1, 301 * 100]).unwrap(),
                [read[0], read[301 * 203 - 1], read[30_100]]
            );
        }
    }
}

#[test]
fn rows_near_the_array_and_small_maps_are_evaluated_pixel_by_pixel() {
    let scene = Scene::default();
    let aperture = Aperture::new(&scene);
    let through = Plane { y_axis: DVec3::Z, centre: DVec3::new(0.0, 0.0, 0.05), ..Plane::default() };
    let plan = Plan::new(&aperture, &through, (400, 400), 1e-3).unwrap();
    assert!(plan.interpolated.start > 100 && plan.interpolated.end == 400, "{}", plan.reason);
    let lowest = plan.grid.as_ref().unwrap().samples.point(0).z;
    assert!(lowest > aperture.wavelength(), "{lowest}");
    let small = Plan::new(&aperture, &Plane::default(), (20, 20), 1e-3).unwrap();
    assert_eq!((small.grid.is_none(), small.evaluated()), (true, 400), "{}", small.reason);
    let one = Plan::new(&aperture, &Plane::default(), (1, 1), 1e-3).unwrap();
    assert_eq!(one.evaluated(), 1);
    let inside = Plane { centre: DVec3::ZERO, ..Plane::default() };
    assert!(Plan::new(&aperture, &inside, (400, 400), 1e-3).unwrap().grid.is_none());
}

#[test]
fn where_the_elements_cancel_samples_are_evaluated_in_f64() {
    let mut scene = Scene::default();
    scene.array.pitch = 0.004;
    scene.array.element_radius = 0.0018;
    scene.plane = Plane { centre: DVec3::new(0.0, 0.0, 0.3), ..Plane::default() };
    let aperture = Aperture::new(&scene);
    // Neighbours less than half a wavelength apart and in opposite phase: next to nothing leaves the array, and f32
    // rounds what cancels.
    let phase = |n: usize| TAU / 2.0 * ((n / 16 + n) % 2) as f64;
    let drive = Drive { amplitudes: vec![1.0; 256], phases: (0..256).map(phase).collect() };
    let tolerance = 1.2e-5;
    let plan = Plan::new(&aperture, &scene.plane, (200, 200), tolerance).unwrap();
    assert!(!plan.double);
    let map::Map { plan, field, .. } = map::by_cpu(plan, &aperture, &drive, tolerance);
    assert!(plan.double);
    assert!(error(&plan, &aperture, &drive, &field, 17) < tolerance);
}

fn planes() -> impl Strategy<Value = Plane> {
    let number = -1.0..1.0f64;
    let vector = || (number.clone(), number.clone(), number.clone()).prop_map(DVec3::from);
    let parallel = (number.clone(), number.clone(), 0.02..0.4f64, 0.02..0.3f64, 0.02..0.3f64).prop_map(
        |(x, y, z, w, h)| Plane {
            centre: DVec3::new(0.1 * x, 0.1 * y, z),
            size: DVec2::new(w, h),
            ..Plane::default()
        },
    );
    let free = (vector(), 0.05..0.4f64, vector(), vector(), 0.02..0.3f64).prop_map(
        |(c, z, x_axis, y_axis, size)| Plane {
            centre: DVec3::new(0.1 * c.x, 0.1 * c.y, z),
            x_axis,
            y_axis,
            size: DVec2::splat(size),
            ..Plane::default()
        },
    );
    let vertical = (parallel.clone()).prop_map(|plane| Plane { y_axis: DVec3::Z, ..plane });
    prop_oneof![parallel, free.prop_filter("axes span a plane", |plane| plane.axes().is_some()), vertical]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: RngSeed::Fixed(9), ..ProptestConfig::default() })]

    #[test]
    fn the_tolerance_is_kept_on_random_scenes(
        (rows, columns) in (1u32..20, 1u32..20),
        frequency in 25e3..100e3f64,
        pitch in 0.004..0.012f64,
        plane in planes(),
        (width, height) in (60usize..260, 60usize..260),
        exponent in -5.0..-1.5f64,
        focus in any::<bool>(),
        seed in 0.0..1.0f64,
    ) {
        let tolerance = 10f64.powf(exponent);
        let mut scene = Scene { plane, ..Scene::default() };
        scene.array.rows = rows;
        scene.array.columns = columns;
        scene.array.pitch = pitch;
        scene.array.element_radius = 0.45 * pitch;
        scene.array.frequency = frequency;
        scene.array.element = if seed < 0.2 { ElementModel::Point } else { ElementModel::Piston };
        let aperture = Aperture::new(&scene);
        let elements = scene.array.elements();
        // A focus somewhere on the plane, or phases without pattern.
        let target = scene.plane.centre + 0.1 * (seed - 0.5) * DVec3::X;
        let phase = |n: usize| if focus {
            aperture.element.wavenumber * target.distance(aperture.positions[n].extend(0.0))
        } else {
            TAU * (seed + n as f64 * 0.754_877_666).fract()
        };
        let drive = Drive { amplitudes: vec![1.0; elements], phases: (0..elements).map(phase).collect() };
        let plan = Plan::new(&aperture, &scene.plane, (width, height), tolerance).unwrap();
        let map::Map { plan, field, .. } = map::by_cpu(plan, &aperture, &drive, tolerance);
        prop_assert_eq!(field.len(), width * height);
        let error = error(&plan, &aperture, &drive, &field, 211);
        prop_assert!(error < tolerance, "{:e} for {:e}: {}", error, tolerance, plan.reason);
    }
}
