//! Levitation of beads in a scene's traps, as figures and text.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::force::{Hold, Levitation, Outcome, Sphere};
use crate::rounding;
use crate::scene::{Scene, Target};

/// A trap of a scene, and the behaviour of a bead released there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Among the scene's targets.
    pub target: usize,
    pub hold: Hold,
}

/// For all visible traps, at their position in the scene.
pub fn held(scene: &Scene, aperture: &Aperture, drives: &[Drive]) -> Vec<Held> {
    let trap = |(target, it): (usize, &Target)| {
        (it.visible && it.shape.is_trap()).then(|| (target, it.shape.centre()))
    };
    let traps: Vec<_> = scene.targets.iter().enumerate().filter_map(trap).collect();
    if traps.is_empty() {
        return Vec::new();
    }
    let levitation = Levitation::new(scene, aperture, drives);
    traps.into_iter().map(|(target, at)| Held { target, hold: levitation.hold(at) }).collect()
}

/// The largest force between beads at rest in a scene's traps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// The target whose bead it acts on.
    pub target: usize,
    /// N
    pub force: DVec3,
    /// Its part of the weight less buoyancy.
    pub part: f64,
}

/// A tenth of the weight: forces between beads from there on are reported.
const FELT: f64 = 0.1;

/// The largest force between the beads that are held, if it counts.
pub fn neighbour(scene: &Scene, aperture: &Aperture, drives: &[Drive], held: &[Held]) -> Option<Neighbour> {
    let held: Vec<_> = held.iter().filter(|held| held.hold.holds()).collect();
    if held.len() < 2 {
        return None;
    }
    let levitation = Levitation::new(scene, aperture, drives);
    let places: Vec<_> = held.iter().map(|held| held.hold.rest).collect();
    let forces = held.iter().zip(levitation.between(&places)?);
    let of = |(held, force): (&&Held, DVec3)| Neighbour {
        target: held.target,
        force,
        part: force.length() / levitation.load.abs(),
    };
    let largest = forces.map(of).max_by(|a, b| a.part.total_cmp(&b.part));
    largest.filter(|neighbour| neighbour.part > FELT)
}

/// The force between beads, a sentence without its full stop.
pub fn between(neighbour: &Neighbour) -> String {
    format!(
        "the others' scattering pushes the bead of target {} by {} of its weight along {}",
        neighbour.target + 1,
        rounding::percent(neighbour.part),
        axis(neighbour.force.normalize_or_zero())
    )
}

/// The warning about forces on the scene's bead.
pub fn warning(scene: &Scene) -> Option<String> {
    let air = Air::new(&scene.medium, scene.array.frequency);
    Sphere::new(&scene.bead, &air, TAU / scene.wavelength()).warning()
}

/// The verdict, a sentence without its full stop.
pub fn verdict(hold: &Hold) -> String {
    let weakest = hold.modes[0];
    match hold.outcome {
        Outcome::Holds => {
            let (way, escape) = hold.nearest_escape();
            let out = match escape.distance.is_finite() {
                true => {
                    format!("escapes {} mm along {}", rounding::millimetres(escape.distance, 2), axis(way))
                }
                false => "no escape within a wavelength".to_owned(),
            };
            format!(
                "stable trap: sag {} mm, weakest stiffness {} ({}), {out}, lifts {:.1} x its weight",
                rounding::millimetres(hold.sag(), 2),
                stiffness(weakest.stiffness),
                line(weakest.direction),
                hold.lift
            )
        }
        Outcome::TooHeavy => {
            format!(
                "no trap: too heavy, the sound lifts {} of its weight",
                rounding::percent(hold.lift.max(0.0))
            )
        }
        Outcome::Unstable => {
            format!("no trap: unstable along {} ({})", line(weakest.direction), stiffness(weakest.stiffness))
        }
        Outcome::Leaves => "no trap: force and weight have no balance within a wavelength".to_owned(),
    }
}

/// A stiffness with three figures, in mN/m or µN/m.
fn stiffness(value: f64) -> String {
    let (factor, unit) = if value.abs() >= 1e-4 { (1e3, "mN/m") } else { (1e6, "µN/m") };
    format!("{:.3} {unit}", value * factor)
}

/// A direction as an axis name or as components.
fn axis(direction: DVec3) -> String {
    let parts = direction.to_array();
    let main = (0..3).find(|&i| parts[i].abs() > 0.99);
    match main {
        Some(i) if parts[i] < 0.0 => ["-x", "-y", "-z"][i].to_owned(),
        Some(i) => ["x", "y", "z"][i].to_owned(),
        None => format!("({:.2}, {:.2}, {:.2})", parts[0], parts[1], parts[2]),
    }
}

/// The same for an undirected line.
fn line(direction: DVec3) -> String {
    let largest = [0, 1, 2].map(|i| direction[i]).into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()));
    axis(direction * largest.unwrap_or(1.0).signum())
}
