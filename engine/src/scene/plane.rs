//! The rectangle on which a field is evaluated.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// The rectangle on which the field is evaluated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// m
    pub centre: DVec3,
    /// Towards the right of the picture; any length but zero.
    pub x_axis: DVec3,
    /// Upwards in the picture; made orthogonal to `x_axis` by [`Plane::axes`].
    pub y_axis: DVec3,
    /// m
    pub size: DVec2,
    /// Tolerated error relative to the map's peak; 0 for direct evaluation.
    pub tolerance: f64,
}

impl Default for Plane {
    fn default() -> Self {
        Self {
            centre: DVec3::new(0.0, 0.0, 0.1),
            x_axis: DVec3::X,
            y_axis: DVec3::Y,
            size: DVec2::new(0.2, 0.2),
            tolerance: 1e-3,
        }
    }
}

impl Plane {
    /// The unit vectors of the plane, or `None` if the given axes are zero or parallel.
    pub fn axes(&self) -> Option<(DVec3, DVec3)> {
        const PARALLEL: f64 = 1e-9;
        let x = self.x_axis.try_normalize()?;
        let y = self.y_axis.try_normalize()?;
        let y = y - x * x.dot(y);
        (y.length() > PARALLEL).then(|| (x, y.normalize_or_zero()))
    }
}
