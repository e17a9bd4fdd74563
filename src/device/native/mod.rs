//! The native protocol: what travels ([`packet`]), and the device that it travels to, exact to the period ([`model`]).

pub mod model;
pub mod packet;
