//! State shared by a link's task and its owner: settings, the wanted content, events and figures.

use std::path::PathBuf;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex};

use web_time::{Duration, Instant};

use crate::device::health::{Found, Health, State};
use crate::device::levels::Levels;
use crate::device::port::{Port, PortError};
use crate::device::profile::Profile;
use crate::device::statistics::{Durations, Rate};
use crate::device::task::{self, Watched, locked};
use crate::scene::Modulation;

/// Write-ahead time of the line: more delays new frames, less leaves gaps on a busy computer. A page is busy with its
/// own frames.
pub const LEAD: Duration = Duration::from_millis(if cfg!(target_arch = "wasm32") { 12 } else { 3 });

/// Port and profile of a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    pub port: PathBuf,
    pub profile: Profile,
    /// Instead of the profile's.
    pub baud: Option<u32>,
}

impl Settings {
    pub fn baud(&self) -> u32 {
        self.baud.unwrap_or(self.profile.baud())
    }
}

/// Content for a board.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    Still(Levels),
    /// Frames in turn, `rate` per second, endlessly.
    Motion {
        frames: Vec<Levels>,
        rate: f64,
    },
}

#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The board is there, silent, and ready.
    Ready(Found),
    /// The reason of the loss; the board is searched for.
    Lost(String),
    /// A notice for the user.
    Notice(String),
}

/// Reasons for having no link.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    #[error(transparent)]
    Port(#[from] PortError),
    #[error("{0} does not answer: is the board on, and is it a native one?")]
    NoAnswer(String),
    #[error(
        "nothing comes back from {port}, but a board of {board} sends back commands: is it on, does its sketch run, is this its port?"
    )]
    NoEcho { port: String, board: &'static str },
    #[error(
        "{port} sends back what a board of {board} does not: is another board there, or are two wires connected?"
    )]
    OtherEcho { port: String, board: &'static str },
    #[error("{0} stopped answering")]
    Silent(String),
    #[error("{0} has no native board, or one at another bit rate")]
    OtherBoard(String),
    #[error("the board speaks version {theirs} of the protocol, this program version {ours}")]
    OtherVersion { theirs: u8, ours: u8 },
    #[error("{asked} baud is more than the board's {largest}")]
    TooFast { asked: u32, largest: u32 },
    #[error("the board has {board} channels, {expected} were expected")]
    OtherCount { board: usize, expected: usize },
    #[error("no board of address {address} answers at {name}")]
    NoDevice { name: String, address: u8 },
    #[error("the board was switched off and on again")]
    Restarted,
    #[error("the board refuses {0} again and again")]
    Refused(&'static str),
}

/// The wanted state, and its generation.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub(super) content: Option<Arc<Content>>,
    pub(super) modulation: Modulation,
    pub(super) generation: u64,
    /// Number of times that others silenced it.
    pub(super) silenced: u64,
    /// When it changed last.
    pub(super) since: Instant,
    pub(super) closing: bool,
}

/// State shared by the task and its owner.
pub struct Shared {
    pub(super) wanted: Watched<Wanted>,
    pub(super) figures: Mutex<Figures>,
    pub(super) events: SyncSender<Event>,
    pub(super) notify: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
pub struct Figures {
    pub(super) health: Health,
    pub(super) frames: Rate,
    pub(super) bytes: Rate,
    pub(super) round_trip: Durations,
    pub(super) latency: Durations,
    pub(super) swaps: Durations,
}

impl Shared {
    pub(super) fn new(events: SyncSender<Event>, notify: Box<dyn Fn() + Send + Sync>) -> Self {
        let wanted = Wanted {
            content: None,
            modulation: Modulation::default(),
            generation: 0,
            silenced: 0,
            since: Instant::now(),
            closing: false,
        };
        Self { wanted: Watched::new(wanted), figures: Mutex::default(), events, notify }
    }

    pub(super) fn wanted(&self) -> Wanted {
        self.wanted.lock().clone()
    }

    pub(super) fn want(&self, change: impl FnOnce(&mut Wanted)) {
        let mut wanted = self.wanted.lock();
        self.renew(&mut wanted, Instant::now(), change);
        drop(wanted);
        self.wanted.ring();
    }

    /// Makes a wish newer.
    pub(super) fn renew(&self, wanted: &mut Wanted, now: Instant, change: impl FnOnce(&mut Wanted)) {
        change(wanted);
        wanted.generation += 1;
        wanted.since = now;
        self.note(|figures| figures.health.in_place = false);
    }

    /// Waits for a newer wish than `generation`, at most for `timeout`.
    pub(super) async fn wait(&self, generation: u64, timeout: Duration) {
        let is_so = |wanted: &Wanted| wanted.generation == generation && !wanted.closing;
        self.wanted.wait_while(timeout, is_so).await;
    }

    pub(super) fn health(&self) -> Health {
        let mut figures = locked(&self.figures);
        let now = Instant::now();
        let Figures { health, frames, bytes, round_trip, latency, swaps } = &mut *figures;
        health.frames_per_second = frames.per_second(now);
        health.bytes_per_second = bytes.per_second(now);
        health.round_trip = round_trip.spread();
        health.latency = latency.spread();
        health.swaps = swaps.spread();
        health.clone()
    }

