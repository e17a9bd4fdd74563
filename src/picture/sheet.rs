//! The sheet: targets, phase and amplitude per element, and the pressure map with axes, as in the paper's figures.

use glam::{DVec2, DVec3};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::acoustics::Aperture;
use crate::field::phase_index;
use crate::picture::lettering::Lettered;
use crate::picture::{ColourMap, Picture, PictureError};
use crate::rounding::{pascals, percent_at_least};
use crate::scene::{Focus, Plane, Sampling, Scene, chart, outline};
use crate::solver::{self, Problem, Solution};

/// Reference width and height of a sheet for the measures below; other sizes scale them.
const PAGE: (f64, f64) = (1600.0, 1560.0);
/// The part of a page that [`drive`] needs.
const DRIVE_PAGE: (f64, f64) = (1600.0, 840.0);
/// Side of the square of a plot.
const PLOT: f64 = 560.0;
/// Left edge of the plots in the two columns, top edge in the two rows.
const COLUMNS: [f64; 2] = [100.0, 880.0];
const ROWS: [f64; 2] = [190.0, 905.0];

const INK: RGBColor = RGBColor(30, 30, 34);
const FAINT: RGBColor = RGBColor(205, 205, 210);
/// Colour of targets.
const WANTED: RGBColor = RGBColor(196, 43, 60);
const EMPTY: [u8; 3] = [244, 244, 246];

/// Height of a sheet of this width.
pub fn height(width: usize) -> usize {
    (width as f64 * PAGE.1 / PAGE.0).round() as usize
}

/// Height of a picture by [`drive`] of this width.
pub fn drive_height(width: usize) -> usize {
    (width as f64 * DRIVE_PAGE.1 / DRIVE_PAGE.0).round() as usize
}

/// Width and height in pixels of the map on a sheet of this size: compute the field for that many.
pub fn map_size(plane: &Plane, width: usize, height: usize) -> (usize, usize) {
    let (columns, rows) = Page::new(PAGE, width, height).plot((1, 1), plane.size).size;
    (columns as usize, rows as usize)
}

/// The legend of the map on a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    pub colours: ColourMap,
    /// Pa RMS, of the last colour.
    pub peak: f64,
    /// On what the colours do not show.
    pub remark: Option<String>,
}

/// Draws the whole sheet; `map` is the RMS pressure, of the size [`map_size`].
///
/// # Errors
/// The page is too small for its axes.
pub fn sheet(
    scene: &Scene,
    solution: &Solution,
    title: &str,
    map: &Picture,
    legend: &Legend,
    (width, height): (usize, usize),
) -> Result<Picture, PictureError> {
    let page = Page::new(PAGE, width, height);
    page.draw(title, &summary(scene, solution), |root| {
        let panels = Panels { page: &page, root, scene, solution };
        panels.wanted_points((0, 0))?;
        panels.phases((1, 0))?;
        panels.amplitudes((0, 1))?;
        panels.map((1, 1), map, legend)
    })
}

/// Draws phase and amplitude per element alone.
///
/// # Errors
/// The page is too small for its axes.
pub fn drive(
    scene: &Scene,
    solution: &Solution,
    title: &str,
    (width, height): (usize, usize),
) -> Result<Picture, PictureError> {
    let page = Page::new(DRIVE_PAGE, width, height);
    page.draw(title, &summary(scene, solution), |root| {
        let panels = Panels { page: &page, root, scene, solution };
        panels.phases((0, 0))?;
        panels.amplitudes((1, 0))
    })
}

/// Numbers of focal points, and of samples of strokes and areas, as text.
fn amount(foci: &[Focus]) -> String {
    let of = |is_one: &dyn Fn(&Focus) -> bool| foci.iter().filter(|focus| is_one(focus)).count();
    let separate = of(&Focus::is_separate);
    let areas = of(&Focus::is_of_area);
    let counts = [
        (separate, if separate == 1 { "focus" } else { "foci" }),
        (foci.len() - separate - areas, "samples of strokes"),
        (areas, "samples of areas"),
    ];
    let said = counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"));
    said.collect::<Vec<_>>().join(", ")
}

fn summary(scene: &Scene, solution: &Solution) -> String {
    let quality = &solution.quality;
    let aperture = Aperture::new(scene);
    let bound = solver::bound(&Problem::new(&aperture, solution.foci.clone()));
    format!(
        "{}, {}     mean {}, weakest {}, std/mean {:.1} %     η {:.1} %     at least {} of the upper bound",
        solution.method.title(),
        amount(&solution.foci),
        pascals(quality.mean_pressure),
        pascals(quality.min_pressure),
        100.0 * quality.spread,
        100.0 * quality.efficiency,
        percent_at_least(solution.certified(bound), 0),
    )
}

