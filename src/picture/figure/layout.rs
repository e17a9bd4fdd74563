//! Plots with axes and a colour bar, and the map among them.

use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::field::contour::Line;
use crate::picture::Picture;
use crate::picture::figure::axes::{round_step, steps};
use crate::picture::figure::font;
use crate::picture::figure::mark::{Anchor, BLACK, Ink, Mark};

/// Heights of letters, mm: 9, 8 and 7 points.
pub const TITLE: f64 = 3.175;
pub const LABEL: f64 = 2.82;
pub const NUMBER: f64 = 2.47;
/// mm
pub const MARGIN: f64 = 1.0;
pub const GAP: f64 = 1.0;
const TICK: f64 = 0.9;
pub const HAIRLINE: f64 = 0.18;
pub const STROKE: f64 = 0.3;
/// Line width (mm) of bars that show a length.
pub const RULE: f64 = 0.6;
const BAR_WIDTH: f64 = 3.0;
const BAR_GAP: f64 = 2.5;
const FOCUS_RADIUS: f64 = 0.8;
/// Height of capitals and figures over that of the letters' em.
pub const CAPITAL: f64 = 0.727;
/// mm from one number on an axis to the next, about.
const SPACING: f64 = 10.0;
const BAR_SPACING: f64 = 8.0;
/// Space for numbers beside a colour bar, fixed so that figures of one size align.
const NUMBERS: &str = "0000";

/// The kinds of file that a figure is written as, by their endings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Format {
    #[default]
    Png,
    Svg,
    Pdf,
}

/// The size of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paper {
    /// Width of the whole figure, mm.
    pub width: f64,
    /// Dots per inch of the map and of the PNG.
    pub dpi: f64,
}

impl Default for Paper {
    /// A column of a journal.
    fn default() -> Self {
        Self { width: 85.0, dpi: 300.0 }
    }
}

/// An axis of the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// mm, at the first and the last edge.
    pub ends: [f64; 2],
    pub label: String,
}

/// A colour bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    pub table: [[u8; 4]; 256],
    /// The values of the first and the last colour.
    pub ends: [f64; 2],
    pub label: String,
    /// Explicit tick values instead of round ones.
    pub numbers: Option<Vec<(f64, String)>>,
    /// A value that a line across the bar marks.
    pub mark: Option<f64>,
}

/// The content of a map except its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Content {
    /// Axes to the right and upwards.
    pub axes: [Axis; 2],
    pub bar: Option<Bar>,
    /// Remark on what the colours do not show, in the map's upper left corner.
    pub remark: Option<String>,
    /// A scale bar in the map's lower left corner.
    pub has_scale_bar: bool,
    /// Lines of equal value in pixels of the map, as made by [`crate::field::contour`].
    pub contours: Vec<Line>,
    /// Outlines of targets, mm on the axes.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Arrows from tail to tip, mm on the axes.
    pub arrows: Vec<[[f64; 2]; 2]>,
    /// Focal points, mm on the axes.
    pub foci: Vec<[f64; 2]>,
    /// Measured lengths: end points in mm on the axes, and text.
    pub lengths: Vec<Length>,
    /// Whether ink must contrast with a light map.
    pub is_light: bool,
}

/// A measured length: its ends on the axes, and its text.
pub type Length = ([[f64; 2]; 2], String);

/// Space around a plot for its axes and its bar, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::picture) struct Room {
    pub left: f64,
    pub right: f64,
    pub above: f64,
    pub below: f64,
}

impl Room {
    /// Around a plot with axes.
    pub(in crate::picture) fn of_axes([_, y]: &[Axis; 2], bar: Option<&Bar>) -> Self {
        // The numbers of the vertical axes depend on the height, which depends on their width; too many candidates
        // are harmless.
        let numbers = steps(y.ends[0], y.ends[1], 10.0);
        let widest = numbers.iter().map(|(_, text)| font::width(text, NUMBER)).fold(0.0, f64::max);
        let right = bar.map_or(font::width("100", NUMBER) / 2.0, |_| Self::of_bar());
        Self {
            left: LABEL + GAP + widest + GAP + TICK,
            right,
            above: NUMBER / 2.0,
            below: TICK + GAP + NUMBER + GAP + LABEL,
        }
    }

    /// The width of a colour bar with its numbers and label.
    pub(in crate::picture) fn of_bar() -> f64 {
        BAR_GAP + BAR_WIDTH + TICK + GAP + font::width(NUMBERS, NUMBER) + GAP + LABEL
    }
}

/// Position of a plot in pixels of the PNG.
#[derive(Clone, Copy, Debug)]
pub(in crate::picture) struct Frame {
    /// Pixels in a millimetre.
    pub density: f64,
    /// Left, top.
    pub corner: [usize; 2],
    pub map: [usize; 2],
}

