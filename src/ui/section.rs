//! The line profile: the map's values along a line in the displayed plane, below the map and aligned with it.

use egui::{
    Align2, Color32, FontId, Label, Painter, Pos2, Rect, Response, RichText, Sense, Stroke, StrokeKind, Ui,
    pos2, vec2,
};
use glam::{DVec2, DVec3};

use crate::field::{Quantity, Range};
use crate::picture::figure::Axis;
use crate::picture::figure::axes;
use crate::picture::figure::curve::Curve;
use crate::studio::convention::Convention;
use crate::studio::width::Widths;
use crate::ui::command::{Export, Purpose};
use crate::ui::measure::{self, ProfileLine};
use crate::ui::sound;
use crate::ui::ticks;
use crate::ui::view::{Cut, Lens};
use crate::ui::{editor::Editor, map::Map, marks, shown::Shown, sound::Sound, theme};

const POINTS: usize = 400;
/// Points of the screen below the plot: ticks and the axis' name.
const BELOW: f32 = 36.0;
/// Points of the screen between two ticks, at least.
const TICK: f64 = 70.0;
const TICK_UP: f64 = 26.0;
/// dB below the threshold that a plot of levels shows.
const LOWEST_LEVEL: f64 = -20.0;
/// In wavelengths: the far-field model is meaningless closer to the array.
const NEAREST: f64 = 0.5;

/// Values along a line.
#[derive(Clone, Debug)]
pub struct Profile {
    pub quantity: Quantity,
    /// Ends of the part of the line in front of the array, m in the plane.
    ends: [DVec2; 2],
    /// Position along the line (m): from its beginning, or on the horizontal axis for a line across the view.
    start: f64,
    pub points: Vec<DVec3>,
    pub values: Vec<f64>,
    /// 5 and 95 % of the RMS pressure, if elements differ.
    pub band: Option<Vec<[f64; 2]>>,
}

/// The lobe with the largest value on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// m from the beginning.
    pub at: f64,
    pub value: f64,
    /// Positions (m) of the -6 dB points on either side; `None` outside the line.
    pub half: Option<[f64; 2]>,
}

impl Profile {
    /// The values along the view's line, over its visible part. `None` without a drive, or if the line is in or
    /// behind the array.
    pub fn of(editor: &Editor, shown: &Shown) -> Option<Self> {
        let (map, sound) = (shown.map.as_ref()?, shown.sound.as_ref()?);
        if map.cut != editor.view.cut || sound.drive().phases.len() != sound.aperture.positions.len() {
            return None;
        }
        let lens = Lens { rect: map.rect, window: map.window };
        let screen = [lens.rect.left_bottom(), lens.rect.right_top()].map(|at| lens.flat(at).x);
        let line = editor.view.line;
        let ends = in_front(map, sound, line.ends(screen))?;
        let start = match line {
            ProfileLine::Across(_) => ends[0].x,
            ProfileLine::Between([from, _]) => ends[0].distance(from),
        };
        let place = |i: usize| ends[0].lerp(ends[1], i as f64 / (POINTS - 1) as f64);
        let points: Vec<_> = (0..POINTS).map(|i| map.axes.world(place(i))).collect();
        let values = match &map.numbers {
            Some(_) => (0..POINTS).map(|i| map.number(place(i)).unwrap_or(0.0)).collect(),
            None => sound.values(map, &points),
        };
        let band = (map.quantity == Quantity::Rms).then(|| sound.band(&points)).flatten();
        (values.len() == POINTS).then_some(Self { quantity: map.quantity, ends, start, points, values, band })
    }

    /// m
    fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// m along the axis of the plot.
    fn place(&self, index: usize) -> f64 {
        self.start + self.length() * index as f64 / (POINTS - 1) as f64
    }

    /// The value at a position on the plot's axis (m).
    fn value(&self, place: f64) -> Option<f64> {
        let at = (place - self.start) / self.length() * (POINTS - 1) as f64;
        let index = at.floor();
        let (low, high) = (self.values.get(index as usize)?, self.values.get(index as usize + 1)?);
        (at >= 0.0).then(|| low + (high - low) * (at - index))
    }

