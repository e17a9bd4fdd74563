//! Overlays of the map: the array, outlines of targets, focal points and the current gesture.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Visuals, vec2};
use glam::{DVec2, DVec3};

use crate::scene::{Sampling, font, outline};
use crate::ui::gesture::{self, Gesture};
use crate::ui::measure::{self, ProfileLine};
use crate::ui::parts::survey::Extremes;
use crate::ui::tool::Tool;
use crate::ui::view::{Cut, Lens};
use crate::ui::{
    array, dimensions, edit, editor::Editor, handle, palm, shown::Shown, sound::Sound, theme, ticks,
    transform,
};

/// m: foci farther than this from the cut are drawn faint.
const NEAR: f64 = 2e-3;
/// Distance from a focus within which its pressure is shown, in points.
const ASKS: f32 = 8.0;

pub fn paint(editor: &Editor, shown: &Shown, painter: &Painter, lens: &Lens, pointer: Option<Pos2>) {
    if editor.view.palm && editor.view.cut == Cut::Xy {
        for (at, size) in palm::paint(DVec2::ZERO, painter, lens) {
            chip(painter, at, Align2::CENTER_CENTER, &format!("{size:.0} mm"), 11.0, theme::MARK);
        }
    }
    array::paint(editor, shown, painter, lens);
    let scene = editor.scene();
    let axes = editor.view.axes(scene);
    for (index, target) in scene.targets.iter().enumerate() {
        let chosen = editor.selection.contains(&index);
        if !target.visible && !chosen {
            continue;
        }
        // Outlines of marked separate foci are faint.
        let is_continuous = target.sampling == Sampling::Continuous || target.is_area();
        let (width, alpha) = match is_continuous {
            // The lines of a caustic are those of the drawing.
            true if editor.view.quantity.declaration().of_light => (0.8, 70),
            true => (1.8, 190),
            false => (1.0, 110),
        };
        let colour = if chosen { theme::CHOSEN } else { theme::line(editor.view.is_light, alpha) };
        for stroke in edit::outline_on(target, &axes) {
            let points: Vec<_> = stroke.into_iter().map(|uv| lens.screen(uv)).collect();
            if let [only] = points[..] {
                if chosen {
                    painter.circle_stroke(only, 10.0, Stroke::new(2.0, theme::CHOSEN));
                }
                continue;
            }
            if chosen {
                painter.add(Shape::line(points.clone(), Stroke::new(4.0, theme::MARK_EDGE)));
            } else if editor.view.is_light {
                // Loud regions are as dark as the line.
                let halo = theme::line(false, alpha);
                painter.add(Shape::line(points.clone(), Stroke::new(width + 1.6, halo)));
            }
            painter.add(Shape::line(points, Stroke::new(if chosen { 2.0 } else { width }, colour)));
        }
    }
    if let Some(sound) = &shown.sound {
        foci(editor, sound, painter, lens, pointer);
    }
    if let Some((Some(found), _)) = editor.parts.survey.exact() {
        extremes(editor, found, painter, lens);
    }
    if let (1, Some(&index)) = (editor.selection.len(), editor.selection.first())
        && let Some(target) = scene.targets.get(index)
    {
        handle::paint(target, &axes, painter, lens);
    }
    transform::paint(editor, &axes, painter, lens);
}

fn foci(editor: &Editor, sound: &Sound, painter: &Painter, lens: &Lens, pointer: Option<Pos2>) {
    let axes = editor.view.axes(editor.scene());
    // A stroke is drawn as its line.
    let separate = sound.foci.iter().zip(&sound.readings).filter(|(focus, _)| focus.is_placed());
    let most = separate.clone().map(|(focus, _)| focus.target).fold(0.0, f64::max);
    let few = separate.clone().count() <= 12;
    for (focus, reading) in separate {
        let at = lens.screen(axes.flat(focus.position));
        let height = axes.height(focus.position);
        let asked = pointer.is_some_and(|pointer| pointer.distance(at) < ASKS);
        // A ring around the focus, which stays visible.
        let radius =
            if few { 4.0 } else { 1.5 } + 2.0 * (focus.target / most.max(f64::MIN_POSITIVE)).sqrt() as f32;
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
        painter.circle_stroke(at, radius, Stroke::new(3.0, theme::MARK_EDGE));
        painter.circle_stroke(at, radius, Stroke::new(1.3, theme::MARK));
        if asked || (few && !editor.selection.is_empty() && is_of_selection(editor, focus.position)) {
            let text = editor.view.convention.pressure(reading.peak());
            chip(painter, at + vec2(12.0, -12.0), Align2::LEFT_BOTTOM, &text, 12.0, theme::MARK);
        }
    }
}

/// Distance of a focus from the plane, for its marker.
fn off_plane(height: f64) -> String {
    let side = if height > 0.0 { "in front" } else { "behind" };
    format!("{} mm {side}", measure::mm(height.abs()))
}

