//! Text being typed on the canvas.

use std::collections::BTreeSet;

use egui::{Event, Key, Ui};

use crate::scene::font;
use crate::ui::edit;
use crate::ui::editor::Editor;
use crate::ui::tool;
use crate::ui::view::Axes;

/// Letters go to the text on the canvas.
pub fn write(editor: &mut Editor, ui: &Ui, axes: &Axes) {
    let Some(mut typing) = editor.typing.take() else { return };
    let events = ui.input(|input| input.events.clone());
    let mut is_done = false;
    for event in events {
        match event {
            Event::Text(letters) => {
                typing.lacking = font::lacking(&letters);
                typing.text.extend(letters.chars().filter(|letter| !typing.lacking.contains(letter)));
            }
            Event::Key { key: Key::Backspace, pressed: true, .. } => drop(typing.text.pop()),
            Event::Key { key: Key::Enter | Key::Escape, pressed: true, .. } => is_done = true,
            _ => {}
        }
    }
    match (typing.text.trim().is_empty(), typing.index) {
        (true, None) => {}
        (true, Some(index)) => {
            edit::delete(&mut editor.document.scene, &mut BTreeSet::from([index]));
            typing.index = None;
            editor.selection.clear();
        }
        (false, Some(index)) => {
            // Only the letters: height and position may have been edited meanwhile.
            let target = editor.document.scene.targets.get_mut(index);
            if let Some(text) = target.and_then(|target| target.shape.text_mut())
                && *text != typing.text
            {
                text.clone_from(&typing.text);
            }
        }
        (false, None) => {
            editor.document.scene.targets.push(tool::text(axes, typing.at, &typing.text));
            let index = editor.scene().targets.len() - 1;
            typing.index = Some(index);
            editor.selection = BTreeSet::from([index]);
            editor.show_target();
        }
    }
    editor.typing = (!is_done).then_some(typing);
}

pub fn end(editor: &mut Editor) {
    editor.typing = None;
}
