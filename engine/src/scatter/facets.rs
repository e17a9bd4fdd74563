//! Triangles with linear functions: places of quadrature, and the integrals of the layers over near pairs.
//!
//! For test functions φᵢ and trial functions φⱼ the operator of [`crate::scatter::boundary`] needs, over pairs of
//! triangles S and T with x on S, y on T and G = e^{-jkR}/(4πR),
//!
//! ∫∫ φᵢ φⱼ (jkβ G + jk n·n' G - ∂G/∂n_y + β ∂G/∂n_x) + (curl φᵢ · curl φⱼ) (-j/k) G,
//!
//! where Maue's formula has turned the hypersingular layer into tangential slopes: curl φ is n × ∇φ, constant on each
//! triangle (A. W. Maue, Z. Phys. 126, 601, 1949). What is left is integrable. For pairs that share a triangle, an
//! edge or a vertex, the transformations of S. A. Sauter and C. Schwab (Boundary Element Methods, 2011, 5.2) leave
//! analytic integrands on the unit cube of four dimensions; pairs beside each other take a finer product rule.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::DVec3;
use num_complex::Complex64;

use crate::mesh::{Mesh, area_vector};
use crate::scatter::waves::{LANES, each, wave};
use crate::simd::{Instructions, Isa, Kernel, fused};
use crate::special::gauss_legendre;

/// Nodes of Gauss's rule in each dimension of the singular integrals: 1e-4 of their largest.
const SINGULAR_NODES: usize = 3;
/// Distances of centroids, relative to the sum of both triangles' radii, up to which a pair is near.
pub(super) const NEAR: f64 = 2.0;

/// A flat triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// Indices of vertices.
    pub nodes: [u32; 3],
    /// m
    pub corners: [DVec3; 3],
    pub centroid: DVec3,
    /// m, from the centroid to the farthest corner.
    pub radius: f64,
    /// Unit vector, outwards.
    pub normal: DVec3,
    /// m²
    pub area: f64,
    /// n × ∇φ of every corner's function, 1/m.
    pub curls: [DVec3; 3],
}

impl Facet {
    /// All triangles of a mesh.
    pub fn all(mesh: &Mesh) -> Vec<Self> {
        let of = |triangle: usize| {
            let corners = mesh.corners(triangle);
            let (vector, centroid) = (area_vector(corners), corners.iter().sum::<DVec3>() / 3.0);
            let radius = corners.iter().map(|corner| corner.distance(centroid)).fold(0.0, f64::max);
            // Files have triangles whose corners are in a line: their curls stay finite.
            let area = vector.length().max(1e-6 * radius * radius);
            let curl = |c: usize| (corners[(c + 2) % 3] - corners[(c + 1) % 3]) / (2.0 * area);
            Self {
                nodes: mesh.triangles[triangle],
                corners,
                centroid,
                radius,
                normal: vector / area,
                area,
                curls: [curl(0), curl(1), curl(2)],
            }
        };
        (0..mesh.triangles.len()).map(of).collect()
    }

    /// The place with these barycentric coordinates.
    pub fn at(&self, [a, b, c]: [f64; 3]) -> DVec3 {
        self.corners[0] * a + self.corners[1] * b + self.corners[2] * c
    }

    /// The places of the rule of three points.
    pub fn points(&self) -> [DVec3; 3] {
        THREE.map(|weights| self.at(weights))
    }

    /// Its nearest point to a point (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5).
    pub fn nearest(&self, at: DVec3) -> DVec3 {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let [d1, d2] = [ab, ac].map(|side| side.dot(at - a));
        let [d3, d4] = [ab, ac].map(|side| side.dot(at - b));
        let [d5, d6] = [ab, ac].map(|side| side.dot(at - c));
        let (of_c, of_b, of_a) = (d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4);
        if d1 <= 0.0 && d2 <= 0.0 {
            a
        } else if d3 >= 0.0 && d4 <= d3 {
            b
        } else if d6 >= 0.0 && d5 <= d6 {
            c
        } else if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            a + ab * (d1 / (d1 - d3))
        } else if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            a + ac * (d2 / (d2 - d6))
        } else if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
            b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6))
        } else {
            a + (ab * of_b + ac * of_c) / (of_a + of_b + of_c)
        }
    }

    pub fn is_near(&self, other: &Self) -> bool {
        let reach = NEAR * (self.radius + other.radius);
        self.centroid.distance_squared(other.centroid) < reach * reach
    }
}

