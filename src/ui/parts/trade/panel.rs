//! The panel of strength against side lobe.

use egui::Ui;
use egui_plot::{Line, MarkerShape, PlotPoints, Points};

use crate::rounding::percent;
use crate::studio::trade::Point;
use crate::ui::panels::form::{fact, form, heading, still_plot};
use crate::ui::{editor::Editor, theme};

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    const HEIGHT: f32 = 110.0;
    heading(ui, "Strength and side lobe");
    let tip = "Solves the drawing for four values of Quiet, with uniform amplitudes and with one per element";
    ui.checkbox(&mut editor.parts.trade.form.is_shown, "Curve of strength and side lobe").on_hover_text(tip);
    if !editor.parts.trade.form.is_shown {
        return;
    }
    let curves = match editor.parts.trade.newest() {
        Some(Ok(curves)) => curves,
        Some(Err(why)) => {
            ui.label(why);
            return;
        }
        None => {
            ui.label("For strokes and areas.");
            return;
        }
    };
    let plot =
        still_plot("trade", HEIGHT).include_x(1.0).x_axis_label("strength / %").y_axis_label("side lobe / %");
    plot.show(ui, |plot| {
        for (curve, colour, name) in curves
            .iter()
            .zip([theme::CHOSEN, theme::ACCENT])
            .zip(["uniform", "per element"])
            .map(|((a, b), c)| (a, b, c))
        {
            let points: Vec<_> = curve.iter().map(|at| [100.0 * at.strength, 100.0 * at.side_lobe]).collect();
            plot.line(Line::new(name, PlotPoints::from(points.clone())).color(colour).width(1.5));
            plot.points(Points::new(name, points).color(colour).shape(MarkerShape::Circle).radius(3.0));
        }
    });
    form(ui, "trade", |ui| {
        let [uniform, free] = curves;
        for (uniform, free) in uniform.iter().zip(free) {
            let tip =
                "Strength, side lobe and, of areas, the error: uniform amplitudes, then one per element";
            fact(
                ui,
                (&format!("Quiet {}", uniform.quiet), tip),
                format!("{}; {}", told(uniform), told(free)),
            );
        }
    });
}

fn told(Point { strength, side_lobe, error, .. }: &Point) -> String {
    let error = error.map_or(String::new(), |error| format!(", error {}", percent(error)));
    format!("{} at {}{error}", percent(*side_lobe), percent(*strength))
}
