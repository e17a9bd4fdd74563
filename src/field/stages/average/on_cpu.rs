//! Averages on the CPU.

use num_complex::Complex32;

use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::plan::Grid;
use crate::field::stages::average::{Job, Made, Mean, Sounding, Squares};
use crate::field::stages::on_cpu::Superposition;
use crate::field::stages::{Kept, Setting, Work};
use crate::scene::Liquid;
use crate::surface::{Dent, Reflector};

/// Drives whose samples are there at the same time.
const TOGETHER: usize = 64;

#[derive(Debug, Default)]
pub(super) struct OnCpu {
    superposition: Superposition,
    /// For samples in f64, or not.
    squares: Kept<(Sounding, bool), Squares>,
    dent: Kept<(Sounding, bool, Liquid), Dent>,
    at_cells: AtCells,
    pub(super) pixels: Vec<Complex32>,
}

/// The pressure of one drive at the cells, its slopes, and what lies between them and the samples; kept for the next drive,
/// since fresh memory costs more than the work on it.
#[derive(Debug, Default)]
struct AtCells {
    between: Between,
    pressure: Vec<Complex32>,
    slopes: [Vec<Complex32>; 2],
}

impl OnCpu {
    pub(super) fn forget(&mut self) {
        self.superposition.forget();
        self.squares.key = None;
        self.dent.key = None;
    }

    /// So many pixels of a shape that is given for every cell, `columns` in a row.
    pub(super) fn shape(
        &mut self,
        cells: &[f64],
        columns: usize,
        [across, up]: [&Resampling; 2],
        pixels: usize,
    ) -> Vec<Complex32> {
        let cells: Vec<_> = cells.iter().map(|&value| Complex32::from(value as f32)).collect();
        let mut shape = vec![Complex32::ZERO; pixels];
        interpolate(&cells, columns, across, up, &mut self.at_cells.between, &mut shape);
        shape
    }
}

impl Job<'_> {
    /// Makes the pixels, with samples in f64 if `double`.
    pub(super) fn on_cpu(&self, cpu: &mut OnCpu, double: bool, work: &mut Work) -> Made {
        let OnCpu { superposition, squares, dent, at_cells, pixels } = cpu;
        let (sounding, part) = (&self.drawn.sounding, self.drawn.part);
        let squares = squares.update(&(sounding.clone(), double), |squares| {
            self.squares(double, superposition, at_cells, squares, work);
        });
        let dent = match (&self.wanted.mean, self.tank) {
            (Mean::Dent(_, liquid), Some(tank)) => {
                let key = (sounding.clone(), double, liquid.clone());
                let full = dent.update(&key, |dent| {
                    work.dent += 1;
                    let pressure: Vec<_> = squares.iter().map(|[_, radiation]| *radiation).collect();
                    *dent = tank.dent(liquid, &pressure);
                });
                Some(full.times(part))
            }
            _ => None,
        };
        let value = |(cell, [square, radiation]): (usize, &[f64; 2])| {
            let shape = dent.as_ref().map_or(*square, |dent| dent.depth[cell]);
            Complex32::new(shape as f32, (part * radiation) as f32)
        };
        let cells: Vec<_> = squares.iter().enumerate().map(value).collect();
        pixels.resize(self.drawn.size.0 * self.drawn.size.1, Complex32::ZERO);
        work.interpolation += 1;
        let frame = self.frame;
        let between = &mut at_cells.between;
        interpolate(&cells, self.filled.cells.counts[0], &frame.across, &frame.up, between, pixels);
        let quantity = self.wanted.mean.quantity();
        Made {
            largest: pixels.iter().map(|&value| quantity.of(value)).fold(0.0, f32::max),
            at_probes: frame.probes.iter().map(|&pixel| pixels[pixel]).collect(),
            squares: squares.clone(),
            dent,
        }
    }

    /// Mean squares at the cells.
    fn squares(
        &self,
        double: bool,
        superposition: &mut Superposition,
        at_cells: &mut AtCells,
        squares: &mut Squares,
        work: &mut Work,
    ) {
        let Some(grid) = &self.filled.plan.grid else { return };
        squares.clear();
        squares.resize(self.filled.cells.len(), [0.0; 2]);
        let setting = Setting::new(self.wanted.aperture, self.filled.cells.plane.clone());
        for drives in self.wanted.drives.chunks(TOGETHER) {
            let all = superposition.at(&setting, grid, self.wanted.aperture, drives, double, work);
            for samples in &all {
                work.squares += 1;
                self.add(samples, grid, at_cells, squares);
            }
        }
        let share = 1.0 / self.wanted.drives.len() as f64;
        squares.iter_mut().for_each(|square| *square = square.map(|value| value * share));
    }

    /// Adds the squares of one drive.
    fn add(&self, samples: &[Complex32], grid: &Grid, at_cells: &mut AtCells, squares: &mut Squares) {
        let AtCells { between, pressure, slopes: [along_x, along_y] } = at_cells;
        let mut fill = |cells: &mut Vec<Complex32>, across: &Resampling, up: &Resampling| {
            cells.resize(squares.len(), Complex32::ZERO);
            interpolate(samples, grid.samples.columns.len(), across, up, between, cells);
        };
        let [[across, up], [across_slope, up_slope]] = [&self.filled.values, &self.filled.slopes];
        fill(pressure, across, up);
        let Some(Reflector { of_pressure, of_gradient }) = self.drawn.sounding.reflector else {
            for (square, p) in squares.iter_mut().zip(pressure) {
                square[0] += f64::from(p.norm_sqr());
            }
            return;
        };
        fill(along_x, across_slope, up);
        fill(along_y, across, up_slope);
        for ((square, p), (x, y)) in squares.iter_mut().zip(pressure).zip(along_x.iter().zip(along_y)) {
            let (p, gradient) = (f64::from(p.norm_sqr()), f64::from(x.norm_sqr() + y.norm_sqr()));
            square[0] += p;
            square[1] += of_pressure * p - of_gradient * gradient;
        }
    }
}
