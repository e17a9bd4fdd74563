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
    /// A filled circle.
    Disc { centre: [f64; 2], radius: f64, ink: Ink },
    /// A line of text on its baseline; turned, it runs upwards.
    Text { at: [f64; 2], height: f64, anchor: Anchor, is_turned: bool, ink: Ink, text: String },
}

impl Mark {
    /// An open line.
    pub(in crate::picture) fn line(points: impl Into<Vec<[f64; 2]>>, width: f64, ink: Ink) -> Self {
        Self::Line { points: points.into(), is_closed: false, width, ink }
    }

    /// A closed rectangle of lines.
    pub(in crate::picture) fn frame(
        [x, y]: [f64; 2],
        [width, height]: [f64; 2],
        line: f64,
        ink: Ink,
    ) -> Self {
        let points = vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
        Self::Line { points, is_closed: true, width: line, ink }
    }

    /// Horizontal text.
    pub(in crate::picture) fn text(at: [f64; 2], height: f64, anchor: Anchor, ink: Ink, text: &str) -> Self {
        Self::Text { at, height, anchor, is_turned: false, ink, text: text.to_owned() }
    }

    /// Text that runs upwards.
    pub(in crate::picture) fn turned_text(at: [f64; 2], height: f64, ink: Ink, text: &str) -> Self {
        let text = text.to_owned();
        Self::Text { at, height, anchor: Anchor::Middle, is_turned: true, ink, text }
    }
}

/// A figure, ready to be written.
#[derive(Debug)]
pub struct Figure {
    /// Pixels of the PNG.
    pub(in crate::picture) pixels: [usize; 2],
    /// Pixels in a millimetre.
    pub(in crate::picture) density: f64,
    pub(in crate::picture) title: String,
    pub(in crate::picture) marks: Vec<Mark>,
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
