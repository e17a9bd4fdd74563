//! Where sound is heard: in front of the nearest board, and on the sound's side of every reflector.

use glam::{DVec2, DVec3};

use crate::acoustics::aperture::Aperture;
use crate::acoustics::face::{Face, Pose};
use crate::scene::Reflector;

/// m: points of a reflector are on its sound's side.
const SLACK: f64 = 1e-6;
/// m: boards and elements that count as equally near.
const EQUAL: f64 = 1e-9;

/// The space in front of boards and reflectors. Behind the nearest board, and within it, and behind a reflector there
/// is no sound, whatever the formula gives: only elements, their images and boards are in it, not their shadows.
#[derive(Debug)]
pub struct Clearance<'a> {
    boards: Vec<Surface<'a>>,
    mirrors: &'a [Reflector],
}

/// A board as an obstacle.
#[derive(Debug)]
enum Surface<'a> {
    /// The box around its elements' centres, m.
    Flat {
        pose: Pose,
        low: DVec2,
        high: DVec2,
    },
    Curved(&'a Face),
}

impl<'a> Clearance<'a> {
    pub fn new(aperture: &'a Aperture) -> Self {
        let surface = |face: &'a Face| {
            let (low, high) = face.corners();
            let flat = Surface::Flat { pose: face.pose, low, high };
            if face.layout.is_flat() { flat } else { Surface::Curved(face) }
        };
        Self { boards: aperture.boards().map(surface).collect(), mirrors: &aperture.mirrors }
    }

    /// Height (m) of a point above the nearest board, or above the nearest element of a curved one; 0 where there is
    /// no sound, and of a point that is not finite.
    pub fn at(&self, point: DVec3) -> f64 {
        let is_before = |mirror: &Reflector| mirror.height(point) >= -SLACK;
        if !point.is_finite() || !self.mirrors.iter().all(is_before) {
            return 0.0;
        }
        let nearest = self.boards.iter().map(|board| board.nearest(point)).reduce(nearer);
        nearest.map_or(0.0, |(_, height)| height.max(0.0))
    }
}

impl Surface<'_> {
    /// Distance (m) of a point, and its height above the nearest part.
    fn nearest(&self, point: DVec3) -> (f64, f64) {
        match self {
            Self::Flat { pose, low, high } => {
                let own = pose.local(point);
                (own.distance(own.truncate().clamp(*low, *high).extend(0.0)), own.z)
            }
            Self::Curved(face) => {
                let own = face.pose.local(point);
                let element =
                    |(n, at): (usize, &DVec3)| (own.distance(*at), face.layout.normal(n).dot(own - at));
                let elements = face.layout.positions.iter().enumerate().map(element);
                elements.reduce(nearer).unwrap_or((f64::INFINITY, 0.0))
            }
        }
    }
}

/// The nearer of two, and of equally near ones that in front of which the point is higher.
fn nearer(one: (f64, f64), other: (f64, f64)) -> (f64, f64) {
    let is_other = if (one.0 - other.0).abs() < EQUAL { other.1 > one.1 } else { other.0 < one.0 };
    if is_other { other } else { one }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Array, Board, Elements, Placed, Scene};

    fn of(scene: &Scene, places: &[([f64; 3], f64)]) {
        let aperture = Aperture::new(scene);
        for &(place, expected) in places {
            let height = Clearance::new(&aperture).at(DVec3::from_array(place));
            assert!((height - expected).abs() < 1e-12, "{place:?}: {height}, not {expected}");
        }
    }

    #[test]
    fn boards_and_reflectors_hide_what_is_behind_them() {
        let array = Array { rows: 4, columns: 4, ..Array::default() };
        let facing = Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() };
        let wall = Reflector { point: DVec3::X * 0.1, normal: DVec3::NEG_X, coefficient: 0.5 };
        let scene = Scene {
            array,
            boards: vec![Board::default(), facing],
            reflectors: vec![wall],
            ..Scene::default()
        };
        of(
            &scene,
            &[
                ([0.0, 0.0, 0.05], 0.05),
                ([0.0, 0.0, 0.16], 0.04),
                ([-0.3, 0.0, 0.02], 0.02),
                ([0.1, 0.0, 0.05], 0.05),
                ([0.11, 0.0, 0.05], 0.0),
                ([0.0, 0.0, -0.01], 0.0),
                ([0.0, 0.02, 0.21], 0.0),
                ([-0.3, 0.0, 0.3], 0.0),
                ([f64::NAN, 0.0, 0.1], 0.0),
            ],
        );
    }

    #[test]
    fn an_outward_ball_has_sound_all_around_and_none_inside() {
        let golden = std::f64::consts::PI * (1.0 + 5f64.sqrt());
        let placed = |n: u32| {
            let (z, angle) = (1.0 - f64::from(2 * n + 1) / 100.0, golden * f64::from(n));
            let (sin, cos) = angle.sin_cos();
            let normal = DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z;
            Placed { at: 0.05 * normal, normal }
        };
        let placed = Elements::new((0..100).map(placed).collect(), None);
        let array = Array { placed, file: Some("ball.csv".to_owned()), ..Array::default() };
        let aperture = Aperture::new(&Scene { array, ..Scene::default() });
        for n in 0..50 {
            let (sin, cos) = f64::from(n).sin_cos();
            let way = DVec3::new(cos, sin, (0.7 * f64::from(n)).sin()).normalize_or_zero();
            for (distance, is_heard) in [(0.02, false), (0.045, false), (0.06, true), (0.2, true)] {
                let height = Clearance::new(&aperture).at(way * distance);
                assert_eq!(height > 0.0, is_heard, "{way} {distance}: {height}");
            }
        }
    }
}
