//! The codes of the native protocol: packet types and results.
//!
//! `gateware/rtl/packets.vh` has the same numbers; a test compares the two.

use strum::{FromRepr, IntoStaticStr, VariantArray};

/// Added to a packet's type in its reply. Packet types are below it.
pub const REPLY: u8 = 0x80;
/// The address that all devices heed and no device answers.
pub const BROADCAST: u8 = 0xFF;
/// Devices have addresses from 0 to this.
pub const LARGEST_ADDRESS: u8 = 7;

/// The type of a packet, named as in `packets.vh` and the protocol's document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, FromRepr, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "UPPERCASE", const_into_str)]
#[repr(u8)]
pub enum Kind {
    Info = 0x01,
    Status = 0x02,
    Enable = 0x03,
    Mute = 0x04,
    Baud = 0x05,
    Reset = 0x06,
    Digest = 0x07,
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
    pub fn code(self) -> u8 {
        self as u8
    }

    /// Bytes that follow the four arguments.
    pub fn payload(self) -> usize {
        match self {
            Self::Phases | Self::Envelope | Self::Widths => 256,
            Self::Frame | Self::Calibration => 512,
            Self::Play => 3,
            Self::Info
            | Self::Status
            | Self::Enable
            | Self::Mute
            | Self::Baud
            | Self::Reset
            | Self::Digest
            | Self::Stop
            | Self::Rate
            | Self::Silencer => 0,
        }
    }
}

/// The result of a packet, named as there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, FromRepr, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "UPPERCASE", const_into_str)]
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
    pub fn code(self) -> u8 {
        self as u8
    }
}
