//! Forms the values of a quantity, and their maximum, on the GPU.

use bytemuck::Zeroable;
use num_complex::Complex32;
use wgpu::{BindingResource, BufferUsages};

use crate::field::gpu::device::Step;
use crate::field::gpu::program::{DirectParams, FormParams, Program};
use crate::field::gpu::resampling::{self, Lines};
use crate::field::gpu::tuning::WORKGROUP;
use crate::field::gpu::{Gpu, Reading};
use crate::field::gpu_report::GpuError;
use crate::field::interpolation::Resampling;
use crate::field::quantity::{Constants, Part, Quantity, Sound};
use crate::field::vicinity::LeftOut;

/// The passes that form values, with their constants.
#[derive(Debug)]
pub(super) struct Forming {
    quantity: Quantity,
    pub(super) steps: Vec<Step>,
    params: FormParams,
    buffer: wgpu::Buffer,
    pub(super) values: wgpu::Buffer,
    /// The largest extents of the pixels that count and of the others, as the bits of floats.
    pub(super) peak: wgpu::Buffer,
}

impl Forming {
    /// The pass for this number of pixels.
    pub(super) fn new(gpu: &Gpu, quantity: Quantity, pixels: usize) -> Self {
        Self {
            quantity,
            steps: Vec::new(),
            params: FormParams::zeroed(),
            buffer: gpu.params(bytemuck::bytes_of(&FormParams::zeroed())),
            // Reads are in units of eight bytes.
            values: gpu.storage("values", (pixels.div_ceil(2) * 8) as u64),
            peak: gpu.storage("peak", 8),
        }
    }

    fn made(&self) -> [(u32, BindingResource<'_>); 3] {
        [
            (3, self.buffer.as_entire_binding()),
            (4, self.values.as_entire_binding()),
            (5, self.peak.as_entire_binding()),
        ]
    }

    /// Adds pixels interpolated from the parts of the sound in sequence; slopes along the second axis have separate
    /// weights.
    pub(super) fn interpolate(
        &mut self,
        gpu: &Gpu,
        parts: &wgpu::Buffer,
        weights: [&Resampling; 2],
        lines: &Lines,
    ) {
        let program = (Program::Form(self.quantity), self.quantity.declaration().parts);
        let step = resampling::step(gpu, program, parts, weights, lines, &self.made());
        self.steps.push(step);
    }

    /// Adds pixels with known parts of the sound, in rows of `columns`; a bit of `left_out` is set for each that does
    /// not count for the peak.
    pub(super) fn take(
        &mut self,
        gpu: &Gpu,
        parts: &wgpu::Buffer,
        [columns, rows]: [usize; 2],
        first_pixel: usize,
        left_out: &[u32],
    ) {
        let params = DirectParams {
            columns: columns as u32,
            count: (columns * rows) as u32,
            first_pixel: first_pixel as u32,
        };
        let params = gpu.params(bytemuck::bytes_of(&params));
        let left_out = gpu.filled("left out", bytemuck::cast_slice(left_out), BufferUsages::STORAGE);
        let mut bindings = vec![
            (0, params.as_entire_binding()),
            (1, parts.as_entire_binding()),
            (2, left_out.as_entire_binding()),
        ];
        bindings.extend(self.made());
        let groups = ((columns as u32).div_ceil(WORKGROUP), rows as u32);
        self.steps.push(gpu.step(Program::FormDirect(self.quantity), &bindings, groups));
    }

    /// Sets the constants, and a factor on the formula.
    pub(super) fn set(&mut self, gpu: &Gpu, constants: &Constants, factor: f32) {
        let params = FormParams {
            of_pressure: constants.of_pressure,
            of_gradient: constants.of_gradient,
            of_velocity: constants.of_velocity,
            factor,
            turn: [constants.turn.re, constants.turn.im],
        };
        if params != self.params {
            self.params = params;
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&params));
        }
    }
}

impl Gpu {
    /// The value of every sound. Blocks.
    ///
    /// # Errors
    /// The device was lost or has not enough memory.
    #[doc(hidden)]
    pub fn form(
        &self,
        quantity: Quantity,
        sounds: &[Sound],
        constants: &Constants,
    ) -> Result<Vec<f32>, GpuError> {
        let parts: Vec<Complex32> = Part::of(quantity.declaration().parts)
            .flat_map(|part| sounds.iter().copied().map(move |mut sound| *sound.part_mut(part)))
            .collect();
        let sound = self.filled("sound", bytemuck::cast_slice(&parts), BufferUsages::STORAGE);
        let mut forming = Forming::new(self, quantity, sounds.len());
        forming.take(self, &sound, [sounds.len(), 1], 0, &LeftOut::default().bits(0..sounds.len()));
        forming.set(self, constants, 1.0);
        let mut encoder = self.encoder();
        for step in &forming.steps {
            step.run(&mut encoder.begin_compute_pass(&Default::default()));
        }
        let bytes = Reading::new(self, encoder, &forming.values).wait(self)?;
        Ok(bytemuck::cast_slice(&bytes)[..sounds.len()].to_vec())
    }
}
