//! Pointer gestures on the canvas: drawing, moving, selecting, erasing, and typing.

use std::collections::BTreeSet;

use egui::{Key, Modifiers, PointerButton, Pos2, Response, Ui};
use glam::DVec2;

use crate::picture::relief::Sight;
use crate::scene::{Body, Target, outline};
use crate::ui::gesture::{Gesture, Typing, closes};
use crate::ui::guides::Guides;
use crate::ui::measure::{self, ProfileLine};
use crate::ui::tool::{self, Tool};
use crate::ui::transform;
use crate::ui::typing;
use crate::ui::view::{Axes, Lens};
use crate::ui::{bodies, brush, edit, editor::Editor, group, handle, pen, way};

/// Pick distance of an outline in points.
const REACH: f64 = 9.0;
/// m, between the vertices of a stroke drawn by hand.
const STROKE_STEP: f64 = 1.5e-3;
const MOST_VERTICES: usize = 600;
/// Zoom per point of the wheel.
const ZOOM_PER_POINT: f64 = 1.0 / 240.0;

/// Handles pointer input. `response` is the canvas.
pub fn act(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    look_around(editor, ui, response, lens);
    // A quick click begins and ends within a frame.
    let is_meant = response.is_pointer_button_down_on() || response.clicked();
    let pressed = is_meant && ui.input(|input| input.pointer.primary_pressed());
    if !is_meant && ui.input(|input| input.pointer.any_pressed()) {
        // A click outside the canvas may change the list that contains the text or the path.
        typing::end(editor);
        pen::end(editor);
    }
    if editor.tool != Tool::Pen {
        pen::end(editor);
    }
    if let Some(at) = response.interact_pointer_pos() {
        let begins = pressed && editor.gesture.is_none() && !ui.input(|input| input.key_down(Key::Space));
        if begins {
            typing::end(editor);
        }
        let mut press = Press::new(editor, lens, at, ui.input(|input| input.modifiers));
        if begins {
            press.begin();
        }
        press.go_on();
    }
    if !ui.input(|input| input.pointer.any_down()) {
        end(editor, lens, response);
    }
    if editor.typing.is_some() {
        let axes = editor.view.axes(editor.scene());
        typing::write(editor, ui, &axes);
    }
}

/// Pans and zooms without editing.
pub fn watch(editor: &mut Editor, ui: &Ui, response: &Response, lens: &Lens) {
    typing::end(editor);
    pen::end(editor);
    look_around(editor, ui, response, lens);
    if response.double_clicked_by(PointerButton::Primary) {
        editor.view.relief.sight = Sight::default();
        editor.fit();
    } else if response.dragged_by(PointerButton::Primary) && !ui.input(|input| input.key_down(Key::Space)) {
        let by = response.drag_delta() / lens.rect.height().max(1.0);
        let sight = &mut editor.view.relief.sight;
        *sight = sight.orbited(DVec2::new(by.x.into(), by.y.into()));
    }
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

/// The pointer on the canvas in this frame.
struct Press<'a> {
    editor: &'a mut Editor,
    axes: Axes,
    lens: &'a Lens,
    at: Pos2,
    /// Its position in the plane, m.
    uv: DVec2,
    modifiers: Modifiers,
}

impl<'a> Press<'a> {
    fn new(editor: &'a mut Editor, lens: &'a Lens, at: Pos2, modifiers: Modifiers) -> Self {
        let axes = editor.view.axes(editor.scene());
        Self { editor, axes, lens, at, uv: lens.flat(at), modifiers }
    }

    /// The snapped position: on the grid if enabled, otherwise aligned with targets that are not `held`. Ctrl disables
    /// snapping.
    fn snapped(&mut self, held: Option<usize>) -> DVec2 {
        let uv = self.uv;
        self.editor.guides.clear();
        if self.modifiers.command {
            return uv;
        }
        if self.editor.snaps {
            return (uv / self.editor.grid).round() * self.editor.grid;
        }
        uv + self.line_up(&[uv], &held.into_iter().collect())
    }

    /// The displacement that aligns these points with targets that are not `held`.
    fn line_up(&mut self, places: &[DVec2], held: &BTreeSet<usize>) -> DVec2 {
        if !self.editor.view.guides {
            return DVec2::ZERO;
        }
        let (by, guides) = Guides::of(self.editor.scene(), &self.axes, held).attract(self.lens, places);
        self.editor.guides = guides;
        by
    }

