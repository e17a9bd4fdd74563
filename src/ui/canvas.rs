//! The canvas: a plane through space with its axes, the map on it, and the pointer's position.

use egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Response, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2,
};
use glam::{DVec2, DVec3};

use crate::field::{Quantity, Range};
use crate::picture::figure::axes::{self, round_step};
use crate::scene::Channel;
use crate::studio::{map, probe};
use crate::ui::parts::arrows;
use crate::ui::parts::flight;
use crate::ui::playback::Moment;
use crate::ui::tool::Tool;
use crate::ui::view::{Lens, View};
use crate::ui::{
    bodies, context, cursor, editor::Editor, gallery, guides, legend, map::Map, marks, measure, path_marks,
    pen, pointer, shown::Shown, sound::Sound, theme, ticks,
};

/// Points of the screen around the plot.
pub const LEFT: f32 = 56.0;
const BELOW: f32 = 40.0;
pub const RIGHT: f32 = 102.0;
/// The same beside another map.
pub const BESIDE: f32 = 16.0;
const ABOVE: f32 = 12.0;
/// Points of the screen between two ticks, at least.
const TICK: f64 = 70.0;
const SMALLEST: f32 = 40.0;
const STEADY: &str = "The skin does not move: steady sound is hardly felt. Add a modulation or a motion on the Felt or the Motion page.";
const ELSEWHERE: &str = "The skin does not move at the frequencies of this channel.";
const CONTOUR: Color32 = Color32::from_rgb(235, 235, 235);
const CONTOUR_EDGE: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 120);

/// The canvas on this frame.
#[derive(Debug)]
pub struct Canvas {
    pub lens: Lens,
    response: Response,
}

impl Canvas {
    /// Position of the pointer, if over it.
    pub fn hover(&self) -> Option<Pos2> {
        self.response.hover_pos()
    }
}

/// Allocates the canvas and handles pointer input.
pub fn interact(editor: &mut Editor, ui: &mut Ui) -> Canvas {
    editor.space.leave();
    let outer = ui.available_rect_before_wrap();
    let right = if editor.is_comparing() { BESIDE } else { RIGHT };
    // A relief has neither axes nor a colour bar.
    let [above, below] = match editor.view.is_shaded() {
        true => [vec2(ABOVE, ABOVE), vec2(if editor.is_comparing() { BESIDE } else { ABOVE }, ABOVE)],
        false => [vec2(LEFT, ABOVE), vec2(right, BELOW)],
    };
    let min = outer.min + above;
    let max = (outer.max - below).max(min + vec2(SMALLEST, SMALLEST));
    let rect = Rect::from_min_max(min.round(), max.round());
    let response = ui.interact(rect, cursor::id(), Sense::click_and_drag());
    ui.advance_cursor_after_rect(outer);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Canvas: the field on the plane")
    });
    let is_held = ui.input(|input| input.pointer.any_down()) || ui.ctx().text_edit_focused();
    let lens = editor.lens(rect, is_held);
    if editor.view.is_shaded() {
        pointer::watch(editor, ui, &response, &lens);
        let response = response.on_hover_cursor(egui::CursorIcon::Grab);
        return Canvas { lens: editor.lens(rect, is_held), response };
    }
    let was_typing = editor.is_typing();
    pointer::act(editor, ui, &response, &lens);
    let cursor = match editor.tool {
        Tool::Select => egui::CursorIcon::Default,
        Tool::Text => egui::CursorIcon::Text,
        Tool::Point
        | Tool::Line
        | Tool::Circle
        | Tool::Rectangle
        | Tool::Triangle
        | Tool::Polygon
        | Tool::Pen
        | Tool::Freehand
        | Tool::Brush
        | Tool::Erase
        | Tool::Measure => egui::CursorIcon::Crosshair,
    };
    // The key that ends a text must not draw.
    if !was_typing {
        cursor::act(editor, ui, &response, &lens);
    }
    context::menu(editor, &response, &lens);
    let response = response.on_hover_cursor(cursor);
    let lens = editor.lens(rect, is_held);
    if let Some(at) = response.hover_pos() {
        editor.pointed = Some(editor.view.axes(editor.scene()).world(lens.flat(at)));
    }
    Canvas { lens, response }
}

