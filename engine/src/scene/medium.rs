//! The air.

use serde::{Deserialize, Serialize};

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
