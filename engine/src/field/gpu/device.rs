//! A device with its pipelines, and runs of programs on it.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use wgpu::BufferUsages;

use crate::field::gpu::program::Program;
use crate::field::gpu::tuning::{AdapterInfo, Tuning};
use crate::field::gpu_report::{GpuError, Traffic};

/// Bytes of a buffer, at most.
pub const LARGEST_BUFFER: u64 = 1 << 27;

/// A device with its pipelines, created on demand.
#[derive(Debug)]
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) info: AdapterInfo,
    pub(super) tuning: Tuning,
    /// Bytes in one buffer.
    pub(super) buffer_limit: u64,
    /// ns per tick, if passes can be timed.
    pub(super) tick: Option<f32>,
    pub(super) pipelines: RefCell<HashMap<Program, wgpu::ComputePipeline>>,
    pub(super) traffic: Cell<Traffic>,
    /// The first error that no call was there to return.
    pub(super) failure: Arc<Mutex<Option<GpuError>>>,
}

/// The requested device limits: except for sizes and timestamps, those of every adapter, so that tests catch a
/// program that needs more.
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let available = adapter.limits();
    let required_limits = wgpu::Limits {
        max_storage_buffer_binding_size: available.max_storage_buffer_binding_size,
        max_buffer_size: available.max_buffer_size,
        max_texture_dimension_2d: available.max_texture_dimension_2d,
        ..wgpu::Limits::downlevel_defaults()
    };
    wgpu::DeviceDescriptor {
        label: Some("sonoglyph"),
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        required_limits,
        ..Default::default()
    }
}

impl Gpu {
    /// Opens an adapter.
    ///
    /// # Errors
    /// The driver refuses a device.
    pub async fn open(adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let refused = |e: wgpu::RequestDeviceError| GpuError::Refused(e.to_string());
        let (device, queue) = adapter.request_device(&device_descriptor(adapter)).await.map_err(refused)?;
        let gpu = Self::on(adapter, device, queue);
        gpu.check()?;
        Ok(gpu)
    }

    /// Another instance on the same device, with its own pipelines.
    pub fn twin(&self) -> Self {
        Self {
            device: self.device.clone(),
            queue: self.queue.clone(),
            info: self.info.clone(),
            tuning: self.tuning,
            buffer_limit: self.buffer_limit,
            tick: self.tick,
            pipelines: RefCell::default(),
            traffic: Cell::default(),
            failure: Arc::clone(&self.failure),
        }
    }

    /// An existing device that also draws a window.
    pub fn on(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let limits = device.limits();
        let failure = Arc::new(Mutex::new(None));
        watch(&device, &failure);
        let has_clock = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let info = AdapterInfo::new(adapter);
        Self {
            tuning: Tuning::of(info.kind),
            info,
            buffer_limit: limits
                .max_storage_buffer_binding_size
                .min(limits.max_buffer_size)
                .min(LARGEST_BUFFER),
            tick: has_clock.then(|| queue.get_timestamp_period()),
            pipelines: RefCell::default(),
            traffic: Cell::default(),
            device,
            queue,
            failure,
        }
    }

    pub fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// Whether 3D pictures are faster here than on the CPU.
    pub fn draws_space(&self) -> bool {
        self.tuning.draws_space
    }

    /// The device itself, for other renderers.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Traffic so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    /// The same device with buffers of at most `bytes`, as if it had no room for larger ones.
    #[doc(hidden)]
    pub fn with_small_buffers(self, bytes: u64) -> Self {
        Self { buffer_limit: self.buffer_limit.min(bytes), ..self }
    }

    /// The same device with work cut as for another kind of adapter.
    #[doc(hidden)]
    pub fn with_tuning(self, tuning: Tuning) -> Self {
        Self { tuning, pipelines: RefCell::default(), ..self }
    }

    /// Loses the device, as a driver may at any time: every later call fails.
    #[doc(hidden)]
    pub fn lose(&self) {
        self.device.destroy();
    }

