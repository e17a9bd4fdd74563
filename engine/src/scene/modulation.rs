//! Amplitude modulation: the envelope of the drive over time.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::solver::is_zero;
use crate::scene::wave::Wave;

/// Tones that a modulation may have.
pub const MOST_TONES: usize = 16;
/// Hz, of the slowest modulation.
const SLOWEST: f64 = 1.0;
/// Limit of a common period, s.
pub(crate) const LONGEST: f64 = 10.0;
/// Hz: the common frequency of tones is looked for among multiples of this.
const GRAIN: f64 = 1e-6;
/// Time steps of an envelope's shortest period that follow it closely.
const STEPS_PER_PERIOD: f64 = 64.0;

/// The envelope of the drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Modulation {
    pub shape: Envelope,
    #[serde(skip_serializing_if = "is_amplitude")]
    pub law: Law,
    /// Hz, of a sine and a square wave.
    pub frequency: f64,
    /// Depth of a sine, a square wave and a file. 0: none; 1: down to silence.
    pub depth: f64,
    /// The tones of `shape = "tones"`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tones: Vec<Tone>,
    /// The waveform (WAV) that `shape = "file"` repeats, relative to the scene's file.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// The waveform of the file, once loaded.
    #[serde(skip)]
    pub wave: Wave,
}

impl Default for Modulation {
    fn default() -> Self {
        Self {
            shape: Envelope::Off,
            law: Law::Amplitude,
            frequency: 200.0,
            depth: 1.0,
            tones: Vec::new(),
            file: String::new(),
            wave: Wave::default(),
        }
    }
}

/// One of the tones that swing together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tone {
    /// Hz
    pub frequency: f64,
    /// Its part of the whole swing.
    pub depth: f64,
    /// rad, of a sine.
    #[serde(skip_serializing_if = "is_zero")]
    pub phase: f64,
}

impl Default for Tone {
    fn default() -> Self {
        Self { frequency: 200.0, depth: 1.0, phase: 0.0 }
    }
}

/// A spectral line: amplitude · cos(2π frequency t + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// Hz
    pub frequency: f64,
    /// Amplitude in the unit of the spectrum's quantity; at 0 Hz its mean.
    pub amplitude: f64,
    /// rad, in (-π, π].
    pub phase: f64,
}

impl SpectralLine {
    /// Its value at a time (s).
    #[doc(hidden)]
    pub fn at(&self, time: f64) -> f64 {
        self.amplitude * (TAU * (self.frequency * time).fract() + self.phase).cos()
    }
}

/// The modulated quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Law {
    /// The amplitude of the sound.
    #[default]
    Amplitude,
    /// Its square, and with it the radiation pressure.
    Power,
}

/// Frequencies (Hz) of the modulations of a carrier (Hz): beyond its half no period of the carrier follows the envelope.
pub fn frequencies(carrier: f64) -> RangeInclusive<f64> {
    SLOWEST..=carrier / 2.0
}

/// The shortest common multiple of two periods (s), at most 10 s unless one of them is it.
pub(crate) fn common(a: f64, b: f64) -> Option<f64> {
    /// Relative.
    const APART: f64 = 1e-9;
    let (long, short) = (a.max(b), a.min(b));
    let is_whole = |count: &f64| {
        let times = count * long / short;
        (times - times.round()).abs() < APART * times
    };
    let most = (LONGEST / long).floor().max(1.0) as u32;
    (1..=most).map(f64::from).find(is_whole).map(|count| count * long)
}

fn is_amplitude(law: &Law) -> bool {
    *law == Law::Amplitude
}

impl Modulation {
    /// The factor on the drive's amplitude at a time (s), 0 to 1.
    pub fn envelope(&self, time: f64) -> f64 {
        let swing = self.swing(time);
        match self.law {
            Law::Amplitude => swing,
            Law::Power => swing.sqrt(),
        }
    }

