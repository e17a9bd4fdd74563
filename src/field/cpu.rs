//! The field in f32 on the CPU: blocks of points in vector registers, elements in the inner loop, rows on all cores.
//!
//! The body is written over arrays of lanes, which the compiler turns into vector code, and is compiled once for every
//! instruction set; the best one that the machine has is chosen when the program runs. It does what
//! `shaders/field.wgsl` does.

#![expect(clippy::needless_range_loop, reason = "lanes are what is looped over, in several arrays at once")]

use std::sync::LazyLock;

use num_complex::Complex32;
use rayon::prelude::*;

use crate::acoustics::element::NEAREST;
use crate::field::Samples;
use crate::field::sources::{COSINE, FEW_DECAY, FEW_DIRECTIVITY, Piston, SINE, Sources};

/// Points computed together.
const LANES: usize = 64;
/// Adding and taking away this rounds an f32 of less than 2²² to the nearest whole number.
const ROUNDER: f32 = 12_582_912.0;

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Isa(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Isa {
    /// Every set that this machine has, the best last.
    pub fn available() -> Vec<Self> {
        let mut sets = vec![Self(Set::Baseline)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push(Self(Set::Avx2));
            }
            if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                sets.push(Self(Set::Avx512));
            }
        }
        sets
    }

    /// The best that this machine has.
    pub fn best() -> Self {
        static BEST: LazyLock<Isa> = LazyLock::new(|| Isa::available().pop().unwrap_or(Isa(Set::Baseline)));
        *BEST
    }

    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "AVX2 + FMA",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "AVX-512",
        }
    }
}

/// Complex pressure (Pa, peak) at every sample.
pub fn pressure(sources: &Sources, samples: &Samples) -> Vec<Complex32> {
    pressure_with(Isa::best(), sources, samples)
}

/// Like [`pressure`], with one of the sets in [`Isa::available`].
pub fn pressure_with(isa: Isa, sources: &Sources, samples: &Samples) -> Vec<Complex32> {
    let block = block_of(isa, sources);
    let mut field = vec![Complex32::ZERO; samples.len()];
    field.par_chunks_mut(LANES).enumerate().for_each(|(index, chunk)| {
        let points = Points::new(sources, samples, index * LANES, chunk.len());
        let sum = block(sources, &points);
        for (lane, p) in chunk.iter_mut().enumerate() {
            *p = Complex32::new(sum.re[lane], sum.im[lane]) * points.onward[lane];
        }
    });
    field
}

/// Adds up lines of numbers, each `stride` after the one before, with a weight each: the interpolation's inner loop.
pub fn weighted_sum(lines: &[f32], stride: usize, weights: &[f32], sum: &mut [f32]) {
    match Isa::best().0 {
        Set::Baseline => weighted_lines::<false>(lines, stride, weights, sum),
        #[cfg(target_arch = "x86_64")]
        set => wide::weighted_sum(set, lines, stride, weights, sum),
    }
}

#[inline(always)]
fn weighted_lines<const FMA: bool>(lines: &[f32], stride: usize, weights: &[f32], sum: &mut [f32]) {
    const RUN: usize = 64;
    let (runs, rest) = sum.as_chunks_mut::<RUN>();
    for (index, run) in runs.iter_mut().enumerate() {
        let mut total = [0.0; RUN];
        for (line, weight) in weights.iter().enumerate() {
            let start = line * stride + index * RUN;
            let values: &[f32; RUN] = lines[start..].first_chunk().expect("a line is as long as the sum");
            for lane in 0..RUN {
                total[lane] = add::<FMA>(*weight, values[lane], total[lane]);
            }
        }
        *run = total;
    }
    let first = runs.len() * RUN;
    for (index, value) in rest.iter_mut().enumerate() {
        let at = |line: usize| lines[line * stride + first + index];
        *value = weights.iter().enumerate().map(|(line, weight)| weight * at(line)).sum();
    }
}

/// The places of one block.
struct Points {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    /// e^{-jkz}, or 0 behind the array.
    onward: [Complex32; LANES],
}

impl Points {
    /// `count` samples from number `first` on; lanes beyond repeat the last.
    fn new(sources: &Sources, samples: &Samples, first: usize, count: usize) -> Self {
        let mut points =
            Self { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES], onward: [Complex32::ZERO; LANES] };
        for lane in 0..LANES {
            let point = samples.point(first + lane.min(count - 1));
            let z = point.z.max(NEAREST);
            points.x[lane] = point.x as f32;
            points.y[lane] = point.y as f32;
            points.z[lane] = z as f32;
            if point.z >= -NEAREST {
                points.onward[lane] = Complex32::from_polar(1.0, -std::f32::consts::TAU * sources.turns(z));
            }
        }
        points
    }
}

struct Sum {
    re: [f32; LANES],
    im: [f32; LANES],
}

type Block = fn(&Sources, &Points) -> Sum;

