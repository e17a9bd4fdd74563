//! The packets of the native protocol, and their encoding.
//!
//! `gateware/doc/protocol.md` defines all fields and their order.

use crate::device::declaration::Level;
use crate::device::levels::Levels;
use crate::device::native::line;

pub use crate::device::native::line::Splitter;
pub use crate::device::native::line::Spoiled;
pub use crate::device::native::reply::Body;
pub use crate::device::native::reply::Digest;
pub use crate::device::native::reply::Flags;
pub use crate::device::native::reply::Info;
pub use crate::device::native::reply::Reply;
pub use crate::device::native::reply::Status;
pub use crate::device::native::table::BROADCAST;
pub use crate::device::native::table::Kind;
pub use crate::device::native::table::Outcome;
pub use crate::device::native::table::REPLY;

/// Flags of a frame: play it, in step if both are set.
pub(crate) const COMMIT: u8 = 1;
pub(crate) const IN_STEP: u8 = 2;
/// The last byte of a PLAY: at once, at the end of the running loop, in step, or at a trigger.
pub(crate) const AT_ONCE: u8 = 0;
pub(crate) const AFTER_LOOP: u8 = 1;
pub(crate) const WHEN_IN_STEP: u8 = 2;
pub(crate) const AT_TRIGGER: u8 = 3;

/// A packet to the device. `code` may be unknown to [`Kind`]: the device answers those, too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    pub code: u8,
    /// Address of its device, or [`BROADCAST`].
    pub address: u8,
    pub seq: u8,
    pub arguments: [u8; 4],
    pub payload: Vec<u8>,
}

/// Tables with a CRC-32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    Slot(u8),
    Envelope,
    Widths,
    Calibration,
}

impl Packet {
    /// A packet for the device at address 0.
    pub fn new(kind: Kind, arguments: [u8; 4], payload: Vec<u8>) -> Self {
        Self { code: kind.code(), address: 0, seq: 0, arguments, payload }
    }

    pub fn info() -> Self {
        Self::new(Kind::Info, [0; 4], Vec::new())
    }

    pub fn status() -> Self {
        Self::new(Kind::Status, [0; 4], Vec::new())
    }

    /// `watchdog` is in units of 64 periods and not 0: the device mutes itself after this time without packets.
    pub fn enable(watchdog: u16) -> Self {
        let [low, high] = watchdog.to_le_bytes();
        Self::new(Kind::Enable, [low, high, 0, 0], Vec::new())
    }

    pub fn mute() -> Self {
        Self::new(Kind::Mute, [0; 4], Vec::new())
    }

    /// Bit rate = increment / 65536 of the device's clock.
    pub fn baud(increment: u16) -> Self {
        let [low, high] = increment.to_le_bytes();
        Self::new(Kind::Baud, [low, high, 0, 0], Vec::new())
    }

    /// Resets to power-up state except bit rate and counters; refused while outputs are on.
    pub fn reset() -> Self {
        Self::new(Kind::Reset, [0; 4], Vec::new())
    }

    /// Requests the CRC-32 ([`line::digest`]) of a table on the device.
    pub fn digest(table: Table) -> Self {
        let [what, slot] = match table {
            Table::Slot(slot) => [0, slot],
            Table::Envelope => [1, 0],
            Table::Widths => [2, 0],
            Table::Calibration => [3, 0],
        };
        Self::new(Kind::Digest, [what, slot, 0, 0], Vec::new())
    }

    /// Delays in 1/256 period and one amplitude for all, into a slot; played from the next period on if `commit`.
    pub fn phases(slot: u8, amplitude: u8, phases: &[u8; 256], commit: bool) -> Self {
        Self::new(Kind::Phases, [slot, amplitude, u8::from(commit), 0], phases.to_vec())
    }

    /// Pairs of delay and amplitude into a slot; played from the next period on if `commit`.
    pub fn frame(slot: u8, pairs: &[[u8; 2]; 256], commit: bool) -> Self {
        Self::new(Kind::Frame, [slot, 0, u8::from(commit), 0], pairs.as_flattened().to_vec())
    }

