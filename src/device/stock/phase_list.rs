//! Boards that take lists of phase bytes: SonicSurface, alone and in twos, its tactile build, and Ultraino's SimpleFPGA.

use crate::device::levels::Level;
use crate::device::levels::Levels;
use crate::device::order;
use crate::device::profile::Profile;
use crate::device::stock::Heard;

/// A list of phases follows.
const PHASES: u8 = 254;
/// Exchanges what is shown and what is hidden, and ends a list.
pub const SWAP: u8 = 253;
/// A list of amplitudes follows; SimpleFPGA only.
const AMPLITUDES: u8 = 251;
const CLOCKS_OFF: u8 = 150;
const CLOCKS_ON: u8 = 151;
/// Phase data is for the first board, for the second.
const FIRST: u8 = 192;
const SECOND: u8 = 193;
/// This element is off, and no other value is.
const OFF: u8 = 32;
/// Clocks that may have been stopped run again, and the first board listens.
pub const START: [u8; 2] = [CLOCKS_ON, FIRST];
const CHANNELS: usize = 256;
/// The tactile build's bytes for the step of its modulation.
const TACTILE_STEPS: std::ops::RangeInclusive<u8> = 0xA0..=0xBF;
/// Hz: of a step of 0 of that modulation.
const TACTILE_FASTEST: f64 = 1250.0;
const FULL: u16 = 16;

/// How far apart the values of neighbouring delays are.
fn spacing(profile: Profile) -> u8 {
    if profile == Profile::SonicSurfaceTactile { 2 } else { 1 }
}

pub fn load(levels: &Levels) -> Vec<u8> {
    let order = order::elements(levels.profile);
    let value = |&element: &usize| match levels.elements[element] {
        None => OFF,
        // 31 at most, since the profile has 32 delays.
        Some(level) => level.delay.to_le_bytes()[0] * spacing(levels.profile),
    };
    let mut bytes = vec![PHASES];
    for (board, channels) in order.chunks(CHANNELS).enumerate() {
        if levels.profile == Profile::SonicSurface2 {
            bytes.push(if board == 0 { FIRST } else { SECOND });
        }
        bytes.extend(channels.iter().map(value));
    }
    let weak = levels.elements.iter().flatten().any(|level| level.amplitude < FULL);
    if levels.profile == Profile::UltrainoSimpleFpga && weak {
        bytes.push(AMPLITUDES);
        let amplitude = |&element: &usize| levels.elements[element].map_or(0, |level| level.amplitude);
        bytes.extend(order.iter().map(|element| amplitude(element).to_le_bytes()[0]));
    }
    bytes
}

/// The byte that sets the tactile build's modulation as near to a frequency (Hz) as it gets, and the frequency.
pub fn tactile_step(frequency: f64) -> (u8, f64) {
    let wanted = TACTILE_FASTEST / frequency - 1.0;
    // What is no frequency gets the slowest.
    let step = if wanted.is_nan() { 31.0 } else { wanted.round().clamp(0.0, 31.0) };
    (TACTILE_STEPS.start() + step as u8, TACTILE_FASTEST / (step + 1.0))
}

/// The board's side.
#[derive(Clone, Debug)]
pub struct Twin {
    profile: Profile,
    boards: Vec<Board>,
}

/// One board on the line.
#[derive(Clone, Debug)]
struct Board {
    listens: bool,
    /// Where the next byte of a list goes.
    index: usize,
    of_amplitudes: bool,
    shown: Buffer,
    hidden: Buffer,
}

#[derive(Clone, Debug)]
struct Buffer {
    phases: [u8; CHANNELS],
    amplitudes: [u8; CHANNELS],
}

impl Twin {
    /// As the boards' logic starts: everything on at phase 0, but for the tactile build.
    pub fn new(profile: Profile) -> Self {
        let phase = if profile == Profile::SonicSurfaceTactile { OFF } else { 0 };
        let buffer = Buffer { phases: [phase; CHANNELS], amplitudes: [FULL as u8; CHANNELS] };
        let board = |board| Board {
            listens: board == 0,
            index: 0,
            of_amplitudes: false,
            shown: buffer.clone(),
            hidden: buffer.clone(),
        };
        Self { profile, boards: (0..profile.elements() / CHANNELS).map(board).collect() }
    }

    pub fn push(&mut self, byte: u8) -> Heard {
        let tactile = self.profile == Profile::SonicSurfaceTactile;
        match byte {
            PHASES => self.start(false),
            AMPLITUDES if self.profile == Profile::UltrainoSimpleFpga => self.start(true),
            SWAP => return self.exchange(),
            _ if tactile && TACTILE_STEPS.contains(&byte) => {}
            CLOCKS_OFF | CLOCKS_ON if !tactile => {}
            FIRST | SECOND if !tactile => self.address(byte == FIRST),
            _ => return self.store(byte),
        }
        Heard::Part
    }

    fn listening(&mut self) -> impl Iterator<Item = &mut Board> {
        self.boards.iter_mut().filter(|board| board.listens)
    }

    fn start(&mut self, of_amplitudes: bool) {
        for board in self.listening() {
            (board.index, board.of_amplitudes) = (0, of_amplitudes);
            if !of_amplitudes {
                board.hidden.amplitudes = [FULL as u8; CHANNELS];
            }
        }
    }

    fn address(&mut self, first: bool) {
        for (number, board) in self.boards.iter_mut().enumerate() {
            board.listens = (number == 0) == first;
        }
    }

    /// A swap after part of a list shows a frame of two pieces.
    fn exchange(&mut self) -> Heard {
        let torn = self.boards.iter().any(|board| ![0, CHANNELS].contains(&board.index));
        for board in &mut self.boards {
            std::mem::swap(&mut board.shown, &mut board.hidden);
            (board.index, board.of_amplitudes) = (0, false);
        }
        if torn { Heard::Nonsense } else { Heard::Shown }
    }

    fn store(&mut self, byte: u8) -> Heard {
        let mut heard = if byte <= OFF { Heard::Part } else { Heard::Nonsense };
        for board in self.listening() {
            if board.index >= CHANNELS {
                heard = Heard::Nonsense;
                continue;
            }
            let buffer = &mut board.hidden;
            let list = if board.of_amplitudes { &mut buffer.amplitudes } else { &mut buffer.phases };
            // Only 32 itself is off; the logic looks at five bits of all else.
            list[board.index] = if byte == OFF { OFF } else { byte & 0x1F };
            board.index += 1;
        }
        heard
    }

    pub fn shown(&self) -> Levels {
        let mut levels = Levels::off(self.profile);
        let channels = self.boards.iter().flat_map(|board| {
            board
                .shown
                .phases
                .iter()
                .zip(&board.shown.amplitudes)
                .map(|(&phase, &amplitude)| (phase, amplitude))
        });
        for (element, (phase, amplitude)) in order::elements(self.profile).into_iter().zip(channels) {
            let amplitude = match self.profile {
                Profile::UltrainoSimpleFpga => u16::from(amplitude),
                _ => 1,
            };
            levels.elements[element] = (phase != OFF && amplitude > 0)
                .then(|| Level { delay: u16::from(phase / spacing(self.profile)), amplitude });
        }
        levels
    }
}
