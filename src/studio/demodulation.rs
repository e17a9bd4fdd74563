//! Self-demodulation: the audible sound of a modulated beam, far away on its axis.
//!
//! Sound of the amplitude p₀E(t) makes sound of its own, since it travels faster where its pressure is high: Westervelt's virtual
//! source, q = β/(ρ²c⁴) ∂|p|²/∂t per volume with |p|² the mean over a period of the carrier, p₀²E²/2. A beam of the area A and
//! the absorption α (Np/m) is a line of such sources, ∫e^{-2αs}ds = 1/(2α) long, all in step on its axis. At the distance z they
//! add up to Berktay's far field (J. Sound Vib. 2:435, 1965),
//!
//! ```text
//! p = ρ/(4πz) A/(2α) ∂q/∂t = β p₀² A/(16π ρc⁴ α z) d²E²/dt² = β W/(8π c³ α z) d²E²/dt²,    W = p₀²A/(2ρc)
//! ```
//!
//! W is the power of the elements by themselves ([`power`]). A line of E² at ω with the amplitude M is heard with the peak pressure
//! β W ω² M/(8π c³ α z): 12 dB more per octave. The envelope 1 - d/2 + d/2 sin has the lines d(1 - d/2) and d²/8, so that its
//! second harmonic is d/(2 - d) of the first; `law = "power"`, whose E² is the shape, has none. Elements with a response filter E
//! before it is squared, the square root's overtones more than its tone, and bring distortion back.
//!
//! Levels are stated at 1 m and fall by 6 dB per doubled distance: the sound of an array a few metres long (1/2α), heard
//! beyond it. Closer, less of the beam is heard ([`nonlinear`](crate::studio::nonlinear) follows it to any listener). Loud primary
//! sound loses power to its harmonics, so that levels are estimates to some 6 dB, and upper ones of beams far beyond linear theory.

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::course::square_lines;
use crate::acoustics::response::Resonator;
use crate::acoustics::{Air, Aperture};
use crate::field::harmonic::NONLINEARITY;
use crate::rounding::percent;
use crate::scene::{Envelope, Modulation, Scene, SpectralLine};
use crate::solver::{Solution, parts};

/// m; the distance of the levels.
const DISTANCE: f64 = 1.0;
/// Pa; 0 dB of a sound pressure level.
pub const AUDIBLE: f64 = 20e-6;
/// Hz; beyond, nobody hears a line.
const HIGHEST: f64 = 20_000.0;
/// Hz; modulations below are felt rather than heard.
const LOWEST: f64 = 100.0;
/// Lines of an envelope that count, and are named.
const MOST_LINES: usize = 64;
const MOST_NAMED: usize = 16;
/// dB below the loudest line, down to which lines are named.
const NAMED: f64 = 60.0;

/// What is heard of a modulation on the axis of its beam, referred to 1 m.
#[derive(Clone, Debug, PartialEq)]
pub struct Demodulated {
    /// The loudest lines: Hz, and dB re 20 µPa, in order of frequency.
    pub lines: Vec<[f64; 2]>,
    /// dB(A), of all lines together.
    pub weighted: f64,
    /// Pressure of the lines that no shape has over those that it has, of the worst envelope: for a sine the second harmonic over
    /// the first. `None` with a waveform from a file.
    pub distortion: Option<f64>,
}

