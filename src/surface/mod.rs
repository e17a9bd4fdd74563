//! What a steady or changing pressure does to the surface of a liquid: its depression at rest, waves, and
//! where the light goes that it bends.

pub mod caustic;
mod coverage;
pub mod dent;
pub mod dispersion;
pub mod waves;

pub use caustic::{Light, Rays};
pub use dent::{Dent, Tank};
pub use waves::{Rest, Waves};
