//! The painted shapes of an SVG in paint order, each cut at its clip paths, its masks and the page.
//!
//! A filled shape has the outlines of its fill as lines, a stroked one its centre lines. Patterns are repeated, and
//! markers and copies are shapes as any other. A mask is an area, too: that of its parts of at least half luminance.

use std::cell::Cell;
use std::collections::BTreeMap;

use glam::DVec2;
use i_overlay::core::overlay_rule::OverlayRule;
use kurbo::{BezPath, PathEl, Point};
use usvg::tiny_skia_path::{self, PathSegment};
use usvg::{
    BlendMode, Fill, FillRule, Group, LineCap, Mask, MaskType, Node, Paint, Path, Pattern, Transform,
};

use crate::import::Line;
use crate::import::area::{Area, Bounds, Clip, Rings};
use crate::scene::check::MOST_LETTERS;

/// Less opacity than this is invisible.
pub const FAINTEST: f32 = 0.02;
/// Limit of the copies of a pattern in a shape.
const MOST_TILES: i64 = 2500;
/// Limit of the dashes of a line; one with more is imported whole.
const MOST_DASHES: f64 = 2000.0;
/// Limit of paths, copies of patterns, clip paths and masks that are looked at: nested ones multiply.
const MOST_STEPS: u32 = 300_000;
/// Limit of groups within groups, copies of patterns and masks included.
const DEEPEST: usize = 1100;

/// Labels of elements, as drawing programs show them, by identifier.
pub type Labels = BTreeMap<String, String>;

/// A painted shape, in pixels of 1/96 inch with y downwards.
#[derive(Clone, Debug)]
pub struct Shape<'a> {
    pub ink: Ink<'a>,
    /// The painted area of a fill.
    pub area: Area,
    pub stroke: Option<Stroke>,
    /// Those that are imported where they are seen.
    pub lines: Vec<Line>,
}

/// The paint of a shape.
#[derive(Clone, Copy, Debug)]
pub struct Ink<'a> {
    pub paint: &'a Paint,
    pub opacity: f32,
    pub blend: BlendMode,
    /// From the paint's coordinates to the drawing's.
    pub transform: Transform,
}

/// The stroke of a shape; its area is in [`Shape::area`] if it is broad.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    pub width: f64,
}

/// What is left aside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Omissions {
    /// Shapes beside the page, cut away by clip paths or masks, and without visible paint.
    pub outside: usize,
    pub cut: usize,
    pub invisible: usize,
    /// Groups with filters, which are drawn without them.
    pub filters: usize,
    /// Dashed lines that are imported whole.
    pub dashed: usize,
    /// Patterns with too many copies.
    pub patterns: usize,
}

/// How finely shapes are taken.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// Largest deviation from a curve.
    pub tolerance: f64,
    /// Strokes at least this wide have an area.
    pub broad: f64,
}

/// The shapes of a group within a page, and what is left aside. `None` if there are too many.
pub fn shapes<'a>(
    root: &'a Group,
    page: Bounds,
    labels: &Labels,
    fineness: Fineness,
) -> Option<(Vec<Shape<'a>>, Omissions)> {
    let steps = Cell::new(MOST_STEPS);
    let left = Omissions::default();
    let mut walk = Walk { fineness, labels, page, steps: &steps, shapes: Vec::new(), left };
    let place = Place {
        base: Transform::identity(),
        clip: Clip::rectangle(page),
        opacity: 1.0,
        blend: BlendMode::Normal,
        name: String::new(),
        group: String::new(),
        has_label: false,
        depth: 0,
    };
    walk.group(root, &place);
    (steps.get() > 0).then_some((walk.shapes, walk.left))
}

struct Walk<'a, 'l> {
    fineness: Fineness,
    labels: &'l Labels,
    page: Bounds,
    /// Steps that remain.
    steps: &'l Cell<u32>,
    shapes: Vec<Shape<'a>>,
    left: Omissions,
}

