//! Boards that take lists of phase bytes: SonicSurface, alone and in twos, its tactile build, and Ultraino's SimpleFPGA.

use crate::device::declaration::{Declaration, Emulation, Heard, Level, Protocol, Strength};

/// The protocol of a build of the logic.
macro_rules! protocol {
    ($build:expr) => {
        Protocol {
            load: |channels| load(&$build, channels),
            swap: Some(SWAP),
            filler: Some(CLOCKS_ON),
            start: &[],
            blanks: 2,
            modulation: None,
            echo: None,
            boot: None,
            emulation: || Box::new(Twin::new(&$build)),
        }
    };
}

pub const SONICSURFACE: Declaration = Declaration {
    name: "sonicsurface",
    title: "SonicSurface",
    elements: CHANNELS,
    shape: Some([16, 16]),
    levels: 32,
    strength: Strength::Fixed,
    baud: 230_400,
    frame_bytes: 258,
    order: Some("sonicsurface"),
    remark: Some("every element sounds from power-up until a program connects"),
    uncalibrated: None,
    protocol: Some(Protocol { start: &START, ..protocol!(PLAIN) }),
};

pub const SONICSURFACE_2: Declaration = Declaration {
    name: "sonicsurface-2",
    title: "2 x SonicSurface",
    elements: 2 * CHANNELS,
    // The second board continues the rows of the first.
    shape: Some([16, 32]),
    frame_bytes: 516,
    // Once more: an interrupted list may have left any index, which only a swap resets.
    protocol: Some(Protocol { start: &START_TWO, blanks: 3, ..protocol!(TWO) }),
    ..SONICSURFACE
};

pub const SONICSURFACE_TACTILE: Declaration = Declaration {
    name: "sonicsurface-tactile",
    title: "SonicSurface, tactile gateware",
    levels: 16,
    remark: Some(
        "the phase corrections of its published gateware are compensated; for gateware built without them use the \
         calibration sonicsurface-tactile-zero-table.csv",
    ),
    // It only accepts lists.
    protocol: Some(Protocol { filler: Some(PHASES), modulation: Some(tactile_step), ..protocol!(TACTILE) }),
    ..SONICSURFACE
};

pub const ULTRAINO_SIMPLEFPGA: Declaration = Declaration {
    name: "ultraino-simplefpga",
    title: "Ultraino, FPGA of 256",
    shape: None,
    strength: Strength::Duty(FULL),
    order: None,
    remark: Some(
        "its gateware is not published: every element may sound from power-up until a program connects",
    ),
    protocol: Some(Protocol { start: &START, ..protocol!(SIMPLEFPGA) }),
    ..SONICSURFACE
};

/// A build of the logic.
#[derive(Debug)]
struct Build {
    /// Boards on the line.
    boards: usize,
    /// Difference of the values of neighbouring delays.
    spacing: u8,
    /// The addition to the byte of each channel.
    correction: [u8; CHANNELS],
    has_amplitudes: bool,
    /// It modulates, knows no commands but lists and steps of its modulation, and is silent at first.
    is_tactile: bool,
}

const PLAIN: Build =
    Build { boards: 1, spacing: 1, correction: [0; CHANNELS], has_amplitudes: false, is_tactile: false };
const TWO: Build = Build { boards: 2, ..PLAIN };
const TACTILE: Build = Build { spacing: 2, correction: TACTILE_CORRECTION, is_tactile: true, ..PLAIN };
const SIMPLEFPGA: Build = Build { has_amplitudes: true, ..PLAIN };

/// A list of phases follows.
const PHASES: u8 = 254;
/// Swaps the shown and the hidden buffer, and ends a list.
const SWAP: u8 = 253;
/// A list of amplitudes follows; SimpleFPGA only.
const AMPLITUDES: u8 = 251;
const CLOCKS_OFF: u8 = 150;
const CLOCKS_ON: u8 = 151;
/// Phase data is for the first board, for the second.
const FIRST: u8 = 192;
const SECOND: u8 = 193;
/// This element is off, and no other value is.
const OFF: u8 = 32;
/// Restarts possibly stopped clocks, and selects the first board.
const START: [u8; 2] = [CLOCKS_ON, FIRST];
/// The same for two boards. A board counts the bytes of a list until a swap, or another list that it is selected for.
const START_TWO: [u8; 5] = [CLOCKS_ON, FIRST, PHASES, SECOND, PHASES];
const CHANNELS: usize = 256;
/// The tactile build's bytes for the step of its modulation.
const TACTILE_STEPS: std::ops::RangeInclusive<u8> = 0xA0..=0xBF;
/// Hz: of a step of 0 of that modulation.
const TACTILE_FASTEST: f64 = 1250.0;
const FULL: u16 = 16;
/// Values of a byte per period, and mask of a byte other than [`OFF`].
const VALUES: u8 = 32;

