//! The desk: the scene shared by all clients. Changes are applied at once, so nothing queues up and the newest wins.

use std::sync::{Arc, Mutex};

use web_time::Duration;

use crate::control::counts::Counts;
use crate::control::edit::{Edit, Wish};
use crate::control::refusal::EditError;
use crate::control::report::Report;
use crate::device::task::{Watched, finish, locked};
use crate::scene::Scene;

pub struct Desk {
    held: Watched<Held>,
    report: Mutex<Arc<Report>>,
    pub counts: Counts,
    /// Called after every change.
    notify: Box<dyn Fn() + Send + Sync>,
    /// Silences the board at once, on the caller's thread.
    silence: Mutex<Option<Box<dyn Fn() + Send + Sync>>>,
}

#[derive(Debug)]
struct Held {
    wish: Wish,
    /// Number of changes of the wish.
    generation: u64,
    /// A result came that the loop has not yet seen.
    has_news: bool,
    closing: bool,
}

impl std::fmt::Debug for Desk {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Desk").field("held", &self.held).finish_non_exhaustive()
    }
}

impl Desk {
    /// Calls `notify` after every change, on the caller's thread.
    pub fn new(scene: Arc<Scene>, notify: Box<dyn Fn() + Send + Sync>) -> Self {
        let held = Held { wish: Wish::new(scene), generation: 1, has_news: false, closing: false };
        Self {
            held: Watched::new(held),
            report: Mutex::default(),
            counts: Counts::default(),
            notify,
            silence: Mutex::default(),
        }
    }

    /// Calls `silence` whenever a change ends playback, before that change is acknowledged.
    pub fn silence_by(&self, silence: Box<dyn Fn() + Send + Sync>) {
        *locked(&self.silence) = Some(silence);
    }

    /// Ends playback and silences the board.
    pub fn silence(&self) {
        let mut held = self.held.lock();
        (held.wish.sends, held.wish.stops) = (false, held.wish.stops + 1);
        held.generation += 1;
        locked(&self.silence).iter().for_each(|silence| silence());
        drop(held);
        self.held.ring();
    }

    /// Applies a change, and returns the number of changes.
    ///
    /// # Errors
    /// Errors of [`Wish::after`]; the wish is then unchanged.
    pub fn change(&self, change: &[Edit]) -> Result<u64, EditError> {
        /// Tries outside of the lock, so that a large edit delays no other's stop.
        const TRIES: usize = 3;
        let beside = (0..TRIES).find_map(|_| {
            let (wish, generation) = self.wish();
            let made = wish.after(change);
            let held = self.held.lock();
            (held.generation == generation).then_some((held, made))
        });
        let (mut held, made) = beside.unwrap_or_else(|| {
            let held = self.held.lock();
            let made = held.wish.after(change);
            (held, made)
        });
        let made = made.inspect_err(|_| self.counts.refused.add())?;
        let is_stopped = made.stops > held.wish.stops && !made.sends;
        (held.wish, held.generation) = (made, held.generation + 1);
        let generation = held.generation;
        // Under the lock: the link refuses a reader of an earlier wish.
        if is_stopped {
            locked(&self.silence).iter().for_each(|silence| silence());
        }
        drop(held);
        self.counts.changes.add();
        self.held.ring();
        (self.notify)();
        Ok(generation)
    }

    /// Replaces the wish of generation `before` by the user's, unless others have changed it since.
    pub fn put(&self, before: u64, wish: Wish) -> Option<u64> {
        let mut held = self.held.lock();
        if held.generation != before {
            return None;
        }
        (held.wish, held.generation) = (wish, before + 1);
        drop(held);
        self.held.ring();
        Some(before + 1)
    }

    /// The current wish, and its generation.
    pub fn wish(&self) -> (Wish, u64) {
        let held = self.held.lock();
        (held.wish.clone(), held.generation)
    }

    /// The current generation.
    pub fn generation(&self) -> u64 {
        self.held.lock().generation
    }

    /// Waits for a newer wish than `generation`, or for news, at most for `timeout`.
    pub fn wait(&self, generation: u64, timeout: Duration) {
        let is_so = |held: &Held| held.generation == generation && !held.has_news && !held.closing;
        finish(self.held.wait_while(timeout, is_so));
        self.held.lock().has_news = false;
    }

    /// Wakes the loop for a result.
    pub fn bring_news(&self) {
        self.held.lock().has_news = true;
        self.held.ring();
    }

    pub fn report(&self) -> Arc<Report> {
        Arc::clone(&locked(&self.report))
    }

    /// Publishes the current report.
    pub fn tell(&self, report: Report) {
        let mut last = locked(&self.report);
        let serial = last.serial + u64::from(report.tells_more_than(&last));
        *last = Arc::new(Report { serial, ..report });
    }

    /// Refuses clients from now on.
    pub fn close(&self) {
        self.held.lock().closing = true;
        self.held.ring();
    }

    pub fn is_closing(&self) -> bool {
        self.held.lock().closing
    }
}