    /// The loudest lobe and its -6 dB width, for quantities with decibels.
    pub fn lobe(&self) -> Option<Lobe> {
        let declaration = self.quantity.declaration();
        if declaration.range != Range::Amount || declaration.is_level() {
            return None;
        }
        let values = &self.values;
        let outside = (0..values.len()).filter(|&i| !values[i].is_nan());
        let top = outside.max_by(|&a, &b| values[a].total_cmp(&values[b]))?;
        // Half the pressure, and a quarter of its square.
        let level = values[top] * 0.5f64.powf(20.0 / declaration.decibels);
        let step = self.length() / (POINTS - 1) as f64;
        let crossing = |inside: usize, outside: usize| {
            let part = (values[inside] - level) / (values[inside] - values[outside]);
            (inside as f64 + part * (outside as f64 - inside as f64)) * step
        };
        // A lobe that ends at a body has no width.
        let is_end = |i: &usize| values[*i].is_nan() || values[*i] < level;
        let before = (0..top).rev().find(is_end).map(|i| crossing(i + 1, i)).filter(|at| !at.is_nan());
        let after =
            (top + 1..values.len()).find(is_end).map(|i| crossing(i - 1, i)).filter(|at| !at.is_nan());
        let half = before.zip(after).map(|(before, after)| [before, after]);
        (values[top] > 0.0).then_some(Lobe { at: top as f64 * step, value: values[top], half })
    }

    /// CSV: distance from the beginning (m), position (m) and value in SI units, with the band of 5 to 95 %, if any.
    pub fn csv(&self) -> String {
        let of_band = if self.band.is_some() { ",p5,p95" } else { "" };
        let mut text = format!("distance,x,y,z,{}{of_band}\n", self.quantity.declaration().name);
        let step = self.length() / (POINTS - 1) as f64;
        for (i, (point, value)) in self.points.iter().zip(&self.values).enumerate() {
            let band = self.band.as_ref().map(|band| band[i]);
            let columns = [i as f64 * step, point.x, point.y, point.z, *value];
            let columns: Vec<_> =
                columns.into_iter().chain(band.into_iter().flatten()).map(|it| format!("{it:?}")).collect();
            text.push_str(&(columns.join(",") + "\n"));
        }
        text
    }
}

/// The part of a line in front of the array.
fn in_front(map: &Map, sound: &Sound, [from, to]: [DVec2; 2]) -> Option<[DVec2; 2]> {
    let nearest = NEAREST * sound.aperture.wavelength();
    let height = |uv: DVec2| map.axes.world(uv).z - nearest;
    let meeting = || from.lerp(to, height(from) / (height(from) - height(to)));
    match (height(from) >= 0.0, height(to) >= 0.0) {
        (true, true) => Some([from, to]),
        (false, true) => Some([meeting(), to]),
        (true, false) => Some([from, meeting()]),
        (false, false) => None,
    }
    .filter(|[from, to]| from.distance(*to) >= measure::SHORTEST)
}

/// A value as it is read.
fn told(quantity: Quantity, value: f64, convention: Convention) -> String {
    let value = ticks::signed(&quantity.with_unit(value * convention.factor(quantity)));
    format!("{value} {}", name(quantity, convention)).trim_end().to_owned()
}

/// The convention's name, of quantities that have one.
fn name(quantity: Quantity, convention: Convention) -> &'static str {
    if quantity.declaration().is_root { convention.into_str() } else { "" }
}

/// The curve of a figure, with its title.
pub fn curve(editor: &Editor, shown: &Shown) -> Option<(String, Curve)> {
    let (profile, map) = (Profile::of(editor, shown)?, shown.map.as_ref()?);
    let plot = Plot::new(editor, shown, map, &profile, Rect::NOTHING);
    let name = match editor.view.line {
        ProfileLine::Across(v) => along(editor.view.cut, v).replace('-', "−"),
        ProfileLine::Between(_) => "Line profile".to_owned(),
    };
    Some((name, plot.curve()))
}

/// The title of a line across the view.
fn along(cut: Cut, v: f64) -> String {
    let (_, up) = cut.axes();
    if up.starts_with("across") {
        return format!("Line profile {} mm across the plane", measure::mm(v));
    }
    let axis = up.split(' ').next().unwrap_or_default();
    format!("Line profile along {axis} = {} mm", measure::mm(v))
}

