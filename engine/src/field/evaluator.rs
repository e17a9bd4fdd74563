//! The field at any points by one of the evaluators, in f64 where f32 does not suffice.

use num_complex::Complex32;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::gpu::Gpu;
use crate::field::gpu_report::GpuError;
use crate::field::samples::Samples;
use crate::field::sources::Sources;
use crate::field::{cpu, plan, reference, sound};
use crate::simd::larger;

/// The field evaluator.
#[derive(Debug)]
pub enum Evaluator {
    /// f64, point by point: slow and right.
    Reference,
    Cpu,
    Gpu(Box<Gpu>),
}

impl Evaluator {
    /// Complex pressure (Pa, peak) at every sample, within [`plan::EXACT`] of the largest: in f64 where f32 does not
    /// suffice.
    ///
    /// # Errors
    /// Errors of the GPU only: a lost device or insufficient memory.
    pub fn pressure(
        &self,
        aperture: &Aperture,
        drive: &Drive,
        samples: &Samples,
    ) -> Result<Vec<Complex32>, GpuError> {
        match self {
            Self::Reference => Ok(on_cpu(aperture, drive, samples, true)),
            Self::Cpu => in_f32(None, aperture, drive, samples),
            Self::Gpu(gpu) => in_f32(Some(gpu), aperture, drive, samples),
        }
    }
}

/// Complex pressure (Pa, peak) at every sample by a GPU or the CPU, in f64 where f32 does not suffice.
///
/// # Errors
/// Errors of the GPU only.
pub fn in_f32(
    gpu: Option<&Gpu>,
    aperture: &Aperture,
    drive: &Drive,
    samples: &Samples,
) -> Result<Vec<Complex32>, GpuError> {
    if !samples.is_empty() && plan::f32_error(aperture, samples) <= plan::EXACT {
        let field = unchecked(gpu, aperture, drive, samples)?;
        if is_exact(aperture, drive, samples, &field) {
            return Ok(field);
        }
    }
    Ok(on_cpu(aperture, drive, samples, true))
}

/// The same without comparison with f64, for values that are compared later.
///
/// # Errors
/// Errors of the GPU only.
pub fn unchecked(
    gpu: Option<&Gpu>,
    aperture: &Aperture,
    drive: &Drive,
    samples: &Samples,
) -> Result<Vec<Complex32>, GpuError> {
    let faces = gpu.and_then(|_| Sources::of_faces(aperture, drive, samples));
    match (gpu, faces.filter(|faces| faces.iter().all(Sources::has_no_sample_beside_rims))) {
        (Some(gpu), Some(faces)) => {
            let mut field = gpu.pressure(&faces)?;
            add_scattered(aperture, drive, samples, false, &mut field);
            Ok(field)
        }
        (_, _) => Ok(on_cpu(aperture, drive, samples, false)),
    }
}

/// Whether pressures agree with f64 at some of the samples.
pub fn is_exact(aperture: &Aperture, drive: &Drive, samples: &Samples, field: &[Complex32]) -> bool {
    /// Number of compared samples, and safety factor for the others.
    const COMPARED: usize = 96;
    const MARGIN: f32 = 3.0;
    let chosen: Vec<_> = (0..samples.len()).step_by(samples.len().div_ceil(COMPARED)).collect();
    let points = chosen.iter().map(|&index| samples.point(index)).collect();
    let expected = on_cpu(aperture, drive, &Samples::at(points), true);
    let off = chosen.iter().zip(expected).map(|(&index, p)| (field[index] - p).norm());
    MARGIN * off.fold(0.0, f32::max) <= plan::EXACT as f32 * peak(field)
}

/// Complex pressure (Pa, peak) at every sample by the CPU, in f64 if `double` or where f32 declines.
pub fn on_cpu(aperture: &Aperture, drive: &Drive, samples: &Samples, double: bool) -> Vec<Complex32> {
    let in_f64 =
        |samples: &Samples| reference::of_elements(aperture, drive, samples).into_iter().map(sound::narrow);
    let mut field = match Sources::of_faces(aperture, drive, samples) {
        Some(faces) if !double => {
            let mut field = cpu::pressure(&faces, samples.len());
            let mut beside: Vec<_> = faces.iter().flat_map(Sources::beside_rims).collect();
            beside.sort_unstable();
            beside.dedup();
            let points = beside.iter().map(|&index| samples.point(index)).collect();
            for (&index, p) in beside.iter().zip(in_f64(&Samples::at(points))) {
                field[index] = p;
            }
            field
        }
        _ => in_f64(samples).collect(),
    };
    add_scattered(aperture, drive, samples, double, &mut field);
    field
}

