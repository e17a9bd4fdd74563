//! The response of elements to changes of their drive.
//!
//! An element is a resonance behind a source. In the frame of the carrier its sound w follows the drive u as
//!
//! ```text
//! w = d u + (1 - d) v,    dv/dt = s (u - v),    s = 1/τ - 2πj (resonance - carrier)
//! ```
//!
//! so that a drive at the offset F from the carrier is answered by G(F) = d + (1 - d) s/(s + 2πjF): relative to the
//! steady answer, G(0) = 1. A resonance alone has d = 0. The circuit of a known transducer (a series resonance Z beside a
//! capacitance C, behind a resistance R; the sound is the current through Z) has the current 1/f with
//! f = R + Z (1 + jωRC). Its slow pole is s, its residue there gives 1 - d, and what is left over, d, varies by 5e-4 within
//! 3 kHz of the carrier.
//!
//! All elements are alike, so the field follows like each drive. For frames of the duration T played in a cycle of M,
//! and the harmonic z = e^{2πjk/M} from frame to frame, v at the start of a frame is (1 - E)/(z - E) of the frame's drive,
//! E = e^{-sT}, and within it
//!
//! ```text
//! w = u (1 + D e^{-st}),    D = (1 - d)(1 - z)/(z - E),    λ_k = ⟨|w|²⟩/|u|² = 1 + 2 Re D φ(sT) + |D|² φ(2 Re s T)
//! ```
//!
//! with φ(x) = (1 - e^{-x})/x. Every quantity that is quadratic in the sound (|P|², intensity, radiation pressure, the force on
//! a bead, a liquid's depression) has the mean over the cycle Σ_k λ_k of the harmonics' own. So M drives with the
//! harmonics √λ_k times those of the frames have, played in turn without any response, the means of the response exactly: a map
//! costs what it cost before. Their phases are those of ⟨w⟩/u, so that each resembles its frame. As convolution: each
//! drive is a sum of its predecessors with a decaying weight.
//!
//! An envelope of lines c_l at the frequencies f_l passes through likewise: each line sees the pole s + 2πj f_l, and the
//! means add up, weighted by |c_l|² (without a common period of envelope and cycle no two lines meet).

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;
use sonoglyph_fourier::coefficients;

use crate::scene::{Circuit, Drive, Envelope, Modulation, Pole, Response, Scene, SpectralLine, motion};

/// Drives in turn per second for a scene at rest.
const TURNS: f64 = 1000.0;
/// Weights of predecessors below this are left out.
const LEAST: f64 = 1e-10;
/// Limits of the samples of an envelope's period.
const SAMPLES: [usize; 2] = [1 << 12, 1 << 20];
/// Longest span (s) for which an envelope without a short period is sampled.
const LONGEST: f64 = 10.0;
/// Lines closer than this (Hz), or than this part of their frequency, count as one: λ changes over 1/(2πτ).
const BIN: f64 = 4.0;
const BIN_PART: f64 = 1.0 / 16.0;

/// The response of an element, relative to the steady one at the carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonator {
    /// s, 1/s: the real part is 1/τ.
    pub pole: Complex64,
    /// d, the part that follows at once.
    pub direct: Complex64,
}

/// A decay within frames, after the harmonics of a cycle.
struct Decay {
    /// The steady answer, relative to the carrier's.
    steady: Complex64,
    /// 1 - d times the steady answer of the pole.
    slow: Complex64,
    /// e^{-sT}
    left: Complex64,
    /// φ(sT), φ(2 Re s T)
    means: [Complex64; 2],
}

impl Decay {
    /// The means of w and of |w|² over a frame, of a drive that turns by z from frame to frame.
    fn of(&self, z: Complex64) -> (Complex64, f64) {
        let swing = self.slow * (1.0 - z) / (z - self.left);
        let mean = self.steady + swing * self.means[0];
        let square = self.steady.norm_sqr()
            + 2.0 * (self.steady.conj() * swing * self.means[0]).re
            + swing.norm_sqr() * self.means[1].re;
        (mean, square)
    }
}

