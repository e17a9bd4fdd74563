//! Sending to the native device: numbered packets, at most four of them unanswered, and what got lost is sent again.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::device::health::Found;
use crate::device::levels::Levels;
use crate::device::link::{Content, Event, LEAD, LinkError, Settings, Shared, Sounding, Wanted};
use crate::device::native::model;
use crate::device::native::packet::{Body, Info, Kind, Outcome, Packet, REPLY, Reply, Splitter};
use crate::device::port::Port;
use crate::device::profile::Profile;

/// Packets without an answer at a time.
const WINDOW: usize = 4;
/// Of the protocol that this program speaks.
const VERSION: u8 = 1;
/// In 64 periods: the device mutes itself after 200 ms of silence.
const WATCHDOG: u16 = 125;
/// The longest that the line is quiet.
const KEEP_ALIVE: Duration = Duration::from_millis(50);
/// After its last byte, a packet is answered within this, or lost.
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
    board: Sounding,
    shared: &'a Shared,
    name: String,
    info: Info,
    splitter: Splitter,
    seq: u8,
    tasks: VecDeque<Task>,
    on_the_way: VecDeque<Sent>,
    written_at: Instant,
    heard_at: Instant,
    ready_at: Instant,
    /// The wish that tasks and frames are made from.
    generation: u64,
    modulation: Option<crate::scene::Modulation>,
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

impl<'a> Session<'a> {
    fn connect(settings: &Settings, shared: &'a Shared) -> Result<Self, LinkError> {
        let port = Port::open(&settings.port, Profile::Native.baud())?;
        let name = port.name().to_owned();
        // A delimiter first, to end what the line may have left there.
        let silence = [vec![0], Packet::mute().to_line()].concat();
        let now = Instant::now();
        let mut session = Self {
            board: Sounding { port, silence },
            shared,
            name,
            info: Info {
                protocol: 0,
                phase_bits: 0,
                slots: 1,
                version: 0,
                carrier_millihertz: 0,
                channels: 1,
                largest_baud: 0,
            },
            splitter: Splitter::default(),
            seq: 0,
            tasks: VecDeque::new(),
            on_the_way: VecDeque::new(),
            written_at: now,
            heard_at: now,
            ready_at: now,
            generation: u64::MAX,
            modulation: None,
            live: false,
            frame: None,
            live_slot: 0,
            placed: false,
            enabled: false,
            ended: None,
        };
        session.info = session.introduce()?;
        session.change_baud(settings.baud())?;
        let found = Found {
            baud: settings.baud(),
            carrier: Some(f64::from(session.info.carrier_millihertz) / 1e3),
            slots: usize::from(session.motion_slots()),
            phase_bits: Some(session.info.phase_bits),
        };
        session.ready_at = Instant::now();
        shared.tell(Event::Ready(found));
        Ok(session)
    }

    /// Asks what is there until it answers; a device that was left at another bit rate comes back to the usual one after 0.8 s.
    fn introduce(&mut self) -> Result<Info, LinkError> {
        let until = Instant::now() + SILENT;
        let mut heard = false;
        while Instant::now() < until && !self.shared.wanted().closing {
            self.board.port.write(&[0])?;
            let reply = self.ask(&Packet::info(), &mut heard)?;
            if let Some(Reply { body: Body::Info(info), .. }) = reply {
                return self.expected(info);
            }
        }
        Err(if heard {
            LinkError::OtherBoard(self.name.clone())
        } else {
            LinkError::NoAnswer(self.name.clone())
        })
    }

    fn expected(&self, info: Info) -> Result<Info, LinkError> {
        if info.protocol != VERSION {
            return Err(LinkError::OtherVersion { theirs: info.protocol, ours: VERSION });
        }
        let (board, expected) = (usize::from(info.channels), Profile::Native.elements());
        if board != expected {
            return Err(LinkError::OtherCount { board, expected });
        }
        Ok(info)
    }

    /// The answer to one packet, if there is one in time.
    fn ask(&mut self, packet: &Packet, heard: &mut bool) -> Result<Option<Reply>, LinkError> {
        self.seq = self.seq.wrapping_add(1);
        self.board.port.write(&packet.clone().numbered(self.seq).to_line())?;
        let until = Instant::now() + self.board.port.backlog() + ANSWER;
        while Instant::now() < until {
            let bytes = self.board.port.read(Duration::from_millis(5))?;
            *heard |= !bytes.is_empty();
            for part in bytes.into_iter().filter_map(|byte| self.splitter.push(byte)) {
                let reply = Reply::of_line(&part).ok();
                if let Some(reply) =
                    reply.filter(|reply| reply.code == packet.code + REPLY && reply.seq == self.seq)
                {
                    self.heard_at = Instant::now();
                    return Ok(Some(reply));
                }
            }
        }
        Ok(None)
    }

    fn change_baud(&mut self, baud: u32) -> Result<(), LinkError> {
        if baud == self.board.port.baud() {
            return Ok(());
        }
        let largest = 100_000 * u32::from(self.info.largest_baud);
        if baud > largest {
            return Err(LinkError::TooFast { asked: baud, largest });
        }
        let carrier = f64::from(self.info.carrier_millihertz) / 1e3;
        let clock = f64::from(model::clocks(self.info.phase_bits)) * carrier;
        let increment = (f64::from(baud) / clock * 65_536.0).round() as u16;
        let mut heard = false;
        let agreed = self.ask(&Packet::baud(increment), &mut heard)?;
        if agreed.is_none_or(|reply| reply.outcome != Outcome::Ok) {
            return Err(LinkError::Refused(Kind::Baud.name()));
        }
        self.board.port.set_baud(baud)?;
        for _ in 0..3 {
            if self.ask(&Packet::status(), &mut heard)?.is_some() {
                return Ok(());
            }
        }
        Err(LinkError::Silent(self.name.clone()))
    }

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

    fn modulate(&mut self, modulation: &crate::scene::Modulation) {
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
        self.push(packet_of(first, slot, true), true);
        for (slot, levels) in (0..self.motion_slots()).zip(frames) {
            self.push(packet_of(levels, slot, false), false);
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
                return Some((packet_of(levels, slot, true), Purpose::Frame(key)));
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
        while self.on_the_way.front().is_some_and(|sent| now > sent.gone + ANSWER) {
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
        let Some(place) = self.on_the_way.iter().position(is_it) else { return Ok(()) };
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

/// With one amplitude for all if there is but one.
fn packet_of(levels: &Levels, slot: u8, commit: bool) -> Packet {
    let pairs: [[u8; 2]; 256] = std::array::from_fn(|n| {
        levels
            .elements
            .get(n)
            .copied()
            .flatten()
            .map_or([0, 0], |level| [level.delay.to_le_bytes()[0], level.amplitude.to_le_bytes()[0]])
    });
    let amplitude = pairs[0][1];
    if pairs.iter().all(|&[_, other]| other == amplitude) {
        Packet::phases(slot, amplitude, &pairs.map(|[phase, _]| phase), commit)
    } else {
        Packet::frame(slot, &pairs, commit)
    }
}
