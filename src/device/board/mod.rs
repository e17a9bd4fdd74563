//! Boards that are not there: each takes bytes no faster than its bit rate, and behaves as the real one.
//!
//! They know the line only: what a link and a board agree on, they agree on over these bytes. One in `memory` serves the program that
//! holds it; one at a pseudo-terminal (Unix) serves any program.

#[cfg(unix)]
pub mod faults;
mod logic;
pub mod memory;
#[cfg(unix)]
mod pty;
#[cfg(unix)]
mod rtl;
#[cfg(unix)]
mod terminal;

pub use crate::device::board::logic::{Playing, Shown};
#[cfg(unix)]
pub use crate::device::board::terminal::{Board, Report, Setup, Watch, running};
