//! Sonoglyph: drives of an ultrasound phased array for focal points, shapes and letters, and the resulting field.
//!
//! The flow is `Scene` → solver → `Drive` → field → picture; `ARCHITECTURE.md` is the map of the code.
//!
//! ```
//! use glam::dvec3;
//! use sonoglyph::field::{Evaluator, Quantity, Request, Stages};
//! use sonoglyph::scene::{Scene, Shape, Target};
//!
//! // Two focal points, 10 cm in front of 16 x 16 elements at 40 kHz; lengths in m.
//! let at = |x| Target::new(Shape::Point { at: dvec3(x, 0.0, 0.1) });
//! let scene = Scene { targets: vec![at(-0.02), at(0.02)], ..Scene::default() };
//!
//! let solution = sonoglyph::solver::solve(&scene)?;
//! assert_eq!(solution.drive.phases.len(), 256);
//! assert!(solution.warnings.is_empty() && solution.quality.min_pressure > 1000.0);
//!
//! // RMS pressure (Pa) on the scene's plane, row by row from the smallest y.
//! let mut stages = Stages::new(Evaluator::Cpu);
//! let map = stages.map(&Request::new(&scene, solution.drives(), Quantity::Rms, (200, 100)))?;
//! assert_eq!(map.values.len(), 200 * 100);
//! assert!(map.error <= scene.plane.tolerance);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//! Without features, the crate has [`scene`], [`acoustics`], [`solver`], [`drive`], [`field`], [`force`],
//! [`surface`] and the colours and PNG files of [`picture`]. `gpu` adds a second evaluator of the field, `studio`
//! operations on scenes (named files, figures, films, boards), `cli` and `window` (the default) the program
//! itself, which is not part of the public interface.

#[cfg(target_arch = "wasm32")]
#[doc(hidden)]
pub use sonoglyph_engine::shelf;
#[doc(inline)]
pub use sonoglyph_engine::{acoustics, drive, field, force, gauge, scene, solver, surface};
#[doc(hidden)]
pub use sonoglyph_engine::{echo, measure, memory, mesh, rounding, simd, source, table};

#[cfg(feature = "window")]
#[doc(hidden)]
pub mod app;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod bench;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[cfg(all(feature = "control", not(target_arch = "wasm32")))]
#[doc(hidden)]
pub mod control;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod device;
#[cfg(feature = "window")]
#[doc(hidden)]
pub mod import;
pub mod picture;
#[cfg(test)]
#[path = "../tests/requirement/mod.rs"]
mod requirement;
#[cfg(feature = "studio")]
#[doc(hidden)]
pub mod studio;
#[cfg(feature = "window")]
#[doc(hidden)]
pub mod ui;
#[cfg(all(target_arch = "wasm32", feature = "window"))]
#[doc(hidden)]
pub mod web;
