//! The pose of a target at a moment of its motion, beside its place in the scene file.

use glam::{DQuat, DVec3};

use crate::scene::run::Vertex;

/// Displacement, loudness, turn and phase of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Offset, m.
    pub at: DVec3,
    /// Factor on the target pressure.
    pub pressure: f64,
    /// Turn about the target's normal, rad.
    pub angle: f64,
    /// Phase added to a trap's signature, rad.
    pub phase: f64,
}

/// A target that follows a motion: its index in the scene, and the place (m) that a file's route brings to its places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover {
    pub target: usize,
    pub from: DVec3,
}

impl Pose {
    pub(super) const AT_REST: Self = Self { at: DVec3::ZERO, pressure: 1.0, angle: 0.0, phase: 0.0 };

    /// Between two poses, `part` of the way to the other.
    pub(super) fn lerp(self, other: Self, part: f64) -> Self {
        let along = |from: f64, to: f64| from + (to - from) * part;
        Self {
            at: self.at.lerp(other.at, part),
            pressure: along(self.pressure, other.pressure),
            angle: along(self.angle, other.angle),
            phase: along(self.phase, other.phase),
        }
    }

    /// A place (m) of a target with this centre (m) and normal, moved along.
    pub(super) fn moved(&self, place: DVec3, centre: DVec3, normal: DVec3) -> DVec3 {
        if self.angle == 0.0 {
            return place + self.at;
        }
        let turn = DQuat::from_axis_angle(normal.try_normalize().unwrap_or(DVec3::Z), self.angle);
        centre + self.at + turn * (place - centre)
    }
}

impl From<Vertex> for Pose {
    fn from(Vertex { at, pressure }: Vertex) -> Self {
        Self { at, pressure, ..Self::AT_REST }
    }
}
