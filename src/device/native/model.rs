//! A model of the native device: the gateware's behaviour, period by period, and its reply to every packet.
//!
//! Rules, their order and the names of the tables are those of `gateware/doc/protocol.md`. A test drives this model
//! and the Verilog with the same packets and compares all 256 pulses of every period.

use std::f64::consts::PI;

use crate::device::native::line;
use crate::device::native::packet::{AFTER_LOOP, AT_ONCE, AT_TRIGGER, COMMIT, IN_STEP, WHEN_IN_STEP};
use crate::device::native::packet::{BROADCAST, Body, Digest, Flags, Info, Kind, Outcome, Packet};
use crate::device::native::packet::{REPLY, Reply, Status};
use crate::device::native::player::{Play, Player, When};
use crate::device::native::table::LARGEST_ADDRESS;
use crate::device::native::version_1::Introduction;

pub const CHANNELS: usize = 256;
/// Slots of the frame store, unless built with others.
const SLOTS: u16 = 64;
/// Versions of the protocol and of the gateware.
pub const PROTOCOL: u8 = 2;
const VERSION: u8 = 3;
/// Bit rate in 100 000 baud.
const LARGEST_BAUD: u8 = 80;
const POWER_UP_BAUD: u32 = 2_000_000;
/// Periods without a good packet before the line reverts to the power-up bit rate.
const RATE_KEPT: u32 = 32_768;
const CONFIRM: u8 = 0x5A;
/// A silencer step without limit.
const UNLIMITED: u16 = 0xFFFF;
/// Amplitude step when muted, per period in 1/256 of a unit: a ramp, independent of the silencer.
const RAMP: u16 = 0x0100;

/// Delay and amplitude of one channel, of 256 each.
type Pair = [u8; 2];

/// When a channel is high: for `width` levels from level `rise` on, around the end of the period. Silence is (0, 0).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pulse {
    pub rise: u8,
    pub width: u8,
}

/// The device: state, gate, boundary and sweep.
#[derive(Clone, Debug)]
pub struct Model {
    phase_bits: u8,
    carrier_millihertz: u32,
    address: u8,
    // State set by packets.
    store: Vec<[Pair; CHANNELS]>,
    envelope: [u8; 256],
    widths: [u8; 256],
    calibration: [Pair; CHANNELS],
    phase_step: u16,
    amplitude_step: u16,
    watchdog: u16,
    increment: u16,
    // State that evolves by itself.
    enabled: bool,
    tripped: bool,
    stopped: bool,
    quiet: u32,
    player: Player,
    nco: u32,
    nco_step: u32,
    restart: bool,
    phases: [u16; CHANNELS],
    amplitudes: [u16; CHANNELS],
    next: [Pulse; CHANNELS],
    next_on: bool,
    /// Slot, envelope and state of a sweep in which no silencer moved: a sweep of the same finds the same.
    settled: Option<(u8, u8, bool)>,
    played: [Pulse; CHANNELS],
    outputs_on: bool,
    /// The period after this one begins a cycle, or this one does.
    next_begins: bool,
    begins: bool,
    // External state.
    pressed: bool,
    follows: bool,
    /// `trigger_in` rose since the last boundary.
    triggered: bool,
    /// The period that begins next is marked on the leader's `sync`, or the one that began last on this device's.
    marked: bool,
    // Counters.
    periods: u32,
    good: u16,
    spoiled: u16,
    framing_errors: u8,
}

