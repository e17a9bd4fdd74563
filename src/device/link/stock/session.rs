//! The bytes to a stock board, as a function of time: without a line or a clock.

use std::sync::Arc;

use web_time::{Duration, Instant};

use crate::device::health::FrameRates;
use crate::device::levels::Levels;
use crate::device::link::shared::{Content, Settings};
use crate::device::link::shared::{LEAD, Shared, Wanted};
use crate::device::link::stock::pulses::{Act, Key, Pulses, REFRESH};
use crate::device::link::stock::rhythm::Rhythm;
use crate::device::pace::Pace;
use crate::device::profile::Profile;
use crate::device::stock::{self, Modulated};

/// The next step.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    Write(Vec<u8>),
    /// Wait until then, or for a newer wish.
    Wait(Instant),
    /// The same, as exactly as possible.
    Watch(Instant),
}

/// The meaning of bytes being written.
#[derive(Clone, Copy, Debug)]
enum Purpose {
    Silence,
    /// The board's modulation.
    Setting,
    Frame(Key),
    Pulse(Act),
}

/// The bytes to a board, and its known state.
pub struct Session<'a> {
    shared: &'a Shared,
    profile: Profile,
    baud: u32,
    pace: Pace,
    writing: Purpose,
    /// Silence or a frame that was sent last.
    sent: Option<Key>,
    sent_at: Instant,
    /// When the board was last made to listen.
    started_at: Instant,
    /// A list has not been shown.
    is_loaded: bool,
    ready_at: Instant,
    pulses: Option<Pulses>,
    /// The frequency of the pulses.
    frequency: f64,
    /// When sound last began or ended.
    switched_at: Option<Instant>,
    /// Generation of the wish that was heard last.
    placed: Option<u64>,
    /// Generation of the wish that `told` belongs to.
    told_of: Option<u64>,
    /// The modulation sent to the board, and the notice given to the user.
    told: Option<(Modulated, Option<String>)>,
    told_rates: Option<FrameRates>,
}

impl<'a> Session<'a> {
    /// A session with a board that has just been silenced, at `now`.
    pub fn new(settings: &Settings, shared: &'a Shared, now: Instant) -> Self {
        let baud = settings.baud();
        Self {
            shared,
            profile: settings.profile,
            baud,
            pace: Pace::new(f64::from(baud), now),
            writing: Purpose::Setting,
            sent: None,
            sent_at: now,
            started_at: now,
            is_loaded: false,
            ready_at: now,
            pulses: None,
            frequency: 0.0,
            switched_at: None,
            placed: None,
            told_of: None,
            told: None,
            told_rates: None,
        }
    }
}

