//! Keyboard shortcuts.

use egui::{Context, Event, Key, Modifiers};

use crate::studio::link;
use crate::ui::action::{self, Action};
use crate::ui::board::{BoardCommand, Plays};
use crate::ui::clipboard;
use crate::ui::cursor;
use crate::ui::gallery;
use crate::ui::pen;
use crate::ui::shown::{Notice, Shown};
use crate::ui::timeline;
use crate::ui::tool::Tool;
use crate::ui::typing;
use crate::ui::{command::Command, editor::Editor};

/// Steps of an arrow key, and with Shift, m.
const NUDGE: f64 = 1e-3;
const FAR_NUDGE: f64 = 1e-2;
/// Time (s) for a second Escape to stop the board.
const TWICE: f64 = 2.0;

/// Keys and pointer gestures besides the actions, by groups, for the help.
pub const GESTURES: &[(&str, &[(&str, &str)])] = &[
    (
        "On the map",
        &[
            ("Wheel", "Zoom where the pointer is"),
            ("Space or right button + drag", "Move the view"),
            ("Double click", "Fit the view"),
            ("D, then drag", "Measure along a line; Esc removes it"),
            ("Shift over the map", "Move the line profile"),
            ("Tab to the map", "Arrows move a cross (Ctrl: 0.1 mm), Enter draws or selects there"),
        ],
    ),
    (
        "Drawing and moving",
        &[
            ("Drag inside the selection's box", "Move the selection"),
            ("Arrows", "Move by 1 mm, with Shift by 10 mm; with nothing selected, step the frames"),
            ("Alt and drag", "Drag a copy"),
            ("Drag inside a body", "Move the body; the handle above it turns it, with Shift in steps of 15°"),
            ("Shift while drawing", "Lines in steps of 15°, squares"),
            ("Ctrl while dragging", "Free of grid and guides"),
            (", and .", "Select the previous and the next target, with the map in focus"),
            ("Right click", "Menu of the selection"),
            ("Click in the list", "Select one target of a group"),
            ("Pen: click, drag", "A corner, a curve; Backspace removes the last knot, Enter ends the path"),
            ("Esc", "Cancel the current action, clear the selection, choose the Select tool"),
        ],
    ),
];

/// Acts on the keys that no widget wants.
pub fn press(editor: &mut Editor, shown: &mut Shown, ctx: &Context, commands: &mut Vec<Command>) {
    stop(editor, shown, ctx, commands);
    if editor.dialog.is_some() {
        return;
    }
    if editor.is_typing() {
        // A text being typed receives letters.
        if is_in_field(ctx) {
            typing::end(editor);
        }
        return;
    }
    let in_field = is_in_field(ctx);
    play(editor, shown, in_field, ctx, commands);
    if !in_field && pen::keys(editor, ctx, !cursor::has_focus(ctx)) {
        return;
    }
    let mut actions: Vec<_> =
        Action::all().into_iter().flat_map(|a| a.keys().into_iter().map(move |k| (k, a))).collect();
    // More modifiers first: a shortcut also matches with extra modifiers.
    actions.sort_by_key(|(keys, _)| (!keys.modifiers.shift, keys.modifiers == Modifiers::NONE));
    let presses = ctx.input(|input| input.events.iter().filter_map(plain_press).collect::<Vec<_>>());
    for (keys, action) in actions {
        if (in_field && !action.is_for_the_window())
            || matches!(action, Action::Cut | Action::Copy | Action::Paste | Action::Play)
        {
            // Clipboard keys arrive as separate events, and the space bar also moves the view.
            continue;
        }
        let is_hit = if keys.modifiers == Modifiers::NONE {
            presses.iter().any(|(key, _)| *key == keys.logical_key)
        } else {
            ctx.input_mut(|input| input.consume_shortcut(&keys))
        };
        if is_hit {
            action.run(editor, shown, ctx, commands);
        }
    }
    if in_field {
        return;
    }
    hear_clipboard(editor, ctx, commands);
    if presses.iter().any(|(key, _)| *key == Key::Escape) {
        escape(editor, ctx);
    }
    let is_free = !editor.has_choice() && !cursor::has_focus(ctx) && timeline::is_wanted(editor);
    if cursor::steps_frames(editor) || is_free {
        presses.iter().for_each(|&(key, _)| step_frame(editor, key));
    } else if cursor::moves_selection(editor, ctx) {
        presses.iter().for_each(|&(key, shift)| nudge(editor, key, shift));
    }
}

