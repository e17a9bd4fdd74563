//! The camera of 3D pictures: an eye orbiting a point.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};
use strum::{EnumString, VariantArray};

use crate::field::volume::Block;

/// Half of the angle of view of a perspective picture, rad.
const HALF_VIEW: f64 = 0.24;
/// Free margin around a fitted view.
const MARGIN: f64 = 1.12;
/// m that the picture may be high at the target.
const SPANS: [f64; 2] = [1e-4, 20.0];
/// Near limit in front of the eye, m.
const NEAREST: f64 = 1e-4;
/// Distance of the eye in parallel projection, in heights of the picture.
const FAR_OFF: f64 = 40.0;

/// Views that have a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Standard {
    Iso,
    Top,
    Front,
    Side,
}

impl Standard {
    /// Azimuth and elevation, rad.
    pub fn direction(self) -> [f64; 2] {
        match self {
            Self::Iso => [0.6, 0.36],
            Self::Top => [0.0, FRAC_PI_2],
            Self::Front => [0.0, 0.0],
            Self::Side => [FRAC_PI_2, 0.0],
        }
    }
}

/// An eye that looks at a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// m, in the middle of the picture.
    pub target: DVec3,
    /// rad, counter-clockwise seen from above; at 0 one looks along +y, with x to the right.
    pub azimuth: f64,
    /// rad above the horizon.
    pub elevation: f64,
    /// m that the picture is high at the target.
    pub span: f64,
    pub is_perspective: bool,
}

/// A camera and the pixels of its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// m. In parallel projection, a point behind the start of all rays.
    pub eye: DVec3,
    /// Unit vectors.
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    pub size: DVec2,
    /// Offset (m) of a ray's start, and its spread per m, for a pixel beside the centre.
    pub aside: f64,
    pub spread: f64,
}

impl Camera {
    /// A view of a whole box on a picture of this aspect ratio.
    pub fn of(block: &Block, [azimuth, elevation]: [f64; 2], aspect: f64, is_perspective: bool) -> Self {
        let mut camera = Self { target: block.centre, azimuth, elevation, span: 1.0, is_perspective };
        let [right, up, forward] = camera.axes();
        let half = block.size / 2.0;
        let corners = [-1.0, 1.0].into_iter().flat_map(|x| {
            [-1.0, 1.0].into_iter().flat_map(move |y| [-1.0, 1.0].map(|z| DVec3::new(x, y, z)))
        });
        // Objects nearer than the target appear larger.
        let spread = if is_perspective { HALF_VIEW.tan() } else { 0.0 };
        let needed = |corner: DVec3| {
            let at = corner * half;
            let across = (right.dot(at).abs() / aspect).max(up.dot(at).abs());
            2.0 * (across - spread * forward.dot(at))
        };
        camera.span = (MARGIN * corners.map(needed).fold(0.0, f64::max)).clamp(SPANS[0], SPANS[1]);
        camera
    }

    /// Unit vectors to the right, upwards and forward.
    pub fn axes(&self) -> [DVec3; 3] {
        let (sine, cosine) = self.azimuth.sin_cos();
        let (rise, run) = self.elevation.sin_cos();
        let right = DVec3::new(cosine, sine, 0.0);
        let forward = DVec3::new(-run * sine, run * cosine, -rise);
        [right, right.cross(forward), forward]
    }

    pub fn projection(&self, size: DVec2) -> Projection {
        let [right, up, forward] = self.axes();
        let per_pixel = self.span / size.y;
        let distance =
            if self.is_perspective { self.span / 2.0 / HALF_VIEW.tan() } else { FAR_OFF * self.span };
        let (aside, spread) =
            if self.is_perspective { (0.0, per_pixel / distance) } else { (per_pixel, 0.0) };
        Projection { eye: self.target - forward * distance, right, up, forward, size, aside, spread }
    }

    /// Orbits the target; a drag over the picture's height is half a turn.
    pub fn orbited(&self, by: DVec2) -> Self {
        let azimuth = (self.azimuth - by.x * TAU / 2.0).rem_euclid(TAU);
        let elevation = (self.elevation + by.y * TAU / 2.0).clamp(-FRAC_PI_2, FRAC_PI_2);
        Self { azimuth, elevation, ..*self }
    }

    /// Pans by fractions of the picture's height to the right and downwards.
    pub fn panned(&self, by: DVec2) -> Self {
        let [right, up, _] = self.axes();
        Self { target: self.target + (up * by.y - right * by.x) * self.span, ..*self }
    }

    /// Zooms by a factor towards a position, in fractions of the picture's height from the centre to the right and
    /// downwards.
    pub fn zoomed(&self, at: DVec2, factor: f64) -> Self {
        let span = (self.span / factor).clamp(SPANS[0], SPANS[1]);
        let [right, up, _] = self.axes();
        let target = self.target + (right * at.x - up * at.y) * (self.span - span);
        Self { span, target, ..*self }
    }
}

impl Projection {
    /// Pixels from the left and the top, and m from the eye's plane; `None` behind the eye.
    pub fn screen(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let offset = point - self.eye;
        let depth = self.forward.dot(offset);
        let per_metre = 1.0 / (self.aside + self.spread * depth);
        let at = DVec2::new(self.right.dot(offset), -self.up.dot(offset)) * per_metre;
        (depth > NEAREST && per_metre.is_finite()).then(|| (at + self.size / 2.0, depth))
    }

    /// Origin and direction of the ray through a pixel, scaled to a forward component of 1.
    pub fn ray(&self, at: DVec2) -> (DVec3, DVec3) {
        let offset = at - self.size / 2.0;
        let across = self.right * offset.x - self.up * offset.y;
        (self.eye + across * self.aside, self.forward + across * self.spread)
    }

