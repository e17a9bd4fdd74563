//! From focal points to a drive, and the quality of that drive.
//!
//! Every method is a function from a [`Problem`] to an [`Excitation`]; [`solve`] makes the excitation uniform, as
//! most boards require, scales it down for targets in pascals, and measures the result. [`Limits`] computes its
//! distance from the best possible drive on request. The inverses (`pinv`, `weighted`) are in [`inverse`], the phase
//! iterations (`naive`, `gs`, `gspat`, `wgs`, `greedy`, `best`) in [`iteration`]. [`shape`] is `best` for continuous
//! strokes and areas with low side lobes. [`frames`] solves motions.

mod bidiagonal;
mod cholesky;
mod contest;
mod descent;
pub mod frames;
mod inverse;
mod iteration;
#[doc(hidden)]
pub mod levels;
mod matrix;
mod method;
mod problem;
mod quality;
#[doc(hidden)]
pub mod room;
mod run;
#[doc(hidden)]
pub mod shape;
mod shape_figures;
mod singular;
mod solution;
mod starts;
mod statistics;
mod steps;
#[doc(hidden)]
pub mod trap;
mod warning;

pub use inverse::rank_and_condition;
pub use method::{excite, excite_from, search};
pub use problem::{Excitation, Problem};
pub use quality::{Limits, Quality, bound};
pub use run::{solve, solve_on, solve_with};
#[doc(hidden)]
pub use shape::{Search, Stage, Surroundings};
pub use shape_figures::{AreaFigures, Figures};
pub use solution::{Solution, SolveError};
pub use steps::PhaseSteps;
#[doc(hidden)]
pub use trap::Traps;
pub use warning::Warning;
#[doc(hidden)]
pub use warning::of_foci as warnings_of_foci;
