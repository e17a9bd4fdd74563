//! The colour legend, and values with the unit that suits them.

use egui::{Align2, Color32, FontId, Mesh, Rect, Stroke, StrokeKind, Ui, pos2, vec2};

use crate::field::colouring::FLOOR;
use crate::field::{Quantity, Scale};
use crate::ui::view::{Lens, decibels};
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
        Quantity::Instantaneous => "Instant",
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
        pos2(plot.right() + GAP, plot.top() + 36.0),
        pos2(plot.right() + GAP + WIDTH, plot.bottom()),
    );
    let full = editor.view.full.unwrap_or(map.largest).max(1e-30);
    let law = Law::of(map.quantity, editor.view.scale);
    painter.text(
        pos2(bar.left(), plot.top() - 4.0),
        Align2::LEFT_TOP,
        law.title(map.quantity, full),
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
    let (factor, _) = unit(map.quantity, full);
    for (part, label) in law.ticks(map.quantity, full * factor) {
        let at = pos2(bar.right(), y(part));
        painter.line_segment([at, at + vec2(4.0, 0.0)], edge);
        painter.text(at + vec2(7.0, 0.0), Align2::LEFT_CENTER, label, FontId::proportional(12.0), ink);
    }
    if let Some(contour) = editor.view.contour_part() {
        let part = law.place(contour * map.largest / full, map.quantity);
        if (0.0..=1.0).contains(&part) {
            painter.hline(bar.expand(3.0).x_range(), y(part), Stroke::new(2.0, ink));
        }
    }
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
        match (quantity, scale) {
            (Quantity::Phase, _) => Self::Turn,
            (Quantity::Instantaneous, _) => Self::Signed,
            (_, Scale::Linear) => Self::Linear,
            (_, Scale::Logarithmic) => Self::Decibels,
        }
    }

    fn title(self, quantity: Quantity, full: f64) -> String {
        let title = title(quantity);
        match self {
            Self::Decibels => format!("{title}, dB of\n{}", with_unit(full, quantity)),
            _ => format!("{title}, {}", unit(quantity, full).1),
        }
    }

    /// The part of the bar at which a part of the largest value stands.
    fn place(self, part: f64, quantity: Quantity) -> f64 {
        match self {
            Self::Linear => part,
            Self::Decibels => 1.0 - decibels(part, quantity) / decibels(FLOOR.into(), quantity),
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
                let least = decibels(FLOOR.into(), quantity);
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

/// 1, 2 or 5 times a power of ten, not less than `least`.
pub fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * power)
        .find(|&step| step >= least * 0.999)
        .unwrap_or(least)
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
    fn decibels_stand_where_their_colours_are() {
        for (quantity, floor) in [(Quantity::Rms, "-60"), (Quantity::Dent, "-30")] {
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