/// (1 - e^{-x})/x
fn mean_of_decay(x: Complex64) -> Complex64 {
    if x.norm() < 1e-5 { 1.0 - x / 2.0 } else { (1.0 - (-x).exp()) / x }
}

impl Resonator {
    /// The elements' own; `None` if they follow at once.
    pub fn new(scene: &Scene) -> Option<Self> {
        let carrier = Complex64::new(0.0, TAU * scene.array.frequency);
        Some(match scene.array.response? {
            Response::Pole(Pole { resonance, tau }) => {
                let pole = carrier - Complex64::new(-1.0 / tau, TAU * resonance);
                Self { pole, direct: Complex64::ZERO }
            }
            Response::Preset(transducer) => Self::of_circuit(&transducer.circuit(), carrier),
        })
    }

    fn of_circuit(circuit: &Circuit, carrier: Complex64) -> Self {
        /// Newton's steps from the series resonance: the pole is within a hundredth of it.
        const STEPS: usize = 8;
        let Circuit { motional: [capacitance, inductance, resistance], parallel, source } = *circuit;
        // f and its derivative.
        let inverse = |s: Complex64| {
            let z = resistance + s * inductance + (s * capacitance).inv();
            let slope = inductance - (s * s * capacitance).inv();
            let charge = parallel * source;
            (source + z * (1.0 + s * charge), slope * (1.0 + s * charge) + z * charge)
        };
        let damping = (resistance + source) / (2.0 * inductance);
        let start = Complex64::new(-damping, (inductance * capacitance).sqrt().recip());
        let pole = (0..STEPS).fold(start, |at, _| {
            let (value, slope) = inverse(at);
            at - value / slope
        });
        let part = inverse(carrier).0 / (inverse(pole).1 * (carrier - pole));
        Self { pole: carrier - pole, direct: 1.0 - part }
    }

    /// G at an offset (Hz) from the carrier.
    pub fn at(&self, offset: f64) -> Complex64 {
        self.direct + (1.0 - self.direct) * self.pole / (self.pole + Complex64::new(0.0, TAU * offset))
    }

    /// For frames of a duration (s), under an envelope's line (Hz).
    fn decay(&self, span: f64, line: f64) -> Decay {
        let pole = self.pole + Complex64::new(0.0, TAU * line);
        let slow = (1.0 - self.direct) * self.pole / pole;
        Decay {
            steady: self.direct + slow,
            slow,
            left: (-pole * span).exp(),
            means: [pole, Complex64::from(2.0 * pole.re)].map(|rate| mean_of_decay(rate * span)),
        }
    }

    /// What is still missing at the beginning of each frame, for frames (of any number of values) of a duration (s) in an endless
    /// cycle: w(t) is the frame's own plus this times e^{-st}.
    pub fn missing(&self, frames: &[Vec<Complex64>], span: f64) -> Vec<Vec<Complex64>> {
        let left = (-self.pole * span).exp();
        let mut slow = vec![Complex64::ZERO; frames.first().map_or(0, Vec::len)];
        let go_on = |slow: &mut [Complex64], frame: &[Complex64]| {
            slow.iter_mut().zip(frame).for_each(|(v, u)| *v = u + (*v - u) * left);
        };
        frames.iter().for_each(|frame| go_on(&mut slow, frame));
        // After a cycle from silence, what the cycles before have left is a geometric series.
        let all = 1.0 - (-self.pole * span * frames.len() as f64).exp();
        slow.iter_mut().for_each(|v| *v /= all);
        let mut missing = Vec::with_capacity(frames.len());
        for frame in frames {
            missing.push(slow.iter().zip(frame).map(|(v, u)| (1.0 - self.direct) * (v - u)).collect());
            go_on(&mut slow, frame);
        }
        missing
    }

