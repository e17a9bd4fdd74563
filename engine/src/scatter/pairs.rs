//! Entries of the operator between one triangle and many, in f32 vector registers: the rule of three points on both.
//!
//! With d from x to y, g = 1/(4πR) and φ = kR, the integrand of [`crate::scatter::facets`] is a g (sin φ + j cos φ) -
//! m g/R² ((cos φ + φ sin φ) + j (φ cos φ - sin φ)), a = k (β + n·n'), m = n'·d times -1 plus n·d times -β with the
//! trial functions on the many, and n·d + β n'·d with the test functions there.

use glam::DVec3;

use crate::scatter::facets::{Facet, THREE, Wall};
use crate::scatter::waves::{LANES, Lanes, each, wave};
use crate::simd::{Instructions, Isa, Kernel, fused};

/// A corner outside a cluster.
pub(super) const OUTSIDE: u32 = u32::MAX;

/// The triangles around the nodes of a cluster, for the many.
#[derive(Clone, Debug, Default)]
pub(super) struct Panel {
    /// Nodes of the cluster.
    pub nodes: usize,
    pub triangles: Vec<u32>,
    /// The node of each corner within the cluster, or [`OUTSIDE`].
    pub corners: Vec<[u32; 3]>,
    /// m, of the rule's points: a run of lanes per axis and point.
    places: [[Vec<f32>; 3]; 3],
    normals: [Vec<f32>; 3],
    /// 1/m, of every corner's function.
    curls: [[Vec<f32>; 3]; 3],
    /// m², a third of each area; 0 beyond the last.
    weights: Vec<f32>,
    /// Numbers of the triangles.
    numbers: Vec<u32>,
}

impl Panel {
    /// Those of a cluster, with places relative to a point near all of them (m).
    pub fn new(
        facets: &[Facet],
        (triangles, corners): (Vec<u32>, Vec<[u32; 3]>),
        nodes: usize,
        origin: DVec3,
    ) -> Self {
        let room = triangles.len().next_multiple_of(LANES);
        // Beyond the last one is a copy of it without weight.
        let index = |i: usize| triangles[i.min(triangles.len() - 1)] as usize;
        let values = |value: &dyn Fn(&Facet) -> f64| {
            (0..room).map(|i| value(&facets[index(i)]) as f32).collect::<Vec<_>>()
        };
        let axes =
            |value: &dyn Fn(&Facet) -> DVec3| [0, 1, 2].map(|axis| values(&|facet| value(facet)[axis]));
        let mut weights = values(&|facet| facet.area / 3.0);
        weights[triangles.len()..].fill(0.0);
        Self {
            nodes,
            places: [0, 1, 2].map(|point| axes(&|facet| facet.at(THREE[point]) - origin)),
            normals: axes(&|facet| facet.normal),
            curls: [0, 1, 2].map(|corner| axes(&|facet| facet.curls[corner])),
            weights,
            numbers: (0..room).map(|i| index(i) as u32).collect(),
            triangles,
            corners,
        }
    }
}

/// Which side the many are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Many {
    Trial,
    Test,
}

/// One triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct One {
    number: u32,
    places: [[f32; 3]; 3],
    normal: [f32; 3],
    curls: [[f32; 3]; 3],
    weight: f32,
}

impl One {
    pub fn all(facets: &[Facet], origin: DVec3) -> Vec<Self> {
        let short = |v: DVec3| v.as_vec3().to_array();
        let of = |(number, facet): (usize, &Facet)| Self {
            number: number as u32,
            places: facet.points().map(|at| short(at - origin)),
            normal: short(facet.normal),
            curls: facet.curls.map(short),
            weight: (facet.area / 3.0 / (4.0 * std::f64::consts::PI)) as f32,
        };
        facets.iter().enumerate().map(of).collect()
    }
}

/// Triangles between two scatterings of sums into rows: the sums of a leaf's nodes stay in the second cache.
const RUN: usize = 256;

/// Adds the entries between the nodes around some triangles and those of a panel, real and imaginary parts: a row of
/// the panel's nodes for each. A corner of the single triangles has a number of a row, or [`OUTSIDE`].
pub(super) fn add(
    wall: &Wall,
    singles: &[(&One, [u32; 3])],
    (panel, many): (&Panel, Many),
    rows: [&mut [f32]; 2],
) {
    Isa::best().run(Rows { wall, singles, panel, many, rows });
}

