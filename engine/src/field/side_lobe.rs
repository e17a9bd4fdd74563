//! The side lobe of a drive: the loudest place on a plane outside the main lobes of the foci.
//!
//! It is the largest local maximum of |p| outside the main lobes of the foci, on the plane including its edge: a lobe
//! cut by the edge counts with its largest value there.
//!
//! *Main lobes.* At a focus all elements arrive in phase. At a point beside it element n is late by
//! δₙ = rₙ(point) - rₙ(focus), and the pressure falls as the δₙ spread: it is their characteristic function,
//! |Σ wₙ exp(-i k δₙ)|, wₙ the pressure of element n. Arrays of all shapes have their first minimum at nearly the same
//! standard deviation σ of δ, weighted by wₙ, and the maximum behind it as well:
//!
//! | δ | array and direction | first minimum | next maximum |
//! |---|---|---|---|
//! | two values | boards that face each other, along their axis | 0.25 λ | 0.50 λ |
//! | uniform | a line or a square, across the beam; a disk, along the beam | 0.29 λ | 0.41 λ |
//! | semicircle | a disk, across the beam | 0.30 λ | 0.41 λ |
//! | sum of two squares | a square, along the beam | 0.39 λ | 0.61 λ |
//!
//! Around 3 foci of each of 17 arrays (rectangles, 1 x 16 to 32 x 32, a hexagon, a spiral, a bowl, TinyLev and BigLev,
//! boards opposite and across, a ball, a cylinder and a ring), in 11 directions, all maxima a tenth louder than the
//! minimum before them, and than a tenth of the focus, lie at 0.358 λ or more, and the top of the focus at less than
//! 0.07 λ. A point is in the main lobe if σ is less than [`LOBE`].
//!
//! The lobes of a trap are loud around a quiet place. Its main lobe has its middle there, and reaches [`LOBE`] beyond
//! the farthest of its foci.

use std::f64::consts::SQRT_2;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::acoustics::{Aperture, Clearance};
use crate::drive::Drive;
use crate::field::quantity::Quantity;
use crate::field::stages::{FieldError, Request, Stages};
use crate::field::summit::Lattice;
use crate::scene::{Focus, Part, Plane, Scene};

/// Samples in a wavelength at least: a maximum of |p| is half a wavelength wide or more.
const PER_WAVELENGTH: f64 = 8.0;
/// Limit of searched samples of a plane.
const MOST_SAMPLES: f64 = 4e6;
/// Tolerance of the map during the search of maxima, relative to the peak; their pressures are then evaluated in f64.
const TOLERANCE: f64 = 1e-3;
/// Standard deviation of path differences at the end of a main lobe, in wavelengths.
const LOBE: f64 = 1.0 / 3.0;
/// Points evaluated together.
const RUN: usize = 16;
/// Elements that stand for all of a larger array.
const MOST_ELEMENTS: usize = 1024;

/// The largest maximum outside the main lobes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SideLobe {
    /// m
    pub position: DVec3,
    /// |P|, Pa
    pub pressure: f64,
    /// Fraction of the mean |P| at the foci.
    pub part: f64,
}

/// Reasons for having no side lobe.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoSideLobe {
    #[error("the plane meets no focus")]
    NoFocus,
    #[error("a direction has no focus, and its side lobes are those of the beam pattern")]
    Direction,
    #[error("the plane is too large to be searched in steps of an eighth of a wavelength")]
    TooLarge,
    #[error("the plane has no local maximum besides the foci")]
    NoMaximum,
    #[error("no sound reaches the plane")]
    Silent,
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// The side lobe of a drive on a plane, or of several drives in turn.
///
/// # Errors
/// [`NoSideLobe`]: no side lobe, or a failure of the field.
pub fn side_lobe(
    stages: &mut Stages,
    aperture: &Aperture,
    plane: &Plane,
    drives: &[Drive],
    foci: &[Focus],
) -> Result<SideLobe, NoSideLobe> {
    let outskirts = Outskirts::new(aperture, plane, foci)?;
    let played: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
    let pressures_at = |points: &[DVec3]| -> Vec<f64> {
        aperture.pressures(points, &played).into_iter().map(|p| audible(p.norm())).collect()
    };
    let positions: Vec<_> = foci.iter().map(|focus| focus.position).collect();
    let mean = pressures_at(&positions).iter().sum::<f64>() / positions.len() as f64;
    if mean == 0.0 {
        return Err(NoSideLobe::Silent);
    }
    let pressures = |places: &[DVec2]| {
        let points: Vec<_> = places.iter().map(|&place| outskirts.at(place)).collect();
        points.par_chunks(RUN).flat_map_iter(pressures_at).collect()
    };
    let samples = sampled(stages, aperture, plane, drives)?;
    let found = samples.summit(|at| outskirts.count(at), pressures).ok_or(NoSideLobe::NoMaximum)?;
    Ok(SideLobe { position: outskirts.at(found.place), pressure: found.value, part: found.value / mean })
}

