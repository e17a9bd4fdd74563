//! The -6 dB widths and area of a focus, in f64 on the continuous field.
//!
//! -6 dB is half the pressure: the full width at half maximum of |p|. The maximum is found by ascent from the focus,
//! in the plane through the focus parallel to the array for `lateral_x`, `lateral_y` and `area`, and on the line
//! along z through that maximum for `axial`. A width is the distance between the two nearest points on either side of
//! the maximum where |p| is half of it; the area is enclosed by such points on all rays from the maximum.
//!
//! The maximum is the focus' own if it is nearer, along x and along y, than half of the array's resolution, λ/(2 NA).
//! If the beam of a narrow array has none there, the maxima on the lines along x, y and z through the focus take its
//! place. A narrow array has a small NA along one axis, so each has its own, from the spread of the directions in
//! which sound arrives: along a line of elements their sines spread evenly between ±NA, with the standard deviation
//! NA/√3.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::acoustics::{Aperture, Clearance};
use crate::drive::Drive;

/// Range of the search for half pressure from the maximum: in wavelengths, or in distances from the array if that is
/// more. Far from the array |p| falls as their inverse.
const REACH: f64 = 60.0;
const REACH_AWAY: f64 = 3.0;
/// Steps in a wavelength while the half is looked for: lobes are half a wavelength wide or more.
const PER_WAVELENGTH: f64 = 12.0;
/// Points evaluated together.
const RUN: usize = 8;
/// Rays that measure an area; the mean of a smooth closed curve converges faster than any power of their number.
const RAYS: usize = 32;
/// Accuracy of positions in wavelengths.
const PLACE: f64 = 1e-7;

/// The -6 dB extent of one focus; `None` if |p| does not fall to half where sound is heard, a wavelength or more above
/// the boards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Widths {
    /// m, along x in the plane through the focus parallel to the array.
    pub lateral_x: Option<f64>,
    /// m, along y in the same plane.
    pub lateral_y: Option<f64>,
    /// m, along z.
    pub axial: Option<f64>,
    /// m², in the plane through the focus parallel to the array.
    pub area: Option<f64>,
}

/// The widths of the focus at `focus` (m) of a drive, or of several in turn (root mean square). All are `None` if
/// ascent from the focus leads away from it by more than half of the array's resolution there: it has no separate
/// lobe.
///
/// # Panics
/// No drive.
pub fn widths(aperture: &Aperture, drives: &[Drive], focus: DVec3) -> Widths {
    let field = Field::new(aperture, drives, focus);
    let is_own = |place: DVec3| field.is_own(focus, place);
    let across = [DVec3::X, DVec3::Y];
    let top = field.climb(focus, &across, is_own);
    // The beam of a narrow array may be louder farther along its ridge; its lobe is then that of lines through the focus.
    let [x, y] = match top {
        Some(top) => [Some(top); 2],
        None => across.map(|axis| field.climb(focus, &[axis], is_own)),
    };
    let (Some(x), Some(y)) = (x, y) else { return Widths::default() };
    let along_z = |place: DVec3| (place.z - focus.z).abs() <= field.reach && field.is_clear(place);
    let axial_top = field.climb(top.map_or(focus, |top| top.place), &[DVec3::Z], along_z);
    Widths {
        lateral_x: field.width(x, DVec3::X),
        lateral_y: field.width(y, DVec3::Y),
        axial: axial_top.and_then(|top| field.width(top, DVec3::Z)),
        area: top.and_then(|top| field.area(top)),
    }
}

/// The ends (m) of the -6 dB widths of the focus at `focus` along the axes of a plane, each through the maximum on the plane.
/// Empty where [`widths`] has none.
///
/// # Panics
/// No drive.
pub fn spans(aperture: &Aperture, drives: &[Drive], focus: DVec3, axes: [DVec3; 2]) -> Vec<[DVec3; 2]> {
    let field = Field::new(aperture, drives, focus);
    // Along the beam the maximum is farther from the focus than across it.
    let is_near = |place: DVec3| field.is_own(focus, place) && field.is_clear(place);
    let Some(top) = field.climb(focus, &axes, is_near) else { return Vec::new() };
    axes.into_iter().filter_map(|axis| field.span(top, axis)).collect()
}

/// The pressure of drives around a focus.
struct Field<'a> {
    aperture: &'a Aperture,
    clearance: Clearance<'a>,
    played: Vec<Complex64>,
    wavelength: f64,
    /// m
    reach: f64,
    /// m, along x and y: half of the resolution at the focus.
    resolved: DVec2,
}

/// A local maximum of |p| (Pa).
#[derive(Clone, Copy)]
struct Top {
    place: DVec3,
    pressure: f64,
}

