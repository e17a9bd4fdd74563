//! Field evaluators by name, cached between calls together with their plans and tables.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{self, Evaluator, Stages};
use sonoglyph::simd::Isa;
use sonoglyph::studio::evaluator::Backend;

use crate::error;

/// The idle evaluators; at most one of each backend per thread.
static IDLE: Mutex<Vec<(Backend, Stages)>> = Mutex::new(Vec::new());
/// Limit of idle evaluators.
const KEPT: usize = 8;

fn idle() -> MutexGuard<'static, Vec<(Backend, Stages)>> {
    IDLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// # Errors
/// A name unknown to the command line's `--backend`.
pub fn named(name: &str) -> PyResult<Backend> {
    match name {
        "auto" => Ok(Backend::Auto),
        "gpu" => Ok(Backend::Gpu),
        "cpu" => Ok(Backend::Cpu),
        "reference" => Ok(Backend::Reference),
        other => {
            Err(PyValueError::new_err(format!("evaluator = {other:?}: must be auto, gpu, cpu or reference")))
        }
    }
}

/// Runs work on an evaluator. A failed evaluator is dropped; unless a GPU was requested by name, the CPU takes over.
///
/// # Errors
/// A missing GPU, or an error of the work.
pub fn with<T>(backend: Backend, work: impl Fn(&mut Stages) -> Result<T, field::FieldError>) -> PyResult<T> {
    let mut stages = match take(backend) {
        Some(stages) => stages,
        None => open(backend)?,
    };
    match work(&mut stages) {
        Ok(made) => {
            give_back(backend, stages);
            Ok(made)
        }
        Err(field::FieldError::Gpu(_)) if backend == Backend::Auto => {
            let mut stages = Stages::new(Evaluator::Cpu);
            let made = work(&mut stages).map_err(|error| error::of_field(&error))?;
            give_back(backend, stages);
            Ok(made)
        }
        Err(error) => Err(error::of_field(&error)),
    }
}

fn take(backend: Backend) -> Option<Stages> {
    let mut idle = idle();
    let at = idle.iter().rposition(|(kept, _)| *kept == backend)?;
    Some(idle.remove(at).1)
}

fn give_back(backend: Backend, stages: Stages) {
    let mut idle = idle();
    idle.push((backend, stages));
    if idle.len() > KEPT {
        idle.remove(0);
    }
}

fn open(backend: Backend) -> PyResult<Stages> {
    /// Whether there is a hardware GPU: the search takes a second.
    static HAS_GPU: AtomicBool = AtomicBool::new(true);
    let gpu = |software| adapter::open_best(software).map(|gpu| Evaluator::Gpu(Box::new(gpu)));
    Ok(Stages::new(match backend {
        Backend::Reference => Evaluator::Reference,
        Backend::Gpu => gpu(true).map_err(|error| error::of_gpu(&error))?,
        Backend::Auto if HAS_GPU.load(Ordering::Relaxed) => gpu(false).unwrap_or_else(|_| {
            HAS_GPU.store(false, Ordering::Relaxed);
            Evaluator::Cpu
        }),
        Backend::Cpu | Backend::Auto => Evaluator::Cpu,
    }))
}

/// Names and hardware.
pub fn available() -> Vec<(&'static str, String)> {
    let gpus = adapter::adapters();
    let gpu = gpus.first().map(|best| ("gpu", best.to_string()));
    let cpu = ("cpu", Isa::best().name().to_owned());
    let reference = ("reference", "f64, every pixel".to_owned());
    gpu.into_iter().chain([cpu, reference]).collect()
}
