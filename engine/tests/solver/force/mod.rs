//! Beads in sound: potential, force and stiffness against closed forms and an independent model, and trapping.

mod flight;
mod forms;
mod table;
mod traps;
mod truth;

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::scene::Scene;

/// The air of the table in the research notes: 343.21 m/s, 1.2041 kg/m³, without absorption.
fn still_air() -> Scene {
    let mut scene = Scene::default();
    scene.medium.sound_speed = Some(343.21);
    scene.medium.density = Some(1.2041);
    scene.medium.absorption = Some(0.0);
    scene
}

/// Phases that focus on a point, plus a `signature` (rad) by element position.
fn focused(aperture: &Aperture, at: DVec3, signature: impl Fn(DVec3) -> f64) -> Drive {
    let k = aperture.element.wavenumber;
    let phase = |place: &DVec3| {
        let phase = k * place.distance(at) + signature(*place);
        (phase + PI).rem_euclid(TAU) - PI
    };
    let phases: Vec<_> = aperture.positions.iter().map(phase).collect();
    Drive { amplitudes: vec![1.0; phases.len()], phases }
}
