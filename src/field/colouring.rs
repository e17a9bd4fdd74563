//! From complex pressure to colour. What `shaders/picture.wgsl` does.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use num_complex::Complex32;
use rayon::prelude::*;

use crate::field::cpu;
use crate::field::cpu::Law;

/// What of a complex pressure is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// |P|/√2, from 0 to the field's peak.
    Rms,
    /// arg P, once round a cyclic table.
    Phase,
    /// Re{P e^{jωt}} at one moment, from minus the peak to the peak.
    Instantaneous,
    /// √(s/2) of a mean square s = ⟨|P|²⟩, the real part of an average.
    MeanRms,
    /// Depth, the real part of an average.
    Dent,
    /// Radiation pressure, the imaginary part of an average.
    Radiation,
}

impl Quantity {
    pub const ALL: [Self; 6] =
        [Self::Rms, Self::Phase, Self::Instantaneous, Self::MeanRms, Self::Dent, Self::Radiation];

    /// The number that is shown: Pa, rad in (-π, π], or m; of an instantaneous pressure that at ωt = 0.
    pub fn of(self, p: Complex32) -> f32 {
        match self {
            Self::Rms => p.norm() * FRAC_1_SQRT_2 as f32,
            Self::Phase => p.arg(),
            Self::Instantaneous => p.re,
            Self::MeanRms => (p.re.max(0.0) / 2.0).sqrt(),
            Self::Dent => p.re,
            Self::Radiation => p.im,
        }
    }

    /// Whether it runs from nothing to a largest number, so that a logarithm can be taken of it.
    pub fn is_amount(self) -> bool {
        !matches!(self, Self::Phase | Self::Instantaneous)
    }
}

/// How amounts are spread over the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scale {
    Linear,
    /// By their logarithm, from [`FLOOR`] of the largest.
    Logarithmic,
}

/// The part of the largest amount that has the first colour of a logarithmic scale: -60 dB of a pressure.
pub const FLOOR: f32 = 1e-3;

/// How a field is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Colouring {
    pub quantity: Quantity,
    /// Colours as the bytes r, g, b, a.
    pub table: [[u8; 4]; 256],
    /// What gets the last colour, the largest if `None`: |P| (Pa, peak) of a field, the number itself of an average.
    pub full: Option<f32>,
    /// Of amounts; phases and instantaneous pressures are linear.
    pub scale: Scale,
    /// rad, the ωt of an instantaneous pressure; nothing else depends on it.
    pub phase: f32,
}

impl Colouring {
    /// Up to the largest number, linearly, at ωt = 0.
    pub fn new(quantity: Quantity, table: [[u8; 4]; 256]) -> Self {
        Self { quantity, table, full: None, scale: Scale::Linear, phase: 0.0 }
    }

    /// The number that is shown of a value.
    pub fn of(&self, p: Complex32) -> f32 {
        match self.quantity {
            Quantity::Instantaneous => (p * self.turn()).re,
            quantity => quantity.of(p),
        }
    }

    /// e^{jωt}
    pub fn turn(&self) -> Complex32 {
        Complex32::cis(self.phase)
    }

    /// The scale that the quantity allows.
    pub fn scale(&self) -> Scale {
        if self.quantity.is_amount() { self.scale } else { Scale::Linear }
    }

    /// The colours of a field whose largest |P| is `peak` (Pa), or of an average with this largest number, in its own order.
    pub fn colours(&self, field: &[Complex32], peak: f32, colours: &mut Vec<[u8; 4]>) {
        /// Pixels whose places in the table are found together.
        const RUN: usize = 1024;
        let law = self.law(self.full.unwrap_or(peak).max(1e-30));
        colours.resize(field.len(), [0; 4]);
        colours.par_chunks_mut(RUN).zip(field.par_chunks(RUN)).with_min_len(16).for_each(
            |(colours, field)| {
                let mut places = [0; RUN];
                self.places(field, law, &mut places);
                for (colour, place) in colours.iter_mut().zip(places) {
                    *colour = self.table[usize::from(place)];
                }
            },
        );
    }

