//! The objective of a shape's drive: unevenness along the strokes, side lobes, and weakness.
//!
//! With I the mean |p|² of all drives in turn, over its target value on the strokes, M the mean of it there, and
//! phases φ of the elements in each of them, it is
//!   α E + β Q - γ S + ½ 30 (max(0, ½ ln(floor/M)))²,
//!   E = 1/2p ln(mean (M/I)^p), a soft minimum of |p| along the strokes under their mean,
//!   Q = 1/2q ln(Σ m (I/M)^q), a soft maximum of |p| elsewhere over that mean, m the mask,
//!   S = ½ ln M.
//! For areas, ε L is added ([`crate::solver::shape::picture`]). M is the mean of I T over them if there are no
//! strokes; otherwise ½ 30 (½ ln(s M))² ties the areas' scale to the strokes.
//! Its derivative by φ_n of one of K drives is 2/K Im(u_n* b_n) with b = Hᴴ (w p) and w its derivative by I.
//!
//! *Free amplitudes.* Where amplitudes are free, u = cos ψ e^{jφ}: never above full drive, and smooth up to it. Angles ψ
//! follow the phases among the unknowns; the derivative by ψ_n is -sin ψ_n 2/K Re(e^{-jφ_n} b_n).

use num_complex::Complex64;

use crate::simd::{Instructions, Isa, Kernel};
use crate::solver::descent::Function;
use crate::solver::shape::picture::{Picture, Slope};
use crate::solver::shape::real::{FAINT, LANES, Real, Waves, lanes, power};
use crate::solver::shape::samples::Samples;
use crate::solver::shape::table::Table;

/// Floor of the intensity relative to the mean |p|².
const LEAST: f64 = 1e-6;
/// Stiffness of the penalty for lost strength.
const STIFFNESS: f64 = 30.0;

/// Weights of its terms.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// α
    pub even: f64,
    /// β
    pub quiet: f64,
    /// γ
    pub strong: f64,
    /// p
    pub sharpness: i32,
    /// q
    pub loudness: Loudness,
    /// ε
    pub picture: f64,
    /// The lower limit of M; 0 for none.
    pub floor: f64,
}

/// The sharpness q of the soft maximum of |p|² elsewhere.
#[derive(Clone, Copy, Debug)]
pub enum Loudness {
    Eight,
    Twelve,
}

/// Samples of the quiet region, their weights, and the field there.
#[derive(Debug)]
pub struct Quiet<T> {
    samples: Samples<T>,
    /// Weight of every sample, 0 to 1.
    mask: Vec<T>,
    /// Weights of the samples in use, padded with zeros to whole blocks of lanes.
    in_use: Vec<T>,
    /// Field of every drive.
    p: Vec<Waves<T>>,
}

impl<T: Real> Quiet<T> {
    /// The mask is laid out as the field of the samples is.
    pub fn new(samples: Samples<T>, mask: Vec<T>) -> Self {
        let padded = mask.len().next_multiple_of(LANES);
        let mut in_use = mask.clone();
        in_use.resize(padded, T::default());
        Self { samples, mask, in_use, p: Vec::new() }
    }

    pub fn is_table(&self) -> bool {
        match self.samples {
            Samples::Grid(_) => false,
            Samples::Table(_) => true,
        }
    }

    fn hear(&mut self, drives: &[Waves<T>]) {
        self.p.resize_with(drives.len(), || Waves::zeros(self.in_use.len()));
        drives.iter().zip(&mut self.p).for_each(|(u, p)| self.samples.forward(u, p));
    }

    /// b += Hᴴ p
    fn back(&mut self, drives: &mut [Waves<T>]) {
        self.p.iter().zip(drives).for_each(|(p, b)| self.samples.back(p, b));
    }

    /// Selects the active rows of a table: those that are loud for these drives.
    fn refresh(&mut self, drives: &[Waves<T>]) {
        /// Threshold relative to the loudest |p|²: higher values are dangerous, since side lobes grow between two
        /// refreshes.
        const LOUD: f64 = 0.16;
        let Samples::Table(table) = &mut self.samples else { return };
        table.rows = (0..self.mask.len() as u32).collect();
        let hear = |u: &Waves<T>| {
            let mut p = Waves::zeros(self.mask.len());
            table.forward(u, &mut p);
            p
        };
        let heard: Vec<_> = drives.iter().map(hear).collect();
        let loudness = |row: usize| {
            if self.mask[row] > T::default() { heard.iter().map(|p| p.square(row)).sum() } else { 0.0 }
        };
        let loudest = (0..self.mask.len()).map(loudness).fold(0.0, f64::max);
        let rows: Vec<_> = (0..self.mask.len()).filter(|&row| loudness(row) >= LOUD * loudest).collect();
        self.in_use = rows.iter().map(|&row| self.mask[row]).collect();
        table.rows = rows.iter().map(|&row| row as u32).collect();
        let padded = rows.len().next_multiple_of(LANES);
        self.in_use.resize(padded, T::default());
        self.p.clear();
    }
}

