//! Lines on surfaces: their sections by planes, and their outlines from a direction.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::mesh::closed::{Mesh, area_vector};

impl Mesh {
    /// The closed lines (m) along which the plane through a point across a normal cuts the surface.
    pub fn section(&self, point: DVec3, normal: DVec3) -> Vec<Vec<DVec3>> {
        let heights: Vec<_> = self.vertices.iter().map(|at| (*at - point).dot(normal)).collect();
        let is_above = |vertex: u32| heights[vertex as usize] >= 0.0;
        let mut next: BTreeMap<[u32; 2], Vec<[u32; 2]>> = BTreeMap::new();
        for corners in &self.triangles {
            // The edges along which the triangle's rim goes down, and up again.
            let crossing = |down: bool| {
                let edges = (0..3).map(|i| (corners[i], corners[(i + 1) % 3]));
                let mut crossed = edges.filter(|&(a, b)| is_above(a) == down && is_above(b) != down);
                crossed.next().map(|(a, b)| [a.min(b), a.max(b)])
            };
            if let (Some(from), Some(to)) = (crossing(true), crossing(false)) {
                next.entry(from).or_default().push(to);
            }
        }
        let place = |[a, b]: [u32; 2]| {
            let [from, to] = [a, b].map(|vertex| self.vertices[vertex as usize]);
            let [above, below] = [a, b].map(|vertex| heights[vertex as usize]);
            from.lerp(to, above / (above - below))
        };
        loops(next).into_iter().map(|line| line.into_iter().map(place).collect()).collect()
    }

    /// The closed lines (m) between what faces a direction and what faces away.
    pub fn silhouette(&self, direction: DVec3) -> Vec<Vec<DVec3>> {
        let faces: Vec<_> = (0..self.triangles.len())
            .map(|triangle| area_vector(self.corners(triangle)).dot(direction) > 0.0)
            .collect();
        let edges = self.edges();
        let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (corners, _) in self.triangles.iter().zip(&faces).filter(|(_, faces)| **faces) {
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                let beside = edges.get(&[a.min(b), a.max(b)]).into_iter().flatten();
                if beside.clone().any(|&triangle| !faces[triangle as usize]) {
                    next.entry(a).or_default().push(b);
                }
            }
        }
        let place = |vertex: u32| self.vertices[vertex as usize];
        loops(next).into_iter().map(|line| line.into_iter().map(place).collect()).collect()
    }

    /// Unit normals at the vertices: the mean of their triangles', by area.
    pub fn normals(&self) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        for (triangle, corners) in self.triangles.iter().enumerate() {
            let area = area_vector(self.corners(triangle));
            corners.iter().for_each(|&vertex| sums[vertex as usize] += area);
        }
        sums.into_iter().map(DVec3::normalize_or_zero).collect()
    }
}

/// Chains of steps that lead back to their beginning.
fn loops<K: Copy + Ord>(mut next: BTreeMap<K, Vec<K>>) -> Vec<Vec<K>> {
    let mut all = Vec::new();
    while let Some((&first, _)) = next.first_key_value() {
        let (mut line, mut at) = (Vec::new(), first);
        while let Some(steps) = next.get_mut(&at) {
            line.push(at);
            let step = steps.pop();
            if steps.is_empty() {
                next.remove(&at);
            }
            match step {
                Some(step) if step != first => at = step,
                Some(_) | None => break,
            }
        }
        if line.len() > 2 {
            all.push(line);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::mesh::shapes;

    fn length(line: &[DVec3]) -> f64 {
        (0..line.len()).map(|i| line[i].distance(line[(i + 1) % line.len()])).sum()
    }

    #[test]
    fn sections_and_silhouettes_of_a_ball_are_circles() {
        let ball = shapes::sphere(1.0, 0.1);
        let normal = DVec3::new(0.3, -0.4, 0.8).normalize_or_zero();
        for height in [0.0, 0.3, -0.8] {
            let lines = ball.section(normal * height, normal);
            let radius = f64::sqrt(1.0 - height * height);
            assert_eq!(lines.len(), 1);
            assert!(lines[0].iter().all(|at| (at.dot(normal) - height).abs() < 1e-12));
            assert!((length(&lines[0]) / (TAU * radius) - 1.0).abs() < 0.01, "{height}");
        }
        assert!(ball.section(normal * 1.1, normal).is_empty());
        let outline = ball.silhouette(normal);
        assert_eq!(outline.len(), 1);
        assert!(outline[0].iter().all(|at| at.dot(normal).abs() < 0.1));
    }

    #[test]
    fn a_plane_may_cut_a_surface_in_several_lines() {
        let part = |x: f64| shapes::sphere(0.01, 0.003).mapped(|at| at + DVec3::X * x);
        let (mut both, other) = (part(0.0), part(0.05));
        let first = both.vertices.len() as u32;
        both.vertices.extend(other.vertices);
        both.triangles.extend(other.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
        assert_eq!(both.section(DVec3::ZERO, DVec3::Z).len(), 2);
        assert_eq!(both.section(DVec3::ZERO, DVec3::X).len(), 1);
    }
}
