//! Averages on the GPU; the squares at the cells, which are few, leave it for the figures.

use crate::field::gpu::{GpuField, GpuResampling, GpuTank};
use crate::field::interpolation::Resampling;
use crate::field::stages::average::{Basin, Job, Made, Mean, Sounding};
use crate::field::stages::{Kept, Work};
use crate::field::{Gpu, GpuError, Sources};

#[derive(Debug, Default)]
pub(super) struct OnGpu {
    /// From samples to the cells, of values, and of slopes along each axis.
    to_cells: Kept<Basin, Option<[GpuResampling; 3]>>,
    tank: Kept<Basin, Option<GpuTank>>,
    to_pixels: Kept<(Basin, (usize, usize)), Option<GpuResampling>>,
    squares: Kept<Sounding, Option<GpuField>>,
    pub(super) pixels: GpuField,
}

impl OnGpu {
    pub(super) fn forget(&mut self) {
        self.to_cells.key = None;
        self.tank.key = None;
        self.to_pixels.key = None;
        self.squares.key = None;
    }
}

impl Job<'_> {
    /// Makes the pixels; `None` where f32 has no room for the elements or a buffer none for the cells.
    pub(super) fn on_gpu(
        &self,
        gpu: &Gpu,
        on_gpu: &mut OnGpu,
        work: &mut Work,
    ) -> Result<Option<Made>, GpuError> {
        let OnGpu { to_cells, tank, to_pixels, squares, pixels } = on_gpu;
        let (sounding, part) = (&self.drawn.sounding, self.drawn.part);
        let (basin, cells) = (&sounding.basin, &self.filled.cells);
        let to_cells = to_cells.update(basin, |to_cells| *to_cells = self.to_cells(gpu));
        let Some(to_cells) = to_cells else { return Ok(None) };
        let squares = squares.try_update(sounding, |squares| {
            *squares = self.squares_on_gpu(gpu, to_cells, work)?;
            Ok::<_, GpuError>(())
        })?;
        let Some(squares) = squares else { return Ok(None) };
        let numbers: Vec<_> =
            gpu.read(squares)?.iter().map(|value| [f64::from(value.re), f64::from(value.im)]).collect();
        let (joined, dent) = match (&self.wanted.mean, self.tank) {
            (Mean::Dent(_, liquid), Some(of_cells)) => {
                let tank = tank.update(basin, |tank| *tank = gpu.tank(cells.counts, cells.step));
                let Some(tank) = tank else { return Ok(None) };
                work.dent += 1;
                let Some(depth) = gpu.dent(tank, liquid, squares)? else { return Ok(None) };
                let joined = gpu.join(&depth, squares, [part, part]);
                let depth: Vec<_> = gpu.read(&joined)?.iter().map(|value| f64::from(value.re)).collect();
                let pressed = numbers.iter().map(|[_, radiation]| part * radiation).sum();
                (joined, Some(of_cells.dent_of(depth, pressed)))
            }
            _ => (gpu.join(squares, squares, [1.0, part]), None),
        };
        let to_pixels = to_pixels.update(&(basin.clone(), self.drawn.size), |to_pixels| {
            *to_pixels = gpu.resampling(&self.frame.across, &self.frame.up, cells.counts[0]);
        });
        let Some(to_pixels) = to_pixels else { return Ok(None) };
        let Some(made) = gpu.interpolate(&joined, to_pixels)? else { return Ok(None) };
        work.interpolation += 1;
        *pixels = made;
        let (largest, at_probes) = gpu.measure(pixels, self.wanted.mean.quantity(), &self.frame.probes)?;
        Ok(Some(Made { largest, at_probes, squares: numbers, dent }))
    }

    fn to_cells(&self, gpu: &Gpu) -> Option<[GpuResampling; 3]> {
        let columns = self.filled.plan.grid.as_ref()?.samples.columns.len();
        let [[across, up], [across_slope, up_slope]] = [&self.filled.values, &self.filled.slopes];
        let resampling = |across: &Resampling, up: &Resampling| gpu.resampling(across, up, columns);
        Some([resampling(across, up)?, resampling(across_slope, up)?, resampling(across, up_slope)?])
    }

    /// Mean squares at the cells.
    fn squares_on_gpu(
        &self,
        gpu: &Gpu,
        to_cells: &[GpuResampling; 3],
        work: &mut Work,
    ) -> Result<Option<GpuField>, GpuError> {
        let Some(grid) = &self.filled.plan.grid else { return Ok(None) };
        let reflector = self.drawn.sounding.reflector;
        let squares = gpu.zeros(self.filled.cells.len());
        let share = 1.0 / self.wanted.drives.len() as f64;
        for drive in self.wanted.drives {
            let sources = Sources::new(self.wanted.aperture, drive, &grid.samples);
            let Some(sources) = sources else { return Ok(None) };
            work.superposition += 1;
            let samples = gpu.pressure(&sources, &grid.samples)?;
            work.squares += 1;
            let Some(pressure) = gpu.interpolate(&samples, &to_cells[0])? else { return Ok(None) };
            if reflector.is_none() {
                gpu.add_squares([&pressure; 3], reflector, share, &squares);
                continue;
            }
            let Some(along_x) = gpu.interpolate(&samples, &to_cells[1])? else { return Ok(None) };
            let Some(along_y) = gpu.interpolate(&samples, &to_cells[2])? else { return Ok(None) };
            gpu.add_squares([&pressure, &along_x, &along_y], reflector, share, &squares);
        }
        Ok(Some(squares))
    }
}
