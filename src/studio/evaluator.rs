//! Which evaluator a command uses.

use crate::field::gpu::adapter;
use crate::field::{Evaluator, GpuError};
use crate::studio::output::note;

/// Who is to compute the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The GPU if there is one that is not software, else the CPU.
    Auto,
    Gpu,
    Cpu,
    /// f64 and slow.
    Reference,
}

/// The evaluator for maps. `auto` takes the GPU if there is one that is not software, else the CPU, and says why not.
///
/// # Errors
/// A GPU that was asked for by name and cannot be had.
pub fn for_maps(backend: Backend) -> Result<Evaluator, GpuError> {
    Ok(match backend {
        Backend::Reference => Evaluator::Reference,
        Backend::Cpu => Evaluator::Cpu,
        Backend::Gpu => Evaluator::Gpu(Box::new(adapter::open_best(true)?)),
        Backend::Auto => match adapter::open_best(false) {
            Ok(gpu) => Evaluator::Gpu(Box::new(gpu)),
            Err(error) => {
                note(&format!("{error}; the CPU computes the field"));
                Evaluator::Cpu
            }
        },
    })
}

/// The evaluator for a list of points, which is short enough for f64.
///
/// # Errors
/// As [`for_maps`].
pub fn for_points(backend: Backend) -> Result<Evaluator, GpuError> {
    match backend {
        Backend::Auto => Ok(Evaluator::Reference),
        backend => for_maps(backend),
    }
}
