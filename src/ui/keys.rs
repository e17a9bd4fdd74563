//! Shortcuts.

use std::collections::BTreeSet;
use std::path::Path;

use egui::{Context, Event, Key, KeyboardShortcut, Modifiers};

use crate::field::Quantity;
use crate::studio::opening;
use crate::ui::brush;
use crate::ui::edit;
use crate::ui::gesture;
use crate::ui::tool::Tool;
use crate::ui::way;
use crate::ui::{Command, Dialog, Editor, Purpose};

pub const NEW: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::N);
pub const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
pub const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
pub const SAVE_AS: KeyboardShortcut =
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
pub const CLOSE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Q);
pub const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
pub const REDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
const REDO_TOO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
pub const DUPLICATE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::D);
/// These come as events of their own; here they stand for the menu.
pub const CUT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::X);
pub const COPY: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::C);
pub const PASTE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::V);
pub const SELECT_ALL: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::A);

/// m: what an arrow key moves by, and with shift.
const NUDGE: f64 = 1e-3;
const FAR_NUDGE: f64 = 1e-2;

/// Every shortcut with what it does, for the help.
pub const HELP: &[(&str, &str)] = &[
    ("Ctrl N / O / S", "New, open, save"),
    ("Ctrl Shift S", "Save as"),
    ("Ctrl Z / Ctrl Shift Z", "Undo, redo"),
    ("Ctrl A / D", "Select all, duplicate"),
    ("Ctrl X / C / V", "Cut, copy, paste targets"),
    ("Delete", "Delete what is selected"),
    ("Arrows", "Move by 1 mm, with Shift by 10 mm"),
    ("Esc", "Stop what is under way, select nothing"),
    ("Wheel", "Zoom where the pointer is"),
    ("Space or right button + drag", "Move the view"),
    ("Double click, or 0", "Show everything"),
    ("1 to 7", "RMS, phase, radiation, depression, instantaneous, intensity, velocity"),
    ("Shift while drawing", "Lines in steps of 15°, squares"),
    ("M", "Focal points and outlines on or off"),
    ("X", "Curve along a line on or off; Shift moves it"),
    ("K", "Snap to the grid on or off"),
    ("[ and ]", "A smaller or larger brush"),
    ("Ctrl Q", "Quit"),
    ("F1", "This help"),
];

/// Acts on the keys that no widget wants.
pub fn press(editor: &mut Editor, ctx: &Context, commands: &mut Vec<Command>) {
    if editor.dialog.is_some() {
        return;
    }
    if editor.is_typing() {
        // Letters belong to the text, and so does what a click elsewhere ends.
        if ctx.egui_wants_keyboard_input() {
            gesture::end_typing(editor);
        }
        return;
    }
    let hit = |shortcut: &KeyboardShortcut| ctx.input_mut(|input| input.consume_shortcut(shortcut));
    let in_field = ctx.egui_wants_keyboard_input();
    // The longer ones first: a shortcut also answers to more modifiers than it asks for.
    if hit(&SAVE_AS) {
        editor.dialog = Some(Dialog::path(Purpose::SaveAs, &editor.document));
    }
    for (shortcut, command) in [(NEW, Command::New), (SAVE, Command::Save), (CLOSE, Command::Close)] {
        if hit(&shortcut) {
            editor.ask(command, commands);
        }
    }
    if hit(&OPEN) {
        editor.dialog = Some(Dialog::path(Purpose::Open, &editor.document));
    }
    if in_field {
        return;
    }
    if hit(&REDO) || hit(&REDO_TOO) {
        editor.redo();
    }
    if hit(&UNDO) {
        editor.undo();
    }
    clipboard(editor, ctx);
    if hit(&DUPLICATE) {
        duplicate(editor);
    }
    if hit(&SELECT_ALL) {
        editor.selection = (0..editor.scene().targets.len()).collect();
    }
    plain_keys(editor, ctx);
}

