//! Boundary elements: the pressure on any body, and what it scatters.
//!
//! With G = e^{-jkR}/(4πR), n outwards and ∂p/∂n = jkβ p on the surface (β = 0: rigid), the sound outside is
//!
//! p = p_in + ∫ p (∂G/∂n_y - jkβ G) dS.
//!
//! On the surface this and its normal slope are two equations, each without unique solution at the wavenumbers at which
//! the inside resonates. Their sum with the factor α = -j/k has one at all (A. J. Burton, G. F. Miller, Proc. R. Soc.
//! A 323, 201, 1971): with the layers K p = ∫ p ∂G/∂n_y, its twin K', V p = ∫ p G and the hypersingular -W,
//!
//! ((1 + β)/2 - K + jkβ V + β K' + α W) p = p_in + α ∂p_in/∂n.
//!
//! Pressures are linear on every flat triangle, and the equation holds in the mean with each node's linear function
//! (Galerkin), which lets Maue's formula turn W into integrable kernels and makes scattered pressures converge by the
//! square of the edge and faster. Those of sharp edges need no normal at nodes.
//!
//! The nodes' values are those of a best fit, and therefore larger than the pressure p by -(σ²/2) Δp, σ² the variance of
//! a node's function: means of neighbours by the mass matrix show twice that difference, and [`Boundary::surface`] takes
//! half of it away.
//!
//! The matrix in f32 has three parts: blocks by one rule for all pairs ([`crate::scatter::hierarchy`]), corrections of
//! near pairs, and the mass. Generalised minimal residuals solve with it, prepared by the inverses of the blocks on the
//! diagonal. It belongs to shape, admittance and wavenumber: a body that moves keeps it.

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;
use thiserror::Error;

use crate::memory;
use crate::mesh::{Inside, Mesh};
use crate::scatter::emission::Emission;
use crate::scatter::facets::{Facet, THREE, Wall};
use crate::scatter::gmres::{self, Outcome};
use crate::scatter::grid::Grid;
use crate::scatter::hierarchy::{Hierarchy, Tree};
use crate::scatter::near::Near;
use crate::scatter::patch::{self, Patch, Sound};
use crate::scatter::radiation::{CLEAR, Radiation};
use crate::scatter::rows::{Columns, Rows, Run, lanes_of};
use crate::scatter::waves::LANES;
use crate::simd::Isa;

/// Residual at which solving ends, relative to the right side.
pub const TOLERANCE: f64 = 1e-5;
/// Depth (m) up to which a point inside is on the surface, and its height then.
pub(super) const SKIN: f64 = 3e-5;
const HAIR: f64 = 2e-6;
/// Most steps of an iteration.
const MOST_STEPS: usize = 200;
/// Most points inside at which a solution is tried.
const MOST_INNER: usize = 300;
/// Errors outside relative to what is left inside.
const LEFT_FACTOR: f64 = 3.0;
/// Errors of corrected values relative to the correction.
const CHANGE_FACTOR: f64 = 0.35;
/// Errors by flat triangles on a round body, relative to the phase of their distance from it.
const FACETS_FACTOR: f64 = 1.4;
/// Angle between normals (rad) from which an edge is meant to be sharp.
const SHARP: f64 = 1.05;
/// Cosine between normals of triangles around a node up to which the surface is smooth there.
const SMOOTH: f64 = 0.8;

/// A body's surface at one wavenumber, ready to be solved for any incident sound.
#[derive(Clone, Debug)]
pub struct Boundary {
    wall: Wall,
    mesh: Mesh,
    facets: Vec<Facet>,
    /// Finds triangles near a point.
    grid: Grid,
    inside: Inside,
    /// Vertices in the sequence of the matrix.
    order: Vec<u32>,
    matrix: Hierarchy,
    near: Near,
    /// Inverses of the blocks on the diagonal, row by row, with their first node.
    inverses: Vec<(usize, Vec<Complex64>)>,
}

/// A body with more triangles than the memory holds.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("a body of {triangles} triangles needs {mebibytes} MiB, more than is free: choose longer edges")]
pub struct TooLarge {
    pub triangles: usize,
    pub mebibytes: usize,
}

/// Bounds on errors, root mean squares: of the pressure on the surface relative to itself, and of the scattered pressure
/// around the body relative to that on the surface.
///
/// The solution's sound does not quite cancel the incident sound inside. What is left just below the surface is the
/// error of the boundary condition between the nodes. Values at vertices are off by a part of their correction
/// ([`Boundary::surface`]), too, and flat triangles by their distance from the round body that they stand for. The factors
/// of these three parts come from 435 random spheres, capsules, slabs, small hands and joined capsules with edges of λ/4
/// to λ/12: with 0.9 for the last one, bounds were 2.3 times the error on the surface and 3.8 times that outside by the
/// median, and six were exceeded, by four tenths at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyError {
    pub surface: f64,
    pub outside: f64,
}

