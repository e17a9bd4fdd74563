//! The menus and the tools.

use std::path::PathBuf;

use egui::containers::menu::MenuBar;
use egui::{Button, DragValue, KeyboardShortcut, ProgressBar, Sense, Stroke, Theme, Ui, vec2};

use crate::scene::motion;
use crate::ui::tool::{self, Tool};
use crate::ui::{Command, Dialog, Editor, Export, Purpose, Shown, keys, theme};

pub fn bar(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(editor, shown, ui, commands));
        ui.menu_button("Edit", |ui| edit(editor, ui));
        ui.menu_button("Examples", |ui| {
            let height = ui.ctx().content_rect().height() - 60.0;
            egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
                for (index, name) in shown.examples.iter().enumerate() {
                    if ui.button(name).clicked() {
                        editor.ask(Command::Example(index), commands);
                        ui.close();
                    }
                }
            });
        });
        ui.menu_button("Export", |ui| {
            if ui.button("Figure…").on_hover_text("With axes and colour bar: PDF, SVG or PNG").clicked() {
                editor.dialog = Some(Dialog::Figure);
            }
            for (name, export) in [
                ("Map as PNG…", Export::Map),
                ("Sheet as PNG…", Export::Sheet),
                ("Map's numbers as NPY…", Export::Numbers),
                ("Drive as CSV…", Export::Drive),
                ("Motion as GIF or animated PNG…", Export::Motion),
            ] {
                let moves = motion::moves(editor.scene());
                let button = ui.add_enabled(export != Export::Motion || moves, Button::new(name));
                if button.on_disabled_hover_text("Nothing moves: choose a path in the Motion panel").clicked()
                {
                    editor.dialog = Some(Dialog::path(Purpose::Export(export), &editor.document));
                }
            }
        });
        ui.menu_button("Help", |ui| {
            if ui.add(Button::new("Keys and tools").shortcut_text("F1")).clicked() {
                editor.dialog = Some(Dialog::Help);
            }
        });
        ui.separator();
        let unsaved = if editor.document.is_unsaved() { " •" } else { "" };
        ui.strong(format!("{}{unsaved}", editor.document.name())).on_hover_text(
            editor
                .document
                .path()
                .map_or_else(|| "No file yet".to_owned(), |path| path.display().to_string()),
        );
        if let Some((name, part)) = &shown.export {
            ui.separator();
            let bar = ProgressBar::new(*part).desired_width(120.0).text(format!("{:.0} %", part * 100.0));
            ui.add(bar).on_hover_text(format!("Writing {name}"));
            if ui
                .button("Call off")
                .on_hover_text(format!("Ends the export; {name} is not written"))
                .clicked()
            {
                commands.push(Command::CallOff);
            }
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let dark = ui.visuals().dark_mode;
            let (sign, to) = if dark { ("Light", Theme::Light) } else { ("Dark", Theme::Dark) };
            if ui.button(sign).on_hover_text("Colours of the window").clicked() {
                ui.ctx().set_theme(to);
            }
        });
    });
}

fn item(ui: &mut Ui, enabled: bool, name: &str, shortcut: &KeyboardShortcut) -> bool {
    let keys = ui.ctx().format_shortcut(shortcut);
    ui.add_enabled(enabled, Button::new(name).shortcut_text(keys)).clicked()
}

fn file(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    if item(ui, true, "New", &keys::NEW) {
        editor.ask(Command::New, commands);
    }
    if item(ui, true, "Open…", &keys::OPEN) {
        editor.dialog = Some(Dialog::path(Purpose::Open, &editor.document));
    }
    ui.add_enabled_ui(!shown.recent.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| recent(editor, &shown.recent, ui, commands));
    });
    ui.separator();
    if item(ui, true, "Save", &keys::SAVE) {
        commands.push(Command::Save);
    }
    if item(ui, true, "Save as…", &keys::SAVE_AS) {
        editor.dialog = Some(Dialog::path(Purpose::SaveAs, &editor.document));
    }
    ui.separator();
    if ui.button("Import drawing…").on_hover_text("Paths of an SVG, or dark strokes of a picture").clicked()
    {
        editor.dialog = Some(Dialog::path(Purpose::Import, &editor.document));
    }
    ui.separator();
    if item(ui, true, "Quit", &keys::CLOSE) {
        editor.ask(Command::Close, commands);
    }
}

fn recent(editor: &mut Editor, recent: &[PathBuf], ui: &mut Ui, commands: &mut Vec<Command>) {
    for path in recent {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
            editor.ask(Command::Open(path.clone()), commands);
        }
    }
    ui.separator();
    if ui.button("Forget these").clicked() {
        commands.push(Command::ForgetRecent);
    }
}

fn edit(editor: &mut Editor, ui: &mut Ui) {
    if item(ui, editor.document.can_undo(), "Undo", &keys::UNDO) {
        editor.undo();
    }
    if item(ui, editor.document.can_redo(), "Redo", &keys::REDO) {
        editor.redo();
    }
    ui.separator();
    let any = !editor.selection.is_empty();
    if item(ui, any, "Cut", &keys::CUT) {
        keys::copy(editor, ui.ctx());
        keys::delete(editor);
    }
    if item(ui, any, "Copy", &keys::COPY) {
        keys::copy(editor, ui.ctx());
    }
    if item(ui, true, "Paste", &keys::PASTE) {
        // It comes as an event in the next frame.
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::RequestPaste);
    }
    if item(ui, any, "Duplicate", &keys::DUPLICATE) {
        keys::duplicate(editor);
    }
    if ui.add_enabled(any, Button::new("Delete").shortcut_text("Delete")).clicked() {
        keys::delete(editor);
    }
    if item(ui, !editor.scene().targets.is_empty(), "Select all", &keys::SELECT_ALL) {
        editor.selection = (0..editor.scene().targets.len()).collect();
    }
    ui.separator();
    ui.checkbox(&mut editor.snaps, "Snap to the grid (K)");
    ui.horizontal(|ui| {
        let label = ui.label("Grid");
        let mut grid = editor.grid * 1e3;
        ui.add(DragValue::new(&mut grid).range(0.5..=50.0).speed(0.1).suffix(" mm")).labelled_by(label.id);
        editor.grid = grid * 1e-3;
    });
}

/// The tools, one below the other.
pub fn tools(editor: &mut Editor, ui: &mut Ui) {
    ui.spacing_mut().item_spacing.y = 4.0;
    for tool in Tool::ALL {
        let (rect, response) = ui.allocate_exact_size(vec2(32.0, 32.0), Sense::click());
        let chosen = editor.tool == tool;
        response
            .widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, chosen, tool.name()));
        if response.clicked() {
            editor.tool = tool;
        }
        let visuals = ui.style().interact_selectable(&response, chosen);
        let fill = if chosen { theme::ACCENT } else { visuals.bg_fill };
        if chosen || response.hovered() || response.has_focus() {
            ui.painter().rect_filled(rect, 6.0, fill);
        }
        let ink = if chosen { egui::Color32::WHITE } else { ui.visuals().text_color() };
        tool::icon(ui.painter(), tool, rect, Stroke::new(1.8, ink));
        response.on_hover_text(format!("{} ({})\n{}", tool.name(), tool.key().name(), tool.tooltip()));
        if matches!(tool, Tool::Select | Tool::Text) {
            ui.add_space(6.0);
        }
    }
}
