//! Interpolation from samples to pixels along one axis, by a Kaiser-windowed sinc.
//!
//! Slopes along the plane are interpolated from the same samples, by the derivative of the sinc under the same
//! window.

use std::f64::consts::{PI, TAU};

use bytemuck::{Pod, Zeroable};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::field::cpu::{self, Lines, ROWS, Rows};
use crate::field::polynomial;

/// f32 in a line of a cache.
const ALIGNED: usize = 16;
/// Terms of the window's polynomial: 1e-9 off for the sharpest tolerance.
const WINDOW_TERMS: usize = 18;

/// First sample of the interpolation, and weights, of every pixel along an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resampling {
    /// Samples per pixel.
    pub taps: usize,
    pub first: Vec<u32>,
    /// `taps` per pixel.
    pub weights: Vec<f32>,
}

impl Resampling {
    /// `positions` of the pixels in samples, none below `half_width` - 1; a window of 2 `half_width` taps and shape β.
    ///
    /// # Panics
    /// A half-width of 0.
    pub fn new(positions: impl Iterator<Item = f64>, half_width: usize, beta: f64) -> Self {
        let window = window(beta);
        Self::with(positions, half_width, |x, sine, inside| {
            let sinc = if x.abs() < 1e-9 { 1.0 } else { sine / (PI * x) };
            sinc * polynomial::evaluate(&window, 2.0 * inside - 1.0)
        })
    }

    /// The same for the slope at the pixels, in units per sample.
    ///
    /// The window's own slope is omitted: the window then passes and stops the sinc's slope exactly as the sinc
    /// itself.
    pub fn slopes(positions: impl Iterator<Item = f64>, half_width: usize, beta: f64) -> Self {
        let window = window(beta);
        Self::with(positions, half_width, |x, sine, inside| {
            // Near its centre the slope of the sinc is a quotient of small numbers.
            let slope =
                if x.abs() < 1e-4 { -PI * PI * x / 3.0 } else { ((PI * x).cos() - sine / (PI * x)) / x };
            slope * polynomial::evaluate(&window, 2.0 * inside - 1.0)
        })
    }

    /// The same for derivatives of the interpolated values, in units per power of a sample: those of the orders below
    /// `count`, exact where values are.
    pub fn derivatives(
        positions: impl Iterator<Item = f64>,
        half_width: usize,
        beta: f64,
        count: usize,
    ) -> Vec<Self> {
        /// Points of Cauchy's integral around a place, and their distance from it, in samples.
        const AROUND: usize = 16;
        const AWAY: f64 = 0.1;
        let window = window(beta);
        let value = |x: Complex64| {
            let inside = (x / half_width as f64).powi(2);
            let sinc = if x.norm() < 1e-9 { Complex64::ONE } else { (PI * x).sin() / (PI * x) };
            sinc * window.iter().rev().fold(Complex64::ZERO, |sum, c| sum * (2.0 * inside - 1.0) + c)
        };
        let turns: Vec<_> =
            (0..AROUND).map(|turn| Complex64::cis(TAU * turn as f64 / AROUND as f64)).collect();
        let taps = 2 * half_width;
        let mut all = vec![Self { taps, ..Self::default() }; count];
        for position in positions {
            let first = (position + 1e-9).floor().max((half_width - 1) as f64) as usize - (half_width - 1);
            all.iter_mut().for_each(|own| own.first.push(first as u32));
            for tap in 0..taps {
                let x = position - (first + tap) as f64;
                let values: Vec<_> = turns.iter().map(|turn| value(x + turn * AWAY)).collect();
                let mut scale = 1.0 / AROUND as f64;
                for (order, own) in all.iter_mut().enumerate() {
                    let part = |(at, value): (usize, &Complex64)| value * turns[(at * order) % AROUND].conj();
                    let sum: Complex64 = values.iter().enumerate().map(part).sum();
                    own.weights.push((sum.re * scale) as f32);
                    scale *= (order + 1) as f64 / AWAY;
                }
            }
        }
        all
    }

