//! The file dialog: a path to type, above the files of a folder.

use std::path::{Path, PathBuf};

use egui::{Button, Key, RichText, ScrollArea, TextEdit, Ui};

use crate::echo;
use crate::picture::figure::Format;
use crate::studio::opening;
use crate::ui::dialog::{answer, is_entered};
use crate::ui::document::Document;
use crate::ui::{Command, Dialog, Editor, Export, IN_PAGE, Shown, theme};

/// Extensions of drawings.
pub const IMPORTED: &[&str] = &["svg", "png", "jpg", "jpeg", "bmp"];
/// Endings of tables of elements.
pub const ELEMENTS: &[&str] = &["csv", "pat"];
/// Sizes of the file list and its surroundings in points.
const LIST: f32 = 260.0;
const AROUND: f32 = 230.0;

/// The purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Open,
    SaveAs,
    /// A drawing that becomes targets.
    Import,
    /// A table of elements that becomes the array.
    Elements,
    /// Of the modulation.
    Waveform,
    Export(Export),
}

impl Purpose {
    /// For a file dropped on the window.
    pub fn of_dropped(path: &Path) -> Self {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            drawing if IMPORTED.contains(&drawing) => Self::Import,
            table if ELEMENTS.contains(&table) => Self::Elements,
            _ => Self::Open,
        }
    }

    pub fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a scene",
            Self::SaveAs => "Save the scene as",
            Self::Elements => "Take a table of elements (CSV, or PAT of OpenMPD)",
            Self::Import => "Import a drawing (SVG) or a picture of strokes (PNG, JPEG, BMP)",
            Self::Waveform => "Open a waveform of the modulation (WAV)",
            Self::Export(Export::Figure(_)) => "Export the figure",
            Self::Export(Export::Map) => "Export the map as PNG",
            Self::Export(Export::Sheet) => "Export the sheet as PNG",
            Self::Export(Export::Numbers) => "Export the map's numbers as NPY",
            Self::Export(Export::Drive) => "Export the drive as CSV",
            Self::Export(Export::Elements) => "Export the elements as CSV",
            Self::Export(Export::Profile) => "Export the line profile as CSV",
            Self::Export(Export::Motion(_)) => "Export the motion",
        }
    }

    /// Accepted extensions, the default first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Open | Self::SaveAs => opening::ENDINGS,
            Self::Import => IMPORTED,
            Self::Elements => ELEMENTS,
            Self::Waveform => &["wav"],
            Self::Export(Export::Figure(Format::Pdf)) => &["pdf"],
            Self::Export(Export::Figure(Format::Svg)) => &["svg"],
            Self::Export(Export::Figure(Format::Png) | Export::Map | Export::Sheet) => &["png"],
            Self::Export(Export::Numbers) => &["npy"],
            Self::Export(Export::Drive | Export::Profile | Export::Elements) => &["csv"],
            Self::Export(Export::Motion(kind)) => kind.endings(),
        }
    }

    /// Whether the file must exist.
    pub fn reads(self) -> bool {
        matches!(self, Self::Open | Self::Import | Self::Elements | Self::Waveform)
    }

    fn verb(self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::SaveAs => "Save",
            Self::Import | Self::Elements | Self::Waveform => "Read",
            Self::Export(_) => "Export",
        }
    }

    pub fn command(self, path: PathBuf) -> Command {
        match self {
            Self::Open => Command::Open(path),
            Self::SaveAs => Command::SaveAs(path),
            Self::Import => Command::Import(path),
            Self::Elements => Command::TakeElements(path),
            Self::Waveform => Command::Waveform(path),
            Self::Export(export) => Command::Export(export, path),
        }
    }

    /// The path with the default extension, if an output has none.
    pub fn with_ending(self, path: PathBuf) -> PathBuf {
        match path.extension() {
            None if !self.reads() => path.with_extension(self.extensions()[0]),
            _ => path,
        }
    }

    fn takes(self, name: &str) -> bool {
        let ending = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
        self.extensions().contains(&ending.as_str())
    }
}

