//! What is seen of the shapes of a drawing: its lines without the parts that are covered or do not stand out.
//!
//! Two pictures hold the broad shapes: their colours on the paper, and which opaque shape lies on top. An outline is
//! seen where the colours on its sides differ; a stroke, or a strip narrower than some pixels, where its colour differs
//! from that of a side; neither is seen where an opaque shape lies on top of it. Parts that lie on a line that is
//! painted later are left to that one. Beyond the page is its ground: the colour along most of its border.

use glam::DVec2;
use tiny_skia::{
    Color, FillRule, GradientStop, LinearGradient, PathBuilder, Pixmap, RadialGradient, Shader, SpreadMode,
    Transform,
};
use usvg::{BaseGradient, BlendMode, Paint};

use crate::import::area::{Area, Bounds};
use crate::import::join::Trace;
use crate::import::layers::{Ink, Shape};
use crate::import::line::{Line, distance_to};

/// Pixels of the longer side.
const PIXELS: f64 = 2000.0;
/// Pixels: a shape that is narrower is not drawn but compared with the pixels beside it.
pub const BROAD: f64 = 3.0;
/// Pixels around the drawing.
const MARGIN: f64 = 4.0;
/// Distance of the compared pixels from an outline.
const ASIDE: f64 = 1.2;
/// Pixels between the places that are looked at where the sight changes, and how many times as many elsewhere.
const STEP: f64 = 1.5;
const FINER: usize = 3;
/// Limit of places at the smaller distance.
const MOST_PLACES: f64 = 600_000.0;
/// Pixels: shorter remainders of a line are traces of a crossing, shorter gaps are crossings.
const SHORTEST: f64 = 6.0;
const SHORTEST_GAP: f64 = 3.0;
/// Pixels between lines that are the same, and over how many they are.
const SAME: f64 = 0.35;
const SHORTEST_SAME: f64 = 24.0;
/// Smallest difference between colours that is seen, of 255.
const CONTRAST: f64 = 8.0;

/// The visible lines of shapes.
#[derive(Clone, Debug, Default)]
pub struct VisibleLines {
    pub traces: Vec<Trace>,
    /// Number of lines of which nothing is seen.
    pub hidden: usize,
}

/// The colour of the paper where nothing is painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paper {
    White,
    Black,
}

/// The size of a pixel for a drawing within bounds.
pub fn pixel(bounds: Bounds) -> f64 {
    bounds.size().max_element() / PIXELS
}

/// The lines of the shapes, and the corners of the page if it is painted alone.
pub fn seen(shapes: &[Shape<'_>], page: Bounds, pixel: f64, paper: Paper) -> VisibleLines {
    let points = shapes.iter().flat_map(|shape| {
        let lines = shape.lines.iter().flat_map(|line| &line.points);
        lines.chain(shape.area.rings.iter().flatten()).copied()
    });
    let Some(bounds) = Bounds::of(points) else { return VisibleLines::default() };
    let Some(mut view) = View::new(bounds, page, pixel) else { return VisibleLines::default() };
    view.paint(shapes, paper);
    view.ground = view.ground();
    let seen = view.lines(shapes);
    if !seen.traces.is_empty() || view.ground == Ground::Paper {
        return seen;
    }
    // A page that is painted all over is the drawing.
    view.ground = Ground::Paper;
    view.lines(shapes)
}

/// What lies beyond the page.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ground {
    Paper,
    Colour([u8; 3]),
    /// Nothing stands out from it.
    Any,
}

/// The pictures of the shapes.
struct View {
    low: DVec2,
    pixel: f64,
    page: Bounds,
    colours: Pixmap,
    /// One more than the index of the shape on top, as a colour; 0 is the paper.
    tops: Pixmap,
    paper: [u8; 3],
    ground: Ground,
}

/// Visibility of a piece of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    Clear,
    /// As its surroundings, or a stroke under another.
    Blank,
    /// Under another shape.
    Covered,
    /// On another line.
    Same,
    /// An outline within a stroke of its colour, which itself has none.
    Merged,
}

