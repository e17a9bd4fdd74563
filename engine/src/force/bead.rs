//! A sphere small against the wavelength: its Gor'kov potential, radiation force and stiffness.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::acoustics::{Air, Along, Derivatives};
use crate::scene::Bead;

/// Limit of ka for small-sphere forces.
pub const SMALL: f64 = 0.3;

/// A bead in inviscid air with sound of one wavenumber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Wavenumber times radius.
    pub ka: f64,
    /// Contrast of compressibility, 1 - κ/κ₀.
    pub monopole: f64,
    /// Contrast of density, 2(ρ - ρ₀)/(2ρ + ρ₀).
    pub dipole: f64,
    /// m³
    pub volume: f64,
    /// kg
    pub mass: f64,
    /// Mass of the displaced air, kg.
    displaced: f64,
    /// U of |p|² (m³/Pa), and less U of |∇p|² (m⁵/Pa).
    of_pressure: f64,
    of_gradient: f64,
    /// F of p ∇p* and of ∇p·∇∇p*: the coefficients of Sapozhnikov and Bailey, conjugate for e^{jωt}.
    coupling: [Complex64; 2],
}

impl Sphere {
    pub fn new(bead: &Bead, air: &Air, wavenumber: f64) -> Self {
        let (radius, density) = (bead.radius, bead.density());
        let compressibility = 1.0 / (air.density * air.sound_speed.powi(2));
        let own = 1.0 / (density * bead.sound_speed().powi(2));
        let monopole = 1.0 - own / compressibility;
        let dipole = 2.0 * (density - air.density) / (2.0 * density + air.density);
        let volume = 4.0 / 3.0 * PI * radius.powi(3);
        let (k, ka) = (wavenumber, wavenumber * radius);
        let (cube, sixth) = (ka.powi(3), ka.powi(6));
        let first =
            Complex64::new(2.0 / 3.0 * cube * monopole, -2.0 / 9.0 * sixth * monopole * (monopole + dipole));
        let second = Complex64::new(-cube * dipole, -sixth / 6.0 * dipole * dipole);
        let angular = k * air.sound_speed;
        Self {
            ka,
            monopole,
            dipole,
            volume,
            mass: volume * density,
            displaced: volume * air.density,
            of_pressure: volume * monopole * compressibility / 4.0,
            of_gradient: 3.0 / 8.0 * volume * dipole / (air.density * angular * angular),
            coupling: [
                (first * (-PI * compressibility / k.powi(3))).conj(),
                (second * (-PI * compressibility / k.powi(5))).conj(),
            ],
        }
    }

    /// Coefficients of Gor'kov's potential, a|p|² - b|∇p|²: a in m³/Pa, b in m⁵/Pa.
    pub fn potential_coefficients(&self) -> [f64; 2] {
        [self.of_pressure, self.of_gradient]
    }

    /// Coefficients A and B of the force, Re{A p ∂p* + B Σᵢ ∂ᵢp (∂ᵢ∂p)*}: in m³/Pa and m⁵/Pa.
    pub(crate) fn coupling(&self) -> [Complex64; 2] {
        self.coupling
    }

    /// Inertial mass (kg): the sphere's mass plus half of the displaced air's.
    pub fn inertia(&self) -> f64 {
        self.mass + 0.5 * self.displaced
    }

    /// N, weight less the buoyancy of the air, at this gravity (m/s²).
    pub fn load(&self, gravity: f64) -> f64 {
        (self.mass - self.displaced) * gravity
    }

    /// J, Gor'kov's potential.
    pub fn potential(&self, sound: &Derivatives) -> f64 {
        let squares: f64 = (0..3).map(|i| sound.slope(i).norm_sqr()).sum();
        self.of_pressure * sound.pressure().norm_sqr() - self.of_gradient * squares
    }

