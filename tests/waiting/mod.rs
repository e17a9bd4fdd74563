//! Waiting for a condition.

use std::time::{Duration, Instant};

/// Upper limit of every wait, for slow machines.
pub const PATIENCE: Duration = Duration::from_secs(60);

pub fn eventually(what: &str, mut condition: impl FnMut() -> bool) {
    let until = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < until, "timed out waiting for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
