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
    /// Bytes that the system no longer counts and that have not left: those in the adapter.
    adapter: Option<f64>,
}

impl Pace {
    /// A line with this bit rate, at least 1.
    pub fn new(baud: f64, now: Instant) -> Self {
        Self { baud: baud.max(1.0), free_at: now, adapter: None }
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

    /// Nothing written has to leave any more.
    pub fn discarded(&mut self, now: Instant) {
        self.free_at = self.free_at.min(now);
    }

    /// Follows a line whose bit rate differs from the nominal one by up to some percent, by the number of bytes that
    /// the system holds. Returns the seconds by which the line is later than was thought.
    pub fn settle(&mut self, held: usize, now: Instant) -> f64 {
        /// The part of a difference that is followed at once: systems count in packets.
        const GAIN: f64 = 0.02;
        // Zero is also the answer of a system that does not count.
        if held == 0 {
            return 0.0;
        }
        let backlog = self.backlog(now).as_secs_f64() * self.baud / BITS;
        let beyond = backlog - held as f64;
        let later = -GAIN * (beyond - *self.adapter.get_or_insert(beyond)) * BITS / self.baud;
        let shift = Duration::from_secs_f64(later.abs());
        let shifted =
            if later < 0.0 { self.free_at.checked_sub(shift) } else { self.free_at.checked_add(shift) };
        self.free_at = shifted.unwrap_or(self.free_at);
        later
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
    fn a_line_of_another_rate_is_followed() {
        // An adapter takes 256 bytes and sends them at its own rate; the system holds the rest.
        for real in [228_000.0, 230_769.0, 234_000.0] {
            let mut now = Instant::now();
            let mut pace = Pace::new(230_400.0, now);
            let (mut waiting, mut least) = (0.0_f64, f64::MAX);
            for turn in 0..20_000 {
                let backlog = pace.backlog(now).as_secs_f64();
                let room = ((0.05 - backlog) * 23_040.0).max(0.0).floor();
                pace.sent(room as usize, now);
                waiting += room;
                now += Duration::from_millis(5);
                waiting = (waiting - 5e-3 * real / BITS).max(0.0);
                pace.settle((waiting - 256.0).max(0.0) as usize, now);
                least = if turn > 100 { least.min(waiting) } else { least };
            }
            assert!((500.0..1500.0).contains(&least) && waiting < 1500.0, "{real}: {least}, {waiting}");
        }
    }

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