pub fn paint(editor: &Editor, shown: &Shown, ui: &Ui, canvas: &Canvas) {
    let lens = &canvas.lens;
    let painter = ui.painter_at(lens.rect);
    let map = shown.map.as_ref().filter(|map| map.cut == editor.view.cut);
    // The area fully covered by a map is not painted twice.
    if !map.is_some_and(|map| place(map, lens).expand(0.1).contains_rect(lens.rect)) {
        painter.rect_filled(lens.rect, 0.0, ground(&editor.view));
    }
    if let Some(map) = map {
        paint_map(map, &painter, lens);
    }
    if editor.view.is_shaded() {
        let notes = shaded(editor, shown, ui, &painter, lens);
        words(editor, shown, &painter, lens.rect, notes);
        return;
    }
    if editor.view.grid || editor.snaps {
        guides::grid(editor.grid, editor.view.is_light, &painter, lens);
    }
    bodies::paint(editor, &painter, lens);
    if let Some(field) = editor.parts.arrows.newest() {
        arrows::paint(field, &editor.view.axes(editor.scene()), &painter, lens);
    }
    if editor.view.marks {
        marks::paint(editor, shown, &painter, lens, canvas.response.hover_pos());
        path_marks::paint(editor, shown, &painter, lens);
    }
    let axes_of_view = editor.view.axes(editor.scene());
    flight::paint(&editor.parts.flight, &painter, |at| Some(lens.screen(axes_of_view.flat(at))));
    marks::gesture(editor, &painter, lens);
    pen::paint(editor, &painter, lens, canvas.response.hover_pos());
    if let Some(at) = canvas.response.hover_pos() {
        marks::brush(editor, &painter, lens, at);
    }
    if editor.view.section || editor.is_measuring() {
        marks::line(editor, &painter, lens);
    }
    if editor.gesture.is_some() {
        guides::paint(&editor.guides, &painter, lens);
    }
    if canvas.response.has_focus() {
        cursor::paint(editor, &painter, lens);
    }
    axes(&editor.view, ui, lens);
    if let Some(map) = shown.map.as_ref().filter(|_| !editor.is_comparing()) {
        legend::paint(editor, map, ui, lens);
    }
    words(editor, shown, &painter, lens.rect, notes_top(editor, lens));
    if let Some(at) = canvas.response.hover_pos().filter(|_| editor.dialog.is_none()) {
        if !editor.is_comparing() {
            probe(editor, shown, &painter, lens, at);
        }
        marks::dimensions(editor, &painter, lens);
    }
}

/// Behind the map.
pub fn ground(view: &View) -> Color32 {
    theme::ground(view.is_light && !view.is_shaded())
}

/// Position of a map on the screen.
fn place(map: &Map, lens: &Lens) -> Rect {
    let there = Lens { rect: map.rect, window: map.window };
    let corner = |at: Pos2| lens.screen(there.flat(at));
    Rect::from_two_pos(corner(map.rect.min), corner(map.rect.max))
}

/// The map's picture with its contour lines.
pub fn paint_map(map: &Map, painter: &Painter, lens: &Lens) {
    let place = place(map, lens);
    // Row 0 of a map is at the smallest y: the bottom.
    let upright = Rect::from_min_max(pos2(0.0, 1.0), pos2(1.0, 0.0));
    for texture in [Some(map.texture.id()), map.veil].into_iter().flatten() {
        painter.image(texture, place, upright, Color32::WHITE);
    }
    contours(map, painter, place);
}

/// Lines of equal value.
fn contours(map: &Map, painter: &Painter, place: Rect) {
    let pixel = place.size() / vec2(map.width as f32, map.height as f32);
    let at = |&[x, y]: &[f32; 2]| place.left_bottom() + vec2(x, -y) * pixel;
    for line in &map.contours {
        let line: Vec<_> = line.iter().map(at).collect();
        painter.add(egui::Shape::line(line.clone(), Stroke::new(3.0, CONTOUR_EDGE)));
        painter.add(egui::Shape::line(line, Stroke::new(1.3, CONTOUR)));
    }
}

/// Where notes begin: below the label of a compared map.
fn notes_top(editor: &Editor, lens: &Lens) -> f32 {
    lens.rect.top() + if editor.is_comparing() { 38.0 } else { 9.0 }
}

/// The note on a shaded surface, which has no axes. Returns where further notes begin.
fn shaded(editor: &Editor, shown: &Shown, ui: &Ui, painter: &Painter, lens: &Lens) -> f32 {
    let outline = Stroke::new(1.0, ui.visuals().weak_text_color());
    ui.painter().rect_stroke(lens.rect, 0.0, outline, StrokeKind::Outside);
    let top = notes_top(editor, lens);
    let Some((map, exaggeration)) = shown.map.as_ref().and_then(|map| Some((map, map.exaggeration?))) else {
        return top;
    };
    let size = editor.view.plane(editor.scene(), lens).size * 1e3;
    scale_bar(map, painter, lens);
    let text = format!(
        "{:.0} × {:.0} mm, at most {} deep, heights × {exaggeration}",
        size.x,
        size.y,
        map.quantity.at_most(map.largest)
    );
    let at = pos2(lens.rect.center().x, top);
    wrapped_chip(painter, at, lens.rect.width() - 40.0, &text, theme::MARK).bottom() + 15.0
}

