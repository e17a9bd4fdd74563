//! Number fields: they parse typed expressions, and report unreadable input and limits.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use egui::emath::TSTransform;
use egui::{Color32, DragValue, Id, Response, Stroke, Ui, vec2};

use crate::ui::{expression, theme};

/// Durations (s) of a field's shaking and of its message.
const SHAKE: f64 = 0.4;
const SAID: f64 = 5.0;
/// Amplitude in points, and oscillations per second.
const SWING: f64 = 5.0;
const RATE: f64 = 9.0;

/// The result of the last typed text.
#[derive(Clone, Debug, PartialEq)]
struct Word {
    text: String,
    is_error: bool,
    /// s on the window's clock.
    since: f64,
}

/// How a number is shown.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// The displayed unit.
    pub unit: &'a str,
    /// Whether the unit is a suffix of the number.
    pub has_suffix: bool,
    pub decimals: usize,
    /// Change per point of dragging.
    pub speed: f64,
    /// Name for screen readers, without an adjacent label.
    pub name: Option<&'a str>,
}

/// A number field. [`Response::changed`] reports changes.
pub fn field(ui: &mut Ui, value: &mut f64, look: &Look<'_>, range: RangeInclusive<f64>) -> Response {
    let id = ui.next_auto_id().with("word");
    let said: Option<Word> = ui.data(|data| data.get_temp(id));
    let now = ui.input(|input| input.time);
    let heard = RefCell::new(None);
    let before = *value;
    let parser = |text: &str| {
        // A number that was looked at keeps the digits that the field does not show.
        let is_untouched =
            |least| egui::emath::format_with_decimals_in_range(before, least..=look.decimals) == text;
        if (0..=look.decimals).any(is_untouched) {
            return Some(before);
        }
        let read = expression::parse(text, look.unit);
        *heard.borrow_mut() = word(text, &read, &range, look);
        read.ok()
    };
    let field = DragValue::new(value)
        .speed(look.speed)
        .range(range.clone())
        .clamp_existing_to_range(false)
        .max_decimals(look.decimals)
        .update_while_editing(false)
        .custom_parser(parser)
        .suffix(if look.has_suffix { look.unit } else { "" });
    let response = shaken(ui, said.as_ref(), now, |ui| ui.add(field));
    let response = match look.name {
        Some(name) => response.accessible_name(name),
        None => response,
    };
    let heard = heard.into_inner().map(|(text, is_error)| Word { text, is_error, since: now });
    let begins_anew =
        response.gained_focus() || response.dragged() || (response.changed() && heard.is_none());
    match (heard, begins_anew) {
        (Some(word), _) => {
            ui.ctx().request_repaint();
            ui.data_mut(|data| data.insert_temp(id, word));
        }
        (None, true) => ui.data_mut(|data| data.remove::<Word>(id)),
        (None, false) => {}
    }
    tell(ui, id, &response, now);
    response
}

/// The message about a text: unreadable, or limited.
fn word(
    text: &str,
    read: &Result<f64, String>,
    range: &RangeInclusive<f64>,
    look: &Look<'_>,
) -> Option<(String, bool)> {
    let unit = look.unit.trim();
    let gap = if unit.is_empty() || unit == "°" { "" } else { " " };
    let limit = |which: &str, limit: f64| {
        let digits = crate::rounding::digits(limit);
        let digits =
            if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { &digits };
        Some((format!("Set to the {which} value here: {digits}{gap}{unit}"), false))
    };
    match read {
        Err(why) => {
            let typed = format!("“{}”", crate::echo::value(text.trim()));
            let says = if why.contains(&typed) { why.clone() } else { format!("{why}: {typed}") };
            Some((says, true))
        }
        Ok(value) if value < range.start() => limit("smallest", *range.start()),
        Ok(value) if value > range.end() => limit("largest", *range.end()),
        Ok(_) => None,
    }
}

/// The field, red and shaking briefly after unreadable text.
fn shaken(ui: &mut Ui, said: Option<&Word>, now: f64, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    let Some(word) = said else { return add(ui) };
    let age = now - word.since;
    let colour = if word.is_error { theme::error(ui.visuals()) } else { theme::warning(ui.visuals()) };
    let before = ui.visuals().widgets.clone();
    let widgets = &mut ui.visuals_mut().widgets;
    for widget in [&mut widgets.inactive, &mut widgets.hovered] {
        widget.bg_stroke = Stroke::new(1.5, colour);
    }
    let by = if word.is_error && age < SHAKE {
        ui.ctx().request_repaint();
        SWING * (1.0 - age / SHAKE) * (std::f64::consts::TAU * RATE * age).sin()
    } else {
        0.0
    };
    let layer = ui.layer_id();
    let first = ui.ctx().graphics(|graphics| graphics.get(layer).map(|list| list.next_idx()));
    let response = add(ui);
    if let (true, Some(first)) = (by != 0.0, first) {
        ui.ctx().graphics_mut(|graphics| {
            let list = graphics.entry(layer);
            let end = list.next_idx();
            list.transform_range(first, end, TSTransform::from_translation(vec2(by as f32, 0.0)));
        });
    }
    ui.visuals_mut().widgets = before;
    response
}

/// The reason, beside the field for a while, and while hovering.
fn tell(ui: &Ui, id: Id, response: &Response, now: f64) {
    let Some(word) = ui.data(|data| data.get_temp::<Word>(id)) else { return };
    let left = SAID - (now - word.since);
    if left > 0.0 {
        ui.ctx().request_repaint_after_secs(left as f32);
    }
    if left > 0.0 || response.hovered() {
        let colour = if word.is_error { theme::error(ui.visuals()) } else { theme::warning(ui.visuals()) };
        say(response, &word.text, colour);
    }
}

fn say(response: &Response, text: &str, colour: Color32) {
    egui::Tooltip::always_open(
        response.ctx.clone(),
        response.layer_id,
        response.id.with("said"),
        response.rect,
    )
    .show(|ui| ui.colored_label(colour, text));
}
