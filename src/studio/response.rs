//! What a motion loses because elements need time to follow their drives: pressure, dips between frames, and the noise of the steps.
//!
//! Within a frame the sound at its foci is p(t) = p + m e^{-st}, p the steady pressure and m what is still missing at its
//! beginning ([`Resonator::missing`]). Its mean square is a closed form. The foci are those of the path itself, also of a
//! motion with `lead`.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;
use serde_json::{Value, json};
use sonoglyph_fourier::coefficients;

use crate::acoustics::Aperture;
use crate::acoustics::response::{Resonator, frames_per_second};
use crate::rounding::percent;
use crate::scene::{Focus, Scene, motion};
use crate::solver::frames::Sequence;

/// rad: larger mean phase changes per frame cost more than a tenth of the pressure between frames at 6 m/s.
pub const COARSE: f64 = 9.0 * TAU / 360.0;
/// Moments of a frame at which the dip is looked for, and their span in time constants: then nothing is missing.
const MOMENTS: u32 = 64;
const SPAN: f64 = 12.0;
/// Samples per second for the noise, Hz, and their limit in a cycle.
const SAMPLING: f64 = 96e3;
const MOST_SAMPLES: usize = 1 << 20;
/// Audible frequencies, Hz.
const AUDIBLE: f64 = 20e3;

/// Figures of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// RMS pressure at the foci, relative to foci at rest.
    pub kept: f64,
    /// Least momentary pressure at a focus, relative to the focus at rest.
    pub dip: f64,
    /// The frame of the dip, from 0.
    pub frame: usize,
    /// Mean phase change per frame of all driven elements, rad.
    pub step: f64,
    /// A-weighted RMS of the changes of |p|² at the foci over its mean, dB; `None` if nothing changes.
    pub noise: Option<f64>,
}

impl Moving {
    /// `None` without a response, without foci, or for a single frame.
    pub fn new(scene: &Scene, sequence: &Sequence) -> Option<Self> {
        let resonator = Resonator::new(scene)?;
        let frames = &sequence.frames;
        if frames.len() < 2 || frames.iter().any(|frame| frame.foci.is_empty()) {
            return None;
        }
        let aperture = Aperture::new(scene);
        let span = frames_per_second(scene).recip();
        let drives: Vec<_> = frames.iter().map(|frame| frame.drive.excitation(&aperture.driven)).collect();
        let missing = resonator.missing(&drives, span);
        let places = places(scene, sequence);
        let of_frame = |index: usize| {
            let transfer = aperture.transfer_to(&places[index]);
            let at_rest = frames[index].pressures.iter().map(|p| p.norm());
            let [steady, missing] = [&drives[index], &missing[index]].map(|u| transfer.pressure(u));
            let foci = steady.into_iter().zip(missing).zip(at_rest);
            foci.map(|((steady, missing), at_rest)| Passage { steady, missing, at_rest }).collect::<Vec<_>>()
        };
        let passages: Vec<_> = (0..frames.len()).into_par_iter().map(of_frame).collect();
        let pole = resonator.pole;
        let all = || passages.iter().flatten();
        let reference: f64 = all().map(|passage| passage.at_rest.powi(2)).sum();
        let square: f64 = all().map(|passage| passage.mean_square(pole, span)).sum();
        if reference == 0.0 {
            return None;
        }
        let dip = |passages: &Vec<Passage>| {
            passages.iter().map(|passage| passage.dip(pole, span)).fold(f64::INFINITY, f64::min)
        };
        let dips = passages.par_iter().map(dip).enumerate();
        let (frame, dip) = dips.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Self {
            kept: (square / reference).sqrt(),
            dip,
            frame,
            step: mean_step(sequence, &aperture.driven),
            noise: noise(&passages, pole, span),
        })
    }

    pub fn json(&self) -> Value {
        json!({
            "kept": self.kept,
            "dip": self.dip,
            "dip_frame": self.frame,
            "mean_phase_step": self.step,
            "step_noise": self.noise,
        })
    }

    /// Whether more frames would keep more between them.
    pub fn is_coarse(&self) -> bool {
        self.step > COARSE
    }

    /// Labels and values, a row each.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let degrees = |angle: f64| format!("{:.1}°", angle * 360.0 / TAU);
        let advice = match self.is_coarse() {
            true => format!("more than the {} that keep dips shallow: take more frames", degrees(COARSE)),
            false => format!("at most {}: fine enough", degrees(COARSE)),
        };
        let mut rows = vec![
            ("pressure kept", format!("{} of that at rest, RMS at the moving foci", percent(self.kept))),
            ("deepest dip", format!("to {} of it, in frame {}", percent(self.dip), self.frame + 1)),
            ("mean phase step", format!("{} per frame, {advice}", degrees(self.step))),
        ];
        if let Some(noise) = self.noise {
            rows.push(("step noise", format!("{noise:.0} dB(A), changes of |p|² at the foci over its mean")));
        }
        rows
    }
}

