//! The player: brings a performance to a board. Window, `serve`, `send` and the page play through it.

use std::io;

#[cfg(not(target_arch = "wasm32"))]
use web_time::Duration;

use crate::device::calibration::Calibration;
use crate::device::envelope;
#[cfg(not(target_arch = "wasm32"))]
use crate::device::health::Found;
use crate::device::levels::{self, Levels};
#[cfg(not(target_arch = "wasm32"))]
use crate::device::link::Event;
use crate::device::link::{Content, Link, Settings};
use crate::device::wiring::{Share, Wiring};
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
    /// The part of a scene's boards at this port.
    pub share: Share,
    played: Option<Played>,
    modulation: Option<Modulation>,
    /// Number of times that other threads silenced it.
    silenced: u64,
}

/// The notice about several boards with the corrections of one.
const ONE_FILE: &str = "every board of the scene is played with the corrections of the same file: give each board its own, in \
                        the scene's order, with `--calibration`";

/// What a board plays.
#[derive(Clone, Debug, PartialEq)]
struct Played {
    performance: Performance,
    /// Frames per second.
    rate: f64,
    wiring: Wiring,
    calibration: Calibration,
}

impl Player {
    /// Begins to look for the board. `calibration` is that of a scene's elements; if it is empty, the corrections of the
    /// scene's own files apply. `notify` is called when the link has something new.
    ///
    /// # Errors
    /// The thread could not be started.
    pub fn open(
        settings: Settings,
        calibration: Calibration,
        notify: Box<dyn Fn() + Send + Sync>,
    ) -> io::Result<Self> {
        let link = Link::open(settings, notify)?;
        Ok(Self { link, calibration, share: Share::default(), played: None, modulation: None, silenced: 0 })
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

    /// Sets the envelope of a carrier (Hz).
    ///
    /// # Errors
    /// An envelope that the board cannot play; it then keeps the one before.
    pub fn modulate(&mut self, modulation: &Modulation, carrier: f64) -> Result<(), String> {
        envelope::playable(self.link.settings().profile, modulation, carrier)?;
        if self.modulation.as_ref() != Some(modulation) {
            self.modulation = Some(modulation.clone());
            self.link.modulate(modulation.clone());
        }
        Ok(())
    }

    /// Plays a scene from now on, unless it does so already. At the start, returns notices about lost amplitudes and a
    /// missing calibration.
    ///
    /// # Errors
    /// A scene that the board cannot play: the performance before it ends.
    pub fn play(&mut self, scene: &Scene, performance: Performance) -> Result<Vec<String>, String> {
        let begun = self.begin(scene, performance);
        if begun.is_err() {
            self.rest();
        }
        begun
    }

    fn begin(&mut self, scene: &Scene, performance: Performance) -> Result<Vec<String>, String> {
        let Settings { profile, .. } = *self.link.settings();
        let wiring = self.wiring(scene)?;
        if matches!(performance, Performance::Motion(_)) {
            envelope::plays(profile, scene)?;
        }
        self.modulate(scene.envelope(), scene.array.frequency)?;
        let rate = match &performance {
            Performance::Still(solution) => {
                profile.turns_per_second(self.link.settings().baud(), 1 + solution.others.len())
            }
            Performance::Motion(_) => motion::cycle(scene).map_or(0.0, |cycle| cycle.frames_per_second()),
        };
        let calibration = self.calibration(scene);
        let wanted = Played { performance, rate, wiring, calibration };
        if self.played.as_ref() == Some(&wanted) {
            return Ok(Vec::new());
        }
        let is_first = self.played.is_none();
        let Played { performance, wiring, calibration, .. } = &wanted;
        let drives = performance.drives();
        let frames = drives.iter().map(|drive| wiring.levels(drive, calibration)).collect::<Result<_, _>>();
        let frames = frames.map_err(|error| error.to_string())?;
        let weak = drives.iter().find_map(|drive| levels::amplitude_notice(profile, drive, calibration));
        let raw = profile.uncalibrated().filter(|_| calibration.elements() == 0).map(str::to_owned);
        let is_shared =
            scene.boards.len() > 1 && self.calibration.elements() == 0 && calibration.elements() > 0;
        let shared = is_shared.then(|| ONE_FILE.to_owned());
        let notices = weak.into_iter().chain(raw).chain(shared).filter(|_| is_first).collect();
        self.show(match performance {
            Performance::Still(_) => Content::in_turn(frames, rate),
            Performance::Motion(_) => Content::Motion { frames, rate },
        });
        self.played = Some(wanted);
        Ok(notices)
    }

    /// The wiring of a scene to the board.
    ///
    /// # Errors
    /// An array that the board cannot play.
    fn wiring(&self, scene: &Scene) -> Result<Wiring, String> {
        Wiring::of(self.link.settings().profile, scene, self.share).map_err(|error| error.to_string())
    }

    /// The calibration of a scene's elements.
    fn calibration(&self, scene: &Scene) -> Calibration {
        match self.calibration.elements() {
            0 => Calibration::of(scene),
            _ => self.calibration.clone(),
        }
    }

    /// The levels of a scene's drive, calibrated.
    ///
    /// # Errors
    /// An array that the board cannot play, or a drive of another.
    pub fn levels(&self, scene: &Scene, drive: &Drive) -> Result<Levels, String> {
        let levels = self.wiring(scene)?.levels(drive, &self.calibration(scene));
        levels.map_err(|error| error.to_string())
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
