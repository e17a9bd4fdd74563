//! The native protocol: what travels ([`table`], [`packet`], [`reply`], and around both [`mod@line`]), and the device that it travels to, exact
//! to the period ([`model`]).

pub mod line;
pub mod model;
pub mod packet;
pub mod reply;
pub mod table;
