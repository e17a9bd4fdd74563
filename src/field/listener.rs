//! What a drive sounds like where somebody listens.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::drive::Drive;

/// Pa, RMS: 0 dB.
const REFERENCE: f64 = 20e-6;
/// dB: what consensus allows an ear between 25 and 50 kHz for less than 4 hours (Howard, Hansen and Zander, 2004).
pub const LIMIT: f64 = 110.0;

/// Sound at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard {
    /// m
    pub position: DVec3,
    /// Pa
    pub rms: f64,
    /// Sound pressure level, dB re 20 µPa.
    pub spl: f64,
}

impl Heard {
    /// What the drive, unmodulated, makes at a point in front of the array; in f64.
    pub fn new(aperture: &Aperture, drive: &Drive, position: DVec3) -> Self {
        let pressure = aperture.transfer(&[position]).pressure(&drive.excitation(&aperture.driven))[0];
        let rms = pressure.norm() * FRAC_1_SQRT_2;
        Self { position, rms, spl: 20.0 * (rms.max(f64::MIN_POSITIVE) / REFERENCE).log10() }
    }

    /// What who listens there should know, in words.
    pub fn warning(&self) -> Option<String> {
        (self.spl > LIMIT).then(|| {
            format!(
                "it is louder than {LIMIT:.0} dB at the listener, the most that an ear may be exposed to between 25 and 50 kHz \
                 for less than 4 hours: go further away, shield it, or drive less"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ElementModel, Scene};

    #[test]
    fn one_element_is_as_loud_as_its_strength_says() {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns, scene.array.element) = (1, 1, ElementModel::Point);
        scene.medium.absorption = Some(0.0);
        let aperture = Aperture::new(&scene);
        let drive = |amplitude: f64| Drive { amplitudes: vec![amplitude], phases: vec![1.0] };
        let heard = |amplitude: f64, z: f64| Heard::new(&aperture, &drive(amplitude), DVec3::Z * z);
        // 3.4 Pa·m at half a metre is 6.8 Pa peak and 4.81 Pa RMS.
        let near = heard(1.0, 0.5);
        assert!((near.rms - 6.8 / 2f64.sqrt()).abs() < 1e-9 && (near.spl - 107.62).abs() < 0.01, "{near:?}");
        assert!((near.spl - heard(1.0, 5.0).spl - 20.0).abs() < 1e-9, "ten times as far is 20 dB less");
        assert!((near.spl - heard(0.1, 0.5).spl - 20.0).abs() < 1e-9, "a tenth of the drive is too");
        assert_eq!(near.warning(), None);
        let loud = heard(1.0, 0.3);
        assert!(loud.warning().is_some_and(|text| text.contains("110 dB")), "{loud:?}");
        assert!(heard(0.0, 0.5).spl.is_finite(), "silence is a number too");
    }
}
