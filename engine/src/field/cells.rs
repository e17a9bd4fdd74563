//! The cells of a plane, where squares of the pressure are formed: fine enough for twice its bandwidth.

use glam::{DVec2, DVec3};

use crate::acoustics::{Aperture, Face};
use crate::field::interpolation::Resampling;
use crate::field::samples::Samples;
use crate::scene::Plane;
use crate::surface::Tank;

/// Cells per wavelength. A square has at most two cycles per wavelength, for which three cells would suffice.
const PER_WAVELENGTH: f64 = 6.0;
/// Cycles per wavelength of a pressure whose square the window passes: slightly more than one, for evanescent sound.
const HIGHEST: f64 = 1.05;
/// Cells that a plane may have.
const MOST: usize = 1 << 23;

/// Square cells that fill a plane and a margin around it, the same on opposite sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// The plane filled by cells, with the tolerance of the pressure at them: squaring doubles errors.
    pub plane: Plane,
    /// Columns and rows; with a margin, products of 2, 3 and 5 for fast transforms.
    pub counts: [usize; 2],
    /// m
    pub step: f64,
    /// Half-width (cells) and shape of the window from cells to pixels.
    half_width: usize,
    beta: f64,
}

impl Cells {
    /// Cells of a `plane`, at least `margin` (m) beyond it, whose interpolated squares are off by at most `accuracy`,
    /// relative to their peak. `None` if there would be too many.
    pub fn new(aperture: &Aperture, plane: &Plane, margin: f64, accuracy: f64) -> Option<Self> {
        /// The window's share of the accuracy; the rest is for the squares.
        const SHARE: f64 = 0.2;
        let step = aperture.wavelength() / (PER_WAVELENGTH * pattern(aperture, plane)?);
        let beta = -(SHARE * accuracy).ln();
        let half_width = (beta / (std::f64::consts::TAU * (0.5 - 2.0 * HIGHEST / PER_WAVELENGTH))).ceil();
        let is_tank = margin > 0.0;
        let margin = margin.max(half_width * step);
        let counts = plane.size.to_array().map(|length| ((length + 2.0 * margin) / step).ceil());
        // Not the other way round: a NaN is not few.
        let is_few = (1.0..=MOST as f64).contains(&(counts[0] * counts[1]));
        if !is_few || !half_width.is_finite() {
            return None;
        }
        let counts = counts.map(|count| if is_tank { smooth(count as usize) } else { count as usize });
        let size = DVec2::from(counts.map(|count| count as f64 * step));
        Some(Self {
            plane: Plane { size, tolerance: plane.tolerance * (1.0 - SHARE) / 2.0, ..plane.clone() },
            counts,
            step,
            half_width: half_width as usize,
            beta,
        })
    }

    /// The cells in the middle, of the same centre if their counts are even or odd alike.
    pub(crate) fn within(&self, counts: [usize; 2]) -> Self {
        let size = DVec2::from(counts.map(|count| count as f64 * self.step));
        Self { plane: Plane { size, ..self.plane.clone() }, counts, ..self.clone() }
    }

    pub fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Distance (m) from a point to the farthest cell of its interpolation.
    pub fn reach(&self) -> f64 {
        self.half_width as f64 * self.step
    }

    /// Cells extended beyond every wall by the window's reach, with the same centre.
    pub fn beyond_walls(&self) -> Self {
        self.within(self.counts.map(|count| count + 2 * self.half_width))
    }

    /// Values of the cells as those of [`Cells::beyond_walls`]: walls mirror them, as they mirror a surface of cosines.
    pub fn mirrored(&self, values: &[f64], part: f64) -> Vec<f32> {
        let from = |axis: usize| -> Vec<usize> {
            let (count, reach) = (self.counts[axis], self.half_width);
            // There are at least twice as many cells as the window reaches.
            let fold = |i: usize| {
                let place = (i + 2 * count - reach) % (2 * count);
                if place < count { place } else { 2 * count - 1 - place }
            };
            (0..count + 2 * reach).map(fold).collect()
        };
        let columns = from(0);
        let row = |row: usize| {
            let values = &values[row * self.counts[0]..][..self.counts[0]];
            columns.iter().map(move |&column| (part * values[column]) as f32)
        };
        from(1).into_iter().flat_map(row).collect()
    }

    /// The centres of the cells along an axis, in m from the plane's centre.
    pub fn places(&self, axis: usize) -> impl Iterator<Item = f64> {
        let (count, step) = (self.counts[axis], self.step);
        (0..count).map(move |i| (i as f64 + 0.5 - count as f64 / 2.0) * step)
    }

    /// The centres of all cells, along a plane's axes.
    pub fn points(&self, [x, y, _]: [DVec3; 3]) -> Samples {
        Samples {
            columns: self.places(0).map(|place| self.plane.centre + x * place).collect(),
            rows: self.places(1).map(|place| y * place).collect(),
        }
    }

    /// Interpolation from the cells to `places` (m) along an axis.
    pub fn resampling(&self, axis: usize, places: impl Iterator<Item = f64>) -> Resampling {
        Resampling::new(self.in_cells(axis, places), self.half_width, self.beta)
    }

