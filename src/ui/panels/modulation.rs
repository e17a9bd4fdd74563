//! The panel of the modulation: waveform, law, tones and a waveform file.

use std::ops::RangeInclusive;

use egui::Ui;

use crate::echo;
use crate::scene::{Envelope, Law, MOST_TONES, Modulation, Tone, frequencies};
use crate::ui::panels::form::{choice, heading, variants};
use crate::ui::panels::{DEGREES, Unit, bare_number, caption, fact, form, number, value};
use crate::ui::{command::Purpose, dialog::state::Dialog, editor::Editor};

const HERTZ: Unit = Unit { per: 1.0, suffix: " Hz", decimals: 1, speed: 1.0 };
const PERCENT: Unit = Unit { per: 100.0, suffix: " %", decimals: 0, speed: 0.5 };

/// The modulation of the scene.
pub fn show(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "Modulation");
    let carrier = editor.scene().array.frequency;
    if settings(&mut editor.document.scene.modulation, carrier, ui) {
        editor.dialog = Some(Dialog::path(Purpose::Waveform(None), &editor.document));
    }
    let own = editor.scene().targets.iter().filter(|it| it.visible && it.modulation.is_some()).count();
    if own > 0 {
        let whose =
            if own == 1 { "1 target has its".to_owned() } else { format!("{own} targets have their") };
        ui.label(format!("{whose} own modulation; see the Scene panel."));
    }
    if let Some(heard) = editor.parts.demodulation.newest().and_then(Option::as_ref) {
        let tip = "Self-demodulation of the beam in air: what is heard on its axis, far away, referred to 1 m (Berktay), ± 6 dB. A modulation \
                   of the power is not distorted";
        ui.label(format!("Heard at 1 m: {}", heard.words())).on_hover_text(tip);
    }
}

/// The own modulation of a target, if it has one.
pub fn of_target(editor: &mut Editor, index: usize, ui: &mut Ui) {
    let scene = &mut editor.document.scene;
    let Some(target) = scene.targets.get_mut(index) else { return };
    let mut has_own = target.modulation.is_some();
    ui.checkbox(&mut has_own, "Own modulation").on_hover_text(
        "Instead of the scene's modulation. Targets with different modulations are played as frames, by boards with amplitudes",
    );
    if !has_own {
        target.modulation = None;
        return;
    }
    let own = target.modulation.get_or_insert_with(|| scene.modulation.clone());
    if settings(own, scene.array.frequency, ui) {
        editor.dialog = Some(Dialog::path(Purpose::Waveform(Some(index)), &editor.document));
    }
}

/// The widgets of a modulation of a carrier (Hz). Returns whether a file is to be chosen.
fn settings(modulation: &mut Modulation, carrier: f64, ui: &mut Ui) -> bool {
    let range = frequencies(carrier);
    let mut shape = modulation.shape;
    let mut asks_for_file = false;
    form(ui, "modulation", |ui| {
        let shapes = variants::<Envelope>(Into::into);
        let tip = "Waveform; skin feels modulated sound, not steady sound";
        choice(ui, ("Amplitude modulation", tip), &mut shape, &shapes);
        if modulation.shape == Envelope::Off {
            return;
        }
        let laws = [(Law::Amplitude, "amplitude"), (Law::Power, "power")];
        let tip = "What has the waveform: the amplitude of the sound, or its square, and with it the radiation pressure";
        choice(ui, ("Waveform of", tip), &mut modulation.law, &laws);
        match modulation.shape {
            Envelope::Off | Envelope::Tones => {}
            Envelope::Sine | Envelope::Square => {
                let tip = "Modulation frequency; skin is most sensitive near 200 Hz";
                number(ui, ("Frequency", tip), &mut modulation.frequency, HERTZ, range.clone());
                depth(modulation, ui);
            }
            Envelope::File => {
                depth(modulation, ui);
                file(modulation, ui);
                caption(ui, "");
                let button = value(ui, |ui| ui.button("Choose…")).on_hover_text("Another WAV file");
                asks_for_file = button.clicked();
                ui.end_row();
            }
        }
    });
    if modulation.shape == Envelope::Tones {
        tones(&mut modulation.tones, &range, ui);
    }
    if shape != modulation.shape {
        asks_for_file = choose(modulation, shape, &range);
    }
    asks_for_file
}

/// Selects a waveform; returns whether a file is required first.
fn choose(modulation: &mut Modulation, shape: Envelope, range: &RangeInclusive<f64>) -> bool {
    if shape == Envelope::File && modulation.wave.get().is_none() {
        return true;
    }
    if shape == Envelope::Tones && modulation.tones.is_empty() {
        let (frequency, depth) = (modulation.frequency, modulation.depth / 2.0);
        let second = (1.25 * frequency).min(*range.end());
        modulation.tones =
            [frequency, second].map(|frequency| Tone { frequency, depth, phase: 0.0 }).to_vec();
    }
    modulation.shape = shape;
    false
}

fn depth(modulation: &mut Modulation, ui: &mut Ui) {
    let tip = match modulation.law {
        Law::Amplitude => "Of the amplitude; 100 % reaches zero",
        Law::Power => "Of the power; 100 % reaches zero",
    };
    number(ui, ("Modulation depth", tip), &mut modulation.depth, PERCENT, 0.0..=1.0);
}

fn file(modulation: &Modulation, ui: &mut Ui) {
    fact(ui, ("Waveform", "WAV file, repeated"), echo::value(&modulation.file).to_string());
    if let Some(samples) = modulation.wave.get() {
        let length = format!("{:.3} s at {} Hz", samples.period(), samples.rate);
        fact(ui, ("Length", "Of a repetition"), length);
    }
}

/// A row for each tone; together they have a depth of 100 % at most.
fn tones(tones: &mut Vec<Tone>, range: &RangeInclusive<f64>, ui: &mut Ui) {
    let mut removed = None;
    let all: f64 = tones.iter().map(|tone| tone.depth).sum();
    let count = tones.len();
    egui::Grid::new("tones").num_columns(4).spacing([6.0, 5.0]).show(ui, |ui| {
        for (index, tone) in tones.iter_mut().enumerate() {
            let number = index + 1;
            let rest = (1.0 - all + tone.depth).clamp(0.0, 1.0);
            let field = bare_number(ui, &mut tone.frequency, HERTZ, range.clone());
            field.on_hover_text("Frequency").accessible_name(format!("Tone {number} frequency"));
            let field = bare_number(ui, &mut tone.depth, PERCENT, 0.0..=rest);
            field
                .on_hover_text("Depth; all tones together have 100 % at most")
                .accessible_name(format!("Tone {number} depth"));
            let turn = std::f64::consts::TAU;
            let field = bare_number(ui, &mut tone.phase, DEGREES, -turn..=turn);
            field.on_hover_text("Phase of the sine").accessible_name(format!("Tone {number} phase"));
            let button = ui.add_enabled(count > 1, egui::Button::new("×"));
            let button =
                button.on_hover_text("Remove this tone").accessible_name(format!("Remove tone {number}"));
            if button.clicked() {
                removed = Some(index);
            }
            ui.end_row();
        }
    });
    if let Some(index) = removed {
        tones.remove(index);
    }
    let add = ui.add_enabled(count < MOST_TONES, egui::Button::new("Add a tone"));
    if add.clicked() {
        let frequency = tones.last().map_or(200.0, |tone| (tone.frequency + 50.0).min(*range.end()));
        tones.push(Tone { frequency, depth: (1.0 - all).clamp(0.0, 1.0), phase: 0.0 });
    }
}
