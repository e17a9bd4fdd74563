//! What the running motion loses to the response of the elements.

use crate::scene::Scene;
use crate::studio::performance::Performance;
use crate::studio::posing::posed_in_motion;
use crate::studio::response::Moving;
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// The figures beside the speed of a motion.
#[derive(Clone, Copy, Debug, Default)]
pub struct Response;

impl Part for Response {
    type Input = (Scene, Performance);
    type Output = Option<Moving>;

    fn input(&self, now: &Now<'_>) -> Option<Self::Input> {
        let is_shown = now.panel == Some(Panel::Motion) && now.scene.array.response.is_some();
        let cycle = now.cycle.filter(|_| is_shown && now.sound.is_some())?;
        Some((posed_in_motion(now.scene), Performance::Motion(cycle.clone())))
    }

    fn computation(&self) -> impl FnOnce(&Self::Input) -> Self::Output + Send + 'static {
        |(scene, performance)| match performance {
            Performance::Motion(sequence) => Moving::new(scene, sequence),
            Performance::Still(_) => None,
        }
    }
}
