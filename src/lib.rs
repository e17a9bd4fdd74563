//! Sonoglyph: ultrasound focal points, shapes and letters for a phased array, and the field they make.
//!
//! The flow is `Scene` → solver → `Drive` → field → picture; `ARCHITECTURE.md` tells it in one page.

pub mod acoustics;
#[cfg(feature = "window")]
pub mod app;
#[cfg(feature = "cli")]
pub mod bench;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(all(any(feature = "cli", feature = "window"), not(target_arch = "wasm32")))]
pub mod control;
#[cfg(any(feature = "cli", feature = "serial", feature = "window"))]
pub mod device;
pub mod drive;
pub mod echo;
pub mod field;
pub mod force;
pub mod gauge;
#[cfg(feature = "window")]
pub mod import;
pub mod memory;
pub mod picture;
#[cfg(test)]
#[path = "../tests/requirement/mod.rs"]
mod requirement;
pub mod rounding;
pub mod scene;
#[cfg(target_arch = "wasm32")]
pub mod shelf;
pub mod simd;
pub mod solver;
pub mod source;
#[cfg(any(feature = "cli", feature = "window"))]
pub mod studio;
pub mod surface;
pub mod table;
#[cfg(feature = "window")]
pub mod ui;
#[cfg(all(target_arch = "wasm32", feature = "window"))]
pub mod web;