impl<'a> Field<'a> {
    fn new(aperture: &'a Aperture, drives: &[Drive], focus: DVec3) -> Self {
        /// Smallest spread of directions, of a single element.
        const LEAST: f64 = 1e-6;
        let played = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
        let wavelength = aperture.wavelength();
        let from = |&n: &usize| focus - aperture.positions[n];
        let heard: Vec<_> = aperture.transfer(&[focus]).row(0).map(Complex64::norm).collect();
        let mean = |value: &dyn Fn(&usize) -> DVec2| {
            let sum: DVec2 = aperture.driven.iter().zip(&heard).map(|(n, heard)| *heard * value(n)).sum();
            sum / heard.iter().sum::<f64>().max(f64::MIN_POSITIVE)
        };
        let sines = |n: &usize| from(n).normalize_or_zero().truncate();
        let middle = mean(&sines);
        let spread = mean(&|n| (sines(n) - middle).powf(2.0)).powf(0.5).max(DVec2::splat(LEAST));
        let away = aperture.driven.iter().map(|n| from(n).length()).fold(0.0, f64::max);
        Self {
            aperture,
            clearance: Clearance::new(aperture),
            played,
            wavelength,
            reach: (REACH * wavelength).max(REACH_AWAY * away),
            resolved: wavelength / (4.0 * 3f64.sqrt()) / spread,
        }
    }

    /// Whether a maximum near a focus is its own.
    fn is_own(&self, focus: DVec3, place: DVec3) -> bool {
        ((place - focus).truncate() / self.resolved).length() <= 1.0
    }

    /// Whether sound is heard there, and not of the next elements alone.
    fn is_clear(&self, place: DVec3) -> bool {
        self.clearance.at(place) > self.wavelength
    }

    /// |p| (Pa, peak).
    fn pressures(&self, points: &[DVec3]) -> Vec<f64> {
        self.aperture.pressures(points, &self.played).into_iter().map(Complex64::norm).collect()
    }

    /// Ascends in steps along the axes, halved when no neighbour is louder.
    fn climb(&self, from: DVec3, axes: &[DVec3], is_allowed: impl Fn(DVec3) -> bool) -> Option<Top> {
        let mut top = Top { place: from, pressure: self.pressures(&[from])[0] };
        let mut step = self.wavelength / PER_WAVELENGTH;
        while step > PLACE * self.wavelength {
            let around: Vec<_> =
                axes.iter().flat_map(|&axis| [top.place - axis * step, top.place + axis * step]).collect();
            let pressures = self.pressures(&around);
            // Between steps the summit is that of a parabola along every axis.
            let mut summit = top.place;
            for (&axis, pair) in axes.iter().zip(pressures.chunks(2)) {
                let bend = pair[0] - 2.0 * top.pressure + pair[1];
                if bend < 0.0 {
                    summit += axis * (step * ((pair[0] - pair[1]) / (2.0 * bend)).clamp(-1.0, 1.0));
                }
            }
            let candidates =
                around.into_iter().zip(pressures).chain([(summit, self.pressures(&[summit])[0])]);
            let loudest =
                candidates.fold(
                    top,
                    |best, (place, pressure)| {
                        if pressure > best.pressure { Top { place, pressure } } else { best }
                    },
                );
            if loudest.place == top.place {
                step /= 4.0;
                continue;
            }
            top = loudest;
            if !is_allowed(top.place) {
                return None;
            }
        }
        (top.pressure > 0.0 && is_allowed(top.place)).then_some(top)
    }

    /// The width (m) of a maximum along a direction and against it.
    fn width(&self, top: Top, direction: DVec3) -> Option<f64> {
        let [from, to] = self.span(top, direction)?;
        Some(from.distance(to))
    }

    /// Its ends (m).
    fn span(&self, top: Top, direction: DVec3) -> Option<[DVec3; 2]> {
        let end = |direction: DVec3| self.half(top, direction).map(|far| top.place + direction * far);
        Some([end(-direction)?, end(direction)?])
    }

    /// The area (m²) around a maximum parallel to the array.
    fn area(&self, top: Top) -> Option<f64> {
        let square = |ray: usize| {
            let (sine, cosine) = (TAU * ray as f64 / RAYS as f64).sin_cos();
            self.half(top, DVec3::new(cosine, sine, 0.0)).map(|radius| radius * radius)
        };
        let sum = (0..RAYS).map(square).sum::<Option<f64>>()?;
        Some(TAU / RAYS as f64 * sum / 2.0)
    }

    /// Distance (m) along a ray to the first point with half of the maximum |p|.
    fn half(&self, top: Top, direction: DVec3) -> Option<f64> {
        let step = self.wavelength / PER_WAVELENGTH;
        let steps = (self.reach / step) as usize;
        let at = |distance: f64| top.place + direction * distance;
        let (level, mut before) = (top.pressure / 2.0, top.pressure);
        for first in (1..=steps).step_by(RUN) {
            let distances: Vec<_> = (first..first + RUN).map(|index| index as f64 * step).collect();
            let points: Vec<_> = distances.iter().map(|&distance| at(distance)).collect();
            for (distance, pressure) in distances.into_iter().zip(self.pressures(&points)) {
                // A lobe that ends at a body has no width.
                if !self.is_clear(at(distance)) || pressure.is_nan() {
                    return None;
                }
                if pressure <= level {
                    let over = |distance: f64| self.pressures(&[at(distance)])[0] - level;
                    let ends = [(distance - step, before - level), (distance, pressure - level)];
                    return Some(root(over, ends, PLACE * self.wavelength));
                }
                before = pressure;
            }
        }
        None
    }
}

