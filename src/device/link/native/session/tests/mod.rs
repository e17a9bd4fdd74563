//! Sessions with virtual devices in simulated time: whole conversations, the same ones on any machine.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod conversations;
mod losses;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};

use fastrand::Rng;

use super::*;
use crate::device::board::faults::{Damage, Faults};
use crate::device::board::logic::{Heeded, Native, Playing};
use crate::device::declaration::Level;
use crate::device::levels::Levels;
use crate::device::link::shared::LEAD;
use crate::device::link::shared::{Content, Event};
use crate::device::native::line;
use crate::device::native::model::{Model, Pulse};
use crate::device::native::packet::{Splitter, Table as Stored};
use crate::device::pace::Pace;
use crate::scene::{Envelope, Modulation};

const MILLI: Duration = Duration::from_millis(1);

fn shared() -> (Shared, Receiver<Event>) {
    let (sender, events) = sync_channel(1000);
    (Shared::new(sender, Box::new(|| {})), events)
}

/// A session, the devices, and the line between them.
struct Line<'a> {
    session: Session<'a>,
    shared: &'a Shared,
    wanted: Wanted,
    now: Instant,
    devices: Native,
    damage: Damage,
    pace: Pace,
    /// Bytes on their way to the devices, and to the session.
    out: VecDeque<(Instant, u8)>,
    back: VecDeque<(Instant, u8)>,
    /// Delay of answers.
    delay: Duration,
    splitter: Splitter,
    /// Written packets and their times.
    said: Vec<(Instant, Packet)>,
    /// Committed frames of device 0.
    shown: Vec<Levels>,
}

fn reply_of(devices: &mut Native, packet: &Packet, at: Instant) -> Reply {
    let mut heeded = Heeded::default();
    packet.to_line().into_iter().for_each(|byte| devices.hear(byte, false, at, &mut heeded));
    Reply::of_line(heeded.answer.strip_suffix(&[0]).unwrap()).unwrap()
}

impl<'a> Line<'a> {
    fn new(profile: Profile, shared: &'a Shared) -> Self {
        Self::of_devices(profile, shared, |_| {})
    }

    /// A line with altered answers to RESET.
    fn of_devices(profile: Profile, shared: &'a Shared, alter: impl Fn(&mut Reply)) -> Self {
        let now = shared.wanted().since;
        let mut devices = Native::new(&Model::new(7), profile.devices(), now);
        let Body::Info(info) = reply_of(&mut devices, &Packet::info(), now).body else { panic!("no INFO") };
        let reset = |address| {
            let mut reply = reply_of(&mut devices, &Packet::reset().to(address as u8), now);
            alter(&mut reply);
            reply
        };
        let resets: Vec<_> = (0..profile.devices()).map(reset).collect();
        let settings = Settings { port: "board".into(), profile, baud: None };
        Self {
            session: Session::new(&settings, info, &resets, shared, now),
            shared,
            wanted: shared.wanted(),
            now,
            damage: Damage::new(Faults::default(), 1),
            pace: Pace::new(devices.baud(), now),
            devices,
            out: VecDeque::new(),
            back: VecDeque::new(),
            delay: MILLI,
            splitter: Splitter::default(),
            said: Vec::new(),
            shown: Vec::new(),
        }
    }

