//! The beam pattern of what is played, on the Drive page.

pub mod panel;

use crate::drive::Drive;
use crate::scene::{Focus, Scene};
use crate::studio::pattern::Pattern;
use crate::ui::part::{Now, Part};

/// Display of the pattern.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beam {
    pub is_shown: bool,
}

impl Part for Beam {
    type Input = (Scene, Vec<Drive>, Vec<Focus>);
    type Output = Pattern;

    fn input(&self, now: &Now<'_>) -> Option<Self::Input> {
        let sound = now.sound.filter(|_| self.is_shown)?;
        // Until the scene is solved again, the drive may belong to another array.
        let is_own = sound.heard.iter().all(|drive| drive.phases.len() == now.scene.elements());
        is_own.then(|| (now.scene.clone(), sound.heard.clone(), sound.foci.clone()))
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Self::Input) -> Pattern + Send + 'static {
        |(scene, drives, foci)| Pattern::new(scene, drives, foci, &[])
    }
}
