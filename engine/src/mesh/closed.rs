//! Closed surfaces of triangles.
//!
//! A body is closed if every edge belongs to two triangles that run along it in opposite directions. Normals point
//! outwards if the volume is positive. A point is inside if the surface covers a solid angle of 4π around it
//! (A. Van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30, 125, 1983).

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::TAU;

use glam::DVec3;
use thiserror::Error;

/// A surface with triangles that run anticlockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// m
    pub vertices: Vec<DVec3>,
    /// Indices of vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// A surface that bounds no body.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Fault {
    #[error("the surface has no triangles")]
    Empty,
    #[error("a vertex is not a finite point")]
    NotFinite,
    #[error("triangle {triangle} names vertex {vertex}: there are {count} vertices")]
    NoSuchVertex { triangle: usize, vertex: u32, count: usize },
    #[error(
        "the surface is not closed: {count} of its edges are on one triangle only, one at ({:.4}, {:.4}, {:.4}) m",
        at.x, at.y, at.z
    )]
    Open { count: usize, at: DVec3 },
    #[error(
        "the surface crosses itself: {count} of its edges are on more than two triangles, one at \
         ({:.4}, {:.4}, {:.4}) m", at.x, at.y, at.z
    )]
    Branched { count: usize, at: DVec3 },
    #[error("the surface encloses no volume")]
    Flat,
}

impl Mesh {
    /// Corners of a triangle, m.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }

    /// Enclosed volume (m³), negative if the triangles run clockwise.
    pub fn volume(&self) -> f64 {
        let of = |triangle: usize| {
            let [a, b, c] = self.corners(triangle);
            a.dot(b.cross(c))
        };
        (0..self.triangles.len()).map(of).sum::<f64>() / 6.0
    }

