//! The pipeline of small maps on the CPU: their memory, progress and probes, and how they are refined.

use std::f64::consts::{PI, SQRT_2};
use std::sync::Mutex;

use glam::{DVec2, DVec3, dvec3};

use super::*;
use crate::acoustics::Aperture;
use crate::field::stages::probes::{AtProbes, corners};
use crate::field::{Quantity, Samples, reference};
use crate::scene::{Array, Plane, Scene};

/// The scattered probes, and the corners.
const PROBES: usize = 48 + 4;

fn scene() -> Scene {
    let array = Array { columns: 4, rows: 4, ..Array::default() };
    let plane = Plane { centre: dvec3(0.004, -0.002, 0.1), size: DVec2::new(0.06, 0.05), ..Plane::default() };
    Scene { array, plane, ..Scene::default() }
}

fn drive() -> Drive {
    let phase = |n: usize| (n as f64 * 0.754_877_666).fract();
    Drive { amplitudes: vec![1.0; 16], phases: (0..16).map(phase).collect() }
}

fn request(scene: &Scene, quantity: Quantity, size: (usize, usize)) -> Request {
    Request::new(scene, vec![drive()], quantity, size)
}

#[test]
fn interpolated_maps_are_those_of_the_reference() {
    let level = scene();
    let mut upright = level.clone();
    (upright.plane.y_axis, upright.plane.centre.z) = (DVec3::Z, 0.03);
    for (scene, how) in [(level, "every pixel is interpolated"), (upright, "evaluated pixel by pixel")] {
        let size = (120, 100);
        let map = Stages::new(Evaluator::Cpu).map(&request(&scene, Quantity::Rms, size)).unwrap().clone();
        assert!(map.by == By::Cpu && map.how.ends_with(how), "{:?}: {}", map.by, map.how);
        assert!(map.evaluated < size.0 * size.1, "{}", map.how);
        let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
        let expected = reference::pressure(&Aperture::new(&scene), &drive(), &pixels);
        for (value, p) in map.values.iter().zip(expected) {
            let off = (f64::from(*value) - p.norm() / SQRT_2).abs() / f64::from(map.peak);
            assert!(off < scene.plane.tolerance, "{off:e}, {}", map.how);
        }
    }
}

#[test]
fn a_map_is_taken_in_the_memory_that_is_given_unless_it_is_there() {
    let request = request(&scene(), Quantity::Rms, (12, 10));
    let mut stages = Stages::new(Evaluator::Cpu);
    let memory = Vec::with_capacity(120);
    let at = memory.as_ptr();
    let taken = stages.take_map(&request, memory).unwrap();
    assert_eq!(taken.values.as_ptr(), at);
    let kept = stages.map(&request).unwrap().clone();
    assert_eq!(taken, kept);
    assert_eq!(stages.take_map(&request, vec![-1.0; 120]).unwrap(), kept);
}

#[test]
fn sound_that_cancels_is_summed_in_f64() {
    // Neighbours a quarter of a wavelength apart, in antiphase.
    let array = Array { columns: 8, rows: 8, pitch: 0.002, element_radius: 0.0009, ..Array::default() };
    let plane =
        Plane { centre: DVec3::Z * 0.3, size: DVec2::splat(0.05), tolerance: 0.0, ..Plane::default() };
    let scene = Scene { array, plane, ..Scene::default() };
    for (phase, by) in [(0.0, By::Cpu), (PI, By::CpuInF64)] {
        let phases = (0..64).map(|n| phase * f64::from((n / 8 + n) % 2)).collect();
        let drives = vec![Drive { amplitudes: vec![1.0; 64], phases }];
        let request = Request::new(&scene, drives, Quantity::Rms, (12, 10));
        let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
        assert!(map.by == by && map.error <= promised(0.0), "{phase}: {:?}, {:e}", map.by, map.error);
    }
}

#[test]
fn a_map_between_loud_places_is_evaluated_pixel_by_pixel_in_f32() {
    // Both halves of the array cancel in the middle, but not at the samples beside the narrow plane.
    let mut scene = scene();
    scene.plane.centre = DVec3::Z * 0.1;
    scene.plane.size = DVec2::new(0.0004, 0.06);
    let phases = (0..16).map(|n| PI * f64::from(n % 4 / 2)).collect();
    let drives = vec![Drive { amplitudes: vec![1.0; 16], phases }];
    let request = Request::new(&scene, drives, Quantity::Rms, (40, 200));
    let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
    assert!(map.how.contains("samples do not keep the tolerance"), "{}", map.how);
    assert!(map.by == By::Cpu && map.error <= scene.plane.tolerance, "{:?}, {:e}", map.by, map.error);
}

