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

/// For a point `rho` from the axis and `z` from the plane (in radii), with `ka` the wavenumber times the radius.
/// Gauss's rule along the radius, equal steps around. Both converge geometrically with the distance of the point;
/// nearer than a tenth of a radius they lose digits.
pub(super) fn nodes(ka: f64, rho: f64, z: f64) -> impl Iterator<Item = Node> {
    let z = z.max(0.02);
    // The radii (complex) at which a ring meets the point, seen from the interval: Bernstein's ellipse.
    let (re, im) = (2.0 * rho - 1.0, 2.0 * z);
    let widest = (((re - 1.0).hypot(im) + (re + 1.0).hypot(im)) / 2.0).max(1.0 + 1e-9);
    let ellipse = widest.acosh();
    let turns = |growth: f64, speed: f64| {
        // The wave itself needs nodes too, however far the point is.
        let tau = growth.min((2.0 * DIGITS / speed).cbrt().min(2.0));
        (DIGITS + speed * tau.sinh()) / (2.0 * tau)
    };
    let radial = turns(ellipse, ka / 2.0);
    let radial = RADIAL.into_iter().find(|&n| n as f64 >= radial).unwrap_or(128);
    let excess = ((rho - 1.0).powi(2) + z * z) / (2.0 * rho.max(1e-9));
    let strip = (1.0 + excess).acosh();
    let across = ka * rho / rho.hypot(z);
    let around = (2.0 * turns(strip, across.max(1.0))).min(MOST_AROUND).ceil().max(6.0) as usize;
    let rule = &RULES[RADIAL.iter().position(|&n| n == radial).unwrap_or(0)];
    rule.iter().flat_map(move |&(radius, weight)| {
        (0..around).map(move |turn| {
            let (sin, cos) = (TAU * turn as f64 / around as f64).sin_cos();
            Node { at: [radius * cos, radius * sin], weight: weight / around as f64 }
        })
    })
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
