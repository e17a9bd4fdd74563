//! The scene: array, medium, targets, plane and all else that the user edits, as plain data in SI units.
//!
//! A [`Scene`] is a value: everything the program shows or sends is a function of it. The TOML file is read and
//! written by [`mod@file`], and by `rewrite` into the text of an earlier one; the limits of every number are held by
//! [`mod@check`], and shapes and letters become focal points in [`outline`], frame by frame in [`motion`].

mod array;
mod bead;
mod board;
mod bodies;
mod body;
#[doc(hidden)]
pub mod chart;
pub mod check;
mod content;
mod cover;
pub(crate) mod directivity;
pub(crate) mod drive;
pub mod file;
mod focus;
#[doc(hidden)]
pub mod font;
mod inline;
mod liquid;
mod loaded;
mod location;
mod medium;
pub(crate) mod modulation;
pub mod motion;
mod names;
pub mod outline;
mod pixels;
mod plane;
mod range;
mod response;
#[doc(hidden)]
pub mod rewrite;
mod run;
mod shape;
mod skin;
mod solver;
mod space;
#[doc(hidden)]
pub mod strict;
mod stroke;
mod target;
mod trap;
mod turns;
mod wave;
mod wires;
mod zone;

pub use array::{Array, ElementModel, Spread};
pub use bead::{Bead, Material};
pub use board::{Board, Elements, Placed, Reflector};
pub use body::{Body, BodyKind, Surface};
pub use content::{FORMAT, Listener, Scene};
#[doc(hidden)]
pub use cover::Cover;
#[doc(hidden)]
pub use directivity::{Directivity, Measured, Reading};
pub use drive::DriveFile;
#[doc(hidden)]
pub use drive::{Drive, DriveTable};
pub use focus::{Focus, Part};
pub use liquid::{Light, Liquid, LiquidName};
#[doc(hidden)]
pub use medium::Fluid;
pub use medium::Medium;
pub use modulation::{Envelope, Law, Modulation, SpectralLine, Tone};
#[doc(hidden)]
pub use modulation::{MOST_TONES, frequencies};
#[doc(hidden)]
pub use motion::{Easing, Keyframe, Motion, MotionPath, Tempo};
pub use pixels::{Dab, Grey, Pixels};
pub use plane::Plane;
pub use range::{Key, KeyError};
pub(crate) use response::Circuit;
pub use response::{Pole, Response, Transducer};
pub use shape::{Shape, ShapeKey, ShapeValue};
pub use skin::{Channel, Skin};
#[doc(hidden)]
pub use skin::{Curve, Threshold, UNCERTAINTY};
pub use solver::{Aim, Amplitudes, Method, Pressures, Solver};
#[doc(hidden)]
pub use space::Size;
#[doc(hidden)]
pub use target::TargetTable;
pub use target::{Sampling, Target};
pub use trap::Trap;
pub use turns::Turns;
pub use wave::{Wave, Waveform};
pub use wires::{Correction, Wire, Wires};
pub use zone::{Area, Zone};
