//! The colour legend.

use egui::{Align2, Color32, FontId, Mesh, Rect, Stroke, StrokeKind, Ui, pos2, vec2};

use crate::field::colouring::FLOOR;
use crate::field::quantity::{Range, figures};
use crate::field::{Quantity, Scale};
use crate::ui::view::Lens;
use crate::ui::{Editor, Map};

const WIDTH: f32 = 16.0;
const GAP: f32 = 14.0;

/// Draws the legend to the right of the plot.
pub fn paint(editor: &Editor, map: &Map, ui: &Ui, lens: &Lens) {
    let painter = ui.painter();
    let ink = ui.visuals().text_color();
    let plot = lens.rect;
    let bar = Rect::from_min_max(
        pos2(plot.right() + GAP, plot.top() + 36.0),
        pos2(plot.right() + GAP + WIDTH, plot.bottom()),
    );
    let full = map.full.unwrap_or(map.largest).max(1e-30);
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
    let (factor, _) = map.quantity.declaration().unit.scaled(full);
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
        match (quantity.declaration().range, scale) {
            (Range::Cyclic, _) => Self::Turn,
            (Range::Signed, _) => Self::Signed,
            (Range::Amount, Scale::Linear) => Self::Linear,
            (Range::Amount, Scale::Logarithmic) => Self::Decibels,
        }
    }

    fn title(self, quantity: Quantity, full: f64) -> String {
        let declaration = quantity.declaration();
        match self {
            Self::Decibels => format!("{}\ndB of {}", declaration.title, quantity.with_unit(full)),
            Self::Linear | Self::Signed | Self::Turn => {
                format!("{}\n{}", declaration.title, declaration.unit.scaled(full).1)
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
    fn ticks_are_round() {
        assert_eq!((round_step(0.7), round_step(1.0), round_step(21.0)), (1.0, 1.0, 50.0));
    }

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
