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
use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::acoustics::{Aperture, Clearance};
use crate::drive::Drive;
use crate::field::summit::Lattice;
use crate::field::{FieldError, Quantity, Request, Stages};
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
    /// Of the mean |P| at the foci.
    pub part: f64,
}

/// Why there is no side lobe to name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoSideLobe {
    #[error("the plane meets no focus")]
    NoFocus,
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
pub fn loudest(
    stages: &mut Stages,
    aperture: &Aperture,
    plane: &Plane,
    drives: &[Drive],
    foci: &[Focus],
) -> Result<SideLobe, NoSideLobe> {
    let is_rectangle = plane.size.is_finite() && plane.size.min_element() > 0.0;
    let (x_axis, y_axis) = plane.axes().filter(|_| is_rectangle).ok_or(FieldError::NoPlane)?;
    let lobes = Lobes::new(aperture, foci);
    // Drawings belong to their plane also where they are beyond its rectangle.
    let size = if foci.iter().all(Focus::is_separate) { plane.size } else { DVec2::INFINITY };
    let is_met = |middle: DVec3| lobes.contain(nearest(plane, [x_axis, y_axis], size, middle));
    if !lobes.lobes.iter().any(|lobe| is_met(lobe.middle)) {
        return Err(NoSideLobe::NoFocus);
    }
    let played: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
    let pressures_at = |points: &[DVec3]| -> Vec<f64> {
        aperture.pressures(points, &played).into_iter().map(Complex64::norm).collect()
    };
    let positions: Vec<_> = foci.iter().map(|focus| focus.position).collect();
    let mean = pressures_at(&positions).iter().sum::<f64>() / positions.len() as f64;
    if mean == 0.0 {
        return Err(NoSideLobe::Silent);
    }
    let at = |place: DVec2| plane.centre + x_axis * place.x + y_axis * place.y;
    let clearance = Clearance::new(aperture);
    let counts = |place: DVec2| {
        let point = at(place);
        // Within a wavelength of a board the elements themselves dominate.
        clearance.at(point) > aperture.wavelength() && !lobes.contain(point)
    };
    let pressures = |places: &[DVec2]| {
        let points: Vec<_> = places.iter().map(|&place| at(place)).collect();
        points.par_chunks(RUN).flat_map_iter(pressures_at).collect()
    };
    let samples = sampled(stages, aperture, plane, drives)?;
    let found = samples.summit(counts, pressures).ok_or(NoSideLobe::NoMaximum)?;
    Ok(SideLobe { position: at(found.place), pressure: found.value, part: found.value / mean })
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
    let values = map.values.iter().map(|&rms| SQRT_2 * f64::from(rms)).collect();
    Ok(Lattice { values, columns, first: -plane.size / 2.0, step, half: plane.size / 2.0 })
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
        /// Of the distance that changes a spread by as much, with equal weights.
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
    use crate::field::Evaluator;
    use crate::scene::{Array, Board};

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

    /// From a focus outwards in steps of a twelfth of a wavelength, while before the array and within 30 cm.
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
    fn the_highest_maximum_outside_all_main_lobes_is_found_beside_a_silent_board() {
        let array = Array { columns: 8, rows: 8, ..Array::default() };
        // Above the plane, which is behind it.
        let above = Board { at: DVec3::Z * 0.5, ..Board::default() };
        let boards = vec![Board::default(), above];
        let aperture = Aperture::new(&Scene { array, boards, ..Scene::default() });
        let foci = [DVec3::new(0.024, -0.01, 0.08), DVec3::new(-0.02, 0.017, 0.08)];
        let drives = foci.map(|focus| {
            let conjugate = aperture.transfer(&[focus]).back(&[Complex64::ONE]);
            let excitation: Vec<_> = conjugate.iter().map(|u| u / u.norm().max(1e-30)).collect();
            Drive::of(128, &aperture.driven, &excitation)
        });
        for x in [-0.03, -0.015, 0.006, 0.02, 0.035] {
            let plane = Plane {
                centre: DVec3::new(x, -0.004, 0.08),
                size: DVec2::new(0.11, 0.08),
                ..Plane::default()
            };
            let foci = points(&foci);
            let found = loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &drives, &foci).unwrap();
            let lobes = Lobes::new(&aperture, &foci);
            let is_outside = |point: DVec3| !lobes.contain(point);
            assert!(is_outside(found.position), "{found:?}");
            let played: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
            let pressures = |points: &[DVec3]| -> Vec<f64> {
                aperture.pressures(points, &played).into_iter().map(Complex64::norm).collect()
            };
            let own = pressures(&[found.position])[0];
            assert!((own / found.pressure - 1.0).abs() < 1e-6, "{found:?}, not {own}");
            // All maxima between the pixels of a map.
            let (width, height) = (121, 89);
            let pixels = crate::field::Samples::on_plane(&plane, width, height).unwrap();
            let points: Vec<_> = (0..pixels.len()).map(|pixel| pixels.point(pixel)).collect();
            let levels = pressures(&points);
            let is_maximum = |&at: &usize| {
                let around = [at - 1, at + 1, at - width, at + width];
                around.iter().all(|&beside| levels[beside] < levels[at])
            };
            let inside =
                (1..height - 1).flat_map(|row| (1..width - 1).map(move |column| row * width + column));
            let outside = inside.filter(is_maximum).filter(|&at| is_outside(points[at]));
            let highest = outside.map(|at| levels[at]).fold(0.0, f64::max);
            assert!(highest > 0.0 && found.pressure > 0.99 * highest, "{x}: {found:?}, not {highest}");
        }
    }

    #[test]
    fn a_board_whose_plane_has_the_focus_does_not_bound_its_lobe() {
        let focus = DVec3::Z * 0.08;
        let array = Array { columns: 4, rows: 4, ..Array::default() };
        let beside = Board { at: DVec3::new(0.1, 0.0, 0.08), ..Board::default() };
        let boards = vec![Board::default(), beside];
        let aperture = Aperture::new(&Scene { array, boards, ..Scene::default() });
        assert!(Lobes::new(&aperture, &points(&[focus])).contain(focus));
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

    #[test]
    fn a_narrow_array_has_a_loud_side_lobe_along_the_beam() {
        // For 6 x 16 the short side does not cancel where the long one does: the first minimum has nearly half the
        // focal pressure, and the maximum behind it towards the array is not part of the focus.
        let focus = DVec3::new(0.0, 0.0, 0.2);
        let scene = Scene::default();
        let plane = Plane { centre: focus, y_axis: DVec3::Z, size: glam::dvec2(0.04, 0.3), ..scene.plane };
        let parts = [16, 6].map(|columns| {
            let (aperture, pressure) = focused(columns, 16, focus);
            let line = outwards(&aperture, focus, -DVec3::Z);
            let levels: Vec<_> = line.iter().map(|&point| pressure(point)).collect();
            let next = turns(&levels).2.map_or(0.0, |next| levels[next] / levels[0]);
            let conjugate = aperture.transfer(&[focus]).back(&[Complex64::ONE]);
            let drive = Drive::uniform(aperture.positions.len(), &aperture.driven, &conjugate);
            let mut stages = Stages::new(Evaluator::Cpu);
            let found = loudest(&mut stages, &aperture, &plane, &[drive], &points(&[focus])).unwrap();
            assert!(found.part > 0.99 * next, "{columns}: {found:?}, not {next}");
            found.part
        });
        assert!((0.15..0.3).contains(&parts[0]) && (0.5..0.65).contains(&parts[1]), "{parts:?}");
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
            loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &drives, &points(foci))
        };
        assert_eq!(found(&foci[1..]), Err(NoSideLobe::NoFocus));
        let found = found(&foci).unwrap();
        let mean = (at_foci[0].norm() + at_foci[1].norm()) / 2.0;
        assert!((found.part * mean / found.pressure - 1.0).abs() < 1e-9, "{found:?}, {mean} Pa");
    }

    #[test]
    fn a_board_elsewhere_has_its_side_lobe_at_the_same_place_before_it() {
        let array = Array { columns: 6, rows: 6, ..Array::default() };
        let at = |offset: DVec3| {
            let boards = vec![Board { at: offset, ..Board::default() }];
            let aperture = Aperture::new(&Scene { array: array.clone(), boards, ..Scene::default() });
            let focus = offset + DVec3::Z * 0.06;
            let plane =
                Plane { centre: focus, y_axis: DVec3::Z, size: DVec2::splat(0.1), ..Plane::default() };
            let drive = drive_for(&aperture, focus);
            let found =
                loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &[drive], &points(&[focus]));
            let found = found.unwrap();
            (found.part, found.position - offset)
        };
        let (part, place) = at(DVec3::ZERO);
        for height in [-0.3, 0.2] {
            let (other_part, other_place) = at(DVec3::Z * height);
            assert!((other_part - part).abs() < 1e-6, "{height} m: {other_part}, not {part}");
            // On the axis' other side it is as loud.
            let beside = DVec3::new(-place.x, place.y, place.z);
            let apart = other_place.distance(place).min(other_place.distance(beside));
            assert!(apart < 1e-4, "{height} m: {other_place}, not {place}");
        }
    }

    #[test]
    fn the_sound_next_to_either_of_two_boards_is_no_side_lobe() {
        let array = Array { columns: 4, rows: 4, ..Array::default() };
        let above = Board { at: DVec3::Z * 0.08, normal: DVec3::NEG_Z, ..Board::default() };
        let boards = vec![Board::default(), above];
        let aperture = Aperture::new(&Scene { array, boards, ..Scene::default() });
        // The plane goes through a row of elements of both.
        let focus = DVec3::new(0.0, aperture.positions[5].y, 0.04);
        let plane =
            Plane { centre: focus, y_axis: DVec3::Z, size: DVec2::new(0.06, 0.08), ..Plane::default() };
        let drive = drive_for(&aperture, focus);
        let found = loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &[drive], &points(&[focus]));
        let z = found.clone().unwrap().position.z;
        assert!(z.min(0.08 - z) >= aperture.wavelength(), "{found:?}");
    }

    #[test]
    fn facing_boards_share_the_lobe_of_one_fringe() {
        let array = Array { columns: 8, rows: 8, ..Array::default() };
        let facing = Board { at: DVec3::Z * 0.12, normal: DVec3::NEG_Z, ..Board::default() };
        let focus = DVec3::new(0.004, 0.0, 0.055);
        for (boards, is_long) in [(vec![], true), (vec![Board::default(), facing], false)] {
            let aperture = Aperture::new(&Scene { array: array.clone(), boards, ..Scene::default() });
            let lobes = Lobes::new(&aperture, &points(&[focus]));
            for (waves, is_within) in [(0.0, true), (0.25, true), (0.5, is_long), (-0.5, is_long)] {
                let point = focus + DVec3::Z * (waves * aperture.wavelength());
                assert_eq!(lobes.contain(point), is_within, "{waves}: {is_long}");
            }
        }
    }

    #[test]
    fn the_lobe_of_a_trap_reaches_beyond_its_foci() {
        let aperture = Aperture::new(&Scene::default());
        let trap = DVec3::Z * 0.1;
        let beside = 0.5 * aperture.wavelength();
        let part = Part::Trap(3);
        let lobe_at = |x: f64| Focus { position: trap + DVec3::X * x, target: 1.0, part };
        let reach = |foci: &[Focus]| {
            let lobes = Lobes::new(&aperture, foci);
            (0..200).map(|i| 1e-4 * f64::from(i)).find(|&x| !lobes.contain(trap + DVec3::X * x)).unwrap()
        };
        let (alone, both) = (reach(&points(&[trap])), reach(&[lobe_at(-beside), lobe_at(beside)]));
        assert!((both - alone - beside).abs() < 6e-4, "{both}, not {alone} and {beside}");
    }
}