    /// With a weight for every distance in samples, the sine of π times it, and the square of its part of the half-width.
    fn with(
        positions: impl Iterator<Item = f64>,
        half_width: usize,
        weight: impl Fn(f64, f64, f64) -> f64,
    ) -> Self {
        assert!(half_width > 0, "a window without taps");
        let taps = 2 * half_width;
        let (mut first, mut weights) = (Vec::new(), Vec::new());
        for position in positions {
            // Rounding may put the first pixel a hair before its sample.
            let below = (position + 1e-9).floor().max((half_width - 1) as f64);
            let start = below as usize - (half_width - 1);
            first.push(start as u32);
            let beyond = position - start as f64;
            // The sine of all taps, up to its sign.
            let sine = (PI * beyond).sin();
            weights.extend((0..taps).map(|tap| {
                let x = beyond - tap as f64;
                let inside = (x / half_width as f64).powi(2).min(1.0);
                weight(x, [sine, -sine][tap % 2], inside) as f32
            }));
        }
        Self { taps, first, weights }
    }

    /// Pixels along the axis.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// Some of the pixels.
    pub fn part(&self, pixels: std::ops::Range<usize>) -> Self {
        let weights = self.weights[pixels.start * self.taps..pixels.end * self.taps].to_vec();
        Self { taps: self.taps, first: self.first[pixels].to_vec(), weights }
    }

    /// The same weights for `together` neighbouring pixels at a time.
    pub fn blocks(&self, together: usize) -> Blocks {
        let first: Vec<_> = self.first.chunks(together).map(|pixels| pixels[0]).collect();
        let ends = self.first.chunks(together).map(|pixels| pixels[pixels.len() - 1] as usize + self.taps);
        let span = first.iter().zip(ends).map(|(&first, end)| end - first as usize).max().unwrap_or(0);
        let mut weights = vec![0.0; first.len() * span * together];
        for pixel in 0..self.len() {
            let block = pixel / together;
            let (start, of_pixel) = self.of(pixel, 1);
            let offset = start - first[block] as usize;
            for (tap, weight) in of_pixel.iter().enumerate() {
                weights[(block * span + offset + tap) * together + pixel % together] = *weight;
            }
        }
        Blocks { first, span, weights }
    }

    /// The first common sample of some neighbouring pixels, and the weights of each.
    pub fn of(&self, pixel: usize, count: usize) -> (usize, &[f32]) {
        (self.first[pixel] as usize, &self.weights[pixel * self.taps..(pixel + count) * self.taps])
    }

    /// [`ROWS`] if the following pixels share their samples, else 1.
    fn alike(&self, pixel: usize, end: usize) -> usize {
        let alike = pixel + ROWS <= end && self.first[pixel] == self.first[pixel + ROWS - 1];
        if alike { ROWS } else { 1 }
    }
}

/// Weights of neighbouring pixels, for every sample that any of them needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    /// The first sample of every block.
    pub first: Vec<u32>,
    /// Samples per block; the last blocks may extend beyond the last sample, with weight 0.
    pub span: usize,
    /// One weight per pixel, for every sample of every block.
    pub weights: Vec<f32>,
}

/// The Kaiser window of shape β as a polynomial in 2x² - 1, x being the position in half-widths: I0(β √(1 - x²)) /
/// I0(β).
fn window(beta: f64) -> Vec<f64> {
    let peak = bessel_i0(beta);
    polynomial::fit(|s| bessel_i0(beta * ((1.0 - s) / 2.0).max(0.0).sqrt()) / peak, WINDOW_TERMS)
}

/// The modified Bessel function I0 by its power series, all of whose terms are positive.
fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for n in 1..200 {
        term *= quarter / f64::from(n * n);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    sum
}

/// An interpolated value: a fixed number of f32 components.
pub trait Value: Pod + Default + Send + Sync {}

