//! The player: brings a performance to a board. Window, `serve`, `send` and the page play through it.

use std::io;
use std::ops::Range;

#[cfg(not(target_arch = "wasm32"))]
use web_time::Duration;

use crate::device::calibration::Calibration;
use crate::device::envelope;
#[cfg(not(target_arch = "wasm32"))]
use crate::device::health::Found;
use crate::device::levels::{self, Levels, OtherCount};
#[cfg(not(target_arch = "wasm32"))]
use crate::device::link::Event;
use crate::device::link::{Content, Link, Settings};
use crate::drive::Drive;
use crate::scene::{Modulation, Scene, motion};
use crate::studio::performance::Performance;

/// Waits until a board is ready, and tells the link's notices; `None` if the wait was cancelled.
///
/// # Errors
/// A board that is not there.
#[cfg(not(target_arch = "wasm32"))]
pub fn ready(link: &Link, is_over: impl Fn() -> bool, tell: fn(&str)) -> anyhow::Result<Option<Found>> {
    while !is_over() {
        match link.event_within(Duration::from_millis(20)) {
            Some(Event::Ready(found)) => return Ok(Some(found)),
            Some(Event::Lost(why)) => anyhow::bail!(why),
            Some(Event::Notice(text)) => tell(&text),
            None => {}
        }
    }
    Ok(None)
}

/// The link to a board, and the last content given to it.
#[derive(Debug)]
pub struct Player {
    pub link: Link,
    calibration: Calibration,
    /// The played elements of every drive, instead of all.
    pub part: Option<Range<usize>>,
    /// The performance, and its frames per second.
    played: Option<(Performance, f64)>,
    modulation: Option<Modulation>,
    /// Number of times that other threads silenced it.
    silenced: u64,
}

impl Player {
    /// Begins to look for the board. `notify` is called when the link has something new.
    ///
    /// # Errors
    /// The thread could not be started.
    pub fn open(
        settings: Settings,
        calibration: Calibration,
        notify: Box<dyn Fn() + Send + Sync>,
    ) -> io::Result<Self> {
        let link = Link::open(settings, notify)?;
        Ok(Self { link, calibration, part: None, played: None, modulation: None, silenced: 0 })
    }

    /// Whether other threads have silenced the board since the last call. Until the next, such a silence refuses what
    /// is played.
    pub fn was_silenced(&mut self) -> bool {
        let silenced = self.link.silenced();
        let is_new = std::mem::replace(&mut self.silenced, silenced) != silenced;
        if is_new {
            self.played = None;
        }
        is_new
    }

    /// Sets the envelope.
    ///
    /// # Errors
    /// An envelope that the board cannot play; it then keeps the one before.
    pub fn modulate(&mut self, modulation: &Modulation) -> Result<(), String> {
        envelope::playable(self.link.settings().profile, modulation)?;
        if self.modulation.as_ref() != Some(modulation) {
            self.modulation = Some(modulation.clone());
            self.link.modulate(modulation.clone());
        }
        Ok(())
    }

    /// Plays a scene from now on, unless it does so already. At the start, returns a notice about lost amplitudes.
    ///
    /// # Errors
    /// A scene that the board cannot play: the performance before it ends.
    pub fn play(&mut self, scene: &Scene, performance: Performance) -> Result<Option<String>, String> {
        let begun = self.begin(scene, performance);
        if begun.is_err() {
            self.rest();
        }
        begun
    }

    fn begin(&mut self, scene: &Scene, performance: Performance) -> Result<Option<String>, String> {
        let Settings { profile, .. } = *self.link.settings();
        profile.drives(scene).map_err(|error| error.to_string())?;
        self.modulate(&scene.modulation)?;
        let rate = match &performance {
            Performance::Still(solution) => {
                profile.turns_per_second(self.link.settings().baud(), 1 + solution.others.len())
            }
            Performance::Motion(_) => motion::cycle(scene).map_or(0.0, |cycle| cycle.frames_per_second()),
        };
        if self.played.as_ref().is_some_and(|(played, at)| *played == performance && *at == rate) {
            return Ok(None);
        }
        let mut drives = performance.drives();
        if let Some(part) = &self.part {
            drives.iter_mut().for_each(|drive| *drive = drive.part(part.clone()));
        }
        let frames = drives.iter().map(|drive| self.levels(drive)).collect::<Result<_, _>>();
        let frames = frames.map_err(|error| error.to_string())?;
        let notice = |drive| levels::amplitude_notice(profile, drive, &self.calibration);
        let notice = drives.iter().find_map(notice).filter(|_| self.played.is_none());
        self.show(match &performance {
            Performance::Still(_) => Content::in_turn(frames, rate),
            Performance::Motion(_) => Content::Motion { frames, rate },
        });
        self.played = Some((performance, rate));
        Ok(notice)
    }

    /// The levels of a drive, calibrated.
    ///
    /// # Errors
    /// An array of another size than the board's.
    pub fn levels(&self, drive: &Drive) -> Result<Levels, OtherCount> {
        Levels::new(self.link.settings().profile, drive, &self.calibration)
    }

    /// Shows content other than a scene's, such as a test pattern.
    pub fn show(&mut self, content: Content) {
        self.forget();
        self.link.show_unless_silenced(content, self.silenced);
    }

    /// Sends the next performance even if it is played already.
    pub fn forget(&mut self) {
        self.played = None;
    }

    /// Ends the performance, if any.
    pub fn rest(&mut self) {
        if self.played.is_some() {
            self.stop();
        }
    }

    /// Silences the board.
    pub fn stop(&mut self) {
        self.forget();
        self.link.stop();
    }
}