type Root<'a> = DrawingArea<Lettered<'a>, plotters::coord::Shift>;
type Chart<'a, 'b> = ChartContext<'a, Lettered<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A page in pixels, and the scale from the nominal measures to them.
struct Page {
    width: usize,
    height: usize,
    scale: f64,
}

/// Position of a plot on the page, in pixels.
#[derive(Clone, Copy)]
struct Plot {
    corner: (i32, i32),
    size: (i32, i32),
}

impl Page {
    fn new(nominal: (f64, f64), width: usize, height: usize) -> Self {
        Self { width, height, scale: (width as f64 / nominal.0).min(height as f64 / nominal.1) }
    }

    fn px(&self, nominal: f64) -> i32 {
        (nominal * self.scale).round() as i32
    }

    fn font(&self, nominal: f64) -> TextStyle<'static> {
        ("sans-serif", (nominal * self.scale).max(1.0)).into_font().color(&INK)
    }

    fn draw(
        &self,
        title: &str,
        summary: &str,
        panels: impl FnOnce(&Root<'_>) -> Result<(), PictureError>,
    ) -> Result<Picture, PictureError> {
        let mut rgb = vec![255; self.width * self.height * 3];
        {
            let root = Lettered::on(&mut rgb, (self.width as u32, self.height as u32)).into_drawing_area();
            root.fill(&WHITE)?;
            let left = self.px(COLUMNS[0]);
            root.draw(&Text::new(title.to_owned(), (left, self.px(40.0)), self.font(44.0)))?;
            root.draw(&Text::new(summary.to_owned(), (left, self.px(98.0)), self.font(23.0)))?;
            panels(&root)?;
            root.present()?;
        }
        let rgba = rgb.chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
        Ok(Picture { width: self.width, height: self.height, rgba })
    }

    /// The largest rectangle of the given shape in the square at a column and a row, centred from left to right.
    fn plot(&self, (column, row): (usize, usize), shape: DVec2) -> Plot {
        let size = shape * (PLOT / shape.max_element());
        let (width, height) = (self.px(size.x).max(1), self.px(size.y).max(1));
        let left = self.px(COLUMNS[column] + (PLOT - size.x) / 2.0);
        let top = self.px(ROWS[row] + (PLOT - size.y) / 2.0);
        Plot { corner: (left, top), size: (width, height) }
    }

    /// Axes around a plot, `low` to `high` in mm.
    fn chart<'a, 'b>(
        &self,
        root: &Root<'b>,
        plot: Plot,
        title: &str,
        (low, high): (DVec2, DVec2),
        labels: (&str, &str),
    ) -> Result<Chart<'a, 'b>, PictureError> {
        let (left, below) = (self.px(88.0), self.px(66.0));
        let above = self.px(44.0);
        root.draw(&Text::new(title.to_owned(), (plot.corner.0, plot.corner.1 - above), self.font(27.0)))?;
        let area = root
            .clone()
            .shrink((plot.corner.0 - left, plot.corner.1), (plot.size.0 + left, plot.size.1 + below));
        let mut chart = ChartBuilder::on(&area)
            .x_label_area_size(below)
            .y_label_area_size(left)
            .build_cartesian_2d(low.x..high.x, low.y..high.y)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(INK)
            .x_desc(labels.0)
            .y_desc(labels.1)
            .axis_desc_style(self.font(22.0))
            .label_style(self.font(20.0))
            .x_labels(7)
            .y_labels(7)
            .x_label_formatter(&|v| format!("{v:.0}"))
            .y_label_formatter(&|v| format!("{v:.0}"))
            .set_all_tick_mark_size(self.px(7.0))
            .draw()?;
        Ok(chart)
    }

    /// A colour bar to the right of a plot.
    fn legend(
        &self,
        root: &Root<'_>,
        plot: Plot,
        map: ColourMap,
        (low, high): (f64, f64),
        ticks: &[(f64, String)],
    ) -> Result<(), PictureError> {
        let (left, top) = (plot.corner.0 + plot.size.0 + self.px(18.0), plot.corner.1);
        let (width, height) = (self.px(20.0).max(1), plot.size.1);
        let table = map.table();
        let step =
            |y: i32| (255.0 * f64::from(height - 1 - y) / f64::from((height - 1).max(1))).round() as usize;
        let row =
            |y: i32| std::iter::repeat_n(table[step(y)], width as usize).flat_map(|[r, g, b, _]| [r, g, b]);
        root.draw(&bitmap(
            (left, top),
            (width as usize, height as usize),
            (0..height).flat_map(row).collect(),
        )?)?;
        frame(root, (left, top), (width, height))?;
        for (value, label) in ticks {
            let y = top + ((high - value) / (high - low) * f64::from(height - 1)).round() as i32;
            root.draw(&PathElement::new([(left + width, y), (left + width + self.px(6.0), y)], INK))?;
            let at = (left + width + self.px(11.0), y - self.px(10.0));
            root.draw(&Text::new(label.clone(), at, self.font(20.0)))?;
        }
        Ok(())
    }
}

