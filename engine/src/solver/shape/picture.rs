//! The error of the intensity over an area relative to its target, up to a scale.
//!
//! With I the mean |p|² of all drives in turn at samples of weight w and target T,
//!   L = Σ w (s I - T)² / Σ w T², s = Σ w I T / Σ w I² the best scale,
//!   ∂L/∂I = 2 s w (s I - T) / Σ w T², since the derivative by s vanishes.
//!
//! For a liquid's depression C I replaces I, C being the liquid's response in cosine modes on the same samples, and
//! ∂L/∂I is multiplied by its adjoint, which is C. Where the quiet region has the same samples, its share of the
//! objective is a function of the same I. It has a small weight, without which some places are louder than the
//! area.

use std::f64::consts::TAU;

use crate::simd::{Instructions, Isa, Kernel};
use crate::solver::shape::real::{FAINT, LANES, Real, Waves, lanes, power};
use crate::solver::shape::response::Response;
use crate::solver::shape::samples::Samples;
use crate::solver::starts::scatter;

/// Blocks summed before their sum is widened.
const RUN: usize = 64;

/// Target values at samples, in the layout of their field; padded to whole blocks of lanes.
#[derive(Clone, Debug)]
pub struct Wanted<T> {
    /// T
    brightness: Vec<T>,
    /// w: 1 on the areas and around them, 0 elsewhere.
    weight: Vec<T>,
    /// Σ w T and Σ w T².
    sum: f64,
    power: f64,
}

/// The fit of an intensity to its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// L, 0 to 1.
    pub error: f64,
    /// s
    pub scale: f64,
    /// Σ w I T / Σ w T
    pub mean: f64,
    /// Σ w I T
    along: f64,
}

/// The terms of the derivative by an intensity.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slope {
    /// Factor of the derivative of L.
    pub error: f64,
    /// Factor of the derivative of ln s.
    pub scale: f64,
    /// Factor of the derivative of ln Σ w I T.
    pub level: f64,
    /// Factor on the weights of [`Picture::weigh`].
    pub loud: f64,
}

impl<T: Real> Wanted<T> {
    /// Targets and weights of every value of a field.
    pub fn new(mut brightness: Vec<T>, mut weight: Vec<T>) -> Self {
        let pairs = || brightness.iter().zip(&weight).map(|(t, w)| (t.wide(), w.wide()));
        let (sum, power) = (pairs().map(|(t, w)| w * t).sum(), pairs().map(|(t, w)| w * t * t).sum());
        let padded = brightness.len().next_multiple_of(LANES);
        brightness.resize(padded, T::default());
        weight.resize(padded, T::default());
        Self { brightness, weight, sum, power }
    }

    /// `None` for a zero field.
    pub fn fit(&self, intensities: &[T]) -> Option<Fit> {
        let (along, square) = Isa::best().run(Products { wanted: self, intensities });
        let scale = along / square;
        let (error, mean) = (1.0 - scale * along / self.power, along / self.sum);
        let is_heard = along > 0.0 && scale.is_finite() && error.is_finite() && mean.is_finite();
        is_heard.then_some(Fit { error, scale, mean, along })
    }

    /// The derivative by every intensity, in its place.
    pub fn slopes(&self, intensities: &mut [T], fit: &Fit, slope: Slope) {
        let (Fit { scale, along, .. }, power) = (*fit, self.power);
        // ∂ ln s/∂I = w (T - 2 s I)/Σ w I T
        let by_intensity = 2.0 * scale * scale * slope.error / power - 2.0 * scale * slope.scale / along;
        let by_wanted = -2.0 * scale * slope.error / power + (slope.scale + slope.level) / along;
        let (by_intensity, by_wanted) = (T::of(by_intensity), T::of(by_wanted));
        Isa::best().run(Derive { wanted: self, intensities, by_intensity, by_wanted });
    }
}

/// Σ w I T and Σ w I².
struct Products<'a, T> {
    wanted: &'a Wanted<T>,
    intensities: &'a [T],
}

