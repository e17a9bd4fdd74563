//! Random scenes in space: several boards, curved arrays, reflectors and their multiple reflections.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use sonoglyph::scene::{Board, Elements, Motion, Placed, Reflector, Scene, check, outline};

use crate::dice::Dice;
use crate::random::tally::count;

/// Attempts to find a scene without overlaps.
const ATTEMPTS: usize = 30;

/// The scene with its array in space; as it is if no attempt makes a valid scene.
pub fn placed(scene: &Scene, dice: &mut Dice) -> Scene {
    let mut attempts = (0..ATTEMPTS).map(|_| attempt(scene, dice));
    let Some(scene) = attempts.find(is_scene) else { return scene.clone() };
    let has_series = |reflector: &Reflector| {
        scene.array.reflectivity != 0.0 && scene.standing().iter().any(|board| reflector.faces(board))
    };
    for (name, is_one) in [
        ("several boards", scene.boards.len() > 1),
        ("reflectors", !scene.reflectors.is_empty()),
        ("reflections between a board and a reflector", scene.reflectors.iter().any(has_series)),
        ("tables of elements", scene.array.file.is_some()),
    ] {
        if is_one {
            count(name);
        }
    }
    scene
}

/// Valid, and with all focal points in front of a board and on the sound side of the reflectors.
fn is_scene(scene: &Scene) -> bool {
    let front = scene.front();
    let is_reached = |at: DVec3| front.contains(at) && scene.reflectors.iter().all(|it| it.height(at) > 0.0);
    check::check(scene).is_ok()
        && outline::foci(scene).is_ok_and(|foci| foci.iter().all(|focus| is_reached(focus.position)))
}

fn attempt(scene: &Scene, dice: &mut Dice) -> Scene {
    let mut scene = scene.clone();
    (scene.motion, scene.listener) = (Motion::default(), None);
    scene.targets.iter_mut().for_each(|target| (target.step, target.motion) = (None, None));
    let middle = scene.plane.centre.with_z(scene.plane.centre.z.max(scene.wavelength()));
    if dice.of(0.4) {
        let placed = bowl(&scene, middle.z * dice.between(1.0, 3.0), dice);
        scene.array.file = Some("elements.csv".to_owned());
        scene.array.placed = Elements::new(placed, None);
    }
    for number in 0..dice.whole(0, 3) {
        let board = match number {
            0 => Board {
                at: direction(dice) * 0.1 * middle.z,
                normal: tilted(DVec3::Z, 0.3, dice),
                ..any_turn(dice)
            },
            _ => {
                let normal = direction(dice);
                let distance = middle.z * dice.between(1.0, 3.0);
                Board { at: middle - normal * distance, normal: tilted(normal, 0.2, dice), ..any_turn(dice) }
            }
        };
        scene.boards.push(board);
    }
    for _ in 0..dice.one_of(&[0, 0, 1, 1, 2]) {
        let first = scene.standing()[0].normal;
        let normal = if dice.of(0.5) { -first } else { tilted(-first, 0.5, dice) };
        let point = middle - normal * scene.wavelength() * dice.between(0.5, 10.0);
        scene.reflectors.push(Reflector { point, normal, coefficient: dice.between(-1.0, 1.0) });
    }
    if dice.of(0.5) {
        scene.array.reflectivity = dice.between(-0.6, 0.6);
    }
    let elements = scene.elements();
    scene.array.off.retain(|&element| element < elements);
    scene.array.off.truncate(elements / 2);
    scene
}

/// The array's elements on a sphere of this radius (m), directed at its centre with some error.
fn bowl(scene: &Scene, radius: f64, dice: &mut Dice) -> Vec<Placed> {
    let place = |it: &Placed| {
        let low = it.at.truncate().clamp_length_max(0.9 * radius);
        let at = low.extend(radius - (radius * radius - low.length_squared()).sqrt());
        Placed { at, normal: tilted((DVec3::Z * radius - at).normalize_or(DVec3::Z), 0.1, dice) }
    };
    scene.array.places().iter().map(place).collect()
}

/// A unit vector.
fn direction(dice: &mut Dice) -> DVec3 {
    let (z, angle) = (dice.between(-1.0, 1.0), dice.between(-PI, PI));
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * angle.cos(), across * angle.sin(), z)
}

/// A unit vector at most this angle (rad) off another.
fn tilted(normal: DVec3, most: f64, dice: &mut Dice) -> DVec3 {
    let axis = normal.cross(direction(dice)).normalize_or(DVec3::X);
    (DQuat::from_axis_angle(axis, dice.between(-most, most)) * normal).normalize_or(normal)
}

/// A board with some direction of its columns.
fn any_turn(dice: &mut Dice) -> Board {
    Board { x_axis: direction(dice), ..Board::default() }
}
