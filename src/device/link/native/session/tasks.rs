//! Packets of a session as tasks, with their purposes.

use crate::device::native::packet::{Kind, Packet};

/// Generation of a wish, and index of its frame.
pub type Key = (u64, usize);

/// A packet that must be accepted.
#[derive(Clone, Debug)]
pub struct Task {
    pub packet: Packet,
    /// Sent only when everything before it was accepted.
    pub last: bool,
    pub attempts: u32,
    /// Generation of its wish.
    pub generation: u64,
}

#[derive(Clone, Debug)]
pub enum Purpose {
    Task(Task),
    /// A frame of a stream; a newer one may replace it.
    Frame(Key),
    Ping,
}

impl Purpose {
    pub fn task(&self) -> Option<&Task> {
        match self {
            Self::Task(task) => Some(task),
            Self::Frame(_) | Self::Ping => None,
        }
    }
}

pub fn is_of(packet: &Packet, kind: Kind) -> bool {
    Kind::from_repr(packet.code) == Some(kind)
}

/// Whether a packet is useless for a newer wish.
pub fn serves_one_wish(packet: &Packet) -> bool {
    is_of_content(packet)
        || matches!(Kind::from_repr(packet.code), Some(Kind::Stop | Kind::Enable | Kind::Mute))
}

pub fn is_of_content(packet: &Packet) -> bool {
    matches!(Kind::from_repr(packet.code), Some(Kind::Phases | Kind::Frame | Kind::Play))
}
