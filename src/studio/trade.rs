//! Strength against side lobe: what `quiet` costs and wins, with uniform and with free amplitudes.

use crate::scene::{Amplitudes, Scene};
use crate::solver::{self, SolveError};

/// The values of `quiet` along a curve.
pub const QUIET: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// A drive of the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub quiet: f64,
    /// Mean pressure over that of the strongest known drive.
    pub strength: f64,
    /// Over the mean along the drawing.
    pub side_lobe: f64,
    /// Of areas.
    pub error: Option<f64>,
}

/// The curve of a scene's drawing with these amplitudes.
///
/// # Errors
/// A scene that cannot be solved.
pub fn curve(scene: &Scene, amplitudes: Amplitudes) -> Result<Vec<Point>, SolveError> {
    let at = |quiet: f64| {
        let mut scene = scene.clone();
        (scene.solver.quiet, scene.solver.amplitudes) = (quiet, amplitudes);
        let figures = solver::solve(&scene)?.figures;
        Ok(figures.map(|figures| Point {
            quiet,
            strength: figures.strength,
            side_lobe: figures.side_lobe,
            error: figures.areas.map(|areas| areas.error),
        }))
    };
    QUIET.into_iter().filter_map(|quiet| at(quiet).transpose()).collect()
}
