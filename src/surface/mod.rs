//! What a steady or changing pressure does to the surface of a liquid: its depression at rest, and waves.

pub mod dent;
pub mod dispersion;
pub mod waves;

pub use dent::{Dent, Tank};
pub use waves::{Rest, Waves};
