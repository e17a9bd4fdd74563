//! The dialog for exporting a film of the motion.

use egui::{ComboBox, DragValue, Ui};

use crate::picture::animation::Pace;
use crate::scene::motion;
use crate::studio::animate::{Kind, RATES};
use crate::ui::command::{Export, Purpose};
use crate::ui::dialog::answer::answer;
use crate::ui::{editor::Editor, shown::Shown};

/// Pixels that a film may be wide.
const WIDTHS: [usize; 2] = [200, 4096];
/// s
const LONGEST: f64 = 10.0;

/// Draws the dialog, and returns whether it stays open.
pub(super) fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) -> bool {
    ui.heading("Export motion");
    let size = shown.map.as_ref().map(|map| editor.film.size(map, ui.ctx().pixels_per_point()));
    let schedule = editor.film.schedule(editor.scene(), &editor.view);
    let moves = motion::moves(editor.scene());
    let (count, real) = match &schedule {
        Ok(Some(schedule)) => (schedule.pictures, schedule.rate()),
        Ok(None) | Err(_) => motion::cycle(editor.scene())
            .map_or((1, 1.0), |cycle| (cycle.frames as usize, cycle.frames_per_second())),
    };
    let pace = editor.film.rate().map_or_else(|| Pace::new(real), |rate| Pace::chosen(rate, real));
    let of_liquid = editor.view.quantity.declaration().of_liquid;
    let form = &mut editor.film;
    egui::Grid::new("film").num_columns(2).show(ui, |ui| {
        ui.label("Format");
        let combo = ComboBox::from_id_salt("kind").selected_text(form.kind.into_str());
        combo.show_ui(ui, |ui| {
            for kind in Kind::writable() {
                ui.selectable_value(&mut form.kind, kind, kind.into_str());
            }
        });
        ui.end_row();
        if let Some((width, height)) = size {
            let label = ui.label("Width");
            ui.horizontal(|ui| {
                let mut own = width;
                let field = DragValue::new(&mut own).range(WIDTHS[0]..=WIDTHS[1]).suffix(" px");
                if ui.add(field).labelled_by(label.id).changed() {
                    form.width = Some(own);
                }
                ui.label(format!("× {height} px"));
            });
            ui.end_row();
        }
        let label = ui.label("Frame rate");
        let mut rate = 1.0 / pace.per_frame;
        let field = DragValue::new(&mut rate).range(RATES[0]..=form.kind.most_rate()).max_decimals(2);
        if ui.add(field.suffix(" per second")).labelled_by(label.id).changed() {
            form.rate = Some(rate);
        }
        ui.end_row();
        if let Ok(Some(schedule)) = &schedule {
            let label = ui.label("Duration");
            let mut seconds = schedule.pictures as f64 / schedule.rate();
            let field = DragValue::new(&mut seconds).range(0.01..=LONGEST).speed(0.01).max_decimals(3);
            let tip = "Duration of the waves from the onset of the sound";
            if ui.add(field.suffix(" s")).labelled_by(label.id).on_hover_text(tip).changed() {
                form.seconds = Some(seconds);
            }
            ui.end_row();
        }
    });
    if of_liquid {
        let mut waves = form.waves || !moves;
        let tip = "The liquid follows the sound; otherwise every frame shows the surface at rest";
        let waves = ui.add_enabled(moves, egui::Checkbox::new(&mut waves, "Waves")).on_hover_text(tip);
        if waves.changed() {
            form.waves = !form.waves;
        }
    }
    ui.label(match &schedule {
        Ok(_) => summary(count, pace),
        Err(error) => error.clone(),
    });
    if matches!(form.kind, Kind::Mp4 | Kind::Webm) {
        ui.weak("The program ffmpeg encodes videos; it must be on PATH.");
    }
    ui.add_space(8.0);
    let mut stays = true;
    let exports = answer(ui, ("Export…", size.is_some() && schedule.is_ok()), |ui| {
        stays = !ui.button("Close").clicked();
    });
    if exports {
        let purpose = Purpose::Export(Export::Motion(editor.film.kind));
        editor.ask_for_file(purpose);
    }
    stays && !exports
}

fn summary(count: usize, pace: Pace) -> String {
    let seconds = count as f64 * pace.per_frame;
    let playback = match pace.slowed {
        slowed if slowed > 1.001 => format!("playback 1/{slowed:.1}"),
        slowed if slowed < 0.999 => format!("playback {:.1} ×", 1.0 / slowed),
        _ => "in real time".to_owned(),
    };
    format!("{count} frames in {seconds:.2} s, {playback}")
}
