//! Argument values for quantities, methods and colour maps, with the names that their layers declare.

use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use strum::VariantArray;

use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::scene::{Channel, Method};
use crate::studio::still::Diagram;

/// Every quantity, and the pages.
static DIAGRAMS: LazyLock<Vec<Diagram>> = LazyLock::new(|| {
    Quantity::ALL.into_iter().map(Diagram::Map).chain([Diagram::Drive, Diagram::Sheet]).collect()
});

impl ValueEnum for Diagram {
    fn value_variants<'a>() -> &'a [Self] {
        &DIAGRAMS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Map(quantity) => {
                let declaration = quantity.declaration();
                PossibleValue::new(declaration.name).help(declaration.help).aliases(declaration.aliases)
            }
            Self::Drive => PossibleValue::new("drive").help("Phase and amplitude per element"),
            Self::Sheet => PossibleValue::new("sheet").help("Everything on one page with axes"),
        })
    }
}

/// Names of the methods, with their titles.
pub fn of_methods() -> impl Iterator<Item = PossibleValue> {
    Method::VARIANTS.iter().map(|method| PossibleValue::new(method.into_str()).help(method.title()))
}

pub fn method() -> impl TypedValueParser<Value = Method> {
    PossibleValuesParser::new(of_methods()).try_map(|name| name.parse::<Method>())
}

impl ValueEnum for ColourMap {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::OF_AMOUNTS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.into_str()))
    }
}

/// Names of the channels of feeling.
pub fn channel() -> impl TypedValueParser<Value = Channel> {
    let names = Channel::VARIANTS.iter().map(|channel| PossibleValue::new(channel.into_str()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Channel>())
}
