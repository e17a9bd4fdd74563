//! The link to native devices: numbered packets, at most four of them unacknowledged, and retransmission of lost
//! ones.
//!
//! A wish becomes tasks, packets in a fixed order: the first frame, then ENABLE, then everything else.

mod ask;
mod connect;
mod motion;
pub mod survey;
mod wish;

use std::collections::VecDeque;

use web_time::{Duration, Instant};

use crate::device::envelope::Table;
use crate::device::link::native::ask::Asker;
use crate::device::link::native::motion::Way;
use crate::device::link::{LEAD, LinkError, Settings, Shared, Sounding, Wanted};
use crate::device::native::packet::{Body, Info, Kind, Outcome, Packet, REPLY, Reply};
use crate::device::profile::Profile;

/// Packets without an answer at a time.
const WINDOW: usize = 4;
/// In 64 periods: the device mutes itself after 200 ms of silence.
const WATCHDOG: u16 = 125;
/// The longest pause on the line.
const KEEP_ALIVE: Duration = Duration::from_millis(50);
/// Time limit of an answer, unless a board turns out to be slower.
const ANSWER: Duration = Duration::from_millis(100);
/// Without any answer for so long the board is lost.
const SILENT: Duration = Duration::from_millis(1500);
/// Attempts to send a packet before the board counts as lost.
const ATTEMPTS: u32 = 12;

/// Which frame of which wish.
type Key = (u64, usize);

pub async fn run(settings: &Settings, shared: &Shared) -> Result<(), LinkError> {
    let mut session = Session::connect(settings, shared).await?;
    loop {
        let wanted = shared.wanted();
        if wanted.closing {
            return Ok(());
        }
        session.follow(&wanted);
        session.send_what_fits(&wanted).await?;
        session.listen(&wanted).await?;
    }
}

/// A packet that must be accepted.
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
    /// A frame of a stream; a newer one may replace it.
    Frame(Key),
    Ping,
}

/// A packet on its way.
#[derive(Clone, Debug)]
struct Sent {
    address: u8,
    seq: u8,
    code: u8,
    purpose: Purpose,
    /// Time at which its last byte leaves.
    gone: Instant,
}

/// One of the devices on the line, as its answers show it.
#[derive(Clone, Copy, Debug, Default)]
struct Device {
    /// The slot being played, which cannot be written.
    slot: u8,
    /// Since power-up.
    periods: u32,
    enabled: bool,
}

struct Session<'a> {
    board: Sounding<'a>,
    shared: &'a Shared,
    profile: Profile,
    name: String,
    info: Info,
    /// By address.
    devices: Vec<Device>,
    /// They share their periods, and can change frames in the same one.
    in_step: bool,
    asker: Asker,
    seq: u8,
    tasks: VecDeque<Task>,
    on_the_way: VecDeque<Sent>,
    written_at: Instant,
    /// After its last byte, a packet is answered within this, or lost.
    patience: Duration,
    ready_at: Instant,
    /// The generation of the wish behind tasks and frames.
    generation: u64,
    /// The modulation that the devices have.
    modulation: Table,
    /// The playback of the wanted motion, pending until the player has stopped.
    storing: Option<Way>,
    /// Frames are sent one by one, not uploaded.
    live: bool,
    /// Whether the devices play a range of slots.
    playing: bool,
    /// The last streamed frame that was not refused.
    frame: Option<Key>,
    live_slot: u8,
    /// Some content of this wish is in place, so the devices may be switched on.
    placed: bool,
    /// ENABLE is pending.
    enabling: bool,
    /// A wish that the emergency stop has ended.
    ended: Option<u64>,
}