/// The places (m) of the loudest local maxima outside the main lobes, at most `most`.
///
/// # Errors
/// The errors of [`side_lobe`].
pub(crate) fn side_lobes(
    stages: &mut Stages,
    aperture: &Aperture,
    plane: &Plane,
    drives: &[Drive],
    (foci, most): (&[Focus], usize),
) -> Result<Vec<DVec3>, NoSideLobe> {
    let outskirts = Outskirts::new(aperture, plane, foci)?;
    let samples = sampled(stages, aperture, plane, drives)?;
    let places = samples.highest(|at| outskirts.count(at), most);
    Ok(places.into_iter().map(|place| outskirts.at(place)).collect())
}

/// The part of a plane outside the main lobes and clear of the boards.
struct Outskirts<'a> {
    centre: DVec3,
    axes: [DVec3; 2],
    lobes: Lobes,
    clearance: Clearance<'a>,
    wavelength: f64,
}

impl<'a> Outskirts<'a> {
    fn new(aperture: &'a Aperture, plane: &Plane, foci: &[Focus]) -> Result<Self, NoSideLobe> {
        if foci.iter().any(Focus::is_direction) {
            return Err(NoSideLobe::Direction);
        }
        let is_rectangle = plane.size.is_finite() && plane.size.min_element() > 0.0;
        let (x_axis, y_axis) = plane.axes().filter(|_| is_rectangle).ok_or(FieldError::NoPlane)?;
        let lobes = Lobes::new(aperture, foci);
        // Drawings belong to their plane also where they are beyond its rectangle.
        let size = if foci.iter().all(Focus::is_separate) { plane.size } else { DVec2::INFINITY };
        let is_met = |middle: DVec3| lobes.contain(nearest(plane, [x_axis, y_axis], size, middle));
        if !lobes.lobes.iter().any(|lobe| is_met(lobe.middle)) {
            return Err(NoSideLobe::NoFocus);
        }
        let clearance = Clearance::new(aperture);
        let (centre, axes) = (plane.centre, [x_axis, y_axis]);
        Ok(Self { centre, axes, lobes, clearance, wavelength: aperture.wavelength() })
    }

    fn at(&self, place: DVec2) -> DVec3 {
        self.centre + self.axes[0] * place.x + self.axes[1] * place.y
    }

    fn count(&self, place: DVec2) -> bool {
        let point = self.at(place);
        // Within a wavelength of a board the elements themselves dominate.
        self.clearance.at(point) > self.wavelength && !self.lobes.contain(point)
    }
}

/// |p| (Pa, peak) on a plane, sampled from edge to edge.
fn sampled(
    stages: &mut Stages,
    aperture: &Aperture,
    plane: &Plane,
    drives: &[Drive],
) -> Result<Lattice, NoSideLobe> {
    let steps = plane.size / (aperture.wavelength() / PER_WAVELENGTH);
    let counts = steps.ceil().max(DVec2::splat(2.0)) + 1.0;
    // Not the other way round: a NaN is not few.
    let is_few = counts.element_product() <= MOST_SAMPLES;
    if !is_few {
        return Err(NoSideLobe::TooLarge);
    }
    let step = plane.size / (counts - 1.0);
    // Samples are at pixel centres, so those on the edge need a plane larger by half a step.
    let around = Plane { size: plane.size + step, tolerance: TOLERANCE, ..plane.clone() };
    let (columns, rows) = (counts.x as usize, counts.y as usize);
    let request = Request {
        aperture: aperture.clone(),
        plane: around,
        ..Request::new(&Scene::default(), drives.to_vec(), Quantity::Rms, (columns, rows))
    };
    let map = stages.map(&request)?;
    if map.peak == 0.0 {
        return Err(NoSideLobe::Silent);
    }
    let values = map.values.iter().map(|&rms| SQRT_2 * audible(rms.into())).collect();
    Ok(Lattice { values, columns, first: -plane.size / 2.0, step, half: plane.size / 2.0 })
}

/// Within bodies there is no maximum: silence there leaves those beside them.
fn audible(pressure: f64) -> f64 {
    if pressure.is_nan() { 0.0 } else { pressure }
}

/// The point of a plane's rectangle of a size nearest to another point.
fn nearest(plane: &Plane, axes: [DVec3; 2], size: DVec2, point: DVec3) -> DVec3 {
    let along = |axis: DVec3, size: f64| {
        let place: f64 = axis.dot(point - plane.centre);
        axis * place.clamp(-size / 2.0, size / 2.0)
    };
    plane.centre + along(axes[0], size.x) + along(axes[1], size.y)
}

