//! The logic of virtual boards: answers and playback.

use std::f64::consts::{PI, TAU};

use web_time::{Duration, Instant};

use crate::device::declaration::{Heard, Level};
use crate::device::levels::Levels;
use crate::device::native::model::{CHANNELS, Model, Pulse};
use crate::device::native::packet::{BROADCAST, Kind, Outcome, Packet, Reply, Splitter};
use crate::device::native::version_1;
use crate::device::profile::Profile;
use crate::device::stock::Twin;
use crate::drive::Drive;

/// Relative difference of bit rates beyond which bytes are garbled.
pub const BAUD_TOLERANCE: f64 = 0.04;

/// A shown frame, complete or not.
#[derive(Clone, Debug)]
pub struct Shown {
    /// When the last byte of it was on the line.
    pub at: Instant,
    pub levels: Levels,
}

/// The observable output of a board.
#[derive(Clone, Debug)]
pub enum Playing {
    Levels(Levels),
    /// Pulses of a period, in levels.
    Pulses {
        levels: u16,
        pulses: Vec<Pulse>,
        outputs_on: bool,
    },
}

impl Playing {
    /// Amplitude and phase of every element, up to a common phase.
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

/// The effects of bytes on a board.
#[derive(Debug, Default)]
pub struct Heeded {
    pub shown: Vec<Shown>,
    /// Invalid bytes, lists or packets.
    pub spoiled: u64,
    pub answer: Vec<u8>,
}

impl Heeded {
    /// Gives a stock board a byte.
    pub fn hear(&mut self, twin: &mut Twin, byte: u8, at: Instant) {
        twin.pass(at);
        let heard = twin.push(byte);
        self.spoiled += u64::from(heard == Heard::Nonsense);
        if heard == Heard::Shown {
            self.shown.push(Shown { at, levels: twin.shown() });
        }
        self.answer.extend(twin.answer(byte));
    }
}

/// Native devices on one line, in time; all of them follow the first.
#[derive(Debug)]
pub struct Native {
    /// Models by address.
    models: Vec<Model>,
    splitter: Splitter,
    /// A byte without a stop bit since the last delimiter.
    unframed: bool,
    /// Current time of the model.
    at: Instant,
}

impl Native {
    /// `devices` copies of this model.
    pub fn new(model: &Model, devices: usize, now: Instant) -> Self {
        let device = |address: usize| {
            let mut device = model.clone().with_address(address as u8);
            device.follow(address > 0);
            device
        };
        Self {
            models: (0..devices).map(device).collect(),
            splitter: Splitter::default(),
            unframed: false,
            at: now,
        }
    }

    /// Bit rate of the line.
    pub fn baud(&self) -> f64 {
        self.models[0].baud()
    }

    fn carrier(&self) -> f64 {
        self.models[0].carrier()
    }

    /// One period of all devices: the leader's mark is seen by the others in it.
    fn period(&mut self) {
        let Some((leader, followers)) = self.models.split_first_mut() else { return };
        leader.period();
        for follower in followers {
            if leader.marks() {
                follower.mark();
            }
            follower.period();
        }
    }

    /// Runs the elapsed periods. After a long pause, unobserved periods are skipped.
    pub fn run_until(&mut self, now: Instant) {
        const LONGEST: u32 = 1000;
        let period = Duration::from_secs_f64(1.0 / self.carrier());
        if now.saturating_duration_since(self.at) > period * LONGEST {
            self.at = now - period * LONGEST;
        }
        while self.at + period <= now {
            self.at += period;
            self.period();
        }
    }

    pub fn hear(&mut self, byte: u8, unframed: bool, at: Instant, heeded: &mut Heeded) {
        self.unframed |= unframed;
        let Some(part) = self.splitter.push(byte) else { return };
        self.run_until(at);
        let unframed = std::mem::take(&mut self.unframed);
        match Packet::of_line(&part) {
            Ok(packet) if !unframed => self.heed(&packet, at, heeded),
            Ok(_) | Err(_) => {
                heeded.spoiled += 1;
                heeded.answer.extend(self.spoiled(&part, unframed));
            }
        }
        // One packet a period goes through the gate.
        self.period();
        self.at += Duration::from_secs_f64(1.0 / self.carrier());
    }

    /// A packet goes to its device, or to all. A frame of several devices is counted with its leader's part.
    fn heed(&mut self, packet: &Packet, at: Instant, heeded: &mut Heeded) {
        for (address, model) in self.models.iter_mut().enumerate().filter(|(_, model)| model.heeds(packet)) {
            let reply = model.apply(packet);
            if address == 0 {
                heeded.shown.extend(committed(packet, &reply).map(|levels| Shown { at, levels }));
            }
            if packet.address != BROADCAST {
                heeded.answer.extend(reply.to_line());
            }
        }
    }

    /// The answer to bytes that were no packet, or that were version 1's INFO.
    fn spoiled(&mut self, part: &[u8], unframed: bool) -> Vec<u8> {
        let asked = version_1::asked(part).ok().filter(|_| !unframed);
        let answer = |model: &mut Model| match asked {
            Some(seq) => model.introduce(seq).map(|answer| answer.to_line()),
            None => model.spoil(unframed).map(|reply| reply.to_line()),
        };
        self.models.iter_mut().filter_map(answer).flatten().collect()
    }

