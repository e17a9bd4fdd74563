//! Two maps side by side with one range of colours, or their difference: two methods, two drives or two planes, with one pointer and
//! one zoom.

use egui::{
    Align2, Color32, ComboBox, DragValue, FontId, Mesh, Painter, Pos2, Rect, Sense, Stroke, StrokeKind, Ui,
    UiBuilder, WidgetInfo, pos2, vec2,
};
use glam::{DVec2, DVec3};
use strum::VariantArray;

use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::scene::{Method, Scene};
use crate::ui::beside::{Compare, Difference, With};
use crate::ui::canvas::{self, Canvas};
use crate::ui::icon::{self, Icon};
use crate::ui::view::{Axes, Cut, Lens, View, Window};
use crate::ui::{
    edit, editor::Editor, legend, map::Map, marks, measure, shown::Shown, sound::Sound, theme, ticks,
};

/// Zoom per point of wheel or pinch, as on the canvas.
const ZOOM_PER_POINT: f64 = 1.0 / 240.0;
/// Points of the screen that two maps need.
const NARROWEST: f32 = 420.0;
const CROSS: Color32 = Color32::from_rgba_premultiplied(150, 150, 150, 150);

/// The second map on the screen.
#[derive(Debug)]
pub struct Second {
    pub lens: Lens,
}

/// Splits the space into the canvas and the comparison map.
pub fn halves(editor: &mut Editor, ui: &mut Ui) -> (Ui, Option<Ui>) {
    if editor.compare.is_some() {
        ui.add_space(4.0);
        ui.horizontal_wrapped(|ui| {
            ui.add_space(8.0);
            settings(editor, ui);
        });
    }
    let whole = ui.available_rect_before_wrap();
    let child = |ui: &mut Ui, rect: Rect| ui.new_child(UiBuilder::new().max_rect(rect));
    let is_wide = whole.width() >= NARROWEST;
    let Some(compare) = &mut editor.compare else { return (child(ui, whole), None) };
    compare.is_split = is_wide;
    if !is_wide {
        return (child(ui, whole), None);
    }
    // Both plots are as wide: only the second has the legend at its side.
    let middle = (whole.center().x - (canvas::RIGHT - canvas::BESIDE) / 2.0).round();
    let (left, right) = whole.split_left_right_at_x(middle);
    (child(ui, left), Some(child(ui, right)))
}

fn settings(editor: &mut Editor, ui: &mut Ui) {
    let cut = editor.view.cut;
    let Some(compare) = &mut editor.compare else { return };
    ui.label("Compare with");
    for (with, name, tip) in [
        (With::Method, "Method", "The scene solved by another method"),
        (With::Levels, "Phase levels", "The drive on a board with this number of phase levels"),
        (With::Plane, "Plane", "Another plane of the same field"),
    ] {
        ui.selectable_value(&mut compare.with, with, name).on_hover_text(tip);
    }
    match compare.with {
        With::Method => {
            let combo = ComboBox::from_id_salt("second method")
                .width(170.0)
                .height(320.0)
                .selected_text(compare.method.title());
            let response = combo.show_ui(ui, |ui| {
                for &method in Method::VARIANTS {
                    ui.selectable_value(&mut compare.method, method, method.title());
                }
            });
            response
                .response
                .on_hover_text("The method of the map at the right")
                .accessible_name("Second method");
        }
        With::Levels => {
            let field = DragValue::new(&mut compare.levels).range(2..=4096).speed(0.1).suffix(" levels");
            ui.add(field).on_hover_text("Phases per period").accessible_name("Second levels");
        }
        With::Plane => {
            for other in [Cut::Xy, Cut::Xz, Cut::Yz, Cut::Own].into_iter().filter(|other| *other != cut) {
                let chosen = compare.cut == other;
                let label = ui.selectable_label(chosen, format!("Beside: {}", other.into_str()));
                if label.on_hover_text(other.tooltip()).clicked() {
                    (compare.cut, compare.centre) = (other, None);
                }
            }
        }
    }
    if !compare.is_split {
        ui.label("Two maps need a wider window.");
    }
    if compare.with != With::Plane {
        ui.toggle_value(&mut compare.difference, "Difference")
            .on_hover_text("The left map minus the right one, about zero");
    }
}

