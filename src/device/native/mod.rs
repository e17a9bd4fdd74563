//! The native protocol: its messages ([`table`], [`packet`], [`reply`], with the framing of [`mod@line`]), and a
//! period-exact model of the device ([`model`]). Programs of version 1 get a reply that names the version
//! ([`version_1`]).

pub mod line;
pub mod model;
pub mod packet;
mod player;
pub mod reply;
pub mod table;
pub mod version_1;
