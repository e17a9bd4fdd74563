//! Maps of the second harmonic ([`crate::field::harmonic`]), with the fundamental by the evaluator of the other maps.

use num_complex::Complex32;

use crate::drive::Drive;
use crate::field::evaluator::{in_f32, on_cpu};
use crate::field::gpu::Gpu;
use crate::field::gpu_report::GpuError;
use crate::field::harmonic::{Overtone, over};
use crate::field::plan::{Costs, Plan};
use crate::field::samples::Samples;
use crate::field::stages::request::{By, FieldError, Map, Request};
use crate::field::stages::work::Work;
use crate::field::vicinity::Vicinity;
use crate::gauge::Gauge;

/// Its work; nothing is kept, since every input changes the sound of all the air.
#[derive(Debug, Default)]
pub(super) struct OfVolume {
    pub(super) work: Work,
}

impl OfVolume {
    /// The RMS pressure at 2f of every pixel, with the fundamental in f64 if `exact`.
    ///
    /// # Errors
    /// An invalid plane, or a scene without a harmonic.
    pub(super) fn map(
        &mut self,
        request: &Request,
        exact: bool,
        gpu: Option<&Gpu>,
        progress: &Gauge,
    ) -> Result<Map, FieldError> {
        let Request { aperture, air, plane, drives, size, .. } = request;
        Plan::new(aperture, plane, Costs::CPU).ok_or(FieldError::NoPlane)?;
        let pixels = Samples::on_plane(plane, size.0, size.1).ok_or(FieldError::NoPlane)?;
        let sample = |drive: &Drive, samples: &Samples| -> Result<Vec<Complex32>, GpuError> {
            if exact {
                Ok(on_cpu(aperture, drive, samples, true))
            } else {
                in_f32(gpu, aperture, drive, samples)
            }
        };
        let made = over((aperture, air), drives, (plane, *size), &sample, progress)?;
        self.work.superposition += drives.len() as u64;
        self.work.interpolation += 1;
        let Overtone { values, error, evaluated, steps, planes } = made;
        let left_out = Vicinity::new(aperture).of(&pixels);
        let [peak, others] = left_out.largest(&values);
        let how = format!(
            "sound of {evaluated} places on {planes} planes, {:.2} mm apart, in steps of {:.2} mm",
            steps[1] * 1e3,
            steps[0] * 1e3
        );
        let by = match (exact, gpu) {
            (true, _) => By::Reference,
            (false, Some(_)) => By::Gpu,
            (false, None) => By::Cpu,
        };
        let (width, height) = *size;
        let (loudest, near) = (peak.max(others), left_out.near);
        Ok(Map { width, height, values, peak, loudest, near, error, evaluated, by, how, ..Map::default() })
    }
}
