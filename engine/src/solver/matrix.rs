//! Complex matrices by rows, and Householder reflections of rows, the inner loops of the singular values.
//!
//! As in `Transfer`, real and imaginary parts are stored separately and rows are padded with zeros to whole blocks.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::gauge;
use crate::simd::{Instructions, Isa, Kernel, accumulate, accumulate_product, deduct_product, total};

/// Rows are padded to a multiple of it.
pub const BLOCK: usize = 16;
/// Reflections applied to a row at once.
const PANEL: usize = 4;

/// A row from the block on that holds some column.
pub type Row<'a> = (&'a [f64], &'a [f64]);
pub type RowMut<'a> = (&'a mut [f64], &'a mut [f64]);

#[derive(Clone, Debug)]
pub struct Matrix {
    pub rows: usize,
    pub columns: usize,
    /// Values from one row to the next: the columns, and zeros.
    stride: usize,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Matrix {
    pub fn zeros(rows: usize, columns: usize) -> Self {
        let stride = columns.next_multiple_of(BLOCK);
        Self { rows, columns, stride, re: vec![0.0; rows * stride], im: vec![0.0; rows * stride] }
    }

    pub fn from_fn(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> Complex64) -> Self {
        let mut matrix = Self::zeros(rows, columns);
        for row in 0..rows {
            (0..columns).for_each(|column| matrix.set(row, column, entry(row, column)));
        }
        matrix
    }

    pub fn at(&self, row: usize, column: usize) -> Complex64 {
        let index = row * self.stride + column;
        Complex64::new(self.re[index], self.im[index])
    }

    pub fn set(&mut self, row: usize, column: usize, value: Complex64) {
        let index = row * self.stride + column;
        (self.re[index], self.im[index]) = (value.re, value.im);
    }

    /// The conjugate transpose.
    pub fn adjoint(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |row, column| self.at(column, row).conj())
    }

    /// The largest modulus of a real or imaginary part; NaN or infinite if a number is.
    pub fn largest(&self) -> f64 {
        // The sum of zeros is NaN if a number is not finite.
        let parts = || self.re.iter().chain(&self.im);
        let largest =
            parts().fold(0.0, |largest: f64, part| if part.abs() > largest { part.abs() } else { largest });
        largest + parts().map(|part| part * 0.0).sum::<f64>()
    }

    pub fn scale(&mut self, factor: f64) {
        self.re.iter_mut().chain(&mut self.im).for_each(|part| *part *= factor);
    }

