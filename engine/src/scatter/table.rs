//! Rows of complex numbers in f32, times one vector or sixteen at once.
//!
//! One vector is as fast as the rows are read: vector registers run along a row. Of sixteen vectors a register holds one
//! number each, and every entry is read once for all of them; some rows (or columns) at a time share what is read of the
//! vectors.

use std::array::from_fn;
use std::ops::Range;

use num_complex::{Complex32, Complex64};

use crate::simd::{Instructions, Isa, Kernel, fused};

/// Rows of complex numbers, real parts of a row before its imaginary parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    pub rows: usize,
    pub columns: usize,
    pub values: Vec<f32>,
}

impl Table {
    pub fn of(rows: &[[Vec<f32>; 2]]) -> Self {
        let columns = rows.first().map_or(0, |row| row[0].len());
        let values = rows.iter().flat_map(|[re, im]| re.iter().chain(im).copied()).collect();
        Self { rows: rows.len(), columns, values }
    }

    pub fn row(&self, row: usize) -> [&[f32]; 2] {
        let (re, im) =
            self.values[2 * row * self.columns..2 * (row + 1) * self.columns].split_at(self.columns);
        [re, im]
    }

    /// A x.
    pub fn times(&self, x: &[Complex32]) -> Vec<Complex32> {
        let (re, im): (Vec<f32>, Vec<f32>) = x.iter().map(|x| (x.re, x.im)).unzip();
        (0..self.rows).map(|row| Isa::best().run(Dot { row: self.row(row), x: [&re, &im] })).collect()
    }

    /// Aᵀ x.
    pub fn transposed_times(&self, x: &[Complex32]) -> Vec<Complex32> {
        let (mut re, mut im) = (vec![0.0; self.columns], vec![0.0; self.columns]);
        for (row, x) in x.iter().enumerate() {
            Isa::best().run(Add { row: self.row(row), x: *x, to: [&mut re, &mut im] });
        }
        re.into_iter().zip(im).map(|(re, im)| Complex32::new(re, im)).collect()
    }

    /// Adds some numbers of A x.
    pub fn add_times(&self, rows: Range<usize>, x: &[Sixteen], to: &mut [Sums]) {
        assert_eq!((rows.len(), x.len()), (to.len(), self.columns));
        Isa::best().run(AddTiles::<false> { table: self, first: rows.start, x, to });
    }

    /// Adds some numbers of Aᵀ x.
    pub fn add_transposed_times(&self, columns: Range<usize>, x: &[Sixteen], to: &mut [Sums]) {
        assert_eq!((columns.len(), x.len()), (to.len(), self.rows));
        Isa::best().run(AddTiles::<true> { table: self, first: columns.start, x, to });
    }
}

/// Vectors that are taken at once.
pub(super) const LANES: usize = 16;

/// Real and imaginary parts of a number of each of sixteen vectors.
pub(super) type Sixteen = [[f32; LANES]; 2];
/// Their sums.
pub(super) type Sums = [[f64; LANES]; 2];

/// Vectors by sixteen, filled up with zeros.
pub(super) fn by_sixteen(vectors: &[Vec<Complex64>]) -> Vec<Vec<Sixteen>> {
    let group = |vectors: &[Vec<Complex64>]| {
        let number = |i: usize| {
            let mut number = [[0.0; LANES]; 2];
            for (lane, vector) in vectors.iter().enumerate() {
                (number[0][lane], number[1][lane]) = (vector[i].re as f32, vector[i].im as f32);
            }
            number
        };
        (0..vectors[0].len()).map(number).collect()
    };
    vectors.chunks(LANES).map(group).collect()
}

pub(super) fn rounded(sums: &[Sums]) -> Vec<Sixteen> {
    sums.iter().map(|sums| sums.map(|part| part.map(|x| x as f32))).collect()
}

/// Σ a x.
pub(super) struct Dot<'a> {
    pub row: [&'a [f32]; 2],
    pub x: [&'a [f32]; 2],
}

impl Kernel for Dot<'_> {
    type Output = Complex32;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Complex32 {
        let (a, b) = (self.row.map(|a| a.as_chunks::<LANES>()), self.x.map(|x| x.as_chunks::<LANES>()));
        let (mut re, mut im) = ([0f32; LANES], [0f32; LANES]);
        for i in 0..a[0].0.len() {
            let (ar, ai, br, bi) = (&a[0].0[i], &a[1].0[i], &b[0].0[i], &b[1].0[i]);
            for l in 0..LANES {
                re[l] = fused::<I>(ar[l], br[l], fused::<I>(-ai[l], bi[l], re[l]));
                im[l] = fused::<I>(ar[l], bi[l], fused::<I>(ai[l], br[l], im[l]));
            }
        }
        let mut sum = Complex32::new(re.iter().sum(), im.iter().sum());
        for i in 0..a[0].1.len() {
            sum += Complex32::new(a[0].1[i], a[1].1[i]) * Complex32::new(b[0].1[i], b[1].1[i]);
        }
        sum
    }
}

/// to += a x.
pub(super) struct Add<'a> {
    pub row: [&'a [f32]; 2],
    pub x: Complex32,
    pub to: [&'a mut [f32]; 2],
}

impl Kernel for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { row: [a_re, a_im], x, to: [re, im] } = self;
        for ((re, im), (a_re, a_im)) in re.iter_mut().zip(im).zip(a_re.iter().zip(a_im)) {
            *re = fused::<I>(*a_re, x.re, fused::<I>(-a_im, x.im, *re));
            *im = fused::<I>(*a_re, x.im, fused::<I>(*a_im, x.re, *im));
        }
    }
}

