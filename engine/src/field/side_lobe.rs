//! The peak side lobe of a drive: the loudest point on a plane outside the main lobes of the foci.
//!
//! It is the largest local maximum of |p| outside the main lobes of the foci, on the plane including its edge: a lobe
//! cut by the edge counts with its largest value there. The field of a rectangle at a point is nearly the product of
//! two integrals, one along each of its sides, ∫ exp(i k δ(x)) dx, where δ is the length of the path from x to the
//! point less that of the path from x to the focus, where all arrive in phase. A lobe ends at the first minimum of
//! one of the two, where in both directions δ varies by about a wavelength along that side:
//!
//! - across the beam δ is linear in x, the integral is sinc, and its first null lies where δ differs by λ from edge to edge;
//! - along the beam δ is quadratic, the integral is Fresnel's, √(C² + S²)(v)/v, and its first minimum lies at v = 1.91, where
//!   δ differs by λ v²/4 = 0.92 λ from an edge to the middle. (The first null of a disk, (sin πu)/πu, has λ.)
//!
//! For a long and narrow rectangle the long side decides along the beam, and its minimum is not a null: for 6 x 16 it
//! is half the focal pressure. Where paths cannot differ by this much, as beyond a distant focus, the beam has no
//! end.
//!
//! A point is in the lobe where δ differs by less than [`REACH`] wavelengths along either middle line of the box
//! around the driven elements. For 16 x 16, 6 x 16, 4 x 32 and 1 x 16 and foci from 5 to 40 cm, steered by up to 50°,
//! all points a tenth louder than the preceding minimum, and louder than a tenth of the focus, lie at 1.19 or more
//! along and across the beam. That minimum lies at 0.86 to 1.25, and later in 4 of 379 cases. (Off both axes, in the
//! corners of a square's lobe, there are maxima of 0.1 of the focus at 1.0 to 1.1.)

use std::f64::consts::SQRT_2;

