//! The sound at a point over time, under the envelope and the frames of a motion, and its spectral lines.
//!
//! |p|² is the envelope's square times the square of the frame that plays. Both are sums of lines that are known in closed form, so
//! the lines of the product are those of an endless sound: no window, and no leakage between lines.
//!
//! Elements with a response ([`acoustics::response`](crate::acoustics::response)) filter the amplitude: the sound is carried on from
//! event to event, and its lines are those of samples of the common period. |p|² has a kink at every event, so that lines are off by
//! about events/(τ (2π samples)²) times the period: 1e-5 at ten thousand frames per second.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;
use sonoglyph_fourier::coefficients;

use crate::acoustics::response::{Resonator, frames_per_second};
use crate::scene::modulation::{Envelope, LONGEST, Law, Modulation, SpectralLine, common};
use crate::scene::{Drive, Scene};

/// Time steps of a frame.
const STEPS_PER_FRAME: f64 = 4.0;
/// Lines closer than this count as one, Hz.
const ONE_LINE: f64 = 1e-6;
/// Smallest line relative to the mean.
const LEAST: f64 = 1e-9;
/// Range of lines of a square wave or a file beyond the band, in bands: combined with those of a motion they fall
/// into it.
const REACH: f64 = 16.0;
/// Limit of products of lines per point.
const MOST_PRODUCTS: f64 = 3e7;

/// Time constants after which nothing is left of what was: e^-40.
const FADED: f64 = 40.0;
/// Longest step of a response, in parts of its pole's modulus.
const STEP: f64 = 0.5;
/// The same of tones, in parts of the fastest period: an eighth.
const TONES: f64 = 4.0;
/// Nodes and weights of Gauss' quadrature on [0, 1]; exact to 1e-12 over such a step.
const NODES: [[f64; 2]; 6] = [
    [0.033_765_242_898_423_99, 0.085_662_246_189_585_17],
    [0.169_395_306_766_867_74, 0.180_380_786_524_069_3],
    [0.380_690_406_958_401_55, 0.233_956_967_286_345_52],
    [0.619_309_593_041_598_5, 0.233_956_967_286_345_52],
    [0.830_604_693_233_132_3, 0.180_380_786_524_069_3],
    [0.966_234_757_101_576, 0.085_662_246_189_585_17],
];
/// Samples per second of sound behind a response, relative to its rate of decay, and limit of the samples of a period.
const SAMPLING: f64 = 64.0;
const MOST_SAMPLES: f64 = (1 << 22) as f64;
/// Samples per second of drives behind a response, and their limit.
const UNROLLED: f64 = 12_000.0;
const MOST_UNROLLED: f64 = 4096.0;

/// Two lines of a spectrum at frequencies of either sign: coefficient · e^{2πj frequency t}.
type Term = (f64, Complex64);

/// The sequence of frames and the envelope over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    modulation: Modulation,
    frames: usize,
    /// Frames per second; 0 for a single frame.
    rate: f64,
    /// Whether frames are held until the next, and not samples of what is smooth between.
    is_held: bool,
    response: Option<Resonator>,
}

/// A spectral line of a quantity that is quadratic in the sound, at every point: its coefficient, of e^{2πj frequency t}, from those
/// of the frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Hz
    pub frequency: f64,
    /// Of frames q_f the coefficient is Σ weight Q_k, Q_k = 1/M Σ q_f e^{-2πj k f/M}; k by `coefficients`.
    pub weights: Vec<(usize, Complex64)>,
}

impl Default for Course {
    /// Steady sound.
    fn default() -> Self {
        Self { modulation: Modulation::default(), frames: 1, rate: 0.0, is_held: true, response: None }
    }
}

impl Course {
    /// For a scene with this number of frames in its motion, or of drives in turn.
    ///
    /// # Panics
    /// No frame.
    pub fn new(scene: &Scene, frames: usize) -> Self {
        assert!(frames > 0, "something is played");
        let rate = if frames == 1 { 0.0 } else { frames_per_second(scene) };
        let modulation = scene.envelope().clone();
        Self { modulation, frames, rate, is_held: true, response: Resonator::new(scene) }
    }