/// The rule of three equal weights, exact for quadratic functions: barycentric coordinates.
pub(super) const THREE: [[f64; 3]; 3] = {
    let (own, other) = (2.0 / 3.0, 1.0 / 6.0);
    [[own, other, other], [other, own, other], [other, other, own]]
};

/// The rule of six points, exact for degree 4: barycentric coordinates and weights (D. A. Dunavant, Int. J. for Numerical
/// Methods Eng. 21, 1129, 1985).
pub(super) const SIX: [([f64; 3], f64); 6] = {
    const A: f64 = 0.445_948_490_915_965;
    const B: f64 = 0.091_576_213_509_771;
    const WA: f64 = 0.223_381_589_678_011;
    const WB: f64 = 0.109_951_743_655_322;
    [
        ([1.0 - 2.0 * A, A, A], WA),
        ([A, 1.0 - 2.0 * A, A], WA),
        ([A, A, 1.0 - 2.0 * A], WA),
        ([1.0 - 2.0 * B, B, B], WB),
        ([B, 1.0 - 2.0 * B, B], WB),
        ([B, B, 1.0 - 2.0 * B], WB),
    ]
};

/// A node of a rule for pairs: barycentric coordinates in both triangles, and the weight relative to both areas.
type PairNode = ([f64; 3], [f64; 3], f64);

/// Nodes in runs of lanes: both triples of coordinates, and the weight, 0 beyond the last.
type PairRun = ([[f32; LANES]; 3], [[f32; LANES]; 3], [f32; LANES]);

/// Entries of a pair of triangles: rows are the test functions.
pub(super) type Entries = [[Complex64; 3]; 3];

/// The medium and the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// rad/m
    pub wavenumber: f64,
    /// β, the admittance of the surface relative to that of the air.
    pub admittance: f64,
}

/// Entries with test functions on the first triangle and trial functions on the second, and the other way round:
/// accurate for all pairs.
pub(super) fn accurate(wall: &Wall, first: &Facet, second: &Facet) -> [Entries; 2] {
    let [a, b] = aligned(first.nodes, second.nodes);
    let shared = (0..3).take_while(|&i| first.nodes[a[i]] == second.nodes[b[i]]).count();
    integral(wall, (first, a), (second, b), rule(shared))
}

/// The same by the rule of three points, without the pair of a triangle with itself.
pub(super) fn rough(wall: &Wall, first: &Facet, second: &Facet) -> [Entries; 2] {
    if first.nodes == second.nodes {
        return [[[Complex64::ZERO; 3]; 3]; 2];
    }
    integral(wall, (first, [0, 1, 2]), (second, [0, 1, 2]), rule(4))
}

/// The corners of both triangles with the shared ones first, in the same sequence.
fn aligned(first: [u32; 3], second: [u32; 3]) -> [[usize; 3]; 2] {
    let partner = |i: usize| second.iter().position(|node| *node == first[i]);
    let shared: Vec<_> = (0..3).filter_map(|i| Some((i, partner(i)?))).collect();
    let complete = |own: Vec<usize>| {
        let rest = (0..3).filter(|i| !own.contains(i)).collect::<Vec<_>>();
        let all = [own, rest].concat();
        [all[0], all[1], all[2]]
    };
    [complete(shared.iter().map(|it| it.0).collect()), complete(shared.iter().map(|it| it.1).collect())]
}

