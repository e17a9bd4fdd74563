//! Figures for papers: a map with axes, colour bar, scale bar, contours and targets, described once and written as SVG, PDF or PNG.
//!
//! The description is a list of marks in millimetres, laid out on the grid of the PNG's pixels: the map is one raster
//! image whose pixels are the same in all three, and the PNG shows them one to one. All else is vectors, and text
//! stays text. A shaded relief is such a raster with bars for lengths and depths.

pub mod axes;
pub(in crate::picture) mod font;
pub(in crate::picture) mod layout;
pub(in crate::picture) mod mark;
mod pdf;
pub(in crate::picture) mod raster;
pub mod surface;
pub(in crate::picture) mod svg;

use crate::picture::{Picture, PictureError};

pub use axes::{round_step, steps};
pub use layout::{Axis, Bar, Content, Format, Paper};
pub use mark::Figure;

impl Figure {
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
