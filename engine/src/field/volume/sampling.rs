//! The RMS pressure on a lattice of points in space, in fast f32, for pictures.

use crate::acoustics::{Aperture, Face};
use crate::drive::Drive;
use crate::field::evaluator::{Evaluator, add_scattered};
use crate::field::plan::Shared;
use crate::field::sources::{Sources, Wave};
use crate::field::transfer::{Layout, Transfer};
use crate::field::vicinity::Vicinity;
use crate::field::volume::bricks::Volume;
use crate::field::volume::{Block, Lattice};
use crate::field::{cpu, samples::Samples};
use glam::{DVec3, UVec3};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

/// Samples per wavelength, and limit of points, of a volume while dragging and at rest.
const COARSE: Fineness = Fineness { per_wavelength: 4.0, least: 1 << 17, most: 1 << 19, pairs: 3e8 };

const FINE: Fineness = Fineness { per_wavelength: 8.0, least: 1 << 18, most: 1 << 22, pairs: 1e10 };

/// Sources on a body's triangle.
const POINTS_OF_TRIANGLE: f64 = 3.0;

/// Relative error of a truncated series of reflections.
const LEFT_OUT: f64 = 1e-3;

/// Rounding error of a step.
const SLACK: f64 = 1e-9;

/// The number of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    pub per_wavelength: f64,
    pub least: usize,
    pub most: usize,
    /// Points times elements, unless that leaves fewer than the least.
    pub pairs: f64,
}

impl Fineness {
    /// While dragging, or at rest.
    pub fn of(is_dragged: bool) -> Self {
        if is_dragged { COARSE } else { FINE }
    }
}

impl Volume {
    /// The RMS pressure of drives in turn in a box.
    pub fn new(aperture: &Aperture, drives: &[Drive], block: &Block, fineness: Fineness) -> Self {
        let lattice = lattice(aperture, drives.len(), block, fineness);
        let excitations: Vec<_> = drives.iter().map(|drive| excitation(aperture, drive)).collect();
        let values = values(aperture, drives, &excitations, &lattice);
        let peak = peak(aperture, &lattice, &values);
        let volume = Self::of(lattice, values);
        Self { peak: peak.unwrap_or(volume.peak), ..volume }
    }
}

/// Points that share tables on boards in rows and columns as far as possible.
fn lattice(aperture: &Aperture, drives: usize, block: &Block, fineness: Fineness) -> Lattice {
    /// Relative cost of a pair without a table.
    const ALONE: f64 = 10.0;
    /// Factor of additional points worth a table.
    const WORTH: f64 = 2.0;
    let pairs = |face: &Face| {
        let times = if along(face, 1).is_some() { 1.0 } else { ALONE };
        times * face.layout.positions.len() as f64
    };
    let of_bodies =
        aperture.bodies.bodies().map_or(0.0, |bodies| POINTS_OF_TRIANGLE * bodies.triangles() as f64);
    let pairs = drives.max(1) as f64 * (heard(aperture).map(pairs).sum::<f64>() + of_bodies);
    let most = (fineness.pairs / pairs.max(1.0)).clamp(fineness.least as f64, fineness.most as f64);
    let volume = block.size.element_product();
    let wanted = (aperture.wavelength() / fineness.per_wavelength).max((volume / most).cbrt());
    let shared = heard(aperture).any(|face| along(face, 1).is_some()).then(|| {
        let in_pitch = (aperture.pitch / wanted - SLACK).ceil().max(1.0);
        let is_too_fine = (in_pitch * wanted / aperture.pitch).powi(2) > WORTH && in_pitch > 1.0;
        aperture.pitch / if is_too_fine { in_pitch - 1.0 } else { in_pitch }
    });
    // With a pitch below a step, no table is shared.
    let across = shared.filter(|across| WORTH * across * across >= wanted * wanted).unwrap_or(wanted);
    Lattice::covering(block, DVec3::new(across, across, wanted))
}

/// The boards and images loud enough to be visible.
fn heard(aperture: &Aperture) -> impl Iterator<Item = &Face> {
    aperture.faces.iter().take_while(|face| face.rest >= LEFT_OUT)
}

/// Steps in a pitch, if these are whole.
fn in_pitch(aperture: &Aperture, lattice: &Lattice) -> Option<isize> {
    let steps = aperture.pitch / lattice.step.x;
    ((steps - steps.round()).abs() < SLACK && steps > 0.5).then(|| steps.round() as isize)
}

/// The repetition of horizontal samples along a flat board in rows and columns, with `samples` per pitch.
fn along(face: &Face, samples: isize) -> Option<[Option<Shared>; 2]> {
    const ALIGNED: f64 = 1e-12;
    face.layout.columns?;
    let shared = |axis: DVec3| {
        let own = face.pose.local_direction(axis);
        let element_axis = own.truncate().abs().max_position();
        let sign = own[element_axis].signum() as isize;
        let is_along = (own[element_axis].abs() - 1.0).abs() < ALIGNED;
        is_along.then_some(Shared { element_axis, samples: sign * samples })
    };
    Some([Some(shared(DVec3::X)?), Some(shared(DVec3::Y)?)])
}

