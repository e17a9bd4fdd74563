//! Warnings about a solution.

use serde::{Deserialize, Serialize};

use crate::acoustics::Aperture;
use crate::echo;
use crate::scene::{Focus, Part, Scene};

/// A warning; as text, a sentence without its full stop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum Warning {
    #[error("{0} pairs of foci coincide: they get the same pressure")]
    Coincident(usize),
    /// Distance of the closest pair and the array's resolution there, m.
    #[error(
        "{pairs} pairs of foci are closer than the array resolves: the closest are {:.2} mm apart, and λ/(2 NA) is \
         {:.2} mm there; they blur into one, and inverse methods waste power on them",
        .distance * 1e3,
        .resolution * 1e3
    )]
    Unresolved { pairs: usize, distance: f64, resolution: f64 },
    #[error(
        "{foci} foci are more than the {elements} driven elements can set: the pressures are a compromise"
    )]
    MoreFociThanElements { foci: usize, elements: usize },
    /// Mean over the foci, Pa (peak).
    #[error(
        "the foci need {asked:.1} Pa (mean, peak), but full drive reaches {brought:.1} Pa, {:.1} % of it: full drive is played",
        100.0 * .brought / .asked
    )]
    TooLoud { asked: f64, brought: f64 },
    /// Peak side lobe over the mean along the strokes.
    #[error(
        "side lobes are {0:.1} times as strong as the strokes: the drawing is too large for this array or out of its reach"
    )]
    OutOfReach(f64),
    /// Separate foci, at most as many as elements.
    #[error(
        "the {foci} foci have only {rank} independent directions (condition {condition:.1e}): the rest is a compromise"
    )]
    Dependent { foci: usize, rank: usize, condition: f64 },
    /// Elements that the file of a drive leaves out.
    #[error("the drive of `{name}` has no row for {elements} of {of} elements: they stay silent")]
    LeftOut { name: String, elements: usize, of: usize },
}

/// The warning about the file of a scene's drive.
pub fn of_drive(scene: &Scene) -> Option<Warning> {
    let elements = scene.drive.table().map_or(0, |table| table.left_out);
    let name = || echo::value(&scene.drive.name).to_string();
    (elements > 0).then(|| Warning::LeftOut { name: name(), elements, of: scene.elements() })
}

/// Warnings about foci in front of an array. Samples of continuous strokes may be arbitrarily close.
pub fn of_foci(aperture: &Aperture, foci: &[Focus]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let resolution_at = aperture.resolution();
    let (mut coincident, mut close, mut closest) = (0, 0, (f64::INFINITY, 0.0));
    // Lobes of a trap may be arbitrarily close.
    let is_counted = |focus: &&Focus| matches!(focus.part, Part::Point | Part::Direction);
    let separate: Vec<_> = foci.iter().filter(is_counted).collect();
    for (i, focus) in separate.iter().enumerate() {
        // Unit vectors of directions are as far apart as points that are resolved at 1 m.
        for other in separate[..i].iter().filter(|other| other.part == focus.part) {
            let distance = focus.position.distance(other.position);
            let resolution = resolution_at((focus.position + other.position) / 2.0);
            coincident += usize::from(distance < 1e-9);
            close += usize::from(distance < resolution);
            if distance < closest.0 {
                closest = (distance, resolution);
            }
        }
    }
    if coincident > 0 {
        warnings.push(Warning::Coincident(coincident));
    }
    if close > coincident {
        let (distance, resolution) = closest;
        warnings.push(Warning::Unresolved { pairs: close - coincident, distance, resolution });
    }
    let (foci, elements) = (separate.len(), aperture.driven.len());
    if foci > elements {
        warnings.push(Warning::MoreFociThanElements { foci, elements });
    }
    warnings
}
