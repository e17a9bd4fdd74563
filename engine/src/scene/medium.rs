//! The air.

use serde::{Deserialize, Serialize};
use strum::VariantArray;

/// The air. `None` is derived from temperature, humidity and pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Medium {
    /// °C
    pub temperature: f64,
    /// Relative humidity, %
    pub humidity: f64,
    /// Pa
    pub pressure: f64,
    /// m/s
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound_speed: Option<f64>,
    /// kg/m³
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// dB/m
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorption: Option<f64>,
}

impl Default for Medium {
    fn default() -> Self {
        Self {
            temperature: 20.0,
            humidity: 50.0,
            pressure: 101_325.0,
            sound_speed: None,
            density: None,
            absorption: None,
        }
    }
}

/// A fluid with known properties.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray)]
pub enum Fluid {
    /// At 20 °C.
    Water,
    SoftTissue,
}

impl Fluid {
    /// Name in menus.
    pub fn title(self) -> &'static str {
        match self {
            Self::Water => "Water, 20 °C",
            Self::SoftTissue => "Soft tissue",
        }
    }

    /// Sound speed (m/s), density (kg/m³) and absorption (dB/m) at a frequency (Hz): of water as its square, α = 25e-15 s²/m f²;
    /// of tissue 0.5 dB/cm/MHz.
    pub fn properties(self, frequency: f64) -> [f64; 3] {
        const DB_PER_NEPER: f64 = 20.0 / std::f64::consts::LN_10;
        match self {
            Self::Water => [1482.0, 998.0, DB_PER_NEPER * 25e-15 * frequency * frequency],
            Self::SoftTissue => [1540.0, 1060.0, 50.0 * frequency / 1e6],
        }
    }
}

impl Medium {
    /// K at 0 °C.
    pub(crate) const ZERO_CELSIUS: f64 = 273.15;

    /// K
    pub fn kelvin(&self) -> f64 {
        self.temperature + Self::ZERO_CELSIUS
    }

    /// m/s: the scene's value, or that of dry air, c = 331.3 √(T/273.15 K).
    pub fn speed_of_sound(&self) -> f64 {
        self.sound_speed.unwrap_or_else(|| 331.3 * (self.kelvin() / Self::ZERO_CELSIUS).sqrt())
    }
}