/// to += A x for rows from a first one, or Aᵀ x for columns.
struct AddTiles<'a, const IS_TRANSPOSED: bool> {
    table: &'a Table,
    first: usize,
    x: &'a [Sixteen],
    to: &'a mut [Sums],
}

impl<const IS_TRANSPOSED: bool> Kernel for AddTiles<'_, IS_TRANSPOSED> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        // As many of them as registers for their sums.
        match I::WIDTH {
            LANES.. => self.by::<I, 6>(),
            _ => self.by::<I, 2>(),
        }
    }
}

impl<const IS_TRANSPOSED: bool> AddTiles<'_, IS_TRANSPOSED> {
    #[inline(always)]
    fn by<I: Instructions, const AT_ONCE: usize>(self) {
        let Self { table, first, x, to } = self;
        let (tiles, rest) = to.as_chunks_mut::<AT_ONCE>();
        let after = first + AT_ONCE * tiles.len();
        for (tile, to) in tiles.iter_mut().enumerate() {
            add_tile::<I, AT_ONCE, IS_TRANSPOSED>(table, first + AT_ONCE * tile, x, to);
        }
        for (last, to) in rest.iter_mut().enumerate() {
            add_tile::<I, 1, IS_TRANSPOSED>(table, after + last, x, std::array::from_mut(to));
        }
    }
}

#[inline(always)]
fn add_tile<I: Instructions, const COUNT: usize, const IS_TRANSPOSED: bool>(
    table: &Table,
    first: usize,
    x: &[Sixteen],
    to: &mut [Sums; COUNT],
) {
    if IS_TRANSPOSED {
        columns_tile::<I, COUNT>(table, first, x, to);
    } else {
        rows_tile::<I, COUNT>(table, first, x, to);
    }
}

#[inline(always)]
fn rows_tile<I: Instructions, const ROWS: usize>(
    table: &Table,
    first: usize,
    x: &[Sixteen],
    to: &mut [Sums; ROWS],
) {
    let count = x.len();
    let rows: [[&[f32]; 2]; ROWS] = from_fn(|row| table.row(first + row).map(|part| &part[..count]));
    let mut sums = [[[0f32; LANES]; 2]; ROWS];
    for column in 0..count {
        let x = &x[column];
        for row in 0..ROWS {
            add_product::<I>(&mut sums[row], [rows[row][0][column], rows[row][1][column]], x);
        }
    }
    add_sums(to, &sums);
}

#[inline(always)]
fn columns_tile<I: Instructions, const COLUMNS: usize>(
    table: &Table,
    first: usize,
    x: &[Sixteen],
    to: &mut [Sums; COLUMNS],
) {
    let mut sums = [[[0f32; LANES]; 2]; COLUMNS];
    let rows = table.values.chunks_exact(2 * table.columns);
    for (row, x) in rows.zip(x) {
        let (re, im) = row.split_at(table.columns);
        let (re, im) = (&re[first..first + COLUMNS], &im[first..first + COLUMNS]);
        for column in 0..COLUMNS {
            add_product::<I>(&mut sums[column], [re[column], im[column]], x);
        }
    }
    add_sums(to, &sums);
}

/// sum += a x.
#[inline(always)]
fn add_product<I: Instructions>(sum: &mut Sixteen, [re, im]: [f32; 2], x: &Sixteen) {
    for lane in 0..LANES {
        sum[0][lane] = fused::<I>(re, x[0][lane], fused::<I>(-im, x[1][lane], sum[0][lane]));
        sum[1][lane] = fused::<I>(re, x[1][lane], fused::<I>(im, x[0][lane], sum[1][lane]));
    }
}

#[inline(always)]
fn add_sums<const COUNT: usize>(to: &mut [Sums; COUNT], sums: &[Sixteen; COUNT]) {
    for (to, sums) in to.iter_mut().zip(sums) {
        for part in 0..2 {
            for lane in 0..LANES {
                to[part][lane] += f64::from(sums[part][lane]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_and_many_vectors_give_the_same_products() {
        let unit = |i: usize, step: f64| (i as f64 * step).fract() as f32 - 0.5;
        let (rows, columns, count) = (23, 37, 19);
        let values: Vec<_> = (0..2 * rows * columns).map(|i| unit(i, 0.618_034)).collect();
        let table = Table { rows, columns, values };
        for is_transposed in [false, true] {
            let (from, to) = if is_transposed { (rows, columns) } else { (columns, rows) };
            let number = |v: usize, i: usize| {
                Complex64::new(unit(v + i, 0.754_878).into(), unit(7 * v + i, 0.57).into())
            };
            let vectors: Vec<Vec<_>> =
                (0..count).map(|v| (0..from).map(|i| number(v, i)).collect()).collect();
            for (group, x) in by_sixteen(&vectors).iter().enumerate() {
                let mut sums = vec![[[0.0; LANES]; 2]; to];
                let middle = to / 3;
                let (before, after) = sums.split_at_mut(middle);
                for (part, sums) in [(0..middle, before), (middle..to, after)] {
                    match is_transposed {
                        true => table.add_transposed_times(part, x, sums),
                        false => table.add_times(part, x, sums),
                    }
                }
                for (lane, vector) in vectors.iter().skip(LANES * group).take(LANES).enumerate() {
                    let short: Vec<_> =
                        vector.iter().map(|x| Complex32::new(x.re as f32, x.im as f32)).collect();
                    let one =
                        if is_transposed { table.transposed_times(&short) } else { table.times(&short) };
                    for (sum, one) in sums.iter().zip(one) {
                        let own = Complex32::new(sum[0][lane] as f32, sum[1][lane] as f32);
                        assert!((own - one).norm() < 1e-5, "{own} {one}");
                    }
                }
            }
        }
    }
}
