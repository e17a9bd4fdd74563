//! How near every invariant came to its limit, and how often what was drawn.

use std::collections::BTreeMap;
use std::sync::Mutex;

static NEAREST: Mutex<BTreeMap<String, (f64, f64)>> = Mutex::new(BTreeMap::new());
static COUNTS: Mutex<BTreeMap<String, usize>> = Mutex::new(BTreeMap::new());

/// Asserts that something is off by at most so much, and keeps the largest part of that which was needed.
#[track_caller]
pub fn within(what: &str, off: f64, most: f64) {
    if let Ok(mut nearest) = NEAREST.lock() {
        let kept = nearest.entry(what.to_owned()).or_insert((0.0, 0.0));
        if off > 0.0 && off / most > kept.0 {
            *kept = (off / most, most);
        }
    }
    // A NaN is not within anything.
    assert!(off <= most, "{what}: off by {off:.3e}, and {most:.3e} is allowed");
}

pub fn count(what: &str) {
    if let Ok(mut counts) = COUNTS.lock() {
        *counts.entry(what.to_owned()).or_insert(0) += 1;
    }
}

pub fn counted(what: &str) -> usize {
    COUNTS.lock().map_or(0, |counts| counts.get(what).copied().unwrap_or(0))
}

/// Prints both, for who runs the tests with `--nocapture`.
pub fn print() {
    if let (Ok(nearest), Ok(counts)) = (NEAREST.lock(), COUNTS.lock()) {
        for (what, (part, most)) in nearest.iter() {
            println!("{what}: at most {part:.1e} of what is allowed, {most:.1e} there");
        }
        for (what, count) in counts.iter() {
            println!("{count:6} {what}");
        }
    }
}
