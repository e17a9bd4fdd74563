//! From numbers to pictures: colour maps, PNG and NPY, sheets with axes, animations and charts; and from picture
//! files to target values.

#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod animation;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod chart;
mod colour;
pub mod export;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod figure;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod grey;
#[cfg(feature = "studio")]
pub mod numbers;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod relief;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod sheet;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod space;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod upright;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod vti;

pub use colour::ColourMap;
#[doc(hidden)]
pub use colour::veil;

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("the picture could not be drawn: {0}")]
pub struct PictureError(String);

/// Colours of a grid of pixels, r, g, b, a from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub rgba: Vec<u8>,
}

impl Picture {
    /// The picture of colours in a field's order, row 0 at the smallest y, the bottom of the picture.
    ///
    /// # Panics
    /// If there are not four bytes per pixel.
    pub fn from_field_order(width: usize, height: usize, colours: &[u8]) -> Self {
        assert_eq!(colours.len(), width * height * 4, "four bytes per pixel");
        let rgba = colours.chunks_exact((width * 4).max(1)).rev().flatten().copied().collect();
        Self { width, height, rgba }
    }

    /// Blends a veil of the same size over it: [`veil()`].
    pub fn veil(&mut self, veil: &Self) {
        let pixels = self.rgba.as_chunks_mut::<4>().0.iter_mut();
        for (pixel, over) in pixels.zip(veil.rgba.as_chunks::<4>().0) {
            *pixel = colour::veiled(*pixel, *over);
        }
    }

    /// One colour, r, g, b, a.
    ///
    /// # Panics
    /// A position outside the picture.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 4] {
        let at = (y * self.width + x) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }
}
