//! The weakest pixels of a mean of squares, whose root is shown, and the loudest of other means.
//!
//! Squares are interpolated from cells, and what is off by ε has a root that is off by ε/(2√m) where the square is m,
//! and by √ε where all drives are silent. ε is measured at weak pixels all over the map, relative to the loudest cell
//! of their interpolation, and pixels too weak for it are evaluated in f64.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::field::interpolation::Resampling;
use crate::field::plan::promised;
use crate::field::samples::Samples;
use crate::field::stages::job::Job;
use crate::field::stages::probes::MARGIN;
use crate::simd::larger;

/// Parts of the map along each axis with a pixel to measure.
const PARTS: usize = 6;
/// Share of the tolerance for roots of interpolated squares.
const SHARE: f64 = 0.4;
/// Evaluations, of a pixel and an element, for each pixel of the map: beyond, interpolated pressures cost less.
const MOST: usize = 4;

/// Pixels with the same cells.
struct Tile {
    rows: Range<usize>,
    columns: Range<usize>,
    weakest: usize,
    least: f32,
    largest: f32,
    /// Largest square of its cells.
    loudest: f32,
}

/// Evaluates the pixels whose roots are beyond the tolerance, and returns the error bound of the other roots, at
/// most. `values` are the mean squares.
pub(super) fn mend(
    job: &Job<'_>,
    (cells, columns): (&[f32], usize),
    [across, up]: [&Resampling; 2],
    values: &mut [f32],
) -> f64 {
    let (width, height) = job.request.size;
    let Some(pixels) = Samples::on_plane(&job.request.plane, width, height) else { return 0.0 };
    let exact = |places: &[usize]| -> Vec<f64> {
        let point = |i: usize| -> DVec3 { pixels.point(places[i]) };
        job.means(0..job.excitations.len(), places.len(), point)
            .into_iter()
            .map(|mean| job.request.part * mean)
            .collect()
    };
    let tiles = tiles((cells, columns), [across, up], values);
    let peak = f64::from(tiles.iter().fold(0.0f32, |most, tile| most.max(tile.largest)).sqrt());
    let allowed = SHARE * promised(job.request.plane.tolerance) * peak;
    let measured = risky(&tiles, (width, height));
    let places: Vec<_> = measured.iter().map(|tile| tile.weakest).collect();
    let off = exact(&places).into_iter().zip(&measured).map(|(mean, tile)| {
        values[tile.weakest] = mean as f32;
        (f64::from(tile.least) - mean).abs() / f64::from(tile.loudest).max(f64::MIN_POSITIVE)
    });
    let part = MARGIN * off.fold(0.0, f64::max);
    let least = |tile: &Tile| least(part * f64::from(tile.loudest), allowed) as f32;
    let is_weak = |tile: &&Tile| tile.least < least(tile);
    let weak = tiles.iter().filter(is_weak).flat_map(|tile| {
        let (width, least) = (width, least(tile));
        let pixels =
            tile.rows.clone().flat_map(move |row| tile.columns.clone().map(move |x| row * width + x));
        let values = &*values;
        pixels.filter(move |&pixel| values[pixel] < least)
    });
    let most = MOST * values.len() / job.request.aperture.driven.len().max(2 * MOST);
    let weak: Vec<_> = weak.take(most + 1).collect();
    let worst = tiles.iter().map(|tile| root_off(tile.least, part * f64::from(tile.loudest)));
    let worst = worst.fold(0.0, f64::max);
    if weak.len() > most {
        return worst;
    }
    for (pixel, mean) in weak.iter().zip(exact(&weak)) {
        values[*pixel] = mean as f32;
    }
    worst.min(allowed)
}