#[test]
fn cells_are_refined_only_after_errors_beyond_the_promised_one() {
    let request = request(&scene(), Quantity::Gorkov, (20, 20)).relevant().unwrap();
    let mut ground = Ground::default();
    let tolerance =
        |ground: &mut Ground| ground.job(&request, false, Costs::CPU).unwrap().key.setting.plane.tolerance;
    let coarse = tolerance(&mut ground);
    let promised = promised(request.plane.tolerance);
    assert!(!ground.refine(&request, false, Costs::CPU, 0.9 * promised));
    assert!(ground.refine(&request, false, Costs::CPU, 3.0 * promised));
    let finer = tolerance(&mut ground);
    assert!(finer < coarse / 3.0, "{finer:e}, {coarse:e}");
}

#[test]
fn progress_runs_from_the_beginning_to_the_end_whatever_the_stages() {
    for (exact, quantity, least) in
        [(false, Quantity::Rms, 2), (false, Quantity::Gorkov, 2), (true, Quantity::Rms, 4)]
    {
        let evaluator = if exact { Evaluator::Reference } else { Evaluator::Cpu };
        let mut stages = Stages::new(evaluator);
        let told = Arc::new(Mutex::new(Vec::new()));
        let hear = Arc::clone(&told);
        stages.show_progress(Gauge::new(move |part| hear.lock().unwrap().push(part)));
        stages.map(&Request::new(&scene(), vec![drive(), drive()], quantity, (12, 10))).unwrap();
        let told = told.lock().unwrap();
        assert!(told.len() >= least, "{quantity:?}: {told:?}");
        assert_eq!((told.first(), told.last()), (Some(&0.0), Some(&1.0)), "{quantity:?}: {told:?}");
    }
}

#[test]
fn corners_are_probed_and_more_pixels_only_next_to_elements() {
    assert_eq!(corners((5, 4)), [0, 4, 15, 19]);
    let mut scene = scene();
    for (height, is_near) in [(0.01, true), (0.1, false)] {
        scene.plane.centre.z = height;
        let request = request(&scene, Quantity::Rms, (41, 37)).relevant().unwrap();
        let mut ground = Ground::default();
        let places = &ground.job(&request, false, Costs::CPU).unwrap().probes.places;
        assert!(corners((41, 37)).iter().all(|corner| places.contains(corner)), "{places:?}");
        assert_eq!(places.len() > PROBES, is_near, "{height}: {}", places.len());
    }
}

#[test]
fn errors_of_differences_count_in_full_where_the_sound_is_loudest() {
    for quantity in [Quantity::Gorkov, Quantity::Radiation] {
        let request = request(&scene(), quantity, (20, 20)).relevant().unwrap();
        let exact = Stages::new(Evaluator::Reference).map(&request).unwrap().clone();
        let mut ground = Ground::default();
        let job = ground.job(&request, false, Costs::CPU).unwrap();
        let values: Vec<_> = job.probes.places.iter().map(|&place| exact.values[place]).collect();
        let error = |values: Vec<f32>| {
            let at_probes = AtProbes { values, ..AtProbes::default() };
            job.probes.error((job.request, job.excitations), &at_probes, exact.peak)
        };
        assert!(error(values.clone()) < 1e-5);
        let off = |probe: usize| {
            let mut values = values.clone();
            values[probe] += 0.01 * exact.peak;
            error(values)
        };
        let errors: Vec<_> = (0..values.len()).map(off).collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let most = errors.iter().copied().fold(0.0, f64::max);
        // Three times the deviation; at most ten times that where the sound is faint.
        assert!((least - 0.03).abs() < 1e-4 && most > 0.05 && most < 0.3001, "{quantity:?}: {least}, {most}");
    }
}

#[test]
fn the_peak_of_phases_and_moments_is_the_largest_pressure_also_in_f64() {
    let (scene, size) = (scene(), (12, 10));
    let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
    let field = reference::pressure(&Aperture::new(&scene), &drive(), &pixels);
    let loudest = field.iter().map(|p| p.norm()).fold(0.0, f64::max);
    for quantity in [Quantity::Phase, Quantity::Instantaneous] {
        let mut stages = Stages::new(Evaluator::Reference);
        let map = stages.map(&request(&scene, quantity, size)).unwrap();
        assert_eq!(map.by, By::Reference);
        assert!((f64::from(map.peak) / loudest - 1.0).abs() < 1e-5, "{quantity:?}: {}", map.peak);
    }
}