/// The main lobes of all foci.
struct Lobes {
    /// m, of the elements, or of some that stand for all.
    elements: Vec<DVec3>,
    lobes: Vec<Lobe>,
}

/// The main lobe of a focus or of a trap.
struct Lobe {
    /// m, of the focus, or of the place between a trap's foci.
    middle: DVec3,
    /// The pressure of each element there, relative to the sum, and its distance (m).
    paths: Vec<(f64, f64)>,
    /// Standard deviation of path differences at its end, m.
    end: f64,
}

impl Lobes {
    fn new(aperture: &Aperture, foci: &[Focus]) -> Self {
        /// Rows of transfers at once.
        const ROWS: usize = 64;
        let count = aperture.driven.len();
        // Evenly spread over rows and columns.
        let scattered = |n: usize| ((n as f64 * 0.618_033_988_749_895).fract() * count as f64) as usize;
        let some: Vec<_> = match count {
            0..=MOST_ELEMENTS => (0..count).collect(),
            _ => (0..MOST_ELEMENTS).map(scattered).collect(),
        };
        let elements: Vec<_> = some.iter().map(|&n| aperture.positions[aperture.driven[n]]).collect();
        let is_one = |a: &Focus, b: &Focus| matches!(a.part, Part::Trap(_)) && a.part == b.part;
        let groups: Vec<_> = foci.chunk_by(is_one).collect();
        let mut lobes = Vec::new();
        for groups in groups.chunks(ROWS) {
            let middle =
                |foci: &&[Focus]| foci.iter().map(|focus| focus.position).sum::<DVec3>() / foci.len() as f64;
            let middles: Vec<_> = groups.iter().map(middle).collect();
            let transfer = aperture.transfer(&middles);
            for (row, (foci, &middle)) in groups.iter().zip(&middles).enumerate() {
                let heard: Vec<_> = some.iter().map(|&n| transfer.at(row, n).norm()).collect();
                let sum = heard.iter().sum::<f64>();
                let path = |(heard, at): (&f64, &DVec3)| (heard / sum, at.distance(middle));
                let paths = heard.iter().zip(&elements).map(path).collect();
                let mut lobe = Lobe { middle, paths, end: LOBE * aperture.wavelength() };
                let farthest = foci.iter().map(|focus| lobe.spread(&elements, focus.position));
                lobe.end += farthest.fold(0.0, f64::max);
                lobes.push(lobe);
            }
        }
        Self { elements, lobes }
    }

    /// Whether a point is in one of them.
    fn contain(&self, point: DVec3) -> bool {
        /// Fraction of the distance that changes a spread by as much, with equal weights.
        const SURELY: f64 = 0.8;
        let away = |lobe: &Lobe| lobe.middle.distance_squared(point);
        let nearest = self.lobes.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        // Along a stroke most of the others are as far as the one before.
        let mut last: Option<(DVec3, f64)> = None;
        nearest.into_iter().chain(&self.lobes).any(|lobe| {
            let is_far = |&(middle, spread): &(DVec3, f64)| {
                SURELY * (spread - lobe.end) > middle.distance(lobe.middle)
            };
            if last.as_ref().is_some_and(is_far) {
                return false;
            }
            let spread = lobe.spread(&self.elements, point);
            last = Some((lobe.middle, spread));
            spread < lobe.end
        })
    }
}

