//! Sound and silence in turn, switched from here: when which frame is loaded, shown and hidden.
//!
//! A board shows one of two buffers and takes frames into the other, or it has one buffer and each change is a frame.

use std::sync::Arc;

use web_time::{Duration, Instant};

use crate::device::levels::Levels;
use crate::device::link::shared::Content;
use crate::device::link::shared::Wanted;
use crate::device::link::stock::rhythm::Rhythm;

/// Repetition interval of unchanged content, in case a byte was damaged.
pub const REFRESH: Duration = Duration::from_millis(250);

/// The same for the buffers of a motion each of whose frames skips pulses: it skips as many again.
const SELDOM: Duration = Duration::from_secs(2);

/// Generation of a wish, and the number of a frame in it.
pub type Key = (u64, usize);

/// The next action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// Silence is loaded and shown, whichever buffer is hidden.
    Darken,
    /// A frame is loaded in silence.
    Load(Key),
    /// The loaded frame is shown.
    Show,
    /// A frame is loaded and shown in sound.
    Stream(Key),
    /// Silence is loaded in sound.
    LoadDark,
    /// The loaded silence is shown.
    ShowDark,
    /// Nothing, until an exact time.
    Watch(Instant),
    /// Nothing any more: the board is silent.
    End,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Whatever the board shows is to be replaced by silence.
    Opening,
    Silence,
    /// Silence, with the next frame loaded.
    Loaded,
    Sound,
    /// Sound, with silence loaded.
    Fading,
}

/// The pulses of a wish and of those that follow it with the same frequency.
#[derive(Debug)]
pub struct Pulses {
    rhythm: Rhythm,
    /// Whether the board has two buffers.
    swaps: bool,
    content: Arc<Content>,
    generation: u64,
    since: Instant,
    stage: Stage,
    /// When the present or next pulse begins.
    due: Instant,
    /// The present or next frame.
    frame: Option<Key>,
    /// Pulses of that frame.
    since_load: u32,
    /// The hidden buffer holds silence, if there is one.
    dark_is_hidden: bool,
    /// When both buffers were last filled, whichever was shown.
    refreshed_at: Instant,
    /// Another kind of wish follows.
    ends: bool,
}

impl Pulses {
    pub fn new(rhythm: Rhythm, swaps: bool, content: &Arc<Content>, wanted: &Wanted, now: Instant) -> Self {
        Self {
            rhythm,
            swaps,
            content: Arc::clone(content),
            generation: wanted.generation,
            since: wanted.since,
            stage: Stage::Opening,
            due: now,
            frame: None,
            since_load: 0,
            dark_is_hidden: true,
            refreshed_at: now,
            ends: false,
        }
    }

    pub fn rhythm(&self) -> Rhythm {
        self.rhythm
    }

    /// Whether the present or next pulse has a frame of this wish.
    pub fn plays(&self, generation: u64) -> bool {
        self.frame.is_some_and(|(of, _)| of == generation)
    }

    pub fn is_of(&self, generation: u64) -> bool {
        self.generation == generation
    }

    /// Goes on with a newer wish of the same frequency, as with the next frame of a motion.
    pub fn follow(&mut self, rhythm: Rhythm, content: &Arc<Content>, wanted: &Wanted) {
        (self.rhythm, self.content) = (rhythm, Arc::clone(content));
        (self.generation, self.since) = (wanted.generation, wanted.since);
    }

    /// The line is later by so many seconds than was thought, and the pulses with it.
    pub fn shift(&mut self, seconds: f64) {
        let shift = Duration::from_secs_f64(seconds.abs());
        let shifted = if seconds < 0.0 { self.due.checked_sub(shift) } else { self.due.checked_add(shift) };
        self.due = shifted.unwrap_or(self.due);
    }

    /// Ends as soon as there is silence.
    pub fn end(&mut self) {
        self.ends = true;
    }

    /// The frame of the present or next pulse.
    pub fn at_due(&self) -> &Levels {
        self.at(self.due)
    }

    pub fn at(&self, moment: Instant) -> &Levels {
        self.content.at(self.elapsed(moment)).1
    }

