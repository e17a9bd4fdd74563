//! The colour bar and its settings.

use std::ops::RangeInclusive;

use egui::{
    Align2, Color32, ComboBox, CursorIcon, FontId, Mesh, Popup, PopupCloseBehavior, Rect, RectAlign, Role,
    Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use crate::field::{Quantity, Range, Scale, figures};
use crate::picture::ColourMap;
use crate::picture::figure::axes::{self, round_step};
use crate::scene::UNCERTAINTY;
use crate::studio::convention::Convention;
use crate::studio::map::{OVER_THRESHOLD, contour, omits_modulation};
use crate::ui::number::{self, Look};
use crate::ui::view::{Lens, View};
use crate::ui::{editor::Editor, map::Map, panels, segments, shown::Shown, theme, ticks};

/// Smallest full-scale value, in the unit of the map.
const SMALLEST: f64 = 1e-12;
const LARGEST: f64 = 1e9;
/// The least distance of the ends, as a part of the upper one.
const NARROWEST: f64 = 1e-3;
/// dB
const FLOORS: RangeInclusive<f64> = -120.0..=-1.0;
/// dB
const CONTOURS: RangeInclusive<f64> = -60.0..=-0.1;
/// Round steps along the bar, about.
const STEPS: f64 = 6.0;
const WIDTH: f32 = 16.0;
const GAP: f32 = 14.0;
/// Width of a remark below the bar.
const ROOM: f32 = 84.0;
/// The remark on pressures of modulated sound.
const WITHOUT_MODULATION: &str = "full amplitude, no modulation";

/// Position of the bar beside a plot.
fn place(plot: Rect) -> Rect {
    Rect::from_min_max(
        pos2(plot.right() + GAP, plot.top() + 36.0),
        pos2(plot.right() + GAP + WIDTH, plot.bottom()),
    )
}

/// Draws the legend to the right of the plot.
pub fn paint(editor: &Editor, map: &Map, ui: &Ui, lens: &Lens) {
    let painter = ui.painter();
    let ink = ui.visuals().text_color();
    let plot = lens.rect;
    let bar = place(plot);
    let convention = editor.view.convention;
    let factor = convention.factor(map.quantity);
    let full = map.full.unwrap_or(map.largest).max(least_full(map.quantity)) * factor;
    let law = Law::of(&editor.view, map.quantity, map.low.map(|low| low * factor), full);
    painter.text(
        pos2(bar.left(), plot.top() - 4.0),
        Align2::LEFT_TOP,
        law.title(map.quantity, convention, full),
        FontId::proportional(12.0),
        ink,
    );
    let table = editor.view.table();
    let dims = editor.view.veil().is_some();
    let ground = theme::ground(editor.view.is_light);
    let mut mesh = Mesh::default();
    for (i, [r, g, b, _]) in table.iter().enumerate() {
        let y = |i: usize| bar.bottom() - bar.height() * i as f32 / table.len() as f32;
        let strip = Rect::from_min_max(pos2(bar.left(), y(i + 1)), pos2(bar.right(), y(i)));
        let colour = Color32::from_rgb(*r, *g, *b);
        mesh.add_colored_rect(strip, colour);
        if dims {
            // From zero at the left to the largest amplitude at the right.
            let corners = mesh.vertices.iter_mut().rev().take(4);
            corners.filter(|corner| corner.pos.x == strip.left()).for_each(|corner| corner.color = ground);
        }
    }
    painter.add(mesh);
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.rect_stroke(bar, 0.0, edge, StrokeKind::Outside);
    let y = |part: f64| bar.bottom() - bar.height() * part as f32;
    let (unit, _) = map.quantity.declaration().unit.scaled(full);
    for (part, label) in law.ticks(map.quantity, full * unit) {
        let at = pos2(bar.right(), y(part));
        painter.line_segment([at, at + vec2(4.0, 0.0)], edge);
        painter.text(at + vec2(7.0, 0.0), Align2::LEFT_CENTER, label, FontId::proportional(12.0), ink);
    }
    // A given range shows what it was given for.
    let threshold = map.quantity.declaration().is_level().then(|| threshold(map.largest));
    let remark = threshold.as_ref().or(map.remark.as_ref().filter(|_| map.full.is_none()));
    let omission = omits_modulation(editor.scene(), map.quantity).then(|| WITHOUT_MODULATION.to_owned());
    let is_clipped = map.quantity.declaration().of_light && map.full.is_some_and(|full| map.largest > full);
    let clipping = is_clipped.then(|| "brighter places clipped".to_owned());
    let remarks: Vec<_> = omission.into_iter().chain(clipping).chain(remark.cloned()).collect();
    if !remarks.is_empty() {
        let font = FontId::proportional(11.0);
        let weak = ui.visuals().weak_text_color();
        let galley = painter.layout(remarks.join("\n"), font, weak, ROOM);
        painter.galley(bar.left_bottom() + vec2(0.0, 6.0), galley, weak);
    }
    for level in editor.view.contour_levels() {
        let part = law.place(contour(map.quantity, *level, map.largest) * factor / full, map.quantity);
        if (0.0..=1.0).contains(&part) {
            painter.hline(bar.expand(3.0).x_range(), y(part), Stroke::new(2.0, ink));
        }
    }
}

/// The least value of the last colour.
fn least_full(quantity: Quantity) -> f64 {
    /// dB: the bar of a map on which nothing is felt is not empty.
    const LEVELS: f64 = 1.0;
    if quantity.declaration().is_level() { LEVELS } else { 1e-30 }
}

/// The meaning of levels up to the largest.
fn threshold(largest: f64) -> String {
    let means = format!("0 dB: just felt, ± {:.0} dB", UNCERTAINTY[0]);
    if largest < 0.0 { format!("not felt: at most {largest:.0} dB") } else { means }
}

/// The bar as a button that opens the choice of colours, range and contour lines.
pub fn controls(editor: &mut Editor, shown: &Shown, ui: &mut Ui, lens: &Lens) {
    let Some(map) = shown.map.as_ref().filter(|_| !editor.view.is_shaded()) else { return };
    let rect = place(lens.rect).expand2(vec2(4.0, 2.0));
    let response = ui.interact(rect, ui.scope_id().with("colour scale"), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Colour scale"));
    if response.hovered() || response.has_focus() {
        ui.painter().rect_stroke(rect, 3.0, Stroke::new(1.5, theme::ACCENT), StrokeKind::Outside);
    }
    let tip = "Colour scale. Click to choose colours, range and contour lines";
    let tip = match omits_modulation(editor.scene(), map.quantity) {
        true => format!("{tip}. Pressures are those at full amplitude, modulation not included"),
        false => tip.to_owned(),
    };
    let response = response.on_hover_cursor(CursorIcon::PointingHand).on_hover_text(tip);
    // Not a menu, in which fields have no frames.
    let popup = Popup::from_toggle_button_response(&response)
        .align(RectAlign::LEFT_START)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    popup.show(|ui| {
        panels::form(ui, "colour scale", |ui| choices(&mut editor.view, map, ui));
    });
}

fn choices(view: &mut View, map: &Map, ui: &mut Ui) {
    let is_amount = view.quantity.is_amount();
    let label = |ui: &mut Ui, text: &str| ui.label(theme::label(text, ui.visuals()));
    if is_amount {
        let name = label(ui, "Colours");
        let list = ComboBox::from_id_salt("colours").selected_text(view.colours.title()).show_ui(ui, |ui| {
            for map in ColourMap::OF_AMOUNTS {
                ui.selectable_value(&mut view.colours, map, map.title());
            }
        });
        list.response.labelled_by(name.id);
        ui.end_row();
    }
    if is_amount && !view.quantity.declaration().is_level() {
        label(ui, "Scale");
        let decibels = "In decibels below the largest value".to_owned();
        let scales = [
            (Scale::Linear, "Linear", "In proportion to the value".to_owned()),
            (Scale::Logarithmic, "dB", decibels),
        ];
        segments::show(ui, "Scale", &mut view.scale, &scales);
        ui.end_row();
    }
    if view.quantity.declaration().range != Range::Cyclic {
        let convention = if view.quantity.declaration().is_root { view.convention.into_str() } else { "" };
        label(ui, format!("Range {convention}").trim_end());
        range(view, map, ui);
        ui.end_row();
    } else {
        label(ui, "Brightness");
        ui.checkbox(&mut view.fades, "Follows amplitude")
            .on_hover_text("Phases are dark at low pressure, where they mean little");
        ui.end_row();
    }
    label(ui, "Background");
    let white = ui.checkbox(&mut view.is_light, "White").on_hover_text("Silence is white, as in print");
    white.accessible_name("White background");
    ui.end_row();
    if view.quantity.declaration().is_level() {
        ui.checkbox(&mut view.threshold_contours, "Contours")
            .on_hover_text("Lines at the threshold of feeling, and 10 and 20 dB over it");
        ui.label(OVER_THRESHOLD.map(|level| format!("{level:.0}")).join(", ") + " dB");
        ui.end_row();
    } else if view.quantity.declaration().has_mean {
        ui.checkbox(&mut view.contours, "Contours").on_hover_text(
            "Lines at a level below the largest value in view; at −6 dB the pressure is half of it",
        );
        ui.add_enabled_ui(view.contours, |ui| {
            let name = Some("Level of the contour lines");
            let look = Look { unit: " dB", has_suffix: true, decimals: 1, speed: 0.1, name };
            number::field(ui, &mut view.contour_level, &look, CONTOURS);
        });
        ui.end_row();
    }
}

/// The ends of the colour range in the unit of the bar. They follow the map until typed or locked.
fn range(view: &mut View, map: &Map, ui: &mut Ui) {
    let largest = view.full.unwrap_or(map.largest);
    let stated = view.convention.factor(view.quantity);
    let (unit, symbol) = view.quantity.declaration().unit.scaled(largest * stated);
    let per = unit * stated;
    let suffix = format!(" {symbol}");
    let is_linear = view.colouring().scale() == Scale::Linear;
    let least = if view.quantity.declaration().range == Range::Signed { -largest } else { 0.0 };
    let field = |ui: &mut Ui, value: f64, range: RangeInclusive<f64>, name: &'static str| {
        let mut typed = value * per;
        let decimals = if largest * per >= 100.0 { 1 } else { 3 };
        let speed = 0.01 * (largest * per).max(1e-3);
        let look = Look { unit: &suffix, has_suffix: true, decimals, speed, name: Some(name) };
        let response = number::field(ui, &mut typed, &look, range.start() * per..=range.end() * per);
        (response.changed() && typed.is_finite()).then(|| (typed / per).clamp(*range.start(), *range.end()))
    };
    ui.horizontal(|ui| {
        if is_linear {
            let low = view.low.filter(|_| view.full.is_some()).unwrap_or(least);
            let has_negative = least < 0.0 || view.quantity.declaration().is_level();
            let lowest = if has_negative { -LARGEST } else { 0.0 };
            let typed =
                field(ui, low, lowest..=largest * (1.0 - NARROWEST), "Smallest value that has a colour");
            if let Some(low) = typed {
                (view.low, view.full) = (Some(low), Some(largest));
            }
            ui.label("to");
        } else {
            floor(view, ui);
            ui.label("below");
        }
        let low = view.low.filter(|_| is_linear && view.full.is_some()).unwrap_or(0.0).max(0.0);
        let smallest = (low * (1.0 + NARROWEST)).max(SMALLEST);
        if let Some(full) = field(ui, largest, smallest..=LARGEST, "Largest value that has a colour") {
            view.full = Some(full);
        }
    });
    ui.end_row();
    ui.label("");
    let mut is_locked = view.full.is_some();
    let tip = "Keep the ends of the colours while the sound changes; typing one locks them";
    if ui.checkbox(&mut is_locked, "Lock").on_hover_text(tip).changed() {
        view.forget_range();
        view.full = is_locked.then_some(map.largest);
    }
}

/// The lower end of a logarithmic scale.
fn floor(view: &mut View, ui: &mut Ui) {
    let mut decibels = view.quantity.decibels(view.floor);
    let name = Some("Lowest level that has a colour");
    let look = Look { unit: " dB", has_suffix: true, decimals: 1, speed: 0.5, name };
    if number::field(ui, &mut decibels, &look, FLOORS).changed() && decibels.is_finite() {
        view.floor = 10f64.powf(decibels / view.quantity.declaration().decibels);
    }
}

/// Mapping of values to the bar.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    /// From this part of the largest.
    Linear(f64),
    /// dB below the largest, down to this part of it.
    Decibels(f64),
    Turn,
}

