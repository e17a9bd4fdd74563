//! What sound does to a surface that reflects it: radiation pressure, the dent it presses into a liquid, and the waves of
//! that.

pub mod dent;
pub mod dispersion;
pub mod radiation;
pub mod waves;

pub use dent::{Dent, Tank};
pub use radiation::Reflector;
pub use waves::{Rest, Waves};
