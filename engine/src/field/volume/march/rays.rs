//! Tests of single rays: through bricks, to a surface, and through objects one behind the other.

use glam::DVec3;

use super::*;
use crate::field::volume::Lattice;

/// m, different along each axis.
const STEP: Vec3 = Vec3::new(1e-3, 2e-3, 5e-4);
const COUNTS: UVec3 = UVec3::new(17, 25, 97);
/// Pa/m, of a field that grows evenly, from 0 at the origin.
const GROWTH: Vec3 = Vec3::new(300.0, 500.0, 2000.0);

fn growing() -> Volume {
    let value = |i: u32| {
        let place = UVec3::new(i % COUNTS.x, i / COUNTS.x % COUNTS.y, i / COUNTS.x / COUNTS.y);
        GROWTH.dot(place.as_vec3() * STEP)
    };
    let lattice = Lattice { first: DVec3::ZERO, step: STEP.as_dvec3(), counts: COUNTS };
    Volume::of(lattice, (0..COUNTS.element_product()).map(value).collect())
}

/// A picture along z of a volume and of things in one tile, with a pixel per mm from the first point.
fn shot(volume: &Volume, things: Vec<Thing>) -> Shot {
    let params = ShotParams {
        aside: 1e-3,
        right: [1.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        forward: [0.0, 0.0, 1.0],
        eye: [0.0, 0.0, -0.1],
        width: 16.0,
        height: 16.0,
        tiles: 1,
        high: (STEP * (COUNTS - UVec3::ONE).as_vec3()).to_array(),
        per_metre: STEP.recip().to_array(),
        per_peak: 1.0 / volume.peak,
        bricks: volume.brick_counts().to_array(),
        counts: COUNTS.to_array(),
        surface: [0.4, 0.5, 0.3, 1.0],
        ..ShotParams::default()
    };
    let count = u32::try_from(things.len()).expect("a few");
    let tiles = [2, 2 + count].into_iter().chain(0..count).collect();
    Shot { params, body: Body::Hidden, things, tiles, size: (16, 16) }
}

const TABLE: [Vec3; 256] = [Vec3::ONE; 256];

fn painter<'a>(shot: &'a Shot, volume: &'a Volume) -> Painter<'a> {
    Painter { shot, params: &shot.params, volume, table: &TABLE }
}

/// Numbers in [-1, 1], without a pattern.
fn scattered(i: u32) -> f32 {
    (i as f32 * 0.618_034).fract() * 2.0 - 1.0
}

#[test]
fn a_ray_leaves_a_brick_through_its_face() {
    let volume = growing();
    let shot = shot(&volume, Vec::new());
    let painter = painter(&shot, &volume);
    let high = Vec3::from(shot.params.high);
    for i in 0..300 {
        let [a, b, c] = [1, 2, 5].map(|times| scattered(times * i + times));
        let ray =
            Ray { start: high * (0.5 + 0.45 * Vec3::new(c, a, b)), direction: Vec3::new(a, b, c + 1.1) };
        let grid = painter.in_steps(ray);
        let brick = |depth: f32| ((grid.start + grid.direction * depth) / BRICK as f32).floor();
        let (largest, exit) = painter.brick(&grid, 0.0);
        let nudge = 2.0 * NUDGE * grid.step;
        let own = brick(nudge);
        assert!(exit > 0.0, "{i}: {exit}");
        assert_eq!(brick(exit - nudge), own, "{i}: before {exit}");
        assert!(brick(exit + nudge) != own, "{i}: beyond {exit}");
        let bricks = volume.brick_counts();
        let cell = own.as_uvec3();
        let number = cell.x + bricks.x * (cell.y + bricks.y * cell.z);
        assert_eq!(largest, volume.bricks[number as usize], "{i}");
    }
}

#[test]
fn a_surface_is_met_where_the_field_reaches_its_level_and_faces_along_its_slope() {
    let volume = growing();
    let mut shot = shot(&volume, Vec::new());
    shot.params.level = 20.0;
    let painter = painter(&shot, &volume);
    let mut inner = 0;
    for i in 0..60 {
        let [a, b] = [1, 2].map(|times| scattered(times * i + times));
        let start = Vec3::new(8e-3 + 6e-3 * a, 0.02 + 0.015 * b, -0.01);
        let ray = Ray { start, direction: Vec3::new(0.1 * b, 0.1 * a, 1.0) };
        let (near, far) = painter.inside(ray).expect("it crosses the box");
        let expected = (20.0 - GROWTH.dot(ray.start)) / GROWTH.dot(ray.direction);
        let met = painter.surface(ray, near, far);
        if expected > far {
            assert_eq!(met, None, "{i}");
            continue;
        }
        let (depth, colour) = met.expect("the level is reached");
        if expected < near {
            assert!(depth == near && colour.truncate() == Vec3::ONE, "{i}: cut at {depth}");
            continue;
        }
        let step = painter.in_steps(ray).step;
        assert!((depth - expected).abs() < 0.03 * step, "{i}: {depth}, not {expected}");
        // Within a step of the outermost points, slopes are one-sided.
        let place = painter.place(ray.start + ray.direction * depth);
        let last = (COUNTS - UVec3::ONE).as_vec3();
        if place.min(last - place).min_element() > 1.0 {
            inner += 1;
            let lit = lit(&shot.params, GROWTH, ray.direction);
            assert!(colour.truncate().distance(lit) < 1e-3, "{i}: {colour}, not {lit}");
        }
    }
    assert!(inner > 10, "{inner}");
}

#[test]
fn rays_along_the_faces_of_bricks_meet_the_surface_too() {
    let volume = growing();
    let mut shot = shot(&volume, Vec::new());
    // Behind more steps than there are turns of the loop at the least advance.
    shot.params.level = 70.0;
    let painter = painter(&shot, &volume);
    for i in 0..40 {
        for slope in [0.0, 1e-9, 3e-8, 1e-6, 1e-5, 1e-4] {
            for sign in [1.0, -1.0] {
                let beside = (i as f32 - 20.0) * 4e-10;
                let start = Vec3::new(8e-3 + beside, 0.016, -1e-3);
                let ray = Ray { start, direction: Vec3::new(sign * slope, 0.0, 1.0) };
                let (near, far) = painter.inside(ray).expect("it crosses the box");
                let expected = (70.0 - GROWTH.dot(ray.start)) / GROWTH.dot(ray.direction);
                let met = painter.surface(ray, near, far).map(|(depth, _)| depth);
                let is_met = met.is_some_and(|depth| (depth - expected).abs() < 0.03 * STEP.z);
                assert!(is_met, "{beside} {slope} {sign}: {met:?}, not {expected}");
            }
        }
    }
}

#[test]
fn a_dot_shines_through_what_hides_it_and_not_through_what_does_not() {
    let volume = growing();
    let green = Vec4::new(0.0, 1.0, 0.0, 1.0);
    let dot = Thing {
        place: [8.0, 8.0, 0.2, DOT as f32],
        first: [5.0, 0.0, 0.0, 0.0],
        second: [0.25, 0.0, 0.0, 0.0],
        colour: green.to_array(),
    };
    for opacity in [0.0, 0.6, 1.0] {
        let panel = Thing {
            place: [0.0, 0.0, 0.05, PANEL as f32],
            first: [10.0, 0.0, 0.0, 0.0],
            second: [0.0, 10.0, 0.0, 0.0],
            colour: [1.0, 0.0, 0.0, opacity],
        };
        let shot = shot(&volume, vec![dot, panel]);
        let colour = painter(&shot, &volume).colour(Vec2::splat(8.0), 0);
        let part = if opacity == 1.0 { 0.25 } else { 1.0 - opacity };
        let expected = Vec3::new(1.0 - part, part, 0.0);
        assert!(colour.distance(expected) < 1e-6, "{opacity}: {colour}, not {expected}");
    }
}

#[test]
fn a_slice_in_a_face_of_the_box_is_seen() {
    let volume = growing();
    let shot = shot(&volume, Vec::new());
    let painter = painter(&shot, &volume);
    let high = Vec3::from(shot.params.high);
    for (z, is_seen) in [(0.0, true), (high.z, true), (high.z + 1e-3, false), (-1e-3, false)] {
        let slice = Thing {
            place: [high.x / 2.0, high.y / 2.0, z, SLICE as f32],
            first: [2.0 / high.x, 0.0, 0.0, 0.0],
            second: [0.0, 2.0 / high.y, 0.0, 1.0],
            ..Thing::default()
        };
        for i in 0..20 {
            let [a, b] = [1, 2].map(|times| 0.05 * scattered(times * i + times));
            let ray =
                Ray { start: Vec3::new(0.5 * high.x, 0.5 * high.y, -0.05), direction: Vec3::new(a, b, 1.0) };
            let met = painter.meet(&slice, Vec2::ZERO, ray);
            assert_eq!(met.is_some(), is_seen, "{z} m, {i}");
        }
    }
}

#[test]
fn a_tint_is_the_nearest_of_the_table() {
    let volume = growing();
    let shot = shot(&volume, Vec::new());
    let table = std::array::from_fn(|i| Vec3::splat(i as f32));
    let painter = Painter { shot: &shot, params: &shot.params, volume: &volume, table: &table };
    for i in 0..=1000 {
        let part = i as f32 / 1000.0;
        let tint = painter.tint(part).x;
        assert!((tint - 255.0 * part).abs() < 0.5 + 1e-3, "{part}: {tint}");
    }
    assert_eq!([-1.0, 2.0].map(|part| painter.tint(part).x), [0.0, 255.0]);
}

#[test]
fn a_dot_is_shaded_as_a_ball() {
    let volume = growing();
    let shot = shot(&volume, Vec::new());
    let painter = painter(&shot, &volume);
    let ray = Ray { start: Vec3::ZERO, direction: Vec3::Z };
    let radius = 5.0;
    let dot = Thing {
        place: [8.0, 8.0, 0.2, DOT as f32],
        first: [radius, 0.0, 0.0, 0.0],
        colour: [1.0, 0.5, 0.25, 1.0],
        ..Thing::default()
    };
    for off in [0.0, 1.5, 3.0, 4.0, 4.9, 5.2] {
        let (_, colour) = painter.meet(&dot, Vec2::new(8.0 + off, 8.0), ray).expect("it covers the pixel");
        // The part of the ball's normal that faces the eye.
        let facing = (1.0 - (off / radius).min(1.0).powi(2)).sqrt();
        let expected = Vec3::new(1.0, 0.5, 0.25) * (0.62 + 0.38 * facing);
        assert!(colour.truncate().distance(expected) < 1e-5, "{off}: {colour}, not {expected}");
    }
}

#[test]
fn the_rim_of_a_disc_covers_pixels_in_part_at_any_distance() {
    let volume = growing();
    let mut shot = shot(&volume, Vec::new());
    shot.params.spread = 2e-3;
    let painter = painter(&shot, &volume);
    let ray = Ray { start: Vec3::new(8e-3, 8e-3, -0.1), direction: Vec3::Z };
    for depth in [0.1, 0.3, 0.8] {
        let pixel = shot.params.aside + shot.params.spread * depth;
        for part in [0.1, 0.5, 0.9] {
            // The rim is so far beyond the ray.
            let radius = 5e-3 + (part - 0.5) * pixel;
            let disc = Thing {
                place: [13e-3, 8e-3, depth - 0.1, DISC as f32],
                first: [0.0, 0.0, 1.0, radius],
                colour: [1.0; 4],
                ..Thing::default()
            };
            let (own, colour) = painter.meet(&disc, Vec2::ZERO, ray).expect("it covers a part");
            assert!((own - depth).abs() < 1e-6, "{own}, not {depth}");
            assert!((colour.w - part).abs() < 1e-3, "{depth}: {colour}, not {part}");
        }
    }
}
