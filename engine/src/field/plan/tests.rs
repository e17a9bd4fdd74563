//! Tests of plans: the finest tolerances, walls, and lattices of several boards.

use glam::dvec3;

use super::*;
use crate::scene::{Array, Board, Scene};

fn array() -> Array {
    Array { rows: 3, columns: 5, ..Array::default() }
}

fn aperture(array: Array) -> Aperture {
    Aperture::new(&Scene { array, ..Scene::default() })
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
