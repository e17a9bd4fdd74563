//! Indices of numbers in a table of 256 colours.

use std::f32::consts::LN_2;

use crate::simd::{Instructions, Isa, Kernel, larger};

/// The last index.
const LAST: f32 = 255.0;
/// Numbers processed together.
const RUN: usize = 32;

/// The mapping of a number to an index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    Linear {
        of_zero: f32,
        per_unit: f32,
    },
    /// Logarithm from a floor, as a part of the largest number, to that number.
    Logarithmic {
        largest: f32,
        floor: f32,
    },
}

/// The index of every number, rounded and clamped to the ends of the table.
pub fn places(numbers: &[f32], law: Law, places: &mut [u8]) {
    Isa::best().run(Places { numbers, law, places });
}

struct Places<'a> {
    numbers: &'a [f32],
    law: Law,
    places: &'a mut [u8],
}

impl Kernel for Places<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { numbers, law, places } = self;
        match law {
            Law::Linear { of_zero, per_unit } => {
                each(numbers, places, |number| rounded(of_zero + number * per_unit));
            }
            Law::Logarithmic { largest, floor } => {
                let per_unit = 1.0 / largest;
                let per_octave = LAST / -floor.log2();
                let least = 0.5 * floor;
                each(numbers, places, |number| {
                    rounded(LAST + per_octave * log2(larger(number * per_unit, least)))
                });
            }
        }
    }
}

#[inline(always)]
fn each(numbers: &[f32], places: &mut [u8], place: impl Fn(f32) -> u8) {
    let (runs, rest) = places.as_chunks_mut::<RUN>();
    let (numbers, numbers_rest) = numbers.as_chunks::<RUN>();
    for (run, numbers) in runs.iter_mut().zip(numbers) {
        for (to, number) in run.iter_mut().zip(numbers) {
            *to = place(*number);
        }
    }
    for (to, number) in rest.iter_mut().zip(numbers_rest) {
        *to = place(*number);
    }
}

#[inline(always)]
fn rounded(place: f32) -> u8 {
    /// Adding this rounds a small number into the last bits.
    const ROUNDER: f32 = 8_388_608.0;
    (place.clamp(0.0, LAST) + ROUNDER).to_bits() as u8
}

/// The logarithm of a positive number to base 2, to 2e-4: that of the mantissa m by artanh's series in (m - 1) / (m + 1).
#[inline(always)]
fn log2(x: f32) -> f32 {
    const MANTISSA: u32 = 0x007f_ffff;
    const ONE: u32 = 0x3f80_0000;
    let bits = x.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let mantissa = f32::from_bits(bits & MANTISSA | ONE);
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let square = s * s;
    exponent as f32 + 2.0 / LN_2 * s * (1.0 + square * (1.0 / 3.0 + square / 5.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_right_to_a_fraction_of_a_colour() {
        let at = |i: i32| 1e-6 * 1.01f32.powi(i);
        assert!((0..2800).all(|i| (log2(at(i)) - at(i).log2()).abs() < 2.1e-4));
    }

    #[test]
    fn every_place_of_a_logarithmic_table_is_met_and_the_ends_hold_what_is_beyond() {
        let law = Law::Logarithmic { largest: 7.0, floor: 1e-3 };
        let numbers: Vec<f32> = (0..=255).map(|i| 7.0 * 1e-3f32.powf(1.0 - i as f32 / 255.0)).collect();
        let mut found = vec![0; 256];
        places(&numbers, law, &mut found);
        assert!(found.iter().enumerate().all(|(i, &place)| usize::from(place) == i), "{found:?}");
        let mut ends = [9; 4];
        places(&[0.0, -3.0, 8.0, f32::INFINITY], law, &mut ends);
        assert_eq!(ends, [0, 0, 255, 255]);
        places(&[-2.0, 0.0, 1.0, 1e30], Law::Linear { of_zero: 127.5, per_unit: 127.5 }, &mut ends);
        assert_eq!(ends, [0, 128, 255, 255]);
    }
}
