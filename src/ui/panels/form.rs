//! Rows of a panel: names with numbers, choices and facts.

use std::ops::RangeInclusive;

use egui::{Align, Label, Layout, Response, RichText, Ui, Vec2b};
use egui_plot::{AxisHints, GridMark, Plot};
use glam::DVec3;
use strum::VariantArray;

use crate::picture::figure::axes::{self, round_step};
use crate::ui::number::{self as typed, Look};
use crate::ui::{segments, theme, ticks};

/// Display of a number: factor and suffix.
#[derive(Clone, Copy)]
pub struct Unit {
    pub per: f64,
    pub suffix: &'static str,
    pub decimals: usize,
    /// Change per point of dragging, in the displayed unit.
    pub speed: f64,
}

pub const MM: Unit = Unit { per: 1e3, suffix: " mm", decimals: 2, speed: 0.25 };

pub const PLAIN: Unit = Unit { per: 1.0, suffix: "", decimals: 3, speed: 0.01 };

pub const PERCENT: Unit = Unit { per: 100.0, suffix: " %", decimals: 2, speed: 0.1 };

pub const DEGREES: Unit = Unit { per: 180.0 / std::f64::consts::PI, suffix: "°", decimals: 1, speed: 0.5 };

pub fn heading(ui: &mut Ui, text: &str) -> Response {
    ui.add_space(12.0);
    let response = ui.label(theme::heading(text));
    ui.add_space(2.0);
    response
}

/// Two columns: names and values.
pub fn form(ui: &mut Ui, id: &str, rows: impl FnOnce(&mut Ui)) {
    egui::Grid::new(id).num_columns(2).spacing([12.0, 5.0]).min_col_width(104.0).show(ui, rows);
}

/// The name of a row.
pub fn caption(ui: &mut Ui, name: &str) -> Response {
    let name = theme::label(name, ui.visuals());
    ui.label(name)
}

/// The value of a row: all values of a page end at its right edge.
pub fn value<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.with_layout(Layout::right_to_left(Align::Center), add).inner
}

/// A row with an editable number. Unreadable text changes nothing, and values out of range are clamped; both with a
/// message.
pub fn number(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    value: &mut f64,
    unit: Unit,
    range: RangeInclusive<f64>,
) -> Response {
    let label = caption(ui, name).on_hover_text(tip);
    let response = self::value(ui, |ui| bare_number(ui, value, unit, range));
    let response = response.labelled_by(label.id).on_hover_text(tip);
    ui.end_row();
    response
}

/// The number alone.
pub fn bare_number(ui: &mut Ui, value: &mut f64, unit: Unit, range: RangeInclusive<f64>) -> Response {
    let mut shown = *value * unit.per;
    let Unit { suffix, decimals, speed, per } = unit;
    let look = Look { unit: suffix, has_suffix: true, decimals, speed, name: None };
    let response = typed::field(ui, &mut shown, &look, range.start() * per..=range.end() * per);
    if response.changed() && shown.is_finite() {
        *value = (shown / per).clamp(*range.start(), *range.end());
    }
    response
}

/// The same for whole numbers.
pub fn count(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    value: &mut u32,
    range: RangeInclusive<u32>,
) -> Response {
    let label = caption(ui, name).on_hover_text(tip);
    let response = self::value(ui, |ui| bare_count(ui, value, range));
    let response = response.labelled_by(label.id).on_hover_text(tip);
    ui.end_row();
    response
}

/// The whole number alone.
pub fn bare_count(ui: &mut Ui, value: &mut u32, range: RangeInclusive<u32>) -> Response {
    let mut shown = f64::from(*value);
    let look = Look { unit: "", has_suffix: false, decimals: 0, speed: 0.1, name: None };
    let response = typed::field(ui, &mut shown, &look, f64::from(*range.start())..=f64::from(*range.end()));
    if response.changed() && shown.is_finite() {
        *value = (shown.round() as u32).clamp(*range.start(), *range.end());
    }
    response
}

/// A row with a remark beneath a value, wrapped at the edge of the page.
pub fn remark(ui: &mut Ui, text: impl Into<String>, colour: egui::Color32) {
    ui.label("");
    ui.add(Label::new(RichText::new(text).color(colour)).wrap());
    ui.end_row();
}

/// A row with a read-only value; a click copies it.
pub fn fact(ui: &mut Ui, (name, tip): (&str, &str), value: impl Into<String>) {
    caption(ui, name).on_hover_text(tip);
    self::value(ui, |ui| {
        let value = value.into();
        let is_cut = segments::text_width(ui, &value) > ui.available_width();
        let tip = if is_cut { format!("{value}\n{tip}") } else { tip.to_owned() };
        ui.add_space(ui.spacing().button_padding.x);
        let label = Label::new(&value).truncate().show_tooltip_when_elided(false).selectable(false);
        if ui.add(label.sense(egui::Sense::CLICK)).on_hover_text(tip).clicked() {
            ui.ctx().copy_text(value);
        }
    });
    ui.end_row();
}

/// All values of an enum, with their names.
pub fn variants<T: Copy + VariantArray>(name: fn(T) -> &'static str) -> Vec<(T, &'static str)> {
    T::VARIANTS.iter().map(|&value| (value, name(value))).collect()
}

