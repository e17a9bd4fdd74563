//! The Verilated device and the model side by side: whatever goes to one goes to the other, and every period is compared.

use std::collections::VecDeque;

use sonoglyph::device::native::model::{Model, Pulse};
use sonoglyph::device::native::packet::{Body, Outcome, Packet, REPLY, Reply, Splitter};

use crate::simulated::{Period, Simulated};

/// Packets that may be unanswered.
pub const WINDOW: usize = 4;

pub struct Twins {
    pub simulated: Simulated,
    pub model: Model,
    seq: u8,
    /// Sent, and not through the gate.
    sent: VecDeque<Packet>,
    /// What the model has answered and the device has not yet.
    expected: VecDeque<Reply>,
    splitter: Splitter,
    /// All answers that came, the newest last.
    pub answers: Vec<Reply>,
    pub periods: u32,
    /// Periods in which something was to be heard.
    pub sounding: u32,
    /// Answers to packets that were spoiled on the way.
    pub spoiled: u16,
}

impl Twins {
    pub fn start(phase_bits: u8) -> Option<Self> {
        Some(Self {
            simulated: Simulated::start(phase_bits)?,
            model: Model::new(phase_bits),
            seq: 0,
            sent: VecDeque::new(),
            expected: VecDeque::new(),
            splitter: Splitter::default(),
            answers: Vec::new(),
            periods: 0,
            sounding: 0,
            spoiled: 0,
        })
    }

    pub fn unanswered(&self) -> usize {
        self.sent.len() + self.expected.len()
    }

    /// Sends a packet under the next number, without waiting for its answer.
    pub fn send(&mut self, packet: Packet) {
        let packet = self.numbered(packet);
        self.simulated.send(&packet.to_line());
        self.sent.push_back(packet);
    }

    pub fn numbered(&mut self, packet: Packet) -> Packet {
        self.seq = self.seq.wrapping_add(1);
        packet.numbered(self.seq)
    }

    /// Sends a packet, and goes on until it is answered.
    pub fn ask(&mut self, packet: Packet) -> Reply {
        self.send(packet);
        self.settle();
        *self.answers.last().unwrap()
    }

    /// Sends a packet that has to succeed.
    pub fn order(&mut self, packet: Packet) {
        let reply = self.ask(packet);
        assert_eq!(reply.outcome, Outcome::Ok, "{reply:?}");
    }

    /// Goes on until everything is answered.
    pub fn settle(&mut self) {
        let late = self.periods + 10_000;
        while self.unanswered() > 0 {
            assert!(self.periods < late, "{} packets are not answered", self.unanswered());
            self.run(4);
        }
    }

    pub fn press(&mut self, pressed: bool) {
        self.simulated.press(pressed);
        self.model.press(pressed);
    }

    /// Goes on by so many periods and compares each.
    pub fn run(&mut self, periods: u32) {
        for period in self.simulated.run(periods) {
            self.compare(period);
        }
    }

    fn compare(&mut self, period: Period) {
        let expected = *self.model.period();
        if let Some(n) = (0..256).find(|&n| period.pulses[n] != expected[n]) {
            panic!(
                "period {}, channel {n}: {:?} instead of {:?}",
                self.periods, period.pulses[n], expected[n]
            );
        }
        let on = self.model.outputs_on();
        assert_eq!(period.outputs_on, on, "outputs in period {}", self.periods);
        self.sounding += u32::from(on && expected.iter().any(|&pulse| pulse != Pulse::default()));
        if let Some([code, seq, result]) = period.gate {
            let packet = self.sent.pop_front().expect("only what was sent goes through the gate");
            assert_eq!((code, seq), (packet.code, packet.seq), "the packet in the gate");
            let reply = self.model.apply(&packet);
            assert_eq!(result, reply.outcome.code(), "the result of {:02x?}", &packet.to_line()[..8]);
            self.expected.push_back(reply);
        }
        for byte in period.received {
            if let Some(line) = self.splitter.push(byte) {
                self.answer(Reply::of_line(&line).expect("the device sends whole answers"));
            }
        }
        self.periods += 1;
    }

    fn answer(&mut self, reply: Reply) {
        if reply.code == REPLY {
            // When it was spoiled is not to be seen from outside.
            let Body::Status(status) = reply.body else { panic!("{reply:?}") };
            let before = self.answers.iter().rev().find_map(|reply| match reply.body {
                Body::Status(status) => Some(status.framing_errors),
                Body::Info(_) => None,
            });
            let mut expected = self.model.spoil(status.framing_errors != before.unwrap_or(0));
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
}