/// A round depth to scale, beside a relief.
fn scale_bar(map: &Map, painter: &Painter, lens: &Lens) {
    /// Points of the screen.
    const LONGEST: f64 = 90.0;
    let longest = LONGEST / map.per_depth.max(1e-9);
    let depth = round_step(longest / 2.0);
    let length = (depth * map.per_depth) as f32;
    let foot = lens.rect.left_bottom() + vec2(26.0, -24.0);
    let head = foot - vec2(0.0, length);
    let ends = [
        (foot, head),
        (foot - vec2(4.0, 0.0), foot + vec2(4.0, 0.0)),
        (head - vec2(4.0, 0.0), head + vec2(4.0, 0.0)),
    ];
    for (width, colour) in [(4.0, Color32::from_black_alpha(200)), (1.6, Color32::WHITE)] {
        for (from, to) in ends {
            painter.line_segment([from, to], Stroke::new(width, colour));
        }
    }
    let at = foot + vec2(9.0, -length / 2.0);
    marks::chip(painter, at, Align2::LEFT_CENTER, &map.quantity.with_unit(depth), 12.0, Color32::WHITE);
}

/// The message in place of a picture, below the notes or the value under the pointer.
pub fn words(editor: &Editor, shown: &Shown, painter: &Painter, rect: Rect, notes: f32) {
    let middle = rect.center();
    if editor.scene().targets.is_empty() && !editor.is_in_gesture() {
        if gallery::is_open(editor) {
            return;
        }
        let text = "Nothing to focus on yet.\nPick a tool on the left and draw, or open an example.";
        marks::chip(painter, middle, Align2::CENTER_CENTER, text, 15.0, Color32::WHITE);
        return;
    }
    let (text, colour) = match &shown.problem {
        Some(problem) => {
            let stays = if shown.map.is_some() { " The map still shows the previous drawing." } else { "" };
            (format!("{}.{stays}", problem.trim_end_matches('.')), Color32::from_rgb(255, 170, 160))
        }
        None => match &shown.pending {
            Some(pending) => (pending.clone(), theme::MARK),
            None if is_unmoved(shown) => {
                let text = if editor.view.channel == Channel::All { STEADY } else { ELSEWHERE };
                (text.to_owned(), theme::MARK)
            }
            None => return,
        },
    };
    let at = pos2(rect.center().x, notes.max(rect.top() + 44.0));
    wrapped_chip(painter, at, rect.width() - 40.0, &text, colour);
}

fn is_unmoved(shown: &Shown) -> bool {
    // The largest value comes with the figures of the map.
    shown.map.as_ref().is_some_and(|map| !map.how.is_empty() && map::is_unmoved(map.quantity, map.largest))
}

fn wrapped_chip(painter: &Painter, top: Pos2, width: f32, text: &str, colour: Color32) -> Rect {
    let galley = painter.layout(text.to_owned(), FontId::proportional(13.5), colour, width.max(60.0));
    let rect = Align2::CENTER_TOP.anchor_size(top, galley.size());
    painter.rect_filled(rect.expand2(vec2(8.0, 5.0)), 4.0, Color32::from_black_alpha(220));
    painter.galley(rect.min, galley, colour);
    rect
}

/// Ticks in mm along the left and the lower edge.
pub fn axes(view: &View, ui: &Ui, lens: &Lens) {
    let (visuals, painter) = (ui.visuals(), ui.painter());
    let ink = visuals.text_color();
    let rect = lens.rect;
    painter.rect_stroke(rect, 0.0, Stroke::new(1.0, visuals.weak_text_color()), StrokeKind::Outside);
    let step = round_step(TICK * lens.window.scale * 1e3);
    let (low, high) = (lens.flat(rect.left_bottom()) * 1e3, lens.flat(rect.right_top()) * 1e3);
    let decimals = ticks::decimals(step).min(2);
    let font = FontId::proportional(12.0);
    let stroke = Stroke::new(1.0, visuals.weak_text_color());
    for x in ticks::between(low.x, high.x, step) {
        let at = pos2(lens.screen(DVec2::new(x * 1e-3, 0.0)).x, rect.bottom());
        painter.line_segment([at, at + vec2(0.0, 5.0)], stroke);
        painter.text(at + vec2(0.0, 6.0), Align2::CENTER_TOP, axes::number(x, decimals), font.clone(), ink);
    }
    for y in ticks::between(low.y, high.y, step) {
        let at = pos2(rect.left(), lens.screen(DVec2::new(0.0, y * 1e-3)).y);
        painter.line_segment([at, at - vec2(5.0, 0.0)], stroke);
        painter.text(at - vec2(8.0, 0.0), Align2::RIGHT_CENTER, axes::number(y, decimals), font.clone(), ink);
    }
    let (across, up) = view.cut.axes();
    painter.text(pos2(rect.center().x, rect.bottom() + 22.0), Align2::CENTER_TOP, across, font.clone(), ink);
    let galley = painter.layout_no_wrap(up.to_owned(), font, ink);
    let at = pos2(rect.left() - LEFT + 4.0, rect.center().y + galley.size().x / 2.0);
    painter.add(egui::epaint::TextShape::new(at, galley, ink).with_angle(-std::f32::consts::FRAC_PI_2));
}