    /// The shape itself at a time (s), 1 - depth to 1.
    pub fn swing(&self, time: f64) -> f64 {
        let swing = match self.shape {
            Envelope::Off => 1.0,
            Envelope::Sine => 1.0 - self.depth * (1.0 - (TAU * (self.frequency * time).fract()).sin()) / 2.0,
            Envelope::Square if (self.frequency * time).rem_euclid(1.0) < 0.5 => 1.0,
            Envelope::Square => 1.0 - self.depth,
            Envelope::Tones => 1.0 - self.tones.iter().map(|tone| tone.dip(time)).sum::<f64>(),
            Envelope::File => 1.0 - self.depth * (1.0 - self.wave.at(time)) / 2.0,
        };
        swing.clamp(0.0, 1.0)
    }

    /// The mean square of the envelope: the mean radiation pressure relative to that of steady sound.
    pub fn mean_square(&self) -> f64 {
        let [mean, mean_square] = self.means();
        match self.law {
            Law::Amplitude => mean_square,
            Law::Power => mean,
        }
    }

    /// The means of the swing and of its square.
    fn means(&self) -> [f64; 2] {
        // The swing is 1 - d/2 + x d/2, and these are the means of x and x².
        let of = |[mean, mean_square]: [f64; 2]| {
            let (middle, half) = (1.0 - self.depth / 2.0, self.depth / 2.0);
            [middle + half * mean, middle.powi(2) + 2.0 * middle * half * mean + half.powi(2) * mean_square]
        };
        match self.shape {
            Envelope::Off => [1.0; 2],
            Envelope::Sine => of([0.0, 0.5]),
            Envelope::Square => of([0.0, 1.0]),
            Envelope::File => of(self.wave.means()),
            Envelope::Tones => {
                let middle = 1.0 - self.tones.iter().map(|tone| tone.depth).sum::<f64>() / 2.0;
                [middle, middle.powi(2) + self.squares_by_frequency().sum::<f64>() / 8.0]
            }
        }
    }

    /// For every frequency, the squared modulus of the sum of depth · e^{j phase} over its tones.
    fn squares_by_frequency(&self) -> impl Iterator<Item = f64> {
        let mut tones = self.tones.clone();
        tones.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        let square = |same: &[Tone]| {
            let part =
                |part: fn(f64) -> f64| same.iter().map(|tone| tone.depth * part(tone.phase)).sum::<f64>();
            part(f64::cos).powi(2) + part(f64::sin).powi(2)
        };
        let squares: Vec<_> = tones.chunk_by(|a, b| a.frequency == b.frequency).map(square).collect();
        squares.into_iter()
    }

    /// Period of the envelope (s); `None` if it is steady. Tones are rounded to multiples of 1 µHz.
    pub fn period(&self) -> Option<f64> {
        match self.shape {
            Envelope::Off => None,
            Envelope::Sine | Envelope::Square => Some(1.0 / self.frequency),
            Envelope::File => self.wave.get().map(|samples| samples.period()),
            Envelope::Tones => {
                let grains = |tone: &Tone| (tone.frequency / GRAIN).round() as u64;
                let common = self.tones.iter().map(grains).reduce(divisor).filter(|common| *common > 0)?;
                Some(1.0 / (common as f64 * GRAIN))
            }
        }
    }

    /// Rate of time steps that resolve the envelope, Hz; 0 if it is steady.
    pub fn step_rate(&self) -> f64 {
        match self.shape {
            Envelope::Off | Envelope::Sine | Envelope::Square | Envelope::Tones => {
                STEPS_PER_PERIOD * self.fastest()
            }
            Envelope::File => self.wave.get().map_or(0.0, |samples| samples.rate),
        }
    }

    /// Whether the envelopes are the same.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self == other || (self.is_steady() && other.is_steady())
    }

    /// Whether the envelope is always full.
    #[doc(hidden)]
    pub fn is_steady(&self) -> bool {
        match self.shape {
            Envelope::Off => true,
            Envelope::Sine | Envelope::Square | Envelope::File => self.depth == 0.0,
            Envelope::Tones => self.tones.iter().all(|tone| tone.depth == 0.0),
        }
    }

    /// The highest frequency (Hz) that the shape names; 0 of steady sound, and of a file.
    #[doc(hidden)]
    pub fn fastest(&self) -> f64 {
        match self.shape {
            Envelope::Off | Envelope::File => 0.0,
            Envelope::Sine | Envelope::Square => self.frequency,
            Envelope::Tones => self.tones.iter().map(|tone| tone.frequency).fold(0.0, f64::max),
        }
    }

    /// Whether a named waveform is not yet loaded.
    pub fn lacks_wave(&self) -> bool {
        !self.file.is_empty() && self.wave.get().is_none()
    }
}

