//! Splits values in two parts at the threshold with the largest variance between them (Otsu 1979), and tells whether
//! the parts are distinct.

use std::ops::Range;

/// Bins of a histogram from 0 to 1.
const BINS: usize = 256;

/// Two parts of values from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// Halfway between the means: where a blurred edge was.
    pub threshold: f32,
    /// Between the means.
    pub contrast: f64,
    /// Variance between the parts, of all, as if both had as many values: 0.64 for normally, 0.75 for uniformly
    /// distributed values, 1 for two values.
    pub separation: f64,
    /// Upper quartile of the lower part.
    pub quartile: f64,
}

impl Split {
    pub fn new(values: &[f32]) -> Self {
        let mut histogram = [0.0f64; BINS];
        let bin = |value: f32| ((value * BINS as f32) as usize).min(BINS - 1);
        values.iter().for_each(|value| histogram[bin(*value)] += 1.0);
        let place = threshold(&histogram);
        let (count, low, low_variance) = part(&histogram, 0..place);
        let (_, high, high_variance) = part(&histogram, place..BINS);
        let contrast = high - low;
        let mut left = 0.75 * count;
        let is_quartile = |count: &f64| {
            left -= count;
            left <= 0.0
        };
        Self {
            threshold: ((low + high) / 2.0) as f32,
            contrast,
            separation: contrast.powi(2) / (contrast.powi(2) + 2.0 * (low_variance + high_variance)),
            quartile: histogram.iter().position(is_quartile).map_or(1.0, level),
        }
    }
}

fn level(bin: usize) -> f64 {
    (bin as f64 + 0.5) / BINS as f64
}

/// Number, mean and variance of values in bins.
fn part(histogram: &[f64; BINS], bins: Range<usize>) -> (f64, f64, f64) {
    let moment = |power: i32| bins.clone().map(|bin| histogram[bin] * level(bin).powi(power)).sum::<f64>();
    let count = moment(0).max(f64::MIN_POSITIVE);
    let mean = moment(1) / count;
    (count, mean, (moment(2) / count - mean * mean).max(0.0))
}

/// The first bin of the higher part.
fn threshold(histogram: &[f64; BINS]) -> usize {
    let (count, mean, _) = part(histogram, 0..BINS);
    let (mut best, mut most, mut below, mut sum) = (BINS, 0.0, 0.0, 0.0);
    for (bin, values) in histogram.iter().enumerate().take(BINS - 1) {
        below += values / count;
        sum += level(bin) * values / count;
        let between = (mean * below - sum).powi(2) / (below * (1.0 - below));
        if below < 1.0 && between > most {
            (best, most) = (bin + 1, between);
        }
    }
    best
}
