//! Pointer input in the 3D view: orbiting, selecting targets, and dragging targets, slices and the clipping box.

use std::collections::BTreeSet;

use egui::{PointerButton, Pos2, Rect, Response, Sense, Ui, vec2};
use glam::{DVec2, DVec3};

use crate::field::volume::Camera;
use crate::scene::{Target, outline};
use crate::ui::space::Stage;
use crate::ui::space::handle::{self};
use crate::ui::space::view::Handle;
use crate::ui::space::view::Held;
use crate::ui::tool::Tool;
use crate::ui::{bodies, canvas, editor::Editor, group, shown::Shown};

/// Pick distance of an outline in points.
const REACH: f32 = 10.0;
/// Zoom per point of the wheel.
const ZOOM_PER_POINT: f64 = 1.0 / 240.0;
/// Downward component of the line of sight beyond which targets are dragged at constant height.
const FROM_ABOVE: f64 = 0.35;
/// The thinnest that the box is clipped, as a part of it.
const THINNEST: f64 = 0.02;

/// Allocates the view and handles pointer input.
pub fn interact(editor: &mut Editor, shown: &Shown, ui: &mut Ui) -> Stage {
    // Drawing tools work on the map: selecting one leaves the 3D view.
    if editor.tool != Tool::Select {
        if editor.space.was_on {
            editor.space.is_on = false;
        } else {
            editor.tool = Tool::Select;
        }
        ui.ctx().request_repaint();
    }
    editor.space.was_on = true;
    let outer = ui.available_rect_before_wrap();
    let max = (outer.max - vec2(canvas::RIGHT, 8.0)).max(outer.min + vec2(60.0, 60.0));
    let rect = Rect::from_min_max((outer.min + vec2(8.0, 8.0)).round(), max.round());
    let response = ui.interact(rect, ui.scope_id().with("space"), Sense::click_and_drag());
    ui.advance_cursor_after_rect(outer);
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Canvas: the scene in space"));
    let is_down = ui.input(|input| input.pointer.any_down());
    let scene = editor.document.scene.clone();
    // The frame of the release counts, too.
    let is_held = is_down || editor.space.is_held() || ui.ctx().text_edit_focused();
    let [block, whole] = editor.space.frame(&scene, shown.sound.as_ref(), is_held);
    let aspect = f64::from(rect.width() / rect.height());
    let camera = |editor: &Editor| {
        let space = &editor.space;
        let home = || Camera::of(&whole, space.direction, aspect, space.is_perspective);
        space.camera.map_or_else(home, |camera| Camera { is_perspective: space.is_perspective, ..camera })
    };
    let stage = |editor: &Editor| Stage {
        rect,
        camera: camera(editor),
        block,
        clip: editor.space.clipped(&block),
        is_moving: false,
        over: None,
    };
    let before = stage(editor);
    look_around(editor, ui, &response, &before);
    hold(editor, ui, &response, &stage(editor));
    let mut stage = stage(editor);
    let is_looking = stage.camera != before.camera;
    stage.is_moving = is_looking || editor.playback.playing || (is_down && editor.space.is_held());
    if let Some(at) = response.hover_pos().filter(|_| !is_down) {
        stage.over = handle::at(&stage, &editor.space, chosen(editor), at);
    }
    if let Some(Held::Targets { handle, .. } | Held::Slide { handle, .. }) = &editor.space.held {
        stage.over = Some(*handle);
    }
    if stage.over.is_some() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
    }
    stage
}

/// The centre of the selection, or the place of the chosen body.
pub fn chosen(editor: &Editor) -> Option<DVec3> {
    if let Some(index) = editor.chosen_body() {
        return Some(editor.scene().bodies[index].at);
    }
    let targets = &editor.scene().targets;
    let places = editor.selection.iter().filter_map(|&index| targets.get(index));
    let centres: Vec<_> = places.map(|target| outline::centre(&target.shape)).collect();
    (!centres.is_empty()).then(|| centres.iter().sum::<DVec3>() / centres.len() as f64)
}

/// Parts of the picture's height from its middle.
fn part(stage: &Stage, at: Pos2) -> DVec2 {
    let offset = (at - stage.rect.center()) / stage.rect.height();
    DVec2::new(offset.x.into(), offset.y.into())
}

