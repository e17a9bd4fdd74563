//! The transfer with its slopes: closed forms of points and of far-field pistons, differences of exact pistons.
//!
//! Where sound grazes a surface, the squares of pressure and slopes cancel to a millionth of themselves. Closed forms
//! share their rounding with the pressure, so that the difference keeps its digits.

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::element::NEAREST;
use crate::acoustics::emitters::{Emitters, Waves};
use crate::acoustics::{aperture::Aperture, transfer::Transfer};

/// Positions (steps) and weights (per step) of differences: relative error (kh)⁴/30.
const STENCIL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
/// Step in wavelengths: truncation is 4e-13 and the integral's rounding 5e-11.
const HAIR: f64 = 3e-4;

impl Aperture {
    /// [`Aperture::transfer_with_slopes`] without bodies.
    pub(super) fn slopes_of_elements(&self, points: &[DVec3], directions: &[DVec3]) -> Transfer {
        let rows = 1 + directions.len();
        let mut transfer = Transfer::zeros(points.len() * rows, self.driven.len());
        let mut waves = Waves::default();
        for face in &self.faces {
            let columns = face.among(&self.driven);
            let mut emitters = Emitters::none(self.element);
            for &n in &self.driven[columns.clone()] {
                let [normal, aside] = [face.layout.normal(n - face.first), face.layout.aside(n - face.first)]
                    .map(|direction| face.pose.world_direction(direction));
                let place = face.pose.world(face.layout.positions[n - face.first]);
                emitters.push(place, [normal, aside], Complex64::I * (self.element.strength * face.gain));
            }
            emitters.pad();
            for (index, &point) in points.iter().enumerate() {
                let first = index * rows;
                if !emitters.waves(point, &mut waves) {
                    for (n, column) in columns.clone().enumerate() {
                        let (place, axes) = emitters.source(n);
                        let waves = self.differences(point - place, axes, directions);
                        for (row, wave) in waves.into_iter().enumerate() {
                            let sum = transfer.at(first + row, column) + wave * face.gain;
                            transfer.set(first + row, column, sum);
                        }
                    }
                    continue;
                }
                let axes = directions.iter().map(|direction| direction.to_array());
                let parts = [[1.0, 0.0, 0.0, 0.0]].into_iter().chain(axes.map(|[x, y, z]| [0.0, x, y, z]));
                for (row, parts) in parts.enumerate() {
                    let (re, im) = transfer.row_mut(first + row);
                    for (sums, part) in [(re, 0), (im, 1)] {
                        for (waves, factor) in waves.0.iter().zip(parts).filter(|(_, factor)| *factor != 0.0)
                        {
                            let pairs = sums[columns.clone()].iter_mut().zip(&waves[part]);
                            pairs.for_each(|(sum, wave)| *sum += factor * wave);
                        }
                    }
                }
            }
        }
        transfer
    }

    /// Pressures (Pa) of a drive at points, and their slopes along the scene's axes (Pa/m), without bodies.
    pub(crate) fn pressures_with_slopes(&self, points: &[DVec3], drive: &[Complex64]) -> [Vec<Complex64>; 4] {
        let emitters = Emitters::new(self, drive);
        let sums: Option<Vec<_>> = points.iter().map(|&point| emitters.sum(point)).collect();
        if let Some(sums) = sums {
            return std::array::from_fn(|part| sums.iter().map(|sum| sum[part]).collect());
        }
        // Longer steps than of single waves: rows share their rounding, and bodies of interest are clear of the elements.
        let step = 10.0 * HAIR * self.wavelength();
        let along = |axis: DVec3| {
            let mut slopes = vec![Complex64::ZERO; points.len()];
            for (at, weight) in STENCIL {
                let beside: Vec<_> = points.iter().map(|point| *point + axis * (at * step)).collect();
                let pressures = self.pressures_of_elements(&beside, drive);
                slopes.iter_mut().zip(pressures).for_each(|(slope, p)| *slope += p * (weight / step));
            }
            slopes
        };
        let [x, y, z] = DVec3::AXES.map(along);
        [self.pressures_of_elements(points, drive), x, y, z]
    }