    /// The sequence without a response, and its drives, that sounds as this one does with it; unchanged without a response, or
    /// without a common period of envelope and frames that samples of some number can follow.
    pub fn unrolled(self, drives: Vec<Drive>) -> (Self, Vec<Drive>) {
        let period = self.period().filter(|_| self.response.is_some());
        let alike = |drive: &Drive| drive.phases.len() == drives[0].phases.len();
        let Some(period) = period.filter(|_| drives.len() == self.frames && drives.iter().all(alike)) else {
            return (self, drives);
        };
        let each = (period * self.usual_rate().max(UNROLLED) / self.frames as f64).ceil();
        let count = each * self.frames as f64;
        if count > MOST_UNROLLED {
            return (self, drives);
        }
        let rate = count / period;
        let element = |n: usize| {
            let of = |drive: &Drive| Complex64::from_polar(drive.amplitudes[n], drive.phases[n]);
            self.pressures(&drives.iter().map(of).collect::<Vec<_>>(), count as usize, rate)
        };
        let elements: Vec<_> = (0..drives[0].phases.len()).into_par_iter().map(element).collect();
        let drive = |instant: usize| Drive {
            amplitudes: elements.iter().map(|u| u[instant].norm()).collect(),
            phases: elements.iter().map(|u| u[instant].arg()).collect(),
        };
        let drives = (0..count as usize).map(drive).collect();
        let modulation = Modulation { shape: Envelope::Off, ..self.modulation };
        (Self { modulation, frames: count as usize, rate, is_held: false, response: None }, drives)
    }

    /// The lines up to a frequency (Hz) of quantities that are quadratic in the sound, the mean first; a response is left out.
    pub fn lines(&self, band: f64) -> Vec<Combination> {
        let cycle = self.cycles_per_second();
        let reach = if self.rate > 0.0 { (1.0 + REACH) * band } else { band };
        let mut terms: Vec<(f64, usize, Complex64)> = Vec::new();
        for (frequency, coefficient) in square_terms(&self.modulation, reach) {
            if cycle == 0.0 {
                terms.push((frequency, 0, coefficient));
                continue;
            }
            let [least, most] = [-frequency - ONE_LINE, band - frequency + ONE_LINE].map(|end| end / cycle);
            for k in least.ceil() as i64..=most.floor() as i64 {
                let harmonic = k.rem_euclid(self.frames as i64) as usize;
                let weight = match self.is_held {
                    true => hold(k, self.frames),
                    false if 2 * k.unsigned_abs() as usize <= self.frames => Complex64::ONE,
                    false => Complex64::ZERO,
                };
                terms.push((frequency + k as f64 * cycle, harmonic, coefficient * weight));
            }
        }
        terms.retain(|(frequency, _, weight)| {
            (-ONE_LINE..=band + ONE_LINE).contains(frequency) && weight.norm() > LEAST
        });
        terms.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let alike = terms.chunk_by(|a, b| b.0 - a.0 < ONE_LINE);
        let line = |same: &[(f64, usize, Complex64)]| Combination {
            frequency: if same[0].0 < ONE_LINE { 0.0 } else { same[0].0 },
            weights: same.iter().map(|(_, harmonic, weight)| (*harmonic, *weight)).collect(),
        };
        alike.map(line).collect()
    }

    /// Frames per second; 0 for a single frame.
    pub(crate) fn frames(&self) -> usize {
        self.frames
    }

    pub fn frames_per_second(&self) -> f64 {
        self.rate
    }

    /// Repetitions of all frames per second; 0 for a single frame.
    pub fn cycles_per_second(&self) -> f64 {
        self.rate / self.frames as f64
    }

    /// Common period (s) of envelope and frames. `None` for steady sound, or without a period below 10 s.
    pub fn period(&self) -> Option<f64> {
        let cycle = (self.rate > 0.0).then(|| 1.0 / self.cycles_per_second());
        match (self.modulation.period(), cycle) {
            (None, other) | (other, None) => other,
            (Some(envelope), Some(cycle)) => common(envelope, cycle),
        }
    }

