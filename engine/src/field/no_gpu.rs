//! Replaces the GPU evaluator in builds without one: every request fails.

use glam::DVec3;
use num_complex::Complex32;

use crate::field::gpu_report::{GpuError, Traffic};
use crate::field::sources::Sources;
use crate::scatter::Emission;

/// An uninhabited type.
#[derive(Clone, Copy, Debug)]
pub enum Gpu {}

/// An uninhabited type.
#[derive(Clone, Copy, Debug)]
pub enum Texture {}

impl Gpu {
    pub fn traffic(&self) -> Traffic {
        match *self {}
    }

    /// # Errors
    /// Never called.
    pub fn scattered(&self, _: &[Emission], _: &[DVec3]) -> Result<Vec<Complex32>, GpuError> {
        match *self {}
    }

    /// # Errors
    /// Never called.
    pub fn pressure(&self, _: &[Sources<'_>]) -> Result<Vec<Complex32>, GpuError> {
        match *self {}
    }
}