fn excitation(aperture: &Aperture, drive: &Drive) -> Vec<Complex64> {
    let mut excitation = vec![Complex64::ZERO; aperture.positions.len()];
    for (&n, u) in aperture.driven.iter().zip(drive.excitation(&aperture.driven)) {
        excitation[n] = u;
    }
    excitation
}

/// The points of a layer.
fn layer(lattice: &Lattice, z: usize) -> Samples {
    let Lattice { first, step, counts } = *lattice;
    let height = first.z + step.z * z as f64;
    Samples {
        columns: (0..counts.x).map(|i| DVec3::new(first.x + step.x * f64::from(i), 0.0, height)).collect(),
        rows: (0..counts.y).map(|j| DVec3::new(0.0, first.y + step.y * f64::from(j), 0.0)).collect(),
    }
}

/// The box's corners, for the range of distances.
fn corners(lattice: &Lattice) -> Samples {
    let (low, high) =
        (lattice.first, lattice.first + lattice.step * (lattice.counts - UVec3::ONE).as_dvec3());
    let xs = [low.x, high.x].map(|x| DVec3::new(x, 0.0, 0.0)).to_vec();
    let yz = [(low.y, low.z), (high.y, low.z), (low.y, high.z), (high.y, high.z)];
    Samples { columns: xs, rows: yz.map(|(y, z)| DVec3::new(0.0, y, z)).to_vec() }
}

/// Sounding elements and their tilts, in the layout of [`Sources`].
type Elements = (Vec<[f32; 4]>, Vec<[f32; 4]>);

/// The data of a face common to all layers.
struct Heard<'a> {
    face: &'a Face,
    wave: Wave,
    shared: Option<[Option<Shared>; 2]>,
    /// Sounding elements and tilts of every drive, without a shared table.
    elements: Vec<Elements>,
}

fn values<'a>(
    aperture: &'a Aperture,
    drives: &[Drive],
    excitations: &[Vec<Complex64>],
    lattice: &Lattice,
) -> Vec<f32> {
    let corners = corners(lattice);
    let in_pitch = in_pitch(aperture, lattice);
    let of_face = |face: &'a Face| {
        let wave = Wave::new(&aperture.element, &face.layout, &corners.seen_from(&face.pose))?;
        let shared = in_pitch.and_then(|samples| along(face, samples));
        let of_drive = |drive: &Drive| elements(aperture, face, &wave, drive);
        let elements = if shared.is_some() { Vec::new() } else { drives.iter().map(of_drive).collect() };
        Some(Heard { face, wave, shared, elements })
    };
    let heard: Option<Vec<_>> = heard(aperture).map(of_face).collect();
    let of_layer = lattice.counts.x as usize * lattice.counts.y as usize;
    let mut values = vec![0.0; lattice.len()];
    // Layers take what bodies answer, found once.
    drives.iter().for_each(|drive| drop(aperture.answer(&drive.excitation(&aperture.driven))));
    let fill = |(z, values): (usize, &mut [f32])| {
        let samples = layer(lattice, z);
        let mut fields = vec![vec![Complex32::ZERO; of_layer]; drives.len()];
        match &heard {
            Some(heard) => {
                heard.iter().for_each(|heard| heard.add(excitations, &samples, &mut fields));
                for (drive, field) in drives.iter().zip(&mut fields) {
                    add_scattered(aperture, drive, &samples, false, field);
                }
            }
            None => {
                // Cases beyond f32.
                for (drive, field) in drives.iter().zip(&mut fields) {
                    if let Ok(exact) = Evaluator::Reference.pressure(aperture, drive, &samples) {
                        *field = exact;
                    }
                }
            }
        }
        let factor = 0.5 / drives.len().max(1) as f32;
        for (i, value) in values.iter_mut().enumerate() {
            let square: f32 = fields.iter().map(|field| field[i].norm_sqr()).sum();
            // Nothing sounds within a body.
            *value = if square.is_nan() { 0.0 } else { (factor * square).sqrt() };
        }
    };
    values.par_chunks_mut(of_layer).enumerate().for_each(fill);
    values
}

/// The sounding elements of a face, and their tilts.
fn elements(aperture: &Aperture, face: &Face, wave: &Wave, drive: &Drive) -> Elements {
    let sounding = crate::field::sources::sounding(aperture, face, drive);
    let mut elements = wave.elements(face, &sounding, drive);
    elements.iter_mut().for_each(|[.., amplitude]| *amplitude *= face.gain as f32);
    (elements, crate::field::sources::tilts(&face.layout, sounding.iter().map(|n| n - face.first)))
}

