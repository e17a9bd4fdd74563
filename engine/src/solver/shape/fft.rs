//! Fourier transforms along the rows of a matrix, one per SIMD lane: values never change lanes.

use std::f64::consts::TAU;

use crate::simd::{Instructions, Isa, Kernel};
use crate::solver::shape::real::{LANES, Real, Waves, lanes};

/// cos and sin of a twiddle factor.
type Turn<T> = [T; 2];
/// Real and imaginary part in every lane.
type Pair<T> = [[T; LANES]; 2];
/// Rows of whole blocks of lanes.
type Row<'a, T> = [&'a [[T; LANES]]; 2];

/// A transform of `length` rows, Stockham's way: radices 4, 3 and 2, not normalised.
#[derive(Clone, Debug)]
pub struct Plan<T> {
    pub length: usize,
    stages: Vec<Stage<T>>,
}

#[derive(Clone, Debug)]
struct Stage<T> {
    radix: usize,
    /// Rows that were transformed together before.
    stride: usize,
    /// Three for each of `stride`; those beyond the radix are not used.
    turns: Vec<[Turn<T>; 3]>,
}

/// The smallest supported length of at least `least`, in whole blocks of lanes.
pub fn length(least: usize) -> usize {
    let is_smooth = |&length: &usize| {
        let mut rest = length;
        for factor in [2, 3] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (least.next_multiple_of(LANES).max(LANES)..).step_by(LANES).find(is_smooth).unwrap_or(LANES)
}

impl<T: Real> Plan<T> {
    /// A plan for a length from [`length`].
    pub fn new(length: usize) -> Self {
        let mut stages = Vec::new();
        let (mut stride, mut rest) = (1, length);
        for radix in [4, 3, 2] {
            while rest.is_multiple_of(radix) {
                let turn = |k: usize, part: usize| {
                    let (sin, cos) = (-TAU * (k * part) as f64 / (stride * radix) as f64).sin_cos();
                    [T::of(cos), T::of(sin)]
                };
                let turns = (0..stride).map(|k| [1, 2, 3].map(|part| turn(k, part))).collect();
                stages.push(Stage { radix, stride, turns });
                (stride, rest) = (stride * radix, rest / radix);
            }
        }
        Self { length, stages }
    }

    /// Transforms rows of `width`, whole blocks of lanes, in `data`; only the first `filled` rows are non-zero, and
    /// later rows need not be initialised. `spare` is as long as `data`.
    pub fn run(&self, width: usize, filled: usize, data: &mut Waves<T>, spare: &mut Waves<T>) {
        Isa::best().run(Transform { plan: self, width, filled, data, spare });
    }

    /// The inverse, times the length.
    pub fn run_back(&self, width: usize, data: &mut Waves<T>, spare: &mut Waves<T>) {
        data.exchange();
        self.run(width, self.length, data, spare);
        data.exchange();
    }
}

struct Transform<'a, T> {
    plan: &'a Plan<T>,
    width: usize,
    filled: usize,
    data: &'a mut Waves<T>,
    spare: &'a mut Waves<T>,
}

impl<T: Real> Kernel for Transform<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { plan, width, mut filled, data, spare } = self;
        for stage in &plan.stages {
            stage.run(plan.length, width, filled, data, spare);
            filled = plan.length;
            std::mem::swap(data, spare);
        }
    }
}

