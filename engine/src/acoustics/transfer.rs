//! The transfer H from driven elements to points, in f64, and its products, the inner loops of the solvers.
//!
//! Real and imaginary parts are stored separately and rows are padded with zeros, so that every loop covers whole
//! vector registers.

use num_complex::Complex64;

use crate::gauge;
use crate::simd::{
    Instructions, Isa, Kernel, accumulate, accumulate_product, deduct_product, fused64, lanes, total,
};

/// Elements processed together; rows are padded to a multiple of it.
pub(super) const BLOCK: usize = 16;
/// Partial sums of a row's product, added up at the end.
pub(super) const LANES: usize = 8;

/// Complex numbers with their real and imaginary parts apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Phasors {
    pub re: Vec<f64>,
    pub im: Vec<f64>,
}

impl Phasors {
    pub fn zeros(count: usize) -> Self {
        Self { re: vec![0.0; count], im: vec![0.0; count] }
    }

    pub fn len(&self) -> usize {
        self.re.len()
    }

    pub fn is_empty(&self) -> bool {
        self.re.is_empty()
    }

    pub fn at(&self, index: usize) -> Complex64 {
        Complex64::new(self.re[index], self.im[index])
    }

    pub fn set(&mut self, index: usize, value: Complex64) {
        (self.re[index], self.im[index]) = (value.re, value.im);
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = Complex64> + Clone {
        self.re.iter().zip(&self.im).map(|(&re, &im)| Complex64::new(re, im))
    }

    /// The first `count` of them.
    pub fn to_vec(&self, count: usize) -> Vec<Complex64> {
        self.iter().take(count).collect()
    }
}

impl FromIterator<Complex64> for Phasors {
    fn from_iter<T: IntoIterator<Item = Complex64>>(values: T) -> Self {
        let (re, im) = values.into_iter().map(|value| (value.re, value.im)).unzip();
        Self { re, im }
    }
}

/// A matrix of transfer values: Pa per unit of drive, a row per point and a column per driven element.
///
/// Its products panic if they are given more or fewer values than their comments say.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    pub points: usize,
    pub elements: usize,
    /// Values from one row to the next: the elements, and zeros.
    pub(super) stride: usize,
    values: Phasors,
}

impl Transfer {
    /// A matrix of zeros.
    pub fn zeros(points: usize, elements: usize) -> Self {
        let stride = elements.next_multiple_of(BLOCK);
        Self { points, elements, stride, values: Phasors::zeros(points * stride) }
    }

    pub fn at(&self, point: usize, element: usize) -> Complex64 {
        self.values.at(point * self.stride + element)
    }

    pub fn set(&mut self, point: usize, element: usize, value: Complex64) {
        self.values.set(point * self.stride + element, value);
    }

    /// Transfers from the driven elements to one point.
    pub fn row(&self, point: usize) -> impl ExactSizeIterator<Item = Complex64> + Clone {
        let row = point * self.stride..point * self.stride + self.elements;
        let (re, im) = (&self.values.re[row.clone()], &self.values.im[row]);
        re.iter().zip(im).map(|(&re, &im)| Complex64::new(re, im))
    }

    /// Real and imaginary parts of a row, with its padding.
    pub(super) fn parts(&self, point: usize) -> (&[f64], &[f64]) {
        let row = point * self.stride..(point + 1) * self.stride;
        (&self.values.re[row.clone()], &self.values.im[row])
    }

