//! The numbers of Sonoglyph: scenes, acoustics, solvers, and fields by CPU and GPU.
//!
//! Programs use the crate `sonoglyph`, which has all of this crate's modules.

pub mod acoustics;
pub mod drive;
#[doc(hidden)]
pub mod echo;
pub mod field;
pub mod force;
pub mod gauge;
#[doc(hidden)]
pub mod measure;
#[doc(hidden)]
pub mod memory;
#[doc(hidden)]
pub mod mesh;
#[cfg(test)]
#[path = "../../tests/requirement/mod.rs"]
mod requirement;
#[doc(hidden)]
pub mod rounding;
#[doc(hidden)]
pub mod scatter;
pub mod scene;
#[cfg(target_arch = "wasm32")]
#[doc(hidden)]
pub mod shelf;
#[doc(hidden)]
pub mod simd;
pub mod solver;
#[doc(hidden)]
pub mod source;
#[doc(hidden)]
pub mod special;
pub mod surface;
#[doc(hidden)]
pub mod table;
