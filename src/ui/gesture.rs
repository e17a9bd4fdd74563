//! Pointer gestures on the canvas: drawing, moving, selecting, erasing, and typing.

use std::collections::BTreeSet;

use egui::{Key, Modifiers, PointerButton, Pos2, Response, Ui};
use glam::DVec2;

use crate::scene::{Target, outline};
use crate::ui::Editor;
use crate::ui::brush;
use crate::ui::edit;
use crate::ui::group;
use crate::ui::guides::Guides;
use crate::ui::handle;
use crate::ui::measure::{self, ProfileLine};
use crate::ui::tool::{self, Tool};
use crate::ui::transform::{self, Grip};
use crate::ui::typing::{self, Typing};
use crate::ui::view::{Axes, Lens};
use crate::ui::way;

/// Pick distance of an outline in points.
const REACH: f64 = 9.0;
/// The same between the ends of a stroke, for closing it.
pub const CLOSES: f64 = 14.0;
/// m, between the vertices of a stroke drawn by hand.
const STROKE_STEP: f64 = 1.5e-3;
const MOST_VERTICES: usize = 600;
/// Zoom per point of the wheel.
const ZOOM_PER_POINT: f64 = 1.0 / 240.0;

/// An edit in progress while the button is held.
#[derive(Clone, Debug)]
pub enum Gesture {
    Pan,
    /// Starting point, and the targets before.
    Move {
        from: DVec2,
        before: Vec<(usize, Target)>,
    },
    /// A handle of the single selected target, and its state before.
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
    /// A shape being drawn: its index in the scene once it has a size.
    Draw {
        from: DVec2,
        index: Option<usize>,
    },
    Stroke {
        points: Vec<DVec2>,
        index: Option<usize>,
    },
    Brush {
        /// Position in the previous frame.
        last: Option<DVec2>,
        /// The painted picture, once it exists.
        index: Option<usize>,
    },
    Erase {
        last: Option<DVec2>,
    },
    /// A line is measured from here.
    Measure {
        fixed: DVec2,
    },
    /// The selection is being scaled or rotated.
    Transform {
        grip: Grip,
        from: DVec2,
        before: Vec<(usize, Target)>,
    },
}

/// Handles pointer input. `response` is the canvas.
pub fn act(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    look_around(editor, ui, response, lens);
    let axes = editor.view.axes(editor.scene());
    let modifiers = ui.input(|input| input.modifiers);
    // A quick click begins and ends within a frame.
    let is_meant = response.is_pointer_button_down_on() || response.clicked();
    let pressed = is_meant && ui.input(|input| input.pointer.primary_pressed());
    if !is_meant && ui.input(|input| input.pointer.any_pressed()) {
        // A click outside the canvas may change the list that contains the text.
        typing::end(editor);
    }
    if let Some(at) = response.interact_pointer_pos() {
        if pressed && editor.gesture.is_none() && !ui.input(|input| input.key_down(Key::Space)) {
            typing::end(editor);
            begin(editor, &axes, lens, at, modifiers);
        }
        go_on(editor, &axes, lens, at, modifiers);
    }
    if !ui.input(|input| input.pointer.any_down()) {
        end(editor, &axes, lens, response);
    }
    if editor.typing.is_some() {
        typing::write(editor, ui, &axes);
    }
}

/// Pans and zooms without editing.
pub fn watch(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    typing::end(editor);
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
    let moves_line = ui.input(|input| input.modifiers.shift && !input.pointer.any_down());
    if let (true, Some(at), ProfileLine::Across(v)) =
        (editor.view.section && moves_line, response.hover_pos(), &mut editor.view.line)
    {
        *v = lens.flat(at).y;
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
            editor.fit();
        }
    }
}

/// The snapped position: on the grid if enabled, otherwise aligned with targets that are not `held`. Ctrl disables
/// snapping.
fn place(
    editor: &mut Editor,
    axes: &Axes,
    lens: &Lens,
    (at, modifiers): (Pos2, Modifiers),
    held: Option<usize>,
) -> DVec2 {
    let uv = lens.flat(at);
    editor.guides.clear();
    if modifiers.command {
        return uv;
    }
    if editor.snaps {
        return (uv / editor.grid).round() * editor.grid;
    }
    uv + line_up(editor, axes, lens, &[uv], &held.into_iter().collect())
}

