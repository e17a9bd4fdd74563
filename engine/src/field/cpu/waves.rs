//! The waves of elements at a block of points in vector registers; the counterpart of `shaders/piston.wgsl` and
//! `shaders/exact_piston.wgsl`.

#![expect(clippy::needless_range_loop, reason = "lanes are what is looped over, in several arrays at once")]

use std::f32::consts::SQRT_2;

use glam::DVec3;

use crate::acoustics::element::NEAREST;
use crate::field::sources::{COSINE, Piston, SINE, Wave};
use crate::simd::{Instructions, Kernel, fused, larger};

/// Points computed together.
pub const LANES: usize = 64;
/// Adding and taking away this rounds an f32 of less than 2²² to the nearest whole number.
const ROUNDER: f32 = 12_582_912.0;
/// m², of the nearest distance from an element of a curved board.
const NEAREST_SQUARED: f32 = (NEAREST * NEAREST) as f32;

/// The places of one block.
#[derive(Debug)]
pub struct Points {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    /// e^{-jk|z|}, or 0 behind a flat board.
    onward_re: [f32; LANES],
    onward_im: [f32; LANES],
}

impl Points {
    /// `count` points; lanes beyond repeat the last.
    pub fn new(wave: &Wave, count: usize, point: impl Fn(usize) -> DVec3) -> Self {
        let zeros = [0.0; LANES];
        let mut points = Self { x: zeros, y: zeros, z: zeros, onward_re: zeros, onward_im: zeros };
        let mut last = (f64::NAN, (0.0, 0.0));
        for lane in 0..LANES {
            let point = point(lane.min(count - 1));
            let z = if wave.is_flat { point.z.max(NEAREST) } else { point.z };
            points.x[lane] = point.x as f32;
            points.y[lane] = point.y as f32;
            points.z[lane] = z as f32;
            if point.z >= -NEAREST || !wave.is_flat {
                // Neighbours often have the same height.
                if z != last.0 {
                    let (sin, cos) = (-std::f32::consts::TAU * wave.turns(z.abs())).sin_cos();
                    last = (z, (cos, sin));
                }
                (points.onward_re[lane], points.onward_im[lane]) = last.1;
            }
        }
        points
    }
}

/// Complex pressure at a block of points.
pub(super) struct Sum {
    pub(super) re: [f32; LANES],
    pub(super) im: [f32; LANES],
}

impl Sum {
    const ZERO: Self = Self { re: [0.0; LANES], im: [0.0; LANES] };

    /// Rotated by the common phase of all elements.
    pub(super) fn onward(&self, points: &Points) -> Self {
        let mut turned = Self::ZERO;
        for lane in 0..LANES {
            turned.re[lane] = self.re[lane] * points.onward_re[lane] - self.im[lane] * points.onward_im[lane];
            turned.im[lane] = self.re[lane] * points.onward_im[lane] + self.im[lane] * points.onward_re[lane];
        }
        turned
    }
}

/// [`crate::field::sources::Form`], for loops of its own each.
pub(super) const ROUND: usize = 0;
pub(super) const OF_COSINE: usize = 1;
pub(super) const RECTANGLE: usize = 2;

/// S · D(θ)/r · e^{-αr} · e^{j(φ - k(r - |z|))} summed over the elements (`Sources::elements`) of a flat board or of a curved one, with
/// D of `D` terms and the decay of `A`; [`Sum::onward`] adds the rest.
pub(super) struct FarField<'a, const FORM: usize, const D: usize, const A: usize, const FLAT: bool> {
    pub(super) wave: &'a Wave,
    pub(super) elements: &'a [[f32; 4]],
    /// Tilt of every element; empty for a flat board.
    pub(super) tilts: &'a [[f32; 4]],
    pub(super) points: &'a Points,
}

impl<const FORM: usize, const D: usize, const A: usize, const FLAT: bool> Kernel
    for FarField<'_, FORM, D, A, FLAT>
{
    type Output = Sum;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Sum {
        far_field::<I, FORM, D, A, FLAT>(self.wave, (self.elements, self.tilts), self.points)
    }
}

