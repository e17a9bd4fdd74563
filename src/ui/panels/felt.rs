//! The Felt page: the skin, what a hand feels, and the primaries of touch.

use egui::{RichText, Slider, Ui};

use crate::echo;
use crate::field::Quantity;
use crate::scene::{Curve, Skin, Threshold, UNCERTAINTY};
use crate::studio::felt::{self, Felt, Speeds};
use crate::studio::primaries::{self, Primaries};
use crate::ui::command::Purpose;
use crate::ui::dialog::state::Dialog;
use crate::ui::editor::Editor;
use crate::ui::measure;
use crate::ui::palm;
use crate::ui::panels::form::{choice, heading, variants};
use crate::ui::panels::{MM, Unit, bare_number, caption, fact, form, number, value};
use crate::ui::theme;
use crate::ui::view::{Cut, View};

const SPEED: Unit = Unit { per: 1.0, suffix: " m/s", decimals: 2, speed: 0.05 };
const VISCOSITY: Unit = Unit { per: 1.0, suffix: " Pa·s", decimals: 2, speed: 0.05 };
const DENSITY: Unit = Unit { per: 1.0, suffix: " kg/m³", decimals: 0, speed: 1.0 };
const PERCENT: Unit = Unit { per: 100.0, suffix: " %", decimals: 0, speed: 0.5 };
/// Points of the screen.
const NUMBER: f32 = 54.0;
/// m, of a layer that is put on bone.
const FIRST_DEPTH: f64 = 0.008;

pub fn show(editor: &mut Editor, ui: &mut Ui) {
    figures(editor, ui);
    primaries(editor, ui);
    skin(editor, ui);
}

/// The levels, with their uncertainty.
fn figures(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "What is felt");
    if !editor.view.quantity.declaration().is_level() {
        ui.label("On the map, the skin is the plane in view; the figures are of the scene plane.");
        if ui.button("Show what is felt").clicked() {
            show_level(&mut editor.view);
        }
    }
    let figures = match editor.parts.feeling.newest() {
        None => return,
        Some(Err(why)) => {
            ui.label(why);
            return;
        }
        Some(Ok(figures)) => figures,
    };
    let Felt { level, pressure, flutter, vibration, position, strokes, share, speeds } = &figures.felt;
    let [absolute, between] = UNCERTAINTY;
    form(ui, "felt", |ui| {
        let tip = "The largest of the three channels, relative to the threshold. From 80 Hz on, sensation adds up over the palm";
        fact(ui, ("Level", tip), decibels(*level));
        let channels = [
            ("Pressure", "Below 20 Hz", pressure),
            ("Flutter", "20 to 60 Hz", flutter),
            ("Vibration", "Above 60 Hz", vibration),
        ];
        for (name, tip, level) in channels {
            fact(ui, (name, tip), decibels(*level));
        }
        if let Some(at) = position {
            let [x, y, z] = at.to_array().map(measure::mm);
            fact(ui, ("Most at", "x, y, z of the largest local level"), format!("{x}, {y}, {z} mm"));
        }
        if let Some(share) = share {
            let tip = "Fraction of the drawn strokes above the threshold";
            fact(ui, ("Drawing felt", tip), format!("{:.0} %", 100.0 * share));
            let levels = strokes.iter().map(|stroke| stroke.level);
            let most = decibels(levels.clone().fold(felt::FLOOR, f64::max));
            let least = decibels(levels.fold(f64::INFINITY, f64::min));
            let text = if least == most { most } else { format!("{least} to {most}") };
            let tip = "Highest local level of a stroke: weakest and strongest stroke";
            fact(ui, ("Strokes", tip), text);
        }
        if let Some(Speeds { own, best }) = speeds {
            let tip = "The speed at which the skin moves most along this path, by the model, and its own";
            fact(ui, ("Best speed", tip), format!("{best:.1} m/s; now {own:.1} m/s"));
        }
    });
    let mut trust = format!("± {absolute:.0} dB absolute, ± {between:.0} dB between levels");
    if editor.parts.feeling.exact().is_none() {
        trust.push_str("; being computed anew");
    }
    ui.label(RichText::new(trust).weak()).on_hover_text("Thresholds depend on contact, body site and person");
    for warning in &figures.warnings {
        ui.label(RichText::new(warning).color(theme::warning(ui.visuals())));
    }
}

/// A level over the threshold.
pub fn decibels(level: f64) -> String {
    if level > felt::FLOOR { format!("{level:.1} dB") } else { "not felt".to_owned() }
}

/// The map of what is felt, on a plane parallel to the array or that of the scene.
fn show_level(view: &mut View) {
    view.quantity = Quantity::Felt;
    if matches!(view.cut, Cut::Xz | Cut::Yz) {
        view.cut = Cut::Xy;
        view.window = None;
    }
}

/// The skin on the plane. A change of the usual one writes it to the scene.
fn skin(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "Skin");
    let skin = &mut editor.document.scene.skin;
    let mut is_there = skin.is_some();
    let tip = "Saves the skin with the scene, so that the command line reports what is felt. Off: default skin where needed";
    if ui.checkbox(&mut is_there, "Skin on the plane").on_hover_text(tip).changed() {
        *skin = is_there.then(Skin::default);
    }
    let mut set = skin.clone().unwrap_or_default();
    let mut asks_for_file = false;
    form(ui, "skin", |ui| {
        let tip = "Of surface waves on skin without viscosity; 7 m/s on a fingertip";
        number(ui, ("Wave speed", tip), &mut set.wave_speed, SPEED, 0.5..=100.0);
        let tip = "Damps waves on the skin";
        number(ui, ("Viscosity", tip), &mut set.viscosity, VISCOSITY, 0.01..=1e3);
        let tip = "With the wave speed, the stiffness of the skin";
        number(ui, ("Density", tip), &mut set.density, DENSITY, 100.0..=1e4);
        depth(&mut set.depth, ui);
        asks_for_file = threshold(&mut set, ui);
    });
    if set != skin.clone().unwrap_or_default() {
        *skin = Some(set);
    }
    if asks_for_file {
        editor.dialog = Some(Dialog::path(Purpose::Thresholds, &editor.document));
    }
}

