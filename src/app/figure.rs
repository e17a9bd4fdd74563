//! The inputs of a figure of what is shown, and its preview.

use eframe::egui::{ColorImage, Context, TextureOptions};

use crate::field::{Evaluator, Stages};
use crate::picture::Picture;
use crate::picture::figure::{Figure, Paper};
use crate::studio::figure::{self, Panel, Wish};
use crate::studio::later::Later;
use crate::ui::Preview;
use crate::ui::part::wake;

/// Pixels of a preview's width.
const PREVIEW: f64 = 900.0;

/// The inputs of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Recipe {
    pub(super) panels: Vec<Panel>,
    pub(super) wish: Wish,
}

/// A picture with its figure's size (mm).
pub(super) type Drawing = (Picture, [f64; 2]);
/// A preview's, or an error.
pub(super) type Made = Result<Drawing, String>;

/// The displayed or pending preview of a recipe.
#[derive(Debug)]
pub(super) struct Previews<R> {
    later: Later<R, Made>,
    shown: Option<R>,
}

impl<R> Default for Previews<R> {
    fn default() -> Self {
        Self { later: Later::default(), shown: None }
    }
}

impl<R: Clone + PartialEq + Send + 'static> Previews<R> {
    pub(super) fn is_busy(&self) -> bool {
        self.later.is_running()
    }

    /// Makes the preview on a thread, unless it is displayed. Call it every frame.
    pub(super) fn update(
        &mut self,
        recipe: R,
        make: fn(&R) -> anyhow::Result<Drawing>,
        preview: &mut Option<Result<Preview, String>>,
        ctx: &Context,
    ) {
        self.later.collect();
        self.later.ask(&recipe, wake(ctx), move |recipe| make(recipe).map_err(|error| format!("{error:#}")));
        let Some(made) = self.later.get(&recipe).filter(|_| self.shown.as_ref() != Some(&recipe)) else {
            return;
        };
        *preview = Some(made.clone().map(|(picture, size)| {
            let texture = ctx.load_texture("figure", image(&picture), TextureOptions::LINEAR);
            Preview { texture, size }
        }));
        self.shown = Some(recipe);
        ctx.request_repaint();
    }
}

impl Recipe {
    pub(super) fn figure(&self) -> anyhow::Result<Figure> {
        let mut stages = Stages::new(Evaluator::Cpu);
        Ok(figure::draw(&self.panels, &self.wish, &mut stages, false)?.figure)
    }

    /// In so few pixels that a screen shows them.
    pub(super) fn preview(&self) -> anyhow::Result<Drawing> {
        let mut small = self.clone();
        let paper = self.wish.paper;
        small.wish.paper = Paper { dpi: paper.dpi.min(PREVIEW * 25.4 / paper.width), ..paper };
        let figure = small.figure()?;
        Ok((figure.picture()?, figure.size()))
    }
}

pub(super) fn image(picture: &Picture) -> ColorImage {
    ColorImage::from_rgba_unmultiplied([picture.width, picture.height], &picture.rgba)
}
