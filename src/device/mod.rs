//! Boards: what they play, what is sent to them, and the line in between.
//!
//! A drive becomes [`levels::Levels`] (what an element is told, or that it is off), a frame of bytes or packets, and goes over a
//! [`link`] to a board. Every board has a twin here that understands the same bytes: a type in [`stock`], or
//! [`native::model::Model`]; [`board`] puts it at the other end of a pseudo-terminal.
//!
//! # Another board
//!
//! 1. A variant of [`profile::Profile`] with its facts: elements, levels, what an amplitude is, bit rate, bytes per frame. The
//!    compiler lists what is missing.
//! 2. Its channels in [`order`]: which element each plays. A test holds that no element is forgotten; add two or three
//!    known ones.
//! 3. A file in [`stock`] with `load`, which makes bytes of levels, and a `Twin`, which makes levels of bytes; and a
//!    line each in `stock::load`, `stock::swap`, `stock::silence` and `stock::Twin`. Off is a mask: give it the board's own
//!    value, never a phase.
//! 4. `tests/device.rs` then sends random drives to the twin and wants them back, after any garbage; `tests/link.rs` does the
//!    same over a real line.

#[cfg(all(unix, feature = "serial"))]
pub mod board;
pub mod calibration;
pub mod health;
pub mod levels;
#[cfg(feature = "serial")]
pub mod link;
pub mod native;
pub mod order;
pub mod pace;
#[cfg(feature = "serial")]
pub mod port;
pub mod profile;
pub mod statistics;
pub mod stock;
