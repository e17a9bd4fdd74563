//! From complex pressure to colour. What `shaders/picture.wgsl` does.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use num_complex::Complex32;
use rayon::prelude::*;

use crate::field::cpu;

/// What of a complex pressure is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// |P|/√2, from 0 to the field's peak.
    Rms,
    /// arg P, once round a cyclic table.
    Phase,
    /// √(s/2) of a mean square s = ⟨|P|²⟩, the real part of an average.
    MeanRms,
    /// Depth, the real part of an average.
    Dent,
    /// Radiation pressure, the imaginary part of an average.
    Radiation,
}

impl Quantity {
    pub const ALL: [Self; 5] = [Self::Rms, Self::Phase, Self::MeanRms, Self::Dent, Self::Radiation];

    /// The number that is shown: Pa, rad in (-π, π], or m.
    pub fn of(self, p: Complex32) -> f32 {
        match self {
            Self::Rms => p.norm() * FRAC_1_SQRT_2 as f32,
            Self::Phase => p.arg(),
            Self::MeanRms => (p.re.max(0.0) / 2.0).sqrt(),
            Self::Dent => p.re,
            Self::Radiation => p.im,
        }
    }
}

/// How a field is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Colouring {
    pub quantity: Quantity,
    /// Colours as the bytes r, g, b, a.
    pub table: [[u8; 4]; 256],
    /// What gets the last colour, the largest if `None`: |P| (Pa, peak) of a field, the number itself of an average.
    pub full: Option<f32>,
}

impl Colouring {
    /// The colours of a field whose largest |P| is `peak` (Pa), or of an average with this largest number, in its own order.
    pub fn colours(&self, field: &[Complex32], peak: f32, colours: &mut Vec<[u8; 4]>) {
        /// Pixels whose places in the table are found together.
        const RUN: usize = 1024;
        let per_unit = 255.0 / self.full.unwrap_or(peak).max(1e-30);
        colours.resize(field.len(), [0; 4]);
        colours.par_chunks_mut(RUN).zip(field.par_chunks(RUN)).with_min_len(16).for_each(
            |(colours, field)| {
                let mut places = [0; RUN];
                match self.quantity {
                    Quantity::Rms => cpu::places(field, per_unit, &mut places[..field.len()]),
                    Quantity::Phase => {
                        for (place, p) in places.iter_mut().zip(field) {
                            *place = phase_index(f64::from(p.arg())) as u8;
                        }
                    }
                    Quantity::MeanRms | Quantity::Dent | Quantity::Radiation => {
                        for (place, &p) in places.iter_mut().zip(field) {
                            *place = (self.quantity.of(p) * per_unit + 0.5).clamp(0.0, 255.0) as u8;
                        }
                    }
                }
                for (colour, place) in colours.iter_mut().zip(places) {
                    *colour = self.table[usize::from(place)];
                }
            },
        );
    }
}

/// The place of a phase (rad) in a cyclic table.
pub fn phase_index(phase: f64) -> usize {
    (((phase / TAU + 0.5).rem_euclid(1.0) * 256.0) as usize).min(255)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_gets_the_last_colour_and_silence_the_first() {
        let field = [Complex32::new(0.0, -3.0), Complex32::ZERO, Complex32::new(1.5, 0.0)];
        let table = std::array::from_fn(|i| [i as u8; 4]);
        let mut colours = Vec::new();
        Colouring { quantity: Quantity::Rms, table, full: None }.colours(&field, 3.0, &mut colours);
        assert_eq!(colours, [[255; 4], [0; 4], [128; 4]]);
        Colouring { quantity: Quantity::Rms, table, full: Some(1.0) }.colours(&field, 3.0, &mut colours);
        assert_eq!(colours, [[255; 4], [0; 4], [255; 4]]);
    }

    #[test]
    fn phases_next_to_the_cut_get_neighbouring_places() {
        let cut = std::f64::consts::PI - 1e-4;
        assert_eq!((phase_index(cut), phase_index(-cut), phase_index(1e-4)), (255, 0, 128));
    }
}
