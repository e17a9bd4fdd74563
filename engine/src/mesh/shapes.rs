//! Bodies by formula: spheres, capsules and slabs, with triangles of a wanted edge and the volume of the round body.
//!
//! Vertices on a convex surface leave flat triangles inside it. The vertices are moved outwards until the volume is that
//! of the body, which removes the first order of that error.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, dvec3};

use crate::mesh::closed::Mesh;
use crate::mesh::hand;

/// A sphere about the origin with a radius and triangles whose edges are about as long as wanted, m: an icosahedron
/// with every edge divided.
pub fn sphere(radius: f64, edge: f64) -> Mesh {
    // Of an icosahedron with a radius of 1; the divided edges spread over its circumscribed sphere.
    let parts = (1.1756 * radius / edge).round().max(3.0) as usize;
    geodesic(radius, parts)
}

/// A sphere of 20 · `parts`² triangles.
pub fn geodesic(radius: f64, parts: usize) -> Mesh {
    let golden = f64::midpoint(1.0, 5.0f64.sqrt());
    let corners: Vec<_> = [(0.0, 1.0, golden), (1.0, golden, 0.0), (golden, 0.0, 1.0)]
        .into_iter()
        .flat_map(|(x, y, z)| {
            [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(s, t)| match (x, y) {
                (0.0, _) => dvec3(0.0, s * y, t * z),
                (_, 1.0..) if z == 0.0 => dvec3(s * x, t * y, 0.0),
                _ => dvec3(s * x, 0.0, t * z),
            })
        })
        .collect();
    let near = |a: &DVec3, b: &DVec3| (a.distance(*b) - 2.0).abs() < 1e-9;
    let mut mesh = Mesh::default();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let face = [corners[a], corners[b], corners[c]];
                if near(&face[0], &face[1]) && near(&face[1], &face[2]) && near(&face[2], &face[0]) {
                    divide(&mut mesh, face, parts);
                }
            }
        }
    }
    let mesh = mesh.mapped(|at| at.normalize_or_zero() * radius);
    with_volume(body(mesh), 4.0 / 3.0 * PI * radius.powi(3), |at, out| at * (1.0 + out / radius))
}

/// A capsule: all points within a radius (m) of the line between two points (m).
pub fn capsule(from: DVec3, to: DVec3, radius: f64, edge: f64) -> Mesh {
    let (axis, middle) = ((to - from).normalize_or(DVec3::Z), from.midpoint(to));
    let half = from.distance(to) / 2.0;
    let arc = ((FRAC_PI_2 * radius / edge).round() as usize).max(3);
    let straight = (2.0 * half / (edge * 0.866)).round() as usize;
    // The meridian from pole to pole: distance from the axis and height.
    let mut meridian = Vec::new();
    for i in 0..=arc {
        let angle = FRAC_PI_2 * i as f64 / arc as f64;
        meridian.push((radius * angle.sin(), half + radius * angle.cos()));
    }
    for i in 1..straight {
        meridian.push((radius, half - 2.0 * half * i as f64 / straight as f64));
    }
    for i in (if half > 0.0 { 0 } else { 1 })..=arc {
        let angle = FRAC_PI_2 * (1.0 - i as f64 / arc as f64);
        meridian.push((radius * angle.sin(), -half - radius * angle.cos()));
    }
    let mesh = revolution(&meridian, edge);
    let volume = PI * radius * radius * (2.0 * half + 4.0 / 3.0 * radius);
    let core = |at: DVec3| dvec3(0.0, 0.0, at.z.clamp(-half, half));
    let mesh = with_volume(mesh, volume, |at, out| at + (at - core(at)).normalize_or_zero() * out);
    let (x, y) = axis.any_orthonormal_pair();
    mesh.mapped(|at| middle + x * at.x + y * at.y + axis * at.z)
}