    /// Area, m².
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|triangle| area_vector(self.corners(triangle)).length()).sum()
    }

    /// The root of the mean square of all edges, m.
    pub fn edge(&self) -> f64 {
        let squares: f64 = (0..self.triangles.len())
            .map(|triangle| {
                let [a, b, c] = self.corners(triangle);
                a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a)
            })
            .sum();
        (squares / (3 * self.triangles.len()).max(1) as f64).sqrt()
    }

    /// The longest edge, m.
    pub fn longest_edge(&self) -> f64 {
        let longest = |triangle: usize| {
            let [a, b, c] = self.corners(triangle);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        (0..self.triangles.len()).map(longest).fold(0.0, f64::max)
    }

    /// The smallest and the largest corner of the box around it, m.
    pub fn extent(&self) -> (DVec3, DVec3) {
        let grow = |(low, high): (DVec3, DVec3), at: &DVec3| (low.min(*at), high.max(*at));
        self.vertices.iter().fold((DVec3::MAX, DVec3::MIN), grow)
    }

    /// The same surface after a map of its vertices.
    pub fn mapped(mut self, map: impl Fn(DVec3) -> DVec3) -> Self {
        self.vertices.iter_mut().for_each(|at| *at = map(*at));
        self
    }

    /// Whether a point (m) is inside.
    pub fn contains(&self, at: DVec3) -> bool {
        self.solid_angle(at) > TAU
    }

    /// The solid angle of the surface around a point, with the sign of its side.
    pub(super) fn solid_angle(&self, at: DVec3) -> f64 {
        let of = |triangle: usize| {
            let [a, b, c] = self.corners(triangle).map(|corner| corner - at);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(below)
        };
        (0..self.triangles.len()).map(of).sum()
    }

    /// A body: vertices closer together than a millionth of its size merged, triangles without area left out, all of
    /// a piece run alike and outwards.
    ///
    /// # Errors
    /// A surface that bounds no body.
    pub fn closed(self) -> Result<Self, Fault> {
        let count = self.vertices.len();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|vertex| **vertex as usize >= count) {
                return Err(Fault::NoSuchVertex { triangle, vertex, count });
            }
        }
        if !self.vertices.iter().all(|at| at.is_finite()) {
            return Err(Fault::NotFinite);
        }
        let mut mesh = self.merged();
        if mesh.triangles.is_empty() {
            return Err(Fault::Empty);
        }
        mesh.check_edges()?;
        mesh.turn_alike()?;
        let (low, high) = mesh.extent();
        if mesh.volume().abs() < 1e-9 * (high - low).length().powi(3) {
            return Err(Fault::Flat);
        }
        Ok(mesh)
    }

    /// The surface with vertices at the same place merged, unused ones and triangles of fewer than three left out.
    fn merged(self) -> Self {
        let (low, high) = self.extent();
        let cell = 1e-6 * (high - low).max_element().max(f64::MIN_POSITIVE);
        let key = |at: DVec3| ((at - low) / cell).round().to_array().map(|x| x as i64);
        let mut cells: HashMap<[i64; 3], u32> = HashMap::new();
        let mut vertices: Vec<DVec3> = Vec::new();
        let mut place = |at: DVec3| {
            let own = key(at);
            // Neighbours at the two sides of a cell's border are in different cells.
            let near = (0..27).filter_map(|i| {
                let beside = [own[0] + i % 3 - 1, own[1] + i / 3 % 3 - 1, own[2] + i / 9 - 1];
                cells.get(&beside).copied().filter(|&index| vertices[index as usize].distance(at) <= cell)
            });
            if let Some(index) = near.min() {
                return index;
            }
            let index = vertices.len() as u32;
            cells.insert(own, index);
            vertices.push(at);
            index
        };
        let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(self.triangles.len());
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|vertex| place(self.vertices[vertex as usize]));
            if a != b && b != c && c != a {
                triangles.push([a, b, c]);
            }
        }
        // Two triangles back to back bound nothing.
        let mut twins: HashMap<[u32; 3], usize> = HashMap::new();
        for corners in &triangles {
            *twins.entry(sorted(*corners)).or_default() += 1;
        }
        triangles.retain(|corners| twins[&sorted(*corners)] == 1);
        Self { vertices, triangles }.without_unused()
    }

    pub(super) fn without_unused(self) -> Self {
        let mut numbers = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::new();
        let triangles = self
            .triangles
            .iter()
            .map(|corners| {
                corners.map(|vertex| {
                    let number = &mut numbers[vertex as usize];
                    if *number == u32::MAX {
                        *number = vertices.len() as u32;
                        vertices.push(self.vertices[vertex as usize]);
                    }
                    *number
                })
            })
            .collect();
        Self { vertices, triangles }
    }

    /// The triangles along every edge, by its vertices in ascending order.
    pub(crate) fn edges(&self) -> BTreeMap<[u32; 2], Vec<u32>> {
        let mut edges: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                edges.entry([a.min(b), a.max(b)]).or_default().push(triangle as u32);
            }
        }
        edges
    }

    fn check_edges(&self) -> Result<(), Fault> {
        let edges = self.edges();
        let fault = |is_bad: &dyn Fn(usize) -> bool| {
            let bad = edges.iter().filter(|(_, triangles)| is_bad(triangles.len()));
            let first = bad.clone().map(|(edge, _)| *edge).min()?;
            let [a, b] = first.map(|vertex| self.vertices[vertex as usize]);
            Some((bad.count(), a.midpoint(b)))
        };
        if let Some((count, at)) = fault(&|triangles| triangles == 1) {
            return Err(Fault::Open { count, at });
        }
        match fault(&|triangles| triangles > 2) {
            Some((count, at)) => Err(Fault::Branched { count, at }),
            None => Ok(()),
        }
    }

    /// Turns triangles until neighbours run alike, and every piece outwards; a piece within another is a cavity.
    fn turn_alike(&mut self) -> Result<(), Fault> {
        let edges = self.edges();
        let mut piece = vec![usize::MAX; self.triangles.len()];
        let mut pieces = Vec::new();
        for start in 0..self.triangles.len() {
            if piece[start] != usize::MAX {
                continue;
            }
            let number = pieces.len();
            let (mut members, mut next) = (Vec::new(), vec![start]);
            piece[start] = number;
            while let Some(triangle) = next.pop() {
                members.push(triangle);
                let corners = self.triangles[triangle];
                for i in 0..3 {
                    let (a, b) = (corners[i], corners[(i + 1) % 3]);
                    for &other in &edges[&[a.min(b), a.max(b)]] {
                        let other = other as usize;
                        let runs_alike = runs_along(self.triangles[other], b, a);
                        if piece[other] == usize::MAX {
                            piece[other] = number;
                            if !runs_alike {
                                self.triangles[other].swap(1, 2);
                            }
                            next.push(other);
                        } else if other != triangle && !runs_alike {
                            // A one-sided surface such as Klein's bottle.
                            return Err(Fault::Flat);
                        }
                    }
                }
            }
            pieces.push(members);
        }
        let of_piece = |members: &[usize]| Self {
            vertices: self.vertices.clone(),
            triangles: members.iter().map(|&triangle| self.triangles[triangle]).collect(),
        };
        let alone: Vec<_> = if pieces.len() == 1 {
            vec![self.clone()]
        } else {
            pieces.iter().map(|members| of_piece(members)).collect()
        };
        for (number, members) in pieces.iter().enumerate() {
            let own = self.vertices[self.triangles[members[0]][0] as usize];
            let around = |(other, mesh): (usize, &Self)| other != number && mesh.solid_angle(own).abs() > TAU;
            let is_cavity = alone.iter().enumerate().filter(|it| around(*it)).count() % 2 == 1;
            if (alone[number].volume() < 0.0) != is_cavity {
                members.iter().for_each(|&triangle| self.triangles[triangle].swap(1, 2));
            }
        }
        Ok(())
    }
}

