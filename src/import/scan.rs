//! The strokes of a picture as polylines, dark on light or light on dark: paper and ink are separated, and the ink is
//! traced.

use std::io::Cursor;

use glam::DVec2;
use image::imageops::FilterType;
use image::{DynamicImage, GrayImage, ImageFormat, ImageReader, Limits};

use crate::import::ink::Ink;
use crate::import::trace;
use crate::import::{ImportError, Line};

/// Limit of the longer side in pixels: larger pictures are reduced.
const LONGEST: u32 = 1000;
/// Limits of decoded pixels per side, and of bytes.
const MOST_PIXELS: u32 = 20_000;
const MOST_MEMORY: u64 = 400 << 20;
/// Grey levels between paper and ink.
const LEAST_CONTRAST: f64 = 24.0;
/// Smallest fraction of the variance between paper and ink: 0.64 for normally, 0.75 for uniformly distributed greys.
const LEAST_SEPARATION: f64 = 0.75;

/// Lines with y upwards; a pixel is the unit.
pub fn lines(bytes: &[u8], format: ImageFormat) -> Result<Vec<Line>, ImportError> {
    let grey = decode(bytes, format)?;
    let mut ink = ink(&grey)?;
    let area = ink.dark().count();
    ink.thin();
    let width = area as f64 / ink.dark().count().max(1) as f64;
    let lines = trace::lines(&ink, width)?;
    if lines.is_empty() {
        return Err(ImportError::NoStrokes);
    }
    let upright = |mut line: Line| {
        line.points.iter_mut().for_each(|point| *point = DVec2::new(point.x, -point.y));
        line
    };
    Ok(lines.into_iter().map(upright).collect())
}

fn decode(bytes: &[u8], format: ImageFormat) -> Result<GrayImage, ImportError> {
    let unreadable = |error: image::ImageError| ImportError::Picture(error.to_string());
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MOST_PIXELS), Some(MOST_PIXELS));
    limits.max_alloc = Some(MOST_MEMORY);
    reader.limits(limits);
    let picture = reader.decode().map_err(unreadable)?;
    let longer = picture.width().max(picture.height());
    if longer == 0 {
        return Err(ImportError::Blank);
    }
    let picture =
        if longer > LONGEST { picture.resize(LONGEST, LONGEST, FilterType::Triangle) } else { picture };
    Ok(on_paper(&picture))
}

/// Grey, with transparent pixels white.
fn on_paper(picture: &DynamicImage) -> GrayImage {
    let pixels = picture.to_luma_alpha8();
    let over_white = |[grey, alpha]: [u8; 2]| {
        let (grey, alpha) = (u16::from(grey), u16::from(alpha));
        ((grey * alpha + 255 * (255 - alpha)) / 255) as u8
    };
    GrayImage::from_fn(pixels.width(), pixels.height(), |x, y| {
        image::Luma([over_white(pixels.get_pixel(x, y).0)])
    })
}

