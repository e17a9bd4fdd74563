//! Charts of measurements: points and lines on logarithmic axes.

use crate::picture::figure::mark::{Anchor, Ink, Mark};
use crate::picture::figure::{Figure, svg};
use crate::picture::{Picture, PictureError};

const SIZE: [usize; 2] = [1200, 800];
/// Letters stay readable when a page scales the chart down.
const SVG_SIZE: [usize; 2] = [900, 600];
/// Width of the column that names the series.
const LEGEND: f64 = 230.0;
/// Margins of the plot without title and legend.
const LEFT: f64 = 120.0;
const MARGIN: f64 = 20.0;
const BELOW: f64 = 80.0;
/// Heights of letters.
const TITLE: f64 = 20.0;
const LABEL: f64 = 16.5;
const NAME: f64 = 15.0;
const NUMBER: f64 = 14.0;
const INK: Ink = [30, 30, 34];
const FAINT: Ink = [225, 225, 230];
/// Colours that stay apart for most eyes: those of Okabe and Ito, and two more.
const COLOURS: [Ink; 9] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [90, 90, 90],
    [110, 60, 160],
    [130, 80, 30],
];

/// Replacements of an SVG's colours on a dark page.
const ON_DARK: [(Ink, &str); 9] = [
    (INK, "#e4e4e8"),
    (FAINT, "#30333c"),
    (COLOURS[0], "#3d86e6"),
    (COLOURS[1], "#f07a28"),
    (COLOURS[2], "#26b88f"),
    (COLOURS[4], "#8ed6f8"),
    (COLOURS[6], "#b4b4bc"),
    (COLOURS[7], "#b095e8"),
    (COLOURS[8], "#c79a62"),
];

/// The content of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    /// Series without points are left out.
    pub series: Vec<Series>,
    pub levels: Vec<Level>,
}

/// A dashed line across the chart, for values without an x.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    pub name: String,
    /// A positive number.
    pub y: f64,
}

/// Points that belong together, joined in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub name: String,
    /// Positive numbers from 1e-30 to 1e30; others are left out, to limit the ticks.
    pub points: Vec<(f64, f64)>,
}

impl Chart {
    /// The chart as a picture of 1200 x 800 pixels.
    ///
    /// # Errors
    /// An empty chart.
    pub fn draw(&self) -> Result<Picture, PictureError> {
        self.figure(SIZE, &self.title)?.picture()
    }

    /// The chart as an SVG element of 900 x 600 units without a title, which the page sets.
    ///
    /// # Errors
    /// An empty chart.
    pub fn svg(&self) -> Result<String, PictureError> {
        svg::element(&self.figure(SVG_SIZE, "")?)
    }

    /// The unit of its marks is a pixel.
    fn figure(&self, pixels: [usize; 2], title: &str) -> Result<Figure, PictureError> {
        let all = || self.series.iter().flat_map(Series::drawable);
        let heights = all().map(|p| p.1).chain(self.drawn_levels().map(|level| level.y));
        let (Some(x), Some(y)) = (range(all().map(|p| p.0)), range(heights)) else {
            return Err(PictureError(format!("{}: there are no points", self.title)));
        };
        let [width, height] = pixels.map(|side| side as f64);
        let (right, bottom) = (width - LEGEND - MARGIN, height - BELOW);
        let top = if title.is_empty() { MARGIN } else { 2.5 * MARGIN };
        let across = |value: f64| LEFT + (right - LEFT) * part(value, x);
        let up = |value: f64| bottom - (bottom - top) * part(value, y);
        let mut marks = Vec::new();
        let centre = [(LEFT + right) / 2.0, (top + bottom) / 2.0];
        marks.push(Mark::text([centre[0], top - 12.0], TITLE, Anchor::Middle, INK, title));
        for tick in ticks(x) {
            let x = across(tick);
            marks.push(Mark::line([[x, top], [x, bottom]], 1.0, FAINT));
            marks.push(Mark::line([[x, bottom], [x, bottom + 5.0]], 1.0, INK));
            marks.push(Mark::text([x, bottom + 21.0], NUMBER, Anchor::Middle, INK, &label(tick)));
        }
        for tick in ticks(y) {
            let y = up(tick);
            marks.push(Mark::line([[LEFT, y], [right, y]], 1.0, FAINT));
            marks.push(Mark::line([[LEFT - 5.0, y], [LEFT, y]], 1.0, INK));
            marks.push(Mark::text([LEFT - 10.0, y + 5.0], NUMBER, Anchor::End, INK, &label(tick)));
        }
        marks.push(Mark::line([[LEFT, top], [LEFT, bottom], [right, bottom]], 1.0, INK));
        marks.push(Mark::text([centre[0], bottom + 54.0], LABEL, Anchor::Middle, INK, &self.x_label));
        marks.push(Mark::turned_text([30.0, centre[1]], LABEL, INK, &self.y_label));
        let name = |y: f64, text: &str| Mark::text([right + 48.0, y + 5.0], NAME, Anchor::Start, INK, text);
        let mut place = 80.0;
        for (style, series) in self.drawn().enumerate() {
            let points: Vec<_> = series.drawable().map(|(x, y)| [across(x), up(y)]).collect();
            marks.push(Mark::line(points.clone(), 3.0, COLOURS[style % COLOURS.len()]));
            marks.extend(points.into_iter().map(|at| point(at, style)));
            marks.extend([point([right + 30.0, place], style), name(place, &series.name)]);
            place += 30.0;
        }
        for level in self.drawn_levels() {
            let y = up(level.y);
            let dashes = (0..((right - LEFT) / 14.0) as usize).map(|n| LEFT + 14.0 * n as f64);
            marks.extend(dashes.map(|x| Mark::line([[x, y], [x + 8.0, y]], 2.0, INK)));
            marks.push(Mark::line([[right + 22.0, place], [right + 38.0, place]], 2.0, INK));
            marks.push(name(place, &level.name));
            place += 30.0;
        }
        Ok(Figure { pixels, density: 1.0, title: String::new(), marks })
    }

