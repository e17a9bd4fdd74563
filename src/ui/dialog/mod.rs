//! The dialogs and messages of the window.

mod answer;
mod figure;
mod file;
mod film;
mod import;
pub(crate) mod options;
mod palette;
pub(crate) mod state;

use std::path::Path;

use egui::{Context, Id, Modal, RichText, ScrollArea, Ui};
use strum::VariantArray;

use crate::echo;
use crate::scene::Target;
use crate::ui::action::{Action, Group};
use crate::ui::board::BoardCommand;
use crate::ui::command::{Command, Purpose};
use crate::ui::{editor::Editor, keys, shown::Shown};
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
    let mut stays = true;
    let modal = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
        let width = if dialog == Dialog::Help { 640.0_f32 } else { 480.0 };
        ui.set_width(width.min(ctx.content_rect().width() - 40.0));
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
            Dialog::Help => {
                help(ui);
                stays = !answer(ui, ("Close", true), |_| ());
            }
        }
    });
    let dismissed = modal.should_close() && !dialog.insists();
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
        "“{}” was changed by another program since it was opened or saved here.",
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
        let tip = "Deletes the scene for good";
        discards = ui.button("Discard").on_hover_text(tip).clicked();
    });
    if recovers {
        commands.push(Command::Recover);
    } else if discards {
        commands.push(Command::Discard);
    }
    !recovers && !discards
}

fn help(ui: &mut Ui) {
    ui.heading("Keys and tools");
    ui.label(
        "The map shows the pressure of the sound on a plane. White rings are the focal points: where the array's waves arrive in \
         step. Draw shapes, and the array's phases follow at once.",
    );
    ui.add_space(4.0);
    let row = |ui: &mut Ui, keys: &str, what: &str| {
        ui.label(RichText::new(keys).strong());
        ui.label(what);
        ui.end_row();
    };
    let height = (ui.ctx().content_rect().height() - 180.0).min(540.0);
    ScrollArea::vertical().max_height(height).show(ui, |ui| {
        egui::Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
            for &group in Group::VARIANTS {
                for action in Action::all().into_iter().filter(|action| action.group() == group) {
                    let keys = action.shortcut(ui.ctx());
                    if !keys.is_empty() {
                        row(ui, &keys, &action.name());
                    }
                }
            }
            for (keys, what) in keys::HELP {
                row(ui, keys, what);
            }
        });
    });
    ui.add_space(8.0);
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
