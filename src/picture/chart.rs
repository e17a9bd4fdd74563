//! Charts of measurements: points and lines over logarithmic axes.

use plotters::prelude::*;

use crate::picture::{Picture, PictureError, register_font};

const SIZE: (u32, u32) = (1200, 800);
/// Width of the column that names the series.
const LEGEND: u32 = 190;
const INK: RGBColor = RGBColor(30, 30, 34);
const FAINT: RGBColor = RGBColor(225, 225, 230);
/// Colours that stay apart for most eyes (Okabe and Ito).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(90, 90, 90),
];

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    pub series: Vec<Series>,
}

/// Points that belong together, joined in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub name: String,
    /// Positive numbers from 1e-30 to 1e30; others are left out, since axes of more decades have no end of ticks.
    pub points: Vec<(f64, f64)>,
}

impl Chart {
    /// The chart as a picture of 1200 x 800 pixels.
    ///
    /// # Errors
    /// There is nothing to draw.
    pub fn draw(&self) -> Result<Picture, PictureError> {
        register_font();
        let (width, height) = SIZE;
        let mut rgb = vec![255; (width * height * 3) as usize];
        {
            let root = BitMapBackend::with_buffer(&mut rgb, SIZE).into_drawing_area();
            root.fill(&WHITE)?;
            self.draw_on(&root)?;
            root.present()?;
        }
        let rgba = rgb.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        Ok(Picture { width: width as usize, height: height as usize, rgba })
    }

    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, plotters::coord::Shift>,
    ) -> Result<(), PictureError> {
        let all = || self.series.iter().flat_map(Series::drawable);
        let (Some(x), Some(y)) = (range(all().map(|p| p.0)), range(all().map(|p| p.1))) else {
            return Err(PictureError(format!("{}: there are no points", self.title)));
        };
        let text = |size: f64| ("sans-serif", size).into_font().color(&INK);
        let (plot, legend) = root.split_horizontally(SIZE.0 - LEGEND);
        let mut chart = ChartBuilder::on(&plot)
            .caption(&self.title, text(24.0))
            .margin(20)
            .x_label_area_size(60)
            .y_label_area_size(100)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
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
        for (index, series) in self.series.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let points: Vec<_> = series.drawable().collect();
            chart.draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(3)))?;
            // Where colours come again, triangles take the place of circles.
            let is_second = index >= COLOURS.len();
            let place = (10, 80 + 30 * index as i32);
            if is_second {
                let marker = |point| TriangleMarker::new(point, 8, colour.filled());
                chart.draw_series(points.iter().copied().map(marker))?;
                legend.draw(&TriangleMarker::new(place, 8, colour.filled()))?;
            } else {
                chart.draw_series(points.iter().map(|&point| Circle::new(point, 6, colour.filled())))?;
                legend.draw(&Circle::new(place, 6, colour.filled()))?;
            }
            legend.draw(&Text::new(series.name.clone(), (place.0 + 18, place.1 - 9), text(18.0)))?;
        }
        Ok(())
    }
}

impl Series {
    fn drawable(&self) -> impl Iterator<Item = (f64, f64)> {
        let is_drawable = |number: &f64| (1e-30..=1e30).contains(number);
        self.points.iter().copied().filter(move |(x, y)| is_drawable(x) && is_drawable(y))
    }
}

/// From a little below the smallest to a little above the largest.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    (low <= high).then_some((low / 1.5, high * 1.5))
}

/// Three digits tell ticks apart; more are rounding.
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
    fn points_are_drawn_and_nothing_is_an_error() {
        let mut chart = Chart {
            title: "time".to_owned(),
            x_label: "pixels".to_owned(),
            y_label: "ms".to_owned(),
            series: vec![Series {
                name: "one".to_owned(),
                points: vec![(1.0, 2.0), (100.0, 5.0), (0.0, 1.0)],
            }],
        };
        let picture = chart.draw().unwrap();
        let blue = picture.rgba.as_chunks::<4>().0.iter().filter(|c| **c == [0, 114, 178, 255]).count();
        assert!(blue > 500, "{blue} pixels of the first colour");
        chart.series[0].points.clear();
        assert!(chart.draw().is_err());
    }
}