impl Dialog {
    /// Opens the dialog with a suggestion.
    pub fn path(purpose: Purpose, document: &Document) -> Self {
        let name = document.name();
        let has_ending = Path::new(&name)
            .extension()
            .is_some_and(|ending| opening::ENDINGS.iter().any(|own| ending == *own));
        let stem = if has_ending { opening::stem(Path::new(&name)) } else { name };
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

/// The files of a folder, folders first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Folder {
    pub path: PathBuf,
    pub home: Option<PathBuf>,
    pub entries: Vec<Entry>,
    /// The reason for not showing the requested folder.
    pub problem: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub name: String,
    pub is_folder: bool,
}

/// The persistent state of the dialog.
#[derive(Clone, Debug, Default)]
pub struct Asking {
    /// The question was there in the frame before.
    pub(super) is_open: bool,
    /// A rejected answer with the reason.
    pub problem: Option<(String, String)>,
}

pub(super) fn show(
    (purpose, text): (Purpose, &mut String),
    (editor, shown): (&mut Editor, &Shown),
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    ui.heading(purpose.title());
    let is_new = !std::mem::replace(&mut editor.asking.is_open, true);
    if is_new {
        commands.push(Command::List(None));
    }
    let label = ui.label("File");
    let field = ui.add(TextEdit::singleline(text).desired_width(f32::INFINITY)).labelled_by(label.id);
    let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if is_new || (entered && ui.memory(|memory| memory.focused().is_none())) {
        field.request_focus();
    }
    if let Some((_, problem)) = editor.asking.problem.as_ref().filter(|(of, _)| of == text) {
        ui.label(RichText::new(echo::message(problem)).color(theme::error(ui.visuals())));
    }
    // A page writes downloads, without a folder.
    let is_listed = purpose.reads() || !IN_PAGE;
    if !is_listed {
        ui.weak("It becomes a download, and the page keeps a copy");
    }
    let folder = shown.folder.as_ref().filter(|_| is_listed);
    let chosen = folder.is_some_and(|folder| list(purpose, text, folder, shown, ui, commands));
    ui.add_space(8.0);
    let wanted = !text.trim().is_empty();
    let (mut stays, mut browses) = (true, false);
    let asked = answer(ui, (purpose.verb(), wanted), |ui| {
        browses = match (IN_PAGE, purpose.reads()) {
            (false, _) => {
                let tip = "Open the desktop's file dialog";
                ui.button("Desktop dialog…").on_hover_text(tip).clicked()
            }
            (true, true) => {
                ui.button("From this computer…").on_hover_text("Load a file into the page").clicked()
            }
            (true, false) => false,
        };
        stays = !ui.button("Cancel").clicked() && !browses;
    });
    if browses {
        commands.push(Command::Browse(purpose, text.clone()));
    } else if !stays {
        editor.after_saving = None;
    }
    if wanted && (asked || chosen || entered || is_entered(ui)) {
        commands.push(Command::Answer(purpose, text.trim().to_owned()));
    }
    stays
}

/// The folder and its files. Returns whether a file was confirmed.
fn list(
    purpose: Purpose,
    text: &mut String,
    folder: &Folder,
    shown: &Shown,
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    let mut go = |text: &mut String, to: PathBuf| {
        // An output keeps its name when the folder changes.
        let name = Path::new(text.as_str()).file_name().filter(|_| !purpose.reads());
        *text = name.map_or_else(String::new, |name| to.join(name).display().to_string());
        commands.push(Command::List(Some(to)));
    };
    ui.add_space(4.0);
    if IN_PAGE {
        ui.weak("What this page has opened or saved before; files can be dropped on it, too");
    }
    let row = |ui: &mut Ui| {
        let up = folder.path.parent();
        if ui.add_enabled(up.is_some(), Button::new("Up")).on_hover_text("To the folder above").clicked()
            && let Some(up) = up
        {
            go(text, up.to_owned());
        }
        let home = ui.add_enabled(folder.home.is_some(), Button::new("Home"));
        if home.on_hover_text("To your own folder").clicked()
            && let Some(home) = &folder.home
        {
            go(text, home.clone());
        }
        ui.menu_button("Recent folders", |ui| {
            let mut folders: Vec<_> = shown.recent.iter().filter_map(|path| path.parent()).collect();
            folders.dedup();
            if folders.is_empty() {
                ui.label("No file was opened or saved yet");
            }
            for recent in folders {
                if ui.button(recent.display().to_string()).clicked() {
                    go(text, recent.to_owned());
                    ui.close();
                }
            }
        });
        let path = folder.path.display().to_string();
        ui.add(egui::Label::new(RichText::new(path).strong()).truncate());
    };
    if !IN_PAGE {
        ui.horizontal(row);
    }
    if let Some(problem) = &folder.problem {
        ui.label(RichText::new(echo::message(problem)).color(theme::error(ui.visuals())));
    }
    let height = (ui.ctx().content_rect().height() - AROUND).clamp(60.0, LIST);
    let entries: Vec<_> =
        folder.entries.iter().filter(|entry| entry.is_folder || purpose.takes(&entry.name)).collect();
    let mut chosen = false;
    let area = ScrollArea::vertical().max_height(height).auto_shrink([false, false]);
    let area = area.id_salt(&folder.path);
    area.show_rows(ui, ui.spacing().interact_size.y, entries.len(), |ui, rows| {
        for entry in &entries[rows] {
            let path = folder.path.join(&entry.name);
            let name = if entry.is_folder { format!("{}/", entry.name) } else { entry.name.clone() };
            let is_meant = !entry.is_folder && Path::new(text.as_str()) == path;
            let row = Button::selectable(is_meant, (name, egui::Atom::grow())).truncate();
            let row = ui.add(row.min_size(egui::vec2(ui.available_width(), 0.0)));
            if row.clicked() && entry.is_folder {
                go(text, path);
            } else if row.clicked() {
                // A second click, or Enter on the row, opens it.
                chosen = is_meant && purpose.reads();
                *text = path.display().to_string();
            }
        }
    });
    if entries.is_empty() && folder.problem.is_none() {
        ui.weak(format!("No {} here", purpose.extensions().join(", ")));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn scenes_of_all_endings_are_listed_and_lend_exports_their_names() {
        for name in ["hit.toml", "hit.sonoglyph", "hit.sonoglyph.toml"] {
            assert!(Purpose::Open.takes(name), "{name}");
            let document = Document::new(Scene::default(), name);
            let Dialog::Path { text, .. } = Dialog::path(Purpose::Export(Export::Map), &document) else {
                panic!("{name}")
            };
            assert_eq!(text, "hit.png");
        }
        assert!(!Purpose::Open.takes("hit.csv"));
    }
}
