//! Starting phases of the strokes: fields of several kinds, each smooth along them.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use strum::VariantArray;

use crate::scene::Plane;
use crate::solver::starts::scatter;

/// Phases of the pressure along the strokes, in the order of trials.
#[derive(Clone, Copy, Debug, VariantArray)]
pub enum Start {
    /// The same everywhere: hardly any other ends better.
    Equal,
    /// Decreasing once around the centre.
    Vortex,
    /// Rising along y.
    Tilted,
    /// Phases of a focus behind the plane.
    Curved,
    Scattered,
}

impl Start {
    /// rad, of every sample, in the plane's axes; beyond the last start all are scattered, each in another way.
    pub fn phases(number: usize, samples: &[DVec3], plane: &Plane) -> Vec<f64> {
        /// Seed of the scattered phases.
        const SEED: usize = 17;
        let start = Self::VARIANTS.get(number).copied().unwrap_or(Self::Scattered);
        let seed = SEED + number;
        let count = samples.len() as f64;
        let (x, y) = plane.axes().unwrap_or((DVec3::X, DVec3::Y));
        let middle = samples.iter().sum::<DVec3>() / count;
        let flat = |sample: &DVec3| DVec2::new((sample - middle).dot(x), (sample - middle).dot(y));
        let mean_square = samples.iter().map(|sample| flat(sample).length_squared()).sum::<f64>() / count;
        let size = mean_square.sqrt().max(f64::MIN_POSITIVE);
        let phase = |(index, sample): (usize, &DVec3)| {
            let place = flat(sample) / size;
            match start {
                Self::Equal => 0.0,
                Self::Vortex => -place.y.atan2(place.x),
                Self::Tilted => PI * place.y,
                Self::Curved => 0.5 * PI * place.length_squared(),
                Self::Scattered => TAU * seed as f64 * scatter(index + seed),
            }
        };
        samples.iter().enumerate().map(phase).collect()
    }
}
