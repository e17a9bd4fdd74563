//! A box in space, lattices of sample points in it, and 3D pictures of it.

pub mod bricks;
pub mod camera;
mod lattice;
pub mod march;
pub mod sampling;
pub mod scenery;

pub use bricks::Volume;
pub use camera::Camera;
pub use lattice::{Block, Lattice, MOST_POINTS, MOST_POINTS_ALONG};
pub use scenery::Scenery;
