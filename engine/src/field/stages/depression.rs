//! Figures of a liquid's surface (depth, slope, force, volume) on the displayed plane.
//!
//! The maximum depth and slope lie between the cells: they are maxima (`summit`) of the surface that the window of
//! the pixels interpolates, on the plane including its edge.

use glam::DVec2;
use rayon::prelude::*;

use crate::field::cells::Cells;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::summit::Lattice;

/// Samples to a cell, along each axis: six to the shortest wave of a square.
const PER_CELL: f64 = 2.0;
/// Points interpolated together.
const RUN: usize = 64;

/// A liquid's surface on a plane, continuous between its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Depression {
    /// Largest depth below the level surface, m.
    pub deepest: f64,
    /// The steepest slope.
    pub slope: f64,
    /// m³ between the surface and its level.
    pub volume: f64,
}

impl Depression {
    /// Figures of a depth (m, positive down) for every cell, on the part of them that a plane of this `size` (m) covers.
    /// Its edge belongs to the plane.
    pub(super) fn new(cells: &Cells, size: DVec2, depth: &[f64]) -> Self {
        let surface = Surface { cells, depth, size };
        Self {
            deepest: surface.largest(false, |places| surface.depths_on(places), |at, place| at.depth(place)),
            slope: surface.largest(true, |places| surface.slopes_on(places), |at, place| at.slope(place)),
            volume: cells.integral(size, depth.iter().copied()),
        }
    }

    /// The depression under this part of the pressure.
    pub(super) fn times(self, part: f64) -> Self {
        Self { deepest: self.deepest * part, slope: self.slope * part, volume: self.volume * part }
    }
}

/// Cells with their depth, and the examined rectangle.
struct Surface<'a> {
    cells: &'a Cells,
    depth: &'a [f64],
    /// m
    size: DVec2,
}

impl Surface<'_> {
    /// The largest value on the rectangle: of lattice values and the underlying function.
    fn largest(
        &self,
        with_slopes: bool,
        on: impl Fn([&[f64]; 2]) -> Vec<f64>,
        at: impl Fn(&Interpolated<'_>, usize) -> f64 + Sync + Send,
    ) -> f64 {
        let counts = (PER_CELL * self.size / self.cells.step).ceil().max(DVec2::ONE) + 1.0;
        let step = self.size / (counts - 1.0);
        let places = [0, 1].map(|axis| -> Vec<f64> {
            (0..counts[axis] as usize).map(|i| step[axis] * i as f64 - self.size[axis] / 2.0).collect()
        });
        let lattice = Lattice {
            values: on([&places[0], &places[1]]),
            columns: places[0].len(),
            first: -self.size / 2.0,
            step,
            half: self.size / 2.0,
        };
        let value = |places: &[DVec2]| {
            let interpolated = Interpolated::new(self, places, with_slopes);
            (0..places.len())
                .into_par_iter()
                .with_min_len(RUN)
                .map(|place| at(&interpolated, place))
                .collect()
        };
        lattice.summit(|_| true, value).map_or(0.0, |summit| summit.value)
    }

    fn depths_on(&self, [x, y]: [&[f64]; 2]) -> Vec<f64> {
        self.on(&self.values(0, x), &self.values(1, y))
    }

    fn slopes_on(&self, [x, y]: [&[f64]; 2]) -> Vec<f64> {
        let along_x = self.on(&self.slopes(0, x), &self.values(1, y));
        let along_y = self.on(&self.values(0, x), &self.slopes(1, y));
        along_x.into_iter().zip(along_y).map(|(x, y)| x.hypot(y) / self.cells.step).collect()
    }

    fn on(&self, across: &Resampling, up: &Resampling) -> Vec<f64> {
        let depth: Vec<_> = self.depth.iter().map(|&depth| depth as f32).collect();
        let mut values = vec![0.0; across.len() * up.len()];
        interpolate(&depth, self.cells.counts[0], across, up, &mut Between::default(), &mut values);
        values.into_iter().map(f64::from).collect()
    }

    fn values(&self, axis: usize, places: &[f64]) -> Resampling {
        self.cells.resampling(axis, places.iter().copied())
    }

    fn slopes(&self, axis: usize, places: &[f64]) -> Resampling {
        self.cells.slopes(axis, places.iter().copied())
    }
}

/// A surface at single places, in f64.
struct Interpolated<'a> {
    surface: &'a Surface<'a>,
    values: [Resampling; 2],
    slopes: [Resampling; 2],
}