impl Model {
    /// A device with 2^`phase_bits` levels per period (5 to 8), just switched on.
    ///
    /// # Panics
    /// Another number of phase bits.
    pub fn new(phase_bits: u8) -> Self {
        assert!((5..=8).contains(&phase_bits), "{phase_bits} phase bits");
        let mut model = Self {
            phase_bits,
            carrier_millihertz: 40_000_000,
            address: 0,
            store: vec![[[0; 2]; CHANNELS]; usize::from(SLOTS)],
            envelope: [255; 256],
            widths: default_widths(),
            calibration: [[0, 255]; CHANNELS],
            phase_step: 0x0300,
            amplitude_step: 0x0600,
            watchdog: 0,
            increment: 0,
            enabled: false,
            tripped: false,
            stopped: false,
            quiet: 0,
            player: Player::default(),
            nco: 0,
            nco_step: 0,
            restart: false,
            phases: [0; CHANNELS],
            amplitudes: [0; CHANNELS],
            next: [Pulse::default(); CHANNELS],
            next_on: false,
            settled: None,
            played: [Pulse::default(); CHANNELS],
            outputs_on: false,
            next_begins: false,
            begins: false,
            pressed: false,
            follows: false,
            triggered: false,
            marked: false,
            periods: 0,
            good: 0,
            spoiled: 0,
            framing_errors: 0,
        };
        model.increment = model.power_up_increment();
        model
    }

    /// The same device on another clock.
    pub fn with_carrier(mut self, carrier_millihertz: u32) -> Self {
        self.carrier_millihertz = carrier_millihertz;
        self
    }

    /// The same device with other address pins.
    ///
    /// # Panics
    /// An address above 7.
    pub fn with_address(mut self, address: u8) -> Self {
        assert!(address <= LARGEST_ADDRESS, "address {address}");
        self.address = address;
        self
    }

    /// The same device with another number of slots in its frame store.
    ///
    /// # Panics
    /// Fewer than 2 slots or more than 256.
    pub fn with_slots(mut self, slots: u16) -> Self {
        assert!((2..=256).contains(&slots), "{slots} slots");
        self.store = vec![[[0; 2]; CHANNELS]; usize::from(slots)];
        self
    }

    fn slots(&self) -> u16 {
        self.store.len() as u16
    }

    pub fn levels(&self) -> u16 {
        1 << self.phase_bits
    }

    /// Hz
    pub fn carrier(&self) -> f64 {
        f64::from(self.carrier_millihertz) / 1e3
    }

    /// Bits per second on the line, both ways.
    pub fn baud(&self) -> f64 {
        f64::from(self.increment) / 65_536.0 * f64::from(clocks(self.phase_bits)) * self.carrier()
    }

    fn power_up_increment(&self) -> u16 {
        let clock = f64::from(clocks(self.phase_bits)) * 40_000.0;
        (f64::from(POWER_UP_BAUD) / clock * 65_536.0).round() as u16
    }

    /// The emergency stop: off at once and until ENABLE or RESET, for any length of press.
    pub fn press(&mut self, pressed: bool) {
        self.pressed = pressed;
        if pressed {
            (self.enabled, self.tripped, self.stopped) = (false, true, true);
        }
    }

    /// Sets whether `sync_in` carries a leader's periods.
    pub fn follow(&mut self, follows: bool) {
        self.follows = follows;
    }

    /// The leader's `sync` marks the next period: commands waiting for the mark are taken in it.
    pub fn mark(&mut self) {
        self.marked = true;
    }

    /// Whether `sync` marks the current period; only a leader's does.
    pub fn marks(&self) -> bool {
        self.marked && !self.follows
    }

    /// `trigger_in` rises.
    pub fn trigger(&mut self) {
        self.triggered = true;
    }

    /// Whether `trigger` is high in this period: the first one of a cycle, with sound.
    pub fn triggers(&self) -> bool {
        self.begins
    }

    /// Advances by one period. It plays the result of the previous sweep.
    pub fn period(&mut self) -> &[Pulse; CHANNELS] {
        self.played = self.next;
        self.outputs_on = self.next_on;
        self.begins = self.next_begins && self.next_on;
        self.boundary();
        self.sweep();
        &self.played
    }

    /// The slot that the sweep reads.
    pub fn slot(&self) -> u8 {
        self.player.slot()
    }

    /// The pulses of the current period.
    pub fn played(&self) -> &[Pulse; CHANNELS] {
        &self.played
    }

    /// Whether the pulses of this period reach the transducers.
    pub fn outputs_on(&self) -> bool {
        self.outputs_on && !self.stopped
    }

