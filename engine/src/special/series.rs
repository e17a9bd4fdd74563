//! Series of elementary functions in vector registers.

use std::f64::consts::SQRT_2;

use crate::simd::{Instructions, fused64, lanes};

/// Elements processed together.
pub(crate) const LANES: usize = 8;
/// Adding and taking away this rounds an f64 of less than 2⁵¹ to the nearest whole number.
pub(crate) const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// √2 cos(πf/2) in f² for |f| ≤ 1/2, 1e-16 off. These polynomials agree with their function at the Chebyshev nodes.
pub(crate) const COSINE: [f64; 7] = [
    SQRT_2,
    -1.744_716_049_909_693_6,
    0.358_742_858_432_497_7,
    -0.029_505_417_413_671_225,
    0.001_300_029_888_695_330_7,
    -3.563_837_306_438_805e-5,
    6.583_583_005_207_542e-7,
];
/// √2 sin(πf/2)/f in f² for |f| ≤ 1/2, 7e-17 off.
pub(crate) const SINE: [f64; 7] = [
    2.221_441_469_079_183,
    -0.913_531_187_499_427_1,
    0.112_702_392_858_284_1,
    -0.006_621_000_189_652_891,
    0.000_226_898_051_342_352_55,
    -5.089_250_235_931_372e-6,
    7.967_585_563_362_772e-8,
];
/// 1/n!
pub(crate) const fn inverse_factorials<const N: usize>() -> [f64; N] {
    let mut terms = [1.0; N];
    let mut n = 1;
    while n < N {
        terms[n] = terms[n - 1] / n as f64;
        n += 1;
    }
    terms
}

/// The polynomial's value.
#[inline(always)]
pub(crate) fn value<I: Instructions, const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let mut sum = coefficients[N - 1];
    for i in (0..N - 1).rev() {
        sum = fused64::<I>(sum, x, coefficients[i]);
    }
    sum
}

/// The polynomial's value in every lane.
#[inline(always)]
pub(crate) fn horner<I: Instructions, const N: usize>(
    coefficients: &[f64; N],
    x: &[f64; LANES],
) -> [f64; LANES] {
    let mut sum = [coefficients[N - 1]; LANES];
    for i in (0..N - 1).rev() {
        sum = lanes(|lane| fused64::<I>(sum[lane], x[lane], coefficients[i]));
    }
    sum
}
