//! The panel of the beam pattern.

use egui::{Color32, Ui};
use egui_plot::{HoverPosition, Line, PlotPoints};

use crate::picture::figure::axes;
use crate::studio::pattern::{ANGLES, Cut, FLOOR, degrees_of};
use crate::ui::panels::form::{fact, form, heading, ruled_plot};
use crate::ui::{editor::Editor, theme};

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    const HEIGHT: f32 = 170.0;
    /// Degrees, on either side.
    const RIGHT_ANGLE: f64 = 90.0;
    heading(ui, "Beam pattern");
    let tip = "Level far from the array against the angle from its normal; Export figure has it as charts";
    ui.checkbox(&mut editor.parts.beam.form.is_shown, "Level against angle").on_hover_text(tip);
    let Some(pattern) = editor.parts.beam.newest().filter(|_| editor.parts.beam.form.is_shown) else {
        return;
    };
    let plot = ruled_plot("beam", HEIGHT, ["angle / °", "level / dB"])
        .auto_bounds(egui::Vec2b::FALSE)
        .default_x_bounds(-RIGHT_ANGLE, RIGHT_ANGLE)
        .default_y_bounds(FLOOR, 0.0)
        .label_formatter(|place| {
            let (name, at) = match place {
                HoverPosition::NearDataPoint { plot_name, position, .. } => (*plot_name, position),
                HoverPosition::Elsewhere { position } => ("", position),
            };
            let [angle, level] = [at.x, at.y].map(|value| axes::number(value, 1));
            Some(format!("{name}\n{angle}°, {level} dB").trim().to_owned())
        });
    plot.show(ui, |plot| {
        for (cut, colour) in pattern.cuts.iter().zip(COLOURS) {
            let level = |row: usize| [degrees_of(row), cut.levels[row].max(2.0 * FLOOR)];
            let points: PlotPoints<'_> = (0..ANGLES).map(level).collect();
            plot.line(Line::new(cut.name(), points).color(colour).width(1.5));
        }
    });
    pattern.cuts.iter().zip(COLOURS).for_each(|(cut, colour)| facts(cut, colour, ui));
}

/// Of the cuts.
const COLOURS: [Color32; 2] = [theme::ACCENT, theme::CHOSEN];

fn facts(cut: &Cut, colour: Color32, ui: &mut Ui) {
    ui.colored_label(colour, cut.name());
    form(ui, &cut.name(), |ui| {
        for (name, value) in cut.rows() {
            fact(ui, (name, "In this plane; angles from the array's normal"), value);
        }
    });
}
