//! Skin under a changing pressure: an incompressible viscoelastic half-space, or a layer of it on a rigid bed (bone).
//!
//! With e^{jωt}, the shear modulus μ* = μ + jωη, k_s² = ρω²/μ* and s = √(k² - k_s²), Re s > 0, a pressure of the wavenumber k
//! presses the half-space in by (Rayleigh's determinant, the cancelling terms of which are summed)
//!
//! ```text
//! U = k / (μ* (4k² s/(k + s) - k_s²))        without motion 1/(2μk)
//! ```
//!
//! A layer of the depth d is the viscous liquid of `dispersion` without gravity and surface tension, whose viscosity is μ*/(jω)
//! (correspondence principle). With σ = -k_s²/k², z = 1 + σ, x = √z, δ = kd, T = tanh δ, C = cosh xδ, S = sinh(xδ)/x it is
//!
//! ```text
//! U = -σ (T C - S) / (μ* k A),   A = 4(z + 1)/cosh δ + (z² + 6z + 1) T S - (z² + 2z + 5) C
//! ```
//!
//! Both brackets vanish with σ, A as its square; one σ is divided out before the sums. Without motion it is F(δ)/(2μk),
//! F(x) = (sinh 2x - 2x)/(cosh 2x + 1 + 2x²).
//!
//! **Response to a point.** g(r) = 1/2π ∫ U(k) J₀(kr) k dk, on skin without edges. The integrand has a pole near the real axis, the
//! surface wave, which lies below it: the path keeps above, where everything is smooth, so one set of nodes serves all
//! frequencies, and a table of J₀ all of them. U is cut off smoothly between the highest wavenumber of a
//! pressure and the lowest of its images by the sampling, so that sums over cells are exact.

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::fmt;

use num_complex::Complex64;
use rayon::prelude::*;
use sonoglyph_fourier::{Transform, transform};

use crate::scene::Skin;
use crate::special::gauss_legendre;

/// Depth in 1/k, and the same of the shear wave's decay, beyond which bone has no effect.
const DEEP: f64 = 20.0;
/// Relative size of σ below which the skin moves as if without inertia.
const SLOW: f64 = 1e-9;

/// Displacement (m) into the skin per Pa, of a pressure with the wavenumber k (1/m) that swings with the angular frequency ω (1/s).
/// k may be complex, with a positive imaginary part.
pub fn yielding(skin: &Skin, k: Complex64, omega: f64) -> Complex64 {
    let modulus = Complex64::new(skin.shear_modulus(), omega * skin.viscosity);
    let shear = skin.density * omega * omega / modulus;
    let s = (k * k - shear).sqrt();
    let Some(depth) = skin.depth.filter(|depth| (depth * k.re.min(s.re)) < DEEP) else {
        return k / (modulus * (4.0 * k * k * s / (k + s) - shear));
    };
    let (delta, sigma) = (k * depth, -shear / (k * k));
    if sigma.norm() < SLOW {
        return creep(delta) / (2.0 * modulus * k);
    }
    let (z, x) = (1.0 + sigma, s / k);
    // All times 2 e^{-Re xδ}.
    let (turns, least) = (x * delta, (x * delta).re);
    let away = 2.0 * (-least).exp();
    let (up, down) = ((turns - least).exp(), (-turns - least).exp());
    let c = up + down;
    let s_x = if turns.norm() < 1e-4 { away * delta * (1.0 + turns * turns / 6.0) } else { (up - down) / x };
    let (cosh, sinh, tanh) = (delta.cosh(), delta.sinh(), delta.tanh());
    let [slope_c, slope_s] = if sigma.norm() < 0.5 {
        let (sum, difference) = ((x + 1.0) * delta / 2.0, sigma / (x + 1.0) * delta / 2.0);
        let by = sinhc(difference) * delta;
        [by * sinhc(sum) * (away * delta / 2.0), (sum.cosh() * by - sinh) * away / (x * (x + 1.0))]
    } else {
        [(c - away * cosh) / sigma, (s_x - away * sinh) / sigma]
    };
    let a = 4.0 * away / cosh + ((z + 7.0) * s_x + 8.0 * slope_s) * tanh - (z + 3.0) * c - 8.0 * slope_c;
    -sigma * (tanh * slope_c - slope_s) / (modulus * k * a)
}

