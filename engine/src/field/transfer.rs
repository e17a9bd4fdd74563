//! The transfer from every element to every sample of a plan as a table in memory, and its product with drives.
//!
//! Where a sample axis is shared ([`crate::field::plan::Shared`]), the transfer from element n to sample i equals
//! that from element 0 to the sample `n · shared.samples` before it. One longer line of samples then serves all
//! elements along that axis: a plane parallel to a 16 x 16 array needs a table of 0.4 MB instead of 35 MB, which
//! stays in the fastest caches. Otherwise the table is stored in the order of access. Tables above 256 MiB
//! ([`crate::field::plan::TABLE_CEILING`]) are not built; each superposition then evaluates the waves again.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::acoustics::{Element, Face};
use crate::field::cpu::{self, LANES, OVERHANG, Points, Split, Term};
use crate::field::plan::Shared;
use crate::field::samples::Samples;
use crate::field::slope::{shifted, stencil};
use crate::field::sources::{self, Wave};
use crate::memory;

/// The index in the table of the transfer from an element of a board to a sample.
///
/// Sample number p, row by row, is `p % line` on line `p / line`; line `l` of the element (column, row) starts at
/// `base + l · line_stride + column · element_strides[0] + row · element_strides[1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    pub line: usize,
    pub line_stride: usize,
    pub base: usize,
    pub element_strides: [isize; 2],
    /// Elements of different transfer, by column and row; the others repeat the first's.
    pub distinct: [usize; 2],
    /// Points of the table: for each of its rows and each distinct element one run of its columns.
    pub points: Samples,
    /// Length of a run.
    pub run: usize,
}

impl Layout {
    /// The layout of a board's elements, at samples in its coordinates that repeat from element to element according to
    /// `shared`.
    pub fn new(board: &Face, samples: &Samples, shared: [Option<Shared>; 2]) -> Self {
        let count = board.layout.positions.len();
        // Elements without rows count as one row.
        let along = board.layout.columns.unwrap_or(count);
        let counts = [along, count / along];
        let Samples { columns, rows } = samples;
        if shared == [None; 2] {
            // Blocks of neighbouring samples, all elements after each other: read from end to end.
            return Self {
                line: LANES,
                line_stride: LANES * count,
                base: 0,
                element_strides: [LANES as isize, (LANES * counts[0]) as isize],
                distinct: counts,
                points: samples.clone(),
                run: LANES,
            };
        }
        let extended =
            [(0, columns), (1, rows)].map(|(axis, places)| Extended::new(shared[axis], places, &counts));
        let [columns, rows] = &extended;
        let mut distinct = counts;
        for shared in shared.into_iter().flatten() {
            distinct[shared.element_axis] = 1;
        }
        let run = columns.places.len();
        let line_stride = run * distinct[0] * distinct[1];
        // One axis at least is shared, so that the runs of the other's elements follow each other.
        let mut element_strides = [run as isize; 2];
        for (shared, stride) in shared.iter().zip([1, line_stride as isize]) {
            if let Some(shared) = shared {
                element_strides[shared.element_axis] = -shared.samples * stride;
            }
        }
        Self {
            line: samples.columns.len(),
            line_stride,
            base: columns.before + rows.before * line_stride,
            element_strides,
            distinct,
            points: Samples { columns: columns.places.clone(), rows: rows.places.clone() },
            run,
        }
    }

    /// Values of the table.
    pub fn count(&self) -> usize {
        self.points.len().next_multiple_of(self.run) * self.distinct[0] * self.distinct[1]
    }

    /// Whether these tables together are within the limit and fit memory.
    pub fn fit(layouts: &[Self], most_bytes: usize) -> bool {
        /// Bytes that need no question.
        const SMALL: usize = 32 << 20;
        let values = layouts.iter().map(Self::count).fold(0, usize::saturating_add);
        let bytes = values.saturating_mul(size_of::<Complex32>());
        bytes <= most_bytes && (bytes <= SMALL || memory::holds(bytes))
    }

