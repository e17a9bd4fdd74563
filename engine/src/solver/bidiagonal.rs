//! Singular values of a real bidiagonal matrix by implicit QR iteration.
//!
//! Golub and Kahan's shifted sweeps, and Demmel and Kahan's sweep without a shift where a value is next to zero (SIAM
//! J. Sci. Stat. Comput. 11:873, 1990).

use std::ops::Range;

use num_complex::Complex64;

use crate::gauge;

/// B with its singular values, of either sign, on the diagonal once it is diagonal.
#[derive(Clone, Debug)]
pub struct Bidiagonal {
    pub diagonal: Vec<f64>,
    /// Above the diagonal: one number fewer.
    pub upper: Vec<f64>,
}

/// A rotation of two neighbouring numbers of a vector.
#[derive(Clone, Copy, Debug)]
pub struct Rotation {
    at: usize,
    cos: f64,
    sin: f64,
}

impl Rotation {
    /// The rotation of (f, g) to (r, 0), and r.
    fn new(at: usize, f: f64, g: f64) -> (Self, f64) {
        /// Least sum of squares with all its digits.
        const FAINTEST: f64 = 1e-280;
        let power = f * f + g * g;
        if power < FAINTEST {
            return (Self { at, cos: 1.0, sin: 0.0 }, f);
        }
        let r = power.sqrt();
        (Self { at, cos: f / r, sin: g / r }, r)
    }

    fn apply(self, x: &mut [Complex64]) {
        let (a, b) = (x[self.at], x[self.at + 1]);
        (x[self.at], x[self.at + 1]) = (a * self.cos + b * self.sin, b * self.cos - a * self.sin);
    }

    pub fn undo(self, x: &mut [Complex64]) {
        Self { sin: -self.sin, ..self }.apply(x);
    }
}

impl Bidiagonal {
    /// Makes B diagonal. Rotations from the left are applied to b; those from the right are returned in their order.
    ///
    /// `None` if it is cancelled, or does not converge, which is known of no matrix of finite numbers.
    pub fn diagonalise(&mut self, b: &mut [Complex64]) -> Option<Vec<Rotation>> {
        /// Sweeps per value; three are many.
        const SWEEPS: usize = 60;
        let Self { diagonal, upper } = self;
        let largest =
            diagonal.iter().chain(&*upper).fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let negligible = f64::EPSILON * largest;
        let mut rotations = Vec::new();
        let mut last = diagonal.len().saturating_sub(1);
        for _ in (0..SWEEPS * diagonal.len()).take_while(|_| !gauge::is_cancelled()) {
            while last > 0 && upper[last - 1].abs() <= negligible {
                last -= 1;
            }
            if last == 0 {
                return Some(rotations);
            }
            let first = (0..last).rev().find(|&i| upper[i].abs() <= negligible).map_or(0, |i| i + 1);
            let block = &diagonal[first..=last];
            let shift = smaller(diagonal[last - 1], upper[last - 1], diagonal[last]);
            let is_singular = block.iter().any(|value| value.abs() <= negligible);
            if is_singular || (shift / diagonal[first]).powi(2) < f64::EPSILON {
                plain(diagonal, upper, first..last, b, &mut rotations);
            } else {
                shifted(diagonal, upper, first..last, shift, b, &mut rotations);
            }
        }
        None
    }
}

/// The smaller singular value of a triangle of two rows.
fn smaller(first: f64, upper: f64, second: f64) -> f64 {
    let (a, b) = (first.abs(), second.abs());
    let power = |difference: f64| (difference * difference + upper * upper).sqrt();
    let larger = 0.5 * (power(a + b) + power(a - b));
    if larger > 0.0 { a / larger * b } else { 0.0 }
}

/// A sweep over the block of these rows and the one after, its shift near a singular value.
fn shifted(
    d: &mut [f64],
    e: &mut [f64],
    rows: Range<usize>,
    shift: f64,
    b: &mut [Complex64],
    rotations: &mut Vec<Rotation>,
) {
    let first = rows.start;
    let mut f = (d[first].abs() - shift) * (d[first].signum() + shift / d[first]);
    let mut g = e[first];
    for i in rows.clone() {
        let (right, r) = Rotation::new(i, f, g);
        if i > first {
            e[i - 1] = r;
        }
        f = right.cos * d[i] + right.sin * e[i];
        e[i] = right.cos * e[i] - right.sin * d[i];
        g = right.sin * d[i + 1];
        d[i + 1] *= right.cos;
        let (left, r) = Rotation::new(i, f, g);
        d[i] = r;
        f = left.cos * e[i] + left.sin * d[i + 1];
        d[i + 1] = left.cos * d[i + 1] - left.sin * e[i];
        if i + 1 < rows.end {
            g = left.sin * e[i + 1];
            e[i + 1] *= left.cos;
        }
        left.apply(b);
        rotations.push(right);
    }
    e[rows.end - 1] = f;
}