    fn begin(&mut self) {
        let from = match self.editor.tool {
            Tool::Select | Tool::Freehand | Tool::Brush | Tool::Erase => self.uv,
            Tool::Point
            | Tool::Line
            | Tool::Circle
            | Tool::Rectangle
            | Tool::Triangle
            | Tool::Polygon
            | Tool::Pen
            | Tool::Text
            | Tool::Measure => self.snapped(None),
        };
        self.editor.gesture = match self.editor.tool {
            Tool::Select => Some(self.grab()),
            Tool::Point => {
                let Some(target) = self.editor.tool.click(&self.axes, from) else { return };
                self.editor.document.scene.targets.push(target.clone());
                let index = self.editor.scene().targets.len() - 1;
                self.editor.selection = BTreeSet::from([index]);
                self.editor.show_target();
                Some(Gesture::Move { from, before: vec![(index, target)], beside: false })
            }
            Tool::Text => {
                self.editor.selection.clear();
                self.editor.typing = Some(Typing::new(from));
                None
            }
            Tool::Pen => {
                let from = if self.modifiers.shift { pen::straight(self.editor, from) } else { from };
                let is_held = pen::press(self.editor, &self.axes, self.lens, self.at, from);
                is_held.then_some(Gesture::Bend { from: self.uv })
            }
            Tool::Freehand => Some(Gesture::Stroke { points: vec![self.uv], index: None }),
            Tool::Brush => {
                let index = brush::picture_at(self.editor, &self.axes, self.uv);
                Some(Gesture::Brush { last: None, index })
            }
            Tool::Erase => Some(Gesture::Erase { last: None }),
            Tool::Measure => {
                let other = other_end(self.editor, self.lens, self.at);
                Some(Gesture::Measure { fixed: other.unwrap_or(from) })
            }
            Tool::Line | Tool::Circle | Tool::Rectangle | Tool::Triangle | Tool::Polygon => {
                Some(Gesture::Draw { from, index: None })
            }
        };
    }

    /// Selects and grabs the target under the pointer, or begins a selection rectangle.
    fn grab(&mut self) -> Gesture {
        let from = self.uv;
        if let Some(pull) = way::take(self.editor, &self.axes, self.lens, self.at) {
            return Gesture::Way(pull);
        }
        if let Some(pull) = self.pull() {
            return pull;
        }
        if let Some(fixed) = other_end(self.editor, self.lens, self.at) {
            return Gesture::Measure { fixed };
        }
        if bodies::is_on_turner(self.editor, &self.axes, self.lens, self.at)
            && let Some(index) = self.editor.chosen_body()
        {
            return self.hold_body(index, true);
        }
        let Some(index) =
            edit::target_at(self.editor.scene(), &self.axes, from, REACH * self.lens.window.scale)
        else {
            if !self.modifiers.shift && transform::contains(self.editor, &self.axes, self.lens, self.at) {
                return self.hold(true);
            }
            if let Some(index) = bodies::at(self.editor, &self.axes, from) {
                self.editor.choose_body(index);
                return self.hold_body(index, false);
            }
            self.editor.body = None;
            let kept = if self.modifiers.shift { self.editor.selection.clone() } else { BTreeSet::new() };
            self.editor.selection = kept.clone();
            return Gesture::Band { from, kept };
        };
        let hit = group::around(self.editor.scene(), index);
        match (self.modifiers.shift, self.editor.selection.contains(&index)) {
            (true, true) => self.editor.selection.retain(|chosen| !hit.contains(chosen)),
            (true, false) => self.editor.selection.extend(hit),
            (false, true) => {}
            (false, false) => self.editor.selection = hit,
        }
        self.hold(false)
    }

    /// Grabs the selection, or with Alt a copy of it.
    fn hold(&mut self, beside: bool) -> Gesture {
        if self.modifiers.alt {
            edit::copy_in_place(&mut self.editor.document.scene, &mut self.editor.selection);
        }
        Gesture::Move { from: self.uv, before: selected(self.editor), beside }
    }

    fn hold_body(&self, index: usize, turns: bool) -> Gesture {
        let before = Box::new(self.editor.scene().bodies[index].clone());
        Gesture::Body { index, from: self.uv, before, turns }
    }