    pub(super) fn tell(&self, event: Event) {
        let mut figures = locked(&self.figures);
        match &event {
            Event::Ready(_) => {
                figures.health.state = State::Ready;
                figures.health.found += 1;
            }
            Event::Lost(why) => {
                figures.health.state = State::Lost(why.clone());
                figures.health.in_place = false;
            }
            Event::Notice(_) => {}
        }
        drop(figures);
        // Unread messages may be dropped.
        let _ = self.events.try_send(event);
        (self.notify)();
    }

    pub(super) fn notice(&self, text: &str) {
        self.tell(Event::Notice(text.to_owned()));
    }

    pub(super) fn note(&self, change: impl FnOnce(&mut Figures)) {
        change(&mut locked(&self.figures));
    }

    pub(super) fn note_bytes(&self, count: usize) {
        self.note(|figures| {
            figures.health.bytes += count as u64;
            figures.bytes.note(count as u64, Instant::now());
        });
    }

    pub(super) fn note_frame(&self) {
        self.note(|figures| {
            figures.health.frames += 1;
            figures.frames.note(1, Instant::now());
        });
    }
}

/// A port whose board is silenced on drop, including panics.
pub struct Sounding<'a> {
    pub(super) port: Port,
    pub(super) silence: Vec<u8>,
    pub(super) shared: &'a Shared,
}

impl<'a> Sounding<'a> {
    /// The board of a port that may take bytes after `wait`.
    pub(super) fn new(mut port: Port, silence: Vec<u8>, wait: Duration, shared: &'a Shared) -> Self {
        if let Err(error) = port.leave_behind(&silence, wait) {
            shared.notice(&format!(
                "the board will not be silenced if this program is killed: no process to do so could be started: {error}"
            ));
        }
        Self { port, silence, shared }
    }
}

impl Drop for Sounding<'_> {
    fn drop(&mut self) {
        // A vanished port cannot be silenced; the native board's watchdog takes over.
        let silenced = self.port.leave(&self.silence);
        self.shared.note(|figures| figures.health.silenced = silenced);
        if silenced {
            task::linger(self.port.backlog() + LEAD);
        }
    }
}

impl Content {
    /// Several drives in turn, or a single one.
    pub fn in_turn(mut frames: Vec<Levels>, rate: f64) -> Self {
        match frames.len() {
            1 => Self::Still(frames.remove(0)),
            _ => Self::Motion { frames, rate },
        }
    }

    pub(super) fn plays(&self) -> bool {
        match self {
            Self::Still(_) => true,
            Self::Motion { frames, rate } => !frames.is_empty() && *rate > 0.0 && rate.is_finite(),
        }
    }

    pub(super) fn frames(&self) -> &[Levels] {
        match self {
            Self::Still(levels) => std::slice::from_ref(levels),
            Self::Motion { frames, .. } => frames,
        }
    }

    /// The frame due after this time, and its number.
    pub(super) fn at(&self, elapsed: Duration) -> (usize, &Levels) {
        match self {
            Self::Still(levels) => (0, levels),
            Self::Motion { frames, rate } => {
                // Below 2^53 for any rate, since a motion's rate is checked.
                let frame = (elapsed.as_secs_f64() * rate) as usize % frames.len();
                (frame, &frames[frame])
            }
        }
    }

    /// The first frame at or after this time that is one of those asked for, and when it is due.
    pub(super) fn turn(
        &self,
        elapsed: Duration,
        is_one: impl Fn(&Levels) -> bool,
    ) -> Option<(Duration, usize)> {
        match self {
            Self::Still(levels) => is_one(levels).then_some((elapsed, 0)),
            Self::Motion { frames, rate } => {
                let first = (elapsed.as_secs_f64() * rate).floor();
                (0..frames.len()).find_map(|ahead| {
                    let turn = first + ahead as f64;
                    let frame = turn as usize % frames.len();
                    let due = Duration::try_from_secs_f64(turn / rate).unwrap_or(Duration::MAX);
                    is_one(&frames[frame]).then_some((due.max(elapsed), frame))
                })
            }
        }
    }

    /// Whether the board's two buffers hold all of it: at most two different frames.
    pub(super) fn fits_two_buffers(&self) -> bool {
        let first = &self.frames()[0];
        let mut others = self.frames().iter().filter(|levels| *levels != first);
        let Some(second) = others.next() else { return true };
        others.all(|levels| levels == second)
    }

    /// Time until the next frame is due.
    pub(super) fn next_in(&self, elapsed: Duration) -> Duration {
        match self {
            Self::Still(_) => Duration::MAX,
            Self::Motion { rate, .. } => {
                let played = elapsed.as_secs_f64() * rate;
                let rest = (played.floor() + 1.0 - played) / rate;
                Duration::try_from_secs_f64(rest).unwrap_or(Duration::MAX)
            }
        }
    }
}
