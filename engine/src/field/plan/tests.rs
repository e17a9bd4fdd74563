//! Estimates of rounding, walls, spatial frequencies and work, against plain formulas.

use glam::dvec3;

use super::*;
use crate::scene::{Array, Board, ElementModel, Scene};

fn array() -> Array {
    Array { rows: 3, columns: 5, ..Array::default() }
}

fn aperture(array: Array) -> Aperture {
    Aperture::new(&Scene { array, ..Scene::default() })
}

#[test]
fn interpolation_costs_as_much_as_its_values() {
    let usual = USUAL_PIXELS as usize;
    assert_eq!(Costs::CPU.for_values(usual), Costs::CPU);
    let four = Costs::CPU.for_values(4 * usual);
    assert!((four.tap - 4.0 * Costs::CPU.tap).abs() < 1e-12, "{four:?}");
    assert_eq!(Costs { tap: Costs::CPU.tap, ..four }, Costs::CPU);
}

#[test]
fn corners_are_half_a_size_from_the_centre() {
    let plane = Plane { centre: dvec3(0.01, 0.02, 0.1), size: DVec2::new(0.06, 0.04), ..Plane::default() };
    let half = dvec3(0.03, 0.02, 0.0);
    let (low, high) = corners(&plane).unwrap().bounds();
    assert!(low.distance(plane.centre - half) < 1e-12 && high.distance(plane.centre + half) < 1e-12);
}

#[test]
fn the_farthest_plane_and_the_finest_tolerance_of_f32_are_allowed() {
    let single = aperture(Array { rows: 1, columns: 1, ..Array::default() });
    let plane = Plane { size: DVec2::splat(0.01), tolerance: F32_ERROR, ..Plane::default() };
    assert!(!Plan::new(&single, &plane, Costs::CPU).unwrap().double);
    let finer = Plane { tolerance: 0.9 * F32_ERROR, ..plane.clone() };
    assert!(Plan::new(&single, &finer, Costs::CPU).unwrap().double);
    assert!(Plan::new(&single, &Plane { centre: dvec3(1e6, 0.0, 0.1), ..plane }, Costs::CPU).is_some());
}

#[test]
fn rounding_is_that_of_the_longest_path_beyond_its_height() {
    let aperture = aperture(array());
    for at in [dvec3(2.0, -1.0, 0.3), dvec3(-1.5, -2.5, 0.1), dvec3(-2.0, 3.0, 0.4), dvec3(0.4, 1.5, 2.0)] {
        let beside = |axis: usize| {
            aperture.positions.iter().map(|from| (at[axis] - from[axis]).abs()).fold(0.0, f64::max)
        };
        let across = beside(0).hypot(beside(1));
        let path = across.hypot(at.z);
        // Of the path, and of the point's position along it.
        let turns = (path - at.z + at.truncate().length() * across / path) / aperture.wavelength();
        let expected = 0.1 * F32_TURN_ERROR * (turns + 1.0);
        assert!(expected > 1.1 * F32_ERROR);
        let estimated = f32_error(&aperture, &Samples::at(vec![at]));
        assert!((estimated / expected - 1.0).abs() < 1e-9, "{at}: {estimated:e}, not {expected:e}");
    }
}

#[test]
fn a_wall_is_passed_by_planes_with_all_corners_behind_it() {
    let half = DVec2::new(0.1, 0.2);
    for (height, slopes, is_passed) in [
        (0.0, [0.0, 0.0], false),
        (-2.0 * NEAREST, [0.0, 0.0], true),
        (-0.01, [0.0, 0.1], false),
        (-0.01, [0.0, -0.1], false),
        (-0.01, [0.2, 0.0], false),
        (-0.05, [0.2, 0.1], true),
    ] {
        assert_eq!(Wall { height, slopes }.is_passed(half), is_passed, "{height}, {slopes:?}");
    }
}

