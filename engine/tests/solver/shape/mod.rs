//! Shapes: even strokes with low side lobes, and areas, measured in f64 by direct formulae.

mod areas;
mod free;
mod solver;
