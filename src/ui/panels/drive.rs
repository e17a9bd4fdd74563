//! The Drive page: phase and amplitude of every element.

use egui::{Color32, Sense, Ui};

use crate::field::phase_index;
use crate::picture::ColourMap;
use crate::studio::probe::Reading;
use crate::ui::panels::form::{choice, heading};
use crate::ui::panels::{fact, form};
use crate::ui::parts::{beam, trade};
use crate::ui::{editor::Editor, element_map, shown::Shown, sound::Sound, ticks};

/// Numbers of phases per period of boards.
const LEVELS: [(Option<u32>, &str); 8] = [
    (None, "ideal"),
    (Some(8), "8 phases"),
    (Some(10), "10 phases"),
    (Some(16), "16 phases"),
    (Some(32), "32 phases"),
    (Some(64), "64 phases"),
    (Some(128), "128 phases"),
    (Some(256), "256 phases"),
];

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    let Some(sound) = &shown.sound else {
        ui.label("Draw a target to get a drive.");
        return;
    };
    form(ui, "levels", |ui| {
        let tip = "Phases per period, as boards play; map and pressures follow";
        choice(ui, ("Quantised to", tip), &mut editor.levels, &LEVELS);
        let mean = sound.readings.iter().map(Reading::peak).sum::<f64>() / sound.readings.len().max(1) as f64;
        fact(ui, ("Mean pressure", "Over the focal points"), editor.view.convention.pressure(mean));
        let silent = sound.drive().amplitudes.iter().filter(|&&amplitude| amplitude == 0.0).count();
        if silent > 0 {
            fact(ui, ("Inactive", "Elements that are not driven"), format!("{silent} elements"));
        }
    });
    heading(ui, "Phase");
    let cyclic = ColourMap::Cyclic.table();
    map(editor, sound, ui, "Phase of every element", |n| cyclic[phase_index(sound.drive().phases[n])]);
    strip(ui, &cyclic, ["-180°", "0°", "180°"]);
    heading(ui, "Amplitude");
    let viridis = ColourMap::Viridis.table();
    let colour = |n: usize| viridis[(sound.drive().amplitudes[n] * 255.0).round().clamp(0.0, 255.0) as usize];
    map(editor, sound, ui, "Amplitude of every element", colour);
    strip(ui, &viridis, ["0", "0.5", "1"]);
    beam::panel::show(editor, ui);
    trade::panel::show(editor, ui);
}

/// The colours of a map with labels.
fn strip(ui: &mut Ui, table: &[[u8; 4]; 256], labels: [&str; 3]) {
    const SIZE: egui::Vec2 = egui::vec2(224.0, 8.0);
    let (rect, _) = ui.allocate_exact_size(SIZE + egui::vec2(0.0, 16.0), Sense::hover());
    let mut mesh = egui::Mesh::default();
    for (i, [r, g, b, _]) in table.iter().enumerate() {
        let x = |i: usize| rect.left() + SIZE.x * i as f32 / table.len() as f32;
        let part = egui::Rect::from_x_y_ranges(x(i)..=x(i + 1), rect.top()..=rect.top() + SIZE.y);
        mesh.add_colored_rect(part, Color32::from_rgb(*r, *g, *b));
    }
    ui.painter().add(mesh);
    let aligns = [egui::Align2::LEFT_TOP, egui::Align2::CENTER_TOP, egui::Align2::RIGHT_TOP];
    for ((label, align), part) in labels.into_iter().zip(aligns).zip([0.0, 0.5, 1.0]) {
        let at = egui::pos2(rect.left() + SIZE.x * part, rect.top() + SIZE.y + 1.0);
        ui.painter().text(at, align, label, egui::FontId::proportional(11.5), ui.visuals().text_color());
    }
}

fn map(editor: &Editor, sound: &Sound, ui: &mut Ui, name: &str, colour: impl Fn(usize) -> [u8; 4]) {
    // Until the scene is solved again, the drive may belong to another array.
    if sound.drive().phases.len() != editor.scene().elements() {
        return;
    }
    let (response, under) = element_map::show(ui, name, editor.scene(), Sense::hover(), |n| {
        let [r, g, b, _] = colour(n);
        (sound.drive().amplitudes[n] > 0.0).then(|| Color32::from_rgb(r, g, b))
    });
    if let Some(n) = under {
        let drive = sound.drive();
        response.on_hover_text_at_pointer(format!(
            "Element {n}: {}, amplitude {:.2}",
            ticks::signed(&format!("{:.0}°", drive.phases[n].to_degrees())),
            drive.amplitudes[n]
        ));
    }
}