/// A root of a function between two points with known values, to within `error`; regula falsi with the Illinois rule.
pub(super) fn root(value: impl Fn(f64) -> f64, [mut a, mut b]: [(f64, f64); 2], error: f64) -> f64 {
    /// More than bisection alone would need.
    const MOST: usize = 60;
    let mut last = a.0;
    for _ in 0..MOST {
        let place = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
        let found = (place, value(place));
        if found.1 == 0.0 || (place - last).abs() <= error {
            return place;
        }
        last = place;
        if (found.1 > 0.0) == (b.1 > 0.0) {
            a.1 /= 2.0;
        } else {
            a = b;
        }
        b = found;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::solver;

    fn solved(text: &str) -> (Aperture, Vec<Drive>, Vec<DVec3>) {
        let scene: Scene =
            crate::scene::file::parse(&format!("format = 1\n{text}"), std::path::Path::new("test")).unwrap();
        let solution = solver::solve(&scene).unwrap();
        let foci = solution.foci.iter().map(|focus| focus.position).collect();
        (Aperture::new(&scene), solution.drives(), foci)
    }

    #[test]
    fn the_root_of_a_curve_is_found() {
        for exponent in [0.3, 1.0, 3.0] {
            let curve = |x: f64| 0.4 - x.powf(exponent);
            let place = root(curve, [(0.0, curve(0.0)), (2.0, curve(2.0))], 1e-12);
            assert!((place - 0.4f64.powf(1.0 / exponent)).abs() < 1e-9, "{exponent}: {place}");
        }
    }

    #[test]
    fn widths_are_those_of_the_formula() {
        const MEDIUM: &str = "[medium]\nsound_speed = 343.0\ndensity = 1.2\nabsorption = 1.0\n";
        // From numpy in f64: the sum over elements on lines, halved until the place is found; areas by counting squares.
        let cases = [
            ("", "[0.0, 0.0, 0.1]", [0.0087048519168, 0.0087048519168, 0.0372957186602, 6.0559e-5]),
            ("", "[0.02, -0.01, 0.15]", [0.0113316297290, 0.0112281281135, 0.0586248466, 1.02481e-4]),
            ("rows = 6\n", "[0.0, 0.01, 0.12]", [0.0093959217554, 0.0218423871508, 0.0606408850, 1.65646e-4]),
            ("", "[0.0, 0.0, 2.0]", [0.1234253504, 0.1234253504, 1.4909069893453, 0.0123927]),
        ];
        for (array, at, [x, y, z, area]) in cases {
            let (aperture, drives, foci) =
                solved(&format!("{MEDIUM}[array]\n{array}[[target]]\nkind = \"point\"\nat = {at}\n"));
            let found = widths(&aperture, &drives, foci[0]);
            let agrees = |found: Option<f64>, expected: f64, error: f64| {
                found.map_or(expected.is_nan(), |found| (found / expected - 1.0).abs() < error)
            };
            assert!(agrees(found.lateral_x, x, 1e-6) && agrees(found.lateral_y, y, 1e-6), "{at}: {found:?}");
            assert!(agrees(found.axial, z, 1e-6) && agrees(found.area, area, 3e-3), "{at}: {found:?}");
        }
    }

    #[test]
    fn a_point_without_a_lobe_of_its_own_has_no_width() {
        let (aperture, drives, _) = solved("[[target]]\nkind = \"point\"\nat = [0.0, 0.0, 0.1]\n");
        assert_eq!(widths(&aperture, &drives, DVec3::new(0.006, 0.0, 0.1)), Widths::default());
    }

    #[test]
    fn narrow_arrays_and_foci_at_any_height_have_widths() {
        let narrow = "[array]\ncolumns = 2\n[[target]]\nkind = \"point\"\nat = [-0.015, 0.066, 0.05]\n";
        let below = "[[board]]\nat = [0, 0, -0.2]\n[[target]]\nkind = \"point\"\nat = [0, 0, -0.1]\n";
        for text in [narrow, below] {
            let (aperture, drives, foci) = solved(text);
            let Widths { lateral_x, lateral_y, axial, area } = widths(&aperture, &drives, foci[0]);
            let all = [lateral_x, lateral_y, axial, area];
            assert!(all.iter().all(|width| width.is_some_and(|width| width > 0.0)), "{text}: {all:?}");
        }
    }
}
