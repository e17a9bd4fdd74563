//! The bodies' answer to the played sound: its error, and the triangles that it took.

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::scatter::BodyError;
use crate::ui::part::{Now, Part};

/// Figures of the bodies in the played sound.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scattering;

/// The answer's figures.
#[derive(Clone, Debug, Default)]
pub struct Scattered {
    /// Of every loaded body, in the order of the scene.
    pub errors: Vec<BodyError>,
    pub triangles: usize,
    /// The reason for a body without sound.
    pub problem: Option<String>,
}

impl Part for Scattering {
    type Input = (Aperture, Drive);
    type Output = Scattered;

    fn input(&self, now: &Now<'_>) -> Option<(Aperture, Drive)> {
        let sound = now.sound.filter(|sound| !sound.aperture.bodies.is_empty())?;
        Some((sound.aperture.clone(), sound.drive().clone()))
    }

    /// The map finds the answer first.
    fn may_begin(&self, now: &Now<'_>) -> bool {
        let is_known = |drive: &[_]| now.sound.is_some_and(|sound| sound.aperture.knows(drive));
        now.rests
            && now.sound.is_some_and(|sound| is_known(&sound.drive().excitation(&sound.aperture.driven)))
    }

    fn computation(&self) -> impl FnOnce(&(Aperture, Drive)) -> Scattered + Send + 'static {
        |(aperture, drive)| Scattered {
            errors: aperture.body_errors(&drive.excitation(&aperture.driven)),
            triangles: aperture.bodies.bodies().map_or(0, |bodies| bodies.triangles()),
            problem: aperture.bodies.check().err().map(|error| error.to_string()),
        }
    }
}
