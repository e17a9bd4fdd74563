//! The packets of the native protocol: the table, and the way between a packet and the bytes on the line.
//!
//! Meaning and order of every field stand in `gateware/doc/protocol.md`; numbers stand in `gateware/rtl/packets.vh` too, and
//! a test compares the two tables.

use crc::{CRC_16_GENIBUS, Crc};

const CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_GENIBUS);
/// Type, sequence number and four arguments.
const HEAD: usize = 6;
const CRC_BYTES: usize = 2;
/// The longest packet before COBS, CRC included: a frame with amplitudes.
pub const LONGEST: usize = HEAD + 512 + CRC_BYTES;
/// COBS puts one byte in front, one more after every 254.
const LONGEST_ON_LINE: usize = LONGEST + 1 + LONGEST / 254;
/// What is added to a packet's type in its reply.
pub const REPLY: u8 = 0x80;

/// What a packet asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Kind {
    Info = 0x01,
    Status = 0x02,
    Enable = 0x03,
    Mute = 0x04,
    Baud = 0x05,
    Phases = 0x10,
    Frame = 0x11,
    Play = 0x20,
    Stop = 0x21,
    Envelope = 0x30,
    Rate = 0x31,
    Silencer = 0x32,
    Widths = 0x33,
    Calibration = 0x34,
}

impl Kind {
    pub const ALL: [Self; 14] = [
        Self::Info,
        Self::Status,
        Self::Enable,
        Self::Mute,
        Self::Baud,
        Self::Phases,
        Self::Frame,
        Self::Play,
        Self::Stop,
        Self::Envelope,
        Self::Rate,
        Self::Silencer,
        Self::Widths,
        Self::Calibration,
    ];

    pub fn code(self) -> u8 {
        self as u8
    }

    pub fn of_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    /// As `packets.vh` and the protocol's document spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Info => "INFO",
            Self::Status => "STATUS",
            Self::Enable => "ENABLE",
            Self::Mute => "MUTE",
            Self::Baud => "BAUD",
            Self::Phases => "PHASES",
            Self::Frame => "FRAME",
            Self::Play => "PLAY",
            Self::Stop => "STOP",
            Self::Envelope => "ENVELOPE",
            Self::Rate => "RATE",
            Self::Silencer => "SILENCER",
            Self::Widths => "WIDTHS",
            Self::Calibration => "CALIBRATION",
        }
    }

    /// Bytes that follow the four arguments.
    pub fn payload(self) -> usize {
        match self {
            Self::Phases | Self::Envelope | Self::Widths => 256,
            Self::Frame | Self::Calibration => 512,
            Self::Play => 3,
            _ => 0,
        }
    }
}

/// What became of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Outcome {
    Ok = 0,
    Crc = 1,
    Length = 2,
    Busy = 3,
    Unknown = 4,
    Argument = 5,
    State = 6,
}

impl Outcome {
    pub const ALL: [Self; 7] =
        [Self::Ok, Self::Crc, Self::Length, Self::Busy, Self::Unknown, Self::Argument, Self::State];

    pub fn code(self) -> u8 {
        self as u8
    }

    /// As `packets.vh` and the protocol's document spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::Crc => "CRC",
            Self::Length => "LENGTH",
            Self::Busy => "BUSY",
            Self::Unknown => "UNKNOWN",
            Self::Argument => "ARGUMENT",
            Self::State => "STATE",
        }
    }
}

/// Why bytes between two delimiters are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spoiled;

/// A packet to the device. `code` need not be that of a [`Kind`]: the device answers what it does not know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    pub code: u8,
    pub seq: u8,
    pub arguments: [u8; 4],
    pub payload: Vec<u8>,
}

impl Packet {
    pub fn new(kind: Kind, arguments: [u8; 4], payload: Vec<u8>) -> Self {
        Self { code: kind.code(), seq: 0, arguments, payload }
    }

    pub fn info() -> Self {
        Self::new(Kind::Info, [0; 4], Vec::new())
    }

    pub fn status() -> Self {
        Self::new(Kind::Status, [0; 4], Vec::new())
    }

    /// `watchdog` is counted in 64 periods and is not 0: the device mutes itself when nothing came for so long.
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

    /// Delays in 1/256 period and one amplitude for all, into a slot; played from the next period on if `commit`.
    pub fn phases(slot: u8, amplitude: u8, phases: &[u8; 256], commit: bool) -> Self {
        Self::new(Kind::Phases, [slot, amplitude, u8::from(commit), 0], phases.to_vec())
    }

    /// Pairs of delay and amplitude into a slot; played from the next period on if `commit`.
    pub fn frame(slot: u8, pairs: &[[u8; 2]; 256], commit: bool) -> Self {
        Self::new(Kind::Frame, [slot, 0, u8::from(commit), 0], pairs.as_flattened().to_vec())
    }

