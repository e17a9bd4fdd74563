//! The transfer H from driven elements to points, in f64, and the products with it that solvers repeat.
//!
//! Real and imaginary parts lie apart and rows are padded with zeros, so that every loop is over whole vector registers.

use num_complex::Complex64;

use crate::simd::{
    Instructions, Isa, Kernel, accumulate, accumulate_product, deduct_product, fused64, lanes,
};

/// Elements that are worked on together; rows are padded to a multiple of it.
const BLOCK: usize = 16;
/// Partial sums of a row's product, added up at the end.
const LANES: usize = 8;

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
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    pub points: usize,
    pub elements: usize,
    /// Values from one row to the next: the elements, and zeros.
    stride: usize,
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

    /// From the driven elements to one point.
    pub fn row(&self, point: usize) -> impl ExactSizeIterator<Item = Complex64> + Clone {
        let row = point * self.stride..point * self.stride + self.elements;
        let (re, im) = (&self.values.re[row.clone()], &self.values.im[row]);
        re.iter().zip(im).map(|(&re, &im)| Complex64::new(re, im))
    }

    /// All rows.
    pub fn rows(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = Complex64> + Clone> {
        (0..self.points).map(|point| self.row(point))
    }

    /// Real and imaginary parts of a row, to be filled; what lies beyond the elements must stay 0.
    pub(super) fn row_mut(&mut self, point: usize) -> (&mut [f64], &mut [f64]) {
        let row = point * self.stride..(point + 1) * self.stride;
        (&mut self.values.re[row.clone()], &mut self.values.im[row])
    }

    /// Room for one value per element, as [`Transfer::drive_by`] wants it.
    pub fn excitation(&self) -> Phasors {
        Phasors::zeros(self.stride)
    }

    /// H u: the pressure at every point.
    pub fn pressure(&self, excitation: &[Complex64]) -> Vec<Complex64> {
        self.rows().map(|row| row.zip(excitation).map(|(h, u)| h * u).sum()).collect()
    }

    /// H* p: what every element would hear.
    pub fn back(&self, pressure: &[Complex64]) -> Vec<Complex64> {
        let mut heard = self.excitation();
        let pressure: Phasors = pressure.iter().copied().collect();
        Isa::best().run(Back { transfer: self, pressure: &pressure, heard: &mut heard });
        heard.to_vec(self.elements)
    }

    /// One step of a phase iteration: u ← ph(keep · u + H* p), each element at full drive, and H u.
    ///
    /// `excitation` is [`Transfer::excitation`]; `pressure` goes in as p, a value per point, and comes out as H u.
    pub fn drive_by(&self, keep: f64, excitation: &mut Phasors, pressure: &mut Phasors, sums: &mut Sums) {
        Isa::best().run(Step { transfer: self, keep, excitation, pressure, sums });
    }

    /// H D H*, D the diagonal of `weights` (one per element), row by row.
    pub fn gram(&self, weights: Option<&[f64]>) -> Phasors {
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

#[inline(always)]
fn block(transfer: &Transfer, point: usize, start: usize) -> (&[f64; BLOCK], &[f64; BLOCK]) {
    let at = point * transfer.stride + start;
    let re = transfer.values.re[at..].first_chunk().expect("rows are padded to whole blocks");
    let im = transfer.values.im[at..].first_chunk().expect("rows are padded to whole blocks");
    (re, im)
}

/// sum += a b, where the two halves of a block come to the same sums.
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
fn halves(block: &[f64; BLOCK]) -> [&[f64; LANES]; 2] {
    let (halves, _) = block.as_chunks::<LANES>();
    [&halves[0], &halves[1]]
}

struct Step<'a> {
    transfer: &'a Transfer,
    keep: f64,
    excitation: &'a mut Phasors,
    pressure: &'a mut Phasors,
    sums: &'a mut Sums,
}

impl Kernel for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { transfer, keep, excitation, pressure, sums } = self;
        for part in [&mut sums.re, &mut sums.im] {
            part.clear();
            part.resize(transfer.points, [0.0; LANES]);
        }
        for start in (0..transfer.stride).step_by(BLOCK) {
            let (heard_re, heard_im) = back_block::<I>(transfer, pressure, start);
            let u_re: &mut [f64; BLOCK] = excitation.re[start..].first_chunk_mut().expect("as long as a row");
            let u_im: &mut [f64; BLOCK] = excitation.im[start..].first_chunk_mut().expect("as long as a row");
            let re = lanes::<BLOCK>(|i| fused64::<I>(keep, u_re[i], heard_re[i]));
            let im = lanes::<BLOCK>(|i| fused64::<I>(keep, u_im[i], heard_im[i]));
            let norm2 = lanes::<BLOCK>(|i| fused64::<I>(re[i], re[i], im[i] * im[i]));
            // An element that hears nothing plays with phase 0.
            let inverse =
                lanes::<BLOCK>(|i| if norm2[i] > f64::MIN_POSITIVE { 1.0 / norm2[i].sqrt() } else { 0.0 });
            let silent = lanes::<BLOCK>(|i| if norm2[i] > f64::MIN_POSITIVE { 0.0 } else { 1.0 });
            let re = lanes::<BLOCK>(|i| fused64::<I>(re[i], inverse[i], silent[i]));
            let im = lanes::<BLOCK>(|i| im[i] * inverse[i]);
            (*u_re, *u_im) = (re, im);
            for (point, (sum_re, sum_im)) in sums.re.iter_mut().zip(&mut sums.im).enumerate() {
                let (h_re, h_im) = block(transfer, point, start);
                // Copies: what may lie in the same memory is not made vector code of.
                let (mut to_re, mut to_im) = (*sum_re, *sum_im);
                multiply::<I>((h_re, h_im), (&re, &im), (&mut to_re, &mut to_im));
                (*sum_re, *sum_im) = (to_re, to_im);
            }
        }
        for (p, sum) in pressure.re.iter_mut().zip(&sums.re).chain(pressure.im.iter_mut().zip(&sums.im)) {
            *p = sum.iter().sum();
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
        for i in 0..points {
            for j in 0..=i {
                let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
                for start in (0..left.stride).step_by(BLOCK) {
                    // H_j* comes from the right.
                    let (b_re, b_im) = block(right, j, start);
                    let b_im = lanes::<BLOCK>(|lane| -b_im[lane]);
                    multiply::<I>(block(left, i, start), (b_re, &b_im), (&mut re, &mut im));
                }
                let value = Complex64::new(re.iter().sum(), im.iter().sum());
                gram.set(i * points + j, value);
                gram.set(j * points + i, value.conj());
            }
        }
    }
}