#[test]
fn a_boards_lattice_is_followed_beside_another_that_is_tilted() {
    let tilted = Board { at: dvec3(0.1, 0.0, 0.0), normal: dvec3(0.0, -0.5, 1.0), ..Board::default() };
    let boards = vec![Board::default(), tilted];
    let aperture = Aperture::new(&Scene { array: array(), boards, ..Scene::default() });
    let plane = Plane { centre: DVec3::Z * 0.2, ..Plane::default() };
    let view = View::new(&aperture, &plane, Costs::CPU).unwrap();
    let shared = view.layout(6, true).unwrap().shared;
    // Both have their rows along the plane's; only the first has its columns along them, too.
    assert!(shared[0].iter().all(Option::is_some) && shared[1][0].is_some(), "{shared:?}");
    assert_eq!(shared[1][1], None);
}

#[test]
fn the_steepest_ray_is_widened_by_a_fresnel_zone_up_to_evanescent_sound() {
    const BETA: f64 = 8.0;
    let aperture = aperture(Array { element: ElementModel::ExactPiston, ..array() });
    let Radiator::Disk(radius) = aperture.element.radiator() else { unreachable!() };
    let (wavelength, margin) = (aperture.wavelength(), DVec2::new(0.01, 0.012));
    let highest = |plane: &Plane, axis: usize| {
        let view = View::new(&aperture, plane, Costs::CPU).unwrap();
        let half = view.half.y;
        view.highest_frequency(axis, &(-half..half), margin, BETA)
    };
    let most = |height: f64| 1f64.hypot(BETA * wavelength / (TAU * height));
    // From the far edge of the array to the far edge of the plane's samples.
    let expected = |longest: f64, height: f64| {
        let sine = longest / longest.hypot(height);
        (sine + BLUR * (BETA * wavelength / height).sqrt()).min(most(height))
    };
    let level = Plane { centre: dvec3(0.02, -0.03, 0.1), size: DVec2::new(0.1, 0.06), ..Plane::default() };
    let pitch = aperture.pitch;
    let along_x = 0.02 + 0.05 + margin.x + 2.0 * pitch + radius;
    let along_y = 0.03 + 0.03 + margin.y + pitch + radius;
    for (axis, longest) in [along_x, along_y].into_iter().enumerate() {
        assert!(expected(longest, 0.1) < most(0.1));
        let found = highest(&level, axis);
        assert!((found - expected(longest, 0.1)).abs() < 1e-12, "{axis}: {found}");
    }
    // The lowest row of an upright plane decides.
    let upright = Plane { y_axis: DVec3::Z, ..level.clone() };
    let lowest = 0.1 - 0.03 - margin.y;
    let found = highest(&upright, 0);
    assert!((found - expected(along_x, lowest)).abs() < 1e-12, "{found}");
    // An axis that rises from the array, however little, meets all directions.
    let tilted = Plane {
        x_axis: dvec3(1.0, 0.0, 0.1),
        centre: DVec3::Z * 0.3,
        size: DVec2::splat(0.01),
        ..level.clone()
    };
    let lowered = 0.3 - (0.005 + margin.x) * 0.1 / 1f64.hypot(0.1);
    let found = highest(&tilted, 0);
    assert!((found - most(lowered)).abs() < 1e-12, "{found}");
    let found = highest(&upright, 1);
    assert!((found - most(lowest)).abs() < 1e-12, "{found}");
}

#[test]
fn work_is_that_of_samples_from_all_elements_and_of_taps() {
    let aperture = aperture(array());
    for (sharing, pair) in [(true, Costs::CPU.shared_pair), (false, Costs::CPU.kept_pair)] {
        let view = View::new(&aperture, &Plane::default(), Costs::CPU).unwrap();
        let layout = view.layout(4, sharing).unwrap();
        let samples = view.grid(&layout).samples.len() as f64;
        assert!((view.samples(&layout) - samples).abs() < 0.5);
        let expected = samples * 15.0 * pair + Costs::CPU.tap * USUAL_PIXELS * 8.0;
        assert!((view.work(&layout) / expected - 1.0).abs() < 1e-9, "{sharing}");
    }
}
