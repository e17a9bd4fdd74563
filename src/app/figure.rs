//! The figure of the current view: preview, file, and pixels on the clipboard.

use std::sync::Arc;

use anyhow::Context;
use eframe::egui::{self, ColorImage, TextureOptions};

use crate::app::Window;
use crate::field::{Evaluator, Request, Stages};
use crate::picture::Picture;
use crate::picture::figure::{Figure, Format, Paper};
use crate::scene::{Focus, Scene};
use crate::studio::figure::{self, Wish};
use crate::studio::later::Later;
use crate::ui::part::wake;
use crate::ui::{Dialog, Preview};

/// Pixels of a preview's width.
const PREVIEW: f64 = 900.0;

/// The inputs of a figure.
#[derive(Clone, Debug, PartialEq)]
struct Recipe {
    scene: Arc<Scene>,
    foci: Vec<Focus>,
    request: Request,
    wish: Wish,
}

/// A preview's picture with its figure's size (mm), or an error.
type Made = Result<(Picture, [f64; 2]), String>;

/// The displayed or pending preview.
#[derive(Debug, Default)]
pub(super) struct Previews {
    later: Later<Recipe, Made>,
    shown: Option<Recipe>,
}

impl Previews {
    pub(super) fn is_busy(&self) -> bool {
        self.later.is_running()
    }
}

impl Recipe {
    fn figure(&self) -> anyhow::Result<Figure> {
        let mut stages = Stages::new(Evaluator::Cpu);
        let subject = (&*self.scene, &self.foci[..]);
        Ok(figure::draw(subject, &self.request, &self.wish, &mut stages, false)?.figure)
    }

    /// In so few pixels that a screen shows them.
    fn preview(&self) -> anyhow::Result<(Picture, [f64; 2])> {
        let mut small = self.clone();
        let paper = self.wish.paper;
        small.wish.paper = Paper { dpi: paper.dpi.min(PREVIEW * 25.4 / paper.width), ..paper };
        let figure = small.figure()?;
        Ok((figure.picture()?, figure.size()))
    }
}

impl Window {
    fn recipe(&self) -> anyhow::Result<Recipe> {
        let request = self.workshop.mapping.request().context("there is no map")?;
        let solution = self.shown.solution.as_ref();
        Ok(Recipe {
            scene: Arc::new(self.editor.scene().clone()),
            foci: solution.map_or_else(Vec::new, |solution| solution.foci.clone()),
            // The figure has its own size in pixels.
            request: Request { size: (1, 1), ..request.clone() },
            wish: self.editor.figure.wish(&self.editor.view),
        })
    }

    /// Updates the preview while it is displayed.
    pub(super) fn preview_figure(&mut self, ctx: &egui::Context) {
        if self.editor.dialog != Some(Dialog::Figure) {
            if self.shown.figure.is_some() {
                (self.previews, self.shown.figure) = (Previews::default(), None);
            }
            return;
        }
        let recipe = match self.recipe() {
            Ok(recipe) => recipe,
            Err(error) => return self.shown.figure = Some(Err(format!("{error:#}"))),
        };
        let Previews { later, shown } = &mut self.previews;
        later.collect();
        later.ask(&recipe, wake(ctx), |recipe| recipe.preview().map_err(|error| format!("{error:#}")));
        let Some(made) = later.get(&recipe) else { return };
        if shown.as_ref() == Some(&recipe) {
            return;
        }
        self.shown.figure = Some(made.clone().map(|(picture, size)| {
            let texture = ctx.load_texture("figure", image(&picture), TextureOptions::LINEAR);
            Preview { texture, size }
        }));
        *shown = Some(recipe);
        ctx.request_repaint();
    }

    pub(super) fn figure_bytes(&self, format: Format) -> anyhow::Result<Vec<u8>> {
        Ok(self.recipe()?.figure()?.write(format)?)
    }

    pub(super) fn copy_figure(&mut self, ctx: &egui::Context) {
        let picture = self.recipe().and_then(|recipe| Ok(recipe.figure()?.picture()?));
        match picture {
            Ok(picture) => {
                let words = format!("Copied {} x {} pixels", picture.width, picture.height);
                ctx.copy_image(image(&picture));
                self.tell(&words, false);
            }
            Err(error) => self.refuse("The figure cannot be copied", &error),
        }
    }
}

fn image(picture: &Picture) -> ColorImage {
    ColorImage::from_rgba_unmultiplied([picture.width, picture.height], &picture.rgba)
}
