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
    /// Discard what was written and has not left.
    Discard,
}

/// The meaning of bytes being written.
#[derive(Clone, Copy, Debug)]
enum Purpose {
    Silence,
    /// The board's modulation.
    Setting,
    /// Time until the next swap.
    Filler,
    /// A frame, loaded and shown.
    Frame(Key),
    /// A frame for the hidden buffer, due at this time.
    Load(Key, Instant),
    /// The hidden buffer.
    Swap(Key),
    Pulse(Act),
}

/// Write-ahead time of a line that keeps the time: longer than a busy computer lets its threads wait, and short enough
/// for silence after some 0.1 s where the system does not discard it.
pub const AHEAD: Duration = Duration::from_millis(30);
/// The same for a wish younger than [`SETTLED`], which may soon be replaced.
const AHEAD_OF_DRAGS: Duration = Duration::from_millis(20);
const SETTLED: Duration = Duration::from_millis(300);
/// The same before a list, which takes long itself.
const AHEAD_OF_LISTS: Duration = Duration::from_millis(10);
/// Time between two looks at such a line.
const SLICE: Duration = Duration::from_millis(5);

/// The frames of a wish on the line.
#[derive(Clone, Copy, Debug)]
struct Frames {
    generation: u64,
    /// Time for loading the longest.
    load: Duration,
    /// At most two of them differ.
    fit_two_buffers: bool,
}

