//! The sound that a surface scatters to points, from the pressures at its nodes: ∫ p (∂G/∂n_y - jkβ G) dS.
//!
//! The rule of three points serves all triangles that are clear of a point; others are divided until the pieces are.

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::scatter::emission::Emission;
use crate::scatter::facets::{Facet, SIX, THREE, Wall};
use crate::scatter::grid::Grid;
use crate::scatter::patch::Sound;
use crate::scatter::rows::Sources;

/// Distances from the centroid, relative to a triangle's radius, from which the rule of three points serves.
pub(super) const CLEAR: f64 = 4.0;
/// The same for pieces, with the rule of six points.
const PIECE_CLEAR: f64 = 2.5;
/// Divisions of a triangle that touches the point.
const DEEPEST: usize = 11;

/// A source of the rule of three points.
#[derive(Clone, Copy, Debug)]
struct Source {
    at: DVec3,
    normal: DVec3,
    /// Pa m²/(4π)
    strength: Complex64,
}

/// A surface with its pressures, ready to be heard at many points.
#[derive(Clone, Debug)]
pub(super) struct Radiation<'a> {
    wall: Wall,
    facets: &'a [Facet],
    /// Finds triangles that are not [`CLEAR`] of a point.
    grid: &'a Grid,
    /// Pa, at the corners of every triangle.
    pressures: Vec<[Complex64; 3]>,
    sources: Vec<Source>,
}

impl<'a> Radiation<'a> {
    /// That of pressures (Pa) at the nodes.
    pub fn new(wall: Wall, facets: &'a [Facet], grid: &'a Grid, nodal: &[Complex64]) -> Self {
        let pressures: Vec<_> =
            facets.iter().map(|facet| facet.nodes.map(|node| nodal[node as usize])).collect();
        let of = |(facet, p): (&Facet, &[Complex64; 3])| {
            let strength = facet.area / 3.0 / (4.0 * PI);
            THREE.map(|w| Source {
                at: facet.at(w),
                normal: facet.normal,
                strength: (p[0] * w[0] + p[1] * w[1] + p[2] * w[2]) * strength,
            })
        };
        let sources = facets.iter().zip(&pressures).flat_map(of).collect();
        Self { wall, facets, grid, pressures, sources }
    }

    /// The rule of three points of all triangles, as plain data.
    pub fn emission(&self) -> Emission {
        let corners = || self.facets.iter().flat_map(|facet| facet.corners);
        let (low, high) = (corners().fold(DVec3::MAX, DVec3::min), corners().fold(DVec3::MIN, DVec3::max));
        let (middle, per_metre) = (low.midpoint(high), self.wall.wavenumber / PI);
        let of = |source: &Source| {
            let [x, y, z] = ((source.at - middle) * per_metre).as_vec3().to_array();
            let [nx, ny, nz] = source.normal.as_vec3().to_array();
            let strength = source.strength * per_metre.powi(2);
            [x, y, z, strength.re as f32, nx, ny, nz, strength.im as f32]
        };
        Emission {
            middle,
            per_metre,
            leak: (PI * self.wall.admittance) as f32,
            least: (least(self.facets) * per_metre) as f32,
            sources: self.sources.iter().map(of).collect(),
        }
    }

    /// Pressures (Pa) of several on one surface, in f32 where no triangle is near; relative to their largest about 1e-5
    /// off.
    pub fn pressures(all: &[Self], points: &[DVec3]) -> Vec<Vec<Complex64>> {
        let emissions: Vec<_> = all.iter().map(Self::emission).collect();
        let mut heard = Emission::pressures_of_all(&emissions.iter().collect::<Vec<_>>(), points);
        for (radiation, heard) in all.iter().zip(&mut heard) {
            let least = least(radiation.facets);
            heard.par_iter_mut().zip(points).for_each(|(sum, at)| *sum += radiation.near(*at, least).0);
        }
        heard
    }

    /// Pressures and gradients (Pa/m), likewise.
    pub fn sounds(&self, points: &[DVec3]) -> Vec<Sound> {
        let mut all = self.emission().sounds(points);
        all.iter_mut().zip(self.corrections(points)).for_each(|(sum, near)| add(sum, near));
        all
    }

