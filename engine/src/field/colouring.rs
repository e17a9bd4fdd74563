//! From values to colours on the CPU; the counterpart of `shaders/picture.wgsl`.

use std::f32::consts::TAU;

use rayon::prelude::*;

use crate::field::cpu::{self, Law};
use crate::field::quantity::{Quantity, Range};

/// The mapping of amounts to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scale {
    Linear,
    /// Logarithm of an amount, from a part of the largest.
    Logarithmic,
}

/// [`Colouring::floor`] by default: -60 dB of a pressure.
pub const FLOOR: f32 = 1e-3;
/// The last index of a table.
const LAST: f32 = 255.0;
/// Divisor for all-zero values.
pub const SMALLEST: f32 = 1e-30;

/// The colours of values.
#[derive(Clone, Debug, PartialEq)]
pub struct Colouring {
    pub range: Range,
    /// Colours as the bytes r, g, b, a.
    pub table: [[u8; 4]; 256],
    /// The value of the last colour; the map's peak if `None`.
    pub full: Option<f32>,
    /// The value of the first colour of a linear scale with a given `full`; if `None`, 0 of amounts and `-full` of
    /// signed values.
    pub low: Option<f32>,
    /// Scale of amounts; other ranges are linear.
    pub scale: Scale,
    /// The part of the largest amount that has the first colour of a logarithmic scale, in (0, 1).
    pub floor: f32,
}

/// r, g, b, a of a body in a map, and of the lines on it.
pub const HATCH: [[u8; 4]; 2] = [[104, 104, 104, 255], [168, 168, 168, 255]];

/// The index of a value in a table: `zero + spread · part`, where the part is `value / full`, or its base-2 logarithm
/// on a logarithmic scale, and `full` may be the peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub zero: f32,
    pub spread: f32,
    /// `None` for the peak.
    pub full: Option<f32>,
}

impl Colouring {
    /// Up to the peak, linearly.
    pub fn new(quantity: Quantity, table: [[u8; 4]; 256]) -> Self {
        let range = quantity.declaration().range;
        Self { range, table, full: None, low: None, scale: Scale::Linear, floor: FLOOR }
    }

    /// The scale that the range allows.
    pub fn scale(&self) -> Scale {
        if self.range == Range::Amount { self.scale } else { Scale::Linear }
    }

    /// The mapping of values to table indices.
    pub fn line(&self) -> Line {
        let full = self.full;
        if self.scale() == Scale::Logarithmic {
            return Line { zero: LAST, spread: LAST / -self.floor.log2(), full };
        }
        // The first colour's part of the last one's value.
        let low = match (self.low, full) {
            (Some(low), Some(full)) if low < full && full > 0.0 => Some(low / full),
            (Some(_) | None, Some(_) | None) => None,
        };
        let from = |low: f32| Line { zero: -LAST * low / (1.0 - low), spread: LAST / (1.0 - low), full };
        match self.range {
            Range::Amount => from(low.unwrap_or(0.0)),
            Range::Signed => from(low.unwrap_or(-1.0)),
            // Every colour covers an equal part of the circle.
            Range::Cyclic => Line { zero: LAST / 2.0, spread: LAST + 1.0, full: Some(TAU) },
        }
    }

    /// The colours of values in their order; `peak` is the largest that they reach.
    pub fn colours(&self, values: &[f32], peak: f32, colours: &mut Vec<[u8; 4]>) {
        /// Values processed together.
        const RUN: usize = 1024;
        let law = self.law(peak);
        colours.resize(values.len(), [0; 4]);
        colours.par_chunks_mut(RUN).zip(values.par_chunks(RUN)).with_min_len(16).for_each(
            |(colours, values)| {
                let mut places = [0; RUN];
                cpu::places(values, law, &mut places[..values.len()]);
                for (colour, place) in colours.iter_mut().zip(places) {
                    *colour = self.table[usize::from(place)];
                }
            },
        );
    }

    fn law(&self, peak: f32) -> Law {
        let Line { zero, spread, full } = self.line();
        // Of a silent map every value is 0, but for rounding.
        let is_silent = match self.range {
            Range::Amount | Range::Signed => self.full.unwrap_or(peak) <= 0.0,
            Range::Cyclic => peak <= 0.0,
        };
        if is_silent {
            return Law::Linear {
                of_zero: if self.scale() == Scale::Linear { zero } else { 0.0 },
                per_unit: 0.0,
            };
        }
        let full = full.unwrap_or(peak).max(SMALLEST);
        match self.scale() {
            Scale::Linear => Law::Linear { of_zero: zero, per_unit: spread / full },
            Scale::Logarithmic => Law::Logarithmic { largest: full, floor: self.floor },
        }
    }
}

