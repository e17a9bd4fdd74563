//! The dialogs and messages of the window.

mod about;
mod answer;
mod figure;
mod file;
mod film;
mod help;
mod import;
mod manual;
mod measured;
pub(crate) mod options;
mod palette;
pub(crate) mod state;

use std::path::Path;

use egui::{Align2, Context, Id, Modal, Ui};

use crate::echo;
use crate::scene::Target;
use crate::ui::board::BoardCommand;
use crate::ui::command::{Command, Purpose};
use crate::ui::{editor::Editor, gallery, shown::Shown};
use answer::{answer, hear_enter};

pub use import::Import;
pub use options::{FigureForm, FilmForm, Piece, Preview};
pub use state::{Asking, Dialog, Entry, Folder};

/// Draws the dialog that is open, if one is.
pub fn show(editor: &mut Editor, shown: &Shown, ctx: &Context, commands: &mut Vec<Command>) {
    if !matches!(editor.dialog, Some(Dialog::Path { .. })) {
        editor.asking.is_open = false;
    }
    let Some(mut dialog) = editor.dialog.take() else { return };
    hear_enter(ctx);
    let is_editing = ctx.memory(|memory| memory.focused().is_some());
    let mut stays = true;
    let id = Id::unique("dialog");
    let area = Modal::default_area(id);
    // The palette's field stays where it is when the list below it changes.
    let is_palette = matches!(dialog, Dialog::Palette { .. });
    let area = if is_palette { area.anchor(Align2::CENTER_TOP, [0.0, 72.0]) } else { area };
    let modal = Modal::new(id).area(area).show(ctx, |ui| {
        let is_page =
            matches!(dialog, Dialog::Examples | Dialog::Manual(_) | Dialog::Help | Dialog::Measured);
        let wide = if dialog == Dialog::Measured { 1200.0_f32 } else { 760.0 };
        let width = if is_page { wide } else { 480.0 };
        let width = width.min(ctx.content_rect().width() - 40.0);
        ui.set_width(width);
        match &mut dialog {
            Dialog::Path { purpose, text } => {
                stays = file::show((*purpose, text), (editor, shown), ui, commands);
            }
            Dialog::Replace { purpose, text, path } => {
                stays = replace((*purpose, text), path, editor, ui, commands);
            }
            Dialog::Unsaved(then) => stays = unsaved(then, editor, ui, commands),
            Dialog::Changed(path) => stays = changed(path, editor, ui, commands),
            Dialog::Message { title, text } => {
                ui.heading(title.as_str());
                ui.label(text.as_str());
                ui.add_space(8.0);
                stays = !answer(ui, ("Close", true), |_| ());
            }
            Dialog::Recovered { name, targets } => stays = recovered(name, *targets, ui, commands),
            Dialog::Loud(command) => stays = loud(command, editor, ui, commands),
            Dialog::Palette { text, chosen } => {
                stays = palette::show((text, chosen), (editor, shown), ui, commands);
            }
            Dialog::Import(import) => {
                if let Some(targets) = import.show(editor.scene(), ui) {
                    add(targets, editor);
                    stays = false;
                }
            }
            Dialog::Figure => stays = figure::show(editor, shown, ui, commands),
            Dialog::Film => stays = film::show(editor, shown, ui),
            Dialog::Measured => {
                measured::show(shown, ui);
                ui.add_space(8.0);
                stays = !answer(ui, ("Close", true), |_| ());
            }
            Dialog::Examples => {
                ui.heading("Examples");
                let height = (ctx.content_rect().height() - 170.0).clamp(100.0, 620.0);
                let is_chosen = gallery::show_cards((width, height), editor, shown, ui, commands);
                ui.add_space(8.0);
                stays = !answer(ui, ("Close", true), |_| ()) && !is_chosen;
            }
            Dialog::Manual(page) => {
                manual::show(page, ui);
                stays = !answer(ui, ("Close", true), |_| ());
            }
            Dialog::About => {
                about::show(shown, ui);
                stays = !answer(ui, ("Close", true), |_| ());
            }
            Dialog::Help => {
                help::show(ui);
                stays = !answer(ui, ("Close", true), |_| ());
            }
        }
    });
    // A dialog is centred by its size in the frame before: after a change it is drawn once more.
    let (place, before) = (modal.response.rect, ctx.data(|data| data.get_temp(id.with("place"))));
    if before != Some(place) {
        ctx.data_mut(|data| data.insert_temp(id.with("place"), place));
        ctx.request_repaint();
    }
    // In these, Esc first ends the editing of a number.
    let is_form = matches!(dialog, Dialog::Figure | Dialog::Film);
    let ends_editing = is_form && is_editing && ctx.input(|input| input.key_pressed(egui::Key::Escape));
    let dismissed = modal.should_close() && !dialog.insists() && !ends_editing;
    if dismissed {
        editor.after_saving = None;
    }
    // A dialog just opened by a button replaces the current one.
    if editor.dialog.is_none() && stays && !dismissed {
        editor.dialog = Some(dialog);
    }
}

