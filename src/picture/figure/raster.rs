//! A figure as pixels: the map one to one, all else antialiased.

use png::{BitDepth, ColorType, PixelDimensions, Unit};
use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapMut, Rect, Stroke, Transform};
use ttf_parser::OutlineBuilder;

use crate::picture::figure::mark::{Anchor, Ink, Mark};
use crate::picture::figure::{Figure, font};
use crate::picture::{Picture, PictureError};

/// A PNG with its physical size.
///
/// # Errors
/// More pixels than a PNG can have.
pub fn png(figure: &Figure) -> Result<Vec<u8>, PictureError> {
    let failed = |error: png::EncodingError| PictureError(error.to_string());
    let picture = picture(figure)?;
    let rgb: Vec<u8> =
        picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width as u32, picture.height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let per_metre = (figure.density * 1e3).round() as u32;
    encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_metre, yppu: per_metre, unit: Unit::Meter }));
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&rgb).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

/// The same as a picture.
///
/// # Errors
/// More pixels than there is room for.
pub fn picture(figure: &Figure) -> Result<Picture, PictureError> {
    let [width, height] = figure.pixels;
    let mut page = Pixmap::new(width as u32, height as u32)
        .ok_or_else(|| PictureError(format!("{width} x {height} pixels are too many")))?;
    page.fill(tiny_skia::Color::WHITE);
    draw(&mut page.as_mut(), figure.density, &figure.marks);
    // The page is opaque, so premultiplication has no effect.
    Ok(Picture { width, height, rgba: page.take() })
}

/// Draws marks in pixels on an opaque picture.
pub(in crate::picture) fn draw_on(picture: &mut Picture, marks: &[Mark]) {
    let (width, height) = (picture.width as u32, picture.height as u32);
    if let Some(mut page) = PixmapMut::from_bytes(&mut picture.rgba, width, height) {
        draw(&mut page, 1.0, marks);
    }
}

fn draw(page: &mut PixmapMut<'_>, pixels_per_mm: f64, marks: &[Mark]) {
    let density = pixels_per_mm as f32;
    let to_pixels = Transform::from_scale(density, density);
    for mark in marks {
        match mark {
            Mark::Pixels { corner, picture, .. } => {
                copy(page, corner.map(|mm| (mm * pixels_per_mm).round() as usize), picture);
            }
            Mark::Disc { centre: [x, y], radius, ink } => {
                if let Some(path) = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32) {
                    page.fill_path(&path, &paint(*ink), FillRule::Winding, to_pixels, None);
                }
            }
            Mark::Line { points, is_closed, width, ink } => {
                let Some(path) = line(points, *is_closed) else { continue };
                let stroke = Stroke { width: *width as f32, line_join: LineJoin::Round, ..Stroke::default() };
                page.stroke_path(&path, &paint(*ink), &stroke, to_pixels, None);
            }
            Mark::Block { corner, size, ink } => {
                let [x, y] = corner.map(|mm| mm as f32);
                if let Some(rect) = Rect::from_xywh(x, y, size[0] as f32, size[1] as f32) {
                    page.fill_rect(rect, &paint(*ink), to_pixels, None);
                }
            }
            Mark::Text { at, height, anchor, is_turned, ink, text } => {
                let Some(path) = letters(text, *anchor) else { continue };
                let size = *height as f32 * density;
                let [x, y] = at.map(|mm| mm as f32 * density);
                // Ems upwards become pixels downwards; turned text runs upwards.
                let placed = match is_turned {
                    false => Transform::from_row(size, 0.0, 0.0, -size, x, y),
                    true => Transform::from_row(0.0, -size, -size, 0.0, x, y),
                };
                page.fill_path(&path, &paint(*ink), FillRule::Winding, placed, None);
            }
        }
    }
}

fn copy(page: &mut PixmapMut<'_>, [left, top]: [usize; 2], picture: &Picture) {
    let width = page.width() as usize;
    let rows = picture.rgba.chunks_exact(picture.width * 4);
    for (row, pixels) in rows.enumerate() {
        let at = ((top + row) * width + left) * 4;
        page.data_mut()[at..at + pixels.len()].copy_from_slice(pixels);
    }
}

fn paint([r, g, b]: Ink) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

fn line(points: &[[f64; 2]], is_closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (index, &[x, y]) in points.iter().enumerate() {
        match index {
            0 => builder.move_to(x as f32, y as f32),
            _ => builder.line_to(x as f32, y as f32),
        }
    }
    if is_closed {
        builder.close();
    }
    builder.finish()
}

/// The outlines of a text in ems, its anchor at the origin.
fn letters(text: &str, anchor: Anchor) -> Option<Path> {
    let width = font::width(text, 1.0);
    let mut x = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -width / 2.0,
        Anchor::End => -width,
    };
    let em = f32::from(font::face().units_per_em());
    let mut builder = PathBuilder::new();
    for character in text.chars() {
        let (glyph, advance) = font::glyph(character);
        font::outline(glyph, &mut Outline { builder: &mut builder, x: x as f32, em });
        x += advance;
    }
    builder.finish()
}

/// An outline on its way to a path.
struct Outline<'a> {
    builder: &'a mut PathBuilder,
    x: f32,
    em: f32,
}

impl Outline<'_> {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x / self.em, y / self.em)
    }
}

impl OutlineBuilder for Outline<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}