/// The function to minimise, of the phases (rad) of the driven elements, drive after drive; with free amplitudes the
/// angles ψ follow, in the same order.
#[derive(Debug)]
pub struct Objective<T> {
    pub weights: Weights,
    /// Whether amplitudes are unknowns.
    pub is_free: bool,
    pub quiet: Vec<Quiet<T>>,
    /// Areas.
    pub picture: Option<Picture<T>>,
    /// Transfers over target pressures.
    strokes: Table<T>,
    /// Per drive: the excitation, the back-propagated field, and the pressures along the strokes.
    u: Vec<Waves<T>>,
    heard: Vec<Waves<T>>,
    p: Vec<Waves<T>>,
    /// Mean |p|² over its target along the strokes.
    intensities: Vec<f64>,
}

impl<T: Real> Objective<T> {
    /// The objective of this number of drives in turn.
    pub fn new(strokes: Table<T>, drives: usize, weights: Weights) -> Self {
        let u = vec![strokes.excitation(); drives];
        let (heard, p) = (u.clone(), vec![Waves::zeros(strokes.points()); drives]);
        let (quiet, intensities) = (Vec::new(), Vec::new());
        Self { weights, is_free: false, quiet, picture: None, strokes, u, heard, p, intensities }
    }

    /// Number of drives in turn.
    pub fn drives(&self) -> usize {
        self.u.len()
    }

    /// Sets the number of drives in turn.
    pub fn set_drives(&mut self, drives: usize) {
        let u = self.strokes.excitation();
        self.u.resize(drives, u.clone());
        self.heard.resize(drives, u);
        self.p.resize(drives, Waves::zeros(self.strokes.points()));
    }

    /// Whether there is a quiet region.
    pub fn is_quiet(&self) -> bool {
        !self.quiet.is_empty() || self.picture.as_ref().is_some_and(Picture::is_quiet)
    }

    /// Whether there are no targets.
    pub fn is_empty(&self) -> bool {
        self.picture.is_none() && !self.has_strokes()
    }

    pub fn has_strokes(&self) -> bool {
        self.strokes.points() > 0
    }

    /// Starting phases of the elements, for a field with equal phases on the areas or, for further starts and drives,
    /// with scattered ones.
    pub fn start(&mut self, number: usize, elements: usize) -> Vec<f64> {
        if let Some(picture) = &mut self.picture {
            picture.start(number, &mut self.heard);
        }
        let phases = |heard: &Waves<T>| {
            let heard = heard.re.iter().zip(&heard.im).take(elements);
            heard.map(|(re, im)| im.wide().atan2(re.wide())).collect::<Vec<_>>()
        };
        self.heard.iter().flat_map(phases).collect()
    }

    /// M of these unknowns.
    pub fn level(&mut self, x: &[f64]) -> f64 {
        self.play(x);
        match &mut self.picture {
            Some(picture) if self.intensities.is_empty() => picture.hear(&self.u).map_or(0.0, |fit| fit.mean),
            Some(_) | None => self.intensities.iter().sum::<f64>() / self.intensities.len() as f64,
        }
    }

    /// Selects the table rows that are loud for these unknowns; false without tables.
    pub fn refresh(&mut self, x: &[f64]) -> bool {
        if !self.quiet.iter().any(Quiet::is_table) {
            return false;
        }
        self.play(x);
        self.quiet.iter_mut().for_each(|quiet| quiet.refresh(&self.u));
        true
    }

    /// Number of phases among the unknowns.
    fn phases(&self, x: &[f64]) -> usize {
        if self.is_free { x.len() / 2 } else { x.len() }
    }

    /// u of the unknowns, drive after drive.
    pub fn excitation(&self, x: &[f64]) -> Vec<Complex64> {
        let (phases, angles) = x.split_at(self.phases(x));
        let u = |(n, &phase): (usize, &f64)| {
            Complex64::from_polar(1.0, phase) * angles.get(n).map_or(1.0, |angle| angle.cos())
        };
        phases.iter().enumerate().map(u).collect()
    }

    /// The unknowns of u.
    pub fn unknowns(&self, u: &[Complex64]) -> Vec<f64> {
        let angles = u.iter().filter(|_| self.is_free).map(|u| u.norm().min(1.0).acos());
        u.iter().map(|u| u.arg()).chain(angles).collect()
    }

