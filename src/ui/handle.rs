//! Handles of shapes on the map.

use egui::{Painter, Pos2, Rect, Stroke, StrokeKind, vec2};
use glam::DVec3;

use crate::scene::Target;
use crate::ui::theme;
use crate::ui::view::{Axes, Lens};

/// Half a handle's side, and pick distance, in points.
pub const HALF: f32 = 4.0;
pub const REACH: f32 = 9.0;

/// The handle under the pointer.
pub fn at(target: &Target, axes: &Axes, lens: &Lens, pointer: Pos2) -> Option<usize> {
    let distance = |place: &DVec3| lens.screen(axes.flat(*place)).distance(pointer);
    let places = target.handles();
    let nearest = (0..places.len()).min_by(|&a, &b| distance(&places[a]).total_cmp(&distance(&places[b])))?;
    (distance(&places[nearest]) <= REACH).then_some(nearest)
}

pub fn paint(target: &Target, axes: &Axes, painter: &Painter, lens: &Lens) {
    for place in target.handles() {
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
    use crate::scene::{Shape, outline};

    fn handles(target: &Target) -> Vec<DVec3> {
        target.handles()
    }

    fn pulled(target: &Target, handle: usize, to: DVec3) -> Target {
        let mut pulled = target.clone();
        pulled.pull(handle, to);
        pulled
    }

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
            Shape::Direction { direction: DVec3::new(0.1, -0.2, 2.0) },
        ]
    }

    /// Targets of every kind, turned and tilted.
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
