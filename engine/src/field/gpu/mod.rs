//! The GPU evaluator: opening a device, and running the programs of a map on it.
//!
//! Objects are sorted by lifetime: [`Gpu`] holds the device and its pipelines, [`Chain`] the buffers and bind groups
//! of one map and its passes, [`Reading`] pending read-backs.

pub mod adapter;
pub(crate) mod chain;
mod device;
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