impl Heard<'_> {
    /// Adds the face's pressure to the points of a layer.
    fn add(&self, excitations: &[Vec<Complex64>], samples: &Samples, fields: &mut [Vec<Complex32>]) {
        let Self { face, wave, shared, elements } = self;
        let own = samples.seen_from(&face.pose);
        if let Some(shared) = shared {
            let table = Transfer::new(face, wave, Layout::new(face, &own, *shared), None);
            table.superpose(face, excitations, fields);
            return;
        }
        for ((elements, tilts), field) in elements.iter().zip(fields) {
            let (elements, tilts) = (elements.clone(), tilts.clone());
            let sources = Sources { wave: wave.clone(), elements, tilts, samples: own.clone() };
            for (sum, p) in field.iter_mut().zip(cpu::pressure(&[sources], samples.len())) {
                *sum += p;
            }
        }
    }
}

/// The largest value a wavelength or more from every element; `None` if all are nearer.
fn peak(aperture: &Aperture, lattice: &Lattice, values: &[f32]) -> Option<f32> {
    let vicinity = Vicinity::new(aperture);
    let of_layer = lattice.counts.x as usize * lattice.counts.y as usize;
    let layers = values.par_chunks(of_layer).enumerate().filter_map(|(z, values)| {
        let left_out = vicinity.of(&layer(lattice, z));
        (left_out.near < values.len()).then(|| left_out.largest(values)[0])
    });
    layers.reduce_with(f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Array, Scene};
    use glam::Vec3;

    #[test]
    fn beyond_the_lattice_the_field_is_that_of_its_rim() {
        let lattice = Lattice { first: DVec3::ZERO, step: DVec3::splat(1e-3), counts: UVec3::new(5, 4, 3) };
        let volume = Volume::of(lattice, (0..60).map(|i| (i as f32 * 0.618).fract()).collect());
        for [x, y, z] in
            [[-0.7, 1.3, 0.4], [4.6, 1.3, 0.4], [1.2, 3.9, 1.5], [1.2, 2.2, 2.5], [9.0, 9.0, 9.0]]
        {
            let place = Vec3::new(x, y, z);
            let rim = place.clamp(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0));
            assert_eq!(volume.at(place), volume.at(rim), "{place}");
        }
    }

    #[test]
    fn values_between_points_are_linear_and_bricks_hold_the_largest_of_their_points() {
        let lattice =
            Lattice { first: DVec3::ZERO, step: DVec3::new(1e-3, 2e-3, 5e-4), counts: UVec3::new(20, 9, 11) };
        let at = |point: DVec3| 3.0 + 1e3 * point.x - 400.0 * point.y + 2e3 * point.z;
        let point = |i: usize| {
            let place = UVec3::new(i as u32 % 20, i as u32 / 20 % 9, i as u32 / 180);
            lattice.first + lattice.step * place.as_dvec3()
        };
        let values: Vec<_> = (0..lattice.len()).map(|i| at(point(i)) as f32).collect();
        let volume = Volume::of(lattice, values.clone());
        for place in [DVec3::new(3.3e-3, 7.1e-3, 4.9e-3), DVec3::new(18.9e-3, 0.2e-3, 0.0), point(1979)] {
            assert!((f64::from(volume.value(place)) - at(place)).abs() < 1e-4, "{place}");
        }
        let slope = volume.slope(Vec3::new(4.5, 3.5, 6.5));
        assert!(slope.distance(Vec3::new(1.0, -0.8, 1.0)) < 1e-4, "{slope}");
        assert_eq!(volume.brick_counts(), UVec3::new(3, 1, 2));
        assert_eq!(volume.bricks[0], values[8 + 8 * 180]);
        assert_eq!(volume.peak, values.iter().copied().fold(0.0, f32::max));
    }

    #[test]
    fn steps_fit_in_a_pitch_if_that_at_most_doubles_or_halves_the_points_of_a_layer() {
        let array = Array { rows: 4, columns: 4, ..Array::default() };
        let aperture = Aperture::new(&Scene { array, ..Scene::default() });
        let block = Block { centre: DVec3::Z * 0.1, size: DVec3::splat(0.03) };
        for part in [0.2, 0.3, 0.45, 0.48, 0.6, 0.7, 0.72, 0.75, 0.9, 1.0, 1.3, 1.5] {
            let wanted = part * aperture.pitch;
            let per_wavelength = aperture.wavelength() / wanted;
            let fineness = Fineness { per_wavelength, least: 1 << 30, most: 1 << 40, pairs: 1e15 };
            let lattice = lattice(&aperture, 1, &block, fineness);
            assert!((lattice.step.z / wanted - 1.0).abs() < 1e-9, "{part}: {}", lattice.step);
            let points = (wanted / lattice.step.x).powi(2);
            assert!((0.499..2.001).contains(&points), "{part}: {}", lattice.step);
            assert_eq!(in_pitch(&aperture, &lattice).is_some(), part < 1.45, "{part}: {}", lattice.step);
        }
    }
}
