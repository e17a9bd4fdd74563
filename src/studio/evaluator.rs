//! Choice of the field evaluator of a command.

use crate::field::{Evaluator, FieldError, Stages};
#[cfg(not(target_arch = "wasm32"))]
use crate::field::{GpuError, gpu::adapter};
use crate::studio::output::note;

/// The choice of the field evaluator; names and help of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Backend {
    /// Maps: a hardware GPU if there is one, otherwise the CPU; points: the f64 reference
    Auto,
    Gpu,
    Cpu,
    /// f64 and slow
    Reference,
}

/// The renderer of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Renderer {
    /// wgpu with a hardware GPU, otherwise OpenGL
    #[default]
    Auto,
    /// The device that computes the field draws the window too
    Wgpu,
    /// OpenGL; the CPU computes the field
    Glow,
}

/// Silences Mesa's device-selection layer, which prints an error about Wayland without a desktop session. A program
/// calls this first, while no other thread runs.
#[cfg(not(target_arch = "wasm32"))]
#[expect(unsafe_code, reason = "no other thread runs yet")]
pub fn quiet_drivers() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// The evaluator for maps. `auto` takes a hardware GPU if available, otherwise the CPU, mentioned only if verbose.
///
/// # Errors
/// An explicitly requested GPU is unavailable.
#[cfg(not(target_arch = "wasm32"))]
pub fn for_maps(backend: Backend, is_verbose: bool) -> Result<Evaluator, GpuError> {
    Ok(match backend {
        Backend::Reference => Evaluator::Reference,
        Backend::Cpu => Evaluator::Cpu,
        Backend::Gpu => Evaluator::Gpu(Box::new(adapter::open_best(true)?)),
        Backend::Auto => match adapter::open_best(false) {
            Ok(gpu) => Evaluator::Gpu(Box::new(gpu)),
            Err(error) => {
                if is_verbose || !matches!(error, GpuError::NoAdapter(_)) {
                    note(&format!("{error}; the CPU computes the field"));
                }
                Evaluator::Cpu
            }
        },
    })
}

/// The evaluator for a list of points, short enough for f64.
///
/// # Errors
/// The errors of [`for_maps`].
#[cfg(not(target_arch = "wasm32"))]
pub fn for_points(backend: Backend) -> Result<Evaluator, GpuError> {
    match backend {
        Backend::Auto => Ok(Evaluator::Reference),
        backend => for_maps(backend, true),
    }
}

/// Runs work on the stages; a failing GPU is replaced by the CPU, once and with a warning, unless requested by name.
///
/// # Errors
/// The errors of the work.
pub fn or_by_cpu<T>(
    stages: &mut Stages,
    gpu_is_asked_for: bool,
    work: impl Fn(&mut Stages) -> Result<T, FieldError>,
) -> Result<T, FieldError> {
    match work(stages) {
        Err(FieldError::Gpu(error)) if !gpu_is_asked_for => {
            note(&format!("{error}; the CPU computes the field"));
            *stages = Stages::new(Evaluator::Cpu);
            work(stages)
        }
        done => done,
    }
}
