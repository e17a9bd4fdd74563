//! The board that plays the remotely controlled scene.

use crate::control::report::BoardReport;
use crate::device::calibration::Calibration;
use crate::device::health::{Found, Health};
use crate::device::link::{Event, Settings};
use crate::scene::Scene;
use crate::studio::felt::Offer;
use crate::studio::output::{note, warn};
use crate::studio::performance::Performance;
use crate::studio::player::{self, Player};

#[derive(Debug)]
pub struct Board {
    player: Player,
    /// Hz.
    carrier: f64,
    /// The modulation last offered for a scene that is hardly felt.
    offer: Option<Offer>,
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
        let player = Player::open(settings, calibration, Box::new(|| {}))?;
        let Some(Found { carrier, .. }) = player::ready(&player.link, is_over, note)? else {
            return Ok(None);
        };
        note_carrier(carrier);
        Ok(Some(Self { player, carrier, offer: None, is_stopped: false, steadied: None }))
    }

    /// Silences it from other threads, even while this one is busy.
    pub fn silencer(&self) -> Box<dyn Fn() + Send + Sync> {
        let silencer = self.player.link.silencer();
        Box::new(move || silencer.silence())
    }

    /// Processes the link's messages. What is played afterwards is refused if it was silenced meanwhile. Returns
    /// whether the emergency stop was pressed since the last call.
    pub fn attend(&mut self) -> bool {
        self.player.was_silenced();
        while let Some(event) = self.player.link.event() {
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
        let is_stopped = self.player.link.health().stopped;
        !std::mem::replace(&mut self.is_stopped, is_stopped) && is_stopped
    }

    /// Gives a scene the board's carrier, and areas one drive if the board is slow.
    pub fn tune(&mut self, scene: &mut Scene) {
        scene.array.frequency = self.carrier;
        let settings = self.player.link.settings();
        let text = settings.profile.steady(scene, settings.baud());
        if text != self.steadied {
            text.iter().for_each(|text| note(text));
            self.steadied = text;
        }
    }

    pub fn stop(&mut self) {
        self.player.rest();
    }

    /// Plays this from now on.
    ///
    /// # Errors
    /// A scene that this board cannot play: it is then silent.
    pub fn play(&mut self, scene: &Scene, performance: Performance) -> Result<(), String> {
        self.offer(scene, matches!(performance, Performance::Motion(_)));
        let notices = self.player.play(scene, performance)?;
        notices.iter().for_each(|notice| warn(notice));
        Ok(())
    }

    /// Says once that a scene is hardly felt.
    fn offer(&mut self, scene: &Scene, moves: bool) {
        let settings = self.player.link.settings();
        let offer = Offer::new(scene, moves, settings.profile, settings.baud());
        if let Some(offer) = offer.filter(|_| self.offer != offer) {
            note(&offer.to_string());
        }
        self.offer = offer;
    }

    pub fn report(&self) -> BoardReport {
        let Settings { port, profile, .. } = self.player.link.settings();
        let health = self.player.link.health();
        BoardReport { port: port.display().to_string(), profile: profile.name(), health }
    }

    /// Closes the link, silencing the board if possible.
    pub fn close(self) -> Health {
        self.player.link.close()
    }
}

fn note_carrier(carrier: f64) {
    note(&format!("the board's carrier is {carrier} Hz; scenes are solved for it"));
}