/// Draws the profile and its figures.
pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    let profile = Profile::of(editor, shown);
    ui.add_space(2.0);
    ui.horizontal_wrapped(|ui| {
        ui.add_space(8.0);
        head(editor, shown, profile.as_ref(), ui);
    });
    let (Some(profile), Some(map)) = (profile, &shown.map) else {
        let why = if shown.sound.is_none() {
            "Nothing is played."
        } else {
            "The line lies in or behind the array, or its field is not computed yet."
        };
        ui.weak(why);
        return;
    };
    let room = ui.available_rect_before_wrap();
    let min = pos2(map.rect.left(), room.top() + 4.0);
    let max = pos2(map.rect.right(), (room.bottom() - BELOW).max(room.top() + 30.0));
    let response =
        ui.interact(Rect::from_min_max(min, max), egui::Id::unique("line profile"), Sense::hover());
    // The full height, otherwise the panel would shrink by the row below the plot.
    ui.advance_cursor_after_rect(room);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Line profile plot"));
    Plot::new(editor, shown, map, &profile, response.rect).paint(ui, &response);
}

/// The measured values, and commands on them.
fn head(editor: &mut Editor, shown: &Shown, profile: Option<&Profile>, ui: &mut Ui) {
    match editor.view.line {
        ProfileLine::Across(v) => {
            ui.label(along(editor.view.cut, v))
                .on_hover_text("Shift and the pointer move the line; the Measure tool draws another");
        }
        ProfileLine::Between(ends) => {
            ui.label("Line");
            copied(ui, &measure::length_and_angle(ends), "Length, and angle from the axis to the right");
        }
    }
    if let Some((profile, lobe)) = profile.and_then(|profile| Some((profile, profile.lobe()?))) {
        ui.separator();
        ui.label("Peak");
        copied(ui, &told(profile.quantity, lobe.value, editor.view.convention), "Largest value on the line");
        if let Some([before, after]) = lobe.half {
            ui.separator();
            ui.label("−6 dB width");
            copied(
                ui,
                &format!("{} mm", measure::mm(after - before)),
                "Between the places on the line where the pressure is half of the peak (FWHM)",
            );
        }
    }
    if let Some(focus) = focus(editor, shown) {
        ui.separator();
        if ui.button("Lateral").on_hover_text("The line through the focus across the beam").clicked() {
            lateral(editor, focus);
        }
        if ui.button("Axial").on_hover_text("The line through the focus away from the array").clicked() {
            axial(editor, focus);
        }
    }
    if let Some(widths) = editor.parts.survey.exact().and_then(|(_, found)| widths(found.as_ref()?)) {
        ui.separator();
        ui.label("Focus");
        copied(ui, &widths, "−6 dB widths of the focus across and along the beam, and its −6 dB area across");
    }
    let button = ui.add_enabled(profile.is_some(), egui::Button::new("CSV…"));
    if button.on_hover_text("Write the places and values along the line to a file").clicked() {
        editor.ask_for_file(Purpose::Export(Export::Profile));
    }
}

/// The widths of a focus as text; `None` without a separate lobe.
fn widths(widths: &Widths) -> Option<String> {
    let Widths { lateral_x, lateral_y, axial, area } = widths;
    let lengths = [("x", lateral_x), ("y", lateral_y), ("z", axial)];
    let lengths = lengths.map(|(name, width)| width.map(|width| format!("{name} {}", measure::mm(width))));
    let lengths: Vec<_> = lengths.into_iter().flatten().collect();
    let area = area.map(|area| format!(", {:.0} mm²", area * 1e6)).unwrap_or_default();
    (!lengths.is_empty()).then(|| format!("{} mm{area}", lengths.join(" x ")))
}

/// A value that a click copies.
pub fn copied(ui: &mut Ui, value: &str, tip: &str) {
    let label = Label::new(RichText::new(value).strong()).selectable(false).extend().sense(Sense::CLICK);
    if ui.add(label).on_hover_text(format!("{tip}. Click to copy")).clicked() {
        ui.ctx().copy_text(value.to_owned());
    }
}

/// The relevant focus: the selected one, or the first.
fn focus(editor: &Editor, shown: &Shown) -> Option<DVec3> {
    sound::focus(editor.scene(), &editor.selection, shown.sound.as_ref())
}

