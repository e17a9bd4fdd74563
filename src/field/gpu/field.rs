//! A field that lies on the GPU, and what is made of it there: its peak, colours, numbers.

use num_complex::Complex32;
use wgpu::BufferUsages;

use crate::field::gpu::program::{PeakParams, PictureParams, WORKGROUP};
use crate::field::gpu::{Gpu, GpuError};
use crate::field::{Colouring, Quantity};

/// Workgroups of the passes that walk over a whole band.
const WALKING_GROUPS: u32 = 1024;

/// A field that lies on the GPU, in bands that have a buffer each.
#[derive(Debug, Default)]
pub struct GpuField {
    bands: Vec<wgpu::Buffer>,
}

impl GpuField {
    pub(super) fn bands(&self) -> &[wgpu::Buffer] {
        &self.bands
    }

    pub(super) fn push(&mut self, band: wgpu::Buffer) {
        self.bands.push(band);
    }

    /// Puts the samples of another field behind these.
    pub fn append(&mut self, mut other: Self) {
        self.bands.append(&mut other.bands);
    }
}

fn count(band: &wgpu::Buffer) -> u32 {
    (band.size() / 8) as u32
}

impl Gpu {
    /// A field of zeros.
    pub(super) fn empty_field(&self, samples: usize) -> GpuField {
        let most = self.samples_per_band();
        let band = |first: usize| self.storage("pressure", (most.min(samples - first) * 8) as u64);
        GpuField { bands: (0..samples).step_by(most).map(band).collect() }
    }

    /// The largest |p| (Pa) and some samples as numbers.
    ///
    /// # Errors
    /// The device was lost.
    pub fn measure(&self, field: &GpuField, samples: &[usize]) -> Result<(f32, Vec<Complex32>), GpuError> {
        // The peak stands in front of the samples.
        let gathered = self.storage("gathered", (samples.len() as u64 + 1) * 8);
        let mut encoder = self.encoder();
        for band in &field.bands {
            let params = PeakParams { count: count(band), invocations: WALKING_GROUPS * WORKGROUP };
            let params = self.params(bytemuck::bytes_of(&params));
            let bindings = [(0, &params), (1, band), (2, &gathered)];
            self.dispatch(&mut encoder, &self.peak, &bindings, (WALKING_GROUPS, 1));
        }
        for (index, &sample) in samples.iter().enumerate() {
            let mut sample = sample as u64;
            for band in &field.bands {
                if sample < u64::from(count(band)) {
                    encoder.copy_buffer_to_buffer(band, sample * 8, &gathered, (index as u64 + 1) * 8, 8);
                    break;
                }
                sample -= u64::from(count(band));
            }
        }
        let bytes = self.read_buffer(encoder, &gathered)?;
        let numbers: &[Complex32] = bytemuck::cast_slice(&bytes);
        Ok((numbers[0].re, numbers[1..].to_vec()))
    }

    /// The field as numbers.
    ///
    /// # Errors
    /// The device was lost.
    pub fn read(&self, field: &GpuField) -> Result<Vec<Complex32>, GpuError> {
        let mut numbers = Vec::new();
        for band in &field.bands {
            numbers.extend_from_slice(bytemuck::cast_slice(&self.read_buffer(self.encoder(), band)?));
        }
        Ok(numbers)
    }

    /// The field as colours r, g, b, a of every sample, in its order; `peak` is its largest |p| (Pa).
    ///
    /// # Errors
    /// The device was lost.
    pub fn colours(
        &self,
        field: &GpuField,
        colouring: &Colouring,
        peak: f32,
        colours: &mut Vec<[u8; 4]>,
    ) -> Result<(), GpuError> {
        let table = self.filled("colours", bytemuck::cast_slice(&colouring.table), BufferUsages::STORAGE);
        colours.clear();
        for band in &field.bands {
            let params = PictureParams {
                count: count(band),
                invocations: WALKING_GROUPS * WORKGROUP,
                quantity: u32::from(colouring.quantity == Quantity::Phase),
                full: colouring.full.unwrap_or(peak),
            };
            let params = self.params(bytemuck::bytes_of(&params));
            let out = self.storage("picture", u64::from(count(band)) * 4);
            let mut encoder = self.encoder();
            let bindings = [(0, &params), (1, band), (2, &table), (3, &out)];
            self.dispatch(&mut encoder, &self.picture, &bindings, (WALKING_GROUPS, 1));
            colours.extend_from_slice(bytemuck::cast_slice(&self.read_buffer(encoder, &out)?));
        }
        Ok(())
    }
}
