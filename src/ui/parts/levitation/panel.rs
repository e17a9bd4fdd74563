//! The panel of the bead and the force on it at a point.

use egui::{Color32, RichText, Ui};
use egui_plot::{Line, PlotPoints};

use crate::force::Outcome;
use crate::scene::{Bead, Material};
use crate::studio::levitation;
use crate::ui::panels::form::{MM, Unit, fact, form, number};
use crate::ui::panels::form::{choice, given, still_plot, variants};
use crate::ui::parts::levitation::{Levitated, Place};
use crate::ui::{editor::Editor, measure, theme, ticks};

/// Points of the screen.
const HEIGHT: f32 = 120.0;
/// Colours of the curves along x, y and z.
const COLOURS: [Color32; 3] =
    [Color32::from_rgb(226, 98, 84), Color32::from_rgb(98, 176, 84), Color32::from_rgb(84, 148, 226)];

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    material(&mut editor.document.scene.bead, ui);
    ui.checkbox(&mut editor.parts.arrows.form.is_shown, "Arrows on the map").on_hover_text(
        "Where the sound drives the bead on the cut; the longer, the stronger. Weight is left out",
    );
    ui.checkbox(&mut editor.parts.levitation.form.is_shown, "Force at a point")
        .on_hover_text("Whether a bead is held there, and the force along x, y and z");
    if !editor.parts.levitation.form.is_shown {
        return;
    }
    form(ui, "bead place", |ui| {
        let places = [(Place::Target, "target"), (Place::Pointer, "pointer")];
        let tip = "Target: the selected one, or else the first trap or focus. Pointer: its last position on the map";
        choice(ui, ("Place", tip), &mut editor.parts.levitation.form.place, &places);
    });
    match editor.parts.levitation.newest() {
        Some(levitated) => figures(levitated, ui),
        None => drop(ui.label(match editor.parts.levitation.form.place {
            Place::Pointer => "Move the pointer over the map.",
            Place::Target => "Nothing is played there.",
        })),
    }
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
    let Levitated { hold, forces, load, curves, warning } = levitated;
    let colour = match hold.outcome {
        Outcome::Holds => ui.visuals().strong_text_color(),
        Outcome::TooHeavy | Outcome::Unstable | Outcome::Leaves => theme::warning(ui.visuals()),
    };
    let verdict = levitation::verdict(hold);
    ui.label(RichText::new(format!("It {verdict}.")).color(colour));
    form(ui, "force", |ui| {
        let [x, y, z] = hold.at.to_array().map(measure::mm);
        fact(ui, ("At", "x, y, z"), format!("{x}, {y}, {z} mm"));
        let [x, y, z] = forces.force.to_array().map(micro);
        fact(ui, ("Force", "Of the sound, along x, y and z"), format!("{x}, {y}, {z} µN"));
        fact(ui, ("Weight", "Less the buoyancy of the air"), format!("{} µN", micro(*load)));
        let [weak, middle, strong] = hold.modes.map(|mode| format!("{:.3}", mode.stiffness * 1e3));
        let tip =
            "Principal stiffnesses in ascending order, at the equilibrium or else at the bead's position";
        fact(ui, ("Stiffness", tip), format!("{weak}, {middle}, {strong} mN/m"));
    });
    if let Some(warning) = warning {
        ui.label(RichText::new(warning.as_str()).color(theme::warning(ui.visuals())));
    }
    ui.horizontal(|ui| {
        ui.label("Force / µN against place / mm:");
        for (name, colour) in ["x", "y", "z"].into_iter().zip(COLOURS) {
            ui.label(RichText::new(name).color(colour).strong());
        }
    })
    .response
    .on_hover_text(
        "Radiation force along each axis through the point. Grey: the weight, to be balanced along z",
    );
    let plot = still_plot("force along axes", HEIGHT).grid_spacing(8.0..=120.0);
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