/// The bytes to a board, and its known state.
pub struct Session<'a> {
    shared: &'a Shared,
    profile: Profile,
    baud: u32,
    pace: Pace,
    /// The byte that fills time, if the line keeps the time.
    filler: Option<u8>,
    writing: Purpose,
    /// Silence or a frame that was sent last.
    sent: Option<Key>,
    sent_at: Instant,
    /// A frame in the hidden buffer, and when it is due if it has not yet been shown.
    hidden: Option<(Key, Option<Instant>)>,
    loaded_at: Instant,
    frames: Option<Frames>,
    /// Generation of the silence for which the line was discarded.
    discarded: Option<u64>,
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
            filler: stock::filler(settings.profile),
            writing: Purpose::Setting,
            sent: None,
            sent_at: now,
            hidden: None,
            loaded_at: now,
            frames: None,
            discarded: None,
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
    /// [`Self::written`], after [`Step::Discard`] [`Self::discarded`] if the line allows it.
    pub fn next(&mut self, wanted: &Wanted, now: Instant, free_at: Instant) -> Step {
        let modulated = stock::modulated(self.profile, &wanted.modulation, self.baud);
        let content = wanted.content.as_ref();
        let is_full = self.filler.is_some() && free_at > now + LEAD;
        let is_new = self.sent != Some((wanted.generation, 0)) && self.discarded != Some(wanted.generation);
        if content.is_none() && is_full && is_new {
            self.discarded = Some(wanted.generation);
            return Step::Discard;
        }
        if self.pulses.is_some() && !(content.is_some() && modulated == Modulated::FromHere(self.frequency)) {
            self.pulses.iter_mut().for_each(Pulses::end);
            if let Some(step) = self.pulse(wanted, now, free_at) {
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
                self.pulse(wanted, now, free_at).unwrap_or(Step::Wait(now))
            }
            Modulated::Steady | Modulated::ByBoard(..) | Modulated::Never(_) | Modulated::OneFrequency => {
                self.steady(content, wanted, now, free_at.max(now))
            }
        }
    }

    /// The line was discarded: the board may have any part of what was written.
    pub fn discarded(&mut self) {
        (self.pulses, self.sent, self.hidden, self.is_loaded) = (None, None, None, true);
    }

    /// What the line is going to do happens later by so many seconds than was thought.
    pub fn shift(&mut self, seconds: f64) {
        self.pulses.iter_mut().for_each(|pulses| pulses.shift(seconds));
    }

    /// Write-ahead time.
    fn ahead(&self, wanted: &Wanted, now: Instant) -> Duration {
        match self.filler {
            None => LEAD,
            Some(_) if now.saturating_duration_since(wanted.since) < SETTLED => AHEAD_OF_DRAGS,
            Some(_) => AHEAD,
        }
    }

    /// The wait until the line, free at `at`, has no more to send than for this time.
    fn room(&self, ahead: Duration, now: Instant, at: Instant) -> Option<Step> {
        let slice = self.filler.map_or(Duration::ZERO, |_| SLICE);
        (at > now + ahead).then(|| Step::Wait(at - ahead + slice))
    }

    /// The step before a byte that is due at this time, unless the line has come to it.
    fn until(&mut self, due: Instant, wanted: &Wanted, now: Instant, at: Instant) -> Option<Step> {
        let Some(filler) = self.filler else { return (at < due).then_some(Step::Watch(due)) };
        let bytes = due.saturating_duration_since(at).as_secs_f64() / self.pace.time_of(1).as_secs_f64();
        let ahead = self.ahead(wanted, now);
        if bytes < 0.5 {
            return None;
        }
        if due > now + ahead {
            return Some(Step::Wait(due - ahead + SLICE));
        }
        Some(self.write(vec![filler; bytes.round() as usize], Purpose::Filler))
    }

    fn write(&mut self, bytes: Vec<u8>, purpose: Purpose) -> Step {
        self.writing = purpose;
        Step::Write(bytes)
    }

    /// The bytes of the last step were written at `now`; the last of them leaves at `gone`.
    pub fn written(&mut self, count: usize, wanted: &Wanted, now: Instant, gone: Instant) {
        self.shared.note_bytes(count);
        match self.writing {
            Purpose::Setting | Purpose::Filler => {}
            Purpose::Silence => self.show((wanted.generation, 0), now),
            Purpose::Load(key, due) => {
                (self.hidden, self.loaded_at, self.is_loaded) = (Some((key, Some(due))), now, true);
            }
            Purpose::Frame(key) | Purpose::Swap(key) => {
                self.shared.note_frame();
                self.place(wanted, gone);
                self.show(key, now);
            }
            Purpose::Pulse(act) => {
                (self.hidden, self.is_loaded) = (None, matches!(act, Act::Load(_) | Act::LoadDark));
                // A line that keeps the time is behind the clock, or ahead of it.
                let at = self.filler.and_then(|_| gone.checked_sub(self.pace.time_of(count)));
                self.pulsed(act, wanted, at.unwrap_or(now), gone);
            }
        }
    }

    /// This frame is shown; the one before is hidden and of use again if the buffers hold all frames.
    fn show(&mut self, key: Key, now: Instant) {
        let before = self.sent.filter(|_| self.frames.is_some_and(|frames| frames.fit_two_buffers));
        let is_swap = matches!(self.writing, Purpose::Swap(_));
        self.hidden = before.filter(|_| is_swap).map(|before| (before, None));
        (self.sent, self.sent_at, self.is_loaded) = (Some(key), now, false);
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

    /// Content that is due on a line that is free at `at`; otherwise a wait for the next.
    fn steady(&mut self, content: &Content, wanted: &Wanted, now: Instant, at: Instant) -> Step {
        match content {
            Content::Motion { .. } if stock::swap(self.profile).is_some() => {
                return self.in_turn(content, wanted, now, at);
            }
            Content::Motion { .. } | Content::Still(_) => {}
        }
        if at > now + LEAD {
            // The newest content is sent afterwards.
            return Step::Wait(at - LEAD);
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

    /// A motion on a board with two buffers: the next frame is loaded early, and shown by a byte in its time. Two frames
    /// that alternate are loaded once.
    fn in_turn(&mut self, content: &Content, wanted: &Wanted, now: Instant, at: Instant) -> Step {
        if let Some(step) = self.room(self.ahead(wanted, now), now, at) {
            return step;
        }
        let Frames { load, fit_two_buffers, .. } = self.frames_of(content, wanted);
        let (show, generation) = (self.pace.time_of(1), wanted.generation);
        let levels_of = |(of, frame): Key| (of == generation).then(|| &content.frames()[frame]);
        let since = |moment: Instant| moment.saturating_duration_since(wanted.since);
        // Of a motion slower than a frame in 30 years, the next is never due.
        let instant = |turn: Duration| wanted.since.checked_add(turn);
        let shown = self.sent.and_then(levels_of);
        let other = content.turn(since(at + load + show), |levels| Some(levels) != shown);
        let other = other.and_then(|(turn, frame)| Some((instant(turn)?, frame)));
        let hidden = self.hidden.filter(|(key, _)| key.0 == generation);
        let swapped = hidden.and_then(|(key, due)| {
            let again = || content.turn(since(at + show), |levels| Some(levels) == levels_of(key));
            Some((key, due.or_else(|| instant(again()?.0))?.max(at + show)))
        });
        let next = swapped.map(|(_, due)| due).or(other.map(|(due, _)| due));
        if let Some(key) = self.sent.filter(|(of, _)| *of == generation)
            && next.is_none_or(|next| next > at + load + REFRESH)
        {
            let due = self.sent_at + REFRESH;
            if now < due {
                return Step::Wait(next.map_or(due, |next| due.min(next - load - REFRESH)));
            }
            let bytes = self.started(stock::frame(&content.frames()[key.1]), now);
            return self.write(bytes, Purpose::Frame(key));
        }
        match (swapped, other) {
            (Some((key, due)), _) => {
                let is_old = fit_two_buffers && now > self.loaded_at + REFRESH;
                if is_old && at + load + show <= due {
                    return self.load(content, key, due, now, at);
                }
                let Some(swap) = stock::swap(self.profile) else { return Step::Wait(due) };
                self.until(due - show, wanted, now, at)
                    .unwrap_or_else(|| self.write(vec![swap], Purpose::Swap(key)))
            }
            (None, Some((due, frame))) => self.load(content, (generation, frame), due, now, at),
            (None, None) => Step::Wait(now + REFRESH),
        }
    }

    fn load(&mut self, content: &Content, key: Key, due: Instant, now: Instant, at: Instant) -> Step {
        let ahead = self.filler.map_or(LEAD, |_| AHEAD_OF_LISTS);
        if let Some(step) = self.room(ahead, now, at) {
            return step;
        }
        let bytes = self.started(stock::load(&content.frames()[key.1]), now);
        self.write(bytes, Purpose::Load(key, due))
    }

    fn frames_of(&mut self, content: &Content, wanted: &Wanted) -> Frames {
        if let Some(frames) = self.frames.filter(|frames| frames.generation == wanted.generation) {
            return frames;
        }
        let frames = Frames {
            generation: wanted.generation,
            load: self.longest(content, stock::load),
            fit_two_buffers: content.fits_two_buffers(),
        };
        *self.frames.insert(frames)
    }

    /// The line's time for the longest list of a content.
    fn longest(&self, content: &Content, bytes: fn(&Levels) -> Vec<u8>) -> Duration {
        let lengths = content.frames().iter().map(|levels| bytes(levels).len());
        self.pace.time_of(lengths.max().unwrap_or_default())
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
    fn pulse(&mut self, wanted: &Wanted, now: Instant, free_at: Instant) -> Option<Step> {
        let swap = stock::swap(self.profile);
        let dark = Levels::off(self.profile);
        // Pulses are in the time of the line, if it keeps one.
        let at = free_at.max(now);
        let mut clock = self.filler.map_or(now, |_| at);
        if let (Some(_), Some(step)) = (self.filler, self.room(self.ahead(wanted, now), now, at)) {
            return self.pulses.as_ref().map(|_| step);
        }
        loop {
            let pulses = self.pulses.as_mut()?;
            let act = pulses.next(clock, free_at.max(clock));
            let bytes = match act {
                Act::Watch(due) => {
                    if let Some(step) = self.until(due, wanted, now, clock) {
                        return Some(step);
                    }
                    clock = due;
                    continue;
                }
                Act::End => {
                    self.pulses = None;
                    return None;
                }
                // One buffer: the frame is sent when it is shown.
                Act::Load(_) if swap.is_none() => {
                    pulses.done(act, now, at);
                    self.shared.note_frame();
                    continue;
                }
                Act::Load(_) => stock::load(pulses.at_due()),
                Act::LoadDark => stock::load(&dark),
                Act::Stream(_) => stock::frame(pulses.at(at)),
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
        match stock::swap(self.profile) {
            Some(_) => Rhythm::new(frequency, self.longest(content, stock::load), self.pace.time_of(1)),
            None => Rhythm::new(frequency, Duration::ZERO, self.longest(content, stock::frame)),
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
                "{name} cannot be switched on and off {asked} times a second, but {fastest:.0} times at most {}: \
                 the sound is steady, and hardly felt",
                match stock::swap(self.profile) {
                    Some(_) => "by a computer's timers".to_owned(),
                    None => format!("at {} baud", self.baud),
                }
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
        let Content::Motion { rate, frames } = content else { return None };
        let line = match stock::swap(self.profile) {
            // A swap is a byte.
            Some(_) if content.fits_two_buffers() => 1.0 / self.pace.time_of(1).as_secs_f64(),
            Some(_) | None => self.profile.frames_per_second(self.baud),
        };
        let played = match modulated {
            Modulated::FromHere(frequency) => self.rhythm(frequency, content).frames_per_second(*rate),
            Modulated::Steady | Modulated::ByBoard(..) | Modulated::Never(_) | Modulated::OneFrequency => {
                rate.min(line)
            }
        };
        Some(FrameRates { asked: *rate, played, cycles: rate / frames.len() as f64 })
    }
}
