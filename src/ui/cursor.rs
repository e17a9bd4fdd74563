//! The canvas by keyboard: arrow keys move a cross, and a key draws with the current tool.

use egui::{Color32, Context, Event, EventFilter, Id, Key, Modifiers, Painter, Response, Stroke, Ui, vec2};
use glam::DVec2;

use crate::ui::gesture::Typing;
use crate::ui::tool::Tool;
use crate::ui::view::Lens;
use crate::ui::{bodies, edit, editor::Editor, group, pen, theme};

/// Steps of an arrow key, with Ctrl and with Shift, m.
const STEP: f64 = 1e-3;
const FINE: f64 = 1e-4;
const FAR: f64 = 1e-2;
/// Pick distance of an outline in points.
const REACH: f64 = 9.0;
/// Points of the screen: half of the cross.
const HALF: f32 = 11.0;

/// The canvas' name among widgets.
pub fn id() -> Id {
    Id::unique("canvas")
}

/// Whether the canvas has the keyboard.
pub fn has_focus(ctx: &Context) -> bool {
    ctx.memory(|memory| memory.has_focus(id()))
}

/// Whether arrow keys move the selection instead of the cross.
pub fn moves_selection(editor: &Editor, ctx: &Context) -> bool {
    !has_focus(ctx) || (editor.tool == Tool::Select && editor.has_choice())
}

/// Whether arrow keys step frames instead: in presentation mode and in the shaded relief nothing is edited.
pub fn steps_frames(editor: &Editor) -> bool {
    editor.layout.presents || (editor.view.is_shaded() && !editor.space.is_on)
}

/// Acts on keys while the canvas has the focus.
pub fn act(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    if !response.has_focus() || editor.is_typing() || editor.dialog.is_some() {
        return;
    }
    let filter = EventFilter { tab: false, horizontal_arrows: true, vertical_arrows: true, escape: false };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    let mut at = place(editor, lens);
    for event in ui.input(|input| input.events.clone()) {
        let Event::Key { key, pressed: true, modifiers, .. } = event else { continue };
        if let Some(by) = step(key, modifiers).filter(|_| !steps_frames(editor)) {
            if !moves_selection(editor, ui.ctx()) {
                at += by;
            } else if modifiers.command {
                nudge(editor, by);
            }
        }
        match key {
            Key::Enter | Key::Space => press(editor, lens, at),
            Key::Period => select_next(editor, 1),
            Key::Comma => select_next(editor, -1),
            _ => {}
        }
    }
    let half = lens.size() / 2.0;
    editor.cursor = Some(at.clamp(lens.window.centre - half, lens.window.centre + half));
}

/// Position of the cross, initially the centre.
fn place(editor: &Editor, lens: &Lens) -> DVec2 {
    editor.cursor.unwrap_or(lens.window.centre)
}

fn step(key: Key, modifiers: Modifiers) -> Option<DVec2> {
    let direction = match key {
        Key::ArrowLeft => -DVec2::X,
        Key::ArrowRight => DVec2::X,
        Key::ArrowUp => DVec2::Y,
        Key::ArrowDown => -DVec2::Y,
        _ => return None,
    };
    Some(
        direction
            * if modifiers.command {
                FINE
            } else if modifiers.shift {
                FAR
            } else {
                STEP
            },
    )
}

fn nudge(editor: &mut Editor, by: DVec2) {
    let axes = editor.view.axes(editor.scene());
    editor.translate_chosen(axes.x * by.x + axes.y * by.y);
}

/// Acts like a click at the cross: draws, or selects the target there.
fn press(editor: &mut Editor, lens: &Lens, at: DVec2) {
    let axes = editor.view.axes(editor.scene());
    match editor.tool {
        Tool::Select => {
            let hit = edit::target_at(editor.scene(), &axes, at, REACH * lens.window.scale);
            editor.selection = hit.map(|hit| group::around(editor.scene(), hit)).unwrap_or_default();
            editor.body = bodies::at(editor, &axes, at).filter(|_| editor.selection.is_empty());
        }
        Tool::Text => {
            editor.selection.clear();
            editor.typing = Some(Typing::new(at));
        }
        Tool::Pen => {
            pen::press(editor, &axes, lens, lens.screen(at), at);
        }
        Tool::Erase => {
            if let Some(hit) = edit::target_at(editor.scene(), &axes, at, REACH * lens.window.scale) {
                edit::delete(&mut editor.document.scene, &mut [hit].into());
                editor.selection.clear();
            }
        }
        Tool::Point
        | Tool::Line
        | Tool::Circle
        | Tool::Rectangle
        | Tool::Triangle
        | Tool::Polygon
        | Tool::Freehand
        | Tool::Brush
        | Tool::Measure => {
            let Some(target) = editor.tool.click(&axes, at) else { return };
            editor.document.scene.targets.push(target);
            editor.selection = [editor.scene().targets.len() - 1].into();
        }
    }
}

/// Goes through the targets in the order of the list.
fn select_next(editor: &mut Editor, by: isize) {
    let count = editor.scene().targets.len() as isize;
    if count == 0 {
        return;
    }
    let next = match editor.selection.first() {
        Some(&index) => (index as isize + by).rem_euclid(count),
        None if by > 0 => 0,
        None => count - 1,
    };
    editor.selection = [next as usize].into();
    editor.tool = Tool::Select;
}

/// Draws the focus' ring around the canvas and the cross.
pub fn paint(editor: &Editor, painter: &Painter, lens: &Lens) {
    let ring = lens.rect.shrink(1.0);
    painter.rect_stroke(ring, 0.0, Stroke::new(2.0, theme::ACCENT), egui::StrokeKind::Inside);
    let at = lens.screen(place(editor, lens));
    for (width, colour) in [(3.5, theme::MARK_EDGE), (1.3, Color32::WHITE)] {
        let stroke = Stroke::new(width, colour);
        painter.line_segment([at - vec2(HALF, 0.0), at + vec2(HALF, 0.0)], stroke);
        painter.line_segment([at - vec2(0.0, HALF), at + vec2(0.0, HALF)], stroke);
    }
}