impl Law {
    /// With the first colour at `low`, if chosen, and the last one at `full`.
    fn of(view: &View, quantity: Quantity, low: Option<f64>, full: f64) -> Self {
        let low = low.filter(|low| *low < full).map(|low| low / full);
        match (quantity.declaration().range, view.scale()) {
            (Range::Cyclic, _) => Self::Turn,
            (Range::Signed, _) => Self::Linear(low.unwrap_or(-1.0)),
            (Range::Amount, Scale::Linear) => Self::Linear(low.unwrap_or(0.0)),
            (Range::Amount, Scale::Logarithmic) => Self::Decibels(view.floor),
        }
    }

    fn title(self, quantity: Quantity, convention: Convention, full: f64) -> String {
        let title = quantity.declaration().title;
        let with_convention = |text: String| match quantity.declaration().is_root {
            true => format!("{text} {}", convention.into_str()),
            false => text,
        };
        match self {
            Self::Decibels(_) => {
                format!("{}\ndB re {}", with_convention(title.to_owned()), quantity.with_unit(full))
            }
            Self::Linear(_) | Self::Turn => {
                let unit = quantity.declaration().unit.scaled(full).1;
                format!("{title}\n{}", with_convention(unit.to_owned()))
            }
        }
    }

    /// Position on the bar of a fraction of the largest value.
    fn place(self, part: f64, quantity: Quantity) -> f64 {
        match self {
            Self::Linear(low) => (part - low) / (1.0 - low),
            Self::Decibels(floor) => 1.0 - quantity.decibels(part) / quantity.decibels(floor),
            Self::Turn => 0.5 + 0.5 * part,
        }
    }

