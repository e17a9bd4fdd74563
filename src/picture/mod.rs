//! From numbers to what a person looks at: colour maps, PNG and NPY, and sheets with axes.

pub mod colour;
pub mod export;
pub mod sheet;

pub use colour::ColourMap;

/// Colours of a grid of pixels, r, g, b, a from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub rgba: Vec<u8>,
}

impl Picture {
    /// From colours in a field's order, whose row 0 is at the smallest y: the bottom of the picture.
    pub fn from_field_order(width: usize, height: usize, colours: &[u8]) -> Self {
        assert_eq!(colours.len(), width * height * 4, "four bytes per pixel");
        let rgba = colours.chunks_exact(width * 4).rev().flatten().copied().collect();
        Self { width, height, rgba }
    }

    /// One colour, r, g, b, a.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 4] {
        let at = (y * self.width + x) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }
}