/// Lays the line across the beam through a focus.
fn lateral(editor: &mut Editor, focus: DVec3) {
    if editor.view.cut == Cut::Xy {
        editor.view.heights[0] = focus.z;
    }
    let at = editor.view.axes(editor.scene()).flat(focus);
    editor.view.line = ProfileLine::Across(at.y);
}

/// Lays the line through a focus along the array's normal, in an upright cut through it.
fn axial(editor: &mut Editor, focus: DVec3) {
    match editor.view.cut {
        Cut::Yz => editor.view.heights[2] = focus.x,
        Cut::Xz => editor.view.heights[1] = focus.y,
        Cut::Xy | Cut::Free | Cut::Own => {
            editor.look_at(Cut::Xz);
            editor.view.heights[1] = focus.y;
        }
    }
    let at = editor.view.axes(editor.scene()).flat(focus);
    editor.view.line = ProfileLine::Between([DVec2::new(at.x, 0.0), DVec2::new(at.x, 2.0 * at.y)]);
}

/// The curve with its axes.
struct Plot<'a> {
    editor: &'a Editor,
    sound: Option<&'a Sound>,
    map: &'a Map,
    profile: &'a Profile,
    rect: Rect,
    /// Range of the axis to the right, m.
    places: [f64; 2],
    /// Range of the axis upwards, in the unit shown.
    values: [f64; 2],
    factor: f64,
    unit: String,
}

impl<'a> Plot<'a> {
    fn new(editor: &'a Editor, shown: &'a Shown, map: &'a Map, profile: &'a Profile, rect: Rect) -> Self {
        let largest = profile.values.iter().fold(0.0f64, |most, value| most.max(value.abs())).max(1e-30);
        let convention = editor.view.convention;
        let (by_convention, name) = (convention.factor(profile.quantity), name(profile.quantity, convention));
        let (factor, unit) = profile.quantity.declaration().unit.scaled(largest * by_convention);
        let factor = factor * by_convention;
        let lens = Lens { rect: map.rect, window: map.window };
        let places = match editor.view.line {
            ProfileLine::Across(_) => {
                [lens.rect.left_bottom(), lens.rect.right_top()].map(|at| lens.flat(at).x)
            }
            ProfileLine::Between([from, to]) => [0.0, from.distance(to)],
        };
        let least = if profile.quantity.declaration().is_level() { LOWEST_LEVEL } else { f64::NEG_INFINITY };
        let lowest = profile.values.iter().copied().fold(0.0, f64::min).max(least) * factor;
        let above = profile.band.iter().flatten().map(|[_, high]| *high);
        let highest = profile.values.iter().copied().chain(above).fold(0.0, f64::max) * factor;
        let values = [lowest, highest + 0.06 * (highest - lowest).max(1e-30)];
        let unit = format!("{unit} {name}").trim_end().to_owned();
        Self { editor, sound: shown.sound.as_ref(), map, profile, rect, places, values, factor, unit }
    }

