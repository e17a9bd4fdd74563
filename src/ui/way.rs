//! Editing of motion paths on the canvas: dragging handles, adding and removing vertices and keyframes.

use std::f64::consts::{FRAC_PI_4, TAU};

use egui::Pos2;
use glam::{DVec2, DVec3};

use crate::scene::motion::{self, Cycle, Group, Pose};
use crate::scene::{Keyframe, Motion, MotionPath, Scene, Target, outline};
use crate::ui::gesture::{Pull, Vertex};
use crate::ui::view::{Axes, Lens};
use crate::ui::{editor::Editor, layout::Panel};

/// m: the sizes that a path can be pulled to.
const SIZES: std::ops::RangeInclusive<f64> = 1e-3..=1.0;

/// Pick distance in points.
const REACH: f32 = 9.0;

/// Segments of a drawn path.
const PIECES: u32 = 96;

/// Snap distance to eighths of a turn, rad.
const LEVEL: f64 = 0.035;

/// A target's own motion, or the scene's.
pub fn motion_of(scene: &Scene, target: Option<usize>) -> Option<&Motion> {
    match target {
        None => Some(&scene.motion),
        Some(index) => scene.targets.get(index)?.motion.as_ref(),
    }
}

/// The same to be edited.
pub fn motion_mut(scene: &mut Scene, target: Option<usize>) -> Option<&mut Motion> {
    match target {
        None => Some(&mut scene.motion),
        Some(index) => scene.targets.get_mut(index)?.motion.as_mut(),
    }
}

/// The motion with handles, and the origin of its offsets (m): that of the single selected target, or the scene's
/// while edited.
pub fn held(editor: &Editor) -> Option<(Option<usize>, DVec3)> {
    let scene = editor.scene();
    let chosen = editor.selection.first().copied().filter(|_| editor.selection.len() == 1);
    let chosen = chosen.and_then(|index| Some((index, scene.targets.get(index)?)));
    let centre = |target: &Target| outline::centre(&target.shape);
    let follows = |target: &&Target| target.visible && target.motion.is_none();
    match chosen {
        Some((index, target)) if target.motion.is_some() => Some((Some(index), centre(target))),
        _ if editor.panel != Panel::Motion => None,
        Some((_, target)) => Some((None, centre(target))),
        None => scene.targets.iter().find(follows).map(|target| (None, centre(target))),
    }
}

/// Position of a size handle before rotation, in units of the size.
pub fn arm(path: MotionPath) -> Option<DVec2> {
    match path {
        MotionPath::Line | MotionPath::Circle | MotionPath::FigureEight => Some(DVec2::X / 2.0),
        MotionPath::Square => Some(DVec2::ONE / 2.0),
        MotionPath::Triangle => Some(DVec2::Y / 3.0_f64.sqrt()),
        MotionPath::None
        | MotionPath::Points
        | MotionPath::Keyframes
        | MotionPath::File
        | MotionPath::Steps
        | MotionPath::Outline => None,
    }
}

/// The offsets (m) of a path's handles.
pub fn handles(motion: &Motion) -> Vec<DVec3> {
    let turn = DVec2::from_angle(motion.angle);
    match motion.path {
        MotionPath::Points => motion.points.clone(),
        MotionPath::Keyframes => motion.keyframes.iter().map(|keyframe| keyframe.at).collect(),
        path => arm(path).map(|arm| (turn.rotate(arm) * motion.size).extend(0.0)).into_iter().collect(),
    }
}

/// The motion with a handle at another offset.
fn pulled(before: &Motion, handle: usize, to: DVec3) -> Motion {
    let mut motion = before.clone();
    match motion.path {
        MotionPath::Points => motion.points.get_mut(handle).into_iter().for_each(|point| *point = to),
        MotionPath::Keyframes => {
            motion.keyframes.get_mut(handle).into_iter().for_each(|keyframe| keyframe.at = to);
        }
        path => {
            let Some(arm) = arm(path) else { return motion };
            let flat = to.truncate();
            motion.size = (flat.length() / arm.length()).clamp(*SIZES.start(), *SIZES.end());
            // A turned circle looks as it did.
            if path != MotionPath::Circle && flat.length() > 0.0 {
                motion.angle = level((flat.to_angle() - arm.to_angle()).rem_euclid(TAU));
            }
        }
    }
    motion
}

/// An angle, snapped to nearby eighths of a turn; from -π to π.
fn level(angle: f64) -> f64 {
    let near = (angle / FRAC_PI_4).round() * FRAC_PI_4;
    let angle = if (angle - near).abs() < LEVEL { near } else { angle };
    if angle > TAU / 2.0 + 1e-9 { angle - TAU } else { angle }
}

