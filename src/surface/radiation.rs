//! Radiation pressure on a surface that reflects all sound.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::acoustics::Air;

/// What turns incident sound into the pressure on a rigid surface, or one of a liquid, which reflects 99.9 % of it.
///
/// On such a surface the incident pressure P (complex, peak) doubles, and only the velocity v along it is left. The mean of
/// ⟨p²⟩/(2ρc²) - ρ⟨v²⟩/2 is then |P|²/(ρc²) - |∇P|²/(ρω²), ∇ taken along the surface. For a plane wave at the angle θ this is
/// Langevin's 2⟨p²⟩cos²θ/(ρc²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflector {
    /// 1/(ρc²), 1/Pa
    pub of_pressure: f64,
    /// 1/(ρω²), m²/Pa
    pub of_gradient: f64,
}

impl Reflector {
    /// In this air, at `frequency` (Hz).
    pub fn new(air: &Air, frequency: f64) -> Self {
        let angular = TAU * frequency;
        Self {
            of_pressure: 1.0 / (air.density * air.sound_speed.powi(2)),
            of_gradient: 1.0 / (air.density * angular * angular),
        }
    }

    /// Pa, from the incident pressure (Pa, peak) and its gradient along the surface (Pa/m).
    pub fn pressure(&self, incident: Complex64, gradient: [Complex64; 2]) -> f64 {
        let along = gradient[0].norm_sqr() + gradient[1].norm_sqr();
        self.of_pressure * incident.norm_sqr() - self.of_gradient * along
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Medium;

    #[test]
    fn a_plane_wave_gives_langevins_pressure() {
        let air = Air::new(&Medium::default(), 40e3);
        let reflector = Reflector::new(&air, 40e3);
        let wavenumber = TAU * 40e3 / air.sound_speed;
        for (angle, turn) in [(0.0f64, 0.0f64), (0.4, 1.0), (1.2, 4.0)] {
            let incident = Complex64::from_polar(842.0 * 2f64.sqrt(), 0.7);
            let along = Complex64::new(0.0, wavenumber * angle.sin()) * incident;
            let pressure = reflector.pressure(incident, [along * turn.cos(), along * turn.sin()]);
            let expected =
                2.0 * 842f64.powi(2) / (air.density * air.sound_speed.powi(2)) * angle.cos().powi(2);
            assert!((pressure - expected).abs() < 1e-12 * 10.0, "{pressure} {expected}");
            // 842 Pa RMS straight on press with 10 Pa.
            assert!((expected - 10.0 * angle.cos().powi(2)).abs() < 0.01);
        }
    }
}
