//! A sphere in any field by its series of partial waves.
//!
//! About the centre of the sphere, incident sound from outside is Σ a j_n(kr) Y_nm. The sphere adds outgoing waves
//! Σ s_n a h_n(kr) Y_nm, h_n = j_n - j y_n, with s_n from its surface, ∂p/∂r = jkβ p: s_n = -(j_n' - jβ j_n)/
//! (h_n' - jβ h_n) at ka. β = (1 - C)/(1 + C) is the ratio of the admittances of surface and air for a pressure
//! reflection of C; a rigid sphere has β = 0. On the surface the Wronskian leaves p = Σ a (-j/(ka)²)/(h_n' - jβ h_n) Y_nm,
//! without the difference of large numbers (E. G. Williams, Fourier Acoustics, 1999, 6.10).
//!
//! The coefficients a are integrals of the incident pressure over two concentric spheres within the body, together by
//! least squares: at a zero of one j_n the other sphere still shows that order.

use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2, TAU};

use glam::{DVec2, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::scatter::patch::{Patch, Sound};
use crate::special::{bessel, gauss_legendre};

/// Radii of the sampled spheres, relative to the body's.
const SHELLS: [f64; 2] = [1.0, 0.82];
/// The part of the largest order's square below which an order counts for nothing.
const FAINT: f64 = 1e-14;

/// A sphere that scatters sound of one wavenumber.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    /// m
    centre: DVec3,
    /// m
    radius: f64,
    /// rad/m
    wavenumber: f64,
    /// Ratio of the admittances of surface and air.
    admittance: f64,
    /// s_n of every order.
    scattered: Vec<Complex64>,
    /// The total pressure on the surface per coefficient, of every order.
    surface: Vec<Complex64>,
}

impl Sphere {
    /// The sphere about a centre (m) with a radius (m) and the pressure reflection of its surface, above -1 and up to 1,
    /// for a wavenumber (rad/m); its orders resolve any sound from farther than a tenth of a radius away to 1e-10.
    pub fn new(centre: DVec3, radius: f64, coefficient: f64, wavenumber: f64) -> Self {
        Self::heard_from(radius, (centre, radius, coefficient), wavenumber)
    }

    /// Those orders of it that resolve sound of sources at a distance (m) from the centre as well.
    pub fn heard_from(
        distance: f64,
        (centre, radius, coefficient): (DVec3, f64, f64),
        wavenumber: f64,
    ) -> Self {
        let size = wavenumber * radius;
        // Waves of sources at a distance d decay by (a/d)^n beyond ka.
        let decay = (distance / radius).max(1.0).ln();
        let most = size + 9.0 * size.cbrt() + 24.0;
        let least = size + 5.0 * size.cbrt() + 5.0;
        let order = (size + 23.0 / decay.max(1e-9)).clamp(least, most.max(least));
        Self::with_order(order.ceil() as usize, (centre, radius, coefficient), wavenumber)
    }

    /// Those up to an order.
    pub fn with_order(
        order: usize,
        (centre, radius, coefficient): (DVec3, f64, f64),
        wavenumber: f64,
    ) -> Self {
        let (x, admittance) = (wavenumber * radius, (1.0 - coefficient) / (1.0 + coefficient));
        let (j, y) = (bessel::spherical(order + 1, x), bessel::spherical_second(order + 1, x));
        let hankel = |n: usize| Complex64::new(j[n], -y[n]);
        let slope = |f: &dyn Fn(usize) -> Complex64, n: usize| f(n) * (n as f64 / x) - f(n + 1);
        let condition =
            |f: &dyn Fn(usize) -> Complex64, n: usize| slope(f, n) - Complex64::new(0.0, admittance) * f(n);
        let outgoing: Vec<_> = (0..=order).map(|n| condition(&hankel, n)).collect();
        let regular = |n: usize| condition(&|n| Complex64::from(j[n]), n);
        let scattered = (0..=order).map(|n| -regular(n) / outgoing[n]).collect();
        let surface = (0..=order).map(|n| Complex64::new(0.0, -1.0 / (x * x)) / outgoing[n]).collect();
        Self { centre, radius, wavenumber, admittance, scattered, surface }
    }

