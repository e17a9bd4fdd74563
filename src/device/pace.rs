//! Pacing of a serial line: ports accept bytes sooner than they send them, so the sender keeps count.

use web_time::{Duration, Instant};

/// Limit of durations.
const LONGEST: Duration = Duration::from_secs(86_400);
/// Bits on the line per byte: a start bit, eight of data, a stop bit.
pub const BITS: f64 = 10.0;

#[derive(Clone, Copy, Debug)]
pub struct Pace {
    baud: f64,
    free_at: Instant,
}

impl Pace {
    /// A line with this bit rate, at least 1.
    pub fn new(baud: f64, now: Instant) -> Self {
        Self { baud: baud.max(1.0), free_at: now }
    }

    /// Time for `bytes`, at most a day.
    pub fn time_of(&self, bytes: usize) -> Duration {
        Duration::try_from_secs_f64(bytes as f64 * BITS / self.baud).unwrap_or(LONGEST).min(LONGEST)
    }

    /// Records written `bytes`, and returns the time at which the last of them leaves.
    pub fn sent(&mut self, bytes: usize, now: Instant) -> Instant {
        self.free_at = self.free_at.max(now) + self.time_of(bytes);
        self.free_at
    }

    /// Time for which the line is busy with bytes written before `now`.
    pub fn backlog(&self, now: Instant) -> Duration {
        self.free_at.saturating_duration_since(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_queue_up_and_drain_at_the_bit_rate() {
        let start = Instant::now();
        let mut pace = Pace::new(1e5, start);
        assert_eq!(pace.sent(100, start), start + Duration::from_millis(10));
        pace.sent(50, start + Duration::from_millis(5));
        assert_eq!(pace.backlog(start + Duration::from_millis(5)), Duration::from_millis(10));
        assert_eq!(pace.backlog(start + Duration::from_secs(1)), Duration::ZERO);
        let late = start + Duration::from_secs(2);
        assert_eq!(pace.sent(1, late), late + Duration::from_micros(100), "idle time is not made up for");
    }
}
