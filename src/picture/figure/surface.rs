//! The figure of a shaded relief: without axes, since only horizontal lengths keep their scale, and with separate
//! bars for lengths and depths.

use glam::DVec2;

use crate::picture::Picture;
use crate::picture::figure::layout::{CAPITAL, GAP, MARGIN, NUMBER, RULE, TALLEST, TITLE};
use crate::picture::figure::mark::{Anchor, BLACK, Mark};
use crate::picture::figure::{Figure, Paper};
use crate::picture::relief::{self, PAPER, Place};

/// Parts of the picture's width above the surface, where waves may rise, and below it, for its front.
const ABOVE: f64 = 0.02;
const FRONT: f64 = 0.06;

/// A bar with its length, mm on paper, and its label.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    pub length: f64,
    pub text: String,
}

/// The content of a figure besides the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    pub title: Option<String>,
    /// Horizontal scale bar.
    pub scale: Option<Measure>,
    /// Depth bar.
    pub depth: Option<Measure>,
}

/// Position of the picture of a surface of this size (m).
pub fn place(paper: Paper, size: DVec2) -> Place {
    let density = paper.dpi / 25.4;
    let wide = (paper.width - 2.0 * MARGIN) * density;
    let (top, bottom) = (ABOVE * wide, FRONT * wide);
    let high = (top + wide * relief::shape(size) + bottom).min(TALLEST * paper.width * density);
    let in_pixels = |length: f64| (length.round() as usize).max(1);
    Place { width: in_pixels(wide), height: in_pixels(high), side: 0.0, top, bottom, ground: PAPER }
}

impl Surface {
    /// The figure of a picture drawn at [`place`].
    pub fn figure(&self, paper: Paper, picture: Picture) -> Figure {
        let density = paper.dpi / 25.4;
        let on_grid = |mm: f64| (mm * density).round() / density;
        let (width, height) = (picture.width as f64 / density, picture.height as f64 / density);
        let top = on_grid(MARGIN + self.title.as_ref().map_or(0.0, |_| TITLE + GAP));
        let left = on_grid(MARGIN);
        let mut marks = vec![Mark::Pixels { corner: [left, top], size: [width, height], picture }];
        let mut text =
            |at, height, anchor, text: &str| marks.push(Mark::text(at, height, anchor, BLACK, text));
        if let Some(title) = &self.title {
            text([left, MARGIN + TITLE * 0.85], TITLE, Anchor::Start, title);
        }
        let row = top + height + GAP;
        let deep = self.depth.as_ref().map_or(0.0, |depth| depth.length);
        let below =
            [&self.scale, &self.depth].iter().any(|bar| bar.is_some()).then(|| GAP + deep.max(NUMBER));
        let base = row + deep.max(NUMBER) / 2.0;
        if let Some(scale) = &self.scale {
            text(
                [left + scale.length + GAP, base + NUMBER * CAPITAL / 2.0],
                NUMBER,
                Anchor::Start,
                &scale.text,
            );
        }
        let right = left + width;
        if let Some(depth) = &self.depth {
            text([right - RULE - GAP, base + NUMBER * CAPITAL / 2.0], NUMBER, Anchor::End, &depth.text);
        }
        let mut bar = |corner, size| marks.push(Mark::Block { corner, size, ink: BLACK });
        if let Some(scale) = &self.scale {
            bar([left, base - RULE / 2.0], [scale.length, RULE]);
        }
        if let Some(depth) = &self.depth {
            bar([right - RULE, base - depth.length / 2.0], [RULE, depth.length]);
        }
        let page = [paper.width, top + height + below.unwrap_or(0.0) + MARGIN];
        let title = self.title.clone().unwrap_or_default();
        let pixels = page.map(|mm| ((mm * density).round() as usize).max(1));
        Figure { pixels, density, title, marks }
    }
}