    /// Writes a frame into a slot, as phases with one amplitude if possible; played from the next period on if
    /// `commit`.
    pub fn playing(levels: &Levels, slot: u8, commit: bool) -> Self {
        let bytes = |level: Level| [level.delay.to_le_bytes()[0], level.amplitude.to_le_bytes()[0]];
        let pairs: [[u8; 2]; 256] =
            std::array::from_fn(|n| levels.channels.get(n).copied().flatten().map_or([0, 0], bytes));
        let amplitude = pairs[0][1];
        if pairs.iter().all(|&[_, other]| other == amplitude) {
            Self::phases(slot, amplitude, &pairs.map(|[phase, _]| phase), commit)
        } else {
            Self::frame(slot, &pairs, commit)
        }
    }

    /// Slots `first` to `last`, `divider` periods each, `loops` times (0: for ever); `after` the running loop or at once.
    pub fn play(first: u8, last: u8, divider: u16, loops: u16, after: bool) -> Self {
        let ([low, high], [fewer, more]) = (divider.to_le_bytes(), loops.to_le_bytes());
        Self::new(
            Kind::Play,
            [first, last, low, high],
            vec![fewer, more, if after { AFTER_LOOP } else { AT_ONCE }],
        )
    }

    pub fn stop() -> Self {
        Self::new(Kind::Stop, [0; 4], Vec::new())
    }

    pub fn envelope(table: &[u8; 256]) -> Self {
        Self::new(Kind::Envelope, [0; 4], table.to_vec())
    }

    /// Modulation frequency = step / 2^24 of the carrier; `restart` at the start of the table.
    pub fn rate(step: u32, restart: bool) -> Self {
        let [a, b, c, _] = step.to_le_bytes();
        Self::new(Kind::Rate, [a, b, c, u8::from(restart)], Vec::new())
    }

    /// Largest changes per period, in 1/256 of a unit of phase and amplitude; 0xFFFF for no limit.
    pub fn silencer(phase_step: u16, amplitude_step: u16) -> Self {
        let ([a, b], [c, d]) = (phase_step.to_le_bytes(), amplitude_step.to_le_bytes());
        Self::new(Kind::Silencer, [a, b, c, d], Vec::new())
    }

    pub fn widths(table: &[u8; 256]) -> Self {
        Self::new(Kind::Widths, [0; 4], table.to_vec())
    }

    /// Pairs of phase offset and gain.
    pub fn calibration(pairs: &[[u8; 2]; 256]) -> Self {
        Self::new(Kind::Calibration, [0; 4], pairs.as_flattened().to_vec())
    }

    /// Makes a frame's commit, or a PLAY, take effect on all devices in the same period: the leader's next marked
    /// one.
    pub fn in_step(mut self) -> Self {
        if self.is_frame() {
            self.arguments[2] |= COMMIT | IN_STEP;
        } else if let (Some(Kind::Play), Some(when)) = (Kind::from_repr(self.code), self.payload.last_mut()) {
            *when = WHEN_IN_STEP;
        }
        self
    }

    /// Makes a PLAY wait for a rising edge of the device's trigger input.
    pub fn at_trigger(mut self) -> Self {
        if let (Some(Kind::Play), Some(when)) = (Kind::from_repr(self.code), self.payload.last_mut()) {
            *when = AT_TRIGGER;
        }
        self
    }

    /// Whether it is a frame with commit, at once or in step.
    pub fn commits(&self) -> bool {
        self.is_frame() && self.arguments[2] & COMMIT != 0
    }

    fn is_frame(&self) -> bool {
        matches!(Kind::from_repr(self.code), Some(Kind::Phases | Kind::Frame))
    }

    /// The same packet to another device, or to all of them ([`BROADCAST`]).
    pub fn to(mut self, address: u8) -> Self {
        self.address = address;
        self
    }

    /// The same packet under another sequence number.
    pub fn numbered(mut self, seq: u8) -> Self {
        self.seq = seq;
        self
    }

