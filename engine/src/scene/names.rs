//! Scene files by the variants' names that strum derives, for enums whose names the program shows as well.

use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error, Visitor};
use serde::ser::{Serialize, Serializer};
use strum::VariantNames;

use crate::scene::body::BodyKind;
use crate::scene::liquid::{Light, LiquidName};
use crate::scene::motion::{Easing, MotionPath};
use crate::scene::{
    bead::Material, modulation::Envelope, response::Transducer, shape, solver::Method, trap::Trap, zone,
};

struct Name<T>(PhantomData<T>);

impl<T: FromStr + VariantNames> Visitor<'_> for Name<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a string")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
        name.parse().map_err(|_| E::unknown_variant(name, T::VARIANTS))
    }
}

macro_rules! by_name {
    ($($type:ty),*) => {$(
        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, format: S) -> Result<S::Ok, S::Error> {
                format.serialize_str(self.into_str())
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(format: D) -> Result<Self, D::Error> {
                format.deserialize_str(Name(PhantomData))
            }
        }
    )*};
}

by_name!(
    BodyKind,
    Easing,
    Envelope,
    Light,
    LiquidName,
    Material,
    Method,
    MotionPath,
    Transducer,
    Trap,
    shape::Kind,
    zone::Kind
);
