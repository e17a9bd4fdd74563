//! Closed surfaces of triangles: from files, by formula, with edges of a wanted length.

mod closed;
mod formats;
mod hand;
mod inside;
mod march;
mod remesh;
pub mod shapes;

pub(crate) use closed::area_vector;
pub use closed::{Fault, Mesh};
pub use formats::{FormatError, obj, stl};
pub(crate) use inside::Inside;
