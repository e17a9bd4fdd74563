//! Live control by other programs, over OSC, WebSocket and Ultraino's commands: edits of a scene, and replies.

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
