//! Targets as they are turned in a frame, for solvers that look at more than their focal points.

use crate::scene::content::Scene;
use crate::scene::motion::frames::Score;
use crate::scene::motion::mover::governing;
use crate::scene::motion::pose::Pose;
use crate::scene::range::KeyError;

/// The scene in every frame of motions that turn targets.
pub(crate) struct Posed<'a> {
    scene: &'a Scene,
    score: Score<'a>,
}

impl<'a> Posed<'a> {
    /// `None` if nothing turns.
    ///
    /// # Errors
    /// The errors of [`crate::scene::motion::check`].
    pub fn of(scene: &'a Scene) -> Result<Option<Self>, KeyError> {
        let mut shown = scene.targets.iter().filter(|target| target.visible);
        if !shown.any(|target| governing(scene, target).turns()) {
            return Ok(None);
        }
        Ok(Some(Self { scene, score: Score::new(scene)? }))
    }

    /// The poses of all targets in a frame.
    pub fn poses(&self, frame: usize) -> Vec<Pose> {
        self.score.poses(frame as u64)
    }

    /// The scene with its targets where and as they are in a frame.
    pub fn scene(&self, frame: usize) -> Scene {
        let mut scene = self.scene.clone();
        for (target, pose) in scene.targets.iter_mut().zip(self.poses(frame)) {
            target.shape.translate(pose.at);
            target.angle += pose.angle;
            target.phase = pose.phase;
        }
        scene
    }
}
