//! The ghost of a drive: the loudest place on a plane where nobody asked for sound.
//!
//! It is the largest local maximum of |p| outside the main lobes of the foci. What a rectangle sends to a point is nearly the
//! product of two integrals, one along each of its sides, ∫ exp(i k δ(x)) dx, where δ is how much longer the path from x to the
//! point is than the path from x to the focus, at which all arrive in phase. A lobe ends where one of the two has its
//! first minimum, and for both ways to leave a focus that is where δ differs by about a wavelength along that side:
//!
//! - across the beam δ is linear in x, the integral is sinc, and its first null lies where δ differs by λ from edge to edge;
//! - along the beam δ is quadratic, the integral is Fresnel's, √(C² + S²)(v)/v, and its first minimum lies at v = 1.91, where
//!   δ differs by λ v²/4 = 0.92 λ from an edge to the middle. (The first null of a disk, (sin πu)/πu, has λ.)
//!
//! Of a rectangle that is long and narrow the long side decides along the beam, and its minimum is no null: one of 6 x 16 has
//! half the focus' pressure there. Where paths cannot differ so much, as beyond a focus far away, the beam has no end.
//!
//! A point is in the lobe where δ differs by less than [`REACH`] wavelengths along either middle line of the box around the
//! driven elements. For 16 x 16, 6 x 16, 4 x 32 and 1 x 16 and foci from 5 to 40 cm, steered by up to 50°, what is a tenth louder
//! than the first minimum before it, and than a tenth of the focus, lies at 1.19 or more along and across the beam. That
//! minimum lies at 0.86 to 1.25, and later in 4 of 379 cases. (Off both axes, in the corners of a square's lobe, there are maxima of
//! 0.1 of the focus at 1.0 to 1.1.)

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::{FieldError, Quantity, Request, Samples, Stages};
use crate::scene::{Plane, Scene};

/// Samples in a wavelength: a maximum of |p| is half a wavelength wide or more.
const PER_WAVELENGTH: f64 = 8.0;
/// Samples of a plane that are searched at most.
const MOST_SAMPLES: f64 = 4e6;
/// Of the peak: what the map may be off while maxima are found; their pressures are then evaluated in f64.
const TOLERANCE: f64 = 1e-3;
/// Of a wavelength: by how much paths differ at the end of a main lobe.
const REACH: f64 = 1.15;
/// Parts into which half a side is cut, at whose ends paths are compared.
const PARTS: i32 = 8;
/// Parabolas that are laid through a maximum, each over half the distance of the last.
const PARABOLAS: i32 = 4;

/// The loudest place beside the foci.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ghost {
    /// m
    pub position: DVec3,
    /// |P|, Pa
    pub pressure: f64,
    /// Of the mean |P| at the foci.
    pub part: f64,
}

/// Why there is no ghost to name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoGhost {
    #[error("the plane meets no focus")]
    NoFocus,
    #[error("the plane is too large to be searched in steps of an eighth of a wavelength")]
    TooLarge,
    #[error("nothing on the plane is louder than its surroundings but the foci")]
    NoMaximum,
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// The ghost on a plane of a drive, or of several that take turns.
///
/// # Errors
/// [`NoGhost`]: it may have none, or the field may fail.
pub fn loudest(
    stages: &mut Stages,
    aperture: &Aperture,
    plane: &Plane,
    drives: &[Drive],
    foci: &[DVec3],
) -> Result<Ghost, NoGhost> {
    let lobes: Vec<_> = foci.iter().map(|&focus| Lobe::of(aperture, focus)).collect();
    let is_rectangle = plane.size.is_finite() && plane.size.min_element() > 0.0;
    let (x_axis, y_axis) = plane.axes().filter(|_| is_rectangle).ok_or(FieldError::NoPlane)?;
    if !lobes.iter().any(|lobe| lobe.contains(nearest(plane, [x_axis, y_axis], lobe.focus))) {
        return Err(NoGhost::NoFocus);
    }
    let step = aperture.wavelength() / PER_WAVELENGTH;
    let [width, height] = (plane.size / step).to_array().map(|samples| samples.ceil().max(3.0));
    if width * height > MOST_SAMPLES {
        return Err(NoGhost::TooLarge);
    }
    let (width, height) = (width as usize, height as usize);
    let plane = Plane { tolerance: TOLERANCE, ..plane.clone() };
    let samples = Samples::on_plane(&plane, width, height).ok_or(FieldError::NoPlane)?;
    let request = Request {
        aperture: aperture.clone(),
        plane: plane.clone(),
        ..Request::new(&Scene::default(), drives.to_vec(), Quantity::Rms, (width, height))
    };
    let pressures = &stages.map(&request)?.values;
    // Nearer to the array than a wavelength it is the elements themselves that are loud.
    let is_ghost = |&index: &usize| {
        let point = samples.point(index);
        point.z > aperture.wavelength() && !lobes.iter().any(|lobe| lobe.contains(point))
    };
    let mut maxima = maxima(pressures, width);
    maxima.sort_by(|&a, &b| pressures[b].total_cmp(&pressures[a]));
    let found = maxima.into_iter().find(is_ghost).ok_or(NoGhost::NoMaximum)?;

    let played: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
    let pressure = |point: DVec3| aperture.transfer(&[point]).moduli(&played)[0];
    let position = climbed(samples.point(found), [x_axis * step, y_axis * step], pressure);
    let focal = aperture.transfer(foci).moduli(&played);
    let mean = focal.iter().sum::<f64>() / focal.len() as f64;
    let pressure = pressure(position);
    Ok(Ghost { position, pressure, part: pressure / mean.max(f64::MIN_POSITIVE) })
}

