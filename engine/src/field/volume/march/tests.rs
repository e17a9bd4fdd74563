//! Tests of rays and of whole small pictures, whose colours are known beforehand.

use glam::{DVec2, DVec3};

use super::*;
use crate::field::volume::camera::Standard;
use crate::field::volume::scenery::Item;
use crate::field::volume::{Block, Camera, Lattice, Scenery};

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

#[test]
fn light_depends_on_where_the_eye_looks_and_not_on_how_far() {
    let params = ShotParams {
        right: [1.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        forward: [0.0, 0.0, 1.0],
        surface: [0.4, 0.5, 0.3, 1.0],
        ..ShotParams::default()
    };
    let slope = Vec3::new(0.3, -0.5, 0.6);
    let seen = |direction: Vec3| lit(&params, slope, direction);
    let along = Vec3::new(0.5, 0.1, 1.0);
    assert!(seen(along).distance(seen(along * 1.3)) < 1e-6);
    assert!(seen(along).distance(seen(Vec3::Z)) > 1e-3);
}

#[test]
fn edges_are_a_pixel_that_differs_and_those_beside_it() {
    const SIDE: usize = 4;
    for bright in 0..SIDE * SIDE {
        let mut rgba = vec![0; 4 * SIDE * SIDE];
        rgba[4 * bright + 1] = 255;
        for pixel in 0..SIDE * SIDE {
            let (x, y) = (pixel % SIDE, pixel / SIDE);
            let apart = x.abs_diff(bright % SIDE) + y.abs_diff(bright / SIDE);
            assert_eq!(is_edge(&rgba, SIDE, SIDE, x, y), apart <= 1, "{bright}: {pixel}");
        }
    }
}

const SIDE: usize = 32;
const GROUND: [u8; 3] = [255, 102, 0];

/// A cube of 1 mm steps about the origin, whose values depend on the place in steps from its first point.
fn cube(count: u32, value: impl Fn(UVec3) -> f32) -> (Block, Volume) {
    let block = Block { centre: DVec3::ZERO, size: DVec3::splat(1e-3 * f64::from(count - 1)) };
    let lattice = Lattice::covering(&block, DVec3::splat(1e-3));
    let place = |i: u32| UVec3::new(i % count, i / count % count, i / count / count);
    (block, Volume::of(lattice, (0..count.pow(3)).map(|i| value(place(i))).collect()))
}

fn scenery(body: Body, clip: Block, items: Vec<Item>) -> Scenery {
    // Red grows with the field, and blue falls.
    let table = std::array::from_fn(|i| [i as u8, 0, 255 - i as u8, 255]);
    Scenery { items, body, clip, surface: Vec3::splat(0.5), table, ground: [Vec3::new(1.0, 0.4, 0.0); 2] }
}

fn painted(scenery: &Scenery, volume: &Volume, camera: &Camera) -> Vec<[u8; 3]> {
    let shot = Shot::new(scenery, volume, camera, (SIDE, SIDE));
    let rgba = picture(&shot, volume, &scenery.table, false);
    rgba.as_chunks::<4>().0.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

#[test]
fn where_nothing_is_the_ground_has_its_colour() {
    let (block, volume) = cube(5, |_| 1.0);
    let camera = Camera::of(&block, Standard::Front.direction(), 1.0, true);
    let painted = painted(&scenery(Body::Hidden, block, Vec::new()), &volume, &camera);
    assert!(painted.iter().all(|colour| *colour == GROUND), "{:?}", painted[0]);
}

#[test]
fn the_field_beyond_the_clipping_box_is_not_seen() {
    let (block, volume) = cube(17, |place| if place.x > 8 { 1.0 } else { 0.0 });
    let low = Block::between(block.low(), block.high().with_x(-1e-3));
    for standard in [Standard::Front, Standard::Side] {
        let camera = Camera::of(&block, standard.direction(), 1.0, false);
        let [_, _, forward] = camera.axes();
        let opposite = Camera { azimuth: camera.azimuth + std::f64::consts::PI, ..camera };
        for camera in [camera, opposite] {
            for body in [Body::Surface(0.5), Body::Projection] {
                let ground = |clip: Block| {
                    let painted = painted(&scenery(body, clip, Vec::new()), &volume, &camera);
                    painted.iter().filter(|colour| **colour == GROUND).count()
                };
                assert!(ground(block) < SIDE * SIDE, "{body:?} along {forward}");
                assert_eq!(ground(low), SIDE * SIDE, "{body:?} along {forward}");
            }
        }
    }
}

#[test]
fn a_slice_shows_the_field_within_the_box_and_grows_opaque_with_it() {
    let (block, volume) = cube(9, |place| place.x as f32);
    let camera = Camera::of(&block, Standard::Front.direction(), 1.0, false);
    let projection = camera.projection(DVec2::splat(SIDE as f64));
    let half = [DVec3::X * 0.05, DVec3::Z * 0.05];
    for opacity in [0.7, 1.0] {
        let slice = Item::Slice { centre: DVec3::ZERO, half, opacity };
        let painted = painted(&scenery(Body::Hidden, block, vec![slice]), &volume, &camera);
        let (mut within, mut beside) = (0, 0);
        for (i, own) in painted.iter().enumerate() {
            let at = DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) + 0.5;
            let (start, _) = projection.ray(at);
            let off = start.x.abs().max(start.z.abs()) - 4e-3;
            if off > 2e-5 {
                beside += 1;
                assert_eq!(*own, GROUND, "{at}");
            } else if off < -2e-5 {
                within += 1;
                let part = ((start.x + 4e-3) / 8e-3) as f32;
                let cover = opacity * (0.4 + 0.6 * part);
                let tint = [255.0 * part, 0.0, 255.0 * (1.0 - part)];
                for ((own, tint), ground) in own.iter().zip(tint).zip(GROUND) {
                    let expected = tint * cover + f32::from(ground) * (1.0 - cover);
                    assert!((f32::from(*own) - expected).abs() < 2.5, "{at}: {own}, not {expected}");
                }
            }
        }
        assert!(within > 100 && beside > 100, "{within} and {beside}");
    }
}

#[test]
fn a_projection_meets_a_peak_of_one_layer_at_any_depth() {
    for peak in 0..17 {
        let (block, volume) = cube(17, |place| if place.y == peak { 1.0 } else { 0.0 });
        let camera = Camera::of(&block, Standard::Front.direction(), 1.0, false);
        let painted = painted(&scenery(Body::Projection, block, Vec::new()), &volume, &camera);
        let [red, green, blue] = painted[SIDE / 2 * SIDE + SIDE / 2];
        // Never farther from the layer than half a stride, where the peak counts as opaque.
        let least = 255.0 * (1.0 - PROJECTION_STRIDE / 2.0) - 2.0;
        let is_seen = f32::from(red) > least && f32::from(255 - blue) > least && green <= 1;
        assert!(is_seen, "{peak}: {red}, {green} and {blue}");
    }
}

#[test]
fn a_ray_looks_up_each_brick_on_its_way_once() {
    let (block, volume) = cube(25, |_| 1.0);
    for standard in [Standard::Front, Standard::Top, Standard::Side] {
        let camera = Camera::of(&block, standard.direction(), 1.0, true);
        let shot = Shot::new(&scenery(Body::Hidden, block, Vec::new()), &volume, &camera, (SIDE, SIDE));
        let table = &[Vec3::ONE; 256];
        let painter = Painter { shot: &shot, params: &shot.params, volume: &volume, table };
        let projection = camera.projection(DVec2::splat(SIDE as f64));
        let (mut rays, mut bricks, mut own) = (0.0, 0.0, 0);
        for pixel in 0..SIDE * SIDE {
            let at = DVec2::new((pixel % SIDE) as f64, (pixel / SIDE) as f64) + 0.5;
            let (start, direction) = projection.ray(at);
            let ray = Ray { start: start.as_vec3(), direction: direction.as_vec3() };
            let Some((near, far)) = painter.inside(ray) else { continue };
            let grid = painter.in_steps(ray);
            let brick = |part: f32| {
                ((grid.start + grid.direction * (near + (far - near) * part)) / BRICK as f32).floor()
            };
            rays += 1.0;
            bricks += 1.0 + (brick(0.999) - brick(0.001)).abs().element_sum();
            let mut depth = near;
            while depth < far {
                depth = painter.brick(&grid, depth).1.max(depth + LEAST * grid.step);
                own += 1;
            }
        }
        // By rounding, the last brick may end just before the box.
        let is_once = (own as f32) < 1.02 * bricks + rays;
        assert!(is_once && bricks > 2.0 * rays, "{standard:?}: {own} times, {bricks} bricks, {rays} rays");
    }
}

#[test]
fn a_dark_surface_glints_where_its_normal_halves_light_and_eye() {
    let params = ShotParams {
        right: [1.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        forward: [0.0, 0.0, 1.0],
        ..ShotParams::default()
    };
    let (light, eye) = (Vec3::new(-0.44, 0.64, -0.63), Vec3::NEG_Z);
    let half = (light + eye).normalize();
    for normal in [half, (half + 0.1 * Vec3::X).normalize(), (half - 0.3 * Vec3::Y).normalize(), eye] {
        let glint = normal.dot(half).max(0.0).powi(32);
        let rim = 1.0 - normal.dot(eye);
        let expected = 0.28 * glint + 0.16 * rim.powi(3);
        let own = lit(&params, -3.0 * normal, Vec3::Z);
        assert!(own.distance(Vec3::splat(expected)) < 1e-4, "{normal}: {own}, not {expected}");
    }
}
