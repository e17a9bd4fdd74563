//! From numbers to what a person looks at: colour maps, PNG and NPY, sheets with axes, animations and charts; and from pictures
//! to the numbers of targets.

pub mod animation;
#[cfg(feature = "cli")]
pub mod chart;
pub mod colour;
pub mod export;
pub mod figure;
pub mod grey;
mod lettering;
pub mod relief;
pub mod sheet;
pub mod space;
pub mod vti;

use plotters::drawing::DrawingAreaErrorKind;

pub use colour::ColourMap;

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("the picture could not be drawn: {0}")]
pub struct PictureError(String);

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for PictureError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self(error.to_string())
    }
}

/// Colours of a grid of pixels, r, g, b, a from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub rgba: Vec<u8>,
}

impl Picture {
    /// From colours in a field's order, whose row 0 is at the smallest y: the bottom of the picture.
    ///
    /// # Panics
    /// Other than four bytes per pixel.
    pub fn from_field_order(width: usize, height: usize, colours: &[u8]) -> Self {
        assert_eq!(colours.len(), width * height * 4, "four bytes per pixel");
        let rgba = colours.chunks_exact((width * 4).max(1)).rev().flatten().copied().collect();
        Self { width, height, rgba }
    }

    /// Lays a veil of as many pixels over it: [`colour::veil`].
    pub fn veil(&mut self, veil: &Self) {
        let pixels = self.rgba.as_chunks_mut::<4>().0.iter_mut();
        for (pixel, over) in pixels.zip(veil.rgba.as_chunks::<4>().0) {
            *pixel = colour::veiled(*pixel, *over);
        }
    }

    /// One colour, r, g, b, a.
    ///
    /// # Panics
    /// A place beside the picture.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 4] {
        let at = (y * self.width + x) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }
}