    /// The elements with waves in the table, at full drive, with their tilts.
    pub fn elements(&self, board: &Face, wave: &Wave) -> (Vec<[f32; 4]>, Vec<[f32; 4]>) {
        let along = board.layout.columns.unwrap_or(self.distinct[0]);
        let numbers = || {
            (0..self.distinct[0] * self.distinct[1])
                .map(|i| i / self.distinct[0] * along + i % self.distinct[0])
        };
        let elements = numbers().map(|n| wave.element(board.layout.positions[n], 1.0, 0.0)).collect();
        (elements, sources::tilts(&board.layout, numbers()))
    }

    /// The elements of a board that sound in any of some excitations (one value per element of the array): the start
    /// of their runs for the first line, and u.
    pub fn terms<const D: usize>(&self, board: &Face, excitations: [&[Complex64]; D]) -> Vec<Term<D>> {
        let along = board.layout.columns.unwrap_or(board.layout.positions.len());
        let start = |n: usize| {
            let place = [n % along, n / along];
            let offset = [0, 1].map(|axis| place[axis] as isize * self.element_strides[axis]);
            self.base.wrapping_add_signed(offset[0] + offset[1])
        };
        let term = |n: usize| {
            let u = excitations.map(|excitation| board.gain * excitation[n]);
            let sounds = u.iter().any(|u| *u != Complex64::ZERO);
            let start = start(n - board.first);
            sounds.then(|| Term { start, re: u.map(|u| u.re as f32), im: u.map(|u| u.im as f32) })
        };
        board.elements().filter_map(term).collect()
    }
}

/// The samples along one axis, and their shifted positions for elements beyond the first.
struct Extended {
    places: Vec<DVec3>,
    /// Number of them before the samples themselves.
    before: usize,
}

impl Extended {
    fn new(shared: Option<Shared>, places: &[DVec3], counts: &[usize; 2]) -> Self {
        let Some(Shared { element_axis, samples }) = shared else {
            return Self { places: places.to_vec(), before: 0 };
        };
        let more = samples.unsigned_abs() * (counts[element_axis] - 1);
        let before = if samples > 0 { more } else { 0 };
        let step = if places.len() > 1 { places[1] - places[0] } else { DVec3::ZERO };
        let place = |i: usize| places[0] + step * (i as f64 - before as f64);
        Self { places: (0..places.len() + more).map(place).collect(), before }
    }
}

/// The table of one board.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    pub layout: Layout,
    table: Split,
}

impl Transfer {
    /// Evaluates the waves of all distinct elements, in the memory of `old`.
    pub fn new(board: &Face, wave: &Wave, layout: Layout, old: Option<Self>) -> Self {
        let mut table = old.map_or_else(Split::default, |old| old.table);
        for part in [&mut table.re, &mut table.im] {
            part.resize(layout.count() + OVERHANG, 0.0);
        }
        let (elements, tilts) = layout.elements(board, wave);
        let row = layout.run * elements.len();
        let whole = layout.count();
        let parts = (table.re[..whole].par_chunks_mut(row), table.im[..whole].par_chunks_mut(row));
        parts.into_par_iter().enumerate().for_each(|(index, (re, im))| {
            for start in (0..layout.run).step_by(LANES) {
                let first = index * layout.run + start;
                let count = LANES.min(layout.run - start).min(layout.points.len() - first);
                let points = Points::new(wave, count, |lane| layout.points.point(first + lane));
                cpu::single_waves(wave, (&elements, &tilts), &points, |element, (wave_re, wave_im)| {
                    let run = element * layout.run + start..element * layout.run + start + count;
                    re[run.clone()].copy_from_slice(&wave_re[..count]);
                    im[run].copy_from_slice(&wave_im[..count]);
                });
            }
        });
        Self { layout, table }
    }