    /// Recommended duration of a time course (s): the common period, or else the longer one; 0 for steady sound.
    pub fn usual_span(&self) -> f64 {
        let cycle = if self.rate > 0.0 { 1.0 / self.cycles_per_second() } else { 0.0 };
        self.period().unwrap_or_else(|| self.modulation.period().unwrap_or(0.0).max(cycle))
    }

    /// Instants per second that follow the course closely: at least four in a frame, 32 in a period of the fastest tone, and one
    /// per sample of a file.
    pub fn usual_rate(&self) -> f64 {
        let of_envelope = match self.modulation.shape {
            Envelope::File => self.modulation.step_rate(),
            Envelope::Off | Envelope::Sine | Envelope::Square | Envelope::Tones => {
                self.modulation.step_rate() / 2.0
            }
        };
        let least = of_envelope.max(STEPS_PER_FRAME * self.rate).max(1.0);
        if self.rate > 0.0 { (least / self.rate).ceil() * self.rate } else { least }
    }

    /// The frame at a time (s); at a boundary, the later one.
    pub fn frame(&self, time: f64) -> usize {
        /// Part of a frame: times are rounded.
        const ROUNDING: f64 = 1e-9;
        (time * self.rate + ROUNDING).floor().rem_euclid(self.frames as f64) as usize % self.frames
    }

    /// The complex pressures (Pa, peak) at instants, so many per second, and a point with these pressures of all frames at full
    /// amplitude.
    pub fn pressures(&self, of_frames: &[Complex64], instants: usize, rate: f64) -> Vec<Complex64> {
        let times = (0..instants).map(|instant| instant as f64 / rate);
        match &self.response {
            None => times.map(|time| self.driven(of_frames, time)).collect(),
            Some(resonator) => {
                let mut slow = Slow {
                    course: self,
                    of_frames,
                    resonator,
                    time: f64::NEG_INFINITY,
                    value: Complex64::ZERO,
                };
                times.map(|time| slow.sound(time)).collect()
            }
        }
    }

    /// The same at a time (s), of elements that follow at once.
    fn driven(&self, of_frames: &[Complex64], time: f64) -> Complex64 {
        of_frames[self.frame(time)] * self.modulation.envelope(time)
    }

    /// Events per second between which frame and envelope are smooth: frames, edges or samples of the envelope, and the
    /// moments at which a sine may touch zero.
    fn events(&self) -> [f64; 2] {
        let of_envelope = match self.modulation.shape {
            Envelope::Off | Envelope::Tones => 0.0,
            Envelope::Sine => 4.0 * self.modulation.frequency,
            Envelope::Square => 2.0 * self.modulation.frequency,
            Envelope::File => self.modulation.step_rate(),
        };
        [self.rate, of_envelope]
    }

    /// The lines of |p|² (Pa², p the complex peak pressure) up to a frequency (Hz), at a point at which these are the pressures of
    /// all frames; lines weaker than 1e-9 of the mean are left out.
    ///
    /// # Errors
    /// Too many lines.
    pub fn spectrum(&self, of_frames: &[Complex64], band: f64) -> Result<Vec<SpectralLine>, String> {
        if let Some(resonator) = self.response {
            return self.sampled(of_frames, band, resonator);
        }
        let squares: Vec<_> = of_frames.iter().map(Complex64::norm_sqr).collect();
        let cycle = self.cycles_per_second();
        let period = self.period().filter(|_| cycle > 0.0 && self.modulation.shape == Envelope::Square);
        if let Some(period) = period.filter(|period| self.edges(*period) * band * period < MOST_PRODUCTS) {
            return Ok(lines(self.between_edges(&squares, band, period)));
        }
        let harmonics = coefficients(squares.into_iter().map(Complex64::from).collect());
        let reach = if self.rate > 0.0 { (1.0 + REACH) * band } else { band };
        let envelope = square_terms(&self.modulation, reach);
        let per_term = if cycle > 0.0 { band / cycle + 1.0 } else { 1.0 };
        if envelope.len() as f64 * per_term > MOST_PRODUCTS {
            return Err(format!(
                "the lines of the envelope and those of the motion meet {:.1e} times up to {band} Hz, more than {MOST_PRODUCTS:.0e}: \
                 take a narrower band, a shorter file or a faster motion",
                envelope.len() as f64 * per_term
            ));
        }
        let mut terms: Vec<Term> = Vec::new();
        for (frequency, coefficient) in envelope {
            if cycle == 0.0 {
                terms.push((frequency, coefficient * harmonics[0]));
                continue;
            }
            let [least, most] = [-frequency - ONE_LINE, band - frequency + ONE_LINE].map(|end| end / cycle);
            for k in least.ceil() as i64..=most.floor() as i64 {
                terms.push((frequency + k as f64 * cycle, coefficient * held(&harmonics, k)));
            }
        }
        let is_in_band = |(frequency, _): &Term| (-ONE_LINE..=band + ONE_LINE).contains(frequency);
        terms.retain(is_in_band);
        Ok(lines(terms))
    }
}