    /// All rows.
    pub fn rows(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = Complex64> + Clone> {
        (0..self.points).map(|point| self.row(point))
    }

    pub(super) fn clear(&mut self) {
        self.values.re.fill(0.0);
        self.values.im.fill(0.0);
    }

    /// Real and imaginary parts of a row, to be filled; the padding must stay 0.
    pub(super) fn row_mut(&mut self, point: usize) -> (&mut [f64], &mut [f64]) {
        let row = point * self.stride..(point + 1) * self.stride;
        (&mut self.values.re[row.clone()], &mut self.values.im[row])
    }

    /// Room for one value per element, for [`Transfer::drive_by`].
    pub(crate) fn excitation(&self) -> Phasors {
        Phasors::zeros(self.stride)
    }

    /// H u, the pressure at every point; u has a value per element.
    pub fn pressure(&self, excitation: &[Complex64]) -> Vec<Complex64> {
        Isa::best().run(Forward { transfer: self, played: &self.played(excitation) })
    }

    /// |p| (peak) at every point: the root mean square of |H u| over drives that take turns, given one after the other
    /// with a value per element.
    pub(crate) fn moduli(&self, drives: &[Complex64]) -> Vec<f64> {
        self.in_turn(drives).into_iter().map(Complex64::norm).collect()
    }

    /// H u; of several drives as in [`Self::moduli`], their modulus with the phase of the first.
    pub(crate) fn in_turn(&self, drives: &[Complex64]) -> Vec<Complex64> {
        let played: Vec<_> = drives.chunks(self.elements.max(1)).map(|drive| self.played(drive)).collect();
        self.taking_turns(&played)
    }

    /// A drive, with nothing up to the end of a row.
    pub(super) fn played(&self, excitation: &[Complex64]) -> Phasors {
        assert_eq!(excitation.len(), self.elements, "a value per element");
        let mut played = self.excitation();
        for (element, &u) in excitation.iter().enumerate() {
            played.set(element, u);
        }
        played
    }

    /// [`Self::in_turn`] of [`Self::played`].
    pub(super) fn taking_turns(&self, drives: &[Phasors]) -> Vec<Complex64> {
        let of_drive = |played| Isa::best().run(Forward { transfer: self, played });
        let [first, others @ ..] = drives else { return vec![Complex64::ZERO; self.points] };
        let mut pressures = of_drive(first);
        if !others.is_empty() {
            let mut squares: Vec<_> = pressures.iter().map(Complex64::norm_sqr).collect();
            for drive in others {
                squares.iter_mut().zip(of_drive(drive)).for_each(|(sum, p)| *sum += p.norm_sqr());
            }
            for (p, square) in pressures.iter_mut().zip(squares) {
                *p = Complex64::from_polar((square / drives.len() as f64).sqrt(), p.arg());
            }
        }
        pressures
    }

    /// H* p, the conjugate field at every element; p has a value per point.
    pub fn back(&self, pressure: &[Complex64]) -> Vec<Complex64> {
        assert_eq!(pressure.len(), self.points, "a value per point");
        let mut heard = self.excitation();
        let pressure: Phasors = pressure.iter().copied().collect();
        Isa::best().run(Back { transfer: self, pressure: &pressure, heard: &mut heard });
        heard.to_vec(self.elements)
    }

    /// One step of a phase iteration: u ← ph(keep · u + H* p), each element at full drive, and H u.
    ///
    /// `excitation` is [`Transfer::excitation`]; `pressure` goes in as p, a value per point, and comes out as H u.
    /// With several channels, the values of an element have a common norm of 1: the relaxed drive of the bounds.
    pub(crate) fn drive_by<const CHANNELS: usize>(
        &self,
        keep: f64,
        excitation: &mut [Phasors; CHANNELS],
        pressure: &mut [Phasors; CHANNELS],
        sums: &mut Sums,
    ) {
        Isa::best().run(Step { transfer: self, keep, excitation, pressure, sums });
    }

    /// H D H*, D the diagonal of `weights` (one per element), row by row.
    pub fn gram(&self, weights: Option<&[f64]>) -> Phasors {
        assert!(weights.is_none_or(|weights| weights.len() == self.elements), "a weight per element");
        let mut scaled = None;
        if let Some(weights) = weights {
            let mut transfer = self.clone();
            for point in 0..self.points {
                let (re, im) = transfer.row_mut(point);
                for ((re, im), weight) in re.iter_mut().zip(im).zip(weights) {
                    *re *= weight;
                    *im *= weight;
                }
            }
            scaled = Some(transfer);
        }
        let mut gram = Phasors::zeros(self.points * self.points);
        Isa::best().run(Gram { left: scaled.as_ref().unwrap_or(self), right: self, gram: &mut gram });
        gram
    }
}

/// Partial sums of [`Transfer::drive_by`], kept from step to step.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    re: Vec<[f64; LANES]>,
    im: Vec<[f64; LANES]>,
}

