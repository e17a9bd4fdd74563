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

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec3;

    use super::*;
    use crate::scene::motion::{self, Keyframe, MotionPath};
    use crate::scene::{outline, shape::Shape, target::Target, trap::Trap};

    #[test]
    fn foci_turn_as_their_targets_do() {
        let at = DVec3::new(0.01, -0.02, 0.12);
        let shapes = [
            Shape::Rectangle { at, width: 0.03, height: 0.01 },
            Shape::Text { text: "F4".to_owned(), at, height: 0.03 },
            Shape::Line { from: at, to: at + DVec3::new(0.03, 0.01, 0.01) },
            Shape::Trap { at, trap: Trap::Vortex, charge: 2 },
        ];
        let keyframe = |time: f64, at: DVec3, angle: f64| Keyframe { angle, ..Keyframe::new(time, at) };
        for shape in shapes {
            let normal = if shape.is_flat() { DVec3::new(0.3, -0.2, 1.0) } else { DVec3::Z };
            let mut scene = Scene { targets: vec![Target::new(shape)], ..Scene::default() };
            (scene.targets[0].normal, scene.targets[0].angle) = (normal, 0.4);
            (scene.motion.path, scene.motion.frames) = (MotionPath::Keyframes, 8);
            scene.motion.keyframes =
                vec![keyframe(0.0, DVec3::ZERO, 0.0), keyframe(0.5, DVec3::X * 0.02, TAU / 2.0)];
            let frames = motion::frames(&scene).unwrap();
            let posed = Posed::of(&scene).unwrap().unwrap();
            for (frame, foci) in frames.iter().enumerate() {
                let turned = posed.scene(frame);
                let wanted = outline::foci(&turned).unwrap();
                assert_eq!(foci.len(), wanted.len());
                let angle = 0.4 + TAU * frame as f64 / 8.0;
                assert!((turned.targets[0].angle - angle).abs() < 1e-12, "the second half goes on");
                for (own, wanted) in foci.iter().zip(&wanted) {
                    assert!(
                        own.position.distance(wanted.position) < 1e-12,
                        "frame {frame} of {:?}",
                        scene.targets[0]
                    );
                }
            }
        }
        assert!(Posed::of(&Scene::default()).unwrap().is_none());
    }
}