    /// A line with frame 1 in place.
    fn playing(profile: Profile, shared: &'a Shared) -> Self {
        let mut line = Self::new(profile, shared);
        line.show(still(profile, 1));
        line.run(100 * MILLI).unwrap();
        line.said.clear();
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

    /// Advances the devices and the line alone.
    fn pass(&mut self, until: Instant) {
        while self.now < until {
            self.now = (self.now + MILLI).min(until);
            while let Some((at, byte)) = self.out.pop_front_if(|(at, _)| *at <= self.now) {
                let mut heeded = Heeded::default();
                self.devices.hear(byte, false, at, &mut heeded);
                let mut answer = Vec::new();
                heeded.answer.into_iter().for_each(|byte| self.damage.pass(byte, &mut answer));
                self.back.extend(answer.into_iter().map(|byte| (at + self.delay, byte)));
                self.shown.extend(heeded.shown.into_iter().map(|shown| shown.levels));
            }
            self.devices.run_until(self.now);
        }
    }

    fn turn(&mut self, until: Instant) -> Result<(), LinkError> {
        self.session.follow(&self.wanted);
        while self.pace.backlog(self.now) < LEAD
            && let Some(message) = self.session.next(&self.wanted, self.now)
        {
            let packet = message.line.iter().copied().skip_while(|&byte| byte == 0).collect::<Vec<_>>();
            self.said.push((self.now, Packet::of_line(packet.strip_suffix(&[0]).unwrap()).unwrap()));
            let mut gone = self.now;
            for &byte in &message.line {
                gone = self.pace.sent(1, self.now);
                let mut arrived = Vec::new();
                self.damage.pass(byte, &mut arrived);
                self.out.extend(arrived.into_iter().map(|byte| (gone, byte)));
            }
            self.session.sent(message, &self.wanted, self.now, gone);
            let short = self.session.on_the_way.iter().filter(|sent| !is_long(sent.code));
            assert!(short.count() <= WINDOW && self.session.on_the_way.len() <= LONG_WINDOW);
        }
        let Some(rest) = self.session.rest(&self.wanted, self.now) else {
            self.pass(until.min(self.now + MILLI));
            let now = self.now;
            let arrived = std::iter::from_fn(|| self.back.pop_front_if(|(at, _)| *at <= now));
            let parts = arrived.filter_map(|(_, byte)| self.splitter.push(byte));
            let replies: Vec<_> = parts.filter_map(|part| Reply::of_line(&part).ok()).collect();
            return self.session.hear(&replies, &self.wanted, self.now);
        };
        // A clock goes on while it is read.
        let rest = rest.max(Duration::from_micros(1));
        self.pass(self.now.checked_add(rest).map_or(until, |due| due.min(until)));
        Ok(())
    }

    fn run(&mut self, time: Duration) -> Result<(), LinkError> {
        let until = self.now + time;
        let mut turns = 0;
        while self.now < until {
            self.turn(until)?;
            turns += 1;
            assert!(turns < 100_000, "the session never rests");
        }
        Ok(())
    }

    /// Packets since the last call, without STATUS.
    fn packets(&mut self) -> Vec<Packet> {
        let all = std::mem::take(&mut self.said).into_iter().map(|(_, packet)| packet);
        all.filter(|packet| packet.code != Kind::Status.code()).collect()
    }

    fn kinds(&mut self) -> Vec<&'static str> {
        self.packets().iter().map(|packet| Kind::from_repr(packet.code).unwrap().into_str()).collect()
    }

    fn health(&self) -> crate::device::health::Health {
        self.shared.health()
    }

    fn pulses(&self) -> Vec<Pulse> {
        let Playing::Pulses { pulses, .. } = self.devices.playing() else { panic!("not native") };
        pulses
    }

    fn is_silent(&self) -> bool {
        self.devices.playing().drive().amplitudes.iter().all(|&amplitude| amplitude == 0.0)
    }

    /// Whether all elements sound as they should.
    fn plays(&self, levels: &Levels) -> bool {
        let (wanted, drive) = (levels.drive(), self.devices.playing().drive());
        let is_near =
            |(one, other): (&f64, &f64)| (one - other).sin().abs() < 0.04 && (one - other).cos() > 0.0;
        drive.amplitudes.iter().all(|&amplitude| amplitude > 0.99)
            && wanted.phases.iter().zip(&drive.phases).all(is_near)
    }

    fn has(&mut self, table: Stored, address: u8, bytes: &[u8]) -> bool {
        let reply = reply_of(&mut self.devices, &Packet::digest(table).to(address), self.now);
        matches!(reply.body, Body::Digest(digest) if digest.crc == line::digest(bytes))
    }
}

/// A frame with its number in every element; the same on all devices.
fn frame(profile: Profile, number: usize) -> Levels {
    let level = |n: usize| Level {
        delay: (number * if n.is_multiple_of(2) { 1 } else { 3 } % 256) as u16,
        amplitude: 255,
    };
    Levels { profile, channels: (0..profile.elements()).map(|n| Some(level(n % 256))).collect() }
}

fn still(profile: Profile, number: usize) -> Content {
    Content::Still(frame(profile, number))
}

fn motion(profile: Profile, frames: usize, rate: f64) -> Content {
    Content::Motion { frames: (0..frames).map(|number| frame(profile, number)).collect(), rate }
}

fn notices(events: &Receiver<Event>) -> String {
    let text = |event| if let Event::Notice(text) = event { Some(text) } else { None };
    events.try_iter().filter_map(text).collect::<Vec<_>>().join("\n")
}

fn bytes(levels: &Levels) -> Vec<u8> {
    levels.channels.iter().flat_map(|level| [level.unwrap().delay as u8, 255]).collect()
}
