//! The declaration of a board: its facts, its bytes, and its emulation, in one place.

use std::fmt;

use web_time::{Duration, Instant};

/// The amplitude control of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strength {
    /// None: an element is on or off.
    Fixed,
    /// A number up to this, proportional to the sound.
    Linear(u16),
    /// A pulse length up to this many levels, which is half a period; the sound follows the sine of the length.
    Duty(u16),
}

/// The level of one element. Off is the absence of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Level {
    /// Less than the board's number of delays.
    pub delay: u16,
    /// Amplitude in the board's [`Strength`], more than 0.
    pub amplitude: u16,
}

/// One kind of board.
#[derive(Debug)]
pub(in crate::device) struct Declaration {
    /// Name on the command line and in files.
    pub name: &'static str,
    /// Name that its users know, in the window.
    pub title: &'static str,
    /// Transducers, of all boards on the line.
    pub elements: usize,
    /// Columns and rows if the transducers are on the board; `None` if channels are wired to any array of at most as
    /// many elements.
    pub shape: Option<[u32; 2]>,
    /// Number of delays per period.
    pub levels: u16,
    pub strength: Strength,
    /// Bit rate after power-up.
    pub baud: u32,
    /// Bytes of a frame at full amplitude.
    pub frame_bytes: usize,
    /// The table of its channels in `assets/wirings`; without, channel n is element n.
    pub order: Option<&'static str>,
    /// A remark for the user before sending.
    pub remark: Option<&'static str>,
    /// A warning for the user who plays it without a calibration.
    pub uncalibrated: Option<&'static str>,
    /// The bytes of a board that does not answer; `None` for the native protocol.
    pub protocol: Option<Protocol>,
}

/// Plain bytes without checksum or reply. Levels are by channel.
#[derive(Debug)]
pub(in crate::device) struct Protocol {
    /// The bytes that put a frame into the hidden buffer, up to the byte that shows it.
    pub load: fn(&[Option<Level>]) -> Vec<u8>,
    /// The byte that exchanges the shown and the hidden buffer, if the board has one.
    pub swap: Option<u8>,
    /// A byte without effect outside a list, which fills the time between swaps; `None` for boards whose line keeps no
    /// time, or that pay for each byte.
    pub filler: Option<u8>,
    /// The bytes that make it take a list in any state, also after a list without a swap.
    pub start: &'static [u8],
    /// Number of dark frames that silence it in any state.
    pub blanks: usize,
    /// The byte and frequency of the board's own modulation that is nearest to a frequency (Hz), if it has one.
    pub modulation: Option<fn(f64) -> (u8, f64)>,
    /// What it sends back for a byte, if it sends back anything.
    pub echo: Option<fn(u8) -> Option<u8>>,
    /// The boot loader that opening the port may start.
    pub boot: Option<Boot>,
    /// A board just switched on.
    pub emulation: fn() -> Box<dyn Emulation>,
}

/// A boot loader that bytes hold: it ends after a time without any.
#[derive(Debug)]
pub(in crate::device) struct Boot {
    /// The time after opening the port.
    pub quiet: Duration,
    /// The time after bytes have held it.
    pub held: Duration,
}

/// The boot loader of an emulated Arduino.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootLoader {
    Factory,
    Optiboot,
}

/// The emulation of a board.
pub(in crate::device) trait Emulation: fmt::Debug + Send {
    fn push(&mut self, byte: u8) -> Heard;
    /// The played levels.
    fn shown(&self) -> Vec<Option<Level>>;
    /// It is reset, as by the opening of its port.
    fn reset(&mut self, _: BootLoader, _: Instant) {}
    /// The time of what follows.
    fn pass(&mut self, _: Instant) {}
    /// Whether its boot loader runs.
    fn boots(&self) -> bool {
        false
    }
}

/// The effect of a byte on a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    Part,
    /// Another frame is shown.
    Shown,
    /// Invalid here; boards react to it nevertheless, and so do their emulations.
    Nonsense,
}
