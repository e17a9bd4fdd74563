//! The figures of a measured field on the Measure page and in its dialog.

use std::sync::Arc;

use crate::app::figure::{Drawing, Previews, Recipe};
use crate::picture::figure::page::Plot;
use crate::picture::figure::{Figure, Paper};
use crate::studio::figure::{Subject, Wish};
use crate::studio::measurement::report;
use crate::ui::parts::measuring::Finding;

/// Width of the page's figure in mm and in pixels.
const NARROW: f64 = 85.0;
const PIXELS: f64 = 700.0;
/// Pixels of a figure's height that every screen can show, at most.
const TALLEST: f64 = 2048.0;
/// Maps on the page: those of the first plane.
const MAPS: usize = 3;

/// A figure on the screen. A result is the same one or another.
#[derive(Clone, Debug)]
pub(super) struct Sketch {
    pub(super) finding: Arc<Finding>,
    pub(super) title: String,
}

impl PartialEq for Sketch {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.finding, &other.finding) && self.title == other.title
    }
}

impl Sketch {
    /// The panels below each other, readable on the page, without what it has in words.
    pub(super) fn column(&self) -> anyhow::Result<Drawing> {
        let is_table =
            |subject: &Subject| matches!(subject, Subject::Plot(plot) if matches!(**plot, Plot::Table(_)));
        let plots = self.finding.panels.iter().filter(|panel| !is_table(&panel.subject)).cloned();
        let (maps, others): (Vec<_>, Vec<_>) =
            plots.partition(|panel| matches!(panel.subject, Subject::Scattered(_)));
        let panels = maps.into_iter().take(MAPS).chain(others).collect();
        let paper = Paper { width: NARROW, dpi: PIXELS * 25.4 / NARROW };
        let mut recipe = Recipe { panels, wish: Wish { paper, columns: Some(1), ..Wish::default() } };
        let mut figure = recipe.figure()?;
        let most = TALLEST * 25.4 / figure.size()[1].max(1.0);
        if recipe.wish.paper.dpi > most {
            recipe.wish.paper.dpi = most;
            figure = recipe.figure()?;
        }
        drawn(&figure)
    }

    /// The figure as files have it.
    pub(super) fn whole(&self) -> anyhow::Result<Drawing> {
        drawn(&report::drawn(&self.finding.measured, &self.title, false)?)
    }
}

fn drawn(figure: &Figure) -> anyhow::Result<Drawing> {
    Ok((figure.picture()?, figure.size()))
}

/// The figures on the page and in its dialog.
#[derive(Debug, Default)]
pub(super) struct MeasuredFigures {
    pub(super) page: Previews<Sketch>,
    pub(super) dialog: Previews<Sketch>,
}

impl MeasuredFigures {
    pub(super) fn is_busy(&self) -> bool {
        self.page.is_busy() || self.dialog.is_busy()
    }
}
