//! A field that lies on the GPU, and what is made of it there: pixels, its peak, colours, numbers.

use num_complex::Complex32;

use crate::field::gpu::program::{PeakParams, PictureParams, ResampleParams, WORKGROUP};
use crate::field::gpu::{Gpu, GpuError};
use crate::field::interpolation::Resampling;

/// Workgroups of the passes that walk over a whole band.
const WALKING_GROUPS: u32 = 1024;

/// Samples that share a buffer.
#[derive(Debug)]
struct Band {
    buffer: wgpu::Buffer,
    count: u32,
}

/// A field that lies on the GPU.
#[derive(Debug)]
pub struct GpuField<'a> {
    gpu: &'a Gpu,
    bands: Vec<Band>,
}

/// What the picture pass makes of a field.
#[derive(Clone, Copy, Debug)]
pub struct Colouring<'a> {
    /// Colours as the bytes r, g, b, a.
    pub table: &'a [[u8; 4]; 256],
    /// Phase, rather than magnitude.
    pub phase: bool,
    /// |p| (Pa, peak) that gets the last colour; the field's peak if `None`.
    pub full: Option<f32>,
}

impl<'a> GpuField<'a> {
    /// A field without samples.
    pub fn empty(gpu: &'a Gpu) -> Self {
        Self { gpu, bands: Vec::new() }
    }

    pub(crate) fn push(&mut self, buffer: wgpu::Buffer, count: u32) {
        self.bands.push(Band { buffer, count });
    }

    /// Puts the samples of another field behind these.
    pub fn append(&mut self, mut other: Self) {
        self.bands.append(&mut other.bands);
    }

    /// This field, as rows of samples, interpolated across and up to pixels.
    ///
    /// # Errors
    /// The samples or the rows between the two passes do not fit one buffer, or the device was lost.
    pub fn interpolated(
        &self,
        across: &Resampling,
        up: &Resampling,
        columns: usize,
    ) -> Result<Self, GpuError> {
        let [samples] = &self.bands[..] else {
            return Err(GpuError::Refused("too many samples to interpolate".to_owned()));
        };
        let gpu = self.gpu;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let rows = samples.count as usize / columns;
        let wide = gpu.buffer("wide", (rows * across.len() * 8) as u64, usage);
        let lines = Lines { count: rows, strides: [columns, across.len()], steps: [1, 1] };
        resample(gpu, &samples.buffer, &wide, across, &lines);
        let mut field = Self::empty(gpu);
        let rows_per_band = (gpu.samples_per_band() as usize / across.len()).max(1);
        for first in (0..up.len()).step_by(rows_per_band) {
            let part = up.part(first..up.len().min(first + rows_per_band));
            let count = part.len() * across.len();
            let buffer = gpu.buffer("pressure", count as u64 * 8, usage);
            let lines = Lines { count: across.len(), strides: [1, 1], steps: [across.len(), across.len()] };
            resample(gpu, &wide, &buffer, &part, &lines);
            field.push(buffer, count as u32);
        }
        gpu.check()?;
        Ok(field)
    }