/// The block for these sources: the common case, the general one (sharp directivity, strong absorption), or the exact
/// piston.
fn block_of(isa: Isa, sources: &Sources) -> Block {
    let common = sources.directivity.terms <= FEW_DIRECTIVITY && sources.decay.terms <= FEW_DECAY;
    match (isa.0, &sources.piston, common) {
        (Set::Baseline, None, true) => far_field::<false, FEW_DIRECTIVITY, FEW_DECAY>,
        (Set::Baseline, None, false) => far_field::<false, 24, 16>,
        (Set::Baseline, Some(_), _) => exact_piston::<false>,
        #[cfg(target_arch = "x86_64")]
        (set, _, _) => wide::block_of(set, sources, common),
    }
}

/// The same blocks with instructions that the build's target does not promise.
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "a call of these is sound only on a machine that has the set, and an `Isa` proves that"
)]
mod wide {
    use crate::field::cpu::{
        Block, FEW_DECAY, FEW_DIRECTIVITY, Points, Set, Sources, Sum, exact_piston, far_field, weighted_lines,
    };

    pub(super) fn block_of(set: Set, sources: &Sources, common: bool) -> Block {
        match (set, &sources.piston, common) {
            (Set::Avx512, None, true) => {
                |s, p| unsafe { far_field_avx512::<FEW_DIRECTIVITY, FEW_DECAY>(s, p) }
            }
            (Set::Avx512, None, false) => |s, p| unsafe { far_field_avx512::<24, 16>(s, p) },
            (Set::Avx512, Some(_), _) => |s, p| unsafe { exact_piston_avx512(s, p) },
            (_, None, true) => |s, p| unsafe { far_field_avx2::<FEW_DIRECTIVITY, FEW_DECAY>(s, p) },
            (_, None, false) => |s, p| unsafe { far_field_avx2::<24, 16>(s, p) },
            (_, Some(_), _) => |s, p| unsafe { exact_piston_avx2(s, p) },
        }
    }

