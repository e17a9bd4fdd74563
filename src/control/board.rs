//! The board that plays the remotely controlled scene.

use std::sync::Arc;

use web_time::Duration;

use crate::control::report::BoardReport;
use crate::device::calibration::Calibration;
use crate::device::envelope;
use crate::device::health::{Found, Health};
use crate::device::levels::{self, Levels};
use crate::device::link::{Content, Event, Link, Settings};
use crate::drive::Drive;
use crate::scene::{Modulation, Scene, motion};
use crate::solver::Solution;
use crate::solver::frames::Sequence;
use crate::studio::felt::Offer;
use crate::studio::output::{note, warn};

/// Content for a board.
#[derive(Clone, Debug)]
pub enum Play {
    Still(Arc<Solution>),
    Motion(Arc<Sequence>),
}

impl Play {
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Still(a), Self::Still(b)) => Arc::ptr_eq(a, b),
            (Self::Motion(a), Self::Motion(b)) => Arc::ptr_eq(a, b),
            (Self::Still(_), Self::Motion(_)) | (Self::Motion(_), Self::Still(_)) => false,
        }
    }
}

#[derive(Debug)]
pub struct Board {
    link: Link,
    calibration: Calibration,
    /// Hz.
    carrier: f64,
    /// The last content sent, and its frame rate.
    played: Option<(Play, f64)>,
    modulation: Option<Modulation>,
    /// The modulation last offered for a scene that is hardly felt.
    offer: Option<Offer>,
    /// Number of times that others silenced it.
    silenced: u64,
    /// Whether the emergency stop silences it.
    is_stopped: bool,
    /// The last word about areas with one drive.
    steadied: Option<String>,
}

impl Board {
    /// The board at a port, once found; `None` if the wait was cancelled.
    ///
    /// # Errors
    /// A board that is not there.
    pub fn open(
        settings: Settings,
        calibration: Calibration,
        is_over: impl Fn() -> bool,
    ) -> anyhow::Result<Option<Self>> {
        note(&settings.profile.bandwidth(settings.baud()));
        let link = Link::open(settings, Box::new(|| {}))?;
        loop {
            match link.event_within(Duration::from_millis(20)) {
                Some(Event::Ready(Found { carrier, .. })) => {
                    note_carrier(carrier);
                    return Ok(Some(Self {
                        link,
                        calibration,
                        carrier,
                        played: None,
                        modulation: None,
                        offer: None,
                        silenced: 0,
                        is_stopped: false,
                        steadied: None,
                    }));
                }
                Some(Event::Lost(why)) => anyhow::bail!(why),
                Some(Event::Notice(text)) => note(&text),
                None if is_over() => return Ok(None),
                None => {}
            }
        }
    }

    /// Silences it from other threads, even while this one is busy.
    pub fn silencer(&self) -> Box<dyn Fn() + Send + Sync> {
        let silencer = self.link.silencer();
        Box::new(move || silencer.silence())
    }

    /// Processes the link's messages. What is played afterwards is refused if it was silenced meanwhile.
    pub fn attend(&mut self) {
        let silenced = self.link.silenced();
        if std::mem::replace(&mut self.silenced, silenced) != silenced {
            self.played = None;
        }
        while let Some(event) = self.link.event() {
            match event {
                Event::Ready(Found { carrier, .. }) => {
                    note("the board is back");
                    if std::mem::replace(&mut self.carrier, carrier) != carrier {
                        note_carrier(carrier);
                    }
                }
                Event::Lost(why) => warn(&format!("{why}; looking for it")),
                Event::Notice(text) => note(&text),
            }
        }
    }

    /// Gives a scene the board's carrier, and areas one drive if the board is slow.
    pub fn tune(&mut self, scene: &mut Scene) {
        scene.array.frequency = self.carrier;
        let (profile, baud) = (self.link.settings().profile, self.link.settings().baud());
        let text = profile.steady(scene, baud);
        if text != self.steadied {
            text.iter().for_each(|text| note(text));
            self.steadied = text;
        }
    }

    /// Whether its emergency stop was pressed since the last call.
    pub fn was_stopped(&mut self) -> bool {
        let is_stopped = self.link.health().stopped;
        !std::mem::replace(&mut self.is_stopped, is_stopped) && is_stopped
    }

    pub fn stop(&mut self) {
        if self.played.take().is_some() {
            self.link.stop();
        }
    }

    /// From now on it plays this.
    ///
    /// # Errors
    /// Content that this board cannot play: it is then silent.
    pub fn play(&mut self, scene: &Scene, play: Play) -> Result<(), String> {
        self.offer(scene, matches!(play, Play::Motion(_)));
        let made = self.prepare(scene, play);
        if made.is_err() {
            self.stop();
        }
        made
    }

    /// Says once that a scene is hardly felt.
    fn offer(&mut self, scene: &Scene, moves: bool) {
        let Settings { profile, .. } = *self.link.settings();
        let offer = Offer::new(scene, moves, profile, self.link.settings().baud());
        if let Some(offer) = offer.filter(|_| self.offer != offer) {
            note(&offer.to_string());
        }
        self.offer = offer;
    }

    fn prepare(&mut self, scene: &Scene, play: Play) -> Result<(), String> {
        let (profile, baud) = (self.link.settings().profile, self.link.settings().baud());
        profile.drives(scene).map_err(|error| error.to_string())?;
        envelope::playable(profile, &scene.modulation)?;
        if self.modulation.as_ref() != Some(&scene.modulation) {
            self.modulation = Some(scene.modulation.clone());
            self.link.modulate(scene.modulation.clone());
        }
        let rate = match &play {
            Play::Still(_) => profile.turns_per_second(baud),
            Play::Motion(_) => motion::cycle(scene).map_or(0.0, |cycle| cycle.frames_per_second()),
        };
        if self.played.as_ref().is_some_and(|(played, at)| played.is(&play) && *at == rate) {
            return Ok(());
        }
        let levels =
            |drive: &Drive| Levels::new(profile, drive, &self.calibration).map_err(|error| error.to_string());
        let content = match &play {
            Play::Still(solution) => {
                let frames: Result<_, _> = solution.drives().iter().map(levels).collect();
                Content::in_turn(frames?, rate)
            }
            Play::Motion(sequence) => {
                let frames: Result<_, _> = sequence.frames.iter().map(|frame| levels(&frame.drive)).collect();
                Content::Motion { frames: frames?, rate }
            }
        };
        if self.played.is_none()
            && let Play::Still(solution) = &play
        {
            let notice = levels::amplitude_notice(profile, &solution.drive, &self.calibration);
            notice.iter().for_each(|notice| warn(notice));
        }
        self.link.show_unless_silenced(content, self.silenced);
        self.played = Some((play, rate));
        Ok(())
    }

    pub fn report(&self) -> BoardReport {
        let Settings { port, profile, .. } = self.link.settings();
        BoardReport { port: port.display().to_string(), profile: profile.name(), health: self.link.health() }
    }

    /// Closes the link, silencing the board if possible.
    pub fn close(self) -> Health {
        self.link.close()
    }
}

fn note_carrier(carrier: f64) {
    note(&format!("the board's carrier is {carrier} Hz; scenes are solved for it"));
}
