//! The dimensions of a target, shown beside the pointer while it is drawn or resized.

use crate::scene::Target;
use crate::ui::edit;
use crate::ui::measure::{length_and_angle, mm};
use crate::ui::view::Axes;

/// Size of a target in mm, or position of a point on the plane.
pub fn of(target: &Target, axes: &Axes) -> String {
    if let Some(size) = target.shape.size(mm) {
        return size.replace(" x ", " × ");
    }
    let strokes = edit::outline_on(target, axes);
    match strokes.concat()[..] {
        [at] => format!("{}, {} mm", mm(at.x), mm(at.y)),
        [from, to] if target.shape.is_line() => format!("length {}", length_and_angle([from, to])),
        _ => {
            let piece = |pair: &[_]| -> f64 { glam::DVec2::distance(pair[0], pair[1]) };
            let length: f64 = strokes.iter().flat_map(|stroke| stroke.windows(2).map(piece)).sum();
            format!("length {} mm", mm(length))
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::scene::{Scene, Shape};
    use crate::ui::tool::Tool;
    use crate::ui::view::View;

    #[test]
    fn what_is_drawn_has_its_size_in_words() {
        let axes = View::of(&Scene::default()).axes(&Scene::default());
        let drawn = |tool: Tool| of(&tool.drag(&axes, DVec2::ZERO, DVec2::new(0.04, 0.02)).unwrap(), &axes);
        assert_eq!(drawn(Tool::Rectangle), "40.0 × 20.0 mm");
        assert_eq!(drawn(Tool::Circle), "Ø 89.4 mm");
        assert_eq!(drawn(Tool::Line), "length 44.7 mm, 26.6°");
        let point = Target::new(Shape::Point { at: DVec3::new(-1e-7, 0.012, 0.1) });
        assert_eq!(of(&point, &axes), "0.0, 12.0 mm");
    }
}