    #[inline(always)]
    pub fn row(&self, row: usize, column: usize) -> Row<'_> {
        let own = row * self.stride + start(column)..(row + 1) * self.stride;
        (&self.re[own.clone()], &self.im[own])
    }

    #[inline(always)]
    pub fn row_mut(&mut self, row: usize, column: usize) -> RowMut<'_> {
        let own = row * self.stride + start(column)..(row + 1) * self.stride;
        (&mut self.re[own.clone()], &mut self.im[own])
    }

    /// A row, and `COUNT` consecutive later ones to change.
    #[inline(always)]
    pub fn row_and_later<const COUNT: usize>(
        &mut self,
        row: usize,
        later: usize,
        column: usize,
    ) -> (Row<'_>, [RowMut<'_>; COUNT]) {
        let (stride, start) = (self.stride, start(column));
        let ((re, later_re), (im, later_im)) =
            (self.re.split_at_mut(later * stride), self.im.split_at_mut(later * stride));
        let own = row * stride + start..(row + 1) * stride;
        let mut rows = later_re.chunks_exact_mut(stride).zip(later_im.chunks_exact_mut(stride));
        let rows = std::array::from_fn(|_| {
            let (re, im) = rows.next().expect("as many rows follow");
            (&mut re[start..], &mut im[start..])
        });
        ((&re[own.clone()], &im[own]), rows)
    }

    /// Replaces a row by the reflection that turns its part from a column on into a single number, which is returned.
    /// The columns before become zero.
    #[inline(always)]
    pub fn make_reflection(&mut self, row: usize, column: usize) -> Complex64 {
        let (re, im) = self.row_mut(row, 0);
        re[..column].fill(0.0);
        im[..column].fill(0.0);
        let start = start(column);
        let mut power = [0.0; BLOCK];
        for part in [&re[start..], &im[start..]] {
            for part in part.as_chunks::<BLOCK>().0 {
                (0..BLOCK).for_each(|lane| power[lane] += part[lane] * part[lane]);
            }
        }
        let Reflection { result, lift, scale } =
            Reflection::new(Complex64::new(re[column], im[column]), total(&power));
        re[column] += lift.re;
        im[column] += lift.im;
        re[start..].iter_mut().chain(&mut im[start..]).for_each(|part| *part *= scale);
        result
    }

    /// A = L Q for no more rows than columns: the square lower triangle L. The rows become reflections, from column i on
    /// in row i; Q is their product from the last to the first.
    pub fn triangle(&mut self, isa: Isa) -> Self {
        /// Numbers per task.
        const PART: usize = 1 << 15;
        let mut triangle = Self::zeros(self.rows, self.rows);
        let part = PART.div_ceil(self.stride) * self.stride;
        for first in (0..self.rows).step_by(PANEL) {
            let after = (first + PANEL).min(self.rows);
            isa.run(Panel { matrix: self, triangle: &mut triangle, rows: first..after });
            if after == self.rows || gauge::is_cancelled() {
                break;
            }
            let stride = self.stride;
            let (re, rest_re) = self.re.split_at_mut(after * stride);
            let (im, rest_im) = self.im.split_at_mut(after * stride);
            let panel: [Row<'_>; PANEL] = std::array::from_fn(|i| {
                let own = (first + i) * stride + start(first)..(first + i + 1) * stride;
                (&re[own.clone()], &im[own])
            });
            let apply =
                |(re, im)| isa.run(Apply { panel: &panel, start: start(first), stride, rows: (re, im) });
            if rest_re.len() > part {
                rest_re.par_chunks_mut(part).zip(rest_im.par_chunks_mut(part)).for_each(apply);
            } else {
                apply((rest_re, rest_im));
            }
        }
        triangle
    }

    /// x ← H x for the reflection that a row has become from a column on.
    pub fn reflect(&self, row: usize, column: usize, x: &mut [Complex64]) {
        let entry = |n: usize| self.at(row, n);
        let along: Complex64 = (column..self.columns).map(|n| entry(n) * x[n]).sum();
        (column..self.columns).for_each(|n| x[n] -= entry(n).conj() * along);
    }
}

/// The first column of a column's block.
#[inline(always)]
pub fn start(column: usize) -> usize {
    column / BLOCK * BLOCK
}

/// A Householder reflection 1 - v v* that turns a vector x into a multiple of its first unit vector e;
/// v = (x + lift e) · scale.
#[derive(Clone, Copy, Debug)]
pub struct Reflection {
    pub result: Complex64,
    pub lift: Complex64,
    pub scale: f64,
}

impl Reflection {
    /// The reflection of x, from its first number and Σ|x|². If the squares underflow, x counts as zero.
    #[inline(always)]
    pub fn new(first: Complex64, power: f64) -> Self {
        /// Sums above it have all their digits.
        const FAINTEST: f64 = 1e-280;
        if power < FAINTEST {
            return Self { result: Complex64::ZERO, lift: Complex64::ZERO, scale: 0.0 };
        }
        let (norm, modulus) = (power.sqrt(), first.norm());
        let phase = if modulus > 0.0 { first / modulus } else { Complex64::ONE };
        let lift = phase * norm;
        Self { result: -lift, lift, scale: 1.0 / (norm * (norm + modulus)).sqrt() }
    }
}

/// Σ a b* in lanes.
#[derive(Clone, Copy, Debug)]
pub struct Sum<const LANES: usize> {
    re: [f64; LANES],
    im: [f64; LANES],
}

impl<const LANES: usize> Sum<LANES> {
    pub const ZERO: Self = Self { re: [0.0; LANES], im: [0.0; LANES] };

