//! The panel of the bead and the force on it at a point.

use egui::{Button, Color32, DragValue, RichText, Ui};
use egui_plot::{Line, PlotPoints};

use crate::force::{Flight, Outcome};
use crate::rounding::millimetres;
use crate::scene::{Bead, Material};
use crate::studio::figure::capital;
use crate::studio::levitation;
use crate::ui::panels::form::{MM, Unit, fact, form, number};
use crate::ui::panels::form::{choice, coordinates, given, ruled_plot, variants};
use crate::ui::parts::flight::Start;
use crate::ui::parts::levitation::{Levitated, Place};
use crate::ui::{editor::Editor, measure, theme, ticks};

/// Points of the screen.
const HEIGHT: f32 = 170.0;
/// Colours of the curves along x, y and z.
const COLOURS: [Color32; 3] =
    [Color32::from_rgb(226, 98, 84), Color32::from_rgb(98, 176, 84), Color32::from_rgb(84, 148, 226)];

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    material(&mut editor.document.scene.bead, ui);
    ui.checkbox(&mut editor.parts.arrows.form.is_shown, "Arrows on the map")
        .on_hover_text("Radiation force on the bead in this plane, without its weight; longer is stronger");
    ui.checkbox(&mut editor.parts.levitation.form.is_shown, "Force at a point")
        .on_hover_text("Whether a bead is trapped there, and the force along x, y and z");
    if !editor.parts.levitation.form.is_shown {
        return;
    }
    form(ui, "bead place", |ui| {
        let places = [(Place::Target, "target"), (Place::Pointer, "pointer")];
        let tip = "Target: the selected one, or else the first trap or focus. Pointer: its last position on the map";
        choice(ui, ("Place", tip), &mut editor.parts.levitation.form.place, &places);
    });
    release(editor, ui);
    match editor.parts.levitation.newest() {
        Some(levitated) => figures(levitated, ui),
        None => drop(ui.label(match editor.parts.levitation.form.place {
            Place::Pointer => "Move the pointer over the map.",
            Place::Target => "There is no focus.",
        })),
    }
}

/// The release of the bead, and its flight.
fn release(editor: &mut Editor, ui: &mut Ui) {
    let Some(at) = editor.parts.levitation.newest().map(|levitated| levitated.at) else { return };
    let typed = editor.parts.levitation.form.typed;
    let mut place = typed.unwrap_or(at);
    let before = place;
    ui.horizontal(|ui| {
        ui.label("Release at")
            .on_hover_text("x, y, z: where the bead is let go, at rest. Unless typed, in the trap; of a motion, in that of the first frame");
        coordinates(ui, "Release", &mut place, -1000.0);
        ui.label("mm");
    });
    if place != before {
        editor.parts.levitation.form.typed = Some(place);
    }
    let target = editor.selection.first().copied();
    let target =
        target.filter(|&index| editor.scene().targets.get(index).is_some_and(|it| it.shape.is_trap()));
    ui.horizontal_wrapped(|ui| {
        if ui.button("Release").on_hover_text("Let the bead go: it flies in sound, weight and drag").clicked()
        {
            let typed = editor.parts.levitation.form.typed;
            editor.parts.flight.form.release(Start { trap: at, typed, target });
        }
        if ui.button("Reset").on_hover_text("Release in the trap again").clicked() {
            editor.parts.levitation.form.typed = None;
        }
        let is_released = editor.parts.flight.form.from.is_some();
        let flight = &mut editor.parts.flight.form;
        let (name, tip) =
            if flight.playing { ("Pause", "Stop the bead (Space)") } else { ("Play", "Go on (Space)") };
        if ui.add_enabled(is_released, Button::new(name)).on_hover_text(tip).clicked() {
            flight.playing = !flight.playing;
        }
        if ui
            .add_enabled(is_released, Button::new("Put away"))
            .on_hover_text("Remove bead and trail")
            .clicked()
        {
            flight.from = None;
        }
        let slowness = DragValue::new(&mut flight.slowness).prefix("1/").range(1.0..=1000.0).max_decimals(0);
        ui.add(slowness).on_hover_text("Playback: 1/1 is real time");
    });
    if editor.parts.flight.form.from.is_none() {
        return;
    }
    ui.label(match editor.parts.flight.newest() {
        None => "Computing the flight.".to_owned(),
        Some(flight) => outcome(flight),
    });
    if let Some(flight) = editor.parts.flight.newest() {
        let end = flight.moments.last().map_or(0.0, |last| last.time);
        ui.weak(format!("{:.1} of {:.1} ms", 1e3 * editor.parts.flight.form.time.min(end), 1e3 * end));
    }
}