/// What a group hands down.
#[derive(Clone)]
struct Place {
    /// From the coordinates of a clip path's, mask's or pattern's content to the drawing's.
    base: Transform,
    clip: Clip,
    opacity: f32,
    blend: BlendMode,
    /// Of paths without their own.
    name: String,
    group: String,
    /// Whether `group` is a label: identifiers within it, which programs invent, do not replace it.
    has_label: bool,
    depth: usize,
}

impl<'a> Walk<'a, '_> {
    /// Whether there are steps left for one more.
    fn steps_on(&self) -> bool {
        self.steps.set(self.steps.get().saturating_sub(1));
        self.steps.get() > 0
    }

    fn group(&mut self, group: &'a Group, place: &Place) {
        for node in group.children() {
            if !self.steps_on() {
                return;
            }
            match node {
                Node::Group(group) => match self.inner(group, place) {
                    Some(inner) => self.group(group, &inner),
                    None => self.left.cut += paths(group),
                },
                Node::Path(path) if path.is_visible() => self.path(path, place),
                Node::Path(_) => self.left.invisible += 1,
                Node::Image(_) | Node::Text(_) => {}
            }
        }
    }

    /// The place of a group's content; `None` if nothing of it is seen.
    fn inner(&mut self, group: &'a Group, place: &Place) -> Option<Place> {
        let mut inner = place.clone();
        inner.depth += 1;
        if inner.depth > DEEPEST {
            return None;
        }
        inner.opacity *= group.opacity().get();
        if group.blend_mode() != BlendMode::Normal {
            inner.blend = group.blend_mode();
        }
        let label = self.labels.get(group.id());
        if let Some(name) = label.cloned().or_else(|| (!group.id().is_empty()).then(|| decoded(group.id()))) {
            if label.is_some() || !place.has_label {
                inner.group.clone_from(&name);
                inner.has_label = label.is_some();
            }
            inner.name = name;
        }
        let transform = place.base.pre_concat(group.abs_transform());
        if let Some(clip) = group.clip_path() {
            inner.clip = inner.clip.common(&self.clip(clip, transform)?)?;
        }
        if let Some(mask) = group.mask() {
            inner.clip = inner.clip.common(&self.mask(mask, transform, place)?)?;
        }
        self.left.filters += usize::from(!group.filters().is_empty());
        Some(inner)
    }

    /// The area of a clip path in the coordinates of `transform`.
    fn clip(&self, clip: &usvg::ClipPath, transform: Transform) -> Option<Clip> {
        let area = self.clip_area(clip.root(), transform.pre_concat(clip.transform()));
        let own = Clip::of(&area)?;
        match clip.clip_path() {
            Some(outer) => own.common(&self.clip(outer, transform)?),
            None => Some(own),
        }
    }

    fn clip_area(&self, group: &Group, base: Transform) -> Area {
        let mut sum = Area::default();
        for node in group.children() {
            if !self.steps_on() {
                break;
            }
            let area = match node {
                Node::Path(path) if path.is_visible() => {
                    let rings = closed(self.lines(path.data(), base.pre_concat(path.abs_transform())));
                    Area { rings, is_even_odd: path.fill().is_some_and(is_even_odd) }
                }
                Node::Group(group) => {
                    let inner = self.clip_area(group, base);
                    match group
                        .clip_path()
                        .map(|clip| self.clip(clip, base.pre_concat(group.abs_transform())))
                    {
                        Some(Some(clip)) => clip.cut(inner),
                        Some(None) => continue,
                        None => inner,
                    }
                }
                Node::Path(_) | Node::Image(_) | Node::Text(_) => continue,
            };
            sum = if sum.rings.is_empty() { area } else { sum.combined(&area, OverlayRule::Union) };
        }
        sum
    }

    /// The area where a mask lets at least half through.
    fn mask(&self, mask: &'a Mask, transform: Transform, place: &Place) -> Option<Clip> {
        let rect = mask.rect();
        let corner = |x: f32, y: f32| point(transform, tiny_skia_path::Point::from_xy(x, y));
        let region = Area::new(vec![vec![
            corner(rect.left(), rect.top()),
            corner(rect.right(), rect.top()),
            corner(rect.right(), rect.bottom()),
            corner(rect.left(), rect.bottom()),
        ]]);
        let mut inner = Walk {
            fineness: Fineness { broad: 0.0, ..self.fineness },
            labels: self.labels,
            page: self.page,
            steps: self.steps,
            shapes: Vec::new(),
            left: Omissions::default(),
        };
        let clip = Clip::of(&region)?;
        let of_mask = Place {
            base: transform,
            clip,
            opacity: 1.0,
            blend: BlendMode::Normal,
            depth: place.depth + 1,
            ..place.clone()
        };
        inner.group(mask.root(), &of_mask);
        let mut area = Area::default();
        for shape in &inner.shapes {
            let [red, green, blue, alpha] = shape.ink.mean().map(f64::from);
            // Weights of luminance as in the specification of masks, for bytes.
            let through = match mask.kind() {
                MaskType::Luminance => alpha * (0.2125 * red + 0.7154 * green + 0.0721 * blue) / 255.0,
                MaskType::Alpha => alpha,
            };
            if through >= 0.5 {
                area = area.combined(&shape.area, OverlayRule::Union);
            } else if alpha >= 0.5 {
                area = area.combined(&shape.area, OverlayRule::Difference);
            }
        }
        let own = Clip::of(&area)?;
        match mask.mask() {
            Some(outer) => own.common(&self.mask(outer, transform, place)?),
            None => Some(own),
        }
    }

    fn path(&mut self, path: &'a Path, place: &Place) {
        let label = self.labels.get(path.id());
        let name = match (label, path.id()) {
            (Some(label), _) => label.clone(),
            (None, "") => place.name.clone(),
            (None, id) => decoded(id),
        };
        let like = Line { name: short(&name), group: short(&place.group), ..Line::new(Vec::new(), false) };
        let transform = place.base.pre_concat(path.abs_transform());
        let whole: Vec<_> = self.lines(path.data(), transform);
        let ink = |paint: &'a Paint, opacity: f32| Ink {
            paint,
            opacity: opacity * place.opacity,
            blend: place.blend,
            transform,
        };
        let fill = path.fill().map(|fill| (fill, ink(fill.paint(), fill.opacity().get())));
        let stroke = path.stroke().map(|stroke| (stroke, ink(stroke.paint(), stroke.opacity().get())));
        let fill = fill.filter(|(_, ink)| ink.is_visible());
        let stroke = stroke.filter(|(_, ink)| ink.is_visible());
        if fill.is_none() && stroke.is_none() {
            self.left.invisible += 1;
            return;
        }
        let before = self.shapes.len();
        if let Some((fill, ink)) = fill {
            let area = Area { rings: closed(whole.clone()), is_even_odd: is_even_odd(fill) };
            let tiled = match fill.paint() {
                Paint::Pattern(pattern) => self.pattern(pattern, &area, transform, place),
                Paint::Color(_) | Paint::LinearGradient(_) | Paint::RadialGradient(_) => false,
            };
            if !tiled {
                // A stroke draws the same line, but for its gaps and the side that closes an open one.
                let is_stroked = stroke.is_some_and(|(stroke, _)| stroke.dasharray().is_none());
                let areas = whole.iter().filter(|line| line.points.len() > 2);
                let sides = areas.filter_map(|line| match (is_stroked, line.closed) {
                    (false, _) => Some(line.with(line.points.clone(), true)),
                    (true, true) => None,
                    (true, false) => {
                        Some(line.with(vec![line.points[line.points.len() - 1], line.points[0]], false))
                    }
                });
                let sides: Vec<_> = sides.collect();
                self.filled(ink, &area, &sides, &like, place);
            }
        }
        if let Some((stroke, ink)) = stroke {
            let (lines, width) = (self.centre_lines(path, stroke, transform, whole), stroke.width().get());
            let width = f64::from(width) * largest_scale(transform);
            let mut area = Area::default();
            if width >= self.fineness.broad {
                let mut pen = stroke.to_tiny_skia();
                pen.dash = None;
                let dashed = stroke.to_tiny_skia().dash.and_then(|dash| path.data().dash(&dash, 1.0));
                // The outline is finer than a pixel at this magnification.
                let finer = 0.2 / self.fineness.tolerance;
                let magnification = (scale(transform) * finer.max(1.0)) as f32;
                let outline = dashed.as_ref().unwrap_or(path.data()).stroke(&pen, magnification);
                if let Some(outline) = outline {
                    area = place.clip.cut(Area::new(closed(self.lines(&outline, transform))));
                }
            }
            let lines = lines.iter().flat_map(|line| place.clip.parts(line));
            let lines: Vec<_> = lines.map(|line| like.with(line.points, line.closed)).collect();
            if !lines.is_empty() || area.bounds().is_some() {
                self.shapes.push(Shape { ink, area, stroke: Some(Stroke { width }), lines });
            }
        }
        if self.shapes.len() == before {
            let bounds =
                Bounds::of(self.lines(path.data(), transform).into_iter().flat_map(|line| line.points));
            let is_outside = bounds.is_some_and(|bounds| bounds.common(self.page).is_none());
            *(if is_outside { &mut self.left.outside } else { &mut self.left.cut }) += 1;
        }
    }

    /// Adds a fill with its outlines: its sides, or the outline of its part within the clip.
    fn filled(&mut self, ink: Ink<'a>, area: &Area, sides: &[Line], like: &Line, place: &Place) {
        let visible = place.clip.cut(area.clone());
        let lines: Vec<_> = if visible == *area {
            sides.iter().map(|line| like.with(line.points.clone(), line.closed)).collect()
        } else {
            // Along the clip no stroke draws them, and elsewhere they are left to it.
            let rings = visible.rings.iter().filter(|ring| ring.len() > 2);
            rings.map(|ring| like.with(ring.clone(), true)).collect()
        };
        if visible.bounds().is_some() {
            self.shapes.push(Shape { ink, area: visible, stroke: None, lines });
        }
    }

    /// The lines that a stroke follows: dashes, dots of round or square caps, or the path itself.
    fn centre_lines(
        &mut self,
        path: &Path,
        stroke: &usvg::Stroke,
        transform: Transform,
        whole: Vec<Line>,
    ) -> Vec<Line> {
        let has_caps = !matches!(stroke.linecap(), LineCap::Butt);
        let is_drawn = |line: &Line| line.points.len() > 1 || has_caps;
        let dash = stroke.to_tiny_skia().dash;
        let period: f32 = stroke.dasharray().unwrap_or_default().iter().sum();
        let length = whole.iter().map(Line::length).sum::<f64>() / scale(transform).max(f64::MIN_POSITIVE);
        let dashed = match dash {
            Some(_) if length > MOST_DASHES * f64::from(period) => {
                self.left.dashed += 1;
                None
            }
            Some(dash) => path.data().dash(&dash, 1.0),
            None => None,
        };
        let lines = dashed.map(|dashed| self.lines(&dashed, transform)).filter(|lines| !lines.is_empty());
        lines.unwrap_or(whole).into_iter().filter(is_drawn).collect()
    }

    /// Adds the copies of a pattern within an area; false if they are too many.
    fn pattern(&mut self, pattern: &'a Pattern, area: &Area, transform: Transform, place: &Place) -> bool {
        let Some(within) = Clip::of(area).and_then(|clip| clip.common(&place.clip)) else { return true };
        let transform = transform.pre_concat(pattern.transform());
        let rect = pattern.rect();
        let (Some(back), Some(bounds)) = (transform.invert(), area.bounds()) else { return true };
        let corners = Area::rectangle(bounds).rings.concat();
        let own = corners.into_iter().map(|at| {
            let mut at = tiny_skia_path::Point::from_xy(at.x as f32, at.y as f32);
            back.map_point(&mut at);
            DVec2::new(f64::from(at.x - rect.x()), f64::from(at.y - rect.y()))
        });
        let Some(own) = Bounds::of(own) else { return true };
        let size = DVec2::new(f64::from(rect.width()), f64::from(rect.height()));
        let (low, high) = ((own.low / size).floor(), (own.high / size).ceil());
        let tiles = high - low;
        if tiles.x * tiles.y > MOST_TILES as f64 || place.depth > DEEPEST {
            self.left.patterns += 1;
            return false;
        }
        for row in low.y as i64..high.y as i64 {
            for column in low.x as i64..high.x as i64 {
                let (x, y) = (rect.x() + column as f32 * rect.width(), rect.y() + row as f32 * rect.height());
                let base = transform.pre_translate(x, y);
                let corner = |x: f32, y: f32| point(base, tiny_skia_path::Point::from_xy(x, y));
                let (width, height) = (rect.width(), rect.height());
                let tile = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)];
                let tile = Clip::of(&Area::new(vec![tile.map(|(x, y)| corner(x, y)).into()]));
                let Some(clip) = tile.and_then(|tile| tile.common(&within)) else { continue };
                let copy = Place { base, clip, depth: place.depth + 1, ..place.clone() };
                self.group(pattern.root(), &copy);
            }
        }
        true
    }

    /// The subpaths of a path as polylines. Those without a length have a single point.
    fn lines(&self, path: &tiny_skia_path::Path, transform: Transform) -> Vec<Line> {
        let mut lines = Vec::new();
        let mut line = Line::new(Vec::new(), false);
        let mut end = |line: &mut Line| {
            line.points.dedup();
            if line.closed && line.points.len() > 1 && line.points.first() == line.points.last() {
                line.points.pop();
            }
            // Two points that close are a line there and back.
            line.closed &= line.points.len() > 2;
            let done = std::mem::replace(line, Line::new(Vec::new(), false));
            if !done.points.is_empty() && done.points.iter().all(|point| point.is_finite()) {
                lines.push(done);
            }
        };
        kurbo::flatten(placed(path, transform), self.fineness.tolerance, |element| match element {
            PathEl::MoveTo(to) => {
                // A point without a line is where a closed part continues, or nothing.
                if line.points.len() < 2 {
                    line.points.clear();
                }
                end(&mut line);
                line.points.push(DVec2::new(to.x, to.y));
            }
            PathEl::LineTo(to) => line.points.push(DVec2::new(to.x, to.y)),
            PathEl::ClosePath => {
                let first = line.points.first().copied();
                line.closed = true;
                end(&mut line);
                // A continuation without a move starts at the beginning of the closed part.
                line.points.extend(first);
            }
            // Flat paths have none.
            PathEl::QuadTo(..) | PathEl::CurveTo(..) => {}
        });
        if line.points.len() > 1 {
            end(&mut line);
        }
        lines
    }
}