/// Wheel, middle button, shift and double click.
fn look_around(editor: &mut Editor, ui: &Ui, response: &Response, stage: &Stage) {
    if let Some(at) = response.hover_pos() {
        let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = f64::from(pinch) * (f64::from(wheel) * ZOOM_PER_POINT).exp();
        if factor != 1.0 {
            editor.space.camera = Some(stage.camera.zoomed(part(stage, at), factor));
        }
    }
    let is_aside =
        response.dragged_by(PointerButton::Middle) || response.dragged_by(PointerButton::Secondary);
    let moved = response.drag_delta() / stage.rect.height();
    let moved = DVec2::new(moved.x.into(), moved.y.into());
    if moved != DVec2::ZERO {
        match &editor.space.held {
            Some(Held::Pan) => editor.space.camera = Some(stage.camera.panned(moved)),
            Some(Held::Orbit) => editor.space.camera = Some(stage.camera.orbited(moved)),
            None if is_aside => {
                editor.space.held = Some(Held::Pan);
                editor.space.camera = Some(stage.camera.panned(moved));
            }
            Some(Held::Targets { .. } | Held::Slide { .. }) | None => {}
        }
    }
    let is_on_target = response.interact_pointer_pos().is_some_and(|at| is_on_object(editor, stage, at));
    if response.double_clicked_by(PointerButton::Primary) && !is_on_target {
        editor.space.go_home();
    }
}

/// Handles press, drag and release of the primary button.
fn hold(editor: &mut Editor, ui: &Ui, response: &Response, stage: &Stage) {
    let is_meant = response.is_pointer_button_down_on() || response.clicked();
    let pressed = is_meant && ui.input(|input| input.pointer.primary_pressed());
    let modifiers = ui.input(|input| input.modifiers);
    if let Some(at) = response.interact_pointer_pos() {
        if pressed && editor.space.held.is_none() {
            let held = take(editor, stage, at, modifiers);
            if let Held::Targets { .. } = held {
                // The box may grow during a drag; the view stays.
                editor.space.camera = Some(stage.camera);
            }
            editor.space.held = Some(held);
        }
        drag(editor, stage, at, modifiers);
    }
    if response.clicked() {
        choose(editor, stage, response.interact_pointer_pos(), modifiers);
    }
    if !ui.input(|input| input.pointer.any_down()) {
        editor.space.held = None;
    }
}

fn take(editor: &mut Editor, stage: &Stage, at: Pos2, modifiers: egui::Modifiers) -> Held {
    match handle::at(stage, &editor.space, chosen(editor), at) {
        Some(handle @ (Handle::Axis(_) | Handle::Plane(_))) => return grab(editor, stage, handle, at),
        Some(handle @ (Handle::Slice(_) | Handle::Face(..))) => {
            let knob = handle::knob(handle, &editor.space, &stage.clip).unwrap_or(stage.clip.centre);
            let taken = handle::dragged(handle, stage.ray(at), knob).unwrap_or(knob);
            return Held::Slide { handle, off: (knob - taken).element_sum() };
        }
        None => {}
    }
    match target_at(editor, stage, at) {
        Some(index) if !editor.selection.contains(&index) => {
            let hit = group::around(editor.scene(), index);
            if modifiers.shift {
                editor.selection.extend(hit);
            } else {
                editor.selection = hit;
            }
        }
        Some(_) => {}
        None => match bodies::hit(editor, stage.ray(at)).filter(|_| !modifiers.shift) {
            Some(index) => editor.choose_body(index),
            None => return if modifiers.shift { Held::Pan } else { Held::Orbit },
        },
    }
    // At constant height when seen from above, otherwise vertically across the line of sight.
    let forward = stage.camera.axes()[2];
    let across = if forward.z.abs() > FROM_ABOVE { 2 } else { forward.truncate().abs().max_position() };
    grab(editor, stage, Handle::Plane(across), at)
}

/// Grabs the selection.
fn grab(editor: &Editor, stage: &Stage, handle: Handle, at: Pos2) -> Held {
    let centre = chosen(editor).unwrap_or(stage.block.centre);
    let from = handle::dragged(handle, stage.ray(at), centre).unwrap_or(centre);
    let targets = &editor.scene().targets;
    let target = |&index: &usize| targets.get(index).map(|target| (index, target.clone()));
    let body = editor.chosen_body().map(|index| (index, editor.scene().bodies[index].at));
    Held::Targets { handle, from, before: editor.selection.iter().filter_map(target).collect(), body }
}

