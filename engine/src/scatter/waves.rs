//! e^{-jkR}/R in vector registers, f32.

use crate::simd::{Instructions, fused};

/// Values processed together.
pub(super) const LANES: usize = 16;

pub(super) type Lanes = [f32; LANES];

/// One value for every lane.
#[inline(always)]
pub(super) fn each(value: impl Fn(usize) -> f32) -> Lanes {
    let mut values = [0.0; LANES];
    for (lane, to) in values.iter_mut().enumerate() {
        *to = value(lane);
    }
    values
}

/// sin πf / f and cos πf in f², for |f| ≤ 1/2: Taylor, 6e-8 off.
const SINE: [f32; 6] = [3.141_592_7, -5.167_712_8, 2.550_164, -0.599_264_5, 0.082_145_885, -0.007_370_431];
const COSINE: [f32; 7] =
    [1.0, -4.934_802, 4.058_712, -1.335_262_8, 0.235_330_63, -0.025_806_892, 0.001_929_574_3];
/// Adding and taking away this rounds an f32 of less than 2²² to the nearest whole number.
const ROUNDER: f32 = 12_582_912.0;

/// e^{-jkR}/R in lanes: real part, minus the imaginary part, and 1/R with R.
#[inline(always)]
pub(super) fn wave<I: Instructions>(half_turns_per_metre: f32, r2: &Lanes) -> [Lanes; 4] {
    let rough = I::rough_inverse_roots(r2);
    let inverse = each(|l| rough[l] * fused::<I>(-0.5 * r2[l] * rough[l], rough[l], 1.5));
    let r = each(|l| r2[l] * inverse[l]);
    let half_turns = each(|l| r[l] * half_turns_per_metre);
    let rounded = each(|l| half_turns[l] + ROUNDER);
    let f = each(|l| half_turns[l] - (rounded[l] - ROUNDER));
    let f2 = each(|l| f[l] * f[l]);
    let g = each(|l| f32::from_bits(inverse[l].to_bits() ^ (rounded[l].to_bits() << 31)));
    let (mut sine, mut cosine) = ([SINE[5]; LANES], [COSINE[6]; LANES]);
    for term in (0..5).rev() {
        sine = each(|l| fused::<I>(sine[l], f2[l], SINE[term]));
    }
    for term in (0..6).rev() {
        cosine = each(|l| fused::<I>(cosine[l], f2[l], COSINE[term]));
    }
    [each(|l| g[l] * cosine[l]), each(|l| g[l] * f[l] * sine[l]), inverse, r]
}
