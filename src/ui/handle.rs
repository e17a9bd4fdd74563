//! Handles of shapes, and the shape that results from dragging one.

use egui::{Painter, Pos2, Rect, Stroke, StrokeKind, vec2};
use glam::{DQuat, DVec2, DVec3};

use crate::scene::{Shape, Target, outline};
use crate::ui::theme;
use crate::ui::view::{Axes, Lens};

/// Smallest size, m.
const SMALLEST: f64 = 1e-3;
/// Vertices of a path that get a handle each; of more, the box around them gets one.
const FEW: usize = 24;
/// Half a handle's side, and pick distance, in points.
pub const HALF: f32 = 4.0;
pub const REACH: f32 = 9.0;

/// The handles of a target.
pub fn handles(target: &Target) -> Vec<DVec3> {
    let flat = |at: DVec3, places: &[DVec2]| -> Vec<DVec3> {
        places.iter().map(|place| at + target.turn() * place.extend(0.0)).collect()
    };
    match &target.shape {
        Shape::Point { .. } | Shape::Trap { .. } => Vec::new(),
        Shape::Line { .. } => outline::strokes(target).unwrap_or_default().concat(),
        Shape::Circle { at, radius } => flat(*at, &[DVec2::X * *radius]),
        Shape::Rectangle { at, width, height } => {
            let half = DVec2::new(*width, *height) / 2.0;
            flat(*at, &[-half, half * DVec2::new(1.0, -1.0), half, half * DVec2::new(-1.0, 1.0)])
        }
        Shape::Triangle { at, size } => flat(*at, &[DVec2::Y * (*size / 3.0_f64.sqrt())]),
        Shape::Polygon { at, radius, .. } => flat(*at, &[DVec2::Y * *radius]),
        Shape::Path { vertices, .. } if vertices.len() <= FEW => placed_vertices(target),
        Shape::Path { .. } | Shape::Text { .. } | Shape::Picture { .. } => {
            corner(target).into_iter().collect()
        }
    }
}

/// The vertices of a path as drawn, rotated about its centre.
fn placed_vertices(target: &Target) -> Vec<DVec3> {
    let Shape::Path { vertices, .. } = &target.shape else { return Vec::new() };
    let centre = outline::centre(&target.shape);
    let turn = DQuat::from_rotation_z(target.angle);
    vertices.iter().map(|vertex| centre + turn * (*vertex - centre)).collect()
}

/// The upper right corner of the box around a target, in the target's own plane.
fn corner(target: &Target) -> Option<DVec3> {
    let centre = outline::centre(&target.shape);
    let back = target.turn().inverse();
    let points = outline::strokes(target).ok()?.concat();
    let high = points.into_iter().map(|point| back * (point - centre)).reduce(DVec3::max)?;
    Some(centre + target.turn() * DVec3::new(high.x, high.y, 0.0))
}

/// The target after moving one of its handles.
pub fn pulled(target: &Target, handle: usize, to: DVec3) -> Target {
    let mut pulled = target.clone();
    let centre = outline::centre(&target.shape);
    let from_centre = (target.turn().inverse() * (to - centre)).truncate();
    let radius = from_centre.length().max(SMALLEST);
    let ends = handles(target);
    match &mut pulled.shape {
        Shape::Point { .. } | Shape::Trap { .. } => {}
        Shape::Line { from, to: end } => {
            if let [a, b] = ends[..] {
                let (other, moves) = if handle == 0 { (b, &mut *from) } else { (a, &mut *end) };
                if other.distance(to) >= SMALLEST {
                    *moves = to;
                    *(if handle == 0 { end } else { from }) = other;
                    pulled.angle = 0.0;
                }
            }
        }
        Shape::Circle { radius: own, .. } | Shape::Polygon { radius: own, .. } => *own = radius,
        Shape::Triangle { size, .. } => *size = radius * 3.0_f64.sqrt(),
        Shape::Rectangle { at, width, height } => {
            // The opposite corner stays.
            let Some(&opposite) = ends.get((handle + 2) % 4) else { return pulled };
            let across = (target.turn().inverse() * (to - opposite)).truncate();
            let size = across.abs().max(DVec2::splat(SMALLEST));
            let signs = DVec2::new(1.0_f64.copysign(across.x), 1.0_f64.copysign(across.y));
            (*width, *height) = (size.x, size.y);
            *at = opposite + target.turn() * (size * signs / 2.0).extend(0.0);
        }
        Shape::Path { vertices, .. } if vertices.len() <= FEW => {
            if let Some(vertex) = ends.get(handle) {
                *vertices = placed_vertices(target);
                let is_own = vertices.iter_mut().find(|own| *own == vertex);
                is_own.into_iter().for_each(|own| *own = to);
                pulled.angle = 0.0;
            }
        }
        Shape::Path { vertices, .. } => {
            let factor = scaling(target, from_centre);
            vertices.iter_mut().for_each(|vertex| *vertex = centre + (*vertex - centre) * factor);
        }
        Shape::Picture { width, .. } => *width = (*width * scaling(target, from_centre)).max(SMALLEST),
        Shape::Text { height, .. } => *height = (*height * scaling(target, from_centre)).max(SMALLEST),
    }
    pulled
}