impl Course {
    /// The lines of sound behind a response, from samples of the common period.
    fn sampled(
        &self,
        of_frames: &[Complex64],
        band: f64,
        resonator: Resonator,
    ) -> Result<Vec<SpectralLine>, String> {
        let period = match self.period() {
            Some(period) => period,
            None if self.usual_span() == 0.0 => 1.0 / band,
            None => {
                return Err(format!(
                    "with array.response, lines need a common period of modulation and motion below {LONGEST} s"
                ));
            }
        };
        let least = period * (16.0 * band).max(SAMPLING * resonator.pole.re);
        let samples = (least / self.frames as f64).ceil() * self.frames as f64;
        if samples > MOST_SAMPLES {
            return Err(format!(
                "the common period of {period} s has {samples:.1e} samples, more than {MOST_SAMPLES:.0e}: \
                 take a narrower band, a shorter file or a faster motion"
            ));
        }
        let pressures = self.pressures(of_frames, samples as usize, samples / period);
        let squares = pressures.iter().map(|p| Complex64::from(p.norm_sqr())).collect();
        let coefficients = coefficients(squares).into_iter().take((band * period + ONE_LINE) as usize + 1);
        Ok(lines(coefficients.enumerate().map(|(n, value)| (n as f64 / period, value)).collect()))
    }

    /// Number of frame and square-wave edges in a time (s).
    fn edges(&self, span: f64) -> f64 {
        span * (self.rate + 2.0 * self.modulation.frequency)
    }

    /// The terms of frames under a square wave, whose lines would combine in infinitely many pairs: with jumps at
    /// times t in a period T, the coefficient at a frequency is Σ jump e^{-jωt}/(jωT).
    fn between_edges(&self, squares: &[f64], band: f64, period: f64) -> Vec<Term> {
        let low = low_square(&self.modulation);
        let times = |rate: f64| (0..(period * rate).round() as usize).map(move |n| (n as f64 / rate, n));
        let frames = times(self.rate).map(|(time, n)| (time, Some(n % self.frames)));
        let swaps = times(2.0 * self.modulation.frequency).map(|(time, _)| (time, None));
        let mut edges: Vec<(f64, Option<usize>)> = frames.chain(swaps).collect();
        edges.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut frame, mut is_on) = (self.frames - 1, false);
        let value = |frame: usize, is_on: bool| squares[frame] * if is_on { 1.0 } else { low };
        let (mut sum, mut jumps) = (0.0, Vec::new());
        for (index, (time, next)) in edges.iter().enumerate() {
            let before = value(frame, is_on);
            match next {
                Some(next) => frame = *next,
                None => is_on = !is_on,
            }
            let after = value(frame, is_on);
            jumps.push((*time, after - before));
            sum += after * (edges.get(index + 1).map_or(period, |(next, _)| *next) - time);
        }
        let term = |n: usize| {
            let omega = 2.0 * PI * n as f64 / period;
            let jump = |&(time, jump): &(f64, f64)| Complex64::from_polar(jump, -omega * time);
            let coefficient = jumps.iter().map(jump).sum::<Complex64>() / Complex64::new(0.0, omega * period);
            (n as f64 / period, if n == 0 { Complex64::from(sum / period) } else { coefficient })
        };
        (0..=(band * period + ONE_LINE) as usize).map(term).collect()
    }
}

/// The slow part of the sound at a point behind a response, carried on in time.
struct Slow<'a> {
    course: &'a Course,
    of_frames: &'a [Complex64],
    resonator: &'a Resonator,
    /// s
    time: f64,
    value: Complex64,
}

