//! Potential and radiation force of a bead over a plane: at cells by their partial waves
//! ([`crate::field::partial`]), interpolated to the pixels, and pixel by pixel near the array.
//!
//! Both are quadratic in the sound, and their bandwidth is twice its own.

use std::ops::Range;

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::acoustics::element::Radiator;
use crate::drive::Drive;
use crate::field::cells::Cells;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::partial::{Derivative, Form, Formation, NORMALS, derivatives};
use crate::field::plan::{Costs, Grid, Plan, promised};
use crate::field::quantity::Quantity;
use crate::field::samples::Samples;
use crate::field::slope::shifted;
use crate::field::sound::narrow;
use crate::field::stages::kept::Kept;
use crate::field::stages::probes::{MARGIN, corners, farthest, largest_sum, rounding_of_terms, spread};
use crate::field::stages::request::{By, FieldError, Map, Request, Setting};
use crate::field::stages::work::Work;
use crate::field::vicinity::{LeftOut, Vicinity};
use crate::force::Levitation;
use crate::gauge::Gauge;
use crate::scene::Plane;
use crate::simd::Isa;

/// The samples' part of the tolerance, since derivatives raise what the window lets through; and the finest tolerance of
/// interpolation in f32.
const FINER: f64 = 0.1;
const FINEST: f64 = 1e-6;
/// Distances from the boards, in wavelengths: beyond the first, force and potential have hardly more than two cycles per
/// wavelength; beyond the second, samples give the derivatives of the sound.
const CLEARANCE: f64 = 0.75;
const FAR: f64 = 2.0;
/// Steps along the normal, in wavelengths, and the weights of value, slope and second slope: 3e-6 off.
const STEP: f64 = 1.0 / 64.0;
const STENCILS: [[f64; 5]; NORMALS] = [
    [0.0, 0.0, 1.0, 0.0, 0.0],
    [1.0 / 12.0, -2.0 / 3.0, 0.0, 2.0 / 3.0, -1.0 / 12.0],
    [-1.0 / 12.0, 4.0 / 3.0, -2.5, 4.0 / 3.0, -1.0 / 12.0],
];
/// Error of maps of far-field pistons, whose sound is a wave only near a point.
const OF_PISTONS: f64 = 5e-3;
/// Points per task.
const RUN: usize = 32;
/// Cells per task.
const CELLS: usize = 1024;

/// The inputs of the last map.
#[derive(Debug, Default)]
pub(super) struct OfBead {
    /// Keyed by the order of partial waves, too.
    site: Kept<(Setting, usize), Option<Site>>,
    /// Potential (J) or components of the force (N) at its cells, for a request without size; 0 in unused rows.
    formed: Kept<Request, Vec<Vec<f32>>>,
    between: Between,
    pub(super) work: Work,
}

/// The cells, far enough from the array, and the derivatives of the sound there.
#[derive(Debug)]
struct Site {
    cells: Cells,
    /// Rows of cells that are filled, and those of them that are filled from samples.
    clear: Range<usize>,
    sampled: Range<usize>,
    /// Range along the plane's second axis (m) of interpolated pixels.
    covered: Range<f64>,
    grid: Grid,
    /// From the samples to the cells, across and up, of derivatives of all orders.
    to_cells: [Vec<Resampling>; 2],
    derivatives: Vec<Derivative>,
}

impl Site {
    /// `None` if the whole plane is near the array, or every pixel is to be evaluated.
    fn new(Setting { aperture, plane }: &Setting, order: usize) -> Option<Self> {
        let cells = Cells::new(aperture, plane, 0.0, plane.tolerance)?;
        let costs = Costs::CPU.for_values(cells.count() * (order + 1).pow(2));
        let tolerance = (FINER * cells.plane.tolerance).max(FINEST);
        let grid = Plan::new(aperture, &Plane { tolerance, ..cells.plane.clone() }, costs)?.grid?;
        let ((x, y), half) = (plane.axes()?, cells.plane.size / 2.0);
        let walls = aperture.walls();
        // The distance is linear along a row, so its ends suffice.
        let is_clear = |row: f64, wavelengths: f64| {
            let ends = [-half.x, half.x].map(|end| plane.centre + x * end + y * row);
            let clearance = wavelengths * aperture.wavelength();
            ends.iter().all(|end| walls.iter().all(|(at, normal)| (*end - *at).dot(*normal) > clearance))
        };
        let rows: Vec<_> = cells.places(1).collect();
        let range = |is_in: &dyn Fn(&f64) -> bool| {
            Some(rows.iter().position(is_in)?..rows.iter().rposition(is_in)? + 1)
        };
        let clear = range(&|row| is_clear(*row, CLEARANCE))?;
        let covered = grid.covered.start..=grid.covered.end;
        let sampled = range(&|row| is_clear(*row, FAR) && covered.contains(row)).unwrap_or_default();
        let (first, last) = (clear.start, clear.end - 1);
        let half = plane.size.y / 2.0;
        let start = if first == 0 { -half } else { rows[first] + cells.reach() };
        let end = if last + 1 == rows.len() { half } else { rows[last] - cells.reach() };
        let across = grid.derivatives(0, cells.places(0), order + 1);
        let up = grid.derivatives(1, rows[sampled.clone()].iter().copied(), order + 1);
        Some(Self {
            cells,
            clear,
            sampled,
            covered: start..end,
            grid,
            to_cells: [across, up],
            derivatives: derivatives(order),
        })
    }
}

