//! Corrections of the entries between near triangles: accurate integrals less the rule of three points, in rows.

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::collections::HashMap;

use glam::DVec3;

use crate::scatter::facets::{self, Facet, Wall};
use crate::simd::{Instructions, Isa, Kernel, fused64};

/// A sparse matrix by rows.
#[derive(Clone, Debug)]
pub(super) struct Near {
    /// First entry of each row, and their number.
    starts: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<Complex32>,
}

impl Near {
    /// Corrections and the mass matrix times a factor, between nodes with these places in the sequence of the rows.
    pub fn new(wall: &Wall, facets: &[Facet], places: &[u32], mass: f64) -> Self {
        /// Pairs whose entries are held at once.
        const RUN: usize = 1 << 14;
        let pairs = near_pairs(facets);
        let (mut starts, columns) = pattern(facets, places, &pairs);
        let mut values = vec![Complex64::ZERO; columns.len()];
        for pairs in pairs.chunks(RUN) {
            let of_pair = |&(a, b): &(u32, u32)| {
                let (first, second) = (&facets[a as usize], &facets[b as usize]);
                let (mut good, rough) =
                    (facets::accurate(wall, first, second), facets::rough(wall, first, second));
                for way in 0..2 {
                    for i in 0..3 {
                        for j in 0..3 {
                            good[way][i][j] -= rough[way][i][j];
                            if a == b {
                                good[way][i][j] +=
                                    mass * first.area * if i == j { 1.0 / 6.0 } else { 1.0 / 12.0 };
                            }
                        }
                    }
                }
                good
            };
            let entries: Vec<_> = pairs.par_iter().map(of_pair).collect();
            // One after the other, so that sums do not depend on the number of threads.
            for (&(a, b), entries) in pairs.iter().zip(&entries) {
                let nodes =
                    [a, b].map(|facet| facets[facet as usize].nodes.map(|node| places[node as usize]));
                for way in 0..if a == b { 1 } else { 2 } {
                    for i in 0..3 {
                        let row = nodes[way][i] as usize;
                        let first = starts[row] as usize;
                        let own = &columns[first..starts[row + 1] as usize];
                        for j in 0..3 {
                            if let Ok(at) = own.binary_search(&nodes[1 - way][j]) {
                                values[first + at] += entries[way][i][j];
                            }
                        }
                    }
                }
            }
        }
        starts.shrink_to_fit();
        let values = values.iter().map(|v| Complex32::new(v.re as f32, v.im as f32)).collect();
        Self { starts, columns, values }
    }

    /// Columns and values of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, Complex64)> {
        let own = self.starts[row] as usize..self.starts[row + 1] as usize;
        let entries = self.columns[own.clone()].iter().zip(&self.values[own]);
        entries.map(|(&column, v)| (column as usize, Complex64::new(v.re.into(), v.im.into())))
    }

    /// Adds A x or Aᵀ x for several x.
    pub fn add(&self, vectors: &[Vec<Complex64>], is_transposed: bool, sums: &mut [Vec<Complex64>]) {
        let groups = sums.par_chunks_mut(LANES).zip(vectors.par_chunks(LANES));
        groups.for_each(|(sums, vectors)| {
            let number = |i: usize| {
                let mut number = [[0.0; LANES]; 2];
                for (lane, vector) in vectors.iter().enumerate() {
                    (number[0][lane], number[1][lane]) = (vector[i].re, vector[i].im);
                }
                number
            };
            let x: Vec<_> = (0..vectors[0].len()).map(number).collect();
            let mut to = vec![[[0.0; LANES]; 2]; x.len()];
            Isa::best().run(Product { near: self, x: &x, is_transposed, to: &mut to });
            for (lane, sum) in sums.iter_mut().enumerate() {
                let pairs = sum.iter_mut().zip(&to);
                pairs.for_each(|(sum, part)| *sum += Complex64::new(part[0][lane], part[1][lane]));
            }
        });
    }

    /// Bytes.
    pub fn size(&self) -> usize {
        self.values.len() * 12 + self.starts.len() * 4
    }
}

/// Vectors that are taken at once.
const LANES: usize = 8;

/// Real and imaginary parts of a number of each vector.
type Eight = [[f64; LANES]; 2];

/// to += A x or Aᵀ x.
struct Product<'a> {
    near: &'a Near,
    x: &'a [Eight],
    is_transposed: bool,
    to: &'a mut [Eight],
}

