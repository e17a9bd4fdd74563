//! Stock boards: plain bytes without checksum or reply. Each has an encoder and a twin that emulates the board.

pub mod acoustophoretic;
pub mod mega64;
pub mod phase_list;

use crate::device::levels::Levels;
use crate::device::profile::Profile;
use crate::scene::{Envelope, Modulation};

/// The bytes that put a frame into the board's hidden buffer, up to the byte that shows it.
///
/// # Panics
/// The native profile, which uses packets; or levels that [`Levels::new`] never produces: a wrong number of elements,
/// or beyond the profile's levels.
pub fn load(levels: &Levels) -> Vec<u8> {
    match levels.profile {
        Profile::Native | Profile::Natives(_) => unreachable!("native boards are sent packets"),
        Profile::UltrainoMega64 => mega64::load(levels),
        Profile::Acoustophoretic512 => acoustophoretic::load(levels),
        Profile::SonicSurface
        | Profile::SonicSurface2
        | Profile::SonicSurfaceTactile
        | Profile::UltrainoSimpleFpga => phase_list::load(levels),
    }
}

/// The byte that exchanges the shown and the hidden buffer, if the board has one.
pub fn swap(profile: Profile) -> Option<u8> {
    match profile {
        Profile::Native | Profile::Natives(_) | Profile::Acoustophoretic512 => None,
        Profile::UltrainoMega64 => Some(mega64::SWAP),
        Profile::SonicSurface
        | Profile::SonicSurface2
        | Profile::SonicSurfaceTactile
        | Profile::UltrainoSimpleFpga => Some(phase_list::SWAP),
    }
}

/// The bytes that play a frame.
pub fn frame(levels: &Levels) -> Vec<u8> {
    let mut bytes = load(levels);
    bytes.extend(swap(levels.profile));
    bytes
}

/// The bytes that silence both buffers of a board in any state: sent first and last.
pub fn silence(profile: Profile) -> Vec<u8> {
    let blank = frame(&Levels::off(profile));
    let times = match profile {
        Profile::SonicSurface | Profile::SonicSurfaceTactile | Profile::UltrainoSimpleFpga => 2,
        // Once more: an interrupted list may have left any index, which only a swap, or the end of a frame, resets.
        Profile::Native
        | Profile::Natives(_)
        | Profile::SonicSurface2
        | Profile::Acoustophoretic512
        | Profile::UltrainoMega64 => 3,
    };
    [start(profile), &blank.repeat(times)].concat()
}

/// The bytes that make a board take a list in any state, also after a list without a swap.
pub(in crate::device) fn start(profile: Profile) -> &'static [u8] {
    match profile {
        Profile::SonicSurface | Profile::UltrainoSimpleFpga => &phase_list::START,
        Profile::SonicSurface2 => &phase_list::START_TWO,
        // The tactile build only accepts lists.
        Profile::Native
        | Profile::Natives(_)
        | Profile::SonicSurfaceTactile
        | Profile::Acoustophoretic512
        | Profile::UltrainoMega64 => &[],
    }
}

/// The playback of an envelope on a stock board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Modulated {
    Steady,
    /// The sender switches the sound on and off at this frequency (Hz).
    FromHere(f64),
    /// The board modulates, set by this byte, at this frequency (Hz).
    ByBoard(u8, f64),
    /// The line is too slow; its highest frequency (Hz).
    Never(f64),
    /// More than one frequency is requested: the sound is steady.
    OneFrequency,
}

/// The playback of a modulation over a line of this bit rate.
pub fn modulated(profile: Profile, modulation: &Modulation, baud: u32) -> Modulated {
    let frequency = modulation.frequency;
    match (modulation.shape, profile) {
        (Envelope::Off, _) => Modulated::Steady,
        (Envelope::Tones | Envelope::File, _) => Modulated::OneFrequency,
        (_, Profile::SonicSurfaceTactile) => {
            let (byte, frequency) = phase_list::tactile_step(frequency);
            Modulated::ByBoard(byte, frequency)
        }
        (
            _,
            Profile::SonicSurface
            | Profile::SonicSurface2
            | Profile::UltrainoSimpleFpga
            | Profile::UltrainoMega64,
        ) => Modulated::FromHere(frequency),
        // Without a second buffer each half period is a frame.
        (_, Profile::Native | Profile::Natives(_) | Profile::Acoustophoretic512) => {
            let fastest = profile.frames_per_second(baud) / 2.0;
            if frequency <= fastest { Modulated::FromHere(frequency) } else { Modulated::Never(fastest) }
        }
    }
}

/// The effect of a byte on a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    Part,
    /// Another frame is shown.
    Shown,
    /// Invalid here; boards react to it nevertheless, and so do the twins.
    Nonsense,
}

/// The board's emulation.
#[derive(Clone, Debug)]
pub enum Twin {
    PhaseList(phase_list::Twin),
    Mega64(mega64::Twin),
    Acoustophoretic(acoustophoretic::Twin),
}

impl Twin {
    /// A board just switched on.
    ///
    /// # Panics
    /// The native profile, whose twin is [`crate::device::native::model::Model`].
    pub fn new(profile: Profile) -> Self {
        match profile {
            Profile::Native | Profile::Natives(_) => unreachable!("the native device has a model of its own"),
            Profile::UltrainoMega64 => Self::Mega64(mega64::Twin::new()),
            Profile::Acoustophoretic512 => Self::Acoustophoretic(acoustophoretic::Twin::new()),
            Profile::SonicSurface
            | Profile::SonicSurface2
            | Profile::SonicSurfaceTactile
            | Profile::UltrainoSimpleFpga => Self::PhaseList(phase_list::Twin::new(profile)),
        }
    }

    pub fn push(&mut self, byte: u8) -> Heard {
        match self {
            Self::PhaseList(twin) => twin.push(byte),
            Self::Mega64(twin) => twin.push(byte),
            Self::Acoustophoretic(twin) => twin.push(byte),
        }
    }

    /// What the board sends back after a byte.
    pub fn answer(&self, byte: u8) -> Option<u8> {
        match self {
            Self::Mega64(_) => (byte == mega64::SWAP).then_some(byte),
            Self::PhaseList(_) | Self::Acoustophoretic(_) => None,
        }
    }

    /// The played levels.
    pub fn shown(&self) -> Levels {
        match self {
            Self::PhaseList(twin) => twin.shown(),
            Self::Mega64(twin) => twin.shown(),
            Self::Acoustophoretic(twin) => twin.shown(),
        }
    }
}