struct Back<'a> {
    transfer: &'a Transfer,
    pressure: &'a Phasors,
    heard: &'a mut Phasors,
}

/// H u.
struct Forward<'a> {
    transfer: &'a Transfer,
    /// u of every element, zero-padded to a full row.
    played: &'a Phasors,
}

impl Kernel for Forward<'_> {
    type Output = Vec<Complex64>;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Vec<Complex64> {
        let Self { transfer, played } = self;
        let mut pressure = vec![Complex64::ZERO; transfer.points];
        for (point, to) in pressure.iter_mut().enumerate() {
            let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
            for start in (0..transfer.stride).step_by(BLOCK) {
                let (Some(u_re), Some(u_im)) =
                    (played.re[start..].first_chunk(), played.im[start..].first_chunk())
                else {
                    break;
                };
                multiply::<I>(block(transfer, point, start), (u_re, u_im), (&mut re, &mut im));
            }
            *to = Complex64::new(total(&re), total(&im));
        }
        pressure
    }
}

impl Kernel for Back<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        for start in (0..self.transfer.stride).step_by(BLOCK) {
            let (re, im) = back_block::<I>(self.transfer, self.pressure, start);
            self.heard.re[start..start + BLOCK].copy_from_slice(&re);
            self.heard.im[start..start + BLOCK].copy_from_slice(&im);
        }
    }
}

/// H* p for one block of elements.
#[inline(always)]
fn back_block<I: Instructions>(
    transfer: &Transfer,
    pressure: &Phasors,
    start: usize,
) -> ([f64; BLOCK], [f64; BLOCK]) {
    let (mut re, mut im) = ([0.0; BLOCK], [0.0; BLOCK]);
    for (point, (&p_re, &p_im)) in pressure.re.iter().zip(&pressure.im).enumerate() {
        let (h_re, h_im) = block(transfer, point, start);
        accumulate::<I, BLOCK>(&mut re, h_re, p_re);
        accumulate::<I, BLOCK>(&mut re, h_im, p_im);
        accumulate::<I, BLOCK>(&mut im, h_re, p_im);
        accumulate::<I, BLOCK>(&mut im, h_im, -p_re);
    }
    (re, im)
}

/// Real and imaginary parts of a block of a row.
#[inline(always)]
pub(super) fn block(transfer: &Transfer, point: usize, start: usize) -> (&[f64; BLOCK], &[f64; BLOCK]) {
    let at = point * transfer.stride + start;
    let re = transfer.values.re[at..].first_chunk().expect("rows are padded to whole blocks");
    let im = transfer.values.im[at..].first_chunk().expect("rows are padded to whole blocks");
    (re, im)
}

/// sum += a b, accumulating both halves of a block into the same sums.
#[inline(always)]
fn multiply<I: Instructions>(
    (a_re, a_im): (&[f64; BLOCK], &[f64; BLOCK]),
    (b_re, b_im): (&[f64; BLOCK], &[f64; BLOCK]),
    (re, im): (&mut [f64; LANES], &mut [f64; LANES]),
) {
    let (a_re, a_im, b_re, b_im) = (halves(a_re), halves(a_im), halves(b_re), halves(b_im));
    accumulate_product::<I, LANES>(re, a_re[0], b_re[0]);
    accumulate_product::<I, LANES>(im, a_re[0], b_im[0]);
    accumulate_product::<I, LANES>(re, a_re[1], b_re[1]);
    accumulate_product::<I, LANES>(im, a_re[1], b_im[1]);
    deduct_product::<I, LANES>(re, a_im[0], b_im[0]);
    accumulate_product::<I, LANES>(im, a_im[0], b_re[0]);
    deduct_product::<I, LANES>(re, a_im[1], b_im[1]);
    accumulate_product::<I, LANES>(im, a_im[1], b_re[1]);
}

#[inline(always)]
pub(super) fn halves(block: &[f64; BLOCK]) -> [&[f64; LANES]; 2] {
    let (halves, _) = block.as_chunks::<LANES>();
    [&halves[0], &halves[1]]
}

