//! The drive: amplitude and phase per element, and their quantisation to a board's levels.
//!
//! ```
//! use sonoglyph::drive::{Drive, delay_level};
//!
//! let drive = Drive { amplitudes: vec![1.0; 2], phases: vec![0.0, 1.6] };
//! // The nearest of 4 phases, and the delay that makes it.
//! assert!((drive.at_levels(4).phases[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
//! assert_eq!(delay_level(drive.phases[1], 4), 3);
//! ```

use std::f64::consts::{PI, TAU};
use std::io::Read;
use std::ops::Range;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::acoustics::Aperture;
use crate::table::{Table, TableError};

/// One value per element of the array, in its numbering; u_n = amplitude · e^{j phase}.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// 0 to 1; 0 for elements that are off.
    pub amplitudes: Vec<f64>,
    /// rad, in (-π, π]
    pub phases: Vec<f64>,
}

impl Drive {
    /// Full amplitude on the `driven` elements of an array of `elements`, with the phases of `excitation` (one value
    /// per driven element).
    ///
    /// # Panics
    /// A driven element beyond the last; the same holds of the next two and of [`Drive::excitation`].
    pub fn uniform(elements: usize, driven: &[usize], excitation: &[Complex64]) -> Self {
        let mut drive = Self { amplitudes: vec![0.0; elements], phases: vec![0.0; elements] };
        for (&element, u) in driven.iter().zip(excitation) {
            drive.amplitudes[element] = 1.0;
            drive.phases[element] = u.arg();
        }
        drive
    }

    /// The `excitation` itself (one value per driven element, of modulus 1 at most).
    pub fn of(elements: usize, driven: &[usize], excitation: &[Complex64]) -> Self {
        /// Rounding error of a phasor of modulus 1.
        const ROUNDING: f64 = 1e-12;
        let mut drive = Self::uniform(elements, driven, excitation);
        for (&element, u) in driven.iter().zip(excitation) {
            // No overflow guard as in `hypot`: all values are at most 1.
            let modulus = u.norm_sqr().sqrt();
            drive.amplitudes[element] = if modulus > 1.0 - ROUNDING { 1.0 } else { modulus };
        }
        drive
    }

    /// The `excitation`, scaled so that the largest amplitude is full drive.
    pub fn free(elements: usize, driven: &[usize], excitation: &[Complex64]) -> Self {
        let largest = excitation.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let scaled: Vec<_> = excitation.iter().map(|u| u / largest).collect();
        Self::of(elements, driven, &scaled)
    }

    /// Reads CSV with the column `phase` (rad) and optionally `amplitude` (0 to 1; without the column 1) and
    /// `element` (from 0; without the column in order); one row per element.
    ///
    /// # Errors
    /// An invalid row, or duplicate or missing elements.
    pub fn read(csv: impl Read, elements: usize) -> Result<Self, TableError> {
        let mut table = Table::open(csv, ["phase"], ["amplitude", "element"])?;
        let mut drive = Self { amplitudes: vec![0.0; elements], phases: vec![0.0; elements] };
        let mut given = vec![false; elements];
        let mut next = 0;
        while let Some(row) = table.next_row()? {
            let ([phase], [amplitude, element]) = (row.required, row.optional);
            let element = element.unwrap_or(next as f64);
            if element.fract() != 0.0 || element < 0.0 || element >= elements as f64 {
                let last = elements.saturating_sub(1);
                let reason = format!("element = {element:?}: the scene's elements are numbered 0 to {last}");
                return Err(table.refusal(reason));
            }
            let element = element as usize;
            let amplitude = amplitude.unwrap_or(1.0);
            if !(0.0..=1.0).contains(&amplitude) {
                return Err(table.refusal(format!("amplitude = {amplitude:?}: must be from 0 to 1")));
            }
            if std::mem::replace(&mut given[element], true) {
                return Err(table.refusal(format!("element {element} is given twice")));
            }
            (drive.phases[element], drive.amplitudes[element]) = (wrapped(phase), amplitude);
            next = element + 1;
        }
        match given.iter().position(|given| !given) {
            Some(missing) => Err(table.refusal(format!("element {missing} of {elements} is missing"))),
            None => Ok(drive),
        }
    }