impl View {
    fn new(bounds: Bounds, page: Bounds, pixel: f64) -> Option<Self> {
        let around = bounds.grown(MARGIN * pixel);
        let [width, height] =
            (around.size() / pixel).ceil().max(DVec2::ONE).to_array().map(|size| size as u32);
        let (colours, tops) = (Pixmap::new(width, height)?, Pixmap::new(width, height)?);
        Some(Self { low: around.low, pixel, page, colours, tops, paper: [255; 3], ground: Ground::Paper })
    }

    fn paint(&mut self, shapes: &[Shape<'_>], paper: Paper) {
        self.paper = match paper {
            Paper::White => [255; 3],
            Paper::Black => [0; 3],
        };
        let [red, green, blue] = self.paper;
        self.colours.fill(Color::from_rgba8(red, green, blue, 255));
        self.tops.fill(Color::BLACK);
        let to_pixels = Transform::from_row(
            (1.0 / self.pixel) as f32,
            0.0,
            0.0,
            (1.0 / self.pixel) as f32,
            (-self.low.x / self.pixel) as f32,
            (-self.low.y / self.pixel) as f32,
        );
        for (i, shape) in shapes.iter().enumerate() {
            if !self.is_broad(shape) {
                continue;
            }
            let Some(path) = self.path(&shape.area) else { continue };
            let rule = if shape.area.is_even_odd { FillRule::EvenOdd } else { FillRule::Winding };
            let mut paint = tiny_skia::Paint { anti_alias: false, ..tiny_skia::Paint::default() };
            if let Some(shader) = shader(&shape.ink, to_pixels) {
                paint.shader = shader;
                paint.blend_mode = blend(shape.ink.blend);
                self.colours.fill_path(&path, &paint, rule, Transform::identity(), None);
            }
            if shape.ink.is_opaque() {
                let [blue, green, red, _] = (i as u32 + 1).to_le_bytes();
                let mut paint = tiny_skia::Paint { anti_alias: false, ..tiny_skia::Paint::default() };
                paint.set_color_rgba8(red, green, blue, 255);
                self.tops.fill_path(&path, &paint, rule, Transform::identity(), None);
            }
        }
    }

    fn is_broad(&self, shape: &Shape<'_>) -> bool {
        let width = shape.stroke.map_or_else(|| shape.area.mean_width(), |stroke| stroke.width);
        !shape.area.rings.is_empty() && width >= BROAD * self.pixel
    }

    fn path(&self, area: &Area) -> Option<tiny_skia::Path> {
        let mut path = PathBuilder::new();
        for ring in &area.rings {
            for (i, &at) in ring.iter().enumerate() {
                let [x, y] = ((at - self.low) / self.pixel).to_array().map(|part| part as f32);
                if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
            }
            path.close();
        }
        path.finish()
    }

    fn index(&self, at: DVec2) -> Option<usize> {
        let [x, y] = ((at - self.low) / self.pixel).floor().to_array();
        let (width, height) = (f64::from(self.colours.width()), f64::from(self.colours.height()));
        let is_inside = x >= 0.0 && y >= 0.0 && x < width && y < height;
        is_inside.then_some(y as usize * self.colours.width() as usize + x as usize)
    }

    /// The colour at a place; `None` beyond a page from which nothing stands out.
    fn colour(&self, at: DVec2) -> Option<[u8; 3]> {
        // Pixels that the border divides belong to the ground.
        if !self.page.grown(-0.5 * self.pixel).has(at) {
            return match self.ground {
                Ground::Paper => Some(self.paper),
                Ground::Colour(colour) => Some(colour),
                Ground::Any => None,
            };
        }
        let pixel = self.index(at).map(|index| self.colours.pixels()[index]);
        Some(pixel.map_or(self.paper, |pixel| [pixel.red(), pixel.green(), pixel.blue()]))
    }

    /// One more than the index of the shape on top.
    fn top(&self, at: DVec2) -> u32 {
        let pixel = self.index(at).map(|index| self.tops.pixels()[index]);
        pixel.map_or(0, |pixel| u32::from_le_bytes([pixel.blue(), pixel.green(), pixel.red(), 0]))
    }

    /// The ground by the colours along the border of the page.
    fn ground(&self) -> Ground {
        let inner = self.page.grown(-0.7 * self.pixel);
        let steps = |length: f64| (length / self.pixel).clamp(1.0, 4.0 * PIXELS) as usize;
        let (across, up) = (steps(inner.size().x), steps(inner.size().y));
        let part = |i: usize, count: usize| i as f64 / count as f64;
        let along = (0..across).map(|i| inner.low.x + inner.size().x * part(i, across));
        let rows = along.flat_map(|x| [DVec2::new(x, inner.low.y), DVec2::new(x, inner.high.y)]);
        let along = (0..up).map(|i| inner.low.y + inner.size().y * part(i, up));
        let columns = along.flat_map(|y| [DVec2::new(inner.low.x, y), DVec2::new(inner.high.x, y)]);
        let colours: Vec<_> = rows.chain(columns).filter_map(|at| self.colour(at)).collect();
        // The majority vote of Boyer and Moore.
        let (mut leader, mut votes) = (self.paper, 0_usize);
        for &colour in &colours {
            if votes == 0 {
                leader = colour;
            }
            votes = if colour == leader { votes + 1 } else { votes.saturating_sub(1) };
        }
        let share = |is: &dyn Fn(&[u8; 3]) -> bool| {
            colours.iter().filter(|colour| is(colour)).count() as f64 / colours.len().max(1) as f64
        };
        if share(&|colour| *colour == leader) > 0.5 {
            return if leader == self.paper { Ground::Paper } else { Ground::Colour(leader) };
        }
        if share(&|colour| *colour != self.paper) > 0.95 { Ground::Any } else { Ground::Paper }
    }

    fn lines(&self, shapes: &[Shape<'_>]) -> VisibleLines {
        let lines = || shapes.iter().flat_map(|shape| &shape.lines);
        let length: f64 = lines().map(Line::length).sum::<f64>() / self.pixel;
        let step = STEP.max(length / MOST_PLACES) * self.pixel;
        let widest = shapes.iter().filter(|shape| self.is_broad(shape)).filter_map(|shape| shape.stroke);
        let widest = widest.map(|stroke| stroke.width).fold(0.0, f64::max);
        let mut taken = Taken::new(self, FINER as f64 * step);
        let mut seen = VisibleLines::default();
        // What is painted last comes first: coincident lines of shapes below are left to it.
        let mut number = 0;
        for (i, shape) in shapes.iter().enumerate().rev() {
            for line in &shape.lines {
                number += 1;
                let sight_of = |place: &Place| {
                    let sight = self.sight(place, i as u32 + 1, shapes);
                    let is_taken =
                        sight == Sight::Clear && taken.has(self, place.middle(), place.along, number);
                    if is_taken { Sight::Same } else { sight }
                };
                let (places, mut sights) = refined(places(line, FINER as f64 * step), line.closed, sight_of);
                let longest_blank = match shape.stroke {
                    // Strokes run on through others.
                    Some(_) => 2.0 * widest + SHORTEST_GAP * self.pixel,
                    None => SHORTEST_GAP * self.pixel,
                };
                self.smooth(&mut sights, &places, line.closed, [longest_blank, 4.0 * widest]);
                for (sight, place) in sights.iter().zip(&places) {
                    if *sight == Sight::Clear {
                        taken.take(self, place.ends, number);
                    }
                }
                let ink = shape.ink.mean();
                let ink = [ink[0], ink[1], ink[2], 255.0 * ink[3]].map(|part| part.round() as u8);
                if sights.iter().all(|sight| *sight == Sight::Clear) {
                    seen.traces.push(Trace { line: line.clone(), ink, is_cut: false });
                } else if sights.contains(&Sight::Clear) {
                    let parts = parts(line, &places, &sights).into_iter();
                    seen.traces.extend(parts.map(|line| Trace { line, ink, is_cut: true }));
                } else {
                    seen.hidden += 1;
                }
            }
        }
        seen.traces.reverse();
        seen
    }

    /// The sight of a place of the shape whose index is one less than `order`.
    fn sight(&self, place: &Place, order: u32, shapes: &[Shape<'_>]) -> Sight {
        let shape = &shapes[order as usize - 1];
        let (at, aside) = (place.middle(), place.along.perp() * ASIDE * self.pixel);
        let around = [at - aside, at, at + aside];
        if around.iter().all(|&at| self.top(at) > order) {
            // Where strokes cross, the lower one runs on.
            let above = &shapes[self.top(at) as usize - 1];
            let crosses = shape.stroke.is_some() && above.stroke.is_some();
            return if crosses { Sight::Blank } else { Sight::Covered };
        }
        let is_seen = if shape.stroke.is_none() && self.is_broad(shape) {
            let [left, middle, right] = around.map(|at| self.colour(at));
            [(left, right), (left, middle), (middle, right)]
                .into_iter()
                .any(|(a, b)| difference(a, b) > CONTRAST)
        } else {
            let half = shape.stroke.map_or(0.0, |stroke| stroke.width / 2.0);
            let aside = place.along.perp() * (half + (ASIDE + 0.3) * self.pixel);
            let [red, green, blue, alpha] = shape.ink.mean();
            let own = Some([red, green, blue].map(|part| part.round() as u8));
            let differs = |at| f64::from(alpha) * difference(self.colour(at), own) > CONTRAST;
            differs(at - aside) || differs(at + aside)
        };
        let is_stroke = |at: DVec2| match self.top(at) {
            0 => false,
            top => shapes[top as usize - 1].stroke.is_some(),
        };
        match (is_seen, shape.stroke) {
            (true, _) => Sight::Clear,
            (false, None) if around.into_iter().any(is_stroke) => Sight::Merged,
            (false, None | Some(_)) => Sight::Blank,
        }
    }

    /// Fills short gaps and removes short remainders.
    fn smooth(
        &self,
        sights: &mut [Sight],
        places: &[Place],
        is_closed: bool,
        [longest_blank, longest_merged]: [f64; 2],
    ) {
        if !sights.contains(&Sight::Clear) {
            return;
        }
        let mut change = |from: Sight, limit: f64, to: Sight| {
            for run in runs(sights, is_closed) {
                let length: f64 = run.iter().map(|&i| places[i].length()).sum();
                if sights[run[0]] == from && length < limit && run.len() < sights.len() {
                    run.iter().for_each(|&i| sights[i] = to);
                }
            }
        };
        change(Sight::Blank, longest_blank, Sight::Clear);
        change(Sight::Merged, longest_merged, Sight::Clear);
        change(Sight::Same, SHORTEST_SAME * self.pixel, Sight::Clear);
        change(Sight::Covered, SHORTEST_GAP * self.pixel, Sight::Clear);
        change(Sight::Clear, SHORTEST * self.pixel, Sight::Covered);
    }
}

/// Groups of neighbours that are alike; over the end of a closed line.
fn runs(sights: &[Sight], is_closed: bool) -> Vec<Vec<usize>> {
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for i in 0..sights.len() {
        match runs.last_mut() {
            Some(run) if sights[run[0]] == sights[i] => run.push(i),
            Some(_) | None => runs.push(vec![i]),
        }
    }
    if is_closed && runs.len() > 1 && sights[0] == sights[sights.len() - 1] {
        let mut last = runs.pop().unwrap_or_default();
        last.append(&mut runs[0]);
        runs[0] = last;
    }
    runs
}

/// A short part of a piece of a line.
#[derive(Clone, Copy, Debug)]
struct Place {
    ends: [DVec2; 2],
    /// Unit vector.
    along: DVec2,
    piece: usize,
    span: [f64; 2],
}

impl Place {
    fn middle(&self) -> DVec2 {
        (self.ends[0] + self.ends[1]) / 2.0
    }

    fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }
}

fn places(line: &Line, step: f64) -> Vec<Place> {
    if let [dot] = line.points[..] {
        return vec![Place { ends: [dot; 2], along: DVec2::X, piece: 0, span: [0.0, 1.0] }];
    }
    let mut places = Vec::new();
    for (piece, [a, b]) in line.pieces().enumerate() {
        let count = (a.distance(b) / step).ceil().max(1.0) as usize;
        let along = (b - a).normalize_or(DVec2::X);
        for i in 0..count {
            let span = [i as f64 / count as f64, (i + 1) as f64 / count as f64];
            places.push(Place { ends: span.map(|part| a.lerp(b, part)), along, piece, span });
        }
    }
    places
}

/// Places with their sights, those beside a change of sight divided.
fn refined(places: Vec<Place>, is_closed: bool, sight: impl Fn(&Place) -> Sight) -> (Vec<Place>, Vec<Sight>) {
    let sights: Vec<_> = places.iter().map(&sight).collect();
    if sights.iter().all(|other| *other == sights[0]) {
        return (places, sights);
    }
    let count = places.len();
    let (mut finer, mut finer_sights) = (Vec::new(), Vec::new());
    for (i, place) in places.into_iter().enumerate() {
        let before = if i > 0 || is_closed { sights[(i + count - 1) % count] } else { sights[i] };
        let after = if i + 1 < count || is_closed { sights[(i + 1) % count] } else { sights[i] };
        if before == sights[i] && after == sights[i] {
            finer_sights.push(sights[i]);
            finer.push(place);
            continue;
        }
        for k in 0..FINER {
            let parts = [k as f64 / FINER as f64, (k + 1) as f64 / FINER as f64];
            let ends = parts.map(|part| place.ends[0].lerp(place.ends[1], part));
            let span = parts.map(|part| place.span[0] + (place.span[1] - place.span[0]) * part);
            // The ends are exact, so that neighbours touch.
            let span = [
                if k == 0 { place.span[0] } else { span[0] },
                if k + 1 == FINER { place.span[1] } else { span[1] },
            ];
            let part = Place { ends, span, ..place };
            finer_sights.push(sight(&part));
            finer.push(part);
        }
    }
    (finer, finer_sights)
}

/// The clear parts of a line.
fn parts(line: &Line, places: &[Place], sights: &[Sight]) -> Vec<Line> {
    let mut piece = 0;
    let mut next = 0;
    line.parts(|_| {
        let mut spans = Vec::new();
        while places.get(next).is_some_and(|place| place.piece == piece) {
            if sights[next] == Sight::Clear {
                spans.push(places[next].span);
            }
            next += 1;
        }
        piece += 1;
        spans
    })
}

/// The places that lines have taken, in cells that are larger than they.
struct Taken {
    cell: f64,
    /// How far the middle of a place can be from a point that it touches.
    reach: f64,
    columns: usize,
    /// The latest entry of each cell and the one before each entry, counted from 1.
    latest: Vec<u32>,
    entries: Vec<([DVec2; 2], u32, u32)>,
}

impl Taken {
    /// Entries of a cell that are compared, the latest: where there are more, nothing can be told apart.
    const MOST: usize = 64;

    fn new(view: &View, step: f64) -> Self {
        let cell = (2.0 * step).max(4.0 * view.pixel);
        let count = |pixels: u32| (f64::from(pixels) * view.pixel / cell) as usize + 1;
        let (columns, rows) = (count(view.colours.width()), count(view.colours.height()));
        let reach = step / 2.0 + SAME * view.pixel;
        Self { cell, reach, columns, latest: vec![0; columns * rows], entries: Vec::new() }
    }

    fn cell(&self, view: &View, at: DVec2) -> Option<usize> {
        view.index(at)?;
        let [x, y] = ((at - view.low) / self.cell).to_array().map(|part| part as usize);
        Some(y * self.columns + x)
    }

    fn take(&mut self, view: &View, ends: [DVec2; 2], line: u32) {
        let Some(cell) = self.cell(view, (ends[0] + ends[1]) / 2.0) else { return };
        self.entries.push((ends, line, self.latest[cell]));
        self.latest[cell] = self.entries.len() as u32;
    }

    /// Whether another line runs through a place in its direction.
    fn has(&self, view: &View, at: DVec2, along: DVec2, line: u32) -> bool {
        let near = SAME * view.pixel;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let mut cells: Vec<_> = corners
            .iter()
            .filter_map(|&corner| self.cell(view, at + DVec2::from(corner) * self.reach))
            .collect();
        cells.dedup();
        cells.into_iter().any(|cell| {
            let (mut next, mut left) = (self.latest[cell], Self::MOST);
            while next > 0 && left > 0 {
                left -= 1;
                let (ends, owner, before) = self.entries[next as usize - 1];
                let is_parallel = (ends[1] - ends[0]).normalize_or(along).perp_dot(along).abs() < 0.05;
                if owner != line && is_parallel && distance_to(ends, at) < near {
                    return true;
                }
                next = before;
            }
            false
        })
    }
}

/// The largest difference of two colours; 0 from one that is unknown.
fn difference(a: Option<[u8; 3]>, b: Option<[u8; 3]>) -> f64 {
    let (Some(a), Some(b)) = (a, b) else { return 0.0 };
    f64::from(a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0))
}

fn shader(ink: &Ink<'_>, to_pixels: Transform) -> Option<Shader<'static>> {
    let transform =
        |gradient: &BaseGradient| to_pixels.pre_concat(ink.transform).pre_concat(gradient.transform());
    match ink.paint {
        Paint::Color(_) | Paint::Pattern(_) => {
            let [red, green, blue, alpha] = ink.mean();
            let colour = Color::from_rgba(red / 255.0, green / 255.0, blue / 255.0, alpha)?;
            Some(Shader::SolidColor(colour))
        }
        Paint::LinearGradient(gradient) => LinearGradient::new(
            tiny_skia::Point::from_xy(gradient.x1(), gradient.y1()),
            tiny_skia::Point::from_xy(gradient.x2(), gradient.y2()),
            stops(gradient, ink.opacity),
            spread(gradient),
            transform(gradient),
        ),
        Paint::RadialGradient(gradient) => RadialGradient::new(
            tiny_skia::Point::from_xy(gradient.fx(), gradient.fy()),
            gradient.fr().get(),
            tiny_skia::Point::from_xy(gradient.cx(), gradient.cy()),
            gradient.r().get(),
            stops(gradient, ink.opacity),
            spread(gradient),
            transform(gradient),
        ),
    }
}

fn stops(gradient: &BaseGradient, opacity: f32) -> Vec<GradientStop> {
    let stop = |stop: &usvg::Stop| {
        let usvg::Color { red, green, blue } = stop.color();
        let alpha = (255.0 * opacity * stop.opacity().get()).round() as u8;
        GradientStop::new(stop.offset().get(), Color::from_rgba8(red, green, blue, alpha))
    };
    gradient.stops().iter().map(stop).collect()
}

fn spread(gradient: &BaseGradient) -> SpreadMode {
    match gradient.spread_method() {
        usvg::SpreadMethod::Pad => SpreadMode::Pad,
        usvg::SpreadMethod::Reflect => SpreadMode::Reflect,
        usvg::SpreadMethod::Repeat => SpreadMode::Repeat,
    }
}

fn blend(mode: BlendMode) -> tiny_skia::BlendMode {
    match mode {
        BlendMode::Normal => tiny_skia::BlendMode::SourceOver,
        BlendMode::Multiply => tiny_skia::BlendMode::Multiply,
        BlendMode::Screen => tiny_skia::BlendMode::Screen,
        BlendMode::Overlay => tiny_skia::BlendMode::Overlay,
        BlendMode::Darken => tiny_skia::BlendMode::Darken,
        BlendMode::Lighten => tiny_skia::BlendMode::Lighten,
        BlendMode::ColorDodge => tiny_skia::BlendMode::ColorDodge,
        BlendMode::ColorBurn => tiny_skia::BlendMode::ColorBurn,
        BlendMode::HardLight => tiny_skia::BlendMode::HardLight,
        BlendMode::SoftLight => tiny_skia::BlendMode::SoftLight,
        BlendMode::Difference => tiny_skia::BlendMode::Difference,
        BlendMode::Exclusion => tiny_skia::BlendMode::Exclusion,
        BlendMode::Hue => tiny_skia::BlendMode::Hue,
        BlendMode::Saturation => tiny_skia::BlendMode::Saturation,
        BlendMode::Color => tiny_skia::BlendMode::Color,
        BlendMode::Luminosity => tiny_skia::BlendMode::Luminosity,
        BlendMode::PlusLighter => tiny_skia::BlendMode::Plus,
    }
}