    /// m per pixel at this depth (m) from the eye's plane.
    pub fn per_pixel(&self, depth: f64) -> f64 {
        self.aside + self.spread * depth
    }

    /// The part of a line that lies in front of the eye.
    pub fn in_front(&self, [a, b]: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let [near, far] = [a, b].map(|point| self.forward.dot(point - self.eye) - 2.0 * NEAREST);
        let crossing = a + (b - a) * (near / (near - far));
        match (near > 0.0, far > 0.0) {
            (true, true) => Some([a, b]),
            (true, false) => Some([a, crossing]),
            (false, true) => Some([crossing, b]),
            (false, false) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    fn block() -> Block {
        Block { centre: dvec3(0.01, -0.02, 0.1), size: dvec3(0.2, 0.1, 0.15) }
    }

    #[test]
    fn standard_views_have_their_axes() {
        let axes = |standard: Standard| Camera::of(&block(), standard.direction(), 1.0, false).axes();
        for (standard, right, up) in [
            (Standard::Front, DVec3::X, DVec3::Z),
            (Standard::Top, DVec3::X, DVec3::Y),
            (Standard::Side, DVec3::Y, DVec3::Z),
        ] {
            let [own_right, own_up, _] = axes(standard);
            assert!(own_right.distance(right) < 1e-12 && own_up.distance(up) < 1e-12, "{standard:?}");
        }
    }

    #[test]
    fn rays_pass_through_what_is_seen_there_and_the_whole_box_is_on_the_picture() {
        for is_perspective in [false, true] {
            for standard in Standard::VARIANTS {
                let camera = Camera::of(&block(), standard.direction(), 1.5, is_perspective);
                let projection = camera.projection(DVec2::new(600.0, 400.0));
                for corner in [block().low(), block().high(), dvec3(-0.09, 0.03, 0.175)] {
                    let (at, depth) = projection.screen(corner).unwrap();
                    assert!(at.cmpge(DVec2::ZERO).all() && at.cmple(projection.size).all(), "{at}");
                    let (start, direction) = projection.ray(at);
                    assert!((start + direction * depth).distance(corner) < 1e-12, "{corner}");
                }
            }
        }
    }

    #[test]
    fn a_drag_over_the_pictures_height_is_half_a_turn() {
        let camera = Camera::of(&block(), [0.4, 0.0], 1.0, true);
        let [right, up, forward] = camera.axes();
        let halfway = |a: DVec3, b: DVec3| (a + b).normalize_or_zero();
        for (by, expected) in [
            (DVec2::X, -forward),
            (DVec2::X * 0.5, right),
            (DVec2::X * -0.25, halfway(forward, -right)),
            (DVec2::Y * 0.25, halfway(forward, -up)),
            (DVec2::Y * -0.5, up),
        ] {
            let own = camera.orbited(by).axes()[2];
            assert!(own.distance(expected) < 1e-12, "{by}: {own}, not {expected}");
        }
    }

    #[test]
    fn what_is_behind_the_eye_is_not_on_the_screen() {
        for is_perspective in [false, true] {
            let projection =
                Camera::of(&block(), [0.4, 0.2], 1.0, is_perspective).projection(DVec2::splat(500.0));
            let ahead = |m: f64| projection.eye + projection.forward * m + projection.right * 0.01;
            assert!(projection.screen(ahead(0.1)).is_some());
            for behind in [0.0, 0.1, 1e3] {
                assert_eq!(projection.screen(ahead(-behind)), None);
            }
        }
    }

    #[test]
    fn lines_are_cut_in_front_of_the_eye() {
        let projection = Camera::of(&block(), [0.4, 0.2], 1.0, true).projection(DVec2::splat(500.0));
        let ahead = |m: f64| projection.eye + projection.forward * m + projection.right * (0.1 + m);
        let (behind, near, far) = (ahead(-0.2), ahead(2.0 * NEAREST), ahead(0.5));
        let [cut, end] = projection.in_front([behind, far]).unwrap();
        assert!(cut.distance(near) < 1e-12 && end == far, "{cut}, not {near}");
        let [start, cut] = projection.in_front([far, behind]).unwrap();
        assert!(start == far && cut.distance(near) < 1e-12, "{cut}, not {near}");
        assert_eq!(projection.in_front([far, ahead(0.1)]), Some([far, ahead(0.1)]));
        assert_eq!(projection.in_front([behind, ahead(-0.1)]), None);
    }

    #[test]
    fn what_is_under_the_pointer_stays_there_when_zoomed_and_follows_it_when_panned() {
        let camera = Camera::of(&block(), [0.4, 0.2], 1.0, true);
        let size = DVec2::splat(500.0);
        let at = DVec2::new(0.2, -0.1);
        let under = |camera: &Camera, at: DVec2| {
            let [right, up, _] = camera.axes();
            camera.target + (right * at.x - up * at.y) * camera.span
        };
        let point = under(&camera, at);
        let seen = |camera: &Camera| camera.projection(size).screen(point).unwrap().0;
        let before = seen(&camera);
        assert!(before.distance(size / 2.0 + at * 500.0) < 1e-9);
        assert!(seen(&camera.zoomed(at, 1.7)).distance(before) < 1e-9);
        let moved = camera.panned(DVec2::new(0.1, 0.05));
        assert!(seen(&moved).distance(before + DVec2::new(50.0, 25.0)) < 1e-9);
        let turned = camera.orbited(DVec2::new(0.1, 9.0));
        assert!((turned.elevation - FRAC_PI_2).abs() < 1e-12 && turned.target == camera.target);
    }
}