/// Data common to the panels of a sheet. Each is drawn in the cell at a column and a row.
struct Panels<'a, 'b> {
    page: &'a Page,
    root: &'a Root<'b>,
    scene: &'a Scene,
    solution: &'a Solution,
}

impl Panels<'_, '_> {
    fn wanted_points(&self, cell: (usize, usize)) -> Result<(), PictureError> {
        let Self { page, root, scene, solution } = self;
        let plane = &scene.plane;
        let plot = page.plot(cell, plane.size);
        let half = plane.size / 2.0 * 1e3;
        let title = format!("Wanted ({})", amount(&solution.foci));
        let mut chart = page.chart(root, plot, &title, ranges(plane), labels(plane))?;
        let place = |point: DVec3| on_plane(plane, point).map(|p| (p.x, p.y));
        for target in scene.targets.iter().filter(|target| target.is_in(0)) {
            let is_continuous = target.sampling == Sampling::Continuous || target.is_area();
            let colour = if is_continuous { WANTED } else { FAINT };
            for stroke in outline::strokes(target).map_err(|e| PictureError(e.to_string()))? {
                let line: Vec<_> = stroke.into_iter().filter_map(place).collect();
                chart
                    .draw_series([PathElement::new(line, colour.stroke_width(page.px(3.0).max(1) as u32))])?;
            }
        }
        let most = solution.foci.iter().map(|focus| focus.target).fold(0.0, f64::max);
        let inside = |&(x, y): &(f64, f64)| {
            let offset = DVec2::new(x, y) - centre(plane);
            offset.x.abs() <= half.x && offset.y.abs() <= half.y
        };
        let separate = solution.foci.iter().filter(|focus| focus.is_separate());
        let dots = separate.filter_map(|focus| Some((place(focus.position)?, focus.target)));
        // A weaker focus is a smaller dot.
        let dot = |((x, y), target): ((f64, f64), f64)| {
            Circle::new((x, y), page.px(8.0 * (target / most).sqrt()).max(1), WANTED.filled())
        };
        chart.draw_series(dots.filter(|(at, _)| inside(at)).map(dot))?;
        frame(root, plot.corner, plot.size)
    }

    fn phases(&self, cell: (usize, usize)) -> Result<(), PictureError> {
        let Self { page, root, solution, .. } = self;
        let table = ColourMap::Cyclic.table();
        let colour = |n: usize| table[phase_index(solution.drive.phases[n])];
        let plot = self.element_map(cell, "Phase per element", colour)?;
        let pi = std::f64::consts::PI;
        let tick = |(value, label): (f64, &str)| (value, label.to_owned());
        let ticks =
            [(-pi, "−π"), (-pi / 2.0, "−π/2"), (0.0, "0"), (pi / 2.0, "π/2"), (pi, "π rad")].map(tick);
        page.legend(root, plot, ColourMap::Cyclic, (-pi, pi), &ticks)
    }

