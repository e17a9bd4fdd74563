//! What the quality of a shape's drive is stated in.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Figures of a drive, independent of its scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Least over mean of |p|/target along the strokes and at the foci, 0 to 1.
    pub evenness: f64,
    /// Loudest over least of |p|/target there, dB.
    pub ripple_db: f64,
    /// |p| of the side lobe on the plane over the mean at the foci, see [`crate::field::side_lobe()`]; 0 without one.
    pub side_lobe: f64,
    /// m
    pub side_lobe_position: DVec3,
    /// Mean |p|/target relative to that of the strongest known drive: of `quiet` = 0, or this one. 0 to 1.
    pub strength: f64,
    /// For areas, or a depression.
    pub areas: Option<AreaFigures>,
}

/// Figures of areas, over them and the 3.7 wavelengths around them: of |p|², or of a liquid's depression if
/// prescribed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaFigures {
    /// Mean inside over mean around.
    pub contrast: f64,
    /// Σ (s I - T)² / Σ T² with I the actual and T the target value and s the best scale: 0 to 1.
    pub error: f64,
}
