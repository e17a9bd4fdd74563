//! Sending to boards that do not answer: frames as fast as the line takes them, and modulation by exchanging buffers in time.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::device::health::Found;
use crate::device::levels::Levels;
use crate::device::link::{Content, Event, LEAD, LinkError, Settings, Shared, Sounding, Wanted};
use crate::device::port::Port;
use crate::device::profile::Profile;
use crate::device::stock::{self, Modulated};

/// A frame that does not change is sent again after this, in case a byte was damaged on its way.
const REFRESH: Duration = Duration::from_millis(250);
/// So long before a swap the thread stops sleeping and looks at the clock.
const WATCHFUL: Duration = Duration::from_micros(300);
/// Hz; a half period has to end.
const SLOWEST: f64 = 0.01;

pub fn run(settings: &Settings, shared: &Shared) -> Result<(), LinkError> {
    let port = Port::open(&settings.port, settings.baud())?;
    let silence = stock::silence(settings.profile);
    let mut session = Session {
        board: Sounding { port, silence: silence.clone(), shared },
        shared,
        profile: settings.profile,
        sent: None,
        sent_at: Instant::now(),
        ready_at: Instant::now(),
        told: None,
    };
    session.write(&silence)?;
    std::thread::sleep(session.board.port.backlog());
    session.ready_at = Instant::now();
    let found = Found { baud: settings.baud(), carrier: None, slots: 0, phase_bits: None };
    shared.tell(Event::Ready(found));
    loop {
        let wanted = shared.wanted();
        if wanted.closing {
            return Ok(());
        }
        session.follow(&wanted)?;
    }
}

struct Session<'a> {
    board: Sounding<'a>,
    shared: &'a Shared,
    profile: Profile,
    /// Generation and frame that were sent last.
    sent: Option<(u64, usize)>,
    sent_at: Instant,
    ready_at: Instant,
    /// The modulation that the user and the board were told of.
    told: Option<Modulated>,
}

