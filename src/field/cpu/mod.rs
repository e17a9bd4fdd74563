//! The f32 kernels of the CPU, and which instruction set runs them.
//!
//! Bodies are written over arrays of lanes, which the compiler turns into vector code, and are compiled once for every
//! instruction set; the best one that the machine has is chosen when the program runs.

mod sums;
mod waves;

use std::sync::LazyLock;

use num_complex::Complex32;
use rayon::prelude::*;

use crate::field::Samples;
use crate::field::sources::{FEW_DECAY, FEW_DIRECTIVITY, Sources, Wave};
use waves::Block;

pub use sums::{Lines, OVERHANG, ROWS, Rows, Split, Term};
pub use waves::{LANES, Points};

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
    let block = block_of(isa, &sources.wave);
    let mut field = vec![Complex32::ZERO; samples.len()];
    field.par_chunks_mut(LANES).enumerate().for_each(|(index, chunk)| {
        let points = Points::new(&sources.wave, chunk.len(), |lane| samples.point(index * LANES + lane));
        let sum = block(&sources.wave, &sources.elements, &points).onward(&points);
        for (p, (re, im)) in chunk.iter_mut().zip(sum.re.iter().zip(&sum.im)) {
            *p = Complex32::new(*re, *im);
        }
    });
    field
}

/// The waves of single elements at a block of points: hands `take` the element's number and real and imaginary parts
/// of the complex pressures (Pa, peak).
pub fn single_waves(
    wave: &Wave,
    elements: &[[f32; 4]],
    points: &Points,
    mut take: impl FnMut(usize, (&[f32; LANES], &[f32; LANES])),
) {
    let block = block_of(Isa::best(), wave);
    for (number, element) in elements.chunks_exact(1).enumerate() {
        let sum = block(wave, element, points).onward(points);
        take(number, (&sum.re, &sum.im));
    }
}

/// The block for a wave: the common case, the general one (sharp directivity, strong absorption), or the exact piston.
fn block_of(isa: Isa, wave: &Wave) -> Block {
    let common = wave.directivity.terms <= FEW_DIRECTIVITY && wave.decay.terms <= FEW_DECAY;
    match (isa.0, &wave.piston, common) {
        (Set::Baseline, None, true) => waves::far_field::<Baseline, FEW_DIRECTIVITY, FEW_DECAY>,
        (Set::Baseline, None, false) => waves::far_field::<Baseline, 24, 16>,
        (Set::Baseline, Some(_), _) => waves::exact_piston::<Baseline>,
        #[cfg(target_arch = "x86_64")]
        (set, _, _) => wide::block_of(set, wave, common),
    }
}

/// Weighted sums of lines, one or [`ROWS`] rows of them: the interpolation's inner loop.
pub fn weighted_sums(rows: usize, lines: &Lines<'_>, sums: &mut Rows<'_>) {
    match (Isa::best().0, rows) {
        (Set::Baseline, ROWS) => sums::weighted_sums::<Baseline, ROWS, 8>(lines, sums),
        (Set::Baseline, _) => sums::weighted_sums::<Baseline, 1, 32>(lines, sums),
        #[cfg(target_arch = "x86_64")]
        (set, _) => wide::weighted_sums(set, rows, lines, sums),
    }
}

/// The places in a colour table of magnitudes: |p| times `scale`, rounded.
pub fn places(field: &[Complex32], scale: f32, places: &mut [u8]) {
    match Isa::best().0 {
        Set::Baseline => sums::places(field, scale, places),
        #[cfg(target_arch = "x86_64")]
        _ => wide::places(field, scale, places),
    }
}

/// Adds up runs of `table`, one per term, with the term's excitation: sum[i] = Σ u table[start + first + i].
///
/// The table must have [`OVERHANG`] values more than the runs reach.
pub fn superpose(table: &Split, terms: &[Term], first: usize, sum: &mut [Complex32]) {
    match Isa::best().0 {
        Set::Baseline => sums::superpose::<Baseline, 16>(table, terms, first, sum),
        #[cfg(target_arch = "x86_64")]
        set => wide::superpose(set, table, terms, first, sum),
    }
}

/// What the sets differ in.
trait Instructions {
    /// a b + c in one instruction.
    const FMA: bool;

    /// 1/√x to at least eleven bits.
    fn rough_inverse_roots(x: &[f32; LANES]) -> [f32; LANES];
}

struct Baseline;

impl Instructions for Baseline {
    const FMA: bool = false;

    #[inline(always)]
    fn rough_inverse_roots(x: &[f32; LANES]) -> [f32; LANES] {
        x.map(|x| 1.0 / x.sqrt())
    }
}

