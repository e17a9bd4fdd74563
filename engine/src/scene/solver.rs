//! The settings of the solver.

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::turns::Turns;

/// How the drive is found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Solver {
    pub method: Method,
    /// 0: the method's own default.
    pub iterations: u32,
    pub pressures: Pressures,
    pub amplitudes: Amplitudes,
    /// Trade-off: 0 for the strongest drive, 1 for the lowest side lobes.
    #[serde(skip_serializing_if = "is_default_quiet")]
    pub quiet: f64,
    /// s of further search for a better drive.
    #[serde(skip_serializing_if = "is_zero")]
    pub search: f64,
    /// Number of drives in turn whose mean |p|² fits the targets.
    #[serde(skip_serializing_if = "is_auto")]
    pub frames: Turns,
    #[serde(skip_serializing_if = "is_pressure")]
    pub target: Aim,
}

/// The quantity prescribed by the targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Aim {
    /// |p|
    #[default]
    Pressure,
    /// The surface depression of the liquid at rest, on the scene's plane.
    Depression,
    /// The level over the threshold of feeling, on the scene's plane: foci and strokes of equal pressure are felt evenly.
    Felt,
}

pub fn is_pressure(aim: &Aim) -> bool {
    *aim == Aim::Pressure
}

impl Solver {
    /// Default of `quiet`.
    pub const QUIET: f64 = 0.5;
}

pub fn is_default_quiet(quiet: &f64) -> bool {
    *quiet == Solver::QUIET
}

pub fn is_auto(turns: &Turns) -> bool {
    *turns == Turns::Auto
}

pub fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            method: Method::Best,
            iterations: 0,
            pressures: Pressures::Relative,
            amplitudes: Amplitudes::Uniform,
            quiet: Self::QUIET,
            search: 0.0,
            frames: Turns::Auto,
            target: Aim::Pressure,
        }
    }
}

/// The meaning of the targets' pressures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pressures {
    /// Ratios; the loudest element is at full drive.
    Relative,
    /// Pa (peak) at every focus; the drive is turned down to them.
    Pascal,
}

/// The amplitudes of the played drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Amplitudes {
    /// One amplitude for all elements.
    Uniform,
    /// An amplitude for each.
    Free,
}

/// The solver's method; see `crate::solver`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames)]
#[strum(serialize_all = "kebab-case", const_into_str)]
pub enum Method {
    Focus,
    Pinv,
    Weighted,
    Naive,
    Gs,
    Gspat,
    Wgs,
    Greedy,
    Best,
}

impl Method {
    /// Full name.
    pub fn title(self) -> &'static str {
        match self {
            Self::Focus => "time of flight",
            Self::Pinv => "pseudo-inverse",
            Self::Weighted => "weighted pseudo-inverse",
            Self::Naive => "phase conjugation",
            Self::Gs => "Gerchberg-Saxton",
            Self::Gspat => "GS-PAT",
            Self::Wgs => "weighted Gerchberg-Saxton",
            Self::Greedy => "greedy search",
            Self::Best => "best (levelled Gauss-Newton)",
        }
    }
}
