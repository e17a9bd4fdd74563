//! Where linear theory ends, of the solution at rest.

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::harmonic::NoHarmonic;
use crate::scene::Scene;
use crate::studio::nonlinear::{Nonlinear, loudest};
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// The figures of the Solver page beyond linear theory.
#[derive(Debug, Default)]
pub struct Harmonic;

impl Part for Harmonic {
    type Input = (Scene, Vec<Drive>, DVec3);
    type Output = Result<Nonlinear, NoHarmonic>;

    fn input(&self, now: &Now<'_>) -> Option<Self::Input> {
        let (scene, solution) = now.solved.filter(|_| now.panel == Some(Panel::Solver))?;
        Some((scene.clone(), solution.drives(), loudest(solution)?))
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Self::Input) -> Self::Output + Send + 'static {
        |(scene, drives, focus)| Nonlinear::new(scene, &Aperture::new(scene), drives, *focus)
    }
}
