//! Motion paths over the map with their handles, and moving targets at their position in the displayed frame.

use egui::{Align2, Color32, Painter, Pos2, Shape, Stroke, vec2};
use glam::DVec3;

use crate::scene::{MotionPath, motion, outline};
use crate::ui::gesture::Vertex;
use crate::ui::view::{Axes, Lens};
use crate::ui::way;
use crate::ui::{edit, editor::Editor, marks, shown::Shown, theme};

/// Points of the screen: half a handle.
const HALF: f32 = 5.5;
/// Limit of targets with drawn paths.
const FEW: usize = 6;

/// Paths, handles, and moving targets.
pub fn paint(editor: &Editor, shown: &Shown, painter: &Painter, lens: &Lens) {
    let scene = editor.scene();
    let axes = editor.view.axes(scene);
    let held = way::held(editor);
    for (index, target) in scene.targets.iter().enumerate().filter(|(_, target)| target.visible).take(FEW) {
        let own = target.motion.is_some().then_some(index);
        let Some(motion) = way::motion_of(scene, own) else { continue };
        let centre = outline::centre(&target.shape);
        if motion.path == MotionPath::Outline {
            for stroke in edit::outline_on(target, &axes) {
                let stroke: Vec<_> = stroke.into_iter().map(|uv| lens.screen(uv)).collect();
                painter.extend(Shape::dotted_line(&stroke, theme::line(editor.view.is_light, 150), 6.0, 2.0));
            }
        } else if motion.path == MotionPath::File {
            for line in way::route(scene, index, &axes, lens) {
                painter.extend(Shape::dotted_line(&line, theme::line(editor.view.is_light, 150), 6.0, 1.2));
            }
        } else if way::arm(motion.path).is_some() || !way::handles(motion).is_empty() {
            let line = way::way(motion, centre, &axes, lens);
            if held == Some((own, centre)) {
                painter.add(Shape::line(line.clone(), Stroke::new(3.0, theme::MARK_EDGE)));
                painter.add(Shape::line(line, Stroke::new(1.4, theme::CHOSEN)));
            } else {
                painter.extend(Shape::dotted_line(&line, theme::line(editor.view.is_light, 150), 6.0, 1.2));
            }
        }
    }
    moved(editor, painter, &axes, lens);
    if let Some((target, centre)) = held {
        paint_handles(editor, painter, &axes, lens, (target, centre));
    }
    speeds(editor, shown, painter, &axes, lens);
}

/// Outlines at their position in the displayed frame.
fn moved(editor: &Editor, painter: &Painter, axes: &Axes, lens: &Lens) {
    let (Some(frame), Some(cycle)) = (editor.playback.moment.frame(), motion::cycle(editor.scene())) else {
        return;
    };
    for (index, target) in editor.scene().targets.iter().enumerate().filter(|(_, target)| target.visible) {
        let own = target.motion.is_some().then_some(index);
        let Some(group) = cycle.groups.iter().find(|group| group.target == own) else { continue };
        let pose = motion::pose_of(editor.scene(), index, way::part_of(&cycle, group, frame));
        let mut there = target.clone();
        there.shape.translate(pose.at);
        there.angle += pose.angle;
        for stroke in edit::outline_on(&there, axes).into_iter().filter(|stroke| stroke.len() > 1) {
            let stroke: Vec<_> = stroke.into_iter().map(|uv| lens.screen(uv)).collect();
            painter.add(Shape::line(stroke, Stroke::new(1.6, theme::line(editor.view.is_light, 200))));
        }
    }
}

fn paint_handles(
    editor: &Editor,
    painter: &Painter,
    axes: &Axes,
    lens: &Lens,
    (target, centre): (Option<usize>, DVec3),
) {
    let Some(motion) = way::motion_of(editor.scene(), target) else { return };
    let screen = |offset: DVec3| lens.screen(axes.flat(centre + offset));
    for (index, offset) in way::handles(motion).into_iter().enumerate() {
        let is_chosen = editor.vertex == Some(Vertex { target, index });
        diamond(painter, screen(offset), HALF, if is_chosen { theme::CHOSEN } else { theme::MARK });
    }
    if let Some(offset) = way::marker(editor, target) {
        let at = screen(offset);
        painter.circle_stroke(at, 9.0, Stroke::new(4.0, theme::MARK_EDGE));
        painter.circle_stroke(at, 9.0, Stroke::new(2.0, theme::CHOSEN));
    }
}

/// The marker of keyframes and path handles.
pub fn diamond(painter: &Painter, at: Pos2, half: f32, fill: Color32) {
    let corners = [vec2(0.0, -half), vec2(half, 0.0), vec2(0.0, half), vec2(-half, 0.0)];
    let corners = corners.map(|corner| at + corner).to_vec();
    painter.add(Shape::convex_polygon(corners, fill, Stroke::new(1.5, theme::ACCENT)));
}

/// Speeds of foci along outlines, beside the first of each.
fn speeds(editor: &Editor, shown: &Shown, painter: &Painter, axes: &Axes, lens: &Lens) {
    let (Some(frame), Some(round)) = (editor.playback.moment.frame(), &shown.round) else { return };
    let Some(cycle) = motion::cycle(editor.scene()) else { return };
    let Some(frame) = round.frames.get(frame) else { return };
    let running = cycle.groups.iter().filter(|group| group.motion.path == MotionPath::Outline);
    // They are last in a frame, in the order of the groups.
    let mut end = frame.foci.len();
    for group in running.rev() {
        let Some(first) = end.checked_sub(group.motion.foci as usize) else { return };
        for focus in &frame.foci[first..end] {
            let at = lens.screen(axes.flat(focus.position));
            painter.circle_filled(at, 6.5, theme::MARK_EDGE);
            painter.circle_filled(at, 5.0, theme::CHOSEN);
        }
        let at = lens.screen(axes.flat(frame.foci[first].position)) + vec2(12.0, 12.0);
        let speed = format!("{:.1} m/s", group.length * cycle.played(group));
        marks::chip(painter, at, Align2::LEFT_TOP, &speed, 12.0, theme::MARK);
        end = first;
    }
}