/// The point of a plane's rectangle that is nearest to another.
fn nearest(plane: &Plane, axes: [DVec3; 2], point: DVec3) -> DVec3 {
    let along = |axis: DVec3, size: f64| {
        let place: f64 = axis.dot(point - plane.centre);
        axis * place.clamp(-size / 2.0, size / 2.0)
    };
    plane.centre + along(axes[0], plane.size.x) + along(axes[1], plane.size.y)
}

/// Samples of a grid, `width` to a row, that are louder than their eight neighbours.
fn maxima(pressures: &[f32], width: usize) -> Vec<usize> {
    let is_maximum = |&at: &usize| {
        let before = [at - width - 1, at - width, at - width + 1, at - 1];
        let after = [at + 1, at + width - 1, at + width, at + width + 1];
        // Of several that are equally loud, one.
        before.iter().all(|&other| pressures[at] > pressures[other])
            && after.iter().all(|&other| pressures[at] >= pressures[other])
    };
    let rows = pressures.len() / width;
    (1..rows - 1).flat_map(|row| row * width + 1..(row + 1) * width - 1).filter(is_maximum).collect()
}

/// The maximum near a point, by parabolas along two steps that become smaller.
fn climbed(mut point: DVec3, steps: [DVec3; 2], pressure: impl Fn(DVec3) -> f64) -> DVec3 {
    for halving in 0..PARABOLAS {
        let middle = pressure(point);
        let [x, y] = steps.map(|step| {
            let step = step * 0.5f64.powi(halving);
            let (before, after) = (pressure(point - step), pressure(point + step));
            let curvature = before - 2.0 * middle + after;
            let part = if curvature < 0.0 { 0.5 * (before - after) / curvature } else { 0.0 };
            step * part.clamp(-1.0, 1.0)
        });
        if pressure(point + x + y) > middle {
            point += x + y;
        }
    }
    point
}

/// The main lobe of a focus.
struct Lobe {
    focus: DVec3,
    /// m, by which paths may differ along a side.
    reach: f64,
    /// Middle of the driven elements.
    middle: DVec3,
    /// From there to the middles of two edges.
    halves: [DVec3; 2],
}

impl Lobe {
    fn of(aperture: &Aperture, focus: DVec3) -> Self {
        let (low, high) = aperture.extent();
        let half = (high - low + aperture.pitch) / 2.0;
        Self {
            focus,
            reach: REACH * aperture.wavelength(),
            middle: ((low + high) / 2.0).extend(0.0),
            halves: [DVec3::X * half.x, DVec3::Y * half.y],
        }
    }

    fn contains(&self, point: DVec3) -> bool {
        // The paths to a point behind the array are those to one before it.
        point.z > 0.0 && self.halves.iter().all(|&half| self.spread(point, half) < self.reach)
    }

    /// By how much paths to a point differ along a side, less what they differ on the way to the focus; m.
    fn spread(&self, point: DVec3, half: DVec3) -> f64 {
        let (least, most) = (-PARTS..=PARTS)
            .map(|part| self.middle + half * (f64::from(part) / f64::from(PARTS)))
            .map(|from| from.distance(point) - from.distance(self.focus))
            .fold((f64::MAX, f64::MIN), |(least, most), path| (least.min(path), most.max(path)));
        most - least
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::field::Evaluator;
    use crate::scene::Array;

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
    /// The places (indices) of the first maximum of a line of levels, the first minimum behind it, and the maximum behind
    /// that, if it is louder than the minimum by a tenth.
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
                    let lobe = Lobe::of(&aperture, focus);
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
    fn a_narrow_array_has_a_loud_ghost_along_the_beam() {
        // Of 6 x 16 the short side cancels nothing where the long one does: the first minimum has nearly half the focus'
        // pressure, and what follows it towards the array is no part of the focus.
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
            let ghost = loudest(&mut stages, &aperture, &plane, &[drive], &[focus]).unwrap();
            assert!(ghost.part > 0.99 * next, "{columns}: {ghost:?}, not {next}");
            ghost.part
        });
        assert!((0.15..0.3).contains(&parts[0]) && (0.5..0.65).contains(&parts[1]), "{parts:?}");
    }
}