impl Boundary {
    /// The surface of a body with a pressure reflection, above -1 and up to 1, for a wavenumber (rad/m).
    ///
    /// # Errors
    /// A matrix larger than the free memory.
    pub fn new(mesh: &Mesh, coefficient: f64, wavenumber: f64) -> Result<Self, TooLarge> {
        let nodes = mesh.vertices.len() as f64;
        // All entries, or blocks: 300 MB while they are made for 10 242 nodes.
        let bytes = (8.0 * nodes * nodes).min(400.0 * nodes.powf(1.5)) as usize;
        let _room = memory::reserve(bytes)
            .ok_or(TooLarge { triangles: mesh.triangles.len(), mebibytes: bytes >> 20 })?;
        let wall = Wall { wavenumber, admittance: (1.0 - coefficient) / (1.0 + coefficient) };
        let facets = Facet::all(mesh);
        let tree = Tree::new(&mesh.vertices);
        let mut places = vec![0; tree.order.len()];
        tree.order.iter().zip(0..).for_each(|(&node, place)| places[node as usize] = place);
        let matrix = Hierarchy::new(&wall, &facets, &tree);
        let near = Near::new(&wall, &facets, &places, (1.0 + wall.admittance) / 2.0);
        let inverse = |leaf: std::ops::Range<usize>| {
            let mut block = matrix.own(&leaf);
            for row in leaf.clone() {
                for (column, value) in near.row(row).filter(|(column, _)| leaf.contains(column)) {
                    block[(row - leaf.start) * leaf.len() + column - leaf.start] += value;
                }
            }
            (leaf.start, inverted(block, leaf.len()))
        };
        let leaves: Vec<_> = tree.leaves().collect();
        let inverses = leaves.into_par_iter().map(inverse).collect();
        let grid = Grid::new(&facets, CLEAR);
        let inside = Inside::new(mesh);
        Ok(Self { wall, mesh: mesh.clone(), facets, grid, inside, order: tree.order, matrix, near, inverses })
    }

    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Whether a point (m) is inside, deeper than the skin: up to there it counts as just outside, since a plane in a flat
    /// face is on either side of it.
    pub fn contains(&self, at: DVec3) -> bool {
        self.inside.contains(at) && self.outside(at).is_none()
    }

    /// The place (m) just outside of a point in the skin.
    pub fn lifted(&self, at: DVec3) -> DVec3 {
        if self.inside.contains(at) { self.outside(at).unwrap_or(at) } else { at }
    }

    fn outside(&self, at: DVec3) -> Option<DVec3> {
        let facets = self.grid.around(at).map(|number| &self.facets[number]);
        let near = facets.map(|facet| (facet.nearest(at), facet.normal));
        let nearest = near.min_by(|(one, _), (other, _)| one.distance(at).total_cmp(&other.distance(at)))?;
        let (place, normal) = nearest;
        (place.distance(at) < SKIN).then(|| place + normal * HAIR)
    }

    /// Bytes of the matrix.
    pub fn size(&self) -> usize {
        let inverses = self.inverses.iter().map(|(_, values)| values.len() * 16).sum::<usize>();
        self.matrix.size() + self.near.size() + inverses
    }

    /// The points (m) at which [`Self::right_side`] takes incident sound, with the surface's normals there.
    pub fn points(&self) -> (Vec<DVec3>, Vec<DVec3>) {
        let of = |facet: &Facet| facet.points().map(|at| (at, facet.normal));
        self.facets.iter().flat_map(of).unzip()
    }

    /// The right side for incident sound with these pressures (Pa) and slopes along the normals (Pa/m) at
    /// [`Self::points`].
    ///
    /// # Panics
    /// Other than a value per point.
    pub fn right_side(&self, pressures: &[Complex64], slopes: &[Complex64]) -> Vec<Complex64> {
        assert_eq!((pressures.len(), slopes.len()), (3 * self.facets.len(), 3 * self.facets.len()));
        let alpha = self.alpha();
        let mut right = vec![Complex64::ZERO; self.mesh.vertices.len()];
        for (index, facet) in self.facets.iter().enumerate() {
            for (point, weights) in THREE.iter().enumerate() {
                let both = pressures[3 * index + point] + alpha * slopes[3 * index + point];
                for (node, weight) in facet.nodes.iter().zip(weights) {
                    right[*node as usize] += both * (weight * facet.area / 3.0);
                }
            }
        }
        right
    }

