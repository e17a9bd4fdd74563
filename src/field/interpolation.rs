//! From samples to pixels along one axis: a Kaiser-windowed sinc.

use std::f64::consts::PI;

use num_complex::Complex32;
use rayon::prelude::*;

use crate::field::cpu;

/// For every pixel along an axis, the first of the samples it is made of and their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampling {
    /// Samples per pixel.
    pub taps: usize,
    pub first: Vec<u32>,
    /// `taps` per pixel.
    pub weights: Vec<f32>,
}

impl Resampling {
    /// `positions` of the pixels in samples, none below `half_width` - 1; a window of 2 `half_width` taps and shape β.
    pub fn new(positions: impl Iterator<Item = f64>, half_width: usize, beta: f64) -> Self {
        let taps = 2 * half_width;
        let (mut first, mut weights) = (Vec::new(), Vec::new());
        for position in positions {
            // Rounding may put the first pixel a hair before its sample.
            let below = (position + 1e-9).floor().max((half_width - 1) as f64);
            let start = below as usize - (half_width - 1);
            first.push(start as u32);
            weights.extend(
                (0..taps).map(|tap| kernel(position - (start + tap) as f64, half_width as f64, beta) as f32),
            );
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

    fn of(&self, pixel: usize) -> (usize, &[f32]) {
        (self.first[pixel] as usize, &self.weights[pixel * self.taps..(pixel + 1) * self.taps])
    }
}

/// sinc(x) times the Kaiser window of half-width K at x.
fn kernel(x: f64, half_width: f64, beta: f64) -> f64 {
    let inside = 1.0 - (x / half_width).powi(2);
    if inside <= 0.0 {
        return 0.0;
    }
    let sinc = if x.abs() < 1e-9 { 1.0 } else { (PI * x).sin() / (PI * x) };
    sinc * bessel_i0(beta * inside.sqrt()) / bessel_i0(beta)
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

/// Interpolates samples (row by row, `columns` in a row) across and up; the pixels come out row by row.
pub fn interpolate(
    samples: &[Complex32],
    columns: usize,
    across: &Resampling,
    up: &Resampling,
) -> Vec<Complex32> {
    let rows = samples.len() / columns;
    // Both passes work along the slow axis, where whole runs of neighbours share their weights.
    let wide = resample(&transposed(samples, columns), rows, across);
    resample(&transposed(&wide, rows), across.len(), up)
}

/// From lines of `length` values to one line per pixel.
fn resample(lines: &[Complex32], length: usize, resampling: &Resampling) -> Vec<Complex32> {
    let mut pixels = vec![Complex32::ZERO; resampling.len() * length];
    pixels.par_chunks_mut(length).enumerate().for_each(|(pixel, line)| {
        let (first, weights) = resampling.of(pixel);
        weighted_sum(&lines[first * length..(first + weights.len()) * length], weights, line);
    });
    pixels
}

/// The sum of as many lines as there are weights.
fn weighted_sum(lines: &[Complex32], weights: &[f32], sum: &mut [Complex32]) {
    let length = sum.len();
    let (lines, sum): (&[f32], &mut [f32]) = (bytemuck::cast_slice(lines), bytemuck::cast_slice_mut(sum));
    cpu::weighted_sum(lines, 2 * length, weights, sum);
}

fn transposed(values: &[Complex32], columns: usize) -> Vec<Complex32> {
    let rows = values.len() / columns;
    (0..columns).flat_map(|column| (0..rows).map(move |row| values[row * columns + column])).collect()
}
