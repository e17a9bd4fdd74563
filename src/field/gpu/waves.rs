//! Sums over the elements on the GPU.
//!
//! There is no table of transfer values as on the CPU: with llvmpipe, reading a value took three times as long as computing
//! it, and a real GPU computes faster still.

use wgpu::BufferUsages;

use crate::field::gpu::program::{FieldProgram, Params, SAMPLES_PER_INVOCATION, UNIFORM_ELEMENTS, WORKGROUP};
use crate::field::gpu::{Gpu, GpuError, GpuField, pipeline};
use crate::field::sources::MOST_NODES;
use crate::field::{Samples, Sources, Wave};

/// Samples times elements in one submission, so that no driver thinks that the device hangs.
const MOST_PAIRS_PER_RUN: u64 = 1 << 31;
/// Rounds of loops in one invocation: llvmpipe leaves a shader's loops after 65 535 of them in all, and says nothing.
const MOST_ROUNDS_PER_RUN: u32 = 1 << 15;

impl Gpu {
    /// Computes the field at every sample and leaves it on the GPU.
    ///
    /// # Errors
    /// The device was lost or has not enough memory.
    pub fn pressure(&self, sources: &Sources, samples: &Samples) -> Result<GpuField, GpuError> {
        let inputs = Inputs::new(self, &sources.wave, &sources.elements, samples);
        let field = self.zeros(samples.len());
        let mut first = 0;
        for band in field.bands() {
            let count = band.len();
            for elements in inputs.element_runs() {
                let run_length = (MOST_PAIRS_PER_RUN / elements.len() as u64).min(u64::from(count)) as u32;
                for written in (0..count).step_by(run_length as usize) {
                    let params = Params {
                        first_element: elements.start,
                        last_element: elements.end,
                        first: first + written,
                        count: run_length.min(count - written),
                        written,
                        ..inputs.params
                    };
                    self.run_field(&inputs, &params, &band.pressure);
                }
            }
            first += count;
        }
        self.check()?;
        Ok(field)
    }

    fn run_field(&self, inputs: &Inputs, params: &Params, out: &wgpu::Buffer) {
        let make = || pipeline(&self.device, "field", &inputs.program.source());
        let pipeline = self.fields.borrow_mut().entry(inputs.program).or_insert_with(make).clone();
        let params_buffer = self.params(bytemuck::bytes_of(params));
        let mut bindings = vec![
            (0, &params_buffer),
            (1, &inputs.elements),
            (2, &inputs.columns),
            (3, &inputs.rows),
            (4, out),
        ];
        bindings.extend(inputs.nodes.as_ref().map(|nodes| (5, nodes)));
        let mut encoder = self.encoder();
        let workgroups = (params.count.div_ceil(WORKGROUP * SAMPLES_PER_INVOCATION), 1);
        self.dispatch(&mut encoder, &pipeline, &bindings, workgroups);
        self.submit(encoder);
    }
}

/// Buffers that every run of one field reads.
struct Inputs {
    program: FieldProgram,
    elements: wgpu::Buffer,
    columns: wgpu::Buffer,
    rows: wgpu::Buffer,
    nodes: Option<wgpu::Buffer>,
    params: Params,
    /// Elements.
    count: u32,
}

impl Inputs {
    fn new(gpu: &Gpu, wave: &Wave, elements: &[[f32; 4]], samples: &Samples) -> Self {
        let program = FieldProgram {
            exact_piston: wave.piston.is_some(),
            many_elements: elements.len() > UNIFORM_ELEMENTS,
            many_terms: wave.directivity.terms > 8 || wave.decay.terms > 4,
        };
        let wide = |points: &[glam::DVec3]| -> Vec<[f32; 4]> {
            points.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32, wave.turns(p.z)]).collect()
        };
        let storage = |label, values: &[[f32; 4]]| {
            gpu.filled(label, bytemuck::cast_slice(values), BufferUsages::STORAGE)
        };
        let uniform = |label, mut values: Vec<[f32; 4]>, length| {
            values.resize(length, [0.0; 4]);
            gpu.filled(label, bytemuck::cast_slice(&values), BufferUsages::UNIFORM)
        };
        let nodes = wave.piston.as_ref().map(|piston| {
            let nodes = piston.nodes.iter().map(|&[cos, sin2]| [cos, sin2, 0.0, 0.0]).collect();
            uniform("nodes", nodes, MOST_NODES)
        });
        Self {
            elements: if program.many_elements {
                storage("elements", elements)
            } else {
                uniform("elements", elements.to_vec(), UNIFORM_ELEMENTS)
            },
            program,
            columns: storage("columns", &wide(&samples.columns)),
            rows: storage("rows", &wide(&samples.rows)),
            nodes,
            params: params(wave, samples),
            count: elements.len() as u32,
        }
    }

    /// The elements, cut into runs that no driver breaks off.
    fn element_runs(&self) -> impl Iterator<Item = std::ops::Range<u32>> {
        // Two groups of four points, each with its nodes or its two polynomials.
        let rounds = 1 + 2 * self.params.nodes + if self.program.many_terms { 2 * (4 + 3) } else { 0 };
        let (length, count) = (MOST_ROUNDS_PER_RUN / rounds, self.count);
        (0..count).step_by(length as usize).map(move |first| first..count.min(first + length))
    }
}

fn params(wave: &Wave, samples: &Samples) -> Params {
    let (radius, nodes) = wave.piston.as_ref().map_or((0.0, 0), |piston| (piston.radius, piston.nodes.len()));
    Params {
        directivity: bytemuck::cast(wave.directivity.coefficients),
        decay: bytemuck::cast(wave.decay.coefficients),
        decay_scale: wave.decay_scale,
        turns_per_metre: wave.turns_per_metre,
        columns: samples.columns.len() as u32,
        nodes: nodes as u32,
        radius,
        piston_scale: if nodes > 0 { 2.0 / (radius * nodes as f32) } else { 0.0 },
        ..Params::default()
    }
}