use glam::{DVec2, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::{Aperture, Face, Pose};
use crate::drive::Drive;
use crate::field::summit::Lattice;
use crate::field::{FieldError, Quantity, Request, Stages};
use crate::scene::{Plane, Scene};

/// Samples in a wavelength at least: a maximum of |p| is half a wavelength wide or more.
const PER_WAVELENGTH: f64 = 8.0;
/// Limit of searched samples of a plane.
const MOST_SAMPLES: f64 = 4e6;
/// Tolerance of the map during the search of maxima, relative to the peak; their pressures are then evaluated in f64.
const TOLERANCE: f64 = 1e-3;
/// Path difference at the end of a main lobe, in wavelengths.
const REACH: f64 = 1.15;
/// Points evaluated together.
const RUN: usize = 16;
/// Divisions of half a side, at whose ends paths are compared.
const PARTS: i32 = 8;

/// The largest maximum outside the main lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// The peak side lobe of a drive on a plane, or of several drives in turn.
///
/// # Errors
/// [`NoSideLobe`]: no side lobe, or a failure of the field.
pub fn loudest(
    stages: &mut Stages,
    aperture: &Aperture,
    plane: &Plane,
    drives: &[Drive],
    foci: &[DVec3],
) -> Result<SideLobe, NoSideLobe> {
    let boards = sides(aperture);
    let walls = aperture.walls();
    let lobes: Vec<_> = foci.iter().map(|&focus| Lobe { focus, boards: &boards }).collect();
    let is_rectangle = plane.size.is_finite() && plane.size.min_element() > 0.0;
    let (x_axis, y_axis) = plane.axes().filter(|_| is_rectangle).ok_or(FieldError::NoPlane)?;
    if !lobes.iter().any(|lobe| lobe.contains(nearest(plane, [x_axis, y_axis], lobe.focus))) {
        return Err(NoSideLobe::NoFocus);
    }
    let played: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
    let focal = aperture.transfer(foci).moduli(&played);
    let mean = focal.iter().sum::<f64>() / focal.len() as f64;
    if mean == 0.0 {
        return Err(NoSideLobe::Silent);
    }
    let at = |place: DVec2| plane.centre + x_axis * place.x + y_axis * place.y;
    // Within a wavelength of a board the elements themselves dominate.
    let is_clear = |point: DVec3| {
        let heights = || walls.iter().map(|(at, normal)| normal.dot(point - at));
        heights().all(|height| height.abs() > aperture.wavelength()) && heights().any(|height| height > 0.0)
    };
    let counts = |place: DVec2| {
        let point = at(place);
        is_clear(point) && !lobes.iter().any(|lobe| lobe.contains(point))
    };
    let pressures = |places: &[DVec2]| {
        let points: Vec<_> = places.iter().map(|&place| at(place)).collect();
        let of_run = |points| aperture.pressures(points, &played).into_iter().map(Complex64::norm);
        points.par_chunks(RUN).flat_map_iter(of_run).collect()
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

/// The point of a plane's rectangle nearest to another point.
fn nearest(plane: &Plane, axes: [DVec3; 2], point: DVec3) -> DVec3 {
    let along = |axis: DVec3, size: f64| {
        let place: f64 = axis.dot(point - plane.centre);
        axis * place.clamp(-size / 2.0, size / 2.0)
    };
    plane.centre + along(axes[0], plane.size.x) + along(axes[1], plane.size.y)
}

/// A board with the sides of the box around its driven elements.
struct Sides {
    pose: Pose,
    /// Largest path difference along a side, m.
    reach: f64,
    /// Middle of the driven elements, in the board's coordinates.
    middle: DVec3,
    /// From there to the middles of two edges.
    halves: [DVec3; 2],
}

fn sides(aperture: &Aperture) -> Vec<Sides> {
    let of_board = |board: &Face| {
        let (low, high) = aperture.extent(board)?;
        let half = (high - low + aperture.pitch) / 2.0;
        let middle = (low + high) / 2.0;
        Some(Sides {
            pose: board.pose,
            reach: REACH * aperture.wavelength(),
            middle,
            halves: [DVec3::X * half.x, DVec3::Y * half.y],
        })
    };
    aperture.boards().filter_map(of_board).collect()
}

impl Sides {
    /// Whether a point is in the main lobe of a focus.
    fn hold(&self, point: DVec3, focus: DVec3) -> bool {
        let [point, focus] = [point, focus].map(|place| self.pose.local(place));
        // The paths to a point behind the board are those to one before it.
        point.z > 0.0 && self.halves.iter().all(|&half| self.spread([point, focus], half) < self.reach)
    }

    /// Variation along a side of the path to a point less the path to the focus; m.
    fn spread(&self, [point, focus]: [DVec3; 2], half: DVec3) -> f64 {
        let (least, most) = (-PARTS..=PARTS)
            .map(|part| self.middle + half * (f64::from(part) / f64::from(PARTS)))
            .map(|from| from.distance(point) - from.distance(focus))
            .fold((f64::MAX, f64::MIN), |(least, most), path| (least.min(path), most.max(path)));
        most - least
    }
}

/// The main lobe of a focus: the intersection of those of all contributing boards.
struct Lobe<'a> {
    focus: DVec3,
    boards: &'a [Sides],
}

impl Lobe<'_> {
    fn contains(&self, point: DVec3) -> bool {
        let mut sending = self.boards.iter().filter(|board| board.pose.local(self.focus).z > 0.0).peekable();
        sending.peek().is_some() && sending.all(|board| board.hold(point, self.focus))
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::field::Evaluator;
    use crate::scene::{Array, Board};

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
            let found = loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &drives, &foci).unwrap();
            let boards = sides(&aperture);
            let is_outside =
                |point: DVec3| !foci.iter().any(|&focus| Lobe { focus, boards: &boards }.contains(point));
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
        for (boards, is_heard) in [(vec![Board::default(), beside.clone()], true), (vec![beside], false)] {
            let aperture = Aperture::new(&Scene { array: array.clone(), boards, ..Scene::default() });
            let boards = sides(&aperture);
            let lobe = Lobe { focus, boards: &boards };
            assert_eq!(lobe.contains(focus), is_heard);
        }
    }

    #[test]
    fn a_lobe_ends_between_the_focus_and_the_next_maximum_whatever_the_shape_of_the_array() {
        let mut followed = 0;
        for (columns, rows) in [(16, 16), (16, 6), (6, 16), (32, 4), (1, 16)] {
            for (x, y) in [(0.0, 0.0), (0.03, 0.0), (0.0, 0.03), (0.02, 0.03)] {
                for z in [0.08, 0.2, 0.4] {
                    let focus = DVec3::new(x, y, z);
                    let (aperture, pressure) = focused(columns, rows, focus);
                    let boards = sides(&aperture);
                    let lobe = Lobe { focus, boards: &boards };
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
                            lobe.contains(line[top]),
                            "{place}: the focus' own maximum, {top}, is outside"
                        );
                        let Some(next) = next else { continue };
                        assert!(!lobe.contains(line[next]), "{place}: another maximum, {next}, is inside");
                        let end = line.iter().position(|&point| !lobe.contains(point));
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
            let found = loudest(&mut stages, &aperture, &plane, &[drive], &[focus]).unwrap();
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
        let found =
            |foci: &[DVec3]| loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &drives, foci);
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
            let found = loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &[drive], &[focus]);
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
        let found = loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane, &[drive], &[focus]);
        let z = found.clone().unwrap().position.z;
        assert!(z.min(0.08 - z) >= aperture.wavelength(), "{found:?}");
    }

    #[test]
    fn a_point_in_the_lobe_of_one_of_two_boards_is_in_no_common_lobe() {
        let focus = DVec3::new(0.0, 0.0, 0.12);
        let beside = Board { at: DVec3::new(-0.12, 0.0, 0.12), normal: DVec3::X, x_axis: DVec3::Y };
        let scene = Scene { boards: vec![Board::default(), beside], ..Scene::default() };
        let boards = sides(&Aperture::new(&scene));
        let of = |boards| Lobe { focus, boards };
        let (common, own) = (of(&boards[..]), [of(&boards[..1]), of(&boards[1..])]);
        let mut found = [0; 3];
        for place in 0..41 * 41 {
            let (x, z) = (place % 41 - 20, place / 41 - 20);
            let point = focus + DVec3::new(f64::from(x), 0.0, f64::from(z)) * 0.002;
            let within = own.iter().filter(|lobe| lobe.contains(point)).count();
            assert_eq!(common.contains(point), within == 2, "{point}");
            found[within] += 1;
        }
        assert!(found.iter().all(|&points| points > 0), "{found:?}");
    }
}