impl Kernel for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { near, x, is_transposed, to } = self;
        for row in 0..x.len() {
            let own = near.starts[row] as usize..near.starts[row + 1] as usize;
            let mut sum = [[0.0; LANES]; 2];
            for (&column, value) in near.columns[own.clone()].iter().zip(&near.values[own]) {
                let (column, re, im) = (column as usize, f64::from(value.re), f64::from(value.im));
                let (x, to) = if is_transposed { (&x[row], &mut to[column]) } else { (&x[column], &mut sum) };
                for lane in 0..LANES {
                    to[0][lane] = fused64::<I>(re, x[0][lane], fused64::<I>(-im, x[1][lane], to[0][lane]));
                    to[1][lane] = fused64::<I>(re, x[1][lane], fused64::<I>(im, x[0][lane], to[1][lane]));
                }
            }
            for part in 0..2 {
                for lane in 0..LANES {
                    to[row][part][lane] += sum[part][lane];
                }
            }
        }
    }
}

/// First entry of each row, and the columns of all entries in ascending order: nodes of near triangles.
fn pattern(facets: &[Facet], places: &[u32], pairs: &[(u32, u32)]) -> (Vec<u32>, Vec<u32>) {
    let mut near = vec![Vec::new(); facets.len()];
    for &(a, b) in pairs {
        near[a as usize].push(b);
        if a != b {
            near[b as usize].push(a);
        }
    }
    let mut around = vec![Vec::new(); places.len()];
    for (number, facet) in facets.iter().enumerate() {
        facet.nodes.iter().for_each(|&node| around[places[node as usize] as usize].push(number));
    }
    let row = |triangles: &Vec<usize>| {
        let near = triangles.iter().flat_map(|&triangle| &near[triangle]);
        let nodes = near.flat_map(|&other| facets[other as usize].nodes);
        let mut row: Vec<_> = nodes.map(|node| places[node as usize]).collect();
        row.sort_unstable();
        row.dedup();
        row
    };
    let rows: Vec<Vec<u32>> = around.par_iter().map(row).collect();
    let mut starts = vec![0];
    for row in &rows {
        starts.push(starts[starts.len() - 1] + row.len() as u32);
    }
    (starts, rows.concat())
}

/// All near pairs of triangles, the smaller number first, in ascending order.
fn near_pairs(facets: &[Facet]) -> Vec<(u32, u32)> {
    // Cells as wide as the reach of the largest triangles would hold too many small ones: a grid for each size, by
    // powers of two; a pair meets in the grid of the larger.
    let level = |facet: &Facet| (facet.radius * facets::NEAR * 2.0).log2().ceil() as i32;
    let key = |at: DVec3, level: i32| {
        let cell = (at / f64::from(level).exp2()).floor();
        (level, cell.x as i64, cell.y as i64, cell.z as i64)
    };
    let mut levels: Vec<i32> = facets.iter().map(level).collect();
    let of_facet = levels.clone();
    levels.sort_unstable();
    levels.dedup();
    let mut cells: HashMap<_, Vec<u32>> = HashMap::new();
    for (number, facet) in facets.iter().enumerate() {
        for &level in levels.iter().filter(|level| **level >= of_facet[number]) {
            cells.entry(key(facet.centroid, level)).or_default().push(number as u32);
        }
    }
    let of = |number: usize| {
        let facet = &facets[number];
        let (level, x, y, z) = key(facet.centroid, of_facet[number]);
        let mut near = Vec::new();
        for i in 0..27 {
            let beside = (level, x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1);
            for &other in cells.get(&beside).into_iter().flatten() {
                let is_mine = of_facet[other as usize] < level || other as usize >= number;
                if is_mine && facet.is_near(&facets[other as usize]) {
                    near.push(((number as u32).min(other), (number as u32).max(other)));
                }
            }
        }
        near
    };
    let mut pairs: Vec<_> = (0..facets.len()).into_par_iter().flat_map_iter(of).collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn near_pairs_are_all_near_pairs() {
        // Triangles of very different sizes.
        let corner = |i: usize| {
            let unit = |step: f64| (i as f64 * step).fract();
            DVec3::new(unit(0.618_034), unit(0.754_878), unit(0.569_84))
        };
        let vertices: Vec<_> = (0..80)
            .flat_map(|i| {
                let (at, size) = (corner(3 * i), 0.3f64.powi(1 + i as i32 % 4));
                [0, 1, 2].map(|c| at + size * (corner(3 * i + c + 7) - DVec3::splat(0.5)))
            })
            .collect();
        let triangles = (0..80).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let facets = Facet::all(&Mesh { vertices, triangles });
        let mut expected = Vec::new();
        for a in 0..80 {
            for b in a..80 {
                if facets[a].is_near(&facets[b]) {
                    expected.push((a as u32, b as u32));
                }
            }
        }
        assert_eq!(near_pairs(&facets), expected);
        assert!((100..2000).contains(&expected.len()), "{}", expected.len());
    }
}