#[inline(always)]
fn far_field<I: Instructions, const FORM: usize, const D: usize, const A: usize, const FLAT: bool>(
    wave: &Wave,
    (elements, tilts): (&[[f32; 4]], &[[f32; 4]]),
    points: &Points,
) -> Sum {
    let [directivity, other]: [[f32; D]; 2] =
        wave.directivity.each_ref().map(|part| first(&part.coefficients));
    let decay: [f32; A] = first(&wave.decay.coefficients);
    let [decay_slope, decay_offset] = wave.decay_scale;
    let half_turns_per_metre = 2.0 * wave.turns_per_metre;
    let mut sum = Sum::ZERO;
    for (n, &[x, y, phase, strength]) in elements.iter().enumerate() {
        let phase = 2.0 * phase;
        let [height, towards_x, towards_y, towards_z] = if FLAT { [0.0, 0.0, 0.0, 1.0] } else { tilts[n] };
        // Stage by stage over all lanes, so that neighbouring instructions are independent. r² - z² (ρ² for a flat
        // board), and r².
        let mut rho2 = [0.0; LANES];
        let mut r2 = [0.0; LANES];
        // Before the element's plane.
        let mut ahead = [0.0; LANES];
        for lane in 0..LANES {
            let (dx, dy, z) = (points.x[lane] - x, points.y[lane] - y, points.z[lane]);
            rho2[lane] = fused::<I>(dx, dx, dy * dy);
            if FLAT {
                r2[lane] = fused::<I>(z, z, rho2[lane]);
            } else {
                let dz = z - height;
                r2[lane] = larger(fused::<I>(dz, dz, rho2[lane]), NEAREST_SQUARED);
                rho2[lane] = fused::<I>(height, fused::<I>(-2.0, z, height), rho2[lane]);
                ahead[lane] = fused::<I>(dx, towards_x, fused::<I>(dy, towards_y, dz * towards_z));
            }
        }
        let rough = I::rough_inverse_roots(&r2);
        let mut beyond = [0.0; LANES];
        let mut amplitude = [0.0; LANES];
        // The imaginary part of the directivity.
        let mut across = [0.0; LANES];
        for lane in 0..LANES {
            let z = if FLAT { points.z[lane] } else { points.z[lane].abs() };
            // Newton's step for 1/r.
            let minus_half = -0.5 * rough[lane];
            let inverse = minus_half * fused::<I>(r2[lane] * rough[lane], rough[lane], -3.0);
            let r = r2[lane] * inverse;
            // And one for r - z, the root of d² + 2zd = ρ²: rounding is then relative to r - z, not to r.
            let d = r - z;
            beyond[lane] = fused::<I>(fused::<I>(d, r + z, -rho2[lane]), minus_half, d);
            let height = if FLAT { z } else { ahead[lane] };
            let (re, im) = match FORM {
                RECTANGLE => {
                    let along = |place: f32| {
                        let part = SQRT_2 * place * inverse;
                        fused::<I>(part, part, -1.0)
                    };
                    let (dx, dy) = (points.x[lane] - x, points.y[lane] - y);
                    (horner::<I, D>(&directivity, along(dx)) * horner::<I, D>(&other, along(dy)), 0.0)
                }
                OF_COSINE => {
                    // A D in cosθ, other than one in its square, shows that heights are clamped.
                    let s = fused::<I>(2.0 * larger(height, NEAREST as f32), inverse, -1.0);
                    (clenshaw::<I, D>(&directivity, s), clenshaw::<I, D>(&other, s))
                }
                _ => {
                    // 2 sin²θ - 1 = 1 - 2 cos²θ.
                    let cos = SQRT_2 * height * inverse;
                    (horner::<I, D>(&directivity, fused::<I>(-cos, cos, 1.0)), 0.0)
                }
            };
            let strength = if FLAT || ahead[lane] >= -NEAREST as f32 { strength } else { 0.0 };
            let decayed = horner::<I, A>(&decay, fused::<I>(r, decay_slope, decay_offset));
            amplitude[lane] = strength * inverse * re * decayed;
            if FORM == OF_COSINE {
                across[lane] = strength * inverse * im * decayed;
            }
        }
        for lane in 0..LANES {
            let turn = turn::<I>(beyond[lane], half_turns_per_metre, phase);
            let amplitude = turn.signed(amplitude[lane]);
            sum.re[lane] = fused::<I>(amplitude, turn.cos, sum.re[lane]);
            sum.im[lane] = fused::<I>(-amplitude, turn.sin, sum.im[lane]);
            if FORM == OF_COSINE {
                let across = turn.signed(across[lane]);
                sum.re[lane] = fused::<I>(across, turn.sin, sum.re[lane]);
                sum.im[lane] = fused::<I>(across, turn.cos, sum.im[lane]);
            }
        }
    }
    sum
}

/// The baffled piston's integral (`acoustics::element`) summed over the elements.
///
/// With h = (R - z)/λ half-turns its wave is e^{-jkz} e^{-jπh}, and its sinc is that of the same angle.
pub(super) struct ExactPiston<'a> {
    pub(super) piston: &'a Piston,
    pub(super) wave: &'a Wave,
    pub(super) elements: &'a [[f32; 4]],
    pub(super) points: &'a Points,
}

