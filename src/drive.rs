//! What the elements are driven with: amplitude and phase, and the levels that a board understands.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// One value per element of the array, in its numbering; u_n = amplitude · e^{j phase}.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive {
    /// 0 to 1; 0 for elements that are off.
    pub amplitudes: Vec<f64>,
    /// rad, in (-π, π]
    pub phases: Vec<f64>,
}

impl Drive {
    /// Full amplitude on the `driven` elements of an array of `elements`, with the phases of `excitation` (one value
    /// per driven element).
    pub fn uniform(elements: usize, driven: &[usize], excitation: &[Complex64]) -> Self {
        let mut drive = Self { amplitudes: vec![0.0; elements], phases: vec![0.0; elements] };
        for (&element, u) in driven.iter().zip(excitation) {
            drive.amplitudes[element] = 1.0;
            drive.phases[element] = u.arg();
        }
        drive
    }

    /// u of each of the `driven` elements.
    pub fn excitation(&self, driven: &[usize]) -> Vec<Complex64> {
        driven.iter().map(|&n| Complex64::from_polar(self.amplitudes[n], self.phases[n])).collect()
    }
}

/// The level that a board with `levels` steps per period plays for a phase (rad): boards speak delay, so the sign is
/// converted here and nowhere else.
pub fn delay_level(phase: f64, levels: u32) -> u32 {
    let delay = (-phase / TAU).rem_euclid(1.0);
    (delay * f64::from(levels)).round() as u32 % levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_ahead_is_a_delay_of_the_rest_of_the_period() {
        assert_eq!(delay_level(0.0, 32), 0);
        assert_eq!(delay_level(TAU / 4.0, 32), 24);
        assert_eq!(delay_level(-TAU / 4.0, 32), 8);
        assert_eq!(delay_level(5.0 * TAU - TAU / 4.0, 32), 8);
    }

    #[test]
    fn rounding_up_to_a_whole_period_wraps() {
        assert_eq!(delay_level(1e-9, 128), 0);
        assert_eq!(delay_level(TAU * 0.002, 128), 0);
    }

    #[test]
    fn elements_that_are_off_stay_silent() {
        let drive =
            Drive::uniform(3, &[0, 2], &[Complex64::from_polar(5.0, 1.0), Complex64::from_polar(0.1, -2.0)]);
        assert_eq!(drive.amplitudes, [1.0, 0.0, 1.0]);
        assert!((drive.phases[0] - 1.0).abs() < 1e-15 && (drive.phases[2] + 2.0).abs() < 1e-15);
    }
}