    /// A pipeline, created on demand.
    pub(super) fn pipeline(&self, program: Program) -> wgpu::ComputePipeline {
        let make = || pipeline(&self.device, &format!("{program:?}"), &program.source(&self.tuning));
        self.pipelines.borrow_mut().entry(program).or_insert_with(make).clone()
    }

    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&Default::default())
    }

    pub(super) fn submit(&self, encoder: wgpu::CommandEncoder) {
        self.queue.submit([encoder.finish()]);
    }

    pub(super) fn count(&self, count: impl FnOnce(&mut Traffic)) {
        let mut traffic = self.traffic.get();
        count(&mut traffic);
        self.traffic.set(traffic);
    }

    pub(super) fn buffer(&self, label: &str, size: u64, usage: BufferUsages) -> wgpu::Buffer {
        self.count(|traffic| traffic.allocations += 1);
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Memory that programs read and write, filled with zeros.
    pub(super) fn storage(&self, label: &str, size: u64) -> wgpu::Buffer {
        self.buffer(label, size, BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST)
    }

    pub(super) fn filled(&self, label: &str, contents: &[u8], usage: BufferUsages) -> wgpu::Buffer {
        // Not by mapping, which would panic on a lost device.
        let buffer = self.buffer(label, contents.len() as u64, usage | BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    pub(super) fn params(&self, contents: &[u8]) -> wgpu::Buffer {
        self.filled("params", contents, BufferUsages::UNIFORM)
    }

    /// A program with its bound buffers.
    pub(super) fn step(
        &self,
        program: Program,
        bindings: &[(u32, wgpu::BindingResource<'_>)],
        workgroups: (u32, u32),
    ) -> Step {
        let pipeline = self.pipeline(program);
        let entries: Vec<_> = bindings
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.clone() })
            .collect();
        let layout = pipeline.get_bind_group_layout(0);
        self.count(|traffic| traffic.allocations += 1);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &entries,
        });
        Step { pipeline, group, workgroups, pairs: 0 }
    }

    /// Waits for all submitted work.
    ///
    /// # Errors
    /// The device was lost, or does not answer.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait(&self) -> Result<(), GpuError> {
        /// Time limit of a submission.
        const TIMEOUT: std::time::Duration = std::time::Duration::from_secs(120);
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(TIMEOUT) };
        self.device.poll(wait).map(|_| ()).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// A browser's device reports between two tasks of the page: poll instead.
    ///
    /// # Errors
    /// Always.
    #[cfg(target_arch = "wasm32")]
    pub fn wait(&self) -> Result<(), GpuError> {
        Err(GpuError::Refused("a page cannot wait for its GPU".to_owned()))
    }

    /// The failure that the driver has reported meanwhile.
    ///
    /// # Errors
    /// It is there.
    pub fn check(&self) -> Result<(), GpuError> {
        // A loss is reported by polling, and explains later refusals.
        self.device.poll(wgpu::PollType::Poll).ok();
        let failure = self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
        failure.map_or(Ok(()), Err)
    }
}

/// One run of a program.
#[derive(Debug)]
pub struct Step {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) group: wgpu::BindGroup,
    pub(super) workgroups: (u32, u32),
    /// Samples times elements.
    pub(super) pairs: u64,
}

impl Step {
    pub(super) fn run(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(self.workgroups.0, self.workgroups.1, 1);
    }
}

/// Records errors that would otherwise panic or be lost.
pub fn watch(device: &wgpu::Device, failure: &Arc<Mutex<Option<GpuError>>>) {
    // The first refusal is the most informative, and a loss explains all others.
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

pub fn pipeline(device: &wgpu::Device, name: &str, source: &str) -> wgpu::ComputePipeline {
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
    use crate::field::gpu::{Reading, adapter};
    use crate::field::quantity::Quantity;
    use crate::requirement::found;

    /// The software adapter is as good as any here. A machine without one fails the test where a GPU is required.
    fn gpu() -> Option<Gpu> {
        found("gpu", adapter::open_best(true))
    }

    #[test]
    fn all_programs_include_every_form_of_every_quantity() {
        let all = Program::all();
        for quantity in Quantity::ALL {
            assert!(all.contains(&Program::Form(quantity)), "{quantity:?}");
            assert!(all.contains(&Program::FormDirect(quantity)), "{quantity:?}");
        }
        let distinct: std::collections::HashSet<_> = all.iter().collect();
        assert_eq!(distinct.len(), all.len());
    }

    #[test]
    fn no_more_is_asked_of_an_adapter_than_every_adapter_has() {
        let Some(gpu) = gpu() else { return };
        let (asked, lowest) = (gpu.device.limits(), wgpu::Limits::downlevel_defaults());
        let of_room = wgpu::Limits {
            max_buffer_size: asked.max_buffer_size,
            max_storage_buffer_binding_size: asked.max_storage_buffer_binding_size,
            max_texture_dimension_2d: asked.max_texture_dimension_2d,
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
        assert!(matches!(Reading::new(&gpu, gpu.encoder(), &huge).wait(&gpu), Err(GpuError::Refused(_))));
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
