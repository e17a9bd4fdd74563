//! Sample points of the field: on a grid, or scattered.

use crate::solver::shape::grid::Grid;
use crate::solver::shape::real::{Real, Waves};
use crate::solver::shape::table::Table;

/// Samples of a plane, or of zones.
#[derive(Debug)]
pub enum Samples<T> {
    Grid(Box<Grid<T>>),
    Table(Table<T>),
}

impl<T: Real> Samples<T> {
    /// p = H u
    pub fn forward(&mut self, u: &Waves<T>, p: &mut Waves<T>) {
        match self {
            Self::Grid(grid) => grid.forward(u, p),
            Self::Table(table) => table.forward(u, p),
        }
    }

    /// b += Hᴴ p
    pub fn back(&mut self, p: &Waves<T>, b: &mut Waves<T>) {
        match self {
            Self::Grid(grid) => grid.back(p, b),
            Self::Table(table) => table.back(p, b),
        }
    }
}
