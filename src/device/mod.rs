//! Boards: their levels, their bytes, and the line to them.
//!
//! A drive becomes [`levels::Levels`] (the level of each channel, or off), a frame of bytes or packets, and goes
//! over a [`link`] to a board. Levels are a drive in a board's own terms, quantised in one place
//! (`Profile::level`); off is the absence of a level. Stock boards receive bytes, native boards packets
//! (`gateware/doc/protocol.md`). Every board has a twin here that understands the same bytes: [`stock::Twin`], or
//! [`native::model::Model`]; [`board`] puts it at the other end of a line.
//!
//! [`profile`] lists the boards: each is one [`declaration`] in `device/profile`; boards of one
//! protocol share a file.
//! `docs/adding-a-board.md` is the guide to adding a board.

pub mod board;
pub mod calibration;
pub mod declaration;
pub mod envelope;
pub mod health;
pub mod levels;
pub mod link;
pub mod native;
pub mod pace;
pub(crate) mod pat;
pub mod port;
pub mod profile;
pub mod statistics;
pub mod stock;
pub mod task;
pub mod wiring;