    #[target_feature(enable = "avx2,fma")]
    fn far_field_avx2<const D: usize, const A: usize>(sources: &Sources, points: &Points) -> Sum {
        far_field::<true, D, A>(sources, points)
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn far_field_avx512<const D: usize, const A: usize>(sources: &Sources, points: &Points) -> Sum {
        far_field::<true, D, A>(sources, points)
    }

    pub(super) fn weighted_sum(set: Set, lines: &[f32], stride: usize, weights: &[f32], sum: &mut [f32]) {
        if set == Set::Avx512 {
            unsafe { weighted_sum_avx512(lines, stride, weights, sum) }
        } else {
            unsafe { weighted_sum_avx2(lines, stride, weights, sum) }
        }
    }

    #[target_feature(enable = "avx2,fma")]
    fn weighted_sum_avx2(lines: &[f32], stride: usize, weights: &[f32], sum: &mut [f32]) {
        weighted_lines::<true>(lines, stride, weights, sum);
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn weighted_sum_avx512(lines: &[f32], stride: usize, weights: &[f32], sum: &mut [f32]) {
        weighted_lines::<true>(lines, stride, weights, sum);
    }

    #[target_feature(enable = "avx2,fma")]
    fn exact_piston_avx2(sources: &Sources, points: &Points) -> Sum {
        exact_piston::<true>(sources, points)
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn exact_piston_avx512(sources: &Sources, points: &Points) -> Sum {
        exact_piston::<true>(sources, points)
    }
}

/// S · D(θ)/r · e^{-αr} · e^{j(φ - k(r - z))} summed over the elements, with D of `D` terms and the decay of `A`.
#[inline(always)]
fn far_field<const FMA: bool, const D: usize, const A: usize>(sources: &Sources, points: &Points) -> Sum {
    let directivity: [f32; D] = first(&sources.directivity.coefficients);
    let decay: [f32; A] = first(&sources.decay.coefficients);
    let [decay_slope, decay_offset] = sources.decay_scale;
    let half_turns_per_metre = 2.0 * sources.turns_per_metre;
    let mut sum = Sum { re: [0.0; LANES], im: [0.0; LANES] };
    for &[x, y, phase, strength] in &sources.elements {
        let phase = 2.0 * phase;
        // Stage by stage over all lanes: neighbouring instructions then do not wait for each other.
        let mut rho2 = [0.0; LANES];
        let mut r = [0.0; LANES];
        let mut both = [0.0; LANES];
        let mut amplitude = [0.0; LANES];
        for lane in 0..LANES {
            let (dx, dy, z) = (points.x[lane] - x, points.y[lane] - y, points.z[lane]);
            rho2[lane] = add::<FMA>(dx, dx, dy * dy);
            r[lane] = add::<FMA>(z, z, rho2[lane]).sqrt();
        }
        for lane in 0..LANES {
            both[lane] = 1.0 / (r[lane] * (r[lane] + points.z[lane]));
        }
        for lane in 0..LANES {
            let inverse = (r[lane] + points.z[lane]) * both[lane];
            let s = add::<FMA>(2.0 * rho2[lane] * inverse, inverse, -1.0);
            let decayed = horner::<FMA, A>(&decay, add::<FMA>(r[lane], decay_slope, decay_offset));
            amplitude[lane] = strength * inverse * horner::<FMA, D>(&directivity, s) * decayed;
        }
        for lane in 0..LANES {
            let (cos, sin) = turn::<FMA>(rho2[lane] * (r[lane] * both[lane]), half_turns_per_metre, phase);
            sum.re[lane] = add::<FMA>(amplitude[lane], cos, sum.re[lane]);
            sum.im[lane] = add::<FMA>(amplitude[lane], -sin, sum.im[lane]);
        }
    }
    sum
}

/// The baffled piston's integral (`acoustics::element`) summed over the elements.
///
/// With h = (R - z)/λ half-turns its wave is e^{-jkz} e^{-jπh}, and its sinc is that of the same angle.
#[inline(always)]
fn exact_piston<const FMA: bool>(sources: &Sources, points: &Points) -> Sum {
    let mut sum = Sum { re: [0.0; LANES], im: [0.0; LANES] };
    let Some(Piston { radius, nodes }) = &sources.piston else { return sum };
    let decay: [f32; 16] = sources.decay.coefficients;
    let [decay_slope, decay_offset] = sources.decay_scale;
    let scale = 2.0 / (radius * nodes.len() as f32);
    for &[x, y, phase, strength] in &sources.elements {
        let (cos_phase, sin_phase) = turn::<FMA>(phase, 2.0, 0.0);
        let mut rho2 = [0.0; LANES];
        let mut wave = Sum { re: [0.0; LANES], im: [0.0; LANES] };
        for lane in 0..LANES {
            let (dx, dy) = (points.x[lane] - x, points.y[lane] - y);
            rho2[lane] = add::<FMA>(dx, dx, dy * dy);
        }
        for &[cos_psi, four_a_sin2] in nodes {
            for lane in 0..LANES {
                let (rho, z) = (rho2[lane].sqrt(), points.z[lane]);
                let beyond = rho - radius;
                let rim2 = add::<FMA>(rho, four_a_sin2, beyond * beyond);
                let inverse = 1.0 / (add::<FMA>(z, z, rim2).sqrt() + z);
                // Small enough for a sinc of 1, large enough to divide by.
                let h = (rim2 * inverse * sources.turns_per_metre).max(1e-6);
                let (cos, sin) = turn::<FMA>(h, 1.0, 0.0);
                let weight = add::<FMA>(-rho, cos_psi, *radius) * inverse * sin / (std::f32::consts::PI * h);
                wave.re[lane] = add::<FMA>(weight, cos, wave.re[lane]);
                wave.im[lane] = add::<FMA>(weight, -sin, wave.im[lane]);
            }
        }
        for lane in 0..LANES {
            let z = points.z[lane];
            let r = add::<FMA>(z, z, rho2[lane]).sqrt();
            let decayed = horner::<FMA, 16>(&decay, add::<FMA>(r, decay_slope, decay_offset));
            let amplitude = strength * scale * decayed;
            let (re, im) = (amplitude * cos_phase, amplitude * sin_phase);
            sum.re[lane] += re * wave.re[lane] - im * wave.im[lane];
            sum.im[lane] += re * wave.im[lane] + im * wave.re[lane];
        }
    }
    sum
}

/// cos and sin of π (distance · rate - phase), phase in half-turns and rate in half-turns per metre.
#[inline(always)]
fn turn<const FMA: bool>(distance: f32, rate: f32, phase: f32) -> (f32, f32) {
    let rounded = add::<FMA>(distance, rate, -phase) + ROUNDER;
    let whole = rounded - ROUNDER;
    // With FMA the product is not rounded before the whole half-turns are taken away.
    let f = add::<FMA>(distance, rate, -whole) - phase;
    // The last bit of the rounded sum is the parity of `whole`; an odd number of half-turns changes both signs.
    let flip = rounded.to_bits() << 31;
    let f2 = f * f;
    let cos = horner::<FMA, 6>(&COSINE, f2);
    let sin = f * horner::<FMA, 5>(&SINE, f2);
    (f32::from_bits(cos.to_bits() ^ flip), f32::from_bits(sin.to_bits() ^ flip))
}

#[inline(always)]
fn horner<const FMA: bool, const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    let mut sum = coefficients[N - 1];
    for i in (0..N - 1).rev() {
        sum = add::<FMA>(sum, x, coefficients[i]);
    }
    sum
}

/// a b + c; fused where the machine does it in one instruction, since elsewhere `mul_add` is a slow library call.
#[inline(always)]
fn add<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

#[inline(always)]
fn first<const N: usize>(coefficients: &[f32]) -> [f32; N] {
    std::array::from_fn(|i| coefficients[i])
}
