//! The levitated bead: named materials, and properties given by the scene.

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::range::{KeyError, within};

/// A small sphere. `None` takes the material's value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bead {
    pub material: Material,
    /// kg/m³
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// m/s, of compression.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound_speed: Option<f64>,
    /// m
    pub radius: f64,
}

impl Default for Bead {
    fn default() -> Self {
        Self { material: Material::Eps, density: None, sound_speed: None, radius: 0.0005 }
    }
}

impl Bead {
    /// kg/m³
    pub fn density(&self) -> f64 {
        self.density.unwrap_or(self.material.properties().0)
    }

    /// m/s
    pub fn sound_speed(&self) -> f64 {
        self.sound_speed.unwrap_or(self.material.properties().1)
    }

    pub(super) fn check(&self) -> Result<(), KeyError> {
        within("density", self.density(), 1e-2, 1e5, "kg/m³")?;
        within("sound_speed", self.sound_speed(), 1.0, 1e5, "m/s")?;
        within("radius", self.radius, 1e-6, 0.1, "m")
    }

    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Materials with known properties at 20 °C.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames)]
#[strum(serialize_all = "kebab-case", const_into_str)]
pub enum Material {
    /// Expanded polystyrene.
    Eps,
    Water,
    Ethanol,
    /// Fused silica.
    Silica,
}

impl Material {
    /// Full name.
    pub fn title(self) -> &'static str {
        match self {
            Self::Eps => "expanded polystyrene",
            Self::Water => "water",
            Self::Ethanol => "ethanol",
            Self::Silica => "fused silica",
        }
    }

    /// Density (kg/m³) and sound speed (m/s). EPS: 29 kg/m³ as AcousTools has it, after Marzo et al., Nature
    /// Communications 6:8661 (2015), and the sound speed of levitate; others take 25 to 30 kg/m³ and 900 to 2350 m/s.
    /// Water: IAPWS R6-95. Ethanol and silica: CRC Handbook of Chemistry and Physics. In air the bead's sound speed
    /// matters only to 1e-3.
    fn properties(self) -> (f64, f64) {
        match self {
            Self::Eps => (29.0, 2350.0),
            Self::Water => (998.2, 1482.0),
            Self::Ethanol => (789.3, 1160.0),
            Self::Silica => (2200.0, 5970.0),
        }
    }
}
