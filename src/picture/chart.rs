//! Charts of measurements: points and lines over logarithmic axes.

use plotters::prelude::*;

use crate::picture::{Picture, register_font};

const SIZE: (u32, u32) = (1200, 800);
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
    /// Positive numbers; others are left out.
    pub points: Vec<(f64, f64)>,
}

/// Why a chart could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("the chart could not be drawn: {0}")]
pub struct ChartError(String);

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for ChartError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self(error.to_string())
    }
}

impl Chart {
    /// The chart as a picture of 1200 x 800 pixels.
    ///
    /// # Errors
    /// There is nothing to draw.
    pub fn draw(&self) -> Result<Picture, ChartError> {
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
    ) -> Result<(), ChartError> {
        let all = || self.series.iter().flat_map(|series| series.drawable());
        let (Some(x), Some(y)) = (range(all().map(|p| p.0)), range(all().map(|p| p.1))) else {
            return Err(ChartError(format!("{}: there are no points", self.title)));
        };
        let text = |size: f64| ("sans-serif", size).into_font().color(&INK);
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, text(26.0))
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
            chart
                .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(3)))?
                .label(&series.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(3)));
            chart.draw_series(points.iter().map(|&point| Circle::new(point, 6, colour.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.9))
            .border_style(FAINT)
            .label_font(text(18.0))
            .margin(14)
            .draw()?;
        Ok(())
    }
}

impl Series {
    fn drawable(&self) -> impl Iterator<Item = (f64, f64)> {
        self.points.iter().copied().filter(|&(x, y)| x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite())
    }
}

/// From a little below the smallest to a little above the largest.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    (low <= high).then_some((low / 1.5, high * 1.5))
}

fn label(value: &f64) -> String {
    if (0.01..100_000.0).contains(value) { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

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
