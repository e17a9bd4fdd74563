//! Invalid, tiny and huge numbers, and empty or mismatched lists, in every layer.
//!
//! The result is an error, a number in range, or the documented panic. Values that a checked scene cannot hold are
//! refused by its check; mathematics (`acoustics`, `surface`) makes NaN only from NaN.

mod boards;
mod fields;
#[cfg(feature = "window")]
mod lines;
mod pictures;
mod scenes;
mod sums;

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Not-a-numbers, infinities and extreme values.
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

/// Zero and excessive sizes.
pub const SIZES: [usize; 3] = [0, u32::MAX as usize, usize::MAX];

/// Whether a call panics as documented.
pub fn panics<T>(call: impl FnOnce() -> T) -> bool {
    catch_unwind(AssertUnwindSafe(call)).is_err()
}