fn is_of_selection(editor: &Editor, at: DVec3) -> bool {
    let is_there = |index: &usize| {
        let target = editor.scene().targets.get(*index);
        target.is_some_and(|it| it.shape.is_point() && it.shape.centre().distance(at) < 1e-9)
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
        let rect = chip(painter, below, Align2::CENTER_TOP, &format!("{text}|"), 13.0, theme::CHOSEN);
        if !typing.lacking.is_empty() {
            let words = font::lacks(&typing.lacking);
            let below = rect.center_bottom() + vec2(0.0, 8.0);
            chip(painter, below, Align2::CENTER_TOP, &words, 13.0, theme::error(&Visuals::dark()));
        }
    }
}

/// The maximum and the peak side lobe, with their pressures.
fn extremes(editor: &Editor, found: &Extremes, painter: &Painter, lens: &Lens) {
    let axes = editor.view.axes(editor.scene());
    let tell = |pressure: f64| editor.view.convention.pressure(pressure);
    let below = |pressure: f64| {
        let peak = found.peak.map_or(pressure, |(_, peak)| peak);
        {
            let level = ticks::signed(&format!("{:.1} dB", 20.0 * (pressure / peak).log10()));
            format!("side lobe {}, {level}", tell(pressure))
        }
    };
    let peak = found.peak.map(|(at, pressure)| (at, format!("peak {}", tell(pressure))));
    let side_lobe = found.side_lobe.map(|(at, pressure)| (at, below(pressure)));
    for (at, text) in peak.into_iter().chain(side_lobe) {
        let at = lens.screen(axes.flat(at));
        for (width, colour) in [(3.5, theme::MARK_EDGE), (1.4, theme::MARK)] {
            let stroke = Stroke::new(width, colour);
            painter.line_segment([at - vec2(6.0, 6.0), at + vec2(6.0, 6.0)], stroke);
            painter.line_segment([at - vec2(6.0, -6.0), at + vec2(6.0, -6.0)], stroke);
        }
        chip(painter, at + vec2(0.0, 14.0), Align2::CENTER_TOP, &text, 12.0, theme::MARK);
    }
}

/// The line of the profile.
pub fn line(editor: &Editor, painter: &Painter, lens: &Lens) {
    let screen = [lens.rect.left_bottom(), lens.rect.right_top()].map(|at| lens.flat(at).x);
    let ends = editor.view.line.ends(screen);
    let [from, to] = ends.map(|end| lens.screen(end));
    painter.line_segment([from, to], Stroke::new(3.0, Color32::from_black_alpha(110)));
    painter.line_segment([from, to], Stroke::new(1.2, theme::CHOSEN.gamma_multiply(0.8)));
    if let ProfileLine::Between(_) = editor.view.line {
        [from, to].into_iter().for_each(|end| handle::square(end, painter));
        if editor.gesture.is_none() {
            let at = from.lerp(to, 0.5) + vec2(0.0, -10.0);
            chip(painter, at, Align2::CENTER_BOTTOM, &measure::length_and_angle(ends), 12.0, theme::MARK);
        }
    }
}

/// Dimensions of the target being drawn or resized, in mm, beside the pointer.
pub fn dimensions(editor: &Editor, painter: &Painter, lens: &Lens) {
    let (Some(gesture), Some(at)) = (&editor.gesture, painter.ctx().pointer_interact_pos()) else { return };
    let axes = editor.view.axes(editor.scene());
    let of = |index: &usize| editor.scene().targets.get(*index).map(|it| dimensions::of(it, &axes));
    let text = match gesture {
        Gesture::Draw { index, .. } => index.as_ref().and_then(of),
        Gesture::Stroke { points, index } => {
            let closes = gesture::closes(points, lens);
            index.as_ref().and_then(of).map(|text| if closes { format!("{text}, closed") } else { text })
        }
        Gesture::Pull { index, .. } => of(index),
        Gesture::Move { before, .. } => before.first().map(|(index, _)| index).and_then(|index| {
            let at = axes.flat(outline::centre(&editor.scene().targets.get(*index)?.shape));
            Some(format!("{}, {} mm", measure::mm(at.x), measure::mm(at.y)))
        }),
        Gesture::Transform { before, .. } => match &before[..] {
            [(index, _)] => of(index),
            _ => {
                edit::bounds(before.iter().filter_map(|(index, _)| editor.scene().targets.get(*index)), &axes)
                    .map(|[low, high]| {
                        format!("{} × {} mm", measure::mm(high.x - low.x), measure::mm(high.y - low.y))
                    })
            }
        },
        Gesture::Body { index, .. } => editor.scene().bodies.get(*index).map(|body| {
            let at = axes.flat(body.at);
            format!("{}, {} mm", measure::mm(at.x), measure::mm(at.y))
        }),
        Gesture::Measure { .. } => match editor.view.line {
            ProfileLine::Between(ends) => Some(measure::length_and_angle(ends)),
            ProfileLine::Across(_) => None,
        },
        Gesture::Pan
        | Gesture::Way(_)
        | Gesture::Band { .. }
        | Gesture::Brush { .. }
        | Gesture::Bend { .. }
        | Gesture::Erase { .. } => None,
    };
    if let Some(text) = text {
        chip(painter, at + vec2(16.0, 16.0), Align2::LEFT_TOP, &text, 12.0, theme::MARK);
    }
}

/// Outline of brush or eraser.
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