    /// Some samples as numbers.
    ///
    /// # Errors
    /// The device was lost.
    pub fn at(&self, samples: &[usize]) -> Result<Vec<Complex32>, GpuError> {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let gathered = self.gpu.buffer("gathered", samples.len() as u64 * 8, usage);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (index, &sample) in samples.iter().enumerate() {
            let mut sample = sample as u64;
            for band in &self.bands {
                if sample < u64::from(band.count) {
                    encoder.copy_buffer_to_buffer(&band.buffer, sample * 8, &gathered, index as u64 * 8, 8);
                    break;
                }
                sample -= u64::from(band.count);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        Ok(bytemuck::cast_slice(&self.gpu.read(&gathered)?).to_vec())
    }

    /// The field as numbers.
    ///
    /// # Errors
    /// The device was lost.
    pub fn read(&self) -> Result<Vec<Complex32>, GpuError> {
        let mut field = Vec::new();
        for band in &self.bands {
            field.extend_from_slice(bytemuck::cast_slice(&self.gpu.read(&band.buffer)?));
        }
        Ok(field)
    }

    /// The largest |p|, Pa.
    ///
    /// # Errors
    /// The device was lost.
    pub fn peak(&self) -> Result<f32, GpuError> {
        let bytes = self.gpu.read(&self.peak_buffer())?;
        Ok(bytemuck::pod_read_unaligned(&bytes))
    }

    /// The field as colours, r, g, b, a of every sample in the field's order.
    ///
    /// # Errors
    /// The device was lost.
    pub fn colours(&self, colouring: &Colouring<'_>) -> Result<Vec<u8>, GpuError> {
        let table =
            self.gpu.filled("colours", bytemuck::cast_slice(colouring.table), wgpu::BufferUsages::STORAGE);
        let peak = self.peak_buffer();
        let mut picture = Vec::new();
        for band in &self.bands {
            let params = PictureParams {
                count: band.count,
                invocations: WALKING_GROUPS * WORKGROUP,
                quantity: u32::from(colouring.phase),
                full: colouring.full.unwrap_or(0.0),
            };
            let params = self.gpu.filled("params", bytemuck::bytes_of(&params), wgpu::BufferUsages::UNIFORM);
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            let out = self.gpu.buffer("picture", u64::from(band.count) * 4, usage);
            let bindings = [(0, &params), (1, &band.buffer), (2, &peak), (3, &table), (4, &out)];
            self.gpu.dispatch(&self.gpu.picture, &bindings, (WALKING_GROUPS, 1));
            picture.extend(self.gpu.read(&out)?);
        }
        Ok(picture)
    }

    fn peak_buffer(&self) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let peak = self.gpu.filled("peak", &[0; 4], usage);
        for band in &self.bands {
            let params = PeakParams { count: band.count, invocations: WALKING_GROUPS * WORKGROUP };
            let params = self.gpu.filled("params", bytemuck::bytes_of(&params), wgpu::BufferUsages::UNIFORM);
            self.gpu.dispatch(
                &self.gpu.peak,
                &[(0, &params), (1, &band.buffer), (2, &peak)],
                (WALKING_GROUPS, 1),
            );
        }
        peak
    }
}

/// How the lines lie that are resampled together: in the samples, and in the pixels.
struct Lines {
    count: usize,
    /// From one line to the next.
    strides: [usize; 2],
    /// From one sample or pixel of a line to the next.
    steps: [usize; 2],
}

fn resample(gpu: &Gpu, samples: &wgpu::Buffer, out: &wgpu::Buffer, resampling: &Resampling, lines: &Lines) {
    const TOGETHER: usize = 8;
    let blocks = resampling.blocks(TOGETHER);
    let params = ResampleParams {
        pixels: resampling.len() as u32,
        lines: lines.count as u32,
        span: blocks.span as u32,
        tap_stride: lines.steps[0] as u32,
        line_stride: lines.strides[0] as u32,
        pixel_stride: lines.steps[1] as u32,
        pixel_line_stride: lines.strides[1] as u32,
    };
    let params = gpu.filled("params", bytemuck::bytes_of(&params), wgpu::BufferUsages::UNIFORM);
    let storage = |label, bytes: &[u8]| gpu.filled(label, bytes, wgpu::BufferUsages::STORAGE);
    let first = storage("first", bytemuck::cast_slice(&blocks.first));
    let weights = storage("weights", bytemuck::cast_slice(&blocks.weights));
    let bindings = [(0, &params), (1, samples), (2, &first), (3, &weights), (4, out)];
    let workgroups = ((lines.count as u32).div_ceil(WORKGROUP), blocks.first.len() as u32);
    gpu.dispatch(&gpu.interpolation, &bindings, workgroups);
}
