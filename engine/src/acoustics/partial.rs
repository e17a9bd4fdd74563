//! The sound about a point as regular partial waves: p = Σ a j_n(kr) Y_nm, with real orthonormal harmonics Y.
//!
//! The coefficients are integrals of the pressure over a small sphere, a = ∮ p Y dΩ / j_n(kR). A product rule of
//! Gauss in height and equal steps around takes them from 2(L + 1)² points, exactly for all orders up to L; of
//! higher orders j_n(kR) leaves next to nothing. So every element has them, however its wave is given: of point
//! sources and exact pistons, which obey the wave equation, to rounding; of far-field pistons, whose wave does not
//! quite, as the wave that it is near the point.
//!
//! With X the matrix of the direction cosine v·r/r between harmonics of neighbouring orders, a step along v changes
//! the coefficients by D a, D = k(X↓ - X↑): from j_n' = j_{n-1} - (n + 1) j_n/x and its twin.

use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2, TAU};
use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::acoustics::{aperture::Aperture, transfer::Transfer};
use crate::special::{bessel, gauss_legendre};

/// Highest order.
pub const MOST: usize = 24;

/// Coefficients of the partial waves about a point, Pa: the harmonic of order n and degree m at n² + n + m, with
/// cosines of positive and sines of negative degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct PartialWaves {
    order: usize,
    /// rad/m
    wavenumber: f64,
    values: Vec<Complex64>,
}

impl PartialWaves {
    /// Those up to an order, of a field with this wavenumber, from its pressures (Pa) on a sphere about a point (m).
    ///
    /// # Panics
    /// An order of 0 or above 24.
    pub fn new(
        order: usize,
        wavenumber: f64,
        (at, radius): (DVec3, f64),
        pressures: impl FnOnce(&[DVec3]) -> Vec<Complex64>,
    ) -> Self {
        let pressures = pressures(&Self::points(order, (at, radius)));
        let sum = |weights: &[f64]| weights.iter().zip(&pressures).map(|(weight, p)| weight * p).sum();
        let mut values: Vec<Complex64> = shell(order).rows().map(sum).collect();
        let bessel = bessel::spherical(order, wavenumber * radius);
        values.iter_mut().enumerate().for_each(|(harmonic, value)| *value /= bessel[harmonic.isqrt()]);
        Self { order, wavenumber, values }
    }

    /// The weights of those pressures in every coefficient up to an order, for a sphere of this radius times wavenumber.
    pub(crate) fn weights(order: usize, size: f64) -> impl Iterator<Item = Vec<f64>> {
        let bessel = bessel::spherical(order, size);
        let of_harmonic = move |(harmonic, weights): (usize, &[f64])| {
            weights.iter().map(|weight| weight / bessel[harmonic.isqrt()]).collect()
        };
        shell(order).rows().enumerate().map(of_harmonic)
    }

    /// The points of that sphere.
    pub(crate) fn points(order: usize, (at, radius): (DVec3, f64)) -> Vec<DVec3> {
        shell(order).directions.iter().map(|direction| at + *direction * radius).collect()
    }

    /// Those with these coefficients.
    ///
    /// # Panics
    /// Other than a coefficient per harmonic.
    pub fn with(order: usize, wavenumber: f64, values: Vec<Complex64>) -> Self {
        assert_eq!(values.len(), (order + 1).pow(2), "a coefficient per harmonic");
        Self { order, wavenumber, values }
    }

    /// The same orders without sound.
    pub(crate) fn silent(&self) -> Self {
        Self { values: vec![Complex64::ZERO; self.values.len()], ..*self }
    }

    /// Adds a multiple of others of the same orders.
    pub(crate) fn add(&mut self, other: &Self, factor: f64) {
        self.values.iter_mut().zip(&other.values).for_each(|(own, other)| *own += factor * other);
    }

    pub fn order(&self) -> usize {
        self.order
    }

    /// rad/m
    pub fn wavenumber(&self) -> f64 {
        self.wavenumber
    }

    pub fn values(&self) -> &[Complex64] {
        &self.values
    }

    pub(crate) fn values_mut(&mut self) -> &mut [Complex64] {
        &mut self.values
    }

    /// Coefficients of an order, all degrees.
    pub fn of_order(&self, order: usize) -> &[Complex64] {
        &self.values[order * order..(order + 1) * (order + 1)]
    }

    /// Pa
    pub fn pressure(&self) -> Complex64 {
        self.values[0] * (0.5 / PI.sqrt())
    }

