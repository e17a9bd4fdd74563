//! What the command line calls values of the layers below: one list for parsing and for help.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::bench::Subject;
use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::studio::evaluator::Backend;
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

impl ValueEnum for Diagram {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self::Map(Quantity::Rms),
            Self::Map(Quantity::Phase),
            Self::Map(Quantity::Radiation),
            Self::Map(Quantity::Dent),
            Self::Drive,
            Self::Sheet,
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self {
            Self::Map(Quantity::Rms) => ("rms", "RMS pressure"),
            Self::Map(Quantity::Phase) => ("phase", "Phase of the pressure"),
            Self::Map(Quantity::Radiation) => {
                ("radiation", "Radiation pressure on the plane as a reflecting surface")
            }
            Self::Map(Quantity::Dent) => {
                ("dent", "Depth of the dent in the liquid whose surface the plane is")
            }
            Self::Drive => ("drive", "Phase and amplitude per element"),
            Self::Sheet => ("sheet", "Everything on one page with axes"),
            // The window shows the first as it oscillates, and a mean is asked for by `--frame mean`.
            Self::Map(Quantity::Instantaneous | Quantity::MeanRms) => return None,
        };
        Some(PossibleValue::new(name).help(help))
    }
}

impl ValueEnum for ColourMap {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Inferno, Self::Viridis, Self::Magma, Self::Grey]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(match self {
            Self::Inferno => "inferno",
            Self::Viridis => "viridis",
            Self::Magma => "magma",
            Self::Grey => "grey",
            // They belong to phases and to instantaneous pressures, which have no others.
            Self::Cyclic | Self::Diverging => return None,
        }))
    }
}

impl ValueEnum for Subject {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Field, Self::Solve, Self::Stability, Self::Window, Self::Link, Self::All]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self {
            Self::Field => ("field", "Maps of the field, and dents and means beside them"),
            Self::Solve => ("solve", "Solver methods"),
            Self::Stability => ("stability", "Solver methods on sets of foci that are hard to solve"),
            Self::Window => ("window", "Frames of the window"),
            Self::Link => ("link", "Links to virtual boards"),
            Self::All => return Some(PossibleValue::new("all")),
        };
        Some(PossibleValue::new(name).help(help))
    }
}
