//! Normal equations of least squares: JᵀJ and Jᵀr of some thousand readings and some hundred unknowns.
//!
//! The Jacobian is kept by blocks of columns, so that the product of two blocks runs through consecutive memory.

use rayon::prelude::*;

use crate::simd::{Instructions, Isa, Kernel, accumulate};
use crate::solver::cholesky::Factor;

/// Columns of a block.
pub const BLOCK: usize = 8;
/// Rows of a product that are summed in registers at once.
const STRIP: usize = 4;

/// A block of columns of the Jacobian: the values of each reading.
pub type Columns = Vec<[f64; BLOCK]>;

/// JᵀJ, Jᵀr and rᵀr.
#[derive(Clone, Debug)]
pub struct Equations {
    pub size: usize,
    /// Rows of the upper triangle, with meaningless numbers below it.
    matrix: Vec<f64>,
    pub right: Vec<f64>,
}

impl Equations {
    /// The first `size` columns; `residual` has a value per row.
    pub fn new(columns: &[Columns], size: usize, residual: &[f64]) -> Self {
        let blocks = size.div_ceil(BLOCK);
        let pairs: Vec<_> =
            (0..blocks).flat_map(|row| (row..blocks).map(move |column| (row, column))).collect();
        let tile = |&(row, column): &(usize, usize)| {
            Isa::best().run(Product { left: &columns[row], right: &columns[column] })
        };
        let tiles: Vec<_> = pairs.par_iter().with_min_len(16).map(tile).collect();
        let mut matrix = vec![0.0; size * size];
        for (&(row, column), tile) in pairs.iter().zip(&tiles) {
            for (i, values) in (row * BLOCK..size).zip(tile) {
                for (j, value) in (column * BLOCK..size).zip(values) {
                    matrix[i * size + j] = *value;
                }
            }
        }
        let sums = |block: &Columns| {
            let mut sum = [0.0; BLOCK];
            for (values, r) in block.iter().zip(residual) {
                values.iter().zip(&mut sum).for_each(|(value, sum)| *sum += value * r);
            }
            sum
        };
        let mut right: Vec<_> = columns[..blocks].par_iter().flat_map_iter(sums).collect();
        right.truncate(size);
        Self { size, matrix, right }
    }

    /// Adds an observation of one unknown: its weight, and how much more than its present value was observed.
    pub fn observe(&mut self, unknown: usize, weight: f64, off: f64) {
        self.matrix[unknown * self.size + unknown] += weight;
        self.right[unknown] += weight * off;
    }

    /// An entry on or above the diagonal.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.matrix[row * self.size + column]
    }

    /// The equations of the first unknowns.
    pub fn factor(&self, size: usize, damping: f64) -> Option<Factor> {
        // An unknown that no reading tells of stays where it is.
        let least = (0..size).map(|i| self.at(i, i)).fold(0.0, f64::max) * f64::EPSILON;
        let entry = |i: usize, j: usize| match i == j {
            true => self.at(i, i) * (1.0 + damping) + least,
            false => self.at(i, j),
        };
        Factor::new(size, entry)
    }
}

struct Product<'a> {
    left: &'a Columns,
    right: &'a Columns,
}

impl Kernel for Product<'_> {
    type Output = [[f64; BLOCK]; BLOCK];

    #[inline(always)]
    fn run<I: Instructions>(self) -> Self::Output {
        let mut tile = [[0.0; BLOCK]; BLOCK];
        for (strip, to) in tile.as_chunks_mut::<STRIP>().0.iter_mut().enumerate() {
            let mut sums = [[0.0; BLOCK]; STRIP];
            for (left, right) in self.left.iter().zip(self.right) {
                for (row, sum) in sums.iter_mut().enumerate() {
                    accumulate::<I, BLOCK>(sum, right, left[strip * STRIP + row]);
                }
            }
            *to = sums;
        }
        tile
    }
}
