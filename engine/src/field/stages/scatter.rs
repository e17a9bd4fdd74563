//! Maps of arrays whose elements differ at random ([`crate::acoustics::Ensemble`]): their mean over all such arrays.
//!
//! A quantity that is a square q of the sound has the mean μ² q(Σ H_n u_n) + v Σ |u_n|² q(H_n): the map of equal elements,
//! and a term that is smooth, since it has no phases. The term is interpolated from six by six Chebyshev nodes in every
//! tile of the map that is no wider than its distance from the nearest element: the waves' 1/r² then is known to 4e-4.
//! Closer tiles are split, down to pixels. Where reflectors add images the element's own waves interfere, and a tile is
//! at most a quarter of a wavelength wide. The term depends on the amplitudes of the drive alone and is kept while
//! phases change.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::acoustics::{Aperture, Face, Moments};
use crate::drive::Drive;
use crate::field::samples::Samples;
use crate::field::slope::SoundTransfer;
use crate::field::stages::kept::Kept;
use crate::field::stages::probes::{MARGIN, spread};
use crate::field::stages::request::{Map, Request, Setting};
use crate::field::vicinity::Vicinity;

/// Nodes of a tile along each side.
const NODES: usize = 6;
/// Width of a tile in front of a mirror, in wavelengths.
const BETWEEN_IMAGES: f64 = 0.25;
/// Points evaluated together.
const RUN: usize = 36;

/// The term of the latest map.
#[derive(Debug, Default)]
pub(super) struct Scatter {
    term: Kept<Request, Vec<f32>>,
}

/// Everything that the term at a point depends on.
struct Source<'a> {
    request: &'a Request,
    /// With every element driven.
    aperture: Aperture,
    /// v |u|² of every element, the mean over the drives.
    weights: Vec<f64>,
    axes: [DVec3; 3],
    /// m, of all elements and images.
    elements: Vec<DVec3>,
    pixels: Samples,
}

/// Columns and rows of some pixels.
struct Tile {
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Scatter {
    /// Turns the map of equal elements into the mean; `exact` evaluates every pixel.
    pub(super) fn add(&mut self, request: &Request, exact: bool, map: &mut Map) {
        let Some(source) = Source::new(request) else { return };
        let direct = exact || request.plane.tolerance == 0.0;
        let still = |drive: &Drive| Drive { phases: vec![0.0; drive.phases.len()], ..drive.clone() };
        let key =
            Request { drives: request.drives.iter().map(still).collect(), part: 1.0, ..request.clone() };
        let term = self.term.update(&key, |term| source.fill(direct, term));
        let (quantity, part) = (request.quantity, request.part);
        let (is_root, mean) = (quantity.declaration().is_root, Moments::new(request.spread).mean);
        let value = |value: f32, term: f64| {
            let value = f64::from(value);
            let nominal = mean * mean * if is_root { value * value } else { value };
            quantity.exact_value(nominal + part * term)
        };
        let places: Vec<_> = if direct { Vec::new() } else { spread(term.len()).collect() };
        let points: Vec<_> = places.iter().map(|&pixel| source.pixels.point(pixel)).collect();
        let off = places.iter().zip(source.at(&points)).map(|(&pixel, exact)| {
            let value = |term: f64| value(map.values[pixel], term);
            (value(exact) - value(f64::from(term[pixel]))).abs()
        });
        // A root moves less than the root below it, which fell by the mean; others by its square.
        let before = if is_root { mean } else { mean * mean } * map.error * f64::from(map.peak);
        let off = before + MARGIN * off.fold(0.0, f64::max);
        map.values.iter_mut().zip(term).for_each(|(own, term)| *own = value(*own, f64::from(*term)) as f32);
        let [peak, others] = Vicinity::new(&request.aperture).of(&source.pixels).largest(&map.values);
        (map.peak, map.loudest) = (peak, peak.max(others));
        if peak > 0.0 {
            (map.error, map.rounding) = (off / f64::from(peak), 0.0);
        }
    }

    pub(super) fn forget(&mut self) {
        self.term.key = None;
    }
}

impl<'a> Source<'a> {
    /// `None` for an invalid plane.
    fn new(request: &'a Request) -> Option<Self> {
        let ((x, y), (width, height)) = (request.plane.axes()?, request.size);
        let aperture = Setting::new(&request.aperture, request.plane.clone()).aperture;
        let share = Moments::new(request.spread).variance / request.drives.len() as f64;
        let mut weights = vec![0.0; aperture.positions.len()];
        for excitation in request.excitations().iter() {
            weights.iter_mut().zip(excitation).for_each(|(sum, u)| *sum += share * u.norm_sqr());
        }
        let of_face = |face: &Face| {
            let world = |at: &DVec3| face.pose.world(*at);
            face.layout.positions.iter().map(world).collect::<Vec<_>>()
        };
        let elements = aperture.faces.iter().flat_map(of_face).collect();
        let pixels = Samples::on_plane(&request.plane, width, height)?;
        Some(Self { request, aperture, weights, axes: [x, y, x.cross(y)], elements, pixels })
    }

