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
    /// As if focused behind the plane.
    Curved,
    Scattered,
}

impl Start {
    /// rad, of every sample, in the plane's axes; beyond the last start all are scattered, each in another way.
    pub fn phases(number: usize, samples: &[DVec3], plane: &Plane) -> Vec<f64> {
        /// Of the scattered phases.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_depend_on_the_drawings_form_alone() {
        let plane = Plane::default();
        let form = |index: usize| DVec3::new((index % 5) as f64, (index / 5) as f64 * 0.7, 100.0);
        let drawn = |size: f64| (0..20).map(|index| form(index) * size).collect::<Vec<_>>();
        for number in 0..Start::VARIANTS.len() {
            let [small, large] = [1e-3, 0.1].map(|size| Start::phases(number, &drawn(size), &plane));
            let is_same = small.iter().zip(&large).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(is_same && small.iter().all(|phase| phase.is_finite()), "{number}: {small:?}, {large:?}");
        }
    }

    #[test]
    fn smooth_starts_do_not_depend_on_the_number_of_samples() {
        // None lies in the middle, where a vortex has any phase, or beside it at half a turn.
        let form = |index: u32| DVec3::new(f64::from(index % 4), 0.7 * f64::from(index / 4), 100.0);
        let once: Vec<_> = (0..16).map(form).collect();
        let twice: Vec<_> = once.iter().flat_map(|&sample| [sample; 2]).collect();
        for number in 0..4 {
            let phases = |samples: &[DVec3]| Start::phases(number, samples, &Plane::default());
            let (few, many) = (phases(&once), phases(&twice));
            let is_same = many.iter().enumerate().all(|(index, phase)| (phase - few[index / 2]).abs() < 1e-9);
            assert!(is_same && many.len() == 32, "{number}: {few:?}, {many:?}");
        }
    }
}