    /// Grabs a handle of the selection.
    fn pull(&self) -> Option<Gesture> {
        if let Some(grip) = transform::at(self.editor, &self.axes, self.lens, self.at) {
            return Some(Gesture::Transform { grip, from: self.uv, before: selected(self.editor) });
        }
        let index = self.editor.selection.first().copied().filter(|_| self.editor.selection.len() == 1)?;
        let before = self.editor.scene().targets.get(index)?.clone();
        let handle = handle::at(&before, &self.axes, self.lens, self.at)?;
        Some(Gesture::Pull { index, handle, before: Box::new(before) })
    }

    fn go_on(&mut self) {
        let Some(mut gesture) = self.editor.gesture.take() else { return };
        match &mut gesture {
            Gesture::Pan => {}
            Gesture::Pull { index, handle, before } => {
                let from = before.handles()[*handle];
                let uv = self.snapped(Some(*index));
                // Small movements during a click pull nothing.
                if uv.distance(self.axes.flat(from)) >= 2.0 * self.lens.window.scale {
                    let depth = self.axes.x.cross(self.axes.y) * self.axes.height(from);
                    if let Some(target) = self.editor.document.scene.targets.get_mut(*index) {
                        target.clone_from(before);
                        target.pull(*handle, self.axes.world(uv) + depth);
                    }
                }
            }
            Gesture::Way(pull) => {
                let uv = self.snapped(pull.target);
                way::pull(self.editor, &self.axes, self.lens, uv, pull);
            }
            Gesture::Move { from, before, .. } => self.follow(*from, before),
            Gesture::Body { index, from, before, turns } => {
                let body = if *turns { self.turned(*from, before) } else { self.moved(*from, before) };
                if let Some(place) = self.editor.document.scene.bodies.get_mut(*index) {
                    *place = body;
                }
            }
            Gesture::Bend { from } => pen::bend(self.editor, &self.axes, self.lens, self.uv - *from),
            Gesture::Band { from, kept } => {
                let inside = edit::targets_in(self.editor.scene(), &self.axes, *from, self.uv);
                let whole = inside.iter().flat_map(|&index| group::around(self.editor.scene(), index));
                self.editor.selection = kept.iter().copied().chain(whole).collect();
            }
            Gesture::Draw { from, index } => {
                let mut to = self.snapped(*index);
                if self.modifiers.shift {
                    to = self.editor.tool.straight(*from, to);
                }
                if let Some(target) = self.editor.tool.drag(&self.axes, *from, to) {
                    self.editor.put(index, target);
                }
            }
            Gesture::Stroke { points, index } => {
                let uv = self.uv;
                let is_far = points.last().is_none_or(|last| last.distance(uv) >= STROKE_STEP);
                if is_far && points.len() < MOST_VERTICES {
                    points.push(uv);
                    if points.len() > 1 {
                        self.editor.put(index, by_hand(tool::path(&self.axes, points, false)));
                    }
                }
            }
            Gesture::Brush { last, index } => {
                if let Some(way) = way(last, self.uv) {
                    *index = brush::paint(self.editor, &self.axes, *index, way);
                }
            }
            Gesture::Erase { last } => {
                let uv = self.uv;
                let is_deleted = |target: &Target| !brush::is_in(target, &self.axes);
                let reach = REACH * self.lens.window.scale;
                if let Some(index) =
                    edit::target_among(self.editor.scene(), &self.axes, uv, reach, is_deleted)
                {
                    let mut erased = BTreeSet::from([index]);
                    edit::delete(&mut self.editor.document.scene, &mut erased);
                    self.editor.selection.clear();
                }
                if let Some(way) = way(last, uv) {
                    brush::wipe(self.editor, &self.axes, way);
                }
            }
            Gesture::Measure { fixed } => {
                let mut to = self.snapped(None);
                if self.modifiers.shift {
                    to = Tool::Line.straight(*fixed, to);
                }
                if fixed.distance(to) >= measure::SHORTEST {
                    self.editor.view.line = ProfileLine::Between([*fixed, to]);
                }
            }
            Gesture::Transform { grip, from, before } => {
                for (index, target) in before.iter() {
                    let pulled =
                        transform::pulled(target, *grip, &self.axes, *from, self.uv, self.modifiers.shift);
                    if let Some(target) = self.editor.document.scene.targets.get_mut(*index) {
                        *target = pulled;
                    }
                }
            }
        }
        self.editor.gesture = Some(gesture);
    }