impl Demodulated {
    /// Of the solution of a scene; `None` without lines from 100 Hz to 20 kHz, or in air without absorption, in which no beam ends.
    pub fn new(scene: &Scene, aperture: &Aperture, solution: &Solution) -> Option<Self> {
        let air = Air::new(&scene.medium, scene.array.frequency);
        let drives = solution.drives();
        let mut all: Vec<[f64; 2]> = Vec::new();
        let (mut distortion, mut lowest) = (Some(0.0f64), f64::INFINITY);
        for (modulation, squares) in parts::powers(scene, aperture, &drives, &solution.foci) {
            if modulation.is_steady() || air.attenuation <= 0.0 {
                continue;
            }
            let power = power_of(aperture, &air, squares);
            let lines = lines(scene, modulation);
            let heard = |line: &SpectralLine| [line.frequency, far_field(&air, power, line) / SQRT_2];
            let own: Vec<_> = lines.iter().map(heard).filter(|[_, rms]| *rms > 0.0).collect();
            distortion = distortion.zip(part_not_in(modulation, &own)).map(|(a, b)| a.max(b));
            lowest = own.iter().map(|line| line[0]).fold(lowest, f64::min);
            all.extend(own);
        }
        let loudest = all.iter().map(|line| line[1]).fold(0.0, f64::max);
        if !(loudest > 0.0 && all.iter().any(|line| line[0] >= LOWEST)) {
            return None;
        }
        let level = |rms: f64| 20.0 * (rms / AUDIBLE).log10();
        let weighted = all.iter().map(|[f, rms]| (rms * a_weight(*f)).powi(2)).sum::<f64>().sqrt();
        all.sort_by(|a, b| b[1].total_cmp(&a[1]));
        all.truncate(MOST_NAMED);
        all.retain(|[_, rms]| level(*rms) > level(loudest) - NAMED);
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let lines = all.into_iter().map(|[frequency, rms]| [frequency, level(rms)]).collect();
        Some(Self { lines, weighted: level(weighted), distortion })
    }

    /// Frequency (Hz) and level of the loudest line.
    fn loudest(&self) -> [f64; 2] {
        self.lines.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap_or_default()
    }

    /// Level and distortion, as text.
    pub fn words(&self) -> String {
        let [frequency, level] = self.loudest();
        let distortion =
            self.distortion.map_or(String::new(), |part| format!(", {} distortion", percent(part)));
        format!("{:.0} dB(A), mostly {frequency:.0} Hz ({level:.0} dB re 20 µPa){distortion}", self.weighted)
    }

    /// The object that programs know.
    pub fn json(&self) -> serde_json::Value {
        let of = |index: usize| self.lines.iter().map(|line| line[index]).collect::<Vec<_>>();
        serde_json::json!({
            "distance": DISTANCE,
            "frequencies": of(0),
            "levels": of(1),
            "level_a": self.weighted,
            "distortion": self.distortion,
        })
    }
}

/// Peak pressure (Pa) at 1 m of a line of E² from a beam of this power (W).
fn far_field(air: &Air, power: f64, line: &SpectralLine) -> f64 {
    let omega = TAU * line.frequency;
    NONLINEARITY * power * omega.powi(2) * line.amplitude
        / (8.0 * PI * air.sound_speed.powi(3) * air.attenuation * DISTANCE)
}

/// The pressure of lines at frequencies that a shape does not have, over that at its own; `None` of a file whose square is heard.
fn part_not_in(modulation: &Modulation, heard: &[[f64; 2]]) -> Option<f64> {
    let is_near = |line: f64, own: f64| (line - own).abs() < 1e-3;
    let is_own = |line: f64| match modulation.shape {
        Envelope::Off | Envelope::File => false,
        Envelope::Sine => is_near(line, modulation.frequency),
        Envelope::Square => {
            let half = (line / modulation.frequency - 1.0) / 2.0;
            is_near(line, (2.0 * half.round() + 1.0) * modulation.frequency)
        }
        Envelope::Tones => modulation.tones.iter().any(|tone| is_near(line, tone.frequency)),
    };
    let power = |is_wanted: bool| {
        let same = heard.iter().filter(|line| is_own(line[0]) == is_wanted);
        same.map(|line| line[1].powi(2)).sum::<f64>()
    };
    let [own, others] = [true, false].map(power);
    (own > 0.0).then(|| (others / own).sqrt())
}

