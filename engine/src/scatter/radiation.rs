//! The sound that a surface scatters to points, from the pressures at its nodes: ∫ p (∂G/∂n_y - jkβ G) dS.
//!
//! The rule of three points serves all triangles that are clear of a point; others are divided until the pieces are.

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::scatter::facets::{Facet, SIX, THREE, Wall};
use crate::scatter::patch::Sound;
use crate::scatter::waves::{LANES, each, wave};
use crate::simd::{Instructions, Isa, Kernel, fused};

/// Distances from the centroid, relative to a triangle's radius, from which the rule of three points serves.
const CLEAR: f64 = 4.0;
/// The same for pieces, with the rule of six points.
const PIECE_CLEAR: f64 = 2.5;
/// Divisions of a triangle that touches the point.
const DEEPEST: usize = 7;

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
    /// Pa, at the corners of every triangle.
    pressures: Vec<[Complex64; 3]>,
    sources: Vec<Source>,
    /// The box around the surface, m.
    low: DVec3,
    high: DVec3,
}

impl<'a> Radiation<'a> {
    /// That of pressures (Pa) at the nodes.
    pub fn new(wall: Wall, facets: &'a [Facet], nodal: &[Complex64]) -> Self {
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
        let corners = || facets.iter().flat_map(|facet| facet.corners);
        let (low, high) = (corners().fold(DVec3::MAX, DVec3::min), corners().fold(DVec3::MIN, DVec3::max));
        Self { wall, facets, pressures, sources, low, high }
    }

    /// Pressures (Pa), in f32 where no triangle is near; relative to their largest about 1e-5 off.
    pub fn pressures(&self, points: &[DVec3]) -> Vec<Complex64> {
        let mut all = vec![Complex64::ZERO; points.len()];
        let middle = self.low.midpoint(self.high);
        all.par_chunks_mut(LANES).zip(points.par_chunks(LANES)).for_each(|(to, points)| {
            let place = |lane: usize, axis: usize| (points[lane.min(points.len() - 1)] - middle)[axis] as f32;
            let places = [0, 1, 2].map(|axis| std::array::from_fn(|lane| place(lane, axis)));
            let sums = Isa::best().run(Sum { radiation: self, middle, places });
            for (lane, (to, at)) in to.iter_mut().zip(points).enumerate() {
                *to = Complex64::new(sums[0][lane], sums[1][lane]) + self.near(*at).0;
            }
        });
        all
    }

    /// Pressure and gradient in f64.
    pub fn sound(&self, at: DVec3) -> Sound {
        let mut sum = self.near(at);
        for source in &self.sources {
            add(&mut sum, heard(&self.wall, source, at));
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

    /// What the rule of three points lacks for near triangles.
    fn near(&self, at: DVec3) -> Sound {
        let mut sum = (Complex64::ZERO, [Complex64::ZERO; 3]);
        let outside = (self.low - at).max(at - self.high).max(DVec3::ZERO).length();
        for (number, facet) in self.facets.iter().enumerate() {
            let clear = CLEAR * facet.radius;
            if outside > clear || facet.centroid.distance_squared(at) >= clear * clear {
                continue;
            }
            add(&mut sum, of_facet(&self.wall, facet, self.pressures[number], at));
            for source in &self.sources[3 * number..3 * number + 3] {
                let (p, gradient) = heard(&self.wall, source, at);
                add(&mut sum, (-p, gradient.map(|slope| -slope)));
            }
        }
        sum
    }
}

/// The sound of a triangle with pressures at its corners, accurately.
fn of_facet(wall: &Wall, facet: &Facet, p: [Complex64; 3], at: DVec3) -> Sound {
    let mut sum = (Complex64::ZERO, [Complex64::ZERO; 3]);
    if facet.centroid.distance(at) >= CLEAR * facet.radius {
        for w in THREE {
            let strength = (p[0] * w[0] + p[1] * w[1] + p[2] * w[2]) * (facet.area / 3.0 / (4.0 * PI));
            add(&mut sum, heard(wall, &Source { at: facet.at(w), normal: facet.normal, strength }, at));
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
        add(sum, heard(wall, &Source { at: facet.at(w), normal: facet.normal, strength }, at));
    }
}

fn add(sum: &mut Sound, (p, gradient): Sound) {
    sum.0 += p;
    sum.1.iter_mut().zip(gradient).for_each(|(sum, slope)| *sum += slope);
}

/// The sound of a source: with d from the point to it, s (G'/R n·d - jkβ G) and its gradient by the point.
fn heard(wall: &Wall, source: &Source, at: DVec3) -> Sound {
    let k = wall.wavenumber;
    let d = source.at - at;
    let r2 = d.length_squared();
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

/// The rule of three points of all triangles at a run of points.
struct Sum<'a, 'b> {
    radiation: &'a Radiation<'b>,
    middle: DVec3,
    places: [[f32; LANES]; 3],
}

impl Kernel for Sum<'_, '_> {
    type Output = [[f64; LANES]; 2];

    #[inline(always)]
    fn run<I: Instructions>(self) -> [[f64; LANES]; 2] {
        /// Sources between two additions to the sums in f64.
        const RUN: usize = 64;
        let Self { radiation, middle, places: [xs, ys, zs] } = self;
        let k = radiation.wall.wavenumber as f32;
        let per_metre = (radiation.wall.wavenumber / PI) as f32;
        let leak = (radiation.wall.wavenumber * radiation.wall.admittance) as f32;
        let mut all = [[0f64; LANES]; 2];
        for sources in radiation.sources.chunks(RUN) {
            let mut sums = [[0f32; LANES]; 2];
            for source in sources {
                let [x, y, z] = (source.at - middle).as_vec3().to_array();
                let [nx, ny, nz] = source.normal.as_vec3().to_array();
                let u = Complex32::new(source.strength.re as f32, source.strength.im as f32);
                let (dx, dy, dz) = (each(|l| x - xs[l]), each(|l| y - ys[l]), each(|l| z - zs[l]));
                let r2 = each(|l| {
                    fused::<I>(dx[l], dx[l], fused::<I>(dy[l], dy[l], fused::<I>(dz[l], dz[l], 1e-16)))
                });
                let [c, s, inverse, r] = wave::<I>(per_metre, &r2);
                let along = each(|l| {
                    fused::<I>(dx[l], nx, fused::<I>(dy[l], ny, dz[l] * nz)) * (inverse[l] * inverse[l])
                });
                let kr = each(|l| k * r[l]);
                let re = each(|l| -fused::<I>(along[l], fused::<I>(kr[l], s[l], c[l]), leak * s[l]));
                let im = each(|l| -fused::<I>(along[l], fused::<I>(kr[l], c[l], -s[l]), leak * c[l]));
                sums[0] = each(|l| fused::<I>(u.re, re[l], fused::<I>(-u.im, im[l], sums[0][l])));
                sums[1] = each(|l| fused::<I>(u.re, im[l], fused::<I>(u.im, re[l], sums[1][l])));
            }
            for part in 0..2 {
                for lane in 0..LANES {
                    all[part][lane] += f64::from(sums[part][lane]);
                }
            }
        }
        all
    }
}
