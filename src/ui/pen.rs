//! The pen: a path of corners and curves, knot by knot, until it is ended or closed.

use egui::{Context, Key, Painter, Pos2, Stroke};
use glam::DVec2;

use crate::import::curve::{Knot, flattened};
use crate::ui::gesture::Pen;
use crate::ui::tool::Tool;
use crate::ui::view::{Axes, Lens};
use crate::ui::{edit, editor::Editor, handle, theme, tool};

/// Pick distance of the first and the last knot in points.
const REACH: f32 = 8.0;
/// Shortest handle in points: a click that trembles makes a corner.
const SHORTEST: f64 = 4.0;
/// Largest deviation of the vertices from the curve, m.
const TOLERANCE: f64 = 2e-4;

/// Acts on a press: closes the path on its first knot, ends it on its last one, and adds a knot elsewhere, which the
/// pointer holds. Returns whether it was added.
pub fn press(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2, uv: DVec2) -> bool {
    let mut pen = editor.pen.take().unwrap_or_default();
    let is_near = |knot: &Knot| lens.screen(knot.at).distance(at) <= REACH;
    match &pen.knots[..] {
        [first, _, _, ..] if is_near(first) => {
            draw(editor, &mut pen, axes, true);
            return false;
        }
        [.., last] if is_near(last) => return false,
        _ => {}
    }
    pen.knots.push(Knot { at: uv, handle: DVec2::ZERO });
    draw(editor, &mut pen, axes, false);
    editor.pen = Some(pen);
    editor.show_target();
    true
}

/// The place nearest to `to` in a direction of steps of 15° from the last knot.
pub fn straight(editor: &Editor, to: DVec2) -> DVec2 {
    let last = editor.pen.as_ref().and_then(|pen| pen.knots.last());
    last.map_or(to, |last| Tool::Line.straight(last.at, to))
}

/// Gives the last knot a handle (m).
pub fn bend(editor: &mut Editor, axes: &Axes, lens: &Lens, handle: DVec2) {
    let Some(mut pen) = editor.pen.take() else { return };
    if let Some(knot) = pen.knots.last_mut() {
        let is_long = handle.length() >= SHORTEST * lens.window.scale;
        knot.handle = if is_long { handle } else { DVec2::ZERO };
    }
    draw(editor, &mut pen, axes, false);
    editor.pen = Some(pen);
}

/// Ends the path as it is.
pub fn end(editor: &mut Editor) {
    editor.pen = None;
}

/// Acts on the keys of a path being drawn; Enter ends it unless it draws at the keyboard's cross. Returns whether
/// there was one.
pub fn keys(editor: &mut Editor, ctx: &Context, ends_by_enter: bool) -> bool {
    if editor.pen.is_none() {
        return false;
    }
    let pressed = |key: Key| ctx.input(|input| input.key_pressed(key));
    if pressed(Key::Escape) || (pressed(Key::Enter) && ends_by_enter) {
        end(editor);
        return true;
    }
    if pressed(Key::Backspace) || pressed(Key::Delete) {
        take_back(editor);
        return true;
    }
    false
}

/// Removes the last knot.
fn take_back(editor: &mut Editor) {
    let Some(mut pen) = editor.pen.take() else { return };
    pen.knots.pop();
    let axes = editor.view.axes(editor.scene());
    draw(editor, &mut pen, &axes, false);
    editor.pen = (!pen.knots.is_empty()).then_some(pen);
}

/// Puts the path into the scene; a single knot is none.
fn draw(editor: &mut Editor, pen: &mut Pen, axes: &Axes, closed: bool) {
    let points = flattened(&pen.knots, closed, TOLERANCE);
    if pen.knots.len() > 1 {
        editor.put(&mut pen.index, tool::path(axes, &points, closed));
    } else if let Some(index) = pen.index.take() {
        edit::delete(&mut editor.document.scene, &mut [index].into());
        editor.selection.clear();
    }
}

/// Draws the knots with the last handle, and the piece that a click at the pointer would add.
pub fn paint(editor: &Editor, painter: &Painter, lens: &Lens, pointer: Option<Pos2>) {
    let Some(pen) = &editor.pen else { return };
    let Some(last) = pen.knots.last() else { return };
    let line = Stroke::new(1.2, theme::CHOSEN.gamma_multiply(0.8));
    if let (Some(to), None) = (pointer, &editor.gesture) {
        let next = Knot { at: lens.flat(to), handle: DVec2::ZERO };
        let piece = flattened(&[*last, next], false, TOLERANCE).into_iter().map(|uv| lens.screen(uv));
        painter.add(egui::Shape::line(piece.collect(), line));
    }
    if last.handle != DVec2::ZERO {
        let ends = [last.at - last.handle, last.at + last.handle].map(|uv| lens.screen(uv));
        painter.line_segment(ends, line);
        for end in ends {
            painter.circle_filled(end, 3.0, theme::CHOSEN);
        }
    }
    pen.knots.iter().for_each(|knot| handle::square(lens.screen(knot.at), painter));
}