/// `PHASE_CORRECTION` of the published tactile gateware (upnalab/SonicSurface,
/// `FPGA tactile modulation/src/Distribute.vhd`): its addition to the byte of each channel, measured by its author on
/// one board.
const TACTILE_CORRECTION: [u8; CHANNELS] = [
    0, 14, 15, 31, 15, 15, 0, 0, 16, 1, 1, 29, 15, 15, 17, 1, 31, 17, 15, 31, 30, 31, 13, 30, 0, 18, 18, 30,
    15, 14, 31, 14, 30, 15, 0, 0, 15, 15, 1, 0, 1, 17, 13, 29, 15, 0, 0, 0, 0, 16, 31, 30, 31, 0, 31, 0, 16,
    0, 16, 15, 30, 14, 17, 0, 14, 31, 30, 13, 30, 14, 14, 30, 15, 1, 0, 13, 31, 31, 31, 31, 14, 31, 1, 29,
    31, 0, 15, 14, 16, 0, 0, 31, 0, 17, 15, 14, 0, 15, 30, 16, 0, 17, 0, 17, 17, 15, 0, 14, 0, 16, 2, 0, 18,
    0, 1, 0, 15, 18, 1, 17, 18, 0, 16, 16, 17, 14, 1, 1, 14, 15, 1, 30, 17, 14, 2, 16, 31, 3, 17, 14, 16, 17,
    1, 0, 1, 30, 0, 30, 0, 14, 15, 15, 13, 30, 31, 15, 31, 0, 0, 0, 0, 31, 31, 14, 31, 31, 16, 0, 18, 17, 1,
    0, 16, 31, 30, 30, 16, 0, 18, 14, 0, 16, 14, 2, 16, 19, 1, 30, 31, 16, 15, 1, 16, 16, 3, 30, 15, 31, 31,
    0, 0, 1, 17, 31, 2, 16, 16, 0, 0, 13, 16, 14, 16, 14, 31, 13, 13, 31, 15, 15, 15, 16, 30, 15, 0, 16, 31,
    31, 1, 0, 15, 18, 0, 31, 1, 15, 1, 0, 0, 14, 15, 1, 16, 0, 15, 18, 30, 1, 19, 2, 16, 30, 15, 15, 1, 1,
];

fn load(build: &Build, channels: &[Option<Level>]) -> Vec<u8> {
    let value = |(level, correction): (&Option<Level>, &u8)| match level {
        None => OFF,
        // At most 31, since there are 32 delays; the board's addition is subtracted.
        Some(level) => (level.delay.to_le_bytes()[0] * build.spacing + VALUES - correction) % VALUES,
    };
    let mut bytes = vec![PHASES];
    for (board, channels) in channels.chunks(CHANNELS).enumerate() {
        if build.boards > 1 {
            bytes.push(if board == 0 { FIRST } else { SECOND });
        }
        bytes.extend(channels.iter().zip(&build.correction).map(value));
    }
    let weak = channels.iter().flatten().any(|level| level.amplitude < FULL);
    if build.has_amplitudes && weak {
        bytes.push(AMPLITUDES);
        let amplitude = |level: &Option<Level>| level.map_or(0, |level| level.amplitude);
        bytes.extend(channels.iter().map(|level| amplitude(level).to_le_bytes()[0]));
    }
    bytes
}

/// The byte for the tactile build's modulation whose period is nearest to that of a frequency (Hz), and its frequency.
fn tactile_step(frequency: f64) -> (u8, f64) {
    let wanted = TACTILE_FASTEST / frequency - 1.0;
    // NaN gets the slowest.
    let step = if wanted.is_nan() { 31.0 } else { wanted.round().clamp(0.0, 31.0) };
    (TACTILE_STEPS.start() + step as u8, TACTILE_FASTEST / (step + 1.0))
}

/// The board's side.
#[derive(Debug)]
struct Twin {
    build: &'static Build,
    boards: Vec<Board>,
}

/// One board on the line.
#[derive(Clone, Debug)]
struct Board {
    listens: bool,
    /// Index of the next byte of a list.
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
    /// The power-up state: every element at phase 0, except in the tactile build, and every board selected.
    fn new(build: &'static Build) -> Self {
        let shown = if build.is_tactile { OFF } else { 0 };
        let buffer = |phase| Buffer { phases: [phase; CHANNELS], amplitudes: [FULL as u8; CHANNELS] };
        let board =
            Board { listens: true, index: 0, of_amplitudes: false, shown: buffer(shown), hidden: buffer(0) };
        Self { build, boards: vec![board; build.boards] }
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
        let correction = &self.build.correction;
        for board in self.listening() {
            if board.index >= CHANNELS {
                heard = Heard::Nonsense;
                continue;
            }
            let buffer = &mut board.hidden;
            let list = if board.of_amplitudes { &mut buffer.amplitudes } else { &mut buffer.phases };
            // Only 32 itself is off; the logic uses five bits of all others.
            let played = byte.wrapping_add(correction[board.index]) % VALUES;
            list[board.index] = if byte == OFF { OFF } else { played };
            board.index += 1;
        }
        heard
    }
}

impl Emulation for Twin {
    fn push(&mut self, byte: u8) -> Heard {
        let tactile = self.build.is_tactile;
        match byte {
            PHASES => self.start(false),
            AMPLITUDES if self.build.has_amplitudes => self.start(true),
            SWAP => return self.exchange(),
            _ if tactile && TACTILE_STEPS.contains(&byte) => {}
            CLOCKS_OFF | CLOCKS_ON if !tactile => {}
            FIRST | SECOND if !tactile => self.address(byte == FIRST),
            _ => return self.store(byte),
        }
        Heard::Part
    }

    fn shown(&self) -> Vec<Option<Level>> {
        let (spacing, has_amplitudes) = (self.build.spacing, self.build.has_amplitudes);
        let level = |(&phase, &amplitude): (&u8, &u8)| {
            let amplitude = if has_amplitudes { amplitude.into() } else { 1 };
            (phase != OFF && amplitude > 0).then(|| Level { delay: (phase / spacing).into(), amplitude })
        };
        let buffers = self.boards.iter().map(|board| &board.shown);
        buffers.flat_map(|buffer| buffer.phases.iter().zip(&buffer.amplitudes).map(level)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modulation_steps_are_in_range_for_any_frequency() {
        for frequency in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -0.0, 0.0, 5e-324, 1e300] {
            let (byte, nearest) = tactile_step(frequency);
            assert!((0xA0..=0xBF).contains(&byte) && (39.0..=1250.0).contains(&nearest), "{frequency}");
        }
    }
}
