//! Whether points are inside a closed surface, quickly.
//!
//! The number of turns of the surface around a point is the number of triangles that a line from there upwards leaves
//! through, less those through which it enters. Triangles stand in columns of cells. On which side of a triangle's edge
//! the line passes depends on the edge alone: its two triangles agree, so a line never slips between them. A line exactly
//! on an edge or a vertex counts as one beside it, at (ε, ε²) (H. Edelsbrunner, E. Mücke, ACM Trans. Graph. 9, 66, 1990).

use glam::{DVec2, DVec3};

use crate::mesh::closed::Mesh;

/// Columns of a surface's triangles.
#[derive(Clone, Debug)]
pub(crate) struct Inside {
    low: DVec3,
    high: DVec3,
    /// Cells per m.
    scale: DVec2,
    counts: [usize; 2],
    /// Where each cell's triangles begin.
    starts: Vec<u32>,
    members: Vec<u32>,
    mesh: Mesh,
}

impl Inside {
    pub fn new(mesh: &Mesh) -> Self {
        let (low, high) = mesh.extent();
        let size = (high - low).truncate().max(DVec2::splat(f64::MIN_POSITIVE));
        // As many cells as triangles, nearly square.
        let side = (size.x * size.y / mesh.triangles.len().max(1) as f64).sqrt();
        let counts = (size / side).to_array().map(|count| (count.ceil() as usize).clamp(1, 4096));
        let scale = DVec2::new(counts[0] as f64, counts[1] as f64) / size;
        let mut inside =
            Self { low, high, scale, counts, starts: Vec::new(), members: Vec::new(), mesh: mesh.clone() };
        let mut cells = vec![Vec::new(); counts[0] * counts[1]];
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            let (from, to) = (inside.cell(a.min(b).min(c)), inside.cell(a.max(b).max(c)));
            for row in from[1]..=to[1] {
                for column in from[0]..=to[0] {
                    cells[row * counts[0] + column].push(triangle as u32);
                }
            }
        }
        let mut start = 0;
        for cell in &cells {
            inside.starts.push(start);
            start += cell.len() as u32;
        }
        inside.starts.push(start);
        inside.members = cells.concat();
        inside
    }

    /// Whether a point (m) is inside.
    pub fn contains(&self, at: DVec3) -> bool {
        if !(at.cmpge(self.low).all() && at.cmple(self.high).all()) {
            return false;
        }
        let [column, row] = self.cell(at);
        let cell = row * self.counts[0] + column;
        let members = &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        members.iter().map(|&triangle| self.turns(triangle as usize, at)).sum::<i32>() > 0
    }

    fn cell(&self, at: DVec3) -> [usize; 2] {
        let cell = (at - self.low).truncate() * self.scale;
        [0, 1].map(|axis| (cell[axis].max(0.0) as usize).min(self.counts[axis] - 1))
    }

    /// 1 where a line upwards from a point leaves through a triangle, -1 where it enters, or 0.
    fn turns(&self, triangle: usize, at: DVec3) -> i32 {
        let corners = self.mesh.corners(triangle);
        if corners[0].z.max(corners[1].z).max(corners[2].z) <= at.z {
            return 0;
        }
        let numbers = self.mesh.triangles[triangle];
        let left = [0, 1, 2].map(|i| {
            let j = (i + 1) % 3;
            match numbers[i] < numbers[j] {
                true => is_left(corners[i], corners[j], at),
                false => !is_left(corners[j], corners[i], at),
            }
        });
        if left[0] != left[1] || left[1] != left[2] {
            return 0;
        }
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let is_below = (at - a).dot(normal) < 0.0;
        match (left[0], is_below) {
            (true, true) => 1,
            (false, false) => -1,
            (true, false) | (false, true) => 0,
        }
    }
}

/// Whether a point is left of the line from a to b, all seen from above.
fn is_left(a: DVec3, b: DVec3, at: DVec3) -> bool {
    let (along, to) = ((b - a).truncate(), (at - a).truncate());
    let area = along.perp_dot(to);
    if area == 0.0 { -along.y > 0.0 || (along.y == 0.0 && along.x > 0.0) } else { area > 0.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::dvec3;

    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn points_are_inside_where_the_solid_angle_says_so() {
        let unit = |i: usize, step: f64| (i as f64 * step).fract() - 0.5;
        let meshes = [
            shapes::hand(dvec3(0.1, 0.085, 0.025), [20.0, 5.0, 60.0, 90.0, 170.0], 4e-3),
            shapes::sphere(0.01, 3e-3),
            shapes::slab(dvec3(0.03, 0.02, 0.01), 0.005, 2e-3),
        ];
        for mesh in meshes {
            let inside = Inside::new(&mesh);
            let (low, high) = mesh.extent();
            let (middle, size) = (low.midpoint(high), 1.1 * (high - low));
            let spread = (0..1500)
                .map(|i| middle + size * dvec3(unit(i, 0.819_173), unit(i, 0.671_044), unit(i, 0.549_7)));
            // Lines through vertices and edges.
            let exact = mesh.vertices.iter().step_by(7).map(|at| at.with_z(middle.z));
            let corners = (0..mesh.triangles.len()).step_by(7).map(|t| mesh.corners(t));
            let edges = corners.map(|[a, b, _]| a.midpoint(b).with_z(middle.z));
            let mut count = 0;
            for at in spread.chain(exact).chain(edges).chain([DVec3::ZERO.with_z(middle.z)]) {
                let angle = mesh.solid_angle(at);
                // On the surface itself, any answer is right.
                if angle.abs() < 0.1 || (angle - 4.0 * PI).abs() < 0.1 {
                    assert_eq!(inside.contains(at), angle > 1.0, "{at}");
                    count += usize::from(angle > 1.0);
                }
            }
            assert!(count > 200, "{count} inside");
        }
    }
}
