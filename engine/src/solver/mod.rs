//! From focal points to a drive, and the quality of that drive.
//!
//! Every method is a function from a [`Problem`] to an [`Excitation`]; [`solve`] makes the excitation uniform, as
//! most boards require, scales it down for targets in pascals, and measures the result. [`excite`] names the
//! methods:
//!
//! - the inverses (`pinv`, `weighted`) prescribe the complex focal field: [`inverse`];
//! - phase conjugation (`naive`) and the phase iterations (`gs`, `gspat`, `wgs`, `greedy`) leave focal phases free:
//!   [`iteration`];
//! - `best` levels moduli in [`contest`], draws continuous strokes and areas with low side lobes in [`shape`], and
//!   holds beads in [`trap`].
//!
//! [`frames`] solves motions, and [`felt`] levels what a hand feels of them. [`Limits`] computes a drive's distance from the best possible one on request: it
//! takes longer than the drive and is independent of the method, so commands that print it compute it once.
//!
//! A solver never returns NaN: singular values below 1e-6 of the largest are not inverted, weights are floored and
//! capped, and `engine/tests/solver/properties.rs` tries coincident, dense and too many foci with every method. No
//! result depends on a clock or on the number of threads, unless a time limit was asked for.
//!
//! `docs/adding-a-solver.md` is the guide to adding a method.

mod bidiagonal;
pub(crate) mod cholesky;
mod contest;
mod descent;
mod felt;
pub mod frames;
mod inverse;
mod iteration;
#[doc(hidden)]
pub mod levels;
mod matrix;
mod method;
mod own;
#[doc(hidden)]
pub mod parts;
mod problem;
mod quality;
mod ranges;
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
#[doc(hidden)]
pub use ranges::{Ranges, left_by_faults};
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
pub use warning::{of_drive as warning_of_drive, of_foci as warnings_of_foci};
