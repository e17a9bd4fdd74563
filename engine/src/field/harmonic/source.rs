//! The source of the second harmonic: its strength, the elements, and the scenes that have one.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::acoustics::{Air, Aperture, Face};

/// β of air, 1 + (γ - 1)/2.
pub const NONLINEARITY: f64 = 1.2;

/// Error of a map, relative to its peak: that of its steps.
pub const TOLERANCE: f64 = 0.03;

/// Deviation from 1 of a reflector's coefficient that counts as rigid.
const NOT_RIGID: f64 = 0.02;

/// The far fields of points and pistons grow without limit towards their centres: their sound nearer than this many
/// wavelengths to a board's plane is that at this height.
pub const NEAREST: f64 = 1.0 / 12.0;

/// Reasons why a scene has no second harmonic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoHarmonic {
    #[error(
        "the second harmonic needs reflectors that are rigid (`coefficient = 1.0`), one at most, and boards that do \
         not reflect (`reflectivity = 0.0`)"
    )]
    Reflector,
    #[error("harmonics with bodies in the field are not modelled: leave out [[body]]")]
    Bodies,
    #[error("no sound reaches the foci")]
    Silent,
    #[error(
        "the second harmonic of this plane needs too many samples of the air between it and the boards: use a smaller or \
         nearer plane"
    )]
    TooLarge,
}

/// 2βk²/(ρc²), 1/(Pa·m²).
pub fn source(aperture: &Aperture, air: &Air) -> f64 {
    let k = aperture.element.wavenumber;
    2.0 * NONLINEARITY * k * k / (air.density * air.sound_speed * air.sound_speed)
}

/// # Errors
/// Reflectors other than a single rigid one, or bodies.
pub fn check(aperture: &Aperture) -> Result<(), NoHarmonic> {
    if !aperture.bodies.is_empty() {
        return Err(NoHarmonic::Bodies);
    }
    let heard = aperture.mirrors.iter().filter(|mirror| mirror.coefficient != 0.0).count();
    let is_rigid = aperture.faces.iter().all(|face| (face.gain - 1.0).abs() < NOT_RIGID);
    if heard > 1 || !is_rigid || aperture.remainder > 0.0 { Err(NoHarmonic::Reflector) } else { Ok(()) }
}

/// Positions (m) and directions of all driven elements and their images.
pub fn elements(aperture: &Aperture) -> Vec<(DVec3, DVec3)> {
    let of_face = |face: &Face| {
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
pub fn wavelengths(aperture: &Aperture, count: f64) -> f64 {
    count * TAU / aperture.element.wavenumber
}
