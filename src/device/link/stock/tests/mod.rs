//! Sessions with emulated boards in simulated time: the sound of random wishes, also on lines that lose bytes.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod switching;
mod wishes;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};

use fastrand::Rng;
use web_time::{Duration, Instant};

use crate::device::board::faults::{Damage, Faults};
use crate::device::board::logic::Heeded;
use crate::device::declaration::Level;
use crate::device::levels::Levels;
use crate::device::link::shared::{Content, Event, Settings};
use crate::device::link::shared::{LEAD, Shared, Wanted};
use crate::device::link::stock::pulses::REFRESH;
use crate::device::link::stock::session::{Session, Step};
use crate::device::pace::Pace;
use crate::device::profile::Profile;
use crate::device::stock::{self, Modulated, Twin};
use crate::scene::{Envelope, Modulation};

const MILLI: Duration = Duration::from_millis(1);
const MICRO: Duration = Duration::from_micros(1);

fn shared() -> (Shared, Receiver<Event>) {
    let (sender, events) = sync_channel(1000);
    (Shared::new(sender, Box::new(|| {})), events)
}

/// A session, the board, and the line between them.
struct Line<'a> {
    session: Session<'a>,
    shared: &'a Shared,
    profile: Profile,
    baud: u32,
    wanted: Wanted,
    now: Instant,
    board: Twin,
    damage: Damage,
    pace: Pace,
    /// Bytes on their way to the board.
    out: VecDeque<(Instant, u8)>,
    /// Limit of the delay of a wait.
    late: Duration,
    chance: Rng,
    /// Bytes of all steps.
    said: Vec<Vec<u8>>,
    /// Frames and when they were shown, the first one at the start.
    shown: Vec<(Instant, Levels)>,
}

impl<'a> Line<'a> {
    fn new(profile: Profile, baud: u32, shared: &'a Shared) -> Self {
        let now = shared.wanted().since;
        let settings = Settings { port: "board".into(), profile, baud: Some(baud) };
        let mut line = Self {
            session: Session::new(&settings, shared, now),
            shared,
            profile,
            baud,
            wanted: shared.wanted(),
            now,
            board: Twin::new(profile),
            damage: Damage::new(Faults::default(), 1),
            pace: Pace::new(f64::from(baud), now),
            out: VecDeque::new(),
            late: Duration::ZERO,
            chance: Rng::with_seed(1),
            said: Vec::new(),
            shown: Vec::new(),
        };
        line.carry(&stock::silence(profile));
        line.now += line.pace.backlog(now);
        line.pass(line.now);
        line.shown = vec![(line.now, Levels::off(profile))];
        line
    }

    fn want(&mut self, change: impl FnOnce(&mut Wanted)) {
        self.shared.renew(&mut self.wanted, self.now, change);
    }

    fn show(&mut self, content: Content) {
        self.want(|wanted| wanted.content = Some(Arc::new(content)));
    }

    fn stop(&mut self) {
        self.want(|wanted| wanted.content = None);
    }

    fn modulate(&mut self, shape: Envelope, frequency: f64) {
        self.want(|wanted| wanted.modulation = Modulation { shape, frequency, ..Modulation::default() });
    }

    /// Puts bytes on the line; returns when the last of them leaves.
    fn carry(&mut self, bytes: &[u8]) -> Instant {
        let mut gone = self.now + self.pace.backlog(self.now);
        for &byte in bytes {
            gone = self.pace.sent(1, self.now);
            let mut arrived = Vec::new();
            self.damage.pass(byte, &mut arrived);
            self.out.extend(arrived.into_iter().map(|byte| (gone, byte)));
        }
        gone
    }

    /// Advances the board and the line alone.
    fn pass(&mut self, until: Instant) {
        self.now = self.now.max(until);
        while let Some((at, byte)) = self.out.pop_front_if(|(at, _)| *at <= until) {
            let mut heeded = Heeded::default();
            heeded.hear(&mut self.board, byte, at);
            // A frame of two pieces is spoiled, and shown, too.
            if !heeded.shown.is_empty() || heeded.spoiled > 0 {
                let shown = self.playing();
                if self.shown.last().is_none_or(|(_, last)| *last != shown) {
                    self.shown.push((at, shown));
                }
            }
        }
    }

