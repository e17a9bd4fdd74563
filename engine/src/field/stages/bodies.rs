//! The sound that bodies scatter, at the pixels of a map.
//!
//! At a surface the formula of scattered sound jumps, so it cannot pass through a window across it. Pixels whose
//! samples are all outside bodies are interpolated as those of other sound. Beside bodies the sound is evaluated at
//! the nodes of a finer lattice, and polynomials through six by six of them give the pixels between. A pixel with a
//! node of its own within a body is evaluated for itself.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex32;
use rayon::prelude::*;

use crate::field::gpu::Gpu;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::quantity::{PRESSURE, Part};
use crate::field::raster::Raster;
use crate::field::sound::narrow;
use crate::field::stages::job::Job;
use crate::field::stages::lattice::Lattice;
use crate::field::stages::nodes::{Nodes, clear_of, step};
use crate::field::stages::site::Weights;
use crate::scatter::{Answer, Bodies, Rows};

/// What gives a pixel its scattered sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    Samples,
    Nodes,
    Itself,
    /// It is within a body.
    Nothing,
}

/// Where the scattered sound of some rows of pixels is evaluated.
#[derive(Debug, Default)]
pub(super) struct Places {
    /// m: samples and nodes outside bodies, and pixels by themselves.
    points: Vec<DVec3>,
    pixels: Vec<By>,
    /// The numbers of the samples and of the nodes among the points.
    samples: Vec<usize>,
    nodes: Vec<usize>,
    lattice: Option<Nodes>,
    /// The sound of every element at the points, where it is worth the memory.
    table: Option<Rows>,
}

/// Rows of a raster, and the weights of its interpolated rows.
#[derive(Clone, Copy)]
pub(super) struct Band<'a> {
    pub(super) raster: &'a Raster,
    pub(super) weights: Option<&'a Weights>,
    pub(super) rows: (usize, usize),
}

impl Band<'_> {
    /// The interpolated rows, and their part of weights along the second axis.
    fn interpolated(&self, up: &Resampling) -> (Range<usize>, Resampling) {
        let all = &self.raster.interpolated;
        let own = self.rows.0.max(all.start)..self.rows.1.min(all.end).max(self.rows.0.max(all.start));
        (own.clone(), up.part(own.start - all.start..own.end - all.start))
    }
}

impl Places {
    pub(super) fn new(job: &Job<'_>, band: Band<'_>) -> Self {
        let Some(bodies) = job.key.setting.aperture.bodies.bodies() else { return Self::default() };
        let Band { raster, weights, rows: (low, high) } = band;
        let (width, first) = (raster.width, low * raster.width);
        let pixels = raster.pixel_rows(low..high);
        let outside =
            |points: &[DVec3]| -> Vec<bool> { points.par_iter().map(|at| !bodies.contains(*at)).collect() };
        let mut places = Self { pixels: vec![By::Itself; pixels.len()], ..Self::default() };
        if let (Some(grid), Some(weights)) = (&job.site.plan.grid, weights) {
            let samples: Vec<_> = (0..grid.samples.len()).map(|sample| grid.samples.point(sample)).collect();
            let is_outside = outside(&samples);
            let [across, up] = weights.of(Part::Pressure);
            let (rows, up) = band.interpolated(up);
            let clear = clear_of(&is_outside, grid.samples.columns.len(), [across, &up]);
            let own = &mut places.pixels[(rows.start - low) * width..];
            own.iter_mut().zip(clear).filter(|(_, is)| *is).for_each(|(by, _)| *by = By::Samples);
            places.samples = (0..samples.len()).filter(|sample| is_outside[*sample]).collect();
            places.points.extend(places.samples.iter().map(|sample| samples[*sample]));
        }
        let from = job.within.partition_point(|pixel| *pixel < first);
        let until = job.within.partition_point(|pixel| *pixel < high * width);
        job.within[from..until].iter().for_each(|pixel| places.pixels[pixel - first] = By::Nothing);
        let plane = &job.key.setting.plane;
        let step = step(plane.tolerance, job.key.setting.aperture.element.wavenumber);
        let size = (width, raster.height);
        let near = places.box_of_itself(width).filter(|_| !job.key.is_direct());
        let lattice = near.and_then(|[columns, rows]| {
            let over = [columns, rows.start + low..rows.end + low];
            Nodes::new((plane, job.site.axes), size, over, step)
        });
        if let Some(lattice) = &lattice {
            let points: Vec<_> = (0..lattice.count()).map(|n| lattice.point(n)).collect();
            let is_outside = outside(&points);
            let clear = clear_of(&is_outside, lattice.counts[0], [&lattice.across, &lattice.up]);
            for (pixel, is_clear) in lattice.pixels(width, low).zip(clear) {
                let by = &mut places.pixels[pixel];
                *by = if is_clear && *by == By::Itself { By::Nodes } else { *by };
            }
            places.nodes = (0..points.len()).filter(|node| is_outside[*node]).collect();
            places.points.extend(places.nodes.iter().map(|node| points[*node]));
        }
        places.lattice = lattice;
        let itself: Vec<_> = places.pixels_by(By::Itself).map(|pixel| pixels.point(pixel)).collect();
        places.points.extend(itself);
        places.points = bodies.lifted(&places.points);
        places
    }

    /// Prepares more drives at the same places, if the answers to all elements are known.
    pub(super) fn tabulate(&mut self, job: &Job<'_>) {
        if self.table.is_none() {
            self.table = job.key.setting.aperture.table_of_bodies(&self.points);
        }
    }

