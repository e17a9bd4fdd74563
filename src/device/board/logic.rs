//! What a board does with bytes: answers, and plays.

use std::f64::consts::{PI, TAU};
use std::time::{Duration, Instant};

use crate::device::levels::Level;
use crate::device::levels::Levels;
use crate::device::native::model::{CHANNELS, Model, Pulse};
use crate::device::native::packet::{BROADCAST, Body, Kind, Outcome, Packet, Reply, Splitter};
use crate::device::native::version_1;
use crate::device::profile::Profile;
use crate::device::stock::mega64;
use crate::device::stock::{Heard, Twin};
use crate::drive::Drive;

/// A frame that was shown, whole or not.
#[derive(Clone, Debug)]
pub struct Shown {
    /// When the last byte of it was on the line.
    pub at: Instant,
    pub levels: Levels,
}

/// What can be seen from outside.
#[derive(Clone, Debug)]
pub enum Playing {
    Levels(Levels),
    /// Pulses of a period, in levels.
    Pulses {
        levels: u16,
        pulses: Box<[Pulse; CHANNELS]>,
        outputs_on: bool,
    },
}

impl Playing {
    /// Amplitude and phase of every element, the same offset of phase left out for all.
    pub fn drive(&self) -> Drive {
        match self {
            Self::Levels(levels) => levels.drive(),
            Self::Pulses { levels, pulses, outputs_on } => {
                let sound = |pulse: &Pulse| fundamental(*pulse, *levels, *outputs_on);
                let (amplitudes, phases) = pulses.iter().map(sound).unzip();
                Drive { amplitudes, phases }
            }
        }
    }
}

/// Amplitude (1 for half a period) and phase (rad, in (-π, π]) of a pulse's fundamental.
fn fundamental(pulse: Pulse, levels: u16, on: bool) -> (f64, f64) {
    let (rise, width, levels) = (f64::from(pulse.rise), f64::from(pulse.width), f64::from(levels));
    let turns = (-(rise + width / 2.0) / levels).rem_euclid(1.0);
    let amplitude = if on { (PI * width / levels).sin() } else { 0.0 };
    (amplitude, TAU * if turns > 0.5 { turns - 1.0 } else { turns })
}

/// What a board made of bytes.
#[derive(Debug, Default)]
pub struct Heeded {
    pub shown: Vec<Shown>,
    /// Bytes, lists or packets that made no sense.
    pub spoiled: u64,
    pub answer: Vec<u8>,
}

/// A stock board.
#[derive(Debug)]
pub struct Stock {
    twin: Twin,
    profile: Profile,
}

impl Stock {
    pub fn new(profile: Profile) -> Self {
        Self { twin: Twin::new(profile), profile }
    }

    pub fn hear(&mut self, byte: u8, at: Instant, heeded: &mut Heeded) {
        let heard = self.twin.push(byte);
        heeded.spoiled += u64::from(heard == Heard::Nonsense);
        if heard == Heard::Shown {
            heeded.shown.push(Shown { at, levels: self.twin.shown() });
        }
        if self.profile == Profile::UltrainoMega64 && byte == mega64::SWAP {
            heeded.answer.push(byte);
        }
    }

    pub fn playing(&self) -> Playing {
        Playing::Levels(self.twin.shown())
    }
}

/// The native device in time.
#[derive(Debug)]
pub struct Native {
    model: Model,
    splitter: Splitter,
    /// A byte without a stop bit since the last delimiter.
    unframed: bool,
    /// How far the model has come.
    at: Instant,
}

impl Native {
    pub fn new(model: Model, now: Instant) -> Self {
        Self { model, splitter: Splitter::default(), unframed: false, at: now }
    }

    pub fn baud(&self) -> f64 {
        self.model.baud()
    }

    /// Runs the periods that are over. What was missed for too long is left out: nobody looked.
    pub fn run_until(&mut self, now: Instant) {
        const LONGEST: u32 = 1000;
        let period = Duration::from_secs_f64(1.0 / self.model.carrier());
        if now.saturating_duration_since(self.at) > period * LONGEST {
            self.at = now - period * LONGEST;
        }
        while self.at + period <= now {
            self.at += period;
            self.model.period();
        }
    }

    pub fn hear(&mut self, byte: u8, unframed: bool, at: Instant, heeded: &mut Heeded) {
        self.unframed |= unframed;
        let Some(part) = self.splitter.push(byte) else { return };
        self.run_until(at);
        let unframed = std::mem::take(&mut self.unframed);
        match Packet::of_line(&part) {
            Ok(packet) if !unframed && self.model.heeds(&packet) => {
                let reply = self.model.apply(&packet);
                heeded.shown.extend(committed(&packet, &reply).map(|levels| Shown { at, levels }));
                if packet.address != BROADCAST {
                    heeded.answer.extend(reply.to_line());
                }
            }
            Ok(_) if !unframed => return,
            Ok(_) | Err(_) => {
                heeded.spoiled += 1;
                heeded.answer.extend(self.spoiled(&part, unframed));
            }
        }
        // One packet a period goes through the gate.
        self.model.period();
        self.at += Duration::from_secs_f64(1.0 / self.model.carrier());
    }

    /// The answer to bytes that were no packet, or that were version 1's INFO.
    fn spoiled(&mut self, part: &[u8], unframed: bool) -> Vec<u8> {
        match version_1::asked(part) {
            Ok(seq) if !unframed => self.model.introduce(seq).map(|answer| answer.to_line()),
            Ok(_) | Err(_) => self.model.spoil(unframed).map(|reply| reply.to_line()),
        }
        .unwrap_or_default()
    }

    pub fn press(&mut self, pressed: bool) {
        self.model.press(pressed);
    }

    pub fn playing(&self) -> Playing {
        Playing::Pulses {
            levels: self.model.levels(),
            pulses: Box::new(*self.model.played()),
            outputs_on: self.model.outputs_on(),
        }
    }
}

/// The frame that a packet put on, if the device took it.
pub fn committed(packet: &Packet, reply: &Reply) -> Option<Levels> {
    let [_, amplitude, flags, _] = packet.arguments;
    if reply.outcome != Outcome::Ok || flags & 1 == 0 || !matches!(reply.body, Body::Status(_)) {
        return None;
    }
    let level = |phase: u8, amplitude: u8| {
        (amplitude > 0).then(|| Level { delay: u16::from(phase), amplitude: u16::from(amplitude) })
    };
    let elements = match Kind::of_code(packet.code)? {
        Kind::Phases => packet.payload.iter().map(|&phase| level(phase, amplitude)).collect(),
        Kind::Frame => packet.payload.as_chunks::<2>().0.iter().map(|&[p, a]| level(p, a)).collect(),
        _ => return None,
    };
    Some(Levels { profile: Profile::Native, elements })
}
