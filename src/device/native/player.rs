//! The player of slots: one slot, or a loop over a range, and a waiting command.

/// A PLAY, or the commit of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Play {
    pub first: u8,
    pub last: u8,
    /// Periods per slot.
    pub divider: u16,
    /// 0: for ever
    pub loops: u16,
    pub when: When,
    /// A PLAY, not the commit of a frame: it begins a cycle.
    pub begins: bool,
}

/// The boundary at which a PLAY is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum When {
    AtOnce,
    AfterLoop,
    /// At a period that the leader marks.
    InStep,
    /// After a rising edge of the trigger input.
    AtTrigger,
}

impl Play {
    fn holds(&self, slot: u8) -> bool {
        (self.first..=self.last).contains(&slot)
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Player {
    slot: u8,
    wait: u16,
    left: u16,
    running: Option<Play>,
    waiting: Option<Play>,
}

impl Player {
    /// Goes over a boundary; `in_step` if its period is marked, `triggered` after an edge of the trigger input.
    /// Returns whether a cycle begins.
    pub fn step(&mut self, in_step: bool, triggered: bool) -> bool {
        let at_once = |play: &Play| match play.when {
            When::AtOnce => true,
            When::AfterLoop => self.running.is_none(),
            When::InStep => in_step,
            When::AtTrigger => triggered,
        };
        match (self.running, self.waiting.filter(at_once)) {
            (_, Some(play)) => self.take(play),
            (Some(play), None) => self.go_on(play),
            (None, None) => false,
        }
    }

    /// Replaces the waiting command.
    pub fn ask(&mut self, play: Play) {
        self.waiting = Some(play);
    }

    /// Stays where it is.
    pub fn stop(&mut self) {
        (self.running, self.waiting) = (None, None);
    }

    pub fn slot(&self) -> u8 {
        self.slot
    }

    pub fn plays_several(&self) -> bool {
        self.running.is_some_and(|play| play.first != play.last)
    }

    pub fn waits(&self) -> bool {
        self.waiting.is_some()
    }

    pub fn waits_in_step(&self) -> bool {
        self.waiting.is_some_and(|play| play.when == When::InStep)
    }

    fn take(&mut self, play: Play) -> bool {
        *self = Self {
            slot: play.first,
            wait: play.divider,
            left: play.loops,
            running: Some(play),
            waiting: None,
        };
        play.begins
    }

    fn go_on(&mut self, play: Play) -> bool {
        self.wait -= 1;
        if self.wait > 0 {
            return false;
        }
        self.wait = play.divider;
        if self.slot < play.last {
            self.slot += 1;
            return false;
        }
        if let Some(next) = self.waiting.filter(|play| play.when == When::AfterLoop) {
            return self.take(next);
        }
        self.left = self.left.wrapping_sub(1);
        if play.loops > 0 && self.left == 0 {
            self.running = None;
            return false;
        }
        self.slot = play.first;
        play.first != play.last
    }

    /// Whether a slot is played, or may be without further packets.
    pub fn holds(&self, slot: u8) -> bool {
        let in_range = |play: Option<Play>| play.is_some_and(|play| play.holds(slot));
        slot == self.slot || in_range(self.running) || in_range(self.waiting)
    }
}
