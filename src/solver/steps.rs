//! Phase changes between the frames of a motion.

use serde::{Deserialize, Serialize};

use std::f64::consts::TAU;

/// How far phases go from one frame to the next, from the last to the first included; rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseSteps {
    /// Of any driven element.
    pub largest: f64,
    /// The frame, counted from 0, that it leads to.
    pub to: usize,
    /// The root mean square over all driven elements and frames.
    pub rms: f64,
}

/// Of the phases (rad) of every frame; `frames` is how many are played, those that stand still included.
pub fn phase_steps(phases: &[&[f64]], driven: &[usize], frames: usize) -> PhaseSteps {
    let mut steps = PhaseSteps::default();
    let mut squares = 0.0;
    for to in 0..phases.len() {
        let before = phases[(to + phases.len() - 1) % phases.len()];
        for &n in driven {
            let apart = (phases[to][n] - before[n]).abs();
            let step = apart.min(TAU - apart);
            squares += step * step;
            if step > steps.largest {
                (steps.largest, steps.to) = (step, to);
            }
        }
    }
    steps.rms = (squares / (driven.len() * frames) as f64).sqrt();
    steps
}
