//! Lines, areas, words and pixels of a page, in millimetres.

use strum::IntoStaticStr;

use crate::picture::Picture;

/// A colour, r, g, b.
pub type Ink = [u8; 3];

pub const BLACK: Ink = [20, 20, 22];

/// Anchor of a text relative to its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub(in crate::picture) enum Anchor {
    Start,
    Middle,
    End,
}

/// The marks of a figure; positions in mm from the top left corner.
#[derive(Debug)]
pub enum Mark {
    /// Pixels in a rectangle.
    Pixels { corner: [f64; 2], size: [f64; 2], picture: Picture },
    /// A line through points.
    Line { points: Vec<[f64; 2]>, is_closed: bool, width: f64, ink: Ink },
    /// A filled rectangle.
    Block { corner: [f64; 2], size: [f64; 2], ink: Ink },
    /// A line of text on its baseline; turned, it runs upwards.
    Text { at: [f64; 2], height: f64, anchor: Anchor, is_turned: bool, ink: Ink, text: String },
}

/// A figure, ready to be written.
#[derive(Debug)]
pub struct Figure {
    /// Pixels of the PNG.
    pub(super) pixels: [usize; 2],
    /// Pixels in a millimetre.
    pub(super) density: f64,
    pub(super) title: String,
    pub(super) marks: Vec<Mark>,
}

impl Figure {
    /// Width and height, mm.
    pub fn size(&self) -> [f64; 2] {
        self.pixels.map(|pixels| pixels as f64 / self.density)
    }

    /// Pixels of the PNG, width and height.
    pub fn pixels(&self) -> [usize; 2] {
        self.pixels
    }
}
