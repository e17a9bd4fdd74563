//! The protocol with native devices as a value: it is given the wanted state, answers and the time, and has neither
//! a line nor a clock.
//!
//! A wish becomes tasks, packets in a fixed order: the first frame, alone until ENABLE is confirmed, then
//! everything else. Frames go to four slots in turn, none of them in play, and are committed by the packet that
//! carries them, so a damaged frame is never played. If a slot is busy, its frame was taken and the answer lost:
//! the frame begins again in another slot. Several devices on a line (`native-N`) have addresses; the leader's
//! packet goes last, and its mark on `sync` makes all change frames in the same period. A packet to each device
//! every 50 ms satisfies its watchdog (200 ms). The emergency stop ends the wanted state; only a new one sounds
//! again.
//!
//! The tests let a session converse with models of devices over lines that lose and change bytes, in simulated
//! time: 20 000 random conversations take two minutes.

mod tasks;
#[cfg(all(test, unix))]
mod tests;
mod wish;

use std::collections::VecDeque;

use web_time::{Duration, Instant};

use crate::device::envelope::Table;
use crate::device::health::Found;
use crate::device::link::native::motion::Way;
use crate::device::link::native::session::tasks::{
    Key, Purpose, Task, is_of, is_of_content, serves_one_wish,
};
use crate::device::link::shared::{LinkError, Settings};
use crate::device::link::shared::{Shared, Wanted};
use crate::device::native::packet::{Body, Info, Kind, Outcome, Packet, REPLY, Reply};
use crate::device::profile::Profile;

/// Short packets without an answer at a time: the device has room for so many.
pub const WINDOW: usize = 4;
/// Packets of any length without an answer. A long one takes so long to arrive that the device has by then answered
/// those before it; this many keep the fastest line busy while an adapter holds answers back.
const LONG_WINDOW: usize = 64;
/// The longest that adapters hold an answer back, and some more. A line without answers for longer is slower than its
/// bit rate: more packets would only wait in it.
const HELD_BACK: Duration = Duration::from_millis(24);
/// Bytes of a long packet's payload.
const LONG: usize = 256;
/// Lost packets whose late answers are recognised.
const GIVEN_UP: usize = 2 * LONG_WINDOW;
/// Later answers are noticed, if a quarter of the first ones are.
const LATE: Duration = Duration::from_millis(8);
const FIRST_ANSWERS: u32 = 64;
/// Time limit of an answer, unless a board turns out to be slower.
pub const ANSWER: Duration = Duration::from_millis(100);
/// Time without any answer after which the board is lost.
pub const SILENT: Duration = Duration::from_millis(1500);
/// Watchdog time in units of 64 periods: the device mutes itself after 200 ms without a packet.
const WATCHDOG: u16 = 125;
/// The longest pause between packets to a device.
const KEEP_ALIVE: Duration = Duration::from_millis(50);
/// The silencer's power-up steps: changes take some periods, without a click.
const SILENCER: (u16, u16) = (0x0300, 0x0600);
/// Attempts to send a packet before the board counts as lost.
const ATTEMPTS: u32 = 12;

/// A packet for the line.
#[derive(Clone, Debug)]
pub struct Message {
    pub line: Vec<u8>,
    address: u8,
    seq: u8,
    code: u8,
    purpose: Purpose,
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
    /// MUTE was sent after the last ENABLE.
    muted: bool,
}

impl Device {
    /// A device in the state of power-up, by its answer to RESET.
    fn reset(reply: &Reply) -> Self {
        match reply.body {
            Body::Status(status) => Self { slot: status.slot, periods: status.periods, ..Self::default() },
            Body::Info(_) | Body::Digest(_) => Self::default(),
        }
    }
}

/// The conversation with the devices, and their known state.
pub struct Session<'a> {
    shared: &'a Shared,
    profile: Profile,
    /// Name of the port.
    name: String,
    info: Info,
    /// Bit rate of the line.
    baud: u32,
    /// Devices by address.
    devices: Vec<Device>,
    /// They share their periods, and can change frames in the same one.
    in_step: bool,
    seq: u8,
    tasks: VecDeque<Task>,
    on_the_way: VecDeque<Sent>,
    written_at: Instant,
    /// When something was answered last.
    heard_at: Instant,
    /// After its last byte, a packet is answered within this, or lost.
    patience: Duration,
    /// Address and number of the latest packets that were lost so.
    given_up: VecDeque<(u8, u8)>,
    /// Answers so far, and those that were late.
    answers: u32,
    late_answers: u32,
    ready_at: Instant,
    /// The generation of the wish behind tasks and frames.
    generation: u64,
    /// The modulation that the devices have.
    modulation: Table,
    /// Phase step of the devices' silencers.
    phase_step: u16,
    /// The playback of the wanted motion.
    storing: Option<Way>,
    /// Frames are sent one by one, not uploaded.
    live: bool,
    /// Whether the devices play a range of slots.
    playing: bool,
    /// The last streamed frame that was not refused.
    frame: Option<Key>,
    live_slot: u8,
    /// Attempts at the frames of this wish, so far.
    attempts: u32,
    /// Some content of this wish is in place, so the devices may be switched on.
    placed: bool,
    /// ENABLE is pending.
    enabling: bool,
    /// A wish that the emergency stop has ended.
    ended: Option<u64>,
}

