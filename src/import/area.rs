//! Areas of a drawing: filled rings, their bounds, and the parts of lines and rings within a clip.

use std::rc::Rc;

use glam::DVec2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;

use crate::import::line::{Line, distance_to};

/// Closed polygons; the first point of each follows its last.
pub type Rings = Vec<Vec<DVec2>>;

/// A filled area. Overlaps of its rings are holes with the even-odd rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Area {
    pub rings: Rings,
    pub is_even_odd: bool,
}

impl Area {
    pub fn new(rings: Rings) -> Self {
        Self { rings, is_even_odd: false }
    }

    pub fn rectangle(bounds: Bounds) -> Self {
        let Bounds { low, high } = bounds;
        Self::new(vec![vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]])
    }

    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.rings.iter().flatten().copied())
    }

    /// Twice the area over the perimeter: the width of a long strip.
    pub fn mean_width(&self) -> f64 {
        let pieces = |ring: &Vec<DVec2>| {
            let next = ring.iter().cycle().skip(1);
            let (mut area, mut length) = (0.0, 0.0);
            for (a, b) in ring.iter().zip(next) {
                area += a.perp_dot(*b) / 2.0;
                length += a.distance(*b);
            }
            DVec2::new(area, length)
        };
        let sum: DVec2 = self.rings.iter().map(pieces).sum();
        2.0 * sum.x.abs() / sum.y.max(f64::MIN_POSITIVE)
    }

    /// The same area by rings that do not overlap.
    fn plain(&self) -> Self {
        let rule = if self.is_even_odd { FillRule::EvenOdd } else { FillRule::NonZero };
        Self::new(rings(contours(&self.rings).simplify_shape(rule)))
    }

    pub fn combined(&self, other: &Self, rule: OverlayRule) -> Self {
        // One rule holds for both.
        let plain = |area: &Self| contours(&if area.is_even_odd { area.plain() } else { area.clone() }.rings);
        Self::new(rings(plain(self).overlay(&plain(other), rule, FillRule::NonZero)))
    }
}

fn contours(rings: &Rings) -> Vec<Vec<[f64; 2]>> {
    rings.iter().map(|ring| ring.iter().map(|point| point.to_array()).collect()).collect()
}

fn rings(shapes: Vec<Vec<Vec<[f64; 2]>>>) -> Rings {
    shapes.into_iter().flatten().map(|ring| ring.into_iter().map(DVec2::from).collect()).collect()
}

/// A box with sides parallel to the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub low: DVec2,
    pub high: DVec2,
}

impl Bounds {
    /// `None` without points.
    pub fn of(points: impl Iterator<Item = DVec2>) -> Option<Self> {
        points.map(|at| Self { low: at, high: at }).reduce(|a, b| a.around(b))
    }