    /// m
    pub fn radius(&self) -> f64 {
        self.radius
    }

    pub fn order(&self) -> usize {
        self.scattered.len() - 1
    }

    /// The points (m) at which [`Self::coefficients`] takes incident pressures.
    pub fn points(&self) -> Vec<DVec3> {
        let around = 2 * self.order() + 2;
        let direction = move |z: f64, turn: usize| {
            (DVec2::from_angle(TAU * turn as f64 / around as f64) * (1.0 - z * z).sqrt()).extend(z)
        };
        let heights = gauss_legendre(self.order() + 1);
        let ring = |(shell, z): (f64, f64)| {
            (0..around).map(move |turn| self.centre + direction(z, turn) * (shell * self.radius))
        };
        let rings = SHELLS.into_iter().flat_map(|shell| heights.iter().map(move |(z, _)| (shell, *z)));
        rings.flat_map(ring).collect()
    }

    /// The coefficients a (Pa) of incident sound from its pressures (Pa) at [`Self::points`]: the harmonic of order n
    /// and degree m at n² + n + m.
    ///
    /// # Panics
    /// Other than a pressure per point.
    pub fn coefficients(&self, pressures: &[Complex64]) -> Vec<Complex64> {
        let (order, around) = (self.order(), 2 * self.order() + 2);
        let heights = gauss_legendre(order + 1);
        assert_eq!(pressures.len(), SHELLS.len() * heights.len() * around, "a pressure per point");
        let count = (order + 1).pow(2);
        let (mut sums, mut weights) = (vec![Complex64::ZERO; count], vec![0.0; order + 1]);
        let turn = |m: usize, step: usize| {
            let angle = TAU * ((m * step) % around) as f64 / around as f64;
            (angle.cos(), angle.sin())
        };
        let turns: Vec<_> =
            (0..=order).map(|m| (0..around).map(|step| turn(m, step)).collect::<Vec<_>>()).collect();
        for (shell, pressures) in SHELLS.iter().zip(pressures.chunks(heights.len() * around)) {
            let j = bessel::spherical(order, self.wavenumber * self.radius * shell);
            weights.iter_mut().zip(&j).for_each(|(weight, j)| *weight += j * j);
            for ((z, weight), ring) in heights.iter().zip(pressures.chunks(around)) {
                let meridian = harmonics(order, DVec2::new((1.0 - z * z).sqrt(), 0.0).extend(*z)).0;
                let area = weight * TAU / around as f64;
                for m in 0..=order {
                    let (mut cosines, mut sines) = (Complex64::ZERO, Complex64::ZERO);
                    for (p, (cosine, sine)) in ring.iter().zip(&turns[m]) {
                        cosines += p * cosine;
                        sines += p * sine;
                    }
                    for n in m..=order {
                        let part = area * j[n] * meridian[n * n + n + m];
                        sums[n * n + n + m] += part * cosines;
                        if m > 0 {
                            sums[n * n + n - m] += part * sines;
                        }
                    }
                }
            }
        }
        // Orders that the smallest numbers cannot hold are silent.
        let scale = |harmonic: usize| {
            let weight = weights[harmonic.isqrt()];
            if weight > 1e-250 { 1.0 / weight } else { 0.0 }
        };
        sums.iter().enumerate().map(|(harmonic, sum)| sum * scale(harmonic)).collect()
    }

    /// The coefficients of e^{-jkR}/R from a point (m) outside, Pa for a strength of 1 Pa·m:
    /// -4πjk Σ j_n(kr) h_n(kr₀) Y(r) Y(r₀).
    pub fn of_point_source(&self, source: DVec3) -> Vec<Complex64> {
        let (order, way) = (self.order(), source - self.centre);
        let x = self.wavenumber * way.length();
        let (j, y) = (bessel::spherical(order, x), bessel::spherical_second(order, x));
        let factor =
            |n: usize| Complex64::new(0.0, -4.0 * PI * self.wavenumber) * Complex64::new(j[n], -y[n]);
        let harmonics = harmonics(order, way.normalize_or(DVec3::Z)).0;
        harmonics.iter().enumerate().map(|(harmonic, y)| factor(harmonic.isqrt()) * y).collect()
    }

