//! Every quantity in f64 from its formula, independently of `field::quantity`; slopes by differences over λ/10000.

use std::f64::consts::SQRT_2;

use glam::DVec3;
use num_complex::Complex64;
use sonoglyph::acoustics::{Air, Aperture};
use sonoglyph::drive::Drive;
use sonoglyph::field::{Quantity, Samples, reference};

/// The sound of one drive at a point.
#[derive(Clone, Copy, Debug)]
pub struct Sound {
    /// Pa, peak.
    pub p: Complex64,
    /// Pa/m, along the plane's axes and its normal.
    pub slopes: [Complex64; 3],
}

/// The sound at points farther than a difference step from the array's plane.
pub fn sounds(aperture: &Aperture, drive: &Drive, axes: [DVec3; 3], points: &[DVec3]) -> Vec<Sound> {
    let hair = 1e-4 * aperture.wavelength();
    let around = |&point: &DVec3| {
        let beside = axes.map(|axis| [point + axis * hair, point - axis * hair]);
        [point].into_iter().chain(beside.into_iter().flatten())
    };
    let samples = Samples::at(points.iter().flat_map(around).collect());
    let sound = |around: &[Complex64]| Sound {
        p: around[0],
        slopes: [1, 3, 5].map(|i| (around[i] - around[i + 1]) / (2.0 * hair)),
    };
    reference::pressure(aperture, drive, &samples).chunks(7).map(sound).collect()
}

/// As [`sounds`], without slopes.
pub fn pressures(aperture: &Aperture, drive: &Drive, points: &[DVec3]) -> Vec<Sound> {
    let pressures = reference::pressure(aperture, drive, &Samples::at(points.to_vec())).into_iter();
    pressures.map(|p| Sound { p, slopes: [Complex64::ZERO; 3] }).collect()
}

/// The value of a quantity at a point: of one drive, or the mean over several, of squares for RMS values. `moment` is
/// the ωt of an instantaneous pressure.
///
/// # Panics
/// A quantity that does not follow from the sound at a point.
pub fn value(
    quantity: Quantity,
    air: &Air,
    aperture: &Aperture,
    moment: f64,
    drives: impl ExactSizeIterator<Item = Sound>,
) -> f64 {
    let (rho, c) = (air.density, air.sound_speed);
    let omega = aperture.element.wavenumber * c;
    let (count, drives) = (drives.len() as f64, drives.collect::<Vec<_>>());
    let mean = |formula: &dyn Fn(Sound) -> f64| drives.iter().copied().map(formula).sum::<f64>() / count;
    match quantity {
        Quantity::Rms => mean(&|Sound { p, .. }| p.norm_sqr() / 2.0).sqrt(),
        Quantity::Phase => mean(&|Sound { p, .. }| p.im.atan2(p.re)),
        Quantity::Instantaneous => mean(&|Sound { p, .. }| (p * Complex64::cis(moment)).re),
        // 2⟨p²⟩ = |P|² of the doubled sound, less the flow along the surface.
        Quantity::Radiation => mean(&|Sound { p, slopes: [x, y, _] }| {
            let along = (x.norm_sqr() + y.norm_sqr()) / (rho * omega).powi(2);
            p.norm_sqr() / (rho * c * c) - rho * along
        }),
        // The flow of energy is a vector, and so is its mean.
        Quantity::Intensity => {
            let flow = |Sound { p, slopes }: Sound| {
                DVec3::from_array(
                    slopes.map(|slope| 0.5 * (p * (Complex64::I * slope / (rho * omega)).conj()).re),
                )
            };
            (drives.iter().copied().map(flow).sum::<DVec3>() / count).length()
        }
        Quantity::Velocity => {
            mean(&|Sound { slopes: [_, _, n], .. }| (n.norm() / (rho * omega) / SQRT_2).powi(2)).sqrt()
        }
        Quantity::Speed => {
            let square = |Sound { slopes, .. }: Sound| {
                slopes.iter().map(|slope| (slope.norm() / (rho * omega)).powi(2)).sum::<f64>() / 2.0
            };
            mean(&square).sqrt()
        }
        Quantity::Depression
        | Quantity::Caustic
        | Quantity::Gorkov
        | Quantity::Force
        | Quantity::Harmonic
        | Quantity::Skin
        | Quantity::Felt => {
            panic!("{quantity:?} does not follow from the sound at a point")
        }
    }
}