    fn play(&mut self, x: &[f64]) {
        let (phases, angles) = x.split_at(self.phases(x));
        let elements = phases.len() / self.u.len();
        for (drive, ((phases, u), p)) in phases.chunks(elements).zip(&mut self.u).zip(&mut self.p).enumerate()
        {
            for ((phase, re), im) in phases.iter().zip(&mut u.re).zip(&mut u.im) {
                let (sin, cos) = phase.sin_cos();
                (*re, *im) = (T::of(cos), T::of(sin));
            }
            let angles = angles.iter().skip(drive * elements).take(elements);
            for ((angle, re), im) in angles.zip(&mut u.re).zip(&mut u.im) {
                let amplitude = T::of(angle.cos());
                *re *= amplitude;
                *im *= amplitude;
            }
            self.strokes.forward(u, p);
        }
        let inverse = 1.0 / self.u.len() as f64;
        let mean = |point| self.p.iter().map(|p| p.square(point)).sum::<f64>() * inverse;
        self.intensities.clear();
        self.intensities.extend((0..self.strokes.points()).map(mean));
    }

    /// ln(Σ m I^q)/2q, with β/2 of its derivatives back-propagated to the elements, and the factor on the weights of a
    /// picture's quiet samples; `None` if the field is zero.
    fn hear(&mut self) -> Option<(f64, f64)> {
        self.heard.iter_mut().for_each(Waves::clear);
        if self.weights.quiet == 0.0 {
            return None;
        }
        self.quiet.iter_mut().for_each(|quiet| quiet.hear(&self.u));
        let drives = self.u.len() as f64;
        let of_picture = self.picture.as_ref().map_or(0.0, |picture| drives * picture.loudest());
        let of_others = self.quiet.iter().map(|quiet| Isa::best().run(Loudest { quiet }).wide());
        let loudest = of_others.fold(of_picture, f64::max);
        let inverse = T::of(1.0 / loudest);
        if loudest <= 0.0 || !inverse.wide().is_finite() {
            return None;
        }
        let (sum, q) = match self.weights.loudness {
            Loudness::Eight => (self.weigh::<8>(inverse), 8.0),
            Loudness::Twelve => (self.weigh::<12>(inverse), 12.0),
        };
        self.quiet.iter_mut().for_each(|quiet| quiet.back(&mut self.heard));
        let scale = 0.5 * drives * self.weights.quiet / (sum * loudest);
        if !self.quiet.is_empty() {
            self.heard.iter_mut().for_each(|heard| heard.scale(T::of(scale)));
        }
        Some((0.5 * (loudest / drives).ln() + sum.ln() / (2.0 * q), scale))
    }

    fn weigh<const Q: usize>(&mut self, inverse: T) -> f64 {
        let of_mean = T::of(inverse.wide() * self.u.len() as f64);
        let of_picture = self.picture.as_mut().map_or(0.0, |picture| picture.weigh::<Q>(of_mean));
        let of_others = self.quiet.iter_mut().map(|quiet| Isa::best().run(Weigh::<T, Q> { quiet, inverse }));
        of_picture + of_others.sum::<f64>()
    }
}

impl<T: Real> Function for Objective<T> {
    fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.play(x);
        let Weights { strong, sharpness, floor, .. } = self.weights;
        let fit = self.picture.as_mut().map(|picture| picture.hear(&self.u));
        let count = self.intensities.len() as f64;
        let is_stroked = count > 0.0;
        let even = if is_stroked { self.weights.even } else { 0.0 };
        let mean = match fit {
            Some(None) => 0.0,
            Some(Some(fit)) if !is_stroked => fit.mean,
            Some(Some(_)) | None => self.intensities.iter().sum::<f64>() / count,
        };
        if mean.is_nan() || mean <= 0.0 {
            gradient.fill(0.0);
            return f64::INFINITY;
        }
        let weakness = |intensity: f64| (mean / intensity.max(LEAST * mean)).powi(sharpness);
        let sum = self.intensities.iter().map(|&intensity| weakness(intensity)).sum::<f64>();
        let lack = if floor > 0.0 { (0.5 * (floor / mean).ln()).max(0.0) } else { 0.0 };
        let mut value = 0.5 * STIFFNESS * lack * lack - 0.5 * strong * mean.ln();
        if is_stroked {
            value += even * (sum / count).ln() / (2.0 * f64::from(sharpness));
        }
        let mut along = even - strong - STIFFNESS * lack;
        let mut loud = 0.0;
        if let Some((loudness, scale)) = self.hear() {
            loud = scale;
            value += self.weights.quiet * (loudness - 0.5 * mean.ln());
            along -= self.weights.quiet;
        }
        if let (Some(Some(fit)), Some(picture)) = (fit, &mut self.picture) {
            let apart = if is_stroked { 0.5 * (fit.scale * mean).ln() } else { 0.0 };
            value += self.weights.picture * fit.error + 0.5 * STIFFNESS * apart * apart;
            along += STIFFNESS * apart;
            let level = if is_stroked { 0.0 } else { 0.5 * along };
            let slope = Slope { error: self.weights.picture, scale: 0.5 * STIFFNESS * apart, level, loud };
            picture.back(slope, &mut self.heard);
        }
        for (point, &intensity) in self.intensities.iter().enumerate() {
            let weak = even * weakness(intensity) / (sum * intensity.max(LEAST * mean));
            let derivative = T::of(0.5 * (along / (count * mean) - weak));
            for p in &mut self.p {
                p.re[point] *= derivative;
                p.im[point] *= derivative;
            }
        }
        let (phases, angles) = x.split_at(self.phases(x));
        let elements = phases.len() / self.u.len();
        let part = 2.0 / self.u.len() as f64;
        let (of_phases, of_angles) = gradient.split_at_mut(phases.len());
        let slopes = of_phases.chunks_mut(elements);
        for (((p, u), heard), slopes) in self.p.iter().zip(&self.u).zip(&mut self.heard).zip(slopes) {
            self.strokes.back(p, heard);
            for (n, slope) in slopes.iter_mut().enumerate() {
                let ahead = u.re[n].wide() * heard.im[n].wide();
                *slope = part * (ahead - u.im[n].wide() * heard.re[n].wide());
            }
        }
        for (n, (slope, angle)) in of_angles.iter_mut().zip(angles).enumerate() {
            let heard = &self.heard[n / elements];
            let (sin, cos) = phases[n].sin_cos();
            let along = cos * heard.re[n % elements].wide() + sin * heard.im[n % elements].wide();
            *slope = -angle.sin() * part * along;
        }
        value
    }
}

