//! The sheet: targets, phase and amplitude per element, and the pressure map with axes, as in the paper's figures.

use glam::{DVec2, DVec3};

use crate::picture::figure::elements::Elements;
use crate::picture::figure::layout::{Axis, Bar, Content, Frame, TITLE, clipped};
use crate::picture::figure::mark::{Anchor, BLACK, Figure, Ink, Mark};
use crate::picture::{Picture, PictureError};
use crate::scene::{Focus, Plane, Sampling, Scene, chart, outline};
use crate::solver::Solution;

/// Width and height of a sheet, mm; its pixels are as many as are asked for.
const PAGE: [f64; 2] = [200.0, 195.0];
/// The part of a page that [`drive`] needs.
const DRIVE_PAGE: [f64; 2] = [200.0, 105.0];
/// Side of the square of a plot.
const PLOT: f64 = 70.0;
/// Left edge of the plots in the two columns, top edge in the two rows.
const COLUMNS: [f64; 2] = [12.5, 111.5];
const ROWS: [f64; 2] = [26.5, 114.0];
/// Baseline of a plot's title above its top.
const ABOVE: f64 = 2.0;
/// Heights of the page's title and of the words below it, and their baselines.
const HEADING: (f64, f64) = (4.5, 7.0);
const SUMMARY: (f64, [f64; 2]) = (2.5, [12.5, 16.5]);
/// Width of strokes, and radius of the strongest focus.
const STROKE: f64 = 0.45;
const DOT: f64 = 1.0;

const FAINT: Ink = [205, 205, 210];
/// Colour of targets.
const WANTED: Ink = [196, 43, 60];

/// Height of a sheet of this width.
pub fn height(width: usize) -> usize {
    (width as f64 * PAGE[1] / PAGE[0]).round() as usize
}

/// Height of a picture by [`drive`] of this width.
pub fn drive_height(width: usize) -> usize {
    (width as f64 * DRIVE_PAGE[1] / DRIVE_PAGE[0]).round() as usize
}

/// Width and height in pixels of the map on a sheet of this size: compute the field for that many.
pub fn map_size(plane: &Plane, width: usize, height: usize) -> (usize, usize) {
    frame(density(PAGE, (width, height)), (1, 1), plane.size).map.into()
}

/// The title of a page, and two lines of figures below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Words {
    pub title: String,
    pub summary: [String; 2],
}

/// The map of a sheet, of the size [`map_size`].
#[derive(Clone, Debug)]
pub struct Pressure {
    pub picture: Picture,
    pub title: String,
    pub bar: Bar,
}

/// Draws the whole sheet.
///
/// # Errors
/// A target without an outline, or too many pixels.
pub fn sheet(
    scene: &Scene,
    solution: &Solution,
    words: &Words,
    map: Pressure,
    size: (usize, usize),
) -> Result<Picture, PictureError> {
    let mut page = Page::new((scene, solution), density(PAGE, size), words);
    page.targets((0, 0))?;
    page.phases((1, 0));
    page.amplitudes((0, 1));
    page.map((1, 1), map);
    page.picture(size)
}

/// Draws phase and amplitude per element alone.
///
/// # Errors
/// Too many pixels.
pub fn drive(
    scene: &Scene,
    solution: &Solution,
    words: &Words,
    size: (usize, usize),
) -> Result<Picture, PictureError> {
    let mut page = Page::new((scene, solution), density(DRIVE_PAGE, size), words);
    page.phases((0, 0));
    page.amplitudes((1, 0));
    page.picture(size)
}

/// Title of a solution's amplitudes.
pub fn amplitude_title(solution: &Solution) -> &'static str {
    match solution.method {
        Some(_) => "Amplitude per element, before it is made uniform",
        None => "Amplitude per element",
    }
}

/// Numbers of focal points, and of samples of strokes and areas, as text.
pub fn amount(foci: &[Focus]) -> String {
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

/// Pixels in a millimetre of a page.
fn density(page: [f64; 2], (width, height): (usize, usize)) -> f64 {
    (width as f64 / page[0]).min(height as f64 / page[1])
}

/// The largest rectangle of a shape in the square at a column and a row, from its upper left corner.
fn frame(density: f64, (column, row): (usize, usize), shape: DVec2) -> Frame {
    let pixels = |mm: f64| (mm * density).round() as usize;
    let size = shape * (PLOT / shape.max_element());
    let map = [size.x, size.y].map(|side| pixels(side).clamp(1, pixels(PLOT).max(1)));
    Frame { density, corner: [COLUMNS[column], ROWS[row]].map(pixels), map }
}

/// A page and what its panels show. Each panel is in the cell at a column and a row.
struct Page<'a> {
    scene: &'a Scene,
    solution: &'a Solution,
    density: f64,
    marks: Vec<Mark>,
}

impl<'a> Page<'a> {
    fn new((scene, solution): (&'a Scene, &'a Solution), density: f64, words: &Words) -> Self {
        let text = |y, height, text: &str| Mark::text([COLUMNS[0], y], height, Anchor::Start, BLACK, text);
        let mut marks = vec![text(HEADING.1, HEADING.0, &words.title)];
        marks.extend(SUMMARY.1.iter().zip(&words.summary).map(|(&y, line)| text(y, SUMMARY.0, line)));
        Self { scene, solution, density, marks }
    }

