//! The colour legend, and values with the unit that suits them.

use egui::{Align2, Color32, FontId, Mesh, Rect, Stroke, StrokeKind, Ui, pos2, vec2};

use crate::field::Quantity;
use crate::ui::canvas::round_step;
use crate::ui::view::Lens;
use crate::ui::{Editor, Map};

const WIDTH: f32 = 16.0;
const GAP: f32 = 14.0;

/// A value in Pa, rad or m as people read it.
pub fn with_unit(value: f64, quantity: Quantity) -> String {
    let (factor, unit) = unit(quantity, value.abs());
    format!("{} {unit}", figures(value * factor))
}

/// The factor from Pa, rad or m to the unit in which values up to `largest` are shown.
pub fn unit(quantity: Quantity, largest: f64) -> (f64, &'static str) {
    match quantity {
        Quantity::Phase => (180.0 / std::f64::consts::PI, "°"),
        Quantity::Dent if largest >= 1e-3 => (1e3, "mm"),
        Quantity::Dent => (1e6, "µm"),
        _ if largest >= 1e3 => (1e-3, "kPa"),
        _ => (1.0, "Pa"),
    }
}

/// Three figures.
pub fn figures(value: f64) -> String {
    let size = value.abs();
    let decimals = if size >= 99.95 || size == 0.0 {
        0
    } else if size >= 9.995 {
        1
    } else {
        2
    };
    format!("{value:.decimals$}")
}

pub fn title(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Rms | Quantity::MeanRms => "RMS",
        Quantity::Phase => "Phase",
        Quantity::Dent => "Depth",
        Quantity::Radiation => "Pressure",
    }
}

/// Draws the legend to the right of the plot.
pub fn paint(editor: &Editor, map: &Map, ui: &Ui, lens: &Lens) {
    let painter = ui.painter();
    let ink = ui.visuals().text_color();
    let plot = lens.rect;
    let bar = Rect::from_min_max(
        pos2(plot.right() + GAP, plot.top() + 26.0),
        pos2(plot.right() + GAP + WIDTH, plot.bottom()),
    );
    let full = editor.view.full.unwrap_or(map.largest).max(1e-30);
    let (factor, unit) = unit(map.quantity, full);
    painter.text(
        pos2(bar.left(), plot.top()),
        Align2::LEFT_TOP,
        format!("{}, {unit}", title(map.quantity)),
        FontId::proportional(12.0),
        ink,
    );
    let table = editor.view.table();
    let mut mesh = Mesh::default();
    for (i, [r, g, b, _]) in table.iter().enumerate() {
        let y = |i: usize| bar.bottom() - bar.height() * i as f32 / table.len() as f32;
        let strip = Rect::from_min_max(pos2(bar.left(), y(i + 1)), pos2(bar.right(), y(i)));
        mesh.add_colored_rect(strip, Color32::from_rgb(*r, *g, *b));
    }
    painter.add(mesh);
    painter.rect_stroke(bar, 0.0, Stroke::new(1.0, ui.visuals().weak_text_color()), StrokeKind::Outside);
    for (part, label) in ticks(map.quantity, full * factor) {
        let at = pos2(bar.right(), bar.bottom() - bar.height() * part as f32);
        painter.line_segment([at, at + vec2(4.0, 0.0)], Stroke::new(1.0, ui.visuals().weak_text_color()));
        painter.text(at + vec2(7.0, 0.0), Align2::LEFT_CENTER, label, FontId::proportional(12.0), ink);
    }
}

/// Parts of the bar with what stands beside them.
fn ticks(quantity: Quantity, full: f64) -> Vec<(f64, String)> {
    if quantity == Quantity::Phase {
        return [-180.0, -90.0, 0.0, 90.0, 180.0]
            .map(|degrees| (degrees / 360.0 + 0.5, format!("{degrees:.0}")))
            .to_vec();
    }
    let step = round_step(full / 6.0);
    let count = (full / step).floor() as usize;
    let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let mut ticks: Vec<_> = (0..=count)
        .map(|i| i as f64 * step)
        // The largest value itself is written at the end.
        .filter(|value| value / full < 0.95)
        .map(|value| (value / full, format!("{value:.decimals$}")))
        .collect();
    ticks.push((1.0, figures(full)));
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_three_figures_and_the_unit_that_suits() {
        for (value, quantity, text) in [
            (1234.0, Quantity::Rms, "1.23 kPa"),
            (12.34, Quantity::Radiation, "12.3 Pa"),
            (4.2e-5, Quantity::Dent, "42.0 µm"),
            (1.5e-3, Quantity::Dent, "1.50 mm"),
            (-std::f64::consts::FRAC_PI_2, Quantity::Phase, "-90.0 °"),
        ] {
            assert_eq!(with_unit(value, quantity), text);
        }
        assert_eq!((round_step(0.7), round_step(1.0), round_step(21.0)), (1.0, 1.0, 50.0));
    }

    #[test]
    fn ticks_stay_on_the_bar() {
        for full in [1e-4, 0.013, 1.0, 7.3, 850.0, 2e6] {
            let ticks = ticks(Quantity::Rms, full);
            assert!(ticks.len() >= 3 && ticks.len() < 12, "{full}: {ticks:?}");
            assert!(ticks.iter().all(|(part, _)| (0.0..=1.0).contains(part)));
        }
    }
}
