//! Statistics of a link: throughput, delay and jitter.

use std::collections::VecDeque;

use web_time::{Duration, Instant};

/// Averaging time of rates.
const SPAN: Duration = Duration::from_secs(1);

/// Rate of events, and of their amounts.
#[derive(Clone, Debug, Default)]
pub struct Rate {
    happened: VecDeque<(Instant, u64)>,
}

impl Rate {
    pub fn note(&mut self, amount: u64, now: Instant) {
        self.happened.push_back((now, amount));
        self.forget(now);
    }

    fn forget(&mut self, now: Instant) {
        while self.happened.front().is_some_and(|(at, _)| now.saturating_duration_since(*at) > SPAN) {
            self.happened.pop_front();
        }
    }

    /// Amount per second in the last second.
    pub fn per_second(&mut self, now: Instant) -> f64 {
        self.forget(now);
        self.happened.iter().map(|(_, amount)| amount).sum::<u64>() as f64 / SPAN.as_secs_f64()
    }
}

/// The last of many durations.
#[derive(Clone, Debug, Default)]
pub struct Durations {
    kept: VecDeque<Duration>,
}

/// Typical and extreme values of durations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    pub mean: Duration,
    pub median: Duration,
    /// 95 of 100 are no further from the median.
    pub jitter: Duration,
    pub largest: Duration,
}

impl Durations {
    const KEPT: usize = 1024;

    pub fn note(&mut self, duration: Duration) {
        if self.kept.len() == Self::KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(duration);
    }

    pub fn clear(&mut self) {
        self.kept.clear();
    }

    /// `None` before the first.
    pub fn spread(&self) -> Option<Spread> {
        let mut sorted: Vec<_> = self.kept.iter().copied().collect();
        sorted.sort_unstable();
        let median = *sorted.get(sorted.len() / 2)?;
        let mean = sorted.iter().sum::<Duration>() / sorted.len() as u32;
        let mut off: Vec<_> = sorted.iter().map(|duration| duration.abs_diff(median)).collect();
        off.sort_unstable();
        Some(Spread { mean, median, jitter: *off.get(off.len() * 95 / 100)?, largest: *sorted.last()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cleared_durations_have_no_spread() {
        let mut durations = Durations::default();
        (1..=2000).for_each(|n| durations.note(Duration::from_micros(n)));
        let spread = durations.spread().unwrap();
        // Of the latest only.
        assert_eq!(
            (spread.median, spread.largest),
            (Duration::from_micros(1489), Duration::from_micros(2000))
        );
        durations.clear();
        assert!(durations.spread().is_none());
    }

    #[test]
    fn rates_are_of_the_last_second() {
        let start = Instant::now();
        let mut rate = Rate::default();
        (0..200).for_each(|n| rate.note(10, start + Duration::from_millis(10 * n)));
        assert_eq!(rate.happened.len(), 101, "older ones are not kept");
        let rate_then = rate.per_second(start + Duration::from_millis(1990));
        assert!((rate_then - 1010.0).abs() < 11.0, "{rate_then}");
        assert_eq!(rate.per_second(start + Duration::from_secs(9)), 0.0);
        rate.note(7, start + Duration::from_secs(20));
        assert_eq!(rate.per_second(start + Duration::from_millis(20_950)), 7.0);
        assert_eq!(rate.per_second(start + Duration::from_millis(21_050)), 0.0);
    }

    #[test]
    fn jitter_leaves_out_what_is_rare() {
        let mut durations = Durations::default();
        assert_eq!(durations.spread(), None);
        (0..98).for_each(|n| durations.note(Duration::from_micros(1000 + n % 3)));
        durations.note(Duration::from_secs(1));
        let spread = durations.spread().unwrap();
        assert_eq!(spread.median, Duration::from_micros(1001));
        assert_eq!(spread.jitter, Duration::from_micros(1));
        assert_eq!(spread.largest, Duration::from_secs(1));
    }

    #[test]
    fn jitter_is_the_deviation_of_95_in_100() {
        let mut durations = Durations::default();
        // In any order.
        (1..=200).for_each(|n| durations.note(Duration::from_micros(77 * n % 201)));
        let spread = durations.spread().unwrap();
        assert_eq!((spread.median, spread.jitter), (Duration::from_micros(101), Duration::from_micros(95)));
    }
}