impl Ink<'_> {
    fn is_visible(&self) -> bool {
        let strongest = match self.paint {
            Paint::Color(_) | Paint::Pattern(_) => 1.0,
            Paint::LinearGradient(gradient) => strongest(gradient.stops()),
            Paint::RadialGradient(gradient) => strongest(gradient.stops()),
        };
        strongest * self.opacity >= FAINTEST
    }

    /// Whether nothing shines through.
    pub fn is_opaque(&self) -> bool {
        let weakest = match self.paint {
            Paint::Color(_) => 1.0,
            Paint::LinearGradient(gradient) => weakest(gradient.stops()),
            Paint::RadialGradient(gradient) => weakest(gradient.stops()),
            Paint::Pattern(_) => 0.0,
        };
        self.blend == BlendMode::Normal && weakest * self.opacity > 0.9
    }

    /// Red, green and blue as bytes and the opacity; of gradients the mean.
    pub fn mean(&self) -> [f32; 4] {
        let [red, green, blue, alpha] = match self.paint {
            Paint::Color(colour) => bytes(*colour, 1.0),
            Paint::LinearGradient(gradient) => mean(gradient.stops()),
            Paint::RadialGradient(gradient) => mean(gradient.stops()),
            Paint::Pattern(_) => [128.0, 128.0, 128.0, 1.0],
        };
        [red, green, blue, alpha * self.opacity]
    }
}

