//! Every tuning of work sizes gives the same maps.

use glam::{DVec2, DVec3, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::gpu::{MOST_GROUPS, Tuning};
use sonoglyph::field::sound::narrow;
use sonoglyph::field::{
    By, Colouring, Evaluator, Map, Quantity, Request, Samples, Sources, Stages, reference,
};
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{ElementModel, Plane, Scene};

use crate::texels::painted;
use crate::{STEP, evaluators, gpu, scattered};

/// Arrays for every GPU program, and a plane whose lowest rows are evaluated directly.
fn requests() -> Vec<(String, Request)> {
    let upright = Plane {
        y_axis: DVec3::Z,
        centre: dvec3(0.0, 0.002, 0.03),
        size: DVec2::new(0.06, 0.05),
        ..Plane::default()
    };
    let level = Plane { size: DVec2::new(0.06, 0.05), ..Plane::default() };
    let mut requests = Vec::new();
    for (side, element) in [
        (16, ElementModel::Piston),
        (16, ElementModel::ExactPiston),
        (33, ElementModel::Piston),
        (33, ElementModel::ExactPiston),
        (16, ElementModel::Rectangle),
        (33, ElementModel::Rectangle),
        (16, ElementModel::Measured),
        (33, ElementModel::Measured),
    ] {
        for (name, plane, quantities) in [
            ("upright", &upright, &[Quantity::Rms, Quantity::Instantaneous][..]),
            ("level", &level, &[Quantity::Rms, Quantity::Intensity, Quantity::Velocity][..]),
        ] {
            let mut scene = Scene { plane: plane.clone(), ..Scene::default() };
            (scene.array.rows, scene.array.columns, scene.array.element) = (side, side, element);
            scene.array.measured = evaluators::measured();
            for &quantity in quantities {
                let drives = vec![scattered(scene.array.elements(), STEP)];
                let request = Request { moment: 0.7, ..Request::new(&scene, drives, quantity, (66, 57)) };
                requests.push((format!("{quantity:?}, {side} x {side} {element:?}, {name}"), request));
            }
        }
    }
    requests
}

/// The largest difference of two maps, relative to the peak.
fn difference(values: &[f32], expected: &Map) -> f32 {
    assert_eq!(values.len(), expected.values.len());
    let off = values.iter().zip(&expected.values).map(|(value, expected)| (value - expected).abs());
    // `max` ignores NaN.
    off.map(|off| if off.is_nan() { f32::INFINITY } else { off }).fold(0.0, f32::max) / expected.peak
}

#[test]
fn every_tuning_gives_the_same_maps_and_pictures() {
    // Work divided much finer than any adapter needs.
    let starved = Tuning { most_rounds: 1 << 11, most_pairs: 1 << 17, ..Tuning::SOFTWARE };
    let requests = requests();
    let mut on_cpu = Stages::new(Evaluator::Cpu);
    let by_cpu: Vec<_> = requests.iter().map(|(_, request)| on_cpu.map(request).unwrap().clone()).collect();
    let mut first: Vec<(Map, Vec<[u8; 4]>)> = Vec::new();
    for tuning in [Tuning::SOFTWARE, Tuning::DISCRETE, starved] {
        let Some(gpu) = gpu() else { return };
        let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu.with_tuning(tuning))));
        for (number, ((name, request), by_cpu)) in requests.iter().zip(&by_cpu).enumerate() {
            let colouring = Colouring::new(request.quantity, ColourMap::Grey.table());
            let picture = painted(&mut stages, request, &colouring);
            let map = stages.map(request).unwrap();
            assert_eq!(map.by, By::Gpu, "{name}");
            // Both keep the tolerance.
            let off = difference(&map.values, by_cpu);
            assert!(off < 2.0 * request.plane.tolerance as f32, "{name}: {off:.1e} from the CPU, {tuning:?}");
            if first.len() == number {
                first.push((map.clone(), picture));
                continue;
            }
            let (same_map, same_picture) = &first[number];
            let off = difference(&map.values, same_map);
            assert!(off < 1e-5, "{name}: {off:.1e}, {tuning:?}");
            assert!((map.peak - same_map.peak).abs() <= 1e-5 * map.peak, "{name}, {tuning:?}");
            let other = |(a, b): (&[u8; 4], &[u8; 4])| a[0].abs_diff(b[0]) > 1;
            assert!(!picture.iter().zip(same_picture).any(other), "{name}, {tuning:?}");
        }
    }
}

#[test]
fn no_pass_has_more_workgroups_than_adapters_allow() {
    // With the smallest workgroups.
    let tuning = Tuning::DISCRETE;
    let mut scene =
        Scene { plane: Plane { size: DVec2::new(0.01, 0.1), ..Plane::default() }, ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (1, 1);
    let drive = scattered(1, STEP);
    // Samples in more workgroups than one dispatch allows.
    let Some(gpu) = gpu() else { return };
    let gpu = gpu.with_tuning(tuning);
    let aperture = Aperture::new(&scene);
    let rows = (MOST_GROUPS * tuning.samples_together()) as usize / 4096 + 1;
    let samples = Samples::on_plane(&scene.plane, 4096, rows).unwrap();
    let sources = Sources::of_faces(&aperture, &drive, &samples).unwrap();
    let field = gpu.pressure(&sources).unwrap();
    assert_eq!(field.len(), samples.len());
    let chosen = [0, samples.len() / 2, samples.len() - 1];
    let points = Samples::at(chosen.map(|index| samples.point(index)).to_vec());
    for (index, expected) in chosen.into_iter().zip(reference::pressure(&aperture, &drive, &points)) {
        let expected = narrow(expected);
        assert!((field[index] - expected).norm() < 1e-5 * expected.norm(), "{index}: {expected}");
    }
    // More rows of pixels than one dispatch allows.
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let request = Request::new(&scene, vec![drive], Quantity::Rms, (8, 70_000));
    let map = stages.map(&request).unwrap();
    assert!(map.by == By::Cpu && map.error < scene.plane.tolerance, "{:?}: {}", map.by, map.how);
}

#[test]
fn the_gpu_makes_maps_of_all_parts_of_the_sound() {
    let Some(gpu) = gpu() else { return };
    let plane = Plane { centre: dvec3(0.003, 0.001, 0.05), size: DVec2::new(0.05, 0.04), ..Plane::default() };
    let mut scene = Scene { plane, ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (4, 4);
    let request = Request::new(&scene, vec![scattered(16, STEP)], Quantity::Intensity, (110, 90));
    let exact = Stages::new(Evaluator::Reference).map(&request).unwrap().clone();
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let map = stages.map(&request).unwrap();
    assert!(map.by == By::Gpu && map.how.contains("every pixel is interpolated"), "{}", map.how);
    let off = difference(&map.values, &exact);
    assert!(off < scene.plane.tolerance as f32, "{off:.1e}");
}
