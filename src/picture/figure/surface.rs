//! The plot of a shaded relief: without axes, since only horizontal lengths keep their scale, and with separate
//! bars for lengths and depths.

use glam::DVec2;

use crate::picture::Picture;
use crate::picture::figure::layout::{CAPITAL, Frame, GAP, NUMBER, Pen, RULE, Room};
use crate::picture::figure::mark::{Anchor, BLACK, Mark};
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

/// The content of a relief besides its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// m
    pub size: DVec2,
    /// Horizontal scale bar.
    pub scale: Option<Measure>,
    /// Depth bar.
    pub depth: Option<Measure>,
}

/// Position of a surface in a picture of this many pixels.
pub fn place([width, height]: [usize; 2]) -> Place {
    let wide = width as f64;
    Place { width, height, side: 0.0, top: ABOVE * wide, bottom: FRONT * wide, ground: PAPER }
}

impl Surface {
    /// Height over width.
    pub(in crate::picture) fn shape(&self) -> f64 {
        ABOVE + relief::shape(self.size) + FRONT
    }

    pub(in crate::picture) fn room(&self) -> Room {
        let bars = [&self.scale, &self.depth].iter().any(|bar| bar.is_some());
        Room { below: if bars { GAP + self.deep() + GAP } else { 0.0 }, ..Room::default() }
    }

    /// Height of the row of bars.
    fn deep(&self) -> f64 {
        self.depth.as_ref().map_or(0.0, |depth| depth.length).max(NUMBER)
    }

    pub(in crate::picture) fn marks(&self, frame: &Frame, picture: Picture) -> Vec<Mark> {
        let mut pen = Pen::new(frame);
        pen.pixels(picture);
        let [left, _, right, bottom] = frame.room();
        let base = bottom + GAP + self.deep() / 2.0;
        let line = base + NUMBER * CAPITAL / 2.0;
        if let Some(scale) = &self.scale {
            pen.number([left + scale.length + GAP, line], Anchor::Start, BLACK, &scale.text);
            let (corner, size) = ([left, base - RULE / 2.0], [scale.length, RULE]);
            pen.list.push(Mark::Block { corner, size, ink: BLACK });
        }
        if let Some(depth) = &self.depth {
            pen.number([right - RULE - GAP, line], Anchor::End, BLACK, &depth.text);
            let (corner, size) = ([right - RULE, base - depth.length / 2.0], [RULE, depth.length]);
            pen.list.push(Mark::Block { corner, size, ink: BLACK });
        }
        pen.list
    }
}
