//! Slopes of the pressure along a direction where no grid provides them: by differences in f32, and in f64 by the
//! transfer's own slopes.
//!
//! Slopes along the plane's normal are differences between samples on four more planes, a thirty-second and a
//! sixteenth of a wavelength away on either side. One table of these differences is used like that of the pressure.
//! Near the array, without interpolation, all slopes are such differences.

use std::sync::OnceLock;

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::acoustics::{Aperture, Moments, Transfer};
use crate::drive::Drive;
use crate::field::evaluator::on_cpu;
use crate::field::quantity::{Constants, Mean, Part, Quantity, Sound, narrow};
use crate::field::samples::Samples;
use crate::gauge::Gauge;
use crate::scene::Spread;

/// Positions (steps) and weights (per step) for pressures in f32: relative error (kh)⁴/30.
const STENCIL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
/// Steps in a wavelength: truncation, 5e-5, and rounding are alike.
const PER_WAVELENGTH: f64 = 32.0;
/// Distance from the array, in wavelengths, within which slopes need f64: there an element's wave varies over its
/// distance, not over a wavelength.
const NEAR: f64 = 1.0;
/// Points evaluated together in f64.
const RUN: usize = 16;
/// The finest tolerance for which slopes by f32 differences will do.
pub const FINEST_IN_F32: f64 = 2e-4;

/// Shifts (m) of the samples along a direction, and the weights (1/m) of their f32 pressures in the slope.
pub fn stencil(wavelength: f64) -> [(f64, f64); 4] {
    let step = wavelength / PER_WAVELENGTH;
    STENCIL.map(|(place, weight)| (place * step, weight / step))
}

/// The samples moved by an offset (m).
pub fn shifted(samples: &Samples, offset: DVec3) -> Samples {
    let columns = samples.columns.iter().map(|point| *point + offset).collect();
    Samples { columns, rows: samples.rows.clone() }
}

/// One part of the sound (see [`crate::field::quantity`]) at every sample, by the CPU: Pa, or Pa/m along one of the
/// plane's two axes and its normal. In f64 if `double`, or where f32 is inaccurate.
pub fn part_on_cpu(
    aperture: &Aperture,
    drive: &Drive,
    samples: &Samples,
    part: Part,
    axes: [DVec3; 3],
    double: bool,
) -> Vec<Complex32> {
    let Some(direction) = direction(part, axes) else { return on_cpu(aperture, drive, samples, double) };
    let (near, walls) = (NEAR * aperture.wavelength(), aperture.walls());
    let is_beside = |point: DVec3| walls.iter().any(|(at, normal)| normal.dot(point - at).abs() < near);
    let is_near = |&index: &usize| double || is_beside(samples.point(index));
    let in_f64: Vec<_> = (0..samples.len()).filter(is_near).collect();
    let mut slopes = vec![Complex32::ZERO; samples.len()];
    if in_f64.len() < samples.len() {
        for (shift, weight) in stencil(aperture.wavelength()) {
            let pressures = on_cpu(aperture, drive, &shifted(samples, direction * shift), false);
            for (slope, p) in slopes.iter_mut().zip(pressures) {
                *slope += p * weight as f32;
            }
        }
    }
    let points: Vec<_> = in_f64.iter().map(|&index| samples.point(index)).collect();
    for (index, slope) in in_f64.into_iter().zip(slopes_in_f64(aperture, drive, direction, &points)) {
        slopes[index] = slope;
    }
    slopes
}

/// Slopes along a direction at points, in f64.
fn slopes_in_f64(aperture: &Aperture, drive: &Drive, direction: DVec3, points: &[DVec3]) -> Vec<Complex32> {
    let excitation = drive.excitation(&aperture.driven);
    let counter = Gauge::current().count(points.len().div_ceil(RUN));
    let of_run = |points: &[DVec3]| {
        counter.add();
        let sounds = aperture.transfer_with_slopes(points, &[direction]).pressure(&excitation);
        sounds.into_iter().skip(1).step_by(2).map(narrow).collect::<Vec<_>>()
    };
    points.par_chunks(RUN).flat_map_iter(of_run).collect()
}