/// The same without a shift, in which values next to zero keep their digits.
fn plain(
    d: &mut [f64],
    e: &mut [f64],
    rows: Range<usize>,
    b: &mut [Complex64],
    rotations: &mut Vec<Rotation>,
) {
    let (first, last) = (rows.start, rows.end);
    let (mut cos, mut before) = (1.0, Rotation { at: first, cos: 1.0, sin: 0.0 });
    for i in rows {
        let (right, r) = Rotation::new(i, d[i] * cos, e[i]);
        if i > first {
            e[i - 1] = before.sin * r;
        }
        let (left, r) = Rotation::new(i, before.cos * r, d[i + 1] * right.sin);
        d[i] = r;
        left.apply(b);
        rotations.push(right);
        (cos, before) = (right.cos, left);
    }
    let corner = d[last] * cos;
    d[last] = corner * before.cos;
    e[last - 1] = corner * before.sin;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hard() -> Vec<(&'static str, Bidiagonal)> {
        let of = |count: i32, diagonal: &dyn Fn(i32) -> f64, upper: &dyn Fn(i32) -> f64| Bidiagonal {
            diagonal: (0..count).map(diagonal).collect(),
            upper: (1..count).map(upper).collect(),
        };
        vec![
            ("one", of(1, &|_| -2.0, &|_| 0.0)),
            ("nothing", of(5, &|_| 0.0, &|_| 0.0)),
            ("equal", of(40, &|_| 1.0, &|_| 1.0)),
            ("above alone", of(20, &|_| 0.0, &|_| 1.0)),
            ("tiny below", of(30, &|_| 1e-9, &|_| 1.0)),
            ("falling", of(60, &|i| 10f64.powi(-5 * i), &|i| 10f64.powi(-5 * i))),
            ("rising", of(60, &|i| 10f64.powi(5 * i - 295), &|i| 10f64.powi(5 * i - 295))),
            ("falling gently", of(60, &|i| 0.6f64.powi(i), &|i| 0.6f64.powi(i))),
            ("rising gently", of(60, &|i| 0.6f64.powi(60 - i), &|i| 0.6f64.powi(60 - i))),
            ("zero inside", of(15, &|i| f64::from(i % 4), &|i| f64::from(i % 3))),
            ("zero first", of(15, &|i| f64::from(i), &|_| 0.5)),
            ("zero last", of(15, &|i| f64::from(14 - i), &|_| 0.5)),
            ("signs", of(15, &|i| (-1.3f64).powi(i), &|i| (-1.1f64).powi(i + 1))),
        ]
    }

    #[test]
    fn rotations_and_values_give_back_the_matrix() {
        for (name, before) in hard() {
            let (count, mut after) = (before.diagonal.len(), before.clone());
            // The rotations from the left, by their columns.
            let unit = |j: usize| (0..count).map(|i| Complex64::from(f64::from(u8::from(i == j)))).collect();
            let mut left: Vec<Vec<Complex64>> = (0..count).map(unit).collect();
            let mut rotations = Vec::new();
            for column in &mut left {
                after = before.clone();
                rotations = after.diagonalise(column).unwrap_or_else(|| panic!("{name} does not converge"));
            }
            let largest = before.diagonal.iter().chain(&before.upper).fold(0.0, |l: f64, v| l.max(v.abs()));
            assert!(after.upper.iter().all(|value| value.abs() <= f64::EPSILON * largest), "{name}");
            let mut right: Vec<Vec<Complex64>> = (0..count).map(unit).collect();
            for vector in &mut right {
                rotations.iter().rev().for_each(|rotation| rotation.undo(vector));
            }
            for i in 0..count {
                for j in 0..count {
                    let expected = match j.checked_sub(i) {
                        Some(0) => before.diagonal[i],
                        Some(1) => before.upper[i],
                        _ => 0.0,
                    };
                    let parts = (0..count).map(|k| left[i][k].re * after.diagonal[k] * right[k][j].re);
                    let error = (parts.sum::<f64>() - expected).abs();
                    assert!(error <= 2e-14 * largest, "{name}: {error} at {i}, {j}");
                    let product = (0..count).map(|k| right[i][k].re * right[j][k].re).sum::<f64>();
                    assert!((product - f64::from(u8::from(i == j))).abs() < 1e-13, "{name}: not orthonormal");
                }
            }
        }
    }

    #[test]
    fn few_sweeps_are_enough() {
        for (name, mut matrix) in hard() {
            let count = matrix.diagonal.len();
            let rotations = matrix.diagonalise(&mut vec![Complex64::ZERO; count]).unwrap();
            assert!(rotations.len() <= 3 * count * count, "{name}: {} for {count}", rotations.len());
        }
    }
}
