//! Bodies that scatter sound.

mod boundary;
mod facets;
mod gmres;
mod hierarchy;
mod mesh;
mod near;
mod pairs;
mod radiation;
pub mod shapes;
mod sphere;

pub use boundary::{Boundary, TOLERANCE};
pub use gmres::Outcome;
pub use mesh::{Fault, Mesh};
pub use sphere::{Sound, Sphere};