fn bytes(colour: usvg::Color, alpha: f32) -> [f32; 4] {
    [f32::from(colour.red), f32::from(colour.green), f32::from(colour.blue), alpha]
}

fn mean(stops: &[usvg::Stop]) -> [f32; 4] {
    let sum = stops.iter().fold([0.0; 4], |sum, stop| {
        let bytes = bytes(stop.color(), stop.opacity().get());
        std::array::from_fn(|i| sum[i] + bytes[i])
    });
    sum.map(|part| part / stops.len().max(1) as f32)
}

fn strongest(stops: &[usvg::Stop]) -> f32 {
    stops.iter().map(|stop| stop.opacity().get()).fold(0.0, f32::max)
}

fn weakest(stops: &[usvg::Stop]) -> f32 {
    stops.iter().map(|stop| stop.opacity().get()).fold(1.0, f32::min)
}

fn is_even_odd(fill: &Fill) -> bool {
    fill.rule() == FillRule::EvenOdd
}

/// Number of paths in a group.
fn paths(group: &Group) -> usize {
    let count = |node: &Node| match node {
        Node::Group(group) => paths(group),
        Node::Path(_) => 1,
        Node::Image(_) | Node::Text(_) => 0,
    };
    group.children().iter().map(count).sum()
}

/// The rings that a fill closes.
fn closed(lines: Vec<Line>) -> Rings {
    lines.into_iter().filter(|line| line.points.len() > 2).map(|line| line.points).collect()
}

