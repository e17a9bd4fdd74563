//! Units of quantities, and their SI prefixes.

use std::f64::consts::PI;

/// The unit of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    Pascal,
    Radian,
    Metre,
    WattPerSquareMetre,
    MetrePerSecond,
    Joule,
    Newton,
    /// Relative to undisturbed light.
    Undisturbed,
    /// Of a level.
    Decibel,
}

impl Unit {
    /// The unit of computed and written values.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Pascal => "Pa",
            Self::Radian => "rad",
            Self::Metre => "m",
            Self::WattPerSquareMetre => "W/m²",
            Self::MetrePerSecond => "m/s",
            Self::Joule => "J",
            Self::Newton => "N",
            Self::Undisturbed => "1",
            Self::Decibel => "dB",
        }
    }

    /// The factor to the unit that suits values up to `largest`, and its symbol.
    pub fn scaled(self, largest: f64) -> (f64, &'static str) {
        match self {
            Self::Radian => (180.0 / PI, "°"),
            Self::Metre if largest >= 1e-3 => (1e3, "mm"),
            Self::Metre => (1e6, "µm"),
            Self::Pascal if largest >= 1e3 => (1e-3, "kPa"),
            Self::Pascal => (1.0, "Pa"),
            Self::WattPerSquareMetre => (1.0, "W/m²"),
            Self::MetrePerSecond if largest >= 1.0 => (1.0, "m/s"),
            Self::MetrePerSecond => (1e3, "mm/s"),
            Self::Joule if largest >= 1e-9 => (1e9, "nJ"),
            Self::Joule if largest >= 1e-12 => (1e12, "pJ"),
            Self::Joule => (1e15, "fJ"),
            Self::Newton if largest >= 1e-6 => (1e6, "µN"),
            Self::Newton => (1e9, "nN"),
            Self::Undisturbed => (1.0, "× undisturbed"),
            Self::Decibel => (1.0, "dB"),
        }
    }
}
