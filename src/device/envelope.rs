//! Modulation on boards: a repeated table on native boards, on and off on the others.

use crate::device::declaration::Strength;
use crate::device::profile::Profile;
use crate::scene::{Envelope, Modulation, Scene};

/// Steps of the native board's table.
pub const STEPS: usize = 256;
/// Steps of the table that a period of the fastest tone needs.
const STEPS_PER_PERIOD: f64 = 8.0;
/// Periods of the carrier, on which the native board takes one step of its table each, that a period of the fastest tone needs.
const PERIODS: f64 = 4.0;
/// Part of a file's power beyond half of the carrier that is too much: what the steps cannot follow comes back as other tones.
const LOST: f64 = 1e-4;
/// Full scale of the native board's step, in parts of the carrier.
const FULL: f64 = 16_777_216.0;

/// The native board's table, 255 for full amplitude, and its increment per carrier period, in 2^-24 of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Table {
    pub values: [u8; STEPS],
    pub step: u32,
}

impl Table {
    /// The table of one period of a modulation at a carrier (Hz).
    ///
    /// # Errors
    /// The errors of [`playable`].
    pub fn new(modulation: &Modulation, carrier: f64) -> Result<Self, String> {
        fits(modulation, carrier)?;
        let frequency = match modulation.shape {
            Envelope::Off | Envelope::Sine | Envelope::Square => modulation.frequency,
            Envelope::Tones | Envelope::File => modulation.period().map_or(modulation.frequency, f64::recip),
        };
        let at = |n: usize| modulation.envelope(n as f64 / STEPS as f64 / frequency);
        let values: [u8; STEPS] = std::array::from_fn(|n| (255.0 * at(n)).round() as u8);
        let is_constant = values.iter().all(|&value| value == values[0]);
        let step = (frequency / carrier * FULL).round().min(FULL - 1.0);
        Ok(Self { values, step: if is_constant { 0 } else { step as u32 } })
    }

    /// Full amplitude all the time.
    pub fn steady() -> Self {
        Self { values: [255; STEPS], step: 0 }
    }
}

/// Whether a board plays the envelopes of a scene: that of all targets, or different ones as frames.
///
/// # Errors
/// The errors of [`playable`], and a board without amplitudes for different envelopes.
pub fn plays(profile: Profile, scene: &Scene) -> Result<(), String> {
    if scene.has_own_envelopes() && profile.strength() == Strength::Fixed {
        return Err(format!(
            "{} has no amplitude control, which targets with different modulations need: leave [target.modulation] out, \
             or take a board with amplitudes",
            profile.name()
        ));
    }
    playable(profile, scene.envelope(), scene.array.frequency)
}

/// Whether a board plays a modulation of a carrier (Hz).
///
/// # Errors
/// The playable alternatives, as text.
pub fn playable(profile: Profile, modulation: &Modulation, carrier: f64) -> Result<(), String> {
    let name = profile.name();
    if profile.answers() {
        return fits(modulation, carrier).map_err(|why| format!("{name}: {why}"));
    }
    match modulation.shape {
        Envelope::Off | Envelope::Sine | Envelope::Square => Ok(()),
        Envelope::Tones | Envelope::File => Err(format!(
            "{name} only switches on and off at one frequency, which excludes modulation.shape = \"{}\": use \"square\" or \"sine\" \
             with a frequency",
            modulation.shape.into_str()
        )),
    }
}

/// Whether a modulation of a carrier (Hz) fits into the native board's table, and into its steps.
fn fits(modulation: &Modulation, carrier: f64) -> Result<(), String> {
    let fastest = modulation.fastest();
    if fastest * PERIODS > carrier * (1.0 + 1e-9) {
        return Err(format!(
            "a modulation has a step per period of the carrier, and needs {PERIODS} for each of its own: {fastest} Hz is more than \
             the {} Hz that a carrier of {carrier} Hz plays",
            carrier / PERIODS
        ));
    }
    match modulation.shape {
        Envelope::Off | Envelope::Sine | Envelope::Square => Ok(()),
        Envelope::Tones => {
            let periods = modulation.period().map_or(0.0, |period| fastest * period);
            if periods <= STEPS as f64 / STEPS_PER_PERIOD + 1e-6 {
                return Ok(());
            }
            Err(format!(
                "a modulation is a repeated table of {STEPS} steps: all tones must be multiples of one frequency, the fastest at \
                 most {} times it; {fastest} Hz is {periods:.0} times the common frequency of these tones",
                STEPS as f64 / STEPS_PER_PERIOD
            ))
        }
        Envelope::File => {
            let count = modulation.wave.get().map_or(0, |samples| samples.values.len());
            match count {
                0 => Err("modulation.file is not loaded".to_owned()),
                1..=STEPS => steps_follow(modulation, carrier),
                _ => Err(format!(
                    "a modulation is a repeated table of {STEPS} steps: modulation.file has {count} samples, the limit is {STEPS}"
                )),
            }
        }
    }
}