impl Value for f32 {}
impl Value for Complex32 {}

/// f32 in a value.
const fn parts<T: Value>() -> usize {
    size_of::<T>() / size_of::<f32>()
}

/// A cache line.
#[derive(Clone, Copy, Debug, Zeroable, Pod)]
#[repr(C, align(64))]
struct Aligned([f32; ALIGNED]);

/// The intermediate values between the two passes; reused, since fresh memory costs more than the computation.
#[derive(Clone, Debug, Default)]
pub struct Between {
    lines: Vec<Aligned>,
    wide: Vec<f32>,
}

impl Between {
    /// Bytes of memory kept.
    pub(super) fn bytes(&self) -> usize {
        self.lines.capacity() * size_of::<Aligned>() + self.wide.capacity() * size_of::<f32>()
    }
}

/// Interpolates samples (row by row, `columns` in a row) across and up into pixels, row by row.
pub fn interpolate<T: Value>(
    samples: &[T],
    columns: usize,
    across: &Resampling,
    up: &Resampling,
    between: &mut Between,
    pixels: &mut [T],
) {
    let rows = samples.len() / columns;
    let Between { lines, wide } = between;
    // Both passes run along the slow axis, where runs of neighbours share their weights.
    transpose(samples, columns, lines);
    wide.resize(across.len() * rows * parts::<T>(), 0.0);
    let wide: &mut [T] = bytemuck::cast_slice_mut(wide);
    resample(lines, across, wide, rows);
    transpose(wide, rows, lines);
    resample(lines, up, pixels, across.len());
}

/// Interpolates lines of `length` values (padded to [`stride`]), one per sample, to one line per pixel.
fn resample<T: Value>(samples: &[Aligned], resampling: &Resampling, pixels: &mut [T], length: usize) {
    /// Pixels per task: most share their samples, which then stay in the fastest cache.
    const PIXELS: usize = 32;
    /// f32 of a line processed together.
    const RUN: usize = 256;
    let samples: &[f32] = bytemuck::cast_slice(samples);
    let (stride, length) = (stride::<T>(length), length * parts::<T>());
    let pixels: &mut [f32] = bytemuck::cast_slice_mut(pixels);
    pixels.par_chunks_mut(PIXELS * length).enumerate().for_each(|(task, lines)| {
        let pixels = task * PIXELS..task * PIXELS + lines.len() / length;
        for start in (0..length).step_by(RUN) {
            let count = RUN.min(length - start);
            let mut pixel = pixels.start;
            while pixel < pixels.end {
                let rows = resampling.alike(pixel, pixels.end);
                let (first, weights) = resampling.of(pixel, rows);
                let to = (pixel - pixels.start) * length + start;
                cpu::weighted_sums(
                    rows,
                    &Lines { values: &samples[first * stride + start..], stride, weights },
                    &mut Rows { values: &mut lines[to..], stride: length, length: count },
                );
                pixel += rows;
            }
        }
    });
}

/// Stride (f32) of lines of `length` values: lines a power of two apart would collide in the cache, and unaligned
/// lines would be read in two pieces.
fn stride<T: Value>(length: usize) -> usize {
    (length * parts::<T>()).next_multiple_of(ALIGNED) + ALIGNED
}