/// Half-space, or the thickness of a layer.
fn depth(depth: &mut Option<f64>, ui: &mut Ui) {
    let mut is_layer = depth.is_some();
    let tip = "Thickness of the skin over bone. Off: unlimited";
    if ui.checkbox(&mut is_layer, "On bone").on_hover_text(tip).changed() {
        *depth = is_layer.then_some(FIRST_DEPTH);
    }
    value(ui, |ui| match depth {
        Some(depth) => {
            bare_number(ui, depth, MM, 5e-4..=0.1).on_hover_text(tip).accessible_name("Depth on bone");
        }
        None => {
            ui.add_space(ui.spacing().button_padding.x);
            ui.label("deep");
        }
    });
    ui.end_row();
}

/// The choice of a curve. Returns whether a file is asked for.
fn threshold(skin: &mut Skin, ui: &mut Ui) -> bool {
    let mut chosen = skin.known();
    let curves = variants::<Threshold>(Into::into).into_iter().map(|(curve, name)| (Some(curve), name));
    let curves: Vec<_> = curves.chain([(None, "file")]).collect();
    let tip = "The displacement that is just felt, by frequency. Hand: the whole hand on a handle (Morioka and Griffin 2006). \
               Psychohaptic: the curve of MPEG. Afferents: the nerve fibre that fires first (TouchSim). File: a CSV";
    choice(ui, ("Threshold", tip), &mut chosen, &curves);
    let mut asks_for_file = chosen.is_none() && skin.known().is_some();
    if let Some(curve) = chosen.filter(|_| chosen != skin.known()) {
        (skin.threshold, skin.curve) = (curve.into_str().to_owned(), Curve::default());
    }
    if skin.known().is_none() {
        fact(
            ui,
            ("Curve", "CSV with frequency (Hz) and displacement (m, peak)"),
            echo::value(&skin.threshold).to_string(),
        );
        caption(ui, "");
        let button = value(ui, |ui| ui.button("Choose…")).on_hover_text("Another CSV file");
        asks_for_file |= button.clicked();
        ui.end_row();
    }
    asks_for_file
}

/// Sliders of pressure, flutter and vibration, and the palm that feels them.
fn primaries(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "Primaries");
    let scene = &mut editor.document.scene;
    let mut mixed = Primaries::of(scene);
    let before = mixed;
    form(ui, "primaries", |ui| {
        let obstacle = primaries::has_other_motion(scene)
            .then_some("The targets have another motion: set its path to none on the Motion page");
        let tip = "Targets circle at 5 Hz with a radius up to 4 mm, which people feel as steady pressure (Morisaki 2022); thresholds \
                   are of vibrations, so levels do not say so";
        slider(ui, ("Pressure", tip), &mut mixed.pressure, 1.0, obstacle);
        let tip = "Depth of a 30 Hz tone; with Vibration at most 100 %. Replaces the modulation";
        let rest = 1.0 - mixed.vibration;
        slider(ui, ("Flutter, 30 Hz", tip), &mut mixed.flutter, rest, None);
        let tip = "Depth of a 150 Hz tone; with Flutter at most 100 %. Replaces the modulation";
        let rest = 1.0 - mixed.flutter;
        slider(ui, ("Vibration, 150 Hz", tip), &mut mixed.vibration, rest, None);
    });
    if mixed != before {
        mixed.apply(scene);
    }
    let [length, width] = palm::SIZE;
    let text = format!("Palm over the map, {length:.0} × {width:.0} mm");
    ui.checkbox(&mut editor.view.palm, text).on_hover_text("An adult's hand to scale, on XY");
}

/// A part of a whole as a slider, up to `most`, with its number; or the reason why it cannot be set.
fn slider(ui: &mut Ui, (name, tip): (&str, &str), part: &mut f64, most: f64, obstacle: Option<&str>) {
    let label = caption(ui, name).on_hover_text(tip);
    ui.add_enabled_ui(obstacle.is_none(), |ui| {
        value(ui, |ui| {
            // Of the same width with any number, so that sliders align.
            ui.spacing_mut().interact_size.x = NUMBER;
            let number = bare_number(ui, part, PERCENT, 0.0..=most);
            number
                .labelled_by(label.id)
                .on_hover_text(tip)
                .on_disabled_hover_text(obstacle.unwrap_or_default());
            // A value rounded by the slider would count as changed.
            let mut percent = (100.0 * *part).round();
            let slider = Slider::new(&mut percent, 0.0..=100.0).max_decimals(0).show_value(false);
            let slid = ui.add(slider).accessible_name(format!("{name} slider"));
            let slid = slid.on_hover_text(tip).on_disabled_hover_text(obstacle.unwrap_or_default());
            if slid.changed() && percent.is_finite() {
                *part = (percent / 100.0).clamp(0.0, most.max(0.0));
            }
        });
    });
    ui.end_row();
}
