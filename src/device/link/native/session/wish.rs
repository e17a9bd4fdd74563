//! From the wanted state to the packets that establish it.

use web_time::Instant;

use crate::device::envelope::Table;
use crate::device::health::FrameRates;
use crate::device::levels::Levels;
use crate::device::link::native::motion::{self, Motion, Way};
use crate::device::link::native::session::tasks::{Key, Purpose, Task, is_of, serves_one_wish};
use crate::device::link::native::session::{SILENCER, Session, WATCHDOG};
use crate::device::link::shared::Content;
use crate::device::link::shared::Wanted;
use crate::device::native::packet::{Kind, Packet};
use crate::scene::Modulation;

/// Slots used in turn by streamed frames.
const LIVE: u8 = 4;
impl Session<'_> {
    /// Turns a new wish into tasks.
    pub fn follow(&mut self, wanted: &Wanted) {
        self.modulate(&wanted.modulation);
        if self.generation == wanted.generation {
            return;
        }
        self.generation = wanted.generation;
        if let (Some(_), Err(why)) = (&wanted.content, Table::new(&wanted.modulation, self.carrier())) {
            self.shared.notice(&format!("the sound is steady: {why}"));
        }
        // Pending tasks of an earlier wish are dropped.
        self.tasks.retain(|task| !serves_one_wish(&task.packet));
        (self.live, self.placed, self.enabling, self.storing, self.attempts) = (false, false, false, None, 0);
        let rates = match wanted.content.as_deref() {
            None => {
                self.push_to_all(&Packet::mute());
                None
            }
            Some(Content::Still(_)) => {
                self.stream();
                None
            }
            Some(Content::Motion { frames, rate }) => Some(self.set_moving(frames.len(), *rate)),
        };
        self.shared.note(|figures| figures.health.rates = rates);
    }

    /// Chooses the playback of a motion.
    fn set_moving(&mut self, frames: usize, rate: f64) -> FrameRates {
        let motion = Motion {
            frames,
            rate,
            slots: usize::from(self.info.slots),
            carrier: self.carrier(),
            line: self.line_rate(),
        };
        let way = motion.way();
        match way {
            Way::Stored { count, .. } if count > 1 => {
                self.storing = Some(way);
                self.push_to_all(&Packet::stop());
            }
            Way::Stored { .. } | Way::Streamed => self.stream(),
        }
        let played = motion.played(way);
        let cycles = match way {
            Way::Stored { count, .. } => played / count as f64,
            // A line that carries fewer frames leaves some out, in the same time.
            Way::Streamed => rate / frames as f64,
        };
        let rates = FrameRates { asked: rate, played, cycles };
        if rates.differ() {
            self.shared.notice(&match way {
                Way::Stored { count, .. } => {
                    format!("{rates}: {count} of {frames} frames, {cycles:.4} cycles/s")
                }
                Way::Streamed => {
                    format!("{rates}: the line carries no more at {} baud", self.baud)
                }
            });
        }
        rates
    }

    /// Streams frames from now on.
    fn stream(&mut self) {
        self.live = true;
        // Until STOP is acknowledged, the playing slots are busy.
        if self.playing {
            self.push_to_all(&Packet::stop());
            self.set_silencer(SILENCER.0);
        }
    }

    fn set_silencer(&mut self, phase_step: u16) {
        self.phase_step = phase_step;
        self.push_to_all(&Packet::silencer(phase_step, SILENCER.1));
    }

    /// The due frame, unless already sent. The first frame of a wish stands alone until the devices are switched on.
    pub(super) fn due_frame(
        &mut self,
        content: &Content,
        wanted: &Wanted,
        now: Instant,
    ) -> Option<(Packet, Purpose)> {
        // A repeated STOP would end the playback of the frame.
        let stops = || self.awaits(|packet| is_of(packet, Kind::Stop));
        if !self.live || self.enabling || self.ended == Some(self.generation) || stops() {
            return None;
        }
        let (frame, levels) = content.at(now.saturating_duration_since(wanted.since));
        let key = (wanted.generation, frame);
        let begun = self.frame.is_some_and(|(generation, _)| generation == wanted.generation);
        if self.frame == Some(key) || (begun && !(self.placed && self.enabled())) {
            return None;
        }
        let slot = self.next_live_slot();
        if let [_] = self.devices[..] {
            return Some((Packet::playing(levels, slot, true), Purpose::Frame(key)));
        }
        self.push_in_step(key, levels, slot);
        None
    }

    /// The leader's frame goes last: with its mark all devices change in the same period.
    fn push_in_step(&mut self, key: Key, levels: &Levels, slot: u8) {
        self.frame = Some(key);
        for address in self.addresses().rev() {
            let packet = self.together(playing(levels, address, slot, true));
            self.push(packet, address == 0);
        }
    }

    /// A packet that takes effect on several devices in the same period.
    fn together(&self, packet: Packet) -> Packet {
        if self.in_step { packet.in_step() } else { packet }
    }

    /// One that no device plays, if their last answers tell of one.
    fn next_live_slot(&mut self) -> u8 {
        let first = self.info.slots.saturating_sub(u16::from(LIVE)) as u8;
        let after = |turn: u8| (self.live_slot + turn) % LIVE;
        let is_free = |turn: &u8| self.devices.iter().all(|device| device.slot != first + after(*turn));
        self.live_slot = after((1..=LIVE).find(is_free).unwrap_or(1));
        first + self.live_slot
    }

    fn modulate(&mut self, modulation: &Modulation) {
        let table = Table::new(modulation, self.carrier()).unwrap_or_else(|_| Table::steady());
        if self.modulation == table {
            return;
        }
        self.tasks.retain(|task| !is_of_modulation(task));
        self.push_to_all(&Packet::envelope(&table.values));
        self.push_to_all(&Packet::rate(table.step, true));
        self.modulation = table;
    }

    /// Whether a newer packet of its kind has superseded it.
    pub(super) fn is_outdated(&self, packet: &Packet) -> bool {
        let Table { values, step } = self.modulation;
        (is_of(packet, Kind::Envelope) && packet.payload != values)
            || (is_of(packet, Kind::Rate) && packet.arguments[..3] != step.to_le_bytes()[..3])
            || (is_of(packet, Kind::Silencer) && packet.arguments[..2] != self.phase_step.to_le_bytes())
    }

    /// Writes a motion into the store, once the player has stopped. Its first frame is played meanwhile from a
    /// separate slot.
    pub(super) fn store(&mut self, wanted: &Wanted) {
        let Some(Way::Stored { count, divider }) = self.storing else { return };
        let Some(Content::Motion { frames, .. }) = wanted.content.as_deref() else { return };
        let chosen: Vec<_> = motion::chosen(frames.len(), count).map(|frame| &frames[frame]).collect();
        let slots = usize::from(self.info.slots);
        let is_free = |slot: &usize| self.devices.iter().all(|device| usize::from(device.slot) != *slot);
        let place = (0..=slots.saturating_sub(count))
            .find_map(|first| (first..first + count).find(is_free).map(|standing| (first, standing)));
        let Some((first, standing)) = place else { return };
        let frame = |slot: usize, address: u8, commit: bool| {
            playing(chosen[slot - first], address, slot as u8, commit)
        };
        let delays: Vec<_> = chosen.iter().map(|levels| delays(levels)).collect();
        let phase_step = motion::phase_step(&delays, divider, motion::GENTLE);
        let addresses = self.addresses();
        for address in addresses.clone() {
            self.push(frame(standing, address, true), false);
        }
        // The others wait until the standing frame was taken, and ENABLE after it.
        let mut waits = true;
        for slot in (first..first + count).filter(|slot| *slot != standing) {
            for address in addresses.clone() {
                self.push(frame(slot, address, false), std::mem::take(&mut waits));
            }
        }
        self.set_silencer(phase_step);
        let last = (first + count - 1) as u8;
        let play = Packet::play(first as u8, last, divider, 0, false);
        let play = self.together(play);
        // No slot of the range can be written any more.
        for address in addresses.rev() {
            self.push(play.clone().to(address), true);
        }
        self.playing = true;
    }

    /// ENABLE follows the first frame of a wish at once.
    pub(super) fn switch_on(&mut self) {
        if !self.placed || self.enabling || self.enabled() || self.ended == Some(self.generation) {
            return;
        }
        for address in self.addresses().rev() {
            if !self.devices[usize::from(address)].enabled {
                let packet = Packet::enable(WATCHDOG).to(address);
                self.tasks.push_front(Task { packet, last: false, attempts: 0, generation: self.generation });
            }
        }
        self.enabling = true;
    }

    /// Hz
    pub(super) fn carrier(&self) -> f64 {
        f64::from(self.info.carrier_millihertz) / 1e3
    }

    /// Frames per second that the line carries to all devices.
    fn line_rate(&self) -> f64 {
        self.profile.frames_per_second(self.baud)
    }
}

/// The part of a frame that a device has, as a packet to it.
fn playing(levels: &Levels, address: u8, slot: u8, commit: bool) -> Packet {
    Packet::playing(&levels.of_device(address), slot, commit).to(address)
}

fn is_of_modulation(task: &Task) -> bool {
    matches!(Kind::from_repr(task.packet.code), Some(Kind::Envelope | Kind::Rate))
}

/// Delays of the elements; 0 for silent ones.
fn delays(levels: &Levels) -> Vec<u8> {
    levels.channels.iter().map(|level| level.map_or(0, |level| level.delay.to_le_bytes()[0])).collect()
}
