//! Boards: what they play, what is sent to them, and the line in between.

pub mod native;