fn drag(editor: &mut Editor, stage: &Stage, at: Pos2, modifiers: egui::Modifiers) {
    let ray = stage.ray(at);
    match editor.space.held.clone() {
        Some(Held::Targets { handle, from, before, body }) => {
            let Some(to) = handle::dragged(handle, ray, from) else { return };
            let mut by = freed(handle, to - from);
            // A click that trembles is no move.
            if by.length() < 2.0 * stage.per_point(from) {
                by = DVec3::ZERO;
            }
            let first = before.first().map(|(_, first)| outline::centre(&first.shape));
            if let Some(centre) = first.or(body.map(|(_, at)| at))
                && editor.snaps
                && !modifiers.command
            {
                by = snapped(handle, centre, by, editor.grid);
            }
            if let Some((index, at)) = body
                && let Some(body) = editor.document.scene.bodies.get_mut(index)
            {
                body.at = at + by;
            }
            for (index, target) in before {
                let mut moved: Target = target;
                if by != DVec3::ZERO {
                    moved.shape.translate(by);
                }
                if let Some(target) = editor.document.scene.targets.get_mut(index) {
                    *target = moved;
                }
            }
        }
        Some(Held::Slide { handle, off }) => {
            let knob = handle::knob(handle, &editor.space, &stage.clip).unwrap_or(stage.clip.centre);
            let Some(to) = handle::dragged(handle, ray, knob) else { return };
            slide(editor, stage, handle, to, off);
        }
        Some(Held::Orbit | Held::Pan) | None => {}
    }
}

/// The move that snaps a point to the grid along the handle's axes.
fn snapped(handle: Handle, centre: DVec3, by: DVec3, grid: f64) -> DVec3 {
    freed(handle, ((centre + by) / grid).round() * grid - centre)
}

/// The part of a move permitted by a handle: exactly zero across its axis or plane.
fn freed(handle: Handle, by: DVec3) -> DVec3 {
    let is_free = |axis: usize| match handle {
        Handle::Axis(own) | Handle::Slice(own) | Handle::Face(own, _) => axis == own,
        Handle::Plane(own) => axis != own,
    };
    DVec3::from_array([0, 1, 2].map(|axis| if is_free(axis) { by[axis] } else { 0.0 }))
}

/// Moves a slice, or a face of the clipped box.
fn slide(editor: &mut Editor, stage: &Stage, handle: Handle, to: DVec3, off: f64) {
    let (low, high) = (stage.block.low(), stage.block.high());
    match handle {
        Handle::Slice(axis) => {
            editor.space.slices[axis] = Some((to[axis] + off).clamp(low[axis], high[axis]));
        }
        Handle::Face(axis, is_high) => {
            let part = ((to[axis] + off - low[axis]) / (high[axis] - low[axis])).clamp(0.0, 1.0);
            let [lower, upper] = &mut editor.space.clip;
            if is_high {
                upper[axis] = part.max(lower[axis] + THINNEST).min(1.0);
            } else {
                lower[axis] = part.min(upper[axis] - THINNEST).max(0.0);
            }
        }
        Handle::Axis(_) | Handle::Plane(_) => {}
    }
}

/// A click on empty space clears the selection.
fn choose(editor: &mut Editor, stage: &Stage, at: Option<Pos2>, modifiers: egui::Modifiers) {
    let Some(at) = at else { return };
    let is_on_handle = handle::at(stage, &editor.space, chosen(editor), at).is_some();
    if !is_on_handle && !modifiers.shift && !is_on_object(editor, stage, at) {
        (editor.selection, editor.body) = (BTreeSet::new(), None);
    }
}

/// Whether a target or a body is at a screen position.
fn is_on_object(editor: &Editor, stage: &Stage, at: Pos2) -> bool {
    target_at(editor, stage, at).is_some() || bodies::hit(editor, stage.ray(at)).is_some()
}

/// The target with the outline nearest to a screen position.
fn target_at(editor: &Editor, stage: &Stage, at: Pos2) -> Option<usize> {
    let distance = |target: &Target| {
        let strokes = outline::strokes(target).unwrap_or_default();
        let seen = strokes.iter().map(|stroke| {
            let places: Vec<_> = stroke.iter().filter_map(|&point| stage.screen(point)).collect();
            match places[..] {
                [only] => only.distance(at),
                _ => places
                    .windows(2)
                    .map(|ends| handle::distance(ends[0], ends[1], at))
                    .fold(f32::INFINITY, f32::min),
            }
        });
        seen.fold(f32::INFINITY, f32::min)
    };
    let visible = editor.scene().targets.iter().enumerate().filter(|(_, target)| target.visible);
    let nearest = visible.map(|(index, target)| (index, distance(target)));
    let (index, off) = nearest.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (off <= REACH).then_some(index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_handle_moves_comes_to_the_grid() {
        let (centre, by) = (DVec3::new(0.0011, 0.0022, 0.1003), DVec3::new(0.0132, 0.0, 0.0));
        let moved = centre + snapped(Handle::Axis(0), centre, by, 0.005);
        assert!(moved.distance(DVec3::new(0.015, 0.0022, 0.1003)) < 1e-12, "{moved}");
        let moved = centre + snapped(Handle::Plane(0), centre, DVec3::new(0.0, 0.004, 0.009), 0.005);
        assert!(moved.distance(DVec3::new(0.0011, 0.005, 0.11)) < 1e-12, "{moved}");
    }
}
