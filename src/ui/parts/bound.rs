//! The upper bound of what any drive of the array can do at the foci.

use crate::acoustics::Aperture;
use crate::scene::{Focus, Scene};
use crate::solver::{self, Problem};
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// The bound of the Solver page.
#[derive(Debug, Default)]
pub struct Bound;

impl Part for Bound {
    type Input = (Scene, Vec<Focus>);
    type Output = f64;

    fn input(&self, now: &Now<'_>) -> Option<Self::Input> {
        let (scene, solution) = now.solved.filter(|_| now.panel == Some(Panel::Solver))?;
        (!solution.foci.is_empty()).then(|| (scene.clone(), solution.foci.clone()))
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Self::Input) -> f64 + Send + 'static {
        |(scene, foci)| solver::bound(&Problem::new(&Aperture::new(scene), foci.clone()))
    }
}