/// Separates paper and ink at the threshold with the largest variance between them (Otsu 1979).
fn ink(grey: &GrayImage) -> Result<Ink, ImportError> {
    let mut histogram = [0.0f64; 256];
    grey.pixels().for_each(|pixel| histogram[usize::from(pixel.0[0])] += 1.0);
    let total: f64 = histogram.iter().sum();
    let moment = |power: i32| {
        histogram.iter().enumerate().map(|(level, count)| (level as f64).powi(power) * count).sum::<f64>()
            / total
    };
    let (mean, variance) = (moment(1), moment(2) - moment(1).powi(2));
    let (mut below, mut sum, mut best) = (0.0, 0.0, (0.0, 0, 0.0, 0.0));
    for (level, count) in histogram.iter().enumerate().take(255) {
        below += count / total;
        sum += level as f64 * count / total;
        if below > 0.0 && below < 1.0 {
            let between = (mean * below - sum).powi(2) / (below * (1.0 - below));
            let contrast = (mean - sum) / (1.0 - below) - sum / below;
            if between > best.0 {
                best = (between, level, contrast, below);
            }
        }
    }
    let (between, threshold, contrast, covered) = best;
    if contrast < LEAST_CONTRAST {
        return Err(ImportError::Blank);
    }
    if between < LEAST_SEPARATION * variance {
        return Err(ImportError::NoStrokes);
    }
    // Strokes cover the smaller area: chalk on a board is a drawing, too.
    let is_chalk = covered > 0.5;
    let is_stroke = |pixel: &image::Luma<u8>| (usize::from(pixel.0[0]) <= threshold) != is_chalk;
    let strokes = grey.enumerate_pixels().filter(|(_, _, pixel)| is_stroke(pixel));
    let places = strokes.map(|(x, y, _)| (x as usize, y as usize));
    Ok(Ink::new(grey.width() as usize, grey.height() as usize, places))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dark where `is_dark` says so, as a PNG.
    fn png(width: u32, height: u32, grey: impl Fn(u32, u32) -> u8) -> Vec<u8> {
        let picture = GrayImage::from_fn(width, height, |x, y| image::Luma([grey(x, y)]));
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn of(width: u32, height: u32, is_dark: impl Fn(u32, u32) -> bool) -> Result<Vec<Line>, ImportError> {
        let grey = |x, y| if is_dark(x, y) { 20 } else { 250 };
        lines(&png(width, height, grey), ImageFormat::Png)
    }

    #[test]
    fn an_l_has_two_legs() {
        // Strokes of 7 pixels about x = 40 and y = 150.
        let is_dark = |x: u32, y: u32| {
            ((37..=43).contains(&x) && (20..=153).contains(&y))
                || ((147..=153).contains(&y) && (37..=120).contains(&x))
        };
        let lines = of(200, 200, is_dark).unwrap();
        let [l] = &lines[..] else { panic!("{lines:?}") };
        // The light margin moves everything by one pixel.
        let corner = DVec2::new(41.0, -151.0);
        for point in &l.points {
            let off = (point.x - corner.x).abs().min((point.y - corner.y).abs());
            assert!(off <= 1.0, "{point} is {off} pixels from both legs");
        }
        let ends = l.simplified(0.5).points;
        assert!(ends.len() == 3 && ends[1].distance(corner) < 0.5, "two legs and a corner: {ends:?}");
        assert!((l.length() - (130.0 + 80.0)).abs() < 10.0, "{}", l.length());
    }

    #[test]
    fn a_ring_closes_and_is_round() {
        let lines = of(300, 300, |x, y| {
            let r = DVec2::new(f64::from(x) - 150.0, f64::from(y) - 150.0).length();
            (96.0..=104.0).contains(&r)
        })
        .unwrap();
        let [ring] = &lines[..] else { panic!("{lines:?}") };
        assert!(ring.closed);
        for point in &ring.points {
            let r = point.distance(DVec2::new(151.0, -151.0));
            assert!((r - 100.0).abs() < 1.0, "{r}");
        }
        assert!((ring.length() / (std::f64::consts::TAU * 100.0) - 1.0).abs() < 0.01, "{}", ring.length());
    }

    #[test]
    fn a_cross_is_two_lines_and_a_t_is_two() {
        let bar = |x: u32, from: u32, to: u32| (from..=to).contains(&x);
        let cross =
            of(200, 200, |x, y| (bar(x, 97, 103) && bar(y, 20, 180)) || (bar(y, 97, 103) && bar(x, 20, 180)));
        let lengths: Vec<_> = cross.unwrap().iter().map(Line::length).collect();
        assert!(lengths.len() == 2 && lengths.iter().all(|l| (l - 155.0).abs() < 12.0), "{lengths:?}");
        let t =
            of(200, 200, |x, y| (bar(x, 97, 103) && bar(y, 20, 180)) || (bar(y, 20, 26) && bar(x, 20, 180)));
        assert_eq!(t.unwrap().len(), 2);
    }

    #[test]
    fn blank_pages_and_photographs_are_no_drawings() {
        assert_eq!(of(50, 50, |_, _| false), Err(ImportError::Blank));
        assert_eq!(of(50, 50, |_, _| true), Err(ImportError::Blank));
        let faint = png(50, 50, |x, _| 200 + (x % 3) as u8);
        assert_eq!(lines(&faint, ImageFormat::Png), Err(ImportError::Blank));
        let hills = png(200, 200, |x, y| {
            (100.0 + 50.0 * (f64::from(x) / 31.0).sin() + 45.0 * (f64::from(y) / 17.0).cos()) as u8
        });
        assert_eq!(lines(&hills, ImageFormat::Png), Err(ImportError::NoStrokes));
    }

    #[test]
    fn chalk_on_a_board_is_a_drawing_too() {
        let is_ring = |x: u32, y: u32| {
            let r = DVec2::new(f64::from(x) - 150.0, f64::from(y) - 150.0).length();
            (96.0..=104.0).contains(&r)
        };
        let chalk = png(300, 300, |x, y| if is_ring(x, y) { 250 } else { 20 });
        let ink = png(300, 300, |x, y| if is_ring(x, y) { 20 } else { 250 });
        let read = |bytes: &[u8]| lines(bytes, ImageFormat::Png).unwrap();
        assert_eq!(read(&chalk), read(&ink));
        assert_eq!(read(&chalk).len(), 1);
    }

    #[test]
    fn a_texture_is_no_drawing() {
        // Dots of three pixels, a third of the picture.
        let dots = of(900, 900, |x, y| x % 5 < 3 && y % 5 < 3);
        assert!(matches!(dots, Err(ImportError::NoStrokes | ImportError::TooManyLines(_))), "{dots:?}");
        let weave = of(900, 900, |x, y| x % 8 < 2 || y % 8 < 2);
        assert!(matches!(weave, Err(ImportError::TooManyLines(_))), "{:?}", weave.map(|lines| lines.len()));
    }

    #[test]
    fn a_large_picture_is_looked_at_in_small() {
        let lines = of(4000, 1200, |x, y| (590..=610).contains(&y) && (400..=3600).contains(&x)).unwrap();
        let [line] = &lines[..] else { panic!("{lines:?}") };
        assert!((line.length() - 800.0).abs() < 10.0, "{}", line.length());
    }
}
