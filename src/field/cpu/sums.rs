//! Sums of runs of numbers that lie in memory: superposition of a table, and interpolation.

use num_complex::Complex32;

use crate::field::cpu::{Instructions, fused};

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

#[inline(always)]
pub(super) fn superpose<I: Instructions, const RUN: usize>(
    table: &Split,
    terms: &[Term],
    first: usize,
    sum: &mut [Complex32],
) {
    let (runs, rest) = sum.as_chunks_mut::<RUN>();
    for (index, run) in runs.iter_mut().enumerate() {
        superpose_run::<I, RUN>(table, terms, first + index * RUN, run);
    }
    let first = first + runs.len() * RUN;
    for (index, run) in rest.chunks_mut(OVERHANG).enumerate() {
        superpose_run::<I, OVERHANG>(table, terms, first + index * OVERHANG, run);
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

#[inline(always)]
pub(super) fn weighted_sum<I: Instructions>(lines: &[f32], stride: usize, weights: &[f32], sum: &mut [f32]) {
    const RUN: usize = 64;
    let (runs, rest) = sum.as_chunks_mut::<RUN>();
    for (index, run) in runs.iter_mut().enumerate() {
        let mut total = [0.0; RUN];
        for (line, weight) in weights.iter().enumerate() {
            let start = line * stride + index * RUN;
            let values: &[f32; RUN] = lines[start..].first_chunk().expect("a line is as long as the sum");
            for lane in 0..RUN {
                total[lane] = fused::<I>(*weight, values[lane], total[lane]);
            }
        }
        *run = total;
    }
    let first = runs.len() * RUN;
    for (index, value) in rest.iter_mut().enumerate() {
        let at = |line: usize| lines[line * stride + first + index];
        *value = weights.iter().enumerate().map(|(line, weight)| weight * at(line)).sum();
    }
}
