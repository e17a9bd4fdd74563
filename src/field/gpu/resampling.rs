//! Interpolation along one axis on the GPU.

use wgpu::BufferUsages;

use crate::field::gpu::program::{Program, ResampleParams, SingleParams, WORKGROUP};
use crate::field::gpu::{Gpu, Step};
use crate::field::interpolation::Resampling;

/// Pixels that one invocation makes of a line, and lines, where it makes several.
const TOGETHER: usize = 16;
const LINES: u32 = 4;

/// How the lines lie that are resampled together: in the samples, and in the pixels.
pub(super) struct Lines {
    pub(super) count: usize,
    /// The first sample and the first pixel.
    pub(super) start: usize,
    pub(super) out_start: usize,
    /// From one line to the next.
    pub(super) strides: [usize; 2],
    /// From one sample or pixel of a line to the next.
    pub(super) steps: [usize; 2],
}

/// The run that makes pixels of samples.
pub(super) fn step(
    gpu: &Gpu,
    resampling: &Resampling,
    [samples, pixels]: [&wgpu::Buffer; 2],
    lines: &Lines,
) -> Step {
    if gpu.tuning.single_pixels {
        single(gpu, resampling, [samples, pixels], lines)
    } else {
        in_blocks(gpu, resampling, [samples, pixels], lines)
    }
}

fn single(gpu: &Gpu, resampling: &Resampling, [samples, pixels]: [&wgpu::Buffer; 2], lines: &Lines) -> Step {
    let (count, taps) = (resampling.len(), resampling.taps);
    let pixels_run_along_x = lines.steps[1] == 1;
    let (across, up) = if pixels_run_along_x { (count, lines.count) } else { (lines.count, count) };
    let params = SingleParams {
        across: across as u32,
        up: up as u32,
        pixels_run_along_x: u32::from(pixels_run_along_x),
        pixels: count as u32,
        taps: taps as u32,
        start: lines.start as u32,
        out_start: lines.out_start as u32,
        tap_stride: lines.steps[0] as u32,
        line_stride: lines.strides[0] as u32,
        pixel_stride: lines.steps[1] as u32,
        pixel_line_stride: lines.strides[1] as u32,
    };
    let of_tap =
        |tap: usize| (0..count).map(move |pixel: usize| resampling.weights[pixel * taps + tap].to_bits());
    let weights = resampling.first.iter().copied().chain((0..taps).flat_map(of_tap)).collect::<Vec<_>>();
    let weights = gpu.filled("weights", bytemuck::cast_slice(&weights), BufferUsages::STORAGE);
    let params = gpu.params(bytemuck::bytes_of(&params));
    gpu.step(
        Program::Interpolation,
        &[
            (0, params.as_entire_binding()),
            (1, samples.as_entire_binding()),
            (2, weights.as_entire_binding()),
            (3, pixels.as_entire_binding()),
        ],
        ((across as u32).div_ceil(WORKGROUP), up as u32),
    )
}

fn in_blocks(
    gpu: &Gpu,
    resampling: &Resampling,
    [samples, pixels]: [&wgpu::Buffer; 2],
    lines: &Lines,
) -> Step {
    let blocks = resampling.blocks(TOGETHER);
    let mut weights: Vec<[u32; 4]> = Vec::new();
    for (block, &first) in blocks.first.iter().enumerate() {
        let length = blocks.span * TOGETHER;
        let of_block = &blocks.weights[block * length..][..length];
        weights.push([first, 0, 0, 0]);
        weights.extend(of_block.as_chunks::<4>().0.iter().map(|weights| weights.map(f32::to_bits)));
    }
    let params = ResampleParams {
        pixels: resampling.len() as u32,
        lines: lines.count as u32,
        start: lines.start as u32,
        out_start: lines.out_start as u32,
        span: blocks.span as u32,
        tap_stride: lines.steps[0] as u32,
        line_stride: lines.strides[0] as u32,
        pixel_stride: lines.steps[1] as u32,
        pixel_line_stride: lines.strides[1] as u32,
    };
    let weights = gpu.filled("weights", bytemuck::cast_slice(&weights), BufferUsages::STORAGE);
    let params = gpu.params(bytemuck::bytes_of(&params));
    gpu.step(
        Program::Interpolation,
        &[
            (0, params.as_entire_binding()),
            (1, samples.as_entire_binding()),
            (2, weights.as_entire_binding()),
            (3, pixels.as_entire_binding()),
        ],
        ((lines.count as u32).div_ceil(LINES * WORKGROUP), blocks.first.len() as u32),
    )
}
