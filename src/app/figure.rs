//! The inputs of a figure of what is shown, and its preview.

use eframe::egui::ColorImage;

use crate::field::{Evaluator, Stages};
use crate::picture::Picture;
use crate::picture::figure::{Figure, Paper};
use crate::studio::figure::{self, Panel, Wish};
use crate::studio::later::Later;

/// Pixels of a preview's width.
const PREVIEW: f64 = 900.0;

/// The inputs of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Recipe {
    pub(super) panels: Vec<Panel>,
    pub(super) wish: Wish,
}

/// A preview's picture with its figure's size (mm), or an error.
pub(super) type Made = Result<(Picture, [f64; 2]), String>;

/// The displayed or pending preview.
#[derive(Debug, Default)]
pub(super) struct Previews {
    pub(super) later: Later<Recipe, Made>,
    pub(super) shown: Option<Recipe>,
}

impl Previews {
    pub(super) fn is_busy(&self) -> bool {
        self.later.is_running()
    }
}

impl Recipe {
    pub(super) fn figure(&self) -> anyhow::Result<Figure> {
        let mut stages = Stages::new(Evaluator::Cpu);
        Ok(figure::draw(&self.panels, &self.wish, &mut stages, false)?.figure)
    }

    /// In so few pixels that a screen shows them.
    pub(super) fn preview(&self) -> anyhow::Result<(Picture, [f64; 2])> {
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
