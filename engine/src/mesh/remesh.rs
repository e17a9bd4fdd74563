//! Edges of a wanted length: long ones are divided, short ones collapse, and triangles become nearly regular.
//!
//! Divided edges keep the surface. An edge collapses to the one of its ends and its middle that is nearest to the planes
//! of all triangles that it replaces (M. Garland, P. S. Heckbert, SIGGRAPH 1997), if the surface stays a surface, no
//! triangle turns over, and the place is within a tenth of the wanted edge of those planes. Then edges opposite to wide
//! angles flip, and vertices of smooth parts move along the surface to the middle of their neighbours (M. Botsch,
//! L. Kobbelt, Symp. Geometry Processing 2004).

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;

use crate::mesh::closed::{Mesh, area_vector};

/// Longest edges, relative to the wanted one.
const LONGEST: f64 = 4.0 / 3.0;
/// Edges that collapse.
const SHORTEST: f64 = 0.6;
/// Distance from the planes of the surface, relative to the wanted edge.
const OFF: f64 = 0.1;
/// Cosine of the angle by which a triangle may turn.
const LEAST_COSINE: f64 = 0.4;
/// Cosine of the angle by which a triangle of a smooth part may turn.
const SMOOTH: f64 = 0.8;
/// Rounds of collapses.
const ROUNDS: usize = 40;
/// Rounds of flips, moves and collapses.
const SMOOTHINGS: usize = 3;

impl Mesh {
    /// The surface with edges of at most 4/3 of a length (m), and few of less than 0.6 of it where the shape needs none.
    pub fn with_edges(&self, edge: f64) -> Self {
        let coarse = Coarsening::new(self, edge).finish();
        coarse.divided(LONGEST * edge)
    }

    /// All edges longer than a limit (m) halved until there are none.
    fn divided(mut self, limit: f64) -> Self {
        loop {
            let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
            for corners in &self.triangles {
                for i in 0..3 {
                    let (a, b) = (corners[i], corners[(i + 1) % 3]);
                    let ends = [a, b].map(|vertex| self.vertices[vertex as usize]);
                    let key = [a.min(b), a.max(b)];
                    if ends[0].distance(ends[1]) > limit && !middles.contains_key(&key) {
                        middles.insert(key, self.vertices.len() as u32);
                        self.vertices.push(ends[0].midpoint(ends[1]));
                    }
                }
            }
            if middles.is_empty() {
                return self;
            }
            let middle = |a: u32, b: u32| middles.get(&[a.min(b), a.max(b)]).copied();
            let mut triangles = Vec::with_capacity(2 * self.triangles.len());
            for &[a, b, c] in &self.triangles {
                let length = |a: u32, b: u32| self.vertices[a as usize].distance(self.vertices[b as usize]);
                match [middle(a, b), middle(b, c), middle(c, a)] {
                    [None, None, None] => triangles.push([a, b, c]),
                    [Some(m), None, None] => triangles.extend([[a, m, c], [m, b, c]]),
                    [None, Some(m), None] => triangles.extend([[a, b, m], [a, m, c]]),
                    [None, None, Some(m)] => triangles.extend([[a, b, m], [m, b, c]]),
                    [Some(p), Some(q), None] => triangles.extend(quad([a, p, q, c], [p, b, q], length)),
                    [None, Some(q), Some(r)] => triangles.extend(quad([b, q, r, a], [q, c, r], length)),
                    [Some(p), None, Some(r)] => triangles.extend(quad([c, r, p, b], [r, a, p], length)),
                    [Some(p), Some(q), Some(r)] => {
                        triangles.extend([[a, p, r], [p, b, q], [r, q, c], [p, q, r]]);
                    }
                }
            }
            self.triangles = triangles;
        }
    }
}

/// A corner cut off a triangle, and the rest divided by its shorter diagonal.
fn quad([a, b, c, d]: [u32; 4], corner: [u32; 3], length: impl Fn(u32, u32) -> f64) -> [[u32; 3]; 3] {
    match length(a, c) < length(b, d) {
        true => [corner, [a, b, c], [a, c, d]],
        false => [corner, [a, b, d], [b, c, d]],
    }
}

