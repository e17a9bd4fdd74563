//! The colour legend, and what it lets one choose.

use egui::{
    Align2, Color32, ComboBox, CursorIcon, DragValue, FontId, Mesh, Popup, PopupCloseBehavior, Rect,
    RectAlign, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use crate::field::colouring::FLOOR;
use crate::field::quantity::{Range, figures};
use crate::field::{Quantity, Scale};
use crate::picture::ColourMap;
use crate::picture::figure::axes::round_step;
use crate::studio::convention::Convention;
use crate::ui::view::{Lens, View};
use crate::ui::{Editor, Map, Shown, panels, segments, theme};

const WIDTH: f32 = 16.0;
const GAP: f32 = 14.0;

/// Where the bar lies beside a plot.
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
    let full = map.full.unwrap_or(map.largest).max(1e-30) * factor;
    let law = Law::of(map.quantity, editor.view.scale);
    painter.text(
        pos2(bar.left(), plot.top() - 4.0),
        Align2::LEFT_TOP,
        law.title(map.quantity, convention, full),
        FontId::proportional(12.0),
        ink,
    );
    let table = editor.view.colour_map().table();
    let mut mesh = Mesh::default();
    for (i, [r, g, b, _]) in table.iter().enumerate() {
        let y = |i: usize| bar.bottom() - bar.height() * i as f32 / table.len() as f32;
        let strip = Rect::from_min_max(pos2(bar.left(), y(i + 1)), pos2(bar.right(), y(i)));
        mesh.add_colored_rect(strip, Color32::from_rgb(*r, *g, *b));
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
    if let Some(contour) = editor.view.contour_part() {
        let part = law.place(contour * map.largest * factor / full, map.quantity);
        if (0.0..=1.0).contains(&part) {
            painter.hline(bar.expand(3.0).x_range(), y(part), Stroke::new(2.0, ink));
        }
    }
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
    let response = response
        .on_hover_cursor(CursorIcon::PointingHand)
        .on_hover_text("Colour scale. Click to choose colours, range and contour lines");
    let popup = Popup::menu(&response)
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
        label(ui, "Scale");
        let decibels = "In decibels, from the largest pressure down to a thousandth of it".to_owned();
        let scales = [
            (Scale::Linear, "Linear", "In proportion to the value".to_owned()),
            (Scale::Logarithmic, "dB", decibels),
        ];
        segments::show(ui, "Scale", &mut view.scale, &scales);
        ui.end_row();
    }
    if view.quantity.declaration().range != Range::Cyclic {
        label(ui, "Range");
        range(view, map, ui);
        ui.end_row();
    }
    if view.quantity.declaration().has_mean {
        ui.checkbox(&mut view.contours, "Contours").on_hover_text(
            "Lines where the value is so many decibels below the largest in view; at -6 dB the pressure is half of it",
        );
        let field = DragValue::new(&mut view.contour_level).speed(0.1).range(-60.0..=-0.1);
        let field = field.max_decimals(1).suffix(" dB");
        ui.add_enabled(view.contours, field).accessible_name("Level of the contour lines");
        ui.end_row();
    }
}

/// Up to the largest value on the screen, or up to one that stays.
fn range(view: &mut View, map: &Map, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let mut is_locked = view.full.is_some();
        ui.checkbox(&mut is_locked, "Lock")
            .on_hover_text("Keep the range of colours while the sound changes");
        view.full = is_locked.then(|| view.full.unwrap_or(map.largest));
        let convention = view.convention.factor(view.quantity);
        let (unit, symbol) =
            view.quantity.declaration().unit.scaled(view.full.unwrap_or(map.largest) * convention);
        let mut value = view.full.unwrap_or(map.largest) * convention * unit;
        let speed = 0.01 * value.abs().max(1e-3);
        let field = DragValue::new(&mut value).speed(speed).suffix(format!(" {symbol}"));
        let response = ui.add_enabled(is_locked, field).accessible_name("Largest value that has a colour");
        if response.changed() && value.is_finite() {
            view.full = Some((value / unit / convention).clamp(1e-12, 1e9));
        }
    });
}

/// How values are spread over the bar.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    /// From nothing to the largest.
    Linear,
    /// dB below the largest.
    Decibels,
    /// From minus the largest to the largest.
    Signed,
    Turn,
}

