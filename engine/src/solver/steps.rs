//! Phase changes between the frames of a motion.

use serde::{Deserialize, Serialize};

use std::f64::consts::TAU;

/// Phase changes between successive frames, including from the last to the first; rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseSteps {
    /// Of any driven element.
    pub largest: f64,
    /// The frame, counted from 0, that it leads to.
    pub to: usize,
    /// The root mean square over all driven elements and frames.
    pub rms: f64,
}

/// The changes of the phases (rad) of every frame; `frames` is the number of played frames, including repeated ones.
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
