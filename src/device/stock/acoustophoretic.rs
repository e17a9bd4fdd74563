//! UCL's and OpenMPD's board: 256 delays, then 256 pulse lengths, with the first byte marked.

use crate::device::levels::Level;
use crate::device::levels::Levels;
use crate::device::order;
use crate::device::profile::Profile;
use crate::device::stock::Heard;

const CHANNELS: usize = 256;
const FRAME: usize = 2 * CHANNELS;
/// This bit marks the first byte of a frame, and nothing else does.
const FIRST: u8 = 0x80;

pub fn load(levels: &Levels) -> Vec<u8> {
    let order = order::elements(Profile::Acoustophoretic512);
    let in_order = || order.iter().map(|&element| levels.elements[element]);
    let delays = in_order().map(|level| level.map_or(0, |level| level.delay));
    let duties = in_order().map(|level| level.map_or(0, |level| level.amplitude));
    let mut bytes: Vec<_> = delays.chain(duties).map(|value| value.to_le_bytes()[0]).collect();
    bytes[0] |= FIRST;
    bytes
}

/// The board's emulation: `FrameBufferController` and `CommandReader` of OpenMPD's gateware 3.4.2, without the
/// timeout of one second after which it discards part of a frame.
#[derive(Clone, Debug)]
pub struct Twin {
    shown: Vec<u8>,
    coming: Vec<u8>,
    /// Received bytes; read when they fill a frame.
    queue: Vec<u8>,
    /// Index in the frame being read; `None` while searching its first byte.
    index: Option<usize>,
}

impl Default for Twin {
    fn default() -> Self {
        Self::new()
    }
}

impl Twin {
    /// The state one second after power-up: until then it plays every element in phase, whatever it receives.
    pub fn new() -> Self {
        let silent = vec![0; FRAME];
        Self { shown: silent.clone(), coming: silent, queue: Vec::new(), index: None }
    }

    pub fn push(&mut self, byte: u8) -> Heard {
        self.queue.push(byte);
        if self.queue.len() < FRAME {
            return Heard::Part;
        }
        let frame = std::mem::take(&mut self.queue);
        let heard: Vec<_> = frame.into_iter().map(|byte| self.read(byte)).collect();
        match heard {
            heard if heard.contains(&Heard::Nonsense) => Heard::Nonsense,
            heard if heard.contains(&Heard::Shown) => Heard::Shown,
            _ => Heard::Part,
        }
    }

    fn read(&mut self, byte: u8) -> Heard {
        let begins = byte & FIRST != 0;
        let (index, mut heard) = match self.index {
            None if begins => (0, Heard::Part),
            None => return Heard::Nonsense,
            // The mark is looked at between frames only; within one it sets lamps and rates.
            Some(index) if begins => (index, Heard::Nonsense),
            Some(index) => (index, Heard::Part),
        };
        self.coming[index] = byte & !FIRST;
        self.index = Some(index + 1).filter(|&next| next < FRAME);
        if self.index.is_none() {
            self.shown.clone_from(&self.coming);
            heard = if heard == Heard::Part { Heard::Shown } else { heard };
        }
        heard
    }

    pub fn shown(&self) -> Levels {
        let mut levels = Levels::off(Profile::Acoustophoretic512);
        for (channel, element) in order::elements(levels.profile).into_iter().enumerate() {
            let (delay, amplitude) = (self.shown[channel], self.shown[CHANNELS + channel]);
            levels.elements[element] =
                (amplitude > 0).then(|| Level { delay: u16::from(delay), amplitude: u16::from(amplitude) });
        }
        levels
    }
}
