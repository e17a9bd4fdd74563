//! Forces of sound on a bead: potential, radiation force, stiffness, and stability of traps.
//!
//! ```
//! use glam::dvec3;
//! use sonoglyph::acoustics::Aperture;
//! use sonoglyph::force::Levitation;
//! use sonoglyph::scene::{Scene, Shape, Target, Trap};
//!
//! let at = dvec3(0.0, 0.0, 0.1);
//! let trap = Target::new(Shape::Trap { at, trap: Trap::Twin, charge: 1 });
//! let scene = Scene { targets: vec![trap], ..Scene::default() };
//! let solution = sonoglyph::solver::solve(&scene)?;
//! let bead = Levitation::new(&scene, &Aperture::new(&scene), &solution.drives());
//! // N/m: whichever way the bead is pushed, it is pushed back.
//! let stiffness = bead.forces(at).symmetric();
//! assert!((0..3).all(|axis| stiffness.col(axis)[axis] > 0.0));
//! # Ok::<(), sonoglyph::solver::SolveError>(())
//! ```

mod bead;
mod flight;
mod hold;
mod modes;
mod pair;
mod rigid;

use std::sync::Arc;

use glam::{DMat3, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::{Air, Aperture, PartialWaves};
use crate::drive::Drive;
use crate::scene::{Bead, Scene};

pub use bead::Sphere;
pub use flight::{Carriage, Drag, Flight, Moment};
pub use hold::{Escape, Hold, Outcome, WAYS};
pub use modes::{Mode, modes};
#[doc(hidden)]
pub use rigid::Push;

/// Order of the points on a bead's surface that touch bodies.
const SURFACE: usize = 4;

/// The radiation force on a bead at a point, with potential and stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forces {
    /// J, the potential of the force that has one.
    pub gorkov: f64,
    /// N, of the sound alone.
    pub force: DVec3,
    /// N/m: -∂Fᵢ/∂xⱼ in row i and column j.
    pub stiffness: DMat3,
}

impl Forces {
    /// The symmetric part of the stiffness, which alone does work; the scattering part drives the bead around the
    /// trap.
    pub fn symmetric(&self) -> DMat3 {
        (self.stiffness + self.stiffness.transpose()) * 0.5
    }
}

/// A bead in the sound of drives in turn, and under its weight.
#[derive(Clone, Debug)]
pub struct Levitation {
    pub sphere: Sphere,
    aperture: Arc<Aperture>,
    /// A value per driven element.
    drives: Vec<Vec<Complex64>>,
    /// N, weight less buoyancy, towards -z.
    pub load: f64,
    /// m
    pub wavelength: f64,
}

impl Levitation {
    /// The scene's bead; it responds to the mean of the fast-changing drives.
    pub fn new(scene: &Scene, aperture: &Aperture, drives: &[Drive]) -> Self {
        let air = Air::new(&scene.medium, scene.array.frequency);
        Self::in_air(aperture, (&air, &scene.bead), drives, scene.liquid.gravity)
    }

    /// Any bead in any air, under this gravity (m/s²).
    pub fn in_air(aperture: &Aperture, (air, bead): (&Air, &Bead), drives: &[Drive], gravity: f64) -> Self {
        let sphere = Sphere::new(bead, air, aperture.element.wavenumber);
        Self {
            load: sphere.load(gravity),
            sphere,
            wavelength: aperture.wavelength(),
            aperture: Arc::new(aperture.clone()),
            drives: Vec::new(),
        }
        .playing(drives)
    }

    /// The same bead in the sound of other drives.
    pub fn playing(&self, drives: &[Drive]) -> Self {
        let drives: Vec<_> = drives.iter().map(|drive| drive.excitation(&self.aperture.driven)).collect();
        // Bodies answer once, before many places ask at the same time: a thread that waits for the surface of a body
        // could otherwise take up a place that waits for it, too.
        drives.iter().for_each(|drive| drop(self.aperture.answer(drive)));
        Self { drives, ..self.clone() }
    }

    /// Whether the bead would touch or overlap a body at a point (m): no force is a number there.
    pub(crate) fn touches(&self, point: DVec3) -> bool {
        let bodies = &self.aperture.bodies;
        !bodies.is_empty()
            && PartialWaves::points(SURFACE, (point, self.sphere.radius))
                .iter()
                .any(|at| bodies.contains(*at))
    }

    /// Potential, force and stiffness at a point, m.
    pub fn forces(&self, point: DVec3) -> Forces {
        if self.touches(point) {
            return Forces { gorkov: f64::NAN, force: DVec3::NAN, stiffness: DMat3::NAN };
        }
        let mut mean = Forces { gorkov: 0.0, force: DVec3::ZERO, stiffness: DMat3::ZERO };
        let shell = (point, self.sphere.shell());
        for drive in &self.drives {
            let (waves, slopes) = self.aperture.waves_with_slopes(self.sphere.order(), shell, drive);
            let part = 1.0 / self.drives.len() as f64;
            mean.gorkov += part * self.sphere.potential(&waves);
            mean.force += part * self.sphere.force(&waves);
            mean.stiffness += part * self.sphere.stiffness_by(&waves, &slopes);
        }
        mean
    }