/// Escape twice stops a sounding board, independently of the keyboard focus.
fn stop(editor: &mut Editor, shown: &mut Shown, ctx: &Context, commands: &mut Vec<Command>) {
    if shown.board.plays == Plays::Nothing {
        editor.escaped = None;
        return;
    }
    let is_escape =
        |event: &Event| matches!(event, Event::Key { key: Key::Escape, pressed: true, repeat: false, .. });
    let (now, times) =
        ctx.input(|input| (input.time, input.events.iter().filter(|event| is_escape(event)).count()));
    for _ in 0..times {
        if editor.escaped.take().is_some_and(|last| now - last < TWICE) {
            commands.push(Command::Board(BoardCommand::Stop));
        } else {
            editor.escaped = Some(now);
            let text = "Press Esc once more to stop the board".to_owned();
            shown.notice = Some(Notice { text, is_error: false });
        }
    }
}

/// Plays or pauses when the space bar is released, unless it moved the view.
fn play(editor: &mut Editor, shown: &Shown, in_field: bool, ctx: &Context, commands: &mut Vec<Command>) {
    if in_field || cursor::has_focus(ctx) || ctx.input(|input| input.pointer.any_down()) {
        editor.is_space_down = false;
        return;
    }
    for event in ctx.input(|input| input.events.clone()) {
        let Event::Key { key: Key::Space, pressed, repeat: false, modifiers: Modifiers::NONE, .. } = event
        else {
            continue;
        };
        if std::mem::replace(&mut editor.is_space_down, pressed) && !pressed {
            Action::Play.run(editor, shown, ctx, commands);
        }
    }
}

fn escape(editor: &mut Editor, ctx: &Context) {
    editor.layout.is_drawn_out = false;
    if editor.layout.presents {
        action::present(editor, ctx, false);
        return;
    }
    editor.has_closed_gallery |= gallery::is_open(editor);
    let is_edit_in_space = editor.space.let_go();
    if editor.gesture.take().is_some() || is_edit_in_space {
        editor.document.revert();
    }
    editor.selection.clear();
    editor.body = None;
    editor.tool = Tool::Select;
    editor.put_line_away();
}

/// Whether a widget other than the canvas has the keyboard.
fn is_in_field(ctx: &Context) -> bool {
    ctx.egui_wants_keyboard_input() && !cursor::has_focus(ctx)
}

/// Handles the clipboard events of the desktop.
fn hear_clipboard(editor: &mut Editor, ctx: &Context, commands: &mut Vec<Command>) {
    for event in ctx.input(|input| input.events.clone()) {
        match event {
            Event::Copy => clipboard::copy(editor, ctx),
            Event::Cut => {
                clipboard::copy(editor, ctx);
                clipboard::delete(editor);
            }
            Event::Paste(text) if link::is_link(&text) => editor.ask(Command::OpenLink(text), commands),
            Event::Paste(text) => clipboard::paste(editor, &text),
            _ => {}
        }
    }
}

/// A key pressed without Ctrl and Alt, and whether Shift was held, however briefly.
fn plain_press(event: &Event) -> Option<(Key, bool)> {
    match event {
        Event::Key { key, pressed: true, modifiers, .. } if !modifiers.command && !modifiers.alt => {
            Some((*key, modifiers.shift))
        }
        _ => None,
    }
}

/// Goes to the previous or the next frame by arrow keys.
fn step_frame(editor: &mut Editor, key: Key) {
    match key {
        Key::ArrowLeft => timeline::step(editor, -1),
        Key::ArrowRight => timeline::step(editor, 1),
        _ => {}
    }
}

/// Moves the selection by arrow keys.
fn nudge(editor: &mut Editor, key: Key, far: bool) {
    let axes = editor.view.axes(editor.scene());
    let direction = match key {
        Key::ArrowLeft => -axes.x,
        Key::ArrowRight => axes.x,
        Key::ArrowUp => axes.y,
        Key::ArrowDown => -axes.y,
        _ => return,
    };
    editor.translate_chosen(direction * if far { FAR_NUDGE } else { NUDGE });
}
