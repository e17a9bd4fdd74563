//! The gateware: what the simulated Verilog does, byte by byte and pulse by pulse, is what `device::native` says.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod dice;
mod line;
mod play;
#[path = "../requirement/mod.rs"]
mod requirement;
mod simulated;
mod stop;
mod table;
mod twins;
mod two;