impl<T: Real> Kernel for Products<'_, T> {
    type Output = (f64, f64);

    #[inline(always)]
    fn run<I: Instructions>(self) -> (f64, f64) {
        let intensities = self.intensities.as_chunks::<LANES>().0;
        let brightness = self.wanted.brightness.as_chunks::<LANES>().0;
        let weight = self.wanted.weight.as_chunks::<LANES>().0;
        let (mut along, mut square) = (0.0, 0.0);
        for ((i, t), w) in intensities.chunks(RUN).zip(brightness.chunks(RUN)).zip(weight.chunks(RUN)) {
            let (mut alongs, mut squares) = ([T::default(); LANES], [T::default(); LANES]);
            for ((i, t), w) in i.iter().zip(t).zip(w) {
                let weighted: [T; LANES] = lanes(|lane| i[lane] * w[lane]);
                let before = (alongs, squares);
                alongs = lanes(|lane| T::fused::<I>(weighted[lane], t[lane], before.0[lane]));
                squares = lanes(|lane| T::fused::<I>(weighted[lane], i[lane], before.1[lane]));
            }
            along += alongs.into_iter().map(Real::wide).sum::<f64>();
            square += squares.into_iter().map(Real::wide).sum::<f64>();
        }
        (along, square)
    }
}

/// I ← w (a I + b T)
struct Derive<'a, T> {
    wanted: &'a Wanted<T>,
    intensities: &'a mut [T],
    by_intensity: T,
    by_wanted: T,
}

impl<T: Real> Kernel for Derive<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { wanted, intensities, by_intensity, by_wanted } = self;
        let brightness = wanted.brightness.as_chunks::<LANES>().0;
        let weight = wanted.weight.as_chunks::<LANES>().0;
        for ((i, t), w) in intensities.as_chunks_mut::<LANES>().0.iter_mut().zip(brightness).zip(weight) {
            let before = *i;
            let part: [T; LANES] = lanes(|lane| by_wanted * t[lane]);
            let sum: [T; LANES] = lanes(|lane| T::fused::<I>(by_intensity, before[lane], part[lane]));
            *i = lanes(|lane| w[lane] * sum[lane]);
        }
    }
}

/// to += |p|²
struct Square<'a, T> {
    p: &'a Waves<T>,
    to: &'a mut [T],
}

impl<T: Real> Kernel for Square<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        for (block, to) in self.to.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let ([re, im], before) = (self.p.block(block), *to);
            let part: [T; LANES] = lanes(|i| T::fused::<I>(re[i], re[i], before[i]));
            *to = lanes(|i| T::fused::<I>(im[i], im[i], part[i]));
        }
    }
}

/// p ← p · by
struct Scale<'a, T> {
    by: &'a [T],
    p: &'a mut Waves<T>,
}

impl<T: Real> Kernel for Scale<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        for (block, by) in self.by.as_chunks::<LANES>().0.iter().enumerate() {
            let [re, im] = self.p.block_mut(block);
            let before = (*re, *im);
            *re = lanes(|i| before.0[i] * by[i]);
            *im = lanes(|i| before.1[i] * by[i]);
        }
    }
}

/// to += scale · part
struct Add<'a, T> {
    scale: T,
    part: &'a [T],
    to: &'a mut [T],
}

impl<T: Real> Kernel for Add<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { scale, part, to } = self;
        for (to, part) in to.as_chunks_mut::<LANES>().0.iter_mut().zip(part.as_chunks::<LANES>().0) {
            let before = *to;
            *to = lanes(|i| T::fused::<I>(scale, part[i], before[i]));
        }
    }
}

/// The largest intensity where the mask is non-zero.
struct Loudest<'a, T> {
    intensities: &'a [T],
    mask: &'a [T],
}

impl<T: Real> Kernel for Loudest<'_, T> {
    type Output = T;

    #[inline(always)]
    fn run<I: Instructions>(self) -> T {
        let mut most = [T::default(); LANES];
        let intensities = self.intensities.as_chunks::<LANES>().0;
        for (square, mask) in intensities.iter().zip(self.mask.as_chunks::<LANES>().0) {
            let heard: [T; LANES] = lanes(|i| if mask[i] > T::default() { square[i] } else { T::default() });
            let before = most;
            most = lanes(|i| if heard[i] > before[i] { heard[i] } else { before[i] });
        }
        most.into_iter().fold(T::default(), |most, square| if square > most { square } else { most })
    }
}

/// The loop of [`Picture::weigh`].
struct Weigh<'a, T, const Q: usize> {
    intensities: &'a [T],
    mask: &'a [T],
    weights: &'a mut [T],
    inverse: T,
}