/// Pans and zooms the second map.
pub fn interact(editor: &mut Editor, first: &Canvas, ui: &mut Ui) -> Option<Second> {
    let compare = editor.compare.clone()?;
    let outer = ui.available_rect_before_wrap();
    let min = pos2(outer.left() + canvas::LEFT, first.lens.rect.top()).round();
    let rect = Rect::from_min_size(min, first.lens.rect.size());
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Canvas, true, "Second map"));
    let lens = second_lens(editor, &compare, &first.lens, rect);
    let mut window = lens.window;
    if let Some(at) = response.hover_pos() {
        let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = f64::from(pinch) * (f64::from(wheel) * ZOOM_PER_POINT).exp();
        if factor != 1.0 {
            window = lens.zoomed(at, factor);
        }
    }
    if response.dragged() {
        window = lens.moved(response.drag_delta());
    }
    if response.double_clicked() {
        editor.fit();
        editor.compare.iter_mut().for_each(|compare| compare.centre = None);
    } else if window != lens.window {
        link(editor, &compare, &first.lens, window);
    }
    let view = compare.view(&editor.view);
    let own = editor.lens(first.lens.rect, false);
    let compare = editor.compare.clone()?;
    let lens = second_lens(editor, &compare, &own, rect);
    let world = |view: &View, scene: &Scene, lens: &Lens, at: Pos2| view.axes(scene).world(lens.flat(at));
    let pointer = match (first.hover(), response.hover_pos()) {
        (Some(at), _) => Some(world(&editor.view, editor.scene(), &first.lens, at)),
        (None, Some(at)) => Some(world(&view, editor.scene(), &lens, at)),
        (None, None) => None,
    };
    editor.compare.iter_mut().for_each(|compare| compare.pointer = pointer);
    Some(Second { lens })
}

/// The view of the second map: at the same scale, at the same position in shared coordinates.
fn second_lens(editor: &Editor, compare: &Compare, first: &Lens, rect: Rect) -> Lens {
    if compare.with != With::Plane {
        return Lens { rect, window: first.window };
    }
    let (scene, view) = (editor.scene(), compare.view(&editor.view));
    let mut centre = compare.centre.unwrap_or_else(|| view.whole(scene).0);
    if shares_across(editor, compare) {
        centre.x = first.window.centre.x;
    }
    Lens { rect, window: Window { centre, scale: first.window.scale } }
}

/// Whether both planes have the same horizontal axis.
fn shares_across(editor: &Editor, compare: &Compare) -> bool {
    let (own, other) = (editor.view.axes(editor.scene()), compare.view(&editor.view).axes(editor.scene()));
    own.x.distance(other.x) < 1e-9
}

/// Moves both windows as the second was moved.
fn link(editor: &mut Editor, compare: &Compare, first: &Lens, window: Window) {
    let mut centre = first.window.centre;
    if compare.with != With::Plane {
        centre = window.centre;
    } else if shares_across(editor, compare) {
        centre.x = window.centre.x;
    }
    editor.view.window = Some(Window { centre, scale: window.scale });
    editor.compare.iter_mut().for_each(|compare| compare.centre = Some(window.centre));
}