/// The direction of a slope; the pressure has none.
fn direction(part: Part, [x, y, normal]: [DVec3; 3]) -> Option<DVec3> {
    match part {
        Part::Pressure => None,
        Part::AlongX => Some(x),
        Part::AlongY => Some(y),
        Part::Normal => Some(normal),
    }
}

/// The f64 transfer of the sound to points: the reference of maps.
#[derive(Clone, Debug)]
pub struct SoundTransfer {
    parts: u8,
    /// Transfer of the pressure at each point and, if any part is one, of the slopes among the parts; from the elements.
    transfer: Transfer,
    /// What bodies scatter to the points, if there are any.
    scattered: Option<Scattered>,
}

/// Points that bodies scatter to, and the directions of the slopes that are needed.
#[derive(Clone, Debug)]
struct Scattered {
    aperture: Aperture,
    points: Vec<DVec3>,
    directions: Vec<DVec3>,
    /// The total transfer, once the answers of bodies to all elements are known.
    total: OnceLock<Transfer>,
}

impl SoundTransfer {
    /// The transfer of these parts of the sound, along a plane's axes and its normal.
    pub fn new(aperture: &Aperture, parts: u8, axes: [DVec3; 3], points: &[DVec3]) -> Self {
        let directions: Vec<_> = Part::of(parts).filter_map(|part| direction(part, axes)).collect();
        let elements = aperture.without_bodies();
        let transfer = match directions[..] {
            [] => elements.transfer(points),
            _ => elements.transfer_with_slopes(points, &directions),
        };
        let scattered = (!aperture.bodies.is_empty()).then(|| Scattered {
            aperture: aperture.clone(),
            points: points.to_vec(),
            directions,
            total: OnceLock::new(),
        });
        Self { parts, transfer, scattered }
    }

    /// The mean of a quantity's formula at every point over the drives with these excitations.
    pub fn means(
        &self,
        excitations: &[Vec<Complex64>],
        (quantity, constants): (Quantity, &Constants<f64>),
    ) -> Vec<f64> {
        let (declaration, mut means) = (quantity.declaration(), Vec::new());
        for excitation in excitations {
            let sounds = self.sounds(excitation);
            means.resize(sounds.len(), Mean::default());
            for (mean, sound) in means.iter_mut().zip(sounds) {
                mean.add(declaration, sound, constants, excitations.len());
            }
        }
        means.iter().map(|mean| mean.of(declaration)).collect()
    }

    /// The same over all arrays whose elements differ by a spread, of quantities with scatter.
    pub fn means_of_arrays(
        &self,
        excitations: &[Vec<Complex64>],
        spread: Spread,
        (quantity, constants): (Quantity, &Constants<f64>),
    ) -> Vec<f64> {
        let nominal = self.means(excitations, (quantity, constants));
        if spread.is_none() || !quantity.declaration().has_scatter() {
            return nominal;
        }
        let moments = Moments::new(spread);
        let share = moments.variance / excitations.len() as f64;
        let square = |n: usize| excitations.iter().map(|u| u[n].norm_sqr()).sum::<f64>();
        let weights: Vec<_> = (0..self.transfer.elements).map(|n| share * square(n)).collect();
        let scatter = self.scatter(&weights, (quantity, constants));
        nominal.iter().zip(scatter).map(|(nominal, term)| moments.mean.powi(2) * nominal + term).collect()
    }

