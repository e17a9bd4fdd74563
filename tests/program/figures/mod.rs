//! Printed figures against judges of their own: formulas in f64 that know nothing of the program.

mod bounds;
mod depression;
mod judge;
mod program;
mod side_lobes;
mod silence;
