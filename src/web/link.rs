//! The link to a board for JavaScript, and a virtual board.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::device::board::memory::VirtualBoard;
use crate::device::calibration::Calibration;
use crate::device::health::State;
use crate::device::levels::Levels;
use crate::device::link::survey::{self, Discovery};
use crate::device::link::{Content, Event, Settings};
use crate::device::port;
use crate::device::profile::Profile;
use crate::device::wiring::{Share, Wiring};
use crate::drive::Drive;
use crate::scene::{Scene, file};
use crate::solver;
use crate::studio::performance::Performance;
use crate::studio::player::Player;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

fn profile(name: &str) -> Result<Profile, JsError> {
    Profile::of_name(name).ok_or_else(|| JsError::new(&format!("{name} is no profile")))
}

/// Amplitude and phase (rad) of every element in turn.
fn in_turn(drive: &Drive) -> Vec<f64> {
    drive.amplitudes.iter().zip(&drive.phases).flat_map(|(&amplitude, &phase)| [amplitude, phase]).collect()
}

/// A virtual board: it accepts bytes and answers.
#[derive(Debug)]
#[wasm_bindgen]
pub struct Board {
    board: VirtualBoard,
    wiring: Wiring,
}

#[wasm_bindgen]
impl Board {
    /// A board of a profile, at its usual bit rate.
    ///
    /// # Errors
    /// An unknown profile.
    #[wasm_bindgen(constructor)]
    pub fn new(name: &str) -> Result<Self, JsError> {
        console_error_panic_hook::set_once();
        let profile = profile(name)?;
        Ok(Self { board: VirtualBoard::new(profile, profile.baud()), wiring: Wiring::own(profile) })
    }

    pub fn set_baud(&mut self, baud: u32) {
        self.board.set_baud(baud);
    }

    pub fn write(&mut self, bytes: &[u8]) {
        self.board.write(bytes);
    }

    pub fn read(&mut self) -> Vec<u8> {
        self.board.read()
    }

    /// Frames shown since the last call.
    pub fn frames(&mut self) -> usize {
        self.board.frames().len()
    }

    /// Amplitude and phase (rad) of every element in turn.
    pub fn playing(&mut self) -> Vec<f64> {
        in_turn(&self.wiring.drive(&self.board.playing().drive()))
    }
}

/// A scene, and the link that it goes over.
#[derive(Debug)]
#[wasm_bindgen]
pub struct Sender {
    player: Player,
    scene: Scene,
    profile: Profile,
}

#[wasm_bindgen]
impl Sender {
    /// Begins to look for a board of a profile at a port, for a scene file.
    ///
    /// # Errors
    /// An unknown profile, or an invalid scene.
    #[wasm_bindgen(constructor)]
    pub fn new(port: &str, name: &str, baud: Option<u32>, scene: &str) -> Result<Self, JsError> {
        let profile = profile(name)?;
        let scene = file::parse(scene, Path::new("scene.toml"))?;
        let settings = Settings { port: PathBuf::from(port), profile, baud };
        let player = Player::open(settings, Calibration::default(), Box::new(|| {}))?;
        Ok(Self { player, scene, profile })
    }

    /// The next message of the link, as text.
    pub fn event(&self) -> Option<String> {
        self.player.link.event().map(|event| match event {
            Event::Ready(found) => format!("ready at {}", found.baud),
            Event::Lost(why) => format!("lost: {why}"),
            Event::Notice(text) => text,
        })
    }

    /// Solves the scene and sends it, as `sonoglyph send` does; returns amplitude and phase (rad) of every element in
    /// turn.
    ///
    /// # Errors
    /// A scene that cannot be solved, or not played by the board.
    pub fn show(&mut self) -> Result<Vec<f64>, JsError> {
        let performance = Performance::Still(Arc::new(solver::solve(&self.scene)?));
        let levels = self.player.levels(&self.scene, performance.first());
        let levels = levels.map_err(|error| JsError::new(&error))?;
        self.player.forget();
        self.player.play(&self.scene, performance).map_err(|error| JsError::new(&error))?;
        Ok(in_turn(&Wiring::own(self.profile).drive(&levels.drive())))
    }

    /// One element alone.
    pub fn one(&mut self, element: usize) {
        let wiring = Wiring::of(self.profile, &self.scene, Share::default());
        let levels = wiring.map_or_else(|_| Levels::off(self.profile), |wiring| wiring.one(element));
        self.player.show(Content::Still(levels));
    }

    pub fn stop(&mut self) {
        self.player.stop();
    }

    pub fn is_ready(&self) -> bool {
        self.player.link.health().state == State::Ready
    }

    pub fn is_in_place(&self) -> bool {
        self.player.link.health().in_place
    }

    /// Frames, retransmissions, losses; then medians and jitters (ms) of the way to the board and back, of the way from a wish to its
    /// last byte, and of half periods of a modulation by swaps.
    pub fn figures(&self) -> Vec<f64> {
        let health = self.player.link.health();
        let spread = [health.round_trip, health.latency, health.swaps].into_iter().flat_map(|spread| {
            let spread = spread.unwrap_or_default();
            [spread.median, spread.jitter].map(|time| 1e3 * time.as_secs_f64())
        });
        [health.frames as f64, health.refused as f64, health.found as f64].into_iter().chain(spread).collect()
    }
}

/// The name of the port chosen by the user, which requires a preceding click.
///
/// # Errors
/// A browser that denies ports.
#[wasm_bindgen]
pub async fn choose() -> Result<Option<String>, JsError> {
    Ok(port::choose().await?.map(|path| path.display().to_string()))
}

/// Names of the ports that this page may use.
///
/// # Errors
/// A browser without an answer.
#[wasm_bindgen]
pub async fn ports() -> Result<Vec<String>, JsError> {
    Ok(port::available().await?.iter().map(ToString::to_string).collect())
}

/// Identification and error figures at each bit rate, a line each.
///
/// # Errors
/// A port that cannot be opened, or no answer.
#[wasm_bindgen]
pub async fn survey(port: &str) -> Result<Vec<String>, JsError> {
    let mut found = Vec::new();
    let tell = &mut |discovery| {
        found.push(match discovery {
            Discovery::Board(info, _) => format!("protocol {}, {} channels", info.protocol, info.channels),
            Discovery::Rate(trial) => {
                let is_clean = if trial.is_clean() { "clean" } else { "not clean" };
                format!("{}: {:?}, {is_clean}", trial.baud, trial.outcome)
            }
        });
    };
    survey::survey(Path::new(port), tell).await?;
    Ok(found)
}

/// Fails like a faulty program, for tests of the page's reaction.
#[wasm_bindgen]
pub fn fail() {
    panic!("on purpose");
}
