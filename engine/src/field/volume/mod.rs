//! A box in space, lattices of sample points in it, and 3D pictures of it.
//!
//! A [`Volume`] is the RMS pressure on a lattice of points in f32. Layers parallel to a flat board share one table
//! per board as in maps, with steps that divide the pitch; other boards evaluate their waves anew. A picture
//! consists of a [`Scenery`] (lines, dots, discs, panels, slices), a body (isosurface, projection), a [`Camera`]
//! and a size. [`scenery::Shot`] converts it for both renderers: objects in the picture's coordinates and, for each
//! tile of 16 x 16 pixels, the list of visible objects.
//!
//! A ray intersects the objects of its tile and marches through the box, skipping by bricks of 8³ cells with known
//! maxima; hits are sorted by depth and blended. Edges of lines and discs are antialiased by coverage; the CPU
//! casts four rays per pixel where neighbours differ, the GPU for every pixel at rest. [`march`] is the CPU
//! renderer and the reference for `shaders/volume.wgsl`, which has the same formulae line by line. On software
//! adapters the CPU draws (`Tuning::draws_space`).

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
