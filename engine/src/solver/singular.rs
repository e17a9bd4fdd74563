//! Singular values of complex matrices, and least squares by them: Householder reflections to a bidiagonal matrix.

use num_complex::Complex64;

use crate::gauge;
use crate::simd::{Instructions, Isa, Kernel};
use crate::solver::bidiagonal::Bidiagonal;
use crate::solver::iteration::phase;
use crate::solver::matrix::{BLOCK, Matrix, Reflection, Row, RowMut, Sum, add, add_block, start};

/// Rows that both reflections of a step are applied to at once.
const TOGETHER: usize = 2;

/// The singular values, in no order, as many as the matrix has rows or columns.
///
/// `None` if a number is infinite or NaN, or the step is cancelled.
pub fn values(matrix: Matrix) -> Option<Vec<f64>> {
    // Fewer rows than columns are less work.
    let matrix = if matrix.rows > matrix.columns { matrix.adjoint() } else { matrix };
    let b = vec![Complex64::ZERO; matrix.rows];
    let Reduced { mut bidiagonal, mut b, scale, .. } = Reduced::new(Isa::best(), matrix, b)?;
    bidiagonal.diagonalise(&mut b)?;
    Some(bidiagonal.diagonal.iter().map(|value| value.abs() * scale).collect())
}

/// The shortest x that meets A x = b as nearly as the singular values above `tolerance` times the largest allow.
///
/// `None` if a number is infinite or NaN, or the step is cancelled.
pub fn solve(matrix: Matrix, b: Vec<Complex64>, tolerance: f64) -> Option<Vec<Complex64>> {
    Reduced::new(Isa::best(), matrix, b)?.solve(tolerance)
}

/// A = scale · U B V*, B real and bidiagonal, and U* b.
struct Reduced {
    bidiagonal: Bidiagonal,
    b: Vec<Complex64>,
    scale: f64,
    /// Phases of V.
    phases: Vec<Complex64>,
    /// Its reflections, from column i + 1 on in row i.
    inner: Matrix,
    /// Reflections of a wide matrix before, from column i on.
    outer: Option<Matrix>,
}

impl Reduced {
    fn new(isa: Isa, mut matrix: Matrix, mut b: Vec<Complex64>) -> Option<Self> {
        let largest = matrix.largest();
        if !largest.is_finite() {
            return None;
        }
        // A power of two changes no digit, and squares are numbers then.
        let scale = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE);
        matrix.scale(1.0 / scale);
        let (mut inner, outer) =
            if matrix.rows < matrix.columns { (matrix.triangle(isa), Some(matrix)) } else { (matrix, None) };
        let (diagonal, upper) = isa.run(Reduction { matrix: &mut inner, b: &mut b })?;
        let mut phases = vec![Complex64::ONE; inner.columns];
        for i in 0..inner.columns {
            let left = phase(diagonal[i] * phases[i]);
            b[i] *= left.conj();
            if let Some(upper) = upper.get(i) {
                phases[i + 1] = phase(upper * left.conj()).conj();
            }
        }
        let moduli = |values: &[Complex64]| values.iter().map(|value| value.norm()).collect();
        let bidiagonal = Bidiagonal { diagonal: moduli(&diagonal), upper: moduli(&upper) };
        Some(Self { bidiagonal, b, scale, phases, inner, outer })
    }

    /// The shortest x of least squares, without singular values below `tolerance` times the largest.
    fn solve(mut self, tolerance: f64) -> Option<Vec<Complex64>> {
        let Self { bidiagonal, b, .. } = &mut self;
        let rotations = bidiagonal.diagonalise(b)?;
        let largest = bidiagonal.diagonal.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let inverse = |(b, value): (&Complex64, &f64)| {
            if value.abs() > tolerance * largest { b / value } else { Complex64::ZERO }
        };
        let mut x: Vec<_> = b.iter().zip(&bidiagonal.diagonal).map(inverse).collect();
        for rotation in rotations.iter().rev() {
            rotation.undo(&mut x);
        }
        Some(self.expand(x))
    }

    /// V x / scale.
    fn expand(&self, mut x: Vec<Complex64>) -> Vec<Complex64> {
        let Self { scale, phases, inner, outer, .. } = self;
        x.iter_mut().zip(phases).for_each(|(x, phase)| *x *= phase / scale);
        (0..inner.columns.saturating_sub(1)).rev().for_each(|i| inner.reflect(i, i + 1, &mut x));
        if let Some(outer) = outer {
            x.resize(outer.columns, Complex64::ZERO);
            (0..outer.rows).rev().for_each(|i| outer.reflect(i, i, &mut x));
        }
        x
    }
}