/// The scale factor for moving a corner of a target's box there.
fn scaling(target: &Target, to: DVec2) -> f64 {
    let Some(corner) = corner(target) else { return 1.0 };
    let own = (target.turn().inverse() * (corner - outline::centre(&target.shape))).truncate();
    let extent = own.length();
    if extent < 1e-9 { 1.0 } else { (to.dot(own) / (extent * extent)).max(SMALLEST / extent) }
}

/// The handle under the pointer.
pub fn at(target: &Target, axes: &Axes, lens: &Lens, pointer: Pos2) -> Option<usize> {
    let distance = |place: &DVec3| lens.screen(axes.flat(*place)).distance(pointer);
    let places = handles(target);
    let nearest = (0..places.len()).min_by(|&a, &b| distance(&places[a]).total_cmp(&distance(&places[b])))?;
    (distance(&places[nearest]) <= REACH).then_some(nearest)
}

pub fn paint(target: &Target, axes: &Axes, painter: &Painter, lens: &Lens) {
    for place in handles(target) {
        square(lens.screen(axes.flat(place)), painter);
    }
}

/// Draws a handle.
pub fn square(at: Pos2, painter: &Painter) {
    let rect = Rect::from_center_size(at, vec2(HALF, HALF) * 2.0);
    painter.rect(rect, 1.0, theme::MARK, Stroke::new(1.5, theme::ACCENT), StrokeKind::Middle);
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: DVec3 = DVec3::new(0.01, 0.02, 0.1);

    fn shapes() -> Vec<Shape> {
        let vertices = vec![AT, AT + DVec3::X * 0.03, AT + DVec3::Y * 0.02];
        let many =
            (0..60).map(|i| AT + DVec3::new(f64::from(i) * 1e-3, f64::from(i % 7) * 1e-3, 0.0)).collect();
        vec![
            Shape::Line { from: AT, to: AT + DVec3::new(0.03, 0.01, 0.0) },
            Shape::Circle { at: AT, radius: 0.02 },
            Shape::Rectangle { at: AT, width: 0.04, height: 0.02 },
            Shape::Triangle { at: AT, size: 0.03 },
            Shape::Polygon { at: AT, radius: 0.02, sides: 5 },
            Shape::Path { vertices, closed: true },
            Shape::Path { vertices: many, closed: false },
            Shape::Text { text: "HIT".to_owned(), at: AT, height: 0.02 },
        ]
    }

    /// Of every kind, turned and tilted.
    fn targets() -> Vec<Target> {
        let target = |shape: Shape| {
            let is_free = matches!(shape, Shape::Line { .. } | Shape::Path { .. });
            let normal = if is_free { DVec3::Z } else { DVec3::new(0.0, -0.6, 0.8) };
            Target { angle: 0.4, normal, ..Target::new(shape) }
        };
        shapes().into_iter().map(target).collect()
    }

    #[test]
    fn a_handle_that_is_not_moved_changes_nothing_and_a_pulled_one_goes_where_it_is_pulled() {
        for target in targets() {
            for (index, &place) in handles(&target).iter().enumerate() {
                let same = handles(&pulled(&target, index, place));
                assert!(same.iter().zip(handles(&target)).all(|(a, b)| a.distance(b) < 1e-12), "{target:?}");
                // Outwards, which is possible for every handle.
                let there = outline::centre(&target.shape) + (place - outline::centre(&target.shape)) * 1.5;
                let after = handles(&pulled(&target, index, there));
                assert!(after[index].distance(there) < 1e-9, "{target:?}: {} {there}", after[index]);
            }
        }
    }

    #[test]
    fn a_rectangle_keeps_its_opposite_corner_and_a_line_its_other_end() {
        let [line, _, rectangle, ..] = &targets()[..] else { panic!("eight") };
        let to = AT + DVec3::new(-0.05, 0.04, 0.0);
        let corners = (handles(rectangle), handles(&pulled(rectangle, 2, to)));
        let is_kept = |place: DVec3| corners.1.iter().any(|corner| corner.distance(place) < 1e-12);
        assert!(is_kept(corners.0[0]));
        let ends = (handles(line), handles(&pulled(line, 1, to)));
        assert!(ends.0[0].distance(ends.1[0]) < 1e-12 && ends.1[1].distance(to) < 1e-12);
    }

    #[test]
    fn nothing_is_pulled_to_nothing() {
        for target in targets() {
            for index in 0..handles(&target).len() {
                for to in [outline::centre(&target.shape), handles(&target)[0]] {
                    let scene = crate::scene::Scene {
                        targets: vec![pulled(&target, index, to)],
                        ..Default::default()
                    };
                    let is_whole = crate::scene::check::check(&scene);
                    assert!(is_whole.is_ok(), "{target:?}: {is_whole:?}");
                }
            }
        }
    }
}
