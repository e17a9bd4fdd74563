//! The radiation force on a bead over a plane: in f64 at cells, with components interpolated to the pixels, and
//! pixel by pixel near the array.
//!
//! The force needs second derivatives of the sound in all directions, which samples on a plane do not contain.
//! Closed forms ([`crate::acoustics::Emitters`]) give them at the cells.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::field::cells::Cells;
use crate::field::interpolation::{Between, interpolate};
use crate::field::plan::{Costs, Plan, promised};
use crate::field::samples::Samples;
use crate::field::stages::kept::Kept;
use crate::field::stages::probes::{MARGIN, corners, farthest, largest_sum, rounding_of_terms, spread};
use crate::field::stages::request::{By, FieldError, Map, Request, Setting};
use crate::field::stages::work::Work;
use crate::field::vicinity::{LeftOut, Vicinity};
use crate::force::Levitation;
use crate::gauge::Gauge;
use crate::scene::Plane;

/// Distance from the boards, in wavelengths, beyond which sound has hardly more than one cycle per wavelength.
const CLEARANCE: f64 = 0.75;
/// Points per task.
const RUN: usize = 32;

/// The inputs of the last map.
#[derive(Debug, Default)]
pub(super) struct OfBead {
    site: Kept<Setting, Option<Site>>,
    /// The force (N) at its cells, for a request without size; 0 in unused rows.
    components: Kept<Request, [Vec<f32>; 3]>,
    between: Between,
    pub(super) work: Work,
}

/// The cells of the force, far enough from the array.
#[derive(Debug)]
struct Site {
    cells: Cells,
    /// Filled rows of cells.
    clear: Range<usize>,
    /// Range along the plane's second axis (m) of interpolated pixels.
    covered: Range<f64>,
}

impl Site {
    /// `None` if the whole plane is near the array, or every pixel is to be evaluated.
    fn new(Setting { aperture, plane }: &Setting) -> Option<Self> {
        let cells = Cells::new(aperture, plane, 0.0, plane.tolerance)?;
        let ((x, y), half) = (plane.axes()?, cells.plane.size / 2.0);
        let (walls, clearance) = (aperture.walls(), CLEARANCE * aperture.wavelength());
        // The distance is linear along a row, so its ends suffice.
        let is_clear = |row: &f64| {
            let ends = [-half.x, half.x].map(|end| plane.centre + x * end + y * *row);
            let is_clear =
                |end: &DVec3| walls.iter().all(|(at, normal)| (*end - *at).dot(*normal) > clearance);
            ends.iter().all(is_clear)
        };
        let rows: Vec<_> = cells.places(1).collect();
        let (first, last) = (rows.iter().position(is_clear)?, rows.iter().rposition(is_clear)?);
        let (clear, reach) = (rows[first]..rows[last], cells.reach());
        let start = if first == 0 { -half.y } else { clear.start + reach };
        let end = if last + 1 == rows.len() { half.y } else { clear.end - reach };
        Some(Self { cells, clear: first..last + 1, covered: start..end })
    }
}

/// A plane, drives and a bead.
struct Scenery<'a> {
    request: &'a Request,
    levitation: Levitation,
    axes: [DVec3; 2],
}