    /// The weights of pressures and of slopes at [`Self::points`] in Σ q b, b their right side and q a value per node.
    pub fn right_side_weights(&self, values: &[Complex64]) -> (Vec<Complex64>, Vec<Complex64>) {
        let alpha = self.alpha();
        let of = |facet: &Facet| {
            let q = facet.nodes.map(|node| values[node as usize]);
            let area = facet.area / 3.0;
            THREE.map(|w| (q[0] * w[0] + q[1] * w[1] + q[2] * w[2]) * area)
        };
        let pressures: Vec<_> = self.facets.iter().flat_map(of).collect();
        let slopes = pressures.iter().map(|weight| weight * alpha).collect();
        (pressures, slopes)
    }

    /// Pressures at the nodes for right sides, to a residual ([`TOLERANCE`]), from earlier pressures if there are any.
    pub fn solve(
        &self,
        rights: &[Vec<Complex64>],
        starts: Option<&[Vec<Complex64>]>,
        tolerance: f64,
    ) -> Vec<Outcome> {
        self.solve_by(rights, starts, tolerance, false)
    }

    /// Solutions q of Aᵀ q = d. With d of [`Self::weights`] at a point, Σ q b is the scattered pressure there of any
    /// right side b.
    pub fn solve_transposed(
        &self,
        rights: &[Vec<Complex64>],
        starts: Option<&[Vec<Complex64>]>,
        tolerance: f64,
    ) -> Vec<Outcome> {
        self.solve_by(rights, starts, tolerance, true)
    }

    /// A x, or Aᵀ x, a value per node.
    pub fn times(&self, vectors: &[Vec<Complex64>], is_transposed: bool) -> Vec<Vec<Complex64>> {
        let products = self.product(&self.sorted(vectors), is_transposed);
        products.iter().map(|product| self.unsorted(product)).collect()
    }

    /// Scattered pressures (Pa) of nodes' pressures at points (m) outside, in f32.
    pub fn scattered(&self, nodal: &[Complex64], points: &[DVec3]) -> Vec<Complex64> {
        self.scattered_by_all(&[nodal], points).remove(0)
    }

    /// The same of several, each with a pressure per node: four cost as much as two alone.
    #[doc(hidden)]
    pub fn scattered_by_all(&self, nodals: &[&[Complex64]], points: &[DVec3]) -> Vec<Vec<Complex64>> {
        let radiations: Vec<_> = nodals.iter().map(|nodal| self.radiation(nodal)).collect();
        Radiation::pressures(&radiations, points)
    }

    /// Pressures and gradients (Pa/m), likewise.
    #[doc(hidden)]
    pub fn sounds(&self, nodal: &[Complex64], points: &[DVec3]) -> Vec<Sound> {
        self.radiation(nodal).sounds(points)
    }

    /// The sources of both as plain data; [`Self::corrections`] adds what they lack near the surface.
    #[doc(hidden)]
    pub fn emission(&self, nodal: &[Complex64]) -> Emission {
        self.radiation(nodal).emission()
    }

    /// Adds the sound of nodes' pressures for every element to a table's rows at points (m) outside, times a gain.
    pub(super) fn tabulate(&self, columns: &Columns, points: &[DVec3], gain: f32, table: &mut Rows) {
        let middle = self.facets.iter().map(|facet| facet.centroid).sum::<DVec3>() / self.facets.len() as f64;
        let sources = Radiation::sources(&self.wall, &self.facets, self.mesh.vertices.len(), middle);
        let per_metre = self.wall.wavenumber / PI;
        let runs = table.each_mut().chunks(LANES).zip(points.par_chunks(LANES));
        runs.for_each(|(rows, points)| {
            let lacks = |(lane, at): (usize, &DVec3)| {
                let own = Radiation::lacks(&self.wall, &self.facets, &self.grid, *at);
                own.into_iter().map(move |(node, lack)| (lane, node, lack))
            };
            let corrections: Vec<_> = points.iter().enumerate().flat_map(lacks).collect();
            let places = lanes_of(points, middle, per_metre);
            let run = Run { sources: &sources, columns, places, corrections: &corrections };
            let sums = Isa::best().run(run);
            for (lane, (re, im)) in rows.into_iter().enumerate() {
                for ((re, im), [a, b]) in re.iter_mut().zip(im).zip(&sums) {
                    *re += gain * a[lane];
                    *im += gain * b[lane];
                }
            }
        });
    }

    /// What the sums of [`Self::emission`] lack at points (m) near the surface.
    #[doc(hidden)]
    pub fn corrections(&self, nodal: &[Complex64], points: &[DVec3]) -> Vec<Sound> {
        self.radiation(nodal).corrections(points)
    }

