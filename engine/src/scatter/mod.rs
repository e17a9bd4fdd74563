//! Bodies that scatter sound.

mod mesh;
pub mod shapes;
mod sphere;

pub use mesh::{Fault, Mesh};
pub use sphere::{Sound, Sphere};