impl Tone {
    /// Its distance from the maximum at a time (s).
    fn dip(&self, time: f64) -> f64 {
        self.depth * (1.0 - (TAU * (self.frequency * time).fract() + self.phase).sin()) / 2.0
    }
}

/// The greatest common one.
fn divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { divisor(b, a % b) }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Envelope {
    Off,
    Sine,
    Square,
    /// Several sines.
    Tones,
    /// A waveform from a file.
    File,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::wave::Waveform;

    fn modulations() -> Vec<Modulation> {
        let tone = |frequency, depth, phase| Tone { frequency, depth, phase };
        let values = (0..50).map(|i| (f64::from(i * i) * 0.37).sin() as f32).collect();
        let wave = Wave::new(Waveform { file: "a.wav".into(), rate: 10_000.0, values });
        let mut all = Vec::new();
        for &shape in <Envelope as VariantArray>::VARIANTS {
            for (depth, law) in
                [0.0, 0.3, 1.0].into_iter().flat_map(|d| [(d, Law::Amplitude), (d, Law::Power)])
            {
                let tones = vec![
                    tone(200.0, 0.5 * depth, 0.4),
                    tone(400.0, 0.2 * depth, 1.0),
                    tone(200.0, 0.3 * depth, -2.0),
                ];
                let wave = wave.clone();
                all.push(Modulation { shape, law, depth, tones, wave, ..Modulation::default() });
            }
        }
        all
    }

    #[test]
    fn the_mean_square_is_that_of_the_envelope() {
        for modulation in modulations() {
            const STEPS: u32 = 100_000;
            let depth = modulation.depth;
            let at = |i: u32| modulation.envelope((f64::from(i) + 0.5) / f64::from(STEPS) / 200.0);
            let mean = (0..STEPS).map(|i| at(i).powi(2)).sum::<f64>() / f64::from(STEPS);
            // The middle of each step is as good as it for sines and squares; of straight pieces it leaves their curvature.
            let error = if modulation.shape == Envelope::File { 1e-8 } else { 1e-11 };
            assert!((mean - modulation.mean_square()).abs() < error, "{modulation:?}: {mean}");
            let range = (0..STEPS).map(at).fold((1.0f64, 0.0f64), |(low, high), m| (low.min(m), high.max(m)));
            let lowest = if modulation.law == Law::Power { (1.0 - depth).sqrt() } else { 1.0 - depth };
            assert!(range.0 >= lowest - 1e-7 && range.1 <= 1.0 + 1e-12, "{modulation:?}: {range:?}");
        }
        let full = |shape| Modulation { shape, ..Modulation::default() }.mean_square();
        assert_eq!((full(Envelope::Sine), full(Envelope::Square)), (0.375, 0.5));
    }

    #[test]
    fn an_envelope_repeats_itself_after_its_period_and_not_before() {
        let tone = |frequency| Tone { frequency, depth: 0.3, phase: 0.1 };
        for (frequencies, period) in [(&[150.0, 200.0][..], 0.02), (&[1.5, 2.5], 2.0), (&[70.0], 1.0 / 70.0)]
        {
            let tones = frequencies.iter().copied().map(tone).collect();
            let modulation = Modulation { shape: Envelope::Tones, tones, ..Modulation::default() };
            let found = modulation.period().unwrap();
            assert!((found - period).abs() < 1e-12, "{frequencies:?}: {found} s");
            assert!((modulation.envelope(0.0123 + found) - modulation.envelope(0.0123)).abs() < 1e-9);
        }
        assert_eq!(Modulation::default().period(), None);
    }

    #[test]
    fn the_square_of_an_envelope_by_power_is_the_shape() {
        for modulation in modulations().into_iter().filter(|modulation| modulation.law == Law::Power) {
            for time in [0.0, 1e-3, 0.00171, 0.0049] {
                let square = modulation.envelope(time).powi(2);
                assert!((square - modulation.swing(time)).abs() < 1e-15, "{modulation:?}");
            }
        }
    }
}
