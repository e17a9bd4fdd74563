//! Profiles: the supported boards and their facts.

use crate::scene::{Scene, Turns};

/// A kind of board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Profile {
    /// The gateware of this repository: CRC, answers, watchdog, amplitudes, modulation, sequences.
    Native,
    /// Several native boards on one line, 2 to [`MOST_DEVICES`], with addresses from 0.
    Natives(u8),
    /// One SonicSurface of 16 x 16.
    SonicSurface,
    /// Two SonicSurface boards on one line.
    SonicSurface2,
    /// One with the gateware for tactile modulation.
    SonicSurfaceTactile,
    /// Ultraino's FPGA of 256 channels.
    UltrainoSimpleFpga,
    /// Ultraino's Arduino Mega of 64 channels.
    UltrainoMega64,
    /// UCL's and OpenMPD's board of 16 x 16.
    Acoustophoretic512,
}

/// Limit of native devices per line.
pub const MOST_DEVICES: u8 = 8;
const NATIVES: [&str; 7] =
    ["native-2", "native-3", "native-4", "native-5", "native-6", "native-7", "native-8"];

/// The amplitude control of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strength {
    /// None: an element is on or off.
    Fixed,
    /// A number up to this, proportional to the sound.
    Linear(u16),
    /// A pulse length up to this many levels, which is half a period; the sound follows the sine of the length.
    Duty(u16),
}

/// An array that does not match the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}, and {} {}", own(*boards, array, *elements), profile.name(), profile.size())]
pub struct OtherArray {
    pub profile: Profile,
    /// Of the scene.
    pub boards: usize,
    /// Columns and rows of the scene's array, if any.
    pub array: Option<[u32; 2]>,
    /// Of all boards.
    pub elements: usize,
}

/// A scene's array, as text.
fn own(boards: usize, array: &Option<[u32; 2]>, elements: usize) -> String {
    match (boards, array) {
        (1, Some([columns, rows])) => {
            format!("the scene's array has {columns} x {rows} elements (columns x rows)")
        }
        (_, Some([columns, rows])) => {
            format!("the scene has {boards} boards of {columns} x {rows} elements (columns x rows)")
        }
        (_, None) => format!("the scene's table of elements makes {elements} in all"),
    }
}

