//! The sound at pixels or cells, and sums of a formula over the drives' sounds.

use std::ops::Range;

use num_complex::Complex32;
use rayon::prelude::*;

use crate::field::interpolation::{Between, interpolate};
use crate::field::quantity::{Part, Sound, Sounds};
use crate::field::stages::job::Job;
use crate::field::stages::samples::Samples;
use crate::field::stages::site::Filled;

/// Points per evaluation of a formula.
pub(super) const RUN: usize = 1024;

/// The parts of the sound at a lattice, in their order; reused, since fresh memory costs more than the computation.
#[derive(Debug, Default)]
pub(super) struct Lattice(pub(super) Vec<Vec<Complex32>>);

impl Lattice {
    pub(super) fn resize(&mut self, parts: u8, count: usize) {
        self.0.resize_with(parts.count_ones() as usize, Vec::new);
        self.0.iter_mut().for_each(|part| part.resize(count, Complex32::ZERO));
    }

    /// Bytes of memory kept.
    pub(super) fn bytes(&self) -> usize {
        self.0.iter().map(|part| part.capacity() * size_of::<Complex32>()).sum()
    }

    pub(super) fn sounds(&self, parts: u8, places: Range<usize>) -> Sounds<'_> {
        Sounds::of(parts, self.0.iter().map(|part| &part[places.clone()]))
    }

    pub(super) fn sound(&self, parts: u8, place: usize) -> Sound {
        let mut sound = Sound::default();
        for (part, values) in Part::of(parts).zip(&self.0) {
            *sound.part_mut(part) = values[place];
        }
        sound
    }
}

/// Sums of the formula at the cells over some of the drives, and the sound of one of them.
#[derive(Debug, Default)]
pub(super) struct Share {
    pub(super) sums: Vec<f64>,
    lattice: Lattice,
    between: Between,
}

impl Share {
    pub(super) fn sum(&mut self, job: &Job<'_>, filled: &Filled, drives: &[Samples]) {
        let Self { sums, lattice, between } = self;
        let (parts, constants) = (job.key.parts, job.request.constants().narrow());
        let formula = job.request.quantity.declaration().formula;
        let (Some(grid), Some(weights)) = (&job.site.plan.grid, &filled.weights) else { return };
        let (columns, count) = (grid.samples.columns.len(), filled.cells.count());
        sums.clear();
        sums.resize(count, 0.0);
        lattice.resize(parts, count);
        for samples in drives {
            for (part, values) in Part::of(parts).zip(&mut lattice.0) {
                let [across, up] = weights.of(part);
                interpolate(samples.of(part), columns, across, up, between, values);
            }
            sums.par_chunks_mut(RUN).enumerate().with_min_len(16).for_each(|(run, sums)| {
                let mut of_drive = [0.0; RUN];
                let of_drive = &mut of_drive[..sums.len()];
                let places = run * RUN..run * RUN + sums.len();
                formula(lattice.sounds(parts, places), &constants, of_drive);
                sums.iter_mut().zip(of_drive).for_each(|(sum, of_drive)| *sum += f64::from(*of_drive));
            });
        }
    }

    /// Bytes of memory kept.
    pub(super) fn bytes(&self) -> usize {
        let Self { sums, lattice, between } = self;
        sums.capacity() * size_of::<f64>() + lattice.bytes() + between.bytes()
    }
}
