//! The second harmonic: what finite amplitudes add to a sound at twice its frequency on the way.
//!
//! Westervelt's equation, ∇²p - p̈/c² = -β/(ρc⁴) ∂²(p²)/∂t², has for p = Re{P e^{jωt}} the source of 2ω in p² =
//! |P|²/2 + Re{P² e^{2jωt}}/2. In second order (quasi-linear: the harmonic takes nothing from the fundamental),
//!
//! ```text
//! ∇²P₂ + K²P₂ = q P²,    q = 2βk²/(ρc²),    K = 2k - jα₂
//! P₂(x) = -q ∫ P(x')² e^{-jKR}/(4πR) dV',    R = |x - x'|
//! ```
//!
//! with the absorption α₂ at 2f, and β = 1 + (γ - 1)/2 = 1.2 of air. A plane wave P e^{-jkx} gives |P₂| = βkx|P|²/(2ρc²),
//! the first term of Fubini's solution. P is the sound of the program with its own element model, before the boards;
//! an image in a rigid reflector is a board beyond it, in front of which the mirrored air sounds too: its integral is
//! the reflection of the harmonic. Other reflectors are refused ([`NoHarmonic`]).
//!
//! P₂ grows with the square of the drive, and P₂/P with the drive itself. It is right while it is small: at a ratio r
//! the fundamental loses about r²/2 of itself, and P₂ as much again.
//!
//! Two ways lead to it: [`at`] sums the integral itself for one loud point, in spherical coordinates about it, and
//! [`over`] marches plane waves of 2f through the air for all points of a plane. Tests compare both with each other
//! and with sums on lattices.

mod march;
mod point;

use std::f64::consts::TAU;

use glam::DVec3;

use crate::acoustics::{Air, Aperture};

pub use march::{MarchError, Overtone, Sampler, over};
pub use point::at;

/// β of air, 1 + (γ - 1)/2.
pub const NONLINEARITY: f64 = 1.2;

/// Error of a map, relative to its peak: that of its steps.
pub const TOLERANCE: f64 = 0.03;

/// Deviation from 1 of a reflector's coefficient that counts as rigid.
const NOT_RIGID: f64 = 0.02;

/// The far fields of points and pistons grow without limit towards their centres: their sound nearer than this many
/// wavelengths to a board's plane is that at this height.
const NEAREST: f64 = 1.0 / 12.0;

/// Reasons why a scene has no second harmonic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoHarmonic {
    #[error(
        "the second harmonic needs reflectors that are rigid (`coefficient = 1.0`), one at most, and boards that do \
         not reflect (`reflectivity = 0.0`)"
    )]
    Reflector,
    #[error("no sound reaches the foci")]
    Silent,
    #[error(
        "the second harmonic of this plane needs too many samples of the air between it and the boards: use a smaller or \
         nearer plane"
    )]
    TooLarge,
}

/// 2βk²/(ρc²), 1/(Pa·m²).
fn source(aperture: &Aperture, air: &Air) -> f64 {
    let k = aperture.element.wavenumber;
    2.0 * NONLINEARITY * k * k / (air.density * air.sound_speed * air.sound_speed)
}

/// # Errors
/// Reflectors other than a single rigid one.
fn check(aperture: &Aperture) -> Result<(), NoHarmonic> {
    let heard = aperture.mirrors.iter().filter(|mirror| mirror.coefficient != 0.0).count();
    let is_rigid = aperture.faces.iter().all(|face| (face.gain - 1.0).abs() < NOT_RIGID);
    if heard > 1 || !is_rigid || aperture.remainder > 0.0 { Err(NoHarmonic::Reflector) } else { Ok(()) }
}

/// Positions (m) and directions of all driven elements and their images.
fn elements(aperture: &Aperture) -> Vec<(DVec3, DVec3)> {
    let of_face = |face: &crate::acoustics::Face| {
        let driven = &aperture.driven[face.among(&aperture.driven)];
        let element = |&n: &usize| {
            let n = n - face.first;
            (face.pose.world(face.layout.positions[n]), face.pose.world_direction(face.layout.normal(n)))
        };
        driven.iter().map(element).collect::<Vec<_>>()
    };
    aperture.faces.iter().flat_map(of_face).collect()
}

/// Length (m) of `count` steps of this many to a wavelength.
fn wavelengths(aperture: &Aperture, count: f64) -> f64 {
    count * TAU / aperture.element.wavenumber
}