/// What the desktop's keys for copying, cutting and pasting ask for.
fn clipboard(editor: &mut Editor, ctx: &Context) {
    for event in ctx.input(|input| input.events.clone()) {
        match event {
            Event::Copy => copy(editor, ctx),
            Event::Cut => {
                copy(editor, ctx);
                delete(editor);
            }
            Event::Paste(text) => paste(editor, &text),
            _ => {}
        }
    }
}

pub fn copy(editor: &mut Editor, ctx: &Context) {
    if let Some((text, targets)) = edit::copied(editor.scene(), &editor.selection) {
        ctx.copy_text(text);
        editor.copied = targets;
    }
}

fn paste(editor: &mut Editor, text: &str) {
    let axes = editor.view.axes(editor.scene());
    if edit::paste(&mut editor.document.scene, &mut editor.selection, &axes, text) {
        let pasted = editor.selection.iter().next().copied().unwrap_or(0);
        edit::return_pixels(&mut editor.document.scene.targets[pasted..], &editor.copied);
        let folder = editor.document.path().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
        // A picture that is missing is named where the scene is shown.
        let _ = opening::load_targets(&mut editor.document.scene.targets, &folder);
    }
}

/// Keys without Ctrl.
fn plain_keys(editor: &mut Editor, ctx: &Context) {
    let presses = ctx.input(|input| input.events.iter().filter_map(plain_press).collect::<Vec<_>>());
    let pressed = |key: Key| presses.iter().any(|(pressed, _)| *pressed == key);
    for tool in Tool::ALL {
        if pressed(tool.key()) {
            editor.tool = tool;
        }
    }
    if (pressed(Key::Delete) || pressed(Key::Backspace)) && !way::delete(editor) {
        delete(editor);
    }
    if pressed(Key::Escape) {
        if editor.gesture.take().is_some() {
            editor.document.revert();
        }
        editor.selection.clear();
        editor.tool = Tool::Select;
    }
    if pressed(Key::Num0) {
        editor.view.window = None;
    }
    const DIGITS: [Key; 9] =
        [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    for (key, quantity) in DIGITS.into_iter().zip(Quantity::ALL) {
        if pressed(key) {
            editor.view.quantity = quantity;
        }
    }
    if pressed(Key::M) {
        editor.view.marks = !editor.view.marks;
    }
    if pressed(Key::X) {
        editor.view.section = !editor.view.section;
    }
    if pressed(Key::K) {
        editor.snaps = !editor.snaps;
    }
    if pressed(Key::OpenBracket) {
        editor.brush.scale(1.0 / brush::STEP);
    }
    if pressed(Key::CloseBracket) {
        editor.brush.scale(brush::STEP);
    }
    if pressed(Key::F1) {
        editor.dialog = Some(Dialog::Help);
    }
    presses.iter().for_each(|&(key, shift)| nudge(editor, key, shift));
}

/// A key that is pressed without Ctrl and Alt, and whether Shift was held with it, however short.
fn plain_press(event: &Event) -> Option<(Key, bool)> {
    match event {
        Event::Key { key, pressed: true, modifiers, .. } if !modifiers.command && !modifiers.alt => {
            Some((*key, modifiers.shift))
        }
        _ => None,
    }
}

/// Arrows move what is selected.
fn nudge(editor: &mut Editor, key: Key, far: bool) {
    let axes = editor.view.axes(editor.scene());
    let direction = match key {
        Key::ArrowLeft => -axes.x,
        Key::ArrowRight => axes.x,
        Key::ArrowUp => axes.y,
        Key::ArrowDown => -axes.y,
        _ => return,
    };
    let by = direction * if far { FAR_NUDGE } else { NUDGE };
    for &index in &editor.selection {
        if let Some(target) = editor.document.scene.targets.get_mut(index) {
            edit::translate(&mut target.shape, by);
        }
    }
}

pub fn delete(editor: &mut Editor) {
    edit::delete(&mut editor.document.scene, &mut editor.selection);
}

pub fn duplicate(editor: &mut Editor) {
    let axes = editor.view.axes(editor.scene());
    let mut selection: BTreeSet<usize> = std::mem::take(&mut editor.selection);
    edit::duplicate(&mut editor.document.scene, &mut selection, &axes);
    editor.selection = selection;
}