/// sinh u / u
fn sinhc(u: Complex64) -> Complex64 {
    if u.norm() < 1e-4 { 1.0 + u * u / 6.0 } else { u.sinh() / u }
}

/// F(δ) of a layer without motion.
fn creep(delta: Complex64) -> Complex64 {
    if delta.norm() < 1e-2 {
        return 2.0 / 3.0 * delta.powi(3);
    }
    let twice = 2.0 * delta;
    (twice.sinh() - twice) / (twice.cosh() + 1.0 + 2.0 * delta * delta)
}

/// The response of the skin to points of pressure on a lattice: the tables that all frequencies share.
#[derive(Clone)]
pub struct Touch {
    /// Columns and rows of the periodic lattice.
    pub counts: [usize; 2],
    /// m, between neighbours.
    step: f64,
    /// Nodes in k with their weights, cut-off and 1/2π included.
    nodes: Vec<[Complex64; 2]>,
    /// J₀(kr) of every node, radius by radius.
    bessel: Vec<Complex64>,
    /// The radii of columns 0 to half of them, of every row 0 to half of them.
    places: Vec<Place>,
    transforms: [Transform; 2],
}

impl fmt::Debug for Touch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Touch")
            .field("counts", &self.counts)
            .field("step", &self.step)
            .finish_non_exhaustive()
    }
}

/// Radii of the table per step of the lattice.
const PER_STEP: f64 = 4.0;
/// Points of an interpolation between radii.
const TAPS: usize = 6;
/// Nodes of a piece of the path.
const NODES: usize = 16;

impl Touch {
    /// For pressures on at most half the columns and rows besides those where the response is wanted; `step` is six to a wavelength of
    /// the sound.
    pub fn new(counts: [usize; 2], step: f64) -> Self {
        let farthest =
            step * counts.iter().map(|count| (*count as f64 / 2.0 + 1.0).powi(2)).sum::<f64>().sqrt();
        let nodes = path(farthest, step);
        let radii = (farthest / step * PER_STEP).ceil() as usize + TAPS;
        let bessel = (0..radii).into_par_iter().flat_map_iter(|radius| {
            let r = radius as f64 * step / PER_STEP;
            nodes.iter().map(move |[k, _]| bessel_0(k * r))
        });
        let [across, up] = counts.map(|count| count / 2 + 1);
        let place = |i: usize| Place::new(((i % across) as f64).hypot((i / across) as f64) * PER_STEP);
        let places = (0..across * up).into_par_iter().map(place).collect();
        Self { counts, step, bessel: bessel.collect(), places, nodes, transforms: counts.map(transform) }
    }

    /// The factors that turn the transform of a pressure (Pa) on the lattice into that of the displacement (m), at each of some
    /// frequencies (Hz): columns 0 to half of them, of every row 0 to half of them.
    pub fn factors(&self, skin: &Skin, frequencies: &[f64]) -> Vec<Vec<Complex64>> {
        let weighted = |frequency: &f64| -> Vec<_> {
            self.nodes.iter().map(|[k, weight]| weight * yielding(skin, *k, TAU * frequency)).collect()
        };
        let weighted: Vec<_> = frequencies.par_iter().map(weighted).collect();
        // Radius by radius, whose row of the table serves all frequencies.
        let of_radius = |bessel: &[Complex64]| -> Vec<_> {
            let sum = |weighted: &Vec<Complex64>| {
                bessel.iter().zip(weighted).fold(Complex64::ZERO, |sum, (j, w)| sum + j * w)
            };
            weighted.iter().map(sum).collect()
        };
        let rows: Vec<_> = self.bessel.par_chunks_exact(self.nodes.len()).map(of_radius).collect();
        let of_frequency = |line: usize| self.transformed(|radius| rows[radius][line]);
        (0..frequencies.len()).into_par_iter().map(of_frequency).collect()
    }

