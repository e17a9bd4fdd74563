//! The field of a drive at many points: in f64 as the reference, and in f32 for speed, on the CPU and on the GPU.
//!
//! [`Stages`] makes the maps: a [`Request`] (array, air, plane with its tolerance, drives, quantity, size) becomes
//! a [`Map`] (values, peak, error). A [`Quantity`] declares once what is formed from the sound. `stages` holds the
//! order of the steps, `plan` the theory of sampling, `volume` fields and pictures in space.
//!
//! The two f32 evaluators do the same sums with the same polynomials from the same [`Sources`]; tests compare them
//! with the reference.

pub mod cells;
pub mod colouring;
pub mod contour;
pub mod cpu;
mod evaluator;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
pub mod gpu;
mod gpu_report;
pub mod interpolation;
pub mod plan;
pub mod polynomial;
pub mod quantity;
pub mod raster;
pub mod reference;
mod samples;
pub mod side_lobe;
pub mod slope;
pub mod sound;
pub mod sources;
pub mod stages;
pub mod summit;
pub mod transfer;
mod unit;
mod vicinity;
pub mod volume;

pub use colouring::{Colouring, Scale};
pub use evaluator::{Evaluator, peak};
pub use gpu::Gpu;
pub use gpu_report::{GpuError, Traffic};
pub use plan::{Plan, missed, promised};
pub use quantity::Quantity;
pub use raster::Raster;
pub use samples::Samples;
pub use side_lobe::{NoSideLobe, SideLobe};
pub use sources::{Sources, Wave};
pub use stages::{By, Depression, FieldError, Map, Pressed, Request, Stages, Work};