    fn law(&self, largest: f32) -> Law {
        match (self.quantity, self.scale()) {
            (Quantity::Instantaneous, _) => Law::Linear { of_zero: 127.5, per_unit: 127.5 / largest },
            (_, Scale::Linear) => Law::Linear { of_zero: 0.0, per_unit: 255.0 / largest },
            (_, Scale::Logarithmic) => Law::Logarithmic { largest, floor: FLOOR },
        }
    }

    fn places<const RUN: usize>(&self, field: &[Complex32], law: Law, places: &mut [u8; RUN]) {
        let mut all = [0.0; RUN];
        let numbers = &mut all[..field.len()];
        let turn = self.turn();
        match self.quantity {
            Quantity::Phase => {
                for (place, p) in places.iter_mut().zip(field) {
                    *place = phase_index(f64::from(p.arg())) as u8;
                }
                return;
            }
            Quantity::Rms => cpu::magnitudes(field, numbers),
            Quantity::Instantaneous => {
                for (number, p) in numbers.iter_mut().zip(field) {
                    *number = p.re * turn.re - p.im * turn.im;
                }
            }
            Quantity::MeanRms | Quantity::Dent | Quantity::Radiation => {
                for (number, &p) in numbers.iter_mut().zip(field) {
                    *number = self.quantity.of(p);
                }
            }
        }
        cpu::places(numbers, law, &mut places[..field.len()]);
    }
}

/// The place of a phase (rad) in a cyclic table.
pub fn phase_index(phase: f64) -> usize {
    (((phase / TAU + 0.5).rem_euclid(1.0) * 256.0) as usize).min(255)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colouring(quantity: Quantity) -> Colouring {
        Colouring::new(quantity, std::array::from_fn(|i| [i as u8; 4]))
    }

    #[test]
    fn the_peak_gets_the_last_colour_and_silence_the_first() {
        let field = [Complex32::new(0.0, -3.0), Complex32::ZERO, Complex32::new(1.5, 0.0)];
        let mut colours = Vec::new();
        colouring(Quantity::Rms).colours(&field, 3.0, &mut colours);
        assert_eq!(colours, [[255; 4], [0; 4], [128; 4]]);
        Colouring { full: Some(1.0), ..colouring(Quantity::Rms) }.colours(&field, 3.0, &mut colours);
        assert_eq!(colours, [[255; 4], [0; 4], [255; 4]]);
    }

    #[test]
    fn a_logarithmic_scale_is_as_fine_at_its_end_as_at_its_start() {
        let at = |decibels: f32| Complex32::from_polar(10f32.powf(decibels / 20.0), 0.3);
        let field: Vec<_> = (0..=240).map(|i| at(-0.25 * i as f32)).collect();
        let mut colours = Vec::new();
        let colouring = Colouring { scale: Scale::Logarithmic, ..colouring(Quantity::Rms) };
        colouring.colours(&field, 1.0, &mut colours);
        assert_eq!((colours[0], colours[240]), ([255; 4], [0; 4]), "-60 dB is the end");
        // A quarter of a dB is 1.06 of 255 places.
        assert!(colours.windows(2).all(|pair| (1..=2).contains(&(pair[0][0] - pair[1][0]))), "{colours:?}");
    }

    #[test]
    fn an_instantaneous_pressure_turns_round_the_middle_of_the_table() {
        let field = [Complex32::new(2.0, 0.0), Complex32::new(0.0, 2.0), Complex32::ZERO];
        let at = |phase: f32| {
            let mut colours = Vec::new();
            let colouring = Colouring { phase, ..colouring(Quantity::Instantaneous) };
            colouring.colours(&field, 2.0, &mut colours);
            colours.iter().map(|colour| colour[0]).collect::<Vec<_>>()
        };
        assert_eq!(at(0.0), [255, 128, 128]);
        assert_eq!(at(std::f32::consts::PI)[0], 0);
        assert_eq!(at(std::f32::consts::FRAC_PI_2)[1], 0, "Re{{j e^(jπ/2)}} = -1");
    }

    #[test]
    fn phases_next_to_the_cut_get_neighbouring_places() {
        let cut = std::f64::consts::PI - 1e-4;
        assert_eq!((phase_index(cut), phase_index(-cut), phase_index(1e-4)), (255, 0, 128));
    }
}
