//! Phase changes between the frames of a motion.

use serde::{Deserialize, Serialize};

use std::f64::consts::TAU;

/// Phase changes between successive frames, including from the last to the first; rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseSteps {
    /// Largest change of any driven element.
    pub largest: f64,
    /// The frame after it, counted from 0.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_go_the_short_way_of_driven_elements_and_from_the_last_frame_to_the_first() {
        // The element in the middle is off. One frame is played twice.
        let frames = [[0.1, 9.0, 0.5], [6.2, 1.0, 0.8], [0.3, 0.0, 0.6]];
        let frames: Vec<_> = frames.iter().map(|phases| &phases[..]).collect();
        let steps = phase_steps(&frames, &[0, 2], 4);
        let expected = [0.2, 0.1, TAU - 6.1, 0.3, TAU - 5.9, 0.2];
        let squares: f64 = expected.iter().map(|step: &f64| step * step).sum();
        assert!((steps.largest - (TAU - 5.9)).abs() < 1e-12 && steps.to == 2, "{steps:?}");
        assert!((steps.rms - (squares / 8.0).sqrt()).abs() < 1e-12, "{steps:?}");
    }
}
