//! Shapes for measurements of solvers: letters, polygons and curves on the plane z = 0.1 m.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::scene::{Sampling, Scene, Shape, Target};

/// A shape in front of the default array.
#[derive(Clone, Copy, Debug)]
pub struct Drawing {
    pub name: &'static str,
    /// The shape at the position of its centre, m.
    shape: fn(DVec3) -> Shape,
}

/// A short run takes the first ones.
pub const DRAWINGS: [Drawing; 11] = [
    Drawing { name: "A", shape: |at| letters("A", at) },
    Drawing { name: "HIT", shape: |at| letters("HIT", at) },
    Drawing { name: "circle", shape: |at| Shape::Circle { at, radius: 0.025 } },
    Drawing { name: "star", shape: star },
    Drawing { name: "spiral", shape: spiral },
    Drawing { name: "H", shape: |at| letters("H", at) },
    Drawing { name: "S", shape: |at| letters("S", at) },
    Drawing { name: "square", shape: |at| Shape::Rectangle { at, width: 0.04, height: 0.04 } },
    Drawing { name: "triangle", shape: |at| Shape::Triangle { at, size: 0.05 } },
    Drawing { name: "heart", shape: heart },
    Drawing {
        name: "line",
        shape: |at| Shape::Line { from: at - 0.025 * DVec3::X, to: at + 0.025 * DVec3::X },
    },
];

impl Drawing {
    /// A scene with this shape alone, `moved` (m) along x.
    pub fn scene(&self, moved: f64, sampling: Sampling) -> Scene {
        let at = DVec3::new(moved, 0.0, 0.1);
        let target = Target { sampling, ..Target::new((self.shape)(at)) };
        Scene { targets: vec![target], ..Scene::default() }
    }
}

fn letters(text: &str, at: DVec3) -> Shape {
    Shape::Text { text: text.to_owned(), at, height: 0.045 }
}

fn star(at: DVec3) -> Shape {
    let vertex = |i: usize| at + polar([0.022, 0.01][i % 2], i as f64 / 10.0);
    Shape::Path { vertices: (0..10).map(vertex).collect(), closed: true }
}

fn spiral(at: DVec3) -> Shape {
    let vertex = |i: u32| {
        let part = f64::from(i) / 60.0;
        at + polar(0.005 + 0.015 * part, 1.5 * part)
    };
    Shape::Path { vertices: (0..=60).map(vertex).collect(), closed: false }
}

fn heart(at: DVec3) -> Shape {
    let vertex = |i: u32| {
        let t = TAU * f64::from(i) / 64.0;
        let y = 13.0 * t.cos() - 5.0 * (2.0 * t).cos() - 2.0 * (3.0 * t).cos() - (4.0 * t).cos();
        at + 1.2e-3 * DVec3::new(16.0 * t.sin().powi(3), y + 2.5, 0.0)
    };
    Shape::Path { vertices: (0..64).map(vertex).collect(), closed: true }
}

/// `turns` clockwise from the y axis.
fn polar(radius: f64, turns: f64) -> DVec3 {
    let (sin, cos) = (TAU * turns).sin_cos();
    DVec3::new(radius * sin, radius * cos, 0.0)
}
