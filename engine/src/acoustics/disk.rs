//! Quadrature points on a disk: the exact piston, for derivatives of its pressure.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Available numbers of nodes along a radius; the first sufficient one is used.
const RADIAL: [usize; 8] = [6, 8, 12, 16, 24, 32, 64, 128];
/// Accuracy of the rules, as a natural logarithm.
const DIGITS: f64 = 34.0;
/// Nodes around the disk, at most.
const MOST_AROUND: f64 = 512.0;

/// A position in radii, and its weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub at: [f64; 2],
    pub weight: f64,
}

/// Quadrature points for a point `rho` from the axis and `z` from the plane (in radii), with `ka` the wavenumber times
/// the radius. Gauss's rule along the radius, equal steps around. Both converge geometrically with the distance of the
/// point; nearer than a tenth of a radius they lose digits.
pub(super) fn nodes(ka: f64, rho: f64, z: f64) -> impl Iterator<Item = Node> {
    let z = z.max(0.02);
    // The radii (complex) at which a ring meets the point, seen from the interval: Bernstein's ellipse.
    let (re, im) = (2.0 * rho - 1.0, 2.0 * z);
    let widest = ((re - 1.0).hypot(im) + (re + 1.0).hypot(im)) / 2.0;
    let radial = count(widest.acosh(), ka / 2.0);
    let rule = RADIAL.iter().position(|&n| n as f64 >= radial).unwrap_or(RADIAL.len() - 1);
    RULES[rule].iter().flat_map(move |&(radius, weight)| {
        // The angles (complex) at which this ring meets the point.
        let excess = ((rho - radius).powi(2) + z * z) / (2.0 * rho * radius).max(1e-9);
        let across = ka * radius * rho / rho.hypot(z);
        let around = (2.0 * count((1.0 + excess).acosh(), across)).min(MOST_AROUND).ceil().max(6.0) as usize;
        (0..around).map(move |turn| {
            let (sin, cos) = (TAU * turn as f64 / around as f64).sin_cos();
            Node { at: [radius * cos, radius * sin], weight: weight / around as f64 }
        })
    })
}

/// Nodes for e^{-DIGITS}, of what has no singularity up to `growth` beside the interval, and waves that grow by
/// e^{speed sinh τ} at τ beside it.
fn count(growth: f64, speed: f64) -> f64 {
    // The wave itself needs nodes too, however far the point is.
    let tau = growth.min((DIGITS / speed.max(1e-3)).asinh());
    (DIGITS + speed * tau.sinh()) / (2.0 * tau)
}

/// Radii in [0, 1] and weights 2 r dr.
static RULES: LazyLock<[Vec<(f64, f64)>; RADIAL.len()]> = LazyLock::new(|| {
    RADIAL.map(|count| {
        let of = |(x, weight): (f64, f64)| {
            let radius = f64::midpoint(x, 1.0);
            (radius, radius * weight)
        };
        legendre(count).into_iter().map(of).collect()
    })
});

/// Nodes in [-1, 1] and weights of Gauss's rule: Newton's method on the roots of Legendre's polynomial.
pub(super) fn legendre(count: usize) -> Vec<(f64, f64)> {
    let polynomial = |x: f64| {
        let (mut before, mut this) = (1.0, x);
        for n in 1..count {
            let n = n as f64;
            (before, this) = (this, ((2.0 * n + 1.0) * x * this - n * before) / (n + 1.0));
        }
        (this, count as f64 * (x * this - before) / (x * x - 1.0))
    };
    let root = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        for _ in 0..6 {
            let (value, slope) = polynomial(x);
            x -= value / slope;
        }
        let slope = polynomial(x).1;
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(root).collect()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    #[test]
    fn waves_converge_from_a_tenth_of_a_radius_on() {
        for ka in [0.3, 4.0, 15.0] {
            for (rho, z) in
                [(0.0, 0.2), (0.4, 0.1), (0.9, 0.3), (1.1, 0.15), (1.7, 0.02), (3.0, 0.5), (4.0, 20.0)]
            {
                let wave = |[x, y]: [f64; 2]| {
                    let distance = ((x - rho).powi(2) + y * y + z * z).sqrt();
                    Complex64::from_polar(1.0 / distance, -ka * distance)
                };
                let got: Complex64 = nodes(ka, rho, z).map(|node| wave(node.at) * node.weight).sum();
                let ring = |&(radius, weight): &(f64, f64)| {
                    let turn = |i: i32| {
                        let (sin, cos) = (TAU * f64::from(i) / 1500.0).sin_cos();
                        wave([radius * cos, radius * sin])
                    };
                    (0..1500).map(turn).sum::<Complex64>() * (weight / 1500.0)
                };
                let rule = legendre(300).into_iter().map(|(x, w)| (f64::midpoint(x, 1.0), w));
                let rule: Vec<_> = rule.map(|(radius, w)| (radius, radius * w)).collect();
                let expected: Complex64 = rule.iter().map(ring).sum();
                let off = (got - expected).norm() / expected.norm();
                println!("ka {ka}, {rho} and {z} radii: {off:e} with {} nodes", nodes(ka, rho, z).count());
                assert!(off < 2e-12, "ka {ka}, {rho} and {z} radii: {off:e}");
            }
        }
    }

    #[test]
    fn a_far_point_takes_few_nodes() {
        for (ka, most) in [(0.3, 60), (4.0, 250)] {
            for (rho, z) in [(0.0, 20.0), (30.0, 0.1), (15.0, 15.0)] {
                let count = nodes(ka, rho, z).count();
                assert!(count <= most, "ka {ka}, {rho} and {z} radii: {count} nodes");
            }
        }
    }
}
