//! A field that lies on the GPU, and what is made of it there: its peak, colours, numbers.

use num_complex::Complex32;
use wgpu::BufferUsages;

use crate::field::gpu::program::{PeakParams, PictureParams, WORKGROUP};
use crate::field::gpu::{Gpu, GpuError};
use crate::field::{Colouring, Quantity};

/// Workgroups of the passes that walk over a whole band.
pub(super) const WALKING_GROUPS: u32 = 256;

/// A field that lies on the GPU, in bands that have a buffer each.
#[derive(Debug, Default)]
pub struct GpuField {
    bands: Vec<Band>,
}

#[derive(Debug)]
pub(super) struct Band {
    pub(super) pressure: wgpu::Buffer,
    /// The largest |p|, where what made the band has found it on the way.
    pub(super) peak: Option<wgpu::Buffer>,
}

impl GpuField {
    pub(super) fn bands(&self) -> &[Band] {
        &self.bands
    }

    pub(super) fn push(&mut self, band: Band) {
        self.bands.push(band);
    }

    /// Puts the samples of another field behind these.
    pub fn append(&mut self, mut other: Self) {
        self.bands.append(&mut other.bands);
    }
}

impl Band {
    /// Samples.
    pub(super) fn len(&self) -> u32 {
        (self.pressure.size() / 8) as u32
    }
}

impl Gpu {
    /// A field of zeros.
    pub fn zeros(&self, samples: usize) -> GpuField {
        let most = self.samples_per_band();
        let band = |first: usize| Band {
            pressure: self.storage("pressure", (most.min(samples - first) * 8) as u64),
            peak: None,
        };
        GpuField { bands: (0..samples).step_by(most).map(band).collect() }
    }

    /// The largest number that a quantity shows (of |p|, Pa, for pressures) and some samples as they are.
    ///
    /// # Errors
    /// The device was lost.
    pub fn measure(
        &self,
        field: &GpuField,
        quantity: Quantity,
        samples: &[usize],
    ) -> Result<(f32, Vec<Complex32>), GpuError> {
        // The peaks of the bands stand in front of the samples.
        let peaks = field.bands.len();
        let gathered = self.storage("gathered", ((peaks + samples.len()) * 8) as u64);
        let mut encoder = self.encoder();
        for (index, band) in field.bands.iter().enumerate() {
            let found;
            let peak = match &band.peak {
                Some(peak) if quantity == Quantity::Rms || !quantity.is_amount() => peak,
                _ => {
                    found = self.band_peak(&mut encoder, band, quantity);
                    &found
                }
            };
            encoder.copy_buffer_to_buffer(peak, 0, &gathered, index as u64 * 8, 4);
        }
        for (index, &sample) in samples.iter().enumerate() {
            let mut sample = sample as u64;
            for band in &field.bands {
                if sample < u64::from(band.len()) {
                    let to = (peaks + index) as u64 * 8;
                    encoder.copy_buffer_to_buffer(&band.pressure, sample * 8, &gathered, to, 8);
                    break;
                }
                sample -= u64::from(band.len());
            }
        }
        let bytes = self.read_buffer(encoder, &gathered)?;
        let numbers: &[Complex32] = bytemuck::cast_slice(&bytes);
        let peak = numbers[..peaks].iter().map(|p| p.re).fold(0.0, f32::max);
        Ok((peak, numbers[peaks..].to_vec()))
    }

    fn band_peak(&self, encoder: &mut wgpu::CommandEncoder, band: &Band, quantity: Quantity) -> wgpu::Buffer {
        let peak = self.storage("peak", 4);
        let params = PeakParams { count: band.len(), invocations: WALKING_GROUPS * WORKGROUP };
        let params = self.params(bytemuck::bytes_of(&params));
        let bindings = [(0, &params), (1, &band.pressure), (2, &peak)];
        self.dispatch(encoder, &self.peak_pipeline(quantity), &bindings, (WALKING_GROUPS, 1));
        peak
    }

    /// The field as numbers.
    ///
    /// # Errors
    /// The device was lost.
    pub fn read(&self, field: &GpuField) -> Result<Vec<Complex32>, GpuError> {
        let mut numbers = Vec::new();
        for band in &field.bands {
            numbers
                .extend_from_slice(bytemuck::cast_slice(&self.read_buffer(self.encoder(), &band.pressure)?));
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
        let pipeline = self.picture_pipeline(colouring);
        let table = self.filled("colours", bytemuck::cast_slice(&colouring.table), BufferUsages::STORAGE);
        colours.clear();
        for band in &field.bands {
            let params = PictureParams {
                count: band.len(),
                invocations: WALKING_GROUPS * WORKGROUP,
                turn: [colouring.turn().re, colouring.turn().im],
                full: colouring.full.unwrap_or(peak),
                padding: 0,
            };
            let params = self.params(bytemuck::bytes_of(&params));
            let out = self.storage("picture", u64::from(band.len()) * 4);
            let mut encoder = self.encoder();
            let bindings = [(0, &params), (1, &band.pressure), (2, &table), (3, &out)];
            self.dispatch(&mut encoder, &pipeline, &bindings, (WALKING_GROUPS, 1));
            colours.extend_from_slice(bytemuck::cast_slice(&self.read_buffer(encoder, &out)?));
        }
        Ok(())
    }
}
