//! Slopes of the pressure by central differences along a direction, where no grid provides them.

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::acoustics::element::NEAREST;
use crate::acoustics::{Aperture, Transfer};
use crate::drive::Drive;
use crate::field::quantity::{Constants, Mean, Part, Quantity, Sound, narrow};
use crate::field::{Samples, on_cpu};
use crate::gauge::Gauge;

/// Positions (steps) and weights (per step) for pressures in f32: relative error (kh)⁴/30.
const STENCIL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
/// Steps in a wavelength: truncation, 5e-5, and rounding are alike.
const PER_WAVELENGTH: f64 = 32.0;
/// Step in wavelengths for pressures in f64: relative error (kh)²/6 = 7e-8.
const HAIR: f64 = 1e-4;
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

/// Slopes along a direction at points, from pressures in f64.
fn slopes_in_f64(aperture: &Aperture, drive: &Drive, direction: DVec3, points: &[DVec3]) -> Vec<Complex32> {
    let hair = HAIR * aperture.wavelength();
    let (excitation, walls) = (drive.excitation(&aperture.driven), aperture.walls());
    let counter = Gauge::current().count(points.len().div_ceil(RUN));
    let of_run = |points: &[DVec3]| {
        counter.add();
        let around: Vec<_> =
            points.iter().flat_map(|&point| beside(point, direction, hair, &walls)).collect();
        let pressures = aperture.transfer(&around).pressure(&excitation);
        let slope = |pair: &[Complex64; 2]| narrow((pair[0] - pair[1]) / (2.0 * hair));
        pressures.as_chunks::<2>().0.iter().map(slope).collect::<Vec<_>>()
    };
    points.par_chunks(RUN).flat_map_iter(of_run).collect()
}

/// Neighbours of a point on both sides, both in front of the board or both behind it.
fn beside(mut point: DVec3, direction: DVec3, hair: f64, walls: &[(DVec3, DVec3)]) -> [DVec3; 2] {
    for (at, normal) in walls {
        let (height, reach) = (normal.dot(point - at), hair * normal.dot(direction).abs());
        let clear =
            if height < -NEAREST { height.min(-NEAREST - 2.0 * reach) } else { height.max(NEAREST + reach) };
        if clear != height {
            point += normal * (clear - height);
        }
    }
    [point + direction * hair, point - direction * hair]
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

/// Neighbours of points whose f64 pressures give the sound there: the reference for slopes.
#[derive(Clone, Debug)]
pub struct Around {
    parts: u8,
    axes: [DVec3; 3],
    /// m, from a point to its neighbours.
    hair: f64,
    /// [`Aperture::walls`].
    walls: Vec<(DVec3, DVec3)>,
}

impl Around {
    /// For these parts of the sound, along the plane's axes and its normal.
    pub fn new(parts: u8, axes: [DVec3; 3], aperture: &Aperture) -> Self {
        Self { parts, axes, hair: HAIR * aperture.wavelength(), walls: aperture.walls() }
    }

    /// The points expected by [`Around::sounds`], the same number for each.
    pub fn points(&self, points: &[DVec3]) -> Vec<DVec3> {
        let mut around = Vec::new();
        for &point in points {
            for part in Part::of(self.parts) {
                match direction(part, self.axes) {
                    None => around.push(point),
                    Some(direction) => around.extend(beside(point, direction, self.hair, &self.walls)),
                }
            }
        }
        around
    }

    /// The mean of a quantity's formula at points over the drives with these excitations, of a transfer to [`Around::points`] of them.
    pub fn means(
        &self,
        transfer: &Transfer,
        excitations: &[Vec<Complex64>],
        (quantity, constants): (Quantity, &Constants<f64>),
    ) -> Vec<f64> {
        let (declaration, mut means) = (quantity.declaration(), Vec::new());
        for excitation in excitations {
            let sounds = self.sounds(&transfer.pressure(excitation));
            means.resize(sounds.len(), Mean::default());
            for (mean, sound) in means.iter_mut().zip(sounds) {
                mean.add(declaration, sound, constants, excitations.len());
            }
        }
        means.iter().map(|mean| mean.of(declaration)).collect()
    }

    /// The sound at the points, from the pressures (Pa, peak) around them.
    pub fn sounds(&self, pressures: &[Complex64]) -> Vec<Sound<f64>> {
        let mut pressures = pressures.iter().copied();
        let mut sounds = Vec::new();
        while pressures.len() > 0 {
            let mut next = || pressures.next().unwrap_or_default();
            let mut sound = Sound::default();
            for part in Part::of(self.parts) {
                *sound.part_mut(part) = match part {
                    Part::Pressure => next(),
                    Part::AlongX | Part::AlongY | Part::Normal => (next() - next()) / (2.0 * self.hair),
                };
            }
            sounds.push(sound);
        }
        sounds
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

    #[test]
    fn neighbours_of_a_point_are_on_its_side_of_a_wall() {
        const HAIR: f64 = 1e-6;
        let (at, normal) = (dvec3(0.01, 0.0, 0.02), dvec3(0.6, 0.0, 0.8));
        let along = dvec3(0.8, 0.0, -0.6) * 0.003 + DVec3::Y * 0.002;
        for height in [-1e-3, -1.2e-5, -1.05e-5, -5e-6, 0.0, 1e-6, 1.05e-5, 1e-3] {
            for direction in [DVec3::X, DVec3::Y, DVec3::Z, normal, -normal] {
                let point = at + along + normal * height;
                let pair = beside(point, direction, HAIR, &[(at, normal)]);
                let place = format!("{height} m, towards {direction}");
                assert!((pair[0] - pair[1]).distance(direction * 2.0 * HAIR) < 1e-12, "{place}: {pair:?}");
                let heights = pair.map(|neighbour| normal.dot(neighbour - at));
                let is_behind = height < -NEAREST;
                let is_beside = |&own: &f64| {
                    if is_behind { own < -NEAREST + 1e-12 } else { own > NEAREST - 1e-12 }
                };
                assert!(heights.iter().all(is_beside), "{place}: {heights:?}");
                // Points near the wall are moved from it, as little as possible, and others not at all.
                let moved = (pair[0] + pair[1]) / 2.0 - point;
                let missing = if is_behind { 0.0 } else { (NEAREST - height).max(0.0) };
                let most = if height.abs() < 2.0 * NEAREST { missing + 3.0 * HAIR } else { 1e-12 };
                assert!(moved.length() < most, "{place}: {moved}");
                assert!(moved.reject_from_normalized(normal).length() < 1e-12, "{place}: {moved}");
            }
        }
    }
}