impl Profile {
    /// The kinds of boards; several native boards are not a separate kind.
    pub const ALL: [Self; 7] = [
        Self::Native,
        Self::SonicSurface,
        Self::SonicSurface2,
        Self::SonicSurfaceTactile,
        Self::UltrainoSimpleFpga,
        Self::UltrainoMega64,
        Self::Acoustophoretic512,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            Self::Natives(count) => NATIVES[usize::from(count).clamp(2, NATIVES.len() + 1) - 2],
            Self::SonicSurface => "sonicsurface",
            Self::SonicSurface2 => "sonicsurface-2",
            Self::SonicSurfaceTactile => "sonicsurface-tactile",
            Self::UltrainoSimpleFpga => "ultraino-simplefpga",
            Self::UltrainoMega64 => "ultraino-mega64",
            Self::Acoustophoretic512 => "acoustophoretic-512",
        }
    }

    /// The user's choices: every kind, and every number of native boards.
    pub fn choices() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().chain((2..=MOST_DEVICES).map(Self::Natives))
    }

    pub fn of_name(name: &str) -> Option<Self> {
        Self::choices().find(|profile| profile.name() == name)
    }

    /// Transducers, of all boards on the line.
    pub fn elements(self) -> usize {
        match self {
            Self::UltrainoMega64 => 64,
            Self::SonicSurface2 => 512,
            Self::Natives(count) => 256 * usize::from(count),
            Self::Native
            | Self::SonicSurface
            | Self::SonicSurfaceTactile
            | Self::UltrainoSimpleFpga
            | Self::Acoustophoretic512 => 256,
        }
    }

    /// Native devices on the line; 0 for other boards.
    pub fn devices(self) -> usize {
        match self {
            Self::Native => 1,
            Self::Natives(count) => usize::from(count),
            Self::SonicSurface
            | Self::SonicSurface2
            | Self::SonicSurfaceTactile
            | Self::UltrainoSimpleFpga
            | Self::UltrainoMega64
            | Self::Acoustophoretic512 => 0,
        }
    }

    /// Whether it answers and acknowledges.
    pub fn answers(self) -> bool {
        self.devices() > 0
    }

    /// Columns and rows if the transducers are on the board; `None` if channels are wired to any array of as many
    /// elements, channel n to element n.
    pub fn shape(self) -> Option<[u32; 2]> {
        match self {
            Self::Native | Self::Natives(_) | Self::UltrainoSimpleFpga => None,
            Self::SonicSurface | Self::SonicSurfaceTactile | Self::Acoustophoretic512 => Some([16, 16]),
            // The second board continues the rows of the first.
            Self::SonicSurface2 => Some([16, 32]),
            Self::UltrainoMega64 => Some([8, 8]),
        }
    }

    /// The board's size, as text.
    fn size(self) -> String {
        match self.shape() {
            Some([columns, rows]) => format!("is {columns} x {rows}"),
            None => format!("drives {} elements in any rows and columns", self.elements()),
        }
    }

    /// Whether a scene's boards match the profile; the pitch may differ. Several boards on a line correspond to
    /// several boards of the scene, or to consecutive rows of one.
    ///
    /// # Errors
    /// Other columns or rows, or another number of elements.
    pub fn drives(self, scene: &Scene) -> Result<(), OtherArray> {
        let boards = scene.boards.len().max(1);
        let array = scene.array.file.is_none().then_some([scene.array.columns, scene.array.rows]);
        let together = array.map(|[columns, rows]| [columns, rows.saturating_mul(boards as u32)]);
        let fits = match self.shape() {
            Some(shape) => together == Some(shape),
            None => scene.elements() == self.elements(),
        };
        let elements = scene.elements();
        if fits { Ok(()) } else { Err(OtherArray { profile: self, boards, array, elements }) }
    }

    /// Number of delays per period.
    pub fn levels(self) -> u16 {
        match self {
            Self::Native | Self::Natives(_) => 256,
            Self::SonicSurface | Self::SonicSurface2 | Self::UltrainoSimpleFpga => 32,
            Self::SonicSurfaceTactile => 16,
            Self::UltrainoMega64 => 10,
            Self::Acoustophoretic512 => 128,
        }
    }

    pub fn strength(self) -> Strength {
        match self {
            Self::Native | Self::Natives(_) => Strength::Linear(255),
            Self::SonicSurface | Self::SonicSurface2 | Self::SonicSurfaceTactile => Strength::Fixed,
            Self::UltrainoSimpleFpga => Strength::Duty(16),
            Self::UltrainoMega64 => Strength::Duty(5),
            Self::Acoustophoretic512 => Strength::Duty(64),
        }
    }

    /// Bit rate after power-up.
    pub fn baud(self) -> u32 {
        match self {
            Self::Native | Self::Natives(_) => 2_000_000,
            Self::UltrainoMega64 => 115_200,
            Self::Acoustophoretic512 => 250_000,
            Self::SonicSurface
            | Self::SonicSurface2
            | Self::SonicSurfaceTactile
            | Self::UltrainoSimpleFpga => 230_400,
        }
    }

    /// Hz. A native board reports its own.
    pub fn carrier(self) -> f64 {
        40_000.0
    }

    /// Bytes of a frame at full amplitude.
    pub fn frame_bytes(self) -> usize {
        match self {
            Self::Native => 270,
            Self::Natives(count) => 270 * usize::from(count),
            Self::SonicSurface | Self::SonicSurfaceTactile | Self::UltrainoSimpleFpga => 258,
            Self::SonicSurface2 => 516,
            Self::UltrainoMega64 => 210,
            Self::Acoustophoretic512 => 512,
        }
    }

    /// The line's frame rate with 8 data bits, a start and a stop bit.
    pub fn frames_per_second(self, baud: u32) -> f64 {
        f64::from(baud) / 10.0 / self.frame_bytes() as f64
    }

    /// Frames per second of drives in turn: the line's rate, limited by a transducer's ringing of some 0.3 ms.
    pub fn turns_per_second(self, baud: u32) -> f64 {
        const MOST: f64 = 1000.0;
        match self {
            // It keeps them.
            Self::Native | Self::Natives(_) => MOST,
            Self::SonicSurface
            | Self::SonicSurface2
            | Self::SonicSurfaceTactile
            | Self::UltrainoSimpleFpga
            | Self::UltrainoMega64
            | Self::Acoustophoretic512 => self.frames_per_second(baud).min(MOST),
        }
    }

    /// Gives areas one drive if the board cannot change drives so fast that their mean counts, and says so.
    pub fn steady(self, scene: &mut Scene, baud: u32) -> Option<String> {
        /// Changes per second: cycles of six drives at 100 Hz.
        const LEAST: f64 = 600.0;
        let rate = self.turns_per_second(baud);
        if scene.solver.frames != Turns::Auto || rate >= LEAST || *scene.drives_in_turn().end() == 1 {
            return None;
        }
        scene.solver.frames = Turns::Count(1);
        Some(format!(
            "{} changes drives {rate:.0} times per second at {baud} baud, fewer than {LEAST}: the areas have one drive instead of \
             several in turn",
            self.name()
        ))
    }

    /// A remark for the user before sending.
    pub fn remark(self) -> Option<&'static str> {
        match self {
            Self::Native | Self::Natives(_) => None,
            Self::SonicSurface | Self::SonicSurface2 | Self::UltrainoMega64 => {
                Some("every element sounds from power-up until a program connects")
            }
            Self::UltrainoSimpleFpga => Some(
                "its gateware is not published: every element may sound from power-up until a program connects",
            ),
            Self::SonicSurfaceTactile => Some(
                "the phase corrections of its published gateware are compensated; for gateware built without them use the \
                 calibration sonicsurface-tactile-zero-table.csv",
            ),
            Self::Acoustophoretic512 => Some(
                "its USB chip must appear as a serial port; every element sounds for the first second after power-up",
            ),
        }
    }

    /// "89 frames/s at 230400 baud"
    pub fn bandwidth(self, baud: u32) -> String {
        format!("{:.0} frames/s at {baud} baud", self.frames_per_second(baud).floor())
    }
}
