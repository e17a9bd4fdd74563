//! Live control by other programs, over OSC, WebSocket and Ultraino's commands: edits of a scene, and replies.
//!
//! Nothing is queued. A socket's thread decodes a packet and changes the scene on the [`desk`] immediately, under a
//! lock. The loop ([`live`]; in the window, the frame) wakes, has the current scene solved on a thread
//! ([`mod@beside`]) and hands the drive to the link, where again the newest wins. A flood of packets costs
//! processing time, never delay or memory. A change is a value (a list of [`edit::Edit`]) and [`edit::Wish::after`]
//! a pure function: a refused change has no effect.
//!
//! Each limit is defined beside its subject: bytes of packets and messages, nested bundles (before rosc descends
//! into them), connections, senders, waiting answers, answers per second.

mod beside;
pub mod board;
pub mod counts;
pub mod desk;
pub mod edit;
pub mod gate;
pub mod json;
mod limiter;
pub mod live;
mod maps;
pub mod osc;
pub mod refusal;
pub mod report;
pub mod server;
pub mod table;
mod udp;
pub mod ultraino;
mod websocket;
