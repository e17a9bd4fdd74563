//! The echo of a board that sends bytes back: whether it is there, and whether it was reset in between.
//!
//! The echo of a byte follows it on the line. A board in its boot loader sends nothing back. One that was reset has
//! missed bytes, whose echoes never come: from then on, every echo is taken for that of an earlier byte and seems late.

use std::collections::VecDeque;

use web_time::{Duration, Instant};

use crate::device::link::shared::{LinkError, Settings};
use crate::device::profile::Profile;
use crate::device::stock;

/// Time for the echo of the first bytes.
pub const ANSWERS: Duration = Duration::from_millis(500);
/// Time for more bytes than that.
const MORE: Duration = Duration::from_millis(30);
/// Lateness of a board that is gone.
const GONE: Duration = Duration::from_secs(1);
/// Lateness that a computer's buffers do not have all the time.
const LATE: Duration = Duration::from_millis(40);

/// The echoes to come.
#[derive(Debug)]
pub struct Echo {
    of: fn(u8) -> Option<u8>,
    /// When bytes leave, and the number of their echoes.
    due: VecDeque<(Instant, usize)>,
    /// The least lateness since then.
    least: Duration,
    since: Instant,
}

impl Echo {
    /// The echo of a board that has one.
    pub fn of(profile: Profile, now: Instant) -> Option<Self> {
        stock::echo(profile).map(|of| Self { of, due: VecDeque::new(), least: Duration::MAX, since: now })
    }

    /// Bytes were written, the last of which leaves at `gone`.
    pub fn wrote(&mut self, bytes: &[u8], gone: Instant) {
        let echoes = bytes.iter().filter_map(|&byte| (self.of)(byte)).count();
        if echoes > 0 {
            self.due.push_back((gone, echoes));
        }
    }

    fn take(&mut self, mut heard: usize) {
        while let Some((_, echoes)) = self.due.front_mut().filter(|_| heard > 0) {
            let taken = heard.min(*echoes);
            (heard, *echoes) = (heard - taken, *echoes - taken);
            if *echoes == 0 {
                self.due.pop_front();
            }
        }
    }

    /// Whether so many bytes are all echoes of those written, and no more come.
    pub fn is_complete(&self, heard: usize) -> bool {
        let due: usize = self.due.iter().map(|(_, echoes)| echoes).sum();
        let quiet = self.due.back().map(|(gone, _)| gone.elapsed() > MORE);
        heard >= due && quiet.unwrap_or(true)
    }

    /// Judges the bytes heard after the first that were written. Some may be lost or added on a bad line.
    ///
    /// # Errors
    /// Another board, or none.
    pub fn greet(&mut self, heard: usize, written: usize, settings: &Settings) -> Result<(), LinkError> {
        let due: usize = self.due.iter().map(|(_, echoes)| echoes).sum();
        self.due.clear();
        let (port, board) = (settings.port.display().to_string(), settings.profile.name());
        match heard {
            heard if heard < due.div_ceil(2) => Err(LinkError::NoEcho { port, board }),
            heard if heard > (due + written) / 2 => Err(LinkError::OtherEcho { port, board }),
            _ => Ok(()),
        }
    }

    /// Bytes came back by `now`.
    ///
    /// # Errors
    /// A board that is gone or was reset.
    pub fn heard(&mut self, heard: usize, now: Instant, port: &str) -> Result<(), LinkError> {
        self.take(heard);
        let late = self.due.front().map_or(Duration::ZERO, |(gone, _)| now.saturating_duration_since(*gone));
        self.least = self.least.min(late);
        if late > GONE {
            return Err(LinkError::Silent(port.to_owned()));
        }
        if now.saturating_duration_since(self.since) < GONE {
            return Ok(());
        }
        self.since = now;
        match std::mem::replace(&mut self.least, Duration::MAX) {
            least if least > LATE => Err(LinkError::Restarted),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLI: Duration = Duration::from_millis(1);

    /// The outcome of 200 swaps per second, whose echo comes 5 ms later, but not between these milliseconds.
    fn played(missed: std::ops::Range<u32>) -> Option<(u32, LinkError)> {
        let start = Instant::now();
        let mut echo = Echo::of(Profile::UltrainoMega64, start).unwrap();
        (0..10_000).find_map(|at| {
            let now = start + at * MILLI;
            if at.is_multiple_of(5) {
                echo.wrote(&[0], now);
            }
            let heard = usize::from(at % 5 == 4 && !missed.contains(&at));
            echo.heard(heard, now, "port").err().map(|error| (at, error))
        })
    }

    #[test]
    fn missing_echoes_tell_of_a_reset_and_of_a_loss() {
        assert!(played(0..0).is_none());
        assert!(matches!(played(2000..2100), Some((2100..4200, LinkError::Restarted))));
        assert!(matches!(played(2000..10_000), Some((3000..3020, LinkError::Silent(_)))));
        // A byte that the line has lost.
        assert!(played(2000..2006).is_none());
    }
}
