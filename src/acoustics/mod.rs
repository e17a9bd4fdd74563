//! From elements to points: the array's geometry, the air, and the transfer between them, in f64.

pub mod air;
pub mod element;
mod jacobian;
mod row;
mod transfer;

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::scene::{Array, Scene};

pub use air::Air;
use row::Elements;

pub use element::Element;
pub use jacobian::PhaseJacobian;
pub use transfer::{Phasors, Sums, Transfer};

/// The array as a radiator: equal elements at known places, some of them driven.
#[derive(Clone, Debug, PartialEq)]
pub struct Aperture {
    pub element: Element,
    /// m, in z = 0; element n = row · columns + column, column 0 at smallest x, row 0 at smallest y.
    pub positions: Vec<DVec2>,
    /// m, between neighbours.
    pub pitch: f64,
    /// Elements along x; `positions` holds whole rows of them.
    pub columns: usize,
    /// Indices into `positions` of the elements that are not off, in rising order.
    pub driven: Vec<usize>,
}

impl Aperture {
    pub fn new(scene: &Scene) -> Self {
        let array = &scene.array;
        let air = Air::new(&scene.medium, array.frequency);
        let element = Element {
            model: array.element,
            wavenumber: TAU * array.frequency / air.sound_speed,
            radius: array.element_radius,
            strength: array.strength,
            attenuation: air.attenuation,
        };
        let off: std::collections::HashSet<_> = array.off.iter().copied().collect();
        let driven = (0..array.elements()).filter(|n| !off.contains(n)).collect();
        Self {
            element,
            positions: positions(array),
            pitch: array.pitch,
            columns: array.columns as usize,
            driven,
        }
    }

    /// m
    pub fn wavelength(&self) -> f64 {
        TAU / self.element.wavenumber
    }

    /// The centres of the first and the last element: opposite corners of the array.
    pub fn corners(&self) -> (DVec2, DVec2) {
        (self.positions[0], self.positions[self.positions.len() - 1])
    }

    /// The box around the centres of the driven elements: its smallest and its largest corner, m.
    pub fn extent(&self) -> (DVec2, DVec2) {
        self.driven
            .iter()
            .map(|&n| self.positions[n])
            .fold((DVec2::MAX, DVec2::MIN), |(low, high), position| (low.min(position), high.max(position)))
    }

    /// H: one row of complex pressures (Pa, peak) per point, one column per driven element.
    pub fn transfer(&self, points: &[DVec3]) -> Transfer {
        let elements = Elements::new(&self.element, self.driven.iter().map(|&n| self.positions[n]));
        let mut transfer = Transfer::zeros(points.len(), self.driven.len());
        for (index, &point) in points.iter().enumerate() {
            let (re, im) = transfer.row_mut(index);
            elements.fill(point, re, im);
        }
        transfer
    }

    /// The distance (m) below which two foci near a point are not told apart: λ/(2 NA), NA the sine of half the angle
    /// under which the array is seen along its wider side.
    pub fn resolution(&self) -> impl Fn(DVec3) -> f64 {
        let ((low, high), wavelength) = (self.extent(), self.wavelength());
        move |point| {
            let half_angle = |low: f64, high: f64, x: f64| {
                (((high - x) / point.z).atan() - ((low - x) / point.z).atan()) / 2.0
            };
            let widest = half_angle(low.x, high.x, point.x).max(half_angle(low.y, high.y, point.y));
            wavelength / (2.0 * widest.sin().max(1e-6))
        }
    }
}

fn positions(array: &Array) -> Vec<DVec2> {
    let last = DVec2::new(f64::from(array.columns - 1), f64::from(array.rows - 1));
    let place =
        |row: u32, column: u32| (DVec2::new(f64::from(column), f64::from(row)) - last / 2.0) * array.pitch;
    (0..array.rows).flat_map(|row| (0..array.columns).map(move |column| place(row, column))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_numbered_row_by_row_and_centred() {
        let array = Array { rows: 3, columns: 4, pitch: 0.01, ..Array::default() };
        let positions = positions(&array);
        assert_eq!(positions.len(), 12);
        assert!(positions[0].distance(DVec2::new(-0.015, -0.01)) < 1e-15);
        assert!(positions[1].distance(DVec2::new(-0.005, -0.01)) < 1e-15, "x runs fastest");
        assert!(positions[11].distance(DVec2::new(0.015, 0.01)) < 1e-15);
    }

    #[test]
    fn elements_that_are_off_have_no_column() {
        let mut scene = Scene::default();
        scene.array.off = vec![3, 3, 255];
        let aperture = Aperture::new(&scene);
        assert_eq!(aperture.driven.len(), 254);
        assert!(!aperture.driven.contains(&3));
        let point = DVec3::new(0.0, 0.0, 0.1);
        assert_eq!(
            aperture.transfer(&[point]).at(0, 3),
            Aperture::new(&Scene::default()).transfer(&[point]).at(0, 4)
        );
    }

    #[test]
    fn the_resolution_is_that_of_the_aperture() {
        let mut scene = Scene::default();
        scene.array.pitch = 0.01;
        let aperture = Aperture::new(&scene);
        let na = (0.075f64 / 0.1).atan().sin();
        let expected = aperture.wavelength() / (2.0 * na);
        assert!((aperture.resolution()(DVec3::new(0.0, 0.0, 0.1)) - expected).abs() < 1e-12);
    }
}
