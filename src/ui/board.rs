//! The board in the window: the user's wishes, and the board's state.

use std::path::PathBuf;

use crate::device::health::{Found, Health};
use crate::device::profile::Profile;
use crate::ui::bring_up::{BringUp, Surveyed};

/// The settings on the Device page.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardForm {
    /// The port as typed.
    pub port: String,
    /// The port of the program's own virtual board, instead.
    pub virtual_port: Option<String>,
    pub profile: Profile,
    /// 0: the default baud rate.
    pub baud: u32,
    /// A CSV file, or empty.
    pub calibration: String,
    /// Whether every change of the scene is sent at once.
    pub live: bool,
    /// The element tested alone.
    pub element: u32,
    /// The board is being brought up.
    pub bring_up: Option<Box<BringUp>>,
}

impl Default for BoardForm {
    fn default() -> Self {
        Self {
            port: String::new(),
            virtual_port: None,
            profile: Profile::Native,
            baud: 0,
            calibration: String::new(),
            live: true,
            element: 0,
            bring_up: None,
        }
    }
}

impl BoardForm {
    pub fn port(&self) -> &str {
        self.virtual_port.as_deref().unwrap_or(self.port.trim())
    }

    pub fn baud(&self) -> Option<u32> {
        (self.baud > 0).then_some(self.baud)
    }

    pub fn calibration(&self) -> Option<PathBuf> {
        let name = self.calibration.trim();
        (!name.is_empty()).then(|| PathBuf::from(name))
    }
}

/// Source of ports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ports {
    /// This computer's ports, with names to type.
    #[default]
    Computer,
    /// Ports permitted to this page in a dialog of the browser.
    Browser,
    /// The browser has no ports for pages.
    Nowhere,
}

impl Ports {
    /// The first step before opening a port, as text.
    pub fn first(self) -> &'static str {
        match self {
            Self::Computer => "Name a port first",
            Self::Browser => "Choose a port first",
            Self::Nowhere => "This browser has no serial ports for pages",
        }
    }
}

/// The commands of the Device page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BoardCommand {
    ListPorts,
    /// Opens the browser's port dialog.
    ChoosePort,
    Connect,
    Disconnect,
    /// Starts a virtual board of the chosen kind and connects to it.
    TryWithout,
    /// The scene at rest, once.
    Send,
    /// All frames of the motion, over and over.
    PlayMotion,
    Stop,
    /// One element alone.
    One,
    /// Neighbours in antiphase.
    Checkerboard,
    /// Adopts the board's carrier in the scene.
    TakeCarrier,
    /// Surveys the port: identification and bit rates; closes the link.
    Survey,
    /// A focus above the centre.
    Focus,
    /// A calibration, as a file's text, is written and used.
    SaveCalibration(String),
}

impl BoardCommand {
    /// Whether a silent board sounds afterwards.
    pub fn sounds(&self) -> bool {
        match self {
            Self::Send | Self::PlayMotion | Self::One | Self::Checkerboard | Self::Focus => true,
            Self::ListPorts
            | Self::ChoosePort
            | Self::Connect
            | Self::Disconnect
            | Self::TryWithout
            | Self::Stop
            | Self::TakeCarrier
            | Self::Survey
            | Self::SaveCalibration(_) => false,
        }
    }
}

/// The board's current activity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plays {
    #[default]
    Nothing,
    Scene,
    Motion,
    One(u32),
    Checkerboard,
    Focus,
}

/// A port to choose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortShown {
    pub name: String,
    /// Including the system's description.
    pub label: String,
    /// Profile of a virtual board.
    pub profile: Option<Profile>,
}

/// The board's known state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoardShown {
    pub ports: Vec<PortShown>,
    pub ports_from: Ports,
    /// The reason for missing board support in this program.
    pub unavailable: Option<String>,
    /// Result of the bring-up's survey; `None` while it runs.
    pub surveyed: Option<Surveyed>,
    /// Present once a port is being opened.
    pub health: Option<Health>,
    pub found: Option<Found>,
    pub plays: Plays,
    /// A word about areas that have one drive on this board.
    pub steadied: Option<String>,
    /// The latest last.
    pub messages: Vec<String>,
    /// Mean pressure over the foci (Pa, peak) of the drive, and of its version on the board.
    pub pressures: Option<(f64, f64)>,
}