/// The field under the pointer.
fn probe(editor: &Editor, shown: &Shown, painter: &Painter, lens: &Lens, at: Pos2) {
    let uv = lens.flat(at);
    let point = editor.view.axes(editor.scene()).world(uv);
    let [x, y, z] = point.to_array().map(measure::mm);
    let mut text = format!("x {x}   y {y}   z {z} mm");
    let sound = shown.sound.as_ref().filter(|sound| sound.is_at_hand());
    if let (Some(map), Some(sound)) = (&shown.map, sound) {
        text.push_str(&format!("     {}", value(editor, map, sound, uv, point)));
    }
    // Wrapped on narrow maps, between values only.
    let values = text.split("   ").map(|value| value.trim().replace(' ', "\u{a0}"));
    let text = values.filter(|value| !value.is_empty()).collect::<Vec<_>>().join("   ");
    let room = (lens.rect.width() - 24.0).max(40.0);
    let galley = painter.layout(text, FontId::proportional(13.0), theme::MARK, room);
    let rect = beside_boards(editor, shown.sound.as_ref(), lens, galley.size());
    painter.rect_filled(rect.expand2(vec2(6.0, 3.0)), 4.0, Color32::from_black_alpha(200));
    painter.galley(rect.min, galley, theme::MARK);
}

/// A place for the read-out of this size in the upper left corner, below a board that lies there.
fn beside_boards(editor: &Editor, sound: Option<&Sound>, lens: &Lens, size: Vec2) -> Rect {
    /// Points of the screen from one place tried to the next.
    const STEP: f32 = 10.0;
    let corner = Rect::from_min_size(lens.rect.left_top() + vec2(12.0, 9.0), size);
    let Some(sound) = sound.filter(|_| !editor.scene().is_home()) else { return corner };
    let axes = editor.view.axes(editor.scene());
    let elements: Vec<_> = sound.aperture.positions.iter().map(|at| lens.screen(axes.flat(*at))).collect();
    let is_free = |place: &Rect| !elements.iter().any(|at| place.expand(STEP).contains(*at));
    let places = (0..).map(|i| corner.translate(vec2(0.0, STEP * i as f32)));
    let inside = places.take_while(|place| place.bottom() < lens.rect.center().y);
    inside.into_iter().find(is_free).unwrap_or(corner)
}

/// A level over the threshold, in dB.
fn over_threshold(level: f64) -> String {
    let side = if level < 0.0 { "below" } else { "over" };
    format!("{:.1} dB {side} threshold", level.abs())
}

fn value(editor: &Editor, map: &Map, sound: &Sound, uv: DVec2, point: DVec3) -> String {
    let quantity = map.quantity;
    let value = map.number(uv).or_else(|| sound.value(map, point));
    if value.is_some_and(f64::is_nan) {
        return "inside a body".to_owned();
    }
    let reading = probe::reading(&sound.aperture, &sound.heard, point);
    if quantity.declaration().is_level() {
        return value.map_or_else(String::new, over_threshold);
    }
    let of_map = match quantity.declaration().range {
        Range::Amount => value.map(|value| {
            let to_peak = quantity.decibels(value / map.largest.max(1e-30)).max(-99.9);
            format!("   {} dB of the peak", ticks::signed(&format!("{to_peak:.1}")))
        }),
        Range::Signed => value.map(|value| format!("   {}", ticks::signed(&quantity.with_unit(value)))),
        Range::Cyclic => None,
    };
    let of_map = of_map.unwrap_or_default();
    if quantity != Quantity::Rms && quantity.declaration().range == Range::Amount {
        let value = value.map_or_else(String::new, |value| quantity.with_unit(value));
        return format!("{value}{of_map}");
    }
    // A mean over frames has no phase.
    let phase = match editor.playback.moment.of(quantity) {
        Moment::Mean => String::new(),
        Moment::Rest | Moment::Frame(_) | Moment::Wave(_) => {
            format!("   phase {}", ticks::signed(&format!("{:.0}°", reading.phase().to_degrees())))
        }
    };
    format!(
        "{}   {} dB SPL{of_map}{phase}",
        editor.view.convention.pressure(reading.peak()),
        ticks::signed(&format!("{:.1}", reading.spl().max(-99.9)))
    )
}
