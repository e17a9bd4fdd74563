//! Painting of the 3D view: picture, names of axes, handles, colour bar and notes.

use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, pos2, vec2};
use glam::DVec3;

use crate::field::Quantity;
use crate::picture::figure::axes;
use crate::studio::space as labels;
use crate::ui::parts::flight;
use crate::ui::space::act::chosen;
use crate::ui::space::handle::{self, ARROW, AXES};
use crate::ui::space::view::Handle;
use crate::ui::space::{Seen, SpaceShown, Stage};
use crate::ui::{canvas, editor::Editor, marks, measure, shown::Shown, theme, ticks};

const COLOURS: [Color32; 3] =
    [Color32::from_rgb(240, 88, 78), Color32::from_rgb(96, 200, 96), Color32::from_rgb(84, 150, 255)];
/// Points of the screen.
const ARROW_WIDTH: f32 = 2.4;
const HEAD: f32 = 9.0;
const KNOB: f32 = 5.5;
const BAR: f32 = 16.0;
/// What the field in the box lacks while it is a preview.
const LACKING: &str = "   without what bodies scatter, except on them";

pub fn paint(editor: &Editor, shown: &Shown, ui: &Ui, stage: &Stage) {
    let painter = ui.painter_at(stage.rect);
    match &shown.space {
        Some(picture) => {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(picture.texture.id(), stage.rect, whole, Color32::WHITE);
        }
        None => {
            painter.rect_filled(stage.rect, 0.0, theme::ground(editor.view.is_light));
        }
    }
    let outline = Stroke::new(1.0, ui.visuals().weak_text_color());
    ui.painter().rect_stroke(stage.rect, 0.0, outline, StrokeKind::Outside);
    axes(editor, &painter, stage);
    knobs(editor, &painter, stage);
    if let Some(point) = chosen(editor) {
        outlines(editor, &painter, stage);
        arrows(&painter, stage, point);
        if stage.is_moving {
            let [x, y, z] = point.to_array().map(measure::mm);
            let at = stage.screen(point).unwrap_or(stage.rect.center()) + vec2(16.0, -16.0);
            let text = format!("x {x}   y {y}   z {z} mm");
            marks::chip(&painter, at, Align2::LEFT_BOTTOM, &text, 12.0, theme::MARK);
        }
    }
    flight::paint(&editor.parts.flight, &painter, |at| stage.screen(at));
    if let Some(picture) = &shown.space {
        describe(editor, picture, &painter, stage);
        bar(editor, picture, ui, stage);
    }
    canvas::words(editor, shown, &painter, stage.rect, stage.rect.top());
}

/// Names and ends of the box's axes.
fn axes(editor: &Editor, painter: &Painter, stage: &Stage) {
    let font = FontId::proportional(12.0);
    let ink = theme::line(editor.view.is_light, 190);
    let ground = theme::ground(editor.view.is_light).gamma_multiply(0.7);
    for label in labels::labels(&stage.block, &stage.projection(), 1.0) {
        let at = stage.rect.min + vec2(label.at.x as f32, label.at.y as f32);
        // For contrast on any background.
        let galley = painter.layout_no_wrap(label.text, font.clone(), ink);
        let rect = Align2::CENTER_CENTER.anchor_size(at, galley.size());
        painter.rect_filled(rect.expand2(vec2(3.0, 0.0)), 3.0, ground);
        painter.galley(rect.min, galley, ink);
    }
}

/// The outlines of the selection.
fn outlines(editor: &Editor, painter: &Painter, stage: &Stage) {
    for &index in &editor.selection {
        let Some(target) = editor.scene().targets.get(index) else { continue };
        for stroke in crate::scene::outline::strokes(target).unwrap_or_default() {
            let line: Vec<_> = stroke.iter().filter_map(|&point| stage.screen(point)).collect();
            if let [only] = line[..] {
                painter.circle_stroke(only, 8.0, Stroke::new(2.0, theme::CHOSEN));
            } else {
                painter.add(Shape::line(line, Stroke::new(1.6, theme::CHOSEN)));
            }
        }
    }
}

/// The handles of the selection: arrows along the axes, squares across them.
fn arrows(painter: &Painter, stage: &Stage, point: DVec3) {
    let per_point = stage.per_point(point);
    let Some(middle) = stage.screen(point) else { return };
    let lit = |handle: Handle, colour: Color32| {
        if stage.over == Some(handle) { Color32::from_rgb(255, 226, 110) } else { colour }
    };
    for (axis, colour) in COLOURS.into_iter().enumerate() {
        let corners: Option<Vec<Pos2>> =
            handle::square(point, axis, per_point).into_iter().map(|corner| stage.screen(corner)).collect();
        if let Some(corners) = corners {
            let colour = lit(Handle::Plane(axis), colour);
            let stroke = Stroke::new(1.2, colour);
            painter.add(Shape::convex_polygon(corners, colour.gamma_multiply(0.35), stroke));
        }
    }
    for (axis, colour) in COLOURS.into_iter().enumerate() {
        let Some(tip) = stage.screen(point + AXES[axis] * (ARROW * per_point)) else { continue };
        let way = tip - middle;
        if way.length() < 2.0 * HEAD {
            continue;
        }
        let colour = lit(Handle::Axis(axis), colour);
        let (along, aside) = (way.normalized(), way.normalized().rot90());
        let neck = tip - along * HEAD;
        painter.line_segment([middle, neck], Stroke::new(ARROW_WIDTH + 1.6, theme::MARK_EDGE));
        painter.line_segment([middle, neck], Stroke::new(ARROW_WIDTH, colour));
        let head = vec![tip, neck + aside * (HEAD * 0.45), neck - aside * (HEAD * 0.45)];
        painter.add(Shape::convex_polygon(head, colour, Stroke::new(0.6, theme::MARK_EDGE)));
    }
    painter.circle(middle, 3.2, theme::CHOSEN, Stroke::new(1.0, theme::MARK_EDGE));
}