impl OfBead {
    /// The length of the force (N) at every pixel; with `exact` each for itself.
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
        let scenery = Scenery { request, levitation, axes: [x, y] };
        let tolerance = if exact { 0.0 } else { request.plane.tolerance };
        let setting = Setting::new(aperture, Plane { tolerance, ..request.plane.clone() });
        let site = self.site.try_update(&setting, |site| {
            self.work.plan += 1;
            Plan::new(aperture, &setting.plane, Costs::CPU).ok_or(FieldError::NoPlane)?;
            *site = Site::new(&setting);
            Ok::<_, FieldError>(())
        })?;
        if let Some(site) = site {
            let key = Request { size: (0, 0), part: 1.0, ..request.clone() };
            let components = self.components.update(&key, |components| {
                self.work.forming += 1;
                *components = scenery.components(site, progress);
            });
            self.work.interpolation += 1;
            let map = scenery.interpolated(site, components, &mut self.between);
            if map.error <= promised(tolerance) {
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

    /// The force at the cells that are clear of the array.
    fn components(&self, Site { cells, clear, .. }: &Site, progress: &Gauge) -> [Vec<f32>; 3] {
        let [columns, rows] = [0, 1].map(|axis| cells.places(axis).collect::<Vec<_>>());
        let places = clear.start * columns.len()..clear.end * columns.len();
        let point = |i: usize| self.point(columns[i % columns.len()], rows[i / columns.len()]);
        let points: Vec<_> = places.clone().map(point).collect();
        let forces = self.forces(&points, progress);
        [0, 1, 2].map(|axis| {
            let mut values = vec![0.0; cells.count()];
            values[places.clone()]
                .iter_mut()
                .zip(&forces)
                .for_each(|(value, force)| *value = force[axis] as f32);
            values
        })
    }

    fn interpolated(&self, site: &Site, components: &[Vec<f32>; 3], between: &mut Between) -> Map {
        let Site { cells, covered, .. } = site;
        let (width, height) = self.request.size;
        let across = cells.resampling(0, (0..width).map(|i| self.along(0, i)));
        let up = cells.resampling(1, (0..height).map(|j| self.along(1, j)));
        let mut values = vec![0.0f32; width * height];
        let mut component = values.clone();
        for own in components {
            interpolate(own, cells.counts[0], &across, &up, between, &mut component);
            values.iter_mut().zip(&component).for_each(|(sum, own)| *sum += own * own);
        }
        let part = self.request.part;
        values.iter_mut().for_each(|value| *value = part as f32 * value.sqrt());
        let near = (0..height).filter(|&row| !covered.contains(&self.along(1, row)));
        let near: Vec<_> = near.flat_map(|row| row * width..(row + 1) * width).collect();
        let points: Vec<_> = near.iter().map(|&pixel| self.pixel(pixel)).collect();
        for (&pixel, force) in near.iter().zip(self.forces(&points, &Gauge::default())) {
            values[pixel] = (part * force.length()) as f32;
        }
        let step = cells.step * 1e3;
        let how = format!(
            "forces in f64 at {} x {} cells of {step:.2} mm, and at {} pixels",
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
        let length = |force: &DVec3| (self.request.part * force.length()) as f32;
        let values: Vec<_> = self.forces(&points, progress).iter().map(length).collect();
        let how = "forces in f64 at every pixel".to_owned();
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
        let [of_slope, of_curvature] = self.levitation.sphere.coupling().map(|factor| factor.norm());
        let largest = (of_slope * k + 3.0 * of_curvature * k.powi(3)) * loudest * loudest;
        2.0 * part * rounding_of_terms(k * farthest(aperture, plane)) * largest
    }

    /// An estimate of the largest deviation of all pixels, relative to the peak or to a larger value itself.
    fn error(&self, values: &[f32], peak: f32) -> f64 {
        let pixels: Vec<_> = spread(values.len()).chain(corners(self.request.size)).collect();
        let points: Vec<_> = pixels.iter().map(|&pixel| self.pixel(pixel)).collect();
        let forces = self.forces(&points, &Gauge::default());
        let off = pixels.iter().zip(forces).map(|(&pixel, force)| {
            let expected = self.request.part * force.length();
            match (expected - f64::from(values[pixel])).abs() {
                0.0 => 0.0,
                off => off / f64::from(peak).max(if peak > 0.0 { expected } else { 0.0 }),
            }
        });
        MARGIN * off.fold(0.0, f64::max)
    }

    fn forces(&self, points: &[DVec3], progress: &Gauge) -> Vec<DVec3> {
        let done = progress.count(points.len().div_ceil(RUN));
        let of_run = |points: &[DVec3]| -> Vec<DVec3> {
            let forces = points.iter().map(|&point| self.levitation.force(point)).collect();
            done.add();
            forces
        };
        points.par_chunks(RUN).flat_map_iter(of_run).collect()
    }
}