/// The largest Σ |p|² over drives where the mask is non-zero.
struct Loudest<'a, T> {
    quiet: &'a Quiet<T>,
}

impl<T: Real> Kernel for Loudest<'_, T> {
    type Output = T;

    #[inline(always)]
    fn run<I: Instructions>(self) -> T {
        let Quiet { p, in_use, .. } = self.quiet;
        let mut most = [T::default(); LANES];
        for (block, mask) in in_use.as_chunks::<LANES>().0.iter().enumerate() {
            let square = squares::<T, I>(p, block);
            let heard = lanes(|i| if mask[i] > T::default() { square[i] } else { T::default() });
            let before = most;
            most = lanes(|i| if heard[i] > before[i] { heard[i] } else { before[i] });
        }
        most.into_iter().fold(T::default(), |most, square| if square > most { square } else { most })
    }
}

/// Σ m t^q with t = Σ |p|² over drives · inverse, 1 at most; every p ← p m t^{q-1}.
struct Weigh<'a, T, const Q: usize> {
    quiet: &'a mut Quiet<T>,
    inverse: T,
}

impl<T: Real, const Q: usize> Kernel for Weigh<'_, T, Q> {
    type Output = f64;

    #[inline(always)]
    fn run<I: Instructions>(self) -> f64 {
        /// Blocks summed before their sum is widened.
        const RUN: usize = 64;
        let Self { quiet: Quiet { p, in_use, .. }, inverse } = self;
        let (faint, one) = (T::of(FAINT), T::of(1.0));
        let mut sum = 0.0;
        for (run, mask) in in_use.as_chunks::<LANES>().0.chunks(RUN).enumerate() {
            let mut sums = [T::default(); LANES];
            for (block, mask) in mask.iter().enumerate() {
                let (block, before) = (run * RUN + block, sums);
                let square = squares::<T, I>(p, block);
                let part: [T; LANES] =
                    lanes(|i| if square[i] * inverse < one { square[i] * inverse } else { one });
                let part: [T; LANES] = lanes(|i| if part[i] > faint { part[i] } else { T::default() });
                let powers = power(&part, Q - 1);
                let weight: [T; LANES] = lanes(|i| mask[i] * powers[i]);
                sums = lanes(|i| T::fused::<I>(weight[i], part[i], before[i]));
                for p in p.iter_mut() {
                    let [re, im] = p.block_mut(block);
                    let before = (*re, *im);
                    *re = lanes(|i| before.0[i] * weight[i]);
                    *im = lanes(|i| before.1[i] * weight[i]);
                }
            }
            sum += sums.into_iter().map(Real::wide).sum::<f64>();
        }
        sum
    }
}

/// Σ |p|² over drives in a block of samples.
#[inline(always)]
fn squares<T: Real, I: Instructions>(p: &[Waves<T>], block: usize) -> [T; LANES] {
    let mut sum = [T::default(); LANES];
    for p in p {
        let ([re, im], before) = (p.block(block), sum);
        let part: [T; LANES] = lanes(|i| T::fused::<I>(re[i], re[i], before[i]));
        sum = lanes(|i| T::fused::<I>(im[i], im[i], part[i]));
    }
    sum
}

#[cfg(test)]
mod tests;
