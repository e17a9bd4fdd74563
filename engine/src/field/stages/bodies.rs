//! The sound that bodies scatter, at the pixels of a map.
//!
//! At a surface the formula of scattered sound jumps, so it cannot pass through the window of the samples. It is
//! evaluated at the nodes of a finer lattice, and polynomials through six by six nodes give the pixels between them. A
//! pixel with a node of its own within a body is evaluated for itself.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex32;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::field::gpu::Gpu;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::quantity::{PRESSURE, Part};
use crate::field::raster::Raster;
use crate::field::samples::Samples;
use crate::field::sound::narrow;
use crate::field::stages::job::Job;
use crate::field::stages::lattice::Lattice;
use crate::scatter::{Answer, Bodies};
use crate::scene::Plane;

/// Nodes along each side of a polynomial.
const TAPS: usize = 6;
/// The error of a polynomial through so many nodes for e^{jkx}, over (kh)^6: the product of the distances to the nodes
/// by 6!, along both axes.
const OF_POLYNOMIALS: f64 = 2.0 * 3.52 / 720.0;
/// The scattered sound's part of the tolerance.
const SHARE: f64 = 0.25;

/// Distance (m) of a body's skin from the plane up to which it is the skin on the plane, and from it of the sound there.
const BESIDE: f64 = 1e-3;
const JUST_OUTSIDE: f64 = 1e-5;

/// The pixels of a frame that are within bodies.
pub(super) fn within(aperture: &Aperture, raster: &Raster) -> Vec<usize> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let pixels = raster.pixels();
    (0..pixels.len()).into_par_iter().filter(|&pixel| bodies.contains(pixels.point(pixel))).collect()
}

/// The pixels of a map from cells that are within bodies. Skin within a body's is that of the body.
pub(super) fn within_cells(
    aperture: &Aperture,
    (plane, [x, y, normal]): (&Plane, [DVec3; 3]),
    (width, height): (usize, usize),
    of_skin: bool,
) -> Vec<usize> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let along = |index: usize, count: usize| (index as f64 + 0.5) / count as f64 - 0.5;
    let is_within = |pixel: &usize| {
        let [x_part, y_part] = [along(pixel % width, width), along(pixel / width, height)];
        let at = plane.centre + x * (plane.size.x * x_part) + y * (plane.size.y * y_part);
        match of_skin {
            true => [-BESIDE, BESIDE].iter().all(|way| bodies.contains(at + normal * *way)),
            false => bodies.contains(at),
        }
    };
    (0..width * height).into_par_iter().filter(is_within).collect()
}

/// Where the sound presses on the skin of bodies that lies on a plane with a normal, at some of its places: just outside
/// the body, `None` elsewhere. Empty if no skin lies on the plane.
pub(super) fn skin(aperture: &Aperture, places: &Samples, normal: DVec3) -> Vec<Option<DVec3>> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let on_skin = |place: usize| {
        let at = places.point(place);
        let is_in = |way: f64| bodies.contains(at + normal * way);
        let [mut outside, mut inside] = match [-BESIDE, BESIDE].map(is_in) {
            [false, true] => [-BESIDE, BESIDE],
            [true, false] => [BESIDE, -BESIDE],
            [true, true] | [false, false] => return None,
        };
        while (outside - inside).abs() > JUST_OUTSIDE {
            let middle = f64::midpoint(outside, inside);
            if is_in(middle) { inside = middle } else { outside = middle }
        }
        Some(at + normal * outside)
    };
    let skin: Vec<_> = (0..places.len()).into_par_iter().map(on_skin).collect();
    if skin.iter().any(Option::is_some) { skin } else { Vec::new() }
}

