//! The stages on the GPU; only the peak, some probed pixels and what is asked for leave it.

use num_complex::Complex32;

use crate::field::gpu::{GpuField, GpuResampling};
use crate::field::plan::Grid;
use crate::field::stages::{Frame, Job, Kept, Painted, Sounding, Work};
use crate::field::{Gpu, GpuError, Quantity, Samples, Sources};

#[derive(Debug)]
pub(super) struct OnGpu {
    pub(super) gpu: Gpu,
    samples: Kept<Sounding, Option<GpuField>>,
    resampling: Kept<Frame, Option<GpuResampling>>,
    field: GpuField,
    picture: Kept<Painted, Vec<[u8; 4]>>,
}

impl OnGpu {
    pub(super) fn new(gpu: Gpu) -> Self {
        Self {
            gpu,
            samples: Kept::default(),
            resampling: Kept::default(),
            field: GpuField::default(),
            picture: Kept::default(),
        }
    }

    pub(super) fn forget(&mut self) {
        self.samples.key = None;
        self.resampling.key = None;
        self.picture.key = None;
    }

    /// Makes the pixels; `false` where f32 is not right at some of them, has no room for the elements or a buffer none for the samples.
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
        let sources = sources.filter(|sources| sources.beside_rims(samples).is_empty());
        sources.map(|sources| self.gpu.pressure(&sources, samples)).transpose()
    }

    fn interpolated(
        &mut self,
        job: &Job<'_>,
        grid: &Grid,
        work: &mut Work,
    ) -> Result<Option<GpuField>, GpuError> {
        self.sample(job, grid, work)?;
        let columns = grid.samples.columns.len();
        let resampling = self.resampling.update(&job.drawn.frame(), |resampling| {
            *resampling = self.gpu.resampling(&job.raster.across, &job.raster.up, columns);
        });
        let (Some(samples), Some(resampling)) = (&self.samples.value, resampling) else { return Ok(None) };
        let interpolated = self.gpu.interpolate(samples, resampling)?;
        work.interpolation += u64::from(interpolated.is_some());
        Ok(interpolated)
    }

    /// Superposition at the samples.
    fn sample(&mut self, job: &Job<'_>, grid: &Grid, work: &mut Work) -> Result<(), GpuError> {
        let sounding = &job.drawn.sounding;
        if self.samples.key.as_ref() != Some(sounding) {
            work.superposition += 1;
            let value = self.evaluated(job, &grid.samples)?;
            self.samples = Kept { key: Some(sounding.clone()), value };
        }
        Ok(())
    }

    /// The largest |P| (Pa) and the pressure at some pixels.
    pub(super) fn measure(&self, pixels: &[usize]) -> Result<(f32, Vec<Complex32>), GpuError> {
        self.gpu.measure(&self.field, Quantity::Rms, pixels)
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