    /// The slope of the pressure, Pa/m.
    pub fn slope(&self) -> [Complex64; 3] {
        // Y₁ is √(3/4π) (y, z, x), and j₁(x) is x/3.
        [3, 1, 2].map(|at: usize| self.values[at] * (self.wavenumber / (12.0 * PI).sqrt()))
    }

    /// The pressure (Pa) of outgoing waves with these coefficients times a factor for each order, at a way (m) from the
    /// centre.
    pub(crate) fn outgoing(&self, factors: &[Complex64], way: DVec3) -> Complex64 {
        let order = self.order.min(factors.len() - 1);
        let x = self.wavenumber * way.length();
        let harmonics = harmonics(order, way.normalize_or_zero());
        let of_order = |(n, (j, y)): (usize, (f64, f64))| {
            let degrees = n * n..(n + 1) * (n + 1);
            let pairs = self.values[degrees.clone()].iter().zip(&harmonics[degrees]);
            factors[n] * Complex64::new(j, -y) * pairs.map(|(a, harmonic)| a * harmonic).sum::<Complex64>()
        };
        let radial = bessel::spherical(order, x).into_iter().zip(bessel::spherical_second(order, x));
        radial.enumerate().map(of_order).sum()
    }

    /// The partial waves of the derivative along v, Pa per unit of v; those of the highest order lack the order above.
    pub(crate) fn along(&self, v: DVec3) -> Self {
        let Self { mut values, .. } = self.silent();
        let parts = (v * self.wavenumber).to_array();
        for (axis, part) in couplings(self.order).iter().zip(parts).filter(|(_, part)| *part != 0.0) {
            for &Coupling { lower, upper, cosine, .. } in axis {
                values[lower] += part * cosine * self.values[upper];
                values[upper] -= part * cosine * self.values[lower];
            }
        }
        Self { values, ..*self }
    }
}

/// The couplings along x, y and z of all orders up to one, by rising order.
pub(crate) fn couplings(order: usize) -> &'static [Vec<Coupling>; 3] {
    &shell(order).couplings
}

impl Aperture {
    /// The transfer from every driven element to the partial waves up to an order, from the sphere of a radius about a
    /// point (m): a row per harmonic.
    pub(crate) fn partial_waves(&self, order: usize, (at, radius): (DVec3, f64)) -> Transfer {
        let pressures = self.transfer(&PartialWaves::points(order, (at, radius)));
        let mut waves = Transfer::zeros((order + 1).pow(2), self.driven.len());
        let bessel = bessel::spherical(order, self.element.wavenumber * radius);
        for (harmonic, weights) in shell(order).rows().enumerate() {
            let (to_re, to_im) = waves.row_mut(harmonic);
            for (point, weight) in weights.iter().map(|weight| weight / bessel[harmonic.isqrt()]).enumerate()
            {
                let (re, im) = pressures.parts(point);
                to_re.iter_mut().zip(re).for_each(|(to, own)| *to += weight * own);
                to_im.iter_mut().zip(im).for_each(|(to, own)| *to += weight * own);
            }
        }
        waves
    }
}

/// The cosine of an axis between two harmonics, the lower one of this order and the upper one of the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coupling {
    pub order: usize,
    pub lower: usize,
    pub upper: usize,
    pub cosine: f64,
}

/// The points of a sphere, and their weights in the integrals of all harmonics up to an order.
#[derive(Debug)]
struct Shell {
    directions: Vec<DVec3>,
    /// A row of weights per harmonic.
    weights: Vec<f64>,
    /// Along x, y and z.
    couplings: [Vec<Coupling>; 3],
}

fn shell(order: usize) -> &'static Shell {
    static SHELLS: [OnceLock<Shell>; MOST + 1] = [const { OnceLock::new() }; MOST + 1];
    assert!((1..=MOST).contains(&order), "an order of partial waves");
    SHELLS[order].get_or_init(|| Shell::new(order))
}