impl Slow<'_> {
    /// The sound at a time (s) no earlier than the last one.
    fn sound(&mut self, time: f64) -> Complex64 {
        let Resonator { pole, direct } = *self.resonator;
        let start = time - FADED / pole.re;
        if self.time < start {
            (self.time, self.value) = (start, Complex64::ZERO);
        }
        // Tones have no events, and a step no more than a part of their period.
        let fastest = match self.course.modulation.shape {
            Envelope::Tones => self.course.modulation.fastest(),
            Envelope::Off | Envelope::Sine | Envelope::Square | Envelope::File => 0.0,
        };
        let longest = STEP / pole.norm().max(TONES * fastest);
        let events = self.course.events();
        while self.time < time {
            /// Part of the distance of events: times are rounded.
            const ROUNDING: f64 = 1e-9;
            let next = |rate: f64| {
                if rate > 0.0 { ((self.time * rate + ROUNDING).floor() + 1.0) / rate } else { f64::INFINITY }
            };
            let until = events.into_iter().map(next).fold(time.min(self.time + longest), f64::min);
            let span = until - self.time;
            // The frame in the middle: at the ends it may be either.
            let frame = self.of_frames[self.course.frame(self.time + span / 2.0)];
            let gained = |[node, weight]: &[f64; 2]| {
                let envelope = self.course.modulation.envelope(self.time + node * span);
                weight * envelope * (-pole * (1.0 - node) * span).exp()
            };
            let gained: Complex64 = NODES.iter().map(gained).sum();
            self.value = self.value * (-pole * span).exp() + pole * span * gained * frame;
            self.time = until;
        }
        direct * self.course.driven(self.of_frames, time) + (1.0 - direct) * self.value
    }
}

/// The coefficient of harmonic k of a sequence with each value held until the next.
fn held(transformed: &[Complex64], k: i64) -> Complex64 {
    transformed[k.rem_euclid(transformed.len() as i64) as usize] * hold(k, transformed.len())
}

/// The factor on harmonic k of so many values from holding each until the next.
fn hold(k: i64, count: usize) -> Complex64 {
    let part = k as f64 / count as f64;
    Complex64::from_polar(sinc(part), -PI * part)
}

/// sin(πx)/πx
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// The lines of the square of an envelope, the mean first: those of sines and tones, which are few, and of edges and files up to
/// a frequency (Hz).
pub fn square_lines(modulation: &Modulation, reach: f64) -> Vec<SpectralLine> {
    let mut terms = square_terms(modulation, reach);
    terms.retain(|(frequency, _)| *frequency > -ONE_LINE);
    lines(terms)
}

/// The terms of the envelope's square; where it has edges or comes from a file, up to a frequency (Hz).
fn square_terms(modulation: &Modulation, reach: f64) -> Vec<Term> {
    let terms = match modulation.shape {
        Envelope::Off => return vec![(0.0, Complex64::ONE)],
        Envelope::Square => return square_wave(modulation, reach),
        Envelope::File => return file(modulation, reach),
        Envelope::Sine => swing(&[(modulation.frequency, modulation.depth, 0.0)]),
        Envelope::Tones => {
            let tones = modulation.tones.iter().map(|tone| (tone.frequency, tone.depth, tone.phase));
            swing(&tones.collect::<Vec<_>>())
        }
    };
    match modulation.law {
        Law::Power => terms,
        Law::Amplitude => {
            let squared =
                |&(f, c): &Term| terms.iter().map(move |&(g, d)| (f + g, c * d)).collect::<Vec<_>>();
            terms.iter().flat_map(squared).collect()
        }
    }
}

/// 1 - Σ depth (1 - sin(2π frequency t + phase))/2.
fn swing(tones: &[(f64, f64, f64)]) -> Vec<Term> {
    let middle = 1.0 - tones.iter().map(|(_, depth, _)| depth).sum::<f64>() / 2.0;
    let of_tone = |&(frequency, depth, phase): &(f64, f64, f64)| {
        let half = Complex64::from_polar(depth / 4.0, phase - PI / 2.0);
        [(frequency, half), (-frequency, half.conj())]
    };
    [(0.0, Complex64::from(middle))].into_iter().chain(tones.iter().flat_map(of_tone)).collect()
}