    /// Scattered sound of nodes' pressures at points (m) outside, in f64.
    pub fn sound(&self, nodal: &[Complex64], points: &[DVec3]) -> Vec<Sound> {
        let radiation = self.radiation(nodal);
        points.par_iter().map(|at| radiation.sound(*at)).collect()
    }

    fn radiation(&self, nodal: &[Complex64]) -> Radiation<'_> {
        Radiation::new(self.wall, &self.facets, &self.grid, nodal)
    }

    /// The weights of the nodes' pressures in the scattered pressure at a point (m) outside, and in its slopes along the
    /// axes.
    pub fn weights(&self, at: DVec3) -> Vec<[Complex64; 4]> {
        Radiation::weights(self.wall, &self.facets, self.mesh.vertices.len(), at)
    }

    /// The pressures (Pa) on the surface at the vertices, from the nodes' values of a solution.
    pub fn surface(&self, nodal: &[Complex64]) -> Vec<Complex64> {
        let (mut means, mut areas) = (vec![Complex64::ZERO; nodal.len()], vec![0.0; nodal.len()]);
        let mut normals = vec![DVec3::ZERO; nodal.len()];
        for facet in &self.facets {
            let total: Complex64 = facet.nodes.iter().map(|node| nodal[*node as usize]).sum();
            for &node in &facet.nodes {
                let node = node as usize;
                means[node] += (total + nodal[node]) * (facet.area / 4.0);
                areas[node] += facet.area;
                normals[node] += facet.normal * facet.area;
            }
        }
        let mut is_smooth = vec![true; nodal.len()];
        for facet in &self.facets {
            for &node in &facet.nodes {
                let node = node as usize;
                is_smooth[node] &= normals[node].normalize_or_zero().dot(facet.normal) > SMOOTH;
            }
        }
        let corrected = |node: usize| match is_smooth[node] {
            true => (nodal[node] + means[node] / areas[node]) / 2.0,
            false => nodal[node],
        };
        (0..nodal.len()).map(corrected).collect()
    }

    /// The surface in small parts, with the total sound of a solution's nodes on it.
    pub fn patches(&self, nodal: &[Complex64]) -> Vec<Patch> {
        let slope = Complex64::new(0.0, self.wall.wavenumber * self.wall.admittance);
        patch::of_triangles(&self.mesh, &self.surface(nodal), slope)
    }

    /// Points (m) inside the body, two fifths of an edge below the surface, at which the sound of an exact solution
    /// would cancel the incident sound: of all parts of the surface, a few hundred at most.
    pub fn inner_points(&self) -> Vec<DVec3> {
        let step = self.facets.len().div_ceil(MOST_INNER);
        let point = |facet: &Facet| {
            // The radius of an equilateral triangle is its edge by √3.
            let at = facet.centroid - facet.normal * (0.4 * 3.0f64.sqrt() * facet.radius);
            self.inside.contains(at).then_some(at)
        };
        let facets: Vec<_> = self.facets.iter().step_by(step).collect();
        facets.par_iter().filter_map(|facet| point(facet)).collect()
    }

    /// Bounds on the errors of a solution, from incident pressures (Pa) at [`Self::points`] and at
    /// [`Self::inner_points`].
    ///
    /// # Panics
    /// Other than a pressure per point.
    pub fn error(&self, solution: &Outcome, incident: &[Complex64], inner: &[Complex64]) -> BodyError {
        let points = self.inner_points();
        assert_eq!(
            (incident.len(), inner.len()),
            (3 * self.facets.len(), points.len()),
            "a pressure per point"
        );
        let surface = self.surface(&solution.values);
        let mean = |squares: f64, weights: f64| (squares / weights.max(f64::MIN_POSITIVE)).sqrt();
        let scattered = self.scattered(&solution.values, &points);
        let left = scattered.iter().zip(inner).map(|(p, inner)| (p + inner).norm_sqr()).sum::<f64>();
        let left = mean(left, points.len() as f64);
        let (mut squares, mut changes, mut echoes, mut area) = (0.0, 0.0, 0.0, 0.0);
        for (index, facet) in self.facets.iter().enumerate() {
            let middle = incident[3 * index..3 * index + 3].iter().sum::<Complex64>() / 3.0;
            let mut own = Complex64::ZERO;
            for node in facet.nodes {
                let (p, node) = (surface[node as usize], solution.values[node as usize]);
                squares += p.norm_sqr() * facet.area / 3.0;
                changes += (p - node).norm_sqr() * facet.area / 3.0;
                own += p / 3.0;
            }
            echoes += (own - middle).norm_sqr() * facet.area;
            area += facet.area;
        }
        let [total, change, echo] = [squares, changes, echoes].map(|squares| mean(squares, area));
        let off = LEFT_FACTOR * (left + solution.residual * total);
        let part = |error: f64, of: f64| if of > 0.0 { error / of } else { 0.0 };
        let facets = FACETS_FACTOR * self.wall.wavenumber * self.sag();
        let [surface, outside] = [part(off + CHANGE_FACTOR * change, total), part(off, echo)];
        BodyError { surface: surface + facets, outside: outside + facets }
    }

    /// The height (m, root of the mean square over the area) of a round surface with these vertices above its triangles:
    /// h θ/8 for edges of length h between normals that differ by θ, unless the edge is sharp.
    fn sag(&self) -> f64 {
        let (mut squares, mut area) = (0.0, 0.0);
        for ([a, b], triangles) in self.mesh.edges() {
            let [one, other] = [0, triangles.len() - 1].map(|i| &self.facets[triangles[i] as usize]);
            let [a, b] = [a, b].map(|vertex| self.mesh.vertices[vertex as usize]);
            let angle = one.normal.angle_between(other.normal);
            if angle < SHARP {
                squares += (a.distance(b) * angle / 8.0).powi(2) * (one.area + other.area);
            }
            area += one.area + other.area;
        }
        (squares / area.max(f64::MIN_POSITIVE)).sqrt()
    }

    fn alpha(&self) -> Complex64 {
        Complex64::new(0.0, -1.0 / self.wall.wavenumber)
    }

    fn solve_by(
        &self,
        rights: &[Vec<Complex64>],
        starts: Option<&[Vec<Complex64>]>,
        tolerance: f64,
        is_transposed: bool,
    ) -> Vec<Outcome> {
        let starts = starts.map(|starts| self.sorted(starts));
        let solved = gmres::solve(
            &self.sorted(rights),
            starts.as_deref(),
            (tolerance, MOST_STEPS),
            |x| self.product(x, is_transposed),
            |x| self.prepared(x, is_transposed),
        );
        let unsorted = |outcome: Outcome| Outcome { values: self.unsorted(&outcome.values), ..outcome };
        solved.into_iter().map(unsorted).collect()
    }

    fn sorted(&self, vectors: &[Vec<Complex64>]) -> Vec<Vec<Complex64>> {
        vectors.iter().map(|x| self.order.iter().map(|&node| x[node as usize]).collect()).collect()
    }

    fn unsorted(&self, values: &[Complex64]) -> Vec<Complex64> {
        let mut all = vec![Complex64::ZERO; values.len()];
        self.order.iter().zip(values).for_each(|(&node, value)| all[node as usize] = *value);
        all
    }

    fn product(&self, vectors: &[Vec<Complex64>], is_transposed: bool) -> Vec<Vec<Complex64>> {
        let mut sums = self.matrix.times(vectors, is_transposed);
        self.near.add(vectors, is_transposed, &mut sums);
        sums
    }

    /// The rough inverse.
    fn prepared(&self, vectors: &[Vec<Complex64>], is_transposed: bool) -> Vec<Vec<Complex64>> {
        let of = |x: &Vec<Complex64>| {
            let mut all = Vec::with_capacity(x.len());
            for (first, inverse) in &self.inverses {
                let count = inverse.len().isqrt();
                let own = &x[*first..first + count];
                let entry =
                    |i: usize, j: usize| inverse[if is_transposed { j * count + i } else { i * count + j }];
                all.extend((0..count).map(|i| (0..count).map(|j| entry(i, j) * own[j]).sum::<Complex64>()));
            }
            all
        };
        vectors.par_iter().map(of).collect()
    }
}

