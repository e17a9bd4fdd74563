//! Import of drawings: the paths of an SVG or the dark strokes of a picture, as polylines and as targets.
//!
//! A drawing becomes targets in independent steps: bytes, polylines in any unit, a [`Drawing`] (polylines centred
//! on the origin with a longer side of 1), targets ([`Placement::targets`]). Photographs are distinguished from
//! drawings by their shades and the widths of what seem strokes. This module accesses neither files nor the
//! window.

pub mod curve;
mod drawing;
mod ink;
mod line;
mod paper;
mod placement;
mod scan;
mod split;
mod svg;
mod trace;
mod windows;

pub use drawing::{Drawing, ImportError, MOST_BYTES};
pub use line::Line;
pub use placement::Placement;

use crate::picture::upright;

/// The drawing of a file: an SVG, or a PNG, JPEG or BMP picture.
///
/// # Errors
/// An unsupported, broken or too large file, or one without drawn content.
pub fn read(bytes: &[u8]) -> Result<Drawing, ImportError> {
    if bytes.len() > MOST_BYTES {
        return Err(ImportError::TooLarge(bytes.len()));
    }
    match upright::format(bytes) {
        Some(format) => Drawing::new(scan::lines(bytes, format)?, Vec::new()),
        None if bytes.starts_with(&[0x1f, 0x8b]) => Err(ImportError::Compressed),
        None => {
            let text = std::str::from_utf8(bytes).map_err(|_| ImportError::UnknownFormat)?;
            if !text.contains("<svg") && !text.contains(":svg") {
                return Err(ImportError::UnknownFormat);
            }
            let (lines, remarks) = svg::lines(text)?;
            Drawing::new(lines, remarks)
        }
    }
}