    /// Scattered sound at a point (m) outside.
    pub fn scattered(&self, coefficients: &[Complex64], at: DVec3) -> Sound {
        let way = at - self.centre;
        let r = way.length();
        self.sum(coefficients, way / r, r, self.radial(r))
    }

    /// The weights of the coefficients in the scattered pressure at a point (m) outside, and in its slopes along the axes.
    pub fn weights(&self, at: DVec3) -> Vec<[Complex64; 4]> {
        let way = at - self.centre;
        let (r, direction) = (way.length(), way.normalize_or(DVec3::Z));
        let (harmonics, slopes) = harmonics(self.order(), direction);
        let mut weights = Vec::with_capacity(harmonics.len());
        for [value, slope] in self.radial(r) {
            let (first, degrees) = (weights.len(), 2 * weights.len().isqrt() + 1);
            let own = first..first + degrees;
            weights.extend(harmonics[own.clone()].iter().zip(&slopes[own]).map(|(y, along)| {
                let gradient =
                    [0, 1, 2].map(|axis| slope * (y * direction[axis]) + value * (along[axis] / r));
                [value * y, gradient[0], gradient[1], gradient[2]]
            }));
        }
        weights.resize(harmonics.len(), [Complex64::ZERO; 4]);
        weights
    }

    /// The outgoing wave of every order at a radius (m) and its slope, as far as the range of f64 goes.
    fn radial(&self, r: f64) -> impl Iterator<Item = [Complex64; 2]> {
        let (order, x) = (self.order(), self.wavenumber * r);
        let (j, y) = (bessel::spherical(order + 1, x), bessel::spherical_second(order + 1, x));
        let hankel = move |n: usize| Complex64::new(j[n], -y[n]);
        let own = move |n: usize| {
            let s = self.scattered[n];
            [s * hankel(n), s * (hankel(n) * (n as f64 / x) - hankel(n + 1)) * self.wavenumber]
        };
        // Beyond it the waves of an order are without weight.
        (0..=order).map(own).take_while(|[value, slope]| {
            [value.re, value.im, slope.re, slope.im].iter().all(|part| part.is_finite())
        })
    }

    /// The total pressure (Pa) on the surface in a direction (a unit vector) from the centre.
    pub fn on_surface(&self, coefficients: &[Complex64], direction: DVec3) -> Complex64 {
        self.along_surface(coefficients, direction).0
    }

    /// The same with its gradient along the surface (Pa/m).
    fn along_surface(&self, coefficients: &[Complex64], direction: DVec3) -> Sound {
        let radial = self.surface.iter().map(|value| [*value, Complex64::ZERO]);
        self.sum(coefficients, direction, self.radius, radial)
    }

    /// The surface at the nodes of Gauss's rule, for squares of the sound.
    pub(super) fn patches(&self, coefficients: &[Complex64]) -> Vec<Patch> {
        let counts = |n: &usize| {
            let own = &coefficients[n * n..(n + 1) * (n + 1)];
            own.iter().map(|a| (a * self.surface[*n]).norm_sqr()).sum::<f64>()
        };
        let squares: Vec<_> = (0..=self.order()).map(|n| counts(&n)).collect();
        let largest = squares.iter().fold(0.0, |most, own| f64::max(most, *own));
        // Squares have twice the order, forces and torques one more.
        let order = squares.iter().rposition(|own| *own > FAINT * largest).unwrap_or(0);
        let (rings, around) = (order + 2, 2 * order + 4);
        let slope = Complex64::new(0.0, self.wavenumber * self.admittance);
        let ring = |(z, weight): (f64, f64)| {
            (0..around).map(move |turn| (z, weight, TAU * turn as f64 / around as f64)).collect::<Vec<_>>()
        };
        let nodes: Vec<_> = gauss_legendre(rings).into_iter().flat_map(ring).collect();
        let patch = |&(z, weight, angle): &(f64, f64, f64)| {
            let normal = (DVec2::from_angle(angle) * (1.0 - z * z).sqrt()).extend(z);
            let (p, gradient) = self.along_surface(coefficients, normal);
            Patch {
                at: self.centre + normal * self.radius,
                normal,
                area: self.radius * self.radius * weight * TAU / around as f64,
                sound: (p, [0, 1, 2].map(|axis| gradient[axis] + slope * p * normal[axis])),
            }
        };
        nodes.par_iter().map(patch).collect()
    }

