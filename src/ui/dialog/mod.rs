//! What is asked or said in the middle of the window.

pub mod figure;
pub mod import;

use std::path::{Path, PathBuf};

use egui::{Context, Id, Key, Modal, RichText, ScrollArea, TextEdit, Ui};

use crate::picture::figure::Format;
use crate::scene::Scene;
use crate::ui::document::Document;
use crate::ui::tool::Tool;
use crate::ui::{Command, Editor, Export, Shown, keys};
use import::Import;

/// A question or a message; nothing else is done meanwhile.
#[derive(Clone, Debug, PartialEq)]
pub enum Dialog {
    /// Which file?
    Path {
        purpose: Purpose,
        text: String,
    },
    /// What is not saved would be lost by this.
    Unsaved(Command),
    /// Another program has written to the file that is to be saved.
    Changed(PathBuf),
    /// What could not be done, and why.
    Message {
        title: String,
        text: String,
    },
    /// A scene that the last run did not save.
    Recovered(Box<Scene>),
    /// Where is this drawing to stand?
    Import(Box<Import>),
    /// What is a figure of the map to look like?
    Figure,
    Help,
}

/// Extensions of files that hold drawings.
pub const IMPORTED: &[&str] = &["svg", "png", "jpg", "jpeg", "bmp"];

/// What a file is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Open,
    SaveAs,
    /// A drawing that becomes targets.
    Import,
    Export(Export),
}

impl Purpose {
    pub fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a scene",
            Self::SaveAs => "Save the scene as",
            Self::Import => "Import a drawing (SVG) or a picture of strokes (PNG, JPEG, BMP)",
            Self::Export(Export::Figure(_)) => "Export the figure",
            Self::Export(Export::Map) => "Export the map as PNG",
            Self::Export(Export::Sheet) => "Export the sheet as PNG",
            Self::Export(Export::Numbers) => "Export the map's numbers as NPY",
            Self::Export(Export::Drive) => "Export the drive as CSV",
            Self::Export(Export::Motion) => "Export the motion as GIF or animated PNG",
        }
    }

    /// Of the files that will do, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Open | Self::SaveAs => &["toml"],
            Self::Import => IMPORTED,
            Self::Export(Export::Figure(Format::Pdf)) => &["pdf"],
            Self::Export(Export::Figure(Format::Svg)) => &["svg"],
            Self::Export(Export::Figure(Format::Png) | Export::Map | Export::Sheet) => &["png"],
            Self::Export(Export::Numbers) => &["npy"],
            Self::Export(Export::Drive) => &["csv"],
            Self::Export(Export::Motion) => &["gif", "png", "apng"],
        }
    }

    /// Whether the file is there already.
    pub fn reads(self) -> bool {
        matches!(self, Self::Open | Self::Import)
    }

    fn verb(self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::SaveAs => "Save",
            Self::Import => "Read",
            Self::Export(_) => "Export",
        }
    }

    pub fn command(self, path: PathBuf) -> Command {
        match self {
            Self::Open => Command::Open(path),
            Self::SaveAs => Command::SaveAs(path),
            Self::Import => Command::Import(path),
            Self::Export(export) => Command::Export(export, path),
        }
    }
}

impl Dialog {
    /// Asks for a file, with a proposal.
    pub fn path(purpose: Purpose, document: &Document) -> Self {
        let stem = document.name();
        let stem = stem.strip_suffix(".toml").unwrap_or(&stem);
        let text = match (purpose, document.path()) {
            (purpose, _) if purpose.reads() => String::new(),
            (Purpose::SaveAs, Some(path)) => path.display().to_string(),
            (_, path) => {
                let file = format!("{stem}.{}", purpose.extensions()[0]);
                let folder = path.and_then(|path| path.parent());
                folder.map_or_else(|| PathBuf::from(&file), |folder| folder.join(&file)).display().to_string()
            }
        };
        Self::Path { purpose, text }
    }
}

