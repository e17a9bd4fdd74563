//! The codes of the native protocol: packet types and results.
//!
//! `gateware/rtl/packets.vh` has the same numbers; a test compares the two.

/// Added to a packet's type in its reply. Packet types are below it.
pub const REPLY: u8 = 0x80;
/// The address that all devices heed and no device answers.
pub const BROADCAST: u8 = 0xFF;
/// Devices have addresses from 0 to this.
pub const LARGEST_ADDRESS: u8 = 7;

/// The type of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    pub const ALL: [Self; 16] = [
        Self::Info,
        Self::Status,
        Self::Enable,
        Self::Mute,
        Self::Baud,
        Self::Reset,
        Self::Digest,
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
            Self::Reset => "RESET",
            Self::Digest => "DIGEST",
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

/// The result of a packet.
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
