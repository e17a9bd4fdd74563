//! The answers of the native device.

use crate::device::native::line;
use crate::device::native::line::Spoiled;
use crate::device::native::table::{Kind, Outcome, REPLY};

/// Bytes of a reply before its CRC.
const BODY: usize = 16;

/// A device's identification.
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
    /// Bit rate in 100 000 baud.
    pub largest_baud: u8,
}

/// The state of a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// The slot being played.
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

/// A reply with the CRC-32 of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digest {
    /// Slot, as in [`Status`].
    pub slot: u8,
    pub framing_errors: u8,
    pub good: u16,
    pub spoiled: u16,
    /// CRC of the table's bytes ([`crate::device::native::line::digest`]).
    pub crc: u32,
}

/// A device's answer to one packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply {
    /// The packet's, plus [`REPLY`].
    pub code: u8,
    /// Address of the device that answers.
    pub address: u8,
    /// Sequence number of the packet.
    pub seq: u8,
    pub outcome: Outcome,
    pub flags: Flags,
    pub body: Body,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    Info(Info),
    Status(Status),
    /// The reply to an accepted DIGEST.
    Digest(Digest),
}

/// The state of a device at its reply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    pub enabled: bool,
    /// Muted by the watchdog or the emergency stop until ENABLE.
    pub tripped: bool,
    /// Playing more than one slot.
    pub playing: bool,
    /// Pressed at this moment.
    pub emergency_stop: bool,
    pub outputs_on: bool,
    /// A PLAY waits.
    pub waiting: bool,
    /// The emergency stop was pressed since the last ENABLE or RESET.
    pub stopped: bool,
    /// It follows another device's periods.
    pub follows: bool,
}

impl Flags {
    pub fn bits(self) -> u8 {
        let bits = [
            self.enabled,
            self.tripped,
            self.playing,
            self.emergency_stop,
            self.outputs_on,
            self.waiting,
            self.stopped,
            self.follows,
        ];
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
            stopped: set(6),
            follows: set(7),
        }
    }
}

impl Reply {
    /// The bytes on the line, including the final delimiter.
    pub fn to_line(&self) -> Vec<u8> {
        let mut body = vec![self.code, self.address, self.seq, self.outcome.code(), self.flags.bits()];
        match self.body {
            Body::Info(info) => {
                body.extend([info.protocol, info.phase_bits, less_one(info.slots), info.version]);
                body.extend(info.carrier_millihertz.to_le_bytes());
                body.extend([less_one(info.channels), info.largest_baud]);
            }
            Body::Status(Status { slot, framing_errors, good, spoiled, periods: last })
            | Body::Digest(Digest { slot, framing_errors, good, spoiled, crc: last }) => {
                body.extend([slot, framing_errors]);
                body.extend(good.to_le_bytes());
                body.extend(spoiled.to_le_bytes());
                body.extend(last.to_le_bytes());
            }
        }
        body.push(0);
        line::framed(body)
    }

    /// The reply before a delimiter.
    ///
    /// # Errors
    /// Invalid COBS, a wrong length, a wrong CRC, or an unknown result.
    pub fn of_line(bytes: &[u8]) -> Result<Self, Spoiled> {
        let body: [u8; BODY] = line::checked(bytes)?.try_into().map_err(|_| Spoiled)?;
        let [code, address, seq, result, flags, b5, b6, b7, b8, b9, b10, b11, b12, b13, b14, _] = body;
        let outcome = Outcome::from_repr(result).ok_or(Spoiled)?;
        if code < REPLY {
            return Err(Spoiled);
        }
        let (slot, framing_errors) = (b5, b6);
        let (good, spoiled) = (u16::from_le_bytes([b7, b8]), u16::from_le_bytes([b9, b10]));
        let last = u32::from_le_bytes([b11, b12, b13, b14]);
        let body = if code == Kind::Info.code() + REPLY {
            Body::Info(Info {
                protocol: b5,
                phase_bits: b6,
                slots: u16::from(b7) + 1,
                version: b8,
                carrier_millihertz: u32::from_le_bytes([b9, b10, b11, b12]),
                channels: u16::from(b13) + 1,
                largest_baud: b14,
            })
        } else if code == Kind::Digest.code() + REPLY && outcome == Outcome::Ok {
            Body::Digest(Digest { slot, framing_errors, good, spoiled, crc: last })
        } else {
            Body::Status(Status { slot, framing_errors, good, spoiled, periods: last })
        };
        Ok(Self { code, address, seq, outcome, flags: Flags::of_bits(flags), body })
    }
}

/// Counts of 1 to 256 are sent less one, by the protocol.
pub(crate) fn less_one(count: u16) -> u8 {
    count.wrapping_sub(1).to_le_bytes()[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body_of(line: &[u8]) -> &[u8] {
        line.strip_suffix(&[0]).unwrap()
    }

    #[test]
    fn replies_come_back_from_the_line_and_have_twenty_bytes() {
        let info = Info {
            protocol: 2,
            phase_bits: 7,
            slots: 256,
            version: 3,
            carrier_millihertz: 39_950_123,
            channels: 256,
            largest_baud: 30,
        };
        let status = Status { slot: 5, framing_errors: 255, good: 65_535, spoiled: 0, periods: 0xDEAD_BEEF };
        let digest = Digest { slot: 5, framing_errors: 255, good: 65_535, spoiled: 0, crc: 0xDEAD_BEEF };
        for (code, outcome, body) in [
            (0x81, Outcome::Busy, Body::Info(info)),
            (0x80, Outcome::Crc, Body::Status(status)),
            (0x90, Outcome::Busy, Body::Status(status)),
            (0x87, Outcome::Argument, Body::Status(status)),
            (0x87, Outcome::Ok, Body::Digest(digest)),
        ] {
            for bits in 0..=255 {
                let flags = Flags::of_bits(bits);
                assert_eq!(flags.bits(), bits);
                let reply = Reply { code, address: 3, seq: 9, outcome, flags, body };
                let line = reply.to_line();
                assert_eq!(line.len(), 22);
                assert_eq!(Reply::of_line(body_of(&line)), Ok(reply));
            }
        }
    }

    #[test]
    fn the_bytes_are_those_of_the_protocols_document() {
        let info = Info {
            protocol: 2,
            phase_bits: 7,
            slots: 64,
            version: 3,
            carrier_millihertz: 40_000_000,
            channels: 256,
            largest_baud: 80,
        };
        let reply = Reply {
            code: 0x81,
            address: 0,
            seq: 1,
            outcome: Outcome::Ok,
            flags: Flags::default(),
            body: Body::Info(info),
        };
        let line: Vec<_> = reply.to_line().iter().map(|byte| format!("{byte:02X}")).collect();
        let text = include_str!("../../../gateware/doc/protocol.md");
        assert!(text.contains(&line.join(" ")), "{line:?}");
    }
}
