//! Boards: what they play, what is sent to them, and the line in between.

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
