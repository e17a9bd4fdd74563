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

    #[test]
    fn starts_do_not_depend_on_where_the_drawing_is() {
        let form = |index: u32| DVec3::new(f64::from(index % 5), 0.7 * f64::from(index / 5), 100.0);
        for shift in [DVec3::new(30.0, 0.0, 0.0), DVec3::new(-3.0, 50.0, 7.0)] {
            for number in 0..Start::VARIANTS.len() {
                let phases = |shift: DVec3| {
                    let samples: Vec<_> = (0..18).map(|index| form(index) + shift).collect();
                    Start::phases(number, &samples, &Plane::default())
                };
                for (here, there) in phases(DVec3::ZERO).into_iter().zip(phases(shift)) {
                    assert!((0.5 * (here - there)).sin().abs() < 1e-9, "{number}: {here}, {there}");
                }
            }
        }
    }

    #[test]
    fn smooth_starts_fall_around_the_middle_rise_along_y_or_rise_outwards() {
        const COUNT: usize = 16;
        let plane = Plane { x_axis: DVec3::Y, y_axis: -DVec3::X, ..Plane::default() };
        let place = |index: usize| {
            let (sin, cos) = (TAU * (index as f64 + 0.5) / COUNT as f64).sin_cos();
            // Two rings.
            DVec2::new(cos, sin) * if index < COUNT { 1.0 } else { 2.0 }
        };
        let in_space = |place: DVec2| DVec3::new(-place.y, place.x, 0.1);
        let samples: Vec<_> = (0..2 * COUNT).map(|index| in_space(place(index))).collect();
        for (number, start) in Start::VARIANTS.iter().enumerate() {
            let phases = Start::phases(number, &samples, &plane);
            let is_like = |form: &dyn Fn(DVec2) -> f64| {
                let factor = phases[0] / form(place(0));
                let mut all = phases.iter().enumerate();
                factor > 0.0 && all.all(|(i, phase)| (phase - factor * form(place(i))).abs() < 1e-9)
            };
            let is_right = match start {
                Start::Equal => phases.iter().all(|phase| phase.abs() < 1e-9),
                Start::Vortex => phases[..COUNT].windows(2).all(|pair| {
                    let ahead = (pair[1] - pair[0] + TAU / COUNT as f64) / 2.0;
                    ahead.sin().abs() < 1e-9
                }),
                Start::Tilted => is_like(&|place| place.y),
                Start::Curved => is_like(&|place| place.length_squared()),
                Start::Scattered => true,
            };
            assert!(is_right, "{start:?}: {phases:?}");
        }
    }
}
