//! Polynomial approximations of smooth functions.

use std::f64::consts::PI;

/// The coefficients of the Chebyshev polynomials of the polynomial that meets `f` at the Chebyshev nodes of [-1, 1].
pub fn chebyshev(f: impl Fn(f64) -> f64, terms: usize) -> Vec<f64> {
    let node = |i: usize| PI * (i as f64 + 0.5) / terms as f64;
    let values: Vec<_> = (0..terms).map(|i| f(node(i).cos())).collect();
    let coefficient = |order: usize| {
        let sum: f64 =
            values.iter().enumerate().map(|(i, value)| value * (order as f64 * node(i)).cos()).sum();
        sum * if order == 0 { 1.0 } else { 2.0 } / terms as f64
    };
    (0..terms).map(coefficient).collect()
}

/// The polynomial (lowest coefficient first) that meets `f` at the Chebyshev nodes of [-1, 1].
pub fn fit(f: impl Fn(f64) -> f64, terms: usize) -> Vec<f64> {
    let (mut power, mut before, mut now) = (vec![0.0; terms], vec![0.0; terms], vec![0.0; terms]);
    now[0] = 1.0;
    for (order, weight) in chebyshev(f, terms).into_iter().enumerate() {
        for (coefficient, chebyshev) in power.iter_mut().zip(&now) {
            *coefficient += weight * chebyshev;
        }
        // T(n+1) = 2 s T(n) - T(n-1), and T(1) = s.
        let twice = if order == 0 { 1.0 } else { 2.0 };
        let next = (0..terms).map(|i| if i == 0 { 0.0 } else { twice * now[i - 1] } - before[i]).collect();
        before = std::mem::replace(&mut now, next);
    }
    power
}

/// The polynomial's value at `s`.
pub fn evaluate(coefficients: &[f64], s: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * s + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_function_is_met_between_the_nodes() {
        let fitted = fit(f64::exp, 14);
        for i in -50..=50 {
            let s = f64::from(i) / 50.0;
            assert!((evaluate(&fitted, s) - s.exp()).abs() < 1e-13, "{s}");
        }
    }
}