/// A plane, drives and a bead.
struct Scenery<'a> {
    request: &'a Request,
    levitation: Levitation,
    axes: [DVec3; 2],
}

impl OfBead {
    /// The potential or the length of the force (N) at every pixel; with `exact` each for itself.
    ///
    /// # Errors
    /// An invalid plane.
    pub(super) fn map(
        &mut self,
        request: &Request,
        exact: bool,
        progress: &Gauge,
    ) -> Result<Map, FieldError> {
        let (x, y) = request.plane.axes().ok_or(FieldError::NoPlane)?;
        let Request { aperture, air, bead, drives, .. } = request;
        let levitation = Levitation::in_air(aperture, (air, bead), drives, 0.0);
        let order = levitation.sphere.order();
        let scenery = Scenery { request, levitation, axes: [x, y] };
        let tolerance = if exact { 0.0 } else { request.plane.tolerance };
        let setting = Setting::new(aperture, Plane { tolerance, ..request.plane.clone() });
        let site = self.site.try_update(&(setting.clone(), order), |site| {
            self.work.plan += 1;
            Plan::new(aperture, &setting.plane, Costs::CPU).ok_or(FieldError::NoPlane)?;
            *site = Site::new(&setting, order);
            Ok::<_, FieldError>(())
        })?;
        if let Some(site) = site {
            let key = Request { size: (0, 0), part: 1.0, ..request.clone() };
            let between = &mut self.between;
            let formed = self.formed.update(&key, |formed| {
                self.work.forming += 1;
                *formed = scenery.formed(site, between);
            });
            self.work.interpolation += 1;
            let map = scenery.interpolated(site, formed, (&mut self.between, progress));
            let floor = match aperture.element.radiator() {
                Radiator::Monopole | Radiator::Disk(_) => 0.0,
                Radiator::Piston(_) => OF_PISTONS,
            };
            if map.error <= promised(tolerance).max(floor) {
                return Ok(map);
            }
        }
        self.work.forming += 1;
        Ok(scenery.direct(progress))
    }

    pub(super) fn forget(&mut self) {
        *self = Self { work: self.work, ..Self::default() };
    }
}

