//! The radiation force on a sphere of any size, by partial waves: potential, force and stiffness.
//!
//! A partial wave a j_n Y is scattered as a s_n h_n Y, with s_n of a fluid sphere:
//!
//! s_n = (γ j_n'(x') j_n(x) - j_n(x') j_n'(x)) / (j_n(x') h_n'(x) - γ j_n'(x') h_n(x)), x = ka, x' = kac/c', γ = ρc/(ρ'c')
//!
//! (Faran, JASA 23:405, 1951, without shear, which air does not excite). With ψ_n = s_n + s*_{n+1} + 2 s_n s*_{n+1}, the
//! force along v is a sum over neighbouring orders (Sapozhnikov and Bailey, JASA 133:661, 2013),
//!
//! F_v = 1/(2ρc²k²) Im Σ ψ_n a_l X a*_u,
//!
//! with the cosines X of v between harmonics l of order n and u of the next ([`PartialWaves`]); s_n are of e^{-jωt}, for which
//! the program's coefficients are conjugate. It is the quadratic form ½ a* H a of a Hermitian H with entries between
//! neighbouring orders, so its slope by a is H a, and its slope along v follows from that of the waves, D a.
//! The imaginary parts of ψ make up the slope of a potential Σ U_n |a|², U_{n+1} - U_n = Im ψ_n/(4ρc²k³): Gor'kov's, of any
//! size. Their real parts, the scattering of travelling waves, have none. The sphere absorbs nothing, so there is no
//! torque on it.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::acoustics::{Air, Coupling, MOST_ORDER, PartialWaves, couplings};
use crate::scene::Bead;
use crate::special::bessel;

/// Largest ka of exact forces: up to it, the highest order of partial waves counts for nothing.
const LARGEST: f64 = 5.0;
/// Orders whose ψ is a smaller part of the largest are not asked for.
const NEGLIGIBLE: f64 = 1e-5;

/// A bead in inviscid air with sound of one wavenumber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// m
    pub radius: f64,
    /// Wavenumber times radius.
    pub ka: f64,
    /// m³
    pub volume: f64,
    /// kg
    pub mass: f64,
    /// Mass of the displaced air, kg.
    displaced: f64,
    /// conj(s_n), of outgoing waves of e^{jωt}.
    scattered: [Complex64; MOST_ORDER + 1],
    /// conj(ψ_n)/(2ρc²k²) in N/Pa²: entries of H between order n and the next are j times this and the cosine.
    coupling: [Complex64; MOST_ORDER],
    /// U_n of the potential, J/Pa².
    potential: [f64; MOST_ORDER + 1],
    /// Highest order of partial waves in the force.
    order: usize,
}

impl Sphere {
    pub fn new(bead: &Bead, air: &Air, wavenumber: f64) -> Self {
        let (radius, density) = (bead.radius, bead.density());
        let (k, ka) = (wavenumber, wavenumber * radius);
        let volume = 4.0 / 3.0 * PI * radius.powi(3);
        let scattered = scattered(ka, [density / air.density, bead.sound_speed() / air.sound_speed]);
        let unit = 0.5 / (air.density * air.sound_speed.powi(2) * k * k);
        let psi = |n: usize| {
            let (own, next) = (scattered[n], scattered[n + 1].conj());
            own + next + 2.0 * own * next
        };
        let coupling: [_; MOST_ORDER] = std::array::from_fn(|n| psi(n).conj() * unit);
        let mut potential = [0.0; MOST_ORDER + 1];
        for n in (0..MOST_ORDER).rev() {
            potential[n] = potential[n + 1] + coupling[n].im / (2.0 * k);
        }
        let largest = coupling.iter().map(|own| own.norm()).fold(0.0, f64::max);
        // The stiffness takes one order more.
        let last =
            coupling[..MOST_ORDER - 1].iter().rposition(|own| own.norm() > NEGLIGIBLE * largest).unwrap_or(0);
        Self {
            radius,
            ka,
            volume,
            mass: volume * density,
            displaced: volume * air.density,
            scattered: scattered.map(|s| s.conj()),
            coupling,
            potential,
            order: last + 1,
        }
    }

    /// Order of partial waves for potential and force.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Entry of H between the upper harmonic (row) and the lower, N/Pa².
    pub(crate) fn entry(&self, coupling: &Coupling) -> Complex64 {
        Complex64::I * self.coupling[coupling.order] * coupling.cosine
    }

    /// Coefficients of the scattered waves over those of the incident waves, of every order in the force.
    pub(crate) fn scattered(&self) -> &[Complex64] {
        &self.scattered[..=self.order]
    }

    /// U_n of every order, J/Pa².
    pub(crate) fn potentials(&self) -> &[f64] {
        &self.potential
    }

    /// Bounds of potential (J) and force (N) where waves of 1 Pa in all arrive.
    #[doc(hidden)]
    pub fn bounds(&self) -> [f64; 2] {
        let degrees = |n: usize| (2 * n + 1) as f64;
        let of_potential = |n: usize| 4.0 * PI * degrees(n) * self.potential[n].abs();
        let of_force = |n: usize| 4.0 * PI * degrees(n) * degrees(n + 1) * self.coupling[n].norm();
        [(0..=self.order).map(of_potential).sum(), (0..self.order).map(of_force).sum()]
    }

