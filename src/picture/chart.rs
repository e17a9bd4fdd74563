//! Charts of measurements: points and lines on logarithmic axes.

use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;

use crate::picture::lettering::Lettered;
use crate::picture::{Picture, PictureError};

const SIZE: (u32, u32) = (1200, 800);
/// Letters stay readable when a page scales the chart down.
const SVG_SIZE: (u32, u32) = (900, 600);
/// Width of the column that names the series.
const LEGEND: u32 = 230;
const INK: RGBColor = RGBColor(30, 30, 34);
const FAINT: RGBColor = RGBColor(225, 225, 230);
/// Colours that stay apart for most eyes: those of Okabe and Ito, and two more.
const COLOURS: [RGBColor; 9] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(90, 90, 90),
    RGBColor(110, 60, 160),
    RGBColor(130, 80, 30),
];

/// Replacements of an SVG's colours on a dark page.
const ON_DARK: [(RGBColor, &str); 10] = [
    (WHITE, "var(--ground)"),
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
        let (width, height) = SIZE;
        let mut rgb = vec![255; (width * height * 3) as usize];
        self.draw_on(Lettered::on(&mut rgb, SIZE), &self.title)?;
        let rgba = rgb.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        Ok(Picture { width: width as usize, height: height as usize, rgba })
    }

    /// The chart as an SVG element of 900 x 600 pixels without a title, which the page sets.
    ///
    /// # Errors
    /// An empty chart.
    pub fn svg(&self) -> Result<String, PictureError> {
        let mut svg = String::new();
        self.draw_on(SVGBackend::with_string(&mut svg, SVG_SIZE), "")?;
        Ok(svg)
    }

    fn draw_on<B: DrawingBackend>(&self, backend: B, title: &str) -> Result<(), PictureError> {
        let root = backend.into_drawing_area();
        root.fill(&WHITE)?;
        let (plot, legend) = root.split_horizontally(root.dim_in_pixel().0 - LEGEND);
        self.draw_plot(&plot, title)?;
        let mut place = (10, 80);
        for (style, series) in self.drawn().enumerate() {
            mark(&legend, place, style)?;
            legend.draw(&Text::new(series.name.clone(), (place.0 + 18, place.1 - 9), text(18.0)))?;
            place.1 += 30;
        }
        for level in self.drawn_levels() {
            let line = [(place.0 - 8, place.1), (place.0 + 8, place.1)];
            legend.draw(&PathElement::new(line, INK.stroke_width(2)))?;
            legend.draw(&Text::new(level.name.clone(), (place.0 + 18, place.1 - 9), text(18.0)))?;
            place.1 += 30;
        }
        root.present()?;
        Ok(())
    }

    fn draw_plot<B: DrawingBackend>(
        &self,
        plot: &DrawingArea<B, Shift>,
        title: &str,
    ) -> Result<(), PictureError> {
        let all = || self.series.iter().flat_map(Series::drawable);
        let heights = all().map(|p| p.1).chain(self.drawn_levels().map(|level| level.y));
        let (Some(x), Some(y)) = (range(all().map(|p| p.0)), range(heights)) else {
            return Err(PictureError(format!("{}: there are no points", self.title)));
        };
        let mut chart = ChartBuilder::on(plot)
            .caption(title, text(24.0))
            .margin(20)
            .x_label_area_size(60)
            .y_label_area_size(100)
            .build_cartesian_2d(
                (x.0..x.1).log_scale().with_key_points(ticks(x)),
                (y.0..y.1).log_scale().with_key_points(ticks(y)),
            )?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .axis_style(INK)
            .label_style(text(17.0))
            .axis_desc_style(text(20.0))
            .bold_line_style(FAINT)
            .light_line_style(WHITE)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .draw()?;
        for level in self.drawn_levels() {
            let line = [(x.0, level.y), (x.1, level.y)];
            chart.draw_series(DashedLineSeries::new(line, 8, 6, INK.stroke_width(2)))?;
        }
        for (style, series) in self.drawn().enumerate() {
            let points: Vec<_> = series.drawable().collect();
            chart.draw_series(LineSeries::new(points.iter().copied(), colour(style).stroke_width(3)))?;
            for point in points {
                // The plot has the backend's origin.
                mark(plot, chart.backend_coord(&point), style)?;
            }
        }
        Ok(())
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
    let rule = |(RGBColor(r, g, b), dark): (RGBColor, &str)| {
        let light = format!("#{r:02X}{g:02X}{b:02X}");
        format!("svg [fill=\"{light}\"] {{ fill: {dark} }} svg [stroke=\"{light}\"] {{ stroke: {dark} }}\n")
    };
    ON_DARK.into_iter().map(rule).collect()
}

fn text(size: f64) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

fn colour(style: usize) -> RGBColor {
    COLOURS[style % COLOURS.len()]
}

/// A point of a series. When colours repeat, triangles replace circles.
fn mark<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    at: (i32, i32),
    style: usize,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let filled = colour(style).filled();
    if style < COLOURS.len() {
        area.draw(&Circle::new(at, 6, filled))
    } else {
        area.draw(&TriangleMarker::new(at, 8, filled))
    }
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
fn label(value: &f64) -> String {
    let rounded = format!("{value:.2e}").parse().unwrap_or(*value);
    if (0.01..100_000.0).contains(&rounded) { format!("{rounded}") } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        let labels = [0.300_000_000_000_000_04, 9.999_999_999_999_999e-6, 1000.0].map(|tick| label(&tick));
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
