//! A virtual board in the program's memory: written bytes arrive at the rate of its line.

use std::collections::VecDeque;

use web_time::{Duration, Instant};

use crate::device::board::logic::{BAUD_TOLERANCE, Heeded, Native, Playing, Shown};
use crate::device::declaration::BootLoader;
use crate::device::native::model::Model;
use crate::device::pace::Pace;
use crate::device::profile::Profile;
use crate::device::stock::Twin;

/// Phase bits of the native device.
const PHASE_BITS: u8 = 7;

#[derive(Debug)]
enum Logic {
    /// It reads any bit rate.
    Stock(Twin),
    Native(Box<Native>),
}

/// A board and the line to it.
#[derive(Debug)]
pub struct VirtualBoard {
    logic: Logic,
    baud: f64,
    pace: Pace,
    /// Bytes on the line, when each arrives, and at which bit rate.
    coming: VecDeque<(Instant, u8, f64)>,
    answers: Vec<u8>,
    shown: Vec<Shown>,
}

impl VirtualBoard {
    pub fn new(profile: Profile, baud: u32) -> Self {
        let now = Instant::now();
        let native = || Native::new(&Model::new(PHASE_BITS), profile.devices(), now);
        let logic = match profile.answers() {
            true => Logic::Native(Box::new(native())),
            false => Logic::Stock(Twin::new(profile)),
        };
        let baud = f64::from(baud);
        let (coming, answers, shown) = (VecDeque::new(), Vec::new(), Vec::new());
        Self { logic, baud, pace: Pace::new(baud, now), coming, answers, shown }
    }

    /// Its port was opened, which resets a board with a boot loader.
    pub(in crate::device) fn reset(&mut self) {
        match &mut self.logic {
            Logic::Stock(twin) => twin.reset(BootLoader::Factory, Instant::now()),
            Logic::Native(_) => {}
        }
    }

    /// The other end's bit rate, from the next byte on.
    pub fn set_baud(&mut self, baud: u32) {
        self.baud = f64::from(baud);
        self.pace = Pace::new(self.baud, Instant::now());
    }

    pub fn write(&mut self, bytes: &[u8]) {
        let now = Instant::now();
        for &byte in bytes {
            self.coming.push_back((self.pace.sent(1, now), byte, self.baud));
        }
        self.run();
    }

    /// Drops the bytes that have not arrived.
    pub fn discard(&mut self) {
        self.run();
        self.coming.clear();
        self.pace = Pace::new(self.baud, Instant::now());
    }

    /// Its answers since the last call.
    pub fn read(&mut self) -> Vec<u8> {
        self.run();
        std::mem::take(&mut self.answers)
    }

    /// The shown frames since the last call.
    pub fn frames(&mut self) -> Vec<Shown> {
        self.run();
        std::mem::take(&mut self.shown)
    }

    pub fn playing(&mut self) -> Playing {
        self.run();
        match &self.logic {
            Logic::Stock(twin) => Playing::Levels(twin.shown()),
            Logic::Native(native) => native.playing(),
        }
    }

    /// When the next byte arrives, or a moment from now.
    pub fn next_in(&self) -> Duration {
        const MOMENT: Duration = Duration::from_micros(500);
        let next = self.coming.front().map(|(at, ..)| at.saturating_duration_since(Instant::now()));
        next.unwrap_or(MOMENT).min(MOMENT)
    }

    /// Up to now.
    fn run(&mut self) {
        let now = Instant::now();
        let mut heeded = Heeded::default();
        while let Some((at, byte, baud)) = self.coming.pop_front_if(|(at, ..)| *at <= now) {
            match &mut self.logic {
                Logic::Stock(twin) => heeded.hear(twin, byte, at),
                Logic::Native(native) => {
                    let unread = (baud / native.baud() - 1.0).abs() > BAUD_TOLERANCE;
                    native.hear(byte, unread, at, &mut heeded);
                }
            }
        }
        match &mut self.logic {
            Logic::Stock(twin) => twin.pass(now),
            Logic::Native(native) => native.run_until(now),
        }
        self.answers.append(&mut heeded.answer);
        // Without calls of `frames`, only the latest are kept.
        const KEPT: usize = 1024;
        self.shown.append(&mut heeded.shown);
        self.shown.drain(..self.shown.len().saturating_sub(KEPT));
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;

    use super::*;
    use crate::device::native::packet::{Outcome, Packet, Reply, Splitter};
    use crate::device::stock;

    const MILLI: Duration = Duration::from_millis(1);

    fn native() -> VirtualBoard {
        VirtualBoard::new(Profile::Native, Profile::Native.baud())
    }

    /// The answer to a question, within half a second.
    fn answer(board: &mut VirtualBoard) -> Option<Reply> {
        let mut splitter = Splitter::default();
        let part = (0..500).find_map(|_| {
            sleep(MILLI);
            board.read().into_iter().find_map(|byte| splitter.push(byte))
        });
        part.and_then(|part| Reply::of_line(&part).ok())
    }

    #[test]
    fn bytes_arrive_at_the_rate_that_they_were_sent_at() {
        let mut board = native();
        for (now, next, outcome) in [(Profile::Native.baud(), 9600, Outcome::Ok), (9600, 9600, Outcome::Crc)]
        {
            board.set_baud(now);
            board.write(&Packet::info().to_line());
            // The bytes are still on the line.
            board.set_baud(next);
            assert_eq!(answer(&mut board).map(|reply| reply.outcome), Some(outcome), "{now}");
        }
    }

    #[test]
    fn the_next_byte_is_awaited_and_never_for_more_than_a_moment() {
        let profile = Profile::SonicSurface;
        let waits = |baud: u32, count: usize| {
            let mut board = VirtualBoard::new(profile, baud);
            board.write(&vec![0; count]);
            board.next_in()
        };
        // A byte in ten seconds, and bytes in a third of a millisecond each.
        let moment = waits(1, 0);
        assert_eq!(waits(1, 1), moment);
        assert!(waits(30_000, 10_000) < moment);
    }

    #[test]
    fn only_the_latest_shown_frames_are_kept() {
        let mut board = VirtualBoard::new(Profile::UltrainoMega64, u32::MAX);
        let swap = stock::swap(Profile::UltrainoMega64).unwrap();
        board.write(&[swap; 1100]);
        sleep(5 * MILLI);
        // Those of a board that is only written to, too.
        board.write(&[]);
        assert_eq!((board.coming.len(), board.shown.len()), (0, 1024));
        assert_eq!(board.frames().len(), 1024);
    }

    #[test]
    fn sound_goes_on_while_nothing_is_sent() {
        let mut board = native();
        let frame = |slot: u8| Packet::phases(slot, 255, &[64 * slot; 256], false);
        for packet in [frame(1), frame(2), Packet::silencer(0xFFFF, 0xFFFF), Packet::enable(10_000)] {
            board.write(&packet.to_line());
        }
        board.write(&Packet::play(1, 2, 400, 0, false).to_line());
        let mut heard = Vec::new();
        for _ in 0..500 {
            sleep(MILLI);
            let first = board.playing().drive();
            let first = (first.amplitudes[0], first.phases[0]);
            if first.0 > 0.0 && heard.last() != Some(&first) {
                heard.push(first);
            }
            if heard.len() > 3 {
                return;
            }
        }
        panic!("{heard:?}");
    }
}