/// Draws what is within bodies, where values in rows of `width` are no numbers, as lines at 45 degrees: in two greys that
/// no colour map takes for values, seen on dark and light maps.
pub fn hatch(values: &[f32], width: usize, colours: &mut [[u8; 4]]) {
    let period = (width / 48).clamp(4, 24);
    for (index, (colour, value)) in colours.iter_mut().zip(values).enumerate() {
        if value.is_nan() {
            let (column, row) = (index % width.max(1), index / width.max(1));
            *colour = HATCH[usize::from((column + row) % period < period.div_ceil(3))];
        }
    }
}

/// The index of a phase (rad) in a cyclic table.
pub fn phase_index(phase: f64) -> usize {
    (((phase / f64::from(TAU) + 0.5).rem_euclid(1.0) * 256.0) as usize).min(255)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    fn places(quantity: Quantity, full: Option<f32>, values: &[f32], peak: f32) -> Vec<u8> {
        let table = std::array::from_fn(|i| [i as u8; 4]);
        let mut colours = Vec::new();
        Colouring { full, ..Colouring::new(quantity, table) }.colours(values, peak, &mut colours);
        colours.iter().map(|colour| colour[0]).collect()
    }

    #[test]
    fn the_peak_gets_the_last_colour_and_silence_the_first() {
        let values = [3.0, 0.0, 1.5];
        assert_eq!(places(Quantity::Rms, None, &values, 3.0), [255, 0, 128]);
        assert_eq!(places(Quantity::Rms, Some(1.0), &values, 3.0), [255, 0, 255]);
    }

    #[test]
    fn bodies_are_hatched_whatever_the_scale() {
        let values = [1.0, f32::NAN, f32::NAN, f32::NAN, f32::NAN, 0.5, f32::NAN, f32::NAN];
        let mut colours = vec![[7; 4]; 8];
        hatch(&values, 4, &mut colours);
        let is_hatched = |colour: &[u8; 4]| HATCH.contains(colour);
        assert!(colours.iter().zip(values).all(|(colour, value)| is_hatched(colour) == value.is_nan()));
        assert!(HATCH.iter().all(|tone| colours.contains(tone)), "{colours:?}");
    }

    #[test]
    fn nothing_stands_in_the_middle_of_signed_values() {
        for quantity in [Quantity::Radiation, Quantity::Instantaneous] {
            assert_eq!(places(quantity, None, &[-2.0, -1.0, 0.0, 2.0], 2.0), [0, 64, 128, 255]);
        }
    }

    #[test]
    fn a_logarithmic_scale_is_as_fine_at_its_end_as_at_its_start() {
        let values: Vec<_> = (0..=240).map(|i| 10f32.powf(-0.25 * i as f32 / 20.0)).collect();
        let mut colours = Vec::new();
        let table = std::array::from_fn(|i| [i as u8; 4]);
        let colouring = Colouring { scale: Scale::Logarithmic, ..Colouring::new(Quantity::Rms, table) };
        colouring.colours(&values, 1.0, &mut colours);
        assert_eq!((colours[0], colours[240]), ([255; 4], [0; 4]), "-60 dB is the end");
        // A quarter of a dB is 1.06 of 255 places.
        assert!(colours.windows(2).all(|pair| (1..=2).contains(&(pair[0][0] - pair[1][0]))), "{colours:?}");
        Colouring { floor: 1e-2, ..colouring }.colours(&[1.0, 0.11, 0.01, 1e-3], 1.0, &mut colours);
        assert_eq!(colours, [[255; 4], [133; 4], [0; 4], [0; 4]], "-40 dB is the end");
    }

    #[test]
    fn a_range_has_its_ends_at_the_first_and_the_last_colour() {
        let table = std::array::from_fn(|i| [i as u8; 4]);
        let places = |quantity, low, full, values: &[f32]| {
            let mut colours = Vec::new();
            let own = Colouring::new(quantity, table);
            Colouring { low: Some(low), full, ..own }.colours(values, 9.0, &mut colours);
            colours.iter().map(|colour| colour[0]).collect::<Vec<_>>()
        };
        let values = [-3.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(places(Quantity::Rms, 1.0, Some(3.0), &values), [0, 0, 128, 255, 255]);
        assert_eq!(places(Quantity::Instantaneous, -1.0, Some(3.0), &values), [0, 128, 191, 255, 255]);
        // Without an upper end there is no lower one, and an empty range is that of the map.
        assert_eq!(places(Quantity::Rms, 1.0, None, &[0.0, 9.0]), [0, 255]);
        assert_eq!(places(Quantity::Rms, 5.0, Some(3.0), &[0.0, 3.0]), [0, 255]);
    }

    #[test]
    fn phases_next_to_the_cut_get_neighbouring_places() {
        let cut = PI - 1e-4;
        assert_eq!(places(Quantity::Phase, None, &[cut, -cut, 1e-4], 9.0), [255, 0, 128]);
        assert_eq!([cut, -cut, 1e-4].map(|phase| phase_index(phase.into())), [255, 0, 128]);
    }
}
