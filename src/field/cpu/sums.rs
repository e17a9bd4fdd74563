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

/// An element's part in a superposition: where its run starts in the table, and its excitation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    pub start: usize,
    pub re: f32,
    pub im: f32,
}

/// Adds up runs of `table`, one per term, with the term's excitation: sum_i = Σ u · table(start + first + i).
///
/// The table must have [`OVERHANG`] values more than the runs reach.
pub fn superpose(table: &Split, terms: &[Term], first: usize, sum: &mut [Complex32]) {
    Isa::best().run(Superposition { table, terms, first, sum });
}

struct Superposition<'a> {
    table: &'a Split,
    terms: &'a [Term],
    first: usize,
    sum: &'a mut [Complex32],
}

impl Kernel for Superposition<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        match I::WIDTH {
            16 => self.in_runs::<I, 64>(),
            8 => self.in_runs::<I, 32>(),
            _ => self.in_runs::<I, 16>(),
        }
    }
}

impl Superposition<'_> {
    #[inline(always)]
    fn in_runs<I: Instructions, const RUN: usize>(self) {
        let Self { table, terms, first, sum } = self;
        let (runs, rest) = sum.as_chunks_mut::<RUN>();
        for (index, run) in runs.iter_mut().enumerate() {
            superpose_run::<I, RUN>(table, terms, first + index * RUN, run);
        }
        let first = first + runs.len() * RUN;
        for (index, run) in rest.chunks_mut(OVERHANG).enumerate() {
            superpose_run::<I, OVERHANG>(table, terms, first + index * OVERHANG, run);
        }
    }
}

/// A run whose sums stay in registers; `out` may be shorter than it.
#[inline(always)]
fn superpose_run<I: Instructions, const RUN: usize>(
    table: &Split,
    terms: &[Term],
    first: usize,
    out: &mut [Complex32],
) {
    let (mut re, mut im) = ([0.0; RUN], [0.0; RUN]);
    for term in terms {
        let start = term.start + first;
        let run = |part: &[f32]| -> [f32; RUN] {
            *part[start..].first_chunk().expect("a table is longer than its runs reach")
        };
        let (table_re, table_im) = (run(&table.re), run(&table.im));
        for lane in 0..RUN {
            re[lane] = fused::<I>(table_re[lane], term.re, re[lane]);
            im[lane] = fused::<I>(table_re[lane], term.im, im[lane]);
            re[lane] = fused::<I>(table_im[lane], -term.im, re[lane]);
            im[lane] = fused::<I>(table_im[lane], term.re, im[lane]);
        }
    }
    for (out, (re, im)) in out.iter_mut().zip(re.iter().zip(&im)) {
        *out = Complex32::new(*re, *im);
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
            (16, ROWS) => weighted_runs::<I, ROWS, 16, 4>(lines, sums),
            (8, ROWS) => weighted_runs::<I, ROWS, 8, 2>(lines, sums),
            (_, ROWS) => weighted_runs::<I, ROWS, 4, 2>(lines, sums),
            (16, _) => weighted_runs::<I, 1, 16, 4>(lines, sums),
            (8, _) => weighted_runs::<I, 1, 8, 8>(lines, sums),
            (_, _) => weighted_runs::<I, 1, 4, 8>(lines, sums),
        }
    }
}

/// `R` rows of weighted sums, `V` vectors of `LANES` neighbours at a time.
#[inline(always)]
fn weighted_runs<I: Instructions, const R: usize, const LANES: usize, const V: usize>(
    lines: &Lines<'_>,
    sums: &mut Rows<'_>,
) {
    let taps = lines.weights.len() / R;
    let run = V * LANES;
    let whole = sums.length / run * run;
    for start in (0..whole).step_by(run) {
        let mut totals = [[[0.0; LANES]; V]; R];
        for tap in 0..taps {
            let values = lines.values[tap * lines.stride + start..][..run].as_chunks::<LANES>().0;
            for row in 0..R {
                let weight = lines.weights[row * taps + tap];
                for vector in 0..V {
                    // One expression per lane becomes vector code, whatever stands around it.
                    let (total, values) = (totals[row][vector], &values[vector]);
                    totals[row][vector] =
                        std::array::from_fn(|lane| fused::<I>(weight, values[lane], total[lane]));
                }
            }
        }
        for (row, total) in totals.iter().enumerate() {
            sums.values[row * sums.stride + start..][..run].copy_from_slice(total.as_flattened());
        }
    }
    for (row, weights) in lines.weights.chunks_exact(taps).enumerate() {
        for index in whole..sums.length {
            let at = |tap: usize| lines.values[tap * lines.stride + index];
            let sum = weights.iter().enumerate().map(|(tap, weight)| weight * at(tap)).sum();
            sums.values[row * sums.stride + index] = sum;
        }
    }
}

/// The places in a colour table of magnitudes: |p| times `scale`, rounded. There are as many as pressures.
pub fn places(field: &[Complex32], scale: f32, places: &mut [u8]) {
    Isa::best().run(Places { field, scale, places });
}

struct Places<'a> {
    field: &'a [Complex32],
    scale: f32,
    places: &'a mut [u8],
}

impl Kernel for Places<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { field, scale, places } = self;
        const RUN: usize = 32;
        /// Adding this rounds a small number into the last bits.
        const ROUNDER: f32 = 8_388_608.0;
        // No hypotenuse that guards against overflow: pressures are nowhere near it.
        let place = |p: &Complex32| {
            let magnitude = (p.re * p.re + p.im * p.im).sqrt();
            ((magnitude * scale).min(255.0) + ROUNDER).to_bits() as u8
        };
        let (runs, rest) = places.as_chunks_mut::<RUN>();
        let (fields, field_rest) = field.as_chunks::<RUN>();
        for (run, field) in runs.iter_mut().zip(fields) {
            for (to, p) in run.iter_mut().zip(field) {
                *to = place(p);
            }
        }
        for (to, p) in rest.iter_mut().zip(field_rest) {
            *to = place(p);
        }
    }
}
