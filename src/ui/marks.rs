//! What lies over the map: the array, the targets' outlines, the focal points and the gesture under way.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, vec2};
use glam::{DVec2, DVec3};

use crate::picture::sheet::pascals;
use crate::scene::Sampling;
use crate::ui::gesture::Gesture;
use crate::ui::tool::Tool;
use crate::ui::view::{Cut, Lens, array_size};
use crate::ui::{Editor, Shown, Sound, edit, handle, theme};

/// m: foci farther than this from the cut are drawn faint.
const NEAR: f64 = 2e-3;
/// Points of the screen around a focus in which the pointer asks for its pressure.
const ASKS: f32 = 8.0;

pub fn paint(editor: &Editor, shown: &Shown, painter: &Painter, lens: &Lens, pointer: Option<Pos2>) {
    array(editor, painter, lens);
    let scene = editor.scene();
    let axes = editor.view.axes(scene);
    for (index, target) in scene.targets.iter().enumerate() {
        let chosen = editor.selection.contains(&index);
        if !target.visible && !chosen {
            continue;
        }
        // Where separate foci are marked, their outline stays behind.
        let is_continuous = target.sampling == Sampling::Continuous || target.is_area();
        let (width, alpha) = if is_continuous { (1.8, 190) } else { (1.0, 110) };
        let colour = if chosen { theme::CHOSEN } else { Color32::from_white_alpha(alpha) };
        for stroke in edit::outline_on(target, &axes) {
            let points: Vec<_> = stroke.into_iter().map(|uv| lens.screen(uv)).collect();
            if let [only] = points[..] {
                if chosen {
                    painter.circle_stroke(only, 9.0, Stroke::new(2.0, theme::CHOSEN));
                }
                continue;
            }
            if chosen {
                painter.add(Shape::line(points.clone(), Stroke::new(4.0, theme::MARK_EDGE)));
            }
            painter.add(Shape::line(points, Stroke::new(if chosen { 2.0 } else { width }, colour)));
        }
        if chosen {
            frame(editor, painter, lens, index);
        }
    }
    if let Some(sound) = &shown.sound {
        foci(editor, sound, painter, lens, pointer);
    }
    if let (1, Some(&index)) = (editor.selection.len(), editor.selection.first())
        && let Some(target) = scene.targets.get(index)
    {
        handle::paint(target, &axes, painter, lens);
    }
}

/// A box around a chosen target, so that it is seen on any map.
fn frame(editor: &Editor, painter: &Painter, lens: &Lens, index: usize) {
    let axes = editor.view.axes(editor.scene());
    let outline = edit::outline_on(&editor.scene().targets[index], &axes).concat();
    let corner = |pick: fn(DVec2, DVec2) -> DVec2| outline.iter().copied().reduce(pick);
    let (Some(low), Some(high)) = (corner(DVec2::min), corner(DVec2::max)) else { return };
    let rect = Rect::from_two_pos(lens.screen(low), lens.screen(high)).expand(14.0);
    painter.rect_stroke(rect, 3.0, Stroke::new(1.0, theme::CHOSEN.gamma_multiply(0.7)), StrokeKind::Middle);
}

/// The outline of the array, or its edge where the cut stands upright.
fn array(editor: &Editor, painter: &Painter, lens: &Lens) {
    let scene = editor.scene();
    let axes = editor.view.axes(scene);
    let half = (array_size(&scene.array) / 2.0).extend(0.0);
    let corner = |x: f64, y: f64| lens.screen(axes.flat(half * DVec3::new(x, y, 0.0)));
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    // Seen edge on, it is a bar.
    let is_upright = axes.x.cross(axes.y).z.abs() < 1e-3;
    let stroke = if !is_upright {
        Stroke::new(1.0, Color32::from_white_alpha(70))
    } else {
        Stroke::new(4.0, Color32::from_rgb(150, 160, 175))
    };
    let closed: Vec<_> = corners.into_iter().chain([corners[0]]).collect();
    if !is_upright {
        painter.extend(Shape::dashed_line(&closed, stroke, 6.0, 4.0));
    } else {
        painter.add(Shape::line(closed, stroke));
    }
}