    /// The held body at the pointer.
    fn moved(&mut self, from: DVec2, before: &Body) -> Body {
        self.editor.guides.clear();
        let mut by = self.uv - from;
        // A click that trembles is no move.
        if by.length() < 2.0 * self.lens.window.scale {
            return before.clone();
        }
        if !self.modifiers.command {
            let middle = self.axes.flat(before.at);
            if self.editor.snaps {
                by = ((middle + by) / self.editor.grid).round() * self.editor.grid - middle;
            } else {
                by += self.line_up(&[middle + by], &BTreeSet::new());
            }
        }
        Body { at: before.at + self.axes.x * by.x + self.axes.y * by.y, ..before.clone() }
    }

    /// The held body turned to the pointer.
    fn turned(&self, from: DVec2, before: &Body) -> Body {
        let middle = self.axes.flat(before.at);
        let angle = (from - middle).angle_to(self.uv - middle);
        bodies::turned_in(before, &self.axes, angle, self.modifiers.shift)
    }

    /// Moves the held targets to the pointer.
    fn follow(&mut self, from: DVec2, before: &[(usize, Target)]) {
        self.editor.guides.clear();
        let mut by = self.uv - from;
        // A click that trembles is no move.
        if by.length() < 2.0 * self.lens.window.scale {
            by = DVec2::ZERO;
        }
        if let (true, Some((_, first))) = (by != DVec2::ZERO && !self.modifiers.command, before.first()) {
            let centre = self.axes.flat(outline::centre(&first.shape));
            if self.editor.snaps {
                // The first target snaps to the grid and the others keep their offsets.
                by = ((centre + by) / self.editor.grid).round() * self.editor.grid - centre;
            } else {
                let edges =
                    edit::bounds(before.iter().map(|(_, target)| target), &self.axes).unwrap_or([centre; 2]);
                let middle = if before.len() == 1 { centre } else { (edges[0] + edges[1]) / 2.0 };
                let held = before.iter().map(|(index, _)| *index).collect();
                let places = [middle, edges[0], edges[1]].map(|place| place + by);
                by += self.line_up(&places, &held);
            }
        }
        for (index, target) in before {
            let mut moved = target.clone();
            if by != DVec2::ZERO {
                moved.shape.translate(self.axes.x * by.x + self.axes.y * by.y);
            }
            if let Some(target) = self.editor.document.scene.targets.get_mut(*index) {
                *target = moved;
            }
        }
    }
}

/// The name of a path drawn with the button held.
fn by_hand(path: Target) -> Target {
    Target { name: "Freehand".to_owned(), ..path }
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

/// The movement of the pointer; `None` at rest.
fn way(last: &mut Option<DVec2>, to: DVec2) -> Option<[DVec2; 2]> {
    let from = last.replace(to).unwrap_or(DVec2::INFINITY);
    (from != to).then_some([if from.is_finite() { from } else { to }, to])
}

fn end(editor: &mut Editor, lens: &Lens, response: &Response) {
    let Some(gesture) = editor.gesture.take() else { return };
    let axes = editor.view.axes(editor.scene());
    editor.guides.clear();
    if let Gesture::Stroke { points, index: Some(index) } = &gesture
        && closes(points, lens)
    {
        editor.put(&mut Some(*index), by_hand(tool::path(&axes, &points[..points.len() - 1], true)));
    }
    if let Gesture::Draw { index: None, .. } = gesture
        && response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        let at = Press::new(editor, lens, at, Modifiers::NONE).snapped(None);
        editor.guides.clear();
        if let Some(target) = editor.tool.click(&axes, at) {
            editor.put(&mut None, target);
        }
    }
    if let (Gesture::Measure { .. }, ProfileLine::Between(_)) = (&gesture, editor.view.line) {
        // Not earlier: its panel takes space from the map under the pointer.
        editor.view.section = true;
    }
    if let Gesture::Erase { .. } = gesture {
        brush::clear_away(editor);
    }
    if let Gesture::Draw { .. } | Gesture::Stroke { .. } = gesture {
        editor.show_target();
    }
    if let (Gesture::Move { beside: true, .. }, true) = (&gesture, response.clicked()) {
        editor.selection.clear();
    }
}