impl Session<'_> {
    fn push(&mut self, packet: Packet, last: bool) {
        self.tasks.push_back(Task { packet, last, attempts: 0, generation: self.generation });
    }

    /// The same to every device.
    fn push_to_all(&mut self, packet: &Packet) {
        for address in self.addresses() {
            self.push(packet.clone().to(address), false);
        }
    }

    fn addresses(&self) -> std::ops::Range<u8> {
        0..self.devices.len() as u8
    }

    fn enabled(&self) -> bool {
        self.devices.iter().all(|device| device.enabled)
    }

    async fn send_what_fits(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        while self.on_the_way.len() < WINDOW && self.board.port.backlog() < LEAD {
            let Some((packet, purpose)) = self.next_packet(wanted) else { break };
            self.send(packet, purpose, wanted).await?;
        }
        Ok(())
    }

    fn next_packet(&mut self, wanted: &Wanted) -> Option<(Packet, Purpose)> {
        if let (true, Some(content)) = (self.tasks.is_empty(), wanted.content.as_deref())
            && let Some(frame) = self.due_frame(content, wanted)
        {
            return Some(frame);
        }
        if let Some(task) = self.tasks.front() {
            if task.last && !self.on_the_way.is_empty() {
                return None;
            }
            let task = self.tasks.pop_front()?;
            return Some((task.packet.clone(), Purpose::Task(task)));
        }
        let quiet = self.on_the_way.is_empty() && self.written_at.elapsed() >= KEEP_ALIVE;
        quiet.then(|| (Packet::status().to(self.next_to_ask()), Purpose::Ping))
    }

    /// Polls all devices in turn, so that no watchdog trips.
    fn next_to_ask(&self) -> u8 {
        self.seq % self.devices.len() as u8
    }

    async fn send(&mut self, packet: Packet, purpose: Purpose, wanted: &Wanted) -> Result<(), LinkError> {
        self.seq = self.seq.wrapping_add(1);
        let (address, seq, code) = (packet.address, self.seq, packet.code);
        let mut line = packet.numbered(seq).to_line();
        if self.on_the_way.is_empty() {
            // Ends a packet possibly begun by noise on the idle line.
            line.insert(0, 0);
        }
        let gone = self.board.port.write(&line).await?;
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
        self.on_the_way.push_back(Sent { address, seq, code, purpose, gone });
        Ok(())
    }

    /// Waits for answers or new work.
    async fn listen(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        if self.on_the_way.is_empty() {
            let next = wanted.content.as_deref().filter(|_| self.live);
            let next = next.map_or(Duration::MAX, |content| content.next_in(wanted.since.elapsed()));
            let alive = KEEP_ALIVE.saturating_sub(self.written_at.elapsed());
            self.shared.wait(wanted.generation, next.min(alive)).await;
            return Ok(());
        }
        for reply in self.asker.replies(&mut self.board.port, Duration::from_millis(1)).await? {
            self.answered(&reply, wanted)?;
        }
        let now = Instant::now();
        while self.on_the_way.front().is_some_and(|sent| now > sent.gone + self.patience) {
            self.lose(0)?;
        }
        if self.asker.heard_at.elapsed() > SILENT {
            return Err(LinkError::Silent(self.name.clone()));
        }
        Ok(())
    }

    fn answered(&mut self, reply: &Reply, wanted: &Wanted) -> Result<(), LinkError> {
        if reply.code == REPLY {
            // Spoiled: answers come in order, so it is the first unanswered packet; if not, sending it twice is
            // harmless.
            return self.lose(0);
        }
        let is_it = |sent: &Sent| {
            (sent.address, sent.seq) == (reply.address, reply.seq)
                && sent.code.wrapping_add(REPLY) == reply.code
        };
        if !self.on_the_way.iter().any(is_it) {
            // It was given up too soon.
            self.patience = (2 * self.patience).min(SILENT / 2);
            return Ok(());
        }
        // A device answers in order: skipped packets were lost.
        while let Some(place) = self.on_the_way.iter().position(|sent| sent.address == reply.address) {
            if self.on_the_way.get(place).is_some_and(is_it) {
                break;
            }
            self.lose(place)?;
        }
        let Some(place) = self.on_the_way.iter().position(is_it) else { return Ok(()) };
        let Some(sent) = self.on_the_way.remove(place) else { return Ok(()) };
        let round_trip = self.asker.heard_at.saturating_duration_since(sent.gone);
        self.shared.note(|figures| figures.round_trip.note(round_trip));
        self.see(reply)?;
        match reply.outcome {
            Outcome::Ok => self.taken(&sent, wanted),
            Outcome::State => self.enabling = false,
            Outcome::Crc | Outcome::Length | Outcome::Busy | Outcome::Unknown | Outcome::Argument => {
                self.refused(sent)?;
            }
        }
        Ok(())
    }

    /// Processes the device's state in an answer.
    fn see(&mut self, reply: &Reply) -> Result<(), LinkError> {
        let flags = reply.flags;
        let Some(device) = self.devices.get_mut(usize::from(reply.address)) else { return Ok(()) };
        if let Body::Status(status) = reply.body {
            device.slot = status.slot;
            // A decreasing counter means that the device has restarted.
            let restarted = status.periods.wrapping_sub(device.periods) > u32::MAX / 2;
            device.periods = status.periods;
            if restarted {
                return Err(LinkError::Restarted);
            }
        }
        let fell_silent = std::mem::replace(&mut device.enabled, flags.enabled) && !flags.enabled;
        let is_ended = self.ended == Some(self.generation);
        // It is held until ENABLE: reports of a press before this wish are ignored.
        if !is_ended && (flags.emergency_stop || (fell_silent && flags.stopped)) {
            self.ended = Some(self.generation);
            self.shared.note(|figures| (figures.health.stopped, figures.health.in_place) = (true, false));
            self.shared.notice(match flags.emergency_stop {
                true => {
                    "the emergency stop is pressed: the board is silent until you release it and send again"
                }
                false => "the emergency stop was pressed: the board is silent until you send again",
            });
        }
        if fell_silent && reply.code != Kind::Mute.code() + REPLY {
            if !flags.tripped {
                return Err(LinkError::Restarted);
            }
            if !flags.stopped && !is_ended {
                self.shared.notice(
                    "no packet reached the board for 200 ms and its watchdog silenced it; it is switched on again",
                );
            }
        }
        Ok(())
    }

    fn taken(&mut self, sent: &Sent, wanted: &Wanted) {
        match &sent.purpose {
            Purpose::Frame((generation, _)) => {
                self.shared.note_frame();
                self.placed |= *generation == self.generation;
            }
            Purpose::Task(task) => self.task_taken(task, wanted),
            Purpose::Ping => {}
        }
        self.switch_on();
        if self.placed && self.enabled() {
            self.shared.note(|figures| (figures.health.stopped, figures.health.in_place) = (false, true));
        }
    }

    fn task_taken(&mut self, task: &Task, wanted: &Wanted) {
        let is_wanted = task.generation == self.generation;
        let is = |kind| Kind::from_repr(task.packet.code) == Some(kind);
        if is(Kind::Enable) {
            self.enabling &= !self.enabled();
        } else if is(Kind::Stop) && self.all_stopped() {
            self.playing = false;
            if is_wanted {
                self.store(wanted);
            }
        } else if is(Kind::Phases) || is(Kind::Frame) {
            self.shared.note_frame();
            self.placed |= is_wanted && task.packet.commits();
        }
    }

    fn lose(&mut self, place: usize) -> Result<(), LinkError> {
        match self.on_the_way.remove(place) {
            Some(sent) => self.refused(sent),
            None => Ok(()),
        }
    }

    /// Sends it again if still wanted.
    fn refused(&mut self, sent: Sent) -> Result<(), LinkError> {
        self.shared.note(|figures| figures.health.refused += 1);
        match sent.purpose {
            // A newer frame may already be pending and then replaces it.
            Purpose::Frame(key) if self.frame == Some(key) => self.frame = None,
            Purpose::Task(mut task) => {
                task.attempts += 1;
                if task.attempts >= ATTEMPTS {
                    let kind = Kind::from_repr(task.packet.code);
                    return Err(LinkError::Refused(kind.map_or("a packet", Into::into)));
                }
                let is_wanted = task.generation == self.generation || !serves_one_wish(&task.packet);
                if is_wanted && !self.is_outdated(&task.packet) {
                    self.tasks.push_front(task);
                }
            }
            Purpose::Frame(_) | Purpose::Ping => {}
        }
        Ok(())
    }
}

/// Whether a packet is useless for a newer wish.
fn serves_one_wish(packet: &Packet) -> bool {
    matches!(
        Kind::from_repr(packet.code),
        Some(Kind::Phases | Kind::Frame | Kind::Play | Kind::Stop | Kind::Enable)
    )
}
