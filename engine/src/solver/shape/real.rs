//! Real numbers and split complex vectors of either precision: f32 solves, f64 checks derivatives.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub};

use crate::simd::{Instructions, fused, fused64};

/// Numbers processed together.
pub const LANES: usize = 8;
/// Powers of smaller parts of the loudest |p|² underflow in f32, and are negligible.
pub const FAINT: f64 = 2e-3;

/// f32 or f64.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + MulAssign
{
    fn of(value: f64) -> Self;
    fn wide(self) -> f64;
    /// a b + c
    fn fused<I: Instructions>(a: Self, b: Self, c: Self) -> Self;
}

impl Real for f32 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn fused<I: Instructions>(a: Self, b: Self, c: Self) -> Self {
        fused::<I>(a, b, c)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }

    #[inline(always)]
    fn fused<I: Instructions>(a: Self, b: Self, c: Self) -> Self {
        fused64::<I>(a, b, c)
    }
}

/// One value for every lane; a loop of one expression becomes vector code.
#[inline(always)]
pub fn lanes<T: Real>(value: impl Fn(usize) -> T) -> [T; LANES] {
    let mut values = [T::default(); LANES];
    for (lane, to) in values.iter_mut().enumerate() {
        *to = value(lane);
    }
    values
}

/// Complex numbers, real and imaginary parts apart.
#[derive(Clone, Debug, Default)]
pub struct Waves<T> {
    pub re: Vec<T>,
    pub im: Vec<T>,
}

impl<T: Real> Waves<T> {
    pub fn zeros(count: usize) -> Self {
        Self { re: vec![T::default(); count], im: vec![T::default(); count] }
    }

    pub fn len(&self) -> usize {
        self.re.len()
    }

    /// |p|² of one number.
    #[inline(always)]
    pub fn square(&self, index: usize) -> f64 {
        let (re, im) = (self.re[index].wide(), self.im[index].wide());
        re * re + im * im
    }

    pub fn clear(&mut self) {
        self.re.fill(T::default());
        self.im.fill(T::default());
    }

    /// Real and imaginary parts of `count` numbers from an index on, in whole blocks of lanes.
    #[inline(always)]
    pub fn blocks(&self, from: usize, count: usize) -> [&[[T; LANES]]; 2] {
        [&self.re, &self.im].map(|part| part[from..from + count].as_chunks().0)
    }

    /// Real and imaginary parts of one block of lanes.
    #[inline(always)]
    pub fn block(&self, index: usize) -> [&[T; LANES]; 2] {
        [&self.re, &self.im].map(|part| &part.as_chunks().0[index])
    }

    #[inline(always)]
    pub fn block_mut(&mut self, index: usize) -> [&mut [T; LANES]; 2] {
        [&mut self.re, &mut self.im].map(|part| &mut part.as_chunks_mut().0[index])
    }

    /// Both parts of the first numbers.
    #[inline(always)]
    pub fn blocks_mut(&mut self, count: usize) -> [&mut [[T; LANES]]; 2] {
        [&mut self.re, &mut self.im].map(|part| part[..count].as_chunks_mut().0)
    }

    pub fn scale(&mut self, by: T) {
        self.re.iter_mut().chain(&mut self.im).for_each(|value| *value *= by);
    }

    /// Real and imaginary parts exchanged: which turns a Fourier transform into its inverse.
    #[inline(always)]
    pub fn exchange(&mut self) {
        std::mem::swap(&mut self.re, &mut self.im);
    }
}

/// The power by squares of squares; the exponent is a constant once this is inlined.
#[inline(always)]
pub fn power<T: Real>(base: &[T; LANES], exponent: usize) -> [T; LANES] {
    let (mut power, mut square, mut rest) = ([T::of(1.0); LANES], *base, exponent);
    while rest > 0 {
        if rest % 2 == 1 {
            let before = power;
            power = lanes(|i| before[i] * square[i]);
        }
        let before = square;
        square = lanes(|i| before[i] * before[i]);
        rest /= 2;
    }
    power
}
