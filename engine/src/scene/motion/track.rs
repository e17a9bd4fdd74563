//! Polylines and circles parametrised by arc length, for motion at constant speed.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::scene::run::Vertex;

/// A line from start to end.
#[derive(Clone, Debug)]
pub(super) enum Track {
    /// A full circle from `x` through `y`, orthogonal vectors of the radius' length; m.
    Circle { centre: Vertex, x: DVec3, y: DVec3 },
    /// `distances` are m from the first vertex to each.
    Polyline { vertices: Vec<Vertex>, distances: Vec<f64> },
}

impl Track {
    pub fn through(vertices: Vec<Vertex>) -> Self {
        let mut distance = 0.0;
        let to_next = vertices.windows(2).map(|pair| {
            distance += pair[0].at.distance(pair[1].at);
            distance
        });
        let distances = std::iter::once(0.0).chain(to_next).collect();
        Self::Polyline { vertices, distances }
    }

    /// A closed polyline.
    pub fn round(places: impl IntoIterator<Item = DVec3>) -> Self {
        let mut vertices: Vec<_> = places.into_iter().map(|at| Vertex { at, pressure: 1.0 }).collect();
        vertices.extend(vertices.first().copied());
        Self::through(vertices)
    }

    /// m
    pub fn length(&self) -> f64 {
        match self {
            Self::Circle { x, .. } => TAU * x.length(),
            Self::Polyline { distances, .. } => distances.last().copied().unwrap_or(0.0),
        }
    }

    /// The point at a distance (m) from the start, clamped to the end.
    pub fn at(&self, distance: f64) -> Vertex {
        match self {
            Self::Circle { centre, x, y } => {
                let (sin, cos) = (distance / x.length()).sin_cos();
                Vertex { at: centre.at + *x * cos + *y * sin, ..*centre }
            }
            Self::Polyline { vertices, distances } => {
                let next = distances.partition_point(|&d| d <= distance);
                match (vertices.get(next.wrapping_sub(1)), vertices.get(next)) {
                    (Some(from), Some(to)) => {
                        let length = distances[next] - distances[next - 1];
                        from.lerp(*to, (distance - distances[next - 1]) / length)
                    }
                    (Some(&end), None) => end,
                    (None, start) => start.copied().unwrap_or(Vertex { at: DVec3::ZERO, pressure: 1.0 }),
                }
            }
        }
    }

    /// The lowest point along a direction.
    pub fn lowest(&self, up: DVec3) -> DVec3 {
        match self {
            Self::Circle { centre, x, y } => {
                let down = f64::atan2(-y.dot(up), -x.dot(up));
                centre.at + *x * down.cos() + *y * down.sin()
            }
            Self::Polyline { vertices, .. } => {
                let places = vertices.iter().map(|vertex| vertex.at);
                places.min_by(|a, b| a.dot(up).total_cmp(&b.dot(up))).unwrap_or(DVec3::ZERO)
            }
        }
    }
}
