//! The GPU: finding one, and running the field's programs on it.
//!
//! Objects are sorted by lifetime: [`Gpu`] holds the device and its pipelines, [`GpuField`] one field's buffers. What
//! changes from run to run travels in `Params`.

pub mod adapter;
mod field;
pub mod program;

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use wgpu::util::DeviceExt;

use crate::field::Samples;
use crate::field::sources::{MOST_NODES, Sources};
use program::{FieldProgram, Params, SAMPLES_PER_INVOCATION, UNIFORM_ELEMENTS, WORKGROUP};

pub use adapter::AdapterInfo;
pub use field::{Colouring, GpuField};

/// Samples in one buffer; larger fields are cut into bands.
const MOST_SAMPLES_PER_BAND: u64 = 1 << 24;
/// Samples times elements in one submission, so that no driver thinks that the device hangs.
const MOST_PAIRS_PER_RUN: u64 = 1 << 31;
/// Rounds of loops in one invocation of the field: llvmpipe leaves a shader's loops after 65 535 of them in all, and
/// says nothing.
const MOST_ROUNDS_PER_RUN: u32 = 1 << 15;
/// How long one submission may take.
const TIMEOUT: std::time::Duration = std::time::Duration::from_secs(120);

/// Why the GPU did not do its work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error("no usable GPU adapter: {0}")]
    NoAdapter(String),
    #[error("the GPU refused the work: {0}")]
    Refused(String),
    #[error("the GPU was lost: {0}")]
    Lost(String),
}

/// A device with the field's pipelines, which are made when first needed.
#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: AdapterInfo,
    fields: RefCell<HashMap<FieldProgram, wgpu::ComputePipeline>>,
    peak: wgpu::ComputePipeline,
    picture: wgpu::ComputePipeline,
    interpolation: wgpu::ComputePipeline,
    /// The first error that no call was there to return.
    failure: Arc<Mutex<Option<GpuError>>>,
}

impl Gpu {
    /// Opens an adapter.
    ///
    /// # Errors
    /// The driver refuses a device or a pipeline.
    pub fn open(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let refused = |e: wgpu::RequestDeviceError| GpuError::Refused(e.to_string());
        let available = adapter.limits();
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: available.max_storage_buffer_binding_size,
            max_buffer_size: available.max_buffer_size,
            ..wgpu::Limits::default()
        };
        let descriptor =
            wgpu::DeviceDescriptor { label: Some("sonoglyph"), required_limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(refused)?;
        let failure = Arc::new(Mutex::new(None));
        watch(&device, &failure);
        let peak = pipeline(&device, "peak", &program::peak_source());
        let picture = pipeline(&device, "picture", &program::picture_source());
        let interpolation = pipeline(&device, "interpolation", &program::interpolation_source());
        let info = AdapterInfo::new(adapter);
        let fields = RefCell::default();
        let gpu = Self { device, queue, info, fields, peak, picture, interpolation, failure };
        gpu.check()?;
        Ok(gpu)
    }

    pub fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// Computes the field at every sample and leaves it on the GPU.
    ///
    /// # Errors
    /// The device was lost or has not enough memory.
    pub fn pressure(&self, sources: &Sources, samples: &Samples) -> Result<GpuField<'_>, GpuError> {
        let program = FieldProgram {
            exact_piston: sources.piston.is_some(),
            many_elements: sources.elements.len() > UNIFORM_ELEMENTS,
        };
        let pipeline = self.field_pipeline(program);
        let inputs = Inputs::new(self, program, sources, samples);
        let mut field = GpuField::empty(self);
        let total = samples.len() as u64;
        let band_length = self.samples_per_band();
        for first in (0..total).step_by(band_length as usize) {
            let count = band_length.min(total - first);
            let buffer = self.buffer(
                "pressure",
                count * 8,
                wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            );
            for elements in inputs.element_runs() {
                let run_length = (MOST_PAIRS_PER_RUN / elements.len() as u64).min(count);
                for written in (0..count).step_by(run_length as usize) {
                    let params = Params {
                        first_element: elements.start,
                        last_element: elements.end,
                        first: (first + written) as u32,
                        count: run_length.min(count - written) as u32,
                        written: written as u32,
                        ..inputs.params
                    };
                    self.run_field(&pipeline, &inputs, &params, &buffer);
                }
            }
            field.push(buffer, count as u32);
        }
        self.check()?;
        Ok(field)
    }

    fn samples_per_band(&self) -> u64 {
        (self.device.limits().max_storage_buffer_binding_size / 8).min(MOST_SAMPLES_PER_BAND)
    }

    fn field_pipeline(&self, program: FieldProgram) -> wgpu::ComputePipeline {
        let make = || pipeline(&self.device, "field", &program.source());
        self.fields.borrow_mut().entry(program).or_insert_with(make).clone()
    }

    fn run_field(
        &self,
        pipeline: &wgpu::ComputePipeline,
        inputs: &Inputs,
        params: &Params,
        out: &wgpu::Buffer,
    ) {
        let params_buffer = self.filled("params", bytemuck::bytes_of(params), wgpu::BufferUsages::UNIFORM);
        let mut bindings = vec![
            (0, &params_buffer),
            (1, &inputs.elements),
            (2, &inputs.columns),
            (3, &inputs.rows),
            (4, out),
        ];
        bindings.extend(inputs.nodes.as_ref().map(|nodes| (5, nodes)));
        self.dispatch(pipeline, &bindings, (params.count.div_ceil(WORKGROUP * SAMPLES_PER_INVOCATION), 1));
    }

    fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        bindings: &[(u32, &wgpu::Buffer)],
        (across, up): (u32, u32),
    ) {
        let entries: Vec<_> = bindings
            .iter()
            .map(|&(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = pipeline.get_bind_group_layout(0);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &entries,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(across, up, 1);
        drop(pass);
        self.queue.submit([encoder.finish()]);
    }

    fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    fn filled(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents,
            usage,
        })
    }

    /// Copies a buffer back and waits for it.
    fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.buffer("staging", buffer.size(), usage);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        let (send, receive) = std::sync::mpsc::sync_channel(1);
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only when this read has already failed.
            send.send(result).ok();
        });
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(TIMEOUT) };
        self.device.poll(wait).map_err(|e| GpuError::Lost(e.to_string()))?;
        self.check()?;
        let mapped =
            receive.try_recv().map_err(|_| GpuError::Lost("it did not answer in time".to_owned()))?;
        mapped.map_err(|e| GpuError::Lost(e.to_string()))?;
        let view = staging.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?;
        Ok(view.to_vec())
    }

    /// The failure that the driver has reported meanwhile.
    fn check(&self) -> Result<(), GpuError> {
        match &*self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner) {
            Some(failure) => Err(failure.clone()),
            None => Ok(()),
        }
    }
}

