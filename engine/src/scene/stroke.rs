//! A target as drawn: its polylines, its handles, and its rotation.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use crate::scene::range::{KeyError, refuse};
use crate::scene::run::Vertex;
use crate::scene::shape::{ARROW, SMALLEST};
use crate::scene::{font, shape::Shape, target::Target};

/// Vertices of a path that get a handle each; of more, the box around them gets one.
const FEW: usize = 24;
/// Vertices of a drawn circle.
const CIRCLE_VERTICES: usize = 96;

/// The polylines of a target, as drawn.
///
/// # Errors
/// A glyph that the font lacks.
pub fn strokes(target: &Target) -> Result<Vec<Vec<DVec3>>, KeyError> {
    let (centre, turn) = (target.shape.centre(), target.turn());
    let placed = |vertex: &DVec2| centre + turn * vertex.extend(0.0);
    let flat = |outline: Vec<DVec2>| vec![outline.iter().map(placed).collect()];
    Ok(match &target.shape {
        Shape::Point { at } | Shape::Trap { at, .. } => vec![vec![*at]],
        Shape::Direction { .. } => arrow(centre),
        Shape::Line { .. } => vec![target.placed()],
        Shape::Path { .. } => vec![path(target).iter().map(|vertex| vertex.at).collect()],
        Shape::Circle { radius, .. } => flat(ring(*radius, CIRCLE_VERTICES, 0.0)),
        Shape::Rectangle { width, height, .. } => flat(frame(*width, *height)),
        Shape::Picture { width, pixels, .. } => flat(frame(*width, width * pixels.aspect())),
        Shape::Triangle { size, .. } => flat(ring(size / 3.0_f64.sqrt(), 3, TAU / 4.0)),
        Shape::Polygon { radius, sides, .. } => flat(ring(*radius, *sides as usize, TAU / 4.0)),
        Shape::Text { text, height, .. } => font::lay_out(text, *height)
            .or_else(|glyph| {
                refuse("text", format!("the stroke font has no glyph for `{}`", glyph.escape_debug()))
            })?
            .iter()
            .map(|stroke| stroke.iter().map(placed).collect())
            .collect(),
    })
}

/// The vertices of a path, as drawn, with their target pressures.
pub(crate) fn path(target: &Target) -> Vec<Vertex> {
    let Shape::Path { closed, .. } = &target.shape else { return Vec::new() };
    let pressures = target.pressures.iter().copied().chain(std::iter::repeat(1.0));
    let vertex = |(at, pressure)| Vertex { at, pressure };
    let mut vertices: Vec<_> = target.placed().into_iter().zip(pressures).map(vertex).collect();
    vertices.dedup_by(|next, vertex| next.at == vertex.at);
    if *closed && vertices.first().map(|first| first.at) != vertices.last().map(|last| last.at) {
        vertices.push(vertices[0]);
    }
    vertices
}

impl Target {
    /// The points of its shape, rotated about its centre.
    fn placed(&self) -> Vec<DVec3> {
        let (centre, turn) = (self.shape.centre(), DQuat::from_rotation_z(self.angle));
        self.shape.clone().points().into_iter().map(|at| centre + turn * (*at - centre)).collect()
    }

    /// The handles that resize it.
    pub fn handles(&self) -> Vec<DVec3> {
        let corners = match &self.shape {
            Shape::Point { .. } | Shape::Trap { .. } => 0,
            Shape::Direction { .. } => return vec![self.shape.centre()],
            Shape::Circle { .. } | Shape::Triangle { .. } | Shape::Polygon { .. } => 1,
            Shape::Rectangle { .. } => 4,
            Shape::Line { .. } => return self.placed(),
            Shape::Path { vertices, .. } if vertices.len() <= FEW => return self.placed(),
            Shape::Path { .. } | Shape::Text { .. } | Shape::Picture { .. } => {
                return self.corner().into_iter().collect();
            }
        };
        strokes(self).unwrap_or_default().into_iter().flatten().take(corners).collect()
    }

    /// The upper right corner of the box around it, in its own plane.
    fn corner(&self) -> Option<DVec3> {
        let (centre, turn) = (self.shape.centre(), self.turn());
        let points = strokes(self).ok()?.concat();
        let high = points.into_iter().map(|point| turn.inverse() * (point - centre)).reduce(DVec3::max)?;
        Some(centre + turn * DVec3::new(high.x, high.y, 0.0))
    }