    fn boundary(&mut self) {
        self.periods = self.periods.wrapping_add(1);
        self.quiet = self.quiet.saturating_add(1);
        let late = self.watchdog > 0 && self.quiet >= 64 * u32::from(self.watchdog);
        if self.enabled && late {
            (self.enabled, self.tripped) = (false, true);
        }
        if self.quiet >= RATE_KEPT {
            self.increment = self.power_up_increment();
        }
        let in_step =
            if self.follows { std::mem::take(&mut self.marked) } else { self.player.waits_in_step() };
        self.marked = in_step && !self.follows;
        let plays = self.player.step(in_step, std::mem::take(&mut self.triggered));
        let nco = if std::mem::take(&mut self.restart) { 1 << 24 } else { self.nco + self.nco_step };
        self.nco = nco & 0xFF_FFFF;
        self.next_begins = plays || (nco > 0xFF_FFFF && !self.player.plays_several());
    }

    fn sweep(&mut self) {
        let envelope = self.envelope[(self.nco >> 16) as usize];
        let inputs = (self.player.slot(), envelope, self.enabled);
        if self.settled == Some(inputs) {
            return;
        }
        let mut moves = false;
        let amplitude_step = if self.enabled { self.amplitude_step } else { self.amplitude_step.max(RAMP) };
        for n in 0..CHANNELS {
            let ([phase, amplitude], [offset, gain]) =
                (self.store[usize::from(self.player.slot())][n], self.calibration[n]);
            let target = u16::from(phase.wrapping_add(offset)) << 8;
            let amplitude = if self.enabled { scaled(amplitude, gain) } else { 0 };
            let before = (self.phases[n], self.amplitudes[n]);
            self.phases[n] = turned(self.phases[n], target, self.phase_step);
            self.amplitudes[n] = approached(self.amplitudes[n], u16::from(amplitude) << 8, amplitude_step);
            moves |= before != (self.phases[n], self.amplitudes[n]);
            let [_, high] = self.amplitudes[n].to_le_bytes();
            let width = match scaled(high, envelope) {
                0 => 0,
                amplitude => self.widths[usize::from(amplitude)].min(128),
            };
            let [_, phase] = self.phases[n].to_le_bytes();
            self.next[n] = pulse(self.phase_bits, phase, width);
        }
        self.next_on = self.enabled || self.amplitudes.iter().any(|&amplitude| amplitude > 0);
        self.settled = (!moves).then_some(inputs);
    }

    /// Applies a good packet and returns its answer, unless it is a broadcast or for another device.
    pub fn hear(&mut self, packet: &Packet) -> Option<Reply> {
        let reply = self.heeds(packet).then(|| self.apply(packet));
        reply.filter(|_| packet.address != BROADCAST)
    }

    /// Whether a packet is for this device, possibly among others. Replies, with types from [`REPLY`] on, never are.
    pub fn heeds(&self, packet: &Packet) -> bool {
        packet.code < REPLY && [self.address, BROADCAST].contains(&packet.address)
    }

    /// The gate: applies or refuses a packet for this device, and returns the answer.
    pub fn apply(&mut self, packet: &Packet) -> Reply {
        self.good = self.good.wrapping_add(1);
        self.quiet = 0;
        self.settled = None;
        let outcome = match Kind::from_repr(packet.code) {
            None => Outcome::Unknown,
            Some(kind) if packet.payload.len() != kind.payload() => Outcome::Length,
            Some(kind) => self.effect(kind, packet),
        };
        let body = match Kind::from_repr(packet.code) {
            Some(Kind::Info) => Body::Info(self.info()),
            Some(Kind::Digest) if outcome == Outcome::Ok => Body::Digest(self.digest(packet)),
            _ => Body::Status(self.status()),
        };
        let (code, seq) = (packet.code.wrapping_add(REPLY), packet.seq);
        Reply { code, address: self.address, seq, outcome, flags: self.flags(), body }
    }

