//! The link to boards without acknowledgements: frames as fast as the line allows, and modulation by timed buffer
//! swaps.

mod rhythm;

use web_time::{Duration, Instant};

use crate::device::health::{Found, FrameRates};
use crate::device::levels::Levels;
use crate::device::link::stock::rhythm::Rhythm;
use crate::device::link::{Content, Event, LEAD, LinkError, Settings, Shared, Sounding, Wanted};
use crate::device::port::Port;
use crate::device::profile::Profile;
use crate::device::stock::{self, Modulated};
use crate::device::task;

/// Repetition interval of an unchanged frame, in case a byte was damaged.
const REFRESH: Duration = Duration::from_millis(250);

pub async fn run(settings: &Settings, shared: &Shared) -> Result<(), LinkError> {
    let port = Port::open(&settings.port, settings.baud()).await?;
    let silence = stock::silence(settings.profile);
    let mut session = Session {
        board: Sounding::new(port, silence.clone(), shared),
        shared,
        profile: settings.profile,
        sent: None,
        sent_at: Instant::now(),
        ready_at: Instant::now(),
        told: None,
        told_rates: None,
    };
    session.write(&silence).await?;
    task::sleep(session.board.port.backlog()).await;
    session.ready_at = Instant::now();
    let found = Found { baud: settings.baud(), carrier: None, slots: 0, phase_bits: None };
    shared.tell(Event::Ready(found));
    if let Some(remark) = settings.profile.remark() {
        shared.notice(&format!("{}: {remark}", settings.profile.name()));
    }
    loop {
        let wanted = shared.wanted();
        if wanted.closing {
            return Ok(());
        }
        session.follow(&wanted).await?;
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
    /// The modulation sent to the board, and the notice given to the user.
    told: Option<(Modulated, Option<String>)>,
    told_rates: Option<FrameRates>,
}

impl Session<'_> {
    async fn write(&mut self, bytes: &[u8]) -> Result<Instant, LinkError> {
        let gone = self.board.port.write(bytes).await?;
        self.shared.note_bytes(bytes.len());
        Ok(gone)
    }

    async fn follow(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        let Some(content) = &wanted.content else { return self.fall_silent(wanted).await };
        let modulated = stock::modulated(self.profile, &wanted.modulation, self.board.port.baud());
        self.tell_modulation(modulated, content, wanted).await?;
        let rates = self.rates(modulated, content);
        if std::mem::replace(&mut self.told_rates, rates) != rates
            && let (Some(rates), false) = (rates, matches!(modulated, Modulated::FromHere(_)))
            && rates.differ()
        {
            let baud = self.board.port.baud();
            self.shared.notice(&format!("{rates}: the line carries no more at {baud} baud"));
        }
        self.shared.note(|figures| figures.health.rates = rates);
        match modulated {
            Modulated::FromHere(frequency) => self.alternate(content, frequency, wanted).await,
            Modulated::Steady | Modulated::ByBoard(..) | Modulated::Never(_) | Modulated::OneFrequency => {
                self.steady(content, wanted).await
            }
        }
    }

    async fn fall_silent(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        let key = (wanted.generation, 0);
        if self.sent != Some(key) {
            self.write(&stock::silence(self.profile)).await?;
            self.shared.note(|figures| figures.health.rates = None);
            self.sent = Some(key);
        }
        self.shared.wait(wanted.generation, REFRESH).await;
        self.look().await
    }

    async fn tell_modulation(
        &mut self,
        modulated: Modulated,
        content: &Content,
        wanted: &Wanted,
    ) -> Result<(), LinkError> {
        let text = self.in_words(modulated, content, wanted.modulation.frequency);
        let told = Some((modulated, text.clone()));
        if self.told == told {
            return Ok(());
        }
        self.told = told;
        if let Modulated::ByBoard(byte, _) = modulated {
            self.write(&[byte]).await?;
        }
        text.iter().for_each(|text| self.shared.notice(text));
        Ok(())
    }

    /// The effect of a modulation of this frequency, as text.
    fn in_words(&self, modulated: Modulated, content: &Content, asked: f64) -> Option<String> {
        let name = self.profile.name();
        match modulated {
            Modulated::Steady => None,
            Modulated::OneFrequency => Some(format!(
                "{name} is switched on and off at one frequency only: the sound is steady, and hardly felt"
            )),
            Modulated::ByBoard(_, frequency) => Some(format!(
                "{name} modulates by itself, at {frequency:.1} Hz; {asked:.1} Hz were asked for"
            )),
            Modulated::Never(fastest) => Some(format!(
                "{name} cannot be switched on and off {asked} times a second, but {fastest:.0} times at most at \
                 {} baud: the sound is steady, and hardly felt",
                self.board.port.baud()
            )),
            Modulated::FromHere(frequency) => Some(format!(
                "{name} has no modulation: it is switched on and off {frequency} times a second from here{}{}",
                if cfg!(target_arch = "wasm32") { ", as evenly as the timers of this page" } else { "" },
                self.motion_in_words(frequency, content)
            )),
        }
    }

    /// The effect of a modulation on a motion, as text.
    fn motion_in_words(&self, frequency: f64, content: &Content) -> String {
        let Content::Motion { rate, .. } = content else { return String::new() };
        let rhythm = self.rhythm(frequency);
        let played = rhythm.frames_per_second(*rate);
        let costs = 1e3 * (rhythm.load + rhythm.show).as_secs_f64();
        match rhythm.lost() {
            0 if played >= *rate => String::new(),
            0 => format!(
                "; {played:.0} of {rate:.0} frames/s are played: each takes {costs:.1} ms on the line"
            ),
            lost => format!(
                "; {played:.0} of {rate:.0} frames/s are played, and each frame ({costs:.1} ms on the line) replaces {lost} of \
                 {} pulses",
                (10.0 * frequency / played).round() / 10.0
            ),
        }
    }

    /// Of a motion.
    fn rates(&self, modulated: Modulated, content: &Content) -> Option<FrameRates> {
        let Content::Motion { rate, .. } = content else { return None };
        let line = self.profile.frames_per_second(self.board.port.baud());
        let played = match modulated {
            Modulated::FromHere(frequency) => self.rhythm(frequency).frames_per_second(*rate),
            Modulated::Steady | Modulated::ByBoard(..) | Modulated::Never(_) | Modulated::OneFrequency => {
                rate.min(line)
            }
        };
        Some(FrameRates { asked: *rate, played })
    }

    fn rhythm(&self, frequency: f64) -> Rhythm {
        let off = Levels::off(self.profile);
        let time_of = |bytes: Vec<u8>| self.board.port.time_of(bytes.len());
        match stock::swap(self.profile) {
            Some(swap) => Rhythm::new(frequency, time_of(stock::load(&off)), time_of(vec![swap])),
            None => Rhythm::new(frequency, Duration::ZERO, time_of(stock::frame(&off))),
        }
    }

    /// Sends due content, then waits for the next.
    async fn steady(&mut self, content: &Content, wanted: &Wanted) -> Result<(), LinkError> {
        let backlog = self.board.port.backlog();
        if backlog > LEAD {
            // The newest content is sent afterwards.
            task::sleep(backlog - LEAD).await;
            return Ok(());
        }
        let elapsed = wanted.since.elapsed();
        let (frame, levels) = content.at(elapsed);
        let key = (wanted.generation, frame);
        let due = self.sent_at + REFRESH;
        if self.sent != Some(key) || Instant::now() >= due {
            let fresh = self.sent.is_none_or(|(generation, _)| generation != wanted.generation);
            let gone = self.write(&stock::frame(levels)).await?;
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
        self.shared.wait(wanted.generation, content.next_in(elapsed).min(refresh)).await;
        self.look().await
    }

    /// Checks the port. A board's bytes are at most an echo.
    async fn look(&mut self) -> Result<(), LinkError> {
        self.board.port.read(Duration::ZERO).await?;
        Ok(())
    }

    /// Alternates sound and silence until another wish. Frames are loaded during silence, where it also ends, so that
    /// the next content only lengthens a pause.
    async fn alternate(
        &mut self,
        content: &Content,
        frequency: f64,
        wanted: &Wanted,
    ) -> Result<(), LinkError> {
        let rhythm = self.rhythm(frequency);
        let dark = Levels::off(self.profile);
        let dark_from = self.write(&stock::frame(&dark)).await?;
        self.sent = Some((wanted.generation, 0));
        self.shared.note(|figures| figures.swaps.clear());
        let mut pulses = Pulses { rhythm, hidden: None, since_load: 0, loaded_at: dark_from, shown: None };
        let mut due = dark_from + rhythm.half;
        loop {
            let (number, levels) = content.at(due.saturating_duration_since(wanted.since));
            if pulses.needs(number) {
                let ready = self.load(levels).await?;
                self.shared.note_frame();
                pulses.loaded(number);
                due = rhythm.next_pulse(due, ready + rhythm.show);
            }
            if !self.wait_until(due - rhythm.show, wanted).await {
                return Ok(());
            }
            self.show(levels, &mut pulses).await?;
            self.shared.note(|figures| figures.health.in_place = true);
            let dark_at = due + rhythm.half;
            let dark_is_hidden = self.stream(content, dark_at, &mut pulses, wanted).await?;
            if !dark_is_hidden {
                self.load(&dark).await?;
            }
            let goes_on = self.wait_until(dark_at - rhythm.show, wanted).await;
            self.show(&dark, &mut pulses).await?;
            if !goes_on {
                return Ok(());
            }
            due = rhythm.next_pulse(due + 2 * rhythm.half, Instant::now());
        }
    }

    /// Plays due frames during sound, as time allows. Returns whether the hidden buffer is still silent.
    async fn stream(
        &mut self,
        content: &Content,
        dark_at: Instant,
        pulses: &mut Pulses,
        wanted: &Wanted,
    ) -> Result<bool, LinkError> {
        let mut dark_is_hidden = true;
        loop {
            let now = Instant::now() + self.board.port.backlog();
            let elapsed = now.saturating_duration_since(wanted.since);
            let (number, levels) = content.at(elapsed);
            if !pulses.rhythm.streams(now, dark_at) {
                return Ok(dark_is_hidden);
            }
            if pulses.hidden == Some(number) {
                let next = now.checked_add(content.next_in(elapsed)).unwrap_or(dark_at);
                if !pulses.rhythm.streams(next, dark_at) || !self.wait_until(next, wanted).await {
                    return Ok(dark_is_hidden);
                }
                continue;
            }
            self.write(&stock::frame(levels)).await?;
            self.shared.note_frame();
            pulses.loaded(number);
            dark_is_hidden = stock::swap(self.profile).is_none();
        }
    }

    /// Loads a frame into the hidden buffer, if there is one, and returns its completion time.
    async fn load(&mut self, levels: &Levels) -> Result<Instant, LinkError> {
        match stock::swap(self.profile) {
            Some(_) => self.write(&stock::load(levels)).await,
            None => Ok(Instant::now() + self.board.port.backlog()),
        }
    }

    /// Shows the hidden buffer, which holds these levels.
    async fn show(&mut self, levels: &Levels, pulses: &mut Pulses) -> Result<(), LinkError> {
        match stock::swap(self.profile) {
            Some(swap) => self.write(&[swap]).await?,
            None => self.write(&stock::frame(levels)).await?,
        };
        self.look().await?;
        let now = Instant::now();
        if let Some(lasted) = pulses.shown.replace(now).map(|before| now - before)
            && lasted < 2 * pulses.rhythm.half
        {
            self.shared.note(|figures| figures.swaps.note(lasted));
        }
        Ok(())
    }

    /// Returns whether the wish still holds then: waits are less exact than the clock.
    async fn wait_until(&self, due: Instant, wanted: &Wanted) -> bool {
        let rest = due.saturating_duration_since(Instant::now());
        self.shared.wait(wanted.generation, rest.saturating_sub(task::WATCHFUL)).await;
        let now = self.shared.wanted();
        let goes_on = now.generation == wanted.generation && !now.closing;
        if goes_on {
            task::watch(due);
        }
        goes_on
    }
}

/// The loaded frames of a motion under modulation.
struct Pulses {
    rhythm: Rhythm,
    /// Number of the current or next frame.
    hidden: Option<usize>,
    since_load: u32,
    loaded_at: Instant,
    /// Start of the current sound or silence.
    shown: Option<Instant>,
}

impl Pulses {
    /// Whether to load a frame: a new one, after as many pulses as its loading skips; or the same again if that skips
    /// no pulse.
    fn needs(&mut self, number: usize) -> bool {
        let lost = self.rhythm.lost();
        let again = lost == 0 && self.loaded_at.elapsed() > REFRESH;
        let needed = match self.hidden {
            None => true,
            Some(hidden) if hidden == number => again,
            Some(_) => self.since_load >= lost,
        };
        self.since_load += u32::from(!needed);
        needed
    }

    fn loaded(&mut self, number: usize) {
        (self.hidden, self.since_load, self.loaded_at) = (Some(number), 1, Instant::now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pulses(load: Duration) -> Pulses {
        let rhythm = Rhythm::new(200.0, load, Duration::from_micros(40));
        Pulses { rhythm, hidden: None, since_load: 0, loaded_at: Instant::now(), shown: None }
    }

    #[test]
    fn a_frame_is_loaded_after_as_many_pulses_as_its_loading_skips() {
        let mut pulses = pulses(Duration::from_micros(11_200));
        assert_eq!(pulses.rhythm.lost(), 2);
        assert!(pulses.needs(0), "the first is loaded at once");
        for number in 1..4 {
            pulses.loaded(number - 1);
            assert_eq!([(); 3].map(|()| pulses.needs(number)), [false, true, true], "{number}");
        }
        pulses.loaded_at -= 2 * REFRESH;
        assert!(!pulses.needs(2), "a repetition would skip pulses");
    }

    #[test]
    fn a_frame_that_skips_no_pulse_is_loaded_at_once_and_repeated_after_a_time() {
        let mut pulses = pulses(Duration::from_micros(500));
        assert_eq!(pulses.rhythm.lost(), 0);
        pulses.loaded(0);
        assert!(pulses.needs(1) && !pulses.needs(0));
        pulses.loaded_at -= 2 * REFRESH;
        assert!(pulses.needs(0));
    }
}
