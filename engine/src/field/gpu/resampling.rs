//! Interpolation along one axis on the GPU.

use wgpu::{BindingResource, BufferUsages};

use crate::field::gpu::Gpu;
use crate::field::gpu::device::Step;
use crate::field::gpu::program::{InterpolationParams, Program};
use crate::field::gpu::tuning::WORKGROUP;
use crate::field::interpolation::Resampling;

/// The layout of samples and pixels of an interpolation.
pub(super) struct Lines {
    pub(super) count: usize,
    /// Strides between samples of a line, between lines, and between parts of the sound.
    pub(super) strides: [usize; 3],
    pub(super) first_pixel: usize,
    /// Strides from one pixel of a line to the next, and from one line to the next.
    pub(super) pixel_strides: [usize; 2],
}

/// A bound pass of a program on interpolated samples of these parts of the sound. Slopes have separate weights.
pub(super) fn step(
    gpu: &Gpu,
    (program, parts): (Program, u8),
    samples: &wgpu::Buffer,
    [values, slopes]: [&Resampling; 2],
    lines: &Lines,
    made: &[(u32, BindingResource<'_>)],
) -> Step {
    let [together, lines_together] = gpu.tuning.block(parts);
    let blocks = values.blocks(together);
    let mut weights: Vec<[u32; 4]> = Vec::new();
    let mut write = |resampling: &Resampling| {
        let weights_ = resampling.blocks(together).weights;
        for (block, &first) in blocks.first.iter().enumerate() {
            let length = blocks.span * together;
            let of_block = &weights_[block * length..][..length];
            weights.push([first, 0, 0, 0]);
            weights.extend(of_block.as_chunks::<4>().0.iter().map(|weights| weights.map(f32::to_bits)));
        }
        weights.len()
    };
    let of_values = write(values);
    if slopes != values {
        write(slopes);
    }
    let [tap_stride, line_stride, part_stride] = lines.strides.map(|stride| stride as u32);
    let [pixel_stride, pixel_line_stride] = lines.pixel_strides.map(|stride| stride as u32);
    let params = InterpolationParams {
        pixels: values.len() as u32,
        lines: lines.count as u32,
        span: blocks.span as u32,
        slopes: of_values as u32,
        tap_stride,
        line_stride,
        part_stride,
        first_pixel: lines.first_pixel as u32,
        pixel_stride,
        pixel_line_stride,
    };
    let weights = gpu.filled("weights", bytemuck::cast_slice(&weights), BufferUsages::STORAGE);
    let params = gpu.params(bytemuck::bytes_of(&params));
    let mut bindings = vec![
        (0, params.as_entire_binding()),
        (1, samples.as_entire_binding()),
        (2, weights.as_entire_binding()),
    ];
    bindings.extend_from_slice(made);
    let of_group = lines_together as u32 * WORKGROUP;
    gpu.step(program, &bindings, ((lines.count as u32).div_ceil(of_group), blocks.first.len() as u32))
}