/// A choice among a few.
pub fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    value: &mut T,
    choices: &[(T, &str)],
) {
    let label = caption(ui, name).on_hover_text(tip);
    let current = choices.iter().find(|(choice, _)| choice == value).map_or("", |(_, name)| name);
    let list = self::value(ui, |ui| {
        let list = egui::ComboBox::from_id_salt(name).selected_text(current).height(320.0).truncate();
        list.show_ui(ui, |ui| {
            for (choice, name) in choices {
                ui.selectable_value(value, *choice, *name);
            }
        })
    });
    list.response.labelled_by(label.id).on_hover_text(tip);
    ui.end_row();
}

/// A derived number that can be overridden.
pub fn given(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    value: &mut Option<f64>,
    otherwise: f64,
    unit: Unit,
    range: RangeInclusive<f64>,
) {
    let mut is_given = value.is_some();
    ui.checkbox(&mut is_given, name).on_hover_text(format!("{tip}. Ticked: as given here"));
    self::value(ui, |ui| {
        if is_given {
            let number = value.get_or_insert(otherwise);
            bare_number(ui, number, unit, range).accessible_name(name);
        } else {
            *value = None;
            // Indented like the numbers in fields.
            ui.add_space(ui.spacing().button_padding.x);
            ui.label(format!("{:.*}{}", unit.decimals, otherwise * unit.per, unit.suffix));
        }
    });
    ui.end_row();
}

/// A static plot from 0 upwards that shows all values, of this height in points.
pub fn still_plot(id: &str, height: f32) -> Plot<'_> {
    Plot::new(id)
        .height(height)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .auto_bounds(Vec2b::TRUE)
        .include_y(0.0)
        .show_grid(true)
}

/// A static plot with these names of its axes, if they have any, and round numbers along both.
pub fn ruled_plot<'a>(id: &'a str, height: f32, [across, up]: [&str; 2]) -> Plot<'a> {
    let number = |mark: GridMark, _: &RangeInclusive<f64>| {
        axes::number(mark.value, ticks::decimals(mark.step_size * 1.001))
    };
    let axes = |hints: AxisHints<'a>, name: &str| {
        vec![hints.label(name).label_spacing(8.0..=14.0).formatter(number)]
    };
    still_plot(id, height)
        .custom_x_axes(axes(AxisHints::new_x(), across))
        .custom_y_axes(axes(AxisHints::new_y(), up))
        .grid_spacing(8.0..=60.0)
        .x_grid_spacer(|input| round_marks(input.bounds, 6.0))
        .y_grid_spacer(|input| round_marks(input.bounds, 5.0))
}

/// About as many marks, at round numbers; more where there would be fewer than three.
fn round_marks((low, high): (f64, f64), count: f64) -> Vec<GridMark> {
    const LEAST: usize = 3;
    let marks = |count: f64| {
        let step = round_step((high - low).abs().max(f64::MIN_POSITIVE) / count);
        ticks::between(low, high, step).map(|value| GridMark { value, step_size: step }).collect::<Vec<_>>()
    };
    let coarse = marks(count);
    if coarse.len() < LEAST { marks(2.0 * count) } else { coarse }
}

/// Turns -0.00 into 0.
pub fn without_sign_on_zero(value: f64) -> f64 {
    if value.abs() < 5e-3 { 0.0 } else { value }
}

/// Width of a coordinate, for most numbers, and the gap between two.
const COORDINATE: f32 = 46.0;
const BETWEEN: f32 = 4.0;

/// The same as the value of a row, at the right edge like others.
pub fn coordinates_at_right(ui: &mut Ui, name: &str, at: &mut DVec3, lowest: f64) {
    // As wide as in the layout before: right to left, the Tab key would go backwards.
    let id = ui.scope_id().with(("width of coordinates", name));
    let width = ui.data(|data| data.get_temp(id)).unwrap_or(3.0 * COORDINATE + 2.0 * BETWEEN);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.add_space((ui.available_width() - width).max(0.0));
        let fields = ui.horizontal(|ui| coordinates(ui, name, at, lowest)).response;
        ui.data_mut(|data| data.insert_temp(id, fields.rect.width()));
    });
}

/// Three numbers in mm, z not below `lowest` mm.
pub fn coordinates(ui: &mut Ui, name: &str, at: &mut DVec3, lowest: f64) {
    ui.spacing_mut().item_spacing.x = BETWEEN;
    // Rows of points align.
    ui.spacing_mut().interact_size.x = COORDINATE;
    for (axis, value) in ["x", "y", "z"].into_iter().zip(at.as_mut()) {
        let mut shown = without_sign_on_zero(*value * 1e3);
        let least = if axis == "z" { lowest } else { -2000.0 };
        let name = format!("{name} {axis}");
        let look = Look { unit: "mm", has_suffix: false, decimals: 2, speed: 0.25, name: Some(&name) };
        let response = typed::field(ui, &mut shown, &look, least..=2000.0).on_hover_text(axis);
        if response.changed() && shown.is_finite() {
            *value = shown.clamp(least, 2000.0) * 1e-3;
        }
    }
}