struct Rows<'a> {
    wall: &'a Wall,
    singles: &'a [(&'a One, [u32; 3])],
    panel: &'a Panel,
    many: Many,
    rows: [&'a mut [f32]; 2],
}

impl Kernel for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { wall, singles, panel, many, rows: [to_re, to_im] } = self;
        let count = to_re.len() / panel.nodes;
        let mut sums = vec![[[[0f32; LANES]; 2]; 3]; count * (RUN / LANES)];
        for start in (0..panel.numbers.len()).step_by(RUN) {
            let blocks = (panel.numbers.len() - start).min(RUN) / LANES;
            sums.fill([[[0.0; LANES]; 2]; 3]);
            for (one, rows) in singles {
                for block in 0..blocks {
                    let entries = block_of::<I>(wall, one, panel, start + block * LANES, many);
                    for (entries, row) in entries.iter().zip(rows) {
                        if *row != OUTSIDE {
                            let to = &mut sums[*row as usize * (RUN / LANES) + block];
                            for corner in 0..3 {
                                for part in 0..2 {
                                    for lane in 0..LANES {
                                        to[corner][part][lane] += entries[corner][part][lane];
                                    }
                                }
                            }
                        }
                    }
                }
            }
            let corners =
                &panel.corners[start.min(panel.corners.len())..(start + RUN).min(panel.corners.len())];
            for row in 0..count {
                let first = row * panel.nodes;
                let (re, im) =
                    (&mut to_re[first..first + panel.nodes], &mut to_im[first..first + panel.nodes]);
                for (i, nodes) in corners.iter().enumerate() {
                    let sums = &sums[row * (RUN / LANES) + i / LANES];
                    for (corner, &node) in nodes.iter().enumerate() {
                        if node != OUTSIDE {
                            re[node as usize] += sums[corner][0][i % LANES];
                            im[node as usize] += sums[corner][1][i % LANES];
                        }
                    }
                }
            }
        }
    }
}