impl Frame {
    /// Left and top, mm.
    pub(in crate::picture) fn corner(&self) -> [f64; 2] {
        self.corner.map(|pixels| pixels as f64 / self.density)
    }

    /// Width and height, mm.
    pub(in crate::picture) fn size(&self) -> [f64; 2] {
        self.map.map(|pixels| pixels as f64 / self.density)
    }

    /// Left, top, right, bottom, mm.
    pub(in crate::picture) fn room(&self) -> [f64; 4] {
        let ([left, top], [width, height]) = (self.corner(), self.size());
        [left, top, left + width, top + height]
    }

    /// Place of a point that is in mm on the axes.
    pub(in crate::picture) fn place(&self, [x, y]: &[Axis; 2], [u, v]: [f64; 2]) -> [f64; 2] {
        let ([left, top], [width, height]) = (self.corner(), self.size());
        [
            left + width * (u - x.ends[0]) / (x.ends[1] - x.ends[0]),
            top + height * (y.ends[1] - v) / (y.ends[1] - y.ends[0]),
        ]
    }
}

impl Content {
    /// Height over width.
    pub(in crate::picture) fn shape(&self) -> f64 {
        let [x, y] = [0, 1].map(|axis: usize| self.axes[axis].ends).map(|[low, high]| (high - low).max(1e-9));
        y / x
    }

    /// The map with its axes and its bar.
    pub(in crate::picture) fn marks(&self, frame: &Frame, map: Picture) -> Vec<Mark> {
        let mut pen = Pen::new(frame);
        pen.pixels(map);
        pen.drawn_on_the_map(self);
        pen.frame(BLACK);
        pen.axes(&self.axes);
        self.bar.iter().for_each(|bar| pen.bar(bar));
        pen.list
    }
}

impl Bar {
    /// Numbers beside a bar of this height (mm).
    fn ticks(&self, height: f64) -> Vec<(f64, String)> {
        let [low, high] = self.ends;
        self.numbers.clone().unwrap_or_else(|| steps(low, high, (height / BAR_SPACING).max(2.0)))
    }
}

/// The marks of a plot.
pub(in crate::picture) struct Pen<'a> {
    pub list: Vec<Mark>,
    frame: &'a Frame,
}

impl<'a> Pen<'a> {
    pub(in crate::picture) fn new(frame: &'a Frame) -> Self {
        Self { list: Vec::new(), frame }
    }

    /// The pixels of the plot.
    pub(in crate::picture) fn pixels(&mut self, picture: Picture) {
        let (corner, size) = (self.frame.corner(), self.frame.size());
        self.list.push(Mark::Pixels { corner, size, picture });
    }

    /// The line around the plot.
    pub(in crate::picture) fn frame(&mut self, ink: Ink) {
        self.list.push(Mark::frame(self.frame.corner(), self.frame.size(), HAIRLINE, ink));
    }

    pub(in crate::picture) fn line(&mut self, points: &[[f64; 2]], width: f64, ink: Ink) {
        self.list.push(Mark::line(points, width, ink));
    }

    pub(in crate::picture) fn number(&mut self, at: [f64; 2], anchor: Anchor, ink: Ink, text: &str) {
        self.list.push(Mark::text(at, NUMBER, anchor, ink, text));
    }

    pub(in crate::picture) fn axes(&mut self, [x, y]: &[Axis; 2]) {
        self.horizontal(x);
        self.vertical(y);
    }

    fn horizontal(&mut self, axis: &Axis) {
        let ([left, top], [width, height]) = (self.frame.corner(), self.frame.size());
        let [low, high] = axis.ends;
        let bottom = top + height;
        for (value, text) in steps(low, high, (width / SPACING).max(2.0)) {
            let x = left + width * (value - low) / (high - low);
            self.line(&[[x, bottom], [x, bottom + TICK]], HAIRLINE, BLACK);
            self.number([x, bottom + TICK + GAP + NUMBER * CAPITAL], Anchor::Middle, BLACK, &text);
        }
        let below = bottom + TICK + GAP + NUMBER + GAP + LABEL * CAPITAL;
        self.list.push(Mark::text([left + width / 2.0, below], LABEL, Anchor::Middle, BLACK, &axis.label));
    }

    fn vertical(&mut self, axis: &Axis) {
        let ([left, top], [_, height]) = (self.frame.corner(), self.frame.size());
        let [low, high] = axis.ends;
        let mut widest = 0.0f64;
        for (value, text) in steps(low, high, (height / SPACING).max(2.0)) {
            let y = top + height * (high - value) / (high - low);
            self.line(&[[left - TICK, y], [left, y]], HAIRLINE, BLACK);
            let at = [left - TICK - GAP, y + NUMBER * CAPITAL / 2.0];
            self.number(at, Anchor::End, BLACK, &text);
            widest = widest.max(font::width(&text, NUMBER));
        }
        self.upwards(left - TICK - GAP - widest - GAP - LABEL * 0.2, &axis.label);
    }

