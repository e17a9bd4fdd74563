//! Motion: the closed path along which all targets move together, or the steps in which they take turns.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::scene::check::{Key, KeyError};
use crate::scene::{Focus, Scene, outline};

/// Bytes that the drives and foci of all frames may take.
const MOST_BYTES: u64 = 1 << 30;
/// Pieces of a figure-eight, which has no closed form for its arc length; their chords are 1e-5 too short.
const PIECES: usize = 512;

/// How the targets change while time goes by. A round begins again where it ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Motion {
    pub path: MotionPath,
    /// m: length of a line, diameter of a circle, side of a square or triangle, width of a figure-eight.
    pub size: f64,
    /// Rounds per second.
    pub rate: f64,
    /// Frames per round.
    pub frames: u32,
    /// The offsets (m) that `path = "points"` visits.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<DVec3>,
}

impl Default for Motion {
    fn default() -> Self {
        Self { path: MotionPath::None, size: 0.03, rate: 5.0, frames: 64, points: Vec::new() }
    }
}

/// The paths lie parallel to the array and are run through at constant speed, counter-clockwise. All but `points` have
/// their mean at the targets' own places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionPath {
    None,
    /// Along x from the left end to the right and back.
    Line,
    /// From +x.
    Circle,
    /// From the corner at smallest x and y.
    Square,
    /// Equilateral, from the corner at largest y.
    Triangle,
    /// The offsets in `points`, one after the other and back to the first.
    Points,
    /// Gerono's: twice as wide as high, from the crossing to the upper right.
    FigureEight,
    /// Nothing moves: targets with `step = 0` are shown first, then those with `step = 1`, and so on.
    Steps,
}

impl MotionPath {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Line => "line",
            Self::Circle => "circle",
            Self::Square => "square",
            Self::Triangle => "triangle",
            Self::Points => "points",
            Self::FigureEight => "figure-eight",
            Self::Steps => "steps",
        }
    }
}

impl Motion {
    /// How far the targets are from their own places (m) after a part of a round, in [0, 1).
    pub fn offset(&self, part: f64) -> DVec3 {
        self.round().at(part)
    }

    /// m, of one round; 0 for steps.
    pub fn length(&self) -> f64 {
        self.round().length()
    }

    /// m/s
    pub fn speed(&self) -> f64 {
        self.length() * self.rate
    }

    pub fn frames_per_second(&self) -> f64 {
        f64::from(self.frames) * self.rate
    }