    /// What the sums of [`Self::emission`] lack at points (m), of near triangles.
    pub fn corrections(&self, points: &[DVec3]) -> Vec<Sound> {
        let least = least(self.facets);
        points.par_iter().map(|at| self.near(*at, least)).collect()
    }

    /// Pressure and gradient in f64.
    pub fn sound(&self, at: DVec3) -> Sound {
        let mut sum = self.near(at, 0.0);
        for source in &self.sources {
            add(&mut sum, heard(&self.wall, source, at, 0.0));
        }
        sum
    }

    /// The weight of every node's pressure in the pressure at a point, and in its slopes along the axes, by the same rules.
    pub fn weights(wall: Wall, facets: &[Facet], nodes: usize, at: DVec3) -> Vec<[Complex64; 4]> {
        let mut weights = vec![[Complex64::ZERO; 4]; nodes];
        for facet in facets {
            for corner in 0..3 {
                let mut unit = [Complex64::ZERO; 3];
                unit[corner] = Complex64::ONE;
                let (p, [x, y, z]) = of_facet(&wall, facet, unit, at);
                let to = &mut weights[facet.nodes[corner] as usize];
                to.iter_mut().zip([p, x, y, z]).for_each(|(sum, weight)| *sum += weight);
            }
        }
        weights
    }

    /// Its rule of three points without pressures.
    pub fn sources(wall: &Wall, facets: &[Facet], nodes: usize, middle: DVec3) -> Sources {
        let per_metre = wall.wavenumber / PI;
        let place = |facet: &Facet, at: DVec3| {
            let [x, y, z] = ((at - middle) * per_metre).as_vec3().to_array();
            let [nx, ny, nz] = facet.normal.as_vec3().to_array();
            [x, y, z, nx, ny, nz]
        };
        let of = |facet: &Facet| facet.points().map(|at| place(facet, at));
        let area = |facet: &Facet| (facet.area / 3.0 / (4.0 * PI) * per_metre.powi(2)) as f32;
        Sources {
            places: facets.iter().flat_map(of).collect(),
            nodes: facets.iter().map(|facet| facet.nodes).collect(),
            areas: facets.iter().map(area).collect(),
            leak: (PI * wall.admittance) as f32,
            least: (least(facets) * per_metre) as f32,
            count: nodes,
        }
    }

    /// What the weights of nodes by [`Self::sources`] lack at a point (m), of near triangles.
    pub fn lacks(wall: &Wall, facets: &[Facet], grid: &Grid, at: DVec3) -> Vec<(u32, Complex64)> {
        let (mut all, least) = (Vec::new(), least(facets));
        for facet in grid.around(at).map(|number| &facets[number]) {
            let clear = CLEAR * facet.radius;
            if facet.centroid.distance_squared(at) >= clear * clear {
                continue;
            }
            let strength = Complex64::from(facet.area / 3.0 / (4.0 * PI));
            let points = facet.points().map(|at| Source { at, normal: facet.normal, strength });
            let rough = points.map(|source| heard(wall, &source, at, least).0);
            for corner in 0..3 {
                let mut unit = [Complex64::ZERO; 3];
                unit[corner] = Complex64::ONE;
                let by_rule: Complex64 = (0..3).map(|point| rough[point] * THREE[point][corner]).sum();
                all.push((facet.nodes[corner], of_facet(wall, facet, unit, at).0 - by_rule));
            }
        }
        all
    }

    /// What the rule of three points lacks for near triangles, with sources that are never nearer than `least` (m).
    fn near(&self, at: DVec3, least: f64) -> Sound {
        let mut sum = (Complex64::ZERO, [Complex64::ZERO; 3]);
        for number in self.grid.around(at) {
            let facet = &self.facets[number];
            let clear = CLEAR * facet.radius;
            if facet.centroid.distance_squared(at) >= clear * clear {
                continue;
            }
            add(&mut sum, of_facet(&self.wall, facet, self.pressures[number], at));
            for source in &self.sources[3 * number..3 * number + 3] {
                let (p, gradient) = heard(&self.wall, source, at, least);
                add(&mut sum, (-p, gradient.map(|slope| -slope)));
            }
        }
        sum
    }
}