    fn picture(self, (width, height): (usize, usize)) -> Result<Picture, PictureError> {
        let Self { density, marks, .. } = self;
        Figure { pixels: [width, height], density, title: String::new(), marks }.picture()
    }

    /// The title above a plot.
    fn title(&mut self, frame: &Frame, title: &str) {
        let [left, top] = frame.corner();
        self.marks.push(Mark::text([left, top - ABOVE], TITLE, Anchor::Start, BLACK, title));
    }

    fn targets(&mut self, cell: (usize, usize)) -> Result<(), PictureError> {
        let (scene, solution) = (self.scene, self.solution);
        let plane = &scene.plane;
        let (frame, axes) = (frame(self.density, cell, plane.size), axes(plane));
        let amount = Some(amount(&solution.foci)).filter(|amount| !amount.is_empty());
        let title = format!("Targets ({})", amount.as_deref().unwrap_or("none"));
        self.title(&frame, &title);
        self.marks.extend(Content { axes: axes.clone(), ..Content::default() }.marks(&frame, plain(&frame)));
        let place = |point| on_plane(plane, point).map(|DVec2 { x, y }| frame.place(&axes, [x, y]));
        let room @ [left, top, right, bottom] = frame.room();
        for target in scene.targets.iter().filter(|target| target.is_in(0)) {
            let is_continuous = target.sampling == Sampling::Continuous || target.is_area();
            let ink = if is_continuous { WANTED } else { FAINT };
            for stroke in outline::strokes(target).map_err(|e| PictureError(e.to_string()))? {
                let points: Vec<_> = stroke.into_iter().filter_map(place).collect();
                let pieces = clipped(&points, room).into_iter();
                self.marks.extend(pieces.map(|piece| Mark::line(piece, STROKE, ink)));
            }
        }
        let most = solution.foci.iter().map(|focus| focus.target).fold(0.0, f64::max);
        let separate = solution.foci.iter().filter(|focus| focus.is_placed());
        let dots = separate.filter_map(|focus| Some((place(focus.position)?, focus.target)));
        let is_inside =
            |&([x, y], _): &([f64; 2], f64)| (left..=right).contains(&x) && (top..=bottom).contains(&y);
        // A weaker focus is a smaller dot.
        self.marks.extend(dots.filter(is_inside).map(|(centre, target)| {
            let radius = (DOT * (target / most).sqrt()).max(0.1);
            Mark::Disc { centre, radius, ink: WANTED }
        }));
        Ok(())
    }

    fn phases(&mut self, cell: (usize, usize)) {
        let drive = &self.solution.drive;
        self.elements(
            cell,
            "Phase per element",
            &Elements::phases(self.scene, &drive.phases, &drive.amplitudes),
        );
    }

    /// The method's own amplitudes; the played ones are uniform, at the cost expressed by the efficiency.
    fn amplitudes(&mut self, cell: (usize, usize)) {
        let (of, played) = (&self.solution.excitation, &self.solution.drive.amplitudes);
        let title = amplitude_title(self.solution);
        self.elements(cell, title, &Elements::amplitudes(self.scene, of, played));
    }

    fn elements(&mut self, cell: (usize, usize), title: &str, elements: &Elements) {
        let frame = frame(self.density, cell, chart::Chart::new(self.scene).size);
        self.title(&frame, title);
        self.marks.extend(elements.marks(&frame));
    }

    fn map(&mut self, cell: (usize, usize), map: Pressure) {
        let plane = &self.scene.plane;
        let frame = frame(self.density, cell, plane.size);
        let Pressure { picture, title, bar } = map;
        self.title(&frame, &title);
        let content = Content { axes: axes(plane), bar: Some(bar), ..Content::default() };
        self.marks.extend(content.marks(&frame, picture));
    }
}

/// A white map.
fn plain(frame: &Frame) -> Picture {
    let [width, height] = frame.map;
    Picture { width, height, rgba: vec![255; 4 * width * height] }
}

/// The axes of a map of the plane.
pub fn axes(plane: &Plane) -> [Axis; 2] {
    let ((low, high), (x, y)) = (ranges(plane), labels(plane));
    let axis = |low: f64, high: f64, label: &str| Axis { ends: [low, high], label: label.to_owned() };
    [axis(low.x, high.x, x), axis(low.y, high.y, y)]
}

/// Coordinates (mm) of a point's projection on the plane, along the axes that label it.
pub fn on_plane(plane: &Plane, point: DVec3) -> Option<DVec2> {
    let (x, y) = plane.axes()?;
    let offset = point - plane.centre;
    Some(centre(plane) + DVec2::new(offset.dot(x), offset.dot(y)) * 1e3)
}

/// The plane's corners in mm.
fn ranges(plane: &Plane) -> (DVec2, DVec2) {
    let half = plane.size * 500.0;
    (centre(plane) - half, centre(plane) + half)
}

/// A plane along two axes of space is labelled with their coordinates, any other from its own centre.
fn centre(plane: &Plane) -> DVec2 {
    let along = |axis: DVec3| axis_name(axis).map_or(0.0, |_| plane.centre.dot(axis));
    plane.axes().map_or(DVec2::ZERO, |(x, y)| DVec2::new(along(x), along(y)) * 1e3)
}

/// Names of the plane's axes.
fn labels(plane: &Plane) -> (&'static str, &'static str) {
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