/// The remaining power in the second half of a square wave's period.
pub fn low_square(modulation: &Modulation) -> f64 {
    match modulation.law {
        Law::Amplitude => (1.0 - modulation.depth).powi(2),
        Law::Power => 1.0 - modulation.depth,
    }
}

/// 1 in the first half of a period, and the square of the remainder in the second.
fn square_wave(modulation: &Modulation, reach: f64) -> Vec<Term> {
    let low = low_square(modulation);
    let frequency = modulation.frequency;
    let most = (reach / frequency).floor() as i64;
    let odd = (-most..=most).filter(|n| n % 2 != 0);
    let term = |n: i64| (n as f64 * frequency, Complex64::new(0.0, -(1.0 - low) / (PI * n as f64)));
    std::iter::once((0.0, Complex64::from((1.0 + low) / 2.0))).chain(odd.map(term)).collect()
}

/// Straight pieces, or their squares.
fn file(modulation: &Modulation, reach: f64) -> Vec<Term> {
    let Some(samples) = modulation.wave.get() else { return vec![(0.0, Complex64::ONE)] };
    let swing: Vec<f64> =
        samples.values.iter().map(|&x| 1.0 - modulation.depth * (1.0 - f64::from(x)) / 2.0).collect();
    let count = swing.len();
    let transform = |value: &dyn Fn(usize) -> f64| {
        coefficients((0..count).map(|index| Complex64::from(value(index))).collect())
    };
    // A piece from a to b is (1 - u)a + ub; its square is (1 - u)a² + ub² - u(1 - u)(b - a)².
    let (ends, bends) = match modulation.law {
        Law::Power => (transform(&|i| swing[i]), None),
        Law::Amplitude => {
            let rise = |i: usize| swing[(i + 1) % count] - swing[i];
            (transform(&|i| swing[i].powi(2)), Some(transform(&|i| rise(i).powi(2))))
        }
    };
    let frequency = 1.0 / samples.period();
    let most = (reach / frequency).floor() as i64;
    let term = |k: i64| {
        let (index, part) = (k.rem_euclid(count as i64) as usize, k as f64 / count as f64);
        let straight = ends[index] * sinc(part).powi(2);
        let bend = |bends: &Vec<Complex64>| bends[index] * Complex64::from_polar(arch(PI * part), -PI * part);
        (k as f64 * frequency, straight - bends.as_ref().map_or(Complex64::ZERO, bend))
    };
    (-most..=most).map(term).collect()
}

/// ∫ u(1 - u) cos(2h(u - ½)) du from 0 to 1.
fn arch(h: f64) -> f64 {
    /// Limit between closed form and series, which are equally accurate there.
    const SMALL: f64 = 0.05;
    if h.abs() < SMALL {
        return 1.0 / 6.0 - h.powi(2) / 60.0 + h.powi(4) / 1680.0;
    }
    (h.sin() - h * h.cos()) / (2.0 * h.powi(3))
}

/// Terms at non-negative frequencies as lines; equal frequencies are summed.
fn lines(mut terms: Vec<Term>) -> Vec<SpectralLine> {
    terms.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let sums = terms.chunk_by(|a, b| b.0 - a.0 < ONE_LINE).map(|same| {
        let sum: Complex64 = same.iter().map(|(_, coefficient)| coefficient).sum();
        (if same[0].0 < ONE_LINE { 0.0 } else { same[0].0 }, sum)
    });
    let line = |(frequency, sum): Term| {
        // Its twin at the negative frequency has the other half.
        let amplitude = if frequency == 0.0 { sum.re } else { 2.0 * sum.norm() };
        SpectralLine { frequency, amplitude, phase: if frequency == 0.0 { 0.0 } else { sum.arg() } }
    };
    let lines: Vec<_> = sums.map(line).collect();
    let mean = lines.first().filter(|line| line.frequency == 0.0).map_or(0.0, |line| line.amplitude);
    lines.into_iter().filter(|line| line.frequency == 0.0 || line.amplitude > LEAST * mean).collect()
}
