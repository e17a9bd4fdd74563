//! The link to a board: a task (`device::task`) brings the board to the wanted state, given as a value.
//!
//! The wanted state is a still frame, a motion, or silence, and an envelope. The task compares it with the state of
//! the board and sends the difference. Nothing is queued: the newest wish wins, an older, unsent wish is never
//! sent, and after a loss the current state is sent. The task writes bytes at most 3 ms before the line can carry
//! them (`pace`), in a page 12 ms.
//!
//! A board is silenced when it is found, and whenever its link ends: `Sounding` does so in its destructor, so also
//! after a panic.

mod native;
mod shared;
mod stock;

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};

use web_time::{Duration, Instant};

use crate::device::health::{Health, State};
use crate::device::task::{self, Task, locked};
use crate::scene::Modulation;
use shared::{Shared, Wanted};

pub use native::survey;
pub use shared::{Content, Event, LinkError, Settings};

/// Interval of reconnection attempts after a loss.
const RETRY: Duration = Duration::from_millis(250);

/// Limit of unread messages; more are dropped.
const MESSAGES: usize = 256;

/// A link to a board. Dropping it silences the board.
pub struct Link {
    settings: Settings,
    shared: Arc<Shared>,
    events: Receiver<Event>,
    task: Option<Task>,
}

/// Silences a board from any thread, while the link's owner does something else.
pub struct Silencer(Arc<Shared>);

impl std::fmt::Debug for Silencer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Silencer").finish_non_exhaustive()
    }
}

impl Silencer {
    /// Silences the board, and refuses content of an owner that has not yet seen this.
    pub fn silence(&self) {
        self.0.want(|wanted| (wanted.content, wanted.silenced) = (None, wanted.silenced + 1));
    }
}

impl std::fmt::Debug for Link {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Link").field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl Link {
    /// Begins to look for the board. `notify` is called by the link's task when there is something new to see.
    ///
    /// # Errors
    /// The thread could not be started.
    pub fn open(settings: Settings, notify: Box<dyn Fn() + Send + Sync>) -> io::Result<Self> {
        let (sender, events) = sync_channel(MESSAGES);
        let shared = Arc::new(Shared::new(sender, notify));
        let (theirs, its) = (Arc::clone(&shared), settings.clone());
        let task = Task::start("link", move || keep_connected(its, theirs))?;
        Ok(Self { settings, shared, events, task: Some(task) })
    }

    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Plays this content from now on; a motion without frames or with an invalid rate is silence.
    pub fn show(&self, content: Content) {
        let content = content.plays().then(|| Arc::new(content));
        self.want(|wanted| wanted.content = content);
    }

    /// The same, unless the board was silenced by a [`Silencer`] since [`Self::silenced`] gave this number.
    pub fn show_unless_silenced(&self, content: Content, silenced: u64) {
        let content = content.plays().then(|| Arc::new(content));
        self.want(|wanted| {
            if wanted.silenced == silenced {
                wanted.content = content;
            }
        });
    }

    /// Silences the board.
    pub fn stop(&self) {
        self.want(|wanted| wanted.content = None);
    }

    /// Number of times that a [`Silencer`] silenced the board.
    pub fn silenced(&self) -> u64 {
        self.shared.wanted.lock().silenced
    }

    /// Silences the board for other threads.
    pub fn silencer(&self) -> Silencer {
        Silencer(Arc::clone(&self.shared))
    }

    /// Sets the envelope.
    pub fn modulate(&self, modulation: Modulation) {
        self.want(|wanted| wanted.modulation = modulation);
    }

    fn want(&self, change: impl FnOnce(&mut Wanted)) {
        self.shared.want(change);
    }

    /// The next message, if there is one.
    pub fn event(&self) -> Option<Event> {
        self.events.try_recv().ok()
    }

    /// The next message within a time.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn event_within(&self, timeout: Duration) -> Option<Event> {
        self.events.recv_timeout(timeout).ok()
    }

    pub fn health(&self) -> Health {
        self.shared.health()
    }
}

impl Link {
    /// Closes the link, silencing the board if possible; returns its final health.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn close(mut self) -> Health {
        self.end();
        self.health()
    }

    fn end(&mut self) {
        self.want(|wanted| wanted.closing = true);
        self.task.take().into_iter().for_each(Task::join);
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.end();
    }
}

/// The task: one session after another, until the link is closed.
async fn keep_connected(settings: Settings, shared: Arc<Shared>) {
    task::hurry();
    let mut said = String::new();
    let mut was_deaf = false;
    while let Err(error) = session(&settings, &shared, was_deaf).await {
        let why = error.to_string();
        was_deaf = matches!(error, LinkError::NoEcho { .. } | LinkError::Silent(_));
        // The same reason is reported once, however often the port is tried.
        if locked(&shared.figures).health.state == State::Ready || said != why {
            shared.tell(Event::Lost(why.clone()));
            said = why;
        }
        let until = Instant::now() + RETRY;
        while Instant::now() < until && !shared.wanted().closing {
            shared.wait(shared.wanted().generation, until.saturating_duration_since(Instant::now())).await;
        }
        if shared.wanted().closing {
            return;
        }
    }
}

