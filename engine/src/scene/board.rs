//! Boards, reflectors and tables of elements.

use std::path::PathBuf;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::scene::loaded::Loaded;
use crate::scene::wires::{Correction, Wires};

/// Sine of the largest angle between planes that count as parallel.
pub(crate) const PARALLEL: f64 = 1e-9;

/// A copy of the scene's array with a position and an orientation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Board {
    /// m, its centre.
    pub at: DVec3,
    /// The direction in which it radiates.
    pub normal: DVec3,
    /// The direction of increasing column; made orthogonal to `normal` by [`Board::axes`].
    pub x_axis: DVec3,
}

impl Default for Board {
    fn default() -> Self {
        Self { at: DVec3::ZERO, normal: DVec3::Z, x_axis: DVec3::X }
    }
}

impl Board {
    /// Unit vectors along increasing columns, increasing rows and the direction of radiation: the columns of a
    /// rotation. `None` if the given ones are zero or parallel.
    pub fn axes(&self) -> Option<DMat3> {
        let normal = self.normal.try_normalize()?;
        let x = self.x_axis.try_normalize()?;
        let x = x - normal * normal.dot(x);
        let x = x.try_normalize().filter(|_| x.length() > PARALLEL)?;
        Some(DMat3::from_cols(x, normal.cross(x), normal))
    }

    /// A point on the board (m, relative to its centre) in the scene's coordinates.
    pub fn world(&self, place: DVec3) -> DVec3 {
        self.at + self.axes().unwrap_or(DMat3::IDENTITY) * place
    }
}

/// An infinite plane that reflects sound on one side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reflector {
    /// m, any point of the plane.
    pub point: DVec3,
    /// Towards the sound.
    pub normal: DVec3,
    /// Pressure reflection coefficient: 1 rigid, -1 soft.
    pub coefficient: f64,
}

impl Default for Reflector {
    fn default() -> Self {
        Self { point: DVec3::new(0.0, 0.0, 0.2), normal: DVec3::NEG_Z, coefficient: 1.0 }
    }
}

impl Reflector {
    /// Height (m), positive on the side of the sound.
    pub fn height(&self, place: DVec3) -> f64 {
        self.normal.normalize_or_zero().dot(place - self.point)
    }
}

/// An element table, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Elements {
    placed: Loaded<[Placed]>,
    /// The board's wires, if its file has them.
    pub wires: Wires,
    corrections: Loaded<[Correction]>,
    /// The file of origin.
    pub from: Option<PathBuf>,
}

/// An element of such an array, in the array's own coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// m
    pub at: DVec3,
    /// Unit vector: the direction in which it radiates.
    pub normal: DVec3,
}

impl Elements {
    pub fn new(placed: Vec<Placed>, from: Option<PathBuf>) -> Self {
        Self { placed: Loaded::new(placed), from, ..Self::default() }
    }

    /// The same elements with what their board's file says about driving them.
    pub fn driven_by(self, wires: Wires, corrections: Vec<Correction>) -> Self {
        Self { wires, corrections: Loaded::new(corrections), ..self }
    }

    pub fn get(&self) -> Option<&[Placed]> {
        self.placed.get()
    }

    /// The measured corrections of one board, if its file has them.
    pub fn corrections(&self) -> Option<&[Correction]> {
        self.corrections.get()
    }
}

impl Reflector {
    /// Whether the plane contains a point (m) and has this unit normal.
    pub(crate) fn lies_in(&self, point: DVec3, normal: DVec3) -> bool {
        let is_parallel = self.normal.normalize_or_zero().cross(normal).length() < PARALLEL;
        is_parallel && self.height(point).abs() < PARALLEL
    }

    /// Whether a board is parallel to it and faces it, which gives multiple reflections.
    pub fn faces(&self, board: &Board) -> bool {
        let (own, its) = (self.normal.normalize_or_zero(), board.normal.normalize_or_zero());
        own.cross(its).length() < PARALLEL && own.dot(its) < 0.0
    }
}
