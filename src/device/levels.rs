//! A drive in a board's own terms: a level per channel, or none for a channel that is off; and the meaning of
//! levels.

use std::f64::consts::{PI, TAU};

use crate::device::calibration::Calibration;
use crate::device::declaration::{Level, Strength};
use crate::device::profile::Profile;
use crate::drive::{Drive, delay_level};

impl Profile {
    /// The nearest level to an amplitude (clamped to 0 … 1) and a phase (rad); `None` for silence, also for NaN,
    /// which must not be loud.
    pub fn level(self, amplitude: f64, phase: f64) -> Option<Level> {
        if amplitude.is_nan() || amplitude <= 0.0 || !phase.is_finite() {
            return None;
        }
        let amplitude = amplitude.min(1.0);
        let levels = u32::from(self.levels());
        match self.strength() {
            Strength::Fixed => Some(Level { delay: delay_level(phase, levels) as u16, amplitude: 1 }),
            Strength::Linear(full) => {
                let amplitude = (amplitude * f64::from(full)).round() as u16;
                (amplitude > 0).then(|| Level { delay: delay_level(phase, levels) as u16, amplitude })
            }
            Strength::Duty(full) => {
                let duty = (amplitude.asin() / PI * f64::from(levels)).round().min(f64::from(full));
                // The centre of the pulse determines the phase and is kept; the board is given its start.
                let later = (f64::from(full) - duty) / 2.0 / f64::from(levels);
                let delay = delay_level(phase - TAU * later, levels) as u16;
                (duty > 0.0).then_some(Level { delay, amplitude: duty as u16 })
            }
        }
    }

    /// Amplitude and phase (rad, in (-π, π]) of a level, up to a phase common to all elements.
    pub fn sounds(self, level: Level) -> (f64, f64) {
        let (delay, strength) = (f64::from(level.delay), f64::from(level.amplitude));
        let levels = f64::from(self.levels());
        let (amplitude, delay) = match self.strength() {
            Strength::Fixed => (1.0, delay),
            Strength::Linear(full) => (strength / f64::from(full), delay),
            Strength::Duty(full) => {
                ((PI * strength / levels).sin(), delay - (f64::from(full) - strength) / 2.0)
            }
        };
        let turns = (-delay / levels).rem_euclid(1.0);
        (amplitude, TAU * if turns > 0.5 { turns - 1.0 } else { turns })
    }
}

/// A drive in the levels of a board, by channel.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Levels {
    pub profile: Profile,
    pub channels: Vec<Option<Level>>,
}

impl Levels {
    /// All elements off.
    pub fn off(profile: Profile) -> Self {
        Self { profile, channels: vec![None; profile.elements()] }
    }

    /// The levels of one native device on the line.
    pub fn of_device(&self, address: u8) -> Self {
        let own = self.channels.chunks(Profile::Native.elements()).nth(usize::from(address));
        Self { profile: self.profile, channels: own.unwrap_or_default().to_vec() }
    }

    /// One channel at full amplitude.
    pub fn one(profile: Profile, channel: usize) -> Self {
        let mut levels = Self::off(profile);
        if let Some(one) = levels.channels.get_mut(channel) {
            *one = profile.level(1.0, 0.0);
        }
        levels
    }

    /// The resulting drive by channel.
    pub fn drive(&self) -> Drive {
        let sound = |level: &Option<Level>| level.map_or((0.0, 0.0), |level| self.profile.sounds(level));
        let (amplitudes, phases) = self.channels.iter().map(sound).unzip();
        Drive { amplitudes, phases }
    }
}

/// The notice about a drive, or a calibration, with amplitudes that a board lacks.
pub fn amplitude_notice(profile: Profile, drive: &Drive, calibration: &Calibration) -> Option<String> {
    let weaker = drive.amplitudes.iter().any(|&amplitude| amplitude > 0.0 && amplitude < 1.0 - 1e-9);
    (profile.strength() == Strength::Fixed && (weaker || calibration.has_gains())).then(|| {
        format!(
            "{} has no amplitude control: elements with reduced amplitude play at full amplitude",
            profile.name()
        )
    })
}

/// The notice about a carrier that differs from the scene's frequency (Hz).
pub fn carrier_notice(carrier: f64, frequency: f64) -> Option<String> {
    /// Tolerance for rounding to mHz, below the uncertainty of air.
    const SAME: f64 = 1e-6;
    ((carrier - frequency).abs() > SAME * frequency).then(|| {
        format!("the board plays {carrier} Hz, the scene {frequency} Hz: the drive is computed for the board's frequency")
    })
}