/// Whether a step per period of the carrier (Hz) follows a waveform.
fn steps_follow(modulation: &Modulation, carrier: f64) -> Result<(), String> {
    let Some(frequency) = modulation.period().map(f64::recip) else { return Ok(()) };
    let at = |n: usize| modulation.envelope(n as f64 / STEPS as f64 / frequency);
    let values: Vec<f64> = (0..STEPS).map(at).collect();
    let power = |k: usize| {
        let turn = |n: usize| std::f64::consts::TAU * (n * k % STEPS) as f64 / STEPS as f64;
        let sum =
            |part: fn(f64) -> f64| values.iter().enumerate().map(|(n, v)| v * part(turn(n))).sum::<f64>();
        sum(f64::cos).powi(2) + sum(f64::sin).powi(2)
    };
    let powers: Vec<_> = (1..=STEPS / 2).map(power).collect();
    let beyond = powers.iter().zip(1u32..).filter(|(_, k)| f64::from(*k) * frequency > carrier / 2.0);
    let (lost, all) = (beyond.map(|(power, _)| power).sum::<f64>(), powers.iter().sum::<f64>());
    if lost <= LOST * all.max(f64::MIN_POSITIVE) {
        return Ok(());
    }
    Err(format!(
        "a modulation has a step per period of the carrier: {:.1} % of the power of modulation.file is above {} Hz, half of the \
         carrier, and would be heard as other tones",
        100.0 * lost / all,
        carrier / 2.0
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Waveform;
    use crate::scene::{Law, Tone, Wave};

    fn tones(frequencies: &[f64]) -> Modulation {
        let depth = 1.0 / frequencies.len() as f64;
        let tones = frequencies.iter().map(|&frequency| Tone { frequency, depth, phase: 0.3 }).collect();
        Modulation { shape: Envelope::Tones, tones, ..Modulation::default() }
    }

    fn file(count: usize, rate: f64) -> Modulation {
        let values = (0..count).map(|i| (i as f32 * 0.1).sin()).collect();
        let wave = Wave::new(Waveform { file: "a.wav".into(), rate, values });
        Modulation { shape: Envelope::File, file: "a.wav".to_owned(), wave, ..Modulation::default() }
    }

    #[test]
    fn the_table_is_the_envelope_over_its_period_to_half_a_step() {
        let power = |modulation| Modulation { law: Law::Power, ..modulation };
        let sine = Modulation { shape: Envelope::Sine, frequency: 180.0, ..Modulation::default() };
        for modulation in
            [sine.clone(), power(sine), tones(&[150.0, 200.0]), power(tones(&[30.0, 960.0])), file(100, 20e3)]
        {
            let carrier = 40_000.0;
            let table = Table::new(&modulation, carrier).unwrap();
            let period = modulation.period().unwrap();
            let off = f64::from(table.step) - FULL / carrier / period;
            assert!(off.abs() <= 0.5 + 1e-6, "{modulation:?}: the step is {off} off");
            for (n, &value) in table.values.iter().enumerate() {
                let wanted = 255.0 * modulation.envelope(n as f64 / 256.0 * period);
                assert!((f64::from(value) - wanted).abs() <= 0.5 + 1e-9, "{modulation:?}");
            }
        }
        assert_eq!(Table::new(&Modulation::default(), 40e3), Ok(Table::steady()));
    }

    #[test]
    fn a_modulation_needs_four_periods_of_the_carrier_for_its_own() {
        let sine = |frequency| Modulation { shape: Envelope::Sine, frequency, ..Modulation::default() };
        assert_eq!(Table::new(&sine(10e3), 40e3).unwrap().step, 1 << 22);
        for frequency in [10.1e3, 40e3, 1e6] {
            let error = Table::new(&sine(frequency), 40e3).unwrap_err();
            assert!(error.contains("more than the 10000 Hz"), "{error}");
        }
        // A waveform of 192 kHz is played if its tones are.
        let wave = |turns: f32| {
            let values = (0..192).map(|n| (n as f32 * turns * std::f32::consts::TAU / 192.0).sin()).collect();
            let wave = Wave::new(Waveform { file: "a.wav".into(), rate: 192e3, values });
            Modulation { shape: Envelope::File, file: "a.wav".to_owned(), wave, ..Modulation::default() }
        };
        assert!(Table::new(&wave(2.0), 40e3).is_ok());
        assert!(Table::new(&wave(30.0), 40e3).unwrap_err().contains("above 20000 Hz"));
    }

    #[test]
    fn what_a_board_cannot_play_is_refused_with_what_it_can() {
        let refused = |profile, modulation: &Modulation, part: &str| {
            let error = playable(profile, modulation, 40e3).unwrap_err();
            assert!(error.starts_with(profile.name()) && error.contains(part), "{error}");
        };
        refused(Profile::Native, &tones(&[1.0, 200.0]), "200 Hz is 200 times the common frequency");
        refused(Profile::Native, &tones(&[150.0, 200.000_001]), "a repeated table of 256 steps");
        refused(Profile::Native, &tones(&[100.0, 3300.0]), "3300 Hz is 33 times");
        assert_eq!(playable(Profile::Native, &tones(&[100.0, 3200.0]), 40e3), Ok(()));
        assert!(Table::new(&tones(&[100.0, 3300.0]), 40e3).is_err());
        refused(Profile::Native, &file(257, 8e3), "has 257 samples");
        assert_eq!(playable(Profile::Native, &tones(&[150.0, 200.0]), 40e3), Ok(()));
        assert_eq!(playable(Profile::Native, &file(256, 8e3), 40e3), Ok(()));
        refused(Profile::SonicSurface, &tones(&[200.0]), "\"tones\": use \"square\"");
        refused(Profile::Acoustophoretic512, &file(10, 8e3), "\"file\"");
        let sine = Modulation { shape: Envelope::Sine, law: Law::Power, ..Modulation::default() };
        for profile in [Profile::Native, Profile::SonicSurface] {
            assert_eq!(playable(profile, &sine, 40e3), Ok(()));
        }
    }
}
