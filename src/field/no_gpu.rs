//! The GPU of a library that is built without one: there is none, and nothing can be done with it.

use num_complex::Complex32;

use crate::field::{GpuError, Sources, Traffic};

/// No value of it exists.
#[derive(Clone, Copy, Debug)]
pub enum Gpu {}

/// No value of it exists.
#[derive(Clone, Copy, Debug)]
pub enum Texture {}

impl Gpu {
    pub fn traffic(&self) -> Traffic {
        match *self {}
    }

    /// # Errors
    /// Never called.
    pub fn pressure(&self, _: &[Sources<'_>]) -> Result<Vec<Complex32>, GpuError> {
        match *self {}
    }
}