struct Step<'a, const CHANNELS: usize> {
    transfer: &'a Transfer,
    keep: f64,
    excitation: &'a mut [Phasors; CHANNELS],
    pressure: &'a mut [Phasors; CHANNELS],
    sums: &'a mut Sums,
}

impl<const CHANNELS: usize> Kernel for Step<'_, CHANNELS> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { transfer, keep, excitation, pressure, sums } = self;
        for part in [&mut sums.re, &mut sums.im] {
            part.clear();
            part.resize(CHANNELS * transfer.points, [0.0; LANES]);
        }
        for start in (0..transfer.stride).step_by(BLOCK) {
            let mut u = [([0.0; BLOCK], [0.0; BLOCK]); CHANNELS];
            let mut norm2 = [0.0; BLOCK];
            for (channel, (re, im)) in u.iter_mut().enumerate() {
                let (heard_re, heard_im) = back_block::<I>(transfer, &pressure[channel], start);
                let before = &excitation[channel];
                let before_re: &[f64; BLOCK] = before.re[start..].first_chunk().expect("as long as a row");
                let before_im: &[f64; BLOCK] = before.im[start..].first_chunk().expect("as long as a row");
                *re = lanes(|i| fused64::<I>(keep, before_re[i], heard_re[i]));
                *im = lanes(|i| fused64::<I>(keep, before_im[i], heard_im[i]));
                accumulate_product::<I, BLOCK>(&mut norm2, re, re);
                accumulate_product::<I, BLOCK>(&mut norm2, im, im);
            }
            // An element with zero field gets phase 0.
            let is_silent = |i: usize| norm2[i] <= f64::MIN_POSITIVE;
            let inverse = lanes::<BLOCK>(|i| if is_silent(i) { 0.0 } else { 1.0 / norm2[i].sqrt() });
            let silent = lanes::<BLOCK>(|i| if is_silent(i) { 1.0 } else { 0.0 });
            for (channel, (re, im)) in u.iter_mut().enumerate() {
                let first = if channel == 0 { 1.0 } else { 0.0 };
                *re = lanes(|i| fused64::<I>(re[i], inverse[i], first * silent[i]));
                *im = lanes(|i| im[i] * inverse[i]);
                excitation[channel].re[start..start + BLOCK].copy_from_slice(re);
                excitation[channel].im[start..start + BLOCK].copy_from_slice(im);
                let own = channel * transfer.points..(channel + 1) * transfer.points;
                let own = sums.re[own.clone()].iter_mut().zip(&mut sums.im[own]);
                for (point, (sum_re, sum_im)) in own.enumerate() {
                    // Local copies, since possible aliasing prevents vectorisation.
                    let (mut to_re, mut to_im) = (*sum_re, *sum_im);
                    multiply::<I>(block(transfer, point, start), (re, im), (&mut to_re, &mut to_im));
                    (*sum_re, *sum_im) = (to_re, to_im);
                }
            }
        }
        for (channel, p) in pressure.iter_mut().enumerate() {
            let first = channel * transfer.points;
            for point in 0..transfer.points {
                p.re[point] = total(&sums.re[first + point]);
                p.im[point] = total(&sums.im[first + point]);
            }
        }
    }
}

struct Gram<'a> {
    left: &'a Transfer,
    right: &'a Transfer,
    gram: &'a mut Phasors,
}

