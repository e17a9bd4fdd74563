//! The ways of playing a drawing for a hand, by what is felt of them.

use crate::scene::{Modulation, Scene, Turns};
use crate::studio::felt;
use crate::studio::stimulus::{self, Kind, Stimulus};
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};
use crate::ui::parts::feeling::at_rest;

/// The comparison of ways on the Device page.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ways {
    pub is_shown: bool,
}

impl Part for Ways {
    type Input = Scene;
    /// The best way of each kind, the one that is felt most first.
    type Output = Result<Vec<Stimulus>, String>;

    fn input(&self, now: &Now<'_>) -> Option<Scene> {
        let is_shown = self.is_shown && now.panel == Some(Panel::Device);
        let can_differ = felt::is_for_a_hand(now.scene) && !now.scene.drive.is_named();
        (is_shown && can_differ).then(|| {
            // The drawing alone: a way that is chosen changes nothing here.
            let mut scene = Scene { modulation: Modulation::default(), ..at_rest(now.scene) };
            scene.solver.frames = Turns::Auto;
            scene
        })
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Scene) -> Self::Output + Send + 'static {
        |scene| {
            let mut all = stimulus::ranked(scene).map_err(|error| error.to_string())?;
            let mut kinds: Vec<Kind> = Vec::new();
            all.retain(|way| {
                let is_first = !kinds.contains(&way.kind);
                kinds.push(way.kind);
                is_first
            });
            Ok(all)
        }
    }
}