fn foci(editor: &Editor, sound: &Sound, painter: &Painter, lens: &Lens, pointer: Option<Pos2>) {
    let axes = editor.view.axes(editor.scene());
    // A stroke is seen as the line that it is.
    let separate = sound.foci.iter().zip(&sound.readings).filter(|(focus, _)| focus.is_separate());
    let most = separate.clone().map(|(focus, _)| focus.target).fold(0.0, f64::max);
    let few = separate.clone().count() <= 12;
    for (focus, reading) in separate {
        let at = lens.screen(axes.flat(focus.position));
        let height = axes.height(focus.position);
        let asked = pointer.is_some_and(|pointer| pointer.distance(at) < ASKS);
        let radius =
            if few { 2.0 } else { 1.0 } + 2.0 * (focus.target / most.max(f64::MIN_POSITIVE)).sqrt() as f32;
        if height.abs() > NEAR {
            painter.circle_stroke(at, radius + 0.7, Stroke::new(2.4, Color32::from_black_alpha(80)));
            painter.circle_stroke(at, radius, Stroke::new(1.0, Color32::from_white_alpha(150)));
            if asked || (few && editor.view.cut == Cut::Free) {
                chip(
                    painter,
                    at + vec2(8.0, -8.0),
                    Align2::LEFT_BOTTOM,
                    &off_plane(height),
                    11.0,
                    theme::MARK,
                );
            }
            continue;
        }
        painter.circle_filled(at, radius + 1.5, theme::MARK_EDGE);
        painter.circle_filled(at, radius, theme::MARK);
        if asked || (few && !editor.selection.is_empty() && is_of_selection(editor, focus.position)) {
            let text = format!("{} RMS", pascals(reading.rms()));
            chip(painter, at + vec2(12.0, -12.0), Align2::LEFT_BOTTOM, &text, 12.0, theme::MARK);
        }
    }
}

/// How far from the plane a focus is whose place is marked on it.
fn off_plane(height: f64) -> String {
    let side = if height > 0.0 { "in front" } else { "behind" };
    format!("{:.1} mm {side}", height.abs() * 1e3)
}

fn is_of_selection(editor: &Editor, at: DVec3) -> bool {
    let is_there = |index: &usize| {
        editor.scene().targets.get(*index).is_some_and(
            |target| matches!(target.shape, crate::scene::Shape::Point { at: own } if own.distance(at) < 1e-9),
        )
    };
    editor.selection.iter().any(is_there)
}

/// The rubber band, and the cursor of a text.
pub fn gesture(editor: &Editor, painter: &Painter, lens: &Lens) {
    if let Some(Gesture::Band { from, .. }) = &editor.gesture
        && let Some(to) = painter.ctx().pointer_interact_pos()
    {
        let rect = Rect::from_two_pos(lens.screen(*from), to);
        painter.rect(
            rect,
            0.0,
            theme::CHOSEN.gamma_multiply(0.15),
            Stroke::new(1.0, theme::CHOSEN),
            StrokeKind::Middle,
        );
    }
    if let Some(typing) = &editor.typing {
        let at = lens.screen(typing.at);
        let text =
            if typing.text.is_empty() { "Type, then press Enter".to_owned() } else { typing.text.clone() };
        let below = at + vec2(0.0, (0.028 / lens.window.scale) as f32);
        chip(painter, below, Align2::CENTER_TOP, &format!("{text}|"), 13.0, theme::CHOSEN);
    }
}

/// How wide the brush and the eraser are.
pub fn brush(editor: &Editor, painter: &Painter, lens: &Lens, at: Pos2) {
    if matches!(editor.tool, Tool::Brush | Tool::Erase) {
        let radius = (editor.brush.diameter / 2.0 / lens.window.scale) as f32;
        painter.circle_stroke(at, radius, Stroke::new(3.0, theme::MARK_EDGE));
        painter.circle_stroke(at, radius, Stroke::new(1.2, Color32::WHITE));
    }
}

/// A text on a dark ground.
pub fn chip(painter: &Painter, at: Pos2, align: Align2, text: &str, size: f32, colour: Color32) -> Rect {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(size), colour);
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand2(vec2(6.0, 3.0)), 4.0, Color32::from_black_alpha(200));
    painter.galley(rect.min, galley, colour);
    rect
}