    #[cfg(unix)]
    pub fn press(&mut self, pressed: bool) {
        self.models.iter_mut().for_each(|model| model.press(pressed));
    }

    pub fn playing(&self) -> Playing {
        let pulses = |model: &Model| match model.outputs_on() {
            true => *model.played(),
            false => [Pulse::default(); CHANNELS],
        };
        Playing::Pulses {
            levels: self.models[0].levels(),
            pulses: self.models.iter().flat_map(pulses).collect(),
            outputs_on: self.models.iter().any(Model::outputs_on),
        }
    }
}

/// The frame that a packet put on, if the device took it.
pub fn committed(packet: &Packet, reply: &Reply) -> Option<Levels> {
    let amplitude = packet.arguments[1];
    if reply.outcome != Outcome::Ok || !packet.commits() {
        return None;
    }
    let level = |phase: u8, amplitude: u8| {
        (amplitude > 0).then(|| Level { delay: u16::from(phase), amplitude: u16::from(amplitude) })
    };
    let channels = match Kind::from_repr(packet.code) == Some(Kind::Phases) {
        true => packet.payload.iter().map(|&phase| level(phase, amplitude)).collect(),
        false => packet.payload.as_chunks::<2>().0.iter().map(|&[p, a]| level(p, a)).collect(),
    };
    Some(Levels { profile: Profile::Native, channels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::native::packet::Body;

    #[test]
    fn phases_end_at_half_a_turn() {
        let of = |rise| fundamental(Pulse { rise, width: 128 }, 256, true);
        for (rise, phase) in [(64, PI), (192, 0.0), (0, -PI / 2.0), (128, PI / 2.0)] {
            let (amplitude, got) = of(rise);
            assert!(amplitude == 1.0 && (got - phase).abs() < 1e-12, "{rise}: {amplitude}, {got}");
        }
    }

    #[test]
    fn a_packet_takes_one_period() {
        let now = Instant::now();
        let mut line = Native::new(&Model::new(7), 1, now);
        let period = Duration::from_secs_f64(1.0 / line.carrier());
        for byte in Packet::stop().to_line() {
            line.hear(byte, false, now, &mut Heeded::default());
        }
        let periods = |line: &mut Native| match line.models[0].apply(&Packet::status()).body {
            Body::Status(status) => status.periods,
            body => panic!("{body:?}"),
        };
        assert_eq!((line.at, periods(&mut line)), (now + period, 1));
        // And no period begins before its time.
        line.run_until(now + period * 21 / 2);
        assert_eq!((line.at, periods(&mut line)), (now + period * 10, 10));
    }

    #[test]
    fn the_periods_before_a_packet_are_run_before_it() {
        let (now, period, mut heeded) = (Instant::now(), Duration::from_micros(25), Heeded::default());
        let mut line = Native::new(&Model::new(7), 1, now);
        for byte in Packet::status().to_line() {
            line.hear(byte, false, now + period * 10, &mut heeded);
        }
        let reply = Reply::of_line(heeded.answer.strip_suffix(&[0]).unwrap()).unwrap();
        let Body::Status(status) = reply.body else { panic!("{reply:?}") };
        assert_eq!((status.periods, line.at), (10, now + period * 11));
    }

    #[test]
    fn elapsed_periods_are_run_but_only_the_last_of_a_long_pause() {
        let (now, period) = (Instant::now(), Duration::from_micros(25));
        for (elapsed, periods) in [(0, 0), (1, 1), (999, 999), (1000, 1000), (40_000, 1000)] {
            let mut line = Native::new(&Model::new(7), 1, now);
            line.run_until(now + period * elapsed);
            assert_eq!(line.at, now + period * elapsed);
            let Body::Status(status) = line.models[0].apply(&Packet::status()).body else { panic!() };
            assert_eq!(status.periods, periods, "of {elapsed}");
        }
    }

    #[test]
    fn info_of_version_1_is_answered_in_its_form_unless_a_stop_bit_is_missing() {
        for unframed in [false, true] {
            let (now, mut heeded) = (Instant::now(), Heeded::default());
            let mut line = Native::new(&Model::new(7), 2, now);
            for byte in version_1::info(9) {
                line.hear(byte, unframed, now, &mut heeded);
            }
            let mut device = Model::new(7);
            let answer = match unframed {
                false => device.introduce(9).unwrap().to_line(),
                true => device.spoil(true).unwrap().to_line(),
            };
            assert_eq!((heeded.answer, heeded.spoiled), (answer, 1), "without a stop bit: {unframed}");
        }
    }

    #[test]
    fn a_line_sounds_while_any_of_its_devices_does() {
        let now = Instant::now();
        let mut line = Native::new(&Model::new(7), 2, now);
        let sounds = |line: &Native| matches!(line.playing(), Playing::Pulses { outputs_on: true, .. });
        assert!(!sounds(&line));
        // The first of them.
        for byte in Packet::enable(100).to_line() {
            line.hear(byte, false, now, &mut Heeded::default());
        }
        line.run_until(now + Duration::from_millis(1));
        assert!(sounds(&line));
    }
}