impl<'a> Session<'a> {
    /// A session with devices that have just been reset, at `now`.
    pub fn new(settings: &Settings, info: Info, resets: &[Reply], shared: &'a Shared, now: Instant) -> Self {
        let mut session = Self {
            shared,
            profile: settings.profile,
            name: settings.port.display().to_string(),
            info,
            baud: settings.baud(),
            devices: resets.iter().map(Device::reset).collect(),
            in_step: resets.len() > 1,
            seq: 0,
            tasks: VecDeque::new(),
            on_the_way: VecDeque::new(),
            written_at: now,
            heard_at: now,
            patience: ANSWER,
            given_up: VecDeque::new(),
            answers: 0,
            late_answers: 0,
            ready_at: now,
            generation: u64::MAX,
            modulation: Table::steady(),
            phase_step: SILENCER.0,
            storing: None,
            live: false,
            playing: false,
            frame: None,
            live_slot: 0,
            attempts: 0,
            placed: false,
            enabling: false,
            ended: None,
        };
        let alone = resets.iter().skip(1).filter(|reply| !reply.flags.follows);
        for Reply { address, .. } in alone {
            session.in_step = false;
            shared.notice(&format!(
                "board {address} receives no sync, so its phase drifts: wire `sync` of board 0 to its `sync_in`"
            ));
        }
        session
    }

    /// The facts of the devices.
    pub fn found(&self) -> Found {
        Found {
            baud: self.baud,
            carrier: self.carrier(),
            slots: usize::from(self.info.slots),
            phase_bits: Some(self.info.phase_bits),
        }
    }
}