/// Until the link is closed, or the board is lost. A board that was deaf may be in a boot loader that bytes hold.
async fn session(settings: &Settings, shared: &Shared, was_deaf: bool) -> Result<(), LinkError> {
    match settings.profile.answers() {
        true => native::run(settings, shared).await,
        false => stock::run(settings, shared, was_deaf).await,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Weak;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::device::levels::Levels;
    use crate::device::link::shared::Figures;
    use crate::device::profile::Profile;

    fn motion(frames: usize, rate: f64) -> Content {
        let one = |element| Levels::one(Profile::UltrainoMega64, element);
        Content::Motion { frames: (0..frames).map(one).collect(), rate }
    }

    #[test]
    fn a_motion_plays_at_any_rate_that_is_one() {
        assert!([0.1, 1.0, 1e6].into_iter().all(|rate| motion(2, rate).plays()));
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].into_iter().all(|rate| !motion(2, rate).plays()));
        assert!(!motion(0, 10.0).plays() && Content::Still(Levels::off(Profile::Native)).plays());
    }

    #[test]
    fn only_the_latest_wish_is_waited_on() {
        let (events, _heard) = sync_channel(1);
        let shared = Shared::new(events, Box::new(|| {}));
        shared.renew(&mut shared.wanted.lock(), Instant::now(), |_| {});
        let waited = |generation: u64, timeout: Duration| {
            let begun = Instant::now();
            task::finish(shared.wait(generation, timeout));
            begun.elapsed() >= timeout
        };
        assert!(waited(1, Duration::from_millis(5)), "no newer wish came");
        assert!(!waited(0, Duration::from_secs(600)), "a newer one was there");
    }

    #[test]
    fn a_wish_wakes_the_task_that_waits_for_it() {
        const TIMEOUT: Duration = Duration::from_secs(20);
        let (sender, events) = sync_channel(1);
        let shared = Arc::new(Shared::new(sender, Box::new(|| {})));
        let its = Arc::clone(&shared);
        let wait = move || {
            let begun = Instant::now();
            task::finish(its.wait(0, TIMEOUT));
            begun.elapsed()
        };
        let waiting = std::thread::Builder::new().name("waiting".to_owned()).spawn(wait).unwrap();
        std::thread::sleep(Duration::from_millis(20));
        let settings = Settings { port: "board".into(), profile: Profile::Native, baud: None };
        Link { settings, shared, events, task: None }.stop();
        assert!(waiting.join().unwrap() < TIMEOUT);
    }

    #[test]
    fn frames_take_turns_and_each_stands_until_the_next_is_due() {
        const HAIR: Duration = Duration::from_micros(1);
        let content = motion(3, 4.0);
        let frame = |elapsed: Duration| content.at(elapsed).0;
        let at = [0, 240, 260, 510, 740, 760, 1010].map(|millis| frame(Duration::from_millis(millis)));
        assert_eq!(at, [0, 0, 1, 2, 2, 0, 1]);
        for elapsed in [0, 3, 130, 249, 251, 800].map(Duration::from_millis) {
            let due = elapsed + content.next_in(elapsed);
            assert_eq!(frame(due - HAIR), frame(elapsed), "{elapsed:?}");
            assert_eq!(frame(due + HAIR), (frame(elapsed) + 1) % 3, "{elapsed:?}");
        }
        let levels = Levels::one(Profile::UltrainoMega64, 2);
        assert_eq!(content.at(Duration::from_millis(600)), (2, &levels));
        assert_eq!(Content::Still(levels).next_in(Duration::ZERO), Duration::MAX);
    }

    #[test]
    fn who_is_told_of_an_event_may_read_the_figures() {
        static WERE_FREE: AtomicBool = AtomicBool::new(false);
        let (events, _heard) = sync_channel(1);
        let shared = Arc::new_cyclic(|shared: &Weak<Shared>| {
            let shared = Weak::clone(shared);
            let are_free = move || shared.upgrade().is_some_and(|shared| shared.figures.try_lock().is_ok());
            Shared::new(events, Box::new(move || WERE_FREE.store(are_free(), Ordering::SeqCst)))
        });
        shared.notice("now");
        assert!(WERE_FREE.load(Ordering::SeqCst));
    }

    #[test]
    fn frames_and_bytes_count_in_all_and_per_second() {
        let shared = Shared::new(sync_channel(1).0, Box::new(|| {}));
        let begun = Instant::now();
        shared.note_frame();
        shared.note_bytes(7);
        let Figures { health, frames, bytes, .. } = &mut *locked(&shared.figures);
        assert_eq!((health.frames, health.bytes), (1, 7));
        assert_eq!((frames.per_second(begun), bytes.per_second(begun)), (1.0, 7.0));
    }
}