    /// The wave of an exact piston and its slopes along directions.
    fn differences(
        &self,
        offset: DVec3,
        [normal, aside]: [DVec3; 2],
        directions: &[DVec3],
    ) -> Vec<Complex64> {
        let hair = HAIR * self.wavelength();
        let slope = |direction: &DVec3| -> Complex64 {
            let offset = clear(offset, normal, 2.0 * hair * normal.dot(*direction).abs());
            let wave = |at: f64| self.element.towards(offset + *direction * (at * hair), normal, aside);
            STENCIL.iter().map(|&(at, weight)| wave(at) * (weight / hair)).sum()
        };
        let wave = self.element.towards(offset, normal, aside);
        [wave].into_iter().chain(directions.iter().map(slope)).collect()
    }
}

/// An offset from an element moved along its normal, so that all neighbours within `reach` are on one side of its
/// plane.
fn clear(offset: DVec3, normal: DVec3, reach: f64) -> DVec3 {
    let height = normal.dot(offset);
    let clear =
        if height < -NEAREST { height.min(-NEAREST - 2.0 * reach) } else { height.max(NEAREST + reach) };
    if clear == height { offset } else { offset + normal * (clear - height) }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;
    use strum::VariantArray;

    use super::*;
    use crate::scene::{Array, Board, ElementModel, Reflector, Scene};

    #[test]
    fn slopes_of_all_models_are_those_of_emitters() {
        let above = Board { at: DVec3::Z * 0.2, normal: dvec3(0.1, 0.0, -1.0), ..Board::default() };
        let mirror = Reflector { point: DVec3::X * 0.15, normal: DVec3::NEG_X, coefficient: 0.6 };
        let directions = [DVec3::X, dvec3(0.0, 0.6, 0.8)];
        let points = [dvec3(0.01, 0.02, 0.06), dvec3(-0.03, 0.0, 0.1), dvec3(0.1, -0.04, 0.012)];
        for &element in ElementModel::VARIANTS {
            let mut array = Array { rows: 2, columns: 3, element, ..Array::default() };
            array.off = vec![1];
            let boards = vec![Board::default(), above.clone()];
            let aperture =
                Aperture::new(&Scene { array, boards, reflectors: vec![mirror.clone()], ..Scene::default() });
            let excitation: Vec<_> =
                (0..aperture.driven.len()).map(|n| Complex64::cis(0.7 * (n * n) as f64)).collect();
            let rows = aperture.transfer_with_slopes(&points, &directions).pressure(&excitation);
            let hair = 2e-3 * aperture.wavelength();
            for (own, &point) in rows.chunks(3).zip(&points) {
                let pressure = |at: DVec3| aperture.pressures(&[at], &excitation)[0];
                let along = |axis: DVec3| -> Complex64 {
                    let part =
                        |&(at, weight): &(f64, f64)| pressure(point + axis * (at * hair)) * (weight / hair);
                    STENCIL.iter().map(part).sum()
                };
                let expected = [pressure(point), along(directions[0]), along(directions[1])];
                let wavenumber = aperture.element.wavenumber;
                for ((own, expected), unit) in own.iter().zip(expected).zip([1.0, wavenumber, wavenumber]) {
                    let off = (own - expected).norm() / (expected.norm().max(1.0) * unit);
                    assert!(off < 1e-7, "{element:?}, {point}: {own}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn slopes_in_the_plane_of_elements_are_finite_and_those_behind_are_zero() {
        for &element in ElementModel::VARIANTS {
            let array = Array { rows: 2, columns: 2, element, ..Array::default() };
            let aperture = Aperture::new(&Scene { array, ..Scene::default() });
            let slope = |height: f64| {
                let rows = aperture.transfer_with_slopes(&[dvec3(0.02, 0.01, height)], &[DVec3::Z]);
                rows.pressure(&[Complex64::ONE; 4])[1]
            };
            let beside = [1.0, 0.5, 0.0, -0.5].map(|part| slope(part * NEAREST));
            for own in beside {
                assert!(own.is_finite() && (own - beside[0]).norm() <= 1e-6 * beside[0].norm(), "{beside:?}");
            }
            assert_eq!(slope(-2.0 * NEAREST), Complex64::ZERO, "{element:?}");
        }
    }
}