    /// The transform of a table by radius, on the lattice, which is even along both axes.
    fn transformed(&self, table: impl Fn(usize) -> Complex64) -> Vec<Complex64> {
        let [columns, rows] = self.counts;
        let [across, up] = self.counts.map(|count| count / 2 + 1);
        let area = self.step * self.step;
        let mut line = vec![Complex64::ZERO; columns];
        let mut halves = vec![Complex64::ZERO; across * up];
        for (places, half) in self.places.chunks_exact(across).zip(halves.chunks_exact_mut(across)) {
            for (column, place) in places.iter().enumerate() {
                let value = area * place.between(&table);
                line[column] = value;
                line[(columns - column) % columns] = value;
            }
            self.transforms[0].process(&mut line);
            half.copy_from_slice(&line[..across]);
        }
        let mut line = vec![Complex64::ZERO; rows];
        for column in 0..across {
            for (row, value) in line.iter_mut().enumerate() {
                *value = halves[row.min(rows - row) * across + column];
            }
            self.transforms[1].process(&mut line);
            for row in 0..up {
                halves[row * across + column] = line[row];
            }
        }
        halves
    }

    /// The displacement (m) under a pressure (Pa) with these [`Touch::factors`]. The pressure's cells stand at the lattice's beginning;
    /// of the displacement those from `first` on are returned, `wanted` columns and rows.
    pub fn displacement(
        &self,
        factors: &[Complex64],
        (pressure, of_pressure): (&[Complex64], [usize; 2]),
        (first, wanted): ([usize; 2], [usize; 2]),
    ) -> Vec<Complex64> {
        let [columns, rows] = self.counts;
        let across = columns / 2 + 1;
        let mut scratch = vec![
            Complex64::ZERO;
            self.transforms.iter().map(|t| t.get_inplace_scratch_len()).max().unwrap_or(0)
        ];
        // By rows, then transposed: column by column.
        let mut line = vec![Complex64::ZERO; columns];
        let mut turned = vec![Complex64::ZERO; columns * rows];
        for (row, values) in pressure.chunks_exact(of_pressure[0]).enumerate() {
            line[..values.len()].copy_from_slice(values);
            line[values.len()..].fill(Complex64::ZERO);
            self.transforms[0].process_with_scratch(&mut line, &mut scratch);
            for (column, value) in line.iter().enumerate() {
                turned[column * rows + row] = *value;
            }
        }
        let mut kept = vec![Complex64::ZERO; columns * wanted[1]];
        let scale = 1.0 / (columns * rows) as f64;
        for (column, line) in turned.chunks_exact_mut(rows).enumerate() {
            self.transforms[1].process_with_scratch(line, &mut scratch);
            let i = column.min(columns - column);
            for (row, value) in line.iter_mut().enumerate() {
                // Conjugate, since only the forward transform is planned.
                *value = (*value * factors[row.min(rows - row) * across + i]).conj();
            }
            self.transforms[1].process_with_scratch(line, &mut scratch);
            for row in 0..wanted[1] {
                kept[row * columns + column] = line[first[1] + row];
            }
        }
        let mut found = Vec::with_capacity(wanted[0] * wanted[1]);
        for line in kept.chunks_exact_mut(columns) {
            self.transforms[0].process_with_scratch(line, &mut scratch);
            found.extend(line[first[0]..][..wanted[0]].iter().map(|value| value.conj() * scale));
        }
        found
    }
}

