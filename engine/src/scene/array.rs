//! The elements of a board: a grid or a table, and how each radiates.

use glam::DVec2;
use serde::{Deserialize, Serialize};
use strum::VariantArray;

use crate::scene::board::{Elements, Placed};
use crate::scene::directivity::Directivity;
use crate::scene::response::Response;
use crate::scene::solver::is_zero;
use crate::scene::wires::Wires;

/// An array of equal elements, in rows and columns or at tabulated positions, radiating towards its own +z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Array {
    pub rows: u32,
    pub columns: u32,
    /// m, centre to centre
    pub pitch: f64,
    /// m
    pub element_radius: f64,
    /// Hz
    pub frequency: f64,
    /// Pa·m, peak, on axis at full drive
    pub strength: f64,
    pub element: ElementModel,
    /// m, width and height of a rectangle, along the element's own x and y.
    #[serde(skip_serializing_if = "is_usual_size")]
    pub element_size: DVec2,
    /// n of cosⁿθ.
    #[serde(skip_serializing_if = "is_usual_exponent")]
    pub element_exponent: f64,
    /// A table of the amplitude by angle, relative to the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directivity: Option<String>,
    /// The content of that table.
    #[serde(skip)]
    pub measured: Directivity,
    /// Elements that are not driven.
    pub off: Vec<usize>,
    /// A table of elements instead of rows, columns and pitch, relative to the scene file.
    #[serde(rename = "elements", skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The content of that table.
    #[serde(skip)]
    pub placed: Elements,
    /// A table of the boards' channels, relative to the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wiring: Option<String>,
    /// The content of that table.
    #[serde(skip)]
    pub wires: Wires,
    /// Pressure reflection coefficient of the array's own face.
    #[serde(skip_serializing_if = "is_zero")]
    pub reflectivity: f64,
    /// How an element follows changes of its drive; absent: at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub response: Option<Response>,
    /// Random differences between elements.
    #[serde(skip_serializing_if = "Spread::is_none")]
    pub spread: Spread,
}

impl Default for Array {
    fn default() -> Self {
        Self {
            rows: 16,
            columns: 16,
            pitch: 0.0105,
            element_radius: 0.005,
            frequency: 40_000.0,
            strength: 3.4,
            element: ElementModel::Piston,
            element_size: USUAL_SIZE,
            element_exponent: USUAL_EXPONENT,
            directivity: None,
            measured: Directivity::default(),
            off: Vec::new(),
            file: None,
            placed: Elements::default(),
            wiring: None,
            wires: Wires::default(),
            reflectivity: 0.0,
            response: None,
            spread: Spread::default(),
        }
    }
}

const USUAL_SIZE: DVec2 = DVec2::splat(0.01);
const USUAL_EXPONENT: f64 = 1.0;

fn is_usual_size(size: &DVec2) -> bool {
    *size == USUAL_SIZE
}

fn is_usual_exponent(exponent: &f64) -> bool {
    *exponent == USUAL_EXPONENT
}

impl Array {
    /// Whether its table of directivity is not yet loaded.
    #[doc(hidden)]
    pub fn lacks_directivity(&self) -> bool {
        self.directivity.is_some() && self.measured.get().is_none()
    }

    /// Half the sides (m) of an element's radiating surface, as it is drawn.
    #[doc(hidden)]
    pub fn element_half(&self) -> DVec2 {
        match self.element {
            ElementModel::Rectangle => self.element_size / 2.0,
            ElementModel::Piston
            | ElementModel::ExactPiston
            | ElementModel::Point
            | ElementModel::Cosine
            | ElementModel::Measured => DVec2::splat(self.element_radius),
        }
    }

    /// Number of elements of one board, driven or not.
    pub fn elements(&self) -> usize {
        self.placed.get().map_or(self.rows as usize * self.columns as usize, <[Placed]>::len)
    }
}

/// Random differences between elements, independent of each other: the deviations of gain and phase, rms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spread {
    /// Relative to the mean gain.
    pub gain: f64,
    /// rad
    pub phase: f64,
}

impl Spread {
    #[doc(hidden)]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// How one element radiates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, VariantArray)]
#[serde(rename_all = "kebab-case")]
pub enum ElementModel {
    /// Far field of a baffled circular piston, the paper's equation (1).
    Piston,
    /// The baffled circular piston itself, near field too.
    ExactPiston,
    /// The same strength in every direction.
    Point,
    /// Far field of a baffled rectangular piston.
    Rectangle,
    /// A power of the cosine of the angle from its axis.
    Cosine,
    /// A directivity from a table.
    Measured,
}