    fn drawn(&self) -> impl Iterator<Item = &Series> {
        self.series.iter().filter(|series| series.drawable().next().is_some())
    }

    fn drawn_levels(&self) -> impl Iterator<Item = &Level> {
        self.levels.iter().filter(|level| is_drawable(level.y))
    }
}

impl Series {
    fn drawable(&self) -> impl Iterator<Item = (f64, f64)> {
        self.points.iter().copied().filter(|&(x, y)| is_drawable(x) && is_drawable(y))
    }
}

/// Whether an axis can show this number.
fn is_drawable(number: f64) -> bool {
    (1e-30..=1e30).contains(&number)
}

/// Style rules for [`Chart::svg`] on a dark page with the colour `--ground`.
pub fn dark_style() -> String {
    let rule = |(light, dark): (String, &str)| {
        format!("svg [fill=\"{light}\"] {{ fill: {dark} }} svg [stroke=\"{light}\"] {{ stroke: {dark} }}\n")
    };
    let inks = ON_DARK.map(|(ink, dark)| (svg::colour(ink), dark));
    inks.into_iter().chain([(svg::PAPER.to_owned(), "var(--ground)")]).map(rule).collect()
}

/// A point of a series. When colours repeat, triangles replace discs.
fn point([x, y]: [f64; 2], style: usize) -> Mark {
    let ink = COLOURS[style % COLOURS.len()];
    if style < COLOURS.len() {
        return Mark::Disc { centre: [x, y], radius: 6.0, ink };
    }
    let points = vec![[x, y - 6.0], [x + 5.5, y + 3.5], [x - 5.5, y + 3.5]];
    Mark::Line { points, is_closed: true, width: 3.0, ink }
}

/// Position of a value between the ends of a logarithmic axis.
fn part(value: f64, (low, high): (f64, f64)) -> f64 {
    (value / low).ln() / (high / low).ln()
}

/// Range from a little below the smallest value to a little above the largest.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    (low <= high).then_some((low / 1.5, high * 1.5))
}

/// Powers of ten, with intermediate numbers if there is room.
fn ticks((low, high): (f64, f64)) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let decades = high.log10() - low.log10();
    let between: &[f64] = match decades {
        ..1.0 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        1.0..3.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    // Beyond a dozen decades every third is enough.
    let every = if decades > 12.0 { 3 } else { 1 };
    (first..=last)
        .filter(|power| power.rem_euclid(every) == 0)
        .flat_map(|power| between.iter().map(move |digit| digit * 10f64.powi(power)))
        .filter(|tick| (low..=high).contains(tick))
        .collect()
}

/// Three digits distinguish ticks; more are rounding errors.
fn label(value: f64) -> String {
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    if (0.01..100_000.0).contains(&rounded) { format!("{rounded}") } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        let labels = [0.300_000_000_000_000_04, 9.999_999_999_999_999e-6, 1000.0].map(label);
        assert_eq!(labels, ["0.3", "1e-5", "1000"]);
    }

    #[test]
    fn every_range_has_some_ticks_and_none_too_many() {
        // The content spans at least the margin on both sides.
        for (low, high) in [(1.2, 2.7), (2.1, 8.5), (0.7, 30.0), (3.0, 4e3), (1e-7, 1e-2), (1e-17, 1.0)] {
            let ticks = ticks((low, high));
            assert!((2..=12).contains(&ticks.len()), "{low} to {high}: {ticks:?}");
            assert!(ticks.iter().all(|tick| (low..=high).contains(tick)), "{low} to {high}: {ticks:?}");
        }
    }

    #[test]
    fn points_are_drawn_and_nothing_is_an_error() {
        let mut chart = Chart {
            title: "time".to_owned(),
            x_label: "pixels".to_owned(),
            y_label: "ms".to_owned(),
            series: vec![Series {
                name: "one".to_owned(),
                points: vec![(1.0, 2.0), (100.0, 5.0), (0.0, 1.0), (f64::NAN, 1.0)],
            }],
            levels: Vec::new(),
        };
        let picture = chart.draw().unwrap();
        let blue = picture.rgba.as_chunks::<4>().0.iter().filter(|c| **c == [0, 114, 178, 255]).count();
        assert!(blue > 500, "{blue} pixels of the first colour");
        let svg = chart.svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.matches("<circle").count() == 3, "{svg}");
        chart.series[0].points.clear();
        assert!(chart.draw().is_err());
    }
}