impl Lobe {
    /// The standard deviation of the paths to a point less those to the middle, m; infinite if no sound reaches the
    /// middle.
    fn spread(&self, elements: &[DVec3], point: DVec3) -> f64 {
        let (mut mean, mut square) = (0.0, 0.0);
        for ((weight, path), at) in self.paths.iter().zip(elements) {
            let late = at.distance(point) - path;
            mean += weight * late;
            square += weight * late * late;
        }
        let variance = square - mean * mean;
        if variance.is_nan() { f64::INFINITY } else { variance.max(0.0).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::field::evaluator::Evaluator;
    use crate::scene::Array;

    fn points(foci: &[DVec3]) -> Vec<Focus> {
        foci.iter().map(|&at| Focus::new(at, 1.0)).collect()
    }

    /// The aperture of `columns` x `rows` elements, and |p| (Pa) of its drive for a focus.
    fn focused(columns: u32, rows: u32, focus: DVec3) -> (Aperture, impl Fn(DVec3) -> f64) {
        let array = Array { columns, rows, ..Array::default() };
        let aperture = Aperture::new(&Scene { array, ..Scene::default() });
        let conjugate = aperture.transfer(&[focus]).back(&[Complex64::ONE]);
        let excitation: Vec<_> = conjugate.iter().map(|u| u / u.norm()).collect();
        let shared = aperture.clone();
        (aperture, move |point| shared.transfer(&[point]).pressure(&excitation)[0].norm())
    }

    /// Points from a focus outwards in steps of a twelfth of a wavelength, while before the array and within 30 cm.
    fn outwards(aperture: &Aperture, focus: DVec3, direction: DVec3) -> Vec<DVec3> {
        let step = direction * aperture.wavelength() / 12.0;
        (0..)
            .map(|index| focus + step * f64::from(index))
            .take_while(|point| point.z > aperture.wavelength() && point.distance(focus) < 0.3)
            .collect()
    }
    /// The indices of the first maximum of a line of levels, the first minimum behind it, and the next maximum, if it
    /// is a tenth louder than the minimum.
    fn turns(levels: &[f64]) -> (usize, Option<usize>, Option<usize>) {
        let turn = |from: usize, sign: f64| {
            (from + 1..levels.len() - 1).find(|&at| {
                sign * levels[at] > sign * levels[at - 1] && sign * levels[at] >= sign * levels[at + 1]
            })
        };
        let top = if levels[1] < levels[0] { 0 } else { turn(0, 1.0).unwrap_or(levels.len() - 1) };
        let null = turn(top, -1.0);
        let next = null.and_then(|null| turn(null, 1.0).filter(|&next| levels[next] > 1.1 * levels[null]));
        (top, null, next)
    }

    #[test]
    fn a_lobe_ends_between_the_focus_and_the_next_maximum_whatever_the_shape_of_the_array() {
        let mut followed = 0;
        for (columns, rows) in [(16, 16), (16, 6), (6, 16), (32, 4), (1, 16)] {
            for (x, y) in [(0.0, 0.0), (0.03, 0.0), (0.0, 0.03), (0.02, 0.03)] {
                for z in [0.08, 0.2, 0.4] {
                    let focus = DVec3::new(x, y, z);
                    let (aperture, pressure) = focused(columns, rows, focus);
                    let lobes = Lobes::new(&aperture, &points(&[focus]));
                    let beam = focus.normalize_or(DVec3::Z);
                    let x_side = DVec3::X.reject_from_normalized(beam).normalize_or(DVec3::X);
                    let y_side = beam.cross(x_side);
                    let oblique = (x_side * 0.2 - beam).normalize_or(beam);
                    for direction in [beam, -beam, x_side, -x_side, y_side, -y_side, oblique] {
                        let line = outwards(&aperture, focus, direction);
                        let levels: Vec<_> = line.iter().map(|&point| pressure(point)).collect();
                        let (top, null, next) = turns(&levels);
                        let place = format!("{columns} x {rows}, {focus} towards {direction}");
                        assert!(
                            lobes.contain(line[top]),
                            "{place}: the focus' own maximum, {top}, is outside"
                        );
                        let Some(next) = next else { continue };
                        assert!(!lobes.contain(line[next]), "{place}: another maximum, {next}, is inside");
                        let end = line.iter().position(|&point| !lobes.contain(point));
                        let end = end.unwrap_or(next).min(null.unwrap_or(next));
                        assert!(levels[end] < 0.7 * levels[top], "{place}: ends at {end}, {levels:?}");
                        followed += 1;
                    }
                }
            }
        }
        assert!(followed > 150, "{followed}");
    }

    /// The drive of an array or board for a focus.
    fn drive_for(aperture: &Aperture, focus: DVec3) -> Drive {
        let conjugate = aperture.transfer(&[focus]).back(&[Complex64::ONE]);
        Drive::uniform(aperture.positions.len(), &aperture.driven, &conjugate)
    }

    #[test]
    fn a_side_lobe_is_part_of_the_mean_at_all_foci_also_those_beside_the_plane() {
        let foci = [DVec3::new(0.0, 0.0, 0.06), DVec3::new(0.12, 0.0, 0.06)];
        let (aperture, _) = focused(6, 6, foci[0]);
        let drives = [drive_for(&aperture, foci[0])];
        let played = drives[0].excitation(&aperture.driven);
        let at_foci = aperture.pressures(&foci, &played);
        let plane = Plane { centre: foci[0], size: DVec2::splat(0.1), ..Plane::default() };
        let found = |foci: &[DVec3]| {
            side_lobe(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &drives, &points(foci))
        };
        assert_eq!(found(&foci[1..]), Err(NoSideLobe::NoFocus));
        let found = found(&foci).unwrap();
        let mean = (at_foci[0].norm() + at_foci[1].norm()) / 2.0;
        assert!((found.part * mean / found.pressure - 1.0).abs() < 1e-9, "{found:?}, {mean} Pa");
    }
}