    /// The same of slopes, per cell.
    pub fn slopes(&self, axis: usize, places: impl Iterator<Item = f64>) -> Resampling {
        Resampling::slopes(self.in_cells(axis, places), self.half_width, self.beta)
    }

    fn in_cells(&self, axis: usize, places: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
        places.map(move |place| place / self.step + self.counts[axis] as f64 / 2.0 - 0.5)
    }

    /// The same cells as a liquid's surface.
    pub fn tank(&self) -> Tank {
        Tank::new(self.counts, [self.step; 2])
    }

    /// The integral of cell values over the part covered by a plane of this `size` (m).
    pub fn integral(&self, size: DVec2, values: impl Iterator<Item = f64>) -> f64 {
        let covered = [0, 1].map(|axis| -> Vec<f64> {
            let part = |place: f64| ((size[axis] / 2.0 - place.abs()) / self.step + 0.5).clamp(0.0, 1.0);
            self.places(axis).map(part).collect()
        });
        let weighted = values
            .enumerate()
            .map(|(i, value)| covered[0][i % self.counts[0]] * covered[1][i / self.counts[0]] * value);
        weighted.sum::<f64>() * self.step * self.step
    }
}

/// Refinement factor for the directivity of elements wider than their distance (see [`crate::field::plan`]); usually
/// one.
fn pattern(aperture: &Aperture, plane: &Plane) -> Option<f64> {
    let (x_axis, y_axis) = plane.axes()?;
    let height = |face: &Face| {
        let [x, y] = [x_axis, y_axis].map(|axis| face.pose.local_direction(axis).z.abs());
        face.pose.local(plane.centre).z - (plane.size.x * x + plane.size.y * y) / 2.0
    };
    let least = aperture.wavelength();
    let heights = aperture.faces.iter().map(height).filter(|&height| height > least);
    let clear = heights.fold(f64::INFINITY, f64::min);
    let is_clear = aperture.faces.iter().all(|face| face.layout.is_flat() && height(face) > least);
    let height = if is_clear { clear } else { least };
    let radius = aperture.element.steepness();
    Some((1f64.hypot(radius / height) / HIGHEST).max(1.0))
}

/// The smallest product of 2, 3 and 5 that is not below `least`.
pub(crate) fn smooth(least: usize) -> usize {
    let is_smooth = |count: &usize| {
        let mut rest = *count;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (least.max(1)..).find(is_smooth).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::scene::Scene;

    #[test]
    fn cells_fill_the_plane_and_its_margin() {
        let scene = Scene::default();
        let aperture = Aperture::new(&scene);
        let cells = Cells::new(&aperture, &scene.plane, 0.03, 1e-3).unwrap();
        for axis in [0, 1] {
            let places: Vec<_> = cells.places(axis).collect();
            assert!(places[0] <= -0.13 + cells.step && (places[0] + places[places.len() - 1]).abs() < 1e-12);
            assert_eq!(smooth(cells.counts[axis]), cells.counts[axis]);
        }
        let area = cells.integral(scene.plane.size, (0..cells.count()).map(|_| 1.0));
        assert!((area - 0.04).abs() < 1e-12, "{area}");
        assert_eq!((smooth(7), smooth(121), smooth(0)), (8, 125, 1));
        for (width, margin) in [(0.1, 0.0), (0.1234, 0.0), (0.0501, 0.001), (0.2, 0.03), (0.2003, 0.0307)] {
            let plane = Plane { size: DVec2::new(width, 0.07), ..scene.plane.clone() };
            let cells = Cells::new(&aperture, &plane, margin, 1e-3).unwrap();
            let needed = plane.size + 2.0 * f64::max(margin, cells.half_width as f64 * cells.step);
            assert!(cells.plane.size.cmpge(needed - 1e-12).all(), "{width}, {margin}: {cells:?}");
            // Squares are twice as far off.
            assert!(cells.plane.tolerance < plane.tolerance / 2.0, "{cells:?}");
        }
        let endless = Plane { size: DVec2::splat(50.0), ..scene.plane };
        assert_eq!(Cells::new(&aperture, &endless, 0.0, 1e-3), None);
    }

    #[test]
    fn the_window_passes_squares_of_evanescent_sound() {
        let scene = Scene::default();
        let aperture = Aperture::new(&scene);
        // Twice the highest frequency of the pressure.
        let cycles = 2.0 * HIGHEST / PER_WAVELENGTH;
        for accuracy in [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5] {
            let cells = Cells::new(&aperture, &scene.plane, 0.0, accuracy).unwrap();
            let places = || (0..200).map(|i| 4.7e-4 * f64::from(i) - 0.05);
            let resampling = cells.resampling(0, places());
            let mut worst = 0.0f64;
            for (pixel, place) in cells.in_cells(0, places()).enumerate() {
                let (first, weights) = resampling.of(pixel, 1);
                for turn in 0..8 {
                    let wave = |at: f64| (TAU * (cycles * at + f64::from(turn) / 8.0)).cos();
                    let taps = weights.iter().enumerate();
                    let sum: f64 = taps.map(|(tap, w)| f64::from(*w) * wave((first + tap) as f64)).sum();
                    worst = worst.max((sum - wave(place)).abs());
                }
            }
            assert!(worst < 0.5 * accuracy, "{accuracy:e}: {worst:e}");
        }
    }
}