/// The displacement that aligns these points with targets that are not `held`.
fn line_up(editor: &mut Editor, axes: &Axes, lens: &Lens, places: &[DVec2], held: &BTreeSet<usize>) -> DVec2 {
    if !editor.view.guides {
        return DVec2::ZERO;
    }
    let (by, guides) = Guides::of(editor.scene(), axes, held).attract(lens, places);
    editor.guides = guides;
    by
}

fn begin(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2, modifiers: Modifiers) {
    let from = place(editor, axes, lens, (at, modifiers), None);
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
            editor.typing = Some(Typing::new(from));
            None
        }
        Tool::Freehand => Some(Gesture::Stroke { points: vec![lens.flat(at)], index: None }),
        Tool::Brush => {
            let index = brush::picture_at(editor, axes, lens.flat(at));
            Some(Gesture::Brush { last: None, index })
        }
        Tool::Erase => Some(Gesture::Erase { last: None }),
        Tool::Measure => {
            let other = other_end(editor, lens, at);
            Some(Gesture::Measure { fixed: other.unwrap_or(from) })
        }
        _ => Some(Gesture::Draw { from, index: None }),
    };
}

/// Selects and grabs the target under the pointer, or begins a selection rectangle.
fn grab(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2, modifiers: Modifiers) -> Gesture {
    let from = lens.flat(at);
    if let Some(pull) = way::take(editor, axes, lens, at) {
        return Gesture::Way(pull);
    }
    if let Some(pull) = pull(editor, axes, lens, at) {
        return pull;
    }
    if let Some(fixed) = other_end(editor, lens, at) {
        return Gesture::Measure { fixed };
    }
    let Some(index) = edit::target_at(editor.scene(), axes, from, REACH * lens.window.scale) else {
        let kept = if modifiers.shift { editor.selection.clone() } else { BTreeSet::new() };
        editor.selection = kept.clone();
        return Gesture::Band { from, kept };
    };
    let hit = group::around(editor.scene(), index);
    match (modifiers.shift, editor.selection.contains(&index)) {
        (true, true) => editor.selection.retain(|chosen| !hit.contains(chosen)),
        (true, false) => editor.selection.extend(hit),
        (false, true) => {}
        (false, false) => editor.selection = hit,
    }
    if modifiers.alt {
        edit::copy_in_place(&mut editor.document.scene, &mut editor.selection);
    }
    Gesture::Move { from, before: selected(editor) }
}

/// The selected targets, with their indices.
fn selected(editor: &Editor) -> Vec<(usize, Target)> {
    let targets = &editor.scene().targets;
    let target = |&index: &usize| targets.get(index).map(|target| (index, target.clone()));
    editor.selection.iter().filter_map(target).collect()
}

/// The end of the measured line that stays when the one under the pointer is dragged.
fn other_end(editor: &Editor, lens: &Lens, at: Pos2) -> Option<DVec2> {
    let ProfileLine::Between([from, to]) = editor.view.line else { return None };
    let is_near = |end: DVec2| f64::from(lens.screen(end).distance(at)) <= REACH;
    match (editor.view.section, is_near(to), is_near(from)) {
        (true, true, _) => Some(from),
        (true, false, true) => Some(to),
        (true, false, false) | (false, _, _) => None,
    }
}