    /// The lines of the envelope's square behind the response, for a steady drive; the mean is first.
    pub fn square_lines(&self, modulation: &Modulation) -> Vec<SpectralLine> {
        let (spacing, mut lines) = spectrum(modulation);
        let count = lines.len();
        for (index, line) in lines.iter_mut().enumerate() {
            *line *= self.at(frequency(index, count, spacing));
        }
        // The coefficients of the conjugate are the values, in the opposite order.
        let values = coefficients(lines.iter().map(Complex64::conj).collect());
        let squares: Vec<_> =
            values.iter().map(|value| Complex64::from(value.norm_sqr() * (count as f64).powi(2))).collect();
        let squares = coefficients(squares);
        let weakest = LEAST * squares[0].re;
        let line = |(index, value): (usize, &Complex64)| SpectralLine {
            frequency: index as f64 * spacing,
            amplitude: value.norm() * if index == 0 { 1.0 } else { 2.0 },
            phase: value.arg(),
        };
        let lines = squares[..count / 2].iter().enumerate().map(line);
        lines.filter(|line| line.frequency == 0.0 || line.amplitude > weakest).collect()
    }
}

/// The frequency (Hz, of either sign) of a coefficient.
fn frequency(index: usize, count: usize, spacing: f64) -> f64 {
    let signed = if 2 * index < count { index as f64 } else { index as f64 - count as f64 };
    signed * spacing
}

/// The distance of the lines of an envelope's amplitude (Hz), and all of them as [`coefficients`] orders them.
fn spectrum(modulation: &Modulation) -> (f64, Vec<Complex64>) {
    let Some(period) = modulation.period().map(|period| period.min(LONGEST)) else {
        return (1.0, vec![Complex64::ONE]);
    };
    let [least, most] = SAMPLES;
    let count = ((period * modulation.step_rate()) as usize).clamp(least, most).next_power_of_two();
    // In the middle of each sample, so that no edge is hit.
    let at = |index: usize| modulation.envelope((index as f64 + 0.5) / count as f64 * period);
    let mut lines = coefficients((0..count).map(|index| Complex64::from(at(index))).collect());
    for (index, line) in lines.iter_mut().enumerate() {
        *line *= Complex64::from_polar(1.0, -TAU / 2.0 * frequency(index, count, 1.0) / count as f64);
    }
    (period.recip(), lines)
}

/// Frequencies (Hz) of an envelope's amplitude with their parts of its mean square, close ones as one.
fn powers(modulation: &Modulation) -> Vec<[f64; 2]> {
    if modulation.shape == Envelope::Off {
        return vec![[0.0, 1.0]];
    }
    let (spacing, lines) = spectrum(modulation);
    let count = lines.len();
    let mut powers: Vec<_> =
        (0..count).map(|index| [frequency(index, count, spacing), lines[index].norm_sqr()]).collect();
    let all: f64 = powers.iter().map(|[_, power]| power).sum();
    powers.retain(|[_, power]| *power > LEAST * all);
    powers.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut bins: Vec<[f64; 2]> = Vec::new();
    let mut first = f64::NEG_INFINITY;
    for [line, power] in powers {
        match bins.last_mut() {
            Some([mean, sum]) if line - first < BIN.max(BIN_PART * line.abs()) => {
                *mean = (*mean * *sum + line * power) / (*sum + power);
                *sum += power;
            }
            Some(_) | None => {
                bins.push([line, power]);
                first = line;
            }
        }
    }
    let all: f64 = bins.iter().map(|[_, power]| power).sum();
    bins.iter_mut().for_each(|[_, power]| *power /= all);
    bins
}

/// Frames per second of a scene's motion, or of its drives in turn.
pub fn frames_per_second(scene: &Scene) -> f64 {
    motion::cycle(scene).map_or(TURNS, |cycle| cycle.frames_per_second())
}

