//! The selection box: its corners scale the selection, and the handle above it rotates it.

use egui::{Painter, Pos2, Rect, Stroke, StrokeKind, pos2};
use glam::{DQuat, DVec2, DVec3};

use crate::scene::Target;
use crate::ui::edit;
use crate::ui::editor::Editor;
use crate::ui::gesture::Grip;
use crate::ui::handle;
use crate::ui::theme;
use crate::ui::view::{Axes, Lens};

/// Distance of the box from the selection, and of the rotation handle from the box, in points.
const AROUND: f32 = 14.0;

const ABOVE: f32 = 22.0;

/// Lower and upper corner (m) of the selection.
fn bounds(editor: &Editor, axes: &Axes) -> Option<[DVec2; 2]> {
    let targets = editor.selection.iter().filter_map(|&index| editor.scene().targets.get(index));
    edit::bounds(targets, axes)
}

fn screen([low, high]: [DVec2; 2], lens: &Lens) -> Rect {
    Rect::from_two_pos(lens.screen(low), lens.screen(high)).expand(AROUND)
}

fn corners([low, high]: [DVec2; 2]) -> [DVec2; 4] {
    [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
}

/// Corners are for multiple targets, which have no common handle.
fn has_corners(editor: &Editor) -> bool {
    editor.selection.len() > 1
}

/// Rotation has no effect on a single point or circle.
fn can_turn(editor: &Editor) -> bool {
    let mut chosen = editor.selection.iter().filter_map(|&index| editor.scene().targets.get(index));
    editor.selection.len() > 1 || chosen.any(|target| !target.shape.is_round())
}

fn turner(rect: Rect) -> Pos2 {
    pos2(rect.center().x, rect.top() - ABOVE)
}

/// Whether the pointer is inside the box.
pub fn contains(editor: &Editor, axes: &Axes, lens: &Lens, pointer: Pos2) -> bool {
    bounds(editor, axes).is_some_and(|around| screen(around, lens).contains(pointer))
}

/// The grip under the pointer.
pub fn at(editor: &Editor, axes: &Axes, lens: &Lens, pointer: Pos2) -> Option<Grip> {
    let around = bounds(editor, axes)?;
    let rect = screen(around, lens);
    if can_turn(editor) && turner(rect).distance(pointer) <= handle::REACH {
        return Some(Grip::Turn((around[0] + around[1]) / 2.0));
    }
    if !has_corners(editor) {
        return None;
    }
    let places = corners(around);
    let on_screen = [rect.left_bottom(), rect.right_bottom(), rect.right_top(), rect.left_top()];
    let hit = on_screen.iter().position(|corner| corner.distance(pointer) <= handle::REACH)?;
    Some(Grip::Corner { held: places[hit], fixed: places[(hit + 2) % 4] })
}

/// Draws the box with its handles.
pub fn paint(editor: &Editor, axes: &Axes, painter: &Painter, lens: &Lens) {
    let Some(around) = bounds(editor, axes) else { return };
    let rect = screen(around, lens);
    let line = Stroke::new(1.0, theme::CHOSEN.gamma_multiply(0.7));
    painter.rect_stroke(rect, 0.0, line, StrokeKind::Middle);
    if can_turn(editor) {
        painter.line_segment([rect.center_top(), turner(rect)], line);
        painter.circle(turner(rect), handle::HALF, theme::MARK, Stroke::new(1.5, theme::ACCENT));
    }
    if has_corners(editor) {
        for corner in [rect.left_bottom(), rect.right_bottom(), rect.right_top(), rect.left_top()] {
            handle::square(corner, painter);
        }
    }
}

/// Targets after moving a grip (m in the plane).
pub fn pulled(before: &Target, grip: Grip, axes: &Axes, from: DVec2, to: DVec2, in_steps: bool) -> Target {
    match grip {
        Grip::Corner { held, fixed } => {
            let diagonal = held - fixed;
            let along = (to - from + diagonal).dot(diagonal) / diagonal.length_squared().max(1e-30);
            scaled(before, axes, fixed, along.max(0.05))
        }
        Grip::Turn(about) => {
            let mut angle = (from - about).angle_to(to - about);
            if in_steps {
                let step = std::f64::consts::TAU / 24.0;
                angle = (angle / step).round() * step;
            }
            turned(before, axes, about, angle)
        }
    }
}

/// Scaled by a factor about a point of the plane.
fn scaled(target: &Target, axes: &Axes, about: DVec2, factor: f64) -> Target {
    let mut target = target.clone();
    let place = |at: &mut DVec3| {
        let by = (axes.flat(*at) - about) * (factor - 1.0);
        *at += axes.x * by.x + axes.y * by.y;
    };
    target.shape.scale(factor, place);
    target
}

/// Rotated (rad) in the plane about a point.
fn turned(target: &Target, axes: &Axes, about: DVec2, angle: f64) -> Target {
    let turn = DQuat::from_axis_angle(axes.x.cross(axes.y).normalize_or(DVec3::Z), angle);
    let mut turned = target.clone();
    turned.rotate(axes.world(about), turn);
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, Shape};
    use crate::ui::view::{Cut, View};

    const AT: DVec3 = DVec3::new(0.01, 0.02, 0.1);

    fn targets() -> Vec<Target> {
        let vertices = vec![AT, AT + DVec3::X * 0.03, AT + DVec3::Y * 0.02];
        let shapes = [
            Shape::Point { at: AT },
            Shape::Line { from: AT, to: AT + DVec3::new(0.03, 0.01, 0.0) },
            Shape::Rectangle { at: AT, width: 0.04, height: 0.02 },
            Shape::Path { vertices, closed: true },
            Shape::Text { text: "HI".to_owned(), at: AT, height: 0.02 },
        ];
        shapes.into_iter().map(|shape| Target { angle: 0.3, ..Target::new(shape) }).collect()
    }

    fn outline_of(target: &Target, axes: &Axes) -> Vec<DVec2> {
        edit::outline_on(target, axes).concat()
    }

    #[test]
    fn every_place_of_what_is_scaled_or_turned_goes_where_it_belongs() {
        let scene = Scene::default();
        for cut in [Cut::Xy, Cut::Xz] {
            let axes = View { cut, ..View::of(&scene) }.axes(&scene);
            let about = DVec2::new(-0.01, 0.005);
            let angle = 0.7;
            for target in targets() {
                let before = outline_of(&target, &axes);
                let after = outline_of(&turned(&target, &axes, about, angle), &axes);
                assert_eq!(before.len(), after.len());
                for (a, b) in before.iter().zip(&after) {
                    let expected = about + DVec2::from_angle(angle).rotate(*a - about);
                    assert!(b.distance(expected) < 1e-9, "{cut:?} {target:?}: {b}, not {expected}");
                }
            }
        }
        let axes = View::of(&scene).axes(&scene);
        let grip = Grip::Corner { held: DVec2::new(0.04, 0.04), fixed: DVec2::ZERO };
        for target in targets() {
            let to = DVec2::splat(0.08);
            let scaled = pulled(&target, grip, &axes, DVec2::splat(0.04), to, false);
            for (a, b) in outline_of(&target, &axes).iter().zip(outline_of(&scaled, &axes)) {
                assert!(b.distance(*a * 2.0) < 1e-9, "{target:?}: {b}, not twice {a}");
            }
        }
    }
}