    /// Radius (m) of the sphere that partial waves are taken from: small enough for far-field pistons, whose sound is a wave
    /// only near a point, and large enough for the orders of the bead.
    #[doc(hidden)]
    pub fn shell(&self) -> f64 {
        self.radius * (self.ka / 3.0).max(0.15) / self.ka
    }

    /// Inertial mass (kg): the sphere's mass plus half of the displaced air's.
    pub fn inertia(&self) -> f64 {
        self.mass + 0.5 * self.displaced
    }

    /// N, weight less the buoyancy of the air, at this gravity (m/s²).
    pub fn load(&self, gravity: f64) -> f64 {
        (self.mass - self.displaced) * gravity
    }

    /// J, the potential of the force that has one; Gor'kov's of a small sphere.
    #[doc(hidden)]
    pub fn potential(&self, waves: &PartialWaves) -> f64 {
        let of_order = |order: usize| -> f64 {
            self.potential[order] * waves.of_order(order).iter().map(|a| a.norm_sqr()).sum::<f64>()
        };
        (0..=waves.order()).map(of_order).sum()
    }

    /// Radiation force (N), including scattering of travelling waves.
    #[doc(hidden)]
    pub fn force(&self, waves: &PartialWaves) -> DVec3 {
        DVec3::AXES.map(|axis| 0.5 * real_product(waves, &self.response(waves, axis))).into()
    }

    /// N/m, -∂Fᵢ/∂xⱼ in row i and column j, in sound that obeys the wave equation; of waves of one order more.
    #[doc(hidden)]
    pub fn stiffness(&self, waves: &PartialWaves) -> DMat3 {
        self.stiffness_by(waves, &DVec3::AXES.map(|axis| waves.along(axis)))
    }

    /// The same in any sound, from its waves and those of its slopes.
    pub(crate) fn stiffness_by(&self, waves: &PartialWaves, slopes: &[PartialWaves; 3]) -> DMat3 {
        let rows = DVec3::AXES.map(|axis| {
            let response = self.response(waves, axis);
            [0, 1, 2].map(|j: usize| -real_product(&slopes[j], &response))
        });
        DMat3::from_cols_array_2d(&rows).transpose()
    }

    /// The gradient of the stiffnesses times these symmetric weights, and of the forces times these: Re Σ conj(g) δ over all
    /// coefficients.
    pub(crate) fn gradient(
        &self,
        waves: &PartialWaves,
        of_stiffness: DMat3,
        of_force: DVec3,
    ) -> PartialWaves {
        // K is -Re (D a)* H a, and D is antisymmetric.
        let mut gradient = self.response(waves, of_force);
        let responses = DVec3::AXES.map(|axis| self.response(waves, axis));
        let slopes = DVec3::AXES.map(|axis| waves.along(axis));
        for (axis, weights) in DVec3::AXES.into_iter().zip(of_stiffness.to_cols_array_2d()) {
            let (mut response, mut slope) = (waves.silent(), waves.silent());
            for (weight, (own_response, own_slope)) in weights.into_iter().zip(responses.iter().zip(&slopes))
            {
                response.add(own_response, weight);
                slope.add(own_slope, weight);
            }
            gradient.add(&response.along(axis), 1.0);
            gradient.add(&self.response(&slope, axis), -1.0);
        }
        gradient
    }

    /// H a for the force along v, which is its gradient.
    pub(crate) fn response(&self, waves: &PartialWaves, v: DVec3) -> PartialWaves {
        let mut response = waves.silent();
        let (a, to) = (waves.values(), response.values_mut());
        for (axis, part) in couplings(waves.order()).iter().zip(v.to_array()).filter(|(_, part)| *part != 0.0)
        {
            for coupling in axis {
                let entry = self.entry(coupling) * part;
                to[coupling.lower] += entry.conj() * a[coupling.upper];
                to[coupling.upper] += entry * a[coupling.lower];
            }
        }
        response
    }

    /// The warning for beads that are too large.
    pub fn warning(&self) -> Option<String> {
        (self.ka > LARGEST)
            .then(|| format!("the bead's ka is {:.2}: its forces are exact up to {LARGEST}", self.ka))
    }
}

/// Re Σ conj(a) b
fn real_product(a: &PartialWaves, b: &PartialWaves) -> f64 {
    a.values().iter().zip(b.values()).map(|(a, b)| a.re * b.re + a.im * b.im).sum()
}

/// s_n of all orders, for density and sound speed of the sphere over those of the air.
fn scattered(ka: f64, [density, speed]: [f64; 2]) -> [Complex64; MOST_ORDER + 1] {
    let (gamma, within) = (1.0 / (density * speed), ka / speed);
    let order = MOST_ORDER + 1;
    let (j, y) = (bessel::spherical(order, ka), bessel::spherical_second(order, ka));
    let quotients = bessel::quotients(order, within);
    std::array::from_fn(|n| {
        let slope = |f: &[f64]| n as f64 / ka * f[n] - f[n + 1];
        // j_n'(x')/j_n(x')
        let inner = gamma * (n as f64 / within - quotients[n]);
        let (h, h_slope) = (Complex64::new(j[n], y[n]), Complex64::new(slope(&j), slope(&y)));
        (inner * j[n] - slope(&j)) / (h_slope - inner * h)
    })
}
