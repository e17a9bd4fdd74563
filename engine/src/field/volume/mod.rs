//! A box in space, lattices of sample points in it, and 3D pictures of it.

pub(crate) mod bricks;
#[doc(hidden)]
pub mod camera;
mod lattice;
#[doc(hidden)]
pub mod march;
mod sampling;
#[doc(hidden)]
pub mod scenery;

pub use bricks::Volume;
#[doc(hidden)]
pub use camera::Camera;
pub use lattice::{Block, Lattice, MOST_POINTS, MOST_POINTS_ALONG};
pub use sampling::Fineness;
#[doc(hidden)]
pub use scenery::Scenery;
