//! Linear equations with a real, symmetric, positive definite matrix, by Cholesky's factors.

use std::ops::Range;

use crate::simd::{Instructions, Isa, Kernel, accumulate, accumulate_product, total};

/// Columns processed together.
const BLOCK: usize = 16;
/// Rows of the factor that are applied to a later row in one pass.
const PANEL: usize = 8;

/// The factor U of a matrix Uᵀ U: its upper triangle, by rows of whole blocks. Numbers below the diagonal have no
/// meaning.
#[derive(Clone, Debug)]
pub struct Factor {
    size: usize,
    /// Blocks of a row.
    stride: usize,
    values: Vec<[f64; BLOCK]>,
}

impl Factor {
    /// The factor of the matrix with these entries on and above the diagonal; `None` if it is not positive definite.
    pub fn new(size: usize, entry: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let stride = size.div_ceil(BLOCK);
        let mut factor = Self { size, stride, values: vec![[0.0; BLOCK]; size * stride] };
        for row in 0..size {
            for column in row..size {
                factor.values[row * stride + column / BLOCK][column % BLOCK] = entry(row, column);
            }
        }
        Isa::best().run(Decompose(&mut factor)).then_some(factor)
    }

    /// x with Uᵀ U x = b.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        Isa::best().run(Substitute { factor: self, b })
    }

    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.stride + column / BLOCK][column % BLOCK]
    }

    /// A row from the block that holds a column.
    #[inline(always)]
    fn row(&self, row: usize, column: usize) -> &[[f64; BLOCK]] {
        &self.values[row * self.stride + column / BLOCK..(row + 1) * self.stride]
    }
}

struct Decompose<'a>(&'a mut Factor);

impl Kernel for Decompose<'_> {
    /// Whether the matrix is positive definite.
    type Output = bool;

    #[inline(always)]
    fn run<I: Instructions>(self) -> bool {
        let Self(factor) = self;
        let (size, stride) = (factor.size, factor.stride);
        for first in (0..size).step_by(PANEL) {
            let after = (first + PANEL).min(size);
            for row in first..after {
                let pivot = factor.at(row, row);
                // NaN is not above 0 either.
                if !(pivot > 0.0 && pivot.is_finite()) {
                    return false;
                }
                let root = pivot.sqrt();
                let own = row * stride + row / BLOCK..(row + 1) * stride;
                factor.values[own].iter_mut().flatten().for_each(|value| *value /= root);
                deduct::<I>(factor, row..row + 1, row + 1..after);
            }
            deduct::<I>(factor, first..after, after..size);
        }
        true
    }
}

/// Takes the products of finished rows from later ones.
#[inline(always)]
fn deduct<I: Instructions>(factor: &mut Factor, finished: Range<usize>, later: Range<usize>) {
    let stride = factor.stride;
    for row in later {
        let (done, to) = factor.values.split_at_mut(row * stride);
        let skip = row / BLOCK;
        let mut factors = [0.0; PANEL];
        for (to, from) in factors.iter_mut().zip(finished.clone()) {
            *to = -done[from * stride + skip][row % BLOCK];
        }
        for (index, to) in (skip..).zip(&mut to[skip..stride]) {
            // A local copy, since possible aliasing prevents vectorisation.
            let mut sum = *to;
            for (factor, from) in factors.iter().zip(finished.clone()) {
                accumulate::<I, BLOCK>(&mut sum, &done[from * stride + index], *factor);
            }
            *to = sum;
        }
    }
}

struct Substitute<'a> {
    factor: &'a Factor,
    b: &'a [f64],
}

impl Kernel for Substitute<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Vec<f64> {
        let Self { factor, b } = self;
        let mut rest = vec![[0.0; BLOCK]; factor.stride];
        rest.as_flattened_mut()[..factor.size].copy_from_slice(b);
        let mut y = vec![0.0; factor.size];
        for (row, y) in y.iter_mut().enumerate() {
            *y = rest.as_flattened()[row] / factor.at(row, row);
            for (rest, values) in rest[row / BLOCK..].iter_mut().zip(factor.row(row, row)) {
                accumulate::<I, BLOCK>(rest, values, -*y);
            }
        }
        // Unknowns are zero until they are solved for.
        let mut x = vec![[0.0; BLOCK]; factor.stride];
        for row in (0..factor.size).rev() {
            let mut sum = [0.0; BLOCK];
            for (x, values) in x[row / BLOCK..].iter().zip(factor.row(row, row)) {
                accumulate_product::<I, BLOCK>(&mut sum, values, x);
            }
            x.as_flattened_mut()[row] = (y[row] - total(&sum)) / factor.at(row, row);
        }
        x.as_flattened()[..factor.size].to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_gives_back_the_right_side() {
        // Within a panel and a block, whole ones, and more.
        for size in [1, 2, 5, 8, 9, 16, 17, 33, 100] {
            let unit = |index: usize| ((index + 1) as f64 * 0.618_033_988).fract() - 0.5;
            let row = |i: usize| (0..size).map(move |k| unit(i * size + k));
            let entry = |i: usize, j: usize| {
                row(i).zip(row(j)).map(|(a, b)| a * b).sum::<f64>() + f64::from(u8::from(i == j))
            };
            for scale in [1e-150, 1.0, 1e150] {
                let b: Vec<_> = (0..size).map(|i| unit(3 * i)).collect();
                let x = Factor::new(size, |i, j| entry(i, j) * scale).unwrap().solve(&b);
                assert_eq!(x.len(), size);
                for (i, b) in b.iter().enumerate() {
                    let got = x.iter().enumerate().map(|(j, x)| entry(i, j) * scale * x).sum::<f64>();
                    assert!((got - b).abs() < 1e-12, "{size}, {scale}: {got} is not {b}");
                }
            }
        }
    }

    #[test]
    fn only_a_positive_definite_matrix_has_a_factor() {
        for value in [0.0, -1.0, 0.25, f64::NAN, f64::INFINITY] {
            // Within a panel and last; the determinant of two of the rows is value - 1/4.
            for at in [11, 19] {
                let entry = |i: usize, j: usize| match (i, j) {
                    (0, j) if j == at => 0.5,
                    (i, j) if i != j => 0.0,
                    (i, _) if i == at => value,
                    _ => 1.0,
                };
                assert!(Factor::new(20, entry).is_none(), "{value} at {at}");
            }
        }
    }
}