    /// Bytes that were no packet; `by_uart` if a byte of them had no stop bit. The device at address 0 answers.
    pub fn spoil(&mut self, by_uart: bool) -> Option<Reply> {
        self.spoiled = self.spoiled.wrapping_add(1);
        self.framing_errors = self.framing_errors.wrapping_add(u8::from(by_uart));
        (self.address == 0).then(|| Reply {
            code: REPLY,
            address: 0,
            seq: 0,
            outcome: Outcome::Crc,
            flags: self.flags(),
            body: Body::Status(self.status()),
        })
    }

    /// INFO of version 1: counted as spoiled but answered.
    pub fn introduce(&mut self, seq: u8) -> Option<Introduction> {
        self.spoiled = self.spoiled.wrapping_add(1);
        (self.address == 0).then(|| Introduction { seq, flags: self.flags(), info: self.info() })
    }

    fn info(&self) -> Info {
        Info {
            protocol: PROTOCOL,
            phase_bits: self.phase_bits,
            slots: self.slots(),
            version: VERSION,
            carrier_millihertz: self.carrier_millihertz,
            channels: CHANNELS as u16,
            largest_baud: LARGEST_BAUD,
        }
    }

    fn status(&self) -> Status {
        Status {
            slot: self.player.slot(),
            framing_errors: self.framing_errors,
            good: self.good,
            spoiled: self.spoiled,
            periods: self.periods,
        }
    }

    fn digest(&self, packet: &Packet) -> Digest {
        let [what, slot, _, _] = packet.arguments;
        let crc = match what {
            0 => line::digest(self.store[usize::from(slot)].as_flattened()),
            1 => line::digest(&self.envelope),
            2 => line::digest(&self.widths),
            _ => line::digest(self.calibration.as_flattened()),
        };
        let Status { slot, framing_errors, good, spoiled, .. } = self.status();
        Digest { slot, framing_errors, good, spoiled, crc }
    }

    fn flags(&self) -> Flags {
        Flags {
            enabled: self.enabled,
            tripped: self.tripped,
            playing: self.player.plays_several(),
            emergency_stop: self.pressed,
            outputs_on: self.outputs_on(),
            waiting: self.player.waits(),
            stopped: self.stopped,
            follows: self.follows,
        }
    }

    /// `packet` is of this kind and of its length.
    fn effect(&mut self, kind: Kind, packet: &Packet) -> Outcome {
        let [a, b, c, d] = packet.arguments;
        let (low, high) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
        match kind {
            Kind::Info | Kind::Status => {}
            Kind::Enable if low == 0 && c != CONFIRM => return Outcome::Argument,
            Kind::Enable if self.pressed => return Outcome::State,
            Kind::Enable => {
                (self.watchdog, self.enabled) = (low, true);
                (self.tripped, self.stopped) = (false, false);
            }
            Kind::Mute => self.enabled = false,
            Kind::Baud if !(64..=16_384).contains(&low) => return Outcome::Argument,
            Kind::Baud => self.increment = low,
            Kind::Reset if self.sounds() => return Outcome::State,
            Kind::Reset => self.reset(),
            Kind::Digest if a > 3 || (a == 0 && u16::from(b) >= self.slots()) => return Outcome::Argument,
            Kind::Digest => {}
            Kind::Phases => return self.write(packet, |payload, n| [payload[n], b]),
            Kind::Frame => return self.write(packet, |payload, n| [payload[2 * n], payload[2 * n + 1]]),
            Kind::Play => return self.play(packet),
            Kind::Stop => self.player.stop(),
            Kind::Envelope => self.envelope.copy_from_slice(&packet.payload),
            Kind::Rate => {
                self.nco_step = u32::from_le_bytes([a, b, c, 0]);
                self.restart |= d & 1 == 1;
            }
            Kind::Silencer if low == 0 || high == 0 => return Outcome::Argument,
            Kind::Silencer => (self.phase_step, self.amplitude_step) = (low, high),
            Kind::Widths => self.widths.copy_from_slice(&packet.payload),
            Kind::Calibration => {
                self.calibration =
                    std::array::from_fn(|n| [packet.payload[2 * n], packet.payload[2 * n + 1]]);
            }
        }
        Outcome::Ok
    }

