//! The caustics of a liquid's surface on a screen of the plane's size: rays between the cells, block by block, as
//! dense as the curvature of the surface requires.
//!
//! Formula, cells and response are those of the depression. Slopes are interpolated from blocks of 8 x 8 cells to
//! lattices of rays, as fine as required by the pixels, the curvature of the surface and the brightness gradient;
//! blocks whose light misses the screen are left out. [`crate::surface::Rays`] spread the light of each patch over
//! its image.

use std::collections::BTreeMap;

use glam::DVec2;
use rayon::prelude::*;

use crate::field::cells::Cells;
use crate::field::interpolation::Resampling;
use crate::field::stages::job::Job;
use crate::simd::{Instructions, Isa, Kernel, fused};
use crate::surface::caustic;
use crate::surface::{Light, Rays};

/// Cells along the side of a block.
const SIDE: usize = 8;
/// Limit of brightness change from patch to patch, unless patches become finer than a pixel or [`FINE`] and
/// [`FINEST`] per cell.
const JUMP: f64 = 0.05;
const FINE: f64 = 3.5;
const FINEST: f64 = 16.0;
/// Tolerated displacement of light between rays, in pixels; and limits of rays per cell.
const ASTRAY: f64 = 0.15;
const MOST: f64 = 48.0;
/// Error of differences between cells for the shortest wave of a square: in the third derivative, and bound for
/// slopes.
const MISSED: f64 = 1.5;
const STEEPER: f64 = 2.5;

/// The result of the last caustic.
#[derive(Debug, Default)]
pub(super) struct Caustic {
    light: Light,
}

/// The data common to all blocks.
struct Surface<'a> {
    cells: &'a Cells,
    /// m, with mirrored cells beyond the walls, `reach` of them on every side.
    depth: Vec<f32>,
    columns: usize,
    reach: usize,
    /// m on the screen for a difference of depth from cell to cell.
    per_cell: f64,
    /// m
    size: DVec2,
    pixel: DVec2,
}

/// Neighbouring cells, and rays to each.
#[derive(Clone, Copy, Debug)]
struct Block {
    first: [usize; 2],
    cells: [usize; 2],
    /// Rays to a cell, along each axis.
    rays: usize,
}

impl Block {
    /// Rays along an axis.
    fn count(&self, axis: usize) -> usize {
        self.cells[axis] * self.rays + 1
    }
}

impl Caustic {
    /// The fate of the light, relative to that of the screen's own area.
    pub(super) fn light(&self) -> Light {
        self.light
    }

    /// The brightness of every pixel for a surface with this depth (m) in every cell; `part` scales the depth.
    pub(super) fn cast(
        &mut self,
        job: &Job<'_>,
        cells: &Cells,
        (depth, part): (&[f64], f64),
        values: &mut [f32],
    ) {
        let request = job.request;
        let (width, height) = request.size;
        let around = cells.beyond_walls();
        let throw = request.liquid.throw();
        let surface = Surface {
            cells,
            depth: cells.mirrored(depth, part),
            columns: around.counts[0],
            reach: (around.counts[0] - cells.counts[0]) / 2,
            per_cell: throw / cells.step,
            size: request.plane.size,
            pixel: request.plane.size / DVec2::new(width as f64, height as f64),
        };
        let blocks = surface.blocks();
        let mut windows = BTreeMap::new();
        for block in &blocks {
            windows.entry(block.rays).or_insert_with(|| surface.windows(&around, block.rays));
        }
        let slopes: Vec<_> =
            blocks.par_iter().map(|block| surface.slopes(block, &windows[&block.rays])).collect();
        let rays: Vec<_> =
            blocks.iter().zip(&slopes).map(|(block, slopes)| surface.rays(block, slopes)).collect();
        let light = caustic::light(&rays, width, values);
        let own = values.len() as f64;
        self.light = Light { sent: light.sent / own, landed: light.landed / own, ..light };
    }
}

