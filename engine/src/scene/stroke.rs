//! The polylines of a target, as drawn.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use crate::scene::range::{Key, KeyError};
use crate::scene::run::Vertex;
use crate::scene::{Shape, Target, font};

/// Vertices of a drawn circle.
const CIRCLE_VERTICES: usize = 96;

/// The polylines of a target, as drawn.
///
/// # Errors
/// A glyph that the font lacks.
pub fn strokes(target: &Target) -> Result<Vec<Vec<DVec3>>, KeyError> {
    let centre = centre(&target.shape);
    let turn = target.turn();
    let placed = |vertex: &DVec2| centre + turn * vertex.extend(0.0);
    let flat = |outline: Vec<DVec2>| vec![outline.iter().map(placed).collect()];
    let turned = |vertex: &DVec3| centre + DQuat::from_rotation_z(target.angle) * (*vertex - centre);
    Ok(match &target.shape {
        Shape::Point { at } | Shape::Trap { at, .. } => vec![vec![*at]],
        Shape::Line { from, to } => vec![[*from, *to].iter().map(turned).collect()],
        Shape::Path { .. } => vec![path(target).iter().map(|vertex| vertex.at).collect()],
        Shape::Circle { radius, .. } => flat(ring(*radius, CIRCLE_VERTICES, 0.0)),
        Shape::Rectangle { width, height, .. } => {
            let (x, y) = (width / 2.0, height / 2.0);
            flat([(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)].map(DVec2::from).to_vec())
        }
        Shape::Picture { width, pixels, .. } => {
            let (x, y) = (width / 2.0, width * pixels.aspect() / 2.0);
            flat([(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)].map(DVec2::from).to_vec())
        }
        Shape::Triangle { size, .. } => flat(ring(size / 3.0_f64.sqrt(), 3, TAU / 4.0)),
        Shape::Polygon { radius, sides, .. } => flat(ring(*radius, *sides as usize, TAU / 4.0)),
        Shape::Text { text, height, .. } => font::lay_out(text, *height)
            .map_err(|glyph| {
                refusal("text", format!("the stroke font has no glyph for `{}`", glyph.escape_debug()))
            })?
            .iter()
            .map(|stroke| stroke.iter().map(placed).collect())
            .collect(),
    })
}

/// The vertices of a path, as drawn, with their target pressures.
pub(crate) fn path(target: &Target) -> Vec<Vertex> {
    let Shape::Path { vertices, closed } = &target.shape else { return Vec::new() };
    let (centre, turn) = (centre(&target.shape), DQuat::from_rotation_z(target.angle));
    let vertex = |(i, at): (usize, &DVec3)| Vertex {
        at: centre + turn * (*at - centre),
        pressure: target.pressures.get(i).copied().unwrap_or(1.0),
    };
    let mut vertices: Vec<_> = vertices.iter().enumerate().map(vertex).collect();
    vertices.dedup_by(|next, vertex| next.at == vertex.at);
    if *closed && vertices.first().map(|first| first.at) != vertices.last().map(|last| last.at) {
        vertices.push(vertices[0]);
    }
    vertices
}

/// The centre of rotation of a target.
pub fn centre(shape: &Shape) -> DVec3 {
    match shape {
        Shape::Point { at }
        | Shape::Trap { at, .. }
        | Shape::Circle { at, .. }
        | Shape::Rectangle { at, .. }
        | Shape::Triangle { at, .. }
        | Shape::Polygon { at, .. }
        | Shape::Text { at, .. }
        | Shape::Picture { at, .. } => *at,
        Shape::Line { from, to } => (*from + *to) / 2.0,
        Shape::Path { vertices, .. } => vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64,
    }
}

impl Shape {
    /// The centre of rotation, which is also its position for edits; m.
    pub fn centre(&self) -> DVec3 {
        centre(self)
    }

    /// Moves its centre to this point (m).
    pub fn move_to(&mut self, place: DVec3) {
        match self {
            Self::Point { at }
            | Self::Trap { at, .. }
            | Self::Circle { at, .. }
            | Self::Rectangle { at, .. }
            | Self::Triangle { at, .. }
            | Self::Polygon { at, .. }
            | Self::Text { at, .. }
            | Self::Picture { at, .. } => *at = place,
            Self::Line { .. } | Self::Path { .. } => self.translate(place - self.centre()),
        }
    }

    /// Moves it (m).
    pub fn translate(&mut self, by: DVec3) {
        match self {
            Self::Point { at }
            | Self::Trap { at, .. }
            | Self::Circle { at, .. }
            | Self::Rectangle { at, .. }
            | Self::Triangle { at, .. }
            | Self::Polygon { at, .. }
            | Self::Text { at, .. }
            | Self::Picture { at, .. } => *at += by,
            Self::Line { from, to } => {
                *from += by;
                *to += by;
            }
            Self::Path { vertices, .. } => vertices.iter_mut().for_each(|vertex| *vertex += by),
        }
    }
}

/// A closed regular polygon about the origin, first vertex at `start`.
fn ring(radius: f64, vertices: usize, start: f64) -> Vec<DVec2> {
    let vertex = |i: usize| DVec2::from_angle(start + TAU * (i % vertices) as f64 / vertices as f64) * radius;
    (0..=vertices).map(vertex).collect()
}

fn refusal(key: &'static str, message: impl Into<String>) -> KeyError {
    KeyError::new([Key::from(key)], message)
}