    /// Writes CSV for [`Self::read`]: the columns `element`, `x`, `y` and, unless all are 0, `z` (m), `phase` (rad)
    /// and `amplitude`.
    pub fn write(&self, aperture: &Aperture) -> String {
        Self::write_in_turn(std::slice::from_ref(self), aperture)
    }

    /// The same of drives in turn, one after the other; several have a further column `frame`, from 0.
    pub fn write_in_turn(drives: &[Self], aperture: &Aperture) -> String {
        let is_flat = aperture.positions.iter().all(|position| position.z == 0.0);
        let mut text = String::from(if is_flat { "element,x,y" } else { "element,x,y,z" });
        text.push_str(",phase,amplitude");
        text.push_str(if drives.len() > 1 { ",frame\n" } else { "\n" });
        for (frame, drive) in drives.iter().enumerate() {
            let frame = if drives.len() > 1 { format!(",{frame}") } else { String::new() };
            for (element, position) in aperture.positions.iter().enumerate() {
                let (phase, amplitude) = (drive.phases[element], drive.amplitudes[element]);
                let z = if is_flat { String::new() } else { format!("{:?},", position.z) };
                text.push_str(&format!(
                    "{element},{:?},{:?},{z}{phase:?},{amplitude:?}{frame}\n",
                    position.x, position.y
                ));
            }
        }
        text
    }

    /// The drive quantised to `levels` phases per period.
    ///
    /// # Panics
    /// No levels.
    pub fn at_levels(&self, levels: u32) -> Self {
        let played = |&phase: &f64| {
            let turns = -f64::from(delay_level(phase, levels)) / f64::from(levels);
            TAU * if turns <= -0.5 { turns + 1.0 } else { turns }
        };
        Self { amplitudes: self.amplitudes.clone(), phases: self.phases.iter().map(played).collect() }
    }

    /// The drive of some elements.
    ///
    /// # Panics
    /// Elements out of range.
    pub fn part(&self, elements: Range<usize>) -> Self {
        let some = |values: &[f64]| values[elements.clone()].to_vec();
        Self { amplitudes: some(&self.amplitudes), phases: some(&self.phases) }
    }

    /// u of each of the `driven` elements.
    pub fn excitation(&self, driven: &[usize]) -> Vec<Complex64> {
        driven.iter().map(|&n| Complex64::from_polar(self.amplitudes[n], self.phases[n])).collect()
    }
}

/// A phase (rad) wrapped to (-π, π], unchanged if already there.
fn wrapped(phase: f64) -> f64 {
    if -PI < phase && phase <= PI { phase } else { phase.sin().atan2(phase.cos()) }
}