    /// Σ v |u_n|² q(H_n) at points.
    fn at(&self, points: &[DVec3]) -> Vec<f64> {
        let (quantity, constants) = (self.request.quantity, self.request.constants());
        let of_run = |points: &[DVec3]| {
            let parts = quantity.declaration().parts;
            SoundTransfer::new(&self.aperture, parts, self.axes, points)
                .scatter(&self.weights, (quantity, &constants))
        };
        points.par_chunks(RUN).flat_map_iter(of_run).collect()
    }

    /// The term at every pixel.
    fn fill(&self, direct: bool, term: &mut Vec<f32>) {
        let (width, height) = self.request.size;
        term.clear();
        term.resize(width * height, 0.0);
        let mut tiles = Vec::new();
        self.split(Tile { columns: 0..width, rows: 0..height }, direct, &mut tiles);
        let filled: Vec<_> = tiles.par_iter().map(|(tile, is_smooth)| self.tile(tile, *is_smooth)).collect();
        for ((Tile { columns, rows }, _), values) in tiles.iter().zip(filled) {
            for (row, values) in rows.clone().zip(values.chunks_exact(columns.len())) {
                term[row * width + columns.start..row * width + columns.end].copy_from_slice(values);
            }
        }
    }

    /// Splits a tile until the term is smooth in every part, or cheaper to evaluate.
    fn split(&self, tile: Tile, direct: bool, tiles: &mut Vec<(Tile, bool)>) {
        /// Pixels of a tile that are evaluated together.
        const FEW: usize = 1024;
        let Tile { columns, rows } = &tile;
        let corner = |column: usize, row: usize| self.pixels.columns[column] + self.pixels.rows[row];
        let (first, last) = (corner(columns.start, rows.start), corner(columns.end - 1, rows.end - 1));
        let width = (corner(columns.end - 1, rows.start) - first).length();
        let height = (corner(columns.start, rows.end - 1) - first).length();
        let pixels = columns.len() * rows.len();
        let middle = first.midpoint(last);
        let nearest =
            self.elements.iter().map(|at| at.distance_squared(middle)).fold(f64::INFINITY, f64::min);
        let clear = nearest.sqrt() - first.distance(last) / 2.0;
        let widest = if self.aperture.boards().count() < self.aperture.faces.len() {
            clear.min(BETWEEN_IMAGES * self.aperture.wavelength())
        } else {
            clear
        };
        let is_smooth = !direct && width.max(height) <= widest && pixels > NODES * NODES;
        let is_last = is_smooth || pixels <= if direct { FEW } else { NODES * NODES };
        if is_last {
            tiles.push((tile, is_smooth));
            return;
        }
        let halves = |range: &Range<usize>| {
            let middle = usize::midpoint(range.start, range.end);
            [range.start..middle, middle..range.end]
        };
        // The longer side, of a single row the columns.
        let parts = if rows.len() == 1 || (columns.len() > 1 && width >= height) {
            halves(columns).map(|columns| Tile { columns, rows: rows.clone() })
        } else {
            halves(rows).map(|rows| Tile { columns: columns.clone(), rows })
        };
        parts.into_iter().for_each(|part| self.split(part, direct, tiles));
    }

    /// The term at the pixels of a tile, row by row.
    fn tile(&self, Tile { columns, rows }: &Tile, is_smooth: bool) -> Vec<f32> {
        let (across, up) = (&self.pixels.columns[columns.clone()], &self.pixels.rows[rows.clone()]);
        let grid = |across: &[DVec3], up: &[DVec3]| {
            self.at(&up.iter().flat_map(|up| across.iter().map(move |at| *at + *up)).collect::<Vec<_>>())
        };
        if !is_smooth {
            return grid(across, up).into_iter().map(|value| value as f32).collect();
        }
        let nodes = |along: &[DVec3]| {
            let (first, last) = (along[0], along[along.len() - 1]);
            chebyshev().map(|place| first.lerp(last, f64::midpoint(1.0, place)))
        };
        let values = grid(&nodes(across), &nodes(up));
        let (across, up) = (weights(across.len()), weights(up.len()));
        // By rows of nodes, then by rows of pixels.
        let row = |values: &[f64]| -> Vec<f64> {
            across.iter().map(|weights| weights.iter().zip(values).map(|(w, v)| w * v).sum()).collect()
        };
        let lines: Vec<_> = values.chunks_exact(NODES).map(row).collect();
        let pixel = |weights: &[f64; NODES], x: usize| -> f64 {
            weights.iter().zip(&lines).map(|(weight, line)| weight * line[x]).sum()
        };
        up.iter().flat_map(|up| (0..across.len()).map(move |x| pixel(up, x) as f32)).collect()
    }
}

/// The nodes in -1 ... 1.
fn chebyshev() -> [f64; NODES] {
    std::array::from_fn(|node| -(PI * (node as f64 + 0.5) / NODES as f64).cos())
}

/// The weights of the nodes at equally spaced places from -1 to 1.
fn weights(count: usize) -> Vec<[f64; NODES]> {
    let nodes = chebyshev();
    let at = |i: usize| {
        let place = if count > 1 { 2.0 * i as f64 / (count - 1) as f64 - 1.0 } else { 0.0 };
        std::array::from_fn(|own| {
            let others = nodes.iter().enumerate().filter(|(other, _)| *other != own);
            others.map(|(_, node)| (place - node) / (nodes[own] - node)).product()
        })
    };
    (0..count).map(at).collect()
}
