//! Special functions: polynomials of vector registers, Bessel functions, Gauss's rule.

pub mod bessel;
mod gauss;
pub mod series;

pub use gauss::legendre as gauss_legendre;
