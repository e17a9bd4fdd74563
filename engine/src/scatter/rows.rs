//! What bodies make of every element's sound at fixed points, in f32: a drive costs one product.

use std::f32::consts::PI;

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::scatter::waves::{LANES, Lanes, each, inverse_roots, phasor};
use crate::simd::{Instructions, Isa, Kernel, fused, larger};

/// Elements whose sums are in registers together.
const GROUP: usize = 8;

/// Rows of the transfer from elements to points by bodies.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Elements, and zeros up to whole registers.
    width: usize,
    /// Real parts and imaginary parts of every point's row.
    rows: Vec<f32>,
}

impl Rows {
    /// Room for a number of elements and points; `None` beyond a number of bytes.
    pub(super) fn zeros(elements: usize, points: usize, most: usize) -> Option<Self> {
        let width = elements.next_multiple_of(LANES);
        let bytes = points.checked_mul(8 * width)?;
        (bytes <= most).then(|| Self { width, rows: vec![0.0; bytes / 4] })
    }

    /// Real and imaginary parts of every point's row.
    pub(super) fn each_mut(&mut self) -> impl IndexedParallelIterator<Item = (&mut [f32], &mut [f32])> {
        let width = self.width;
        self.rows.par_chunks_mut(2 * width).map(move |row| row.split_at_mut(width))
    }

    /// The pressures (Pa) of a drive, a value per element, at every point.
    pub fn pressures(&self, drive: &[Complex64]) -> Vec<Complex32> {
        /// Points of a task.
        const TASK: usize = 256;
        let part = |part: fn(&Complex64) -> f64| {
            let mut values: Vec<_> = drive.iter().map(|u| part(u) as f32).collect();
            values.resize(self.width, 0.0);
            values
        };
        let drive = [part(|u| u.re), part(|u| u.im)];
        let row = 2 * self.width;
        let of_task = |rows: &[f32]| {
            rows.chunks(row).map(|row| Isa::best().run(Row { row, drive: &drive })).collect::<Vec<_>>()
        };
        self.rows.par_chunks(TASK * row.max(1)).flat_map_iter(of_task).collect()
    }
}

/// A row times a drive.
struct Row<'a> {
    row: &'a [f32],
    drive: &'a [Vec<f32>; 2],
}

impl Kernel for Row<'_> {
    type Output = Complex32;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Complex32 {
        let (re, im) = self.row.split_at(self.row.len() / 2);
        let [mut sum_re, mut sum_im] = [[0.0; LANES]; 2];
        let (re, _) = re.as_chunks::<LANES>();
        let (im, _) = im.as_chunks::<LANES>();
        let [u, v] = [0, 1].map(|part| self.drive[part].as_chunks::<LANES>().0);
        for (((a, b), u), v) in re.iter().zip(im).zip(u).zip(v) {
            sum_re = each(|l| fused::<I>(a[l], u[l], fused::<I>(-b[l], v[l], sum_re[l])));
            sum_im = each(|l| fused::<I>(a[l], v[l], fused::<I>(b[l], u[l], sum_im[l])));
        }
        Complex32::new(sum_re.iter().sum(), sum_im.iter().sum())
    }
}

/// The rule of three points of all triangles, without strengths.
pub(super) struct Sources {
    /// Places (half turns, from a middle) and normals, three for every triangle.
    pub places: Vec<[f32; 6]>,
    /// Nodes of every triangle.
    pub nodes: Vec<[u32; 3]>,
    /// A third of the area by 4π, in squares of half turns.
    pub areas: Vec<f32>,
    /// πβ
    pub leak: f32,
    /// Least distance, half turns.
    pub least: f32,
    /// Number of nodes.
    pub count: usize,
}

/// Answers to elements, in groups: the real parts of a group at a node, and its imaginary parts.
pub(super) struct Columns {
    groups: Vec<Vec<[f32; 2 * GROUP]>>,
}

