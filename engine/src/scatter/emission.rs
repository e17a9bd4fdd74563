//! Sources on a surface as plain data, and the sums of their sound in f32.
//!
//! Lengths are in half turns, k/π per metre, so that phases are πr and are reduced without a product. With d from a point
//! to a source, r = |d|, n the normal and β the admittance, a source of the strength u sounds like
//!
//! p = -u e^{-jπr}/r (n·d (1 + jπr)/r² + jπβ),
//!
//! which is [`crate::scatter::boundary`]'s ∂G/∂n_y - jkβ G. Sources nearer than [`Emission::least`] sound as if they were
//! there, since f32 would lose them: who corrects near triangles takes the same away in f64.

use std::f32::consts::PI;

use glam::{DMat3, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::scatter::patch::Sound;
use crate::scatter::waves::{inverse_roots, phasor, wide};
use crate::simd::{Instructions, Isa, Kernel, fused, larger};

/// Sources between two additions to the sums in f64.
const RUN: usize = 64;
/// Points together: with fewer than 48 the compiler makes code of a third of the speed.
const LANES: usize = 64;

type Lanes = [f32; LANES];

/// The sources of a surface with its pressures.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// m; the sources' places are from here.
    pub middle: DVec3,
    /// k/π, half turns per metre.
    pub per_metre: f64,
    /// πβ
    pub leak: f32,
    /// Least distance, half turns.
    pub least: f32,
    /// Place (half turns) and real part of the strength (Pa), normal and imaginary part.
    pub sources: Vec<[f32; 8]>,
}

impl Emission {
    /// The same of a surface that is turned about its origin (axes as columns, or a mirror's) and shifted (m), with all
    /// strengths times a gain.
    #[must_use]
    pub fn placed(&self, axes: DMat3, shift: DVec3, gain: f64) -> Self {
        let turn = axes.as_mat3();
        let gain = gain as f32;
        let of = |&[x, y, z, re, nx, ny, nz, im]: &[f32; 8]| {
            let ([x, y, z], [nx, ny, nz]) =
                ((turn * glam::vec3(x, y, z)).to_array(), (turn * glam::vec3(nx, ny, nz)).to_array());
            [x, y, z, re * gain, nx, ny, nz, im * gain]
        };
        Self { middle: axes * self.middle + shift, sources: self.sources.iter().map(of).collect(), ..*self }
    }

    /// A point (m) from the middle, half turns.
    pub fn seen(&self, at: DVec3) -> [f32; 3] {
        ((at - self.middle) * self.per_metre).as_vec3().to_array()
    }

    /// Pressures (Pa) at points (m): within 1e-5 of the largest.
    pub fn pressures(&self, points: &[DVec3]) -> Vec<Complex64> {
        Self::pressures_of_all(&[self], points).remove(0)
    }

    /// Those of a surface with several pressures on it, one after the other: four cost as much as two alone.
    ///
    /// # Panics
    /// Other than a strength of each per source.
    pub fn pressures_of_all(all: &[&Self], points: &[DVec3]) -> Vec<Vec<Complex64>> {
        let (fours, rest) = all.as_chunks::<4>();
        let fours = fours.iter().flat_map(|four| Self::pressures_of(four, points));
        fours.chain(rest.iter().flat_map(|one| Self::pressures_of(&[one], points))).collect()
    }

    fn pressures_of<const N: usize>(all: &[&Self; N], points: &[DVec3]) -> [Vec<Complex64>; N] {
        let lanes = points.par_chunks(LANES).flat_map_iter(|points| {
            let sums = Isa::best().run(Pressures { all, places: &all[0].places(points) });
            (0..points.len())
                .map(move |lane| std::array::from_fn(|n| Complex64::new(sums[n][0][lane], sums[n][1][lane])))
        });
        let together: Vec<[Complex64; N]> = lanes.collect();
        std::array::from_fn(|n| together.iter().map(|pressures| pressures[n]).collect())
    }

