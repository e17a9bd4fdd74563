//! How the elements of an array follow changes of their drive, as a scene states it: a resonance, or a known transducer.

use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

/// The response of an element: see `acoustics::Resonator`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Response {
    Pole(Pole),
    Preset(Transducer),
}

/// A resonance of the motional branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pole {
    /// Hz
    pub resonance: f64,
    /// Time constant (s) of the amplitude.
    pub tau: f64,
}

/// A transducer whose circuit is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Transducer {
    /// Nippon Ceramic's, of 10 mm.
    T4010A1,
}

/// The equivalent circuit of a transducer and its driver: a series resonance and a capacitance beside it, behind a resistance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circuit {
    /// F, H and Ω of the motional branch.
    pub motional: [f64; 3],
    /// F
    pub parallel: f64,
    /// Ω
    pub source: f64,
}

impl Transducer {
    /// Name in menus.
    #[doc(hidden)]
    pub fn title(self) -> &'static str {
        match self {
            Self::T4010A1 => "T4010A1",
        }
    }

    pub(crate) fn circuit(self) -> Circuit {
        match self {
            Self::T4010A1 => Circuit { motional: [200e-12, 80e-3, 700.0], parallel: 2700e-12, source: 150.0 },
        }
    }
}

impl Response {
    /// Time constant of the amplitude, s.
    #[doc(hidden)]
    pub fn tau(self) -> f64 {
        match self {
            Self::Pole(pole) => pole.tau,
            Self::Preset(transducer) => {
                let Circuit { motional: [_, inductance, resistance], source, .. } = transducer.circuit();
                2.0 * inductance / (resistance + source)
            }
        }
    }
}

impl Serialize for Response {
    fn serialize<S: Serializer>(&self, format: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Pole(pole) => pole.serialize(format),
            Self::Preset(transducer) => transducer.serialize(format),
        }
    }
}

impl<'de> Deserialize<'de> for Response {
    fn deserialize<D: Deserializer<'de>>(format: D) -> Result<Self, D::Error> {
        format.deserialize_any(Written)
    }
}

/// A table or a name.
struct Written;

impl<'de> Visitor<'de> for Written {
    type Value = Response;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a table {{ resonance, tau }} or a transducer's name ({})",
            <Transducer as VariantNames>::VARIANTS.join(", ")
        )
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Response, E> {
        let known = name.parse().map(Response::Preset);
        known.map_err(|_| E::unknown_variant(name, <Transducer as VariantNames>::VARIANTS))
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Response, A::Error> {
        Pole::deserialize(MapAccessDeserializer::new(table)).map(Response::Pole)
    }
}