/// The inverse of a matrix, row by row, by elimination with the largest pivots.
fn inverted(mut a: Vec<Complex64>, count: usize) -> Vec<Complex64> {
    let mut inverse = vec![Complex64::ZERO; count * count];
    (0..count).for_each(|i| inverse[i * count + i] = Complex64::ONE);
    for column in 0..count {
        let pivot = (column..count).fold(column, |best, row| {
            if a[row * count + column].norm_sqr() > a[best * count + column].norm_sqr() { row } else { best }
        });
        for j in 0..count {
            a.swap(column * count + j, pivot * count + j);
            inverse.swap(column * count + j, pivot * count + j);
        }
        let scale = Complex64::ONE / a[column * count + column];
        for j in 0..count {
            a[column * count + j] *= scale;
            inverse[column * count + j] *= scale;
        }
        for row in (0..count).filter(|row| *row != column) {
            let factor = a[row * count + column];
            for j in 0..count {
                let (own, other) = (a[column * count + j], inverse[column * count + j]);
                a[row * count + j] -= factor * own;
                inverse[row * count + j] -= factor * other;
            }
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::dvec3;

    use super::*;
    use crate::mesh::area_vector;
    use crate::mesh::shapes;
    use crate::scatter::Sphere;

    const K: f64 = 732.274_780;
    const WAVELENGTH: f64 = TAU / K;

    /// Incident sound with its gradient.
    type Incident<'a> = &'a dyn Fn(DVec3) -> Sound;

    /// e^{-jkR}/R from a point.
    fn from(source: DVec3) -> impl Fn(DVec3) -> Sound {
        move |at| {
            let (way, r) = (at - source, at.distance(source));
            let p = Complex64::cis(-K * r) / r;
            let slope = p * Complex64::new(-1.0 / r, -K) / r;
            (p, way.to_array().map(|x| slope * x))
        }
    }

    fn pressures(incident: Incident<'_>, points: &[DVec3]) -> Vec<Complex64> {
        points.iter().map(|at| incident(*at).0).collect()
    }

    fn right_side(boundary: &Boundary, incident: Incident<'_>) -> Vec<Complex64> {
        let (points, normals) = boundary.points();
        let slope = |(at, normal): (&DVec3, &DVec3)| -> Complex64 {
            incident(*at).1.iter().zip(normal.to_array()).map(|(slope, n)| slope * n).sum()
        };
        let slopes: Vec<_> = points.iter().zip(&normals).map(slope).collect();
        boundary.right_side(&pressures(incident, &points), &slopes)
    }

    fn solve(boundary: &Boundary, incident: Incident<'_>) -> Outcome {
        boundary.solve(&[right_side(boundary, incident)], None, TOLERANCE).remove(0)
    }

    /// The relative difference, root mean square.
    fn off(got: &[Complex64], expected: &[Complex64]) -> f64 {
        let square = |values: &mut dyn Iterator<Item = Complex64>| values.map(|x| x.norm_sqr()).sum::<f64>();
        let difference = square(&mut got.iter().zip(expected).map(|(a, b)| a - b));
        (difference / square(&mut expected.iter().copied())).sqrt()
    }

    /// Directions all around.
    fn directions(count: usize) -> Vec<DVec3> {
        let direction = |i: usize| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let (sine, cosine) = (2.399_963_23 * i as f64).sin_cos();
            let flat = (1.0 - z * z).sqrt();
            dvec3(flat * cosine, flat * sine, z)
        };
        (0..count).map(direction).collect()
    }

    /// Errors of a sphere on its surface and outside, and what is printed for them.
    fn sphere_errors(size: f64, edge: f64, coefficient: f64) -> ([f64; 2], BodyError) {
        let (radius, source) = (size / K, dvec3(0.02, -0.01, 0.1));
        let boundary = Boundary::new(&shapes::sphere(radius, edge), coefficient, K).unwrap();
        let incident = from(source);
        let solution = solve(&boundary, &incident);
        let sphere = Sphere::new(DVec3::ZERO, radius, coefficient, K);
        let exact = sphere.of_point_source(source);
        let surface: Vec<_> = boundary
            .mesh()
            .vertices
            .iter()
            .map(|at| sphere.on_surface(&exact, at.normalize_or_zero()))
            .collect();
        let outside: Vec<_> = [1.2, 2.0, 4.0]
            .into_iter()
            .flat_map(|r| directions(100).into_iter().map(move |direction| direction * (r * radius)))
            .collect();
        let scattered: Vec<_> = outside.iter().map(|at| sphere.scattered(&exact, *at).0).collect();
        let error = boundary.error(
            &solution,
            &pressures(&incident, &boundary.points().0),
            &pressures(&incident, &boundary.inner_points()),
        );
        let errors = [
            off(&boundary.surface(&solution.values), &surface),
            off(&boundary.scattered(&solution.values, &outside), &scattered),
        ];
        (errors, error)
    }

    #[test]
    fn spheres_are_those_of_the_series_resonant_or_not() {
        // 5.7635 is a zero of j₂, 4.4934 one of j₁ and of j₀'.
        for (size, coefficient) in [(3.0, 1.0), (4.4934, 1.0), (5.7635, 1.0), (10.0, 1.0), (5.7635, 0.5)] {
            let ([surface, outside], printed) = sphere_errors(size, WAVELENGTH / 6.0, coefficient);
            assert!(surface < 0.02 && outside < 0.02, "{size} {coefficient}: {surface} {outside}");
            assert!(surface < printed.surface && outside < printed.outside, "{size}: {printed:?}");
            assert!(printed.surface < 0.12 && printed.outside < 0.12, "{size}: {printed:?}");
        }
    }

    #[test]
    fn half_the_edge_leaves_a_quarter_of_the_error() {
        let [coarse, fine] = [4.0, 8.0].map(|part| sphere_errors(4.0, 1.1756 * 4.0 / K / part, 1.0).0);
        assert!(fine[0] < coarse[0] / 3.0 && fine[1] < coarse[1] / 4.0, "{coarse:?} {fine:?}");
    }

    #[test]
    fn a_triangle_without_area_does_no_harm() {
        let mesh = shapes::sphere(0.004, WAVELENGTH / 6.0);
        // A vertex in the middle of an edge, on one side only: a flat triangle closes the gap.
        let mut gap = mesh.clone();
        let [a, b, c] = mesh.triangles[7];
        let middle = mesh.vertices.len() as u32;
        gap.vertices.push(mesh.vertices[a as usize].midpoint(mesh.vertices[b as usize]));
        gap.triangles[7] = [a, middle, c];
        gap.triangles.extend([[middle, b, c], [a, b, middle]]);
        let gap = gap.closed().unwrap();
        let incident = from(dvec3(0.02, -0.01, 0.1));
        let points: Vec<_> = directions(50).into_iter().map(|direction| direction * 0.008).collect();
        let [one, other] = [mesh, gap].map(|mesh| {
            let boundary = Boundary::new(&mesh, 1.0, K).unwrap();
            boundary.scattered(&solve(&boundary, &incident).values, &points)
        });
        assert!(off(&other, &one) < 0.01, "{}", off(&other, &one));
    }

    #[test]
    fn sources_and_microphones_can_change_places() {
        let capsule =
            shapes::capsule(dvec3(-0.004, 0.0, 0.0), dvec3(0.006, 0.003, 0.0), 0.004, WAVELENGTH / 8.0);
        let boundary = Boundary::new(&capsule, 0.9, K).unwrap();
        let [one, other] = [dvec3(0.02, -0.01, 0.1), dvec3(-0.03, 0.02, 0.06)];
        let rights = [one, other].map(|source| right_side(&boundary, &from(source)));
        let [p, _] = &boundary.solve(&rights, None, 1e-8)[..] else { panic!() };
        // By the adjoint: weights of the incident sound in the pressure at the other point, exactly those of the matrix.
        let weights: Vec<_> = boundary.weights(other).into_iter().map(|[p, ..]| p).collect();
        let q = boundary.solve_transposed(std::slice::from_ref(&weights), None, 1e-8).remove(0);
        let product =
            |a: &[Complex64], b: &[Complex64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<Complex64>();
        let direct = product(&weights, &p.values);
        let adjoint = product(&q.values, &rights[0]);
        assert!((direct - adjoint).norm() < 1e-6 * direct.norm(), "{direct} {adjoint}");
        let (of_pressures, of_slopes) = boundary.right_side_weights(&q.values);
        let (points, normals) = boundary.points();
        let incident = from(one);
        let heard: Complex64 = (0..points.len())
            .map(|i| {
                let (p, gradient) = incident(points[i]);
                let slope: Complex64 = (0..3).map(|axis| gradient[axis] * normals[i][axis]).sum();
                of_pressures[i] * p + of_slopes[i] * slope
            })
            .sum();
        assert!((direct - heard).norm() < 1e-6 * direct.norm(), "{direct} {heard}");
        let field = boundary.sound(&p.values, &[other])[0].0;
        assert!((direct - field).norm() < 1e-9 * direct.norm(), "{direct} {field}");
        // By the sound's own reciprocity, to the error of the elements.
        let back = solve(&boundary, &from(other));
        let back = boundary.scattered(&back.values, &[one])[0];
        assert!((direct - back).norm() < 1e-3 * direct.norm(), "{direct} {back}");
        // The matrix alone.
        let scattered = |seed: usize| -> Vec<_> {
            let unit = |i: usize, step: f64| (i as f64 * step).fract() - 0.5;
            (0..weights.len())
                .map(|i| Complex64::new(unit(i + seed, 0.618_034), unit(i + seed, 0.754_878)))
                .collect()
        };
        let (x, y) = (scattered(1), scattered(1000));
        let forth = product(&y, &boundary.times(std::slice::from_ref(&x), false)[0]);
        let back = product(&x, &boundary.times(std::slice::from_ref(&y), true)[0]);
        let size = |x: &[Complex64]| x.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let scale = size(&y) * size(&boundary.times(std::slice::from_ref(&x), false)[0]);
        assert!((forth - back).norm() < 1e-6 * scale, "{forth} {back} {scale}");
    }

    #[test]
    fn a_large_plate_is_a_mirror() {
        // A beam from a complex source point, so that the edges are in silence.
        const REACH: f64 = 2.0 * WAVELENGTH;
        let beam = |from: f64, sign: f64| {
            move |at: DVec3| -> Sound {
                let z = Complex64::new(sign * (at.z - from), REACH);
                let r = (Complex64::from(at.x * at.x + at.y * at.y) + z * z).sqrt();
                let p = (Complex64::new(0.0, -K) * (r - Complex64::new(0.0, REACH))).exp() / r;
                let slope = p * (Complex64::new(0.0, -K) - 1.0 / r) / r;
                (p, [slope * at.x, slope * at.y, slope * z * sign])
            }
        };
        let thick = 0.6 * WAVELENGTH;
        let size = dvec3(5.0 * WAVELENGTH, 5.0 * WAVELENGTH, thick);
        let plate = shapes::slab(size, 0.2 * WAVELENGTH, WAVELENGTH / 6.0);
        let boundary = Boundary::new(&plate, 1.0, K).unwrap();
        // The beam comes from above the plate, whose face is at half its thickness.
        let (face, waist) = (thick / 2.0, thick / 2.0 + 1.5 * WAVELENGTH);
        let solution = solve(&boundary, &beam(waist, -1.0));
        let image = beam(2.0 * face - waist, 1.0);
        let points: Vec<_> = (0..150)
            .map(|i| {
                let (x, y, z) = (f64::from(i % 5) - 2.0, f64::from(i / 5 % 5) - 2.0, f64::from(i / 25));
                dvec3(0.3 * x, 0.3 * y, 0.25 + 0.15 * z) * WAVELENGTH + DVec3::Z * face
            })
            .collect();
        let scattered = boundary.scattered(&solution.values, &points);
        let error = off(&scattered, &pressures(&image, &points));
        assert!(error < 0.02, "{error}");
    }

    #[test]
    fn energy_is_kept_or_taken_by_the_surface() {
        let mesh =
            shapes::capsule(dvec3(0.0, 0.0, -0.004), dvec3(0.002, 0.0, 0.005), 0.004, WAVELENGTH / 8.0);
        let incident = from(dvec3(0.02, -0.01, 0.1));
        for coefficient in [1.0, 0.4] {
            let boundary = Boundary::new(&mesh, coefficient, K).unwrap();
            let solution = solve(&boundary, &incident);
            // Flux of conj(p) ∂p/∂r into a sphere around the body, and that of the scattered sound out of it.
            let (radius, directions) = (0.014, directions(3000));
            let points: Vec<_> = directions.iter().map(|direction| *direction * radius).collect();
            let (mut into, mut out) = (0.0, 0.0);
            for ((at, direction), (p, slopes)) in
                points.iter().zip(&directions).zip(boundary.sound(&solution.values, &points))
            {
                let (p_in, in_slopes) = incident(*at);
                let along =
                    |slopes: [Complex64; 3]| (0..3).map(|i| slopes[i] * direction[i]).sum::<Complex64>();
                let area = 4.0 * PI * radius * radius / directions.len() as f64;
                into += ((p + p_in).conj() * (along(slopes) + along(in_slopes))).im * area;
                out -= (p.conj() * along(slopes)).im * area;
            }
            let admittance = (1.0 - coefficient) / (1.0 + coefficient);
            let surface = boundary.surface(&solution.values);
            let of_triangle = |t: usize| {
                let squares: f64 = mesh.triangles[t].iter().map(|v| surface[*v as usize].norm_sqr()).sum();
                squares / 3.0 * area_vector(mesh.corners(t)).length()
            };
            let absorbed = K * admittance * (0..mesh.triangles.len()).map(of_triangle).sum::<f64>();
            assert!(
                (into - absorbed).abs() < 0.01 * (out + absorbed),
                "{coefficient}: {into} {absorbed} {out}"
            );
        }
    }

    #[test]
    fn threads_do_not_change_results() {
        let mesh = shapes::sphere(0.006, WAVELENGTH / 5.0);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let boundary = Boundary::new(&mesh, 1.0, K).unwrap();
                let p = solve(&boundary, &from(dvec3(0.02, -0.01, 0.1)));
                (boundary.scattered(&p.values, &directions(40)), p)
            })
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn a_warm_start_takes_fewer_steps() {
        let boundary = Boundary::new(&shapes::sphere(0.006, WAVELENGTH / 6.0), 1.0, K).unwrap();
        let p = solve(&boundary, &from(dvec3(0.02, -0.01, 0.1)));
        let right = right_side(&boundary, &from(dvec3(0.0202, -0.01, 0.1)));
        let warm = boundary.solve(&[right], Some(&[p.values]), TOLERANCE).remove(0);
        assert!(warm.residual <= TOLERANCE && warm.steps < p.steps, "{} {}", warm.steps, p.steps);
    }
}