    /// The colour bar at the right of the plot.
    pub(in crate::picture) fn bar(&mut self, bar: &Bar) {
        let ([plot_left, top], [plot_width, height]) = (self.frame.corner(), self.frame.size());
        let density = self.frame.density;
        let on_grid = |mm: f64| (mm * density).round() / density;
        let (left, width) =
            (on_grid(plot_left + plot_width + BAR_GAP), on_grid(BAR_WIDTH).max(1.0 / density));
        let rows = self.frame.map[1];
        let columns = (width * density).round() as usize;
        let colour = |row: usize| bar.table[(rows - 1 - row) * 255 / (rows - 1).max(1)];
        let rgba = (0..rows).flat_map(|row| std::iter::repeat_n(colour(row), columns)).flatten().collect();
        let picture = Picture { width: columns, height: rows, rgba };
        self.list.push(Mark::Pixels { corner: [left, top], size: [width, height], picture });
        self.list.push(Mark::frame([left, top], [width, height], HAIRLINE, BLACK));
        let ([low, high], right) = (bar.ends, left + width);
        let y = |value: f64| top + height * (high - value) / (high - low);
        let mut widest = 0.0f64;
        for (value, text) in bar.ticks(height) {
            let y = y(value);
            self.line(&[[right, y], [right + TICK, y]], HAIRLINE, BLACK);
            let at = [right + TICK + GAP, y + NUMBER * CAPITAL / 2.0];
            self.number(at, Anchor::Start, BLACK, &text);
            widest = widest.max(font::width(&text, NUMBER));
        }
        if let Some(value) = bar.mark {
            self.line(&[[left - TICK, y(value)], [right + TICK, y(value)]], STROKE, BLACK);
        }
        self.upwards(right + TICK + GAP + widest + GAP + LABEL * 0.75, &bar.label);
    }

    /// A label along the plot's height, smaller if it is longer.
    fn upwards(&mut self, x: f64, label: &str) {
        let ([_, top], [_, height]) = (self.frame.corner(), self.frame.size());
        let letters = font::fitted(label, LABEL, height);
        self.list.push(Mark::turned_text([x, top + height / 2.0], letters, BLACK, label));
    }

    /// An arrow from tail to tip, a dot if it is short.
    fn arrow(&mut self, [tail, tip]: [[f64; 2]; 2], ink: Ink) {
        /// mm
        const SHORTEST: f64 = 0.4;
        /// Of the length.
        const HEAD: f64 = 0.36;
        let way = [tip[0] - tail[0], tip[1] - tail[1]];
        if way[0].hypot(way[1]) < SHORTEST {
            let centre = [f64::midpoint(tail[0], tip[0]), f64::midpoint(tail[1], tip[1])];
            return self.list.push(Mark::Disc { centre, radius: HAIRLINE, ink });
        }
        let wing =
            |side: f64| [tip[0] - HEAD * (way[0] - side * way[1]), tip[1] - HEAD * (way[1] + side * way[0])];
        self.line(&[tail, tip], HAIRLINE, ink);
        self.line(&[wing(0.5), tip, wing(-0.5)], HAIRLINE, ink);
    }

    /// Contours, targets and scale bar: ink on the map.
    fn drawn_on_the_map(&mut self, content: &Content) {
        let ink = if content.is_light { BLACK } else { [255; 3] };
        let density = self.frame.density;
        let ([left, top], [width, height]) = (self.frame.corner(), self.frame.size());
        for line in &content.contours {
            let place =
                |&[u, v]: &[f32; 2]| [left + f64::from(u) / density, top + height - f64::from(v) / density];
            let points: Vec<_> = line.iter().map(place).collect();
            self.line(&points, HAIRLINE, ink);
        }
        let place = |point| self.frame.place(&content.axes, point);
        let target_ink = if content.is_light { [0, 90, 181] } else { [120, 220, 255] };
        let room = self.frame.room();
        for outline in &content.outlines {
            let points: Vec<_> = outline.iter().map(|&point| place(point)).collect();
            for piece in clipped(&points, room) {
                self.line(&piece, STROKE, target_ink);
            }
        }
        for arrow in &content.arrows {
            self.arrow(arrow.map(place), ink);
        }
        for &focus in &content.foci {
            let [u, v] = place(focus);
            let ring: Vec<_> = (0..=36)
                .map(|step| f64::from(step) * std::f64::consts::TAU / 36.0)
                .map(|angle| [u + FOCUS_RADIUS * angle.cos(), v + FOCUS_RADIUS * angle.sin()])
                .collect();
            for piece in clipped(&ring, room) {
                self.line(&piece, STROKE, target_ink);
            }
        }
        for (ends, text) in &content.lengths {
            self.length(ends.map(place), text, ink, room);
        }
        if let Some(remark) = &content.remark {
            self.number([left + GAP, top + GAP + NUMBER * CAPITAL], Anchor::Start, ink, remark);
        }
        if content.has_scale_bar {
            let [low, high] = content.axes[0].ends;
            let span = high - low;
            let length = round_step(span / 8.0);
            let (from, base) = (left + 2.0, top + height - 2.0);
            let drawn = width * length / span;
            self.list.push(Mark::Block { corner: [from, base - RULE], size: [drawn, RULE], ink });
            let (at, text) = ([from + drawn / 2.0, base - 1.4], format!("{length} mm"));
            let anchor = if font::width(&text, NUMBER) > drawn { Anchor::Start } else { Anchor::Middle };
            let at = if anchor == Anchor::Start { [from, at[1]] } else { at };
            self.number(at, anchor, ink, &text);
        }
    }