/// The entries between one triangle's corners and those of a run of lanes, real and imaginary parts.
#[inline(always)]
fn block_of<I: Instructions>(
    wall: &Wall,
    one: &One,
    panel: &Panel,
    at: usize,
    many: Many,
) -> [[[Lanes; 2]; 3]; 3] {
    let run =
        |values: &[f32]| -> Lanes { *values[at..].first_chunk().expect("panels are padded to whole runs") };
    let (k, beta) = (wall.wavenumber as f32, wall.admittance as f32);
    let per_metre = (wall.wavenumber / std::f64::consts::PI) as f32;
    let n = [run(&panel.normals[0]), run(&panel.normals[1]), run(&panel.normals[2])];
    let own = one.normal;
    let even =
        each(|l| k * (beta + fused::<I>(own[0], n[0][l], fused::<I>(own[1], n[1][l], own[2] * n[2][l]))));
    let (of_many, of_one) = match many {
        Many::Trial => (-1.0, -beta),
        Many::Test => (beta, 1.0),
    };
    // The normal whose product with d is m.
    let m = [
        each(|l| fused::<I>(of_many, n[0][l], of_one * own[0])),
        each(|l| fused::<I>(of_many, n[1][l], of_one * own[1])),
        each(|l| fused::<I>(of_many, n[2][l], of_one * own[2])),
    ];
    let mut single = [[0f32; LANES]; 2];
    // Sums over the many's points with its functions, for each point of the one.
    let mut sums = [[[[0f32; LANES]; 2]; 3]; 3];
    for (x, sums) in one.places.iter().zip(&mut sums) {
        let mut total = [[0f32; LANES]; 2];
        for (place, sum) in panel.places.iter().zip(sums.iter_mut()) {
            let y = [run(&place[0]), run(&place[1]), run(&place[2])];
            let (dx, dy, dz) = (each(|l| y[0][l] - x[0]), each(|l| y[1][l] - x[1]), each(|l| y[2][l] - x[2]));
            // A triangle with itself has no weight; its distance must not be 0.
            let r2 =
                each(|l| fused::<I>(dx[l], dx[l], fused::<I>(dy[l], dy[l], fused::<I>(dz[l], dz[l], 1e-16))));
            let [c, s, inverse, r] = wave::<I>(per_metre, &r2);
            let along = each(|l| {
                fused::<I>(dx[l], m[0][l], fused::<I>(dy[l], m[1][l], dz[l] * m[2][l]))
                    * (inverse[l] * inverse[l])
            });
            let kr = each(|l| k * r[l]);
            let re = each(|l| fused::<I>(even[l], s[l], -along[l] * fused::<I>(kr[l], s[l], c[l])));
            let im = each(|l| fused::<I>(even[l], c[l], -along[l] * fused::<I>(kr[l], c[l], -s[l])));
            single = [each(|l| single[0][l] + c[l]), each(|l| single[1][l] - s[l])];
            total = [each(|l| total[0][l] + re[l]), each(|l| total[1][l] + im[l])];
            *sum = [re, im];
        }
        for sum in sums.iter_mut() {
            for part in 0..2 {
                sum[part] = each(|l| fused::<I>(0.5, sum[part][l], total[part][l] * (1.0 / 6.0)));
            }
        }
    }
    let weight = run(&panel.weights);
    let numbers: [u32; LANES] = *panel.numbers[at..].first_chunk().expect("panels are padded to whole runs");
    let weight = each(|l| if numbers[l] == one.number { 0.0 } else { weight[l] * one.weight });
    let mut entries = [[[[0f32; LANES]; 2]; 3]; 3];
    for corner in 0..3 {
        let curl = [run(&panel.curls[corner][0]), run(&panel.curls[corner][1]), run(&panel.curls[corner][2])];
        let mut total = [[0f32; LANES]; 2];
        for part in 0..2 {
            total[part] = each(|l| {
                (sums[0][corner][part][l] + sums[1][corner][part][l] + sums[2][corner][part][l]) * (1.0 / 6.0)
            });
        }
        for row in 0..3 {
            let own = [one.curls[row][0] / k, one.curls[row][1] / k, one.curls[row][2] / k];
            let curls =
                each(|l| fused::<I>(own[0], curl[0][l], fused::<I>(own[1], curl[1][l], own[2] * curl[2][l])));
            let sum = &sums[row][corner];
            entries[row][corner] = [
                each(|l| {
                    weight[l] * fused::<I>(curls[l], single[1][l], fused::<I>(0.5, sum[0][l], total[0][l]))
                }),
                each(|l| {
                    weight[l] * fused::<I>(-curls[l], single[0][l], fused::<I>(0.5, sum[1][l], total[1][l]))
                }),
            ];
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::mesh::Mesh;
    use crate::scatter::facets;

    #[test]
    fn vector_entries_are_those_of_f64() {
        let mesh = crate::mesh::shapes::geodesic(0.01, 3);
        let mesh: Mesh = mesh.mapped(|at| dvec3(at.x, 1.3 * at.y, 0.8 * at.z));
        let facets = Facet::all(&mesh);
        let origin = DVec3::splat(0.001);
        let count = mesh.vertices.len();
        let all: Vec<u32> = (0..facets.len() as u32).collect();
        let panel = Panel::new(&facets, (all, mesh.triangles.clone()), count, origin);
        let ones = One::all(&facets, origin);
        for wall in [Wall { wavenumber: 700.0, admittance: 0.0 }, Wall { wavenumber: 700.0, admittance: 0.4 }]
        {
            let mut expected = vec![num_complex::Complex64::ZERO; count * count];
            for (a, first) in facets.iter().enumerate() {
                for second in &facets[..a] {
                    let [forth, back] = facets::rough(&wall, first, second);
                    for i in 0..3 {
                        for j in 0..3 {
                            let (row, column) = (first.nodes[i] as usize, second.nodes[j] as usize);
                            expected[row * count + column] += forth[i][j];
                            expected[column * count + row] += back[j][i];
                        }
                    }
                }
            }
            let largest = expected.iter().map(|e| e.norm()).fold(0.0, f64::max);
            let singles: Vec<_> = ones.iter().zip(mesh.triangles.iter().copied()).collect();
            for many in [Many::Trial, Many::Test] {
                let (mut re, mut im) = (vec![0.0; count * count], vec![0.0; count * count]);
                add(&wall, &singles, (&panel, many), [&mut re, &mut im]);
                for row in 0..count {
                    for column in 0..count {
                        let at = match many {
                            Many::Trial => row * count + column,
                            Many::Test => column * count + row,
                        };
                        let own = num_complex::Complex64::new(re[at].into(), im[at].into());
                        let off = (own - expected[row * count + column]).norm();
                        assert!(off < 2e-5 * largest, "{many:?} {row} {column}: {own}");
                    }
                }
            }
        }
    }
}