/// The foci of every frame on their path.
fn places(scene: &Scene, sequence: &Sequence) -> Vec<Vec<Focus>> {
    let played = || sequence.frames.iter().map(|frame| frame.foci.clone()).collect();
    let motions = scene.targets.iter().filter_map(|target| target.motion.as_ref());
    if !std::iter::once(&scene.motion).chain(motions).any(|motion| motion.lead) {
        return played();
    }
    let mut path = scene.clone();
    path.motion.lead = false;
    path.targets
        .iter_mut()
        .filter_map(|target| target.motion.as_mut())
        .for_each(|motion| motion.lead = false);
    let is_same = |places: &Vec<Vec<Focus>>| {
        let counts = |places: &[Vec<Focus>]| places.iter().map(Vec::len).collect::<Vec<_>>();
        counts(places) == counts(&played())
    };
    motion::frames(&path).ok().filter(is_same).unwrap_or_else(played)
}

/// The pressure at a focus during a frame.
struct Passage {
    /// Pa
    steady: Complex64,
    /// Pa, at the beginning.
    missing: Complex64,
    /// Pa, of the focus at rest.
    at_rest: f64,
}

impl Passage {
    fn square(&self, pole: Complex64, time: f64) -> f64 {
        (self.steady + self.missing * (-pole * time).exp()).norm_sqr()
    }

    /// Over the frame, Pa².
    fn mean_square(&self, pole: Complex64, span: f64) -> f64 {
        let mean = |rate: Complex64| (1.0 - (-rate * span).exp()) / (rate * span);
        self.steady.norm_sqr()
            + 2.0 * (self.steady.conj() * self.missing * mean(pole)).re
            + self.missing.norm_sqr() * mean(Complex64::from(2.0 * pole.re)).re
    }

    /// The least |p| of the frame over that at rest.
    fn dip(&self, pole: Complex64, span: f64) -> f64 {
        if self.at_rest == 0.0 {
            return f64::INFINITY;
        }
        let step = span.min(SPAN / pole.re) / f64::from(MOMENTS);
        let square = |moment: f64| self.square(pole, moment * step);
        let moments = (0..=MOMENTS).map(f64::from);
        let best = moments.min_by(|a, b| square(*a).total_cmp(&square(*b))).unwrap_or(0.0);
        // Between its neighbours the square has one minimum.
        let (mut low, mut high) = ((best - 1.0).max(0.0), (best + 1.0).min(f64::from(MOMENTS)));
        for _ in 0..MOMENTS {
            let [a, b] = [1.0 / 3.0, 2.0 / 3.0].map(|part| low + part * (high - low));
            if square(a) < square(b) { high = b } else { low = a }
        }
        square(low).min(square(high)).sqrt() / self.at_rest
    }
}

/// rad
fn mean_step(sequence: &Sequence, driven: &[usize]) -> f64 {
    let frames = &sequence.frames;
    let before = frames.iter().cycle().skip(frames.len() - 1);
    let step = |(from, to): (f64, f64)| {
        let apart = (to - from).rem_euclid(TAU);
        apart.min(TAU - apart)
    };
    let pairs = before
        .zip(frames)
        .flat_map(|(from, to)| driven.iter().map(|&n| (from.drive.phases[n], to.drive.phases[n])));
    pairs.map(step).sum::<f64>() / (frames.len() * driven.len().max(1)) as f64
}

/// The A-weighted changes of Σ|p|² at the foci, over its mean, dB.
fn noise(passages: &[Vec<Passage>], pole: Complex64, span: f64) -> Option<f64> {
    /// Nothing but rounding, relative.
    const SILENT: f64 = 1e-9;
    let per_frame = ((span * SAMPLING).ceil() as usize).max(2);
    let count = passages.len() * per_frame;
    if count > MOST_SAMPLES {
        return None;
    }
    let sample = |index: usize| {
        let time = (index % per_frame) as f64 * span / per_frame as f64;
        passages[index / per_frame].iter().map(|passage| passage.square(pole, time)).sum::<f64>()
    };
    let squares: Vec<_> = (0..count).into_par_iter().map(|index| Complex64::from(sample(index))).collect();
    let lines = coefficients(squares);
    let cycle = 1.0 / (span * passages.len() as f64);
    let audible = ((AUDIBLE / cycle) as usize).min(count.div_ceil(2) - 1);
    let weighted = |k: usize| 2.0 * (lines[k].norm() * a_weight(k as f64 * cycle)).powi(2);
    let ratio = (1..=audible).map(weighted).sum::<f64>().sqrt() / lines[0].re;
    (ratio > SILENT).then(|| 20.0 * ratio.log10())
}

/// The A-weighting of IEC 61672, as a factor, 1 at 1 kHz.
fn a_weight(frequency: f64) -> f64 {
    const AT_1_KHZ: f64 = 0.794_346_7;
    let f = frequency.powi(2);
    let corner = |hertz: f64| f + hertz * hertz;
    let slopes = (corner(107.7) * corner(737.9)).sqrt();
    12194.0_f64.powi(2) * f * f / (corner(20.6) * slopes * corner(12194.0)) / AT_1_KHZ
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weighting_is_that_of_the_standard() {
        for (frequency, level) in
            [(31.62, -39.4), (100.0, -19.1), (1000.0, 0.0), (2512.0, 1.3), (10_000.0, -2.5)]
        {
            let found = 20.0 * a_weight(frequency).log10();
            assert!((found - level).abs() < 0.06, "{frequency} Hz: {found} dB");
        }
    }
}
