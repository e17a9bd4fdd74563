//! Commands on the selected targets as a whole: copy, paste, duplicate, delete.

use std::collections::BTreeSet;
use std::path::Path;

use egui::Context;

use crate::studio::opening;
use crate::ui::{bodies, edit, editor::Editor, way};

pub fn copy(editor: &mut Editor, ctx: &Context) {
    if let Some((text, targets)) = edit::copied(editor.scene(), &editor.selection) {
        ctx.copy_text(text);
        editor.copied = targets;
    }
}

pub fn paste(editor: &mut Editor, text: &str) {
    let axes = editor.view.axes(editor.scene());
    if edit::paste(&mut editor.document.scene, &mut editor.selection, &axes, text) {
        let pasted = editor.selection.iter().next().copied().unwrap_or(0);
        edit::return_pixels(&mut editor.document.scene.targets[pasted..], &editor.copied);
        let folder = editor.document.path().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
        // A missing picture is reported where the scene is shown.
        let _ = opening::load_targets(&mut editor.document.scene.targets, &folder);
    }
}

/// Deletes the last grabbed vertex or keyframe of a path, or else what is chosen.
pub fn delete_chosen(editor: &mut Editor) {
    if way::delete(editor) {
        return;
    }
    match editor.chosen_body() {
        Some(index) => {
            editor.document.scene.bodies.remove(index);
            editor.body = None;
        }
        None => delete(editor),
    }
}

/// Duplicates what is chosen, beside it.
pub fn duplicate_chosen(editor: &mut Editor) {
    let Some(index) = editor.chosen_body() else { return duplicate(editor) };
    let axes = editor.view.axes(editor.scene());
    let body = &editor.scene().bodies[index];
    let copy = bodies::beside(editor.scene(), body, &axes);
    bodies::add(editor, copy);
}

pub fn delete(editor: &mut Editor) {
    edit::delete(&mut editor.document.scene, &mut editor.selection);
}

fn duplicate(editor: &mut Editor) {
    let axes = editor.view.axes(editor.scene());
    let mut selection: BTreeSet<usize> = std::mem::take(&mut editor.selection);
    edit::duplicate(&mut editor.document.scene, &mut selection, &axes);
    editor.selection = selection;
}
