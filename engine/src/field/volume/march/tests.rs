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
fn rays_along_faces_of_bricks_meet_the_surface() {
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
fn rim_of_a_disc_covers_pixels_in_part() {
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
fn a_slice_grows_opaque_with_the_field_in_the_box() {
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