    /// Radiation force (N) without weight, faster than `at`.
    pub fn force(&self, point: DVec3) -> DVec3 {
        if self.touches(point) {
            return DVec3::NAN;
        }
        let waves = self.waves(self.sphere.order(), point);
        waves.map(|waves| self.sphere.force(&waves)).sum::<DVec3>() / self.drives.len() as f64
    }

    /// The potential (J) of the force that has one.
    pub fn potential(&self, point: DVec3) -> f64 {
        if self.touches(point) {
            return f64::NAN;
        }
        let waves = self.waves(self.sphere.order(), point);
        waves.map(|waves| self.sphere.potential(&waves)).sum::<f64>() / self.drives.len() as f64
    }

    /// N, of sound and weight.
    pub fn net(&self, point: DVec3) -> DVec3 {
        self.force(point) - DVec3::Z * self.load
    }

    /// Radiation forces (N) at many points, for arrows on a plane. On all cores.
    pub fn forces_at(&self, points: &[DVec3]) -> Vec<DVec3> {
        points.par_iter().map(|&point| self.force(point)).collect()
    }

    /// The force of the sound (N) along x, y and z through a point, each at `count` points from -`reach` to `reach`
    /// (m): the component along the axis.
    pub fn curves(&self, at: DVec3, reach: f64, count: usize) -> [Vec<[f64; 2]>; 3] {
        let step = 2.0 * reach / count.saturating_sub(1).max(1) as f64;
        [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
            let along = |i: usize| {
                let place = step * i as f64 - reach;
                [place, self.force(at + axis * place).dot(axis)]
            };
            (0..count).into_par_iter().map(along).collect()
        })
    }

    /// The partial waves of each drive up to an order, about a point.
    fn waves(&self, order: usize, point: DVec3) -> impl Iterator<Item = PartialWaves> {
        (0..self.drives.len()).map(move |drive| self.waves_of(drive, order, point))
    }

    fn waves_of(&self, drive: usize, order: usize, point: DVec3) -> PartialWaves {
        let pressures = |points: &[DVec3]| self.aperture.pressures(points, &self.drives[drive]);
        PartialWaves::new(order, self.wavenumber(), (point, self.sphere.shell()), pressures)
    }

    /// rad/m
    fn wavenumber(&self) -> f64 {
        self.aperture.element.wavenumber
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Array, Board};

    /// A bead between two facing boards that sound in phase, and the lower of the two nodes beside the middle, where
    /// it floats.
    pub(super) fn standing_wave() -> (Levitation, DVec3) {
        let (aperture, scene) = boards();
        let middle = DVec3::Z * 0.04;
        let lift = aperture.wavelength() / 4.0;
        (Levitation::new(&scene, &aperture, &[towards(&aperture, middle)]), middle - DVec3::Z * lift)
    }

    fn boards() -> (Aperture, Scene) {
        let array = Array { rows: 4, columns: 4, strength: 10.0, ..Array::default() };
        let above = Board { at: DVec3::Z * 0.08, normal: DVec3::NEG_Z, ..Board::default() };
        let scene = Scene { array, boards: vec![Board::default(), above], ..Scene::default() };
        (Aperture::new(&scene), scene)
    }

    fn towards(aperture: &Aperture, focus: DVec3) -> Drive {
        let phases = aperture.positions.iter().map(|at| aperture.element.wavenumber * at.distance(focus));
        Drive { amplitudes: vec![1.0; aperture.positions.len()], phases: phases.collect() }
    }

    #[test]
    fn the_force_of_drives_in_turn_is_the_mean_of_theirs() {
        let (aperture, scene) = boards();
        let drives = [0.03, 0.04, 0.045].map(|z| towards(&aperture, DVec3::Z * z));
        let both = Levitation::new(&scene, &aperture, &drives);
        let alone = drives.map(|drive| Levitation::new(&scene, &aperture, &[drive]));
        let points = [DVec3::new(0.001, 0.002, 0.041), DVec3::new(-0.003, 0.0, 0.035)];
        let forces = both.forces_at(&points);
        assert_eq!(forces.len(), points.len());
        for (point, force) in points.into_iter().zip(forces) {
            let expected = alone.iter().map(|alone| alone.force(point)).sum::<DVec3>() / 3.0;
            assert!(force.distance(expected) < 1e-12 * expected.length(), "{force}, not {expected}");
            let all = both.forces(point).force;
            assert!(force.distance(all) < 1e-9 * expected.length(), "{force}, not {all}");
        }
    }
}
