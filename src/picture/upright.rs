//! Decodes picture files within limits, with the orientation that their camera noted (EXIF).

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, ImageResult, Limits};

/// Limits of decoded pixels per side, and of bytes.
const MOST_PIXELS: u32 = 20_000;
const MOST_MEMORY: u64 = 400 << 20;

/// The format of bytes that are a picture: PNG, JPEG or BMP.
pub fn format(bytes: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(bytes).ok()?;
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp].contains(&format).then_some(format)
}

/// The pixels as stored, and the turn that makes them upright: a turn is cheaper once a picture is reduced.
///
/// # Errors
/// A picture that is broken or larger than 20 000 pixels a side or 400 MiB.
pub fn decode(bytes: &[u8], format: ImageFormat) -> ImageResult<(DynamicImage, Orientation)> {
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MOST_PIXELS), Some(MOST_PIXELS));
    limits.max_alloc = Some(MOST_MEMORY);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits.clone());
    let mut decoder = reader.into_decoder()?;
    limits.reserve(decoder.total_bytes())?;
    decoder.set_limits(limits)?;
    // A broken note is no reason to refuse the pixels.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    Ok((DynamicImage::from_decoder(decoder)?, orientation))
}