    /// Pressures (Pa) and gradients (Pa/m) at points (m): within 1e-5 of the largest.
    pub fn sounds(&self, points: &[DVec3]) -> Vec<Sound> {
        let mut all = vec![(Complex64::ZERO, [Complex64::ZERO; 3]); points.len()];
        all.par_chunks_mut(LANES).zip(points.par_chunks(LANES)).for_each(|(to, points)| {
            let sums = Isa::best().run(Sounds { emission: self, places: &self.places(points) });
            for (lane, to) in to.iter_mut().enumerate() {
                let part = |n: usize| Complex64::new(sums[2 * n][lane], sums[2 * n + 1][lane]);
                *to = (part(0), [1, 2, 3].map(|axis| part(axis) * self.per_metre));
            }
        });
        all
    }

    /// Points in lanes; those beyond the last are the last.
    fn places(&self, points: &[DVec3]) -> [Lanes; 3] {
        let seen: [[f32; 3]; LANES] =
            std::array::from_fn(|lane| self.seen(points[lane.min(points.len() - 1)]));
        [0, 1, 2].map(|axis| seen.map(|at| at[axis]))
    }
}

/// The pressures of all sources, for each of several strengths, at a run of points.
struct Pressures<'a, const N: usize> {
    /// Of one surface.
    all: &'a [&'a Emission; N],
    places: &'a [Lanes; 3],
}

impl<const N: usize> Kernel for Pressures<'_, N> {
    type Output = [[[f64; LANES]; 2]; N];

    #[inline(always)]
    fn run<I: Instructions>(self) -> Self::Output {
        let Self { all, places: [xs, ys, zs] } = self;
        let (leak, nearest) = (all[0].leak, all[0].least * all[0].least);
        let mut totals = [[[0.0; LANES]; 2]; N];
        for first in (0..all[0].sources.len()).step_by(RUN) {
            let run = first..all[0].sources.len().min(first + RUN);
            let runs = all.map(|emission| &emission.sources[run.clone()]);
            let mut sums = [[[0.0; LANES]; 2]; N];
            for (n, &[x, y, z, _, nx, ny, nz, _]) in runs[0].iter().enumerate() {
                let [dx, dy, dz] = [lanes(|l| x - xs[l]), lanes(|l| y - ys[l]), lanes(|l| z - zs[l])];
                let Wave { inverse, g, cosine, sine, .. } = wave::<I>([&dx, &dy, &dz], nearest);
                let along = lanes(|l| fused::<I>(dx[l], nx, fused::<I>(dy[l], ny, dz[l] * nz)) * inverse[l]);
                // (a + j b) (cosine - j sine)
                let a = lanes(|l| -along[l] * inverse[l] * g[l]);
                let b = lanes(|l| -fused::<I>(along[l], PI, leak) * g[l]);
                let re = lanes(|l| fused::<I>(a[l], cosine[l], b[l] * sine[l]));
                let im = lanes(|l| fused::<I>(b[l], cosine[l], -(a[l] * sine[l])));
                for (sums, run) in sums.iter_mut().zip(runs) {
                    let [_, _, _, u, _, _, _, v] = run[n];
                    sums[0] = lanes(|l| fused::<I>(u, re[l], fused::<I>(-v, im[l], sums[0][l])));
                    sums[1] = lanes(|l| fused::<I>(u, im[l], fused::<I>(v, re[l], sums[1][l])));
                }
            }
            for (totals, sums) in totals.iter_mut().zip(&sums) {
                accumulate(totals, sums);
            }
        }
        totals
    }
}

/// The same with gradients, by half turns: real and imaginary parts of the pressure and of each slope.
struct Sounds<'a> {
    emission: &'a Emission,
    places: &'a [Lanes; 3],
}

