//! Limits of motions: steps without targets, paths without length, more frames than memory holds.

use glam::DVec3;

use crate::scene::check::RATES;
use crate::scene::motion::cycle::Group;
use crate::scene::motion::{Motion, MotionPath, Tempo};
use crate::scene::range::{Key, KeyError};
use crate::scene::space::Front;
use crate::scene::{content::Scene, focus::Focus};

/// Limit of the memory of drives and foci of all frames, in bytes.
const MOST_BYTES: u64 = 1 << 30;
/// Overhead of a frame in bytes.
const LISTS: usize = 1024;
/// Allocator overhead, as a divisor.
const SLACK: u64 = 6;
/// Fewest frames per repetition, if a cycle has several.
const FEWEST: u64 = 3;

/// The number of steps; one without steps.
pub fn steps(scene: &Scene) -> u32 {
    if scene.motion.path != MotionPath::Steps {
        return 1;
    }
    let shown = scene.targets.iter().filter(|target| target.visible);
    shown.filter_map(|target| target.step).max().map_or(1, |last| last.saturating_add(1))
}

/// Every step has a target and a frame, and every target's step is shown.
pub fn check_steps(scene: &Scene) -> Result<(), KeyError> {
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
    // A gap is found within as many steps as there are targets, for any last step.
    if let Some(missing) = (0..steps(scene)).find(|&step| !has_step(step)) {
        return refuse(
            None,
            "path",
            format!(
                "no target has `step = {missing}`: the steps of visible targets must be consecutive from 0"
            ),
        );
    }
    if steps(scene) > scene.motion.frames {
        return refuse(None, "frames", format!("{} steps need a frame each", steps(scene)));
    }
    Ok(())
}

/// Several drives in turn are for scenes at rest only.
pub fn check_turns(scene: &Scene, moves: bool) -> Result<(), KeyError> {
    if !scene.solver.frames.are_several() || !moves || scene.drive.is_named() {
        return Ok(());
    }
    let message = "several drives take turns only where nothing moves: every frame of a motion is one drive";
    Err(KeyError::new([Key::from("solver"), Key::from("frames")], message))
}

/// Checks length and speed of a group.
pub fn check_group(group: &Group<'_>, runs: bool, frames: u64) -> Result<(), KeyError> {
    let Group { target, motion, length, rounds } = *group;
    if runs && length == 0.0 {
        let message = match target {
            Some(_) => "this target has no outline to run along: it is a point",
            None => {
                "no outline to run along: points, hidden targets and targets with their own motion have none"
            }
        };
        return refuse(target, "path", message);
    }
    if motion.lacks_routes() {
        return Ok(());
    }
    if motion.path == MotionPath::File {
        check_file(target, motion, length)?;
    }
    if let Tempo::Speed(speed) = motion.tempo {
        match motion.tempo.rate(length) {
            None => return refuse(target, "speed", "the path has no length: give `rate`"),
            Some(rate) if !RATES.contains(&rate) => {
                let message = format!(
                    "a path of {length} m at {speed} m/s makes {rate} cycles per second: must be {} to {}",
                    RATES.start(),
                    RATES.end()
                );
                return refuse(target, "speed", message);
            }
            Some(_) => {}
        }
    }
    if rounds > 1 && rounds.saturating_mul(FEWEST) > frames {
        let tempo = match motion.tempo {
            Tempo::Rate(_) | Tempo::Own => "rate",
            Tempo::Speed(_) => "speed",
        };
        let message = format!(
            "{rounds} rounds in one cycle of {frames} frames leave fewer than {FEWEST} frames each: use more frames per cycle, \
             or a lower rate"
        );
        return refuse(target, tempo, message);
    }
    Ok(())
}

/// A file's routes belong to targets that exist and follow it, and its own tempo is within the limits.
fn check_file(target: Option<usize>, motion: &Motion, length: f64) -> Result<(), KeyError> {
    if let (Tempo::Own, Some(rate)) = (motion.tempo, motion.rate(length))
        && !RATES.contains(&rate)
    {
        let (least, most) = (RATES.start(), RATES.end());
        let message = format!("its times make {rate} cycles per second: must be {least} to {most}");
        return refuse(target, "file", message);
    }
    if let Some(own) = target
        && !motion.routes.are_shared()
        && !motion.routes.targets().any(|target| target == own)
    {
        let message = format!("it has no path of target {}, whose motion names it", own + 1);
        return refuse(target, "file", message);
    }
    Ok(())
}

/// Every route of the scene's file leads a target.
pub fn check_routes(scene: &Scene) -> Result<(), KeyError> {
    if scene.motion.path != MotionPath::File {
        return Ok(());
    }
    let follows = |target: usize| scene.targets.get(target).is_some_and(|target| target.motion.is_none());
    match scene.motion.routes.targets().find(|target| !follows(*target)) {
        None => Ok(()),
        Some(target) => {
            let (number, count) = (target + 1, scene.targets.len());
            let message = match scene.targets.get(target) {
                None => format!("it has a path of target {number}, and the scene has {count}"),
                Some(_) => format!("it has a path of target {number}, which has a motion of its own"),
            };
            refuse(None, "file", message)
        }
    }
}

/// Drives and foci of all frames fit into [`MOST_BYTES`].
pub fn check_memory(scene: &Scene, frames: u64, foci: usize) -> Result<(), String> {
    const FLOAT: usize = size_of::<f64>();
    let elements = scene.elements();
    // Phase, amplitude and complex excitation of an element; each focus as requested and as found, with pressure and
    // weight; and the overhead of all lists.
    let of_focus = 2 * size_of::<Focus>() + 4 * FLOAT;
    let bytes = (elements * 4 * FLOAT + foci * of_focus + LISTS) as u64;
    // Allocator overhead.
    let bytes = bytes + bytes / SLACK;
    if frames * bytes <= MOST_BYTES {
        return Ok(());
    }
    Err(format!(
        "{frames} frames of {elements} elements and {foci} {} need {:.1} GiB, and 1 GiB is the most: take up to {}",
        if foci == 1 { "focus" } else { "foci" },
        (frames * bytes) as f64 / MOST_BYTES as f64,
        MOST_BYTES / bytes
    ))
}

/// Text for a focus behind the array.
pub fn behind(place: DVec3, front: &Front) -> String {
    let [x, y, z] = place.to_array();
    format!("({x:.4}, {y:.4}, {z:.4}), {}", front.behind())
}

/// A key of the scene's motion, or of a target's own.
pub fn key(target: Option<usize>, key: &'static str) -> Vec<Key> {
    let own = target.map(|index| [Key::from("target"), Key::from(index)]);
    own.into_iter().flatten().chain([Key::from("motion"), Key::from(key)]).collect()
}

/// An error at this key.
pub fn refuse<T>(
    target: Option<usize>,
    name: &'static str,
    message: impl Into<String>,
) -> Result<T, KeyError> {
    Err(KeyError::new(key(target, name), message))
}
