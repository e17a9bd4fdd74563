//! Tests of whole small pictures, whose colours are known beforehand.

use glam::{DVec2, DVec3};

use super::*;
use crate::field::volume::camera::Standard;
use crate::field::volume::scenery::Item;
use crate::field::volume::{Block, Camera, Lattice, Scenery};

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