/// Grabs a handle of the selection.
fn pull(editor: &Editor, axes: &Axes, lens: &Lens, at: Pos2) -> Option<Gesture> {
    if let Some(grip) = transform::at(editor, axes, lens, at) {
        return Some(Gesture::Transform { grip, from: lens.flat(at), before: selected(editor) });
    }
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
            let from = before.handles()[*handle];
            let uv = place(editor, axes, lens, (at, modifiers), Some(*index));
            // Small movements during a click pull nothing.
            if uv.distance(axes.flat(from)) >= 2.0 * lens.window.scale {
                let depth = axes.x.cross(axes.y) * axes.height(from);
                if let Some(target) = editor.document.scene.targets.get_mut(*index) {
                    target.clone_from(before);
                    target.pull(*handle, axes.world(uv) + depth);
                }
            }
        }
        Gesture::Way(pull) => {
            let uv = place(editor, axes, lens, (at, modifiers), pull.target());
            way::pull(editor, axes, lens, uv, pull);
        }
        Gesture::Move { from, before } => follow(editor, axes, lens, (at, modifiers), (*from, before)),
        Gesture::Band { from, kept } => {
            let inside = edit::targets_in(editor.scene(), axes, *from, lens.flat(at));
            let whole = inside.iter().flat_map(|&index| group::around(editor.scene(), index));
            editor.selection = kept.iter().copied().chain(whole).collect();
        }
        Gesture::Draw { from, index } => {
            let mut to = place(editor, axes, lens, (at, modifiers), *index);
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
                    put(editor, index, tool::path(axes, points, false));
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
        Gesture::Measure { fixed } => {
            let mut to = place(editor, axes, lens, (at, modifiers), None);
            if modifiers.shift {
                to = straight(Tool::Line, *fixed, to);
            }
            if fixed.distance(to) >= measure::SHORTEST {
                editor.view.line = ProfileLine::Between([*fixed, to]);
            }
        }
        Gesture::Transform { grip, from, before } => {
            for (index, target) in before.iter() {
                let pulled = transform::pulled(target, *grip, axes, *from, lens.flat(at), modifiers.shift);
                if let Some(target) = editor.document.scene.targets.get_mut(*index) {
                    *target = pulled;
                }
            }
        }
    }
    editor.gesture = Some(gesture);
}

/// The movement of the pointer; `None` at rest.
fn way(last: &mut Option<DVec2>, to: DVec2) -> Option<[DVec2; 2]> {
    let from = last.replace(to).unwrap_or(DVec2::INFINITY);
    (from != to).then_some([if from.is_finite() { from } else { to }, to])
}

/// Whether a stroke ends close to its start.
pub fn closes(points: &[DVec2], lens: &Lens) -> bool {
    let reach = CLOSES * lens.window.scale;
    let [first, .., last] = points else { return false };
    let length: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    points.len() > 4 && first.distance(*last) <= reach && length > 4.0 * reach
}

/// Moves the held targets to the pointer.
fn follow(
    editor: &mut Editor,
    axes: &Axes,
    lens: &Lens,
    (at, modifiers): (Pos2, Modifiers),
    (from, before): (DVec2, &[(usize, Target)]),
) {
    editor.guides.clear();
    let mut by = lens.flat(at) - from;
    // A click that trembles is no move.
    if by.length() < 2.0 * lens.window.scale {
        by = DVec2::ZERO;
    }
    if let (true, Some((_, first))) = (by != DVec2::ZERO && !modifiers.command, before.first()) {
        let centre = axes.flat(outline::centre(&first.shape));
        if editor.snaps {
            // The first target snaps to the grid and the others keep their offsets.
            by = ((centre + by) / editor.grid).round() * editor.grid - centre;
        } else {
            let edges = edit::bounds(before.iter().map(|(_, target)| target), axes).unwrap_or([centre; 2]);
            let middle = if before.len() == 1 { centre } else { (edges[0] + edges[1]) / 2.0 };
            let held = before.iter().map(|(index, _)| *index).collect();
            let places = [middle, edges[0], edges[1]].map(|place| place + by);
            by += line_up(editor, axes, lens, &places, &held);
        }
    }
    for (index, target) in before {
        let mut moved = target.clone();
        if by != DVec2::ZERO {
            moved.shape.translate(axes.x * by.x + axes.y * by.y);
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

/// Puts a target being drawn into the scene, replacing its previous state.
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
    editor.guides.clear();
    if let Gesture::Stroke { points, index: Some(index) } = &gesture
        && closes(points, lens)
    {
        put(editor, &mut Some(*index), tool::path(axes, &points[..points.len() - 1], true));
    }
    if let Gesture::Draw { index: None, .. } = gesture
        && response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        let at = place(editor, axes, lens, (at, Modifiers::NONE), None);
        editor.guides.clear();
        if let Some(target) = editor.tool.click(axes, at) {
            put(editor, &mut None, target);
        }
    }
    if let (Gesture::Measure { .. }, ProfileLine::Between(_)) = (&gesture, editor.view.line) {
        // Not earlier: its panel takes space from the map under the pointer.
        editor.view.section = true;
    }
    if let Gesture::Erase { .. } = gesture {
        brush::clear_away(editor);
    }
}
