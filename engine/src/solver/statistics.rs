//! Mean, spread and evenness of pressures.

pub fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

pub fn mean_square(values: &[f64]) -> f64 {
    mean(values.iter().map(|value| value * value))
}

/// Standard deviation over mean.
pub fn spread(values: &[f64]) -> f64 {
    let mean = mean(values.iter().copied());
    let variance = self::mean(values.iter().map(|value| (value - mean).powi(2)));
    variance.sqrt() / mean.max(f64::MIN_POSITIVE)
}

/// Least over mean.
pub fn evenness(values: &[f64]) -> f64 {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    least / mean(values.iter().copied()).max(f64::MIN_POSITIVE)
}
