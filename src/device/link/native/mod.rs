//! Sending to the native device: numbered packets, at most four of them unanswered, and what got lost is sent again.

mod connect;

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::device::levels::Levels;
use crate::device::link::{Content, LEAD, LinkError, Settings, Shared, Sounding, Wanted};
use crate::device::native::packet::{Info, Kind, Outcome, Packet, REPLY, Reply, Splitter};
use crate::scene::Modulation;

/// Packets without an answer at a time.
const WINDOW: usize = 4;
/// In 64 periods: the device mutes itself after 200 ms of silence.
const WATCHDOG: u16 = 125;
/// The longest that the line is quiet.
const KEEP_ALIVE: Duration = Duration::from_millis(50);
/// What an answer takes at most, unless a board turns out to be slower.
const ANSWER: Duration = Duration::from_millis(100);
/// Without any answer for so long the board is lost.
const SILENT: Duration = Duration::from_millis(1500);
/// How often a packet is sent before the board is given up.
const ATTEMPTS: u32 = 12;
/// Slots at the end of the store that live frames take turns in; a motion has the others.
const LIVE: u8 = 4;
/// The silencer's steps of power-up: a change takes some periods instead of making a click.
const SILENCER: (u16, u16) = (0x0300, 0x0600);

/// Which frame of which wish.
type Key = (u64, usize);

pub fn run(settings: &Settings, shared: &Shared) -> Result<(), LinkError> {
    let mut session = Session::connect(settings, shared)?;
    session.set_up();
    loop {
        let wanted = shared.wanted();
        if wanted.closing {
            return Ok(());
        }
        session.follow(&wanted);
        session.send_what_fits(&wanted)?;
        session.listen(&wanted)?;
    }
}

/// A packet that has to be taken.
#[derive(Clone, Debug)]
struct Task {
    packet: Packet,
    /// Only when everything before it was taken.
    last: bool,
    attempts: u32,
    /// The wish that it serves.
    generation: u64,
}

#[derive(Clone, Debug)]
enum Purpose {
    Task(Task),
    Frame(Key),
    Ping,
}

/// A packet on its way.
#[derive(Clone, Debug)]
struct Sent {
    seq: u8,
    code: u8,
    purpose: Purpose,
    /// When its last byte will have left.
    gone: Instant,
}

struct Session<'a> {
    board: Sounding<'a>,
    shared: &'a Shared,
    name: String,
    info: Info,
    splitter: Splitter,
    seq: u8,
    tasks: VecDeque<Task>,
    on_the_way: VecDeque<Sent>,
    written_at: Instant,
    heard_at: Instant,
    /// After its last byte, a packet is answered within this, or lost.
    patience: Duration,
    ready_at: Instant,
    /// The wish that tasks and frames are made from.
    generation: u64,
    modulation: Option<Modulation>,
    /// Frames are sent one by one, not uploaded.
    live: bool,
    /// The frame that was sent last and not refused since.
    frame: Option<Key>,
    live_slot: u8,
    /// Something of this wish is in place, so that the device may be switched on.
    placed: bool,
    enabled: bool,
    /// A wish that the emergency stop has ended.
    ended: Option<u64>,
}

