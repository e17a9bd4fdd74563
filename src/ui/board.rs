//! The board in the window: the user's wishes, and the board's state.

use std::collections::HashMap;
use std::path::PathBuf;

use crate::device::health::{Found, Health, State};
use crate::device::port;
use crate::device::profile::Profile;
use crate::studio::figure::capital;
use crate::ui::bring_up::{BringUp, KeptTest, Surveyed};

/// The settings on the Device page.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardForm {
    /// The port as typed.
    pub port: String,
    /// The port of the program's own virtual board, instead.
    pub virtual_port: Option<String>,
    pub profile: Profile,
    /// Bits per second that the user chose for a kind of board; the others have their own.
    pub rates: HashMap<Profile, u32>,
    /// A CSV file, or empty.
    pub calibration: String,
    /// Whether every change of the scene is sent at once.
    pub live: bool,
    /// The element tested alone.
    pub element: u32,
    /// The board is being tested.
    pub bring_up: Option<Box<BringUp>>,
    /// Tests that were left, each of a board at a port.
    pub tests: Vec<KeptTest>,
}

impl Default for BoardForm {
    fn default() -> Self {
        Self {
            port: String::new(),
            virtual_port: None,
            profile: Profile::Native,
            rates: HashMap::new(),
            calibration: String::new(),
            live: true,
            element: 0,
            bring_up: None,
            tests: Vec::new(),
        }
    }
}

impl BoardForm {
    pub fn port(&self) -> &str {
        self.virtual_port.as_deref().unwrap_or(self.port.trim())
    }

    /// The bit rate of this kind of board, if not its default: that of a test at this port, or as chosen.
    pub fn baud(&self) -> Option<u32> {
        let run = self.bring_up.as_deref().or_else(|| self.kept_test().map(|kept| &kept.run));
        run.and_then(|run| run.baud).or_else(|| self.rates.get(&self.profile).copied())
    }

    /// Chooses the bit rate of this kind of board; `None`: its default.
    pub fn set_baud(&mut self, baud: Option<u32>) {
        let profile = self.profile;
        match baud {
            Some(baud) => drop(self.rates.insert(profile, baud)),
            None => drop(self.rates.remove(&profile)),
        }
        let kept = self.test_place().and_then(|place| self.tests.get_mut(place));
        let kept = kept.map(|kept| &mut kept.run);
        kept.into_iter().chain(self.bring_up.as_deref_mut()).for_each(|run| run.baud = None);
    }

    fn test_place(&self) -> Option<usize> {
        self.tests.iter().position(|kept| kept.profile == self.profile && kept.port == self.port())
    }

    /// The test that was left of this board at this port.
    pub fn kept_test(&self) -> Option<&KeptTest> {
        self.test_place().map(|place| &self.tests[place])
    }

    /// The same, to be continued.
    pub fn take_test(&mut self) -> Option<KeptTest> {
        self.test_place().map(|place| self.tests.remove(place))
    }

    /// Leaves the running test; its results are kept.
    pub fn leave_test(&mut self) {
        let Some(run) = self.bring_up.take() else { return };
        if run.has_results() {
            self.take_test();
            self.tests.push(KeptTest { port: self.port().to_owned(), profile: self.profile, run: *run });
        }
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
            Self::Computer => "Choose or type a port first",
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
    /// Something was to be sent, but there is no board.
    AskForBoard,
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
    /// A test has ended or is left: silences the board.
    EndTest,
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
            | Self::AskForBoard
            | Self::Stop
            | Self::TakeCarrier
            | Self::Survey
            | Self::EndTest
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

/// The reason for not having a board, as a sentence for the window.
pub fn absence(why: &str, was_found: bool) -> String {
    match why.strip_suffix(port::LISTED) {
        Some(missing) => {
            let missing = missing.replacen("there", "There", 1);
            format!("{missing}. Plug the board in, or press “Choose…” for the ports of this computer.")
        }
        None if was_found => format!("The board is lost: {why}"),
        None => format!("No board answers: {why}"),
    }
}

/// The notice of a Send without a board.
const MISSING: &str =
    "No board is connected: choose a port, or try a virtual board with “Try without a board”";

/// Keys of files in messages, and their names in the window.
const KEYS: [(&str, &str); 3] = [
    ("`array.wiring` names", "“Wiring” on the Scene page names"),
    ("name it as the scene's `array.elements`", "take it as the element table on the Scene page"),
    ("modulation.shape = ", "the shape "),
];

/// A message as a sentence for the window: with the board's title, and a capital unless it begins with a file's name.
pub fn sentence(text: &str) -> String {
    let text = KEYS.iter().fold(text.to_owned(), |text, (key, name)| text.replace(key, name));
    let text = Profile::choices().fold(text, |text, profile| {
        text.replace(&format!(" {} is ", profile.name()), &format!(" {} is ", profile.title()))
    });
    let named = Profile::choices().find_map(|profile| {
        let rest = text.strip_prefix(profile.name())?;
        rest.starts_with([' ', ':']).then(|| format!("{}{rest}", profile.title()))
    });
    let is_word = text.split(' ').next().is_some_and(|word| word.chars().all(char::is_alphabetic));
    named.unwrap_or_else(|| if is_word { capital(&text) } else { text })
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

impl BoardShown {
    /// The reason for not sending, as a sentence for the window.
    pub fn missing(&self) -> String {
        match &self.health {
            Some(Health { state: State::Lost(why), found, .. }) => absence(why, *found > 0),
            Some(_) | None => self.unavailable.clone().unwrap_or_else(|| MISSING.to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_begin_with_a_title_or_a_capital() {
        for (text, sentence_of_it) in [
            ("sonicsurface-2: slow", "2 x SonicSurface: slow"),
            ("sonicsurface has no amplitudes", "SonicSurface has no amplitudes"),
            ("the sound is steady", "The sound is steady"),
            ("calibration.csv: not found", "calibration.csv: not found"),
        ] {
            assert_eq!(sentence(text), sentence_of_it);
        }
    }
}