/// Reflections from both sides in turn, of a matrix with no fewer rows than columns, to its diagonal and the one above;
/// those from the left are applied to b, those from the right stay in the rows.
struct Reduction<'a> {
    matrix: &'a mut Matrix,
    b: &'a mut [Complex64],
}

impl Kernel for Reduction<'_> {
    type Output = Option<(Vec<Complex64>, Vec<Complex64>)>;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Self::Output {
        let Self { matrix, b } = self;
        let (rows, columns) = (matrix.rows, matrix.columns);
        let (mut diagonal, mut upper) = (Vec::with_capacity(columns), Vec::with_capacity(columns));
        let width = columns.next_multiple_of(BLOCK);
        let zeros = || (vec![0.0; width], vec![0.0; width]);
        let (mut sum, mut w) = (zeros(), zeros());
        // One pass per column: as soon as a row is final, its next number, conjugate, times it is added to the sum
        // that the next reflection from the left needs.
        let mut column: Vec<_> = (0..rows).map(|row| matrix.at(row, 0)).collect();
        for (row, x) in column.iter().enumerate() {
            add::<I>(&mut (&mut sum.0, &mut sum.1), matrix.row(row, 0), x.conj());
        }
        for i in 0..columns {
            if gauge::is_cancelled() {
                return None;
            }
            let power = column[i..].iter().map(Complex64::norm_sqr).sum();
            let Reflection { result, lift, scale } = Reflection::new(column[i], power);
            diagonal.push(result);
            add::<I>(&mut (&mut sum.0[start(i)..], &mut sum.1[start(i)..]), matrix.row(i, i), lift.conj());
            sum.0.iter_mut().chain(&mut sum.1).for_each(|part| *part *= scale);
            column[i] += lift;
            column[i..].iter_mut().for_each(|v| *v *= scale);
            let along: Complex64 = column[i..].iter().zip(&b[i..]).map(|(v, b)| v.conj() * b).sum();
            b[i..].iter_mut().zip(&column[i..]).for_each(|(b, v)| *b -= v * along);
            let next = i + 1;
            if next == columns {
                break;
            }
            std::mem::swap(&mut w, &mut sum);
            sum.0.fill(0.0);
            sum.1.fill(0.0);
            let w: Row<'_> = (&w.0[start(next)..], &w.1[start(next)..]);
            add::<I>(&mut matrix.row_mut(i, next), w, -column[i]);
            upper.push(matrix.make_reflection(i, next));
            let mut pass = Pass { matrix, i, w, sum: (&mut sum.0[start(next)..], &mut sum.1[start(next)..]) };
            let mut later = column[next..].chunks_exact_mut(TOGETHER);
            let mut row = next;
            for column in later.by_ref() {
                pass.run::<I, TOGETHER>(row, column);
                row += TOGETHER;
            }
            for column in later.into_remainder().chunks_exact_mut(1) {
                pass.run::<I, 1>(row, column);
                row += 1;
            }
        }
        Some((diagonal, upper))
    }
}

/// Both reflections of a step, applied to the rows after it.
struct Pass<'a> {
    matrix: &'a mut Matrix,
    i: usize,
    /// v* A of the reflection from the left.
    w: Row<'a>,
    sum: RowMut<'a>,
}