fn integral(
    wall: &Wall,
    (first, a): (&Facet, [usize; 3]),
    (second, b): (&Facet, [usize; 3]),
    rule: &[PairRun],
) -> [Entries; 2] {
    // Places relative to the first triangle keep their digits.
    let turn =
        |f: &Facet, order: [usize; 3]| order.map(|i| (f.corners[i] - first.centroid).as_vec3().to_array());
    let normals = [first, second].map(|facet| facet.normal.as_vec3().to_array());
    let (forth, back, single) =
        Isa::best().run(Integral { wall, corners: [turn(first, a), turn(second, b)], normals, rule });
    let scale = first.area * second.area / (4.0 * PI);
    let single = single * Complex64::new(0.0, -1.0 / wall.wavenumber);
    let mut entries = [[[Complex64::ZERO; 3]; 3]; 2];
    for i in 0..3 {
        for j in 0..3 {
            let turning = first.curls[a[i]].dot(second.curls[b[j]]) * single;
            entries[0][a[i]][b[j]] = (forth[i][j] + turning) * scale;
            entries[1][b[j]][a[i]] = (back[i][j] + turning) * scale;
        }
    }
    entries
}

/// The sums of a rule, for both ways, and of G alone; rows belong to the first triangle.
struct Integral<'a> {
    wall: &'a Wall,
    /// m
    corners: [[[f32; 3]; 3]; 2],
    normals: [[f32; 3]; 2],
    rule: &'a [PairRun],
}

impl Kernel for Integral<'_> {
    type Output = (Entries, Entries, Complex64);

    #[inline(always)]
    fn run<I: Instructions>(self) -> Self::Output {
        let Self { wall, corners: [p, q], normals: [m, n], rule } = self;
        let (k, beta) = (wall.wavenumber as f32, wall.admittance as f32);
        let per_metre = (wall.wavenumber / PI) as f32;
        let even = k * (beta + m[0] * n[0] + m[1] * n[1] + m[2] * n[2]);
        let mut sums = [[[[[0f32; LANES]; 2]; 3]; 3]; 2];
        let mut single = [[0f32; LANES]; 2];
        for (u, v, weights) in rule {
            // Loops, since closures within closures are not compiled for the instruction set.
            let mut d = [[0f32; LANES]; 3];
            for axis in 0..3 {
                let (p, q) = ([p[0][axis], p[1][axis], p[2][axis]], [q[0][axis], q[1][axis], q[2][axis]]);
                let y = each(|l| fused::<I>(q[0], v[0][l], fused::<I>(q[1], v[1][l], q[2] * v[2][l])));
                let x = each(|l| fused::<I>(p[0], u[0][l], fused::<I>(p[1], u[1][l], p[2] * u[2][l])));
                d[axis] = each(|l| y[l] - x[l]);
            }
            let r2 = each(|l| {
                fused::<I>(
                    d[0][l],
                    d[0][l],
                    fused::<I>(d[1][l], d[1][l], fused::<I>(d[2][l], d[2][l], 1e-24)),
                )
            });
            let [c, s, inverse, r] = wave::<I>(per_metre, &r2);
            let (c, s) = (each(|l| c[l] * weights[l]), each(|l| s[l] * weights[l]));
            let kr = each(|l| k * r[l]);
            // Minus G'/R.
            let inverse2 = each(|l| inverse[l] * inverse[l]);
            let (slope_re, slope_im) = (
                each(|l| inverse2[l] * fused::<I>(kr[l], s[l], c[l])),
                each(|l| inverse2[l] * fused::<I>(kr[l], c[l], -s[l])),
            );
            let of_first = each(|l| fused::<I>(m[0], d[0][l], fused::<I>(m[1], d[1][l], m[2] * d[2][l])));
            let of_second = each(|l| fused::<I>(n[0], d[0][l], fused::<I>(n[1], d[1][l], n[2] * d[2][l])));
            let ways = [
                each(|l| fused::<I>(beta, of_first[l], of_second[l])),
                each(|l| -fused::<I>(beta, of_second[l], of_first[l])),
            ];
            single = [each(|l| single[0][l] + c[l]), each(|l| single[1][l] - s[l])];
            for (sums, way) in sums.iter_mut().zip(&ways) {
                let re = each(|l| fused::<I>(even, s[l], way[l] * slope_re[l]));
                let im = each(|l| fused::<I>(even, c[l], way[l] * slope_im[l]));
                for i in 0..3 {
                    let (re, im) = (each(|l| re[l] * u[i][l]), each(|l| im[l] * u[i][l]));
                    for j in 0..3 {
                        let sum = &mut sums[i][j];
                        *sum = [
                            each(|l| fused::<I>(re[l], v[j][l], sum[0][l])),
                            each(|l| fused::<I>(im[l], v[j][l], sum[1][l])),
                        ];
                    }
                }
            }
        }
        let total = |lanes: &[f32; LANES]| lanes.iter().map(|x| f64::from(*x)).sum::<f64>();
        let complex = |sum: &[[f32; LANES]; 2]| Complex64::new(total(&sum[0]), total(&sum[1]));
        let [forth, back] = sums.map(|way| way.map(|row| row.map(|sum| complex(&sum))));
        (forth, back, complex(&single))
    }
}