    /// The name of the axis to the right.
    fn name(&self) -> &'static str {
        match self.editor.view.line {
            ProfileLine::Across(_) => self.editor.view.cut.axes().0,
            ProfileLine::Between(_) => "along the line / mm",
        }
    }

    /// The same for a figure.
    fn curve(&self) -> Curve {
        let profile = self.profile;
        let point = |place: f64, value: f64| [place * 1e3, value * self.factor];
        let values = |of: &dyn Fn(usize) -> f64| -> Vec<_> {
            (0..profile.values.len()).map(|i| point(profile.place(i), of(i))).collect()
        };
        let (unit, words) = (&self.unit, profile.quantity.declaration().title.to_owned());
        let label = if unit.is_empty() { words } else { format!("{words} / {unit}") };
        let width = profile.lobe().and_then(|lobe| {
            let level = 0.5f64.powf(20.0 / profile.quantity.declaration().decibels);
            let ends = lobe.half?.map(|at| point(profile.start + at, lobe.value * level));
            Some((ends, format!("{} mm", measure::mm(ends[1][0] * 1e-3 - ends[0][0] * 1e-3))))
        });
        Curve {
            axes: [
                Axis { ends: self.places.map(|place| place * 1e3), label: self.name().to_owned() },
                Axis { ends: self.values, label },
            ],
            points: values(&|i| profile.values[i]),
            others: Vec::new(),
            names: Vec::new(),
            dots: Vec::new(),
            limits: profile.band.as_ref().map(|band| [0, 1].map(|edge| values(&|i| band[i][edge]))),
            places: self.foci().map(|place| place * 1e3).collect(),
            width,
        }
    }

    fn x(&self, place: f64) -> f32 {
        let [low, high] = self.places;
        self.rect.left() + self.rect.width() * ((place - low) / (high - low)) as f32
    }

    fn y(&self, value: f64) -> f32 {
        let [low, high] = self.values;
        self.rect.bottom() - self.rect.height() * ((value * self.factor - low) / (high - low)) as f32
    }

    fn paint(&self, ui: &Ui, response: &Response) {
        let painter = ui.painter();
        self.axes(ui, painter);
        let inside = ui.painter_at(self.rect);
        if let Some(lobe) = self.profile.lobe() {
            self.width(&inside, &lobe);
        }
        if self.profile.quantity.declaration().is_level() {
            let threshold = Stroke::new(1.0, theme::CHOSEN.gamma_multiply(0.6));
            inside.hline(self.rect.x_range(), self.y(0.0), threshold);
        }
        for place in self.foci() {
            let stroke = Stroke::new(1.0, theme::CHOSEN.gamma_multiply(0.4));
            inside.vline(self.x(place), self.rect.y_range(), stroke);
        }
        self.band(&inside);
        let point = |(i, &value): (usize, &f64)| pos2(self.x(self.profile.place(i)), self.y(value));
        let values: Vec<_> = self.profile.values.iter().enumerate().collect();
        for run in values.split(|(_, value)| value.is_nan()) {
            let curve = run.iter().copied().map(point).collect();
            inside.add(egui::Shape::line(curve, Stroke::new(1.5, theme::ACCENT)));
        }
        if let Some(at) = response.hover_pos() {
            self.hover(&inside, at);
        }
    }

    fn axes(&self, ui: &Ui, painter: &Painter) {
        let ink = ui.visuals().text_color();
        let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
        let faint = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.25));
        let font = FontId::proportional(12.0);
        let rect = self.rect;
        let span = (self.places[1] - self.places[0]) * 1e3;
        let step = axes::round_step(TICK * span / f64::from(rect.width().max(1.0)));
        let decimals = ticks::decimals(step);
        for x in ticks::between(self.places[0] * 1e3, self.places[1] * 1e3, step) {
            let at = pos2(self.x(x * 1e-3), rect.bottom());
            painter.vline(at.x, rect.y_range(), faint);
            painter.line_segment([at, at + vec2(0.0, 4.0)], edge);
            painter.text(
                at + vec2(0.0, 5.0),
                Align2::CENTER_TOP,
                axes::number(x, decimals),
                font.clone(),
                ink,
            );
        }
        let range = self.values[1] - self.values[0];
        let step = axes::round_step(TICK_UP * range / f64::from(rect.height().max(1.0)));
        let decimals = ticks::decimals(step);
        for value in ticks::between(self.values[0], self.values[1], step) {
            let at = pos2(rect.left(), self.y(value / self.factor));
            painter.hline(rect.x_range(), at.y, faint);
            painter.line_segment([at, at - vec2(4.0, 0.0)], edge);
            painter.text(
                at - vec2(6.0, 0.0),
                Align2::RIGHT_CENTER,
                axes::number(value, decimals),
                font.clone(),
                ink,
            );
        }
        painter.rect_stroke(rect, 0.0, edge, StrokeKind::Outside);
        let name = self.name();
        let below = pos2(rect.center().x, rect.bottom() + 19.0);
        painter.text(below, Align2::CENTER_TOP, name, font.clone(), ink);
        painter.text(rect.right_top() + vec2(8.0, 0.0), Align2::LEFT_TOP, &self.unit, font, ink);
    }

    /// Draws the band of 5 to 95 %.
    fn band(&self, painter: &Painter) {
        let Some(band) = &self.profile.band else { return };
        let mut mesh = egui::Mesh::default();
        let is_outside = |edges: &[f64; 2]| edges.iter().all(|edge| !edge.is_nan());
        for (i, edges) in (0u32..).zip(band) {
            let x = self.x(self.profile.place(i as usize));
            for &edge in edges {
                let y = if edge.is_nan() { self.rect.bottom() } else { self.y(edge) };
                mesh.colored_vertex(pos2(x, y), theme::ACCENT.gamma_multiply(0.25));
            }
            if i > 0 && is_outside(edges) && is_outside(&band[i as usize - 1]) {
                mesh.add_triangle(2 * i - 2, 2 * i - 1, 2 * i);
                mesh.add_triangle(2 * i - 1, 2 * i, 2 * i + 1);
            }
        }
        painter.add(mesh);
    }

    /// Draws the -6 dB width of the loudest lobe.
    fn width(&self, painter: &Painter, lobe: &Lobe) {
        let Some(half) = lobe.half else { return };
        let [before, after] = half.map(|at| self.x(self.profile.start + at));
        let band = Rect::from_x_y_ranges(before..=after, self.rect.y_range());
        painter.rect_filled(band, 0.0, theme::ACCENT.gamma_multiply(0.12));
        let level = 0.5f64.powf(20.0 / self.profile.quantity.declaration().decibels);
        painter.hline(before..=after, self.y(lobe.value * level), Stroke::new(1.0, theme::CHOSEN));
    }

    /// Positions of separate foci near the line on the axis to the right, m.
    fn foci(&self) -> impl Iterator<Item = f64> {
        let ends = self.profile.ends;
        let along = (ends[1] - ends[0]).normalize_or_zero();
        let separate = self.sound.into_iter().flat_map(|sound| &sound.foci).filter(|focus| focus.is_placed());
        separate.filter_map(move |focus| {
            let from = self.map.axes.flat(focus.position) - ends[0];
            let is_near =
                from.perp_dot(along).abs() < 1e-3 && self.map.axes.height(focus.position).abs() < 2e-3;
            is_near.then(|| self.profile.start + from.dot(along))
        })
    }

    /// Position and value under the pointer.
    fn hover(&self, painter: &Painter, at: Pos2) {
        let part = f64::from((at.x - self.rect.left()) / self.rect.width());
        let place = self.places[0] + (self.places[1] - self.places[0]) * part;
        let Some(value) = self.profile.value(place).filter(|value| !value.is_nan()) else { return };
        let on_curve = pos2(at.x, self.y(value));
        painter.vline(at.x, self.rect.y_range(), Stroke::new(1.0, Color32::from_white_alpha(90)));
        painter.circle_filled(on_curve, 3.0, theme::CHOSEN);
        let value = told(self.profile.quantity, value, self.editor.view.convention);
        let text = format!("{} mm   {value}", measure::mm(place));
        let is_left = at.x < self.rect.center().x;
        let align = if is_left { Align2::LEFT_TOP } else { Align2::RIGHT_TOP };
        let beside = pos2(at.x + if is_left { 12.0 } else { -12.0 }, self.rect.top() + 6.0);
        marks::chip(painter, beside, align, &text, 12.0, theme::MARK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(value: impl Fn(f64) -> f64) -> Profile {
        let length = 0.1;
        let values = (0..POINTS).map(|i| value(length * i as f64 / (POINTS - 1) as f64)).collect();
        let ends = [DVec2::ZERO, DVec2::X * length];
        let points = vec![DVec3::ZERO; POINTS];
        Profile { quantity: Quantity::Rms, ends, start: 0.0, points, values, band: None }
    }

    #[test]
    fn the_width_of_a_lobe_is_that_of_half_the_pressure_and_of_a_quarter_of_its_square() {
        let width = |lobe: Lobe| lobe.half.map(|[before, after]| after - before).unwrap();
        let triangle = |x: f64| (1.0 - (x - 0.04).abs() / 0.02).max(0.0);
        let of_pressure = profile(triangle).lobe().unwrap();
        // Its tip lies between two of the points.
        assert!((width(of_pressure) - 0.02).abs() < 2e-4 && (of_pressure.at - 0.04).abs() < 2e-4);
        let squared = Profile { quantity: Quantity::Intensity, ..profile(|x| triangle(x).powi(2)) };
        assert!((width(squared.lobe().unwrap()) - 0.02).abs() < 3e-4);
        assert_eq!(profile(|x| x).lobe().unwrap().half, None, "a slope has no width");
        assert_eq!(profile(|_| 0.0).lobe(), None);
    }
}
