//! Bodies that scatter sound.

mod boundary;
mod facets;
mod formats;
mod gmres;
mod hierarchy;
mod mesh;
mod near;
mod pairs;
mod radiation;
mod remesh;
pub mod shapes;
mod sphere;
mod waves;

pub use boundary::{BodyError, Boundary, TOLERANCE};
pub use formats::{FormatError, obj, stl};
pub use gmres::Outcome;
pub use mesh::{Fault, Mesh};
pub use sphere::{Sound, Sphere};