    /// The table of the pressure at samples, or of its slope along a direction, in the memory of `old`. `None` if f32
    /// declines.
    pub fn of_part(
        (element, board): (&Element, &Face),
        samples: &Samples,
        shared: [Option<Shared>; 2],
        direction: Option<DVec3>,
        old: Option<Self>,
    ) -> Option<Self> {
        let Some(direction) = direction else {
            let samples = samples.seen_from(&board.pose);
            let wave = Wave::new(element, &board.layout, &samples)?;
            return Some(Self::new(board, &wave, Layout::new(board, &samples, shared), old));
        };
        let (mut slope, mut one) = (None::<Self>, old);
        for (shift, weight) in stencil(TAU / element.wavenumber) {
            let shifted = shifted(samples, direction * shift);
            let samples = shifted.seen_from(&board.pose);
            let wave = Wave::new(element, &board.layout, &samples)?;
            let table = Self::new(board, &wave, Layout::new(board, &samples, shared), one.take());
            match &mut slope {
                None => slope = Some(table.times(weight as f32)),
                Some(slope) => {
                    slope.add(weight as f32, &table);
                    one = Some(table);
                }
            }
        }
        slope
    }

    fn times(mut self, factor: f32) -> Self {
        let Split { re, im } = &mut self.table;
        re.iter_mut().chain(im).for_each(|value| *value *= factor);
        self
    }

    /// Adds a multiple of another table of this layout.
    fn add(&mut self, factor: f32, other: &Self) {
        let Split { re, im } = &mut self.table;
        let pairs = re.iter_mut().zip(&other.table.re).chain(im.iter_mut().zip(&other.table.im));
        pairs.for_each(|(value, other)| *value += factor * other);
    }

    /// Adds a board's pressure to `fields`, the complex pressure (Pa, peak) at the samples of the plan for each of
    /// several drives (u of every element of the array): a matrix product with each read of the table shared by
    /// several drives.
    pub fn superpose(&self, board: &Face, excitations: &[Vec<Complex64>], fields: &mut [Vec<Complex32>]) {
        let (together, alone) = excitations.as_chunks::<{ cpu::DRIVES }>();
        let (fields_together, fields_alone) = fields.as_chunks_mut::<{ cpu::DRIVES }>();
        for (excitations, fields) in together.iter().zip(fields_together) {
            self.superpose_together(board, excitations, fields);
        }
        for (excitation, field) in alone.as_chunks::<1>().0.iter().zip(fields_alone.as_chunks_mut::<1>().0) {
            self.superpose_together(board, excitation, field);
        }
    }

    fn superpose_together<const D: usize>(
        &self,
        board: &Face,
        excitations: &[Vec<Complex64>; D],
        fields: &mut [Vec<Complex32>; D],
    ) {
        let Layout { line, line_stride, .. } = self.layout;
        let terms = self.layout.terms(board, excitations.each_ref().map(Vec::as_slice));
        let count = fields[0].len().div_ceil(line);
        let mut lines = fields.each_mut().map(|field| field.chunks_mut(line));
        let lines: Vec<_> =
            (0..count).map(|_| lines.each_mut().map(|lines| lines.next().unwrap_or_default())).collect();
        lines.into_par_iter().enumerate().with_min_len(4).for_each(|(index, sums)| {
            cpu::superpose(&self.table, &terms, index * line_stride, sums);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::Scene;

    #[test]
    fn a_table_that_no_machine_holds_does_not_fit() {
        let aperture = Aperture::new(&Scene::default());
        let samples = Samples { columns: vec![DVec3::X; 64], rows: vec![DVec3::Y; 64] };
        let own = Layout::new(&aperture.faces[0], &samples, [None, None]);
        let endless = Layout { distinct: [1 << 24, 1 << 20], ..own.clone() };
        assert!(Layout::fit(&[own], usize::MAX) && !Layout::fit(&[endless], usize::MAX));
    }
}
