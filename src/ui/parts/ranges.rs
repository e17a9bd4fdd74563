//! 5, 50 and 95 % of the figures of a solution, for elements that differ.

use std::sync::Arc;

use crate::acoustics::Aperture;
use crate::field::{Evaluator, SideLobe, Stages};
use crate::scene::Scene;
use crate::solver::{Problem, Ranges, Solution};
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// The ranges of the Solver page.
#[derive(Debug, Default)]
pub struct FigureRanges;

/// A scene and its solution, the same one or an equal phase by phase.
#[derive(Clone, Debug)]
pub struct Judged {
    scene: Scene,
    solution: Arc<Solution>,
}

impl PartialEq for Judged {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.solution, &other.solution) && self.scene == other.scene
    }
}

impl Part for FigureRanges {
    type Input = Judged;
    type Output = Option<Ranges>;

    fn input(&self, now: &Now<'_>) -> Option<Judged> {
        let (scene, solution) = now.solved.filter(|_| now.panel == Some(Panel::Solver))?;
        let is_spread = !scene.array.spread.is_none() && !solution.foci.is_empty();
        is_spread.then(|| Judged { scene: scene.clone(), solution: Arc::clone(solution) })
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Judged) -> Option<Ranges> + Send + 'static {
        |Judged { scene, solution }| {
            let (aperture, mut solution) = (Aperture::new(scene), Solution::clone(solution));
            let problem = Problem::of_scene(scene, &aperture, solution.foci.clone());
            solution.judge(scene, &problem);
            let figures = solution.figures.filter(|figures| figures.side_lobe > 0.0);
            let lobe = figures.map(|figures| SideLobe {
                position: figures.side_lobe_position,
                pressure: figures.side_lobe * solution.quality.mean_pressure,
                part: figures.side_lobe,
            });
            Ranges::new(scene, &problem, (&solution, lobe.as_ref()), &mut Stages::new(Evaluator::Cpu))
        }
    }
}