/// The second map, and the labels of both.
pub fn paint(editor: &Editor, shown: &Shown, ui: &Ui, first: &Canvas, second: &Second) {
    let Some(compare) = &editor.compare else { return };
    let view = compare.view(&editor.view);
    let lens = &second.lens;
    let painter = ui.painter_at(lens.rect);
    painter.rect_filled(lens.rect, 0.0, canvas::ground(&view));
    let Some(beside) = &shown.beside else { return };
    let map = beside.map.as_ref().filter(|map| map.cut == view.cut);
    let difference = beside.difference.as_ref().filter(|_| compare.is_subtracted());
    if let Some(difference) = difference {
        picture(
            &painter,
            (difference.texture.id(), difference.rect, difference.window),
            (lens, first.lens.rect),
        );
    } else if let Some(map) = map {
        canvas::paint_map(map, &painter, lens);
    }
    let is_flat = !view.is_shaded();
    if is_flat && view.marks {
        outlines(editor, beside.sound.as_ref(), &view, &painter, lens);
    }
    if is_flat {
        canvas::axes(&view, ui, lens);
    }
    match (difference, map) {
        (Some(difference), _) => balance(difference, view.is_light, ui, lens.rect),
        (None, Some(map)) => legend::paint(editor, map, ui, lens),
        (None, None) => {}
    }
    let scene = editor.scene();
    let own = if scene.drive.is_named() { "drive of a file" } else { scene.solver.method.title() };
    let [own, other] = compare.names(own, editor.levels, editor.view.cut);
    let other = if difference.is_some() { "left minus right".to_owned() } else { other };
    if is_flat && let Some(point) = compare.pointer {
        cross(
            &ui.ctx().layer_painter(ui.layer_id()).with_clip_rect(first.lens.rect),
            &first.lens,
            editor.view.axes(editor.scene()).flat(point),
        );
        cross(&painter, lens, view.axes(editor.scene()).flat(point));
    }
    let point = compare.pointer.filter(|_| is_flat);
    let read = |map: Option<&Map>, sound: Option<&Sound>, axes: Axes| {
        let point = on(&axes, point?);
        value(map?, sound?, axes.flat(point), point)
    };
    let left = read(shown.map.as_ref(), shown.sound.as_ref(), editor.view.axes(editor.scene()));
    let right = read(map, beside.sound.as_ref(), view.axes(editor.scene()));
    let of_right = match (difference, left, right) {
        (Some(difference), Some(left), Some(right)) => {
            Some(signed(editor, difference.quantity, left - right))
        }
        (Some(_), _, _) => None,
        (None, _, right) => right.map(|value| stated(editor, view.quantity, value)),
    };
    let all = ui.ctx().layer_painter(ui.layer_id());
    let left = left.map(|value| stated(editor, view.quantity, value));
    let on_left = point.map(|point| on(&editor.view.axes(editor.scene()), point));
    let clip = first.lens.rect.intersect(ui.clip_rect());
    words(&all.with_clip_rect(clip), first.lens.rect, &own, left, shown.map.as_ref(), on_left);
    let on_right = point.map(|point| on(&view.axes(editor.scene()), point));
    words(&painter, lens.rect, &other, of_right, map, on_right);
    let (text, colour) = match (&beside.problem, beside.is_pending) {
        (Some(problem), _) => (problem.clone(), theme::error(ui.visuals())),
        (None, true) => ("Being solved".to_owned(), theme::MARK),
        (None, false) => return,
    };
    let galley =
        painter.layout(text, FontId::proportional(13.0), colour, (lens.rect.width() - 24.0).max(60.0));
    let at = Align2::CENTER_CENTER.anchor_size(lens.rect.center(), galley.size());
    painter.rect_filled(at.expand2(vec2(8.0, 5.0)), 4.0, Color32::from_black_alpha(220));
    painter.galley(at.min, galley, colour);
}

/// A picture of the first map's view, at the second's position.
fn picture(
    painter: &Painter,
    (texture, rect, window): (egui::TextureId, Rect, Window),
    (lens, first): (&Lens, Rect),
) {
    let there = Lens { rect: rect.translate(lens.rect.min - first.min), window };
    let corner = |at: Pos2| lens.screen(there.flat(at));
    let place = Rect::from_two_pos(corner(there.rect.min), corner(there.rect.max));
    painter.image(texture, place, Rect::from_min_max(pos2(0.0, 1.0), pos2(1.0, 0.0)), Color32::WHITE);
}

/// Outlines at their scene positions, and foci of the displayed frame.
fn outlines(editor: &Editor, sound: Option<&Sound>, view: &View, painter: &Painter, lens: &Lens) {
    let axes = view.axes(editor.scene());
    for target in editor.scene().targets.iter().filter(|target| target.visible) {
        for stroke in edit::outline_on(target, &axes) {
            let stroke: Vec<_> = stroke.into_iter().map(|uv| lens.screen(uv)).collect();
            painter.add(egui::Shape::line(stroke, Stroke::new(1.0, theme::line(view.is_light, 110))));
        }
    }
    for focus in sound.iter().flat_map(|sound| &sound.foci).filter(|focus| focus.is_placed()) {
        let at = lens.screen(axes.flat(focus.position));
        painter.circle_stroke(at, 5.0, Stroke::new(3.0, theme::MARK_EDGE));
        painter.circle_stroke(at, 5.0, Stroke::new(1.2, theme::MARK));
    }
}

/// Where the pointer is.
fn cross(painter: &Painter, lens: &Lens, uv: DVec2) {
    let at = lens.screen(uv);
    painter.hline(lens.rect.x_range(), at.y, Stroke::new(1.0, CROSS));
    painter.vline(at.x, lens.rect.y_range(), Stroke::new(1.0, CROSS));
}