/// A slab about the origin with rounded edges: a box of this size less a margin, and all points within that margin
/// (all m). A palm is a slab.
pub fn slab(size: DVec3, margin: f64, edge: f64) -> Mesh {
    let margin = margin.min(size.min_element() / 2.0);
    let core = size / 2.0 - DVec3::splat(margin);
    // Lines of the grid along an axis: the core evenly, and the rounding in equal steps of angle.
    let bend = ((FRAC_PI_2 * margin / edge / 2.0).ceil() as usize).max(2);
    let lines = |half: f64| -> Vec<f64> {
        let straight = ((2.0 * half / edge).round() as usize).max(1);
        let rounding = (1..=bend)
            .map(|i| half + margin * (FRAC_PI_2 / 2.0 * i as f64 / bend as f64).tan())
            .collect::<Vec<_>>();
        let own = (0..=straight).map(|i| 2.0 * half * i as f64 / straight as f64 - half);
        let own: Vec<_> = if half > 1e-12 { own.collect() } else { vec![0.0] };
        let below = rounding.iter().rev().map(|x| -x);
        below.chain(own).chain(rounding.iter().copied()).collect()
    };
    let lines = [lines(core.x), lines(core.y), lines(core.z)];
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            for i in 0..lines[u].len() - 1 {
                for j in 0..lines[v].len() - 1 {
                    let corner = |di: usize, dj: usize| {
                        let mut at = DVec3::ZERO;
                        at[axis] = side * (core[axis] + margin);
                        (at[u], at[v]) = (lines[u][i + di], lines[v][j + dj]);
                        at
                    };
                    let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
                    // Diagonals across the corners, so that no triangle has all its vertices on one edge.
                    let middle = |n: usize, lines: &[f64]| lines[n] + lines[n + 1] > 0.0;
                    let faces = if middle(i, &lines[u]) == middle(j, &lines[v]) {
                        [[a, b, d], [b, c, d]]
                    } else {
                        [[a, b, c], [a, c, d]]
                    };
                    for face in faces {
                        let first = mesh.vertices.len() as u32;
                        mesh.vertices.extend(face);
                        mesh.triangles.push([first, first + 1, first + 2]);
                    }
                }
            }
        }
    }
    let inner = |at: DVec3| at.clamp(-core, core);
    let mesh = mesh.mapped(|at| inner(at) + (at - inner(at)).normalize_or_zero() * margin);
    let [a, b, c] = (core * 2.0).to_array();
    let volume = a * b * c
        + 2.0 * margin * (a * b + b * c + c * a)
        + PI * margin * margin * (a + b + c)
        + 4.0 / 3.0 * PI * margin.powi(3);
    with_volume(body(mesh), volume, |at, out| at + (at - inner(at)).normalize_or_zero() * out)
}

/// A right hand whose palm's skin has its middle in the origin and faces z, with fingers along x and the thumb at negative
/// y: the palm's size (m: along x, across, and its thickness) and the angles (degrees) by which thumb, index, middle, ring
/// and little finger are bent towards the palm.
pub fn hand(size: DVec3, fingers: [f64; 5], edge: f64) -> Mesh {
    hand::mesh(size, fingers, edge)
}

