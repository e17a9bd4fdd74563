//! Parts of the window: values derived from what is displayed, computed in the background on demand.

use std::sync::Arc;

use egui::Context;
use glam::DVec3;

use crate::drive::Drive;
use crate::field::Quantity;
use crate::scene::Scene;
use crate::solver::Solution;
use crate::solver::frames::Sequence;
use crate::studio::later::Later;
use crate::ui::board::Plays;
use crate::ui::layout::Panel;
use crate::ui::playback::Playback;
use crate::ui::sound::{self, Sound};
use crate::ui::view::{Lens, View};

/// Everything that parts are derived from.
#[derive(Clone, Debug)]
pub struct Now<'a> {
    pub scene: &'a Scene,
    pub view: &'a View,
    /// The page of the right panel; `None` in presentation mode.
    pub panel: Option<Panel>,
    pub playback: Playback,
    /// Phase levels per period of the displayed drive.
    pub levels: Option<u32>,
    /// The played drive, if it is one of the scene's array.
    pub sound: Option<&'a Sound>,
    /// The displayed solution at rest.
    pub solution: Option<&'a Arc<Solution>>,
    /// The last solved scene at rest, with its solution.
    pub solved: Option<(&'a Scene, &'a Arc<Solution>)>,
    /// The sound of the board.
    pub plays: Plays,
    /// The drives of the motion.
    pub cycle: Option<&'a Arc<Sequence>>,
    /// Whether targets are selected.
    pub has_selection: bool,
    /// Position of the selected target, or else of the first focus, m.
    pub focus: Option<DVec3>,
    /// Last position of the pointer on the map, m.
    pub pointer: Option<DVec3>,
    /// The displayed part of the plane; `None` in 3D.
    pub lens: Option<&'a Lens>,
    /// Whether nothing is being dragged.
    pub rests: bool,
}

impl Now<'_> {
    /// The drives of a map of this quantity.
    pub fn drives(&self, quantity: Quantity) -> Vec<Drive> {
        sound::drives(self.cycle, self.sound, self.playback, quantity)
    }
}

/// A derived value, with its settings.
pub trait Part: Default {
    type Input: Clone + PartialEq + Send + 'static;
    type Output: Send + 'static;

    /// The input of the value; `None` while it is not displayed.
    fn input(&self, now: &Now<'_>) -> Option<Self::Input>;

    /// Whether a computation may begin now.
    fn may_begin(&self, _now: &Now<'_>) -> bool {
        true
    }

    fn computation(&self) -> impl FnOnce(&Self::Input) -> Self::Output + Send + 'static;
}

/// A part with its newest value.
#[derive(Debug)]
pub struct Derived<P: Part> {
    pub form: P,
    input: Option<P::Input>,
    made: Later<P::Input, P::Output>,
}

impl<P: Part> Default for Derived<P> {
    fn default() -> Self {
        Self { form: P::default(), input: None, made: Later::default() }
    }
}

impl<P: Part> Derived<P> {
    /// The newest value while it is displayed: the previous one until the next is there.
    pub fn newest(&self) -> Option<&P::Output> {
        self.input.as_ref().and(self.made.newest())
    }

    /// The value of the current input.
    pub fn exact(&self) -> Option<&P::Output> {
        self.made.get(self.input.as_ref()?)
    }
}

/// Draws a frame once a value is there.
pub fn wake(ctx: &Context) -> impl Fn() + Send + 'static {
    let ctx = ctx.clone();
    move || ctx.request_repaint()
}

/// The background work of a part.
pub trait Background {
    /// Collects a finished value, and returns whether there was one.
    fn collect(&mut self) -> bool;

    /// Requests the displayed value.
    fn update(&mut self, now: &Now<'_>, ctx: &Context);

    fn is_running(&self) -> bool;
}

impl<P: Part> Background for Derived<P> {
    fn collect(&mut self) -> bool {
        self.made.collect()
    }

    fn update(&mut self, now: &Now<'_>, ctx: &Context) {
        self.input = self.form.input(now);
        if let Some(input) = self.input.as_ref().filter(|_| self.form.may_begin(now)) {
            self.made.ask(input, wake(ctx), self.form.computation());
        }
    }

    fn is_running(&self) -> bool {
        self.made.is_running()
    }
}
