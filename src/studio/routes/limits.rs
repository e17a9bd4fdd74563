//! Limits of the places of a file with a path.

use crate::scene::motion::Trace;

/// Places of a file, at most.
pub(super) const MOST_PLACES: usize = 1_000_000;
/// m: places farther away are slips of the unit.
pub(super) const FARTHEST: f64 = 10.0;

/// The traces of a file, with remarks on what was left aside in it.
pub type Traced = (Vec<Trace>, Vec<String>);
