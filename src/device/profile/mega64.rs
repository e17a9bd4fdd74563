//! Ultraino's Arduino Mega: a pattern of ten port states per period, each byte in two halves.
//!
//! Opening its port raises DTR, which resets it into its boot loader. The factory's (`stk500boot.c` of
//! arduino/ArduinoCore-avr) starts the sketch after a second without a byte; a byte holds it until none has come for
//! F_CPU / 2 turns of a loop, some 8 s. Optiboot starts it after a second, or at once after bytes that are no command.
//! The sketch (`DriverMEGA.ino` of asiermarzo/Ultraino) plays every element until it gets a frame, and sends back
//! all bytes but those of its pattern.

use web_time::{Duration, Instant};

use crate::device::declaration::{
    Boot, BootLoader, Declaration, Emulation, Heard, Level, Protocol, Strength,
};

pub const ULTRAINO_MEGA64: Declaration = Declaration {
    name: "ultraino-mega64",
    title: "Ultraino, Arduino Mega of 64",
    elements: ELEMENTS,
    shape: Some([8, 8]),
    levels: DIVISIONS as u16,
    strength: Strength::Duty(5),
    baud: 115_200,
    frame_bytes: 210,
    order: None,
    remark: Some("every element sounds from power-up until a program connects"),
    uncalibrated: None,
    protocol: Some(Protocol {
        load,
        swap: Some(SWAP),
        // It sends every other byte on to the next board, in the time of its sound.
        filler: None,
        start: &[],
        // Once more: an interrupted list may have left any index, which only a swap resets.
        blanks: 3,
        modulation: None,
        echo: Some(answer),
        boot: Some(Boot { quiet: Duration::from_secs(2), held: Duration::from_secs(10) }),
        emulation: || Box::new(Twin::new()),
    }),
};

const DIVISIONS: usize = 10;
const PORTS: usize = 10;
const PATTERN: usize = DIVISIONS * PORTS;
const ELEMENTS: usize = 64;
/// Exchanges the buffers.
const SWAP: u8 = 0x00;
/// Two bits of a duration, in the two highest.
const DURATION: u8 = 0x30;
const COMMIT_DURATIONS: u8 = 0x10;
/// Low half of a data byte for the first board on the line.
const MINE: u8 = 0x01;

/// Bit of every element's pin within the ten ports (A C L B K F H D G J).
const PINS: [usize; ELEMENTS] = [
    51, 52, 53, 54, 28, 29, 30, 31, 47, 46, 45, 44, 43, 42, 41, 40, //
    56, 57, 58, 59, 48, 49, 72, 69, 39, 38, 37, 36, 35, 34, 33, 32, //
    21, 23, 65, 63, 9, 11, 13, 15, 20, 22, 64, 66, 8, 10, 12, 14, //
    24, 25, 26, 27, 16, 17, 18, 19, 7, 6, 5, 4, 3, 2, 1, 0,
];

fn load(channels: &[Option<Level>]) -> Vec<u8> {
    let mut pattern = [0u8; PATTERN];
    for (level, pin) in channels.iter().zip(PINS) {
        let Some(level) = level else { continue };
        for later in 0..level.amplitude {
            let division = usize::from(level.delay + later) % DIVISIONS;
            pattern[division * PORTS + pin / 8] |= 1 << (pin % 8);
        }
    }
    let halves = |byte: u8| [byte & 0xF0 | MINE, byte << 4 | MINE];
    let mut bytes: Vec<_> = pattern.into_iter().flat_map(halves).collect();
    // One pattern, shown for ever: a duration of 1 and the 0 that ends the list.
    bytes.extend([1, 0].into_iter().flat_map(duration));
    bytes.push(COMMIT_DURATIONS);
    bytes
}

/// Two bits a byte, the highest first.
fn duration(periods: u8) -> [u8; 4] {
    [0, 2, 4, 6].map(|shift| DURATION | periods << shift & 0xC0)
}

