//! Boards as radiators in their own coordinates: pose, elements, and images in reflectors.

use std::ops::Range;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use crate::scene::{Board, Reflector};

/// Position and orientation of a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// m, of its centre.
    at: DVec3,
    /// Unit vectors along its axes; those of an image are left-handed.
    axes: DMat3,
}

impl Pose {
    /// The pose in z = 0, centred on the origin, facing +z.
    pub const HOME: Self = Self { at: DVec3::ZERO, axes: DMat3::IDENTITY };

    pub fn of(board: &Board) -> Self {
        Self { at: board.at, axes: board.axes().unwrap_or(DMat3::IDENTITY) }
    }

    /// A point of the scene in the board's coordinates.
    pub fn local(&self, point: DVec3) -> DVec3 {
        if *self == Self::HOME { point } else { self.axes.transpose() * (point - self.at) }
    }

    /// A direction of the scene in the board's coordinates.
    pub fn local_direction(&self, direction: DVec3) -> DVec3 {
        if *self == Self::HOME { direction } else { self.axes.transpose() * direction }
    }

    /// A point of the board in the scene's coordinates.
    pub fn world(&self, place: DVec3) -> DVec3 {
        if *self == Self::HOME { place } else { self.at + self.axes * place }
    }

    /// A direction of the board in the scene's coordinates.
    pub fn world_direction(&self, direction: DVec3) -> DVec3 {
        if *self == Self::HOME { direction } else { self.axes * direction }
    }

    /// The composition of two poses.
    pub(super) fn after(&self, own: &Self) -> Self {
        if *own == Self::HOME {
            return *self;
        }
        Self { at: self.world(own.at), axes: self.axes * own.axes }
    }

    fn moved(self, by: DVec3) -> Self {
        Self { at: self.at + by, ..self }
    }

    /// x' = x - 2n (n·x - d), and every direction likewise.
    fn mirrored(self, mirror: &Reflector) -> Self {
        let normal = mirror.normal.normalize_or_zero();
        let turned = |direction: DVec3| direction - normal * (2.0 * normal.dot(direction));
        let DMat3 { x_axis, y_axis, z_axis } = self.axes;
        Self {
            at: self.at - normal * (2.0 * mirror.height(self.at)),
            axes: DMat3::from_cols(turned(x_axis), turned(y_axis), turned(z_axis)),
        }
    }
}

/// The elements of a board in its own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// m, centres.
    pub positions: Vec<DVec3>,
    /// Directions of radiation; empty if all elements lie in z = 0 and radiate along z.
    pub normals: Vec<DVec3>,
    /// Directions of the elements' own x axes, by [`aside`]; empty if these are the board's.
    pub asides: Vec<DVec3>,
    /// Number of elements along x, if they form full rows in z = 0; element n = row · columns + column, column 0 at
    /// smallest x, row 0 at smallest y.
    pub columns: Option<usize>,
}

impl Layout {
    /// Whether all elements lie in z = 0 and radiate along z.
    pub fn is_flat(&self) -> bool {
        self.normals.is_empty()
    }

    /// The direction in which an element radiates.
    pub fn normal(&self, element: usize) -> DVec3 {
        self.normals.get(element).copied().unwrap_or(DVec3::Z)
    }

    /// The direction of an element's own x axis.
    pub fn aside(&self, element: usize) -> DVec3 {
        self.asides.get(element).copied().unwrap_or(DVec3::X)
    }

    /// The box around the centres of its elements, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let places = self.positions.iter();
        places.fold((DVec3::MAX, DVec3::MIN), |(low, high), at| (low.min(*at), high.max(*at)))
    }

    /// The elements in coordinates in which they are flat, or else with their mean direction along z; and the pose of
    /// these coordinates.
    pub(super) fn level(self) -> (Self, Pose) {
        let count = self.positions.len() as f64;
        let centre = self.positions.iter().sum::<DVec3>() / count;
        let mean = (0..self.positions.len()).map(|n| self.normal(n)).sum::<DVec3>() / count;
        // Elements that face each other have no direction in common.
        let up = mean.try_normalize().filter(|_| mean.length() > 0.1).unwrap_or(DVec3::Z);
        let (mut pose, mut level) = (Pose::HOME, self);
        if up != DVec3::Z || level.positions.iter().any(|at| at.z != 0.0) {
            let x = aside(up);
            pose = Pose { at: centre, axes: DMat3::from_cols(x, up.cross(x), up) };
            level.positions.iter_mut().for_each(|at| *at = pose.local(*at));
            let directions = level.normals.iter_mut().chain(&mut level.asides);
            directions.for_each(|direction| *direction = pose.local_direction(*direction));
        }
        let is_level = |at: &DVec3| at.z.abs() < FLAT;
        let is_straight = |normal: &DVec3| normal.truncate().length() < FLAT && normal.z > 0.0;
        if level.positions.iter().all(is_level) && level.normals.iter().all(is_straight) {
            level.positions.iter_mut().for_each(|at| at.z = 0.0);
            level.normals.clear();
            level.asides.clear();
        }
        (level, pose)
    }
}

/// The x axis (a unit vector) of an element that radiates along a normal: that of its array, turned with +z to the normal by the
/// shortest way; about x if the normal is -z.
pub(super) fn aside(normal: DVec3) -> DVec3 {
    let across = normal.truncate().length_squared();
    // 1 + z, without a difference of like numbers.
    let above = if normal.z >= 0.0 { 1.0 + normal.z } else { across / (1.0 - normal.z) };
    if above == 0.0 {
        return DVec3::X;
    }
    let x = DVec3::new(1.0 - normal.x * normal.x / above, -normal.x * normal.y / above, -normal.x);
    x.normalize_or(DVec3::X)
}

