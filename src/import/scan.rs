//! The strokes of a picture as polylines: upright and in small, its shades are those of a sheet, whose ink is traced.
//!
//! Transparent pictures have no paper. Where their visible pixels have one colour or are narrow strokes, alpha is the
//! ink, whatever their colours; other pictures lie on white.

use glam::DVec2;
use image::{DynamicImage, ImageBuffer, ImageFormat, Pixel, Rgba, Rgba32FImage};

use crate::import::ink::Ink;
use crate::import::paper::{self, Shades};
use crate::import::trace;
use crate::import::{ImportError, Line};
use crate::picture::upright;

/// Longer side in pixels of what is traced, to a factor of 1.5: larger pictures are reduced by a whole number.
const LONGER: u32 = 1000;
/// Alpha of visible pixels.
const VISIBLE: f32 = 0.1;
/// Standard deviation of a colour's channels, of 1, within one ink.
const ONE_COLOUR: f64 = 0.1;
/// Width of narrow strokes, of the longer side.
const NARROW: f64 = 0.06;

/// Lines with y upwards; a pixel of the reduced picture is the unit.
pub fn lines(bytes: &[u8], format: ImageFormat) -> Result<Vec<Line>, ImportError> {
    let unreadable = |error: image::ImageError| ImportError::Picture(error.to_string());
    let (picture, orientation) = upright::decode(bytes, format).map_err(unreadable)?;
    if picture.width() == 0 || picture.height() == 0 {
        return Err(ImportError::Blank);
    }
    let mut picture = DynamicImage::ImageRgba32F(in_small(picture));
    picture.apply_orientation(orientation);
    let mut ink = paper::ink(&shades(&picture.into_rgba32f()))?;
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

/// Means of squares of pixels, with colours multiplied by alpha, which makes them means of light.
fn in_small(picture: DynamicImage) -> Rgba32FImage {
    match picture {
        DynamicImage::ImageLuma8(pixels) => means(&pixels),
        DynamicImage::ImageLumaA8(pixels) => means(&pixels),
        DynamicImage::ImageRgb8(pixels) => means(&pixels),
        other => means(&other.into_rgba8()),
    }
}

fn means<P: Pixel<Subpixel = u8>>(pixels: &ImageBuffer<P, Vec<u8>>) -> Rgba32FImage {
    let (width, height) = pixels.dimensions();
    let factor = ((width.max(height) + LONGER / 2) / LONGER).max(1);
    let (columns, rows) = (width.div_ceil(factor), height.div_ceil(factor));
    let mut small = Rgba32FImage::new(columns, rows);
    let mut sums = vec![[0u32; 4]; columns as usize];
    let row_length = width as usize * usize::from(P::CHANNEL_COUNT);
    let mut stored = pixels.as_raw().chunks_exact(row_length);
    for row in 0..rows {
        let lines = factor.min(height - row * factor);
        sums.fill([0; 4]);
        for line in stored.by_ref().take(lines as usize) {
            let squares = line.chunks(factor as usize * usize::from(P::CHANNEL_COUNT));
            for (sum, square) in sums.iter_mut().zip(squares) {
                for pixel in square.chunks_exact(usize::from(P::CHANNEL_COUNT)) {
                    let [r, g, b, alpha] = P::from_slice(pixel).to_rgba().0.map(u32::from);
                    let own = [r * alpha, g * alpha, b * alpha, 255 * alpha];
                    sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
                }
            }
        }
        for (column, sum) in (0..columns).zip(&sums) {
            let count = lines * factor.min(width - column * factor);
            let scale = 1.0 / (255.0 * 255.0 * count as f32);
            small.put_pixel(column, row, Rgba(sum.map(|sum| sum as f32 * scale)));
        }
    }
    small
}

/// Shades on a white sheet, from colours that are multiplied by their alpha.
fn shades(picture: &Rgba32FImage) -> Shades {
    let is_ink = alpha_is_ink(picture);
    let extremes = |&Rgba([r, g, b, alpha]): &Rgba<f32>| {
        let sheet = 1.0 - alpha;
        if is_ink { (sheet, sheet) } else { (r.min(g).min(b) + sheet, r.max(g).max(b) + sheet) }
    };
    let (darkest, lightest) = picture.pixels().map(extremes).unzip();
    Shades { width: picture.width() as usize, darkest, lightest }
}

/// Whether alpha varies, and the visible pixels have one colour or are narrow strokes.
fn alpha_is_ink(picture: &Rgba32FImage) -> bool {
    if picture.pixels().all(|pixel| pixel.0[3] >= 1.0 - VISIBLE) {
        return false;
    }
    let visible = || picture.pixels().filter(|pixel| pixel.0[3] >= VISIBLE);
    let sum = |value: &dyn Fn(&Rgba<f32>) -> f32| visible().map(|pixel| f64::from(value(pixel))).sum::<f64>();
    let weight = sum(&|pixel| pixel.0[3]);
    let is_one_colour = (0..3).all(|channel| {
        let mean = sum(&|pixel| pixel.0[channel]) / weight;
        let square = sum(&|pixel| pixel.0[channel].powi(2) / pixel.0[3]) / weight;
        square - mean.powi(2) < ONE_COLOUR.powi(2)
    });
    let (width, height) = picture.dimensions();
    let places = picture.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[3] >= VISIBLE);
    let visible = Ink::new(width as usize, height as usize, places.map(|(x, y, _)| (x as usize, y as usize)));
    is_one_colour || visible.stroke_width() < NARROW * f64::from(width.max(height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, GrayImage, ImageEncoder, RgbaImage};
    use std::io::Cursor;

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

    /// Light on an L from (90, 70) to (90, 170) to (220, 170), of which 9 pixels are dark.
    fn l_in_light(light: impl Fn(f64, f64) -> f64, [paper, ink]: [f64; 2]) -> Result<Vec<Line>, ImportError> {
        let bytes = png(300, 240, |x, y| {
            let at = DVec2::new(f64::from(x), f64::from(y));
            let legs =
                Line::new([(90.0, 70.0), (90.0, 170.0), (220.0, 170.0)].map(DVec2::from).into(), false);
            let grain = f64::from((x * 7919 + y * 104_729) % 13) / 13.0 - 0.5;
            let shade = if legs.distance(at) <= 4.5 { ink } else { paper };
            (shade * light(at.x / 300.0, at.y / 240.0) + 8.0 * grain).clamp(0.0, 255.0) as u8
        });
        lines(&bytes, ImageFormat::Png)
    }

    #[test]
    fn light_and_shadow_leave_an_l() {
        let table = |x: f64, y: f64| if (x - 0.5).abs() < 0.42 && (y - 0.5).abs() < 0.42 { 1.0 } else { 0.4 };
        let hand = |x: f64, y: f64| 1.0 - 0.6 * ((0.7 - (x - 1.0).hypot(y - 1.0)) * 8.0).clamp(0.0, 1.0);
        type Light<'a> = &'a dyn Fn(f64, f64) -> f64;
        let lights: [Light<'_>; 6] = [
            &|_, _| 1.0,
            &|x, _| 1.0 - 0.7 * x,
            &|x, y| 0.3 + 0.35 * (x + y),
            &|x, y| (-3.0 * ((x - 0.5).powi(2) + (y - 0.5).powi(2))).exp(),
            &hand,
            &table,
        ];
        for (number, light) in lights.iter().enumerate() {
            for shades in [[235.0, 40.0], [225.0, 150.0], [60.0, 225.0]] {
                // A board on a table is darker than both.
                if number == 5 && shades[0] < shades[1] {
                    continue;
                }
                let lines = l_in_light(light, shades).unwrap();
                let [l] = &lines[..] else { panic!("{number} {shades:?}: {lines:?}") };
                let true_l = [(91.0, -71.0), (91.0, -171.0), (221.0, -171.0)].map(DVec2::from);
                let true_l = Line::new(true_l.into(), false);
                let off = |a: &Line, b: &Line| a.points.iter().map(|&at| b.distance(at)).fold(0.0, f64::max);
                let off = off(l, &true_l).max(off(&true_l, l));
                assert!(off < 5.0, "{number} {shades:?}: {off} pixels of {l:?}");
            }
        }
    }

    #[test]
    fn light_alone_is_no_drawing() {
        for light in [|x: f64, _: f64| 1.0 - 0.7 * x, |x: f64, y: f64| 1.0 - 0.5 * (x * y)] {
            assert_eq!(l_in_light(light, [235.0, 235.0]), Err(ImportError::Blank));
        }
    }

    #[test]
    fn alpha_is_ink_of_any_colour() {
        let is_l = |x: u32, y: u32| (20..=26).contains(&x) && y >= 10 || (100..=106).contains(&y) && x >= 20;
        let of = |colour: &dyn Fn(u32, u32) -> [u8; 4]| {
            let picture = RgbaImage::from_fn(160, 120, |x, y| {
                let [r, g, b, alpha] = colour(x, y);
                Rgba([r, g, b, if is_l(x, y) && x < 140 && y < 110 { alpha } else { 0 }])
            });
            let mut bytes = Cursor::new(Vec::new());
            picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
            lines(&bytes.into_inner(), ImageFormat::Png).unwrap()
        };
        let black = of(&|_, _| [0, 0, 0, 255]);
        assert_eq!(black.len(), 1);
        for colour in [[255, 255, 255, 255], [255, 230, 0, 255], [128, 128, 128, 128], [255, 255, 255, 90]] {
            assert_eq!(of(&|_, _| colour), black, "{colour:?}");
        }
        assert_eq!(of(&|x, _| [x as u8, 255 - x as u8, 255, 255]), black, "many colours");
    }

    #[test]
    fn a_card_without_surroundings_is_paper() {
        // White and opaque with a black bar, transparent around.
        let picture = RgbaImage::from_fn(200, 120, |x, y| match (x, y) {
            (0..8 | 192.., _) | (_, 0..8 | 112..) => Rgba([0; 4]),
            (40..160, 57..64) => Rgba([0, 0, 0, 255]),
            _ => Rgba([255; 4]),
        });
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let lines = lines(&bytes.into_inner(), ImageFormat::Png).unwrap();
        assert!(lines.len() == 1 && (lines[0].length() - 114.0).abs() < 6.0, "{lines:?}");
    }

    #[test]
    fn a_drawing_is_upright() {
        let l = |x: u32, y: u32| if (20..=25).contains(&x) || (y >= 90 && x > 20) { 10 } else { 240 };
        let picture = GrayImage::from_fn(140, 96, |x, y| image::Luma([l(x, y)]));
        let read = |stored: &GrayImage, note: u8| {
            let mut bytes = Vec::new();
            let mut encoder = PngEncoder::new(&mut bytes);
            encoder.set_exif_metadata(upright::note(note)).unwrap();
            let (width, height) = stored.dimensions();
            encoder.write_image(stored, width, height, ExtendedColorType::L8).unwrap();
            lines(&bytes, ImageFormat::Png).unwrap()
        };
        let plain = read(&picture, 1);
        for note in 2..=8 {
            let stored = upright::stored(&picture, note);
            let size = |lines: &[Line]| {
                let points = || lines.iter().flat_map(|line| line.points.iter().copied());
                points().reduce(DVec2::max).unwrap() - points().reduce(DVec2::min).unwrap()
            };
            let lines = read(&stored, note);
            assert!(size(&lines).distance(size(&plain)) < 1e-9, "{note}: {lines:?}");
            let corner =
                |lines: &[Line]| lines[0].points.iter().map(|at| at.x + at.y).fold(f64::INFINITY, f64::min);
            assert!((corner(&lines) - corner(&plain)).abs() < 1e-9, "{note}");
        }
    }
}
