//! Stock boards: plain bytes without checksum or reply, as their declarations have them.

use web_time::{Duration, Instant};

use crate::device::declaration::{BootLoader, Emulation, Heard, Protocol};
use crate::device::levels::Levels;
use crate::device::profile::Profile;
use crate::scene::{Envelope, Modulation};

/// # Panics
/// The native profile, which uses packets, and whose emulation is [`crate::device::native::model::Model`].
fn protocol(profile: Profile) -> &'static Protocol {
    let Some(protocol) = &profile.declaration().protocol else {
        unreachable!("native boards are sent packets")
    };
    protocol
}

/// The bytes that put a frame into the board's hidden buffer, up to the byte that shows it.
///
/// # Panics
/// The native profile, which uses packets; or levels that no wiring produces: a wrong number of channels,
/// or beyond the profile's levels.
pub fn load(levels: &Levels) -> Vec<u8> {
    (protocol(levels.profile).load)(&levels.channels)
}

/// The byte that exchanges the shown and the hidden buffer, if the board has one.
///
/// # Panics
/// The native profile.
pub fn swap(profile: Profile) -> Option<u8> {
    protocol(profile).swap
}

/// A byte without effect outside a list, if the board has one.
///
/// # Panics
/// The native profile.
pub(in crate::device) fn filler(profile: Profile) -> Option<u8> {
    protocol(profile).filler
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
    [start(profile), &blank.repeat(protocol(profile).blanks)].concat()
}

/// The bytes that make a board take a list in any state, also after a list without a swap.
pub(in crate::device) fn start(profile: Profile) -> &'static [u8] {
    protocol(profile).start
}

/// Time without bytes after the port is opened, in which a boot loader ends, also one that bytes may have held.
pub(in crate::device) fn quiet(profile: Profile, is_held: bool) -> Duration {
    let boot = protocol(profile).boot.as_ref();
    boot.map_or(Duration::ZERO, |boot| if is_held { boot.held } else { boot.quiet })
}

/// What a board sends back for a byte, if it sends back anything.
pub(in crate::device) fn echo(profile: Profile) -> Option<fn(u8) -> Option<u8>> {
    protocol(profile).echo
}

/// Hz: the fastest modulation by swaps, of which a computer's timers send one each half period.
const FASTEST: f64 = 1000.0;

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
///
/// # Panics
/// The native profile.
pub fn modulated(profile: Profile, modulation: &Modulation, baud: u32) -> Modulated {
    let frequency = modulation.frequency;
    let Protocol { modulation: own, swap, .. } = protocol(profile);
    match (modulation.shape, own, swap) {
        (Envelope::Off, ..) => Modulated::Steady,
        (Envelope::Tones | Envelope::File, ..) => Modulated::OneFrequency,
        (Envelope::Sine | Envelope::Square, Some(nearest), _) => {
            let (byte, frequency) = nearest(frequency);
            Modulated::ByBoard(byte, frequency)
        }
        (Envelope::Sine | Envelope::Square, None, Some(_)) if frequency > FASTEST => {
            Modulated::Never(FASTEST)
        }
        (Envelope::Sine | Envelope::Square, None, Some(_)) => Modulated::FromHere(frequency),
        // Without a second buffer each half period is a frame.
        (Envelope::Sine | Envelope::Square, None, None) => {
            let fastest = profile.frames_per_second(baud) / 2.0;
            if frequency <= fastest { Modulated::FromHere(frequency) } else { Modulated::Never(fastest) }
        }
    }
}

/// A board's emulation.
#[derive(Debug)]
pub struct Twin {
    profile: Profile,
    emulation: Box<dyn Emulation>,
}

impl Twin {
    /// A board just switched on.
    ///
    /// # Panics
    /// The native profile.
    pub fn new(profile: Profile) -> Self {
        Self { profile, emulation: (protocol(profile).emulation)() }
    }

    pub fn push(&mut self, byte: u8) -> Heard {
        self.emulation.push(byte)
    }

    /// The board's answer to a byte that it got.
    pub fn answer(&self, byte: u8) -> Option<u8> {
        echo(self.profile).filter(|_| !self.emulation.boots()).and_then(|echo| echo(byte))
    }

    /// The port was opened, which resets a board with a boot loader.
    pub(in crate::device) fn reset(&mut self, loader: BootLoader, now: Instant) {
        self.emulation.reset(loader, now);
    }

    /// The time of what follows.
    pub(in crate::device) fn pass(&mut self, now: Instant) {
        self.emulation.pass(now);
    }

    /// The played levels.
    pub fn shown(&self) -> Levels {
        Levels { profile: self.profile, channels: self.emulation.shown() }
    }
}
