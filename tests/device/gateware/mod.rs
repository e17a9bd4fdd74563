//! The gateware: what the simulated Verilog does, byte by byte and pulse by pulse, is what `device::native` says.

mod dice;
mod line;
#[cfg(all(unix, feature = "serial"))]
mod link;
mod play;
mod simulated;
mod stop;
mod table;
mod twins;
mod two;
