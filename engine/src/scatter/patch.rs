//! The sound on a surface at points with areas, for integrals over it.
//!
//! Of triangles it is a cubic Bézier polynomial of the pressures and slopes at their corners. A corner's slope is the
//! mean of those of the flat triangles around it that face about the same way, turned into its plane, which is too small by (kh)²/8 on a
//! regular surface of edges h. The same mean of given slopes is too small by (kh)²/6, so three quarters of what a
//! second mean takes away are added.

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::mesh::{Mesh, area_vector};

/// Pressure (Pa) and its gradient (Pa/m).
pub type Sound = (Complex64, [Complex64; 3]);

/// A small part of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// m
    pub at: DVec3,
    /// Outwards.
    pub normal: DVec3,
    /// m²
    pub area: f64,
    /// The total pressure (Pa) and its gradient (Pa/m) just outside.
    pub sound: Sound,
}

/// Cosine between normals of triangles at a corner up to which the surface is smooth there.
const SMOOTH: f64 = 0.8;
/// What is added of the loss by a second mean.
const ADDED: f64 = 0.75;
/// Points of a rule of fifth order on a triangle, with their parts of the area (J. Radon, Monatsh. Math. 52, 286, 1948).
const RULE: [([f64; 3], f64); 7] = {
    const A: f64 = 0.059_715_871_789_769_82;
    const B: f64 = 0.470_142_064_105_115_1;
    const C: f64 = 0.797_426_985_353_087_3;
    const D: f64 = 0.101_286_507_323_456_34;
    const NEAR: f64 = 0.132_394_152_788_506_2;
    const FAR: f64 = 0.125_939_180_544_827_15;
    [
        ([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], 0.225),
        ([A, B, B], NEAR),
        ([B, A, B], NEAR),
        ([B, B, A], NEAR),
        ([C, D, D], FAR),
        ([D, C, D], FAR),
        ([D, D, C], FAR),
    ]
};

type Gradient = [Complex64; 3];

const SILENT: Gradient = [Complex64::ZERO; 3];

/// Points on triangles with pressures (Pa) at the vertices, and the pressure's slope along the normal relative to itself
/// (1/m).
pub(super) fn of_triangles(mesh: &Mesh, pressures: &[Complex64], along_normal: Complex64) -> Vec<Patch> {
    let facets: Vec<_> = (0..mesh.triangles.len()).map(|triangle| Facet::new(mesh, triangle)).collect();
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        corners.iter().for_each(|corner| around[*corner as usize].push(triangle));
    }
    let mean = |own: usize, corner: u32, of: &(dyn Fn(usize) -> Gradient + Sync)| {
        let (mut sum, mut area) = (SILENT, 0.0);
        for &other in &around[corner as usize] {
            if facets[other].normal.dot(facets[own].normal) > SMOOTH {
                let turned = turned(of(other), [facets[other].normal, facets[own].normal]);
                add(&mut sum, turned, facets[other].area);
                area += facets[other].area;
            }
        }
        sum.map(|part| part / f64::max(area, f64::MIN_POSITIVE))
    };
    let flat = |triangle: usize| {
        let mut sum = SILENT;
        for (corner, slope) in mesh.triangles[triangle].iter().zip(facets[triangle].slopes) {
            let p = pressures[*corner as usize];
            add(&mut sum, slope.to_array().map(|slope| p * slope), 1.0);
        }
        sum
    };
    let corners = |own: usize, of: &(dyn Fn(usize) -> Gradient + Sync)| {
        mesh.triangles[own].map(|corner| mean(own, corner, of))
    };
    let first: Vec<_> = (0..facets.len()).into_par_iter().map(|own| corners(own, &flat)).collect();
    let middle = |triangle: usize| {
        let mut sum = SILENT;
        first[triangle].iter().for_each(|slope| add(&mut sum, *slope, 1.0 / 3.0));
        sum
    };
    let patches = |own: usize| {
        let facet = &facets[own];
        let second = corners(own, &middle);
        let slopes: [Gradient; 3] = std::array::from_fn(|corner| {
            let (slope, less) = (first[own][corner], second[corner]);
            [0, 1, 2].map(|axis| slope[axis] + (slope[axis] - less[axis]) * ADDED)
        });
        let p = mesh.triangles[own].map(|corner| pressures[corner as usize]);
        let [a, b, c] = mesh.corners(own);
        let cubic = Cubic::new(p, slopes, [a, b, c]);
        RULE.map(|(weights, part)| {
            let (p, by_weights) = cubic.at(weights);
            let mut gradient = facet.normal.to_array().map(|n| p * along_normal * n);
            for (slope, by_weight) in facet.slopes.iter().zip(by_weights) {
                add(&mut gradient, slope.to_array().map(|slope| by_weight * slope), 1.0);
            }
            Patch {
                at: a * weights[0] + b * weights[1] + c * weights[2],
                normal: facet.normal,
                area: facet.area * part,
                sound: (p, gradient),
            }
        })
    };
    (0..facets.len()).into_par_iter().flat_map_iter(patches).collect()
}

