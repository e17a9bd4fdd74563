//! Slopes of the pressure where no grid gives them: central differences of fourth order along a direction.

use glam::DVec3;
use num_complex::{Complex32, Complex64};

use crate::acoustics::Aperture;
use crate::acoustics::element::NEAREST;
use crate::drive::Drive;
use crate::field::quantity::{Part, Sound, narrow};
use crate::field::{Samples, on_cpu};

/// Places (steps) and weights (per step): off by (kh)⁴/30 of the slope.
const STENCIL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
/// Steps in a wavelength where the pressures are f32: truncation, 5e-5, and rounding are alike.
const PER_WAVELENGTH: f64 = 32.0;
/// The same in f64, where only what comes of it is rounded to f32.
const PER_WAVELENGTH_IN_F64: f64 = 200.0;
/// The finest tolerance for which slopes by f32 differences will do.
pub const FINEST_IN_F32: f64 = 2e-4;

/// Shifts (m) of the samples along a direction, and the weights (1/m) with which their pressures add up to the slope.
pub fn stencil(wavelength: f64, double: bool) -> [(f64, f64); 4] {
    let step = wavelength / if double { PER_WAVELENGTH_IN_F64 } else { PER_WAVELENGTH };
    STENCIL.map(|(place, weight)| (place * step, weight / step))
}

/// The samples moved by an offset (m).
pub fn shifted(samples: &Samples, offset: DVec3) -> Samples {
    let columns = samples.columns.iter().map(|point| *point + offset).collect();
    Samples { columns, rows: samples.rows.clone() }
}

/// One part of the sound (see [`crate::field::quantity`]) at every sample, by the CPU: Pa, or Pa/m along one of the plane's
/// two axes and its normal.
pub fn part_on_cpu(
    aperture: &Aperture,
    drive: &Drive,
    samples: &Samples,
    part: Part,
    axes: [DVec3; 3],
    double: bool,
) -> Vec<Complex32> {
    let direction = match part {
        Part::Pressure => return on_cpu(aperture, drive, samples, double),
        Part::AlongX => axes[0],
        Part::AlongY => axes[1],
        Part::Normal => axes[2],
    };
    let stencil = stencil(aperture.wavelength(), double);
    // The stencil stays in front of the array, beyond which there is no sound.
    let reach = stencil[3].0 * direction.z.abs() + NEAREST;
    let lowest = samples.bounds().0.z;
    let lifted;
    let samples = if lowest < reach {
        let lift = |point: DVec3| if point.z < -NEAREST { point } else { point.with_z(point.z.max(reach)) };
        lifted = Samples::at((0..samples.len()).map(|index| lift(samples.point(index))).collect());
        &lifted
    } else {
        samples
    };
    let mut slopes = vec![Complex32::ZERO; samples.len()];
    for (shift, weight) in stencil {
        let pressures = on_cpu(aperture, drive, &shifted(samples, direction * shift), double);
        for (slope, p) in slopes.iter_mut().zip(pressures) {
            *slope += p * weight as f32;
        }
    }
    if lowest < reach {
        for (index, slope) in slopes.iter_mut().enumerate() {
            if samples.point(index).z < -NEAREST {
                *slope = Complex32::ZERO;
            }
        }
    }
    slopes
}

/// Points beside others at which pressures in f64 give the sound there: the reference for slopes.
#[derive(Clone, Debug)]
pub struct Around {
    parts: u8,
    axes: [DVec3; 3],
    /// m, from a point to its neighbours: far enough for f64, and much less than a wavelength.
    hair: f64,
}

impl Around {
    /// For these parts of the sound, along the plane's axes and its normal.
    pub fn new(parts: u8, axes: [DVec3; 3], wavelength: f64) -> Self {
        Self { parts, axes, hair: 1e-3 * wavelength }
    }

    /// As many points for each as [`Around::sounds`] takes pressures.
    pub fn points(&self, points: &[DVec3]) -> Vec<DVec3> {
        let along = |part| match part {
            Part::Pressure => None,
            Part::AlongX => Some(self.axes[0]),
            Part::AlongY => Some(self.axes[1]),
            Part::Normal => Some(self.axes[2]),
        };
        let mut around = Vec::new();
        for &point in points {
            for part in Part::of(self.parts) {
                match along(part) {
                    None => around.push(point),
                    Some(axis) => around.extend([point + axis * self.hair, point - axis * self.hair]),
                }
            }
        }
        around
    }

    /// The sound at the points, from the pressures (Pa, peak) around them.
    pub fn sounds(&self, pressures: &[Complex64]) -> Vec<Sound> {
        let mut pressures = pressures.iter().copied();
        let mut sounds = Vec::new();
        while pressures.len() > 0 {
            let mut next = || pressures.next().unwrap_or_default();
            let mut sound = Sound::default();
            for part in Part::of(self.parts) {
                *sound.part_mut(part) = narrow(match part {
                    Part::Pressure => next(),
                    Part::AlongX | Part::AlongY | Part::Normal => (next() - next()) / (2.0 * self.hair),
                });
            }
            sounds.push(sound);
        }
        sounds
    }
}