    /// Moves one of its handles.
    pub fn pull(&mut self, handle: usize, to: DVec3) {
        let (centre, turn, ends) = (self.shape.centre(), self.turn(), self.handles());
        let flat = |from: DVec3, to: DVec3| (turn.inverse() * (to - from)).truncate();
        let reach = flat(centre, to).length().max(SMALLEST);
        match &mut self.shape {
            Shape::Point { .. } | Shape::Trap { .. } => {}
            Shape::Direction { .. } => self.shape.move_to(to),
            Shape::Circle { radius, .. } | Shape::Polygon { radius, .. } => *radius = reach,
            Shape::Triangle { size, .. } => *size = reach * 3.0_f64.sqrt(),
            Shape::Rectangle { at, width, height } => {
                // The opposite corner stays.
                let Some(&opposite) = ends.get((handle + 2) % 4) else { return };
                let across = flat(opposite, to);
                let size = across.abs().max(DVec2::splat(SMALLEST));
                let signs = DVec2::new(1.0_f64.copysign(across.x), 1.0_f64.copysign(across.y));
                (*width, *height) = (size.x, size.y);
                *at = opposite + turn * (size * signs / 2.0).extend(0.0);
            }
            Shape::Line { .. } if ends[1 - handle.min(1)].distance(to) < SMALLEST => {}
            Shape::Path { vertices, .. } if vertices.len() > FEW => self.enlarge(centre, flat(centre, to)),
            Shape::Text { .. } | Shape::Picture { .. } => self.enlarge(centre, flat(centre, to)),
            Shape::Line { .. } | Shape::Path { .. } => {
                for (index, (at, end)) in self.shape.points().into_iter().zip(ends).enumerate() {
                    *at = if index == handle { to } else { end };
                }
                self.angle = 0.0;
            }
        }
    }

    /// Scales it so that the corner of its box goes to a point of its plane, from its centre.
    fn enlarge(&mut self, centre: DVec3, to: DVec2) {
        let corner = self.corner().unwrap_or(centre) - centre;
        let own = (self.turn().inverse() * corner).truncate();
        let extent = own.length();
        let factor =
            if extent < 1e-9 { 1.0 } else { (to.dot(own) / (extent * extent)).max(SMALLEST / extent) };
        self.shape.scale(factor, |at| *at = centre + (*at - centre) * factor);
    }

    /// Rotates it about a point (m).
    pub fn rotate(&mut self, about: DVec3, turn: DQuat) {
        let (placed, facing) = (self.placed(), turn * self.turn());
        for (at, placed) in self.shape.points().into_iter().zip(placed) {
            *at = about + turn * (placed - about);
        }
        self.angle = 0.0;
        if let Shape::Direction { direction } = &mut self.shape {
            *direction = turn * *direction;
        }
        if self.shape.is_flat() {
            self.face(facing * DVec3::Z, facing * DVec3::X);
        }
    }

    /// Sets normal and angle of a flat shape from its axes.
    pub fn face(&mut self, normal: DVec3, x: DVec3) {
        self.normal = if normal.distance(DVec3::Z) < 1e-9 { DVec3::Z } else { normal };
        self.angle = 0.0;
        let x = self.turn().inverse() * x;
        self.angle = x.y.atan2(x.x);
    }
}

/// The arrow of a direction, from the origin to its tip, with a head that is seen from all sides.
fn arrow(tip: DVec3) -> Vec<Vec<DVec3>> {
    /// Of its length.
    const HEAD: f64 = 0.14;
    let (across, other) = tip.normalize_or(DVec3::Z).any_orthonormal_pair();
    let barb = |side: DVec3| tip * (1.0 - HEAD) + side * (0.4 * HEAD * ARROW);
    let head = |side: DVec3| vec![barb(side), tip, barb(-side)];
    vec![vec![DVec3::ZERO, tip], head(across), head(other)]
}

/// A rectangle about the origin.
fn frame(width: f64, height: f64) -> Vec<DVec2> {
    let (x, y) = (width / 2.0, height / 2.0);
    [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)].map(DVec2::from).to_vec()
}

/// A closed regular polygon about the origin, first vertex at `start`.
fn ring(radius: f64, vertices: usize, start: f64) -> Vec<DVec2> {
    let vertex = |i: usize| DVec2::from_angle(start + TAU * (i % vertices) as f64 / vertices as f64) * radius;
    (0..=vertices).map(vertex).collect()
}