/// Draws the dialog that is open, if one is.
pub fn show(editor: &mut Editor, shown: &Shown, ctx: &Context, commands: &mut Vec<Command>) {
    let Some(mut dialog) = editor.dialog.take() else { return };
    let mut stays = true;
    let modal = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
        let width = if dialog == Dialog::Help { 640.0_f32 } else { 480.0 };
        ui.set_width(width.min(ctx.content_rect().width() - 40.0));
        match &mut dialog {
            Dialog::Path { purpose, text } => stays = path(*purpose, text, editor, ui, commands),
            Dialog::Unsaved(then) => stays = unsaved(then, editor, ui, commands),
            Dialog::Changed(path) => stays = changed(path, editor, ui, commands),
            Dialog::Message { title, text } => {
                ui.heading(title.as_str());
                ui.label(text.as_str());
                ui.add_space(8.0);
                stays = !ui.button("Close").clicked();
            }
            Dialog::Recovered(scene) => stays = recovered(scene, ui, commands),
            Dialog::Import(import) => stays = import.show(editor, ui),
            Dialog::Figure => stays = figure::show(editor, shown, ui, commands),
            Dialog::Help => {
                help(ui);
                stays = !ui.button("Close").clicked();
            }
        }
    });
    let dismissed = modal.should_close();
    if dismissed {
        editor.after_saving = None;
    }
    // What was just opened by a button goes before what stays.
    if editor.dialog.is_none() && stays && !dismissed {
        editor.dialog = Some(dialog);
    }
}

fn path(
    purpose: Purpose,
    text: &mut String,
    editor: &mut Editor,
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    ui.heading(purpose.title());
    let label = ui.label("File");
    let field = ui.add(TextEdit::singleline(text).desired_width(f32::INFINITY)).labelled_by(label.id);
    let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if !entered && ui.memory(|memory| memory.focused().is_none()) {
        field.request_focus();
    }
    ui.add_space(8.0);
    let mut stays = true;
    ui.horizontal(|ui| {
        let wanted = !text.trim().is_empty();
        if ui.add_enabled(wanted, egui::Button::new(purpose.verb())).clicked() || (entered && wanted) {
            editor.ask(purpose.command(PathBuf::from(text.trim())), commands);
            stays = false;
        }
        if ui.button("Browse…").on_hover_text("Ask the desktop for a file").clicked() {
            commands.push(Command::Browse(purpose));
            stays = false;
        }
        if ui.button("Cancel").clicked() {
            editor.after_saving = None;
            stays = false;
        }
    });
    stays
}

fn unsaved(then: &Command, editor: &mut Editor, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Save the changes?");
    ui.label(format!("“{}” has changes that no file holds.", editor.document.name()));
    ui.add_space(8.0);
    let mut stays = true;
    ui.horizontal(|ui| {
        if ui.button("Save").clicked() {
            editor.after_saving = Some(then.clone());
            match editor.document.path() {
                Some(_) => commands.push(Command::Save),
                None => editor.dialog = Some(Dialog::path(Purpose::SaveAs, &editor.document)),
            }
            stays = false;
        }
        if ui.button("Don't save").clicked() {
            commands.push(then.clone());
            stays = false;
        }
        if ui.button("Cancel").clicked() {
            stays = false;
        }
    });
    stays
}

fn changed(path: &Path, editor: &mut Editor, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Write over the other changes?");
    ui.label(format!(
        "“{}” was changed elsewhere since it was opened or saved here.",
        editor.document.name()
    ));
    ui.add_space(8.0);
    let mut stays = true;
    ui.horizontal(|ui| {
        if ui.button("Save as…").clicked() {
            editor.dialog = Some(Dialog::path(Purpose::SaveAs, &editor.document));
            stays = false;
        }
        if ui.button("Write over them").clicked() {
            commands.push(Command::Overwrite(path.to_owned()));
            stays = false;
        }
        if ui.button("Cancel").clicked() {
            editor.after_saving = None;
            stays = false;
        }
    });
    stays
}

fn recovered(scene: &Scene, ui: &mut Ui, commands: &mut Vec<Command>) -> bool {
    ui.heading("Go on where you were?");
    let count = scene.targets.len();
    ui.label(format!(
        "The last run ended without saving a scene with {count} {}.",
        if count == 1 { "target" } else { "targets" }
    ));
    ui.add_space(8.0);
    let mut stays = true;
    ui.horizontal(|ui| {
        if ui.button("Recover").clicked() {
            commands.push(Command::Recover(Box::new(scene.clone())));
            stays = false;
        }
        if ui.button("Discard").clicked() {
            stays = false;
        }
    });
    stays
}

fn help(ui: &mut Ui) {
    ui.heading("Keys and tools");
    ui.label(
        "The map shows the pressure of the sound on a plane. White dots are the focal points: where the array's waves arrive in \
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
        ui.horizontal_top(|ui| {
            egui::Grid::new("tools").striped(true).show(ui, |ui| {
                for tool in Tool::ALL {
                    row(ui, tool.key().name(), tool.name());
                }
            });
            ui.separator();
            egui::Grid::new("keys").striped(true).show(ui, |ui| {
                for (keys, what) in keys::HELP {
                    row(ui, keys, what);
                }
            });
        });
    });
    ui.add_space(8.0);
}