impl Law {
    fn of(quantity: Quantity, scale: Scale) -> Self {
        match (quantity.declaration().range, scale) {
            (Range::Cyclic, _) => Self::Turn,
            (Range::Signed, _) => Self::Signed,
            (Range::Amount, Scale::Linear) => Self::Linear,
            (Range::Amount, Scale::Logarithmic) => Self::Decibels,
        }
    }

    fn title(self, quantity: Quantity, convention: Convention, full: f64) -> String {
        let title = quantity.declaration().title;
        let with_convention = |text: String| match quantity.declaration().is_root {
            true => format!("{text} {}", convention.name()),
            false => text,
        };
        match self {
            Self::Decibels => format!("{title}\ndB of {}", with_convention(quantity.with_unit(full))),
            Self::Linear | Self::Signed | Self::Turn => {
                let unit = quantity.declaration().unit.scaled(full).1;
                format!("{title}\n{}", with_convention(unit.to_owned()))
            }
        }
    }

    /// The part of the bar at which a part of the largest value stands.
    fn place(self, part: f64, quantity: Quantity) -> f64 {
        match self {
            Self::Linear => part,
            Self::Decibels => 1.0 - quantity.decibels(part) / quantity.decibels(FLOOR.into()),
            Self::Signed | Self::Turn => 0.5 + 0.5 * part,
        }
    }

    /// Parts of the bar with what stands beside them, for values up to `full` in their unit.
    fn ticks(self, quantity: Quantity, full: f64) -> Vec<(f64, String)> {
        match self {
            Self::Turn => [-180.0, -90.0, 0.0, 90.0, 180.0]
                .map(|degrees| (degrees / 360.0 + 0.5, format!("{degrees:.0}")))
                .to_vec(),
            Self::Decibels => {
                let least = quantity.decibels(FLOOR.into());
                let tick = |part: f64| (1.0 - part, format!("{:.0}", least * part + 0.0));
                (0..=6).map(|i| tick(f64::from(i) / 6.0)).collect()
            }
            Self::Linear => amounts(full, 6.0),
            Self::Signed => {
                let above = amounts(full, 3.0);
                let below = above.iter().skip(1).map(|(part, label)| (-part, format!("-{label}")));
                let all: Vec<_> = below.chain(above.iter().cloned()).collect();
                all.into_iter().map(|(part, label)| (0.5 + 0.5 * part, label)).collect()
            }
        }
    }
}

/// Round values from nothing to `full`, about so many, as parts of it; the largest value itself is written at the end.
fn amounts(full: f64, count: f64) -> Vec<(f64, String)> {
    let step = round_step(full / count);
    let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let mut ticks: Vec<_> = (0..=(full / step).floor() as usize)
        .map(|i| i as f64 * step)
        .filter(|value| value / full < 1.0 - 0.36 / count)
        .map(|value| (value / full, format!("{value:.decimals$}")))
        .collect();
    ticks.push((1.0, figures(full)));
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decibels_stand_where_their_colours_are() {
        for (quantity, floor) in [(Quantity::Rms, "-60"), (Quantity::Depression, "-30")] {
            let ticks = Law::Decibels.ticks(quantity, 7.0);
            assert_eq!(ticks.last().unwrap(), &(0.0, floor.to_owned()));
            assert_eq!(ticks[0], (1.0, "0".to_owned()));
            assert!((Law::Decibels.place(FLOOR.into(), quantity)).abs() < 1e-6);
            assert!((Law::Decibels.place(0.1, quantity) - 2.0 / 3.0).abs() < 1e-6);
        }
        assert_eq!(
            (Law::Signed.place(-1.0, Quantity::Instantaneous), Law::Linear.place(0.5, Quantity::Rms)),
            (0.0, 0.5)
        );
    }

    #[test]
    fn ticks_stay_on_the_bar() {
        for full in [1e-4, 0.013, 1.0, 7.3, 850.0, 2e6] {
            for law in [Law::Linear, Law::Decibels, Law::Signed, Law::Turn] {
                let ticks = law.ticks(Quantity::Rms, full);
                assert!(ticks.len() >= 3 && ticks.len() < 12, "{full}: {ticks:?}");
                assert!(ticks.iter().all(|(part, _)| (0.0..=1.0).contains(part)), "{ticks:?}");
            }
        }
    }
}