    /// A measured length: a line between two ticks, and its number beyond the end at the right or above.
    pub(in crate::picture) fn length(&mut self, ends: [[f64; 2]; 2], text: &str, ink: Ink, room: [f64; 4]) {
        let [from, to] = ends;
        let along = [to[0] - from[0], to[1] - from[1]];
        let size = along[0].hypot(along[1]).max(1e-9);
        let across = [along[1] / size * TICK / 2.0, -along[0] / size * TICK / 2.0];
        let ticks = ends.map(|[x, y]| [[x - across[0], y - across[1]], [x + across[0], y + across[1]]]);
        for line in ticks.into_iter().chain([ends]) {
            for piece in clipped(&line, room) {
                self.line(&piece, HAIRLINE, ink);
            }
        }
        let is_across = along[0].abs() > along[1].abs();
        let ([x, y], anchor) = if is_across {
            let right = ends.into_iter().max_by(|a, b| a[0].total_cmp(&b[0])).unwrap_or(to);
            ([right[0] + GAP / 2.0, right[1] + NUMBER * CAPITAL / 2.0], Anchor::Start)
        } else {
            let top = ends.into_iter().min_by(|a, b| a[1].total_cmp(&b[1])).unwrap_or(to);
            ([top[0], top[1] - GAP / 2.0], Anchor::Middle)
        };
        let wide = font::width(text, NUMBER);
        let left = if is_across { x } else { x - wide / 2.0 };
        let fits = left >= room[0] && left + wide <= room[2] && y - NUMBER >= room[1] && y <= room[3];
        if fits {
            self.number([x, y], anchor, ink, text);
        }
    }
}

/// The pieces of a line within a rectangle (left, top, right, bottom).
pub(in crate::picture) fn clipped(points: &[[f64; 2]], room: [f64; 4]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut last = None;
    for pair in points.windows(2) {
        let Some([from, to]) = inside(pair[0], pair[1], room) else { continue };
        match pieces.last_mut() {
            Some(piece) if last == Some(from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
        last = Some(to);
    }
    pieces
}

/// The part of a straight line within a rectangle, after Liang and Barsky; none of a line from or to nowhere.
fn inside(from: [f64; 2], to: [f64; 2], [left, top, right, bottom]: [f64; 4]) -> Option<[[f64; 2]; 2]> {
    if from.iter().chain(&to).any(|place| place.is_nan()) {
        return None;
    }
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (axis, low, high) in [(0, left, right), (1, top, bottom)] {
        let (start, way) = (from[axis], to[axis] - from[axis]);
        if way == 0.0 {
            if start < low || start > high {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - start) / way, (high - start) / way);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    let at = |part: f64| match part {
        0.0 => from,
        1.0 => to,
        part => [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])],
    };
    (first <= last).then(|| [at(first), at(last)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_edge_of_the_map() {
        let room = [0.0, 0.0, 10.0, 10.0];
        let gap = clipped(&[[1.0, 1.0], [2.0, 2.0], [3.0, f64::NAN], [4.0, 4.0], [5.0, 5.0]], room);
        assert_eq!(gap, [[[1.0, 1.0], [2.0, 2.0]], [[4.0, 4.0], [5.0, 5.0]]]);
        let line = [[-5.0, 5.0], [5.0, 5.0], [5.0, 15.0], [8.0, 15.0], [8.0, 5.0]];
        let pieces = clipped(&line, room);
        assert_eq!(pieces, [vec![[0.0, 5.0], [5.0, 5.0], [5.0, 10.0]], vec![[8.0, 10.0], [8.0, 5.0]]]);
        assert!(clipped(&[[-1.0, -1.0], [-1.0, 11.0]], room).is_empty());
    }
}