    pub fn around(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub fn grown(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    pub fn size(self) -> DVec2 {
        self.high - self.low
    }

    pub fn has(self, at: DVec2) -> bool {
        at.cmpge(self.low).all() && at.cmple(self.high).all()
    }

    fn holds(self, other: Self) -> bool {
        self.has(other.low) && self.has(other.high)
    }

    /// `None` if they do not touch.
    pub fn common(self, other: Self) -> Option<Self> {
        let common = Self { low: self.low.max(other.low), high: self.high.min(other.high) };
        common.low.cmple(common.high).all().then_some(common)
    }
}

/// The visible part of the plane: a rectangle, or rings within it.
#[derive(Clone, Debug)]
pub struct Clip {
    bounds: Bounds,
    outline: Option<Rc<Outline>>,
}

impl Clip {
    pub fn rectangle(bounds: Bounds) -> Self {
        Self { bounds, outline: None }
    }

    /// `None` if the area is empty.
    pub fn of(area: &Area) -> Option<Self> {
        let area = area.plain();
        let bounds = area.bounds()?;
        let slack = slack(bounds);
        let is_corner =
            |at: &DVec2| (*at - bounds.low).abs().min((*at - bounds.high).abs()).max_element() < slack;
        let is_rectangle = matches!(&area.rings[..], [ring] if ring.len() == 4 && ring.iter().all(is_corner));
        let outline = (!is_rectangle).then(|| Rc::new(Outline::new(area, bounds)));
        Some(Self { bounds, outline })
    }

    fn area(&self) -> Area {
        self.outline.as_ref().map_or_else(|| Area::rectangle(self.bounds), |outline| outline.area.clone())
    }

    /// `None` if nothing remains.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let bounds = self.bounds.common(other.bounds)?;
        match (&self.outline, &other.outline) {
            (None, None) => Some(Self::rectangle(bounds)),
            (None, Some(_)) if self.bounds.holds(other.bounds) => Some(other.clone()),
            (Some(_), None) if other.bounds.holds(self.bounds) => Some(self.clone()),
            (None | Some(_), None | Some(_)) => {
                Self::of(&self.area().combined(&other.area(), OverlayRule::Intersect))
            }
        }
    }

    /// The part of an area within this clip.
    pub fn cut(&self, area: Area) -> Area {
        let Some(bounds) = area.bounds() else { return area };
        if self.bounds.common(bounds).is_none() {
            return Area::default();
        }
        if self.outline.is_none() && self.bounds.grown(slack(self.bounds)).holds(bounds) {
            return area;
        }
        match &self.outline {
            Some(_) => area.combined(&self.area(), OverlayRule::Intersect),
            // Rings that cross themselves often are cut as they are.
            None => Area { rings: area.rings.iter().map(|ring| within(ring, self.bounds)).collect(), ..area },
        }
    }

    /// The parts of a line within this clip, its border included.
    pub fn parts(&self, line: &Line) -> Vec<Line> {
        let Some(bounds) = Bounds::of(line.points.iter().copied()) else { return Vec::new() };
        let border = self.bounds.grown(slack(self.bounds));
        if border.common(bounds).is_none() {
            return Vec::new();
        }
        if self.outline.is_none() && border.holds(bounds) {
            return vec![line.clone()];
        }
        line.parts(|piece| self.inside(piece))
    }

    /// The parts of a piece within this clip, from 0 at its beginning to 1 at its end.
    fn inside(&self, [a, b]: [DVec2; 2]) -> Vec<[f64; 2]> {
        let border = self.bounds.grown(slack(self.bounds));
        if self.outline.is_none() && border.has(a) && border.has(b) {
            return vec![[0.0, 1.0]];
        }
        let mut cuts = vec![0.0, 1.0];
        let mut cross = |[c, d]: [DVec2; 2]| {
            let (along, edge) = (b - a, d - c);
            let turn = along.perp_dot(edge);
            if turn != 0.0 {
                let (at, there) = ((c - a).perp_dot(edge) / turn, (c - a).perp_dot(along) / turn);
                if (0.0..=1.0).contains(&at) && (-1e-9..=1.0 + 1e-9).contains(&there) {
                    cuts.push(at);
                }
            }
        };
        match &self.outline {
            None => {
                let area = Area::rectangle(self.bounds);
                let ring = &area.rings[0];
                (0..4).for_each(|i| cross([ring[i], ring[(i + 1) % 4]]));
            }
            Some(outline) => outline.edges_between(a.y, b.y).for_each(|edge| cross(*edge)),
        }
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let is_inside = |middle: DVec2| {
            border.has(middle) && self.outline.as_ref().is_none_or(|outline| outline.has(middle))
        };
        let spans = cuts.windows(2).map(|pair| [pair[0], pair[1]]);
        spans.filter(|[from, to]| is_inside(a.lerp(b, (from + to) / 2.0))).collect()
    }
}

/// A ring cut at the sides of a rectangle (Sutherland and Hodgman). Where its parts are apart, the border between them
/// is run along there and back.
fn within(ring: &[DVec2], bounds: Bounds) -> Vec<DVec2> {
    let sides = [
        (DVec2::X, bounds.low),
        (DVec2::NEG_X, bounds.high),
        (DVec2::Y, bounds.low),
        (DVec2::NEG_Y, bounds.high),
    ];
    let mut ring = ring.to_vec();
    for (inwards, corner) in sides {
        let depth = |at: DVec2| (at - corner).dot(inwards);
        let mut inside = Vec::with_capacity(ring.len());
        for (i, &b) in ring.iter().enumerate() {
            let a = ring[(i + ring.len() - 1) % ring.len()];
            let (from, to) = (depth(a), depth(b));
            if (from < 0.0) != (to < 0.0) {
                inside.push(a.lerp(b, from / (from - to)));
            }
            if to >= 0.0 {
                inside.push(b);
            }
        }
        ring = inside;
    }
    ring
}

/// Rounding of coordinates, which are f32 in usvg.
fn slack(bounds: Bounds) -> f64 {
    1e-6 * bounds.low.abs().max(bounds.high.abs()).max_element()
}

/// Rings with their edges in rows, so that few are compared with a line.
#[derive(Debug)]
struct Outline {
    area: Area,
    bounds: Bounds,
    rows: Vec<Vec<[DVec2; 2]>>,
}

impl Outline {
    const MOST_ROWS: usize = 512;

    fn new(area: Area, bounds: Bounds) -> Self {
        let count = area.rings.iter().map(Vec::len).sum::<usize>();
        let rows = vec![Vec::new(); count.clamp(1, Self::MOST_ROWS)];
        let mut outline = Self { area, bounds, rows };
        for ring in std::mem::take(&mut outline.area.rings) {
            for (i, &a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % ring.len()];
                let [from, to] = outline.rows_of(a.y, b.y);
                outline.rows[from..=to].iter_mut().for_each(|row| row.push([a, b]));
            }
            outline.area.rings.push(ring);
        }
        outline
    }

    /// First and last row of the heights between two.
    fn rows_of(&self, a: f64, b: f64) -> [usize; 2] {
        let slack = slack(self.bounds);
        [self.row(a.min(b) - slack), self.row(a.max(b) + slack)]
    }

    fn row(&self, y: f64) -> usize {
        let part = (y - self.bounds.low.y) / self.bounds.size().y.max(f64::MIN_POSITIVE);
        ((part * self.rows.len() as f64).max(0.0) as usize).min(self.rows.len() - 1)
    }

    fn edges_between(&self, a: f64, b: f64) -> impl Iterator<Item = &[DVec2; 2]> {
        let [from, to] = self.rows_of(a, b);
        self.rows[from..=to].iter().flatten()
    }

    /// Whether a point is inside or on the border.
    fn has(&self, at: DVec2) -> bool {
        let slack = slack(self.bounds);
        if self.edges_between(at.y, at.y).any(|&edge| distance_to(edge, at) < slack) {
            return true;
        }
        let mut winding = 0;
        for &[a, b] in &self.rows[self.row(at.y)] {
            let is_left = (b - a).perp_dot(at - a) > 0.0;
            if a.y <= at.y && at.y < b.y && is_left {
                winding += 1;
            } else if b.y <= at.y && at.y < a.y && !is_left {
                winding -= 1;
            }
        }
        winding != 0
    }
}
