//! The samples of a modulation waveform, loaded from a WAV file when a scene is opened.

use std::path::PathBuf;

use crate::scene::loaded::Loaded;

/// A repeated waveform, interpolated linearly, also from the last sample to the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Waveform {
    /// The file of origin.
    pub file: PathBuf,
    /// Samples per second.
    pub rate: f64,
    /// -1 to 1.
    pub values: Vec<f32>,
}

impl Waveform {
    /// s, of a repetition.
    pub fn period(&self) -> f64 {
        self.values.len() as f64 / self.rate
    }

    /// The value at a time (s).
    fn at(&self, time: f64) -> f64 {
        let count = self.values.len();
        let place = (time / self.period()).rem_euclid(1.0) * count as f64;
        let index = (place as usize).min(count.saturating_sub(1));
        let value = |index: usize| self.values.get(index % count).copied().map_or(0.0, f64::from);
        let (from, to) = (value(index), value(index + 1));
        from + (to - from) * (place - index as f64)
    }
}

/// A waveform, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wave(Loaded<Measured>);

#[derive(Debug, PartialEq)]
struct Measured {
    samples: Waveform,
    mean: f64,
    mean_square: f64,
}

impl Wave {
    /// # Panics
    /// No samples.
    pub fn new(samples: Waveform) -> Self {
        let count = samples.values.len();
        assert!(count > 0 && samples.rate > 0.0, "a waveform has samples and a rate");
        let next = samples.values.iter().cycle().skip(1);
        let pairs = samples.values.iter().zip(next).map(|(a, b)| (f64::from(*a), f64::from(*b)));
        // Along a straight line from a to b, x has the mean (a + b)/2 and x² has (a² + ab + b²)/3.
        let (sum, squares) = pairs.fold((0.0, 0.0), |(sum, squares), (a, b)| {
            (sum + 0.5 * (a + b), squares + (a * a + a * b + b * b) / 3.0)
        });
        let (mean, mean_square) = (sum / count as f64, squares / count as f64);
        Self(Loaded::new(Measured { samples, mean, mean_square }))
    }

    pub fn get(&self) -> Option<&Waveform> {
        self.0.get().map(|loaded| &loaded.samples)
    }

    /// The value at a time (s), -1 to 1; 1 before loading.
    pub fn at(&self, time: f64) -> f64 {
        self.get().map_or(1.0, |samples| samples.at(time))
    }

    /// The means of value and square.
    pub fn means(&self) -> [f64; 2] {
        self.0.get().map_or([1.0; 2], |loaded| [loaded.mean, loaded.mean_square])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_waveform_runs_straight_from_sample_to_sample_and_closes() {
        let samples = Waveform { file: PathBuf::new(), rate: 4.0, values: vec![0.0, 1.0, 0.0, -1.0] };
        let wave = Wave::new(samples);
        for (time, value) in
            [(0.0, 0.0), (0.125, 0.5), (0.25, 1.0), (0.875, -0.5), (1.125, 0.5), (-0.125, -0.5)]
        {
            assert!((wave.at(time) - value).abs() < 1e-12, "{time} s: {}", wave.at(time));
        }
        assert_eq!(wave.get().map(Waveform::period), Some(1.0));
        let [mean, mean_square] = wave.means();
        assert!(mean.abs() < 1e-12 && (mean_square - 1.0 / 3.0).abs() < 1e-12, "{mean} {mean_square}");
    }
}