impl Session<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<Instant, LinkError> {
        let gone = self.board.port.write(bytes)?;
        self.shared.note_bytes(bytes.len());
        Ok(gone)
    }

    fn follow(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        let Some(content) = &wanted.content else { return self.fall_silent(wanted) };
        let modulated = stock::modulated(self.profile, &wanted.modulation);
        let moves = matches!(**content, Content::Motion { .. });
        self.tell_modulation(modulated, moves, wanted)?;
        match (modulated, &**content) {
            (Modulated::BySwaps(frequency), Content::Still(levels)) => {
                self.modulate(levels, frequency, wanted)
            }
            _ => self.steady(content, wanted),
        }
    }

    fn fall_silent(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        let key = (wanted.generation, 0);
        if self.sent != Some(key) {
            self.write(&stock::silence(self.profile))?;
            self.sent = Some(key);
        }
        self.shared.wait(wanted.generation, REFRESH);
        self.look()
    }

    fn tell_modulation(
        &mut self,
        modulated: Modulated,
        moves: bool,
        wanted: &Wanted,
    ) -> Result<(), LinkError> {
        if self.told.replace(modulated) == Some(modulated) {
            return Ok(());
        }
        let name = self.profile.name();
        match modulated {
            Modulated::ByBoard(byte, frequency) => {
                self.write(&[byte])?;
                self.shared.notice(&format!(
                    "{name} modulates by itself, at {frequency:.1} Hz; {:.1} Hz were asked for",
                    wanted.modulation.frequency
                ));
            }
            Modulated::Never => {
                self.shared
                    .notice(&format!("{name} cannot be modulated: the sound is steady, and hardly felt"));
            }
            Modulated::BySwaps(_) if moves => {
                self.shared
                    .notice(&format!("{name} cannot be modulated while it moves: the sound is steady"));
            }
            Modulated::BySwaps(frequency) => self.shared.notice(&format!(
                "{name} has no modulation: it is switched on and off {frequency} times a second from here"
            )),
            Modulated::Steady => {}
        }
        Ok(())
    }

    /// One look at what is due, and then a wait until something else may be.
    fn steady(&mut self, content: &Arc<Content>, wanted: &Wanted) -> Result<(), LinkError> {
        let backlog = self.board.port.backlog();
        if backlog > LEAD {
            // What is newest then is sent.
            std::thread::sleep(backlog - LEAD);
            return Ok(());
        }
        let elapsed = wanted.since.elapsed();
        let (frame, levels) = content.at(elapsed);
        let key = (wanted.generation, frame);
        let due = self.sent_at + REFRESH;
        if self.sent != Some(key) || Instant::now() >= due {
            let fresh = self.sent.is_none_or(|(generation, _)| generation != wanted.generation);
            let gone = self.write(&stock::frame(levels))?;
            self.shared.note_frame();
            self.shared.note(|figures| figures.health.in_place = true);
            if fresh && wanted.since > self.ready_at {
                let latency = gone.saturating_duration_since(wanted.since);
                self.shared.note(|figures| figures.latency.note(latency));
            }
            (self.sent, self.sent_at) = (Some(key), Instant::now());
            return Ok(());
        }
        let refresh = due.saturating_duration_since(Instant::now());
        self.shared.wait(wanted.generation, content.next_in(elapsed).min(refresh));
        self.look()
    }

    /// Whether the port is still there. What a board says is an echo at most.
    fn look(&mut self) -> Result<(), LinkError> {
        self.board.port.read(Duration::ZERO)?;
        Ok(())
    }

    /// Exchanges a frame and darkness until something else is wanted. It is left while dark, so that loading what comes next
    /// lengthens a pause and nothing else.
    fn modulate(&mut self, levels: &Levels, frequency: f64, wanted: &Wanted) -> Result<(), LinkError> {
        let Some(swap) = stock::swap(self.profile) else { return Ok(()) };
        let half = Duration::from_secs_f64(0.5 / frequency.max(SLOWEST));
        self.write(&stock::frame(levels))?;
        let loaded = self.write(&stock::load(&Levels::off(self.profile)))?;
        self.shared.note_frame();
        self.shared.note(|figures| {
            figures.swaps.clear();
            figures.health.in_place = true;
        });
        self.sent = Some((wanted.generation, 0));
        let mut due = loaded + half;
        let mut swapped: Option<Instant> = None;
        let mut lit = true;
        loop {
            // Waits less exactly than the clock is read, and no longer than something else is wanted.
            let rest = due.saturating_duration_since(Instant::now());
            self.shared.wait(wanted.generation, rest.saturating_sub(WATCHFUL));
            let now = self.shared.wanted();
            if now.generation != wanted.generation || now.closing {
                return if lit { self.write(&[swap]).map(drop) } else { Ok(()) };
            }
            while Instant::now() < due {
                std::hint::spin_loop();
            }
            self.write(&[swap])?;
            self.look()?;
            let now = Instant::now();
            lit = !lit;
            if let Some(before) = swapped.replace(now) {
                self.shared.note(|figures| figures.swaps.note(now - before));
            }
            due = after(due, half, now);
        }
    }
}

/// When the swap after the one at `due` is to come, if it is `now`. Where that is too late for some, whole periods are left out,
/// and what follows is in time again.
fn after(due: Instant, half: Duration, now: Instant) -> Instant {
    let due = due + half;
    let missed = now.saturating_duration_since(due).as_secs_f64() / (2.0 * half.as_secs_f64());
    due + (2 * half).mul_f64(missed.ceil())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swap_that_comes_late_leaves_out_whole_periods_and_the_next_is_in_time() {
        let (due, half) = (Instant::now(), Duration::from_millis(2));
        let late = |millis: f64| {
            (after(due, half, due + Duration::from_secs_f64(millis / 1000.0)) - due).as_secs_f64()
        };
        // Light stays light and dark dark: an odd number of half periods after the last, and the first that is not over.
        for (millis, halves) in
            [(0.0, 1), (1.9, 1), (2.1, 3), (5.9, 3), (6.1, 5), (9.9, 5), (10.1, 7), (4001.0, 2001)]
        {
            let expected = f64::from(halves) * half.as_secs_f64();
            assert!((late(millis) - expected).abs() < 1e-6, "{millis} ms: {} s", late(millis));
        }
    }
}