/// Error bound of a map's pixels, from those with the largest values in every part of it.
pub(super) fn off_at_loudest(job: &Job<'_>, values: &[f32]) -> f64 {
    let (width, height) = job.request.size;
    let Some(pixels) = Samples::on_plane(&job.request.plane, width, height) else { return 0.0 };
    let edge = |part: usize, count: usize| part * count / PARTS;
    let largest_of = |part: usize| {
        let (left, right) = (edge(part % PARTS, width), edge(part % PARTS + 1, width));
        let rows = edge(part / PARTS, height)..edge(part / PARTS + 1, height);
        let lines = rows.map(|row| (row * width + left, &values[row * width + left..row * width + right]));
        let largest = |line: &[f32]| line.iter().fold(0.0f32, |most, value| larger(value.abs(), most));
        let (first, line) = lines.max_by(|a, b| largest(a.1).total_cmp(&largest(b.1)))?;
        let most = largest(line);
        line.iter().position(|value| value.abs() == most).map(|place| first + place)
    };
    let places: Vec<_> = (0..PARTS * PARTS).into_par_iter().filter_map(largest_of).collect();
    let quantity = job.request.quantity;
    let means = job.means(0..job.excitations.len(), places.len(), |i| pixels.point(places[i])).into_iter();
    let off = means.zip(&places).map(|(mean, &place)| {
        (quantity.exact_value(job.request.part * mean) - f64::from(values[place])).abs()
    });
    MARGIN * off.fold(0.0, f64::max)
}

/// The least square whose root is off by no more than `allowed`, if it is off by `off` itself.
fn least(off: f64, allowed: f64) -> f64 {
    if off <= allowed * allowed { 0.0 } else { ((off + allowed * allowed) / (2.0 * allowed)).powi(2) }
}

/// Error bound of the root of a square.
fn root_off(square: f32, off: f64) -> f64 {
    let square = f64::from(square);
    let root = square.max(0.0).sqrt();
    let least = (square - off).max(0.0).sqrt();
    let most = (square + off).max(0.0).sqrt();
    (root - least).max(most - root)
}

/// The weakest tile of every part of the map, relative to its loudest cell.
fn risky(tiles: &[Tile], (width, height): (usize, usize)) -> Vec<&Tile> {
    let mut parts: Vec<Option<&Tile>> = vec![None; PARTS * PARTS];
    let ratio = |tile: &Tile| tile.least / tile.loudest;
    for tile in tiles.iter().filter(|tile| tile.loudest > 0.0) {
        let part = (tile.rows.start * PARTS / height) * PARTS + tile.columns.start * PARTS / width;
        if parts[part].is_none_or(|other| ratio(tile) < ratio(other)) {
            parts[part] = Some(tile);
        }
    }
    parts.into_iter().flatten().collect()
}

fn tiles(cells: (&[f32], usize), [across, up]: [&Resampling; 2], values: &[f32]) -> Vec<Tile> {
    let (cells, columns) = cells;
    let groups = |along: &Resampling| -> Vec<(usize, Range<usize>)> {
        let mut end = 0;
        let group = |pixels: &[u32]| {
            let start = end;
            end += pixels.len();
            (pixels[0] as usize, start..end)
        };
        along.first.chunk_by(|a, b| a == b).map(group).collect()
    };
    let (across_groups, up_groups) = (groups(across), groups(up));
    let loudest = |values: &mut dyn Iterator<Item = f32>| values.fold(0.0f32, f32::max);
    // Of every row of cells, for every group of columns.
    let of_rows: Vec<f32> = cells
        .par_chunks(columns)
        .flat_map_iter(|row| {
            let of = |(first, _): &(usize, Range<usize>)| row[*first..first + across.taps].iter().copied();
            across_groups.iter().map(move |group| loudest(&mut of(group)))
        })
        .collect();
    let count = across_groups.len();
    let of_group = |(first, rows): &(usize, Range<usize>)| {
        let (first, rows) = (*first, rows.clone());
        let of_rows = &of_rows;
        across_groups.iter().enumerate().map(move |(group, (_, columns))| {
            let mut tile = Tile {
                rows: rows.clone(),
                columns: columns.clone(),
                weakest: 0,
                least: f32::INFINITY,
                largest: 0.0,
                loudest: loudest(&mut (first..first + up.taps).map(|row| of_rows[row * count + group])),
            };
            for row in rows.clone() {
                let start = row * across.len();
                for (column, &value) in
                    columns.clone().zip(&values[start + columns.start..start + columns.end])
                {
                    if value < tile.least {
                        (tile.least, tile.weakest) = (value, start + column);
                    }
                    tile.largest = tile.largest.max(value);
                }
            }
            tile
        })
    };
    up_groups.par_iter().flat_map_iter(of_group).collect()
}