    #[inline(always)]
    pub fn add<I: Instructions>(
        &mut self,
        (a_re, a_im): (&[f64; LANES], &[f64; LANES]),
        (b_re, b_im): (&[f64; LANES], &[f64; LANES]),
    ) {
        accumulate_product::<I, LANES>(&mut self.re, a_re, b_re);
        accumulate_product::<I, LANES>(&mut self.re, a_im, b_im);
        accumulate_product::<I, LANES>(&mut self.im, a_im, b_re);
        deduct_product::<I, LANES>(&mut self.im, a_re, b_im);
    }

    #[inline(always)]
    pub fn total(&self) -> Complex64 {
        Complex64::new(total(&self.re), total(&self.im))
    }
}

/// to += a factor.
#[inline(always)]
pub fn add_block<I: Instructions, const LANES: usize>(
    (to_re, to_im): (&mut [f64; LANES], &mut [f64; LANES]),
    (a_re, a_im): (&[f64; LANES], &[f64; LANES]),
    factor: Complex64,
) {
    accumulate::<I, LANES>(to_re, a_re, factor.re);
    accumulate::<I, LANES>(to_im, a_re, factor.im);
    accumulate::<I, LANES>(to_re, a_im, -factor.im);
    accumulate::<I, LANES>(to_im, a_im, factor.re);
}

/// The same for rows.
#[inline(always)]
pub fn add<I: Instructions>(to: &mut RowMut<'_>, a: Row<'_>, factor: Complex64) {
    let to = to.0.as_chunks_mut::<8>().0.iter_mut().zip(to.1.as_chunks_mut::<8>().0);
    for ((re, im), a) in to.zip(a.0.as_chunks::<8>().0.iter().zip(a.1.as_chunks::<8>().0)) {
        // Local copies, since possible aliasing prevents vectorisation.
        let (mut to_re, mut to_im) = (*re, *im);
        add_block::<I, 8>((&mut to_re, &mut to_im), a, factor);
        (*re, *im) = (to_re, to_im);
    }
}

/// Σ a b* of rows.
#[inline(always)]
pub fn product<I: Instructions>(a: Row<'_>, b: Row<'_>) -> Complex64 {
    let mut sum = Sum::<BLOCK>::ZERO;
    let a = a.0.as_chunks().0.iter().zip(a.1.as_chunks().0);
    for (a, b) in a.zip(b.0.as_chunks().0.iter().zip(b.1.as_chunks().0)) {
        sum.add::<I>(a, b);
    }
    sum.total()
}

/// Reflections of a few rows, each applied to those after it.
struct Panel<'a> {
    matrix: &'a mut Matrix,
    triangle: &'a mut Matrix,
    rows: std::ops::Range<usize>,
}

impl Kernel for Panel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { matrix, triangle, rows } = self;
        for row in rows.clone() {
            (0..row).for_each(|column| triangle.set(row, column, matrix.at(row, column)));
            let result = matrix.make_reflection(row, row);
            triangle.set(row, row, result);
            for later in row + 1..rows.end {
                let (by, [mut to]) = matrix.row_and_later(row, later, row);
                let along = product::<I>((to.0, to.1), by);
                add::<I>(&mut to, by, -along);
            }
        }
    }
}

/// Consecutive reflections applied to whole rows.
struct Apply<'a> {
    /// Reflections, used from column `start` on.
    panel: &'a [Row<'a>; PANEL],
    start: usize,
    stride: usize,
    rows: RowMut<'a>,
}

impl Kernel for Apply<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        // Sums of a panel fill half of the registers.
        if I::WIDTH == 16 { self.in_lanes::<I, 8>() } else { self.in_lanes::<I, 4>() }
    }
}

