//! Field evaluators by name, cached between calls together with their plans and tables.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Evaluator, FieldError, Map, Request, Stages};
use sonoglyph::gauge::Gauge;
use sonoglyph::simd::Isa;
use sonoglyph::studio::evaluator::Backend;

use crate::{error, work};

/// The idle evaluators; at most one of each backend per thread.
static IDLE: Mutex<Vec<Cached>> = Mutex::new(Vec::new());
/// Limit of idle evaluators.
const KEPT: usize = 8;

fn idle() -> MutexGuard<'static, Vec<Cached>> {
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

/// An evaluator with its plans and tables.
#[derive(Debug)]
pub struct Cached {
    backend: Backend,
    /// `None` before its first map.
    stages: Option<Stages>,
    /// What its last map was of, if that took less than [`work::BRIEF`].
    brief: Option<Alike>,
}

/// A request without its drives, and their number: maps that agree in it take about the same time.
type Alike = (Request, usize);

fn alike(request: &Request) -> Alike {
    (Request { drives: Arc::from([]), ..request.clone() }, request.drives.len())
}

impl Cached {
    /// An idle evaluator, or a new one.
    pub fn take(backend: Backend) -> Self {
        let mut idle = idle();
        match idle.iter().rposition(|kept| kept.backend == backend) {
            Some(at) => idle.remove(at),
            None => Self { backend, stages: None, brief: None },
        }
    }

    /// Whether its last map was like this one, and brief.
    pub fn is_brief(&self, request: &Request) -> bool {
        self.brief.as_ref().is_some_and(|brief| *brief == alike(request))
    }

    /// Makes a map, if possible in this memory. A failed evaluator is dropped; unless a GPU was requested by name, the CPU takes over.
    ///
    /// # Errors
    /// A missing GPU, or an error of the map.
    pub fn map(self, request: &Request, memory: Vec<f32>, gauge: &Gauge) -> PyResult<Map> {
        let Self { backend, stages, .. } = self;
        let mut stages = stages.map_or_else(|| open(backend), Ok)?;
        let begun = Instant::now();
        let mut made = map(&mut stages, request, memory, gauge);
        if backend == Backend::Auto && matches!(made, Err(FieldError::Gpu(_))) {
            stages = Stages::new(Evaluator::Cpu);
            made = map(&mut stages, request, Vec::new(), gauge);
        }
        let made = made.map_err(|error| error::of_field(&error))?;
        let brief = (begun.elapsed() < work::BRIEF).then(|| alike(request));
        Self { backend, stages: Some(stages), brief }.give_back();
        Ok(made)
    }

    fn give_back(self) {
        let mut idle = idle();
        idle.push(self);
        if idle.len() > KEPT {
            idle.remove(0);
        }
    }
}

fn map(stages: &mut Stages, request: &Request, memory: Vec<f32>, gauge: &Gauge) -> Result<Map, FieldError> {
    stages.show_progress(gauge.clone());
    let map = stages.take_map(request, memory);
    stages.show_progress(Gauge::default());
    map
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