impl Kernel for ExactPiston<'_> {
    type Output = Sum;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Sum {
        exact_piston::<I>(self.piston, self.wave, self.elements, self.points)
    }
}

#[inline(always)]
fn exact_piston<I: Instructions>(
    Piston { radius, nodes }: &Piston,
    wave: &Wave,
    elements: &[[f32; 4]],
    points: &Points,
) -> Sum {
    let mut sum = Sum::ZERO;
    let decay: [f32; 16] = wave.decay.coefficients;
    let [decay_slope, decay_offset] = wave.decay_scale;
    let scale = 2.0 / (radius * nodes.len() as f32);
    for &[x, y, phase, strength] in elements {
        let own = turn::<I>(phase, 2.0, 0.0);
        let mut rho2 = [0.0; LANES];
        let mut integral = Sum::ZERO;
        for lane in 0..LANES {
            let (dx, dy) = (points.x[lane] - x, points.y[lane] - y);
            rho2[lane] = fused::<I>(dx, dx, dy * dy);
        }
        for &[cos_psi, four_a_sin2] in nodes {
            for lane in 0..LANES {
                let (rho, z) = (rho2[lane].sqrt(), points.z[lane]);
                let beyond = rho - radius;
                let rim2 = fused::<I>(rho, four_a_sin2, beyond * beyond);
                let inverse = 1.0 / (fused::<I>(z, z, rim2).sqrt() + z);
                // Small enough for a sinc of 1, large enough to divide by.
                let h = larger(rim2 * inverse * wave.turns_per_metre, 1e-6);
                // The common sign of sine and cosine is squared away.
                let Turn { cos, sin, .. } = turn::<I>(h, 1.0, 0.0);
                let weight = fused::<I>(-rho, cos_psi, *radius) * inverse * sin / (std::f32::consts::PI * h);
                integral.re[lane] = fused::<I>(weight, cos, integral.re[lane]);
                integral.im[lane] = fused::<I>(weight, -sin, integral.im[lane]);
            }
        }
        for lane in 0..LANES {
            let z = points.z[lane];
            let r = fused::<I>(z, z, rho2[lane]).sqrt();
            let decayed = horner::<I, 16>(&decay, fused::<I>(r, decay_slope, decay_offset));
            let amplitude = strength * scale * decayed;
            let (re, im) = (own.signed(amplitude) * own.cos, own.signed(amplitude) * own.sin);
            sum.re[lane] += re * integral.re[lane] - im * integral.im[lane];
            sum.im[lane] += re * integral.im[lane] + im * integral.re[lane];
        }
    }
    sum
}

/// cos and sin of π (distance · rate - phase), phase in half-turns and rate in half-turns per metre.
#[inline(always)]
fn turn<I: Instructions>(distance: f32, rate: f32, phase: f32) -> Turn {
    let rounded = fused::<I>(distance, rate, -phase) + ROUNDER;
    let whole = rounded - ROUNDER;
    // With FMA the product is not rounded before whole half-turns are subtracted.
    let f = fused::<I>(distance, rate, -whole) - phase;
    let f2 = f * f;
    Turn {
        cos: horner::<I, 6>(&COSINE, f2),
        sin: f * horner::<I, 5>(&SINE, f2),
        // The last bit of the rounded sum is the parity of `whole`.
        flip: rounded.to_bits() << 31,
    }
}

/// Cosine and sine without their common sign.
struct Turn {
    cos: f32,
    sin: f32,
    /// The sign bit, flipped by an odd number of half-turns.
    flip: u32,
}

impl Turn {
    #[inline(always)]
    fn signed(&self, value: f32) -> f32 {
        f32::from_bits(value.to_bits() ^ self.flip)
    }
}

#[inline(always)]
fn horner<I: Instructions, const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    let mut sum = coefficients[N - 1];
    for i in (0..N - 1).rev() {
        sum = fused::<I>(sum, x, coefficients[i]);
    }
    sum
}

/// A sum of Chebyshev polynomials, by Clenshaw's rule.
#[inline(always)]
fn clenshaw<I: Instructions, const N: usize>(coefficients: &[f32; N], s: f32) -> f32 {
    let twice = 2.0 * s;
    let (mut now, mut before) = (0.0, 0.0);
    for i in (1..N).rev() {
        (now, before) = (fused::<I>(twice, now, coefficients[i] - before), now);
    }
    fused::<I>(s, now, coefficients[0] - before)
}

#[inline(always)]
fn first<const N: usize>(coefficients: &[f32]) -> [f32; N] {
    std::array::from_fn(|i| coefficients[i])
}