impl<T: Real> Stage<T> {
    #[inline(always)]
    fn run(&self, length: usize, width: usize, filled: usize, from: &Waves<T>, to: &mut Waves<T>) {
        let Self { radix, stride, turns } = self;
        let (radix, stride, blocks) = (*radix, *stride, width / LANES);
        let runs = length / (stride * radix);
        let from = [from.re.as_chunks::<LANES>().0, from.im.as_chunks::<LANES>().0];
        let (to_re, to_im) = (to.re.as_chunks_mut::<LANES>().0, to.im.as_chunks_mut::<LANES>().0);
        let step = stride * blocks;
        for run in 0..runs {
            for (k, turns) in turns.iter().enumerate() {
                let first_at = (run * stride + k) * blocks;
                let apart = runs * stride * blocks;
                let target = (run * radix * stride + k) * blocks;
                // Later input rows of the first stage are zero: its output repeats this row.
                if stride == 1 && filled <= runs {
                    let first = row(from, first_at, blocks);
                    for to in (target..target + radix * step).step_by(step) {
                        if run < filled {
                            to_re[to..to + blocks].copy_from_slice(first[0]);
                            to_im[to..to + blocks].copy_from_slice(first[1]);
                        } else {
                            to_re[to..to + blocks].fill([T::default(); LANES]);
                            to_im[to..to + blocks].fill([T::default(); LANES]);
                        }
                    }
                    continue;
                }
                let last = target + (radix - 1) * step + blocks;
                let to = (&mut to_re[target..last], &mut to_im[target..last]);
                match radix {
                    4 => {
                        let [a, b] = [row(from, first_at, blocks), row(from, first_at + apart, blocks)];
                        let [c, d] = [first_at + 2 * apart, first_at + 3 * apart];
                        four([a, b, row(from, c, blocks), row(from, d, blocks)], to, step, turns);
                    }
                    3 => {
                        let [a, b] = [row(from, first_at, blocks), row(from, first_at + apart, blocks)];
                        three([a, b, row(from, first_at + 2 * apart, blocks)], to, step, turns);
                    }
                    _ => {
                        let [a, b] = [row(from, first_at, blocks), row(from, first_at + apart, blocks)];
                        two([a, b], to, step, turns);
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn row<'a, T>(all: Row<'a, T>, at: usize, blocks: usize) -> Row<'a, T> {
    [&all[0][at..at + blocks], &all[1][at..at + blocks]]
}

#[inline(always)]
fn turned<T: Real>(row: Row<'_, T>, block: usize, turn: Turn<T>) -> Pair<T> {
    let (re, im) = (row[0][block], row[1][block]);
    [lanes(|i| re[i] * turn[0] - im[i] * turn[1]), lanes(|i| re[i] * turn[1] + im[i] * turn[0])]
}

#[inline(always)]
fn plain<T: Real>(row: Row<'_, T>, block: usize) -> Pair<T> {
    [row[0][block], row[1][block]]
}

#[inline(always)]
fn plus<T: Real>(a: &[T; LANES], b: &[T; LANES]) -> [T; LANES] {
    lanes(|i| a[i] + b[i])
}

#[inline(always)]
fn minus<T: Real>(a: &[T; LANES], b: &[T; LANES]) -> [T; LANES] {
    lanes(|i| a[i] - b[i])
}

/// Output of a butterfly: real and imaginary parts, from its first row to the end of its last.
type Target<'a, T> = (&'a mut [[T; LANES]], &'a mut [[T; LANES]]);

#[inline(always)]
fn four<T: Real>(rows: [Row<'_, T>; 4], (to_re, to_im): Target<'_, T>, step: usize, turns: &[Turn<T>; 3]) {
    for block in 0..rows[0][0].len() {
        let [r0, i0] = plain(rows[0], block);
        let [r1, i1] = turned(rows[1], block, turns[0]);
        let [r2, i2] = turned(rows[2], block, turns[1]);
        let [r3, i3] = turned(rows[3], block, turns[2]);
        let (even_re, even_im) = (plus(&r0, &r2), plus(&i0, &i2));
        let (other_re, other_im) = (minus(&r0, &r2), minus(&i0, &i2));
        let (odd_re, odd_im) = (plus(&r1, &r3), plus(&i1, &i3));
        let (cross_re, cross_im) = (minus(&r1, &r3), minus(&i1, &i3));
        to_re[block] = plus(&even_re, &odd_re);
        to_im[block] = plus(&even_im, &odd_im);
        to_re[step + block] = plus(&other_re, &cross_im);
        to_im[step + block] = minus(&other_im, &cross_re);
        to_re[2 * step + block] = minus(&even_re, &odd_re);
        to_im[2 * step + block] = minus(&even_im, &odd_im);
        to_re[3 * step + block] = minus(&other_re, &cross_im);
        to_im[3 * step + block] = plus(&other_im, &cross_re);
    }
}

#[inline(always)]
fn three<T: Real>(rows: [Row<'_, T>; 3], (to_re, to_im): Target<'_, T>, step: usize, turns: &[Turn<T>; 3]) {
    let (half, sin) = (T::of(0.5), T::of(0.75f64.sqrt()));
    for block in 0..rows[0][0].len() {
        let [r0, i0] = plain(rows[0], block);
        let [r1, i1] = turned(rows[1], block, turns[0]);
        let [r2, i2] = turned(rows[2], block, turns[1]);
        let (sum_re, sum_im) = (plus(&r1, &r2), plus(&i1, &i2));
        let (cross_re, cross_im) = (lanes(|i| sin * (r1[i] - r2[i])), lanes(|i| sin * (i1[i] - i2[i])));
        let (rest_re, rest_im) = (lanes(|i| r0[i] - half * sum_re[i]), lanes(|i| i0[i] - half * sum_im[i]));
        to_re[block] = plus(&r0, &sum_re);
        to_im[block] = plus(&i0, &sum_im);
        to_re[step + block] = plus(&rest_re, &cross_im);
        to_im[step + block] = minus(&rest_im, &cross_re);
        to_re[2 * step + block] = minus(&rest_re, &cross_im);
        to_im[2 * step + block] = plus(&rest_im, &cross_re);
    }
}

#[inline(always)]
fn two<T: Real>(rows: [Row<'_, T>; 2], (to_re, to_im): Target<'_, T>, step: usize, turns: &[Turn<T>; 3]) {
    for block in 0..rows[0][0].len() {
        let [r0, i0] = plain(rows[0], block);
        let [r1, i1] = turned(rows[1], block, turns[0]);
        to_re[block] = plus(&r0, &r1);
        to_im[block] = plus(&i0, &i1);
        to_re[step + block] = minus(&r0, &r1);
        to_im[step + block] = minus(&i0, &i1);
    }
}

/// The first columns of rows become rows: `size` is their number and length, `strides` those of the rows of both.
pub fn transpose<T: Real>(from: &Waves<T>, to: &mut Waves<T>, size: [usize; 2], strides: [usize; 2]) {
    for (from, to) in [(&from.re, &mut to.re), (&from.im, &mut to.im)] {
        Isa::best().run(Transposition { from, to, size, strides });
    }
}

struct Transposition<'a, T> {
    from: &'a [T],
    to: &'a mut [T],
    size: [usize; 2],
    strides: [usize; 2],
}

impl<T: Real> Kernel for Transposition<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { from, to, size: [rows, columns], strides: [from_stride, to_stride] } = self;
        for row in (0..rows).step_by(LANES) {
            for column in (0..columns).step_by(LANES) {
                let (high, wide) = ((rows - row).min(LANES), (columns - column).min(LANES));
                if high < LANES || wide < LANES {
                    for i in 0..high {
                        for j in 0..wide {
                            to[(column + j) * to_stride + row + i] =
                                from[(row + i) * from_stride + column + j];
                        }
                    }
                    continue;
                }
                let mut block = [[T::default(); LANES]; LANES];
                for (i, line) in block.iter_mut().enumerate() {
                    line.copy_from_slice(&from[(row + i) * from_stride + column..][..LANES]);
                }
                for j in 0..LANES {
                    let line = lanes(|i| block[i][j]);
                    to[(column + j) * to_stride + row..][..LANES].copy_from_slice(&line);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::solver::starts::scatter;

    #[test]
    fn rows_are_transformed_lane_by_lane() {
        for length in [8, 16, 24, 48, 72, 96] {
            for (filled, width) in [(length, 8), (length / 4, 16), (1, 8)] {
                let value = |row: usize, lane: usize, seed: usize| {
                    if row < filled { scatter(row * width + lane + seed) - 0.5 } else { 0.0 }
                };
                let fill =
                    |seed: usize| (0..length * width).map(|i| value(i / width, i % width, seed)).collect();
                let mut data = Waves::<f64> { re: fill(1), im: fill(1000) };
                Plan::new(length).run(width, filled, &mut data, &mut Waves::zeros(length * width));
                for k in 0..length {
                    for lane in [0, width - 1] {
                        let term = |row: usize| {
                            let turn = Complex64::from_polar(1.0, -TAU * (row * k) as f64 / length as f64);
                            turn * Complex64::new(value(row, lane, 1), value(row, lane, 1000))
                        };
                        let expected: Complex64 = (0..length).map(term).sum();
                        let at = k * width + lane;
                        let got = Complex64::new(data.re[at], data.im[at]);
                        assert!((got - expected).norm() < 1e-12, "{length} {k}: {got} is not {expected}");
                    }
                }
            }
        }
    }
}