/// The squared distances from planes, weighted by area, as a quadratic function.
#[derive(Clone, Copy, Debug, Default)]
struct Quadric {
    /// Σ w n nᵀ, Σ w h n, Σ w h² and Σ w, with n·x = h on the plane.
    normals: [[f64; 3]; 3],
    heights: DVec3,
    square: f64,
    weight: f64,
}

impl Quadric {
    fn of(corners: [DVec3; 3]) -> Self {
        let vector = area_vector(corners);
        let (weight, normal) = (vector.length(), vector.normalize_or_zero());
        let height = normal.dot(corners[0]);
        let n = normal.to_array();
        Self {
            normals: [0, 1, 2].map(|i| [0, 1, 2].map(|j| weight * n[i] * n[j])),
            heights: normal * (weight * height),
            square: weight * height * height,
            weight,
        }
    }

    fn add(&mut self, other: &Self) {
        for i in 0..3 {
            for j in 0..3 {
                self.normals[i][j] += other.normals[i][j];
            }
        }
        self.heights += other.heights;
        self.square += other.square;
        self.weight += other.weight;
    }

    /// The mean squared distance (m²).
    fn at(&self, x: DVec3) -> f64 {
        let v = x.to_array();
        let twice: f64 = (0..3).map(|i| (0..3).map(|j| v[i] * self.normals[i][j] * v[j]).sum::<f64>()).sum();
        ((twice - 2.0 * x.dot(self.heights) + self.square) / self.weight.max(f64::MIN_POSITIVE)).max(0.0)
    }
}

/// A mesh whose short edges collapse.
struct Coarsening {
    /// m
    edge: f64,
    mesh: Mesh,
    is_alive: Vec<bool>,
    /// Triangles around each vertex.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    /// The middle of the box, near which places keep their digits.
    origin: DVec3,
}