    /// The bytes on the line, including the final delimiter.
    pub fn to_line(&self) -> Vec<u8> {
        let mut body = vec![self.code, self.address, self.seq];
        body.extend(self.arguments);
        body.extend(&self.payload);
        line::framed(body)
    }

    /// The packet before a delimiter.
    ///
    /// # Errors
    /// A line that is not COBS, too short or too long, or has a wrong CRC.
    pub fn of_line(bytes: &[u8]) -> Result<Self, Spoiled> {
        let body = line::checked(bytes)?;
        let Some((&[code, address, seq, a, b, c, d], payload)) = body.split_first_chunk() else {
            return Err(Spoiled);
        };
        Ok(Self { code, address, seq, arguments: [a, b, c, d], payload: payload.to_vec() })
    }
}

#[cfg(test)]
mod tests {
    use strum::VariantArray;

    use super::*;

    fn body_of(line: &[u8]) -> &[u8] {
        line.strip_suffix(&[0]).unwrap()
    }

    #[test]
    fn packets_come_back_from_the_line() {
        let mut phases = [0; 256];
        (0..=255).zip(&mut phases).for_each(|(n, phase)| *phase = n);
        let pairs = phases.map(|n: u8| [n.wrapping_mul(37), 255 - n]);
        let packets = [
            Packet::info(),
            Packet::status(),
            Packet::enable(0x1234),
            Packet::mute(),
            Packet::baud(3200),
            Packet::reset(),
            Packet::digest(Table::Slot(9)),
            Packet::phases(63, 255, &phases, true),
            Packet::frame(1, &pairs, false),
            Packet::play(3, 9, 40_000, 7, true),
            Packet::stop(),
            Packet::envelope(&[0; 256]),
            Packet::rate(0x12_3456, true),
            Packet::silencer(0x0300, 0xFFFF),
            Packet::widths(&[1; 256]),
            Packet::calibration(&pairs),
        ];
        for (kind, packet) in Kind::VARIANTS.iter().zip(packets) {
            assert_eq!(
                (packet.code, packet.payload.len()),
                (kind.code(), kind.payload()),
                "{}",
                kind.into_str()
            );
            let packet = packet.to(5).numbered(200);
            let line = packet.to_line();
            assert!(!body_of(&line).contains(&0));
            assert_eq!(Packet::of_line(body_of(&line)), Ok(packet));
        }
        assert_eq!(Packet::phases(0, 0, &[1; 256], true).to_line().len(), 270);
    }

    #[test]
    fn the_bytes_are_those_of_the_protocols_document() {
        let hex =
            |bytes: Vec<u8>| bytes.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ");
        let text = include_str!("../../../gateware/doc/protocol.md");
        for packet in
            [Packet::info().numbered(1), Packet::enable(125).to(2).numbered(7), Packet::mute().to(BROADCAST)]
        {
            let line = hex(packet.to_line());
            assert!(text.contains(&line), "{line}");
        }
    }

    #[test]
    fn what_is_in_step_says_so() {
        assert_eq!(Packet::phases(1, 2, &[3; 256], false).in_step().arguments, [1, 2, 3, 0]);
        assert_eq!(Packet::play(1, 2, 3, 4, false).in_step().payload, [4, 0, 2]);
        assert_eq!(Packet::stop().in_step(), Packet::stop());
    }

    #[test]
    fn damage_spoils_a_packet() {
        let line = Packet::phases(1, 200, &[77; 256], true).to_line();
        let body = body_of(&line);
        for at in 0..body.len() {
            let mut flipped = body.to_vec();
            flipped[at] ^= 4;
            assert_eq!(Packet::of_line(&flipped), Err(Spoiled), "flip at {at}");
            let mut shorter = body.to_vec();
            shorter.remove(at);
            assert_eq!(Packet::of_line(&shorter), Err(Spoiled), "drop at {at}");
        }
        for short in [&[][..], &[1], &[5, 0xFF, 0xFF, 0xFF, 0xFF]] {
            assert_eq!(Packet::of_line(short), Err(Spoiled));
        }
        assert_eq!(Packet::of_line(&vec![1; 5000]), Err(Spoiled));
    }
}
