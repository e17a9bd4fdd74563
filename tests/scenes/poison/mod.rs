//! Numbers that are none, next to nothing or beyond everything, and lists that are empty or do not match, into every layer.
//!
//! What takes them answers with an error or a number in its range, or panics as its documentation says. What checked scenes cannot
//! hold, their check refuses; mathematics (`acoustics`, `surface`) makes NaN of NaN, and of nothing else.

mod boards;
mod fields;
#[cfg(feature = "window")]
mod lines;
mod pictures;
mod scenes;
mod sums;

use std::panic::{AssertUnwindSafe, catch_unwind};

/// What is no number that anybody means.
pub const POISON: [f64; 12] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    -0.0,
    5e-324,
    -1e-310,
    1e-300,
    -1e-300,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
];
/// The finite ones among them.
pub fn numbers() -> impl Iterator<Item = f64> {
    POISON.into_iter().filter(|number| number.is_finite())
}

/// Sizes that nobody means.
pub const SIZES: [usize; 3] = [0, u32::MAX as usize, usize::MAX];

/// Whether a call panics, as its documentation says it does.
pub fn panics<T>(call: impl FnOnce() -> T) -> bool {
    catch_unwind(AssertUnwindSafe(call)).is_err()
}
