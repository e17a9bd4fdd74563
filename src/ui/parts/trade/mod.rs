//! The curve of strength against side lobe on the Drive page.

pub mod panel;

use crate::scene::{Amplitudes, Scene};
use crate::studio::trade::{self, Point};
use crate::ui::layout::Panel;
use crate::ui::part::{Now, Part};

/// Display of the curves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trade {
    pub is_shown: bool,
}

/// The curves with uniform and with free amplitudes.
pub type Curves = Result<[Vec<Point>; 2], String>;

impl Part for Trade {
    type Input = Scene;
    type Output = Curves;

    fn input(&self, now: &Now<'_>) -> Option<Scene> {
        let (scene, solution) = now.solved.filter(|_| self.is_shown && now.panel == Some(Panel::Drive))?;
        (!solution.foci.iter().all(|focus| focus.is_separate())).then(|| scene.clone())
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Scene) -> Curves + Send + 'static {
        |scene| {
            let curve = |amplitudes| trade::curve(scene, amplitudes).map_err(|error| error.to_string());
            Ok([curve(Amplitudes::Uniform)?, curve(Amplitudes::Free)?])
        }
    }
}
