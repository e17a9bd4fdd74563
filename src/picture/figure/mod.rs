//! Figures for papers: a map with axes, colour bar, scale bar, contours and targets, described once and written as SVG, PDF or PNG.
//!
//! The description is a list of marks in millimetres, laid out on the grid of the PNG's pixels: the map is one raster
//! image whose pixels are the same in all three, and the PNG shows them one to one. All else is vectors, and text
//! stays text. A shaded relief is such a raster with bars for lengths and depths.

pub mod axes;
pub(in crate::picture) mod font;
mod layout;
mod pdf;
mod raster;
pub mod surface;
mod svg;

use strum::IntoStaticStr;

use crate::picture::Picture;
use crate::picture::PictureError;

pub use axes::{round_step, steps};
pub use layout::{Axis, Bar, Content, Format, Paper};
pub(in crate::picture) use raster::letters;

/// A colour, r, g, b.
type Ink = [u8; 3];

const BLACK: Ink = [20, 20, 22];

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
enum Mark {
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
    pixels: [usize; 2],
    /// Pixels in a millimetre.
    density: f64,
    title: String,
    marks: Vec<Mark>,
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

    /// The bytes of a file.
    ///
    /// # Errors
    /// The encoder of the map's pixels refuses them.
    pub fn write(&self, format: Format) -> Result<Vec<u8>, PictureError> {
        match format {
            Format::Png => raster::png(self),
            Format::Svg => svg::write(self),
            Format::Pdf => pdf::write(self),
        }
    }

    /// The picture of the PNG.
    ///
    /// # Errors
    /// More pixels than a picture can have.
    pub fn picture(&self) -> Result<Picture, PictureError> {
        raster::picture(self)
    }
}
