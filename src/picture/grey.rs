//! Decodes picture files of targets to grey values.

use std::io::Cursor;

use image::codecs::png::PngEncoder;
use image::imageops::{self, FilterType};
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, Luma};

use crate::echo;
use crate::picture::upright;
use crate::scene::Grey;

/// Limit of the longer side in pixels: larger pictures are reduced.
pub const LONGEST: u32 = 512;
/// Rec. 709 luma of red, green and blue.
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Why bytes are no picture that can be a target.
#[derive(Debug, thiserror::Error)]
pub enum GreyError {
    #[error("this is neither a PNG, JPEG nor BMP picture")]
    UnknownFormat,
    #[error("the picture cannot be read: {}", echo::line(.0.to_string().trim_end()))]
    Broken(#[from] image::ImageError),
    #[error("the picture is black or transparent all over: it prescribes no sound")]
    Black,
}

/// The picture of a file's bytes, upright: 8-bit luma over 255, black where transparent.
///
/// # Errors
/// An unknown format, a picture that is broken or larger than 20 000 pixels a side, or a black one.
pub fn read(bytes: &[u8]) -> Result<Grey, GreyError> {
    let format = upright::format(bytes).ok_or(GreyError::UnknownFormat)?;
    let (mut picture, orientation) = upright::decode(bytes, format)?;
    picture.apply_orientation(orientation);
    let coloured = picture.into_rgba8();
    let brightness = |pixel: &image::Rgba<u8>| {
        let [r, g, b, alpha] = pixel.0.map(|value| f32::from(value) / 255.0);
        // Grey values stay exactly as painted.
        let luma = if r == g && g == b { r } else { LUMA[0] * r + LUMA[1] * g + LUMA[2] * b };
        luma * alpha
    };
    let (width, height) = coloured.dimensions();
    let mut grey = ImageBuffer::from_fn(width, height, |x, y| Luma([brightness(coloured.get_pixel(x, y))]));
    let longer = width.max(height);
    if longer > LONGEST {
        let reduced = |side: u32| ((u64::from(side) * u64::from(LONGEST)).div_ceil(u64::from(longer))) as u32;
        grey = imageops::resize(&grey, reduced(width), reduced(height), FilterType::Triangle);
    }
    let (width, height) = grey.dimensions();
    let brightness = grey.into_raw().into_iter().map(|it| it.clamp(0.0, 1.0)).collect();
    let grey = Grey { file: None, width: width as usize, height: height as usize, brightness };
    if grey.is_black() { Err(GreyError::Black) } else { Ok(grey) }
}

/// Brightness as an 8-bit grey PNG, which [`read`] opens again.
///
/// # Errors
/// The encoder refuses the picture: one without pixels.
pub fn png(grey: &Grey) -> Result<Vec<u8>, image::ImageError> {
    let level = |brightness: &f32| (brightness.clamp(0.0, 1.0) * 255.0).round() as u8;
    let levels: Vec<u8> = grey.brightness.iter().map(level).collect();
    let mut bytes = Vec::new();
    let (width, height) = (grey.width as u32, grey.height as u32);
    PngEncoder::new(Cursor::new(&mut bytes)).write_image(&levels, width, height, ExtendedColorType::L8)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageFormat};

    /// Including transparency, which the program's own pictures lack.
    fn coloured(width: u32, height: u32, colour: impl Fn(usize, usize) -> [u8; 4]) -> Vec<u8> {
        let pixel = |x: u32, y: u32| image::Rgba(colour(x as usize, y as usize));
        let mut bytes = Cursor::new(Vec::new());
        image::RgbaImage::from_fn(width, height, pixel).write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn brightness_is_luma_and_what_is_transparent_is_black() {
        let colours =
            [[255, 255, 255, 255], [255, 255, 255, 0], [0, 0, 0, 255], [51, 51, 51, 255], [0, 255, 0, 255]];
        let grey = read(&coloured(5, 1, |x, _| colours[x])).unwrap();
        assert_eq!((grey.width, grey.height), (5, 1));
        for (grey, expected) in grey.brightness.into_iter().zip([1.0, 0.0, 0.0, 0.2, 0.7152]) {
            assert!((grey - expected).abs() < 1e-6, "{grey}, not {expected}");
        }
    }

    #[test]
    fn a_picture_of_a_camera_is_upright() {
        let picture = GrayImage::from_fn(3, 2, |x, y| Luma([(x * 51 + y * 17) as u8]));
        let stored = upright::stored(&picture, 6);
        let mut bytes = Vec::new();
        let mut encoder = PngEncoder::new(&mut bytes);
        encoder.set_exif_metadata(upright::note(6)).unwrap();
        encoder.write_image(&stored, 2, 3, ExtendedColorType::L8).unwrap();
        let grey = read(&bytes).unwrap();
        assert_eq!((grey.width, grey.height), (3, 2));
        let levels: Vec<u8> = grey.brightness.iter().map(|level| (level * 255.0).round() as u8).collect();
        assert_eq!(levels, picture.into_raw());
    }

    #[test]
    fn what_is_written_is_read_again() {
        let brightness = (0..=255).map(|level: u8| f32::from(level) / 255.0).collect();
        let grey = Grey { file: None, width: 64, height: 4, brightness };
        let again = read(&png(&grey).unwrap()).unwrap();
        assert_eq!((again.width, again.height), (64, 4));
        assert_eq!(again.brightness, grey.brightness);
    }

    #[test]
    fn large_pictures_are_made_smaller_and_keep_their_form() {
        let bytes = coloured(1500, 300, |x, _| if x < 750 { [0, 0, 0, 255] } else { [255, 255, 255, 255] });
        let Grey { width, height, brightness: grey, .. } = read(&bytes).unwrap();
        assert_eq!((width, height), (512, 103));
        assert!(
            grey[..250].iter().all(|grey| *grey < 0.01) && grey[262..512].iter().all(|grey| *grey > 0.99)
        );
        assert_eq!(read(&coloured(5000, 1, |_, _| [255; 4])).unwrap().height, 1, "a row is left");
    }

    #[test]
    fn what_is_no_picture_or_black_is_refused() {
        let black = coloured(3, 3, |_, _| [0, 0, 0, 255]);
        assert!(matches!(read(&black), Err(GreyError::Black)));
        assert!(matches!(read(b"no picture"), Err(GreyError::UnknownFormat)));
        assert!(matches!(read(b""), Err(GreyError::UnknownFormat)));
        assert!(matches!(read(&black[..40]), Err(GreyError::Broken(_))));
        // A header that promises gigabytes.
        let mut vast = black;
        vast[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
        assert!(read(&vast).is_err());
    }
}