impl Apply<'_> {
    #[inline(always)]
    fn in_lanes<I: Instructions, const LANES: usize>(self) {
        let Self { panel, start, stride, rows } = self;
        // Loops rather than closures, which may be compiled apart, for the baseline.
        let mut between = [[Complex64::ZERO; PANEL]; PANEL];
        for later in 1..PANEL {
            for earlier in 0..later {
                between[later][earlier] = product::<I>(panel[earlier], panel[later]);
            }
        }
        let by = panel.map(|(re, im)| (re.as_chunks::<LANES>().0, im.as_chunks::<LANES>().0));
        let blocks = by[0].0.len();
        let by = by.map(|(re, im)| (&re[..blocks], &im[..blocks]));
        for (re, im) in rows.0.chunks_exact_mut(stride).zip(rows.1.chunks_exact_mut(stride)) {
            let (re, im) = (re[start..].as_chunks_mut::<LANES>().0, im[start..].as_chunks_mut::<LANES>().0);
            let (re, im) = (&mut re[..blocks], &mut im[..blocks]);
            let mut sums = [Sum::ZERO; PANEL];
            for block in 0..blocks {
                for (sum, by) in sums.iter_mut().zip(&by) {
                    sum.add::<I>((&re[block], &im[block]), (&by.0[block], &by.1[block]));
                }
            }
            // Each reflection meets the row as those before it left it.
            let mut factors = [Complex64::ZERO; PANEL];
            for later in 0..PANEL {
                let mut along = sums[later].total();
                for earlier in 0..later {
                    along += factors[earlier] * between[later][earlier];
                }
                factors[later] = -along;
            }
            for block in 0..blocks {
                let (mut to_re, mut to_im) = (re[block], im[block]);
                for (by, factor) in by.iter().zip(factors) {
                    add_block::<I, LANES>((&mut to_re, &mut to_im), (&by.0[block], &by.1[block]), factor);
                }
                (re[block], im[block]) = (to_re, to_im);
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Numbers without pattern.
    pub fn scattered(index: usize) -> Complex64 {
        let unit = |step: f64| ((index + 1) as f64 * step).fract() - 0.5;
        Complex64::new(unit(0.618_033_988), unit(0.754_877_666))
    }

    #[test]
    fn a_triangle_and_its_reflections_give_back_the_matrix() {
        // Within a panel, of whole panels and not, in blocks and not, and in several tasks.
        for (rows, columns) in [(1, 1), (1, 5), (3, 16), (4, 17), (9, 40), (33, 33), (24, 3000)] {
            let entry = |m: usize, n: usize| scattered(m * columns + n);
            for isa in Isa::available() {
                let mut reflections = Matrix::from_fn(rows, columns, entry);
                let triangle = reflections.triangle(isa);
                for m in 0..rows {
                    // A* e = Q* L* e.
                    let mut row: Vec<_> = (0..columns)
                        .map(|n| if n < rows { triangle.at(m, n).conj() } else { Complex64::ZERO })
                        .collect();
                    assert!(row[m + 1..].iter().all(|value| *value == Complex64::ZERO), "no triangle");
                    (0..rows).rev().for_each(|i| reflections.reflect(i, i, &mut row));
                    for (n, got) in row.iter().enumerate() {
                        let error = (got.conj() - entry(m, n)).norm();
                        assert!(error < 1e-12, "{} {rows} x {columns}: {error} at {m}, {n}", isa.name());
                    }
                }
            }
        }
    }

    #[test]
    fn reflections_keep_lengths() {
        let mut matrix = Matrix::from_fn(3, 20, |m, n| scattered(20 * m + n) * 1e-100f64.powi(m as i32));
        matrix.triangle(Isa::best());
        let x: Vec<_> = (0..20).map(|n| scattered(7 * n)).collect();
        let power = |x: &[Complex64]| x.iter().map(Complex64::norm_sqr).sum::<f64>();
        for row in 0..3 {
            let mut reflected = x.clone();
            matrix.reflect(row, row, &mut reflected);
            assert!((power(&reflected) / power(&x) - 1.0).abs() < 1e-14, "row {row}");
        }
    }

    #[test]
    fn the_largest_part_is_a_number_only_if_all_are() {
        let mut matrix = Matrix::from_fn(2, 3, |m, n| Complex64::new(m as f64, -(n as f64)));
        assert_eq!(matrix.largest(), 2.0);
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            matrix.set(0, 1, Complex64::new(0.0, value));
            assert!(!matrix.largest().is_finite(), "{value}");
        }
    }
}