/// Letters of a name as a scene may have them.
fn short(name: &str) -> String {
    name.chars().filter(|letter| !letter.is_control()).take(MOST_LETTERS).collect()
}

/// An identifier with the characters that Illustrator and CorelDRAW write as `_x20_` and `_x0020_`.
fn decoded(id: &str) -> String {
    let mut parts = id.split("_x");
    let mut name = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let letter = part.split_once('_').filter(|(code, _)| matches!(code.len(), 2 | 4));
        let letter = letter.and_then(|(code, rest)| Some((u32::from_str_radix(code, 16).ok()?, rest)));
        match letter.and_then(|(code, rest)| Some((char::from_u32(code)?, rest))) {
            Some((letter, rest)) => {
                name.push(letter);
                name.push_str(rest);
            }
            None => {
                name.push_str("_x");
                name.push_str(part);
            }
        }
    }
    name
}

/// Mean magnification.
fn scale(transform: Transform) -> f64 {
    let Transform { sx, kx, ky, sy, .. } = transform;
    let [sx, kx, ky, sy] = [sx, kx, ky, sy].map(f64::from);
    (sx * sy - kx * ky).abs().sqrt()
}

/// Magnification in the direction where it is largest.
fn largest_scale(transform: Transform) -> f64 {
    let Transform { sx, kx, ky, sy, .. } = transform;
    let [sx, kx, ky, sy] = [sx, kx, ky, sy].map(f64::from);
    f64::midpoint((sx + sy).hypot(ky - kx), (sx - sy).hypot(ky + kx))
}

