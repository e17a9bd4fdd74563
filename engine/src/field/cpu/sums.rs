//! Sums over contiguous numbers: superposition from a table, and interpolation.

use num_complex::Complex32;

use crate::simd::{Instructions, Isa, Kernel, fused};

/// Values that a run of [`superpose`] may read beyond its end.
pub const OVERHANG: usize = 64;

/// Complex numbers with their real and imaginary parts apart, as vector registers like them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Split {
    pub re: Vec<f32>,
    pub im: Vec<f32>,
}

/// An element's contribution to `D` superpositions: the start of its run in the table, and its excitations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term<const D: usize> {
    pub start: usize,
    pub re: [f32; D],
    pub im: [f32; D],
}

/// Drives superposed together, sharing each read of the table.
pub const DRIVES: usize = 4;

/// Adds up runs of `table`, one per term, with the term's excitations, and adds that to `sums`: Σ u · table(start + first + i), for one
/// drive or [`DRIVES`], whose sums are of one length.
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
        // Sums stay in registers, enough of them to hide latency.
        match (I::WIDTH, D) {
            (16, 1) => self.in_runs::<I, 64>(),
            (16, _) => self.in_runs::<I, 32>(),
            (8, 1) => self.in_runs::<I, 32>(),
            (8, _) => self.in_runs::<I, 8>(),
            (_, 1) => self.in_runs::<I, 16>(),
            (_, _) => self.in_runs::<I, 4>(),
        }
    }
}

impl<const D: usize> Superposition<'_, D> {
    /// The remainder is a full overlapping run, too: a shorter one would take as long by latency.
    #[inline(always)]
    fn in_runs<I: Instructions, const RUN: usize>(mut self) {
        for start in (0..self.sums[0].len()).step_by(RUN) {
            self.in_run::<I, RUN>(start);
        }
    }

    /// A run, of which possibly fewer than `RUN` values are written.
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
            // Lanes outside and drives inside: required for sums in registers.
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
                *to += Complex32::new(*re, *im);
            }
        }
    }
}

/// Rows weighted from the same lines.
pub const ROWS: usize = 4;

/// Lines of numbers, each `stride` after the one before, with a weight for every row and line.
#[derive(Clone, Copy, Debug)]
pub struct Lines<'a> {
    pub values: &'a [f32],
    pub stride: usize,
    /// Weights of the first row, then of the next.
    pub weights: &'a [f32],
}

/// Output of sums: rows of `length` numbers, each `stride` after the previous one.
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

/// `R` rows of weighted sums, `LONG` neighbours at a time, of shorter rows `SHORT`, of the shortest one. The last run
/// ends with the row and overlaps the previous one: faster than shorter runs, which are bound by latency.
#[inline(always)]
fn weighted_runs<I: Instructions, const R: usize, const LONG: usize, const SHORT: usize>(
    lines: &Lines<'_>,
    sums: &mut Rows<'_>,
) {
    if sums.length >= LONG {
        weighted_whole::<I, R, LONG>(lines, sums);
    } else if sums.length >= SHORT {
        weighted_whole::<I, R, SHORT>(lines, sums);
    } else {
        weighted_whole::<I, R, 1>(lines, sums);
    }
}

#[inline(always)]
fn weighted_whole<I: Instructions, const R: usize, const RUN: usize>(lines: &Lines<'_>, sums: &mut Rows<'_>) {
    for start in (0..sums.length).step_by(RUN) {
        weighted_run::<I, R, RUN>(lines, sums, start.min(sums.length - RUN));
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
        // Lanes outside and rows inside: required for totals in registers.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from -1 to 1 in no order.
    fn scattered(count: usize, seed: f64) -> Vec<f32> {
        (0..count).map(|i| (2.0 * ((i as f64 + seed) * 0.618_034).fract() - 1.0) as f32).collect()
    }

    /// Shorter than any run, as long as one, and with every rest.
    fn lengths() -> impl Iterator<Item = usize> {
        (1..100).chain([124, 127, 128, 129, 190, 256, 257])
    }

    fn superposed<const D: usize>(isa: Isa, length: usize) {
        const TERMS: usize = 7;
        let reach = length + 3 * TERMS;
        let part = |seed| scattered(reach + OVERHANG, seed);
        let table = Split { re: part(0.1), im: part(0.7) };
        let u = |i: usize| std::array::from_fn(|drive| (i as f32 - 3.0) * 0.2 + drive as f32);
        let terms: Vec<_> = (0..TERMS).map(|i| Term::<D> { start: 3 * i, re: u(i), im: u(2 * i) }).collect();
        let mut sums: [_; D] = std::array::from_fn(|_| vec![Complex32::ZERO; length]);
        let first = 2;
        isa.run(Superposition {
            table: &table,
            terms: &terms,
            first,
            sums: sums.each_mut().map(Vec::as_mut_slice),
        });
        for (drive, sums) in sums.iter().enumerate() {
            for (i, sum) in sums.iter().enumerate() {
                let product = |term: &Term<D>| {
                    let at = term.start + first + i;
                    Complex32::new(table.re[at], table.im[at])
                        * Complex32::new(term.re[drive], term.im[drive])
                };
                let expected: Complex32 = terms.iter().map(product).sum();
                assert!((sum - expected).norm() < 1e-4, "{isa:?}, {i} of {length}: {sum} is not {expected}");
            }
        }
    }

    #[test]
    fn runs_of_every_length_are_superposed_by_every_set_of_instructions() {
        for isa in Isa::available() {
            for length in lengths() {
                superposed::<1>(isa, length);
                superposed::<DRIVES>(isa, length);
            }
        }
    }

    #[test]
    fn rows_of_every_length_are_weighted_by_every_set_of_instructions() {
        const TAPS: usize = 5;
        for isa in Isa::available() {
            for (rows, length) in lengths().flat_map(|length| [(1, length), (ROWS, length)]) {
                let (values, weights) = (scattered(TAPS * length, 0.3), scattered(rows * TAPS, 0.9));
                let lines = Lines { values: &values, stride: length, weights: &weights };
                // A gap between the rows is not handed out.
                let stride = length + 3;
                let mut sums = vec![7.0; rows * stride];
                let mut out = Rows { values: &mut sums, stride, length };
                isa.run(WeightedSums { rows, lines: &lines, sums: &mut out });
                for (row, sums) in sums.chunks(stride).enumerate() {
                    for (i, &sum) in sums.iter().enumerate() {
                        let product = |tap: usize| weights[row * TAPS + tap] * values[tap * length + i];
                        let expected = if i < length { (0..TAPS).map(product).sum() } else { 7.0f32 };
                        assert!((sum - expected).abs() < 1e-5, "{isa:?}, {i} of {length}: {sum}, {expected}");
                    }
                }
            }
        }
    }
}
