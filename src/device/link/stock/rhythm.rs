//! The timing of modulation from the computer: switching times, and pulses skipped for a new frame.

use web_time::{Duration, Instant};

/// Hz; a half period has to end.
const SLOWEST: f64 = 0.01;

/// Alternating sound and silence of equal duration, and the line's time for changes.
#[derive(Clone, Copy, Debug)]
pub struct Rhythm {
    pub half: Duration,
    /// Loading time of a frame into the hidden buffer; zero without one.
    pub load: Duration,
    /// Time for switching the sound: a swap, or a whole frame.
    pub show: Duration,
}

impl Rhythm {
    /// The rhythm of a frequency in Hz.
    pub fn new(frequency: f64, load: Duration, show: Duration) -> Self {
        Self { half: Duration::from_secs_f64(0.5 / frequency.max(SLOWEST)), load, show }
    }

    /// Pulses skipped while a frame is loaded, until sound begins in phase again.
    pub fn lost(&self) -> u32 {
        let halves = (self.load + self.show).as_secs_f64() / self.half.as_secs_f64();
        (0.5 * (halves - 1.0)).ceil().max(0.0) as u32
    }

    /// Whether the line can carry another frame, and the silence after it, before `dark_at`.
    pub fn streams(&self, now: Instant, dark_at: Instant) -> bool {
        now + 2 * (self.load + self.show) <= dark_at
    }

    /// Whether the line can carry silence for the hidden buffer before `dark_at`.
    pub fn fits(&self, now: Instant, dark_at: Instant) -> bool {
        now + self.load + self.show <= dark_at
    }

    /// The first pulse from `due` on that begins at `ready` or later.
    pub fn next_pulse(&self, due: Instant, ready: Instant) -> Instant {
        let missed = ready.saturating_duration_since(due).as_secs_f64() / (2.0 * self.half.as_secs_f64());
        due + (2 * self.half).mul_f64(missed.ceil())
    }

    /// Audible frames per second of a motion. Each frame has at least as many pulses as its loading skips.
    pub fn frames_per_second(&self, asked: f64) -> f64 {
        let pulses = 0.5 / self.half.as_secs_f64();
        let most = match self.lost() {
            0 if self.half >= 2 * (self.load + self.show) => 1.0 / (self.load + self.show).as_secs_f64(),
            0 => pulses,
            lost => pulses / f64::from(2 * lost),
        };
        asked.min(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLI: Duration = Duration::from_millis(1);

    /// One SonicSurface at `baud`.
    fn sonicsurface(frequency: f64, baud: f64) -> Rhythm {
        let bytes = |count: f64| Duration::from_secs_f64(count * 10.0 / baud);
        Rhythm::new(frequency, bytes(257.0), bytes(1.0))
    }

    #[test]
    fn sound_that_comes_late_leaves_out_whole_periods_and_the_next_is_in_time() {
        let (due, rhythm) = (Instant::now(), Rhythm::new(250.0, MILLI, MILLI));
        for (micros, periods) in [(0, 0), (1, 1), (3900, 1), (4100, 2), (4_001_000, 1001)] {
            let pulse = rhythm.next_pulse(due, due + Duration::from_micros(micros));
            let off = (pulse - due).as_secs_f64() - f64::from(periods) * 4e-3;
            assert!(off.abs() < 1e-6, "{micros} us: {off} s");
        }
        assert_eq!(rhythm.next_pulse(due + MILLI, due), due + MILLI);
    }

    #[test]
    fn a_frame_costs_the_pulses_that_its_bytes_take() {
        // 258 bytes take 11.2 ms at 230400 baud, which is 2.2 periods of 5 ms, and 1.8 ms at 1462857 baud.
        let lost = |frequency, baud| sonicsurface(frequency, baud).lost();
        assert_eq!((lost(200.0, 230_400.0), lost(100.0, 230_400.0), lost(44.0, 230_400.0)), (2, 1, 0));
        assert_eq!((lost(200.0, 1_462_857.0), lost(300.0, 1_462_857.0)), (0, 1));
        let heard = |frequency, asked| sonicsurface(frequency, 230_400.0).frames_per_second(asked);
        assert!((heard(200.0, 64.0) - 50.0).abs() < 1e-3 && heard(200.0, 20.0) == 20.0);
        assert!((heard(44.0, 64.0) - 44.0).abs() < 1e-3, "a frame for each pulse");
        assert!((heard(2.0, 1000.0) - 89.3).abs() < 0.1, "all that the line carries, while it sounds");
    }

    #[test]
    fn frames_are_streamed_while_there_is_time_for_darkness_after_them() {
        let (now, rhythm) = (Instant::now(), Rhythm::new(10.0, 9 * MILLI, MILLI));
        assert!(rhythm.streams(now, now + 20 * MILLI) && !rhythm.streams(now, now + 19 * MILLI));
        assert!(rhythm.fits(now, now + 10 * MILLI) && !rhythm.fits(now, now + 9 * MILLI));
        // A half period that is just long enough for one frame.
        let just = Rhythm::new(25.0, 9 * MILLI, MILLI);
        assert!(just.streams(now, now + just.half));
        assert!((just.frames_per_second(1000.0) - 100.0).abs() < 1e-9);
    }
}
