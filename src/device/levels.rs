//! A drive as a board takes it: a level per element, and none where an element is off.

use crate::device::calibration::Calibration;
use crate::device::profile::{Profile, Strength};
use crate::drive::Drive;

/// What one element is told. Off is the absence of a level, never a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Level {
    /// Of [`Profile::levels`].
    pub delay: u16,
    /// Of [`Profile::strength`], more than 0.
    pub amplitude: u16,
}

/// A drive in the levels of a board, in the numbering of the array.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Levels {
    pub profile: Profile,
    pub elements: Vec<Option<Level>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the scene's array has {array} elements, but {} drives {}", profile.name(), profile.elements())]
pub struct OtherCount {
    pub profile: Profile,
    pub array: usize,
}

impl Levels {
    /// # Errors
    /// An array of another size than the board's.
    pub fn new(profile: Profile, drive: &Drive, calibration: &Calibration) -> Result<Self, OtherCount> {
        let array = profile.elements();
        let counts = [drive.phases.len(), drive.amplitudes.len()];
        if let Some(array) = counts.into_iter().find(|&count| count != array) {
            return Err(OtherCount { profile, array });
        }
        let level = |n| {
            let (amplitude, phase) = calibration.corrected(n, drive.amplitudes[n], drive.phases[n]);
            profile.level(amplitude, phase)
        };
        Ok(Self { profile, elements: (0..array).map(level).collect() })
    }

    /// Nothing sounds.
    pub fn off(profile: Profile) -> Self {
        Self { profile, elements: vec![None; profile.elements()] }
    }

    /// One element at full amplitude, for finding it.
    pub fn one(profile: Profile, element: usize) -> Self {
        let mut levels = Self::off(profile);
        if let Some(one) = levels.elements.get_mut(element) {
            *one = profile.level(1.0, 0.0);
        }
        levels
    }

    /// Neighbours in antiphase, `columns` to a row.
    pub fn checkerboard(profile: Profile, columns: usize) -> Self {
        let black = |n: usize| (n / columns.max(1) + n % columns.max(1)) % 2 == 1;
        let phase = |n| if black(n) { std::f64::consts::PI } else { 0.0 };
        Self { profile, elements: (0..profile.elements()).map(|n| profile.level(1.0, phase(n))).collect() }
    }

    /// What the elements sound like, calibration left out.
    pub fn drive(&self) -> Drive {
        let sound = |level: &Option<Level>| level.map_or((0.0, 0.0), |level| self.profile.sounds(level));
        let (amplitudes, phases) = self.elements.iter().map(sound).unzip();
        Drive { amplitudes, phases }
    }
}

/// What a board makes of a drive, a calibration and a scene's frequency that its user should know; a sentence each.
pub fn notices(profile: Profile, drive: &Drive, calibration: &Calibration, frequency: f64) -> Vec<String> {
    let mut notices = Vec::new();
    let weaker = drive.amplitudes.iter().any(|&amplitude| amplitude > 0.0 && amplitude < 1.0 - 1e-9);
    if profile.strength() == Strength::Fixed && (weaker || calibration.has_gains()) {
        notices.push(format!(
            "{} has no amplitudes: elements that are to play softly play fully",
            profile.name()
        ));
    }
    notices.extend(carrier_notice(profile.carrier(), frequency));
    notices
}

/// A carrier that is not the scene's frequency (Hz), if it is not.
pub fn carrier_notice(carrier: f64, frequency: f64) -> Option<String> {
    /// What rounding to mHz may make of a frequency, and no more than air's own uncertainty.
    const SAME: f64 = 1e-6;
    ((carrier - frequency).abs() > SAME * frequency).then(|| {
        format!("the board plays {carrier} Hz, the scene is made for {frequency} Hz: the drive is found for the board's")
    })
}
