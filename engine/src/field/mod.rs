//! The field of a drive at many points: in f64 as the reference, and in f32 for speed, on the CPU and on the GPU.
//!
//! [`Stages`] makes the maps: a [`Request`] (array, air, plane with its tolerance, drives, quantity, size) becomes
//! a [`Map`] (values, peak, error). A [`Quantity`] declares once what is formed from the sound. `stages` holds the
//! order of the steps, `plan` the theory of sampling, `volume` fields and pictures in space.
//!
//! The two f32 evaluators do the same sums with the same polynomials from the same [`Sources`]; tests compare them
//! with the reference.

#[doc(hidden)]
pub mod cells;
pub(crate) mod colouring;
pub mod contour;
#[doc(hidden)]
pub mod cpu;
mod evaluator;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
pub mod gpu;
mod gpu_report;
#[doc(hidden)]
pub mod harmonic;
#[doc(hidden)]
pub mod interpolation;
mod partial;
#[doc(hidden)]
pub mod plan;
#[doc(hidden)]
pub mod polynomial;
pub(crate) mod quantity;
#[doc(hidden)]
pub mod raster;
pub mod reference;
mod samples;
mod side_lobe;
#[doc(hidden)]
pub mod slope;
#[doc(hidden)]
pub mod sound;
#[doc(hidden)]
pub mod sources;
pub(crate) mod stages;
mod summit;
#[doc(hidden)]
pub mod transfer;
mod unit;
mod vicinity;
pub mod volume;

pub use colouring::{Colouring, Scale};
#[doc(hidden)]
pub use colouring::{FLOOR, HATCH, hatch, phase_index};
pub use evaluator::{Evaluator, peak};
pub use gpu::Gpu;
pub use gpu_report::{GpuError, Traffic};
#[doc(hidden)]
pub use plan::{Plan, missed, promised};
#[doc(hidden)]
pub use quantity::figures;
pub use quantity::{Declaration, Norm, Quantity, Range, Unit};
#[doc(hidden)]
pub use raster::Raster;
pub use samples::Samples;
pub(crate) use side_lobe::side_lobes;
pub use side_lobe::{NoSideLobe, SideLobe, side_lobe};
#[doc(hidden)]
pub use sources::{Sources, Wave};
pub use stages::{By, Depression, FieldError, MOST_PIXELS, Map, Pressed, Request, Stages, Work};
#[doc(hidden)]
pub use stages::{Picture, SkinMotion};
