//! SIMD instruction sets: detection, and compilation of one body of plain loops for each of them.
//!
//! A [`Kernel`] is written over arrays of lanes, which the compiler turns into vector code. [`Isa::run`] calls the
//! copy that was compiled for a set; an `Isa` proves that the machine has it.

use std::sync::LazyLock;

use strum::IntoStaticStr;

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Isa(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "UPPERCASE", const_into_str)]
enum Set {
    #[strum(serialize = "baseline")]
    Baseline,
    #[cfg(target_arch = "x86_64")]
    #[strum(serialize = "AVX2 + FMA")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    #[strum(serialize = "AVX-512")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    Simd128,
}

/// The differences between instruction sets.
pub trait Instructions {
    /// a b + c in one instruction.
    const FMA: bool;
    /// f32 in one register.
    const WIDTH: usize;

    /// 1/√x to at least eleven bits.
    fn rough_inverse_roots<const N: usize>(x: &[f32; N]) -> [f32; N];
}

/// Loops compiled for every set; `run` and all its callees must be `#[inline(always)]`.
pub trait Kernel {
    type Output;

    fn run<I: Instructions>(self) -> Self::Output;
}

impl Isa {
    /// Every set of this machine, the best last. A browser has the set that its page was built for, or refuses the
    /// page.
    pub fn available() -> Vec<Self> {
        #[cfg_attr(
            not(any(target_arch = "x86_64", target_arch = "aarch64", target_feature = "simd128")),
            expect(unused_mut, reason = "other targets have one set")
        )]
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
        #[cfg(target_arch = "aarch64")]
        sets.push(Self(Set::Neon));
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        sets.push(Self(Set::Simd128));
        sets
    }

    /// The best that this machine has.
    pub fn best() -> Self {
        static BEST: LazyLock<Isa> = LazyLock::new(|| Isa::available().pop().unwrap_or(Isa(Set::Baseline)));
        *BEST
    }

    pub fn name(self) -> &'static str {
        self.0.into_str()
    }

    /// Runs the copy of a kernel compiled for this set.
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Set::Baseline => kernel.run::<Baseline>(),
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => wide::avx2(kernel),
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => wide::avx512(kernel),
            #[cfg(target_arch = "aarch64")]
            Set::Neon => kernel.run::<neon::Neon>(),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Set::Simd128 => kernel.run::<wasm::Simd128>(),
        }
    }
}

/// a b + c; fused if it is a single instruction, since elsewhere `mul_add` is a slow library call.
#[inline(always)]
pub fn fused<I: Instructions>(a: f32, b: f32, c: f32) -> f32 {
    if I::FMA { a.mul_add(b, c) } else { a * b + c }
}

/// The same in f64.
#[inline(always)]
pub fn fused64<I: Instructions>(a: f64, b: f64, c: f64) -> f64 {
    if I::FMA { a.mul_add(b, c) } else { a * b + c }
}

/// The larger of two, and `b` if `a` is NaN: one instruction in every set, unlike `f32::max`, which is a call in a
/// browser.
#[inline(always)]
pub fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// One value for every lane. A loop of one expression is always vectorised, loops of several may not be.
#[inline(always)]
pub fn lanes<const N: usize>(value: impl Fn(usize) -> f64) -> [f64; N] {
    let mut values = [0.0; N];
    for (lane, to) in values.iter_mut().enumerate() {
        *to = value(lane);
    }
    values
}

/// sum += a b in every lane.
#[inline(always)]
pub fn accumulate<I: Instructions, const N: usize>(sum: &mut [f64; N], a: &[f64; N], b: f64) {
    for lane in 0..N {
        sum[lane] = fused64::<I>(a[lane], b, sum[lane]);
    }
}

/// sum += a b, lane by lane.
#[inline(always)]
pub fn accumulate_product<I: Instructions, const N: usize>(sum: &mut [f64; N], a: &[f64; N], b: &[f64; N]) {
    for lane in 0..N {
        sum[lane] = fused64::<I>(a[lane], b[lane], sum[lane]);
    }
}

/// sum -= a b, lane by lane.
#[inline(always)]
pub fn deduct_product<I: Instructions, const N: usize>(sum: &mut [f64; N], a: &[f64; N], b: &[f64; N]) {
    for lane in 0..N {
        sum[lane] = fused64::<I>(-a[lane], b[lane], sum[lane]);
    }
}

/// The sum of all lanes by pairwise folding, which avoids a latency-bound chain.
#[inline(always)]
pub fn total<const N: usize>(sum: &[f64; N]) -> f64 {
    let mut sum = *sum;
    let mut width = N;
    while width > 1 {
        width /= 2;
        for lane in 0..width {
            sum[lane] += sum[lane + width];
        }
    }
    sum[0]
}

struct Baseline;

impl Instructions for Baseline {
    const FMA: bool = false;
    const WIDTH: usize = 4;

    #[inline(always)]
    fn rough_inverse_roots<const N: usize>(x: &[f32; N]) -> [f32; N] {
        x.map(|x| 1.0 / x.sqrt())
    }
}

