//! Gauss's rule of integration.

use std::f64::consts::PI;

/// Nodes in [-1, 1] and weights of Gauss's rule: Newton's method on the roots of Legendre's polynomial.
pub fn legendre(count: usize) -> Vec<(f64, f64)> {
    let polynomial = |x: f64| {
        let (mut before, mut this) = (1.0, x);
        for n in 1..count {
            let n = n as f64;
            (before, this) = (this, ((2.0 * n + 1.0) * x * this - n * before) / (n + 1.0));
        }
        (this, count as f64 * (x * this - before) / (x * x - 1.0))
    };
    let root = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        for _ in 0..6 {
            let (value, slope) = polynomial(x);
            x -= value / slope;
        }
        let slope = polynomial(x).1;
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(root).collect()
}
