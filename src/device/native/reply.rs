//! The answers of the native device.

use crate::device::native::line;
use crate::device::native::line::Spoiled;
use crate::device::native::table::{Kind, Outcome, REPLY};

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
        line::framed(body)
    }

    /// The reply that stands before a delimiter.
    ///
    /// # Errors
    /// Not COBS, another length than a reply's, a wrong CRC, or a result that no device gives.
    pub fn of_line(bytes: &[u8]) -> Result<Self, Spoiled> {
        let body: [u8; 14] = line::checked(bytes)?.try_into().map_err(|_| Spoiled)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn body_of(line: &[u8]) -> &[u8] {
        line.strip_suffix(&[0]).unwrap()
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
        let status = Status { slot: 5, framing_errors: 255, good: 65_535, spoiled: 0, periods: 0xDEAD_BEEF };
        for (code, body) in
            [(0x81, Body::Info(info)), (0x80, Body::Status(status)), (0x90, Body::Status(status))]
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
}
