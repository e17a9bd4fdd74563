//! The plot of a 3D picture: its pixels, with the labels of its box and a colour bar as text and lines.

use glam::DVec2;

use crate::picture::Picture;
use crate::picture::figure::font;
use crate::picture::figure::layout::{Bar, CAPITAL, Frame, GAP, NUMBER, Pen, Room};
use crate::picture::figure::mark::{Anchor, BLACK, Ink, Mark};

/// Space around a label's letters.
const RIM: f64 = 0.3;
/// Colours of letters and of what is behind them, on a dark and on a light ground.
const ON_DARK: [Ink; 2] = [[232, 233, 238], [16, 16, 20]];
const ON_LIGHT: [Ink; 2] = [[32, 33, 38], [244, 245, 248]];

/// The content of a 3D picture besides its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Space {
    /// Height over width.
    pub shape: f64,
    /// Middle of each label in pixels of the picture.
    pub labels: Vec<(DVec2, String)>,
    /// Description in the upper left corner.
    pub remark: String,
    pub bar: Option<Bar>,
    pub is_light: bool,
}

/// Pixels of a point of the screen, for labels with letters of a figure, if a millimetre has so many.
pub fn label_scale(pixels_per_mm: f64) -> f64 {
    /// Height of the screen's letters in points.
    const POINTS: f64 = 12.0;
    NUMBER * pixels_per_mm / POINTS
}

impl Space {
    pub(in crate::picture) fn room(&self) -> Room {
        Room { right: self.bar.as_ref().map_or(0.0, |_| Room::of_bar()), ..Room::default() }
    }

    pub(in crate::picture) fn marks(&self, frame: &Frame, picture: Picture) -> Vec<Mark> {
        let mut pen = Pen::new(frame);
        pen.pixels(picture);
        let [left, top, right, bottom] = frame.room();
        let [ink, ground] = if self.is_light { ON_LIGHT } else { ON_DARK };
        for (at, text) in &self.labels {
            let [x, y] = [left + at.x / frame.density, top + at.y / frame.density];
            let (wide, high) = (font::width(text, NUMBER) / 2.0 + RIM, NUMBER / 2.0);
            if x + wide < left || x - wide > right || y + high < top || y - high > bottom {
                continue;
            }
            let x = x.clamp(left + wide, (right - wide).max(left + wide));
            let y = y.clamp(top + high, (bottom - high).max(top + high));
            let (corner, size) = ([x - wide, y - high], [2.0 * wide, 2.0 * high]);
            pen.list.push(Mark::Block { corner, size, ink: ground });
            pen.number([x, y + NUMBER * CAPITAL / 2.0], Anchor::Middle, ink, text);
        }
        if !self.remark.is_empty() {
            let height = font::fitted(&self.remark, NUMBER, right - left - 2.0 * GAP);
            let at = [left + GAP, top + GAP + height * CAPITAL];
            pen.list.push(Mark::text(at, height, Anchor::Start, ink, &self.remark));
        }
        pen.frame(BLACK);
        self.bar.iter().for_each(|bar| pen.bar(bar));
        pen.list
    }
}