impl<T: Real, const Q: usize> Kernel for Weigh<'_, T, Q> {
    type Output = f64;

    #[inline(always)]
    fn run<I: Instructions>(self) -> f64 {
        let inverse = self.inverse;
        let (faint, one) = (T::of(FAINT), T::of(1.0));
        let intensities = self.intensities.as_chunks::<LANES>().0.chunks(RUN);
        let mask = self.mask.as_chunks::<LANES>().0.chunks(RUN);
        let weights = self.weights.as_chunks_mut::<LANES>().0.chunks_mut(RUN);
        let mut sum = 0.0;
        for ((intensities, mask), weights) in intensities.zip(mask).zip(weights) {
            let mut sums = [T::default(); LANES];
            for ((square, mask), weight) in intensities.iter().zip(mask).zip(weights) {
                let before = sums;
                let part: [T; LANES] =
                    lanes(|i| if square[i] * inverse < one { square[i] * inverse } else { one });
                let part: [T; LANES] = lanes(|i| if part[i] > faint { part[i] } else { T::default() });
                let powers = power(&part, Q - 1);
                *weight = lanes(|i| mask[i] * powers[i]);
                sums = lanes(|i| T::fused::<I>(weight[i], part[i], before[i]));
            }
            sum += sums.into_iter().map(Real::wide).sum::<f64>();
        }
        sum
    }
}

/// Targets over areas, and the field there.
#[derive(Debug)]
pub struct Picture<T> {
    samples: Samples<T>,
    wanted: Wanted<T>,
    /// Response of the liquid, for a prescribed depression.
    response: Option<Response>,
    /// Field of every drive.
    p: Vec<Waves<T>>,
    /// I or the depression, then the derivatives by I.
    pub(super) intensities: Vec<T>,
    fit: Option<Fit>,
    /// Mask of the quiet region if it has the same samples, and the weights of the last field there; empty otherwise.
    quiet: [Vec<T>; 2],
}

impl<T: Real> Picture<T> {
    pub fn new(samples: Samples<T>, wanted: Wanted<T>, response: Option<Response>) -> Self {
        let padded = wanted.weight.len();
        let intensities = vec![T::default(); padded];
        let quiet = [Vec::new(), Vec::new()];
        Self { samples, wanted, response, p: Vec::new(), intensities, fit: None, quiet }
    }

    /// Adds the quiet region at these samples.
    pub fn be_quiet(&mut self, mut mask: Vec<T>) {
        mask.resize(self.intensities.len(), T::default());
        self.quiet = [mask, vec![T::default(); self.intensities.len()]];
    }

    pub fn is_quiet(&self) -> bool {
        !self.quiet[0].is_empty()
    }

    /// The largest |p|² where the mask is non-zero.
    pub fn loudest(&self) -> f64 {
        Isa::best().run(Loudest { intensities: &self.intensities, mask: &self.quiet[0] }).wide()
    }

    /// Σ m t^q with t = |p|² · inverse, 1 at most; the weights become m t^{q-1}.
    pub fn weigh<const Q: usize>(&mut self, inverse: T) -> f64 {
        let [mask, weights] = &mut self.quiet;
        Isa::best().run(Weigh::<T, Q> { intensities: &self.intensities, mask, weights, inverse })
    }

    /// The fit of the field of these drives.
    pub fn hear(&mut self, drives: &[Waves<T>]) -> Option<Fit> {
        self.p.resize_with(drives.len(), || Waves::zeros(self.intensities.len()));
        self.intensities.fill(T::default());
        for (u, p) in drives.iter().zip(&mut self.p) {
            self.samples.forward(u, p);
            Isa::best().run(Square { p, to: &mut self.intensities });
        }
        if drives.len() > 1 {
            let part = T::of(1.0 / drives.len() as f64);
            self.intensities.iter_mut().for_each(|intensity| *intensity *= part);
        }
        if let Some(response) = &mut self.response {
            response.apply(&mut self.intensities);
        }
        self.fit = self.wanted.fit(&self.intensities);
        self.fit
    }

