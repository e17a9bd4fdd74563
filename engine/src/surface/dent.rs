//! The static depression of a liquid under a pressure: ρ g h - σ ∇²h = p, h being the depth.
//!
//! In cosine modes, which meet the walls level, this is a division by ρg + σq² for the mode of wavenumber q.

use std::f64::consts::PI;
use std::fmt;

use sonoglyph_fourier::{Cosines, cosines};

use crate::scene::Liquid;

/// Limit of the surface's slope for the linear theory.
pub const STEEPEST: f64 = 0.3;

/// A rectangle of a liquid's surface, divided into cells. Its walls, half a cell beyond the centres of the outermost, are met at
/// a right angle: every shape of the surface is a sum of cosines.
#[derive(Clone)]
pub struct Tank {
    /// Columns and rows.
    pub counts: [usize; 2],
    /// m, between the centres of neighbouring cells, along a row and from row to row.
    pub step: [f64; 2],
    transforms: [Cosines; 2],
}

impl fmt::Debug for Tank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tank").field("counts", &self.counts).field("step", &self.step).finish_non_exhaustive()
    }
}

/// The shape of a liquid's whole surface under a pressure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dent {
    /// m, positive down, for every cell, row by row.
    pub depth: Vec<f64>,
    /// Displaced volume (m³), F/(ρ g).
    pub volume: f64,
    /// N that press on the whole surface.
    pub force: f64,
}

/// The largest factor on the drive's amplitude for which the linear theory holds, given the slope at full drive;
/// depressions scale with its square.
pub fn largest_drive(slope: f64) -> f64 {
    if slope > 0.0 { (STEEPEST / slope).sqrt() } else { f64::INFINITY }
}

impl Tank {
    /// `counts` cells, along a row and rows, `step` (m) apart. All shapes and pressures of a tank have a value for each.
    ///
    /// # Panics
    /// No cells, or invalid steps; later calls panic on a wrong number of values.
    pub fn new(counts: [usize; 2], step: [f64; 2]) -> Self {
        assert!(counts.iter().all(|&count| count > 0), "no cells: {counts:?}");
        assert!(step.iter().all(|&step| step.is_normal() && step > 0.0), "no lengths: {step:?}");
        Self { counts, step, transforms: counts.map(cosines) }
    }

    /// Cells.
    pub fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// The depression under a pressure (Pa) given for every cell, row by row.
    pub fn dent(&self, liquid: &Liquid, pressure: &[f64]) -> Dent {
        let mut modes = self.modes(pressure);
        for (mode, square) in modes.iter_mut().zip(self.squares()) {
            *mode *= compliance(liquid, square);
        }
        let depth = self.surface(modes);
        let cell = self.step[0] * self.step[1];
        Dent { volume: depth.iter().sum::<f64>() * cell, force: pressure.iter().sum::<f64>() * cell, depth }
    }

    /// The amplitudes of the cosines that a shape is the sum of: a_kl of a_kl cos(πkx/X) cos(πly/Y), row by row.
    pub fn modes(&self, shape: &[f64]) -> Vec<f64> {
        let [columns, rows] = self.counts;
        assert_eq!(shape.len(), self.count(), "a value for every cell");
        let mut modes = shape.to_vec();
        self.along_both(&mut modes, |transform, line, scratch| {
            transform.process_dct2_with_scratch(line, scratch);
        });
        for (index, mode) in modes.iter_mut().enumerate() {
            let half = |is_first: bool| if is_first { 1.0 } else { 2.0 };
            let share = half(index % columns == 0) * half(index < columns);
            *mode *= share / (columns * rows) as f64;
        }
        modes
    }

    /// The shape with these modes.
    pub fn surface(&self, mut modes: Vec<f64>) -> Vec<f64> {
        assert_eq!(modes.len(), self.count(), "an amplitude for every mode");
        self.along_both(&mut modes, |transform, line, scratch| {
            line[0] *= 2.0;
            transform.process_dct3_with_scratch(line, scratch);
        });
        modes
    }

    /// q² (1/m²) of every mode, row by row.
    pub fn squares(&self) -> impl Iterator<Item = f64> {
        let [columns, rows] = self.counts;
        let along = move |axis: usize, k: usize| {
            (PI * k as f64 / (self.step[axis] * self.counts[axis] as f64)).powi(2)
        };
        (0..rows).flat_map(move |l| (0..columns).map(move |k| along(0, k) + along(1, l)))
    }

    /// Every row, then every column.
    fn along_both(&self, values: &mut Vec<f64>, process: impl Fn(&Cosines, &mut [f64], &mut [f64])) {
        for axis in [0, 1] {
            let transform = &self.transforms[axis];
            let mut scratch = vec![0.0; transform.get_scratch_len()];
            for line in values.chunks_exact_mut(self.counts[axis]) {
                process(transform, line, &mut scratch);
            }
            *values = transposed(values, self.counts[axis]);
        }
    }
}

/// 1/(ρ g + σ q²), m/Pa: the compliance of a mode.
pub fn compliance(liquid: &Liquid, square: f64) -> f64 {
    1.0 / (liquid.density() * liquid.gravity + liquid.surface_tension() * square)
}

/// Transposed values; `columns` values per row.
fn transposed(values: &[f64], columns: usize) -> Vec<f64> {
    /// A square of values stays in the nearest cache.
    const SIDE: usize = 16;
    let rows = values.len() / columns;
    let mut lines = vec![0.0; values.len()];
    for first in (0..columns).step_by(SIDE) {
        for start in (0..rows).step_by(SIDE) {
            for column in first..columns.min(first + SIDE) {
                for row in start..rows.min(start + SIDE) {
                    lines[column * rows + row] = values[row * columns + column];
                }
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_come_back_as_the_shape() {
        let tank = Tank::new([7, 12], [0.01, 0.02]);
        let shape: Vec<_> = (0..84).map(|i| f64::from(i * i % 29)).collect();
        let back = tank.surface(tank.modes(&shape));
        assert!(shape.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-12));
        let mut single = vec![0.0; 84];
        single[7 * 2 + 3] = 1.0;
        let wave = tank.surface(single);
        let expected = |i: usize| {
            (PI * 3.0 * ((i % 7) as f64 + 0.5) / 7.0).cos() * (PI * 2.0 * ((i / 7) as f64 + 0.5) / 12.0).cos()
        };
        assert!((0..84).all(|i| (wave[i] - expected(i)).abs() < 1e-12));
    }
}