/// The knobs of slices and of the clipping box's faces.
fn knobs(editor: &Editor, painter: &Painter, stage: &Stage) {
    for knob in handle::knobs() {
        let Some(at) = handle::knob(knob, &editor.space, &stage.clip).and_then(|point| stage.screen(point))
        else {
            continue;
        };
        let axis = match knob {
            Handle::Slice(axis) | Handle::Face(axis, _) | Handle::Axis(axis) | Handle::Plane(axis) => axis,
        };
        let is_over = stage.over == Some(knob);
        let colour = if is_over { Color32::from_rgb(255, 226, 110) } else { COLOURS[axis] };
        let edge = Stroke::new(1.5, theme::MARK_EDGE);
        match knob {
            Handle::Slice(_) => {
                let corner = |x: f32, y: f32| at + vec2(x, y) * (KNOB * 1.3);
                let diamond = vec![corner(0.0, -1.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(-1.0, 0.0)];
                painter.add(Shape::convex_polygon(diamond, colour, edge));
                if let (Some(place), true) = (editor.space.slices[axis], is_over) {
                    let text = format!("{} {} mm", ["x", "y", "z"][axis], measure::mm(place));
                    marks::chip(painter, at + vec2(12.0, 0.0), Align2::LEFT_CENTER, &text, 12.0, theme::MARK);
                }
            }
            Handle::Face(..) | Handle::Axis(_) | Handle::Plane(_) => {
                painter.circle(at, KNOB, colour, edge);
            }
        }
    }
}

/// Description of the picture.
fn describe(editor: &Editor, picture: &SpaceShown, painter: &Painter, stage: &Stage) {
    if picture.peak <= 0.0 {
        return;
    }
    let convention = editor.view.convention;
    let pressure = |rms: f64| convention.pressure(rms * std::f64::consts::SQRT_2);
    let peak = pressure(picture.peak);
    let text = match editor.space.seen {
        Seen::Surface => {
            let part = 10f64.powf(editor.space.level / 20.0);
            format!(
                "Surface at {}: {}   peak {peak}",
                ticks::signed(&format!("{:.1} dB", editor.space.level)),
                pressure(part * picture.peak)
            )
        }
        Seen::Projection => format!("Largest pressure along every line of sight   peak {peak}"),
        Seen::Slices => format!("Pressure on slices   peak {peak}"),
    };
    let text = if picture.is_incident { text + LACKING } else { text };
    let corner = stage.rect.left_top() + vec2(12.0, 9.0);
    marks::chip(painter, corner, Align2::LEFT_TOP, &text, 13.0, theme::MARK);
}

/// The colour bar, with the level of the isosurface.
fn bar(editor: &Editor, picture: &SpaceShown, ui: &Ui, stage: &Stage) {
    const TICKS: f64 = 6.0;
    let painter = ui.painter();
    let ink = ui.visuals().text_color();
    let left = stage.rect.right() + 14.0;
    let top = stage.rect.top() + 36.0;
    let rect = Rect::from_min_max(pos2(left, top), pos2(left + BAR, stage.rect.bottom()));
    let convention = editor.view.convention;
    let full = picture.peak * convention.factor(Quantity::Rms);
    let (factor, unit) = Quantity::Rms.declaration().unit.scaled(full);
    let font = FontId::proportional(12.0);
    let title = format!("{unit} {}", convention.into_str());
    painter.text(pos2(left, stage.rect.top() - 2.0), Align2::LEFT_TOP, title, font.clone(), ink);
    let table = editor.view.colours.on(editor.view.is_light);
    let mut mesh = Mesh::default();
    let y = |part: f32| rect.bottom() - rect.height() * part;
    for (i, [r, g, b, _]) in table.iter().enumerate() {
        let (low, high) = (y(i as f32 / 256.0), y((i + 1) as f32 / 256.0));
        let strip = Rect::from_min_max(pos2(rect.left(), high), pos2(rect.right(), low));
        mesh.add_colored_rect(strip, Color32::from_rgb(*r, *g, *b));
    }
    painter.add(mesh);
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.rect_stroke(rect, 0.0, edge, StrokeKind::Outside);
    let largest = (full * factor).max(f64::MIN_POSITIVE);
    for (value, label) in axes::steps(0.0, largest, TICKS) {
        let at = pos2(rect.right(), y((value / largest) as f32));
        painter.line_segment([at, at + vec2(4.0, 0.0)], edge);
        painter.text(at + vec2(7.0, 0.0), Align2::LEFT_CENTER, label, font.clone(), ink);
    }
    if editor.space.seen == Seen::Surface {
        let part = 10f64.powf(editor.space.level / 20.0) as f32;
        painter.hline(rect.expand(3.0).x_range(), y(part), Stroke::new(2.0, ink));
    }
}