impl Shell {
    fn new(order: usize) -> Self {
        let around = 2 * order + 2;
        let (mut directions, mut areas) = (Vec::new(), Vec::new());
        for (z, weight) in gauss_legendre(order + 1) {
            for turn in 0..around {
                let flat = DVec2::from_angle(TAU * turn as f64 / around as f64) * (1.0 - z * z).sqrt();
                directions.push(flat.extend(z));
                areas.push(weight * TAU / around as f64);
            }
        }
        let harmonics: Vec<_> = directions.iter().map(|direction| harmonics(order, *direction)).collect();
        let weight = |harmonic: usize, point: usize| areas[point] * harmonics[point][harmonic];
        let rows = (0..(order + 1).pow(2)).flat_map(|harmonic| {
            (0..directions.len()).map(move |point| (harmonic, point)).collect::<Vec<_>>()
        });
        let weights = rows.map(|(harmonic, point)| weight(harmonic, point)).collect();
        let couplings = [0, 1, 2].map(|axis: usize| {
            let mut couplings = Vec::new();
            for lower in 0..order * order {
                let above = lower.isqrt() + 1;
                let uppers = above * above..(above + 1) * (above + 1);
                for upper in uppers {
                    let product = |(point, harmonics): (usize, &Vec<f64>)| {
                        weight(lower, point) * directions[point][axis] * harmonics[upper]
                    };
                    let cosine: f64 = harmonics.iter().enumerate().map(product).sum();
                    if cosine.abs() > 1e-9 {
                        couplings.push(Coupling { order: above - 1, lower, upper, cosine });
                    }
                }
            }
            couplings
        });
        Self { directions, weights, couplings }
    }

    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.weights.chunks_exact(self.directions.len())
    }
}

/// Real orthonormal spherical harmonics up to an order in a direction (a unit vector): polynomials in its height
/// times the real and imaginary parts of (x + jy)^m.
fn harmonics(order: usize, direction: DVec3) -> Vec<f64> {
    let mut all = vec![0.0; (order + 1) * (order + 1)];
    let (mut flat, mut first) = (Complex64::ONE, 0.5 * FRAC_1_SQRT_2 * (2.0 / PI).sqrt());
    for m in 0..=order {
        let (mut before, mut this) = (0.0, first);
        for n in m..=order {
            let (centre, norm) = (n * n + n, if m == 0 { 1.0 } else { SQRT_2 });
            all[centre + m] = norm * this * flat.re;
            if m > 0 {
                all[centre - m] = norm * this * flat.im;
            }
            let (n, m) = ((n + 1) as f64, m as f64);
            let scale = ((4.0 * n * n - 1.0) / (n * n - m * m)).sqrt();
            let last = (((n - 1.0).powi(2) - m * m) / (4.0 * (n - 1.0).powi(2) - 1.0)).sqrt();
            (before, this) = (this, scale * (direction.z * this - last * before));
        }
        first *= ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
        flat *= Complex64::new(direction.x, direction.y);
    }
    all
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    /// A standing and a travelling plane wave.
    fn field(at: DVec3) -> Complex64 {
        const K: f64 = 700.0;
        let way = dvec3(0.48, -0.64, 0.6);
        Complex64::cis(-K * way.dot(at)) + 0.5 * (K * at.z + 0.3).cos()
    }

    #[test]
    fn pressure_and_slope_are_those_of_the_field() {
        let at = dvec3(0.01, 0.02, 0.1);
        for order in [3, 5, 9] {
            let waves = PartialWaves::new(order, 700.0, (at, 5e-4), |points| {
                points.iter().map(|at| field(*at)).collect()
            });
            assert!((waves.pressure() - field(at)).norm() < 1e-8, "{order}: {}", waves.pressure());
            for (axis, slope) in DVec3::AXES.into_iter().zip(waves.slope()) {
                let expected = (field(at + axis * 1e-7) - field(at - axis * 1e-7)) / 2e-7;
                assert!((slope - expected).norm() < 1e-5 * 700.0, "{order}: {slope}, not {expected}");
            }
        }
    }

    #[test]
    fn waves_along_a_direction_are_those_of_the_derivative() {
        let (at, v, step) = (dvec3(-0.01, 0.005, 0.03), dvec3(0.36, 0.48, -0.8), 1e-6);
        let about = |at: DVec3| {
            PartialWaves::new(8, 700.0, (at, 1.5e-3), |points| points.iter().map(|at| field(*at)).collect())
        };
        let (own, before, after) = (about(at).along(v), about(at - v * step), about(at + v * step));
        // The highest orders have parts of those above them.
        for harmonic in 0..36 {
            let expected = (after.values[harmonic] - before.values[harmonic]) / (2.0 * step);
            let off = (own.values[harmonic] - expected).norm();
            assert!(off < 1e-4 * 700.0, "{harmonic}: {}, not {expected}", own.values[harmonic]);
        }
    }
}