/// The rule for pairs with 0 to 3 shared corners; 4: that of three points on each.
fn rule(shared: usize) -> &'static [PairRun] {
    static RULES: [OnceLock<Vec<PairRun>>; 5] = [const { OnceLock::new() }; 5];
    let nodes = || match shared {
        0 => product(&SIX),
        4 => product(&THREE.map(|weights| (weights, 1.0 / 3.0))),
        shared => singular(shared, SINGULAR_NODES),
    };
    let runs = |nodes: Vec<PairNode>| {
        let run = |nodes: &[PairNode]| {
            // Beyond the last one is a copy of it without weight.
            let node = |l: usize| &nodes[l.min(nodes.len() - 1)];
            let weight = |l: usize| if l < nodes.len() { node(l).2 as f32 } else { 0.0 };
            let own = [0, 1, 2].map(|i| each(|l| node(l).0[i] as f32));
            (own, [0, 1, 2].map(|i| each(|l| node(l).1[i] as f32)), each(weight))
        };
        nodes.chunks(LANES).map(run).collect()
    };
    RULES[shared].get_or_init(|| runs(nodes()))
}

fn product(nodes: &[([f64; 3], f64)]) -> Vec<PairNode> {
    nodes.iter().flat_map(|(u, wu)| nodes.iter().map(move |(v, wv)| (*u, *v, wu * wv))).collect()
}