    /// Positions on the bar with labels, for values up to `full` in their unit.
    fn ticks(self, quantity: Quantity, full: f64) -> Vec<(f64, String)> {
        match self {
            Self::Turn => [-180.0, -90.0, 0.0, 90.0, 180.0]
                .map(|degrees| (degrees / 360.0 + 0.5, axes::number(degrees, 0)))
                .to_vec(),
            Self::Decibels(floor) => {
                let least = quantity.decibels(floor);
                let step = round_step(-least / STEPS);
                let levels = (0..).map(|i| -step * f64::from(i)).take_while(|level| *level > least - 1e-6);
                let decimals = ticks::decimals(step);
                levels.map(|level| (1.0 - level / least, axes::number(level, decimals))).collect()
            }
            Self::Linear(low) => amounts(low * full, full),
        }
    }
}

/// Round values from `low` to `full`, as fractions of the range; both ends are labelled exactly.
fn amounts(low: f64, full: f64) -> Vec<(f64, String)> {
    /// Round values this close to an end are omitted, as a fraction of the range.
    const NEAR: f64 = 0.06;
    let step = round_step((full - low) / STEPS);
    let decimals = ticks::decimals(step).min(6);
    let within = ticks::between(low, full, step).map(|value| ((value - low) / (full - low), value));
    let within = within.filter(|(part, _)| (NEAR..1.0 - NEAR).contains(part));
    let mut ticks = vec![(0.0, figures(low).replace('-', "−"))];
    ticks.extend(within.map(|(part, value)| (part, axes::number(value, decimals))));
    ticks.push((1.0, figures(full)));
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decibels_stand_where_their_colours_are() {
        for (quantity, floor) in [(Quantity::Rms, "−60"), (Quantity::Depression, "−30")] {
            let law = Law::Decibels(1e-3);
            let ticks = law.ticks(quantity, 7.0);
            assert_eq!(ticks.last().unwrap(), &(0.0, floor.to_owned()));
            assert_eq!(ticks[0], (1.0, "0".to_owned()));
            assert!(law.place(1e-3, quantity).abs() < 1e-6);
            assert!((law.place(0.1, quantity) - 2.0 / 3.0).abs() < 1e-6);
        }
        assert!((Law::Decibels(1e-2).place(0.1, Quantity::Rms) - 0.5).abs() < 1e-6);
        assert_eq!((Law::Linear(-1.0).place(-1.0, Quantity::Instantaneous)), 0.0);
        assert_eq!(Law::Linear(0.0).place(0.5, Quantity::Rms), 0.5);
        assert_eq!(Law::Linear(0.25).place(0.5, Quantity::Rms), 1.0 / 3.0);
    }

    #[test]
    fn ticks_stay_on_the_bar_and_rise() {
        for full in [1e-4, 0.013, 1.0, 7.3, 850.0, 2e6] {
            for law in [-1.0, -0.2, 0.0, 0.3, 0.99]
                .map(Law::Linear)
                .into_iter()
                .chain([1e-3, 0.02, 1e-6].map(Law::Decibels))
            {
                let ticks = law.ticks(Quantity::Rms, full);
                assert!(ticks.len() >= 3 && ticks.len() < 14, "{full} {law:?}: {ticks:?}");
                assert!(ticks.iter().all(|(part, _)| (-1e-9..=1.0).contains(part)), "{ticks:?}");
                let rises = |pair: &[(f64, String)]| pair[0].0 < pair[1].0;
                assert!(
                    ticks.windows(2).all(rises) || ticks.windows(2).all(|pair| !rises(pair)),
                    "{ticks:?}"
                );
            }
        }
    }
}