    /// The next act at `now`, on a line that has sent everything at `free_at`.
    pub fn next(&mut self, now: Instant, free_at: Instant) -> Act {
        match self.stage {
            Stage::Opening | Stage::Silence | Stage::Loaded if self.ends => Act::End,
            Stage::Opening => Act::Darken,
            Stage::Silence => {
                let key = self.key_at(self.due);
                if self.needs(key) {
                    let is_old = self.swaps && self.age(now) > SELDOM;
                    return if is_old { Act::Darken } else { Act::Load(key) };
                }
                self.stage = Stage::Loaded;
                self.next(now, free_at)
            }
            Stage::Loaded => Self::then(self.due - self.rhythm.show, Act::Show, now),
            Stage::Sound if self.ends => {
                if self.dark_is_hidden {
                    Act::ShowDark
                } else {
                    Act::LoadDark
                }
            }
            Stage::Sound => self.in_sound(now, free_at.max(now)),
            Stage::Fading if self.ends => Act::ShowDark,
            Stage::Fading => Self::then(self.dark_at() - self.rhythm.show, Act::ShowDark, now),
        }
    }

    fn then(due: Instant, act: Act, now: Instant) -> Act {
        if now < due { Act::Watch(due) } else { act }
    }

    fn dark_at(&self) -> Instant {
        self.due + self.rhythm.half
    }

    /// Plays due frames as time allows, then sees to the silence after them.
    fn in_sound(&mut self, now: Instant, free_at: Instant) -> Act {
        if self.rhythm.streams(free_at, self.dark_at()) {
            let key = self.key_at(free_at);
            if self.frame != Some(key) {
                return Act::Stream(key);
            }
            let next = free_at.checked_add(self.content.next_in(self.elapsed(free_at)));
            if let Some(next) = next.filter(|&next| self.rhythm.streams(next, self.dark_at())) {
                return Act::Watch(next);
            }
        }
        if !self.dark_is_hidden || self.refreshes(now, free_at) {
            return Act::LoadDark;
        }
        self.stage = Stage::Fading;
        self.next(now, free_at)
    }

    /// Whether to fill both buffers again, in case a byte was damaged: a lost swap would leave frames in both, and
    /// sound without a pause. Silence is loaded in sound, the frame in the silence after it, if neither skips a pulse.
    fn refreshes(&self, now: Instant, free_at: Instant) -> bool {
        let skips_none = self.rhythm.lost() == 0 && self.rhythm.fits(free_at, self.dark_at());
        self.swaps && self.age(now) > REFRESH && skips_none
    }

    /// Age of the contents of both buffers.
    fn age(&self, now: Instant) -> Duration {
        now.saturating_duration_since(self.refreshed_at)
    }

    fn elapsed(&self, at: Instant) -> Duration {
        at.saturating_duration_since(self.since)
    }

    fn key_at(&self, at: Instant) -> Key {
        (self.generation, self.content.at(self.elapsed(at)).0)
    }

    /// Whether to load a frame: a new one, after as many pulses as its loading skips.
    fn needs(&self, key: Key) -> bool {
        self.frame.is_none_or(|frame| frame != key && self.since_load >= self.rhythm.lost())
    }

    /// `act` was carried out: written at `now`, on the line until `gone`.
    pub fn done(&mut self, act: Act, now: Instant, gone: Instant) {
        match act {
            Act::Darken => {
                self.due = match self.stage {
                    Stage::Opening => gone + self.rhythm.half,
                    Stage::Silence | Stage::Loaded | Stage::Sound | Stage::Fading => {
                        self.rhythm.next_pulse(self.due, gone)
                    }
                };
                (self.stage, self.refreshed_at) = (Stage::Silence, now);
            }
            Act::Load(key) => {
                self.loaded(key);
                self.stage = Stage::Loaded;
                self.due = self.rhythm.next_pulse(self.due, gone + self.rhythm.show);
            }
            Act::Show => {
                self.stage = Stage::Sound;
                self.since_load += 1;
                self.dark_is_hidden = true;
            }
            Act::Stream(key) => {
                self.loaded(key);
                self.dark_is_hidden = !self.swaps;
            }
            Act::LoadDark => {
                if self.dark_is_hidden {
                    (self.frame, self.refreshed_at) = (None, now);
                }
                self.stage = Stage::Fading;
            }
            Act::ShowDark => {
                self.stage = Stage::Silence;
                self.due = self.rhythm.next_pulse(self.due, now);
            }
            Act::Watch(_) | Act::End => {}
        }
    }

    fn loaded(&mut self, key: Key) {
        (self.frame, self.since_load) = (Some(key), 0);
    }
}
