//! Import of drawings: the seen paths of an SVG or the dark strokes of a picture, as polylines and as targets.
//!
//! A drawing becomes targets in independent steps: bytes, polylines in any unit, a [`Drawing`] (polylines centred
//! on the origin with a longer side of 1), targets ([`Placement::targets`]). Photographs are distinguished from
//! drawings by their shades and the widths of what seem strokes. This module accesses neither files nor the
//! window.

mod area;
pub mod curve;
mod drawing;
mod encoding;
mod ink;
mod join;
mod layers;
mod line;
mod paper;
mod placement;
#[cfg(test)]
mod samples;
mod scan;
mod sight;
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
        None => {
            let bytes = encoding::unpacked(bytes)?;
            let text = encoding::text(&bytes)?;
            if !text.contains("<svg") && !text.contains(":svg") {
                return Err(ImportError::UnknownFormat);
            }
            svg::drawing(&text)
        }
    }
}
