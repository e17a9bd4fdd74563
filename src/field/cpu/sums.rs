//! Sums of runs of numbers that lie in memory: superposition of a table, and interpolation.

use num_complex::Complex32;

use crate::simd::{Instructions, Isa, Kernel, fused};

/// Values that a run of [`superpose`] may read beyond its end.
pub const OVERHANG: usize = 16;

/// Complex numbers with their real and imaginary parts apart, as vector registers like them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Split {
    pub re: Vec<f32>,
    pub im: Vec<f32>,
}

/// An element's part in `D` superpositions: where its run starts in the table, and its excitations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term<const D: usize> {
    pub start: usize,
    pub re: [f32; D],
    pub im: [f32; D],
}

/// Drives that are superposed together: what is read of the table serves them all.
pub const DRIVES: usize = 4;

/// Adds up runs of `table`, one per term, with the term's excitations: sum_i = Σ u · table(start + first + i), for one drive or
/// [`DRIVES`], whose sums are of one length.
///
/// The table must have [`OVERHANG`] values more than the runs reach.
pub fn superpose<const D: usize>(
    table: &Split,
    terms: &[Term<D>],
    first: usize,
    sums: [&mut [Complex32]; D],
) {
    Isa::best().run(Superposition { table, terms, first, sums });
}

struct Superposition<'a, const D: usize> {
    table: &'a Split,
    terms: &'a [Term<D>],
    first: usize,
    sums: [&'a mut [Complex32]; D],
}

impl<const D: usize> Kernel for Superposition<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        // Sums stay in registers, and there are enough of them to wait for none.
        match (I::WIDTH, D) {
            (16, 1) => self.in_runs::<I, 64, 16>(),
            (16, _) => self.in_runs::<I, 32, 16>(),
            (8, 1) => self.in_runs::<I, 32, 8>(),
            (8, _) => self.in_runs::<I, 8, 8>(),
            (_, 1) => self.in_runs::<I, 16, 4>(),
            (_, _) => self.in_runs::<I, 4, 4>(),
        }
    }
}

impl<const D: usize> Superposition<'_, D> {
    #[inline(always)]
    fn in_runs<I: Instructions, const LONG: usize, const SHORT: usize>(mut self) {
        let length = self.sums[0].len();
        let long = length / LONG * LONG;
        for start in (0..long).step_by(LONG) {
            self.in_run::<I, LONG>(start);
        }
        for start in (long..length).step_by(SHORT) {
            self.in_run::<I, SHORT>(start);
        }
    }

    /// A run, of which there may be less than `RUN` to write.
    #[inline(always)]
    fn in_run<I: Instructions, const RUN: usize>(&mut self, start: usize) {
        let Self { table, terms, first, sums } = self;
        let (mut re, mut im) = ([[0.0; RUN]; D], [[0.0; RUN]; D]);
        for term in *terms {
            let at = term.start + *first + start;
            let run = |part: &[f32]| -> [f32; RUN] {
                *part[at..].first_chunk().expect("a table is longer than its runs reach")
            };
            let (table_re, table_im) = (run(&table.re), run(&table.im));
            // Lanes outside and drives inside: only so do the sums become registers.
            for lane in 0..RUN {
                for drive in 0..D {
                    let (u_re, u_im) = (term.re[drive], term.im[drive]);
                    re[drive][lane] = fused::<I>(table_re[lane], u_re, re[drive][lane]);
                    im[drive][lane] = fused::<I>(table_re[lane], u_im, im[drive][lane]);
                    re[drive][lane] = fused::<I>(table_im[lane], -u_im, re[drive][lane]);
                    im[drive][lane] = fused::<I>(table_im[lane], u_re, im[drive][lane]);
                }
            }
        }
        for (sum, (re, im)) in sums.iter_mut().zip(re.iter().zip(&im)) {
            for (to, (re, im)) in sum[start..].iter_mut().zip(re.iter().zip(im)) {
                *to = Complex32::new(*re, *im);
            }
        }
    }
}

/// Rows that are weighted from the same lines.
pub const ROWS: usize = 4;

/// Lines of numbers, each `stride` after the one before, with a weight for every row and line.
#[derive(Clone, Copy, Debug)]
pub struct Lines<'a> {
    pub values: &'a [f32],
    pub stride: usize,
    /// Those of the first row, then of the next.
    pub weights: &'a [f32],
}

/// Where sums go: rows of `length` numbers, each `stride` after the one before.
#[derive(Debug)]
pub struct Rows<'a> {
    pub values: &'a mut [f32],
    pub stride: usize,
    pub length: usize,
}

/// Weighted sums of lines, one or [`ROWS`] rows of them: the interpolation's inner loop.
pub fn weighted_sums(rows: usize, lines: &Lines<'_>, sums: &mut Rows<'_>) {
    Isa::best().run(WeightedSums { rows, lines, sums });
}

struct WeightedSums<'a, 'b, 'c> {
    rows: usize,
    lines: &'a Lines<'b>,
    sums: &'a mut Rows<'c>,
}

impl Kernel for WeightedSums<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { rows, lines, sums } = self;
        match (I::WIDTH, rows) {
            (16, ROWS) => weighted_runs::<I, ROWS, 64, 16>(lines, sums),
            (8, ROWS) => weighted_runs::<I, ROWS, 16, 8>(lines, sums),
            (_, ROWS) => weighted_runs::<I, ROWS, 8, 4>(lines, sums),
            (16, _) => weighted_runs::<I, 1, 128, 16>(lines, sums),
            (8, _) => weighted_runs::<I, 1, 64, 8>(lines, sums),
            (_, _) => weighted_runs::<I, 1, 32, 4>(lines, sums),
        }
    }
}

/// `R` rows of weighted sums, `LONG` neighbours at a time, then `SHORT`, then one.
#[inline(always)]
fn weighted_runs<I: Instructions, const R: usize, const LONG: usize, const SHORT: usize>(
    lines: &Lines<'_>,
    sums: &mut Rows<'_>,
) {
    let long = sums.length / LONG * LONG;
    for start in (0..long).step_by(LONG) {
        weighted_run::<I, R, LONG>(lines, sums, start);
    }
    let short = sums.length / SHORT * SHORT;
    for start in (long..short).step_by(SHORT) {
        weighted_run::<I, R, SHORT>(lines, sums, start);
    }
    for start in short..sums.length {
        weighted_run::<I, R, 1>(lines, sums, start);
    }
}

#[inline(always)]
fn weighted_run<I: Instructions, const R: usize, const RUN: usize>(
    lines: &Lines<'_>,
    sums: &mut Rows<'_>,
    start: usize,
) {
    let taps = lines.weights.len() / R;
    let mut totals = [[0.0; RUN]; R];
    for tap in 0..taps {
        let values: [f32; RUN] =
            *lines.values[tap * lines.stride + start..].first_chunk().expect("a line is as long as the sum");
        let weights: [f32; R] = std::array::from_fn(|row| lines.weights[row * taps + tap]);
        // Lanes outside and rows inside: only so do the totals become registers.
        for lane in 0..RUN {
            for row in 0..R {
                totals[row][lane] = fused::<I>(weights[row], values[lane], totals[row][lane]);
            }
        }
    }
    for (row, total) in totals.iter().enumerate() {
        sums.values[row * sums.stride + start..][..RUN].copy_from_slice(total);
    }
}