impl Session<'_> {
    fn motion_slots(&self) -> u8 {
        self.info.slots.min(256).saturating_sub(u16::from(LIVE)).to_le_bytes()[0]
    }

    /// A device that may have been left in any state becomes silent, with nothing of what it was told before.
    fn set_up(&mut self) {
        let (phase_step, amplitude_step) = SILENCER;
        self.push(Packet::mute(), false);
        self.push(Packet::stop(), false);
        self.push(Packet::silencer(phase_step, amplitude_step), false);
        self.push(Packet::calibration(&[[0, 255]; 256]), true);
    }

    fn push(&mut self, packet: Packet, last: bool) {
        self.tasks.push_back(Task { packet, last, attempts: 0, generation: self.generation });
    }

    /// Turns a new wish into tasks.
    fn follow(&mut self, wanted: &Wanted) {
        if self.modulation.as_ref() != Some(&wanted.modulation) {
            self.modulate(&wanted.modulation);
        }
        if self.generation == wanted.generation {
            return;
        }
        self.generation = wanted.generation;
        self.shared.note(|figures| figures.health.in_place = false);
        // What an earlier wish has not brought over yet is not wanted any more.
        self.tasks.retain(|task| !is_of_motion(&task.packet));
        (self.live, self.placed) = (false, false);
        match wanted.content.as_deref() {
            None => {
                self.push(Packet::mute(), false);
                self.enabled = false;
            }
            Some(Content::Motion { frames, rate }) if self.divider(frames.len(), *rate).is_some() => {
                self.upload(frames, *rate);
            }
            Some(Content::Motion { frames, .. }) => {
                self.live = true;
                self.shared.notice(&format!(
                    "{} frames are more than the board's {}, or too slow for it: they are streamed",
                    frames.len(),
                    self.motion_slots()
                ));
            }
            Some(Content::Still(_)) => self.live = true,
        }
    }

    fn modulate(&mut self, modulation: &Modulation) {
        let carrier = f64::from(self.info.carrier_millihertz) / 1e3;
        let step = (modulation.frequency / carrier * f64::from(1 << 24)).round().min(f64::from(0xFF_FFFF));
        let at = |n: usize| modulation.envelope(n as f64 / 256.0 / modulation.frequency);
        let table = std::array::from_fn(|n| (255.0 * at(n)).round() as u8);
        self.push(Packet::envelope(&table), false);
        self.push(Packet::rate(step as u32, true), false);
        self.modulation = Some(modulation.clone());
    }

    /// Periods per frame, if the device can play such a motion by itself.
    fn divider(&self, frames: usize, rate: f64) -> Option<u16> {
        let periods = (f64::from(self.info.carrier_millihertz) / 1e3 / rate).round();
        let fits = frames <= usize::from(self.motion_slots()) && (1.0..=65_535.0).contains(&periods);
        fits.then_some(periods as u16)
    }

    fn upload(&mut self, frames: &[Levels], rate: f64) {
        let (Some(first), Some(divider)) = (frames.first(), self.divider(frames.len(), rate)) else { return };
        // The first frame stands meanwhile, where it is in nobody's way: what plays cannot be written.
        let slot = self.next_live_slot();
        self.push(Packet::playing(first, slot, true), true);
        for (slot, levels) in (0..self.motion_slots()).zip(frames) {
            self.push(Packet::playing(levels, slot, false), false);
        }
        let last = frames.len().saturating_sub(1).to_le_bytes()[0];
        self.push(Packet::play(0, last, divider, 0, false), true);
    }

    fn next_live_slot(&mut self) -> u8 {
        self.live_slot = (self.live_slot + 1) % LIVE;
        self.motion_slots() + self.live_slot
    }

    fn send_what_fits(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        while self.on_the_way.len() < WINDOW && self.board.port.backlog() < LEAD {
            let Some((packet, purpose)) = self.next_packet(wanted) else { break };
            self.send(packet, purpose, wanted)?;
        }
        Ok(())
    }

    fn next_packet(&mut self, wanted: &Wanted) -> Option<(Packet, Purpose)> {
        if let Some(task) = self.tasks.front() {
            if task.last && !self.on_the_way.is_empty() {
                return None;
            }
            let task = self.tasks.pop_front()?;
            return Some((task.packet.clone(), Purpose::Task(task)));
        }
        if let (true, Some(content)) = (self.live, wanted.content.as_deref()) {
            let (frame, levels) = content.at(wanted.since.elapsed());
            let key = (wanted.generation, frame);
            if self.frame != Some(key) {
                let slot = self.next_live_slot();
                return Some((Packet::playing(levels, slot, true), Purpose::Frame(key)));
            }
        }
        if self.placed && !self.enabled && self.ended != Some(self.generation) && self.on_the_way.is_empty() {
            let packet = Packet::enable(WATCHDOG);
            let task = Task { packet, last: true, attempts: 0, generation: self.generation };
            return Some((task.packet.clone(), Purpose::Task(task)));
        }
        let quiet = self.on_the_way.is_empty() && self.written_at.elapsed() >= KEEP_ALIVE;
        quiet.then(|| (Packet::status(), Purpose::Ping))
    }

    fn send(&mut self, packet: Packet, purpose: Purpose, wanted: &Wanted) -> Result<(), LinkError> {
        self.seq = self.seq.wrapping_add(1);
        let (seq, code) = (self.seq, packet.code);
        let mut line = packet.numbered(seq).to_line();
        if self.on_the_way.is_empty() {
            // Ends what noise may have begun while the line was idle.
            line.insert(0, 0);
        }
        let gone = self.board.port.write(&line)?;
        self.shared.note_bytes(line.len());
        self.written_at = Instant::now();
        if let Purpose::Frame(key) = purpose {
            let fresh = self.frame.is_none_or(|(generation, _)| generation != key.0);
            if fresh && wanted.since > self.ready_at {
                let latency = gone.saturating_duration_since(wanted.since);
                self.shared.note(|figures| figures.latency.note(latency));
            }
            self.frame = Some(key);
        }
        self.on_the_way.push_back(Sent { seq, code, purpose, gone });
        Ok(())
    }

    /// Waits for answers, or for something to do.
    fn listen(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        if self.on_the_way.is_empty() {
            let next = wanted.content.as_deref().filter(|_| self.live);
            let next = next.map_or(Duration::MAX, |content| content.next_in(wanted.since.elapsed()));
            let alive = KEEP_ALIVE.saturating_sub(self.written_at.elapsed());
            self.shared.wait(wanted.generation, next.min(alive));
            return Ok(());
        }
        for byte in self.board.port.read(Duration::from_millis(1))? {
            if let Some(part) = self.splitter.push(byte) {
                self.answered(&part)?;
            }
        }
        let now = Instant::now();
        while self.on_the_way.front().is_some_and(|sent| now > sent.gone + self.patience) {
            self.lose_first()?;
        }
        if self.heard_at.elapsed() > SILENT {
            return Err(LinkError::Silent(self.name.clone()));
        }
        Ok(())
    }

    fn answered(&mut self, part: &[u8]) -> Result<(), LinkError> {
        let Ok(reply) = Reply::of_line(part) else { return Ok(()) };
        self.heard_at = Instant::now();
        if reply.code == REPLY {
            // Spoiled: the answers come in order, so it is the first, and if it is not, sending it twice does no harm.
            return self.lose_first();
        }
        let is_it = |sent: &Sent| sent.seq == reply.seq && sent.code.wrapping_add(REPLY) == reply.code;
        let Some(place) = self.on_the_way.iter().position(is_it) else {
            // It was given up too soon.
            self.patience = (2 * self.patience).min(SILENT / 2);
            return Ok(());
        };
        for _ in 0..place {
            self.lose_first()?;
        }
        let Some(sent) = self.on_the_way.pop_front() else { return Ok(()) };
        let round_trip = self.heard_at.saturating_duration_since(sent.gone);
        self.shared.note(|figures| figures.round_trip.note(round_trip));
        self.see(&reply)?;
        match reply.outcome {
            Outcome::Ok => self.taken(&sent),
            Outcome::State => {}
            _ => self.refused(sent)?,
        }
        Ok(())
    }

    /// What an answer says of the device's state.
    fn see(&mut self, reply: &Reply) -> Result<(), LinkError> {
        let flags = reply.flags;
        if flags.emergency_stop && self.ended != Some(self.generation) {
            self.ended = Some(self.generation);
            self.shared.notice(
                "the emergency stop is pressed: the board is silent until you release it and send again",
            );
        }
        if self.enabled && !flags.enabled && reply.code != Kind::Mute.code() + REPLY {
            self.enabled = false;
            if !flags.tripped {
                return Err(LinkError::Restarted);
            }
            if !flags.emergency_stop && self.ended != Some(self.generation) {
                self.shared.notice(
                    "nothing reached the board for 200 ms and it fell silent; it is switched on again",
                );
            }
        }
        Ok(())
    }

    fn taken(&mut self, sent: &Sent) {
        match &sent.purpose {
            Purpose::Frame((generation, _)) => {
                self.shared.note_frame();
                self.placed |= *generation == self.generation;
            }
            Purpose::Task(task) => match Kind::of_code(task.packet.code) {
                Some(Kind::Enable) => self.enabled = true,
                Some(Kind::Play) => self.placed |= task.generation == self.generation,
                Some(Kind::Phases | Kind::Frame) => self.shared.note_frame(),
                _ => {}
            },
            Purpose::Ping => {}
        }
        if self.placed && self.enabled {
            self.shared.note(|figures| figures.health.in_place = true);
        }
    }

    fn lose_first(&mut self) -> Result<(), LinkError> {
        match self.on_the_way.pop_front() {
            Some(sent) => self.refused(sent),
            None => Ok(()),
        }
    }

    /// Sends it again, if it is still wanted.
    fn refused(&mut self, sent: Sent) -> Result<(), LinkError> {
        self.shared.note(|figures| figures.health.refused += 1);
        match sent.purpose {
            // A newer one may be on its way already; then that one is the frame.
            Purpose::Frame(key) if self.frame == Some(key) => self.frame = None,
            Purpose::Task(mut task) => {
                task.attempts += 1;
                if task.attempts >= ATTEMPTS {
                    let kind = Kind::of_code(task.packet.code);
                    return Err(LinkError::Refused(kind.map_or("a packet", Kind::name)));
                }
                if task.generation == self.generation || !is_of_motion(&task.packet) {
                    self.tasks.push_front(task);
                }
            }
            Purpose::Frame(_) | Purpose::Ping => {}
        }
        Ok(())
    }
}

fn is_of_motion(packet: &Packet) -> bool {
    matches!(Kind::of_code(packet.code), Some(Kind::Phases | Kind::Frame | Kind::Play))
}
