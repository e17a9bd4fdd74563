//! What is heard of the modulation, of the solution at rest.

use crate::acoustics::Aperture;
use crate::scene::Scene;
use crate::studio::demodulation::Demodulated;
use crate::studio::performance::Performance;
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// The figure below the modulation.
#[derive(Debug, Default)]
pub struct Demodulation;

impl Part for Demodulation {
    type Input = (Scene, Performance);
    type Output = Option<Demodulated>;

    fn input(&self, now: &Now<'_>) -> Option<Self::Input> {
        let solution = now.solution.filter(|_| now.panel == Some(Panel::Motion) && now.sound.is_some())?;
        // Until the scene is solved again, the drive may belong to another array.
        let fits = solution.drive.phases.len() == now.scene.elements();
        fits.then(|| (now.scene.clone(), Performance::Still(solution.clone())))
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Self::Input) -> Self::Output + Send + 'static {
        |(scene, performance)| match performance {
            Performance::Still(solution) => Demodulated::new(scene, &Aperture::new(scene), solution),
            Performance::Motion(_) => None,
        }
    }
}