/// The point of a plane nearest to another point.
fn on(axes: &Axes, point: DVec3) -> DVec3 {
    axes.world(axes.flat(point))
}

/// A map's value at a point of its plane.
fn value(map: &Map, sound: &Sound, uv: DVec2, point: DVec3) -> Option<f64> {
    map.number(uv).or_else(|| sound.value(map, point))
}

/// An amount in words.
fn stated(editor: &Editor, quantity: Quantity, value: f64) -> String {
    match quantity {
        Quantity::Rms => editor.view.convention.pressure(value * std::f64::consts::SQRT_2),
        _ => ticks::signed(&quantity.with_unit(value)),
    }
}

/// A difference in words.
fn signed(editor: &Editor, quantity: Quantity, value: f64) -> String {
    let sign = if value < 0.0 { "−" } else { "+" };
    format!("{sign}{}", stated(editor, quantity, value.abs()))
}

/// Label of a side: its content, its value at the pointer, and its error.
fn words(
    painter: &Painter,
    rect: Rect,
    name: &str,
    value: Option<String>,
    map: Option<&Map>,
    point: Option<DVec3>,
) {
    let value = value.map_or_else(String::new, |value| format!("   {value}"));
    let corner = rect.left_top() + vec2(10.0, 8.0);
    let first = marks::chip(painter, corner, Align2::LEFT_TOP, &format!("{name}{value}"), 13.0, theme::MARK);
    if let Some(point) = point {
        let [x, y, z] = point.to_array().map(measure::mm);
        let text = format!("x {x}   y {y}   z {z} mm");
        marks::chip(
            painter,
            first.left_bottom() + vec2(0.0, 9.0),
            Align2::LEFT_TOP,
            &text,
            12.0,
            theme::MARK,
        );
    }
    if let Some(map) = map {
        let text = format!("error {:.0e} of the peak", map.error);
        let corner = rect.left_bottom() + vec2(10.0, -8.0);
        marks::chip(painter, corner, Align2::LEFT_BOTTOM, &text, 12.0, theme::MARK);
    }
}

/// The legend of a difference.
fn balance(difference: &Difference, is_light: bool, ui: &Ui, plot: Rect) {
    let (painter, ink) = (ui.painter(), ui.visuals().text_color());
    let left = plot.right() + 14.0;
    let bar = Rect::from_min_max(pos2(left, plot.top() + 36.0), pos2(left + 16.0, plot.bottom()));
    let (factor, unit) = difference.quantity.declaration().unit.scaled(difference.largest);
    let font = FontId::proportional(12.0);
    let title = format!("Difference\n{unit}");
    painter.text(pos2(left, plot.top() - 4.0), Align2::LEFT_TOP, title, font.clone(), ink);
    let table = ColourMap::Diverging.on(is_light);
    let mut mesh = Mesh::default();
    let y = |part: f32| bar.bottom() - bar.height() * part;
    for (i, [r, g, b, _]) in table.iter().enumerate() {
        let part = |i: usize| i as f32 / table.len() as f32;
        let strip = Rect::from_min_max(pos2(bar.left(), y(part(i + 1))), pos2(bar.right(), y(part(i))));
        mesh.add_colored_rect(strip, Color32::from_rgb(*r, *g, *b));
    }
    painter.add(mesh);
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.rect_stroke(bar, 0.0, edge, StrokeKind::Outside);
    for part in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        let at = pos2(bar.right(), y(0.5 + 0.5 * part));
        painter.line_segment([at, at + vec2(4.0, 0.0)], edge);
        let value = f64::from(part) * difference.largest * factor;
        let text = ticks::signed(&crate::field::figures(value));
        painter.text(at + vec2(7.0, 0.0), Align2::LEFT_CENTER, text, font.clone(), ink);
    }
}

/// The switch among the overlays.
pub fn switch(editor: &mut Editor, ui: &mut Ui) {
    let mut is_on = editor.compare.is_some();
    let tip = "Two methods, drives or planes side by side with one range of colours, or their difference";
    icon::toggle(ui, Icon::Compare, "Compare", tip, &mut is_on);
    if is_on != editor.compare.is_some() {
        toggle(editor);
    }
}

/// Begins or ends the comparison.
pub fn toggle(editor: &mut Editor) {
    editor.compare = match editor.compare {
        Some(_) => None,
        None => Some(Compare::default()),
    };
}