    /// The sum over the elements of a quantity's formula of each alone, times its weight, at every point.
    pub fn scatter(&self, weights: &[f64], (quantity, constants): (Quantity, &Constants<f64>)) -> Vec<f64> {
        let slopes: Vec<_> = Part::of(self.parts).filter(|part| *part != Part::Pressure).collect();
        let exact = quantity.declaration().exact;
        let at = |point: usize| {
            let first = point * (1 + slopes.len());
            let own = |(n, weight): (usize, &f64)| {
                let mut sound = Sound { p: self.transfer.at(first, n), ..Sound::default() };
                for (row, &part) in (first + 1..).zip(&slopes) {
                    *sound.part_mut(part) = self.transfer.at(row, n);
                }
                weight * exact(sound, constants)
            };
            weights.iter().enumerate().map(own).sum()
        };
        (0..self.transfer.points / (1 + slopes.len())).map(at).collect()
    }

    /// The transfer of the pressure from every element to each point.
    pub fn pressure_rows(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = Complex64> + Clone> {
        let slopes = Part::of(self.parts).filter(|part| *part != Part::Pressure).count();
        self.transfer.rows().step_by(1 + slopes)
    }

    /// The transfer with what bodies scatter, if that costs a drive less; within a body nothing is a number, but rows are 0.
    fn total(&self) -> Option<&Transfer> {
        let Scattered { aperture, points, directions, total } = self.scattered.as_ref()?;
        let is_known =
            aperture.bodies.has_columns() && !points.iter().any(|at| aperture.bodies.contains(*at));
        if !is_known {
            return None;
        }
        if total.get().is_none() {
            // Others may do the same meanwhile: nobody waits in the middle of parallel work.
            let _ = total.set(match directions[..] {
                [] => aperture.transfer(points),
                _ => aperture.transfer_with_slopes(points, directions),
            });
        }
        total.get()
    }

    /// The sound of one drive at every point.
    pub fn sounds(&self, excitation: &[Complex64]) -> Vec<Sound<f64>> {
        let slopes: Vec<_> = Part::of(self.parts).filter(|part| *part != Part::Pressure).collect();
        let sound = |values: &[Complex64]| {
            let mut sound = Sound { p: values[0], ..Sound::default() };
            slopes.iter().zip(&values[1..]).for_each(|(&part, &slope)| *sound.part_mut(part) = slope);
            sound
        };
        let total = self.total();
        let mut values = total.unwrap_or(&self.transfer).pressure(excitation);
        if let Some(Scattered { aperture, points, directions, .. }) = &self.scattered
            && total.is_none()
            && let Some(scattered) = aperture.scattered((points, directions), excitation)
        {
            values.iter_mut().zip(scattered).for_each(|(sum, value)| *sum += value);
        }
        values.chunks_exact(1 + slopes.len()).map(sound).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, dvec3};

    use super::*;
    use crate::field::reference;
    use crate::scene::{Array, Plane, Scene};

    #[test]
    fn slopes_of_pressures_in_f32_are_those_of_the_reference() {
        /// m
        const HALF: f64 = 1e-7;
        let array = Array { columns: 4, rows: 4, ..Array::default() };
        let aperture = Aperture::new(&Scene { array, ..Scene::default() });
        let phase = |n: usize| (n as f64 * 0.754_877_666).fract();
        let drive = Drive { amplitudes: vec![1.0; 16], phases: (0..16).map(phase).collect() };
        let centre = dvec3(0.004, -0.003, 0.05);
        let plane = Plane { centre, size: DVec2::splat(0.03), ..Plane::default() };
        let samples = Samples::on_plane(&plane, 7, 5).unwrap();
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for (part, axis) in [Part::AlongX, Part::AlongY, Part::Normal].into_iter().zip(axes) {
            let [before, behind] =
                [HALF, -HALF].map(|by| reference::pressure(&aperture, &drive, &shifted(&samples, axis * by)));
            let expected: Vec<_> = before.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * HALF)).collect();
            let peak = expected.iter().map(|slope| slope.norm()).fold(0.0, f64::max);
            let slopes = part_on_cpu(&aperture, &drive, &samples, part, axes, false);
            for (slope, expected) in slopes.iter().zip(&expected) {
                let off = Complex64::new(slope.re.into(), slope.im.into()) - expected;
                assert!(off.norm() < 2e-4 * peak, "{part:?}: {slope} is not {expected}");
            }
        }
    }
}
