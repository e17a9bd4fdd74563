//! The panel of the pressure at a point over time, with the spectrum of its square, and of the skin there.

use egui::Ui;
use egui_plot::{Line, PlotPoints};

use crate::field::Quantity;
use crate::scene::SpectralLine;
use crate::studio::map::omits_modulation;
use crate::ui::panels::form::{choice, heading, ruled_plot};
use crate::ui::panels::form::{fact, form};
use crate::ui::parts::course::{BAND, Course, Place};
use crate::ui::{editor::Editor, measure, theme};

/// Points of the screen.
const HEIGHT: f32 = 92.0;

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "At a point");
    let tip =
        "Pressure under modulation, motion and the frame rate of the board, and the spectrum of its square";
    ui.checkbox(&mut editor.parts.course.form.is_shown, "Time course and spectrum at a point")
        .on_hover_text(tip);
    if !editor.parts.course.form.is_shown {
        return;
    }
    form(ui, "course place", |ui| {
        let places = [(Place::Focus, "focus"), (Place::Pointer, "pointer"), (Place::Listener, "listener")];
        let tip =
            "Focus: the position of the selected or the first target. Pointer: its last position on the map";
        choice(ui, ("Place", tip), &mut editor.parts.course.form.place, &places);
    });
    let Some(course) = editor.parts.course.newest() else {
        ui.label(match editor.parts.course.form.place {
            Place::Pointer if editor.pointed.is_none() => "Move the pointer over the map.",
            Place::Listener if editor.scene().listener.is_none() => {
                "There is no listener: the Scene panel sets one."
            }
            Place::Focus | Place::Pointer | Place::Listener => "There is no focus.",
        });
        return;
    };
    match course {
        Ok(course) => plots(editor, course, ui),
        Err(why) => {
            ui.label(why);
        }
    }
}

fn plots(editor: &Editor, course: &Course, ui: &mut Ui) {
    let convention = editor.view.convention;
    form(ui, "course", |ui| {
        let [x, y, z] = course.at.to_array().map(measure::mm);
        fact(ui, ("At", "x, y, z"), format!("{x}, {y}, {z} mm"));
        let (name, tip) = match omits_modulation(editor.scene(), Quantity::Rms) {
            true => (
                "Mean with modulation",
                "Mean pressure (RMS over time) with modulation; the map is at full amplitude",
            ),
            false => ("Mean pressure", "RMS over time"),
        };
        fact(ui, (name, tip), convention.pressure(course.mean().max(0.0).sqrt()));
        if let Some(line) = course.strongest() {
            let part = 100.0 * line.amplitude / course.mean().max(f64::MIN_POSITIVE);
            let tip = "Lines of |p|²: amplitude relative to the mean";
            fact(ui, ("Strongest line", tip), format!("{part:.1} % at {} Hz", hertz(line.frequency)));
        }
        if let Some(Ok(displacements)) = &course.skin {
            let tip = "From the least to the largest displacement of the skin";
            let text = format!("{} peak to peak", Quantity::Skin.with_unit(swing(displacements)));
            fact(ui, ("Skin moves", tip), text);
        }
    });
    let largest = course.moduli.iter().fold(0.0f64, |most, [_, p]| most.max(*p));
    let (name, factor) = if largest * convention.of_peak() < 1000.0 { ("Pa", 1.0) } else { ("kPa", 1e-3) };
    let factor = factor * convention.of_peak();
    let times = course.moduli.iter().map(|[time, p]| [time * 1e3, p * factor]).collect::<Vec<_>>();
    ui.label(format!("|p| / {name} ({}) against time / ms", convention.into_str()));
    plot("course of time", ui, vec![times]);
    match &course.skin {
        Some(Ok(displacements)) => {
            let microns = displacements.iter().map(|[time, u]| [time * 1e3, u * 1e6]).collect();
            ui.label("Displacement of the skin / µm against time / ms")
                .on_hover_text("Positive into the skin, with its mean");
            plot("skin over time", ui, vec![microns]);
        }
        Some(Err(why)) => {
            ui.label(why);
        }
        None => {}
    }
    ui.label("Lines of |p|² / % of its mean against frequency / Hz");
    let stem = |line: &SpectralLine| {
        let part = 100.0 * line.amplitude / course.mean().max(f64::MIN_POSITIVE);
        vec![[line.frequency, 0.0], [line.frequency, part]]
    };
    let stems = course.lines.iter().filter(|line| line.frequency > 0.0).map(stem);
    plot("spectrum", ui, stems.chain([vec![[0.0, 0.0], [BAND, 0.0]]]).collect());
}

/// From the least to the largest value.
fn swing(curve: &[[f64; 2]]) -> f64 {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = curve.iter().fold(ends, |(low, high), [_, u]| (low.min(*u), high.max(*u)));
    (high - low).max(0.0)
}

fn hertz(frequency: f64) -> String {
    let text = format!("{frequency:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn plot(id: &str, ui: &mut Ui, curves: Vec<Vec<[f64; 2]>>) {
    let plot = ruled_plot(id, HEIGHT, ["", ""]);
    plot.show(ui, |plot| {
        for curve in curves {
            plot.line(Line::new(id, PlotPoints::from(curve)).color(theme::ACCENT).width(1.5));
        }
    });
}