/// Tolerance for flat boards in files (m, and a sine).
const FLAT: f64 = 1e-12;

/// A board, or its image in a reflector.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    pub pose: Pose,
    pub layout: Arc<Layout>,
    /// The number of its first element among those of the array.
    pub first: usize,
    /// Factor on the drive of its elements: 1, or for an image the coefficient of its reflector.
    pub gain: f64,
    /// Bound on the contribution of this and all later images, relative to the board's own sound.
    pub rest: f64,
}

impl Face {
    pub(super) fn board(pose: Pose, layout: Arc<Layout>, first: usize) -> Self {
        Self { pose, layout, first, gain: 1.0, rest: f64::INFINITY }
    }

    /// Its elements among those of the array.
    pub fn elements(&self) -> Range<usize> {
        self.first..self.first + self.layout.positions.len()
    }

    /// Its elements among some of the array's, in ascending order, and their indices there.
    pub(crate) fn among(&self, elements: &[usize]) -> Range<usize> {
        let Range { start, end } = self.elements();
        elements.partition_point(|&n| n < start)..elements.partition_point(|&n| n < end)
    }

    /// Whether it is the board itself rather than an image.
    pub(crate) fn is_direct(&self) -> bool {
        self.rest == f64::INFINITY
    }

    /// Opposite corners of the box around its elements' centres, across the direction of radiation; m.
    pub fn corners(&self) -> (DVec2, DVec2) {
        let (low, high) = self.layout.bounds();
        (low.truncate(), high.truncate())
    }
}

/// Reflections back and forth between an array's face and a reflector, at most.
const MOST_REFLECTIONS: i32 = 2000;
/// Relative error of a truncated series.
const SILENCE: f64 = 1e-13;

/// The images of boards in reflectors, the loudest first. A reflector makes one image of each board, or, if the
/// board's face of reflectivity `reflectivity` is parallel to it, the series of multiple reflections: with R the
/// reflector's coefficient and h its distance, boards at -2mh with (reflectivity R)^m, and their images with another
/// R. And a bound on what the longest series leaves out, relative to the board's own sound.
pub(super) fn images(
    boards: &[Face],
    mirrors: &[Reflector],
    standing: &[Board],
    reflectivity: f64,
) -> (Vec<Face>, f64) {
    let (mut images, mut remainder) = (Vec::new(), 0.0_f64);
    for mirror in mirrors.iter().filter(|mirror| mirror.coefficient != 0.0) {
        for (face, board) in boards.iter().zip(standing) {
            let own = if mirror.faces(board) { reflectivity } else { 0.0 };
            let (both, up) = (own * mirror.coefficient, mirror.normal.normalize_or_zero());
            // The remaining terms form a geometric series, reduced by their distances.
            let rest = |gain: f64, times: i32| (gain / (1.0 - both.abs()) / f64::from(2 * times + 1)).abs();
            remainder = remainder.max(rest(both.powi(MOST_REFLECTIONS + 1), MOST_REFLECTIONS + 1));
            for times in 0..=MOST_REFLECTIONS {
                let gain = both.powi(times);
                if rest(gain, times) < SILENCE {
                    break;
                }
                let pose = face.pose.moved(up * (2.0 * f64::from(times) * mirror.height(board.at)));
                let image =
                    |pose: Pose, gain: f64| Face { pose, gain, rest: rest(gain, times), ..face.clone() };
                if times > 0 {
                    images.push(image(pose, gain));
                }
                images.push(image(pose.mirrored(mirror), gain * mirror.coefficient));
            }
        }
    }
    images.sort_by(|a, b| b.rest.total_cmp(&a.rest));
    (images, remainder)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three elements in a row on a plane through `at`, with these directions in the plane's axes.
    fn placed(at: DVec3, axes: DMat3, normals: [DVec3; 3]) -> Layout {
        let position = |x: f64| at + axes * DVec3::new(x, 0.0, 0.0);
        Layout {
            positions: vec![position(-0.01), position(0.0), position(0.01)],
            normals: normals.map(|normal| axes * normal).to_vec(),
            asides: normals.map(|normal| aside(axes * normal)).to_vec(),
            columns: None,
        }
    }

    #[test]
    fn elements_in_a_plane_that_radiate_across_it_are_flat() {
        let up = DVec3::new(0.6, 0.0, 0.8);
        let x = up.any_orthonormal_vector();
        let tilted = DMat3::from_cols(x, up.cross(x), up);
        for (at, axes) in [(DVec3::ZERO, DMat3::IDENTITY), (DVec3::new(0.1, -0.2, 0.3), tilted)] {
            let (level, pose) = placed(at, axes, [DVec3::Z; 3]).level();
            assert!(level.is_flat() && level.positions.iter().all(|position| position.z == 0.0), "{level:?}");
            assert!(pose.world_direction(DVec3::Z).distance(axes.z_axis) < 1e-12, "{pose:?}");
            // One that looks aside is enough to need all directions.
            let aside = DVec3::new(0.28, 0.0, 0.96);
            let (level, _) = placed(at, axes, [aside, DVec3::Z, aside * DVec3::new(-1.0, 1.0, 1.0)]).level();
            assert_eq!(level.normals.len(), 3);
        }
    }
}
