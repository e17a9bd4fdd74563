//! The stages on the CPU.

use std::ops::Range;

use num_complex::Complex32;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::interpolation::{Between, interpolate};
use crate::field::plan::{Grid, TABLE_CEILING};
use crate::field::stages::{Job, Kept, Painted, Setting, Sounding, Wanted, Work, excitation};
use crate::field::transfer::{Layout, Transfer};
use crate::field::{self, Samples, Wave};

#[derive(Debug, Default)]
pub(super) struct OnCpu {
    superposition: Superposition,
    samples: Kept<(Sounding, bool), Vec<Complex32>>,
    between: Between,
    field: Vec<Complex32>,
    picture: Kept<Painted, Vec<[u8; 4]>>,
}

/// Sums over the elements at the samples of a plan, from a table where there is room for one.
#[derive(Debug, Default)]
pub(super) struct Superposition {
    transfer: Kept<Setting, Option<Transfer>>,
}

impl Superposition {
    pub(super) fn forget(&mut self) {
        self.transfer.key = None;
    }

    /// Complex pressure (Pa, peak) at the samples for every drive.
    pub(super) fn at(
        &mut self,
        setting: &Setting,
        grid: &Grid,
        aperture: &Aperture,
        drives: &[Drive],
        double: bool,
        work: &mut Work,
    ) -> Vec<Vec<Complex32>> {
        work.superposition += 1;
        let each = |drive: &Drive| field::on_cpu(aperture, drive, &grid.samples, double);
        if double {
            return drives.iter().map(each).collect();
        }
        let table = self.transfer.update(setting, |table| {
            let layout = Layout::new(&setting.aperture, grid);
            let wave = Wave::new(&setting.aperture, &grid.samples).filter(|_| layout.fits(TABLE_CEILING));
            work.transfer += u64::from(wave.is_some());
            let old = table.take();
            *table = wave.map(|wave| Transfer::new(&setting.aperture, &wave, layout, old));
        });
        let Some(table) = table else { return drives.iter().map(each).collect() };
        let excitations: Vec<_> = drives.iter().map(|drive| excitation(aperture, drive)).collect();
        table.superpose(aperture, &excitations, grid.samples.len())
    }
}

impl OnCpu {
    pub(super) fn forget(&mut self) {
        self.superposition.forget();
        self.samples.key = None;
        self.picture.key = None;
    }

    /// Makes the pixels.
    pub(super) fn pixels(&mut self, job: &Job<'_>, double: bool, work: &mut Work) {
        let raster = job.raster;
        self.field.resize(raster.len(), Complex32::ZERO);
        let pixels_of = |rows: &Range<usize>| rows.start * raster.width..rows.end * raster.width;
        for rows in raster.direct() {
            work.superposition += 1;
            let evaluated = job.evaluate(&raster.pixel_rows(rows.clone()), double);
            self.field[pixels_of(&rows)].copy_from_slice(&evaluated);
        }
        if let Some(grid) = job.grid() {
            self.sample(job, grid, double, work);
            work.interpolation += 1;
            let columns = grid.samples.columns.len();
            let pixels = &mut self.field[pixels_of(&raster.interpolated)];
            interpolate(&self.samples.value, columns, &raster.across, &raster.up, &mut self.between, pixels);
        }
    }

    fn sample(&mut self, job: &Job<'_>, grid: &Grid, double: bool, work: &mut Work) {
        let sounding = &job.drawn.sounding;
        let Self { superposition, samples, .. } = self;
        samples.update(&(sounding.clone(), double), |samples| {
            let Wanted { aperture, drive, .. } = job.wanted;
            let drives = std::slice::from_ref(drive);
            *samples =
                superposition.at(&sounding.setting, grid, aperture, drives, double, work).swap_remove(0);
        });
    }

    pub(super) fn field(&self) -> &[Complex32] {
        &self.field
    }

    pub(super) fn colours(&mut self, key: &Painted, peak: f32, work: &mut Work) -> &[[u8; 4]] {
        self.picture.update(key, |colours| {
            work.picture += 1;
            key.colouring.colours(&self.field, peak, colours);
        })
    }
}

impl Job<'_> {
    /// The samples that pixels are interpolated from, if any are.
    pub(super) fn grid(&self) -> Option<&Grid> {
        self.plan.grid.as_ref().filter(|_| !self.raster.interpolated.is_empty())
    }

    fn evaluate(&self, samples: &Samples, double: bool) -> Vec<Complex32> {
        field::on_cpu(self.wanted.aperture, self.wanted.drive, samples, double)
    }
}