/// The same bodies with instructions that the build's target does not promise.
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

    use num_complex::Complex32;

    use crate::field::cpu::sums::{self, Lines, ROWS, Rows, Split, Term};
    use crate::field::cpu::waves::{self, Block, LANES, Points, Sum};
    use crate::field::cpu::{Instructions, Set};
    use crate::field::sources::{FEW_DECAY, FEW_DIRECTIVITY, Wave};

    struct Avx2;
    struct Avx512;

    impl Instructions for Avx2 {
        const FMA: bool = true;

        #[inline(always)]
        fn rough_inverse_roots(x: &[f32; LANES]) -> [f32; LANES] {
            let mut roots = [0.0; LANES];
            for (x, root) in x.as_chunks::<8>().0.iter().zip(roots.as_chunks_mut::<8>().0) {
                unsafe { _mm256_storeu_ps(root.as_mut_ptr(), _mm256_rsqrt_ps(_mm256_loadu_ps(x.as_ptr()))) };
            }
            roots
        }
    }

    impl Instructions for Avx512 {
        const FMA: bool = true;

        #[inline(always)]
        fn rough_inverse_roots(x: &[f32; LANES]) -> [f32; LANES] {
            let mut roots = [0.0; LANES];
            for (x, root) in x.as_chunks::<16>().0.iter().zip(roots.as_chunks_mut::<16>().0) {
                unsafe {
                    _mm512_storeu_ps(root.as_mut_ptr(), _mm512_rsqrt14_ps(_mm512_loadu_ps(x.as_ptr())));
                };
            }
            roots
        }
    }

    pub(super) fn block_of(set: Set, wave: &Wave, common: bool) -> Block {
        match (set, &wave.piston, common) {
            (Set::Avx512, None, true) => {
                |w, e, p| unsafe { far_field_avx512::<FEW_DIRECTIVITY, FEW_DECAY>(w, e, p) }
            }
            (Set::Avx512, None, false) => |w, e, p| unsafe { far_field_avx512::<24, 16>(w, e, p) },
            (Set::Avx512, Some(_), _) => |w, e, p| unsafe { exact_piston_avx512(w, e, p) },
            (_, None, true) => |w, e, p| unsafe { far_field_avx2::<FEW_DIRECTIVITY, FEW_DECAY>(w, e, p) },
            (_, None, false) => |w, e, p| unsafe { far_field_avx2::<24, 16>(w, e, p) },
            (_, Some(_), _) => |w, e, p| unsafe { exact_piston_avx2(w, e, p) },
        }
    }

    #[target_feature(enable = "avx2,fma")]
    fn far_field_avx2<const D: usize, const A: usize>(w: &Wave, elements: &[[f32; 4]], p: &Points) -> Sum {
        waves::far_field::<Avx2, D, A>(w, elements, p)
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn far_field_avx512<const D: usize, const A: usize>(w: &Wave, elements: &[[f32; 4]], p: &Points) -> Sum {
        waves::far_field::<Avx512, D, A>(w, elements, p)
    }

    #[target_feature(enable = "avx2,fma")]
    fn exact_piston_avx2(w: &Wave, elements: &[[f32; 4]], p: &Points) -> Sum {
        waves::exact_piston::<Avx2>(w, elements, p)
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn exact_piston_avx512(w: &Wave, elements: &[[f32; 4]], p: &Points) -> Sum {
        waves::exact_piston::<Avx512>(w, elements, p)
    }

    pub(super) fn weighted_sums(set: Set, rows: usize, lines: &Lines<'_>, sums: &mut Rows<'_>) {
        match (set, rows) {
            (Set::Avx512, ROWS) => unsafe { weighted_sums_avx512::<ROWS, 32>(lines, sums) },
            (Set::Avx512, _) => unsafe { weighted_sums_avx512::<1, 64>(lines, sums) },
            (_, ROWS) => unsafe { weighted_sums_avx2::<ROWS, 16>(lines, sums) },
            (_, _) => unsafe { weighted_sums_avx2::<1, 64>(lines, sums) },
        }
    }

    #[target_feature(enable = "avx2,fma")]
    fn weighted_sums_avx2<const R: usize, const RUN: usize>(lines: &Lines<'_>, sums: &mut Rows<'_>) {
        sums::weighted_sums::<Avx2, R, RUN>(lines, sums);
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn weighted_sums_avx512<const R: usize, const RUN: usize>(lines: &Lines<'_>, sums: &mut Rows<'_>) {
        sums::weighted_sums::<Avx512, R, RUN>(lines, sums);
    }

    pub(super) fn places(field: &[Complex32], scale: f32, places: &mut [u8]) {
        #[target_feature(enable = "avx2,fma")]
        fn places_avx2(field: &[Complex32], scale: f32, places: &mut [u8]) {
            sums::places(field, scale, places);
        }
        unsafe { places_avx2(field, scale, places) }
    }

    pub(super) fn superpose(set: Set, table: &Split, terms: &[Term], first: usize, sum: &mut [Complex32]) {
        if set == Set::Avx512 {
            unsafe { superpose_avx512(table, terms, first, sum) }
        } else {
            unsafe { superpose_avx2(table, terms, first, sum) }
        }
    }

    #[target_feature(enable = "avx2,fma")]
    fn superpose_avx2(table: &Split, terms: &[Term], first: usize, sum: &mut [Complex32]) {
        sums::superpose::<Avx2, 32>(table, terms, first, sum);
    }

    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn superpose_avx512(table: &Split, terms: &[Term], first: usize, sum: &mut [Complex32]) {
        sums::superpose::<Avx512, 64>(table, terms, first, sum);
    }
}

/// a b + c; fused where the machine does it in one instruction, since elsewhere `mul_add` is a slow library call.
#[inline(always)]
fn fused<I: Instructions>(a: f32, b: f32, c: f32) -> f32 {
    if I::FMA { a.mul_add(b, c) } else { a * b + c }
}