/// Columns as lines.
fn transpose<T: Value>(values: &[T], columns: usize, lines: &mut Vec<Aligned>) {
    /// A square of values stays in the nearest cache.
    const SIDE: usize = 16;
    let rows = values.len() / columns;
    let floats = stride::<T>(rows);
    lines.resize(columns * floats / ALIGNED, Aligned::zeroed());
    let lines: &mut [T] = bytemuck::cast_slice_mut(lines);
    let stride = floats / parts::<T>();
    lines.par_chunks_mut(SIDE * stride).enumerate().for_each(|(task, lines)| {
        for first in (0..rows).step_by(SIDE) {
            for (offset, line) in lines.chunks_exact_mut(stride).enumerate() {
                for row in first..rows.min(first + SIDE) {
                    line[row] = values[row * columns + task * SIDE + offset];
                }
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn some_pixels_have_the_weights_that_they_have_among_all() {
        let whole = Resampling::new((0..30).map(|i| 3.0 + 0.37 * f64::from(i)), 3, 5.0);
        for pixels in [0..30, 4..9, 17..30, 8..8] {
            let part = whole.part(pixels.clone());
            assert_eq!(part.len(), pixels.len());
            for (own, pixel) in pixels.enumerate() {
                assert_eq!(part.of(own, 1), whole.of(pixel, 1), "{pixel}");
            }
        }
    }

    #[test]
    fn a_wave_within_the_band_is_met_and_one_beyond_is_not() {
        // Half-width 8 and β = 12 pass 0.5 - 12/(16 π) = 0.26 cycles per sample.
        let positions = |i: usize| 7.0 + 0.113 * i as f64;
        let resampling = Resampling::new((0..200).map(positions), 8, 12.0);
        let worst = |cycles: f64| {
            let at = |position: f64| (TAU * cycles * position).cos();
            let off = |pixel: usize| {
                let (first, weights) = resampling.of(pixel, 1);
                let sum: f64 =
                    weights.iter().enumerate().map(|(i, w)| f64::from(*w) * at((first + i) as f64)).sum();
                (sum - at(positions(pixel))).abs()
            };
            (0..200).map(off).fold(0.0, f64::max)
        };
        assert!(worst(0.0) < 1e-5 && worst(0.13) < 1e-5 && worst(0.25) < 1e-5, "{}", worst(0.25));
        assert!(worst(0.45) > 1e-2);
    }

    #[test]
    fn the_slope_of_a_wave_within_the_band_is_met() {
        let positions = |i: usize| 7.0 + 0.113 * i as f64;
        let slopes = Resampling::slopes((0..200).map(positions), 8, 12.0);
        for cycles in [0.0, 0.13, 0.25] {
            let off = |pixel: usize| {
                let (first, weights) = slopes.of(pixel, 1);
                let at = |i: usize| (TAU * cycles * (first + i) as f64).cos();
                let sum: f64 = weights.iter().enumerate().map(|(i, w)| f64::from(*w) * at(i)).sum();
                (sum + TAU * cycles * (TAU * cycles * positions(pixel)).sin()).abs()
            };
            let worst = (0..200).map(off).fold(0.0, f64::max);
            assert!(worst < 3e-5, "{cycles}: {worst}");
        }
    }

    #[test]
    fn a_plane_of_samples_comes_out_as_many_pixels_across_and_up() {
        let wave = |x: f64, y: f64| {
            Complex32::new((0.3 * x + 0.5 * y).cos() as f32, (0.2 * x - 0.4 * y).sin() as f32)
        };
        let (columns, rows) = (40, 30);
        let samples: Vec<_> =
            (0..columns * rows).map(|i| wave((i % columns) as f64, (i / columns) as f64)).collect();
        let place = |i: usize| 7.0 + 0.15 * i as f64;
        let (width, height) = (131, 77);
        let across = Resampling::new((0..width).map(place), 8, 12.0);
        let up = Resampling::new((0..height).map(place), 8, 12.0);
        let mut pixels = vec![Complex32::ZERO; width * height];
        interpolate(&samples, columns, &across, &up, &mut Between::default(), &mut pixels);
        let real: Vec<_> = samples.iter().map(|sample| sample.re).collect();
        let mut values = vec![0.0; width * height];
        interpolate(&real, columns, &across, &up, &mut Between::default(), &mut values);
        for (i, (pixel, value)) in pixels.iter().zip(&values).enumerate() {
            assert!((pixel - wave(place(i % width), place(i / width))).norm() < 1e-5, "pixel {i}");
            assert!((pixel.re - value).abs() < 1e-6, "pixel {i}");
        }
    }
}
