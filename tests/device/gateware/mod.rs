//! The gateware: the simulated Verilog agrees with `device::native` byte by byte and pulse by pulse.

mod line;
#[cfg(unix)]
mod link;
mod packets;
mod play;
mod simulated;
mod stop;
mod table;
mod twins;
mod two;
