//! Potential and radiation force of a bead over a plane: at cells by their partial waves
//! ([`crate::field::partial`]), interpolated to the pixels.
//!
//! Both are quadratic in the sound, and their bandwidth is twice its own. Near the array, samples give no derivatives
//! of the sound: there partial waves are integrals over small spheres, whose points are samples of the evaluator of
//! other maps. Where the window from cells to pixels would reach too near, rows of pixels are interpolated along
//! themselves; still nearer, every pixel has its sphere.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex32;
use rayon::prelude::*;

use crate::acoustics::PartialWaves;
use crate::acoustics::element::Radiator;
use crate::drive::Drive;
use crate::field::cells::Cells;
use crate::field::evaluator::unchecked;
use crate::field::gpu::Gpu;
use crate::field::gpu_report::GpuError;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::partial::{Derivative, Form, Formation, NORMALS, derivatives};
use crate::field::plan::{Costs, Grid, Plan, promised};
use crate::field::quantity::Quantity;
use crate::field::samples::Samples;
use crate::field::slope::shifted;
use crate::field::sound::narrow;
use crate::field::stages::kept::Kept;
use crate::field::stages::nodes::{self, Nodes, clear_of};
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
/// Steps along the normal, in wavelengths, and the weights of value, slope and second slope: 2e-6 off, as far as f32
/// rounds them.
const STEP: f64 = 1.0 / 24.0;
const STENCILS: [[f64; 7]; NORMALS] = [
    [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    [-1.0 / 60.0, 3.0 / 20.0, -0.75, 0.0, 0.75, -3.0 / 20.0, 1.0 / 60.0],
    [1.0 / 90.0, -3.0 / 20.0, 1.5, -49.0 / 18.0, 1.5, -3.0 / 20.0, 1.0 / 90.0],
];
/// Error of maps among bodies, whose scattered sound is not exact either.
const OF_BODIES: f64 = 5e-3;
/// Error of maps of far-field pistons, whose sound is a wave only near a point.
const OF_PISTONS: f64 = 5e-3;
/// The finest tolerance of samples in f32.
const FINEST_IN_F32: f64 = 5e-4;
/// Cells per task.
const CELLS: usize = 1024;
/// Places whose spheres are in memory at the same time.
const PLACES: usize = 1 << 14;

/// The sound of a drive at samples (Pa, peak), in f64 if `true`.
type Sampler<'a> = dyn Fn(&Drive, &Samples, bool) -> Result<Vec<Complex32>, GpuError> + 'a;

/// The inputs of the last map.
#[derive(Debug, Default)]
pub(super) struct OfBead {
    /// Keyed by the order of partial waves, too.
    site: Kept<(Setting, usize), Option<Site>>,
    /// Potential (J) or components of the force (N) at its cells, for a request without size, from samples in f64 or
    /// not; 0 in unused rows.
    formed: Kept<(Request, bool), Vec<Vec<f32>>>,
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
    /// Ranges along the plane's second axis (m): of rows that are interpolated along themselves, and among them of pixels
    /// that are interpolated from cells.
    open: Range<f64>,
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
        let within = |reach: f64| {
            let start = if first == 0 { -half } else { rows[first] + reach };
            start..if last + 1 == rows.len() { half } else { rows[last] - reach }
        };
        let across = grid.derivatives(0, cells.places(0), order + 1);
        let up = grid.derivatives(1, rows[sampled.clone()].iter().copied(), order + 1);
        Some(Self {
            open: within(0.0),
            covered: within(cells.reach()),
            clear,
            sampled,
            cells,
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
    /// The plane's axes and its normal.
    axes: [DVec3; 3],
    sample: &'a Sampler<'a>,
    by: By,
}

impl OfBead {
    /// The potential or the length of the force (N) at every pixel; with `exact` each for itself, in f64.
    ///
    /// # Errors
    /// An invalid plane, or a failing GPU.
    pub(super) fn map(
        &mut self,
        request: &Request,
        exact: bool,
        gpu: Option<&Gpu>,
        progress: &Gauge,
    ) -> Result<Map, FieldError> {
        let (x, y) = request.plane.axes().ok_or(FieldError::NoPlane)?;
        let Request { aperture, air, bead, drives, .. } = request;
        let levitation = Levitation::in_air(aperture, (air, bead), drives, 0.0);
        let order = levitation.sphere.order();
        let sample = |drive: &Drive, samples: &Samples, double: bool| match double {
            true => {
                let points: Vec<_> = (0..samples.len()).map(|i| samples.point(i)).collect();
                let played = drive.excitation(&aperture.driven);
                Ok(aperture.pressures(&points, &played).into_iter().map(narrow).collect())
            }
            false => unchecked(gpu, aperture, drive, samples),
        };
        let by = if gpu.is_some() { By::Gpu } else { By::Cpu };
        let scenery = Scenery { request, levitation, axes: [x, y, x.cross(y)], sample: &sample, by };
        let tolerance = if exact { 0.0 } else { request.plane.tolerance };
        let setting = Setting::new(aperture, Plane { tolerance, ..request.plane.clone() });
        let is_open = aperture.bodies.is_empty();
        let site = self.site.try_update(&(setting.clone(), order), |site| {
            self.work.plan += 1;
            Plan::new(aperture, &setting.plane, Costs::CPU).ok_or(FieldError::NoPlane)?;
            // Samples would reach across the surfaces of bodies.
            *site = if is_open { Site::new(&setting, order) } else { None };
            Ok::<_, FieldError>(())
        })?;
        let floor = match aperture.element.radiator() {
            Radiator::Monopole | Radiator::Disk(_) if is_open => 0.0,
            Radiator::Monopole | Radiator::Disk(_) => OF_BODIES,
            Radiator::Piston(_) | Radiator::Rectangle(_) | Radiator::Cosine(_) | Radiator::Measured => {
                OF_PISTONS
            }
        };
        let is_coarse = tolerance >= FINEST_IN_F32;
        for double in [false, true].into_iter().filter(|double| tolerance > 0.0 && (is_coarse || *double)) {
            let map = match site {
                Some(site) => {
                    let key = (Request { size: (0, 0), part: 1.0, ..request.clone() }, double);
                    let between = &mut self.between;
                    let formed = self.formed.try_update(&key, |formed| {
                        self.work.forming += 1;
                        *formed = scenery.formed(site, double, (between, progress))?;
                        Ok::<_, FieldError>(())
                    })?;
                    self.work.interpolation += 1;
                    scenery.interpolated(site, formed, double, (&mut self.between, progress))?
                }
                None => {
                    self.work.forming += 1;
                    match is_open {
                        true => scenery.on_spheres(double, progress)?,
                        false => scenery.among_bodies(double, (&mut self.between, progress))?,
                    }
                }
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

    fn pixel(&self, pixel: usize) -> DVec3 {
        let (width, [x, y, _]) = (self.request.size.0, self.axes);
        self.request.plane.centre + x * self.along(0, pixel % width) + y * self.along(1, pixel / width)
    }

    /// The places of columns and rows, in m from the plane's centre.
    fn lattice(
        &self,
        columns: impl IntoIterator<Item = f64>,
        rows: impl IntoIterator<Item = f64>,
    ) -> Samples {
        let ([x, y, _], centre) = (self.axes, self.request.plane.centre);
        Samples {
            columns: columns.into_iter().map(|place| centre + x * place).collect(),
            rows: rows.into_iter().map(|place| y * place).collect(),
        }
    }

    /// Potential or force at the cells that are clear of the array.
    fn formed(
        &self,
        site: &Site,
        double: bool,
        (between, progress): (&mut Between, &Gauge),
    ) -> Result<Vec<Vec<f32>>, FieldError> {
        let Site { cells, clear, sampled, grid, to_cells: [across, up], .. } = site;
        let Request { aperture, drives, .. } = self.request;
        let width = cells.counts[0];
        let places = |rows: &Range<usize>| rows.start * width..rows.end * width;
        let mut formed = vec![vec![0.0f32; cells.count()]; self.components()];
        if !sampled.is_empty() {
            let formation = Formation::new(&self.levitation.sphere, aperture.element.wavenumber);
            let mut at_cells = vec![vec![Complex32::ZERO; places(sampled).len()]; site.derivatives.len()];
            for drive in drives.iter() {
                let normals = self.normals(drive, grid, double)?;
                for (Derivative { orders: [x, y], normal }, to) in site.derivatives.iter().zip(&mut at_cells)
                {
                    let (columns, samples) = (grid.samples.columns.len(), &normals[*normal]);
                    interpolate(samples, columns, &across[*x], &up[*y], between, to);
                }
                self.add(&formation, &at_cells, formed.iter_mut().map(|own| &mut own[places(sampled)]));
            }
        }
        // The others are too near to the array for samples.
        let rows: Vec<_> = cells.places(1).collect();
        let near = match sampled.is_empty() {
            true => [clear.clone(), 0..0],
            false => [clear.start..sampled.start, sampled.end..clear.end],
        };
        for near in near.into_iter().filter(|near| !near.is_empty()) {
            let lattice = self.lattice(cells.places(0), rows[near.clone()].iter().copied());
            let own = self.around(&lattice, double, &progress.share(1))?;
            for (to, own) in formed.iter_mut().zip(own) {
                to[places(&near)].copy_from_slice(&own);
            }
        }
        Ok(formed)
    }

    /// One for the potential; the force has a component along each of the plane's axes and its normal.
    fn components(&self) -> usize {
        if self.request.quantity == Quantity::Force { 3 } else { 1 }
    }

    /// Adds a drive's part of potential or force to sums, from values that a formation begins with.
    fn add<'a>(
        &self,
        formation: &Formation,
        given: &[Vec<Complex32>],
        to: impl Iterator<Item = &'a mut [f32]>,
    ) {
        let part = 1.0 / self.request.drives.len() as f32;
        let mut to: Vec<_> = to.collect();
        let count = given[0].len();
        // A force has its potential beside it, which nothing shows.
        let mut unused = vec![0.0; if to.len() == 1 { 0 } else { count }];
        let (potential, mut forces) = match &mut to[..] {
            [potential] => (&mut **potential, Vec::new()),
            forces => (&mut unused[..], forces.iter_mut().map(|axis| axis.chunks_mut(CELLS)).collect()),
        };
        let runs = (0..count).step_by(CELLS).map(|start| start..count.min(start + CELLS));
        let jobs: Vec<_> = runs
            .zip(potential.chunks_mut(CELLS))
            .map(|(points, potential)| {
                let mut forces = forces.iter_mut().map(|axis| axis.next().unwrap_or_default());
                let force = [(); 3].map(|()| forces.next().unwrap_or_default());
                Form { formation, given, points, part, potential, force }
            })
            .collect();
        jobs.into_par_iter().for_each(|form| Isa::best().run(form));
    }

    /// Potential or force at a lattice, from the sound on a sphere about each of its places.
    fn around(&self, lattice: &Samples, double: bool, progress: &Gauge) -> Result<Vec<Vec<f32>>, FieldError> {
        let Request { aperture, drives, .. } = self.request;
        let (sphere, [x, y, normal]) = (&self.levitation.sphere, self.axes);
        let offsets = PartialWaves::points(sphere.order(), (DVec3::ZERO, sphere.shell()));
        let formation = Formation::on_spheres(sphere, aperture.element.wavenumber);
        let mut formed = vec![vec![0.0f32; lattice.len()]; self.components()];
        let together = (PLACES / lattice.columns.len().max(1)).max(1);
        let done = progress.count(lattice.rows.len().div_ceil(together) * drives.len());
        for first in (0..lattice.rows.len()).step_by(together) {
            let rows = first..lattice.rows.len().min(first + together);
            let places = rows.start * lattice.columns.len()..rows.end * lattice.columns.len();
            let band = Samples { columns: lattice.columns.clone(), rows: lattice.rows[rows].to_vec() };
            for drive in drives.iter() {
                if progress.is_cancelled() {
                    return Err(FieldError::Cancelled);
                }
                let at = |way: &DVec3| {
                    (self.sample)(drive, &shifted(&band, x * way.x + y * way.y + normal * way.z), double)
                };
                let given = offsets.iter().map(at).collect::<Result<Vec<_>, _>>()?;
                self.add(&formation, &given, formed.iter_mut().map(|own| &mut own[places.clone()]));
                done.add();
            }
        }
        if !aperture.bodies.is_empty() {
            let levitation = &self.levitation;
            let touches = |place: &usize| levitation.touches(lattice.point(*place));
            for place in (0..lattice.len()).into_par_iter().filter(touches).collect::<Vec<_>>() {
                formed.iter_mut().for_each(|own| own[place] = f32::NAN);
            }
        }
        Ok(formed)
    }

    /// The pressure of a drive at samples, and its first and second slope along the normal, by differences.
    fn normals(
        &self,
        drive: &Drive,
        grid: &Grid,
        double: bool,
    ) -> Result<[Vec<Complex32>; NORMALS], GpuError> {
        let step = STEP * self.request.aperture.wavelength();
        let at = |place: usize| {
            let offset = self.axes[2] * ((place as f64 - 3.0) * step);
            (self.sample)(drive, &shifted(&grid.samples, offset), double)
        };
        let planes = (0..STENCILS[0].len()).map(at).collect::<Result<Vec<_>, _>>()?;
        Ok([0, 1, 2].map(|order: usize| {
            let weights = STENCILS[order].map(|weight| (weight / step.powi(order as i32)) as f32);
            let value = |i: usize| planes.iter().zip(weights).map(|(p, weight)| p[i] * weight).sum();
            (0..grid.samples.len()).map(value).collect()
        }))
    }

    fn interpolated(
        &self,
        site: &Site,
        formed: &[Vec<f32>],
        double: bool,
        (between, progress): (&mut Between, &Gauge),
    ) -> Result<Map, FieldError> {
        let Site { cells, open, covered, .. } = site;
        let (width, height) = self.request.size;
        let across = cells.resampling(0, (0..width).map(|i| self.along(0, i)));
        let up = cells.resampling(1, (0..height).map(|j| self.along(1, j)));
        let mut values = vec![0.0f32; width * height];
        let mut component = vec![0.0f32; width * height];
        let mut gather = |formed: &[Vec<f32>], columns: usize, up: &Resampling, values: &mut [f32]| {
            let component = &mut component[..values.len()];
            values.fill(0.0);
            for own in formed {
                interpolate(own, columns, &across, up, between, component);
                values.iter_mut().zip(&*component).for_each(|(sum, own)| *sum += own * own);
            }
            // A potential has its sign.
            match formed {
                [_] => values.copy_from_slice(component),
                _ => values.iter_mut().for_each(|value| *value = value.sqrt()),
            }
        };
        gather(formed, cells.counts[0], &up, &mut values);
        let runs = |is_in: &dyn Fn(f64) -> bool| {
            let rows: Vec<_> = (0..height).filter(|&row| is_in(self.along(1, row))).collect();
            rows.chunk_by(|a, b| a + 1 == *b).map(|run| run[0]..run[run.len() - 1] + 1).collect::<Vec<_>>()
        };
        let mut evaluated = cells.count();
        let rows_of = |rows: &Range<usize>| rows.clone().map(|row| self.along(1, row));
        let beside = runs(&|row| open.contains(&row) && !covered.contains(&row));
        let nearest = runs(&|row| !open.contains(&row));
        let all: usize = beside.iter().chain(&nearest).map(Range::len).sum();
        let mut done = 0;
        for rows in beside {
            let lattice = self.lattice(cells.places(0), rows_of(&rows));
            let own = self.around(&lattice, double, &progress.part(done..done + rows.len(), all))?;
            (evaluated, done) = (evaluated + lattice.len(), done + rows.len());
            gather(
                &own,
                cells.counts[0],
                &itself(rows.len()),
                &mut values[rows.start * width..rows.end * width],
            );
        }
        for rows in nearest {
            let lattice = self.lattice((0..width).map(|i| self.along(0, i)), rows_of(&rows));
            let own = self.around(&lattice, double, &progress.part(done..done + rows.len(), all))?;
            (evaluated, done) = (evaluated + lattice.len(), done + rows.len());
            values[rows.start * width..rows.end * width].copy_from_slice(&lengths(own));
        }
        let step = cells.step * 1e3;
        let [columns, rows] = cells.counts;
        let others = evaluated - cells.count();
        let how =
            format!("partial waves at {columns} x {rows} cells of {step:.2} mm, and at {others} places");
        Ok(self.map(values, evaluated, how, if double { By::CpuInF64 } else { self.by }))
    }

    /// From nodes clear of bodies and boards, where pixels are more, and from spheres of their own beside these. A bead that
    /// touches a body has no force.
    fn among_bodies(
        &self,
        double: bool,
        (between, progress): (&mut Between, &Gauge),
    ) -> Result<Map, FieldError> {
        let Request { aperture, plane, size, .. } = self.request;
        // Squares have twice the wavenumber.
        let step = nodes::step(plane.tolerance.max(FINEST), 2.0 * aperture.element.wavenumber);
        let Some(nodes) = Nodes::new((plane, self.axes), *size, [0..size.0, 0..size.1], step) else {
            return self.on_spheres(double, progress);
        };
        let (walls, clearance) = (aperture.walls(), CLEARANCE * aperture.wavelength());
        let is_beside = |node: usize| {
            let at = nodes.point(node);
            walls.iter().any(|(wall, normal)| (at - *wall).dot(*normal) <= clearance)
                || aperture.bodies.contains(at)
        };
        let mut is_beside: Vec<_> = (0..nodes.count()).into_par_iter().map(is_beside).collect();
        let clear: Vec<_> = (0..nodes.count()).filter(|node| !is_beside[*node]).collect();
        let all = nodes.count();
        let at_nodes = |node: &usize| nodes.point(*node);
        let own = self.at_places(&clear, at_nodes, double, &progress.part(0..clear.len(), all))?;
        let mut formed = vec![vec![0.0f32; all]; own.len()];
        for (to, own) in formed.iter_mut().zip(own) {
            for (node, value) in clear.iter().zip(own) {
                is_beside[*node] |= value.is_nan();
                to[*node] = if value.is_nan() { 0.0 } else { value };
            }
        }
        let is_open: Vec<_> = is_beside.iter().map(|is| !is).collect();
        let is_clear = clear_of(&is_open, nodes.counts[0], [&nodes.across, &nodes.up]);
        let is_direct: Vec<_> = is_clear.iter().map(|is| !is).collect();
        let direct: Vec<_> = (0..is_direct.len()).filter(|pixel| is_direct[*pixel]).collect();
        let mut components = vec![vec![0.0f32; is_direct.len()]; formed.len()];
        for (component, own) in components.iter_mut().zip(&formed) {
            interpolate(own, nodes.counts[0], &nodes.across, &nodes.up, between, component);
        }
        let mut values = lengths(components);
        let at_pixels = |pixel: &usize| self.pixel(*pixel);
        let own = self.at_places(&direct, at_pixels, double, &progress.part(clear.len()..all, all))?;
        direct.iter().zip(lengths(own)).for_each(|(pixel, value)| values[*pixel] = value);
        let (nodes, step) = (clear.len(), step * 1e3);
        let beside = direct.len();
        let how = format!(
            "partial waves at {nodes} nodes, {step:.2} mm apart, and at {beside} places beside bodies"
        );
        Ok(self.map(values, nodes + beside, how, if double { By::CpuInF64 } else { self.by }))
    }

    /// Potential or force at some places.
    fn at_places(
        &self,
        places: &[usize],
        at: impl Fn(&usize) -> DVec3,
        double: bool,
        progress: &Gauge,
    ) -> Result<Vec<Vec<f32>>, FieldError> {
        let mut formed = vec![Vec::with_capacity(places.len()); self.components()];
        for (run, some) in places.chunks(PLACES).enumerate() {
            let progress = progress.part(run * PLACES..run * PLACES + some.len(), places.len());
            let own = self.around(&Samples::at(some.iter().map(&at).collect()), double, &progress)?;
            formed.iter_mut().zip(own).for_each(|(to, own)| to.extend(own));
        }
        Ok(formed)
    }

    /// Every pixel from the sound on a sphere about it.
    fn on_spheres(&self, double: bool, progress: &Gauge) -> Result<Map, FieldError> {
        let (width, height) = self.request.size;
        let lattice =
            self.lattice((0..width).map(|i| self.along(0, i)), (0..height).map(|row| self.along(1, row)));
        let values = lengths(self.around(&lattice, double, progress)?);
        let by = if double { By::CpuInF64 } else { self.by };
        Ok(self.map(values, lattice.len(), "partial waves at every pixel".to_owned(), by))
    }

    /// Every pixel for itself, in f64 throughout.
    fn direct(&self, progress: &Gauge) -> Map {
        let (width, height) = self.request.size;
        let points: Vec<_> = (0..width * height).map(|pixel| self.pixel(pixel)).collect();
        let done = progress.count(points.len().div_ceil(PLACES));
        let of_run = |points: &[DVec3]| {
            let values = if progress.is_cancelled() { vec![0.0; points.len()] } else { self.exact(points) };
            done.add();
            values
        };
        let narrow = |value: f64| (self.request.part * value) as f32;
        let values: Vec<_> = points.chunks(PLACES).flat_map(of_run).map(narrow).collect();
        let how = "partial waves in f64 at every pixel".to_owned();
        let (evaluated, by) = (values.len(), By::Reference);
        self.measured(Map { width, height, values, evaluated, by, how, ..Map::default() })
    }

    /// The map of a part of these values, with the largest of them and their error.
    fn map(&self, mut values: Vec<f32>, evaluated: usize, how: String, by: By) -> Map {
        let (width, height) = self.request.size;
        let part = self.request.part as f32;
        values.iter_mut().for_each(|value| *value *= part);
        let map = self.measured(Map { width, height, values, evaluated, by, how, ..Map::default() });
        Map { error: if map.peak > 0.0 { self.error(&map.values, map.peak) } else { 0.0 }, ..map }
    }

    /// The map with the largest of its values.
    fn measured(&self, map: Map) -> Map {
        let Request { aperture, plane, size: (width, height), .. } = self.request;
        let pixels = Samples::on_plane(plane, *width, *height);
        let left_out = pixels.map(|pixels| Vicinity::new(aperture).of(&pixels)).unwrap_or_default();
        let [peak, others] = left_out.largest(&map.values);
        let (loudest, near, rounding) = (peak.max(others), left_out.near, self.rounding(&left_out));
        let within = map.values.iter().filter(|value| value.is_nan()).count();
        if f64::from(peak) <= rounding {
            return Map { peak: 0.0, loudest, near, within, rounding, ..map };
        }
        Map { peak, loudest, near, within, ..map }
    }

    /// A bound of the rounding of forces whose terms may cancel.
    fn rounding(&self, left_out: &LeftOut) -> f64 {
        let Request { aperture, plane, drives, size, part, .. } = self.request;
        let probed = spread(size.0 * size.1).chain(corners(*size)).filter(|&pixel| !left_out.contains(pixel));
        let elements = aperture.without_bodies();
        let transfer = elements.transfer(&probed.map(|pixel| self.pixel(pixel)).collect::<Vec<_>>());
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
        let exact = self.exact(&points);
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
    fn exact(&self, points: &[DVec3]) -> Vec<f64> {
        let Self { request, levitation, .. } = self;
        let is_force = request.quantity == Quantity::Force;
        let value = |&point: &DVec3| match is_force {
            true => levitation.force(point).length(),
            false => levitation.potential(point),
        };
        points.par_iter().map(value).collect()
    }
}

/// Potentials as they are, and the lengths of forces.
fn lengths(mut components: Vec<Vec<f32>>) -> Vec<f32> {
    if components.len() == 1 {
        return components.remove(0);
    }
    let length = |i: usize| components.iter().map(|own| own[i] * own[i]).sum::<f32>().sqrt();
    (0..components[0].len()).map(length).collect()
}

/// Rows that are their own pixels.
fn itself(count: usize) -> Resampling {
    Resampling { taps: 1, first: (0..count as u32).collect(), weights: vec![1.0; count] }
}
