//! The surface where a function of space is zero, by marching tetrahedra.
//!
//! Corners and centres of cubes form a body-centred lattice. Two neighbouring centres and an edge of the face between
//! them make a tetrahedron, all alike and nearly regular. In a tetrahedron the surface is the triangle or quadrilateral
//! whose corners divide the edges with a change of sign. Neighbours share these corners, so the surface is closed and no
//! edge is on more than two triangles, for any function (A. Doi, A. Koide, IEICE Trans. E74, 214, 1991; without the
//! ambiguities of cubes). Blocks of cubes far from the surface are left out.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::closed::Mesh;

/// Cubes along a side of a block.
const BLOCK: i64 = 4;
/// The other nodes of a tetrahedron after each, so that all four are an even permutation.
const OTHERS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [3, 0, 1], [2, 1, 0]];
/// Pairs of nodes and the other two, even permutations.
const PAIRS: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];

/// A node of the lattice: a cube's lowest corner, or its centre.
type Node = ([i64; 3], bool);
/// A corner of the surface by the edge on which it is, and its place (m).
type Cut = ([Node; 2], DVec3);

/// The surface around all points where a function is negative, with triangles of about the side of a cube (m). The function
/// changes at most `steepest` times as fast as the place, and is positive within a side of the box between two corners (m)
/// and outside.
pub(super) fn surface(
    field: impl Fn(DVec3) -> f64 + Sync,
    steepest: f64,
    (low, high): (DVec3, DVec3),
    side: f64,
) -> Mesh {
    let counts = ((high - low) / side / BLOCK as f64).ceil().to_array().map(|count| count as i64);
    let place = |(cube, is_centre): Node| {
        let own = DVec3::from_array(cube.map(|x| x as f64));
        low + side * (own + if is_centre { DVec3::splat(0.5) } else { DVec3::ZERO })
    };
    let block = |number: i64| {
        let first = [number % counts[0], number / counts[0] % counts[1], number / counts[0] / counts[1]]
            .map(|x| x * BLOCK);
        let middle = place((first, false)) + DVec3::splat(side * BLOCK as f64 / 2.0);
        // The tetrahedra of its cubes reach half a cube further.
        let reach = side * (BLOCK as f64 / 2.0 + 0.5) * 3.0f64.sqrt();
        match field(middle).abs() > steepest * reach {
            true => Vec::new(),
            false => triangles(first, |node| field(place(node)), place),
        }
    };
    let parts: Vec<Vec<[Cut; 3]>> = (0..counts.iter().product()).into_par_iter().map(block).collect();
    let mut mesh = Mesh::default();
    let mut numbers: HashMap<[Node; 2], u32> = HashMap::new();
    for corners in parts.into_iter().flatten() {
        let corners = corners.map(|(edge, at)| {
            *numbers.entry(edge).or_insert_with(|| {
                mesh.vertices.push(at);
                mesh.vertices.len() as u32 - 1
            })
        });
        mesh.triangles.push(corners);
    }
    mesh
}

/// The triangles in a block with a first cube.
fn triangles(first: [i64; 3], value: impl Fn(Node) -> f64, place: impl Fn(Node) -> DVec3) -> Vec<[Cut; 3]> {
    const WIDTH: i64 = BLOCK + 1;
    let cubes = |n: i64| [n % WIDTH, n / WIDTH % WIDTH, n / WIDTH / WIDTH];
    let added = |a: [i64; 3], b: [i64; 3]| [0, 1, 2].map(|axis| a[axis] + b[axis]);
    let values = |is_centre: bool| -> Vec<f64> {
        (0..WIDTH.pow(3)).map(|n| value((added(first, cubes(n)), is_centre))).collect()
    };
    let (of_corners, of_centres) = (values(false), values(true));
    // Node and value at a cube of the block.
    let node = |cube: [i64; 3], is_centre: bool| {
        let values = if is_centre { &of_centres } else { &of_corners };
        let value = values[(cube[0] + WIDTH * (cube[1] + WIDTH * cube[2])) as usize];
        ((added(first, cube), is_centre), value)
    };
    let cut = |a: (Node, f64), b: (Node, f64)| -> Cut {
        let (a, b) = if a.0 < b.0 { (a, b) } else { (b, a) };
        // Not at a node itself, where several corners would meet.
        let part = (a.1 / (a.1 - b.1)).clamp(0.02, 0.98);
        ([a.0, b.0], place(a.0).lerp(place(b.0), part))
    };
    let mut triangles = Vec::new();
    for n in 0..WIDTH.pow(3) {
        let cube = cubes(n);
        if cube.contains(&BLOCK) {
            continue;
        }
        for axis in 0..3 {
            let unit = |axis: usize| [0, 1, 2].map(|other| i64::from(other == axis % 3));
            let (u, v) = (unit(axis + 1), unit(axis + 2));
            let next = added(cube, unit(axis));
            let face = [next, added(next, u), added(added(next, u), v), added(next, v)];
            for side in 0..4 {
                let corners = [face[side], face[(side + 1) % 4]].map(|corner| node(corner, false));
                let nodes = [node(cube, true), corners[0], corners[1], node(next, true)];
                add_cuts(&mut triangles, nodes, cut);
            }
        }
    }
    triangles
}

/// The part of the surface in a tetrahedron, anticlockwise seen from where the function is positive.
fn add_cuts(
    triangles: &mut Vec<[Cut; 3]>,
    nodes: [(Node, f64); 4],
    cut: impl Fn((Node, f64), (Node, f64)) -> Cut,
) {
    let is_inside = nodes.map(|(_, value)| value < 0.0);
    match is_inside.iter().filter(|inside| **inside).count() {
        count @ (1 | 3) => {
            let single = (0..4).find(|&i| is_inside[i] == (count == 1)).unwrap_or(0);
            let [a, b, c] = OTHERS[single].map(|other| cut(nodes[single], nodes[other]));
            triangles.push(if count == 1 { [a, b, c] } else { [a, c, b] });
        }
        2 => {
            let pair = PAIRS.iter().find(|pair| is_inside[pair[0]] && is_inside[pair[1]]);
            let [i, j, k, l] = pair.unwrap_or(&PAIRS[0]).map(|number| nodes[number]);
            let [a, b, c, d] = [cut(i, k), cut(i, l), cut(j, l), cut(j, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        _ => (),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn marched_balls_are_closed_and_round() {
        // Two balls of which one has a cavity: three pieces.
        let field = |at: DVec3| {
            let (one, other) = (at.length() - 1.0, (at - DVec3::X * 2.5).length() - 0.8);
            one.max(0.4 - at.length()).min(other)
        };
        let mesh = surface(field, 1.0, (DVec3::splat(-1.2), DVec3::new(3.6, 1.2, 1.2)), 0.1);
        let volume = 4.0 / 3.0 * PI * (1.0 - 0.4f64.powi(3) + 0.8f64.powi(3));
        assert!((mesh.volume() / volume - 1.0).abs() < 0.01, "{} {volume}", mesh.volume());
        let closed = mesh.clone().closed().unwrap();
        assert_eq!(closed, mesh, "nothing to merge or to turn");
        let components = mesh.vertices.len() as i64 - mesh.triangles.len() as i64 / 2;
        assert_eq!(components, 2 * 3, "Euler's number of three balls");
    }
}
