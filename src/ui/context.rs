//! The context menu of the selection.

use egui::{Button, Response, Ui};
use glam::DVec2;
use strum::VariantArray;

use crate::scene::Target;
use crate::ui::bodies;
use crate::ui::clipboard;
use crate::ui::edit::{self, Align};
use crate::ui::editor::Editor;
use crate::ui::group;
use crate::ui::view::Lens;

/// Pick distance of an outline in points.
const REACH: f64 = 9.0;

/// Opens the menu at the click of the right button, and selects the target there.
pub fn menu(editor: &mut Editor, response: &Response, lens: &Lens) {
    if response.secondary_clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        let place = lens.flat(at);
        let axes = editor.view.axes(editor.scene());
        let hit = edit::target_at(editor.scene(), &axes, place, REACH * lens.window.scale);
        match hit {
            Some(hit) if !editor.selection.contains(&hit) => {
                editor.selection = group::around(editor.scene(), hit);
            }
            Some(_) => {}
            None => {
                if let Some(index) = bodies::at(editor, &axes, place) {
                    editor.choose_body(index);
                }
            }
        }
        editor.asked = place;
    }
    response.context_menu(|ui| show(editor, ui));
}

fn show(editor: &mut Editor, ui: &mut Ui) {
    let chosen = editor.selection.len();
    let any = usize::from(editor.chosen_body().is_none());
    let item =
        |ui: &mut Ui, least: usize, name: &str| ui.add_enabled(chosen >= least, Button::new(name)).clicked();
    if item(ui, any, "Duplicate") {
        clipboard::duplicate_chosen(editor);
    }
    if item(ui, 1, "Copy") {
        clipboard::copy(editor, ui.ctx());
    }
    if ui.add_enabled(!editor.copied.is_empty(), Button::new("Paste here")).clicked() {
        paste(editor);
    }
    if item(ui, any, "Delete") {
        clipboard::delete_chosen(editor);
    }
    ui.separator();
    if item(ui, 2, "Group") {
        group::join(&mut editor.document.scene, &editor.selection);
    }
    let is_grouped = group::any(editor.scene(), &editor.selection);
    if ui.add_enabled(is_grouped, Button::new("Ungroup")).clicked() {
        group::rename(&mut editor.document.scene, &editor.selection, "");
    }
    ui.separator();
    let axes = editor.view.axes(editor.scene());
    for &align in Align::VARIANTS {
        if item(ui, 2, align.into_str()) {
            edit::align(&mut editor.document.scene, &editor.selection, &axes, align);
        }
    }
    ui.separator();
    for (name, is_upwards) in [("Distribute horizontally", false), ("Distribute vertically", true)] {
        if item(ui, 3, name) {
            edit::distribute(&mut editor.document.scene, &editor.selection, &axes, is_upwards);
        }
    }
}

/// Pastes at the menu's position.
fn paste(editor: &mut Editor) {
    let axes = editor.view.axes(editor.scene());
    let mut pasted: Vec<Target> = editor.copied.clone();
    let Some([low, high]) = edit::bounds(&pasted, &axes) else { return };
    let by: DVec2 = editor.asked - (low + high) / 2.0;
    pasted.iter_mut().for_each(|target| target.shape.translate(axes.x * by.x + axes.y * by.y));
    let first = editor.scene().targets.len();
    editor.document.scene.targets.extend(pasted);
    group::part(&mut editor.document.scene.targets, first);
    editor.selection = (first..editor.scene().targets.len()).collect();
}
