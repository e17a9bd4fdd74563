//! Transfers to scattered points as a dense table, with an optional subset of active rows.

use num_complex::Complex64;

use crate::simd::{Instructions, Isa, Kernel};
use crate::solver::shape::real::{LANES, Real, Waves, lanes};

/// Elements processed together; rows are padded to whole blocks.
pub const BLOCK: usize = 2 * LANES;

/// H, a row per point and a column per driven element.
#[derive(Clone, Debug)]
pub struct Table<T> {
    values: Waves<T>,
    stride: usize,
    /// The rows in use, in rising order.
    pub rows: Vec<u32>,
}

impl<T: Real> Table<T> {
    /// Without rows.
    pub fn new(elements: usize) -> Self {
        Self { values: Waves::default(), stride: elements.next_multiple_of(BLOCK), rows: Vec::new() }
    }

    /// A row that is in use.
    pub fn push(&mut self, row: impl Iterator<Item = Complex64>, scale: f64) {
        self.rows.push(self.points() as u32);
        let padded = self.values.len() + self.stride;
        for value in row {
            self.values.re.push(T::of(value.re * scale));
            self.values.im.push(T::of(value.im * scale));
        }
        self.values.re.resize(padded, T::default());
        self.values.im.resize(padded, T::default());
    }

    pub fn points(&self) -> usize {
        self.values.len() / self.stride
    }

    /// Room for a value per element.
    pub fn excitation(&self) -> Waves<T> {
        Waves::zeros(self.stride)
    }

    /// p = H u at the rows in use.
    pub fn forward(&self, u: &Waves<T>, p: &mut Waves<T>) {
        Isa::best().run(Forward { table: self, u, p });
    }

    /// b += Hᴴ y over the rows in use.
    pub fn back(&self, y: &Waves<T>, b: &mut Waves<T>) {
        Isa::best().run(Back { table: self, y, b });
    }
}

struct Forward<'a, T> {
    table: &'a Table<T>,
    u: &'a Waves<T>,
    p: &'a mut Waves<T>,
}

impl<T: Real> Kernel for Forward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { table, u, p } = self;
        let [u_re, u_im] = u.blocks(0, table.stride);
        for ((&row, p_re), p_im) in table.rows.iter().zip(&mut p.re).zip(&mut p.im) {
            let [h_re, h_im] = table.values.blocks(row as usize * table.stride, table.stride);
            // Two accumulators each hide the latency of additions.
            let (mut re, mut im) = ([[T::default(); LANES]; 2], [[T::default(); LANES]; 2]);
            for block in 0..table.stride / LANES {
                let (a, b, c, d) = (&h_re[block], &h_im[block], &u_re[block], &u_im[block]);
                let half = block % 2;
                let (before_re, before_im) = (re[half], im[half]);
                let part = lanes(|i| T::fused::<I>(a[i], c[i], before_re[i]));
                re[half] = lanes(|i| T::fused::<I>(-b[i], d[i], part[i]));
                let part = lanes(|i| T::fused::<I>(a[i], d[i], before_im[i]));
                im[half] = lanes(|i| T::fused::<I>(b[i], c[i], part[i]));
            }
            *p_re = total(&re);
            *p_im = total(&im);
        }
    }
}

#[inline(always)]
fn total<T: Real>(sums: &[[T; LANES]; 2]) -> T {
    let mut sums: [T; LANES] = lanes(|i| sums[0][i] + sums[1][i]);
    for width in [4, 2, 1] {
        for lane in 0..width {
            sums[lane] += sums[lane + width];
        }
    }
    sums[0]
}

struct Back<'a, T> {
    table: &'a Table<T>,
    y: &'a Waves<T>,
    b: &'a mut Waves<T>,
}

impl<T: Real> Kernel for Back<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { table, y, b } = self;
        let [b_re, b_im] = b.blocks_mut(table.stride);
        for ((&row, &re), &im) in table.rows.iter().zip(&y.re).zip(&y.im) {
            if re == T::default() && im == T::default() {
                continue;
            }
            let [h_re, h_im] = table.values.blocks(row as usize * table.stride, table.stride);
            for block in 0..table.stride / LANES {
                let (h_re, h_im, to_re, to_im) = (&h_re[block], &h_im[block], b_re[block], b_im[block]);
                let part = lanes(|i| T::fused::<I>(h_re[i], re, to_re[i]));
                b_re[block] = lanes(|i| T::fused::<I>(h_im[i], im, part[i]));
                let part = lanes(|i| T::fused::<I>(h_re[i], im, to_im[i]));
                b_im[block] = lanes(|i| T::fused::<I>(-h_im[i], re, part[i]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::starts::scatter;

    fn value(seed: usize) -> Complex64 {
        Complex64::new(scatter(seed) - 0.5, scatter(7 * seed + 3) - 0.5)
    }

    #[test]
    fn products_are_those_of_the_rows_in_use() {
        let mut table = Table::<f64>::new(21);
        (0..5).for_each(|row| table.push((0..21).map(|n| value(1 + row * 21 + n)), 2.0));
        table.rows = vec![1, 4];
        let h = |row: usize, n: usize| value(1 + row * 21 + n) * 2.0;
        let mut u = table.excitation();
        (0..21).for_each(|n| (u.re[n], u.im[n]) = (value(500 + n).re, value(500 + n).im));
        let mut p = Waves::zeros(2);
        table.forward(&u, &mut p);
        for (at, row) in [(0, 1), (1, 4)] {
            let expected: Complex64 = (0..21).map(|n| h(row, n) * value(500 + n)).sum();
            assert!((Complex64::new(p.re[at], p.im[at]) - expected).norm() < 1e-13, "{row}");
        }
        // Rows with one part of zero count, too.
        (p.re[0], p.im[1]) = (0.0, 0.0);
        let mut b = table.excitation();
        b.re[20] = 1.0;
        table.back(&p, &mut b);
        for n in 0..21 {
            let heard = |(at, row)| h(row, n).conj() * Complex64::new(p.re[at], p.im[at]);
            let before = if n == 20 { 1.0 } else { 0.0 };
            let expected = heard((0, 1)) + heard((1, 4)) + before;
            assert!((Complex64::new(b.re[n], b.im[n]) - expected).norm() < 1e-12, "{n}");
        }
        assert!(b.re[21..].iter().chain(&b.im[21..]).all(|&padding| padding == 0.0));
    }
}