/// The audible lines of a modulation's square, behind the elements' response; of many, the loudest of groups of neighbours.
pub fn lines(scene: &Scene, modulation: &Modulation) -> Vec<SpectralLine> {
    let mut lines = match Resonator::new(scene) {
        None => square_lines(modulation, HIGHEST),
        Some(resonator) => resonator.square_lines(modulation),
    };
    lines.retain(|line| line.frequency > 0.0 && line.frequency <= HIGHEST && line.amplitude > 0.0);
    if lines.len() <= MOST_LINES {
        return lines;
    }
    // Neighbours are heard together: their powers add up at the frequency that has most of it.
    lines.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    let lowest = lines[0].frequency;
    let width = (HIGHEST / lowest).ln() / MOST_LINES as f64;
    let group = |line: &SpectralLine| ((line.frequency / lowest).ln() / width) as usize;
    let heard = |line: &SpectralLine| line.amplitude * line.frequency.powi(2);
    let together = |same: &[SpectralLine]| {
        let loudest = same.iter().copied().max_by(|a, b| heard(a).total_cmp(&heard(b))).unwrap_or(same[0]);
        let all = same.iter().map(|line| heard(line).powi(2)).sum::<f64>().sqrt();
        SpectralLine { amplitude: all / loudest.frequency.powi(2), ..loudest }
    };
    lines.chunk_by(|a, b| group(a) == group(b)).map(together).collect()
}

/// Acoustic power (W) of elements that each radiate by themselves: S²/(2ρc) ∫ D² dΩ over the half-space.
pub fn power(aperture: &Aperture, air: &Air, u: &[Complex64]) -> f64 {
    power_of(aperture, air, u.iter().map(|u| u.norm_sqr()).sum())
}

/// The same of elements with this Σ|u|².
fn power_of(aperture: &Aperture, air: &Air, squares: f64) -> f64 {
    const STEPS: usize = 256;
    const SPOKES: usize = 32;
    let element = &aperture.element;
    let ring = |i: usize| {
        let (sin, cos) = (PI / 2.0 * (i as f64 + 0.5) / STEPS as f64).sin_cos();
        let spoke = |spoke: usize| {
            let round = TAU * (spoke as f64 + 0.5) / SPOKES as f64;
            let towards = DVec3::new(sin * round.cos(), sin * round.sin(), cos);
            element.loudness(towards, DVec3::Z, DVec3::X).powi(2)
        };
        (0..SPOKES).map(spoke).sum::<f64>() / SPOKES as f64 * sin
    };
    let solid = TAU * (0..STEPS).map(ring).sum::<f64>() * PI / 2.0 / STEPS as f64;
    squares * element.strength.powi(2) * solid / (2.0 * air.density * air.sound_speed)
}

