//! The GPU evaluator: opening a device, and running the programs of a map on it.
//!
//! Objects are sorted by lifetime: [`Gpu`] holds the device and its pipelines, [`Chain`] the buffers and bind
//! groups of one map and its passes, [`Reading`] pending read-backs.
//!
//! [`Chain`] lives as long as plan, size and quantity stay the same. A new drive writes the elements and a few
//! counts, then runs superposition, interpolation across, interpolation up with forming, and gathering; the sound
//! at the pixels is never written to memory. [`Texture`] holds the colours on the same device, scaled by the peak
//! on the device. Results for panels (peak and sound at the probes, less than 2 KiB) arrive a frame later through
//! one of three staging buffers; values are read back only on request (`Stages::map`, which waits, or
//! `Stages::poll`, which never does). Maps with too large an error are computed on the CPU from the next frame on.
//! The GPU forms quantities of one drive at pixels; cells (being few), means and liquids are computed on the CPU.

pub mod adapter;
pub(crate) mod chain;
mod device;
mod emission;
mod forming;
mod gathering;
mod painting;
mod program;
mod reading;
mod resampling;
mod space;
mod superposition;
pub(crate) mod tuning;

pub(crate) use chain::{Chain, Shape};
#[doc(hidden)]
pub use device::{Gpu, device_descriptor};
pub(crate) use gathering::Gathered;
#[doc(hidden)]
pub use painting::Texture;
pub(crate) use reading::Reading;
#[doc(hidden)]
pub use space::SpacePainting;
pub use tuning::{AdapterInfo, Kind};
#[doc(hidden)]
pub use tuning::{MOST_GROUPS, Tuning};