/// Sets beyond the build's target.
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "a call of these is sound only on a machine that has the set, and an `Isa` proves that"
)]
mod wide {
    use std::arch::x86_64::{
        _mm256_loadu_ps, _mm256_rsqrt_ps, _mm256_storeu_ps, _mm512_loadu_ps, _mm512_rsqrt14_ps,
        _mm512_storeu_ps,
    };

    use crate::simd::{Instructions, Kernel};

    struct Avx2;
    struct Avx512;

    impl Instructions for Avx2 {
        const FMA: bool = true;
        const WIDTH: usize = 8;

        #[inline(always)]
        fn rough_inverse_roots<const N: usize>(x: &[f32; N]) -> [f32; N] {
            let mut roots = [0.0; N];
            let (runs, rest) = x.as_chunks::<8>();
            let (root_runs, root_rest) = roots.as_chunks_mut::<8>();
            for (x, root) in runs.iter().zip(root_runs) {
                unsafe { _mm256_storeu_ps(root.as_mut_ptr(), _mm256_rsqrt_ps(_mm256_loadu_ps(x.as_ptr()))) };
            }
            for (x, root) in rest.iter().zip(root_rest) {
                *root = 1.0 / x.sqrt();
            }
            roots
        }
    }

    impl Instructions for Avx512 {
        const FMA: bool = true;
        const WIDTH: usize = 16;

        #[inline(always)]
        fn rough_inverse_roots<const N: usize>(x: &[f32; N]) -> [f32; N] {
            let mut roots = [0.0; N];
            let (runs, rest) = x.as_chunks::<16>();
            let (root_runs, root_rest) = roots.as_chunks_mut::<16>();
            for (x, root) in runs.iter().zip(root_runs) {
                unsafe {
                    _mm512_storeu_ps(root.as_mut_ptr(), _mm512_rsqrt14_ps(_mm512_loadu_ps(x.as_ptr())));
                };
            }
            for (x, root) in rest.iter().zip(root_rest) {
                *root = 1.0 / x.sqrt();
            }
            roots
        }
    }

    pub(super) fn avx2<K: Kernel>(kernel: K) -> K::Output {
        #[target_feature(enable = "avx2,fma")]
        fn run<K: Kernel>(kernel: K) -> K::Output {
            kernel.run::<Avx2>()
        }
        unsafe { run(kernel) }
    }

    pub(super) fn avx512<K: Kernel>(kernel: K) -> K::Output {
        #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
        fn run<K: Kernel>(kernel: K) -> K::Output {
            kernel.run::<Avx512>()
        }
        unsafe { run(kernel) }
    }
}

/// The set that every 64-bit ARM has.
#[cfg(target_arch = "aarch64")]
#[expect(unsafe_code, reason = "no machine is without NEON, and the pointers lead to arrays of four f32")]
mod neon {
    use std::arch::aarch64::{vld1q_f32, vmulq_f32, vrsqrteq_f32, vrsqrtsq_f32, vst1q_f32};

    use crate::simd::Instructions;

    pub(super) struct Neon;

    impl Instructions for Neon {
        const FMA: bool = true;
        const WIDTH: usize = 4;

        #[inline(always)]
        fn rough_inverse_roots<const N: usize>(x: &[f32; N]) -> [f32; N] {
            let mut roots = [0.0; N];
            let (runs, rest) = x.as_chunks::<4>();
            let (root_runs, root_rest) = roots.as_chunks_mut::<4>();
            for (x, root) in runs.iter().zip(root_runs) {
                // The estimate has eight bits; a step of Newton's doubles them.
                unsafe {
                    let x = vld1q_f32(x.as_ptr());
                    let rough = vrsqrteq_f32(x);
                    let step = vrsqrtsq_f32(x, vmulq_f32(rough, rough));
                    vst1q_f32(root.as_mut_ptr(), vmulq_f32(rough, step));
                }
            }
            for (x, root) in rest.iter().zip(root_rest) {
                *root = 1.0 / x.sqrt();
            }
            roots
        }
    }
}

/// The set of browsers. Fused products would be of relaxed SIMD, which not every browser has, and which may differ from one to the next.
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm {
    use crate::simd::Instructions;

    pub(super) struct Simd128;

    impl Instructions for Simd128 {
        const FMA: bool = false;
        const WIDTH: usize = 4;

        /// A guess from the bits and two of Newton's steps are no sooner.
        #[inline(always)]
        fn rough_inverse_roots<const N: usize>(x: &[f32; N]) -> [f32; N] {
            x.map(|x| 1.0 / x.sqrt())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rough_roots_have_eleven_bits() {
        struct Rough([f32; 19]);

        impl Kernel for Rough {
            type Output = [f32; 19];

            #[inline(always)]
            fn run<I: Instructions>(self) -> [f32; 19] {
                I::rough_inverse_roots(&self.0)
            }
        }

        for isa in Isa::available() {
            for start in [1e-30, 1e-6, 1.0, 1.7, 3e20] {
                let x: [f32; 19] = std::array::from_fn(|i| start * 1.37f32.powi(i as i32));
                for (x, rough) in x.iter().zip(isa.run(Rough(x))) {
                    let error = f64::from(rough) * f64::from(*x).sqrt() - 1.0;
                    assert!(error.abs() < 1.0 / 2048.0, "{}: {rough} for {x}", isa.name());
                }
            }
        }
    }
}
