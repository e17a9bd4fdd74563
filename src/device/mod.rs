//! Boards: what they play, what is sent to them, and the line in between.

pub mod calibration;
pub mod levels;
pub mod native;
pub mod order;
pub mod profile;
pub mod stock;
