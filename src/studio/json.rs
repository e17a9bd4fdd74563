//! A solution as JSON for other programs.

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::force::{Escape, Hold, Mode, Outcome, WAYS};
use crate::scene::Focus;
use crate::solver::{Limits, Solution};
use crate::studio::levitation::{self, Held};
use crate::studio::nonlinear::Nonlinear;
use crate::studio::width;

/// Limit of separate foci with widths; each takes about as long as a hundred superpositions at a point.
const MOST_WIDTHS: usize = 16;

/// Foci, quality, phases and amplitudes; with figures relative to the limits of foci and array, if known.
pub fn solution(solution: &Solution, limits: Option<&Limits>) -> Value {
    let quality = &solution.quality;
    let focus = |(focus, pressure): (&Focus, &Complex64)| {
        let place = if focus.is_direction() { "direction" } else { "position" };
        json!({
            place: focus.position.to_array(),
            "target": focus.target,
            "pressure": pressure.norm(),
            "phase": pressure.arg(),
        })
    };
    let foci: Vec<_> = solution.foci.iter().zip(&solution.pressures).map(focus).collect();
    let mut value = json!({
        "method": solution.method_name(),
        "elements": solution.drive.phases.len(),
        "foci": foci,
        "quality": {
            "mean_pressure": quality.mean_pressure,
            "min_pressure": quality.min_pressure,
            "spread": quality.spread,
            "efficiency": quality.efficiency,
            "relative_to_single": quality.relative_to_single,
            "residual": quality.residual,
        },
        "seconds": solution.seconds,
        "iterations": solution.iterations,
        "phases": solution.drive.phases,
        "amplitudes": solution.drive.amplitudes,
    });
    shape(&mut value["quality"], solution);
    if !solution.others.is_empty() {
        let drive = |drive: &Drive| json!({ "phases": drive.phases, "amplitudes": drive.amplitudes });
        value["frames"] = solution.drives().iter().map(drive).collect();
    }
    if let Some(limits) = limits {
        let quality = &mut value["quality"];
        quality["bound"] = json!(limits.bound);
        quality["certified"] = json!(solution.certified(limits.bound));
        quality["rank"] = json!(limits.rank);
        quality["condition"] = json!(limits.condition);
    }
    value
}

/// Figures beyond linear theory.
pub fn nonlinear(nonlinear: &Nonlinear) -> Value {
    let Nonlinear { position, harmonic, linear_drive, streaming, audible } = nonlinear;
    let mut value = json!({
        "position": position.to_array(),
        "harmonic": harmonic,
        "linear_drive": linear_drive,
        "streaming": streaming,
    });
    if let Some(audible) = audible {
        value["audible"] = json!({
            "spl": audible.level(),
            "spl_a": audible.weighted_level(),
            "frequency": audible.frequency,
        });
    }
    value
}

/// Adds the -6 dB `widths` of the first separate foci to the quality of a solution, with their indices among the
/// foci: m, and m² for their area, null if |p| does not fall to half.
pub fn add_widths(value: &mut Value, aperture: &Aperture, solution: &Solution) {
    let drives = solution.drives();
    let separate = solution.foci.iter().enumerate().filter(|(_, focus)| focus.is_placed());
    let first: Vec<_> = separate.take(MOST_WIDTHS).collect();
    let widths = |&(index, focus): &(usize, &Focus)| {
        let widths = width::widths(aperture, &drives, focus.position);
        json!({
            "focus": index,
            "lateral_x": widths.lateral_x,
            "lateral_y": widths.lateral_y,
            "axial": widths.axial,
            "area": widths.area,
        })
    };
    value["quality"]["widths"] = first.par_iter().map(widths).collect::<Vec<_>>().into();
}

/// The behaviour of a bead in a trap: lengths in m, stiffnesses in N/m, forces in N; null for distances beyond a
/// wavelength.
pub fn trap(held: &Held) -> Value {
    let Hold { at, rest, modes, lift, escapes, outcome } = &held.hold;
    let way = |(way, escape): (&DVec3, &Escape)| {
        json!({
            "direction": way.to_array(),
            "distance": escape.distance.is_finite().then_some(escape.distance),
            "force": escape.force,
        })
    };
    let mode = |mode: &Mode| json!({ "stiffness": mode.stiffness, "direction": mode.direction.to_array() });
    json!({
        "target": held.target,
        "position": at.to_array(),
        "holds": *outcome == Outcome::Holds,
        "verdict": levitation::verdict(&held.hold),
        "rest": rest.to_array(),
        "stiffness": modes.iter().map(mode).collect::<Vec<_>>(),
        "lift": lift,
        "escape": WAYS.iter().zip(escapes).map(way).collect::<Vec<_>>(),
    })
}

/// Adds the figures of a shape.
fn shape(quality: &mut Value, solution: &Solution) {
    quality["evenness"] = json!(solution.quality.evenness);
    if let Some(figures) = &solution.figures {
        quality["evenness"] = json!(figures.evenness);
        let lobe = (figures.side_lobe, figures.side_lobe_position);
        set_side_lobe(quality, (lobe.0 > 0.0).then_some(lobe));
        quality["strength"] = json!(figures.strength);
        if let Some(areas) = figures.areas {
            quality["contrast"] = json!(areas.contrast);
            quality["error"] = json!(areas.error);
        }
    }
}

/// Writes the side lobe, relative to the mean at the foci, with its position (m), or nulls; also by the name that
/// programs have read it by.
pub fn set_side_lobe(quality: &mut Value, lobe: Option<(f64, DVec3)>) {
    for [name, position] in [["side_lobe", "side_lobe_position"], ["ghost", "ghost_position"]] {
        quality[name] = json!(lobe.map(|(part, _)| part));
        quality[position] = json!(lobe.map(|(_, at)| at.to_array()));
    }
}
