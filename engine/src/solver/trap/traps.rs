//! The traps of a scene, and their figures.

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::{Air, Aperture};
use crate::force::{Sphere, modes};
use crate::scene::{Focus, Part, Scene, Trap, motion};

/// The traps of a scene, and the bead.
#[derive(Clone, Debug)]
pub struct Traps {
    pub sphere: Sphere,
    /// N, towards -z.
    pub load: f64,
    pub kinds: Kinds,
    pub traps: Vec<Wanted>,
}

/// The meaning of the kinds that the scene names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kinds {
    /// A first start of the search for the stiffest traps.
    First,
    /// The traps that are played, in balance of force and weight: the stiffest would not turn with their targets.
    Balanced,
    /// The same without balance, which would undo a shift of phases.
    Signature,
}

/// One of them.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub trap: Trap,
    pub charge: i32,
    /// Phase (rad) added to its signature.
    pub phase: f64,
    pub at: DVec3,
    /// Rotation from the trap's axes to the scene's.
    pub turn: glam::DQuat,
    /// Its lobes among the foci.
    pub foci: std::ops::Range<usize>,
}

impl Traps {
    /// The traps whose lobes are foci; `None` without traps.
    pub fn of_scene(scene: &Scene, aperture: &Aperture, foci: &[Focus]) -> Option<Self> {
        let air = Air::new(&scene.medium, scene.array.frequency);
        let mut traps: Vec<Wanted> = Vec::new();
        let mut start = 0;
        let mut kinds = Kinds::First;
        while start < foci.len() {
            let Part::Trap(index) = foci[start].part else {
                start += 1;
                continue;
            };
            let target = &scene.targets[index];
            let Some((trap, charge)) = target.shape.trap() else {
                start += 1;
                continue;
            };
            let lobes = trap.lobes(charge, aperture.wavelength());
            let range = start..(start + lobes.len()).min(foci.len());
            let turn = target.turn();
            // Motions move the lobes; the trap moves with them.
            let places = range.clone().zip(&lobes).map(|(i, lobe)| foci[i].position - turn * lobe.at);
            let at = places.sum::<DVec3>() / range.len() as f64;
            start = range.end;
            let phase = target.phase;
            traps.push(Wanted { trap, charge, phase, at, turn, foci: range });
            let motion = motion::governing(scene, target);
            kinds = kinds.max(match (motion.shifts(), motion.turns()) {
                (true, _) => Kinds::Signature,
                (false, true) => Kinds::Balanced,
                (false, false) => Kinds::First,
            });
        }
        let sphere = Sphere::new(&scene.bead, &air, aperture.element.wavenumber);
        (!traps.is_empty()).then(|| Self { sphere, load: sphere.load(scene.liquid.gravity), kinds, traps })
    }

    /// The weakest stiffness (N/m) of each trap under a drive.
    pub fn weakest(&self, aperture: &Aperture, excitation: &[Complex64]) -> Vec<f64> {
        let of = |trap: &Wanted| {
            let shell = (trap.at, self.sphere.shell());
            let (waves, slopes) = aperture.waves_with_slopes(self.sphere.order(), shell, excitation);
            let stiffness = self.sphere.stiffness_by(&waves, &slopes);
            modes(&((stiffness + stiffness.transpose()) * 0.5))[0].stiffness
        };
        self.traps.iter().map(of).collect()
    }
}
