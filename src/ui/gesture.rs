//! What the pointer does on the canvas: drawing, moving, selecting, erasing, and typing.

use std::collections::BTreeSet;

use egui::{Event, Key, Modifiers, PointerButton, Pos2, Response, Ui};
use glam::DVec2;

use crate::scene::{Shape, Target, font};
use crate::ui::Editor;
use crate::ui::brush;
use crate::ui::edit;
use crate::ui::handle;
use crate::ui::tool::{self, Tool};
use crate::ui::view::{Axes, Lens};
use crate::ui::way;

/// Points of the screen within which an outline is meant.
const REACH: f64 = 9.0;
/// m, between the vertices of a stroke drawn by hand.
const STROKE_STEP: f64 = 1.5e-3;
const MOST_VERTICES: usize = 600;
/// What one turn of the wheel's notch does.
const ZOOM_PER_POINT: f64 = 1.0 / 240.0;

/// An edit that goes on as long as the button is held.
#[derive(Clone, Debug)]
pub enum Gesture {
    Pan,
    /// From where, and how the targets stood.
    Move {
        from: DVec2,
        before: Vec<(usize, Target)>,
    },
    /// A handle of the one target that is selected, and how that stood.
    Pull {
        index: usize,
        handle: usize,
        before: Target,
    },
    /// The path of a motion.
    Way(way::Pull),
    Band {
        from: DVec2,
        /// Selected before, and kept.
        kept: BTreeSet<usize>,
    },
    /// A shape under way: its place in the scene once it has a size.
    Draw {
        from: DVec2,
        index: Option<usize>,
    },
    Stroke {
        points: Vec<DVec2>,
        index: Option<usize>,
    },
    Brush {
        /// Where it was in the frame before.
        last: Option<DVec2>,
        /// The picture that it paints, once there is one.
        index: Option<usize>,
    },
    Erase {
        last: Option<DVec2>,
    },
}

/// A text under way.
#[derive(Clone, Debug)]
pub struct Typing {
    pub at: DVec2,
    pub text: String,
    /// Its place in the scene once there is something to write.
    index: Option<usize>,
}

/// Lets the pointer act. `response` is the canvas.
pub fn act(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    look_around(editor, ui, response, lens);
    let axes = editor.view.axes(editor.scene());
    let modifiers = ui.input(|input| input.modifiers);
    // A quick click comes and goes within a frame.
    let is_meant = response.is_pointer_button_down_on() || response.clicked();
    let pressed = is_meant && ui.input(|input| input.pointer.primary_pressed());
    if !is_meant && ui.input(|input| input.pointer.any_pressed()) {
        // What is pressed beside the canvas may change the list that the text stands in.
        end_typing(editor);
    }
    if let Some(at) = response.interact_pointer_pos() {
        if pressed && editor.gesture.is_none() && !ui.input(|input| input.key_down(Key::Space)) {
            end_typing(editor);
            begin(editor, &axes, lens, at, modifiers);
        }
        go_on(editor, &axes, lens, at, modifiers);
    }
    if !ui.input(|input| input.pointer.any_down()) {
        end(editor, &axes, lens, response);
    }
    if editor.typing.is_some() {
        write(editor, ui, &axes);
    }
}

/// Lets the pointer look around where nothing is edited.
pub fn watch(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    end_typing(editor);
    look_around(editor, ui, response, lens);
    if !ui.input(|input| input.pointer.any_down()) {
        editor.gesture = None;
    }
}

/// Wheel, middle button, space bar and double click.
fn look_around(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    if let Some(at) = response.hover_pos() {
        let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = f64::from(pinch) * (f64::from(wheel) * ZOOM_PER_POINT).exp();
        if factor != 1.0 {
            editor.view.window = Some(lens.zoomed(at, factor));
        }
    }
    if let (true, Some(at)) = (editor.view.section, response.hover_pos())
        && ui.input(|input| input.modifiers.shift)
    {
        editor.view.line = lens.flat(at).y;
    }
    let space = ui.input(|input| input.key_down(Key::Space)) && !editor.is_typing();
    let pans = response.dragged_by(PointerButton::Middle)
        || response.dragged_by(PointerButton::Secondary)
        || (space && response.dragged_by(PointerButton::Primary));
    if pans {
        editor.gesture.get_or_insert(Gesture::Pan);
        editor.view.window = Some(lens.moved(response.drag_delta()));
    }
    if response.double_clicked_by(PointerButton::Primary) && editor.tool == Tool::Select {
        let axes = editor.view.axes(editor.scene());
        let on_way =
            response.interact_pointer_pos().is_some_and(|at| way::add_vertex(editor, &axes, lens, at));
        if !on_way {
            editor.view.window = None;
        }
    }
}