/// Grabs a path under the pointer.
pub fn take(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2) -> Option<Pull> {
    editor.vertex = None;
    if !editor.view.marks {
        return None;
    }
    let (target, centre) = held(editor)?;
    let screen = |offset: DVec3| lens.screen(axes.flat(centre + offset));
    // At the target itself, its own handles take precedence while it is edited.
    let is_free =
        |offset: DVec3| editor.panel == Panel::Motion || screen(offset).distance(screen(DVec3::ZERO)) > REACH;
    let motion = motion_of(editor.scene(), target)?;
    let near = |offset: &DVec3| screen(*offset).distance(at);
    let offsets = handles(motion);
    let nearest = (0..offsets.len()).min_by(|&a, &b| near(&offsets[a]).total_cmp(&near(&offsets[b])));
    let handle = nearest.filter(|&handle| near(&offsets[handle]) <= REACH && is_free(offsets[handle]));
    let playhead = marker(editor, target).filter(|offset| near(offset) <= REACH && is_free(*offset));
    let on_curve =
        || motion.path == MotionPath::Points && distance(&way(motion, centre, axes, lens), at) <= REACH;
    let (is_keyed, path) = (handle.is_none() && playhead.is_some(), motion.path);
    if handle.is_none() && !is_keyed && !on_curve() {
        return None;
    }
    // A drag at the playhead creates a keyframe there.
    let handle =
        if is_keyed && path == MotionPath::Keyframes { add_keyframe(editor, target) } else { handle };
    editor.vertex = handle.filter(|_| arm(path).is_none()).map(|index| Vertex { target, index });
    let before = motion_of(editor.scene(), target)?.clone();
    Some(Pull { target, centre, handle, from: lens.flat(at), before })
}

/// Drags a handle to a point (m) in the plane.
pub fn pull(editor: &mut Editor, axes: &Axes, lens: &Lens, uv: DVec2, pull: &Pull) {
    let Some(handle) = pull.handle else { return };
    let Some(&from) = handles(&pull.before).get(handle) else { return };
    // Small movements during a click pull nothing.
    let moved = uv.distance(pull.from) >= 2.0 * lens.window.scale;
    let depth = axes.x.cross(axes.y) * axes.height(pull.centre + from);
    let to = axes.world(uv) + depth - pull.centre;
    if let Some(motion) = motion_mut(&mut editor.document.scene, pull.target) {
        *motion = if moved { pulled(&pull.before, handle, to) } else { pull.before.clone() };
    }
}

/// Adds a vertex at a double click on a path through points.
pub fn add_vertex(editor: &mut Editor, axes: &Axes, lens: &Lens, at: Pos2) -> bool {
    let Some((target, centre)) = held(editor).filter(|_| editor.view.marks) else { return false };
    let Some(motion) = motion_mut(&mut editor.document.scene, target) else { return false };
    if motion.path != MotionPath::Points {
        return false;
    }
    let screen = |offset: DVec3| lens.screen(axes.flat(centre + offset));
    let count = motion.points.len();
    let way = |i: usize| [motion.points[i], motion.points[(i + 1) % count]];
    let near = |&i: &usize| distance(&way(i).map(screen), at);
    let Some(segment) = (0..count).min_by(|a, b| near(a).total_cmp(&near(b))) else { return false };
    if near(&segment) > REACH {
        return false;
    }
    let [from, to] = way(segment);
    let middle = (from + to) / 2.0;
    let depth = axes.x.cross(axes.y) * axes.height(centre + middle);
    motion.points.insert(segment + 1, axes.world(lens.flat(at)) + depth - centre);
    editor.vertex = Some(Vertex { target, index: segment + 1 });
    true
}

/// Whether [`delete`] has something to delete.
pub fn can_delete(editor: &Editor) -> bool {
    let Some(Vertex { target, index }) = editor.vertex else { return false };
    if editor.panel != Panel::Motion && held(editor).is_none_or(|(held, _)| held != target) {
        return false;
    }
    let motion = motion_of(editor.scene(), target);
    let count = motion.map_or(0, |motion| match motion.path {
        MotionPath::Points => motion.points.len(),
        MotionPath::Keyframes => motion.keyframes.len(),
        MotionPath::None
        | MotionPath::Line
        | MotionPath::Circle
        | MotionPath::Square
        | MotionPath::Triangle
        | MotionPath::FigureEight
        | MotionPath::File
        | MotionPath::Steps
        | MotionPath::Outline => 0,
    });
    count > 1 && index < count
}

/// Deletes the last grabbed vertex or keyframe, unless it is the only one.
pub fn delete(editor: &mut Editor) -> bool {
    let can_delete = can_delete(editor);
    let Some(Vertex { target, index }) = editor.vertex.take().filter(|_| can_delete) else { return false };
    let Some(motion) = motion_mut(&mut editor.document.scene, target) else { return false };
    if motion.path == MotionPath::Points {
        motion.points.remove(index);
    } else {
        motion.keyframes.remove(index);
    }
    true
}

/// The completed fraction of a motion's repetition in the displayed frame, or at rest.
pub fn part(editor: &Editor, target: Option<usize>) -> Option<f64> {
    let cycle = motion::cycle(editor.scene())?;
    let group = cycle.groups.iter().find(|group| group.target == target)?;
    Some(part_of(&cycle, group, editor.playback.moment.frame().unwrap_or(0)))
}

