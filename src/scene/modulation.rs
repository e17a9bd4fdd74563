//! The envelope that makes a hand feel the sound.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

/// The envelope of the drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Modulation {
    pub shape: Envelope,
    /// Hz
    pub frequency: f64,
    /// 0: none; 1: down to silence.
    pub depth: f64,
}

impl Default for Modulation {
    fn default() -> Self {
        Self { shape: Envelope::Off, frequency: 200.0, depth: 1.0 }
    }
}

impl Modulation {
    /// The factor on the drive's amplitude at a time (s), 1 - depth to 1.
    pub fn envelope(&self, time: f64) -> f64 {
        let cycles = self.frequency * time;
        match self.shape {
            Envelope::Off => 1.0,
            Envelope::Sine => 1.0 - self.depth * (1.0 - (TAU * cycles.fract()).sin()) / 2.0,
            Envelope::Square if cycles.rem_euclid(1.0) < 0.5 => 1.0,
            Envelope::Square => 1.0 - self.depth,
        }
    }

    /// The mean of its square: the part of the steady sound's radiation pressure that is there on average.
    pub fn mean_square(&self) -> f64 {
        let low = 1.0 - self.depth;
        match self.shape {
            Envelope::Off => 1.0,
            Envelope::Sine => (1.0 - self.depth / 2.0).powi(2) + self.depth.powi(2) / 8.0,
            Envelope::Square => (1.0 + low * low) / 2.0,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Envelope {
    Off,
    Sine,
    Square,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_square_is_that_of_the_envelope() {
        for shape in [Envelope::Off, Envelope::Sine, Envelope::Square] {
            for depth in [0.0, 0.3, 1.0] {
                let modulation = Modulation { shape, depth, frequency: 200.0 };
                const STEPS: u32 = 1000;
                let at = |i: u32| modulation.envelope((f64::from(i) + 0.5) / f64::from(STEPS) / 200.0);
                let mean = (0..STEPS).map(|i| at(i).powi(2)).sum::<f64>() / f64::from(STEPS);
                assert!((mean - modulation.mean_square()).abs() < 1e-12, "{modulation:?}: {mean}");
                let range =
                    (0..STEPS).map(at).fold((1.0f64, 0.0f64), |(low, high), m| (low.min(m), high.max(m)));
                assert!(range.0 >= 1.0 - depth - 1e-12 && range.1 <= 1.0 + 1e-12, "{range:?}");
            }
        }
        let full = |shape| Modulation { shape, ..Modulation::default() }.mean_square();
        assert_eq!((full(Envelope::Sine), full(Envelope::Square)), (0.375, 0.5));
    }
}