impl Coarsening {
    fn new(mesh: &Mesh, edge: f64) -> Self {
        let (low, high) = mesh.extent();
        let origin = low.midpoint(high);
        let mesh = mesh.clone().mapped(|at| at - origin);
        let mut around = vec![Vec::new(); mesh.vertices.len()];
        let mut quadrics = vec![Quadric::default(); mesh.vertices.len()];
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            let quadric = Quadric::of(mesh.corners(triangle));
            for &vertex in corners {
                around[vertex as usize].push(triangle as u32);
                quadrics[vertex as usize].add(&quadric);
            }
        }
        let is_alive = vec![true; mesh.triangles.len()];
        Self { edge, mesh, is_alive, around, quadrics, origin }
    }

    fn finish(mut self) -> Mesh {
        for _ in 0..ROUNDS {
            if !self.round() {
                break;
            }
        }
        for _ in 0..SMOOTHINGS {
            self.flip_edges();
            self.centre_vertices();
            self.round();
        }
        let Self { mesh, is_alive, origin, .. } = self;
        let alive = mesh.triangles.iter().zip(&is_alive).filter(|(_, alive)| **alive);
        let triangles = alive.map(|(corners, _)| *corners).collect();
        Mesh { vertices: mesh.vertices, triangles }.without_unused().mapped(|at| at + origin)
    }

    /// Collapses short edges, the shortest first, and says whether it found any.
    fn round(&mut self) -> bool {
        let mut edges = Vec::new();
        for (corners, _) in self.mesh.triangles.iter().zip(&self.is_alive).filter(|(_, alive)| **alive) {
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                let length = self.place(a).distance(self.place(b));
                if a < b && length < SHORTEST * self.edge {
                    // Bits of positive numbers are in the sequence of the numbers.
                    edges.push((length.to_bits(), a, b));
                }
            }
        }
        edges.sort_unstable();
        let mut found = false;
        for (length, a, b) in edges {
            if self.place(a).distance(self.place(b)).to_bits() == length {
                found |= self.collapse(a, b);
            }
        }
        found
    }

    fn place(&self, vertex: u32) -> DVec3 {
        self.mesh.vertices[vertex as usize]
    }

    /// In ascending order.
    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let corners = self.around[vertex as usize].iter().flat_map(|&t| self.mesh.triangles[t as usize]);
        let mut others: Vec<u32> = corners.filter(|other| *other != vertex).collect();
        others.sort_unstable();
        others.dedup();
        others
    }

    /// The triangles on both sides of an edge.
    fn beside(&self, a: u32, b: u32) -> Vec<u32> {
        let other = &self.around[b as usize];
        self.around[a as usize].iter().copied().filter(|triangle| other.contains(triangle)).collect()
    }

    /// Area vectors of a triangle without and with some corners moved to a place.
    fn turned(&self, triangle: u32, moved: impl Fn(u32) -> bool, to: DVec3) -> [DVec3; 2] {
        let before = self.mesh.corners(triangle as usize);
        let corners = self.mesh.triangles[triangle as usize];
        let after = [0, 1, 2].map(|i| if moved(corners[i]) { to } else { before[i] });
        [area_vector(before), area_vector(after)]
    }

    /// Flips edges opposite to two angles of more than half a turn, where the surface is smooth.
    fn flip_edges(&mut self) {
        for triangle in 0..self.mesh.triangles.len() {
            for i in 0..3 {
                if self.is_alive[triangle] {
                    let corners = self.mesh.triangles[triangle];
                    self.flip(corners[i], corners[(i + 1) % 3]);
                }
            }
        }
    }

    fn flip(&mut self, a: u32, b: u32) {
        let [first, second] = self.beside(a, b)[..] else { return };
        // The first runs from a to b.
        let runs = |t: u32| {
            let corners = self.mesh.triangles[t as usize];
            (0..3).any(|i| corners[i] == a && corners[(i + 1) % 3] == b)
        };
        let (first, second) = if runs(first) { (first, second) } else { (second, first) };
        let opposite = |t: u32| self.mesh.triangles[t as usize].into_iter().find(|v| *v != a && *v != b);
        let (Some(c), Some(d)) = (opposite(first), opposite(second)) else { return };
        let [pa, pb, pc, pd] = [a, b, c, d].map(|vertex| self.place(vertex));
        let angles = (pa - pc).angle_between(pb - pc) + (pa - pd).angle_between(pb - pd);
        if angles < PI + 1e-6 || pc.distance(pd) > LONGEST * self.edge {
            return;
        }
        let old = [[pa, pb, pc], [pb, pa, pd]].map(area_vector);
        let new = [[pa, pd, pc], [pb, pc, pd]].map(area_vector);
        // A sliver has no normal worth a comparison.
        let least = 1e-3 * self.edge.powi(2);
        let is_alike = |new: DVec3| {
            let alike = |old: &DVec3| old.dot(new) > SMOOTH * old.length() * new.length();
            new.length() > least && old.iter().all(|own| own.length() < least || alike(own))
        };
        let few = [a, b].iter().any(|&vertex| self.around[vertex as usize].len() < 4);
        if c == d || few || !new.into_iter().all(is_alike) || !self.beside(c, d).is_empty() {
            return;
        }
        self.mesh.triangles[first as usize] = [a, d, c];
        self.mesh.triangles[second as usize] = [b, c, d];
        self.around[a as usize].retain(|t| *t != second);
        self.around[b as usize].retain(|t| *t != first);
        self.around[c as usize].push(second);
        self.around[d as usize].push(first);
    }

    /// Moves vertices of smooth parts along the surface to the middle of their neighbours.
    fn centre_vertices(&mut self) {
        for vertex in 0..self.mesh.vertices.len() as u32 {
            let around = &self.around[vertex as usize];
            let vectors = around.iter().map(|&t| area_vector(self.mesh.corners(t as usize)));
            let normal = vectors.clone().sum::<DVec3>().normalize_or_zero();
            let neighbours = self.neighbours(vertex);
            if neighbours.is_empty() || vectors.clone().any(|own| own.dot(normal) < SMOOTH * own.length()) {
                continue;
            }
            let own = self.place(vertex);
            let sum: DVec3 = neighbours.iter().map(|&other| self.place(other)).sum();
            let to = own + (sum / neighbours.len() as f64 - own).reject_from_normalized(normal);
            let longest = LONGEST * self.edge;
            let fits = |&triangle: &u32| {
                let [old, new] = self.turned(triangle, |corner| corner == vertex, to);
                new.dot(old) > SMOOTH * new.length() * old.length() && new.length() > 1e-3 * self.edge.powi(2)
            };
            if self.quadrics[vertex as usize].at(to) < (OFF / 2.0 * self.edge).powi(2)
                && neighbours.iter().all(|&other| self.place(other).distance(to) <= longest)
                && around.iter().all(fits)
            {
                self.mesh.vertices[vertex as usize] = to;
            }
        }
    }

    /// Moves both ends to one place, if the surface allows.
    fn collapse(&mut self, a: u32, b: u32) -> bool {
        let (near_a, near_b) = (self.neighbours(a), self.neighbours(b));
        // Two triangles share the edge, and no other vertex joins its ends.
        if near_a.binary_search(&b).is_err()
            || near_a.iter().filter(|other| near_b.binary_search(other).is_ok()).count() != 2
            || near_a.len() + near_b.len() < 8
        {
            return false;
        }
        let mut quadric = self.quadrics[a as usize];
        quadric.add(&self.quadrics[b as usize]);
        let places = [self.place(a), self.place(b), self.place(a).midpoint(self.place(b))];
        let best = places.into_iter().min_by(|p, q| quadric.at(*p).total_cmp(&quadric.at(*q)));
        let Some(to) = best.filter(|to| quadric.at(*to) < (OFF * self.edge).powi(2)) else { return false };
        let longest = LONGEST * self.edge;
        let mut others = near_a.iter().chain(&near_b).filter(|other| **other != a && **other != b);
        if others.any(|&other| self.place(other).distance(to) > longest) {
            return false;
        }
        let shared = self.beside(a, b);
        for &triangle in self.around[a as usize].iter().chain(&self.around[b as usize]) {
            if shared.contains(&triangle) {
                continue;
            }
            let [old, new] = self.turned(triangle, |corner| corner == a || corner == b, to);
            if new.dot(old) < LEAST_COSINE * new.length() * old.length()
                || new.length() < 1e-3 * self.edge.powi(2)
            {
                return false;
            }
        }
        for triangle in shared {
            self.is_alive[triangle as usize] = false;
            for vertex in self.mesh.triangles[triangle as usize] {
                self.around[vertex as usize].retain(|own| *own != triangle);
            }
        }
        for triangle in std::mem::take(&mut self.around[b as usize]) {
            let corners = &mut self.mesh.triangles[triangle as usize];
            corners.iter_mut().filter(|vertex| **vertex == b).for_each(|vertex| *vertex = a);
            self.around[a as usize].push(triangle);
        }
        self.mesh.vertices[a as usize] = to;
        self.quadrics[a as usize] = quadric;
        true
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn fine_and_coarse_bodies_get_the_wanted_edge() {
        let edge = 1.4e-3;
        let bodies = [
            ("fine ball", shapes::sphere(0.008, 0.4e-3), 0.03),
            ("coarse ball", shapes::sphere(0.008, 6e-3), 1e-9),
            ("fine slab", shapes::slab(dvec3(0.02, 0.015, 0.006), 0.002, 0.5e-3), 0.03),
            ("finger", shapes::capsule(DVec3::ZERO, DVec3::Z * 0.03, 0.007, 0.5e-3), 0.03),
        ];
        for (name, body, off) in bodies {
            let mesh = body.with_edges(edge);
            assert!(mesh.longest_edge() <= LONGEST * edge * 1.0001, "{name}: {}", mesh.longest_edge());
            assert!((0.55..1.2).contains(&(mesh.edge() / edge)), "{name}: edges of {}", mesh.edge());
            assert!(
                (mesh.volume() / body.volume() - 1.0).abs() < off,
                "{name}: {}",
                mesh.volume() / body.volume()
            );
            let again = mesh.clone().closed().unwrap();
            assert_eq!(again.triangles.len(), mesh.triangles.len(), "{name}");
            assert!((again.volume() - mesh.volume()).abs() < 1e-6 * mesh.volume(), "{name}: turned over");
        }
    }

    #[test]
    fn a_box_keeps_its_corners() {
        let size = dvec3(0.02, 0.01, 0.005);
        let corner = |i: u32| dvec3(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * size;
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let body = Mesh { vertices: (0..8).map(corner).collect(), triangles }.closed().unwrap();
        let mesh = body.with_edges(0.4e-3).with_edges(1.4e-3);
        assert!((mesh.volume() / 1e-6 - 1.0).abs() < 1e-9, "{}", mesh.volume());
        assert!((0.6..1.1).contains(&(mesh.edge() / 1.4e-3)), "edges of {}", mesh.edge());
    }
}