/// The part of its repetition that a group has behind it in a frame.
pub fn part_of(cycle: &Cycle<'_>, group: &Group<'_>, frame: usize) -> f64 {
    let frames = u64::from(cycle.frames).max(1);
    (frame as u64).wrapping_mul(group.rounds).rem_euclid(frames) as f64 / frames as f64
}

/// Adds a keyframe at the playhead with current values. Returns its index.
pub fn add_keyframe(editor: &mut Editor, target: Option<usize>) -> Option<usize> {
    let time = part(editor, target)?;
    let motion = motion_mut(&mut editor.document.scene, target)?;
    if let Some(index) = motion.keyframes.iter().position(|keyframe| keyframe.time == time) {
        return Some(index);
    }
    let before = motion.keyframes.iter().rev().find(|keyframe| keyframe.time < time);
    let easing = before.or(motion.keyframes.last()).map(|keyframe| keyframe.easing).unwrap_or_default();
    let Pose { at, pressure, angle, phase } = motion.pose(time);
    let keyframe = Keyframe { pressure, angle, phase, easing, ..Keyframe::new(time, at) };
    let index = motion::insert(&mut motion.keyframes, keyframe);
    editor.vertex = Some(Vertex { target, index });
    Some(index)
}

/// The offset (m) at the playhead of a motion with keyframes, while a frame is shown.
pub fn marker(editor: &Editor, target: Option<usize>) -> Option<DVec3> {
    editor.playback.moment.frame()?;
    let motion = motion_of(editor.scene(), target)?;
    let is_keyed = motion.path == MotionPath::Keyframes;
    is_keyed.then(|| part(editor, target).map(|part| motion.offset(part)))?
}

/// A repetition of a file's path on the screen, in pieces between jumps.
pub fn route(scene: &Scene, target: usize, axes: &Axes, lens: &Lens) -> Vec<Vec<Pos2>> {
    let Some(own) = scene.targets.get(target) else { return Vec::new() };
    let (motion, centre) = (own.motion.as_ref().unwrap_or(&scene.motion), own.shape.centre());
    let screen = |at: DVec3| lens.screen(axes.flat(centre + at));
    let ways = motion::ways(scene, target, motion.frame_count().max(PIECES) as usize);
    ways.into_iter().map(|way| way.into_iter().map(screen).collect()).collect()
}

/// A repetition on the screen.
pub fn way(motion: &Motion, centre: DVec3, axes: &Axes, lens: &Lens) -> Vec<Pos2> {
    let at = |i: u32| centre + motion.offset(f64::from(i % PIECES) / f64::from(PIECES));
    (0..=PIECES).map(|i| lens.screen(axes.flat(at(i)))).collect()
}

/// Points of the screen from a polyline.
fn distance(line: &[Pos2], at: Pos2) -> f32 {
    let to_piece = |pair: &[Pos2]| {
        let along = pair[1] - pair[0];
        let part = ((at - pair[0]).dot(along) / along.length_sq().max(1e-12)).clamp(0.0, 1.0);
        at.distance(pair[0] + along * part)
    };
    line.windows(2).map(to_piece).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATHS: [MotionPath; 7] = [
        MotionPath::Line,
        MotionPath::Circle,
        MotionPath::Square,
        MotionPath::Triangle,
        MotionPath::FigureEight,
        MotionPath::Points,
        MotionPath::Keyframes,
    ];

    fn motion(path: MotionPath) -> Motion {
        let points = vec![DVec3::ZERO, DVec3::new(0.03, 0.0, 0.01), DVec3::new(0.0, 0.02, -0.01)];
        let keyframes = (0..3).zip(&points).map(|(i, &at)| Keyframe::new(f64::from(i) / 3.0, at)).collect();
        Motion { path, size: 0.04, points, keyframes, ..Motion::default() }
    }

    #[test]
    fn handles_are_on_the_path_and_go_where_they_are_pulled() {
        for path in PATHS {
            let motion = motion(path);
            for (index, at) in handles(&motion).into_iter().enumerate() {
                let on_path = (0..4800).map(|i| motion.offset(f64::from(i) / 4800.0).distance(at));
                let off = on_path.fold(f64::INFINITY, f64::min);
                assert!(off < 2e-5, "{path:?}: {off}");
                assert_eq!(pulled(&motion, index, at), motion, "{path:?}");
                let to = DVec3::new(0.011, -0.023, at.z);
                let there = handles(&pulled(&motion, index, to))[index];
                let off = match path {
                    MotionPath::Circle => (there.length() - to.length()).abs(),
                    _ => there.distance(to),
                };
                assert!(off < 1e-12, "{path:?}: {there}");
            }
        }
    }

    #[test]
    fn a_path_that_is_nearly_level_is_level() {
        let line = motion(MotionPath::Line);
        let turned = pulled(&line, 0, DVec3::new(0.02, 0.0003, 0.0));
        assert_eq!(turned.angle, 0.0);
        let turned = pulled(&line, 0, DVec3::new(0.0201, -0.02, 0.0));
        assert!((turned.angle + FRAC_PI_4).abs() < 1e-12);
        assert_eq!(pulled(&line, 0, DVec3::ZERO).size, *SIZES.start());
    }
}
