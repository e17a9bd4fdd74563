//! Labels of 3D pictures: names of axes, lines of text, and a colour bar.

use glam::DVec2;

use crate::picture::Picture;
use crate::picture::figure::layout::CAPITAL;
use crate::picture::figure::mark::{Anchor, Ink, Mark};
use crate::picture::figure::raster::draw_on;

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
    pub fn write(&self, picture: &mut Picture) {
        let (ink, ground): (Ink, Ink) =
            if self.is_light { ([32, 33, 38], [244, 245, 248]) } else { ([232, 233, 238], [16, 16, 20]) };
        let faint = mixed(ink, ground, 0.62);
        let (width, height, scale) = (picture.width as f64, picture.height as f64, self.scale);
        let mut marks = Vec::new();
        let mut top = 16.0;
        for (index, line) in self.lines.iter().enumerate() {
            let (em, ink) = if index == 0 { (15.7, ink) } else { (11.15, faint) };
            let at = [18.0 * scale, (top + 0.6 * em) * scale];
            marks.push(Mark::text(at, em * scale, Anchor::Start, ink, line));
            top += 1.815 * em;
        }
        // With an outline in the ground's colour for contrast.
        let rim = (1.5 * scale).ceil();
        for (at, text) in &self.labels {
            let around = (0..9).map(|i| [f64::from(i % 3 - 1) * rim, f64::from(i / 3 - 1) * rim]);
            let em = 10.75 * scale;
            for [x, y] in around.filter(|by| *by != [0.0, 0.0]).chain([[0.0, 0.0]]) {
                let ink = if [x, y] == [0.0, 0.0] { mixed(ink, ground, 0.85) } else { ground };
                let at = [at.x + x, at.y + y + em * CAPITAL / 2.0];
                marks.push(Mark::text(at, em, Anchor::Middle, ink, text));
            }
        }
        if let Some(bar) = &self.bar {
            let tall = (0.42 * height).max(40.0 * scale);
            let (right, bottom) = (width - EDGE * scale, height - EDGE * scale);
            let (left, wide, em) = (right - BAR * scale, BAR * scale, 10.33 * scale);
            for (step, &[r, g, b, _]) in bar.table.iter().enumerate() {
                let low = bottom - tall * step as f64 / 256.0;
                let (corner, size) = ([left, low - tall / 256.0], [wide, tall / 256.0 + 0.5]);
                marks.push(Mark::Block { corner, size, ink: [r, g, b] });
            }
            marks.push(Mark::frame([left, bottom - tall], [wide, tall], 1.0, mixed(ink, ground, 0.5)));
            for (part, text) in &bar.ticks {
                let y = bottom - tall * part;
                marks.push(Mark::line([[left - 4.0 * scale, y], [left, y]], 1.0, faint));
                let at = [left - 8.0 * scale, y + em * CAPITAL / 2.0];
                marks.push(Mark::text(at, em, Anchor::End, faint, text));
            }
            if let Some(part) = bar.mark {
                let y = bottom - tall * part;
                marks.push(Mark::line([[left, y], [right, y]], (1.6 * scale).floor().max(1.0), ink));
            }
            let at = [right, bottom - tall - 8.0 * scale - 0.37 * em];
            marks.push(Mark::text(at, em, Anchor::End, faint, &bar.title));
        }
        draw_on(picture, &marks);
    }
}

/// A part of one colour over another.
fn mixed(ink: Ink, ground: Ink, part: f64) -> Ink {
    let channel = |n: usize| part * f64::from(ink[n]) + (1.0 - part) * f64::from(ground[n]);
    std::array::from_fn(|n| channel(n).round() as u8)
}
