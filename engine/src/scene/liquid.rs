//! The liquid under the array: named liquids, and properties given by the scene.

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

/// The liquid. `None` takes the named liquid's value. A scene that differs from the default is for a liquid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Liquid {
    /// Without a name the scene needs no liquid; water is assumed where one is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<LiquidName>,
    /// kg/m³
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// N/m
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_tension: Option<f64>,
    /// Pa·s
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<f64>,
    /// m/s²
    pub gravity: f64,
    /// m; affects waves but not a static depression.
    pub depth: f64,
    /// Whether the surface reflects sound.
    #[serde(skip_serializing_if = "is_false")]
    pub reflects: bool,
    /// Refractive index for light.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refractive_index: Option<f64>,
    #[serde(skip_serializing_if = "Light::is_through")]
    pub light: Light,
    /// Distance from the surface to the screen, m.
    #[serde(skip_serializing_if = "is_default_screen")]
    pub screen: f64,
}

/// Pressure reflection coefficient from air to water, (Z - 1)/(Z + 1) with impedances 1.48 MPa·s/m and 413 Pa·s/m.
pub const REFLECTION: f64 = 0.9994;

fn is_false(value: &bool) -> bool {
    !value
}

/// The direction of the light of caustics, along the normal of the level surface.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames,
)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Light {
    /// From below through the liquid.
    #[default]
    Through,
    /// From above, reflected.
    Reflected,
}

impl Light {
    fn is_through(&self) -> bool {
        *self == Self::Through
    }
}

fn is_default_screen(screen: &f64) -> bool {
    *screen == Liquid::SCREEN
}

impl Default for Liquid {
    fn default() -> Self {
        Self {
            name: None,
            density: None,
            surface_tension: None,
            viscosity: None,
            gravity: 9.80665,
            depth: 0.05,
            reflects: false,
            refractive_index: None,
            light: Light::Through,
            screen: Self::SCREEN,
        }
    }
}

impl Liquid {
    /// Default of `screen`.
    pub const SCREEN: f64 = 0.2;

    /// The liquid whose values are taken where the scene gives none.
    pub fn named(&self) -> LiquidName {
        self.name.unwrap_or(LiquidName::Water)
    }

    /// kg/m³
    pub fn density(&self) -> f64 {
        self.density.unwrap_or(self.named().properties().density)
    }

    /// N/m
    pub fn surface_tension(&self) -> f64 {
        self.surface_tension.unwrap_or(self.named().properties().surface_tension)
    }

    /// Pa·s
    pub fn viscosity(&self) -> f64 {
        self.viscosity.unwrap_or(self.named().properties().viscosity)
    }

    pub fn refractive_index(&self) -> f64 {
        self.refractive_index.unwrap_or(self.named().properties().refractive_index)
    }

    /// Displacement of light on the screen (m) per unit slope of the surface's depth, for small slopes.
    pub fn throw(&self) -> f64 {
        self.screen
            * match self.light {
                Light::Through => self.refractive_index() - 1.0,
                Light::Reflected => -2.0,
            }
    }

    /// The liquid with only the properties that determine its surface.
    pub(crate) fn in_the_dark(&self) -> Self {
        let Self { refractive_index, light, screen, .. } = Self::default();
        Self { refractive_index, light, screen, ..self.clone() }
    }

    /// √(σ/ρg), m: the range of a depression beyond its load.
    pub fn capillary_length(&self) -> f64 {
        (self.surface_tension() / (self.density() * self.gravity)).sqrt()
    }
}

/// Liquids with known properties at 20 °C.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames)]
#[strum(serialize_all = "kebab-case", const_into_str)]
pub enum LiquidName {
    Water,
    Glycerol,
    SiliconeOil,
    VegetableOil,
    Ethanol,
}

/// The properties that determine depressions and waves.
struct Properties {
    density: f64,
    surface_tension: f64,
    viscosity: f64,
    refractive_index: f64,
}

impl LiquidName {
    /// At 20 °C. Water: IAPWS R6-95, R1-76, R12-08. Glycerol and ethanol: CRC Handbook of Chemistry and Physics.
    /// Silicone oil: polydimethylsiloxane of 50 cSt, makers' data sheets. Vegetable oil: sunflower; density and viscosity
    /// from Noureddini, Teoh and Clements, JAOCS 69 (1992), tension from Sahasrabudhe et al., Int. J. Food
    /// Prop. 20 (2017). Refractive indices at 589 nm: IAPWS R9-97, CRC Handbook, makers' data sheets, and for sunflower oil
    /// Codex Alimentarius CXS 210 (1.461 to 1.468 at 40 °C, and 0.0004 more per kelvin below).
    fn properties(self) -> Properties {
        let (density, surface_tension, viscosity, refractive_index) = match self {
            Self::Water => (998.2, 0.0728, 1.002e-3, 1.333),
            Self::Glycerol => (1261.0, 0.0634, 1.41, 1.474),
            Self::SiliconeOil => (960.0, 0.0208, 0.048, 1.402),
            Self::VegetableOil => (919.0, 0.0330, 0.065, 1.472),
            Self::Ethanol => (789.3, 0.0223, 1.20e-3, 1.361),
        };
        Properties { density, surface_tension, viscosity, refractive_index }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_scene_gives_goes_before_the_name() {
        let oil = Liquid { name: Some(LiquidName::VegetableOil), density: Some(925.0), ..Liquid::default() };
        assert_eq!((oil.density(), oil.surface_tension()), (925.0, 0.033));
        let names = <LiquidName as VariantArray>::VARIANTS;
        let of = |&name: &LiquidName| Liquid { name: Some(name), ..Liquid::default() };
        let lengths: Vec<_> = names.iter().map(|name| of(name).capillary_length() * 1e3).collect();
        let [water, glycerol, silicone, vegetable, ethanol] = lengths[..] else { panic!("{names:?}") };
        assert_eq!(Liquid::default().capillary_length() * 1e3, water, "water, unless another is named");
        // mm; of water 2.727, and the rest in the order of σ/ρ.
        assert!((water - 2.727).abs() < 1e-3, "{water}");
        assert!(water > glycerol && glycerol > vegetable && vegetable > ethanol && ethanol > silicone);
    }
}