/// The path of the integral over k, up to where the cut-off has ended, for radii up to the `farthest` (m): nodes with weights times
/// cut-off and k/2π.
fn path(farthest: f64, step: f64) -> Vec<[Complex64; 2]> {
    /// Rise of J₀ along the path, as an exponent.
    const RISE: f64 = 3.0;
    /// Cycles of J₀ at the farthest radius in a piece, while poles are near the path, and beyond, where viscosity has damped them.
    const CYCLES: [f64; 2] = [1.7, 3.0];
    const DAMPED: f64 = 400.0;
    /// Cut-off e^{-(k/k_c)^p}: 1e-5 away from one at twice the sound's wavenumber, and ended at four times.
    const POWER: i32 = 20;
    const CUT: f64 = 1.153;
    const END: f64 = 1.18;
    let cut = CUT * PI / step;
    let height = RISE / farthest;
    let at = |t: f64| Complex64::new(t, t.min(height));
    // Finer towards k = 0, where slow waves have their poles.
    let mut ends = vec![0.0];
    ends.extend((-6..=0).map(|n| height * 2f64.powi(n)));
    let last = END * cut;
    for (until, cycles) in [height.max(DAMPED).min(last), last].into_iter().zip(CYCLES) {
        let first = ends[ends.len() - 1];
        let pieces = ((until - first) * farthest / (TAU * cycles)).ceil();
        ends.extend((1..=pieces as usize).map(|n| first + (until - first) * n as f64 / pieces));
    }
    let rule = gauss_legendre(NODES);
    let piece = |ends: &[f64]| {
        let (start, end) = (at(ends[0]), at(ends[1]));
        let node = move |&(x, weight): &(f64, f64)| {
            let k = (start + end) / 2.0 + (end - start) / 2.0 * x;
            let taper = (-(k / cut).powi(POWER)).exp();
            [k, (end - start) / 2.0 * weight * taper * k / TAU]
        };
        rule.iter().map(node).collect::<Vec<_>>()
    };
    ends.windows(2).flat_map(piece).collect()
}

/// A place between the entries of a table that is even about 0 (Lagrange).
#[derive(Clone, Copy, Debug)]
struct Place {
    first: i32,
    weights: [f64; TAPS],
}

impl Place {
    fn new(place: f64) -> Self {
        let first = place.floor() as i32 - (TAPS as i32 / 2 - 1);
        let weight = |i: usize| {
            let others = (0..TAPS).filter(|j| *j != i);
            others.map(|j| (place - f64::from(first) - j as f64) / (i as f64 - j as f64)).product()
        };
        Self { first, weights: std::array::from_fn(weight) }
    }

    fn between(&self, table: impl Fn(usize) -> Complex64) -> Complex64 {
        let taps = (self.first..).zip(&self.weights);
        taps.map(|(entry, weight)| table(entry.unsigned_abs() as usize) * weight).sum()
    }
}

/// J₀ of a complex number with a positive real part.
fn bessel_0(z: Complex64) -> Complex64 {
    /// |z| from which Hankel's expansion is as accurate as the series.
    const FAR: f64 = 12.0;
    if z.norm_sqr() < FAR * FAR {
        let square = -z * z / 4.0;
        let (mut term, mut sum, mut m) = (Complex64::ONE, Complex64::ONE, 1.0);
        while term.norm_sqr() > 1e-34 && m < 60.0 {
            term *= square / (m * m);
            sum += term;
            m += 1.0;
        }
        return sum;
    }
    // Terms a_m/z^m with a_m/a_{m-1} = -(2m - 1)²/(8m), of alternating parts.
    let inverse = z.inv();
    let (mut term, mut parts) = (Complex64::ONE, [Complex64::ONE, Complex64::ZERO]);
    for m in 1..20 {
        let next = term * inverse * (-f64::from((2 * m - 1) * (2 * m - 1)) / f64::from(8 * m));
        if next.norm_sqr() > term.norm_sqr() || next.norm_sqr() < 1e-26 {
            break;
        }
        term = next;
        parts[m as usize % 2] += if m / 2 % 2 == 0 { term } else { -term };
    }
    let up = (Complex64::I * (z - FRAC_PI_4)).exp();
    let down = up.inv();
    let [even, odd] = parts;
    (0.5 * PI * z).inv().sqrt() * 0.5 * (even * (up + down) + odd * Complex64::I * (up - down))
}
