//! Pending read-backs from the GPU.

use std::sync::{Arc, OnceLock};

use wgpu::BufferUsages;

use crate::field::gpu::Gpu;
use crate::field::gpu_report::GpuError;

/// CPU-readable memory with the latest copy.
#[derive(Debug)]
pub struct Reading {
    staging: wgpu::Buffer,
    /// Whether the copy has arrived; `None` without a request.
    arrived: Option<Arrival>,
}

type Arrival = Arc<OnceLock<Result<(), wgpu::BufferAsyncError>>>;

impl Reading {
    /// A buffer with room for `bytes` bytes.
    pub(super) fn with_room(gpu: &Gpu, bytes: u64) -> Self {
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        Self { staging: gpu.buffer("staging", bytes, usage), arrived: None }
    }

    /// A copy of a whole buffer, after the encoder's commands.
    pub(super) fn new(gpu: &Gpu, encoder: wgpu::CommandEncoder, buffer: &wgpu::Buffer) -> Self {
        let mut reading = Self::with_room(gpu, buffer.size());
        reading.ask(gpu, encoder, &[buffer]);
        reading
    }

    /// Whether no copy is pending, so that it can be reused.
    pub(super) fn is_free(&self) -> bool {
        self.arrived.is_none()
    }

    /// Submits the encoder's commands, and requests copies of whole buffers in sequence.
    pub(super) fn ask(&mut self, gpu: &Gpu, mut encoder: wgpu::CommandEncoder, buffers: &[&wgpu::Buffer]) {
        let mut place = 0;
        for buffer in buffers {
            encoder.copy_buffer_to_buffer(buffer, 0, &self.staging, place, buffer.size());
            place += buffer.size();
        }
        gpu.submit(encoder);
        let arrived = Arrival::default();
        self.arrived = Some(arrived.clone());
        self.staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // This is the only setter.
            arrived.set(result).ok();
        });
    }

    /// The bytes, if available, without waiting.
    ///
    /// # Errors
    /// The device was lost.
    pub fn poll(&mut self, gpu: &Gpu) -> Result<Option<Vec<u8>>, GpuError> {
        gpu.check()?;
        let Some(arrived) = self.arrived.as_ref().and_then(|arrived| arrived.get().cloned()) else {
            return Ok(None);
        };
        arrived.map_err(|e| GpuError::Lost(e.to_string()))?;
        let view = self.staging.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?;
        let bytes = view.to_vec();
        drop(view);
        self.staging.unmap();
        self.arrived = None;
        gpu.count(|traffic| traffic.read_back += bytes.len() as u64);
        Ok(Some(bytes))
    }

    /// The bytes, after waiting for them.
    ///
    /// # Errors
    /// The device was lost, or does not answer.
    pub fn wait(&mut self, gpu: &Gpu) -> Result<Vec<u8>, GpuError> {
        gpu.wait()?;
        self.poll(gpu)?.ok_or_else(|| GpuError::Lost("it did not answer in time".to_owned()))
    }
}
