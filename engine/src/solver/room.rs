//! Memory of a problem's tables, reserved before they are built.

use num_complex::Complex64;

use crate::memory::{self, Room};
use crate::scene::{Method, Scene};
use crate::solver::solution::SolveError;

/// Numbers of tables of elements x foci and of foci x foci in memory at the same time: measured, and rounded up.
struct Tables {
    of_elements: usize,
    of_foci: usize,
}

impl Tables {
    fn of(method: Method) -> Self {
        let (of_elements, of_foci) = match method {
            Method::Focus | Method::Naive | Method::Greedy => (2, 1),
            Method::Weighted | Method::Pinv => (5, 8),
            Method::Gs | Method::Gspat | Method::Wgs | Method::Best => (3, 6),
        };
        Self { of_elements, of_foci }
    }
}

/// Memory for solving scenes with this number of foci, `threads` at a time.
///
/// # Errors
/// [`SolveError::TooLarge`].
pub fn of_methods(scene: &Scene, foci: usize, threads: usize) -> Result<Room, SolveError> {
    reserve(scene, foci, threads, &Tables::of(scene.solver.method))
}

/// Room for the problem and its [`crate::solver::Limits`].
///
/// # Errors
/// [`SolveError::TooLarge`].
pub fn of_limits(scene: &Scene, foci: usize) -> Result<Room, SolveError> {
    reserve(scene, foci, 1, &Tables { of_elements: 6, of_foci: 8 })
}

fn reserve(scene: &Scene, foci: usize, threads: usize, tables: &Tables) -> Result<Room, SolveError> {
    let elements = scene.elements();
    let numbers = threads * foci * (elements * tables.of_elements + foci * tables.of_foci);
    let bytes = numbers * size_of::<Complex64>();
    memory::reserve(bytes).ok_or(SolveError::TooLarge { elements, foci, mebibytes: bytes >> 20 })
}
