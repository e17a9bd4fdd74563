//! Everything around the canvas.

use egui::{CentralPanel, Color32, Frame, Ui};

use crate::ui::command::Command;
use crate::ui::editor::Editor;
use crate::ui::shown::Shown;
use crate::ui::{arrangement, dialog, gallery, keys, menu};

/// Draws everything around the canvas and passes the remaining space to `canvas`.
pub fn show(
    editor: &mut Editor,
    shown: &mut Shown,
    ui: &mut Ui,
    canvas: impl FnOnce(&mut Editor, &mut Shown, &mut Ui),
) -> Vec<Command> {
    let mut commands = Vec::new();
    let quantity = editor.view.quantity;
    keys::press(editor, shown, ui.ctx(), &mut commands);
    // The window is cleared to the panels' colour: filling every pixel again would cost a software driver half a
    // frame.
    let clear = Frame::side_top_panel(ui.style()).fill(Color32::TRANSPARENT);
    if editor.layout.presents {
        menu::presented_stop(shown, ui.ctx(), &mut commands);
        arrangement::timeline(editor, shown, clear, ui);
    } else {
        arrangement::around(editor, shown, clear, ui, &mut commands);
    }
    let centre = CentralPanel::default().frame(Frame::NONE).show(ui, |ui| canvas(editor, shown, ui));
    gallery::show(centre.response.rect, editor, shown, ui, &mut commands);
    dialog::show(editor, shown, ui.ctx(), &mut commands);
    if editor.view.quantity != quantity {
        // A range in pascals is meaningless in metres.
        editor.view.forget_range();
    }
    if !editor.selection.is_empty() {
        editor.body = None;
    }
    commands.append(&mut editor.asked_by_others);
    dialog::warn_of_loudness(editor, &mut commands);
    commands
}