impl Scenery<'_> {
    /// m from the plane's centre, of a pixel's row or column.
    fn along(&self, axis: usize, index: usize) -> f64 {
        let (width, height) = self.request.size;
        self.request.plane.size[axis] * ((index as f64 + 0.5) / [width, height][axis] as f64 - 0.5)
    }

    fn point(&self, x: f64, y: f64) -> DVec3 {
        self.request.plane.centre + self.axes[0] * x + self.axes[1] * y
    }

    fn pixel(&self, pixel: usize) -> DVec3 {
        let width = self.request.size.0;
        self.point(self.along(0, pixel % width), self.along(1, pixel / width))
    }

    /// Potential or force at the cells that are clear of the array.
    fn formed(&self, site: &Site, between: &mut Between) -> Vec<Vec<f32>> {
        let Site { cells, clear, sampled, grid, to_cells: [across, up], .. } = site;
        let Request { aperture, drives, .. } = self.request;
        let formation = Formation::new(&self.levitation.sphere, aperture.element.wavenumber);
        let is_force = self.request.quantity == Quantity::Force;
        let count = sampled.len() * cells.counts[0];
        let (mut potential, mut force) =
            (vec![0.0f32; count], vec![vec![0.0f32; count * usize::from(is_force)]; 3]);
        let mut at_cells = vec![vec![Complex32::ZERO; count]; site.derivatives.len()];
        for drive in drives.iter().filter(|_| count > 0) {
            let normals = self.normals(drive, grid);
            for (Derivative { orders: [x, y], normal }, to) in site.derivatives.iter().zip(&mut at_cells) {
                let (columns, samples) = (grid.samples.columns.len(), &normals[*normal]);
                interpolate(samples, columns, &across[*x], &up[*y], between, to);
            }
            let [x, y, normal] = &mut force[..] else { unreachable!("three axes") };
            let part = 1.0 / drives.len() as f32;
            let runs = (0..count).step_by(CELLS).map(|start| start..count.min(start + CELLS));
            let forces = x.chunks_mut(CELLS).zip(y.chunks_mut(CELLS)).zip(normal.chunks_mut(CELLS));
            let mut forces = forces.map(|((x, y), normal)| [x, y, normal]);
            let jobs: Vec<_> = runs
                .zip(potential.chunks_mut(CELLS))
                .map(|(points, potential)| {
                    let force = forces.next().unwrap_or_default();
                    Form { formation: &formation, derivatives: &at_cells, points, part, potential, force }
                })
                .collect();
            jobs.into_par_iter().for_each(|form| Isa::best().run(form));
        }
        let places = sampled.start * cells.counts[0]..sampled.end * cells.counts[0];
        let spread = |own: Vec<f32>| {
            let mut values = vec![0.0; cells.count()];
            values[places.clone()].copy_from_slice(&own);
            values
        };
        let mut formed: Vec<_> =
            if is_force { force } else { vec![potential] }.into_iter().map(spread).collect();
        // The others are too near to the array.
        let [columns, rows] = [0, 1].map(|axis| cells.places(axis).collect::<Vec<_>>());
        let near = clear.clone().filter(|row| !sampled.contains(row));
        let near: Vec<_> = near.flat_map(|row| (0..columns.len()).map(move |column| (row, column))).collect();
        let axes = [self.axes[0], self.axes[1], self.axes[0].cross(self.axes[1])];
        let value = |&(row, column): &(usize, usize)| {
            let point = self.point(columns[column], rows[row]);
            match is_force {
                true => {
                    let force = self.levitation.force(point);
                    axes.map(|axis| force.dot(axis)).to_vec()
                }
                false => vec![self.levitation.potential(point)],
            }
        };
        let values: Vec<_> = near.par_iter().map(value).collect();
        for (&(row, column), values) in near.iter().zip(values) {
            for (formed, value) in formed.iter_mut().zip(values) {
                formed[row * columns.len() + column] = value as f32;
            }
        }
        formed
    }

    /// The pressure of a drive at samples, and its first and second slope along the normal, by differences in f64.
    fn normals(&self, drive: &Drive, grid: &Grid) -> [Vec<Complex32>; NORMALS] {
        let Request { aperture, .. } = self.request;
        let step = STEP * aperture.wavelength();
        let normal = self.axes[0].cross(self.axes[1]);
        let played = drive.excitation(&aperture.driven);
        let at = |place: f64| {
            let samples = shifted(&grid.samples, normal * (place * step));
            let points: Vec<_> = (0..samples.len()).map(|i| samples.point(i)).collect();
            aperture.pressures(&points, &played)
        };
        let planes = [-2.0, -1.0, 0.0, 1.0, 2.0].map(at);
        [0, 1, 2].map(|order: usize| {
            let unit = step.powi(order as i32);
            let weights = STENCILS[order].map(|weight| weight / unit);
            let value =
                |i: usize| -> Complex64 { planes.iter().zip(weights).map(|(p, weight)| p[i] * weight).sum() };
            (0..grid.samples.len()).map(|i| narrow(value(i))).collect()
        })
    }

    fn interpolated(
        &self,
        site: &Site,
        formed: &[Vec<f32>],
        (between, progress): (&mut Between, &Gauge),
    ) -> Map {
        let Site { cells, covered, .. } = site;
        let (width, height) = self.request.size;
        let across = cells.resampling(0, (0..width).map(|i| self.along(0, i)));
        let up = cells.resampling(1, (0..height).map(|j| self.along(1, j)));
        let mut values = vec![0.0f32; width * height];
        let part = self.request.part;
        match formed {
            [potential] => {
                interpolate(potential, cells.counts[0], &across, &up, between, &mut values);
                values.iter_mut().for_each(|value| *value *= part as f32);
            }
            components => {
                let mut component = values.clone();
                for own in components {
                    interpolate(own, cells.counts[0], &across, &up, between, &mut component);
                    values.iter_mut().zip(&component).for_each(|(sum, own)| *sum += own * own);
                }
                values.iter_mut().for_each(|value| *value = part as f32 * value.sqrt());
            }
        }
        let near = (0..height).filter(|&row| !covered.contains(&self.along(1, row)));
        let near: Vec<_> = near.flat_map(|row| row * width..(row + 1) * width).collect();
        let points: Vec<_> = near.iter().map(|&pixel| self.pixel(pixel)).collect();
        for (&pixel, value) in near.iter().zip(self.exact(&points, progress)) {
            values[pixel] = (part * value) as f32;
        }
        let step = cells.step * 1e3;
        let how = format!(
            "partial waves at {} x {} cells of {step:.2} mm, and at {} pixels",
            cells.counts[0],
            cells.counts[1],
            near.len()
        );
        let evaluated = cells.count() + near.len();
        let map = Map { width, height, values, evaluated, by: By::CpuInF64, how, ..Map::default() };
        let map = self.measured(map);
        Map { error: if map.peak > 0.0 { self.error(&map.values, map.peak) } else { 0.0 }, ..map }
    }

    fn direct(&self, progress: &Gauge) -> Map {
        let (width, height) = self.request.size;
        let points: Vec<_> = (0..width * height).map(|pixel| self.pixel(pixel)).collect();
        let narrow = |value: f64| (self.request.part * value) as f32;
        let values: Vec<_> = self.exact(&points, progress).into_iter().map(narrow).collect();
        let how = "partial waves in f64 at every pixel".to_owned();
        let (evaluated, by) = (values.len(), By::Reference);
        self.measured(Map { width, height, values, evaluated, by, how, ..Map::default() })
    }

    /// The map with the largest of its values.
    fn measured(&self, map: Map) -> Map {
        let Request { aperture, plane, size: (width, height), .. } = self.request;
        let pixels = Samples::on_plane(plane, *width, *height);
        let left_out = pixels.map(|pixels| Vicinity::new(aperture).of(&pixels)).unwrap_or_default();
        let [peak, others] = left_out.largest(&map.values);
        let (loudest, near, rounding) = (peak.max(others), left_out.near, self.rounding(&left_out));
        if f64::from(peak) <= rounding {
            return Map { peak: 0.0, loudest, near, rounding, ..map };
        }
        Map { peak, loudest, near, ..map }
    }

    /// A bound of the rounding of forces whose terms may cancel.
    fn rounding(&self, left_out: &LeftOut) -> f64 {
        let Request { aperture, plane, drives, size, part, .. } = self.request;
        let probed = spread(size.0 * size.1).chain(corners(*size)).filter(|&pixel| !left_out.contains(pixel));
        let transfer = aperture.transfer(&probed.map(|pixel| self.pixel(pixel)).collect::<Vec<_>>());
        let excitations: Vec<_> = drives.iter().map(|drive| drive.excitation(&aperture.driven)).collect();
        let loudest = largest_sum(transfer.rows(), &excitations);
        let k = aperture.element.wavenumber;
        let [potential, force] = self.levitation.sphere.bounds();
        let bound = if self.request.quantity == Quantity::Force { force } else { potential };
        let largest = bound * loudest * loudest;
        2.0 * part * rounding_of_terms(k * farthest(aperture, plane)) * largest
    }

    /// An estimate of the largest deviation of all pixels, relative to the peak or to a larger value itself.
    fn error(&self, values: &[f32], peak: f32) -> f64 {
        let pixels: Vec<_> = spread(values.len()).chain(corners(self.request.size)).collect();
        let points: Vec<_> = pixels.iter().map(|&pixel| self.pixel(pixel)).collect();
        let exact = self.exact(&points, &Gauge::default());
        let off = pixels.iter().zip(exact).map(|(&pixel, exact)| {
            let expected = self.request.part * exact;
            match (expected - f64::from(values[pixel])).abs() {
                0.0 => 0.0,
                off => off / f64::from(peak).max(if peak > 0.0 { expected.abs() } else { 0.0 }),
            }
        });
        MARGIN * off.fold(0.0, f64::max)
    }

    /// Potential or length of the force at points, in f64.
    fn exact(&self, points: &[DVec3], progress: &Gauge) -> Vec<f64> {
        let done = progress.count(points.len().div_ceil(RUN));
        let of_run = |points: &[DVec3]| -> Vec<f64> {
            let value = |&point: &DVec3| match self.request.quantity == Quantity::Force {
                true => self.levitation.force(point).length(),
                false => self.levitation.potential(point),
            };
            let values = points.iter().map(value).collect();
            done.add();
            values
        };
        points.par_chunks(RUN).flat_map_iter(of_run).collect()
    }
}