    /// The method's own amplitudes; the played ones are uniform, at the cost expressed by the efficiency.
    fn amplitudes(&self, cell: (usize, usize)) -> Result<(), PictureError> {
        let Self { page, root, solution, .. } = self;
        let table = ColourMap::Viridis.table();
        let colour = |n: usize| table[(solution.excitation[n] * 255.0).round() as usize];
        let title = "Amplitude per element, before it is made uniform";
        let plot = self.element_map(cell, title, colour)?;
        let ticks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|value| (value, format!("{value}")));
        page.legend(root, plot, ColourMap::Viridis, (0.0, 1.0), &ticks)
    }

    /// The array seen from the front, every driven element a disk of its colour.
    fn element_map(
        &self,
        cell: (usize, usize),
        title: &str,
        colour: impl Fn(usize) -> [u8; 4],
    ) -> Result<Plot, PictureError> {
        let Self { page, root, scene, solution } = self;
        let chart = chart::Chart::new(scene);
        let plot = page.plot(cell, chart.size);
        let half = chart.size * 500.0;
        page.chart(root, plot, title, (-half, half), ("x / mm", "y / mm"))?;
        let radius = scene.array.element_radius.min(chart.cell * 0.5);
        let (width, height) = (plot.size.0 as usize, plot.size.1 as usize);
        let pixel = DVec2::new(width as f64, height as f64) / chart.size;
        let mut rgb = EMPTY.repeat(width * height);
        for (n, place) in chart.places.iter().enumerate() {
            let driven = solution.drive.amplitudes[n] > 0.0;
            let [r, g, b, _] = if driven { colour(n) } else { [214, 214, 218, 255] };
            let (low, high) = ((place - radius) * pixel, (place + radius) * pixel);
            let along =
                |low: f64, high: f64, count: usize| low.max(0.0) as usize..(high.ceil() as usize).min(count);
            for row in along(low.y, high.y, height) {
                for column in along(low.x, high.x, width) {
                    let at = (DVec2::new(column as f64, row as f64) + 0.5) / pixel;
                    if at.distance(*place) <= radius {
                        let first = 3 * ((height - 1 - row) * width + column);
                        rgb[first..first + 3].copy_from_slice(&[r, g, b]);
                    }
                }
            }
        }
        root.draw(&bitmap(plot.corner, (width, height), rgb)?)?;
        frame(root, plot.corner, plot.size)?;
        Ok(plot)
    }

    fn map(&self, cell: (usize, usize), map: &Picture, legend: &Legend) -> Result<(), PictureError> {
        let Legend { colours, peak, remark } = legend;
        let Self { page, root, scene, .. } = self;
        let plane = &scene.plane;
        let plot = page.plot(cell, plane.size);
        let (low, high) = ranges(plane);
        let title = match remark {
            Some(remark) => format!("RMS pressure, {remark}"),
            None => "RMS pressure".to_owned(),
        };
        page.chart(root, plot, &title, (low, high), labels(plane))?;
        let rgb = map.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        root.draw(&bitmap(plot.corner, (map.width, map.height), rgb)?)?;
        frame(root, plot.corner, plot.size)?;
        let (unit, divisor) = if *peak >= 1000.0 { ("kPa", 1000.0) } else { ("Pa", 1.0) };
        let full = (peak / divisor).max(1e-9);
        let decimals = if full >= 100.0 {
            0
        } else if full >= 10.0 {
            1
        } else {
            2
        };
        let tick = |part: f64| {
            let unit = if part == 1.0 { format!(" {unit}") } else { String::new() };
            (part * full, format!("{:.decimals$}{unit}", part * full))
        };
        page.legend(root, plot, *colours, (0.0, full), &[0.0, 0.25, 0.5, 0.75, 1.0].map(tick))
    }
}

/// Pixels with their top left corner at a position.
fn bitmap<C>(
    corner: C,
    (width, height): (usize, usize),
    rgb: Vec<u8>,
) -> Result<BitMapElement<'static, C>, PictureError> {
    BitMapElement::with_owned_buffer(corner, (width as u32, height as u32), rgb)
        .ok_or_else(|| PictureError("a map has the wrong number of pixels".to_owned()))
}

fn frame(root: &Root<'_>, (left, top): (i32, i32), (width, height): (i32, i32)) -> Result<(), PictureError> {
    Ok(root.draw(&Rectangle::new([(left, top), (left + width, top + height)], INK))?)
}

/// Coordinates (mm) of a point's projection on the plane, along the axes that label it.
pub fn on_plane(plane: &Plane, point: DVec3) -> Option<DVec2> {
    let (x, y) = plane.axes()?;
    let offset = point - plane.centre;
    Some(centre(plane) + DVec2::new(offset.dot(x), offset.dot(y)) * 1e3)
}

/// The plane's corners in mm.
pub fn ranges(plane: &Plane) -> (DVec2, DVec2) {
    let half = plane.size * 500.0;
    (centre(plane) - half, centre(plane) + half)
}

/// A plane along two axes of space is labelled with their coordinates, any other from its own centre.
fn centre(plane: &Plane) -> DVec2 {
    let along = |axis: DVec3| axis_name(axis).map_or(0.0, |_| plane.centre.dot(axis));
    plane.axes().map_or(DVec2::ZERO, |(x, y)| DVec2::new(along(x), along(y)) * 1e3)
}

/// Names of the plane's axes.
pub fn labels(plane: &Plane) -> (&'static str, &'static str) {
    let (x, y) = plane.axes().unwrap_or((DVec3::X, DVec3::Y));
    (
        axis_name(x).unwrap_or("along the plane's x axis / mm"),
        axis_name(y).unwrap_or("along the plane's y axis / mm"),
    )
}

fn axis_name(axis: DVec3) -> Option<&'static str> {
    [(DVec3::X, "x / mm"), (DVec3::Y, "y / mm"), (DVec3::Z, "z / mm")]
        .into_iter()
        .find_map(|(unit, name)| (axis.dot(unit) > 1.0 - 1e-9).then_some(name))
}