/// Adds the scattered sound of a drive to some rows of pixels; within bodies there is none.
pub(super) fn add(
    (job, gpu): (&Job<'_>, Option<&Gpu>),
    drive: usize,
    (raster, rows): (&Raster, Range<usize>),
    to: &mut Lattice,
) {
    let aperture = &job.key.setting.aperture;
    let Some((bodies, answer)) = aperture.answer(&job.excitations[drive]) else { return };
    let parts: Vec<_> = Part::of(job.key.parts).collect();
    let double = job.key.is_direct();
    let sounds = |points: &[DVec3]| -> Vec<Vec<Complex32>> {
        if job.key.parts == PRESSURE && !double {
            return vec![pressures(gpu, bodies, &answer, points)];
        }
        let sounds = match double {
            true => bodies.sounds(&answer, points),
            false => bodies.sounds_in_f32(&answer, points),
        };
        let of = |part: &Part| {
            let value = |(p, [x, y, z]): &(_, [_; 3])| {
                let along = |axis: usize| {
                    let to = job.site.axes[axis];
                    x * to.x + y * to.y + z * to.z
                };
                narrow(match part {
                    Part::Pressure => *p,
                    Part::AlongX => along(0),
                    Part::AlongY => along(1),
                    Part::Normal => along(2),
                })
            };
            sounds.iter().map(value).collect()
        };
        parts.iter().map(of).collect()
    };
    let pixels = raster.pixel_rows(rows.clone());
    let first = rows.start * raster.width;
    let last = rows.end * raster.width;
    let from = job.within.partition_point(|pixel| *pixel < first);
    let until = job.within.partition_point(|pixel| *pixel < last);
    let mut is_direct = vec![true; pixels.len()];
    let plane = &job.key.setting.plane;
    let step = step(plane.tolerance, aperture.element.wavenumber);
    let size = (raster.width, raster.height);
    let nodes = Nodes::new((plane, job.site.axes), size, rows, step).filter(|_| !job.key.is_direct());
    if let Some(nodes) = nodes {
        let points: Vec<_> = (0..nodes.count()).map(|node| nodes.point(node)).collect();
        let is_within: Vec<_> = points.par_iter().map(|at| bodies.contains(*at)).collect();
        let outside: Vec<_> = (0..points.len()).filter(|node| !is_within[*node]).collect();
        let heard = sounds(&outside.iter().map(|node| points[*node]).collect::<Vec<_>>());
        mark(&nodes, &is_within, &mut is_direct);
        let (mut between, mut at_pixels) = (Between::default(), vec![Complex32::ZERO; pixels.len()]);
        for (values, heard) in to.0.iter_mut().zip(heard) {
            let mut at_nodes = vec![Complex32::ZERO; points.len()];
            outside.iter().zip(heard).for_each(|(node, value)| at_nodes[*node] = value);
            interpolate(&at_nodes, nodes.counts[0], &nodes.across, &nodes.up, &mut between, &mut at_pixels);
            let sums = values.iter_mut().zip(&at_pixels).zip(&is_direct);
            sums.filter(|(_, is_direct)| !**is_direct).for_each(|((sum, value), _)| *sum += value);
        }
    }
    for pixel in &job.within[from..until] {
        is_direct[pixel - first] = false;
        to.0.iter_mut().for_each(|values| values[pixel - first] = Complex32::ZERO);
    }
    let direct: Vec<_> = (0..pixels.len()).filter(|pixel| is_direct[*pixel]).collect();
    let heard = sounds(&direct.iter().map(|pixel| pixels.point(*pixel)).collect::<Vec<_>>());
    for (values, heard) in to.0.iter_mut().zip(heard) {
        direct.iter().zip(heard).for_each(|(pixel, value)| values[*pixel] += value);
    }
}

/// Scattered pressures (Pa) at points, by the GPU if there is one.
fn pressures(gpu: Option<&Gpu>, bodies: &Bodies, answer: &Answer, points: &[DVec3]) -> Vec<Complex32> {
    let by_gpu = gpu.and_then(|gpu| {
        let emissions = bodies.emissions(answer);
        // A lost device is noticed by the map itself.
        gpu.scattered(&emissions, points).ok()
    });
    let Some(mut all) = by_gpu else {
        return bodies.pressures(answer, points).into_iter().map(narrow).collect();
    };
    let corrections = bodies.corrections(answer, points);
    all.iter_mut().zip(corrections).for_each(|(sum, own)| *sum += narrow(own));
    all
}

/// The step (m) of nodes for waves up to a wavenumber (rad/m).
pub(super) fn step(tolerance: f64, wavenumber: f64) -> f64 {
    (SHARE * tolerance / OF_POLYNOMIALS).powf(1.0 / TAPS as f64) / wavenumber
}

/// A lattice over some rows of pixels.
pub(super) struct Nodes {
    origin: DVec3,
    /// From node to node.
    steps: [DVec3; 2],
    pub(super) counts: [usize; 2],
    pub(super) across: Resampling,
    pub(super) up: Resampling,
}

impl Nodes {
    /// Those over rows of the pixels of a plane, a step (m) apart. `None` if they would be hardly fewer than the pixels.
    pub(super) fn new(
        (plane, [x, y, _]): (&Plane, [DVec3; 3]),
        (width, height): (usize, usize),
        rows: Range<usize>,
        step: f64,
    ) -> Option<Self> {
        let sizes = [plane.size.x / width as f64, plane.size.y / height as f64];
        if 1.5 * sizes[0] * sizes[1] > step * step {
            return None;
        }
        let pixel = |axis: usize, index: usize| {
            sizes[axis] * (index as f64 + 0.5) - [plane.size.x, plane.size.y][axis] / 2.0
        };
        let along = |axis: usize, pixels: Range<usize>| {
            let margin = TAPS / 2 - 1;
            let begin = pixel(axis, pixels.start) - step * margin as f64;
            let mut resampling = Resampling { taps: TAPS, first: Vec::new(), weights: Vec::new() };
            for index in pixels {
                let place = (pixel(axis, index) - begin) / step;
                let first = (place.floor() as usize).saturating_sub(margin);
                resampling.first.push(first as u32);
                let own = place - first as f64;
                let weight = |tap: usize| {
                    let others = (0..TAPS).filter(|other| *other != tap);
                    others.map(|other| (own - other as f64) / (tap as f64 - other as f64)).product::<f64>()
                        as f32
                };
                resampling.weights.extend((0..TAPS).map(weight));
            }
            let count = resampling.first.last().map_or(0, |first| *first as usize + TAPS);
            (begin, count, resampling)
        };
        let (left, columns, across) = along(0, 0..width);
        let (low, lines, up) = along(1, rows);
        let origin = plane.centre + x * left + y * low;
        Some(Self { origin, steps: [x * step, y * step], counts: [columns, lines], across, up })
    }

    pub(super) fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    pub(super) fn point(&self, node: usize) -> DVec3 {
        let [column, row] = [node % self.counts[0], node / self.counts[0]];
        self.origin + self.steps[0] * column as f64 + self.steps[1] * row as f64
    }
}

/// Unmarks the pixels all of whose nodes are outside bodies.
pub(super) fn mark(nodes: &Nodes, is_within: &[bool], is_direct: &mut [bool]) {
    let Nodes { counts: [columns, rows], across, up, .. } = nodes;
    let (columns, rows) = (*columns, *rows);
    // Of nodes within, at rows and columns before.
    let mut sums = vec![0u32; (columns + 1) * (rows + 1)];
    for row in 0..rows {
        for column in 0..columns {
            let before = |up: usize, left: usize| sums[(row + 1 - up) * (columns + 1) + column + 1 - left];
            let own = u32::from(is_within[row * columns + column]);
            let sum = own + before(1, 0) + before(0, 1) - before(1, 1);
            sums[(row + 1) * (columns + 1) + column + 1] = sum;
        }
    }
    let width = across.first.len();
    for (pixel, is_direct) in is_direct.iter_mut().enumerate() {
        let (column, row) = (across.first[pixel % width], up.first[pixel / width]);
        let [left, low] = [column as usize, row as usize];
        let at = |row: usize, column: usize| sums[row * (columns + 1) + column];
        let inner = at(low + up.taps, left + across.taps) + at(low, left);
        *is_direct = inner != at(low, left + across.taps) + at(low + up.taps, left);
    }
}
