//! The native protocol: what travels ([`table`], [`packet`], [`reply`], and around both [`mod@line`]), and the device that it travels to, exact
//! to the period ([`model`]). Programs of version 1 are told what they found ([`version_1`]).

pub mod line;
pub mod model;
pub mod packet;
mod player;
pub mod reply;
pub mod table;
pub mod version_1;