    fn turn(&mut self, until: Instant) {
        let late = self.late.mul_f64(self.chance.f64());
        // A clock goes on while it is read.
        self.now += MICRO;
        match self.session.next(&self.wanted, self.now, self.now + self.pace.backlog(self.now)) {
            Step::Write(bytes) => {
                assert!(!bytes.is_empty());
                let gone = self.carry(&bytes);
                self.session.written(bytes.len(), &self.wanted, self.now, gone);
                self.said.push(bytes);
            }
            Step::Wait(due) => self.pass((due + late).min(until)),
            Step::Watch(due) => self.pass(due.min(until)),
            Step::Discard => {
                self.out.clear();
                self.pace = Pace::new(f64::from(self.baud), self.now);
                self.session.discarded();
            }
        }
    }

    fn run(&mut self, time: Duration) {
        let (until, mut turns) = (self.now + time, 0);
        while self.now < until {
            self.turn(until);
            turns += 1;
            assert!(turns < 100_000, "the session never rests");
        }
        self.pass(until);
    }

    fn health(&self) -> crate::device::health::Health {
        self.shared.health()
    }

    fn playing(&self) -> Levels {
        self.board.shown()
    }

    /// Frames shown since then, with the duration of each.
    fn since(&self, from: Instant) -> Vec<(Levels, Duration)> {
        let ends = self.shown.iter().skip(1).map(|(at, _)| *at).chain([self.now]);
        let lasting = self.shown.iter().zip(ends).filter(|(_, end)| *end > from);
        lasting.map(|((at, levels), end)| (levels.clone(), end - (*at).max(from))).collect()
    }

    /// Sound and silence in turn since then, and how long each; without the first and the last.
    fn halves_since(&self, from: Instant) -> Vec<(bool, Duration)> {
        let mut halves: Vec<(bool, Duration)> = Vec::new();
        for (levels, time) in self.since(from) {
            let sounds = levels != Levels::off(self.profile);
            match halves.last_mut() {
                Some((before, lasted)) if *before == sounds => *lasted += time,
                _ => halves.push((sounds, time)),
            }
        }
        halves.pop();
        halves.into_iter().skip(1).collect()
    }

    /// The share of the time since then that is not silent.
    fn sound_since(&self, from: Instant) -> f64 {
        let dark = Levels::off(self.profile);
        let loud = self.since(from).into_iter().filter(|(levels, _)| *levels != dark);
        loud.map(|(_, time)| time.as_secs_f64()).sum::<f64>() / (self.now - from).as_secs_f64()
    }
}

/// A frame with its number in every element: a torn one would hold two numbers.
fn frame(profile: Profile, number: usize) -> Levels {
    let levels = profile.levels();
    let amplitude = profile.level(1.0, 0.0).unwrap().amplitude;
    let delay = |n: usize| (number as u16 / if n.is_multiple_of(2) { 1 } else { levels }) % levels;
    Levels {
        profile,
        channels: (0..profile.elements()).map(|n| Some(Level { delay: delay(n), amplitude })).collect(),
    }
}

fn still(profile: Profile, number: usize) -> Content {
    Content::Still(frame(profile, number))
}

fn motion(profile: Profile, frames: usize, rate: f64) -> Content {
    Content::Motion { frames: (0..frames).map(|number| frame(profile, number)).collect(), rate }
}

fn notices(events: &Receiver<Event>) -> Vec<String> {
    let text = |event| if let Event::Notice(text) = event { Some(text) } else { None };
    events.try_iter().filter_map(text).collect()
}

/// Boards switched by the computer: profile, bit rate and frequency; and the pulses that a frame skips.
const SWITCHED: [(Profile, u32, f64, u32); 7] = [
    (Profile::SonicSurface, 230_400, 200.0, 2),
    (Profile::SonicSurface, 1_000_000, 100.0, 0),
    (Profile::SonicSurface2, 1_000_000, 160.0, 1),
    (Profile::UltrainoSimpleFpga, 230_400, 10.0, 0),
    (Profile::UltrainoMega64, 1_000_000, 200.0, 0),
    (Profile::Acoustophoretic512, 2_000_000, 150.0, 0),
    (Profile::Acoustophoretic512, 460_800, 20.0, 0),
];
