//! Virtual boards: each accepts bytes at its bit rate and behaves like the real board.
//!
//! A virtual board accepts bytes at the bit rate of the sender, and reads noise if its own differs (a stock board
//! in memory accepts any). `native::model` plays the native device in real time; `rtl` runs the Verilated gateware
//! in its own, slower time.
//!
//! They share only the line with a link, so both sides are tested against the same bytes. A board in `memory` (the
//! port `virtual:PROFILE`, on the desktop and in a page) serves its own program; a board at a pseudo-terminal
//! (Unix) serves any program. A `hidden` board differs from its model, and a `microphone` reads its field.

#[cfg(unix)]
pub mod faults;
pub mod hidden;
pub(in crate::device) mod logic;
pub mod memory;
pub mod microphone;
#[cfg(unix)]
mod pty;
#[cfg(unix)]
mod rtl;
#[cfg(unix)]
mod terminal;

pub use crate::device::board::logic::{Playing, Shown};
#[cfg(unix)]
pub use crate::device::board::terminal::{Board, Report, Setup, Watch, running};