fn point(transform: Transform, at: tiny_skia_path::Point) -> DVec2 {
    let Transform { sx, kx, ky, sy, tx, ty } = transform;
    let [sx, kx, ky, sy, tx, ty] = [sx, kx, ky, sy, tx, ty].map(f64::from);
    let [x, y] = [at.x, at.y].map(f64::from);
    DVec2::new(sx * x + kx * y + tx, ky * x + sy * y + ty)
}

fn placed(path: &tiny_skia_path::Path, transform: Transform) -> BezPath {
    let place = |at: tiny_skia_path::Point| {
        let at = point(transform, at);
        Point::new(at.x, at.y)
    };
    let element = |segment| match segment {
        PathSegment::MoveTo(to) => PathEl::MoveTo(place(to)),
        PathSegment::LineTo(to) => PathEl::LineTo(place(to)),
        PathSegment::QuadTo(a, to) => PathEl::QuadTo(place(a), place(to)),
        PathSegment::CubicTo(a, b, to) => PathEl::CurveTo(place(a), place(b), place(to)),
        PathSegment::Close => PathEl::ClosePath,
    };
    path.segments().map(element).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escaped_identifiers_are_read() {
        let names = ["Ebene_x0020_1", "a_x20_b_x5F_", "max_x", "_xyz_", "plain"];
        assert_eq!(names.map(decoded), ["Ebene 1", "a b_", "max_x", "_xyz_", "plain"]);
    }
}