impl Surface<'_> {
    /// The blocks whose light may reach the screen.
    fn blocks(&self) -> Vec<Block> {
        let [columns, rows] = self.cells.counts;
        let starts = (0..rows)
            .step_by(SIDE)
            .flat_map(|row| (0..columns).step_by(SIDE).map(move |column| [column, row]))
            .collect::<Vec<_>>();
        starts.into_par_iter().filter_map(|first| self.block(first)).collect()
    }

    fn block(&self, first: [usize; 2]) -> Option<Block> {
        let step = self.cells.step;
        let cells = [0, 1].map(|axis| SIDE.min(self.cells.counts[axis] - first[axis]));
        // Including neighbouring cells: a window is at least two cells wide on either side.
        let (mut slope, mut third) = ([0.0f32; 2], 0.0f32);
        let from = first.map(|first| first + self.reach - 2);
        for row in from[1]..=from[1] + cells[1] {
            for column in from[0]..=from[0] + cells[0] {
                // Differences between the middle two of four cells, in the rows and columns of these two.
                for beside in [1, 2] {
                    let at = |i: usize| self.depth[(row + beside) * self.columns + column + i];
                    let up = |i: usize| self.depth[(row + i) * self.columns + column + beside];
                    slope[0] = slope[0].max((at(2) - at(1)).abs());
                    slope[1] = slope[1].max((up(2) - up(1)).abs());
                    third = third.max((at(3) - at(0) - 3.0 * (at(2) - at(1))).abs());
                    third = third.max((up(3) - up(0) - 3.0 * (up(2) - up(1))).abs());
                }
            }
        }
        let per_cell = self.per_cell.abs();
        for axis in [0, 1] {
            let [low, high] = [first[axis], first[axis] + cells[axis]].map(|edge| self.place(axis, edge));
            let beyond = (low - self.size[axis] / 2.0).max(-self.size[axis] / 2.0 - high);
            if beyond > STEEPER * per_cell * f64::from(slope[axis]) {
                return None;
            }
        }
        let bend = (MISSED * f64::from(third) * per_cell).max(f64::MIN_POSITIVE);
        let pixel = self.pixel.min_element();
        let even = JUMP * step * step / bend;
        // Between rays the mapping is linear, with an error of an eighth of the second difference.
        let straight = step * (8.0 * ASTRAY * pixel / bend).sqrt();
        let wanted = even.max(pixel.clamp(step / FINEST, step / FINE)).min(straight);
        Some(Block { first, cells, rays: (step / wanted).ceil().clamp(1.0, MOST) as usize })
    }

    /// m from the plane's centre to the edge before a cell.
    fn place(&self, axis: usize, edge: usize) -> f64 {
        (edge as f64 - self.cells.counts[axis] as f64 / 2.0) * self.cells.step
    }

    /// The weights of depths and of slopes (per cell) at the rays of a cell.
    fn windows(&self, around: &Cells, rays: usize) -> [Resampling; 2] {
        let edge = (self.reach as f64 - around.counts[0] as f64 / 2.0) * around.step;
        let places = || (0..rays).map(move |ray| edge + ray as f64 / rays as f64 * around.step);
        [around.resampling(0, places()), around.slopes(0, places())]
    }

    /// The slopes (per cell) along both axes at the rays of a block, row by row.
    fn slopes(&self, block: &Block, windows: &[Resampling; 2]) -> [Vec<f32>; 2] {
        let count = block.count(0) * block.count(1);
        let mut made = [vec![0.0f32; count], vec![0.0f32; count]];
        Isa::best().run(Slopes { surface: self, block, windows, made: &mut made });
        made
    }

    fn rays<'a>(&self, block: &Block, slopes: &'a [Vec<f32>; 2]) -> Rays<'a> {
        let step = self.cells.step / block.rays as f64;
        Rays {
            counts: [block.count(0), block.count(1)],
            first: [0, 1]
                .map(|axis| (self.place(axis, block.first[axis]) + self.size[axis] / 2.0) / self.pixel[axis]),
            step: [0, 1].map(|axis| step / self.pixel[axis]),
            slopes: slopes.each_ref().map(|slopes| &slopes[..]),
            throw: [0, 1].map(|axis| self.per_cell / self.pixel[axis]),
        }
    }
}

/// Interpolates between the cells of a block, with the weights of depths and of slopes.
struct Slopes<'a> {
    surface: &'a Surface<'a>,
    block: &'a Block,
    windows: &'a [Resampling; 2],
    /// Along both axes, row by row.
    made: &'a mut [Vec<f32>; 2],
}

impl Kernel for Slopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        /// The cells of a block plus one, whose first ray is the last of the block, padded to registers.
        const LANES: usize = 16;
        let Self { surface, block: Block { first, cells, rays }, windows: [depths, slopes], made } = self;
        let taps = depths.taps;
        // Including the reach of the weights.
        let wide = (LANES + 1 + taps).next_multiple_of(LANES);
        let mut between = [vec![0.0f32; wide], vec![0.0f32; wide]];
        let columns = cells[0] * rays + 1;
        for row in 0..=cells[1] * rays {
            // Depths and slopes upwards between the rows of cells, at the columns of cells.
            for (window, line) in [depths, slopes].into_iter().zip(&mut between) {
                line.fill(0.0);
                let (start, weights) = window.of(row % rays, 1);
                let from = (first[1] + row / rays + start) * surface.columns + first[0];
                for (tap, weight) in weights.iter().enumerate() {
                    let cells = &surface.depth[from + tap * surface.columns..];
                    let cells = &cells[..wide.min(cells.len())];
                    for (sum, cell) in line.iter_mut().zip(cells) {
                        *sum = fused::<I>(*weight, *cell, *sum);
                    }
                }
            }
            for ((window, line), made) in [slopes, depths].into_iter().zip(&between).zip(&mut *made) {
                let made = &mut made[row * columns..][..columns];
                for ray in 0..*rays {
                    let (start, weights) = window.of(ray, 1);
                    let mut sums = [0.0f32; LANES];
                    for (weight, line) in weights.iter().zip(line[start..].windows(LANES)) {
                        for (sum, value) in sums.iter_mut().zip(line) {
                            *sum = fused::<I>(*weight, *value, *sum);
                        }
                    }
                    made[ray..].iter_mut().step_by(*rays).zip(sums).for_each(|(to, sum)| *to = sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
