//! UCL's and OpenMPD's board: 256 delays, then 256 pulse lengths, with the first byte marked.

use crate::device::declaration::{Declaration, Emulation, Heard, Level, Protocol, Strength};

pub const ACOUSTOPHORETIC_512: Declaration = Declaration {
    name: "acoustophoretic-512",
    title: "Acoustophoretic board (UCL, OpenMPD)",
    elements: CHANNELS,
    shape: Some([16, 16]),
    levels: 128,
    strength: Strength::Duty(64),
    baud: 250_000,
    frame_bytes: FRAME,
    order: Some("acoustophoretic-512"),
    remark: Some(
        "its USB chip must appear as a serial port; every element sounds for the first second after power-up",
    ),
    uncalibrated: Some(
        "acoustophoretic-512 is played without the measured phases of its transducers, which are mounted in both \
         polarities: 0 to 19 % of the focus is left on the boards that OpenMPD publishes. Give the board's own file \
         board_N.pat as the calibration, or name it as the scene's `array.elements`",
    ),
    protocol: Some(Protocol {
        load,
        swap: None,
        filler: None,
        start: &[],
        // Once more: an interrupted frame may have left any index, which only its end resets.
        blanks: 3,
        modulation: None,
        echo: None,
        boot: None,
        emulation: || Box::new(Twin::new()),
    }),
};

const CHANNELS: usize = 256;
const FRAME: usize = 2 * CHANNELS;
/// This bit marks the first byte of a frame, and nothing else does.
const FIRST: u8 = 0x80;

fn load(channels: &[Option<Level>]) -> Vec<u8> {
    let delays = channels.iter().map(|level| level.map_or(0, |level| level.delay));
    let duties = channels.iter().map(|level| level.map_or(0, |level| level.amplitude));
    let mut bytes: Vec<_> = delays.chain(duties).map(|value| value.to_le_bytes()[0]).collect();
    bytes[0] |= FIRST;
    bytes
}

/// The board's emulation: `FrameBufferController` and `CommandReader` of OpenMPD's gateware 3.4.2, without the
/// timeout of one second after which it discards part of a frame.
#[derive(Debug)]
struct Twin {
    shown: Vec<u8>,
    coming: Vec<u8>,
    /// Received bytes; read when they fill a frame.
    queue: Vec<u8>,
    /// Index in the frame being read; `None` while searching its first byte.
    index: Option<usize>,
}

impl Twin {
    /// The state one second after power-up: until then it plays every element in phase, whatever it receives.
    fn new() -> Self {
        let silent = vec![0; FRAME];
        Self { shown: silent.clone(), coming: silent, queue: Vec::new(), index: None }
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
}

impl Emulation for Twin {
    fn push(&mut self, byte: u8) -> Heard {
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

    fn shown(&self) -> Vec<Option<Level>> {
        let (delays, duties) = self.shown.split_at(CHANNELS);
        let level = |(&delay, &duty): (&u8, &u8)| {
            (duty > 0).then(|| Level { delay: delay.into(), amplitude: duty.into() })
        };
        delays.iter().zip(duties).map(level).collect()
    }
}
