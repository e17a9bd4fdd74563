//! The polar chart of a beam pattern: levels around a half circle.

use crate::picture::figure::curve::INKS;
use crate::picture::figure::layout::{CAPITAL, Frame, GAP, HAIRLINE, LABEL, NUMBER, Pen, Room, STROKE};
use crate::picture::figure::mark::{Anchor, BLACK, Ink, Mark};

const GRID: Ink = [205, 205, 210];
/// dB between circles.
const RINGS: f64 = 10.0;
/// Degrees between spokes.
const SPOKES: i32 = 30;
/// mm: space around the half circle for numbers.
const BESIDE: f64 = 5.5;
const ABOVE: f64 = NUMBER + GAP;
const BELOW: f64 = NUMBER + 2.5 * GAP;

/// Levels against angles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polar {
    /// dB in the middle; 0 dB is the outermost circle.
    pub floor: f64,
    /// Angles in degrees from the normal, which points up, and levels in dB.
    pub lines: Vec<Vec<(f64, f64)>>,
    pub names: Vec<String>,
}

impl Polar {
    pub(in crate::picture) fn room(&self) -> Room {
        Room { left: LABEL, right: LABEL, above: NUMBER / 2.0, below: 0.0 }
    }

    /// The height of a chart of this width, mm.
    pub(in crate::picture) fn height(&self, width: f64) -> f64 {
        (width / 2.0 - BESIDE).max(1.0) + ABOVE + BELOW
    }

    pub(in crate::picture) fn marks(&self, frame: &Frame) -> Vec<Mark> {
        let mut pen = Pen::new(frame);
        let [left, top, right, _] = frame.room();
        let radius = ((right - left) / 2.0 - BESIDE).max(1.0);
        let middle = [f64::midpoint(left, right), top + ABOVE + radius];
        let at = |degrees: f64, part: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            [middle[0] + radius * part * sin, middle[1] - radius * part * cos]
        };
        let part = |level: f64| (1.0 - level / self.floor).max(0.0);
        let circle = |part: f64| (-90..=90).map(|degrees| at(f64::from(degrees), part)).collect::<Vec<_>>();
        let rings = (-self.floor / RINGS).round() as i32;
        for ring in 0..rings {
            let level = -RINGS * f64::from(ring);
            let ink = if ring == 0 { BLACK } else { GRID };
            pen.line(&circle(part(level)), HAIRLINE, ink);
            // The levels are on the right half of the base line.
            let [x, y] = at(90.0, part(level));
            let text = if ring == 0 { "0 dB".to_owned() } else { format!("−{}", RINGS * f64::from(ring)) };
            pen.number([x, y + 1.8 * GAP + NUMBER * CAPITAL], Anchor::Middle, BLACK, &text);
        }
        for degrees in (-90..=90).step_by(SPOKES as usize) {
            let degrees = f64::from(degrees);
            let base = if degrees.abs() == 90.0 { BLACK } else { GRID };
            pen.line(&[at(degrees, 0.0), at(degrees, 1.0)], HAIRLINE, base);
            let text = format!("{}°", degrees.abs());
            let text = if degrees < 0.0 { format!("−{text}") } else { text };
            let [x, y] = at(degrees, 1.0);
            let (sin, cos) = degrees.to_radians().sin_cos();
            let anchor = match sin {
                sin if sin > 0.1 => Anchor::Start,
                sin if sin < -0.1 => Anchor::End,
                _ => Anchor::Middle,
            };
            let place = [x + GAP * sin, y - GAP * cos + NUMBER * CAPITAL * 0.5 * (1.0 - cos)];
            pen.number(place, anchor, BLACK, &text);
        }
        for (line, ink) in self.lines.iter().zip(INKS.iter().cycle()) {
            let points: Vec<_> = line.iter().map(|&(degrees, level)| at(degrees, part(level))).collect();
            pen.line(&points, STROKE, *ink);
        }
        for (index, (name, ink)) in self.names.iter().zip(INKS.iter().cycle()).enumerate() {
            let y = top + NUMBER * CAPITAL + index as f64 * (NUMBER + 0.6 * GAP);
            pen.number([left, y], Anchor::Start, *ink, name);
        }
        pen.list
    }
}