impl Session<'_> {
    /// The next step at `now`, on a line that has carried everything at `free_at`. After [`Step::Write`] comes
    /// [`Self::written`].
    pub fn next(&mut self, wanted: &Wanted, now: Instant, free_at: Instant) -> Step {
        let modulated = stock::modulated(self.profile, &wanted.modulation, self.baud);
        let content = wanted.content.as_ref();
        if self.pulses.is_some() && !(content.is_some() && modulated == Modulated::FromHere(self.frequency)) {
            self.pulses.iter_mut().for_each(Pulses::end);
            if let Some(step) = self.pulse(now, free_at) {
                return step;
            }
        }
        let Some(content) = content else { return self.silence(wanted, now) };
        if let Some(byte) = self.tell(modulated, content, wanted) {
            return self.write(vec![byte], Purpose::Setting);
        }
        match modulated {
            Modulated::FromHere(frequency) => {
                self.follow(frequency, content, wanted, now);
                self.pulse(now, free_at).unwrap_or(Step::Wait(now))
            }
            Modulated::Steady | Modulated::ByBoard(..) | Modulated::Never(_) | Modulated::OneFrequency => {
                self.steady(content, wanted, now, free_at)
            }
        }
    }

    fn write(&mut self, bytes: Vec<u8>, purpose: Purpose) -> Step {
        self.writing = purpose;
        Step::Write(bytes)
    }

    /// The bytes of the last step were written at `now`; the last of them leaves at `gone`.
    pub fn written(&mut self, count: usize, wanted: &Wanted, now: Instant, gone: Instant) {
        self.shared.note_bytes(count);
        self.is_loaded = matches!(self.writing, Purpose::Pulse(Act::Load(_) | Act::LoadDark));
        match self.writing {
            Purpose::Silence => (self.sent, self.sent_at) = (Some((wanted.generation, 0)), now),
            Purpose::Setting => {}
            Purpose::Frame(key) => {
                self.shared.note_frame();
                self.place(wanted, gone);
                (self.sent, self.sent_at) = (Some(key), now);
            }
            Purpose::Pulse(act) => self.pulsed(act, wanted, now, gone),
        }
    }

    /// The wish is heard from `gone` on.
    fn place(&mut self, wanted: &Wanted, gone: Instant) {
        let is_fresh = self.placed.replace(wanted.generation) != Some(wanted.generation);
        self.shared.note(|figures| {
            figures.health.in_place = true;
            if is_fresh && wanted.since > self.ready_at {
                figures.latency.note(gone.saturating_duration_since(wanted.since));
            }
        });
    }

    fn silence(&mut self, wanted: &Wanted, now: Instant) -> Step {
        let is_sent = self.sent == Some((wanted.generation, 0));
        let due = self.sent_at + REFRESH;
        if is_sent && now < due {
            return Step::Wait(due);
        }
        self.shared.note(|figures| figures.health.rates = None);
        let bytes = match is_sent {
            true => self.started(stock::frame(&Levels::off(self.profile)), now),
            false => stock::silence(self.profile),
        };
        self.write(bytes, Purpose::Silence)
    }

    /// A list, after what makes the board take it if it follows another, or if a damaged byte may have turned it away.
    fn started(&mut self, list: Vec<u8>, now: Instant) -> Vec<u8> {
        if !self.is_loaded && now.saturating_duration_since(self.started_at) < REFRESH {
            return list;
        }
        self.started_at = now;
        [stock::start(self.profile), &list].concat()
    }

    /// Content that is due; otherwise a wait for the next.
    fn steady(&mut self, content: &Content, wanted: &Wanted, now: Instant, free_at: Instant) -> Step {
        if free_at > now + LEAD {
            // The newest content is sent afterwards.
            return Step::Wait(free_at - LEAD);
        }
        let elapsed = now.saturating_duration_since(wanted.since);
        let (frame, levels) = content.at(elapsed);
        let key = (wanted.generation, frame);
        let due = self.sent_at + REFRESH;
        if self.sent != Some(key) || now >= due {
            let bytes = self.started(stock::frame(levels), now);
            return self.write(bytes, Purpose::Frame(key));
        }
        let next = now.checked_add(content.next_in(elapsed));
        Step::Wait(next.map_or(due, |next| next.min(due)))
    }

    /// Begins pulses, or goes on with them.
    fn follow(&mut self, frequency: f64, content: &Arc<Content>, wanted: &Wanted, now: Instant) {
        if self.pulses.as_ref().is_some_and(|pulses| pulses.is_of(wanted.generation)) {
            return;
        }
        let rhythm = self.rhythm(frequency, content);
        if let Some(pulses) = &mut self.pulses {
            return pulses.follow(rhythm, content, wanted);
        }
        let swaps = stock::swap(self.profile).is_some();
        self.pulses = Some(Pulses::new(rhythm, swaps, content, wanted, now));
        (self.frequency, self.switched_at) = (frequency, None);
        self.shared.note(|figures| figures.swaps.clear());
    }

    /// The next step of pulses, until they have ended.
    fn pulse(&mut self, now: Instant, free_at: Instant) -> Option<Step> {
        let swap = stock::swap(self.profile);
        let dark = Levels::off(self.profile);
        loop {
            let pulses = self.pulses.as_mut()?;
            let act = pulses.next(now, free_at);
            let bytes = match act {
                Act::Watch(due) => return Some(Step::Watch(due)),
                Act::End => {
                    self.pulses = None;
                    return None;
                }
                // One buffer: the frame is sent when it is shown.
                Act::Load(_) if swap.is_none() => {
                    pulses.done(act, now, free_at.max(now));
                    self.shared.note_frame();
                    continue;
                }
                Act::Load(_) => stock::load(pulses.at_due()),
                Act::LoadDark => stock::load(&dark),
                Act::Stream(_) => stock::frame(pulses.at(free_at.max(now))),
                Act::Darken => stock::frame(&dark),
                Act::Show => swap.map_or_else(|| stock::frame(pulses.at_due()), |swap| vec![swap]),
                Act::ShowDark => swap.map_or_else(|| stock::frame(&dark), |swap| vec![swap]),
            };
            let is_list = bytes.len() > 1;
            let bytes = if is_list { self.started(bytes, now) } else { bytes };
            return Some(self.write(bytes, Purpose::Pulse(act)));
        }
    }

    fn pulsed(&mut self, act: Act, wanted: &Wanted, now: Instant, gone: Instant) {
        let Some(pulses) = &mut self.pulses else { return };
        pulses.done(act, now, gone);
        let period = 2 * pulses.rhythm().half;
        let is_heard = matches!(act, Act::Show | Act::Stream(_)) && pulses.plays(wanted.generation);
        match act {
            Act::Load(_) | Act::Stream(_) => self.shared.note_frame(),
            Act::Show | Act::ShowDark => {
                let lasted =
                    self.switched_at.replace(now).map(|before| now.saturating_duration_since(before));
                if let Some(lasted) = lasted.filter(|lasted| *lasted < period) {
                    self.shared.note(|figures| figures.swaps.note(lasted));
                }
            }
            Act::Darken | Act::LoadDark | Act::Watch(_) | Act::End => {}
        }
        if is_heard {
            self.place(wanted, gone);
        }
    }

    /// The rhythm of this content on the line.
    fn rhythm(&self, frequency: f64, content: &Content) -> Rhythm {
        let time_of = |bytes: usize| self.pace.time_of(bytes);
        let longest = |bytes: fn(&Levels) -> Vec<u8>| {
            let lengths = content.frames().iter().map(|levels| bytes(levels).len());
            time_of(lengths.max().unwrap_or_default())
        };
        match stock::swap(self.profile) {
            Some(_) => Rhythm::new(frequency, longest(stock::load), time_of(1)),
            None => Rhythm::new(frequency, Duration::ZERO, longest(stock::frame)),
        }
    }

    /// Says how a new wish is played, and returns the byte that sets the board's own modulation, if it changes.
    fn tell(&mut self, modulated: Modulated, content: &Content, wanted: &Wanted) -> Option<u8> {
        if self.told_of.replace(wanted.generation) == Some(wanted.generation) {
            return None;
        }
        let rates = self.rates(modulated, content);
        self.shared.note(|figures| figures.health.rates = rates);
        let text = self.in_words(modulated, content, wanted.modulation.frequency);
        let told = Some((modulated, text));
        let is_new = self.told != told;
        if is_new {
            let text = told.as_ref().and_then(|(_, text)| text.as_ref());
            text.into_iter().for_each(|text| self.shared.notice(text));
            self.told = told;
        }
        if std::mem::replace(&mut self.told_rates, rates) != rates
            && let (Some(rates), false) = (rates, matches!(modulated, Modulated::FromHere(_)))
            && rates.differ()
        {
            self.shared.notice(&format!("{rates}: the line carries no more at {} baud", self.baud));
        }
        match modulated {
            Modulated::ByBoard(byte, _) if is_new => Some(byte),
            Modulated::ByBoard(..)
            | Modulated::Steady
            | Modulated::FromHere(_)
            | Modulated::Never(_)
            | Modulated::OneFrequency => None,
        }
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
                self.baud
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
        let rhythm = self.rhythm(frequency, content);
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

    /// Frame rates of a motion.
    fn rates(&self, modulated: Modulated, content: &Content) -> Option<FrameRates> {
        let Content::Motion { rate, .. } = content else { return None };
        let line = self.profile.frames_per_second(self.baud);
        let played = match modulated {
            Modulated::FromHere(frequency) => self.rhythm(frequency, content).frames_per_second(*rate),
            Modulated::Steady | Modulated::ByBoard(..) | Modulated::Never(_) | Modulated::OneFrequency => {
                rate.min(line)
            }
        };
        Some(FrameRates { asked: *rate, played })
    }
}
