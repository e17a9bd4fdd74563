//! Handles in the 3D view: arrows and squares that move targets, and knobs of slices and of the clipping box.

use egui::Pos2;
use glam::DVec3;

use crate::field::volume::Block;
use crate::ui::space::view::Handle;
use crate::ui::space::{SpaceView, Stage};

/// Length of arrows, position and size of squares, and pick distance, in points.
pub const ARROW: f64 = 70.0;
pub const SQUARE: [f64; 2] = [17.0, 33.0];
const REACH: f32 = 9.0;
/// Limits of an axis' or plane normal's component along the line of sight for dragging.
const STEEPEST: f64 = 0.985;
const FLATTEST: f64 = 0.06;

pub const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

/// Position on an axis nearest to a ray, in the axis' unit. `None` for parallel rays.
pub fn along_axis((start, direction): (DVec3, DVec3), point: DVec3, axis: DVec3) -> Option<f64> {
    let (a, d, w) = (axis.length_squared(), direction.length_squared(), start - point);
    let both = axis.dot(direction);
    if both * both > STEEPEST * a * d {
        return None;
    }
    Some((w.dot(axis) * d - w.dot(direction) * both) / (a * d - both * both))
}

/// Intersection of a ray and a plane. `None` if the ray is nearly parallel, or points away.
pub fn on_plane((start, direction): (DVec3, DVec3), point: DVec3, normal: DVec3) -> Option<DVec3> {
    let slope = direction.dot(normal);
    if slope.abs() < FLATTEST * direction.length() * normal.length() {
        return None;
    }
    let depth = (point - start).dot(normal) / slope;
    (depth > 0.0).then(|| start + direction * depth)
}

/// Position of a handle at a point after dragging to a ray.
pub fn dragged(handle: Handle, ray: (DVec3, DVec3), point: DVec3) -> Option<DVec3> {
    match handle {
        Handle::Axis(axis) | Handle::Slice(axis) | Handle::Face(axis, _) => {
            along_axis(ray, point, AXES[axis]).map(|by| point + AXES[axis] * by)
        }
        Handle::Plane(axis) => on_plane(ray, point, AXES[axis]),
    }
}

/// The corners of the square handle of a point across an axis.
pub fn square(point: DVec3, axis: usize, per_point: f64) -> [DVec3; 4] {
    let [near, far] = SQUARE.map(|off| off * per_point);
    let (a, b) = (AXES[(axis + 1) % 3], AXES[(axis + 2) % 3]);
    [(near, near), (far, near), (far, far), (near, far)].map(|(x, y)| point + a * x + b * y)
}

/// Position of the knob of a slice or face: at its centre.
pub fn knob(handle: Handle, space: &SpaceView, clip: &Block) -> Option<DVec3> {
    match handle {
        Handle::Slice(axis) => {
            // At a corner, to hide nothing.
            let mut at = clip.low();
            at[(axis + 1) % 3] = clip.high()[(axis + 1) % 3];
            at[axis] = space.slices[axis]?;
            Some(at)
        }
        Handle::Face(axis, is_high) if space.is_clipped => {
            let mut at = clip.centre;
            at[axis] = if is_high { clip.high()[axis] } else { clip.low()[axis] };
            Some(at)
        }
        Handle::Face(..) | Handle::Axis(_) | Handle::Plane(_) => None,
    }
}

/// The knobs of slices and faces.
pub fn knobs() -> impl Iterator<Item = Handle> {
    (0..3).map(Handle::Slice).chain((0..6).map(|i| Handle::Face(i / 2, i % 2 == 1)))
}

/// The handle under a screen position; `chosen` is the centre of the selection.
pub fn at(stage: &Stage, space: &SpaceView, chosen: Option<DVec3>, at: Pos2) -> Option<Handle> {
    if let Some(point) = chosen {
        let per_point = stage.per_point(point);
        let middle = stage.screen(point)?;
        let arrow = |axis: usize| {
            let tip = stage.screen(point + AXES[axis] * (ARROW * per_point))?;
            (distance(middle + (tip - middle) * 0.25, tip, at) <= REACH
                && along_axis(stage.ray(at), point, AXES[axis]).is_some())
            .then_some(Handle::Axis(axis))
        };
        let in_square = |axis: usize| {
            let hit = on_plane(stage.ray(at), point, AXES[axis])? - point;
            let [near, far] = SQUARE.map(|off| off * per_point);
            let is_in = |other: usize| (near..=far).contains(&hit[(axis + other) % 3]);
            (is_in(1) && is_in(2)).then_some(Handle::Plane(axis))
        };
        if let Some(found) = (0..3).find_map(in_square).or_else(|| (0..3).find_map(arrow)) {
            return Some(found);
        }
    }
    let near = |handle: &Handle| {
        let knob = knob(*handle, space, &stage.clip).and_then(|point| stage.screen(point));
        knob.is_some_and(|knob| knob.distance(at) <= REACH)
    };
    knobs().find(near)
}

/// Distance from a screen position to a line, in points.
pub fn distance(a: Pos2, b: Pos2, at: Pos2) -> f32 {
    let along = b - a;
    let part = ((at - a).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
    at.distance(a + along * part)
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn a_ray_drags_along_an_axis_to_the_place_nearest_to_it() {
        let point = dvec3(0.01, 0.02, 0.1);
        for axis in AXES {
            // A skew ray: the point is at the common perpendicular.
            let perpendicular = axis.any_orthonormal_vector();
            let towards = axis.cross(perpendicular) + axis * 0.3;
            let nearest = point + axis * 0.037;
            let start = nearest + perpendicular * 0.005 - towards * 2.0;
            let by = along_axis((start, towards * 1.7), point, axis).unwrap();
            assert!((by - 0.037).abs() < 1e-12, "{axis}: {by}");
            assert_eq!(along_axis((start, axis + perpendicular * 0.01), point, axis), None, "along the axis");
        }
    }

    #[test]
    fn a_ray_drags_across_an_axis_to_where_it_meets_the_plane() {
        let point = dvec3(0.0, 0.0, 0.1);
        let ray = (dvec3(0.3, -0.2, 0.5), dvec3(-0.5, 0.4, -1.0));
        for (axis, normal) in AXES.into_iter().enumerate() {
            let Some(hit) = dragged(Handle::Plane(axis), ray, point) else { continue };
            assert!((hit - point).dot(normal).abs() < 1e-12);
            let along = hit - ray.0;
            assert!(along.cross(ray.1).length() < 1e-12 && along.dot(ray.1) > 0.0);
        }
        assert!(dragged(Handle::Plane(2), ray, point).is_some());
        assert_eq!(on_plane((ray.0, DVec3::X), point, DVec3::Z), None, "in the plane");
        assert_eq!(on_plane((ray.0, DVec3::Z), point, DVec3::Z), None, "behind");
    }
}