/// A-weighting of IEC 61672 as a factor, 1 at 1 kHz.
pub fn a_weight(frequency: f64) -> f64 {
    let response = |f: f64| {
        let f2 = f * f;
        12_194f64.powi(2) * f2 * f2
            / ((f2 + 20.6f64.powi(2))
                * ((f2 + 107.7f64.powi(2)) * (f2 + 737.9f64.powi(2))).sqrt()
                * (f2 + 12_194f64.powi(2)))
    };
    response(frequency) / response(1000.0)
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::scene::{Law, Pole, Response, Shape, Target, Tone};
    use crate::solver;

    fn heard(scene: &Scene) -> Demodulated {
        Demodulated::new(scene, &Aperture::new(scene), &solver::solve(scene).unwrap()).unwrap()
    }

    fn scene(modulation: Modulation) -> Scene {
        let target = Target::new(Shape::Point { at: DVec3::Z });
        Scene { targets: vec![target], modulation, ..Scene::default() }
    }

    #[test]
    fn a_tone_is_as_loud_and_as_distorted_as_in_closed_form() {
        let sine = |frequency, depth| Modulation {
            shape: Envelope::Sine,
            frequency,
            depth,
            ..Modulation::default()
        };
        for depth in [1.0, 0.5] {
            let found = heard(&scene(sine(2000.0, depth)));
            let [[first, level], [second, harmonic]] = found.lines[..] else { panic!("{found:?}") };
            assert!((first, second) == (2000.0, 4000.0), "{found:?}");
            let distortion = depth / (2.0 - depth);
            assert!((found.distortion.unwrap() - distortion).abs() < 1e-9, "{found:?}");
            assert!((harmonic - level - 20.0 * distortion.log10()).abs() < 1e-9, "{found:?}");
            // Berktay's formula in numpy for 256 default elements at 20 °C: 97.025 dB of a full sine.
            let lines = depth * (1.0 - depth / 2.0) / 0.5;
            assert!((level - 97.025 - 20.0 * lines.log10()).abs() < 0.02, "{found:?}");
        }
        let octave =
            heard(&scene(sine(4000.0, 1.0))).lines[0][1] - heard(&scene(sine(2000.0, 1.0))).lines[0][1];
        assert!((octave - 40.0 * 2f64.log10()).abs() < 1e-9, "{octave}");
    }

    #[test]
    fn power_is_heard_without_distortion_unless_elements_are_slow() {
        let of = |law, response| {
            let modulation =
                Modulation { shape: Envelope::Sine, frequency: 1000.0, law, ..Modulation::default() };
            let mut scene = scene(modulation);
            scene.array.response = response;
            heard(&scene)
        };
        let pole = Some(Response::Pole(Pole { resonance: 40e3, tau: 1.88e-4 }));
        let [clean, slow] = [None, pole].map(|response| of(Law::Power, response));
        assert!(clean.lines.len() == 1 && clean.distortion.unwrap() < 1e-9, "{clean:?}");
        assert!(slow.distortion.unwrap() > 0.02, "{slow:?}");
        // One pole leaves 1/√(1 + (2πfτ)²) of the amplitude's line, which is beside the mean of it.
        let [fast, damped] = [None, pole].map(|response| of(Law::Amplitude, response).lines[0][1]);
        let left = -10.0 * (1.0 + (TAU * 1000.0 * 1.88e-4f64).powi(2)).log10();
        assert!((damped - fast - left).abs() < 0.01, "{fast} {damped} {left}");
    }

    #[test]
    fn tones_and_own_modulations_are_heard_each() {
        let tone = |frequency| Tone { frequency, depth: 0.5, phase: 0.0 };
        let tones = vec![tone(500.0), tone(700.0)];
        let law = Law::Power;
        let modulation = Modulation { shape: Envelope::Tones, tones, law, ..Modulation::default() };
        let both = heard(&scene(modulation.clone()));
        assert_eq!(both.lines.iter().map(|line| line[0]).collect::<Vec<_>>(), [500.0, 700.0]);
        let mut own = scene(Modulation::default());
        own.targets.push(Target::new(Shape::Point { at: DVec3::new(0.3, 0.0, 1.0) }));
        for (target, frequency) in own.targets.iter_mut().zip([500.0, 700.0]) {
            let shape = Envelope::Sine;
            target.modulation = Some(Modulation { shape, frequency, law, ..Modulation::default() });
        }
        let each = heard(&own);
        for (a, b) in both.lines.iter().zip(&each.lines) {
            // Each has half of the swing, or half of the power with all of it.
            assert!(a[0] == b[0] && (a[1] - b[1]).abs() < 2.0, "{both:?} {each:?}");
        }
    }

    #[test]
    fn a_weighting_is_that_of_the_standard() {
        for (frequency, decibels) in [(100.0, -19.1), (200.0, -10.9), (1000.0, 0.0), (4000.0, 1.0)] {
            let own = 20.0 * a_weight(frequency).log10();
            assert!((own - decibels).abs() < 0.15, "{frequency}: {own}");
        }
    }
}
