//! Interpolation on the GPU.

use wgpu::BufferUsages;

use crate::field::gpu::field::Band;
use crate::field::gpu::program::{ResampleParams, WORKGROUP};
use crate::field::gpu::{Gpu, GpuError, GpuField};
use crate::field::interpolation::Resampling;

/// Pixels that one invocation makes of a line, and lines.
const TOGETHER: usize = 16;
const LINES: u32 = 4;

/// From samples to pixels in both directions, in bands of pixel rows that fit one buffer each.
#[derive(Debug)]
pub struct GpuResampling {
    across: Pass,
    bands: Vec<BandPass>,
    /// Sample columns, pixel columns.
    columns: [usize; 2],
}

#[derive(Debug)]
struct BandPass {
    /// The sample rows that the band's pixels are made of.
    first_row: usize,
    rows: usize,
    up: Pass,
}

/// The weights along one axis.
#[derive(Debug)]
struct Pass {
    pixels: usize,
    blocks: usize,
    span: usize,
    /// Of every block its first sample and its weights, as the program reads them.
    weights: wgpu::Buffer,
}

/// How the lines lie that are resampled together: in the samples, and in the pixels.
struct Lines {
    count: usize,
    /// The first sample.
    start: usize,
    /// From one line to the next.
    strides: [usize; 2],
    /// From one sample or pixel of a line to the next.
    steps: [usize; 2],
}

impl Gpu {
    /// Weights for samples with `columns` in a row; `None` if there is no room for a single row of pixels.
    pub fn resampling(&self, across: &Resampling, up: &Resampling, columns: usize) -> Option<GpuResampling> {
        let most = self.samples_per_band();
        let width = across.len();
        // A band's samples, made as wide as its pixels, must fit as well.
        let fits = |first: usize, count: usize| {
            let rows = up.first[first + count - 1] as usize + up.taps - up.first[first] as usize;
            (rows * width).max(count * width) <= most
        };
        let (mut bands, mut first) = (Vec::new(), 0);
        while first < up.len() {
            let rest = up.len() - first;
            let count = (1..=rest).collect::<Vec<_>>().partition_point(|&count| fits(first, count));
            if count == 0 {
                return None;
            }
            let mut part = up.part(first..first + count);
            let first_row = part.first[0] as usize;
            let rows = part.first[count - 1] as usize + part.taps - first_row;
            part.first.iter_mut().for_each(|sample| *sample -= first_row as u32);
            bands.push(BandPass { first_row, rows, up: self.pass(&part) });
            first += count;
        }
        Some(GpuResampling { across: self.pass(across), bands, columns: [columns, width] })
    }

    fn pass(&self, resampling: &Resampling) -> Pass {
        let blocks = resampling.blocks(TOGETHER);
        let mut weights: Vec<[u32; 4]> = Vec::new();
        for (block, &first) in blocks.first.iter().enumerate() {
            let length = blocks.span * TOGETHER;
            let of_block = &blocks.weights[block * length..][..length];
            weights.push([first, 0, 0, 0]);
            weights.extend(of_block.as_chunks::<4>().0.iter().map(|weights| weights.map(f32::to_bits)));
        }
        Pass {
            pixels: resampling.len(),
            blocks: blocks.first.len(),
            span: blocks.span,
            weights: self.filled("weights", bytemuck::cast_slice(&weights), BufferUsages::STORAGE),
        }
    }

    /// Samples, row by row, interpolated to pixels; `None` if they do not lie in one buffer.
    ///
    /// # Errors
    /// The device was lost.
    pub fn interpolate(
        &self,
        samples: &GpuField,
        resampling: &GpuResampling,
    ) -> Result<Option<GpuField>, GpuError> {
        let [Band { pressure: samples, .. }] = samples.bands() else { return Ok(None) };
        let [columns, width] = resampling.columns;
        let mut field = GpuField::default();
        let mut encoder = self.encoder();
        for band in &resampling.bands {
            let wide = self.storage("wide", (band.rows * width * 8) as u64);
            let lines = Lines {
                count: band.rows,
                start: band.first_row * columns,
                strides: [columns, width],
                steps: [1, 1],
            };
            let peak = self.storage("peak", 4);
            self.resample(&mut encoder, samples, [&wide, &peak], &resampling.across, &lines);
            let pixels = self.storage("pressure", (band.up.pixels * width * 8) as u64);
            let lines = Lines { count: width, start: 0, strides: [1, 1], steps: [width, width] };
            // What lies between the passes has a peak of its own, which nobody wants.
            let peak = self.storage("peak", 4);
            self.resample(&mut encoder, &wide, [&pixels, &peak], &band.up, &lines);
            field.push(Band { pressure: pixels, peak: Some(peak) });
        }
        self.submit(encoder);
        self.check()?;
        Ok(Some(field))
    }

    fn resample(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        samples: &wgpu::Buffer,
        [out, peak]: [&wgpu::Buffer; 2],
        pass: &Pass,
        lines: &Lines,
    ) {
        let params = ResampleParams {
            pixels: pass.pixels as u32,
            lines: lines.count as u32,
            start: lines.start as u32,
            span: pass.span as u32,
            tap_stride: lines.steps[0] as u32,
            line_stride: lines.strides[0] as u32,
            pixel_stride: lines.steps[1] as u32,
            pixel_line_stride: lines.strides[1] as u32,
        };
        let params = self.params(bytemuck::bytes_of(&params));
        let bindings = [(0, &params), (1, samples), (2, &pass.weights), (3, out), (4, peak)];
        let workgroups = ((lines.count as u32).div_ceil(LINES * WORKGROUP), pass.blocks as u32);
        self.dispatch(encoder, &self.interpolation, &bindings, workgroups);
    }
}
