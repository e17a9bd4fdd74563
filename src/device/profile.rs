//! Profiles: the supported boards and their facts.

mod acoustophoretic;
mod mega64;
mod phase_list;

use crate::device::declaration::{Declaration, Strength};
use crate::scene::{Scene, Turns};

macro_rules! boards {
    ($($(#[$doc:meta])* $board:ident: $declaration:expr,)*) => {
        /// A kind of board.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Profile {
            /// Several native boards on one line, 2 to [`MOST_DEVICES`], with addresses from 0.
            Natives(u8),
            $($(#[$doc])* $board,)*
        }

        impl Profile {
            /// The kinds of boards; several native boards are not a separate kind.
            pub const ALL: [Self; [$(stringify!($board)),*].len()] = [$(Self::$board),*];

            pub(in crate::device) fn declaration(self) -> &'static Declaration {
                match self {
                    Self::Natives(_) => &NATIVE,
                    $(Self::$board => &const { $declaration },)*
                }
            }
        }
    };
}

boards! {
    /// The gateware of this repository: CRC, answers, watchdog, amplitudes, modulation, sequences.
    Native: NATIVE,
    /// One SonicSurface of 16 x 16.
    SonicSurface: phase_list::SONICSURFACE,
    /// Two SonicSurface boards on one line.
    SonicSurface2: phase_list::SONICSURFACE_2,
    /// One with the gateware for tactile modulation.
    SonicSurfaceTactile: phase_list::SONICSURFACE_TACTILE,
    /// Ultraino's FPGA of 256 channels.
    UltrainoSimpleFpga: phase_list::ULTRAINO_SIMPLEFPGA,
    /// Ultraino's Arduino Mega of 64 channels.
    UltrainoMega64: mega64::ULTRAINO_MEGA64,
    /// UCL's and OpenMPD's board of 16 x 16.
    Acoustophoretic512: acoustophoretic::ACOUSTOPHORETIC_512,
}

/// One native board; several have as many times its elements and bytes.
const NATIVE: Declaration = Declaration {
    name: "native",
    title: "This project's FPGA board",
    elements: 256,
    shape: None,
    levels: 256,
    strength: Strength::Linear(255),
    baud: 2_000_000,
    frame_bytes: 270,
    order: None,
    remark: None,
    uncalibrated: None,
    protocol: None,
};

/// Limit of native devices per line.
pub const MOST_DEVICES: u8 = 8;
const NATIVES: [&str; 7] =
    ["native-2", "native-3", "native-4", "native-5", "native-6", "native-7", "native-8"];
const TITLES: [&str; 7] = [
    "2 x this project's FPGA board",
    "3 x this project's FPGA board",
    "4 x this project's FPGA board",
    "5 x this project's FPGA board",
    "6 x this project's FPGA board",
    "7 x this project's FPGA board",
    "8 x this project's FPGA board",
];

impl Profile {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        if let Self::Natives(count) = self {
            return NATIVES[usize::from(count).clamp(2, NATIVES.len() + 1) - 2];
        }
        self.declaration().name
    }

    /// The name that its users know.
    #[doc(hidden)]
    pub fn title(self) -> &'static str {
        if let Self::Natives(count) = self {
            return TITLES[usize::from(count).clamp(2, TITLES.len() + 1) - 2];
        }
        self.declaration().title
    }

    /// The user's choices: every kind, and every number of native boards.
    pub fn choices() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().chain((2..=MOST_DEVICES).map(Self::Natives))
    }

    /// The board of a name, in upper or lower case.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::choices().find(|profile| profile.name().eq_ignore_ascii_case(name))
    }

    /// Transducers, of all boards on the line.
    pub fn elements(self) -> usize {
        self.declaration().elements * self.devices().max(1)
    }

    /// Native devices on the line; 0 for other boards.
    pub fn devices(self) -> usize {
        if let Self::Natives(count) = self {
            return count.into();
        }
        self.declaration().protocol.is_none().into()
    }

    /// Whether it answers and acknowledges.
    pub fn answers(self) -> bool {
        self.devices() > 0
    }

    /// Whether it sends back commands, which shows that it is there, but not what it plays.
    pub(crate) fn echoes(self) -> bool {
        self.declaration().protocol.as_ref().is_some_and(|protocol| protocol.echo.is_some())
    }

    /// Columns and rows if the transducers are on the board; `None` if channels are wired to any array of at most as
    /// many elements.
    pub fn shape(self) -> Option<[u32; 2]> {
        self.declaration().shape
    }

    /// Number of delays per period.
    pub fn levels(self) -> u16 {
        self.declaration().levels
    }

    pub fn strength(self) -> Strength {
        self.declaration().strength
    }

    /// Bit rate after power-up.
    pub fn baud(self) -> u32 {
        self.declaration().baud
    }

    /// Hz. A native board reports its own.
    pub fn carrier(self) -> f64 {
        40_000.0
    }

    /// Bytes of a frame at full amplitude.
    pub fn frame_bytes(self) -> usize {
        self.declaration().frame_bytes * self.devices().max(1)
    }

    /// The line's frame rate with 8 data bits, a start and a stop bit.
    pub fn frames_per_second(self, baud: u32) -> f64 {
        f64::from(baud) / 10.0 / self.frame_bytes() as f64
    }

    /// Frames per second of so many drives in turn: the line's rate, limited by a transducer's ringing of some 0.3 ms.
    pub fn turns_per_second(self, baud: u32, drives: usize) -> f64 {
        const MOST: f64 = 1000.0;
        let has_two_buffers =
            self.declaration().protocol.as_ref().is_some_and(|protocol| protocol.swap.is_some());
        let keeps_them = self.answers() || has_two_buffers && drives <= 2;
        if keeps_them { MOST } else { self.frames_per_second(baud).min(MOST) }
    }

    /// Gives areas one drive if the board cannot change drives so fast that their mean counts, and says so.
    pub fn steady(self, scene: &mut Scene, baud: u32) -> Option<String> {
        /// Changes per second: cycles of six drives at 100 Hz.
        const LEAST: f64 = 600.0;
        let drives = *scene.drives_in_turn().end();
        let rate = self.turns_per_second(baud, drives);
        if scene.solver.frames != Turns::Auto || rate >= LEAST || drives == 1 {
            return None;
        }
        scene.solver.frames = Turns::Count(1);
        Some(format!(
            "{} shows {rate:.0} drives per second at {baud} baud, and alternating drives need {LEAST}: areas use a single drive",
            self.name()
        ))
    }

    /// The table of its channels in `assets/wirings`; without, channel n is element n.
    pub(in crate::device) fn order(self) -> Option<&'static str> {
        self.declaration().order
    }

    /// A warning for the user who plays it without a calibration.
    pub fn uncalibrated(self) -> Option<&'static str> {
        self.declaration().uncalibrated
    }

    /// A remark for the user before sending.
    pub fn remark(self) -> Option<&'static str> {
        self.declaration().remark
    }

    /// "89 frames/s at 230400 baud"
    pub fn bandwidth(self, baud: u32) -> String {
        format!("{:.0} frames/s at {baud} baud", self.frames_per_second(baud).floor())
    }
}
