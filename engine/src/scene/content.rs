//! The content of a scene file, as plain data in SI units.

use std::sync::LazyLock;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::scene::array::Array;
use crate::scene::bead::Bead;
use crate::scene::board::{Board, Reflector};
use crate::scene::body::Body;
use crate::scene::drive::DriveFile;
use crate::scene::liquid::Liquid;
use crate::scene::medium::Medium;
use crate::scene::modulation::Modulation;
use crate::scene::motion::Motion;
use crate::scene::plane::Plane;
use crate::scene::skin::Skin;
use crate::scene::solver::{Aim, Method, Solver};
use crate::scene::target::Target;
use crate::scene::zone::Zone;

/// The format of scene files.
pub const FORMAT: u32 = 1;

/// Full amplitude all the time.
static STEADY: LazyLock<Modulation> = LazyLock::new(Modulation::default);

/// The content of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    pub format: u32,
    /// The drives that are played instead of solved ones, if a file is named.
    #[serde(skip_serializing_if = "DriveFile::is_absent")]
    pub drive: DriveFile,
    pub medium: Medium,
    pub array: Array,
    /// The boards of the array; element numbers continue from board to board. Without boards the array lies in z = 0.
    #[serde(rename = "board", skip_serializing_if = "Vec::is_empty")]
    pub boards: Vec<Board>,
    #[serde(rename = "reflector", skip_serializing_if = "Vec::is_empty")]
    pub reflectors: Vec<Reflector>,
    /// What stands in the sound and scatters it.
    #[serde(rename = "body", skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<Body>,
    #[serde(rename = "target")]
    pub targets: Vec<Target>,
    /// Quiet zones, in addition to the rest of the plane.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub quiet: Vec<Zone>,
    pub solver: Solver,
    pub plane: Plane,
    pub liquid: Liquid,
    #[serde(skip_serializing_if = "Bead::is_default")]
    pub bead: Bead,
    /// The skin on the plane, if the scene is for a hand and says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skin: Option<Skin>,
    pub modulation: Modulation,
    pub motion: Motion,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub listener: Option<Listener>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            format: FORMAT,
            drive: DriveFile::default(),
            medium: Medium::default(),
            array: Array::default(),
            boards: Vec::new(),
            reflectors: Vec::new(),
            bodies: Vec::new(),
            targets: Vec::new(),
            quiet: Vec::new(),
            solver: Solver::default(),
            plane: Plane::default(),
            liquid: Liquid::default(),
            bead: Bead::default(),
            skin: None,
            modulation: Modulation::default(),
            motion: Motion::default(),
            listener: None,
        }
    }
}

impl Scene {
    /// Whether a target is visible.
    #[doc(hidden)]
    pub fn has_foci(&self) -> bool {
        self.targets.iter().any(|target| target.visible)
    }

    /// Whether targets or a file give it a drive.
    #[doc(hidden)]
    pub fn has_drive(&self) -> bool {
        !self.targets.is_empty() || self.drive.is_named()
    }

    /// The modulation that a target follows.
    pub(crate) fn modulation_of<'a>(&'a self, target: &'a Target) -> &'a Modulation {
        target.modulation.as_ref().unwrap_or(&self.modulation)
    }

    /// The modulation of all visible targets; `None` if theirs differ.
    fn shared_modulation(&self) -> Option<&Modulation> {
        let mut own = self.targets.iter().filter(|it| it.visible).map(|target| self.modulation_of(target));
        let first = own.next().unwrap_or(&self.modulation);
        own.all(|other| other.is_like(first)).then_some(first)
    }

    /// The envelope of the whole drive: that of all visible targets, or full amplitude if theirs differ: the frames then
    /// have them.
    #[doc(hidden)]
    pub fn envelope(&self) -> &Modulation {
        self.shared_modulation().unwrap_or(&STEADY)
    }

    /// Whether the envelopes of visible targets differ, so that frames have them.
    #[doc(hidden)]
    pub fn has_own_envelopes(&self) -> bool {
        !self.drive.is_named() && self.shared_modulation().is_none()
    }

    /// The modulations of the scene and of its targets, each with the target's index.
    #[doc(hidden)]
    pub fn modulations(&self) -> impl Iterator<Item = (Option<usize>, &Modulation)> {
        let own = self.targets.iter().enumerate();
        let own = own.filter_map(|(index, target)| Some((Some(index), target.modulation.as_ref()?)));
        std::iter::once((None, &self.modulation)).chain(own)
    }

    /// The same to be changed.
    #[doc(hidden)]
    pub fn modulations_mut(&mut self) -> impl Iterator<Item = (Option<usize>, &mut Modulation)> {
        let own = self.targets.iter_mut().enumerate();
        let own = own.filter_map(|(index, target)| Some((Some(index), target.modulation.as_mut()?)));
        std::iter::once((None, &mut self.modulation)).chain(own)
    }

    /// Lets a method find the drive, instead of a file.
    pub fn solve_by(&mut self, method: Method) {
        (self.solver.method, self.drive) = (method, DriveFile::default());
    }

    /// Whether the targets prescribe a liquid's depression.
    pub fn aims_at_depression(&self) -> bool {
        self.solver.target == Aim::Depression && self.solver.method == Method::Best
    }

    /// Whether the targets prescribe what a hand feels.
    #[doc(hidden)]
    pub fn aims_at_felt(&self) -> bool {
        self.solver.target == Aim::Felt
    }

    /// Whether |p|² or a depression is prescribed over areas.
    pub fn has_areas(&self) -> bool {
        self.aims_at_depression() || self.targets.iter().any(|target| target.visible && target.is_area())
    }

    /// Whether named files are not yet loaded; without them the scene has no foci.
    pub fn is_incomplete(&self) -> bool {
        self.lacks_pixels() || self.array.lacks_elements() || self.array.lacks_directivity()
    }

    /// Whether visible pictures are not yet loaded.
    pub fn lacks_pixels(&self) -> bool {
        self.targets.iter().any(|target| target.visible && target.lacks_pixels())
    }

    /// m, of the carrier.
    pub fn wavelength(&self) -> f64 {
        self.medium.speed_of_sound() / self.array.frequency
    }
}

/// The position of an ear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listener {
    /// m
    pub at: DVec3,
}