impl Kernel for Sounds<'_> {
    type Output = [[f64; LANES]; 8];

    #[inline(always)]
    fn run<I: Instructions>(self) -> Self::Output {
        let Self { emission, places: [xs, ys, zs] } = self;
        let (leak, nearest) = (emission.leak, emission.least * emission.least);
        let mut all = [[0.0; LANES]; 8];
        for sources in emission.sources.chunks(RUN) {
            let mut sums = [[0.0; LANES]; 8];
            for &[x, y, z, u, nx, ny, nz, v] in sources {
                let [dx, dy, dz] = [lanes(|l| x - xs[l]), lanes(|l| y - ys[l]), lanes(|l| z - zs[l])];
                let Wave { r2, inverse, g, cosine, sine } = wave::<I>([&dx, &dy, &dz], nearest);
                let dot = lanes(|l| fused::<I>(dx[l], nx, fused::<I>(dy[l], ny, dz[l] * nz)));
                let inverse2 = lanes(|l| inverse[l] * inverse[l]);
                let phase = lanes(|l| PI * r2[l] * inverse[l]);
                // The wave G, G'/r = -(1 + jπr) G/r², and the derivative of that by r over r, -(3 G'/r + π² G)/r².
                let gr = lanes(|l| g[l] * fused::<I>(u, cosine[l], v * sine[l]));
                let gi = lanes(|l| g[l] * fused::<I>(v, cosine[l], -(u * sine[l])));
                let sr = lanes(|l| -inverse2[l] * fused::<I>(-phase[l], gi[l], gr[l]));
                let si = lanes(|l| -inverse2[l] * fused::<I>(phase[l], gr[l], gi[l]));
                let br = lanes(|l| -inverse2[l] * fused::<I>(3.0, sr[l], PI * PI * gr[l]));
                let bi = lanes(|l| -inverse2[l] * fused::<I>(3.0, si[l], PI * PI * gi[l]));
                sums[0] = lanes(|l| fused::<I>(sr[l], dot[l], fused::<I>(leak, gi[l], sums[0][l])));
                sums[1] = lanes(|l| fused::<I>(si[l], dot[l], fused::<I>(-leak, gr[l], sums[1][l])));
                let er = lanes(|l| fused::<I>(br[l], dot[l], leak * si[l]));
                let ei = lanes(|l| fused::<I>(bi[l], dot[l], -leak * sr[l]));
                for (axis, (d, n)) in [(&dx, nx), (&dy, ny), (&dz, nz)].into_iter().enumerate() {
                    let (re, im) = (2 + 2 * axis, 3 + 2 * axis);
                    sums[re] = lanes(|l| fused::<I>(-er[l], d[l], fused::<I>(-sr[l], n, sums[re][l])));
                    sums[im] = lanes(|l| fused::<I>(-ei[l], d[l], fused::<I>(-si[l], n, sums[im][l])));
                }
            }
            accumulate(&mut all, &sums);
        }
        all
    }
}

/// What pressure and gradient share: e^{-jπr} is g (cosine - j sine) r, and `inverse` 1/r.
struct Wave {
    r2: Lanes,
    inverse: Lanes,
    g: Lanes,
    cosine: Lanes,
    sine: Lanes,
}

#[inline(always)]
fn wave<I: Instructions>([dx, dy, dz]: [&Lanes; 3], nearest: f32) -> Wave {
    let r2 = lanes(|l| larger(fused::<I>(dx[l], dx[l], fused::<I>(dy[l], dy[l], dz[l] * dz[l])), nearest));
    let inverse = inverse_roots::<I, LANES>(&r2);
    let [g, cosine, sine] = phasor::<I, LANES>(&lanes(|l| r2[l] * inverse[l]), &inverse);
    Wave { r2, inverse, g, cosine, sine }
}

#[inline(always)]
fn lanes(value: impl Fn(usize) -> f32) -> Lanes {
    wide(value)
}

#[inline(always)]
fn accumulate<const N: usize>(all: &mut [[f64; LANES]; N], sums: &[Lanes; N]) {
    for (all, sums) in all.iter_mut().zip(sums) {
        for lane in 0..LANES {
            all[lane] += f64::from(sums[lane]);
        }
    }
}
