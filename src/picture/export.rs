//! Encodes pictures as PNG files.

use png::{BitDepth, ColorType, Compression, EncodingError, Filter};

use crate::picture::Picture;

/// A PNG; opaque, so without an alpha channel.
///
/// # Errors
/// A picture refused by the encoder: a side of 0 or more than 2³¹ pixels.
///
/// # Panics
/// A picture without four bytes per pixel.
pub fn png(picture: &Picture) -> Result<Vec<u8>, EncodingError> {
    assert_eq!(picture.rgba.len(), picture.width * picture.height * 4, "four bytes per pixel");
    let rgb: Vec<u8> =
        picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width as u32, picture.height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_holds_the_pixels_top_row_first() {
        let bottom_then_top = [[1, 2, 3, 255], [4, 5, 6, 255], [7, 8, 9, 255], [10, 11, 12, 255]].concat();
        let picture = Picture::from_field_order(2, 2, &bottom_then_top);
        let image = image::load_from_memory(&png(&picture).unwrap()).unwrap().to_rgb8();
        assert_eq!((image.width(), image.height()), (2, 2));
        assert_eq!(image.get_pixel(0, 0).0, [7, 8, 9]);
        assert_eq!(image.get_pixel(1, 1).0, [4, 5, 6]);
    }
}