/// Adds what bodies scatter; within them nothing is a number.
pub fn add_scattered(
    aperture: &Aperture,
    drive: &Drive,
    samples: &Samples,
    double: bool,
    field: &mut [Complex32],
) {
    let Some((bodies, answer)) = aperture.answer(&drive.excitation(&aperture.driven)) else { return };
    let points: Vec<_> = (0..samples.len()).map(|index| samples.point(index)).collect();
    let scattered: Vec<_> = match double {
        true => bodies.sounds(&answer, &points).into_iter().map(|(p, _)| p).collect(),
        false => bodies.pressures(&answer, &points),
    };
    let all = field.par_iter_mut().zip(&points).zip(scattered);
    all.for_each(|((sum, at), p)| match bodies.contains(*at) {
        true => *sum = Complex32::new(f32::NAN, f32::NAN),
        false => *sum += sound::narrow(p),
    });
}

/// The largest |p| of a field, Pa.
pub fn peak(field: &[Complex32]) -> f32 {
    const LANES: usize = 16;
    let of_part = |part: &[Complex32]| {
        let (runs, rest) = part.as_chunks::<LANES>();
        let mut largest = [0.0f32; LANES];
        for run in runs {
            for (largest, p) in largest.iter_mut().zip(run) {
                *largest = larger(p.norm_sqr(), *largest);
            }
        }
        rest.iter().map(|p| p.norm_sqr()).chain(largest).fold(0.0, f32::max)
    };
    field.par_chunks(1 << 14).map(of_part).reduce(|| 0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};

    use super::*;
    use crate::field::quantity::Part;
    use crate::field::slope;
    use crate::scene::{Array, Board, Scene};

    /// Two boards face to face, 0.2 m apart.
    fn between_boards() -> (Aperture, Drive) {
        let array = Array { columns: 2, rows: 2, ..Array::default() };
        let opposite = Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() };
        let boards = vec![Board::default(), opposite];
        let drive = Drive { amplitudes: vec![1.0; 8], phases: (0..8).map(|n| 0.7 * f64::from(n)).collect() };
        (Aperture::new(&Scene { array, boards, ..Scene::default() }), drive)
    }

    #[test]
    fn the_field_of_usual_boards_is_in_f32_and_that_of_no_point_is_empty() {
        let (aperture, drive) = between_boards();
        let points = (0..40).map(|i| dvec3(0.002 * f64::from(i) - 0.03, 0.001 * f64::from(i), 0.09));
        let samples = Samples::at(points.collect());
        let expected = on_cpu(&aperture, &drive, &samples, false);
        assert_ne!(expected, on_cpu(&aperture, &drive, &samples, true));
        assert_eq!(Evaluator::Cpu.pressure(&aperture, &drive, &samples).unwrap(), expected);
        // Where f32 is not promised to suffice, it is not tried.
        let single = Array { columns: 1, rows: 1, ..Array::default() };
        let single = Aperture::new(&Scene { array: single, ..Scene::default() });
        for i in 0..20 {
            let far = Samples::at(vec![dvec3(0.9 + 0.011 * f64::from(i), 0.0, 0.1)]);
            let expected = on_cpu(&single, &drive, &far, true);
            assert_eq!(Evaluator::Cpu.pressure(&single, &drive, &far).unwrap(), expected);
        }
        let none = Samples::at(Vec::new());
        for evaluator in [Evaluator::Cpu, Evaluator::Reference] {
            assert!(evaluator.pressure(&aperture, &drive, &none).unwrap().is_empty());
        }
    }

    #[test]
    fn slopes_next_to_one_of_several_boards_are_those_of_f64() {
        /// m
        const HALF: f64 = 1e-7;
        let (aperture, drive) = between_boards();
        let point = |i: u32| dvec3(0.003 * f64::from(i) - 0.007, 0.002 * f64::from(i), 0.004);
        let near = Samples::at((0..6).map(point).collect());
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for (part, axis) in [Part::AlongX, Part::AlongY, Part::Normal].into_iter().zip(axes) {
            let slopes = |double| slope::part_on_cpu(&aperture, &drive, &near, part, axes, double);
            assert_eq!(slopes(false), slopes(true), "{part:?}");
            let [before, behind] = [HALF, -HALF]
                .map(|by| reference::pressure(&aperture, &drive, &slope::shifted(&near, axis * by)));
            let expected: Vec<_> =
                before.iter().zip(&behind).map(|(a, b)| sound::narrow((a - b) / (2.0 * HALF))).collect();
            assert_eq!(slopes(true).len(), near.len());
            let steepest = peak(&expected);
            for (slope, expected) in slopes(true).iter().zip(&expected) {
                let off = (slope - expected).norm();
                assert!(off < 1e-5 * steepest, "{part:?}: {slope}, not {expected}");
            }
        }
    }
}
