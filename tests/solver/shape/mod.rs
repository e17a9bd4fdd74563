//! Shapes: strokes evenly loud and the rest of the plane quiet, judged in f64 by formulae written out plainly.

mod areas;
mod solver;
