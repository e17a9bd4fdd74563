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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_are_those_of_a_known_row() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        assert!((mean(values.into_iter()) - 3.0).abs() < 1e-15);
        assert!((mean_square(&values) - 11.0).abs() < 1e-12);
        assert!((spread(&values) - 2f64.sqrt() / 3.0).abs() < 1e-15);
        assert!((evenness(&values) - 1.0 / 3.0).abs() < 1e-15);
    }
}
