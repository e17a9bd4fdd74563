//! A solution as the object that other programs read.

use num_complex::Complex64;
use serde_json::{Value, json};

use crate::drive::Drive;
use crate::scene::Focus;
use crate::solver::{Limits, Solution};

/// Foci, quality, phases and amplitudes; what follows from the limits of foci and array where these are known.
pub fn solution(solution: &Solution, limits: Option<&Limits>) -> Value {
    let quality = &solution.quality;
    let focus = |(focus, pressure): (&Focus, &Complex64)| {
        json!({
            "position": focus.position.to_array(),
            "target": focus.target,
            "pressure": pressure.norm(),
            "phase": pressure.arg(),
        })
    };
    let foci: Vec<_> = solution.foci.iter().zip(&solution.pressures).map(focus).collect();
    let mut value = json!({
        "method": solution.method.name(),
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

/// Adds the figures of a shape.
fn shape(quality: &mut Value, solution: &Solution) {
    quality["evenness"] = json!(solution.quality.evenness);
    if let Some(figures) = &solution.figures {
        quality["evenness"] = json!(figures.evenness);
        quality["side_lobe"] = json!(figures.side_lobe);
        quality["side_lobe_position"] = json!(figures.side_lobe_position.to_array());
        quality["strength"] = json!(figures.strength);
        if let Some(areas) = figures.areas {
            quality["contrast"] = json!(areas.contrast);
            quality["error"] = json!(areas.error);
        }
    }
}
