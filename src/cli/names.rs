//! What the command line calls values of the layers below: one list for parsing and for help.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::bench::Subject;
use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::studio::evaluator::{Backend, Renderer};
use crate::studio::still::Diagram;

impl ValueEnum for Backend {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Auto, Self::Gpu, Self::Cpu, Self::Reference]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Auto => PossibleValue::new("auto"),
            Self::Gpu => PossibleValue::new("gpu"),
            Self::Cpu => PossibleValue::new("cpu"),
            Self::Reference => PossibleValue::new("reference").help("f64 and slow"),
        })
    }
}

impl ValueEnum for Renderer {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Auto, Self::Wgpu, Self::Glow]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Auto => PossibleValue::new("auto").help("wgpu where there is a GPU, else glow"),
            Self::Wgpu => {
                PossibleValue::new("wgpu").help("The device that computes the field draws the window too")
            }
            Self::Glow => PossibleValue::new("glow").help("OpenGL; the CPU computes the field"),
        })
    }
}

/// Every quantity, and what is not one.
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

impl ValueEnum for ColourMap {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::OF_AMOUNTS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

impl ValueEnum for Subject {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Field, Self::Solve, Self::Stability, Self::Shapes, Self::Window, Self::Link, Self::All]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self {
            Self::Field => ("field", "Maps: of one drive, of means, and of surface depressions"),
            Self::Solve => ("solve", "Solver methods"),
            Self::Stability => ("stability", "Solver methods on sets of foci that are hard to solve"),
            Self::Shapes => ("shapes", "Drives of drawings, call by call, beside separate foci"),
            Self::Window => ("window", "Frames of the window"),
            Self::Link => ("link", "Links to virtual boards"),
            Self::All => return Some(PossibleValue::new("all")),
        };
        Some(PossibleValue::new(name).help(help))
    }
}