/// The weights of a cycle's drives: of itself, and of its predecessors.
struct Weights(Vec<(usize, Complex64)>);

impl Weights {
    /// `None` if the elements follow at once.
    fn new(scene: &Scene, count: usize, is_slow: bool) -> Option<Self> {
        let resonator = Resonator::new(scene)?;
        let span = frames_per_second(scene).recip();
        let steady = resonator.decay(span, 0.0);
        let envelope = if is_slow { powers(scene.envelope()) } else { vec![[0.0, 1.0]] };
        let decays: Vec<_> =
            envelope.into_iter().map(|[line, power]| (resonator.decay(span, line), power)).collect();
        let harmonic = |k: usize| {
            let z = Complex64::from_polar(1.0, TAU * k as f64 / count as f64);
            let square: f64 = decays.iter().map(|(decay, power)| power * decay.of(z).1).sum();
            Complex64::from_polar(square.max(0.0).sqrt(), steady.of(z).0.arg())
        };
        let weights = coefficients((0..count).map(harmonic).collect());
        // These are the coefficients of e^{-…}: of the predecessors counted backwards.
        let weights = weights.into_iter().enumerate();
        let behind = weights.map(|(index, weight)| ((count - index) % count, weight));
        let mut all: Vec<_> = behind.filter(|(_, weight)| weight.norm() > LEAST).collect();
        all.sort_by_key(|(behind, _)| *behind);
        Some(Self(all))
    }

    /// The drive in the place of one in the cycle, from those that it consists of.
    fn drive<U: AsRef<[Complex64]>>(&self, count: usize, index: usize, u: impl Fn(usize) -> U) -> Drive {
        let mut sum: Vec<Complex64> = Vec::new();
        for &(behind, weight) in &self.0 {
            let u = u((index + count - behind) % count);
            sum.resize(u.as_ref().len(), Complex64::ZERO);
            sum.iter_mut().zip(u.as_ref()).for_each(|(sum, u)| *sum += weight * u);
        }
        // No overflow guard as in `hypot`: all values are about 1.
        Drive {
            amplitudes: sum.iter().map(|u| u.norm_sqr().sqrt()).collect(),
            phases: sum.iter().map(|u| u.arg()).collect(),
        }
    }
}

/// u of every element.
fn phasors(drive: &Drive) -> Vec<Complex64> {
    let values = drive.amplitudes.iter().zip(&drive.phases);
    values.map(|(amplitude, phase)| Complex64::from_polar(*amplitude, *phase)).collect()
}

/// Drives in turn whose sound has, without a response, the means of a cycle of `drives` with the scene's response; for slow quantities
/// under the scene's envelope, relative to its mean square. The same drives without a response.
pub fn responding(scene: &Scene, drives: Vec<Drive>, is_slow: bool) -> Vec<Drive> {
    match Weights::new(scene, drives.len(), is_slow) {
        Some(weights) if is_alike(&drives) => {
            let all: Vec<_> = drives.par_iter().map(phasors).collect();
            let drive = |index| weights.drive(all.len(), index, |part| &all[part]);
            (0..all.len()).into_par_iter().map(drive).collect()
        }
        Some(_) | None => drives,
    }
}

/// One of the drives of [`responding`], of a quantity that is not slow.
pub fn responding_at(scene: &Scene, drives: &[Drive], index: usize) -> Drive {
    match Weights::new(scene, drives.len(), false) {
        Some(weights) if is_alike(drives) => {
            weights.drive(drives.len(), index, |part| phasors(&drives[part]))
        }
        Some(_) | None => drives[index].clone(),
    }
}

/// Whether all drives are of one array.
fn is_alike(drives: &[Drive]) -> bool {
    drives.iter().all(|drive| {
        [&drive.amplitudes, &drive.phases].iter().all(|values| values.len() == drives[0].phases.len())
    })
}
