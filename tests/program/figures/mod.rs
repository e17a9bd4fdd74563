//! Printed figures against independent formulae in f64.

mod bounds;
mod depression;
mod judge;
mod lobes_of_arrays;
mod program;
mod side_lobes;
mod silence;