    /// Whether outputs are active in this period or the next, apart from the emergency stop.
    fn sounds(&self) -> bool {
        self.enabled || self.outputs_on || self.next_on
    }

    /// A chip reset, except for bit rate, counters, and external state.
    fn reset(&mut self) {
        let fresh = Self::new(self.phase_bits).with_carrier(self.carrier_millihertz).with_slots(self.slots());
        *self = Self {
            increment: self.increment,
            tripped: self.pressed,
            stopped: self.pressed,
            pressed: self.pressed,
            follows: self.follows,
            triggered: self.triggered,
            periods: self.periods,
            good: self.good,
            spoiled: self.spoiled,
            framing_errors: self.framing_errors,
            ..fresh.with_address(self.address)
        };
    }

    fn write(&mut self, packet: &Packet, pair: impl Fn(&[u8], usize) -> Pair) -> Outcome {
        let [slot, _, flags, _] = packet.arguments;
        if u16::from(slot) >= self.slots() {
            return Outcome::Argument;
        }
        if self.player.holds(slot) {
            return Outcome::Busy;
        }
        self.store[usize::from(slot)] = std::array::from_fn(|n| pair(&packet.payload, n));
        if flags & COMMIT != 0 {
            let when = if flags & IN_STEP != 0 { When::InStep } else { When::AtOnce };
            self.player.ask(Play { first: slot, last: slot, divider: 1, loops: 0, when, begins: false });
        }
        Outcome::Ok
    }

    fn play(&mut self, packet: &Packet) -> Outcome {
        let [first, last, low, high] = packet.arguments;
        let divider = u16::from_le_bytes([low, high]);
        let &[fewer, more, when] = &packet.payload[..] else { return Outcome::Length };
        let when = match when {
            AT_ONCE => When::AtOnce,
            AFTER_LOOP => When::AfterLoop,
            WHEN_IN_STEP => When::InStep,
            AT_TRIGGER => When::AtTrigger,
            _ => return Outcome::Argument,
        };
        if last < first || u16::from(last) >= self.slots() || divider == 0 {
            return Outcome::Argument;
        }
        let loops = u16::from_le_bytes([fewer, more]);
        self.player.ask(Play { first, last, divider, loops, when, begins: true });
        Outcome::Ok
    }
}

/// Clocks per period.
pub fn clocks(phase_bits: u8) -> u32 {
    8 << phase_bits.max(7)
}

/// Widths in 1/256 period for a fundamental proportional to the amplitude.
fn default_widths() -> [u8; 256] {
    std::array::from_fn(|amplitude| (256.0 / PI * (amplitude as f64 / 255.0).asin()).round() as u8)
}

fn scaled(value: u8, by: u8) -> u8 {
    let [_, high] = (u16::from(value) * (u16::from(by) + 1)).to_le_bytes();
    high
}

/// `phase`, turned towards `target` the short way round by at most `step`.
fn turned(phase: u16, target: u16, step: u16) -> u16 {
    let way = target.wrapping_sub(phase) as i16;
    if way.unsigned_abs() <= step || step == UNLIMITED {
        target
    } else if way > 0 {
        phase.wrapping_add(step)
    } else {
        phase.wrapping_sub(step)
    }
}

fn approached(value: u16, target: u16, step: u16) -> u16 {
    if value < target { value + step.min(target - value) } else { value - step.min(value - target) }
}

/// The pulse around a delay (1/256 period) of a width (1/256 period), in levels.
fn pulse(phase_bits: u8, phase: u8, width: u8) -> Pulse {
    let shift = 8 - phase_bits;
    let half = (1 << shift) >> 1;
    let levels = (i32::from(width) + half) >> shift;
    if levels == 0 {
        return Pulse::default();
    }
    // The pulse is centred as it is played: the rise depends on the rounded width.
    let rise = (2 * i32::from(phase) - (levels << shift) + (1 << shift)) >> (shift + 1);
    Pulse { rise: rise.rem_euclid(1 << phase_bits) as u8, width: levels as u8 }
}
