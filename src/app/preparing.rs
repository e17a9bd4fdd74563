//! The answers of a body to all elements, found once nothing has changed for a while: then a new drive costs a sum.

use egui::Context;

use crate::acoustics::Aperture;
use crate::studio::later::Later;
use crate::ui::part::wake;

/// s without a change.
const REST: f64 = 0.5;

/// The answers, which the aperture keeps, one search at a time.
#[derive(Debug, Default)]
pub struct Preparing {
    found: Later<Aperture, ()>,
    /// The array with its bodies, and since when it rests, s on the window's clock.
    since: Option<(Aperture, f64)>,
}

impl Preparing {
    /// Begins the search when it is time. A page would stand still, and bodies that hear each other or mirrors take
    /// minutes.
    pub fn update(&mut self, aperture: Option<&Aperture>, rests: bool, ctx: &Context) {
        self.found.collect();
        let is_quick = |aperture: &Aperture| aperture.bodies.of().len() < 2 && aperture.mirrors.is_empty();
        let lacks = |aperture: &&Aperture| {
            rests && !cfg!(target_arch = "wasm32") && is_quick(aperture) && !aperture.is_prepared()
        };
        let Some(aperture) = aperture.filter(lacks) else {
            self.since = None;
            return;
        };
        let now = ctx.input(|input| input.time);
        let since = match &self.since {
            Some((own, since)) if own == aperture => *since,
            Some(_) | None => self.since.insert((aperture.clone(), now)).1,
        };
        if now - since >= REST {
            self.found.ask(aperture, wake(ctx), Aperture::prepare);
        } else {
            ctx.request_repaint_after_secs((REST - (now - since)) as f32);
        }
    }
}
