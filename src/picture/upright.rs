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

/// An EXIF note of an orientation from 1 to 8.
#[cfg(test)]
pub fn note(orientation: u8) -> Vec<u8> {
    // Little-endian; one directory at byte 8 with one entry: tag 0x112, of one 16-bit number.
    let mut note = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    note.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
    note
}

/// The pixels of which an orientation makes an upright picture.
#[cfg(test)]
pub fn stored(upright: &image::GrayImage, orientation: u8) -> image::GrayImage {
    // Turns by 90° undo each other, mirrors themselves.
    let inverse = [0, 1, 2, 3, 4, 5, 8, 7, 6][usize::from(orientation)];
    let mut picture = DynamicImage::ImageLuma8(upright.clone());
    picture.apply_orientation(Orientation::from_exif(inverse).unwrap());
    picture.into_luma8()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::GrayImage;
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, ImageEncoder};

    #[test]
    fn an_orientation_of_a_camera_is_found() {
        let upright = GrayImage::from_fn(3, 2, |x, y| image::Luma([(x * 50 + y * 20) as u8]));
        for orientation in 1..=8 {
            let stored = stored(&upright, orientation);
            // Where Exif has the upper left corner, from the sides that row and column 0 are.
            let corner = [[0, 0], [2, 0], [2, 1], [0, 1], [0, 0], [0, 2], [1, 2], [1, 0]];
            let [x, y] = corner[usize::from(orientation) - 1];
            assert_eq!(stored.get_pixel(x, y).0, [0], "{orientation}");
            let mut bytes = Vec::new();
            let mut encoder = PngEncoder::new(&mut bytes);
            encoder.set_exif_metadata(note(orientation)).unwrap();
            let (width, height) = stored.dimensions();
            encoder.write_image(&stored, width, height, ExtendedColorType::L8).unwrap();
            let (mut picture, found) = decode(&bytes, format(&bytes).unwrap()).unwrap();
            picture.apply_orientation(found);
            assert_eq!(picture.into_luma8(), upright, "{orientation}");
        }
    }

    #[test]
    fn a_broken_note_is_ignored() {
        let mut bytes = Vec::new();
        let mut encoder = PngEncoder::new(&mut bytes);
        encoder.set_exif_metadata(b"II*\0\xff\xff".to_vec()).unwrap();
        encoder.write_image(&[7, 8], 2, 1, ExtendedColorType::L8).unwrap();
        let (picture, found) = decode(&bytes, ImageFormat::Png).unwrap();
        assert_eq!((picture.into_luma8().into_raw(), found), (vec![7, 8], Orientation::NoTransforms));
    }
}