/// Whether a triangle runs from one vertex to another.
fn runs_along(corners: [u32; 3], from: u32, to: u32) -> bool {
    (0..3).any(|i| corners[i] == from && corners[(i + 1) % 3] == to)
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// Half the cross product of two edges: the normal times the area.
pub(crate) fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        Mesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        }
    }

    /// Every triangle with vertices of its own, as in STL files.
    fn apart(mesh: &Mesh) -> Mesh {
        let vertices: Vec<_> = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
        let triangles = (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Mesh { vertices, triangles }
    }

    #[test]
    fn bodies_are_merged_and_turned_outwards() {
        let mut mesh = apart(&tetrahedron());
        mesh.triangles[1].swap(0, 1);
        mesh.vertices[4] += DVec3::splat(1e-8);
        let mesh = mesh.closed().unwrap();
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4));
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-6, "{}", mesh.volume());
        let inwards = tetrahedron().mapped(|at| -at).closed().unwrap();
        assert!((inwards.volume() - 1.0 / 6.0).abs() < 1e-9);
        assert!(mesh.contains(DVec3::splat(0.1)) && !mesh.contains(DVec3::splat(0.4)));
    }

    #[test]
    fn cavities_stay_cavities() {
        let both = |outer: &Mesh, inner: &Mesh| {
            let first = outer.vertices.len() as u32;
            let triangles = inner.triangles.iter().map(|corners| corners.map(|vertex| vertex + first));
            Mesh {
                vertices: [&outer.vertices[..], &inner.vertices].concat(),
                triangles: outer.triangles.iter().copied().chain(triangles).collect(),
            }
        };
        let inner = tetrahedron().mapped(|at| DVec3::splat(0.1) + at * 0.2);
        let mesh = both(&tetrahedron(), &inner).closed().unwrap();
        assert!((mesh.volume() - (1.0 - 0.008) / 6.0).abs() < 1e-9, "{}", mesh.volume());
        assert!(mesh.contains(DVec3::splat(0.05)) && !mesh.contains(DVec3::splat(0.12)));
    }

    #[test]
    fn faults_say_what_is_wrong() {
        let mut open = tetrahedron();
        open.triangles.pop();
        assert!(matches!(open.closed(), Err(Fault::Open { count: 3, .. })));
        let mut branched = tetrahedron();
        branched.vertices.push(DVec3::splat(-1.0));
        branched.triangles.extend([[0, 1, 4], [1, 0, 4]]);
        assert!(branched.closed().is_ok(), "triangles back to back are left out");
        let mut wrong = tetrahedron();
        wrong.triangles[2][1] = 9;
        let text = wrong.closed().unwrap_err().to_string();
        assert_eq!(text, "triangle 2 names vertex 9: there are 4 vertices");
        assert_eq!(Mesh::default().closed(), Err(Fault::Empty));
        let flat = tetrahedron().mapped(|at| at.with_z(0.0));
        assert!(flat.closed().is_err());
        let nan = tetrahedron().mapped(|at| at / 0.0);
        assert_eq!(nan.closed(), Err(Fault::NotFinite));
    }
}
