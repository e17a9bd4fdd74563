//! The plot of values along a line.

use crate::picture::figure::layout::{
    Axis, CAPITAL, Frame, GAP, HAIRLINE, Length, NUMBER, Pen, Room, STROKE, clipped,
};
use crate::picture::figure::mark::{Anchor, BLACK, Ink, Mark};

/// Height over width.
pub(in crate::picture) const SHAPE: f64 = 0.6;
const CURVE: Ink = [0, 114, 178];
const BAND: Ink = [150, 195, 222];
const FAINT: Ink = [150, 150, 156];
const DOT: Ink = [213, 94, 0];
/// Of several curves.
pub(in crate::picture) const INKS: [Ink; 4] = [CURVE, DOT, [0, 158, 115], [204, 121, 167]];
/// mm
const DOT_RADIUS: f64 = 0.35;

/// A curve with its axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    pub axes: [Axis; 2],
    /// On the axes.
    pub points: Vec<[f64; 2]>,
    /// Further curves.
    pub others: Vec<Vec<[f64; 2]>>,
    /// Names of the curves, in their colours; empty: none.
    pub names: Vec<String>,
    /// Readings beside the curve, on the axes.
    pub dots: Vec<[f64; 2]>,
    /// Lower and upper limits of what the points scatter by, if known.
    pub limits: Option<[Vec<[f64; 2]>; 2]>,
    /// Places on the axis to the right that a line marks.
    pub places: Vec<f64>,
    /// The width of a lobe.
    pub width: Option<Length>,
}

impl Curve {
    pub(in crate::picture) fn room(&self) -> Room {
        Room::of_axes(&self.axes, None)
    }

    pub(in crate::picture) fn marks(&self, frame: &Frame) -> Vec<Mark> {
        let mut pen = Pen::new(frame);
        let room @ [_, top, _, bottom] = frame.room();
        let mut lines = |points: &[[f64; 2]], width: f64, ink: Ink| {
            for piece in clipped(points, room) {
                pen.line(&piece, width, ink);
            }
        };
        for &place in &self.places {
            let [x, _] = frame.place(&self.axes, [place, 0.0]);
            lines(&[[x, top], [x, bottom]], HAIRLINE, FAINT);
        }
        let placed = |points: &[[f64; 2]]| -> Vec<_> {
            points.iter().map(|&point| frame.place(&self.axes, point)).collect()
        };
        for limit in self.limits.iter().flatten() {
            lines(&placed(limit), HAIRLINE, BAND);
        }
        for (points, ink) in std::iter::once(&self.points).chain(&self.others).zip(INKS.iter().cycle()) {
            lines(&placed(points), STROKE, *ink);
        }
        let [left, top, right, bottom] = room;
        let is_inside = |[x, y]: &[f64; 2]| (left..=right).contains(x) && (top..=bottom).contains(y);
        let dots = placed(&self.dots).into_iter().filter(is_inside);
        pen.list.extend(dots.map(|centre| Mark::Disc { centre, radius: DOT_RADIUS, ink: DOT }));
        if let Some((ends, text)) = &self.width {
            pen.length(ends.map(|end| frame.place(&self.axes, end)), text, BLACK, room);
        }
        for (index, (name, ink)) in self.names.iter().zip(INKS.iter().cycle()).enumerate() {
            let y = top + GAP + NUMBER * CAPITAL + index as f64 * (NUMBER + 0.6 * GAP);
            pen.number([right - GAP, y], Anchor::End, *ink, name);
        }
        pen.frame(BLACK);
        pen.axes(&self.axes);
        pen.list
    }
}
