//! The file dialog: a path to type, above the files of a folder.

use std::path::{Path, PathBuf};

use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Button, Key, RichText, ScrollArea, TextEdit, Ui};

use crate::echo;
use crate::studio::opening;
use crate::ui::command::{Command, Purpose};
use crate::ui::dialog::answer::{answer, is_entered};
use crate::ui::dialog::state::Entry;
use crate::ui::{IN_PAGE, dialog::state::Folder, editor::Editor, shown::Shown, theme};

/// Sizes of the file list and its surroundings in points.
const LIST: f32 = 260.0;
const AROUND: f32 = 230.0;

pub(super) fn show(
    (purpose, text): (Purpose, &mut String),
    (editor, shown): (&mut Editor, &Shown),
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    ui.heading(purpose.title());
    let is_new = !std::mem::replace(&mut editor.asking.is_open, true);
    if is_new {
        // The list shows the folder of the suggestion, if it names one.
        let folder = Path::new(text.as_str()).parent().filter(|folder| !folder.as_os_str().is_empty());
        commands.push(Command::List(folder.map(Path::to_owned)));
    }
    let label = ui.label("File");
    let field = ui.add(TextEdit::singleline(text).desired_width(f32::INFINITY)).labelled_by(label.id);
    if field.changed() && text.ends_with(std::path::MAIN_SEPARATOR) {
        commands.push(Command::List(Some(PathBuf::from(text.as_str()))));
    }
    let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if is_new && !purpose.reads() {
        select_stem(text, field.id, ui);
    }
    if is_new || (entered && ui.memory(|memory| memory.focused().is_none())) {
        field.request_focus();
    }
    let below = ui.cursor().top();
    if let Some((_, problem)) = editor.asking.problem.as_ref().filter(|(of, _)| of == text) {
        ui.label(RichText::new(echo::message(problem)).color(theme::error(ui.visuals())));
    }
    // A page writes downloads, without a folder.
    let is_listed = purpose.reads() || !IN_PAGE;
    if !is_listed {
        ui.weak("It becomes a download, and the page keeps a copy");
    }
    let folder = shown.folder.as_ref().filter(|_| is_listed);
    // The list gives way to the error, so that the dialog keeps its height.
    let room = LIST - (ui.cursor().top() - below);
    let is_typed = field.changed();
    let chosen =
        folder.is_some_and(|folder| list((purpose, text), (room, is_typed), folder, shown, ui, commands));
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

/// Selects the name of a file to write, without folder and ending.
fn select_stem(text: &str, field: egui::Id, ui: &Ui) {
    let (path, letters) = (Path::new(text), |text: &str| text.chars().count());
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else { return };
    let (stem, start) = (opening::stem(path), letters(text).saturating_sub(letters(name)));
    let (from, to) = (CCursor::new(start), CCursor::new(start + letters(&stem)));
    let mut state = TextEditState::load(ui.ctx(), field).unwrap_or_default();
    state.cursor.set_char_range(Some(CCursorRange::two(from, to)));
    state.store(ui.ctx(), field);
}

/// The folder and its files, in this room (points); typing scrolls to the first of that name. Returns whether a file was
/// confirmed.
fn list(
    (purpose, text): (Purpose, &mut String),
    (room, is_typed): (f32, bool),
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
        if home.on_hover_text("To your home folder").clicked()
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
    let below = ui.cursor().top();
    if let Some(problem) = &folder.problem {
        ui.label(RichText::new(echo::message(problem)).color(theme::error(ui.visuals())));
    }
    let room = room - (ui.cursor().top() - below);
    let height = room.min(ui.ctx().content_rect().height() - AROUND).max(60.0);
    let entries: Vec<_> =
        folder.entries.iter().filter(|entry| entry.is_folder || purpose.takes(&entry.name)).collect();
    let mut chosen = false;
    let area = ScrollArea::vertical().max_height(height).auto_shrink([false, false]);
    let area = area.id_salt(&folder.path);
    if entries.is_empty() {
        let endings: Vec<_> = purpose.extensions().iter().map(|ending| ending.to_uppercase()).collect();
        area.show(ui, |ui| ui.weak(format!("No {} files here", endings.join(", "))));
        return false;
    }
    let typed = Path::new(text.as_str()).file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let begins = |entry: &&Entry| entry.name.to_lowercase().starts_with(&typed);
    let place = entries.iter().position(begins).filter(|_| is_typed && !typed.is_empty());
    let row_height = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
    let area = match place {
        Some(place) => area.vertical_scroll_offset(place as f32 * row_height),
        None => area,
    };
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
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::ui::document::Document;
    use crate::ui::{command::Export, dialog::state::Dialog};

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