    fn pixels_by(&self, by: By) -> impl Iterator<Item = usize> {
        (0..self.pixels.len()).filter(move |pixel| self.pixels[*pixel] == by)
    }

    /// The columns and rows of the pixels that samples do not give.
    fn box_of_itself(&self, width: usize) -> Option<[Range<usize>; 2]> {
        let places = self.pixels_by(By::Itself).map(|pixel| [pixel % width, pixel / width]);
        let grow = |ranges: Option<[Range<usize>; 2]>, place: [usize; 2]| {
            let ranges = ranges.unwrap_or(place.map(|index| index..index + 1));
            Some(
                [0, 1].map(|axis| ranges[axis].start.min(place[axis])..ranges[axis].end.max(place[axis] + 1)),
            )
        };
        places.fold(None, grow)
    }
}

/// Adds the scattered sound of a drive to a band of pixels; within bodies there is none.
pub(super) fn add(
    (job, gpu): (&Job<'_>, Option<&Gpu>),
    drive: usize,
    (places, band): (&Places, Band<'_>),
    to: &mut Lattice,
) {
    let heard = match &places.table {
        Some(table) => vec![table.pressures(&job.excitations[drive])],
        None => {
            let answer = job.key.setting.aperture.answer(&job.excitations[drive]);
            let Some((bodies, answer)) = answer else { return };
            heard((job, gpu), bodies, &answer, &places.points)
        }
    };
    let width = band.raster.width;
    let mut between = Between::default();
    for (part, (values, heard)) in Part::of(job.key.parts).zip(to.0.iter_mut().zip(&heard)) {
        let (of_samples, others) = heard.split_at(places.samples.len());
        let (of_nodes, of_pixels) = others.split_at(places.nodes.len());
        if let (Some(grid), Some(weights)) = (&job.site.plan.grid, band.weights) {
            let [across, up] = weights.of(part);
            let (rows, up) = band.interpolated(up);
            let samples = spread_out(grid.samples.len(), &places.samples, of_samples);
            let mut own = vec![Complex32::ZERO; rows.len() * width];
            interpolate(&samples, grid.samples.columns.len(), across, &up, &mut between, &mut own);
            let start = (rows.start - band.rows.0) * width;
            let sums = values[start..].iter_mut().zip(own).zip(&places.pixels[start..]);
            sums.filter(|(_, by)| **by == By::Samples).for_each(|((sum, value), _)| *sum += value);
        }
        if let Some(lattice) = &places.lattice {
            let nodes = spread_out(lattice.count(), &places.nodes, of_nodes);
            let mut own = vec![Complex32::ZERO; lattice.across.first.len() * lattice.up.first.len()];
            interpolate(&nodes, lattice.counts[0], &lattice.across, &lattice.up, &mut between, &mut own);
            let all = lattice.pixels(width, band.rows.0).zip(own);
            all.filter(|(pixel, _)| places.pixels[*pixel] == By::Nodes)
                .for_each(|(pixel, value)| values[pixel] += value);
        }
        places.pixels_by(By::Itself).zip(of_pixels).for_each(|(pixel, value)| values[pixel] += value);
        places.pixels_by(By::Nothing).for_each(|pixel| values[pixel] = Complex32::ZERO);
    }
}

/// Values at their numbers, and 0 elsewhere.
fn spread_out(count: usize, numbers: &[usize], values: &[Complex32]) -> Vec<Complex32> {
    let mut all = vec![Complex32::ZERO; count];
    numbers.iter().zip(values).for_each(|(number, value)| all[*number] = *value);
    all
}

/// The parts of the scattered sound at points.
fn heard(
    (job, gpu): (&Job<'_>, Option<&Gpu>),
    bodies: &Bodies,
    answer: &Answer,
    points: &[DVec3],
) -> Vec<Vec<Complex32>> {
    let double = job.key.is_direct();
    if job.key.parts == PRESSURE && !double {
        return vec![pressures(gpu, bodies, answer, points)];
    }
    let sounds = match double {
        true => bodies.sounds(answer, points),
        false => bodies.sounds_in_f32(answer, points),
    };
    let of = |part: Part| {
        let along = |[x, y, z]: [_; 3], axis: usize| {
            let to = job.site.axes[axis];
            x * to.x + y * to.y + z * to.z
        };
        let value = |&(p, slopes): &(_, _)| match part {
            Part::Pressure => p,
            Part::AlongX => along(slopes, 0),
            Part::AlongY => along(slopes, 1),
            Part::Normal => along(slopes, 2),
        };
        sounds.iter().map(|sound| narrow(value(sound))).collect()
    };
    Part::of(job.key.parts).map(of).collect()
}

/// Scattered pressures (Pa) at points, by the GPU if there is one.
fn pressures(gpu: Option<&Gpu>, bodies: &Bodies, answer: &Answer, points: &[DVec3]) -> Vec<Complex32> {
    // A lost device is noticed by the map itself.
    let by_gpu = gpu.and_then(|gpu| gpu.scattered(&bodies.emissions(answer), points).ok());
    let Some(mut all) = by_gpu else {
        return bodies.pressures(answer, points).into_iter().map(narrow).collect();
    };
    let corrections = bodies.corrections(answer, points);
    all.iter_mut().zip(corrections).for_each(|(sum, own)| *sum += narrow(own));
    all
}