/// Least distance (m) of sources in f32: of those that need no correction, none is nearer.
fn least(facets: &[Facet]) -> f64 {
    facets.iter().map(|facet| facet.radius).fold(f64::INFINITY, f64::min)
}

/// The sound of a triangle with pressures at its corners, accurately.
fn of_facet(wall: &Wall, facet: &Facet, p: [Complex64; 3], at: DVec3) -> Sound {
    let mut sum = (Complex64::ZERO, [Complex64::ZERO; 3]);
    if facet.centroid.distance(at) >= CLEAR * facet.radius {
        for w in THREE {
            let strength = (p[0] * w[0] + p[1] * w[1] + p[2] * w[2]) * (facet.area / 3.0 / (4.0 * PI));
            add(&mut sum, heard(wall, &Source { at: facet.at(w), normal: facet.normal, strength }, at, 0.0));
        }
        return sum;
    }
    pieces(wall, facet, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], (p, at), DEEPEST, &mut sum);
    sum
}

/// Adds the sound of a part of a triangle, given by the barycentric coordinates of its corners.
fn pieces(
    wall: &Wall,
    facet: &Facet,
    corners: [[f64; 3]; 3],
    (p, at): ([Complex64; 3], DVec3),
    depth: usize,
    sum: &mut Sound,
) {
    let mix = |w: [f64; 3]| [0, 1, 2].map(|i| (0..3).map(|c| w[c] * corners[c][i]).sum::<f64>());
    let centre = facet.at(mix([1.0 / 3.0; 3]));
    let radius = corners.iter().map(|c| facet.at(*c).distance(centre)).fold(0.0, f64::max);
    if depth > 0 && centre.distance(at) < PIECE_CLEAR * radius {
        let half = |a: usize, b: usize| [0, 1, 2].map(|i| f64::midpoint(corners[a][i], corners[b][i]));
        let ([a, b, c], [ab, bc, ca]) = (corners, [half(0, 1), half(1, 2), half(2, 0)]);
        for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            pieces(wall, facet, part, (p, at), depth - 1, sum);
        }
        return;
    }
    let area = facet.area * 0.25f64.powi((DEEPEST - depth) as i32) / (4.0 * PI);
    for (w, weight) in SIX {
        let w = mix(w);
        let strength = (p[0] * w[0] + p[1] * w[1] + p[2] * w[2]) * (area * weight);
        add(sum, heard(wall, &Source { at: facet.at(w), normal: facet.normal, strength }, at, 0.0));
    }
}

fn add(sum: &mut Sound, (p, gradient): Sound) {
    sum.0 += p;
    sum.1.iter_mut().zip(gradient).for_each(|(sum, slope)| *sum += slope);
}

/// The sound of a source: with d from the point to it, s (G'/R n·d - jkβ G) and its gradient by the point,
/// from a distance R of at least `least` (m).
fn heard(wall: &Wall, source: &Source, at: DVec3, least: f64) -> Sound {
    let k = wall.wavenumber;
    let d = source.at - at;
    let r2 = d.length_squared().max(least * least);
    if r2 == 0.0 {
        return (Complex64::ZERO, [Complex64::ZERO; 3]);
    }
    let r = r2.sqrt();
    let g = source.strength * Complex64::cis(-k * r) / r;
    let kr = Complex64::new(1.0, k * r);
    // G'/R and its derivative by R over R.
    let slope = -g * kr / r2;
    let bend = g * (kr * 3.0 - k * k * r2) / (r2 * r2);
    let (along, leak) = (source.normal.dot(d), Complex64::new(0.0, k * wall.admittance));
    let gradient = [0, 1, 2]
        .map(|axis| -(bend * along * d[axis] + slope * source.normal[axis]) + leak * slope * d[axis]);
    (slope * along - leak * g, gradient)
}
