//! Ticks along an axis.

pub use crate::picture::figure::axes::signed;

/// Multiples of `step` from `low` to `high`; no more than a hundred.
pub fn between(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last.min(first.saturating_add(100))).map(move |i| i as f64 * step)
}

/// Decimals that distinguish multiples of a round step.
pub fn decimals(step: f64) -> usize {
    (-step.log10().floor()).clamp(0.0, 6.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_inside_and_told_apart() {
        assert_eq!(between(-0.7, 1.1, 0.5).collect::<Vec<_>>(), [-0.5, 0.0, 0.5, 1.0]);
        assert_eq!(["-0.0 dB", "-12 mm", "3"].map(signed), ["0.0 dB", "−12 mm", "3"]);
        assert_eq!([100.0, 1.0, 0.5, 0.02].map(decimals), [0, 0, 1, 2]);
    }
}