impl Columns {
    /// Those of nodes' values of every element.
    pub fn new<'a>(columns: impl Iterator<Item = &'a [Complex64]>) -> Self {
        let all: Vec<_> = columns.collect();
        let nodes = all.first().map_or(0, |own| own.len());
        let group = |own: &[&[Complex64]]| {
            let at = |node: usize| {
                let mut values = [0.0; 2 * GROUP];
                for (n, column) in own.iter().enumerate() {
                    (values[n], values[GROUP + n]) = (column[node].re as f32, column[node].im as f32);
                }
                values
            };
            (0..nodes).map(at).collect()
        };
        Self { groups: all.chunks(GROUP).map(group).collect() }
    }
}

/// The sound of all answers at a run of at most [`LANES`] points, with corrections of the nodes' weights at each: real and
/// imaginary parts for every element.
pub(super) struct Run<'a> {
    pub sources: &'a Sources,
    pub columns: &'a Columns,
    /// Half turns from the middle; beyond the last the last again.
    pub places: [Lanes; 3],
    /// Lane, node and what its weight lacks.
    pub corrections: &'a [(usize, u32, Complex64)],
}

impl Kernel for Run<'_> {
    type Output = Vec<[Lanes; 2]>;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Self::Output {
        let Self { sources, columns, places: [xs, ys, zs], corrections } = self;
        let nearest = sources.least * sources.least;
        let mut weights = vec![[[0.0f32; LANES]; 2]; sources.count];
        let (threes, _) = sources.places.as_chunks::<3>();
        for ((three, nodes), area) in threes.iter().zip(&sources.nodes).zip(&sources.areas) {
            let mut own = [[[0.0f32; LANES]; 2]; 3];
            for (own, &[x, y, z, nx, ny, nz]) in own.iter_mut().zip(three) {
                let (dx, dy, dz) = (each(|l| x - xs[l]), each(|l| y - ys[l]), each(|l| z - zs[l]));
                let r2 = each(|l| {
                    larger(fused::<I>(dx[l], dx[l], fused::<I>(dy[l], dy[l], dz[l] * dz[l])), nearest)
                });
                let inverse = inverse_roots::<I, LANES>(&r2);
                let [g, cosine, sine] = phasor::<I, LANES>(&each(|l| r2[l] * inverse[l]), &inverse);
                let along = each(|l| fused::<I>(dx[l], nx, fused::<I>(dy[l], ny, dz[l] * nz)) * inverse[l]);
                let a = each(|l| -along[l] * inverse[l] * g[l]);
                let b = each(|l| -fused::<I>(along[l], PI, sources.leak) * g[l]);
                own[0] = each(|l| area * fused::<I>(a[l], cosine[l], b[l] * sine[l]));
                own[1] = each(|l| area * fused::<I>(b[l], cosine[l], -(a[l] * sine[l])));
            }
            for part in 0..2 {
                // A corner has two thirds of the point next to it, and a sixth of the others.
                let sixth = each(|l| (own[0][part][l] + own[1][part][l] + own[2][part][l]) * (1.0 / 6.0));
                for (corner, node) in nodes.iter().enumerate() {
                    let to = &mut weights[*node as usize][part];
                    *to = each(|l| fused::<I>(0.5, own[corner][part][l], to[l] + sixth[l]));
                }
            }
        }
        for &(lane, node, lack) in corrections {
            weights[node as usize][0][lane] += lack.re as f32;
            weights[node as usize][1][lane] += lack.im as f32;
        }
        let mut all = Vec::with_capacity(columns.groups.len() * GROUP);
        for group in &columns.groups {
            let mut sums = [[[0.0f32; LANES]; 2]; GROUP];
            for ([re, im], values) in weights.iter().zip(group) {
                for (n, sum) in sums.iter_mut().enumerate() {
                    let (u, v) = (values[n], values[GROUP + n]);
                    sum[0] = each(|l| fused::<I>(re[l], u, fused::<I>(-v, im[l], sum[0][l])));
                    sum[1] = each(|l| fused::<I>(re[l], v, fused::<I>(u, im[l], sum[1][l])));
                }
            }
            all.extend(sums);
        }
        all
    }
}

/// Points (m) from a middle in lanes, half turns.
pub(super) fn lanes_of(points: &[DVec3], middle: DVec3, per_metre: f64) -> [Lanes; 3] {
    let place = |lane: usize| (points[lane.min(points.len() - 1)] - middle) * per_metre;
    [0, 1, 2].map(|axis| each(|lane| place(lane)[axis] as f32))
}
