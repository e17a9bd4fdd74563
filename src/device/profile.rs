//! The boards that can be driven: their facts, and what their levels mean.

use std::f64::consts::{PI, TAU};

use crate::device::levels::Level;
use crate::drive::delay_level;

/// A kind of board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Profile {
    /// The gateware of this repository: CRC, answers, watchdog, amplitudes, modulation, sequences.
    Native,
    /// One SonicSurface of 16 x 16.
    SonicSurface,
    /// Two of them on one line.
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

/// How a board makes a weaker sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strength {
    /// It cannot: an element is on or off.
    Fixed,
    /// A number up to this, proportional to the sound.
    Linear(u16),
    /// Pulses up to this many levels long, which is half a period; the sound follows the sine of their length.
    Duty(u16),
}

impl Profile {
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
            Self::SonicSurface => "sonicsurface",
            Self::SonicSurface2 => "sonicsurface-2",
            Self::SonicSurfaceTactile => "sonicsurface-tactile",
            Self::UltrainoSimpleFpga => "ultraino-simplefpga",
            Self::UltrainoMega64 => "ultraino-mega64",
            Self::Acoustophoretic512 => "acoustophoretic-512",
        }
    }

    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.name() == name)
    }

    /// Transducers, of all boards on the line.
    pub fn elements(self) -> usize {
        match self {
            Self::UltrainoMega64 => 64,
            Self::SonicSurface2 => 512,
            _ => 256,
        }
    }

    /// Delays that it tells apart in a period.
    pub fn levels(self) -> u16 {
        match self {
            Self::Native => 256,
            Self::SonicSurface | Self::SonicSurface2 | Self::UltrainoSimpleFpga => 32,
            Self::SonicSurfaceTactile => 16,
            Self::UltrainoMega64 => 10,
            Self::Acoustophoretic512 => 128,
        }
    }

    pub fn strength(self) -> Strength {
        match self {
            Self::Native => Strength::Linear(255),
            Self::SonicSurface | Self::SonicSurface2 | Self::SonicSurfaceTactile => Strength::Fixed,
            Self::UltrainoSimpleFpga => Strength::Duty(16),
            Self::UltrainoMega64 => Strength::Duty(5),
            Self::Acoustophoretic512 => Strength::Duty(64),
        }
    }

    /// Bits per second that it speaks when it is switched on.
    pub fn baud(self) -> u32 {
        match self {
            Self::Native => 2_000_000,
            Self::UltrainoMega64 => 115_200,
            Self::Acoustophoretic512 => 250_000,
            _ => 230_400,
        }
    }

    /// Hz. A native board says its own.
    pub fn carrier(self) -> f64 {
        40_000.0
    }

    /// Bytes of a frame at full amplitude.
    pub fn frame_bytes(self) -> usize {
        match self {
            Self::Native => 267,
            Self::SonicSurface | Self::SonicSurfaceTactile | Self::UltrainoSimpleFpga => 258,
            Self::SonicSurface2 => 516,
            Self::UltrainoMega64 => 210,
            Self::Acoustophoretic512 => 512,
        }
    }

    /// What the line carries: 8 data bits, a start and a stop bit.
    pub fn frames_per_second(self, baud: u32) -> f64 {
        f64::from(baud) / 10.0 / self.frame_bytes() as f64
    }

    /// "89 frames/s at 230400 baud"
    pub fn bandwidth(self, baud: u32) -> String {
        format!("{:.0} frames/s at {baud} baud", self.frames_per_second(baud).floor())
    }

    /// What is nearest to an amplitude (0 to 1, and 1 for what is more) and a phase (rad); nothing where nothing is to sound, or
    /// nobody knows what: a NaN must not be loud.
    pub fn level(self, amplitude: f64, phase: f64) -> Option<Level> {
        if amplitude.is_nan() || amplitude <= 0.0 || !phase.is_finite() {
            return None;
        }
        let amplitude = amplitude.min(1.0);
        let levels = u32::from(self.levels());
        match self.strength() {
            Strength::Fixed => Some(Level { delay: delay_level(phase, levels) as u16, amplitude: 1 }),
            Strength::Linear(full) => {
                let amplitude = (amplitude * f64::from(full)).round() as u16;
                (amplitude > 0).then(|| Level { delay: delay_level(phase, levels) as u16, amplitude })
            }
            Strength::Duty(full) => {
                let duty = (amplitude.asin() / PI * f64::from(levels)).round().min(f64::from(full));
                // The middle of the pulse is what sounds, and it stays; the board is told where it begins.
                let later = (f64::from(full) - duty) / 2.0 / f64::from(levels);
                let delay = delay_level(phase - TAU * later, levels) as u16;
                (duty > 0.0).then_some(Level { delay, amplitude: duty as u16 })
            }
        }
    }

    /// Amplitude and phase (rad, in (-π, π]) that sound at a level, the same offset of phase left out for all elements.
    pub fn sounds(self, level: Level) -> (f64, f64) {
        let (delay, strength) = (f64::from(level.delay), f64::from(level.amplitude));
        let levels = f64::from(self.levels());
        let (amplitude, delay) = match self.strength() {
            Strength::Fixed => (1.0, delay),
            Strength::Linear(full) => (strength / f64::from(full), delay),
            Strength::Duty(full) => {
                ((PI * strength / levels).sin(), delay - (f64::from(full) - strength) / 2.0)
            }
        };
        let turns = (-delay / levels).rem_euclid(1.0);
        (amplitude, TAU * if turns > 0.5 { turns - 1.0 } else { turns })
    }
}
