//! The stages on the GPU; only the peak, some probed pixels and what is asked for leave it.

use num_complex::Complex32;

use crate::field::gpu::{GpuField, GpuResampling, GpuTransfer};
use crate::field::plan::Grid;
use crate::field::stages::{Job, Kept, Painted, Setting, Sounding, Work};
use crate::field::transfer::Layout;
use crate::field::{Gpu, GpuError, Samples, Sources, Wave};

#[derive(Debug)]
pub(super) struct OnGpu {
    pub(super) gpu: Gpu,
    transfer: Kept<Setting, Option<GpuTransfer>>,
    samples: Kept<Sounding, Option<GpuField>>,
    resampling: Kept<(Setting, (usize, usize)), Option<GpuResampling>>,
    field: GpuField,
    picture: Kept<Painted, Vec<[u8; 4]>>,
}

impl OnGpu {
    pub(super) fn new(gpu: Gpu) -> Self {
        Self {
            gpu,
            transfer: Kept::default(),
            samples: Kept::default(),
            resampling: Kept::default(),
            field: GpuField::default(),
            picture: Kept::default(),
        }
    }

    /// Makes the pixels; `false` where f32 has no room for the elements or a buffer none for the samples.
    pub(super) fn pixels(&mut self, job: &Job<'_>, work: &mut Work) -> Result<bool, GpuError> {
        let raster = job.raster;
        self.field = GpuField::default();
        for (rows, interpolated) in [
            (0..raster.interpolated.start, false),
            (raster.interpolated.clone(), true),
            (raster.interpolated.end..raster.height, false),
        ] {
            if rows.is_empty() {
                continue;
            }
            let part = match job.grid().filter(|_| interpolated) {
                Some(grid) => self.interpolated(job, grid, work)?,
                None => {
                    work.superposition += 1;
                    self.evaluated(job, &raster.pixel_rows(rows))?
                }
            };
            let Some(part) = part else { return Ok(false) };
            self.field.append(part);
        }
        Ok(true)
    }

    fn evaluated(&self, job: &Job<'_>, samples: &Samples) -> Result<Option<GpuField>, GpuError> {
        let sources = Sources::new(job.wanted.aperture, job.wanted.drive, samples);
        sources.map(|sources| self.gpu.pressure(&sources, samples)).transpose()
    }

    fn interpolated(
        &mut self,
        job: &Job<'_>,
        grid: &Grid,
        work: &mut Work,
    ) -> Result<Option<GpuField>, GpuError> {
        self.sample(job, grid, work)?;
        let key = (job.drawn.sounding.setting.clone(), job.drawn.size);
        let columns = grid.samples.columns.len();
        let resampling = self.resampling.update(&key, |resampling| {
            *resampling = self.gpu.resampling(&job.raster.across, &job.raster.up, columns);
        });
        let (Some(samples), Some(resampling)) = (&self.samples.value, resampling) else { return Ok(None) };
        let interpolated = self.gpu.interpolate(samples, resampling)?;
        work.interpolation += u64::from(interpolated.is_some());
        Ok(interpolated)
    }

    /// Superposition at the samples, from a table where there is room for one.
    fn sample(&mut self, job: &Job<'_>, grid: &Grid, work: &mut Work) -> Result<(), GpuError> {
        let sounding = &job.drawn.sounding;
        let aperture = &sounding.setting.aperture;
        let table = self.transfer.try_update(&sounding.setting, |table| {
            let wave = Wave::new(aperture, &grid.samples);
            let layout = Layout::new(aperture, grid);
            *table = match wave {
                Some(wave) => self.gpu.transfer(aperture, &wave, layout)?,
                None => None,
            };
            work.transfer += u64::from(table.is_some());
            Ok(())
        })?;
        if self.samples.key.as_ref() == Some(sounding) {
            return Ok(());
        }
        work.superposition += 1;
        let superposed = match table {
            Some(table) => {
                let terms = table.layout.terms(aperture, &sounding.excitation);
                self.gpu.superpose(table, &terms, grid.samples.len())?
            }
            None => None,
        };
        let evaluated = match superposed {
            Some(field) => Some(field),
            None => self.evaluated(job, &grid.samples)?,
        };
        self.samples = Kept { key: Some(sounding.clone()), value: evaluated };
        Ok(())
    }

    /// The largest |P| (Pa) and the pressure at some pixels.
    pub(super) fn measure(&self, pixels: &[usize]) -> Result<(f32, Vec<Complex32>), GpuError> {
        self.gpu.measure(&self.field, pixels)
    }

    pub(super) fn read(&self) -> Result<Vec<Complex32>, GpuError> {
        self.gpu.read(&self.field)
    }

    pub(super) fn colours(
        &mut self,
        key: &Painted,
        peak: f32,
        work: &mut Work,
    ) -> Result<&[[u8; 4]], GpuError> {
        let Self { gpu, field, picture, .. } = self;
        let colours = picture.try_update(key, |colours| {
            work.picture += 1;
            gpu.colours(field, &key.colouring, peak, colours)
        })?;
        Ok(colours)
    }
}
