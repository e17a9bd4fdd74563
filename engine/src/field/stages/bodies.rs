//! The sound that bodies scatter, at the pixels of a map.
//!
//! At a surface the formula of scattered sound jumps, so it cannot pass through a window across it. Pixels whose
//! samples are all outside bodies are interpolated as those of other sound. Beside bodies the sound is evaluated at
//! the nodes of a finer lattice, and polynomials through six by six of them give the pixels between. A pixel with a
//! node of its own within a body is evaluated for itself.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;
use num_complex::Complex32;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::field::gpu::Gpu;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::quantity::{PRESSURE, Part};
use crate::field::raster::Raster;
use crate::field::sound::narrow;
use crate::field::stages::job::Job;
use crate::field::stages::lattice::Lattice;
use crate::field::stages::site::Weights;
use crate::scatter::{Answer, Bodies, Rows};

/// Nodes along each side of a polynomial.
const TAPS: usize = 6;
/// The error of a polynomial through so many nodes for e^{jkx}, over (kh)^6: the product of the distances to the nodes
/// by 6!, along both axes.
const OF_POLYNOMIALS: f64 = 2.0 * 3.52 / 720.0;
/// The scattered sound's part of the tolerance.
const SHARE: f64 = 0.25;

/// The pixels of a frame that are within bodies.
pub(super) fn within(aperture: &Aperture, raster: &Raster) -> Vec<usize> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let pixels = raster.pixels();
    (0..pixels.len()).into_par_iter().filter(|&pixel| bodies.contains(pixels.point(pixel))).collect()
}

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
        let mut lattice = places.box_of_itself(width).and_then(|near| Nodes::new(job, raster, near, low));
        if let Some(lattice) = &mut lattice {
            let points: Vec<_> =
                (0..lattice.counts[0] * lattice.counts[1]).map(|n| lattice.point(n)).collect();
            let is_outside = outside(&points);
            let clear = clear_of(&is_outside, lattice.counts[0], [&lattice.across, &lattice.up]);
            for (pixel, is_clear) in lattice.pixels(width).zip(clear) {
                let by = &mut places.pixels[pixel];
                *by = if is_clear && *by == By::Itself { By::Nodes } else { *by };
            }
            places.nodes = (0..points.len()).filter(|node| is_outside[*node]).collect();
            places.points.extend(places.nodes.iter().map(|node| points[*node]));
        }
        places.lattice = lattice;
        let itself: Vec<_> = places.pixels_by(By::Itself).map(|pixel| pixels.point(pixel)).collect();
        places.points.extend(itself);
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
            let nodes = spread_out(lattice.counts[0] * lattice.counts[1], &places.nodes, of_nodes);
            let mut own = vec![Complex32::ZERO; lattice.across.first.len() * lattice.up.first.len()];
            interpolate(&nodes, lattice.counts[0], &lattice.across, &lattice.up, &mut between, &mut own);
            let all = lattice.pixels(width).zip(own);
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

/// The pixels all of whose samples are outside bodies.
fn clear_of(is_outside: &[bool], columns: usize, [across, up]: [&Resampling; 2]) -> Vec<bool> {
    let rows = is_outside.len() / columns;
    // Samples within bodies at all columns and rows before.
    let mut sums = vec![0u32; (columns + 1) * (rows + 1)];
    let at = |column: usize, row: usize| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let own = u32::from(!is_outside[row * columns + column]);
            sums[at(column + 1, row + 1)] =
                own + sums[at(column, row + 1)] + sums[at(column + 1, row)] - sums[at(column, row)];
        }
    }
    let is_clear = |(column, row): (u32, u32)| {
        let [left, low] = [column as usize, row as usize];
        let [right, high] = [left + across.taps, low + up.taps];
        sums[at(right, high)] + sums[at(left, low)] == sums[at(left, high)] + sums[at(right, low)]
    };
    let pixels = up.first.iter().flat_map(|row| across.first.iter().map(move |column| (*column, *row)));
    pixels.map(is_clear).collect()
}

/// A lattice over some columns and rows of pixels.
#[derive(Debug)]
struct Nodes {
    /// Pixels, the rows from the first of a band.
    near: [Range<usize>; 2],
    origin: DVec3,
    /// From node to node.
    steps: [DVec3; 2],
    counts: [usize; 2],
    across: Resampling,
    up: Resampling,
}

impl Nodes {
    /// `None` where every pixel is to be evaluated, or nodes would be hardly fewer.
    fn new(job: &Job<'_>, raster: &Raster, near: [Range<usize>; 2], low: usize) -> Option<Self> {
        let plane = &job.key.setting.plane;
        if job.key.is_direct() {
            return None;
        }
        let reach = (SHARE * plane.tolerance / OF_POLYNOMIALS).powf(1.0 / TAPS as f64);
        let step = reach * job.key.setting.aperture.wavelength() / TAU;
        let sizes = [plane.size.x / raster.width as f64, plane.size.y / raster.height as f64];
        if 1.5 * sizes[0] * sizes[1] > step * step {
            return None;
        }
        let along = |axis: usize, pixels: Range<usize>| {
            let pixel = |index: usize| sizes[axis] * (index as f64 + 0.5) - plane.size[axis] / 2.0;
            let margin = TAPS / 2 - 1;
            let begin = pixel(pixels.start) - step * margin as f64;
            let mut resampling = Resampling { taps: TAPS, ..Resampling::default() };
            for index in pixels {
                let place = (pixel(index) - begin) / step;
                let first = (place.floor() as usize).saturating_sub(margin);
                resampling.first.push(first as u32);
                let own = place - first as f64;
                let weight = |tap: usize| {
                    let others = (0..TAPS).filter(|other| *other != tap).map(|other| other as f64);
                    others.map(|other| (own - other) / (tap as f64 - other)).product::<f64>() as f32
                };
                resampling.weights.extend((0..TAPS).map(weight));
            }
            let count = resampling.first.last().map_or(0, |first| *first as usize + TAPS);
            (begin, count, resampling)
        };
        let [x, y, _] = job.site.axes;
        let (left, columns, across) = along(0, near[0].clone());
        let (bottom, lines, up) = along(1, near[1].start + low..near[1].end + low);
        let origin = plane.centre + x * left + y * bottom;
        Some(Self { near, origin, steps: [x * step, y * step], counts: [columns, lines], across, up })
    }

    fn point(&self, node: usize) -> DVec3 {
        let [column, row] = [node % self.counts[0], node / self.counts[0]];
        self.origin + self.steps[0] * column as f64 + self.steps[1] * row as f64
    }

    /// The pixels that it covers, by their numbers in a band of this width.
    fn pixels(&self, width: usize) -> impl Iterator<Item = usize> {
        let [columns, rows] = self.near.clone();
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }
}
