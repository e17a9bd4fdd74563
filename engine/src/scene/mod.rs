//! The scene: array, medium, targets, plane and all else that the user edits, as plain data in SI units.
//!
//! A [`Scene`] is a value: everything the program shows or sends is a function of it. The TOML file is read and
//! written by [`mod@file`], and by [`mod@rewrite`] into the text of an earlier one; the limits of every number are
//! held by [`check`], and shapes and letters become focal points in [`outline`], frame by frame in [`motion`].

mod array;
mod bead;
pub mod board;
pub mod chart;
pub mod check;
mod content;
pub mod cover;
pub mod file;
mod focus;
pub mod font;
mod inline;
pub mod liquid;
mod loaded;
mod location;
mod medium;
pub mod modulation;
pub mod motion;
mod names;
pub mod outline;
pub mod pixels;
mod plane;
mod range;
pub mod rewrite;
mod run;
mod shape;
mod solver;
pub mod space;
pub mod strict;
mod stroke;
pub mod target;
mod trap;
mod turns;
pub mod wave;
pub mod zone;

pub use array::{Array, ElementModel};
pub use bead::{Bead, Material};
pub use board::{Board, Elements, Placed, Reflector};
pub use content::{FORMAT, Listener, Scene};
pub use cover::Cover;
pub use focus::{Focus, Part};
pub use liquid::{Light, Liquid, LiquidName};
pub use medium::Medium;
pub use modulation::{Envelope, Law, Modulation, Tone};
pub use motion::{Easing, Keyframe, Motion, MotionPath, Tempo};
pub use pixels::{Dab, Grey, Pixels};
pub use plane::Plane;
pub use range::{Key, KeyError};
pub use shape::{Shape, ShapeKey, ShapeValue};
pub use solver::{Aim, Amplitudes, Method, Pressures, Solver};
pub use target::{Sampling, Target};
pub use trap::{Lobe, Trap};
pub use turns::Turns;
pub use wave::Wave;
pub use zone::{Area, Zone};