/// The end of a flight, a sentence.
fn outcome(flight: &Flight) -> String {
    let Some(last) = flight.moments.last() else { return String::new() };
    if flight.is_lost {
        let [x, y, z] = last.at.to_array().map(measure::mm);
        return format!("Lost after {:.1} ms, at {x}, {y}, {z} mm.", 1e3 * last.time);
    }
    let farthest = millimetres(flight.farthest, 2);
    format!("Stays in the trap: at most {farthest} mm away in {:.0} ms.", 1e3 * last.time)
}

fn material(bead: &mut Bead, ui: &mut Ui) {
    form(ui, "bead", |ui| {
        let names = variants(Material::title);
        choice(ui, ("Material", "Its density and sound speed"), &mut bead.material, &names);
        number(ui, ("Radius", "Of the sphere"), &mut bead.radius, MM, 1e-6..=0.1);
        let density = Unit { per: 1.0, suffix: " kg/m³", decimals: 1, speed: 1.0 };
        let usual = Bead { density: None, ..bead.clone() }.density();
        given(ui, ("Density", "From the material"), &mut bead.density, usual, density, 1e-2..=1e5);
        let speed = Unit { per: 1.0, suffix: " m/s", decimals: 0, speed: 5.0 };
        let usual = Bead { sound_speed: None, ..bead.clone() }.sound_speed();
        given(
            ui,
            ("Sound speed", "Of compression, from the material"),
            &mut bead.sound_speed,
            usual,
            speed,
            1.0..=1e5,
        );
    });
}

fn figures(levitated: &Levitated, ui: &mut Ui) {
    let Levitated { hold, forces, load, curves, warning, .. } = levitated;
    let colour = match hold.outcome {
        Outcome::Holds => ui.visuals().strong_text_color(),
        Outcome::TooHeavy | Outcome::Unstable | Outcome::Leaves => theme::warning(ui.visuals()),
    };
    let verdict = levitation::verdict(hold).replace(" x ", " × ");
    let verdict = [" -", "(-"].iter().fold(verdict, |text, sign| text.replace(sign, &sign.replace('-', "−")));
    ui.label(RichText::new(format!("{}.", capital(&verdict))).color(colour));
    form(ui, "force", |ui| {
        let [x, y, z] = hold.at.to_array().map(measure::mm);
        fact(ui, ("At", "x, y, z"), format!("{x}, {y}, {z} mm"));
        let [x, y, z] = forces.force.to_array().map(micro);
        fact(ui, ("Force", "Of the sound, along x, y and z"), format!("{x}, {y}, {z} µN"));
        fact(ui, ("Weight", "Less the buoyancy of the air"), format!("{} µN", micro(*load)));
        let [weak, middle, strong] =
            hold.modes.map(|mode| ticks::signed(&format!("{:.3}", mode.stiffness * 1e3)));
        let tip =
            "Principal stiffnesses in ascending order, at the equilibrium or else at the bead's position";
        fact(ui, ("Stiffness", tip), format!("{weak}, {middle}, {strong} mN/m"));
    });
    if let Some(warning) = warning {
        ui.label(RichText::new(warning.as_str()).color(theme::warning(ui.visuals())));
    }
    ui.horizontal(|ui| {
        ui.label("Force along each axis:");
        for (name, colour) in ["x", "y", "z"].into_iter().zip(COLOURS) {
            ui.label(RichText::new(name).color(colour).strong());
        }
    })
    .response
    .on_hover_text(
        "Radiation force along each axis through the point. Grey: the weight, to be balanced along z",
    );
    let plot = ruled_plot("force along axes", HEIGHT, ["distance / mm", "force / µN"]);
    plot.show(ui, |plot| {
        let ends = curves[2].first().zip(curves[2].last());
        if let Some(([from, _], [to, _])) = ends {
            let weight = vec![[from * 1e3, load * 1e6], [to * 1e3, load * 1e6]];
            plot.line(Line::new("weight", PlotPoints::from(weight)).color(Color32::GRAY).width(1.0));
        }
        for ((name, curve), colour) in ["x", "y", "z"].into_iter().zip(curves).zip(COLOURS) {
            let curve: Vec<_> = curve.iter().map(|[place, force]| [place * 1e3, force * 1e6]).collect();
            plot.line(Line::new(name, PlotPoints::from(curve)).color(colour).width(1.5));
        }
    });
}

/// µN with three figures.
fn micro(force: f64) -> String {
    ticks::signed(&format!("{:.3}", force * 1e6))
}