    /// b += Hᴴ (w p), w the derivative by I of the last field.
    pub fn back(&mut self, slope: Slope, drives: &mut [Waves<T>]) {
        let Some(fit) = &self.fit else { return };
        self.wanted.slopes(&mut self.intensities, fit, slope);
        if let Some(response) = &mut self.response {
            response.apply(&mut self.intensities);
        }
        if slope.loud > 0.0 {
            Isa::best().run(Add {
                scale: T::of(slope.loud),
                part: &self.quiet[1],
                to: &mut self.intensities,
            });
        }
        for (p, b) in self.p.iter_mut().zip(drives) {
            Isa::best().run(Scale { by: &self.intensities, p });
            self.samples.back(p, b);
        }
    }

    /// The back-propagated field of target |p| with equal phases or, for further starts and drives, with scattered
    /// ones.
    pub fn start(&mut self, number: usize, drives: &mut [Waves<T>]) {
        for (drive, b) in (number..).zip(drives) {
            let mut p = Waves::zeros(self.intensities.len());
            let wanted = self.wanted.brightness.iter().zip(&self.wanted.weight).enumerate();
            for (index, (t, w)) in wanted.filter(|(_, (t, _))| **t > T::default()) {
                let angle = TAU * drive as f64 * scatter(index + drive);
                let (sin, cos) = angle.sin_cos();
                let modulus = (t.wide() * w.wide()).sqrt();
                (p.re[index], p.im[index]) = (T::of(modulus * cos), T::of(modulus * sin));
            }
            b.clear();
            self.samples.back(&p, b);
        }
    }

    /// Mean of the last |p|² or depression inside the targets, over the mean around them; `None` without
    /// surroundings.
    pub fn contrast(&self) -> Option<f64> {
        let (mut inside, mut wanted, mut around, mut rest) = (0.0, 0.0, 0.0, 0.0);
        let most = self.wanted.brightness.iter().map(|t| t.wide()).fold(f64::MIN_POSITIVE, f64::max);
        for ((i, t), w) in self.intensities.iter().zip(&self.wanted.brightness).zip(&self.wanted.weight) {
            let (i, t, w) = (i.wide(), t.wide() / most, w.wide());
            inside += w * i * t;
            wanted += w * t;
            around += w * i * (1.0 - t);
            rest += w * (1.0 - t);
        }
        let contrast = (inside / wanted) / (around / rest);
        contrast.is_finite().then_some(contrast)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::solver::shape::table::Table;

    /// A picture with as many elements as samples, each of which sounds at one sample alone.
    fn picture(brightness: &[f64], weight: &[f64]) -> Picture<f64> {
        let count = brightness.len();
        let mut table = Table::new(count);
        for row in 0..count {
            table.push((0..count).map(|n| Complex64::from(if n == row { 1.0 } else { 0.0 })), 1.0);
        }
        Picture::new(Samples::Table(table), Wanted::new(brightness.to_vec(), weight.to_vec()), None)
    }

    #[test]
    fn the_contrast_is_the_mean_inside_over_the_mean_around() {
        // Inside, half covered, around, and elsewhere.
        let (brightness, weight) = ([3.0, 3.0, 1.5, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
        let mut drive = Waves::zeros(16);
        drive.re[..6].copy_from_slice(&[2.0, 1.0, 1.5, 0.5, 0.7, 9.0]);
        let mut areas = picture(&brightness, &weight);
        areas.hear(std::slice::from_ref(&drive));
        let inside = (4.0 + 1.0 + 0.5 * 2.25) / 2.5;
        let around = (0.5 * 2.25 + 0.25 + 0.49) / 2.5;
        let contrast = areas.contrast().unwrap();
        assert!((contrast - inside / around).abs() < 1e-12, "{contrast}, not {}", inside / around);
        let mut everywhere = picture(&[3.0; 6], &[1.0; 6]);
        everywhere.hear(&[drive]);
        assert_eq!(everywhere.contrast(), None);
    }

    #[test]
    fn a_field_around_a_silent_area_has_no_fit() {
        let mut areas = picture(&[1.0, 1.0, 0.0, 0.0], &[1.0; 4]);
        let mut drive = Waves::zeros(16);
        drive.re[2..4].copy_from_slice(&[1.0, 2.0]);
        assert_eq!(areas.hear(std::slice::from_ref(&drive)), None);
        drive.re[0] = 0.1;
        assert!(areas.hear(&[drive]).is_some());
    }
}