impl Kernel for Gram<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { left, right, gram } = self;
        let points = left.points;
        for i in (0..points).take_while(|_| !gauge::is_cancelled()) {
            // Two rows at a time keep the adders busy; beyond the diagonal the second is the conjugate of a later
            // result.
            for j in (0..=i).step_by(2) {
                let others = [j, (j + 1).min(points - 1)];
                let mut sums = [([0.0; LANES], [0.0; LANES]); 2];
                for start in (0..left.stride).step_by(BLOCK) {
                    let of_i = block(left, i, start);
                    for ((re, im), other) in sums.iter_mut().zip(others) {
                        // H_j* comes from the right.
                        let (b_re, b_im) = block(right, other, start);
                        let b_im = lanes::<BLOCK>(|lane| -b_im[lane]);
                        multiply::<I>(of_i, (b_re, &b_im), (re, im));
                    }
                }
                for ((re, im), other) in sums.iter().zip(others) {
                    let value = Complex64::new(total(re), total(im));
                    gram.set(i * points + other, value);
                    gram.set(other * points + i, value.conj());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without pattern.
    fn scattered(index: usize) -> Complex64 {
        let unit = |step: f64| (index as f64 * step).fract() - 0.5;
        Complex64::new(unit(0.618_033_988), unit(0.754_877_666))
    }

    fn transfer(points: usize, elements: usize) -> Transfer {
        let mut transfer = Transfer::zeros(points, elements);
        for point in 0..points {
            for element in 0..elements {
                transfer.set(point, element, scattered(1 + point * elements + element));
            }
        }
        transfer
    }

    fn assert_near(got: impl Iterator<Item = Complex64>, expected: &[Complex64]) {
        let got: Vec<_> = got.collect();
        assert_eq!(got.len(), expected.len());
        for (got, expected) in got.iter().zip(expected) {
            assert!((got - expected).norm() < 1e-12, "{got} is not {expected}");
        }
    }

    #[test]
    fn a_step_sends_back_normalises_and_sends_again() {
        // Elements that fill no block, one block and more.
        for elements in [1, 15, 16, 37] {
            let transfer = transfer(3, elements);
            for keep in [0.0, 1.0] {
                let p: [Vec<_>; 2] = [7, 11].map(|seed| (0..3).map(|i| scattered(seed + 5 * i)).collect());
                let before: [Vec<_>; 2] =
                    [3, 5].map(|seed| (0..elements).map(|i| scattered(seed * i + 1)).collect());
                let mut u = [transfer.excitation(), transfer.excitation()];
                for (u, before) in u.iter_mut().zip(&before) {
                    before.iter().enumerate().for_each(|(n, value)| u.set(n, *value));
                }
                let mut pressure = p.clone().map(|p| p.into_iter().collect());
                transfer.drive_by(keep, &mut u, &mut pressure, &mut Sums::default());

                let heard = |n: usize, channel: usize| {
                    let back: Complex64 = (0..3).map(|m| transfer.at(m, n).conj() * p[channel][m]).sum();
                    before[channel][n] * keep + back
                };
                let norm = |n: usize| (heard(n, 0).norm_sqr() + heard(n, 1).norm_sqr()).sqrt();
                for channel in [0, 1] {
                    let expected: Vec<_> = (0..elements).map(|n| heard(n, channel) / norm(n)).collect();
                    assert_near(u[channel].to_vec(elements).into_iter(), &expected);
                    assert_near(pressure[channel].iter(), &transfer.pressure(&expected));
                }
            }
        }
    }

    #[test]
    fn an_element_that_hears_nothing_plays_with_phase_0() {
        let transfer = transfer(2, 5);
        let mut u = [transfer.excitation()];
        let mut pressure = [Phasors::zeros(2)];
        transfer.drive_by(0.0, &mut u, &mut pressure, &mut Sums::default());
        assert_near(u[0].to_vec(5).into_iter(), &[Complex64::ONE; 5]);
    }

    #[test]
    fn products_are_those_of_matrices() {
        let transfer = transfer(4, 21);
        let weights: Vec<_> = (0..21).map(|n| 0.5 + f64::from(n)).collect();
        for weights in [None, Some(&weights[..])] {
            let gram = transfer.gram(weights);
            for (i, j) in [(0, 0), (1, 3), (3, 1), (2, 0)] {
                let expected: Complex64 = (0..21)
                    .map(|n| transfer.at(i, n) * transfer.at(j, n).conj() * weights.map_or(1.0, |w| w[n]))
                    .sum();
                assert!((gram.at(i * 4 + j) - expected).norm() < 1e-10, "{i} {j}");
            }
        }
        let p: Vec<_> = (0..4).map(scattered).collect();
        let expected: Vec<_> =
            (0..21).map(|n| (0..4).map(|m| transfer.at(m, n).conj() * p[m]).sum()).collect();
        assert_near(transfer.back(&p).into_iter(), &expected);
    }
}