/// The place that is meant: on the grid if the pointer snaps.
fn place(editor: &Editor, lens: &Lens, at: Pos2) -> DVec2 {
    let uv = lens.flat(at);
    if editor.snaps { (uv / editor.grid).round() * editor.grid } else { uv }
}

fn begin(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2, modifiers: Modifiers) {
    let from = place(editor, lens, at);
    editor.gesture = match editor.tool {
        Tool::Select => Some(grab(editor, axes, lens, at, modifiers)),
        Tool::Point => {
            let Some(target) = editor.tool.click(axes, from) else { return };
            editor.document.scene.targets.push(target.clone());
            let index = editor.scene().targets.len() - 1;
            editor.selection = BTreeSet::from([index]);
            Some(Gesture::Move { from, before: vec![(index, target)] })
        }
        Tool::Text => {
            editor.selection.clear();
            editor.typing = Some(Typing { at: from, text: String::new(), index: None });
            None
        }
        Tool::Freehand => Some(Gesture::Stroke { points: vec![lens.flat(at)], index: None }),
        Tool::Brush => {
            let index = brush::picture_at(editor, axes, lens.flat(at));
            Some(Gesture::Brush { last: None, index })
        }
        Tool::Erase => Some(Gesture::Erase { last: None }),
        Tool::Line | Tool::Circle | Tool::Rectangle | Tool::Triangle | Tool::Polygon => {
            Some(Gesture::Draw { from, index: None })
        }
    };
}

/// Selects what is under the pointer and takes hold of it, or begins a rubber band.
fn grab(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2, modifiers: Modifiers) -> Gesture {
    let from = lens.flat(at);
    if let Some(pull) = way::take(editor, axes, lens, at) {
        return Gesture::Way(pull);
    }
    if let Some(pull) = pull(editor, axes, lens, at) {
        return pull;
    }
    let Some(index) = edit::target_at(editor.scene(), axes, from, REACH * lens.window.scale) else {
        let kept = if modifiers.shift { editor.selection.clone() } else { BTreeSet::new() };
        editor.selection = kept.clone();
        return Gesture::Band { from, kept };
    };
    match (modifiers.shift, editor.selection.contains(&index)) {
        (true, true) => drop(editor.selection.remove(&index)),
        (true, false) => drop(editor.selection.insert(index)),
        (false, true) => {}
        (false, false) => editor.selection = BTreeSet::from([index]),
    }
    let targets = &editor.scene().targets;
    let before = editor.selection.iter().map(|&index| (index, targets[index].clone())).collect();
    Gesture::Move { from, before }
}

/// Takes hold of a handle of what is selected.
fn pull(editor: &Editor, axes: &Axes, lens: &Lens, at: Pos2) -> Option<Gesture> {
    let index = editor.selection.first().copied().filter(|_| editor.selection.len() == 1)?;
    let before = editor.scene().targets.get(index)?.clone();
    let handle = handle::at(&before, axes, lens, at)?;
    Some(Gesture::Pull { index, handle, before })
}

fn go_on(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2, modifiers: Modifiers) {
    let Some(mut gesture) = editor.gesture.take() else { return };
    match &mut gesture {
        Gesture::Pan => {}
        Gesture::Pull { index, handle, before } => {
            let from = handle::handles(before)[*handle];
            let uv = place(editor, lens, at);
            // A click that trembles pulls nothing.
            if uv.distance(axes.flat(from)) >= 2.0 * lens.window.scale {
                let depth = axes.x.cross(axes.y) * axes.height(from);
                let pulled = handle::pulled(before, *handle, axes.world(uv) + depth);
                if let Some(target) = editor.document.scene.targets.get_mut(*index) {
                    *target = pulled;
                }
            }
        }
        Gesture::Way(pull) => way::pull(editor, axes, lens, place(editor, lens, at), pull),
        Gesture::Move { from, before } => follow(editor, axes, lens, at, (*from, before)),
        Gesture::Band { from, kept } => {
            let inside = edit::targets_in(editor.scene(), axes, *from, lens.flat(at));
            editor.selection = kept.union(&inside).copied().collect();
        }
        Gesture::Draw { from, index } => {
            let mut to = place(editor, lens, at);
            if modifiers.shift {
                to = straight(editor.tool, *from, to);
            }
            if let Some(target) = editor.tool.drag(axes, *from, to) {
                put(editor, index, target);
            }
        }
        Gesture::Stroke { points, index } => {
            let uv = lens.flat(at);
            let is_far = points.last().is_none_or(|last| last.distance(uv) >= STROKE_STEP);
            if is_far && points.len() < MOST_VERTICES {
                points.push(uv);
                if points.len() > 1 {
                    put(editor, index, tool::path(axes, points));
                }
            }
        }
        Gesture::Brush { last, index } => {
            if let Some(way) = way(last, lens.flat(at)) {
                *index = brush::paint(editor, axes, *index, way);
            }
        }
        Gesture::Erase { last } => {
            let uv = lens.flat(at);
            let is_deleted = |target: &Target| !brush::is_in(target, axes);
            let reach = REACH * lens.window.scale;
            if let Some(index) = edit::target_among(editor.scene(), axes, uv, reach, is_deleted) {
                let mut erased = BTreeSet::from([index]);
                edit::delete(&mut editor.document.scene, &mut erased);
                editor.selection.clear();
            }
            if let Some(way) = way(last, uv) {
                brush::wipe(editor, axes, way);
            }
        }
    }
    editor.gesture = Some(gesture);
}

