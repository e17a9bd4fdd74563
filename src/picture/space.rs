//! Labels of 3D pictures: names of axes, lines of text, and a colour bar.

use glam::DVec2;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::picture::relief::on_picture;
use crate::picture::{Picture, PictureError};

/// The bar's width and its distance from the picture's edge, in points of the screen.
const BAR: f64 = 14.0;
const EDGE: f64 = 22.0;

/// All labels of a picture.
#[derive(Clone, Debug, Default)]
pub struct Words {
    /// Lines of text at the top, the first one larger.
    pub lines: Vec<String>,
    /// Centre of each label in pixels.
    pub labels: Vec<(DVec2, String)>,
    pub bar: Option<Bar>,
    pub is_light: bool,
    /// Pixels of a point of the screen.
    pub scale: f64,
}

/// A colour bar with its labels.
#[derive(Clone, Debug)]
pub struct Bar {
    pub table: [[u8; 4]; 256],
    /// Fractions of the peak with their labels.
    pub ticks: Vec<(f64, String)>,
    /// The fraction of the isosurface.
    pub mark: Option<f64>,
    pub title: String,
}

impl Words {
    /// Writes them on a picture.
    ///
    /// # Errors
    /// They cannot be set.
    pub fn write(&self, picture: &mut Picture) -> Result<(), PictureError> {
        let ink = if self.is_light { RGBColor(32, 33, 38) } else { RGBColor(232, 233, 238) };
        let faint = ink.mix(0.62);
        let (width, height, scale) = (picture.width as f64, picture.height as f64, self.scale);
        let font = |size: f64| ("sans-serif", size * scale).into_font();
        let middle = |h, v| Pos::new(h, v);
        on_picture(picture, |root| {
            let mut top = 16.0;
            for (index, line) in self.lines.iter().enumerate() {
                let size = if index == 0 { 19.0 } else { 13.5 };
                let colour = if index == 0 { ink.mix(1.0) } else { faint };
                let at = ((18.0 * scale) as i32, (top * scale) as i32);
                root.draw_text(line, &font(size).color(&colour), at)?;
                top += 1.5 * size;
            }
            // With an outline in the ground's colour for contrast.
            let ground = if self.is_light { RGBColor(244, 245, 248) } else { RGBColor(16, 16, 20) };
            let rim = (1.5 * scale).ceil() as i32;
            for (at, text) in &self.labels {
                let around =
                    (0..9).map(|i| ((i % 3 - 1) * rim, (i / 3 - 1) * rim)).filter(|by| *by != (0, 0));
                for (x, y) in around.chain([(0, 0)]) {
                    let colour = if (x, y) == (0, 0) { ink.mix(0.85) } else { ground.mix(0.9) };
                    let style = font(13.0).color(&colour).pos(middle(HPos::Center, VPos::Center));
                    root.draw_text(text, &style, (at.x as i32 + x, at.y as i32 + y))?;
                }
            }
            let Some(bar) = &self.bar else { return Ok(()) };
            let tall = (0.42 * height).max(40.0 * scale);
            let right = width - EDGE * scale;
            let (left, bottom) = (right - BAR * scale, height - EDGE * scale);
            for step in 0..256 {
                let [r, g, b, _] = bar.table[step];
                let low = bottom - tall * step as f64 / 256.0;
                let corners = [(left as i32, (low - tall / 256.0) as i32), (right as i32, low as i32)];
                root.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled()))?;
            }
            let corners = [(left as i32, (bottom - tall) as i32), (right as i32, bottom as i32)];
            root.draw(&Rectangle::new(corners, ink.mix(0.5)))?;
            let beside = font(12.5).color(&faint).pos(middle(HPos::Right, VPos::Center));
            for (part, text) in &bar.ticks {
                let y = (bottom - tall * part) as i32;
                root.draw(&PathElement::new([((left - 4.0 * scale) as i32, y), (left as i32, y)], faint))?;
                root.draw_text(text, &beside, ((left - 8.0 * scale) as i32, y))?;
            }
            if let Some(part) = bar.mark {
                let y = bottom - tall * part;
                let line = [(left as i32, y as i32), (right as i32, y as i32)];
                root.draw(&PathElement::new(line, ink.stroke_width((1.6 * scale) as u32)))?;
            }
            let title = font(12.5).color(&faint).pos(middle(HPos::Right, VPos::Bottom));
            root.draw_text(&bar.title, &title, (right as i32, (bottom - tall - 8.0 * scale) as i32))?;
            Ok(())
        })
    }
}