impl Pass<'_> {
    /// One pass over `COUNT` rows: `column` holds v and becomes the next column.
    #[inline(always)]
    fn run<I: Instructions, const COUNT: usize>(&mut self, row: usize, column: &mut [Complex64]) {
        if I::WIDTH == 16 {
            self.in_lanes::<I, COUNT, 8>(row, column);
        } else {
            self.in_lanes::<I, COUNT, 4>(row, column);
        }
    }

    #[inline(always)]
    fn in_lanes<I: Instructions, const COUNT: usize, const LANES: usize>(
        &mut self,
        row: usize,
        column: &mut [Complex64],
    ) {
        let Self { matrix, i, w, sum } = self;
        let next = *i + 1;
        let (by, rows) = matrix.row_and_later::<COUNT>(*i, row, next);
        let (w_re, w_im) = (w.0.as_chunks::<LANES>().0, w.1.as_chunks::<LANES>().0);
        let blocks = w_re.len();
        let w_im = &w_im[..blocks];
        let (by_re, by_im) = (&by.0.as_chunks::<LANES>().0[..blocks], &by.1.as_chunks::<LANES>().0[..blocks]);
        let mut rows = rows.map(|(re, im)| {
            (&mut re.as_chunks_mut::<LANES>().0[..blocks], &mut im.as_chunks_mut::<LANES>().0[..blocks])
        });
        let v: [Complex64; COUNT] = std::array::from_fn(|k| -column[k]);
        let mut along = [Sum::<LANES>::ZERO; COUNT];
        for block in 0..blocks {
            for ((row, v), along) in rows.iter_mut().zip(v).zip(&mut along) {
                let (mut re, mut im) = (row.0[block], row.1[block]);
                add_block::<I, LANES>((&mut re, &mut im), (&w_re[block], &w_im[block]), v);
                along.add::<I>((&re, &im), (&by_re[block], &by_im[block]));
                (row.0[block], row.1[block]) = (re, im);
            }
        }
        let (block, lane) = (next % BLOCK / LANES, next % LANES);
        let own = Complex64::new(by_re[block][lane], by_im[block][lane]);
        // Loops rather than closures, which may be compiled apart, for the baseline.
        let (mut by_factors, mut factors) = ([Complex64::ZERO; COUNT], [Complex64::ZERO; COUNT]);
        for k in 0..COUNT {
            by_factors[k] = -along[k].total();
            column[k] = Complex64::new(rows[k].0[block][lane], rows[k].1[block][lane]) + by_factors[k] * own;
            factors[k] = column[k].conj();
        }
        let (sum_re, sum_im) = (
            &mut sum.0.as_chunks_mut::<LANES>().0[..blocks],
            &mut sum.1.as_chunks_mut::<LANES>().0[..blocks],
        );
        for block in 0..blocks {
            let (mut to_re, mut to_im) = (sum_re[block], sum_im[block]);
            for ((row, by_factor), factor) in rows.iter_mut().zip(by_factors).zip(factors) {
                let (mut re, mut im) = (row.0[block], row.1[block]);
                add_block::<I, LANES>((&mut re, &mut im), (&by_re[block], &by_im[block]), by_factor);
                add_block::<I, LANES>((&mut to_re, &mut to_im), (&re, &im), factor);
                (row.0[block], row.1[block]) = (re, im);
            }
            (sum_re[block], sum_im[block]) = (to_re, to_im);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::matrix::tests::scattered;

    fn vector(seed: usize, count: usize) -> Vec<Complex64> {
        (0..count).map(|i| scattered(seed + 13 * i)).collect()
    }

    /// Orthonormal vectors by Gram and Schmidt, twice.
    fn orthonormal(seed: usize, count: usize, length: usize) -> Vec<Vec<Complex64>> {
        let mut vectors: Vec<Vec<Complex64>> = Vec::new();
        for i in 0..count {
            let mut new = vector(seed + 1009 * i, length);
            for _ in 0..2 {
                for other in &vectors {
                    let along: Complex64 = other.iter().zip(&new).map(|(a, b)| a.conj() * b).sum();
                    new.iter_mut().zip(other).for_each(|(new, other)| *new -= along * other);
                }
            }
            let norm = new.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
            vectors.push(new.iter().map(|value| value / norm).collect());
        }
        vectors
    }

    /// U S V* with its factors.
    fn composed(rows: usize, columns: usize, s: &[f64]) -> (Matrix, [Vec<Vec<Complex64>>; 2]) {
        let (u, v) = (orthonormal(3, s.len(), rows), orthonormal(5, s.len(), columns));
        let entry = |m: usize, n: usize| (0..s.len()).map(|i| u[i][m] * v[i][n].conj() * s[i]).sum();
        (Matrix::from_fn(rows, columns, entry), [u, v])
    }

    fn solve_by(isa: Isa, matrix: &Matrix, b: &[Complex64], tolerance: f64) -> Vec<Complex64> {
        Reduced::new(isa, matrix.clone(), b.to_vec()).unwrap().solve(tolerance).unwrap()
    }

    fn largest(values: impl Iterator<Item = f64>) -> f64 {
        values.fold(0.0, |largest, value| if value > largest || value.is_nan() { value } else { largest })
    }

    const SHAPES: [(usize, usize); 9] =
        [(1, 1), (1, 7), (7, 1), (2, 256), (5, 40), (17, 17), (33, 64), (40, 5), (70, 33)];

    #[test]
    fn the_values_are_those_that_the_matrix_was_made_of() {
        for (rows, columns) in SHAPES {
            let count = rows.min(columns);
            for decades in [0.0, 1.0, 12.0] {
                let s: Vec<_> = (0..count).map(|i| 3.0 * 10f64.powf(-decades * i as f64 / 64.0)).collect();
                let (matrix, _) = composed(rows, columns, &s);
                for scale in [1e-150, 1.0, 1e150] {
                    let mut scaled = matrix.clone();
                    scaled.scale(scale);
                    let mut values = values(scaled).unwrap();
                    values.sort_by(|a, b| b.total_cmp(a));
                    assert_eq!(values.len(), count);
                    let error = largest(values.iter().zip(&s).map(|(a, b)| (a / scale - b).abs()));
                    assert!(error < 1e-13, "{rows} x {columns}, {decades} decades, {scale}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_solution_is_the_pseudo_inverse_without_the_smallest_values() {
        const TOLERANCE: f64 = 1e-6;
        for (rows, columns) in SHAPES {
            let count = rows.min(columns);
            let b = vector(11, rows);
            // All above the tolerance, and every third far below it.
            for faint in [1.0, 1e-9, 0.0] {
                let s: Vec<_> = (0..count).map(|i| if i % 3 == 1 { faint } else { 1.0 + i as f64 }).collect();
                let (matrix, [u, v]) = composed(rows, columns, &s);
                let mut expected = vec![Complex64::ZERO; columns];
                for i in (0..count).filter(|&i| s[i] > TOLERANCE * count as f64) {
                    let along: Complex64 = u[i].iter().zip(&b).map(|(u, b)| u.conj() * b).sum();
                    expected.iter_mut().zip(&v[i]).for_each(|(x, v)| *x += v * along / s[i]);
                }
                for isa in Isa::available() {
                    let got = solve_by(isa, &matrix, &b, TOLERANCE);
                    let error = largest(got.iter().zip(&expected).map(|(a, b)| (a - b).norm()));
                    // Directions of values 1e-9 apart are known to 1e-16 / 1e-9 and less.
                    assert!(error < 1e-11, "{} {rows} x {columns}, {faint}: {error}", isa.name());
                }
            }
        }
    }

    #[test]
    fn dependent_and_empty_rows_are_finite() {
        let row = vector(1, 24);
        for (name, factors) in [
            ("equal", vec![1.0; 30]),
            ("one of all", [vec![0.0; 12], vec![1.0], vec![0.0; 12]].concat()),
            ("nothing", vec![0.0; 9]),
            ("far apart", (0..40).map(|i| 10f64.powi(-8 * i)).collect()),
        ] {
            let matrix = Matrix::from_fn(factors.len(), 24, |m, n| row[n] * factors[m]);
            let power =
                factors.iter().map(|f| f * f).sum::<f64>() * row.iter().map(Complex64::norm_sqr).sum::<f64>();
            let values = values(matrix.clone()).unwrap();
            let found = values.iter().map(|value| value * value).sum::<f64>();
            assert!((found - power).abs() <= 1e-13 * power, "{name}: {found} is not {power}");
            let loudest = largest(values.iter().copied());
            assert!(
                values.iter().filter(|&&value| value > 1e-13 * loudest).count() <= 1,
                "{name}: {values:?}"
            );
            let x = solve(matrix, vector(3, factors.len()), 1e-6).unwrap();
            assert!(x.len() == 24 && x.iter().all(|x| x.is_finite()), "{name}: {x:?}");
            assert_eq!(x.iter().all(|x| *x == Complex64::ZERO), power == 0.0, "{name}");
        }
    }

    #[test]
    fn what_is_no_number_has_no_values() {
        for value in [f64::NAN, f64::INFINITY] {
            let matrix = Matrix::from_fn(3, 4, |m, n| Complex64::from(if m == n { value } else { 1.0 }));
            assert!(values(matrix.clone()).is_none(), "{value}");
            assert!(solve(matrix, vector(0, 3), 1e-6).is_none(), "{value}");
        }
    }
}