/// The rules of Sauter and Schwab, with Gauss's rule in each dimension. Triangles have the coordinates 0 ≤ x₂ ≤ x₁ ≤ 1
/// with the shared corners first.
fn singular(shared: usize, nodes: usize) -> Vec<PairNode> {
    let line: Vec<_> =
        gauss_legendre(nodes).into_iter().map(|(x, weight)| ((x + 1.0) / 2.0, weight / 2.0)).collect();
    let mut all = Vec::new();
    let barycentric = |[x1, x2]: [f64; 2]| [1.0 - x1, x1 - x2, x2];
    for &(s, ws) in &line {
        for &(a, wa) in &line {
            for &(b, wb) in &line {
                for &(c, wc) in &line {
                    let mut add = |x: [f64; 2], y: [f64; 2], jacobian: f64| {
                        // Twice the area of each reference triangle is 1.
                        let weight = 4.0 * ws * wa * wb * wc * jacobian;
                        all.push((barycentric(x.map(|x| s * x)), barycentric(y.map(|y| s * y)), weight));
                    };
                    let s3 = s * s * s;
                    match shared {
                        3 => {
                            let jacobian = s3 * a * a * b;
                            let pairs = [
                                ([1.0, 1.0 - a + a * b], [1.0 - a * b * c, 1.0 - a]),
                                ([1.0, a * (1.0 - b + b * c)], [1.0 - a * b, a * (1.0 - b)]),
                                ([1.0 - a * b * c, a * (1.0 - b * c)], [1.0, a * (1.0 - b)]),
                            ];
                            for (x, y) in pairs {
                                add(x, y, jacobian);
                                add(y, x, jacobian);
                            }
                        }
                        2 => {
                            let jacobian = s3 * a * a;
                            add([1.0, a * c], [1.0 - a * b, a * (1.0 - b)], jacobian);
                            let jacobian = jacobian * b;
                            add([1.0, a], [1.0 - a * b * c, a * b * (1.0 - c)], jacobian);
                            add([1.0 - a * b, a * (1.0 - b)], [1.0, a * b * c], jacobian);
                            add([1.0 - a * b * c, a * b * (1.0 - c)], [1.0, a], jacobian);
                            add([1.0 - a * b * c, a * (1.0 - b * c)], [1.0, a * b], jacobian);
                        }
                        _ => {
                            let jacobian = s3 * b;
                            add([1.0, a], [b, b * c], jacobian);
                            add([b, b * c], [1.0, a], jacobian);
                        }
                    }
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn rules_for_pairs_agree_with_divided_triangles() {
        // Pairs that share 3, 2, 1 and no corners; ∫∫ 1/R over the triangles, of which the second is divided until the
        // pieces are clear of the first or negligible.
        let corners = [
            dvec3(0.0, 0.0, 0.0),
            dvec3(1.0, 0.1, 0.0),
            dvec3(0.3, 0.9, 0.2),
            dvec3(0.9, -0.7, 0.5),
            dvec3(-0.8, -0.6, 0.3),
            dvec3(-0.6, 0.7, -0.2),
        ];
        let mesh = Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2], [1, 0, 3], [4, 5, 0]] };
        let facets = Facet::all(&mesh);
        for (other, shared) in [(0, 3), (1, 2), (2, 1)] {
            let [a, b] = aligned(facets[0].nodes, facets[other].nodes);
            let sum = |nodes: usize| -> [f64; 3] {
                let mut sums = [0.0; 3];
                for (u, v, weight) in singular(shared, nodes) {
                    let place = |facet: &Facet, order: [usize; 3], u: [f64; 3]| -> DVec3 {
                        (0..3).map(|i| facet.corners[order[i]] * u[i]).sum()
                    };
                    let r = place(&facets[0], a, u).distance(place(&facets[other], b, v));
                    sums[0] += weight;
                    sums[1] += weight / r;
                    sums[2] += weight * u[2] * v[1];
                }
                sums
            };
            let (few, many) = (sum(SINGULAR_NODES), sum(9));
            assert!((many[0] - 1.0).abs() < 1e-12, "{shared}: all of both areas, not {}", many[0]);
            assert!((many[2] - 1.0 / 9.0).abs() < 1e-12, "{shared}: {}", many[2]);
            assert!((few[1] / many[1] - 1.0).abs() < 2e-3, "{shared}: {} {}", few[1], many[1]);
            if shared == 3 {
                // A quarter of the triangle with itself has twice the mean of the whole.
                let [p, q, r] = facets[0].corners;
                let vertices = vec![p, q, r, p.midpoint(q), q.midpoint(r), r.midpoint(p)];
                let triangles = vec![[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
                let parts = Facet::all(&Mesh { vertices, triangles });
                let apart = (0..16).filter(|i| i / 4 != i % 4);
                let means = apart.map(|i| divided(parts[i / 4].corners, parts[i % 4].corners, 6));
                let expected = means.sum::<f64>() / 8.0;
                assert!((many[1] / expected - 1.0).abs() < 1e-2, "{shared}: {} {expected}", many[1]);
                continue;
            }
            let expected = divided(facets[0].corners, facets[other].corners, 6);
            assert!((many[1] / expected - 1.0).abs() < 5e-3, "{shared}: {} {expected}", many[1]);
        }
    }

    /// The mean of 1/R over both triangles, by pieces.
    fn divided(first: [DVec3; 3], second: [DVec3; 3], depth: usize) -> f64 {
        let centre = |t: [DVec3; 3]| t.iter().sum::<DVec3>() / 3.0;
        let size = |t: [DVec3; 3]| t.iter().map(|c| c.distance(centre(t))).fold(0.0, f64::max);
        let r = centre(first).distance(centre(second));
        if depth == 0 || r > 3.0 * (size(first) + size(second)) {
            // Pieces that meet: the mean of 1/R is near that over a disk.
            return 1.0 / r.max(0.4 * (size(first) + size(second)));
        }
        let pieces = |[a, b, c]: [DVec3; 3]| {
            let (ab, bc, ca) = (a.midpoint(b), b.midpoint(c), c.midpoint(a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        let own = pieces(first);
        let pairs = own.iter().flat_map(|own| pieces(second).map(|other| divided(*own, other, depth - 1)));
        pairs.sum::<f64>() / 16.0
    }
}
