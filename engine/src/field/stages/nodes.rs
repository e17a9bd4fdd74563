//! Nodes of polynomials between which pixels are interpolated, beside places that these must not reach across.

use std::ops::Range;

use glam::DVec3;

use crate::field::interpolation::Resampling;
use crate::scene::Plane;

/// Nodes along each side of a polynomial.
const TAPS: usize = 6;
/// The error of a polynomial through so many nodes for e^{jkx}, over (kh)^6: the product of the distances to the nodes
/// by 6!, along both axes.
const OF_POLYNOMIALS: f64 = 2.0 * 3.52 / 720.0;
/// The polynomials' part of the tolerance.
const SHARE: f64 = 0.25;

/// The step (m) of nodes for waves up to a wavenumber (rad/m).
pub(super) fn step(tolerance: f64, wavenumber: f64) -> f64 {
    (SHARE * tolerance / OF_POLYNOMIALS).powf(1.0 / TAPS as f64) / wavenumber
}

/// A lattice over some columns and rows of pixels.
#[derive(Debug)]
pub(super) struct Nodes {
    /// Columns and rows of pixels.
    over: [Range<usize>; 2],
    origin: DVec3,
    /// From node to node.
    steps: [DVec3; 2],
    pub(super) counts: [usize; 2],
    pub(super) across: Resampling,
    pub(super) up: Resampling,
}

impl Nodes {
    /// Those over columns and rows of the pixels of a plane, a step (m) apart. `None` if they would be hardly fewer than the
    /// pixels.
    pub(super) fn new(
        (plane, [x, y, _]): (&Plane, [DVec3; 3]),
        (width, height): (usize, usize),
        over: [Range<usize>; 2],
        step: f64,
    ) -> Option<Self> {
        let sizes = [plane.size.x / width as f64, plane.size.y / height as f64];
        if 1.5 * sizes[0] * sizes[1] > step * step {
            return None;
        }
        let along = |axis: usize| {
            let pixel = |index: usize| sizes[axis] * (index as f64 + 0.5) - plane.size[axis] / 2.0;
            let margin = TAPS / 2 - 1;
            let begin = pixel(over[axis].start) - step * margin as f64;
            let mut resampling = Resampling { taps: TAPS, ..Resampling::default() };
            for index in over[axis].clone() {
                let place = (pixel(index) - begin) / step;
                let first = (place.floor() as usize).saturating_sub(margin);
                resampling.first.push(first as u32);
                let own = place - first as f64;
                let weight = |tap: usize| {
                    let others = (0..TAPS).filter(|other| *other != tap).map(|other| other as f64);
                    others.map(|other| (own - other) / (tap as f64 - other)).product::<f64>() as f32
                };
                resampling.weights.extend((0..TAPS).map(weight));
            }
            let count = resampling.first.last().map_or(0, |first| *first as usize + TAPS);
            (begin, count, resampling)
        };
        let ((left, columns, across), (low, lines, up)) = (along(0), along(1));
        let origin = plane.centre + x * left + y * low;
        Some(Self { over, origin, steps: [x * step, y * step], counts: [columns, lines], across, up })
    }

    pub(super) fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    pub(super) fn point(&self, node: usize) -> DVec3 {
        let [column, row] = [node % self.counts[0], node / self.counts[0]];
        self.origin + self.steps[0] * column as f64 + self.steps[1] * row as f64
    }

    /// The pixels that it covers, by their numbers from the start of a row, in a raster of a width.
    pub(super) fn pixels(&self, width: usize, first_row: usize) -> impl Iterator<Item = usize> {
        let [columns, rows] = self.over.clone();
        rows.flat_map(move |row| columns.clone().map(move |column| (row - first_row) * width + column))
    }
}

/// The pixels all of whose samples are outside bodies.
pub(super) fn clear_of(is_outside: &[bool], columns: usize, [across, up]: [&Resampling; 2]) -> Vec<bool> {
    let rows = is_outside.len() / columns;
    // Samples within bodies at all columns and rows before.
    let mut sums = vec![0u32; (columns + 1) * (rows + 1)];
    let at = |column: usize, row: usize| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let own = u32::from(!is_outside[row * columns + column]);
            sums[at(column + 1, row + 1)] =
                own + sums[at(column, row + 1)] + sums[at(column + 1, row)] - sums[at(column, row)];
        }
    }
    let is_clear = |(column, row): (u32, u32)| {
        let [left, low] = [column as usize, row as usize];
        let [right, high] = [left + across.taps, low + up.taps];
        sums[at(right, high)] + sums[at(left, low)] == sums[at(left, high)] + sums[at(right, low)]
    };
    let pixels = up.first.iter().flat_map(|row| across.first.iter().map(move |column| (*column, *row)));
    pixels.map(is_clear).collect()
}
