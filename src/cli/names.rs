//! Argument values for quantities, methods and colour maps, with the names that their layers declare.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::scene::Method;
use crate::studio::still::Diagram;

/// Every quantity, and the pages.
const DIAGRAMS: [Diagram; Quantity::ALL.len() + 2] = {
    let mut all = [Diagram::Drive; Quantity::ALL.len() + 2];
    let mut i = 0;
    while i < Quantity::ALL.len() {
        all[i] = Diagram::Map(Quantity::ALL[i]);
        i += 1;
    }
    all[i] = Diagram::Sheet;
    all
};

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

impl ValueEnum for Method {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(self.title()))
    }
}

impl ValueEnum for ColourMap {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::OF_AMOUNTS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}
