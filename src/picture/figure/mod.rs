//! Figures for papers: panels in a grid, described once and written as SVG, PDF or PNG.
//!
//! A panel is a map with axes, colour bar, scale bar, contours and targets; a shaded relief with bars for lengths and
//! depths; a 3D picture; the elements of an array; a curve; or a table. The description is a list of marks in
//! millimetres, laid out on the grid of the PNG's pixels: a map, a relief or a 3D picture is one raster image whose
//! pixels are the same in all three, and the PNG shows them one to one. All else is vectors, and text stays text.

pub mod axes;
pub mod curve;
pub mod elements;
pub(in crate::picture) mod font;
pub(in crate::picture) mod layout;
pub(in crate::picture) mod mark;
pub mod page;
mod pdf;
pub mod polar;
pub(in crate::picture) mod raster;
pub mod space;
pub mod surface;
pub(in crate::picture) mod svg;
pub mod table;

use crate::picture::{Picture, PictureError};

pub use axes::{round_step, steps};
pub use layout::{Axis, Bar, Content, Format, Length, Paper};
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
