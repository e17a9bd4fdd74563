//! Levitation of the scene's bead at a point.

pub mod panel;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::force::{self, Forces, Hold};
use crate::scene::Scene;
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// Points on each of the three curves.
const PLACES: usize = 81;

/// Display of the force on the scene's bead, and its position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Levitation {
    pub is_shown: bool,
    pub place: Place,
    /// Where the bead is to be released (m), if typed.
    pub typed: Option<DVec3>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// The selected target, or else the first trap or focus.
    #[default]
    Target,
    Pointer,
}

/// The drives, the bead and its position.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    scene: Scene,
    aperture: Aperture,
    drives: Vec<Drive>,
    /// m
    at: DVec3,
}

/// Levitation of the scene's bead at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Levitated {
    /// m
    pub at: DVec3,
    pub hold: Hold,
    /// Where it is put.
    pub forces: Forces,
    /// N, weight less buoyancy.
    pub load: f64,
    /// m from there along x, y and z, and the force (N) along the same axis.
    pub curves: [Vec<[f64; 2]>; 3],
    /// A warning about the bead.
    pub warning: Option<String>,
}

impl Part for Levitation {
    type Input = Input;
    type Output = Levitated;

    fn input(&self, now: &Now<'_>) -> Option<Input> {
        let sound = now.sound.filter(|_| self.is_shown && now.panel == Some(Panel::Scene))?;
        let at = match self.place {
            Place::Target if now.has_selection => now.focus,
            Place::Target => trap(now.scene).or(now.focus),
            Place::Pointer => now.pointer,
        };
        let is_in_front = |at: &DVec3| !now.scene.is_home() || at.z > 0.0;
        Some(Input {
            scene: now.scene.clone(),
            aperture: sound.aperture.clone(),
            drives: sound.heard.clone(),
            at: at.filter(is_in_front)?,
        })
    }

    fn computation(&self) -> impl FnOnce(&Input) -> Levitated + Send + 'static {
        |Input { scene, aperture, drives, at }| {
            let levitation = force::Levitation::new(scene, aperture, drives);
            Levitated {
                at: *at,
                hold: levitation.hold(*at),
                forces: levitation.forces(*at),
                load: levitation.load,
                curves: levitation.curves(*at, levitation.wavelength, PLACES),
                warning: levitation.sphere.warning(),
            }
        }
    }
}

/// Position of the first played trap; beads do not sit at its lobes.
fn trap(scene: &Scene) -> Option<DVec3> {
    let mut targets = scene.targets.iter().filter(|target| target.visible);
    targets.find(|target| target.shape.is_trap()).map(|target| target.shape.centre())
}