impl Session<'_> {
    fn push(&mut self, packet: Packet, last: bool) {
        let attempts = if is_of_content(&packet) { self.attempts } else { 0 };
        self.tasks.push_back(Task { packet, last, attempts, generation: self.generation });
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

    fn next_packet(&mut self, wanted: &Wanted, now: Instant) -> Option<(Packet, Purpose)> {
        if let (true, Some(content)) = (self.tasks.is_empty(), wanted.content.as_deref())
            && let Some(frame) = self.due_frame(content, wanted, now)
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
        self.until_ping(now).is_zero().then(|| (Packet::status().to(self.next_to_ask()), Purpose::Ping))
    }

    /// Time until the next packet to a device is due, also while an answer is awaited: it may be lost.
    fn until_ping(&self, now: Instant) -> Duration {
        let pause = KEEP_ALIVE / self.devices.len() as u32;
        pause.saturating_sub(now.saturating_duration_since(self.written_at))
    }

    /// Polls all devices in turn, so that no watchdog trips.
    fn next_to_ask(&self) -> u8 {
        self.seq % self.devices.len() as u8
    }

    /// The next message, if there is one and the device has room for it.
    pub fn next(&mut self, wanted: &Wanted, now: Instant) -> Option<Message> {
        let short = self.on_the_way.iter().filter(|sent| !is_long(sent.code)).count();
        let first = self.on_the_way.front().map(|sent| sent.gone);
        if short >= WINDOW || !has_room(self.on_the_way.len(), first, now) {
            return None;
        }
        let (packet, purpose) = self.next_packet(wanted, now)?;
        self.seq = self.seq.wrapping_add(1);
        let (address, seq, code) = (packet.address, self.seq, packet.code);
        let mut line = packet.numbered(seq).to_line();
        if self.on_the_way.is_empty() {
            // Ends a packet possibly begun by noise on the idle line.
            line.insert(0, 0);
        }
        Some(Message { line, address, seq, code, purpose })
    }

    /// A message was written at `now`; its last byte leaves at `gone`.
    pub fn sent(&mut self, message: Message, wanted: &Wanted, now: Instant, gone: Instant) {
        self.shared.note_bytes(message.line.len());
        self.written_at = now;
        if let Purpose::Frame(key) = message.purpose {
            let fresh = self.frame.is_none_or(|(generation, _)| generation != key.0);
            if fresh && wanted.since > self.ready_at {
                let latency = gone.saturating_duration_since(wanted.since);
                self.shared.note(|figures| figures.latency.note(latency));
            }
            self.frame = Some(key);
        }
        let Message { address, seq, code, purpose, .. } = message;
        if let (Some(device), Some(kind @ (Kind::Mute | Kind::Enable))) =
            (self.devices.get_mut(usize::from(address)), Kind::from_repr(code))
        {
            device.muted = kind == Kind::Mute;
        }
        self.on_the_way.push_back(Sent { address, seq, code, purpose, gone });
    }

    /// Time without work unless the wish changes; none while answers are awaited.
    pub fn rest(&self, wanted: &Wanted, now: Instant) -> Option<Duration> {
        if !self.on_the_way.is_empty() {
            return None;
        }
        let next = wanted.content.as_deref().filter(|_| self.live);
        let elapsed = now.saturating_duration_since(wanted.since);
        let next = next.map_or(Duration::MAX, |content| content.next_in(elapsed));
        Some(next.min(self.until_ping(now)))
    }

    /// Processes answers, and their absence.
    ///
    /// # Errors
    /// Devices that were lost, restarted, or refuse a packet again and again.
    pub fn hear(&mut self, replies: &[Reply], wanted: &Wanted, now: Instant) -> Result<(), LinkError> {
        if !replies.is_empty() {
            self.heard_at = now;
        }
        for reply in replies {
            self.answered(reply, wanted)?;
        }
        while let Some(late) = self.on_the_way.front().filter(|sent| now > sent.gone + self.patience) {
            self.given_up.truncate(GIVEN_UP - 1);
            self.given_up.push_front((late.address, late.seq));
            self.lose(0)?;
        }
        if now.saturating_duration_since(self.heard_at) > SILENT {
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
            if self.given_up.contains(&(reply.address, reply.seq)) {
                // Too soon.
                self.given_up.clear();
                self.patience = (2 * self.patience).min(SILENT / 2);
            }
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
        let round_trip = self.heard_at.saturating_duration_since(sent.gone);
        self.note_answer(round_trip);
        self.see(reply)?;
        match reply.outcome {
            Outcome::Ok => self.taken(&sent, wanted),
            Outcome::Busy => self.busy(sent, wanted)?,
            Outcome::State => self.enabling = false,
            Outcome::Crc | Outcome::Length | Outcome::Unknown | Outcome::Argument => {
                self.refused(sent)?;
            }
        }
        Ok(())
    }

    /// Adapters that collect bytes before they hand them on make all answers late.
    fn note_answer(&mut self, round_trip: Duration) {
        self.shared.note(|figures| figures.round_trip.note(round_trip));
        self.answers = self.answers.saturating_add(1);
        self.late_answers += u32::from(self.answers <= FIRST_ANSWERS && round_trip > LATE);
        if self.answers == FIRST_ANSWERS && 4 * self.late_answers >= FIRST_ANSWERS {
            self.shared.notice(&format!(
                "answers of the board take more than {} ms: set the latency timer of the USB adapter to 1 ms",
                LATE.as_millis()
            ));
        }
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
        let was_muted = device.muted;
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
        if fell_silent && !was_muted {
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
        let is = |kind| is_of(&task.packet, kind);
        if is(Kind::Enable) {
            self.enabling &= !self.enabled();
        } else if is(Kind::Stop) && !self.awaits(|packet| is_of(packet, Kind::Stop)) {
            self.playing = false;
            if is_wanted {
                self.store(wanted);
            }
        } else if is(Kind::Phases) || is(Kind::Frame) {
            self.shared.note_frame();
            self.placed |= is_wanted && task.packet.commits() && !self.awaits(Packet::commits);
        }
    }

    /// Whether a packet of a wish, or of the one before, is not yet taken.
    fn awaits(&self, is: impl Fn(&Packet) -> bool) -> bool {
        let sent = self.on_the_way.iter().filter_map(|sent| sent.purpose.task());
        self.tasks.iter().chain(sent).any(|task| is(&task.packet))
    }

    fn lose(&mut self, place: usize) -> Result<(), LinkError> {
        match self.on_the_way.remove(place) {
            Some(sent) => self.refused(sent),
            None => Ok(()),
        }
    }

    /// A slot is played or waited for, perhaps by an attempt whose answer was lost: the frame begins again in another.
    fn busy(&mut self, sent: Sent, wanted: &Wanted) -> Result<(), LinkError> {
        let begins = |task: &&Task| task.generation == self.generation && task.packet.commits();
        let attempts = sent.purpose.task().filter(begins).map(|task| task.attempts + 1);
        self.refused(sent)?;
        if let Some(attempts) = attempts {
            self.attempts = attempts;
            self.tasks.retain(|task| !is_of_content(&task.packet));
            match self.live {
                true => self.frame = None,
                false => self.store(wanted),
            }
        }
        Ok(())
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

/// Whether one more may follow these unanswered long packets, of which the first one left at `first`.
pub fn has_room(unanswered: usize, first: Option<Instant>, now: Instant) -> bool {
    let held_back = first.is_some_and(|gone| now < gone + HELD_BACK);
    unanswered < WINDOW || (unanswered < LONG_WINDOW && held_back)
}

fn is_long(code: u8) -> bool {
    Kind::from_repr(code).is_some_and(|kind| kind.payload() >= LONG)
}
