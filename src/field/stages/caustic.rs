//! The light that a liquid's surface casts on a screen of the plane's size: rays through a lattice between the cells.

use glam::DVec2;

use crate::field::cells::Cells;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::stages::Job;
use crate::field::stages::kept::Kept;
use crate::surface::caustic;
use crate::surface::{Light, Rays};

/// From ray to ray, in cells: at most, where pixels are coarse and light is bent much, and at least for brightness alone.
const COARSEST: f64 = 1.0 / 1.5;
const COARSE: f64 = 1.0 / 3.5;
const FINEST: f64 = 1.0 / 16.0;
/// By how much brightness may change from patch to patch, if that takes no patches below a pixel.
const JUMP: f64 = 0.05;
/// Pixels that light may land beside where it would between rays.
const ASTRAY: f64 = 0.25;
/// What third differences from cell to cell miss of a square's shortest wave.
const MISSED: f64 = 1.5;
/// Rays that a lattice may have.
const MOST_RAYS: f64 = (1 << 22) as f64;
/// What differences from cell to cell may miss of a slope.
const STEEPER: f64 = 2.5;

/// What casting light needs, with what of it the last one made.
#[derive(Debug, Default)]
pub(super) struct Caustic {
    lattice: Kept<(Cells, [Axis; 2]), [Resampling; 4]>,
    slopes: [Vec<f32>; 2],
    between: Between,
    light: Light,
}

/// Rays along one axis: how many, from which to which place (m from the centre, either way).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    count: usize,
    half: f64,
}

impl Axis {
    fn step(self) -> f64 {
        2.0 * self.half / (self.count - 1) as f64
    }

    fn places(self) -> impl Iterator<Item = f64> {
        (0..self.count).map(move |i| self.step() * i as f64 - self.half)
    }
}

impl Caustic {
    /// What became of the light, of that of the screen's own area as 1.
    pub(super) fn light(&self) -> Light {
        self.light
    }

    /// The brightness of every pixel under a surface with this depth (m) in every cell, of which a part is there.
    pub(super) fn cast(
        &mut self,
        job: &Job<'_>,
        cells: &Cells,
        (depth, part): (&[f64], f64),
        values: &mut [f32],
    ) {
        let request = job.request;
        let (width, height) = request.size;
        let pixel = request.plane.size / DVec2::new(width as f64, height as f64);
        let throw = request.liquid.throw();
        let axes = lattice(cells, depth, request.plane.size, pixel, throw * part);
        let around = cells.beyond_walls();
        let [x, y, x_slopes, y_slopes] = self.lattice.update(&(cells.clone(), axes), |made| {
            let values = [0, 1].map(|axis| around.resampling(axis, axes[axis].places()));
            let slopes = [0, 1].map(|axis| around.slopes(axis, axes[axis].places()));
            let ([x, y], [x_slopes, y_slopes]) = (values, slopes);
            *made = [x, y, x_slopes, y_slopes];
        });
        let mirrored = cells.mirrored(depth, part);
        for (slopes, (across, up)) in self.slopes.iter_mut().zip([(x_slopes, y), (x, y_slopes)]) {
            slopes.resize(across.len() * up.len(), 0.0);
            interpolate(&mirrored, around.counts[0], across, up, &mut self.between, slopes);
        }
        let rays = Rays {
            counts: axes.map(|axis| axis.count),
            first: [0, 1].map(|i| (0.5 * request.plane.size[i] - axes[i].half) / pixel[i]),
            step: [0, 1].map(|i| axes[i].step() / pixel[i]),
            slopes: self.slopes.each_ref().map(|slopes| &slopes[..]),
            // Slopes are per cell.
            throw: [0, 1].map(|i| throw / cells.step / pixel[i]),
        };
        let light = caustic::light(&rays, width, values);
        let own = values.len() as f64;
        self.light = Light { sent: light.sent / own, landed: light.landed / own, ..light };
    }
}

/// Rays as far from the plane as light comes from that falls on its screen, and so close that it is known between them where it lands.
fn lattice(cells: &Cells, depth: &[f64], size: DVec2, pixel: DVec2, throw: f64) -> [Axis; 2] {
    let [columns, rows] = cells.counts;
    let per_cell = throw.abs() / cells.step;
    // m that the light of every column and of every row is displaced by across it, and the largest bend of that from cell to cell.
    let (mut reach, mut bend) = ([vec![0.0f64; columns], vec![0.0f64; rows]], 0.0f64);
    for row in 0..rows {
        for column in 0..columns {
            let at = |i: usize, j: usize| depth[j * columns + i];
            let here = at(column, row);
            if column + 1 < columns {
                reach[0][column] = reach[0][column].max((at(column + 1, row) - here).abs());
            }
            if row + 1 < rows {
                reach[1][row] = reach[1][row].max((at(column, row + 1) - here).abs());
            }
            if column + 3 < columns {
                let third = at(column + 3, row) - here - 3.0 * (at(column + 2, row) - at(column + 1, row));
                bend = bend.max(third.abs());
            }
            if row + 3 < rows {
                let third = at(column, row + 3) - here - 3.0 * (at(column, row + 2) - at(column, row + 1));
                bend = bend.max(third.abs());
            }
        }
    }
    let bend = (MISSED * bend * per_cell).max(f64::MIN_POSITIVE);
    let finest_pixel = pixel.min_element();
    let least = finest_pixel.clamp(FINEST * cells.step, COARSE * cells.step);
    let even = (JUMP * cells.step * cells.step / bend).clamp(least, COARSEST * cells.step);
    // Between rays light goes straight, which is off by an eighth of the second difference.
    let straight = cells.step * (8.0 * ASTRAY * finest_pixel / bend).sqrt();
    // A little more sound makes no other lattice.
    let stepped = |step: f64| cells.step * 2f64.powf((2.0 * (step / cells.step).log2()).floor() / 2.0);
    let step = if straight < least { stepped(straight) } else { stepped(even.min(straight)).max(least) };
    let halves = [0, 1].map(|axis| {
        let beyond = |place: f64| place.abs() - size[axis] / 2.0;
        let reaching = cells.places(axis).zip(&reach[axis]).map(|(place, reach)| {
            let beyond = beyond(place) - cells.step;
            if beyond < STEEPER * per_cell * reach { beyond / cells.step + 3.0 } else { 0.0 }
        });
        let margin = reaching.fold(2.0, f64::max).log2().ceil().exp2() * cells.step;
        let wall = cells.counts[axis] as f64 * cells.step / 2.0;
        (size[axis] / 2.0 + margin).min(wall)
    });
    let most = (4.0 * halves[0] * halves[1] / MOST_RAYS).sqrt();
    let step = step.max(most);
    halves.map(|half| Axis { count: (2.0 * half / step).ceil().max(1.0) as usize + 1, half })
}