    /// Slots `first` to `last`, `divider` periods each, `loops` times (0: for ever); `after` the running loop or at once.
    pub fn play(first: u8, last: u8, divider: u16, loops: u16, after: bool) -> Self {
        let ([low, high], [fewer, more]) = (divider.to_le_bytes(), loops.to_le_bytes());
        Self::new(Kind::Play, [first, last, low, high], vec![fewer, more, u8::from(after)])
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

    /// The same packet under another sequence number.
    pub fn numbered(mut self, seq: u8) -> Self {
        self.seq = seq;
        self
    }

    /// What goes over the line, the delimiter at its end included.
    pub fn to_line(&self) -> Vec<u8> {
        let mut body = vec![self.code, self.seq];
        body.extend(self.arguments);
        body.extend(&self.payload);
        framed(body)
    }

    /// The packet that stands before a delimiter.
    ///
    /// # Errors
    /// Not COBS, too short or too long, or a wrong CRC.
    pub fn of_line(bytes: &[u8]) -> Result<Self, Spoiled> {
        let body = checked(bytes)?;
        let Some((&[code, seq, a, b, c, d], payload)) = body.split_first_chunk() else { return Err(Spoiled) };
        Ok(Self { code, seq, arguments: [a, b, c, d], payload: payload.to_vec() })
    }
}

/// What a device says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Info {
    pub protocol: u8,
    pub phase_bits: u8,
    /// 1 to 256
    pub slots: u16,
    pub version: u8,
    /// mHz
    pub carrier_millihertz: u32,
    /// 1 to 256
    pub channels: u16,
    /// In 100 000 baud.
    pub largest_baud: u8,
}

/// How a device fares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// The slot that is being played.
    pub slot: u8,
    /// Packets that the UART spoiled; wraps.
    pub framing_errors: u8,
    /// Wraps.
    pub good: u16,
    /// Wraps.
    pub spoiled: u16,
    /// Periods since power-up; wraps.
    pub periods: u32,
}

/// A device's answer to one packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply {
    /// The packet's, plus [`REPLY`].
    pub code: u8,
    pub seq: u8,
    pub outcome: Outcome,
    pub flags: Flags,
    pub body: Body,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    Info(Info),
    Status(Status),
}

/// What holds in a device at the moment of its reply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    pub enabled: bool,
    /// Muted by the watchdog or the emergency stop, until it is enabled again.
    pub tripped: bool,
    /// Playing more than one slot.
    pub playing: bool,
    pub emergency_stop: bool,
    pub outputs_on: bool,
    /// A PLAY waits.
    pub waiting: bool,
}

impl Flags {
    pub fn bits(self) -> u8 {
        let bits =
            [self.enabled, self.tripped, self.playing, self.emergency_stop, self.outputs_on, self.waiting];
        bits.into_iter().enumerate().map(|(bit, set)| u8::from(set) << bit).sum()
    }

    pub fn of_bits(bits: u8) -> Self {
        let set = |bit: u8| bits >> bit & 1 == 1;
        Self {
            enabled: set(0),
            tripped: set(1),
            playing: set(2),
            emergency_stop: set(3),
            outputs_on: set(4),
            waiting: set(5),
        }
    }
}

impl Reply {
    /// What goes over the line, the delimiter at its end included.
    pub fn to_line(&self) -> Vec<u8> {
        let mut body = vec![self.code, self.seq, self.outcome.code(), self.flags.bits()];
        match self.body {
            Body::Info(info) => {
                // Counts of 1 to 256 travel less one, as the protocol has them.
                let less_one = |count: u16| count.wrapping_sub(1).to_le_bytes()[0];
                body.extend([info.protocol, info.phase_bits, less_one(info.slots), info.version]);
                body.extend(info.carrier_millihertz.to_le_bytes());
                body.extend([less_one(info.channels), info.largest_baud]);
            }
            Body::Status(status) => {
                body.extend([status.slot, status.framing_errors]);
                body.extend(status.good.to_le_bytes());
                body.extend(status.spoiled.to_le_bytes());
                body.extend(status.periods.to_le_bytes());
            }
        }
        framed(body)
    }

    /// The reply that stands before a delimiter.
    ///
    /// # Errors
    /// Not COBS, another length than a reply's, a wrong CRC, or a result that no device gives.
    pub fn of_line(bytes: &[u8]) -> Result<Self, Spoiled> {
        let body: [u8; 14] = checked(bytes)?.try_into().map_err(|_| Spoiled)?;
        let [code, seq, result, flags, b4, b5, b6, b7, b8, b9, b10, b11, b12, b13] = body;
        let outcome = Outcome::ALL.into_iter().find(|outcome| outcome.code() == result).ok_or(Spoiled)?;
        if code < REPLY {
            return Err(Spoiled);
        }
        let body = if code == Kind::Info.code() + REPLY {
            Body::Info(Info {
                protocol: b4,
                phase_bits: b5,
                slots: u16::from(b6) + 1,
                version: b7,
                carrier_millihertz: u32::from_le_bytes([b8, b9, b10, b11]),
                channels: u16::from(b12) + 1,
                largest_baud: b13,
            })
        } else {
            Body::Status(Status {
                slot: b4,
                framing_errors: b5,
                good: u16::from_le_bytes([b6, b7]),
                spoiled: u16::from_le_bytes([b8, b9]),
                periods: u32::from_le_bytes([b10, b11, b12, b13]),
            })
        };
        Ok(Self { code, seq, outcome, flags: Flags::of_bits(flags), body })
    }
}

