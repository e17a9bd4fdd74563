//! Focal points, and samples of strokes and areas.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A focal point, or a sample of a stroke or an area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Focus {
    /// m; of a direction the point at 1 m from the origin, a unit vector.
    pub position: DVec3,
    /// Target pressure: relative to the other foci, or Pa (peak), depending on [`crate::scene::Solver::pressures`].
    pub target: f64,
    /// The origin of the focus.
    pub part: Part,
}

/// The origin of a focus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Part {
    /// A focal point of its own.
    Point,
    /// A sample of a continuous stroke.
    Stroke,
    /// A sample of an area: of the scene's target with this number.
    Area(usize),
    /// A lobe of a trap: of the scene's target with this number.
    Trap(usize),
    /// A plane wave: a focal point at infinity, with the pressure at 1 m without absorption.
    Direction,
}

impl Focus {
    /// A separate focal point; position in m.
    pub fn new(position: DVec3, target: f64) -> Self {
        Self { position, target, part: Part::Point }
    }

    /// Whether it is a separate focal point rather than a sample of a stroke or an area.
    pub fn is_separate(&self) -> bool {
        match self.part {
            Part::Point | Part::Trap(_) | Part::Direction => true,
            Part::Stroke | Part::Area(_) => false,
        }
    }

    /// Whether it is a plane wave, which has no place.
    #[doc(hidden)]
    pub fn is_direction(&self) -> bool {
        self.part == Part::Direction
    }

    /// Whether it is a separate focal point with a place of its own.
    #[doc(hidden)]
    pub fn is_placed(&self) -> bool {
        self.is_separate() && !self.is_direction()
    }

    /// Whether it is a sample of an area.
    pub fn is_of_area(&self) -> bool {
        matches!(self.part, Part::Area(_))
    }
}