    /// The sum of harmonics with a factor and its radial slope (1/m) for each order.
    fn sum(
        &self,
        coefficients: &[Complex64],
        direction: DVec3,
        r: f64,
        radial: impl Iterator<Item = [Complex64; 2]>,
    ) -> Sound {
        let (harmonics, slopes) = harmonics(self.order(), direction);
        let (mut p, mut gradient) = (Complex64::ZERO, [Complex64::ZERO; 3]);
        for (n, [value, slope]) in radial.enumerate() {
            let degrees = n * n..(n + 1) * (n + 1);
            for ((a, y), along) in
                coefficients[degrees.clone()].iter().zip(&harmonics[degrees.clone()]).zip(&slopes[degrees])
            {
                p += a * value * y;
                for axis in 0..3 {
                    gradient[axis] += a * (slope * (y * direction[axis]) + value * (along[axis] / r));
                }
            }
        }
        (p, gradient)
    }
}

/// Real orthonormal spherical harmonics up to an order in a direction (a unit vector), as in
/// [`crate::acoustics::PartialWaves`], and their gradients on the unit sphere.
fn harmonics(order: usize, direction: DVec3) -> (Vec<f64>, Vec<DVec3>) {
    let count = (order + 1) * (order + 1);
    let (mut all, mut slopes) = (vec![0.0; count], vec![DVec3::ZERO; count]);
    let tangential = |slope: DVec3| slope - direction * slope.dot(direction);
    let (mut flat, mut before_flat) = (Complex64::ONE, Complex64::ZERO);
    let mut first = 0.5 * FRAC_1_SQRT_2 * (2.0 / PI).sqrt();
    for m in 0..=order {
        // A polynomial in z with its slope, times parts of (x + jy)^m with slopes m (x + jy)^(m-1).
        let (mut before, mut this) = ([0.0; 2], [first, 0.0]);
        let turned = before_flat * m as f64;
        for n in m..=order {
            let (centre, norm) = (n * n + n, if m == 0 { 1.0 } else { SQRT_2 });
            all[centre + m] = norm * this[0] * flat.re;
            slopes[centre + m] =
                tangential(DVec3::new(this[0] * turned.re, -this[0] * turned.im, this[1] * flat.re) * norm);
            if m > 0 {
                all[centre - m] = norm * this[0] * flat.im;
                slopes[centre - m] = tangential(
                    DVec3::new(this[0] * turned.im, this[0] * turned.re, this[1] * flat.im) * norm,
                );
            }
            let (n, m) = ((n + 1) as f64, m as f64);
            let scale = ((4.0 * n * n - 1.0) / (n * n - m * m)).sqrt();
            let last = (((n - 1.0).powi(2) - m * m) / (4.0 * (n - 1.0).powi(2) - 1.0)).sqrt();
            let next = [
                scale * (direction.z * this[0] - last * before[0]),
                scale * (this[0] + direction.z * this[1] - last * before[1]),
            ];
            (before, this) = (this, next);
        }
        first *= ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
        before_flat = flat;
        flat *= Complex64::new(direction.x, direction.y);
    }
    (all, slopes)
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    const K: f64 = 732.274_780;

    fn wave(at: DVec3, source: DVec3) -> Complex64 {
        let r = at.distance(source);
        Complex64::cis(-K * r) / r
    }

    #[test]
    fn scattered_sound_is_that_of_the_tables() {
        // numpy, f64, from the series in Legendre polynomials: a point source 0.1 m above the centre.
        let source = dvec3(0.0, 0.0, 0.1);
        type Case = (f64, [(f64, f64); 4], [(f64, f64); 4]);
        let cases: [Case; 2] = [
            (
                0.008,
                [
                    (-6.384310, 19.565115),
                    (6.355061, -15.794852),
                    (1.373564, -7.614913),
                    (2.543543, -9.597469),
                ],
                [(1.749335, -0.178972), (0.755991, 1.063094), (0.643117, 0.802782), (1.884314, -8.052719)],
            ),
            (
                0.02,
                [
                    (-9.573512, -22.784913),
                    (-9.789036, 15.726512),
                    (1.446519, -4.786999),
                    (-2.544251, 5.848843),
                ],
                [(-2.470324, 2.932387), (-2.657950, 0.116625), (-2.919723, -1.246195), (7.075475, -1.204003)],
            ),
        ];
        for (a, surface, outside) in cases {
            let sphere = Sphere::new(DVec3::ZERO, a, 1.0, K);
            let sampled = sphere.points().iter().map(|at| wave(*at, source)).collect::<Vec<_>>();
            let (sampled, exact) = (sphere.coefficients(&sampled), sphere.of_point_source(source));
            for (angle, (re, im)) in [0.0, 60.0, 120.0, 180.0f64].into_iter().zip(surface) {
                let (sine, cosine) = angle.to_radians().sin_cos();
                for coefficients in [&sampled, &exact] {
                    let p = sphere.on_surface(coefficients, dvec3(sine, 0.0, cosine));
                    assert!((p - Complex64::new(re, im)).norm() < 1e-6, "{a} {angle}: {p}");
                }
            }
            let points = [(0.0, 0.0, a + 0.02), (0.0, 0.03, 0.0), (0.03, 0.0, 0.03), (0.0, 0.0, -a - 0.02)];
            for ((x, y, z), (re, im)) in points.into_iter().zip(outside) {
                let (p, _) = sphere.scattered(&exact, dvec3(x, y, z));
                assert!((p - Complex64::new(re, im)).norm() < 1e-6, "{a} {x} {y} {z}: {p}");
                let (again, _) = sphere.scattered(&sampled, dvec3(x, y, z));
                assert!((p - again).norm() < 1e-10 * p.norm(), "{a} {x} {y} {z}: {again}, not {p}");
            }
        }
    }

    #[test]
    fn the_surface_obeys_its_condition() {
        let (centre, source) = (dvec3(0.01, -0.02, 0.12), dvec3(0.03, 0.01, 0.0));
        for (radius, coefficient) in [(0.002, 1.0), (5.7635 / K, 1.0), (0.02, 0.7), (0.03, 0.0), (0.01, -0.9)]
        {
            let sphere = Sphere::new(centre, radius, coefficient, K);
            let coefficients = sphere.of_point_source(source);
            let admittance = (1.0 - coefficient) / (1.0 + coefficient);
            for direction in [DVec3::X, DVec3::NEG_Z, dvec3(0.48, -0.64, 0.6)] {
                let at = centre + direction * radius;
                let (p, gradient) = sphere.scattered(&coefficients, at);
                let (way, r) = (at - source, at.distance(source));
                let incident = wave(at, source);
                let slope = |axis: usize| incident * Complex64::new(-1.0 / r, -K) * way[axis] / r;
                let along: Complex64 =
                    (0..3).map(|axis| (gradient[axis] + slope(axis)) * direction[axis]).sum();
                let total = p + incident;
                let expected = Complex64::new(0.0, K * admittance) * total;
                assert!(
                    (along - expected).norm() < 1e-9 * K * incident.norm(),
                    "{radius}: {along}, not {expected}"
                );
                let surface = sphere.on_surface(&coefficients, direction);
                assert!(
                    (surface - total).norm() < 1e-10 * incident.norm(),
                    "{radius}: {surface}, not {total}"
                );
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_pressure() {
        let sphere = Sphere::new(DVec3::ZERO, 0.008, 1.0, K);
        let coefficients = sphere.of_point_source(dvec3(0.01, 0.0, 0.1));
        for at in [dvec3(0.0, 0.0, 0.02), dvec3(0.01, -0.02, 0.005), dvec3(-0.009, 0.0, 0.0)] {
            let (p, gradient) = sphere.scattered(&coefficients, at);
            for (axis, slope) in DVec3::AXES.into_iter().zip(gradient) {
                let near = |step: f64| sphere.scattered(&coefficients, at + axis * step).0;
                let expected = (near(1e-6) - near(-1e-6)) / 2e-6;
                assert!((slope - expected).norm() < 1e-5 * K * p.norm(), "{at}: {slope}, not {expected}");
            }
        }
    }
}
