//! The GPU: finding one, and running the field's programs on it.
//!
//! Objects are sorted by lifetime: [`Gpu`] holds the device and its pipelines, [`GpuResampling`] the weights
//! of one map's pixels, [`GpuField`] one field's buffers. What changes from run to run travels in `Params`.

pub mod adapter;
mod average;
mod field;
pub mod program;
mod resampling;
mod waves;

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use wgpu::BufferUsages;

use crate::field::{Colouring, Quantity, Scale};
use program::FieldProgram;

pub use adapter::AdapterInfo;
pub use average::GpuTank;
pub use field::GpuField;
pub use resampling::GpuResampling;

/// Samples in one buffer; larger fields are cut into bands.
const MOST_SAMPLES_PER_BAND: u64 = 1 << 24;
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

type OtherProgram = (&'static str, Option<(Quantity, Scale)>);

/// A device with its pipelines, most of which are made when first needed.
#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: AdapterInfo,
    /// Bytes in one buffer.
    buffer_limit: u64,
    fields: RefCell<HashMap<FieldProgram, wgpu::ComputePipeline>>,
    interpolation: wgpu::ComputePipeline,
    /// Programs besides those of the field, by name, and quantity and scale.
    others: RefCell<HashMap<OtherProgram, wgpu::ComputePipeline>>,
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
        // But for room, no more than any adapter has; so a program that wants more fails on all of them, and tests see it.
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: available.max_storage_buffer_binding_size,
            max_buffer_size: available.max_buffer_size,
            ..wgpu::Limits::downlevel_defaults()
        };
        let buffer_limit = required_limits.max_storage_buffer_binding_size.min(available.max_buffer_size);
        let descriptor =
            wgpu::DeviceDescriptor { label: Some("sonoglyph"), required_limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(refused)?;
        let failure = Arc::new(Mutex::new(None));
        watch(&device, &failure);
        let gpu = Self {
            interpolation: pipeline(&device, "interpolation", &program::interpolation_source()),
            info: AdapterInfo::new(adapter),
            buffer_limit,
            fields: RefCell::default(),
            others: RefCell::default(),
            device,
            queue,
            failure,
        };
        gpu.check()?;
        Ok(gpu)
    }

    pub fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// The same device with buffers of at most `bytes`, as if it had no room for larger ones.
    pub fn with_small_buffers(self, bytes: u64) -> Self {
        Self { buffer_limit: self.buffer_limit.min(bytes), ..self }
    }

    /// Gives the device up, as a driver may at any time: every later call fails.
    pub fn lose(&self) {
        self.device.destroy();
    }

    fn peak_pipeline(&self, quantity: Quantity) -> wgpu::ComputePipeline {
        self.other(("peak", Some((quantity, Scale::Linear))), || program::peak_source(quantity))
    }

    fn picture_pipeline(&self, colouring: &Colouring) -> wgpu::ComputePipeline {
        let (quantity, scale) = (colouring.quantity, colouring.scale());
        self.other(("picture", Some((quantity, scale))), || program::picture_source(quantity, scale))
    }

    /// A pipeline that is made when first needed.
    fn other(&self, program: OtherProgram, source: impl FnOnce() -> String) -> wgpu::ComputePipeline {
        let mut others = self.others.borrow_mut();
        others.entry(program).or_insert_with(|| pipeline(&self.device, program.0, &source())).clone()
    }

    fn samples_per_band(&self) -> usize {
        (self.buffer_limit / 8).min(MOST_SAMPLES_PER_BAND) as usize
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&Default::default())
    }

    fn submit(&self, encoder: wgpu::CommandEncoder) {
        self.queue.submit([encoder.finish()]);
    }

    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
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
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(across, up, 1);
    }

    /// Memory that programs read and write, filled with zeros.
    fn storage(&self, label: &str, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    fn filled(&self, label: &str, contents: &[u8], usage: BufferUsages) -> wgpu::Buffer {
        // Not by mapping it: that would panic on a lost device.
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: contents.len() as u64,
            usage: usage | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    fn params(&self, contents: &[u8]) -> wgpu::Buffer {
        self.filled("params", contents, BufferUsages::UNIFORM)
    }

    /// Copies a buffer back, after what the encoder holds, and waits for it.
    fn read_buffer(
        &self,
        mut encoder: wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
    ) -> Result<Vec<u8>, GpuError> {
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size: buffer.size(),
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.submit(encoder);
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
        let failure = || self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
        if matches!(failure(), Some(GpuError::Refused(_))) {
            // A lost device refuses everything, and says only when it is asked that it is lost.
            self.device.poll(wgpu::PollType::Poll).ok();
        }
        failure().map_or(Ok(()), Err)
    }
}

/// Keeps what would otherwise be a panic or go unseen.
fn watch(device: &wgpu::Device, failure: &Arc<Mutex<Option<GpuError>>>) {
    // The first refusal tells most, and a loss explains all.
    let keep = |failure: &Mutex<Option<GpuError>>, error| {
        let mut kept = failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if kept.is_none() || matches!(error, GpuError::Lost(_)) {
            *kept = Some(error);
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requirement::found;

    /// The software adapter is as good as any here. A machine without one fails the test where a GPU is required.
    fn gpu() -> Option<Gpu> {
        found("gpu", adapter::open_best(true))
    }

    #[test]
    fn no_more_is_asked_of_an_adapter_than_every_adapter_has() {
        let Some(gpu) = gpu() else { return };
        let (asked, lowest) = (gpu.device.limits(), wgpu::Limits::downlevel_defaults());
        let of_room = wgpu::Limits {
            max_buffer_size: asked.max_buffer_size,
            max_storage_buffer_binding_size: asked.max_storage_buffer_binding_size,
            ..lowest
        };
        assert_eq!(asked, of_room);
        // So one storage buffer too many is refused by all of them.
        let buffers: String = (1..=5)
            .map(|n| format!("@group(0) @binding({n}) var<storage, read_write> b{n}: array<u32>;\n"))
            .collect();
        let sum = "@compute @workgroup_size(1) fn main() { b1[0] = b2[0] + b3[0] + b4[0] + b5[0]; }";
        pipeline(&gpu.device, "five", &format!("{buffers}{sum}"));
        assert!(matches!(gpu.check(), Err(GpuError::Refused(_))), "{:?}", gpu.check());
    }

    #[test]
    fn what_has_no_room_is_refused_without_a_panic_and_stays_refused() {
        let Some(gpu) = gpu() else { return };
        let huge = gpu.storage("huge", 1 << 60);
        assert!(matches!(gpu.check(), Err(GpuError::Refused(_))));
        assert!(matches!(gpu.read_buffer(gpu.encoder(), &huge), Err(GpuError::Refused(_))));
    }

    #[test]
    fn the_first_refusal_is_what_is_told_until_the_device_is_lost() {
        let Some(gpu) = gpu() else { return };
        gpu.storage("first", 1 << 60);
        let first = gpu.check();
        assert!(matches!(&first, Err(GpuError::Refused(why)) if why.contains("first")), "{first:?}");
        gpu.storage("second", 1 << 60);
        assert_eq!(gpu.check(), first);
        gpu.lose();
        assert!(matches!(gpu.check(), Err(GpuError::Lost(_))), "{:?}", gpu.check());
        gpu.storage("third", 1 << 60);
        assert!(matches!(gpu.check(), Err(GpuError::Lost(_))), "a loss explains what is refused after it");
    }
}