    fn round(&self) -> Round {
        let size = self.size;
        let flat = |vertices: &[DVec2]| Round::through(vertices.iter().map(|v| (*v * size).extend(0.0)));
        match self.path {
            MotionPath::None | MotionPath::Steps => Round::through([DVec3::ZERO]),
            MotionPath::Circle => Round::Circle { radius: size / 2.0 },
            MotionPath::Line => flat(&[(-0.5, 0.0), (0.5, 0.0)].map(DVec2::from)),
            MotionPath::Square => {
                flat(&[(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(DVec2::from))
            }
            MotionPath::Triangle => {
                let corner = |i: u32| DVec2::from_angle(TAU * (0.25 + f64::from(i) / 3.0)) / 3.0_f64.sqrt();
                flat(&[0, 1, 2].map(corner))
            }
            MotionPath::FigureEight => Round::through((0..PIECES).map(|i| {
                let (sin, cos) = (TAU * i as f64 / PIECES as f64).sin_cos();
                size / 2.0 * DVec3::new(sin, sin * cos, 0.0)
            })),
            MotionPath::Points => Round::through(self.points.iter().copied()),
        }
    }
}

/// A closed path that is run through at constant speed.
enum Round {
    Circle {
        radius: f64,
    },
    /// The first vertex is the last one, too; `distances` are m from the first to each.
    Polyline {
        vertices: Vec<DVec3>,
        distances: Vec<f64>,
    },
}

impl Round {
    fn through(vertices: impl IntoIterator<Item = DVec3>) -> Self {
        let mut vertices: Vec<_> = vertices.into_iter().collect();
        vertices.extend(vertices.first().copied());
        let mut distance = 0.0;
        let lengths = vertices.windows(2).map(|pair| pair[0].distance(pair[1]));
        let to_next = lengths.map(|length| {
            distance += length;
            distance
        });
        let distances = std::iter::once(0.0).chain(to_next).collect();
        Self::Polyline { vertices, distances }
    }

    fn length(&self) -> f64 {
        match self {
            Self::Circle { radius } => TAU * radius,
            Self::Polyline { distances, .. } => distances.last().copied().unwrap_or(0.0),
        }
    }

    fn at(&self, part: f64) -> DVec3 {
        match self {
            Self::Circle { radius } => (DVec2::from_angle(TAU * part) * *radius).extend(0.0),
            Self::Polyline { vertices, distances } => {
                let distance = part * self.length();
                let next = distances.partition_point(|&d| d <= distance);
                if next == 0 || next >= vertices.len() {
                    // Without vertices, without length, or rounded to the end.
                    return vertices.first().copied().unwrap_or(DVec3::ZERO);
                }
                let along = (distance - distances[next - 1]) / (distances[next] - distances[next - 1]);
                vertices[next - 1].lerp(vertices[next], along)
            }
        }
    }
}

/// Frames of one round: as many as the motion asks for, or the one that a scene without motion has.
pub fn count(scene: &Scene) -> usize {
    if scene.motion.path == MotionPath::None { 1 } else { scene.motion.frames as usize }
}

/// The step, counted from 0, that a frame shows: steps share the frames evenly.
pub fn step_of(scene: &Scene, frame: usize) -> u32 {
    (frame as u64 * u64::from(steps(scene)) / count(scene) as u64) as u32
}

fn steps(scene: &Scene) -> u32 {
    match scene.motion.path {
        MotionPath::Steps => scene
            .targets
            .iter()
            .filter(|target| target.visible)
            .filter_map(|target| target.step)
            .max()
            .map_or(1, |last| last.saturating_add(1)),
        _ => 1,
    }
}

/// The focal points of every frame of a round.
///
/// # Errors
/// Those of [`outline::foci`] and [`check`].
pub fn frames(scene: &Scene) -> Result<Vec<Vec<Focus>>, KeyError> {
    let steps = checked_steps(scene)?;
    let (round, count) = (scene.motion.round(), count(scene));
    let frame = |frame: usize| {
        let offset = round.at(frame as f64 / count as f64);
        let moved = |focus: &Focus| Focus { position: focus.position + offset, ..*focus };
        steps[step_of(scene, frame) as usize].iter().map(moved).collect()
    };
    Ok((0..count).map(frame).collect())
}

/// Checks what the targets and the motion are together.
///
/// # Errors
/// Focal points that cannot be, a step that no target has or a target whose step is never shown, frames that take more
/// than 1 GiB, or a focal point that moves behind the array.
pub fn check(scene: &Scene) -> Result<(), KeyError> {
    checked_steps(scene).map(drop)
}

/// The focal points of every step, before they move.
fn checked_steps(scene: &Scene) -> Result<Vec<Vec<Focus>>, KeyError> {
    check_steps(scene)?;
    let steps: Vec<_> =
        (0..steps(scene)).map(|step| outline::foci_of_step(scene, step)).collect::<Result<_, _>>()?;
    if scene.motion.path != MotionPath::None {
        check_memory(scene, steps.iter().map(Vec::len).max().unwrap_or(0))?;
        check_heights(scene, &steps)?;
    }
    Ok(steps)
}

fn check_steps(scene: &Scene) -> Result<(), KeyError> {
    let has_step = |step: u32| scene.targets.iter().any(|it| it.visible && it.step == Some(step));
    if scene.motion.path != MotionPath::Steps {
        return match scene.targets.iter().position(|target| target.step.is_some()) {
            None => Ok(()),
            Some(index) => Err(KeyError::new(
                [Key::from("target"), Key::from(index), Key::from("step")],
                "only `path = \"steps\"` in [motion] shows targets step by step",
            )),
        };
    }
    // A gap is found after as many steps as there are targets, however large the last one is.
    if let Some(missing) = (0..steps(scene)).find(|&step| !has_step(step)) {
        return refuse(
            "path",
            format!(
                "no target has `step = {missing}`: steps are counted from 0, and hidden targets have none"
            ),
        );
    }
    if steps(scene) > scene.motion.frames {
        return refuse("frames", format!("{} steps need a frame each", steps(scene)));
    }
    Ok(())
}

fn check_memory(scene: &Scene, foci: usize) -> Result<(), KeyError> {
    const FLOAT: usize = size_of::<f64>();
    let elements = scene.array.elements();
    // Phase and amplitude of an element, and the complex number that they are made from; position, target and complex
    // pressure of a focus.
    let bytes = (elements * 4 * FLOAT + foci * (size_of::<Focus>() + 2 * FLOAT)) as u64;
    let frames = u64::from(scene.motion.frames);
    if frames * bytes <= MOST_BYTES {
        return Ok(());
    }
    refuse(
        "frames",
        format!(
            "{frames} frames of {elements} elements and {foci} {} need {:.1} GiB, and 1 GiB is the most: take up to {}",
            if foci == 1 { "focus" } else { "foci" },
            (frames * bytes) as f64 / MOST_BYTES as f64,
            MOST_BYTES / bytes
        ),
    )
}

fn check_heights(scene: &Scene, steps: &[Vec<Focus>]) -> Result<(), KeyError> {
    let Some(lowest) = steps
        .iter()
        .flatten()
        .min_by(|a, b| a.position.z.total_cmp(&b.position.z))
        .map(|focus| focus.position)
    else {
        return Ok(());
    };
    let (round, count) = (scene.motion.round(), count(scene));
    let behind = |&frame: &usize| lowest.z + round.at(frame as f64 / count as f64).z <= 0.0;
    let Some(frame) = (0..count).find(behind) else { return Ok(()) };
    let [x, y, z] = (lowest + round.at(frame as f64 / count as f64)).to_array();
    refuse(
        "points",
        format!(
            "in frame {} of {count} the motion takes a focal point to ({x:.4}, {y:.4}, {z:.4}), on or behind the array, \
             which stands in z = 0 and radiates towards +z",
            frame + 1
        ),
    )
}

fn refuse<T>(key: &'static str, message: impl Into<String>) -> Result<T, KeyError> {
    Err(KeyError::new([Key::from("motion"), Key::from(key)], message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Shape, Target};

    const MOVING: [MotionPath; 6] = [
        MotionPath::Line,
        MotionPath::Circle,
        MotionPath::Square,
        MotionPath::Triangle,
        MotionPath::FigureEight,
        MotionPath::Points,
    ];

    fn motion(path: MotionPath) -> Motion {
        let points = vec![DVec3::ZERO, DVec3::new(0.03, 0.0, 0.01), DVec3::new(0.0, 0.02, -0.01)];
        Motion { path, size: 0.04, points, ..Motion::default() }
    }

    fn scene(motion: Motion, at: &[DVec3]) -> Scene {
        let target = |&at: &DVec3| Target::new(Shape::Point { at });
        Scene { motion, targets: at.iter().map(target).collect(), ..Scene::default() }
    }

    #[test]
    fn every_path_is_closed_and_run_through_at_constant_speed() {
        const STEPS: u32 = 4000;
        for path in MOVING {
            let motion = motion(path);
            let at = |i: u32| motion.offset(f64::from(i % STEPS) / f64::from(STEPS));
            let step = motion.length() / f64::from(STEPS);
            let distances: Vec<_> = (0..STEPS).map(|i| at(i).distance(at(i + 1))).collect();
            // Corners are cut short, and there are few.
            let uneven = distances.iter().filter(|&&d| (d / step - 1.0).abs() > 0.01).count();
            assert!(uneven <= 4, "{path:?}: {uneven} uneven steps");
            assert!(distances.iter().all(|&d| d < 1.01 * step), "{path:?} jumps");
            let mean = (0..STEPS).map(at).sum::<DVec3>() / f64::from(STEPS);
            assert!(path == MotionPath::Points || mean.length() < 1e-6, "{path:?}: {mean}");
        }
    }

    #[test]
    fn lengths_and_extents_are_those_of_the_figures() {
        let size = 0.04;
        for (path, length, width, height) in [
            (MotionPath::Line, 2.0 * size, size, 0.0),
            (MotionPath::Circle, TAU / 2.0 * size, size, size),
            (MotionPath::Square, 4.0 * size, size, size),
            (MotionPath::Triangle, 3.0 * size, size, 0.75_f64.sqrt() * size),
            // ∫ √(cos² t + cos² 2t) dt = 6.09722 for a figure that is two wide.
            (MotionPath::FigureEight, 6.097_22 / 2.0 * size, size, size / 2.0),
            (MotionPath::None, 0.0, 0.0, 0.0),
            (MotionPath::Steps, 0.0, 0.0, 0.0),
        ] {
            let motion = motion(path);
            assert!((motion.length() - length).abs() < 1e-4 * size, "{path:?}: {}", motion.length());
            let offsets: Vec<_> = (0..2400).map(|i| motion.offset(f64::from(i) / 2400.0)).collect();
            let extent = |of: fn(&DVec3) -> f64| {
                let values = offsets.iter().map(of);
                values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
            };
            assert!((extent(|o| o.x) - width).abs() < 2e-3 * size, "{path:?}");
            assert!((extent(|o| o.y) - height).abs() < 2e-3 * size, "{path:?}");
        }
        assert!((motion(MotionPath::Square).speed() - 0.8).abs() < 1e-12, "4 x 40 mm, 5 times a second");
    }

    #[test]
    fn paths_begin_where_they_say() {
        let (h, part) = (0.02, 1e-3);
        for (path, start, towards) in [
            (MotionPath::Line, DVec3::new(-h, 0.0, 0.0), DVec3::X),
            (MotionPath::Circle, DVec3::new(h, 0.0, 0.0), DVec3::Y),
            (MotionPath::Square, DVec3::new(-h, -h, 0.0), DVec3::X),
            (
                MotionPath::Triangle,
                DVec3::new(0.0, 0.04 / 3.0_f64.sqrt(), 0.0),
                DVec3::new(-0.5, -0.866, 0.0),
            ),
            (MotionPath::FigureEight, DVec3::ZERO, (DVec3::X + DVec3::Y) * std::f64::consts::FRAC_1_SQRT_2),
        ] {
            let motion = motion(path);
            assert!(motion.offset(0.0).distance(start) < 1e-12, "{path:?}");
            let direction = (motion.offset(part) - start).normalize_or_zero();
            assert!(direction.dot(towards) > 0.999, "{path:?}: {direction}");
        }
    }

    #[test]
    fn points_without_a_way_between_them_stand_still() {
        let at = DVec3::new(0.01, 0.0, 0.0);
        for points in [vec![at], vec![at, at]] {
            let motion = Motion { points, ..motion(MotionPath::Points) };
            assert_eq!((motion.offset(0.4), motion.length()), (at, 0.0));
        }
    }

    #[test]
    fn frames_move_every_focus_and_leave_a_still_scene_alone() {
        let at = [DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.02, 0.0, 0.12)];
        let moving = scene(Motion { frames: 8, ..motion(MotionPath::Circle) }, &at);
        let moved = frames(&moving).unwrap();
        assert_eq!(moved.len(), 8);
        for (i, foci) in moved.iter().enumerate() {
            let offset = (DVec2::from_angle(TAU * i as f64 / 8.0) * 0.02).extend(0.0);
            for (focus, at) in foci.iter().zip(at) {
                assert!(focus.position.distance(at + offset) < 1e-12);
            }
        }
        assert_eq!(frames(&scene(Motion::default(), &at)).unwrap().len(), 1);
    }

    #[test]
    fn steps_take_turns_and_share_the_frames() {
        let at = [DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.02, 0.0, 0.1), DVec3::new(0.0, 0.02, 0.1)];
        let mut scene = scene(Motion { frames: 5, ..motion(MotionPath::Steps) }, &at);
        scene.targets[0].step = Some(1);
        scene.targets[1].step = Some(0);
        let frames = frames(&scene).unwrap();
        let shown: Vec<Vec<_>> =
            frames.iter().map(|foci| foci.iter().map(|focus| focus.position).collect()).collect();
        let (first, second) = (vec![at[1], at[2]], vec![at[0], at[2]]);
        assert_eq!(shown, [first.clone(), first.clone(), first.clone(), second.clone(), second]);
        let still: Vec<_> = outline::foci(&scene).unwrap().iter().map(|focus| focus.position).collect();
        assert_eq!(still, first, "a still view shows the first step");
    }

    #[test]
    fn what_does_not_go_together_is_refused() {
        let at = [DVec3::new(0.0, 0.0, 0.005), DVec3::new(0.02, 0.0, 0.1)];
        let stepped = |steps: [Option<u32>; 2], frames: u32| {
            let mut scene = scene(Motion { frames, ..motion(MotionPath::Steps) }, &at);
            (scene.targets[0].step, scene.targets[1].step) = (steps[0], steps[1]);
            scene
        };
        let mut stray = scene(motion(MotionPath::Circle), &at);
        stray.targets[1].step = Some(0);
        let circle = |frames| scene(Motion { frames, ..motion(MotionPath::Circle) }, &at);
        for (scene, key, part) in [
            (stray, "target[2].step", "path = \"steps\""),
            (stepped([None, None], 4), "motion.path", "`step = 0`"),
            (stepped([Some(0), Some(2)], 4), "motion.path", "`step = 1`"),
            (stepped([Some(0), Some(u32::MAX)], 4), "motion.path", "`step = 1`"),
            (stepped([Some(0), Some(1)], 1), "motion.frames", "2 steps"),
            (circle(1_000_000), "motion.frames", "1000000 frames of 256 elements and 2 foci need 7.7 GiB"),
            (circle(u32::MAX), "motion.frames", "take up to 129"),
            (scene(motion(MotionPath::Points), &at), "motion.points", "in frame 44 of 64"),
        ] {
            let error = check(&scene).unwrap_err();
            assert!(error.key() == key && error.message.contains(part), "{error}");
        }
        check(&circle(100_000)).unwrap();
    }
}