/// The delay level of a phase (rad), of `levels` per period: boards use delay, and the sign is converted only here. A
/// NaN phase has no delay.
///
/// # Panics
/// No levels.
pub fn delay_level(phase: f64, levels: u32) -> u32 {
    let delay = (-phase / TAU).rem_euclid(1.0);
    (delay * f64::from(levels)).round() as u32 % levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Array, Elements, Placed, Scene};

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
    fn played_phases_are_the_nearest_levels() {
        let drive =
            Drive { amplitudes: vec![1.0; 41], phases: (-20..=20).map(|i| f64::from(i) / 6.4).collect() };
        for levels in [2, 3, 8, 32, 256] {
            let played = drive.at_levels(levels);
            for (wanted, phase) in drive.phases.iter().zip(&played.phases) {
                let off = (wanted - phase).rem_euclid(TAU);
                assert!(
                    off.min(TAU - off) <= TAU / 2.0 / f64::from(levels) + 1e-12,
                    "{levels}: {wanted} as {phase}"
                );
                assert!(-PI < *phase && *phase <= PI, "{phase}");
                let level = delay_level(*phase, levels);
                assert_eq!(level, delay_level(*wanted, levels), "playing what is played changes nothing");
            }
        }
    }

    #[test]
    fn a_free_drive_keeps_ratios_and_its_loudest_element_plays_fully() {
        let values = [(3.0, 1.0), (0.0, 0.0), (6.0, -2.0)].map(|(r, phase)| Complex64::from_polar(r, phase));
        let drive = Drive::free(4, &[0, 1, 3], &values);
        assert!((drive.amplitudes[0] - 0.5).abs() < 1e-15 && drive.amplitudes[1..] == [0.0, 0.0, 1.0]);
        assert!((drive.phases[3] + 2.0).abs() < 1e-15);
        assert_eq!(Drive::free(1, &[0], &[Complex64::ZERO]).amplitudes, [0.0], "nothing stays nothing");
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let scene = Scene { array: Array { rows: 2, columns: 2, ..Array::default() }, ..Scene::default() };
        let drive = Drive { amplitudes: vec![1.0, 0.0, 0.3, 1.0], phases: vec![PI, -0.0, 1e-9, -3.0] };
        let text = drive.write(&Aperture::new(&scene));
        assert_eq!(text.lines().count(), 5);
        assert!(text.starts_with("element,x,y,phase,amplitude\n"), "a flat array has no heights: {text}");
        assert_eq!(Drive::read(text.as_bytes(), 4), Ok(drive));
        let in_order = Drive::read(&b"phase\n0\n7.0\n1e300\n-4.0\n"[..], 4).unwrap();
        assert_eq!(in_order.amplitudes, [1.0; 4]);
        assert!((in_order.phases[3] - (TAU - 4.0)).abs() < 1e-12);
        assert!((in_order.phases[1] - (7.0 - TAU)).abs() < 1e-12 && in_order.phases[2].abs() <= PI);
    }

    #[test]
    fn heights_are_written_if_any_element_has_one() {
        let placed = |z: f64| Placed { at: [0.01, 2.0 * z, z].into(), normal: [0.0, 0.0, 1.0].into() };
        let placed = Elements::new([-0.004, 0.0, 0.004].map(placed).to_vec(), None);
        let array = Array { placed, file: Some("stairs.csv".to_owned()), ..Array::default() };
        let aperture = Aperture::new(&Scene { array, ..Scene::default() });
        assert_eq!(aperture.positions[1].z, 0.0);
        let drive = Drive { amplitudes: vec![1.0, 0.5, 0.25], phases: vec![0.1, -0.2, 0.3] };
        let text = drive.write(&aperture);
        assert!(text.starts_with("element,x,y,z,phase,amplitude\n"), "{text}");
        assert_eq!(Drive::read(text.as_bytes(), 3), Ok(drive));
    }

    #[test]
    fn phases_within_half_a_turn_are_kept_to_the_last_digit_and_others_wrapped() {
        for i in -999..=1000 {
            let phase = PI * f64::from(i) / 1000.0;
            assert_eq!(wrapped(phase), phase);
            for turns in [-3.0, -1.0, 1.0, 2.0] {
                let off = (wrapped(phase + TAU * turns) - phase).abs();
                assert!(off.min(TAU - off) < 1e-12, "{phase} and {turns} turns: {off}");
            }
        }
    }

    #[test]
    fn a_table_that_is_no_drive_is_refused_by_line() {
        for (text, error) in [
            ("phase\n0\n", "2: element 1 of 2 is missing"),
            ("phase\n0\n\n0\n0\n", "5: element = 2.0: the scene's elements are numbered 0 to 1"),
            ("phase,element\n0,0.5\n", "2: element = 0.5: the scene's"),
            ("phase,element\n0,1\n0,1\n", "3: element 1 is given twice"),
            ("phase,amplitude\n0,1.5\n", "2: amplitude = 1.5: must be"),
            ("phase,amplitude\n0,0.5\n0,\n", "3: amplitude is empty"),
        ] {
            let refused = Drive::read(text.as_bytes(), 2).unwrap_err().to_string();
            assert!(refused.starts_with(error), "{text:?}: {refused}");
        }
    }

    #[test]
    fn elements_that_are_off_stay_silent() {
        let drive =
            Drive::uniform(3, &[0, 2], &[Complex64::from_polar(5.0, 1.0), Complex64::from_polar(0.1, -2.0)]);
        assert_eq!(drive.amplitudes, [1.0, 0.0, 1.0]);
        assert!((drive.phases[0] - 1.0).abs() < 1e-15 && (drive.phases[2] + 2.0).abs() < 1e-15);
    }
}
