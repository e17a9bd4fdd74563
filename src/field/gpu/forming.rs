//! Values of a quantity from the sound, and the largest of them, on the GPU.

use bytemuck::Zeroable;
use num_complex::Complex32;

use crate::field::gpu::program::{FormParams, Program, WORKGROUP};
use crate::field::gpu::{Gpu, GpuError, Reading, Step};
use crate::field::quantity::{Constants, Part, Quantity, Sound};

/// The pass that forms values, with its constants.
#[derive(Debug)]
pub(super) struct Forming {
    pub(super) step: Step,
    params: FormParams,
    buffer: wgpu::Buffer,
    /// The largest extent, as the bits of a float.
    pub(super) peak: wgpu::Buffer,
}

impl Forming {
    /// From `count` values of each part that the quantity needs, one part after the other.
    pub(super) fn new(
        gpu: &Gpu,
        quantity: Quantity,
        count: usize,
        [parts, values]: [&wgpu::Buffer; 2],
    ) -> Self {
        let groups = gpu.tuning.walking_groups;
        let params =
            FormParams { count: count as u32, invocations: groups * WORKGROUP, ..FormParams::zeroed() };
        let buffer = gpu.params(bytemuck::bytes_of(&params));
        let peak = gpu.storage("peak", 4);
        let step = gpu.step(
            Program::Form(quantity),
            &[
                (0, buffer.as_entire_binding()),
                (1, parts.as_entire_binding()),
                (2, values.as_entire_binding()),
                (3, peak.as_entire_binding()),
            ],
            (groups, 1),
        );
        Self { step, params, buffer, peak }
    }

    /// Sets the constants, and a factor on the formula.
    pub(super) fn set(&mut self, gpu: &Gpu, constants: &Constants, factor: f32) {
        let params = FormParams {
            of_pressure: constants.of_pressure,
            of_gradient: constants.of_gradient,
            of_velocity: constants.of_velocity,
            factor,
            turn: [constants.turn.re, constants.turn.im],
            ..self.params
        };
        if params != self.params {
            self.params = params;
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&params));
        }
    }
}

/// The values of sounds.
pub(super) fn form(
    gpu: &Gpu,
    quantity: Quantity,
    sounds: &[Sound],
    constants: &Constants,
) -> Result<Vec<f32>, GpuError> {
    let parts: Vec<Complex32> = Part::of(quantity.declaration().parts)
        .flat_map(|part| sounds.iter().copied().map(move |mut sound| *sound.part_mut(part)))
        .collect();
    let sound = gpu.filled("sound", bytemuck::cast_slice(&parts), wgpu::BufferUsages::STORAGE);
    let values = gpu.storage("values", (sounds.len() * 4) as u64);
    let mut forming = Forming::new(gpu, quantity, sounds.len(), [&sound, &values]);
    forming.set(gpu, constants, 1.0);
    let mut encoder = gpu.encoder();
    forming.step.run(&mut encoder.begin_compute_pass(&Default::default()));
    let bytes = Reading::new(gpu, encoder, &values).wait(gpu)?;
    Ok(bytemuck::cast_slice(&bytes).to_vec())
}
