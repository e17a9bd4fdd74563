//! e^{-jkR}/R in vector registers, f32.

use crate::simd::{Instructions, fused};

/// Values processed together.
pub(super) const LANES: usize = 16;

pub(super) type Lanes = [f32; LANES];

/// One value for every lane.
#[inline(always)]
pub(super) fn wide<const N: usize>(value: impl Fn(usize) -> f32) -> [f32; N] {
    let mut values = [0.0; N];
    for (lane, to) in values.iter_mut().enumerate() {
        *to = value(lane);
    }
    values
}

/// The same of [`LANES`].
#[inline(always)]
pub(super) fn each(value: impl Fn(usize) -> f32) -> Lanes {
    wide(value)
}

/// Coefficients of sin(πf)/f in f², |f| ≤ ½, lowest first; 7e-9 off before rounding.
pub(crate) const SINE: [f32; 5] = [std::f32::consts::PI, -5.167_71, 2.550_077_4, -0.598_290_4, 0.077_655_91];
/// Coefficients of cos(πf) in f², |f| ≤ ½, lowest first; 1e-9 off before rounding.
pub(crate) const COSINE: [f32; 6] = [1.0, -4.934_802, 4.058_711_5, -1.335_24, 0.235_074_37, -0.024_627_112];
/// Adding and taking away this rounds an f32 of less than 2²² to the nearest whole number.
const ROUNDER: f32 = 12_582_912.0;

/// 1/√x.
#[inline(always)]
pub(super) fn inverse_roots<I: Instructions, const N: usize>(x: &[f32; N]) -> [f32; N] {
    let rough = I::rough_inverse_roots(x);
    wide(|l| rough[l] * fused::<I>(-0.5 * x[l] * rough[l], rough[l], 1.5))
}

/// A gain times the cosine and the sine of πx: the gain as it is or negative, cosine, and sine.
#[inline(always)]
pub(super) fn phasor<I: Instructions, const N: usize>(x: &[f32; N], gain: &[f32; N]) -> [[f32; N]; 3] {
    let rounded: [f32; N] = wide(|l| x[l] + ROUNDER);
    let f: [f32; N] = wide(|l| x[l] - (rounded[l] - ROUNDER));
    let f2: [f32; N] = wide(|l| f[l] * f[l]);
    let (mut sine, mut cosine) = ([SINE[4]; N], [COSINE[5]; N]);
    for term in (0..4).rev() {
        sine = wide(|l| fused::<I>(sine[l], f2[l], SINE[term]));
    }
    for term in (0..5).rev() {
        cosine = wide(|l| fused::<I>(cosine[l], f2[l], COSINE[term]));
    }
    // An odd number of half turns changes both signs.
    let gain = wide(|l| f32::from_bits(gain[l].to_bits() ^ (rounded[l].to_bits() << 31)));
    [gain, cosine, wide(|l| f[l] * sine[l])]
}

/// e^{-jkR}/R in lanes: real part, minus the imaginary part, and 1/R with R.
#[inline(always)]
pub(super) fn wave<I: Instructions>(half_turns_per_metre: f32, r2: &Lanes) -> [Lanes; 4] {
    let inverse = inverse_roots::<I, LANES>(r2);
    let r = each(|l| r2[l] * inverse[l]);
    let [g, cosine, sine] = phasor::<I, LANES>(&each(|l| r[l] * half_turns_per_metre), &inverse);
    [each(|l| g[l] * cosine[l]), each(|l| g[l] * sine[l]), inverse, r]
}
