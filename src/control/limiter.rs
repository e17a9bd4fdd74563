//! A rate limiter: a number of events per second, with a small burst.

use std::time::Instant;

#[derive(Clone, Copy, Debug)]
pub struct Limiter {
    per_second: f64,
    most: f64,
    left: f64,
    at: Instant,
}

impl Limiter {
    /// The burst is half a second's worth, at least one.
    pub fn new(per_second: f64) -> Self {
        let most = (per_second / 2.0).max(1.0);
        Self { per_second, most, left: most, at: Instant::now() }
    }

    /// Whether an event is allowed now; if so, it is counted.
    pub fn takes(&mut self, now: Instant) -> bool {
        let passed = now.saturating_duration_since(self.at).as_secs_f64();
        (self.left, self.at) = ((self.left + passed * self.per_second).min(self.most), now);
        let may = self.left >= 1.0;
        if may {
            self.left -= 1.0;
        }
        may
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_flood_is_let_through_at_the_rate_and_no_faster() {
        let mut limiter = Limiter::new(50.0);
        let start = Instant::now();
        let mut full = Limiter::new(50.0);
        assert_eq!((0..100).filter(|_| full.takes(start)).count(), 25);
        let through = (0..20_000).filter(|&i| limiter.takes(start + Duration::from_micros(100 * i)));
        let through = through.count();
        assert!((120..=126).contains(&through), "{through} in 2 s");
    }
}