impl<'a> Interpolated<'a> {
    fn new(surface: &'a Surface<'a>, places: &[DVec2], with_slopes: bool) -> Self {
        let along = [0, 1].map(|axis| places.iter().map(|place| place[axis]).collect::<Vec<_>>());
        Self {
            surface,
            values: [0, 1].map(|axis| surface.values(axis, &along[axis])),
            slopes: match with_slopes {
                true => [0, 1].map(|axis| surface.slopes(axis, &along[axis])),
                false => [Resampling::default(), Resampling::default()],
            },
        }
    }

    fn depth(&self, place: usize) -> f64 {
        self.sum(place, &self.values[0], &self.values[1])
    }

    fn slope(&self, place: usize) -> f64 {
        let along_x = self.sum(place, &self.slopes[0], &self.values[1]);
        let along_y = self.sum(place, &self.values[0], &self.slopes[1]);
        along_x.hypot(along_y) / self.surface.cells.step
    }

    fn sum(&self, place: usize, across: &Resampling, up: &Resampling) -> f64 {
        let ((column, across), (row, up)) = (across.of(place, 1), up.of(place, 1));
        let columns = self.surface.cells.counts[0];
        let line = |row: usize| &self.surface.depth[row * columns + column..][..across.len()];
        let of_line = |row: usize| -> f64 {
            line(row).iter().zip(across).map(|(depth, part)| depth * f64::from(*part)).sum()
        };
        up.iter().enumerate().map(|(tap, part)| of_line(row + tap) * f64::from(*part)).sum()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::{Plane, Scene};

    #[test]
    fn figures_of_a_wave_are_its_depth_its_slope_and_its_mean() {
        const HEIGHT: f64 = 1e-5;
        let plane = Plane { size: DVec2::new(0.05, 0.04), ..Plane::default() };
        let cells = Cells::new(&Aperture::new(&Scene::default()), &plane, 0.02, 1e-3).unwrap();
        for axis in [0, 1] {
            // A wave of eleven cells about a mean depth.
            let turn = TAU / (11.3 * cells.step);
            let places = [0, 1].map(|axis| cells.places(axis).collect::<Vec<_>>());
            let depth: Vec<_> = (0..cells.count())
                .map(|i| [places[0][i % cells.counts[0]], places[1][i / cells.counts[0]]][axis])
                .map(|place| HEIGHT * (1.0 + (turn * place).sin()))
                .collect();
            let Depression { deepest, slope, volume } = Depression::new(&cells, plane.size, &depth);
            assert!((deepest / (2.0 * HEIGHT) - 1.0).abs() < 2e-3, "{axis}: {deepest:e}");
            assert!((slope / (HEIGHT * turn) - 1.0).abs() < 2e-3, "{axis}: {slope:e}");
            let mean = volume / plane.size.element_product();
            assert!((mean / HEIGHT - 1.0).abs() < 1e-9, "{axis}: {mean:e}");
        }
    }

    /// A plane of the size, its cells, and depths (m) along one of its axes.
    fn along(size: DVec2, axis: usize, depth: impl Fn(f64, f64) -> f64) -> (Cells, Depression) {
        let plane = Plane { size, ..Plane::default() };
        let cells = Cells::new(&Aperture::new(&Scene::default()), &plane, 0.02, 1e-3).unwrap();
        let places: Vec<_> = cells.places(axis).collect();
        let place = |i: usize| places[[i % cells.counts[0], i / cells.counts[0]][axis]];
        let depths: Vec<_> = (0..cells.count()).map(|i| depth(place(i), cells.step)).collect();
        let found = Depression::new(&cells, size, &depths);
        (cells, found)
    }

    #[test]
    fn the_deepest_place_may_be_on_any_edge() {
        let size = DVec2::new(0.05, 0.04);
        for (axis, side) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)] {
            let half = size[axis] / 2.0;
            // A short wave with its crest on the edge, the highest of all.
            let depth = |place: f64, step: f64| {
                (1.0 + 0.5 * side * place / half) * (TAU * (place - side * half) / (3.3 * step)).cos()
            };
            let deepest = along(size, axis, depth).1.deepest;
            assert!((deepest / 1.5 - 1.0).abs() < 5e-3, "{axis}, {side}: {deepest}");
        }
    }

    #[test]
    fn a_plane_smaller_than_a_cell_has_the_depth_and_the_slope_there() {
        let size = DVec2::splat(2e-4);
        for axis in [0, 1] {
            let turn = |step: f64| TAU / (11.3 * step);
            let (cells, found) = along(size, axis, |place, step| 1.0 + (turn(step) * place).sin());
            let turn = turn(cells.step);
            let deepest = 1.0 + (turn * size[axis] / 2.0).sin();
            assert!((found.deepest / deepest - 1.0).abs() < 2e-3, "{axis}: {found:?}");
            assert!((found.slope / turn - 1.0).abs() < 2e-3, "{axis}: {found:?}");
        }
    }
}
