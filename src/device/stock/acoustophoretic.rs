//! UCL's and OpenMPD's board: 256 delays, then 256 pulse lengths, with the first byte marked.

use crate::device::levels::Level;
use crate::device::levels::Levels;
use crate::device::order;
use crate::device::profile::Profile;
use crate::device::stock::Heard;

const CHANNELS: usize = 256;
/// The first byte of a frame has this bit, and it is all that tells where one begins.
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

/// The board's side.
#[derive(Clone, Debug)]
pub struct Twin {
    shown: Vec<u8>,
    coming: Vec<u8>,
    index: usize,
}

impl Default for Twin {
    fn default() -> Self {
        Self::new()
    }
}

impl Twin {
    pub fn new() -> Self {
        let silent = vec![0; 2 * CHANNELS];
        Self { shown: silent.clone(), coming: silent, index: 2 * CHANNELS }
    }

    pub fn push(&mut self, byte: u8) -> Heard {
        let mut heard = Heard::Part;
        if byte & FIRST != 0 {
            if self.index < 2 * CHANNELS {
                heard = Heard::Nonsense;
            }
            self.index = 0;
        }
        let Some(place) = self.coming.get_mut(self.index) else { return Heard::Nonsense };
        *place = byte & !FIRST;
        self.index += 1;
        if self.index == 2 * CHANNELS {
            self.shown.clone_from(&self.coming);
            heard = Heard::Shown;
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
