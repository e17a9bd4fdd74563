//! Targets and the motions that govern them.

use glam::DVec3;

use crate::scene::content::Scene;
use crate::scene::motion::Motion;
use crate::scene::motion::pose::{Mover, Pose};
use crate::scene::target::Target;

/// The motion of a target: its own, or the scene's.
pub(crate) fn governing<'a>(scene: &'a Scene, target: &'a Target) -> &'a Motion {
    target.motion.as_ref().unwrap_or(&scene.motion)
}

/// The pose of a target of a scene after a fraction of a repetition of its motion, in [0, 1).
#[doc(hidden)]
pub fn pose_of(scene: &Scene, target: usize, part: f64) -> Pose {
    let Some(own) = scene.targets.get(target) else { return Pose::AT_REST };
    governing(scene, own).round().at(part, mover(scene, target, own))
}

/// The offsets (m) of a target in a repetition of a file's path, in pieces between jumps of at most `most` places.
#[doc(hidden)]
pub fn ways(scene: &Scene, target: usize, most: usize) -> Vec<Vec<DVec3>> {
    let Some(own) = scene.targets.get(target) else { return Vec::new() };
    governing(scene, own).routes.ways(mover(scene, target, own), most)
}

/// A target of a scene, by its index, with the place that a file's route brings to its places: its centre, or that of
/// the first of all targets that share a single route, so that they keep their arrangement.
pub(super) fn mover(scene: &Scene, target: usize, own: &Target) -> Mover {
    let is_shared = own.motion.is_none() && scene.motion.routes.are_shared();
    let follows = |target: &&Target| is_shared && target.visible && target.motion.is_none();
    let first = scene.targets.iter().find(follows).unwrap_or(own);
    Mover { target, from: first.shape.centre() }
}