/// Divides a triangle's edges into parts and adds its triangles.
fn divide(mesh: &mut Mesh, [a, b, c]: [DVec3; 3], parts: usize) {
    let at = |i: usize, j: usize| a + ((b - a) * i as f64 + (c - a) * j as f64) / parts as f64;
    for i in 0..parts {
        for j in 0..parts - i {
            let mut add = |corners: [DVec3; 3]| {
                let first = mesh.vertices.len() as u32;
                mesh.vertices.extend(corners);
                mesh.triangles.push([first, first + 1, first + 2]);
            };
            add([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 1 < parts {
                add([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
}

/// The surface of revolution about z of a meridian (distance from z, height; from pole to pole), with rings of
/// vertices that are an edge apart.
fn revolution(meridian: &[(f64, f64)], edge: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for (number, &(distance, height)) in meridian.iter().enumerate() {
        let is_pole = number == 0 || number + 1 == meridian.len();
        let count = if is_pole { 1 } else { ((TAU * distance / edge).round() as usize).max(6) };
        let ring = (0..count).map(|i| {
            let angle = TAU * (i as f64 + 0.5 * (number % 2) as f64) / count as f64;
            let distance = if is_pole { 0.0 } else { distance };
            mesh.vertices.push(dvec3(distance * angle.cos(), distance * angle.sin(), height));
            mesh.vertices.len() as u32 - 1
        });
        rings.push(ring.collect());
    }
    for (number, pair) in rings.windows(2).enumerate() {
        let (upper, lower) = (&pair[0], &pair[1]);
        let phase = |ring: usize, i: usize, count: usize| {
            (i as f64 + if count > 1 { 0.5 * (ring % 2) as f64 } else { 0.5 }) / count as f64
        };
        // Around both rings, each step where the other ring's next vertex is farther on.
        let (mut i, mut j) = (0, 0);
        while i < upper.len() || j < lower.len() {
            let next_upper = phase(number, i + 1, upper.len());
            let next_lower = phase(number + 1, j + 1, lower.len());
            let (a, b) = (upper[i % upper.len()], lower[j % lower.len()]);
            let by_upper = j >= lower.len() || (i < upper.len() && next_upper <= next_lower);
            if by_upper {
                if upper.len() > 1 {
                    mesh.triangles.push([a, b, upper[(i + 1) % upper.len()]]);
                }
                i += 1;
            } else {
                if lower.len() > 1 {
                    mesh.triangles.push([a, b, lower[(j + 1) % lower.len()]]);
                }
                j += 1;
            }
        }
    }
    body(mesh)
}

fn body(mesh: Mesh) -> Mesh {
    mesh.closed().expect("shapes are closed")
}

/// The mesh with vertices moved outwards by equal ways until it has a volume (m³).
fn with_volume(mut mesh: Mesh, volume: f64, outwards: impl Fn(DVec3, f64) -> DVec3) -> Mesh {
    for _ in 0..4 {
        let out = (volume - mesh.volume()) / mesh.area();
        mesh = mesh.mapped(|at| outwards(at, out));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_closed_and_have_their_volume() {
        let edge = 1.4e-3;
        let cases = [
            ("sphere", sphere(0.008, edge), 4.0 / 3.0 * PI * 0.008f64.powi(3)),
            (
                "capsule",
                capsule(dvec3(0.01, 0.0, 0.1), dvec3(0.0, 0.03, 0.12), 0.008, edge),
                PI * 0.008f64.powi(2) * (dvec3(0.01, -0.03, -0.02).length() + 4.0 / 3.0 * 0.008),
            ),
            ("ball", capsule(DVec3::ZERO, DVec3::ZERO, 0.008, edge), 4.0 / 3.0 * PI * 0.008f64.powi(3)),
            (
                "slab",
                slab(dvec3(0.03, 0.02, 0.008), 0.004, edge),
                0.022 * 0.012 * 0.008 + PI * 0.004f64.powi(2) * 0.034 + 4.0 / 3.0 * PI * 0.004f64.powi(3),
            ),
        ];
        for (name, mesh, volume) in cases {
            assert!((mesh.volume() / volume - 1.0).abs() < 1e-6, "{name}: {} {volume}", mesh.volume());
            assert!((0.7..1.25).contains(&(mesh.edge() / edge)), "{name}: edges of {}", mesh.edge());
            assert!(mesh.longest_edge() < 1.9 * edge, "{name}: an edge of {}", mesh.longest_edge());
            assert_eq!(mesh.clone().closed().unwrap().triangles.len(), mesh.triangles.len(), "{name}");
            assert_eq!(2 * mesh.vertices.len(), mesh.triangles.len() + 4, "{name}: a ball's surface");
        }
    }

    #[test]
    fn a_finer_sphere_has_more_triangles() {
        assert_eq!(geodesic(1.0, 4).triangles.len(), 320);
        assert_eq!(geodesic(1.0, 1).vertices.len(), 12);
    }
}