/// Keeps what would otherwise be a panic or go unseen.
fn watch(device: &wgpu::Device, failure: &Arc<Mutex<Option<GpuError>>>) {
    let keep = |failure: &Mutex<Option<GpuError>>, error| {
        failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
    };
    let refused = Arc::clone(failure);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        keep(&refused, GpuError::Refused(error.to_string()));
    }));
    let lost = Arc::clone(failure);
    device.set_device_lost_callback(move |_, message| keep(&lost, GpuError::Lost(message)));
}

fn pipeline(device: &wgpu::Device, name: &str, source: &str) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    })
}

/// Buffers that every run of one field reads.
struct Inputs {
    elements: wgpu::Buffer,
    columns: wgpu::Buffer,
    rows: wgpu::Buffer,
    nodes: Option<wgpu::Buffer>,
    params: Params,
    /// Elements.
    count: u32,
}

impl Inputs {
    fn new(gpu: &Gpu, program: FieldProgram, sources: &Sources, samples: &Samples) -> Self {
        let wide = |points: &[glam::DVec3]| -> Vec<[f32; 4]> {
            points.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32, sources.turns(p.z)]).collect()
        };
        let storage = |label, values: &[[f32; 4]]| {
            gpu.filled(label, bytemuck::cast_slice(values), wgpu::BufferUsages::STORAGE)
        };
        let uniform = |label, mut values: Vec<[f32; 4]>, length| {
            values.resize(length, [0.0; 4]);
            gpu.filled(label, bytemuck::cast_slice(&values), wgpu::BufferUsages::UNIFORM)
        };
        let elements = if program.many_elements {
            storage("elements", &sources.elements)
        } else {
            uniform("elements", sources.elements.clone(), UNIFORM_ELEMENTS)
        };
        let nodes = sources.piston.as_ref().map(|piston| {
            let nodes = piston.nodes.iter().map(|&[cos, sin2]| [cos, sin2, 0.0, 0.0]).collect();
            uniform("nodes", nodes, MOST_NODES)
        });
        Self {
            elements,
            columns: storage("columns", &wide(&samples.columns)),
            rows: storage("rows", &wide(&samples.rows)),
            nodes,
            params: params(sources, samples),
            count: sources.elements.len() as u32,
        }
    }

    /// The elements, cut into runs that no driver breaks off.
    fn element_runs(&self) -> impl Iterator<Item = std::ops::Range<u32>> {
        let general = self.params.directivity_terms > 8 || self.params.decay_terms > 4;
        // Two groups of four points, each with its nodes or its two polynomials.
        let rounds = 1 + 2 * self.params.nodes + if general { 2 * (4 + 3) } else { 0 };
        let (length, count) = (MOST_ROUNDS_PER_RUN / rounds, self.count);
        (0..count).step_by(length as usize).map(move |first| first..count.min(first + length))
    }
}

fn params(sources: &Sources, samples: &Samples) -> Params {
    let (radius, nodes) =
        sources.piston.as_ref().map_or((0.0, 0), |piston| (piston.radius, piston.nodes.len()));
    Params {
        directivity: bytemuck::cast(sources.directivity.coefficients),
        decay: bytemuck::cast(sources.decay.coefficients),
        decay_scale: sources.decay_scale,
        turns_per_metre: sources.turns_per_metre,
        directivity_terms: sources.directivity.terms as u32,
        decay_terms: sources.decay.terms as u32,
        columns: samples.columns.len() as u32,
        nodes: nodes as u32,
        radius,
        piston_scale: if nodes > 0 { 2.0 / (radius * nodes as f32) } else { 0.0 },
        ..Params::default()
    }
}
