//! The Verilated device beside its model: both receive the same input, and every period is compared.

use std::collections::VecDeque;

use sonoglyph::device::native::model::{Model, Pulse};
use sonoglyph::device::native::packet::{BROADCAST, Body, Kind, Outcome, Packet, REPLY, Reply, Splitter};
use sonoglyph::device::native::version_1;

use crate::gateware::simulated::{Period, Simulated};

/// Limit of unanswered packets.
pub const WINDOW: usize = 4;

/// A simulated device and its model.
pub struct Twins {
    pub simulated: Simulated,
    pub twin: Twin,
}

/// The model of a device, with the expected answers.
pub struct Twin {
    pub model: Model,
    seq: u8,
    /// Sent, but not yet through the gate.
    sent: VecDeque<Packet>,
    /// Answers of the model that the device has not given yet.
    expected: VecDeque<Reply>,
    splitter: Splitter,
    /// All received answers, the newest last.
    pub answers: Vec<Reply>,
    /// Number of received answers in the form of version 1.
    pub introductions: u32,
    pub periods: u32,
    /// Number of periods with sound.
    pub sounding: u32,
    /// Number of answers to corrupted packets.
    pub spoiled: u16,
    /// Periods with a high trigger output.
    pub triggers: Vec<u32>,
}

impl Twins {
    pub fn start(phase_bits: u8) -> Option<Self> {
        let simulated = Simulated::start(phase_bits)?;
        Some(Self { simulated, twin: Twin::new(Model::new(phase_bits)) })
    }

    pub fn start_with_256_slots() -> Option<Self> {
        let simulated = Simulated::start_with_256_slots()?;
        Some(Self { simulated, twin: Twin::new(Model::new(7).with_slots(256)) })
    }

    /// Sends a packet with the next number, without waiting for its answer.
    pub fn send(&mut self, packet: Packet) {
        let packet = self.twin.numbered(packet);
        self.simulated.send(&packet.to_line());
        self.twin.is_sent(packet);
    }

    /// Sends a packet, and runs until its answer.
    pub fn ask(&mut self, packet: Packet) -> Reply {
        self.send(packet);
        self.settle();
        *self.twin.answers.last().unwrap()
    }

    /// Sends a packet that must succeed.
    pub fn order(&mut self, packet: Packet) {
        let reply = self.ask(packet);
        assert_eq!(reply.outcome, Outcome::Ok, "{reply:?}");
    }

    /// Sends INFO of version 1 without other unanswered packets, and runs until its answer.
    pub fn introduce(&mut self) {
        self.settle();
        self.simulated.send(&version_1::info(77));
        let (before, late) = (self.twin.introductions, self.twin.periods + 100);
        while self.twin.introductions == before {
            assert!(self.twin.periods < late, "INFO of version 1 is not answered");
            self.run(1);
        }
    }

    /// Runs until all packets are answered.
    pub fn settle(&mut self) {
        let late = self.twin.periods + 10_000;
        while self.twin.unanswered() > 0 {
            assert!(self.twin.periods < late, "{} packets are not answered", self.twin.unanswered());
            self.run(4);
        }
    }

    pub fn press(&mut self, pressed: bool) {
        self.simulated.press(pressed);
        self.twin.model.press(pressed);
    }

    /// A pulse at the trigger input, within a period.
    pub fn trigger(&mut self) {
        self.simulated.trigger(true);
        self.twin.model.trigger();
        self.run(1);
        self.simulated.trigger(false);
    }

    /// Runs periods and compares each.
    pub fn run(&mut self, periods: u32) {
        for period in self.simulated.run(periods) {
            self.twin.compare(period);
        }
    }
}

impl Twin {
    pub fn new(model: Model) -> Self {
        Self {
            model,
            seq: 0,
            sent: VecDeque::new(),
            expected: VecDeque::new(),
            splitter: Splitter::default(),
            answers: Vec::new(),
            introductions: 0,
            periods: 0,
            sounding: 0,
            spoiled: 0,
            triggers: Vec::new(),
        }
    }

    pub fn unanswered(&self) -> usize {
        self.sent.len() + self.expected.len()
    }

    pub fn numbered(&mut self, packet: Packet) -> Packet {
        self.seq = self.seq.wrapping_add(1);
        packet.numbered(self.seq)
    }

    /// Registers a packet that goes to the device, if the device heeds it.
    pub fn is_sent(&mut self, packet: Packet) {
        if self.model.heeds(&packet) {
            self.sent.push_back(packet);
        }
    }

    pub fn compare(&mut self, period: Period) {
        self.model.follow(period.follows);
        let expected = *self.model.period();
        if let Some(n) = (0..256).find(|&n| period.pulses[n] != expected[n]) {
            panic!(
                "period {}, channel {n}: {:?} instead of {:?}",
                self.periods, period.pulses[n], expected[n]
            );
        }
        let on = self.model.outputs_on();
        assert_eq!(period.outputs_on, on, "outputs in period {}", self.periods);
        // ENABLE releases the emergency stop in the middle of a period.
        let enabled = period.gate.is_some_and(|[code, _, _]| code == Kind::Enable.code());
        assert!(on || enabled || !period.outputs_ever_on, "outputs in period {}", self.periods);
        assert_eq!(period.marked, self.model.marks(), "the mark of period {}", self.periods);
        assert_eq!(period.triggers, self.model.triggers(), "the trigger of period {}", self.periods);
        if period.triggers {
            self.triggers.push(self.periods);
        }
        self.sounding += u32::from(on && expected.iter().any(|&pulse| pulse != Pulse::default()));
        if let Some([code, seq, result]) = period.gate {
            let packet = self.sent.pop_front().expect("only sent packets pass the gate");
            assert_eq!((code, seq), (packet.code, packet.seq), "the packet in the gate");
            let reply = self.model.apply(&packet);
            assert_eq!(result, reply.outcome.code(), "the result of {:02x?}", &packet.to_line()[..8]);
            if packet.address != BROADCAST {
                self.expected.push_back(reply);
            }
        }
        for byte in period.received {
            if let Some(line) = self.splitter.push(byte) {
                match Reply::of_line(&line) {
                    Ok(reply) => self.answer(reply),
                    Err(_) => self.introduction(&line),
                }
            }
        }
        self.periods += 1;
    }

    fn answer(&mut self, reply: Reply) {
        if reply.code == REPLY {
            // The moment of the corruption cannot be seen from outside.
            let Body::Status(status) = reply.body else { panic!("{reply:?}") };
            let before = self.answers.iter().rev().find_map(|reply| match reply.body {
                Body::Status(status) => Some(status.framing_errors),
                Body::Digest(digest) => Some(digest.framing_errors),
                Body::Info(_) => None,
            });
            let spoiled = self.model.spoil(status.framing_errors != before.unwrap_or(0));
            let mut expected = spoiled.expect("the device at address 0 answers");
            let Body::Status(counts) = &mut expected.body else { panic!("{expected:?}") };
            assert!(counts.periods - status.periods < 64, "{reply:?}, now {}", counts.periods);
            counts.periods = status.periods;
            assert_eq!(reply, expected);
            self.spoiled += 1;
        } else {
            assert_eq!(Some(reply), self.expected.pop_front());
        }
        self.answers.push(reply);
    }

    /// Compares an answer to INFO of version 1.
    fn introduction(&mut self, line: &[u8]) {
        let expected = self.model.introduce(77).expect("the device at address 0 answers").to_line();
        assert_eq!(line, expected.strip_suffix(&[0]).unwrap(), "a whole answer in either form");
        self.introductions += 1;
    }
}