/// Commands are sent back, and bytes for the next board on the line are sent on, counted down by one.
fn answer(byte: u8) -> Option<u8> {
    match byte {
        _ if byte & 0x0F == MINE => None,
        SWAP | COMMIT_DURATIONS => Some(byte),
        _ if byte & 0x3F == DURATION => Some(byte),
        _ => Some(byte - 1),
    }
}

/// The boot loaders' time for the first byte.
const FIRST_BYTE: Duration = Duration::from_secs(1);
/// The factory's time for the next byte.
const NEXT_BYTE: Duration = Duration::from_secs(8);
/// Optiboot's time to the watchdog's reset after a byte that is no command.
const WATCHDOG: Duration = Duration::from_millis(16);

/// A running boot loader.
#[derive(Debug)]
struct Booting {
    loader: BootLoader,
    now: Instant,
    ends: Instant,
}

/// The board's side.
#[derive(Debug)]
struct Twin {
    booting: Option<Booting>,
    shown: [u8; PATTERN],
    hidden: [u8; PATTERN],
    /// Index of the next half byte.
    index: usize,
}

impl Twin {
    /// The state in which the firmware starts: every pin high for the first half of each period.
    fn new() -> Self {
        let mut shown = [0; PATTERN];
        shown[..PATTERN / 2].fill(0xFF);
        Self { booting: None, shown, hidden: [0; PATTERN], index: 0 }
    }

    fn store(&mut self, byte: u8) {
        let half = byte & 0xF0;
        let whole = &mut self.hidden[self.index / 2];
        *whole = if self.index.is_multiple_of(2) { half } else { *whole | half >> 4 };
        self.index += 1;
    }

    fn exchange(&mut self) -> Heard {
        let torn = ![0, 2 * PATTERN].contains(&self.index);
        std::mem::swap(&mut self.shown, &mut self.hidden);
        self.index = 0;
        if torn { Heard::Nonsense } else { Heard::Shown }
    }

    /// The one pulse of a pin; of several, the first that begins.
    fn pulse(&self, pin: usize) -> Option<Level> {
        let high = |division: usize| self.shown[division % DIVISIONS * PORTS + pin / 8] >> (pin % 8) & 1 == 1;
        let rises = |&division: &usize| high(division) && !high(division + DIVISIONS - 1);
        let delay = (0..DIVISIONS).find(rises)?;
        let amplitude = (delay..).take_while(|&division| high(division)).count();
        Some(Level { delay: delay as u16, amplitude: amplitude as u16 })
    }
}

impl Emulation for Twin {
    fn reset(&mut self, loader: BootLoader, now: Instant) {
        *self = Self { booting: Some(Booting { loader, now, ends: now + FIRST_BYTE }), ..Self::new() };
    }

    fn pass(&mut self, now: Instant) {
        if let Some(booting) = &mut self.booting {
            booting.now = now;
        }
        self.booting.take_if(|booting| booting.ends <= now);
    }

    fn boots(&self) -> bool {
        self.booting.is_some()
    }

    fn push(&mut self, byte: u8) -> Heard {
        if let Some(Booting { loader, now, ends }) = &mut self.booting {
            *ends = match loader {
                BootLoader::Factory => *now + NEXT_BYTE,
                BootLoader::Optiboot => (*ends).min(*now + WATCHDOG),
            };
            return Heard::Nonsense;
        }
        match byte {
            SWAP => return self.exchange(),
            COMMIT_DURATIONS => {}
            _ if byte & 0x3F == DURATION => {}
            _ if byte & 0x0F == MINE && self.index < 2 * PATTERN => self.store(byte),
            _ => return Heard::Nonsense,
        }
        Heard::Part
    }

    fn shown(&self) -> Vec<Option<Level>> {
        // The boot loader's pins are inputs.
        PINS.map(|pin| if self.boots() { None } else { self.pulse(pin) }).to_vec()
    }
}