/// From where the pointer was to where it is; `None` while it rests.
fn way(last: &mut Option<DVec2>, to: DVec2) -> Option<[DVec2; 2]> {
    let from = last.replace(to).unwrap_or(DVec2::INFINITY);
    (from != to).then_some([if from.is_finite() { from } else { to }, to])
}

/// Moves what is held to where the pointer is.
fn follow(
    editor: &mut Editor,
    axes: &Axes,
    lens: &Lens,
    at: Pos2,
    (from, before): (DVec2, &[(usize, Target)]),
) {
    let mut by = lens.flat(at) - from;
    // A click that trembles is no move.
    if by.length() < 2.0 * lens.window.scale {
        by = DVec2::ZERO;
    }
    if let (true, Some((_, first))) = (editor.snaps && by != DVec2::ZERO, before.first()) {
        // The first target goes to the grid and the others keep their distance from it.
        let centre = axes.flat(crate::scene::outline::centre(&first.shape));
        by = ((centre + by) / editor.grid).round() * editor.grid - centre;
    }
    for (index, target) in before {
        let mut moved = target.clone();
        if by != DVec2::ZERO {
            edit::translate(&mut moved.shape, axes.x * by.x + axes.y * by.y);
        }
        if let Some(target) = editor.document.scene.targets.get_mut(*index) {
            *target = moved;
        }
    }
}

/// With shift, lines go in steps of 15° and rectangles become squares.
fn straight(tool: Tool, from: DVec2, to: DVec2) -> DVec2 {
    let offset = to - from;
    match tool {
        Tool::Line => {
            let step = std::f64::consts::TAU / 24.0;
            let angle = (offset.to_angle() / step).round() * step;
            from + DVec2::from_angle(angle) * offset.length()
        }
        Tool::Rectangle => from + offset.signum() * offset.abs().max_element(),
        _ => to,
    }
}

/// Puts a target that is under way into the scene, in place of what it was before.
fn put(editor: &mut Editor, index: &mut Option<usize>, target: Target) {
    let targets = &mut editor.document.scene.targets;
    match index.and_then(|index| targets.get_mut(index)) {
        Some(place) => *place = target,
        None => {
            targets.push(target);
            *index = Some(targets.len() - 1);
        }
    }
    editor.selection = index.iter().copied().collect();
}

fn end(editor: &mut Editor, axes: &Axes, lens: &Lens, response: &Response) {
    let Some(gesture) = editor.gesture.take() else { return };
    if let Gesture::Draw { index: None, .. } = gesture
        && response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        let at = place(editor, lens, at);
        if let Some(target) = editor.tool.click(axes, at) {
            put(editor, &mut None, target);
        }
    }
    if let Gesture::Erase { .. } = gesture {
        brush::clear_away(editor);
    }
}

/// Letters go to the text on the canvas.
fn write(editor: &mut Editor, ui: &Ui, axes: &Axes) {
    let Some(mut typing) = editor.typing.take() else { return };
    let events = ui.input(|input| input.events.clone());
    let mut is_done = false;
    for event in events {
        match event {
            Event::Text(letters) => {
                let known = |letter: &char| font::lay_out(&letter.to_string(), 1.0).is_ok();
                typing.text.extend(letters.chars().filter(known));
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
            // Only the letters: height and place may have been changed by hand meanwhile.
            if let Some(Shape::Text { text, .. }) =
                editor.document.scene.targets.get_mut(index).map(|target| &mut target.shape)
                && *text != typing.text
            {
                text.clone_from(&typing.text);
            }
        }
        (false, None) => put(editor, &mut typing.index, tool::text(axes, typing.at, &typing.text)),
    }
    editor.typing = (!is_done).then_some(typing);
    if is_done {
        editor.tool = Tool::Select;
    }
}

pub fn end_typing(editor: &mut Editor) {
    editor.typing = None;
}