    /// Radiation force (N), including scattering of travelling waves.
    pub fn force(&self, sound: &Derivatives) -> DVec3 {
        let [a, b] = self.coupling;
        let along = |q: usize| {
            let inner: Complex64 = (0..3).map(|i| sound.slope(i) * sound.second(i, q).conj()).sum();
            (a * sound.pressure() * sound.slope(q).conj() + b * inner).re
        };
        DVec3::from_array([0, 1, 2].map(along))
    }

    /// N/m, -∂Fᵢ/∂xⱼ in row i and column j.
    pub fn stiffness(&self, sound: &Derivatives) -> DMat3 {
        let [a, b] = self.coupling;
        let at = |q: usize, s: usize| {
            let outer = sound.slope(s) * sound.slope(q).conj() + sound.pressure() * sound.second(q, s).conj();
            let inner = |i: usize| {
                sound.second(i, s) * sound.second(i, q).conj() + sound.slope(i) * sound.third(i, q, s).conj()
            };
            -(a * outer + b * (0..3).map(inner).sum::<Complex64>()).re
        };
        DMat3::from_cols_array_2d(&[0, 1, 2].map(|s| [0, 1, 2].map(|q| at(q, s))))
    }

    /// The stiffness along a direction, N/m, and its gradient: Re Σ conj(g) δ over all derivatives of the sound.
    pub(crate) fn stiffness_along(&self, sound: &Derivatives, direction: DVec3) -> (f64, Derivatives) {
        let v = direction.to_array();
        let [a, b] = self.coupling;
        let along = sound.along(v);
        let mut slope = Along::default();
        // -Re{A (p_v p_v* + p p_vv*) + B Σ (p_iv p_iv* + p_i p_ivv*)}
        let mut value = -(a * (along.first.norm_sqr() + sound.pressure() * along.second.conj())).re;
        slope.first -= 2.0 * a.re * along.first;
        slope.pressure -= a.conj() * along.second;
        slope.second -= a * sound.pressure();
        for i in 0..3 {
            value -= (b * (along.slopes[i].norm_sqr() + sound.slope(i) * along.seconds[i].conj())).re;
            slope.slopes[i] -= 2.0 * b.re * along.slopes[i];
            slope.own[i] -= b.conj() * along.seconds[i];
            slope.seconds[i] -= b * sound.slope(i);
        }
        (value, slope.spread(v))
    }

    /// A component of the force, N, and its gradient, likewise.
    pub(crate) fn force_along(&self, sound: &Derivatives, direction: DVec3) -> (f64, Derivatives) {
        let v = direction.to_array();
        let [a, b] = self.coupling;
        let along = sound.along(v);
        let mut slope = Along::default();
        let mut value = (a * sound.pressure() * along.first.conj()).re;
        slope.pressure += a.conj() * along.first;
        slope.first += a * sound.pressure();
        for i in 0..3 {
            value += (b * sound.slope(i) * along.slopes[i].conj()).re;
            slope.own[i] += b.conj() * along.slopes[i];
            slope.slopes[i] += b * sound.slope(i);
        }
        (value, slope.spread(v))
    }

    /// The warning for beads that are not small.
    pub fn warning(&self) -> Option<String> {
        (self.ka > SMALL).then(|| {
            format!(
                "the bead's ka is {:.2}: the force model assumes a bead much smaller than the wavelength; above {SMALL} it is an \
                 estimate",
                self.ka
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Medium;

    #[test]
    fn a_bead_that_is_not_small_has_a_warning_with_its_ka() {
        let (frequency, medium) = (40_000.0, Medium::default());
        let air = Air::new(&medium, frequency);
        let wavenumber = 2.0 * PI * frequency / air.sound_speed;
        let warning = |ka: f64| {
            let bead = Bead { radius: ka / wavenumber, ..Bead::default() };
            Sphere::new(&bead, &air, wavenumber).warning()
        };
        assert_eq!(warning(0.99 * SMALL), None);
        assert!(warning(0.31).is_some_and(|text| text.contains("0.31")));
    }
}
