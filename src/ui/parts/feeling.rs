//! The levels at which a hand feels the scene as it is played.

use std::sync::{Arc, Mutex, PoisonError};

use crate::field::{Evaluator, Stages};
use crate::scene::{Motion, Scene, Target, motion};
use crate::studio::felt::{self, Felt};
use crate::studio::performance::Performance;
use crate::ui::board::Plays;
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// The scene as a board plays it that was sent no motion.
pub fn at_rest(scene: &Scene) -> Scene {
    let at_rest = |target: &Target| Target { motion: None, modulation: None, ..target.clone() };
    let (targets, modulation) = (scene.targets.iter().map(at_rest).collect(), scene.envelope().clone());
    Scene { targets, modulation, motion: Motion::default(), ..scene.clone() }
}

/// The figures of the Felt page, and of what a board is to play.
#[derive(Debug)]
pub struct Feeling {
    /// Stages with cached results.
    stages: Arc<Mutex<Stages>>,
}

impl Default for Feeling {
    fn default() -> Self {
        Self { stages: Arc::new(Mutex::new(Stages::new(Evaluator::Cpu))) }
    }
}

/// The levels, with warnings.
#[derive(Clone, Debug, PartialEq)]
pub struct FeltFigures {
    pub felt: Felt,
    pub warnings: Vec<String>,
}

impl Part for Feeling {
    type Input = (Scene, Performance);
    type Output = Result<FeltFigures, String>;

    fn input(&self, now: &Now<'_>) -> Option<Self::Input> {
        let (is_shown, is_still) = match now.panel? {
            Panel::Felt => (true, false),
            Panel::Device => (felt::is_for_a_hand(now.scene), now.plays == Plays::Scene),
            Panel::Scene | Panel::Solver | Panel::Drive | Panel::Liquid | Panel::Motion | Panel::Measure => {
                (false, false)
            }
        };
        let scene = if is_still { at_rest(now.scene) } else { now.scene.clone() };
        let performance = match now.cycle.filter(|_| motion::moves(&scene)) {
            _ if !is_shown => return None,
            Some(cycle) => Performance::Motion(cycle.clone()),
            None if motion::moves(&scene) => return None,
            None => Performance::Still(now.solution?.clone()),
        };
        // Until the scene is solved again, the drive may belong to another array.
        let fits = now.sound.is_some() && performance.first().phases.len() == now.scene.elements();
        fits.then_some((scene, performance))
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Self::Input) -> Self::Output + Send + 'static {
        let stages = Arc::clone(&self.stages);
        move |(scene, performance)| {
            let mut stages = stages.lock().unwrap_or_else(PoisonError::into_inner);
            let felt = Felt::with_speeds(scene, &performance.drives(), &mut stages);
            let felt = felt.map_err(|error| error.to_string())?;
            let foci = match performance {
                Performance::Still(solution) => &solution.foci[..],
                Performance::Motion(_) => &[],
            };
            Ok(FeltFigures { warnings: felt.warnings(scene, foci), felt })
        }
    }
}