/// CRC, COBS and delimiter around a body.
fn framed(mut body: Vec<u8>) -> Vec<u8> {
    body.extend(CHECKSUM.checksum(&body).to_be_bytes());
    let mut line = cobs::encode_vec(&body);
    line.push(0);
    line
}

/// The body within COBS and CRC.
fn checked(bytes: &[u8]) -> Result<Vec<u8>, Spoiled> {
    if bytes.len() > LONGEST_ON_LINE {
        return Err(Spoiled);
    }
    let mut body = cobs::decode_vec(bytes).map_err(|_| Spoiled)?;
    let Some((rest, &[high, low])) = body.split_last_chunk() else { return Err(Spoiled) };
    if body.len() > LONGEST || CHECKSUM.checksum(rest) != u16::from_be_bytes([high, low]) {
        return Err(Spoiled);
    }
    body.truncate(body.len() - CRC_BYTES);
    Ok(body)
}

/// Cuts a stream of bytes at its delimiters.
#[derive(Clone, Debug, Default)]
pub struct Splitter {
    part: Vec<u8>,
}

impl Splitter {
    /// What stood before the delimiter, if `byte` is one and anything stood there. Of what is too long for a packet, only
    /// enough is kept to be refused.
    pub fn push(&mut self, byte: u8) -> Option<Vec<u8>> {
        if byte != 0 {
            if self.part.len() <= LONGEST_ON_LINE {
                self.part.push(byte);
            }
            return None;
        }
        let part = std::mem::take(&mut self.part);
        (!part.is_empty()).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body_of(line: &[u8]) -> &[u8] {
        line.strip_suffix(&[0]).unwrap()
    }

    #[test]
    fn the_checksum_is_genibus() {
        // The catalogue's check value, and the register that body and CRC end at before the final XOR.
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0xD64E);
        let mut line = b"123456789".to_vec();
        line.extend(0xD64Eu16.to_be_bytes());
        assert_eq!(CHECKSUM.checksum(&line) ^ 0xFFFF, 0x1D0F);
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
        for (kind, packet) in Kind::ALL.into_iter().zip(packets) {
            assert_eq!((packet.code, packet.payload.len()), (kind.code(), kind.payload()), "{}", kind.name());
            let packet = packet.numbered(200);
            let line = packet.to_line();
            assert!(!body_of(&line).contains(&0));
            assert_eq!(Packet::of_line(body_of(&line)), Ok(packet));
        }
        assert_eq!(Packet::phases(0, 0, &[1; 256], true).to_line().len(), 267);
    }

    #[test]
    fn replies_come_back_from_the_line_and_have_sixteen_bytes() {
        let info = Info {
            protocol: 1,
            phase_bits: 7,
            slots: 256,
            version: 3,
            carrier_millihertz: 39_950_123,
            channels: 256,
            largest_baud: 30,
        };
        let status =
            Status { slot: 5, framing_errors: 255, good: 65_535, spoiled: 0, periods: 0xDEAD_BEEF };
        for (code, body) in [(0x81, Body::Info(info)), (0x80, Body::Status(status)), (0x90, Body::Status(status))]
        {
            for bits in 0..64 {
                let flags = Flags::of_bits(bits);
                assert_eq!(flags.bits(), bits);
                let reply = Reply { code, seq: 9, outcome: Outcome::Busy, flags, body };
                let line = reply.to_line();
                assert_eq!(line.len(), 18);
                assert_eq!(Reply::of_line(body_of(&line)), Ok(reply));
            }
        }
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
        for short in [&[][..], &[1], &[3, 0xFF, 0xFF]] {
            assert_eq!(Packet::of_line(short), Err(Spoiled));
        }
        assert_eq!(Packet::of_line(&vec![1; 5000]), Err(Spoiled));
    }

    #[test]
    fn a_stream_is_cut_at_delimiters_and_never_kept_for_ever() {
        let mut splitter = Splitter::default();
        let parts: Vec<_> =
            [0, 0, 1, 2, 0, 0, 3, 0].into_iter().filter_map(|byte| splitter.push(byte)).collect();
        assert_eq!(parts, [vec![1, 2], vec![3]]);
        (0..100_000).for_each(|_| assert_eq!(splitter.push(9), None));
        assert!(splitter.push(0).unwrap().len() < 1000);
    }
}