/// Adds imported targets, and selects them.
fn add(targets: Vec<Target>, editor: &mut Editor) {
    if targets.is_empty() {
        return;
    }
    let own = &mut editor.document.scene.targets;
    let first = own.len();
    own.extend(targets);
    editor.selection = (first..editor.scene().targets.len()).collect();
}

/// The confirmation for overwriting a file.
fn replace(
    (purpose, text): (Purpose, &str),
    path: &Path,
    editor: &mut Editor,
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    ui.heading(format!("Replace “{}”?", echo::value(&name)));
    ui.label(format!(
        "{} already exists; its content would be lost.",
        echo::message(&path.display().to_string())
    ));
    ui.add_space(8.0);
    let mut stays = true;
    let replaces = answer(ui, ("Replace", true), |ui| {
        if ui.button("Cancel").clicked() {
            editor.dialog = Some(Dialog::Path { purpose, text: text.to_owned() });
            stays = false;
        }
    });
    if replaces {
        commands.push(purpose.command(path.to_owned()));
    }
    stays && !replaces
}

fn unsaved(then: &Command, editor: &mut Editor, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Save changes?");
    ui.label(format!("Your changes to “{}” have not been saved.", editor.document.name()));
    ui.add_space(8.0);
    let mut stays = true;
    let saves = answer(ui, ("Save", true), |ui| {
        if ui.button("Don't save").clicked() {
            commands.push(then.clone());
            stays = false;
        }
        stays &= !ui.button("Cancel").clicked();
    });
    if saves {
        editor.after_saving = Some(then.clone());
        match editor.document.path() {
            Some(_) => commands.push(Command::Save),
            None => editor.dialog = Some(Dialog::path(Purpose::SaveAs, &editor.document)),
        }
    }
    stays && !saves
}

fn changed(path: &Path, editor: &mut Editor, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Replace the newer file?");
    ui.label(format!(
        "Another program has changed “{}” since it was opened or saved here.",
        editor.document.name()
    ));
    ui.add_space(8.0);
    let mut stays = true;
    let saves_as = answer(ui, ("Save as…", true), |ui| {
        if ui.button("Replace").clicked() {
            commands.push(Command::Overwrite(path.to_owned()));
            stays = false;
        }
        if ui.button("Cancel").clicked() {
            editor.after_saving = None;
            stays = false;
        }
    });
    if saves_as {
        editor.dialog = Some(Dialog::path(Purpose::SaveAs, &editor.document));
    }
    stays && !saves_as
}

fn recovered(name: &str, targets: usize, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Recover unsaved work?");
    ui.label(format!(
        "Sonoglyph closed unexpectedly; “{}” ({targets} {}) was not saved.",
        echo::value(name),
        if targets == 1 { "target" } else { "targets" }
    ));
    ui.add_space(8.0);
    let mut discards = false;
    let recovers = answer(ui, ("Recover", true), |ui| {
        let tip = "Deletes the unsaved scene";
        discards = ui.button("Discard").on_hover_text(tip).clicked();
    });
    if recovers {
        commands.push(Command::Recover);
    } else if discards {
        commands.push(Command::Discard);
    }
    !recovers && !discards
}

/// Asks before the first sound of a run; the command waits for the answer.
pub(super) fn warn_of_loudness(editor: &mut Editor, commands: &mut Vec<Command>) {
    if editor.was_warned {
        return;
    }
    let sounds = |command: &Command| matches!(command, Command::Board(command) if command.sounds());
    if let Some(place) = commands.iter().position(sounds)
        && let Command::Board(command) = commands.remove(place)
    {
        editor.dialog = Some(Dialog::Loud(command));
    }
}

fn loud(command: &BoardCommand, editor: &mut Editor, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("The array will be loud.");
    ui.label(
        "Ultrasound of this strength can harm hearing although it is hardly heard. Protect your ears, keep your head out of the beam, \
         and mind other people and animals in the room. Esc twice stops the board.",
    );
    ui.add_space(8.0);
    let mut stays = true;
    let sends = answer(ui, ("Start sound", true), |ui| stays = !ui.button("Cancel").clicked());
    if sends {
        editor.was_warned = true;
        commands.push(Command::Board(command.clone()));
    }
    stays && !sends
}