/// A flat triangle.
struct Facet {
    normal: DVec3,
    /// m²
    area: f64,
    /// 1/m, of the linear functions that are 1 at one corner.
    slopes: [DVec3; 3],
}

impl Facet {
    fn new(mesh: &Mesh, triangle: usize) -> Self {
        let corners = mesh.corners(triangle);
        let vector = area_vector(corners);
        let (area, normal) = (vector.length(), vector.normalize_or_zero());
        let [a, b, c] = corners;
        let slope = |edge: DVec3| normal.cross(edge) / (2.0 * area.max(f64::MIN_POSITIVE));
        Self { normal, area, slopes: [slope(c - b), slope(a - c), slope(b - a)] }
    }
}

/// A polynomial on a triangle, by its corners, the points on its edges (from a corner towards another), and its middle.
struct Cubic {
    corners: [Complex64; 3],
    /// From corner i towards i + 1, and towards i + 2.
    edges: [[Complex64; 2]; 3],
    middle: Complex64,
}

impl Cubic {
    /// With values and slopes at corners (m).
    fn new(values: [Complex64; 3], slopes: [Gradient; 3], at: [DVec3; 3]) -> Self {
        let edges: [[Complex64; 2]; 3] = std::array::from_fn(|i| {
            [(i + 1) % 3, (i + 2) % 3].map(|other| {
                let way = at[other] - at[i];
                let along: Complex64 = slopes[i].iter().zip(way.to_array()).map(|(s, w)| s * w).sum();
                values[i] + along / 3.0
            })
        });
        let all: Complex64 = edges.iter().flatten().sum();
        let middle = all / 4.0 - values.iter().sum::<Complex64>() / 6.0;
        Self { corners: values, edges, middle }
    }

    /// The value, and its slopes by the three weights.
    fn at(&self, w: [f64; 3]) -> (Complex64, [Complex64; 3]) {
        let mut value = self.middle * (6.0 * w[0] * w[1] * w[2]);
        let mut slopes = [0, 1, 2].map(|i: usize| self.middle * (6.0 * w[(i + 1) % 3] * w[(i + 2) % 3]));
        for i in 0..3 {
            value += self.corners[i] * w[i].powi(3);
            slopes[i] += self.corners[i] * (3.0 * w[i] * w[i]);
            for (other, edge) in [(i + 1) % 3, (i + 2) % 3].into_iter().zip(self.edges[i]) {
                value += edge * (3.0 * w[i] * w[i] * w[other]);
                slopes[i] += edge * (6.0 * w[i] * w[other]);
                slopes[other] += edge * (3.0 * w[i] * w[i]);
            }
        }
        (value, slopes)
    }
}

/// A slope in the plane of a normal, turned with it to another, so that means on a round body lose no length.
fn turned(slope: Gradient, [from, to]: [DVec3; 2]) -> Gradient {
    let along: Complex64 = slope.iter().zip(to.to_array()).map(|(slope, n)| slope * n).sum();
    let both = (from + to) / (1.0 + from.dot(to));
    let both = both.to_array();
    [0, 1, 2].map(|axis| slope[axis] - along * both[axis])
}

fn add(sum: &mut Gradient, own: Gradient, factor: f64) {
    sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own * factor);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn waves_on_a_sphere_have_their_squares_and_slopes() {
        const K: f64 = 732.274_780;
        // A plane wave, whose pressure is 1 everywhere and whose slope along the surface is k sin θ.
        let radius = 6.0 / K;
        let mesh = shapes::sphere(radius, TAU / K / 6.0);
        let pressures: Vec<_> = mesh.vertices.iter().map(|at| Complex64::cis(-K * at.z)).collect();
        let patches = of_triangles(&mesh, &pressures, Complex64::ZERO);
        let area = patches.iter().map(|patch| patch.area).sum::<f64>();
        assert!((area / mesh.area() - 1.0).abs() < 1e-12, "{area}");
        let mean = |of: &dyn Fn(&Patch) -> f64| patches.iter().map(|it| of(it) * it.area).sum::<f64>() / area;
        let square = mean(&|patch| patch.sound.0.norm_sqr());
        let slopes = mean(&|patch| patch.sound.1.iter().map(Complex64::norm_sqr).sum::<f64>() / (K * K));
        assert!((square - 1.0).abs() < 0.01, "{square}");
        assert!((slopes * 1.5 - 1.0).abs() < 0.03, "{slopes}");
    }
}
