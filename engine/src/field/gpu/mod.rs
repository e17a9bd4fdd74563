//! The GPU evaluator: opening a device, and running the programs of a map on it.
//!
//! Objects are sorted by lifetime: [`Gpu`] holds the device and its pipelines, [`Chain`] the buffers and bind groups
//! of one map and its passes, [`Reading`] pending read-backs.

pub mod adapter;
pub mod chain;
mod device;
mod forming;
mod gathering;
mod painting;
pub mod program;
mod reading;
mod resampling;
mod space;
mod superposition;
pub mod tuning;

pub use chain::{Chain, Shape};
pub use device::{Gpu, device_descriptor};
pub use gathering::Gathered;
pub use painting::Texture;
pub use reading::Reading;
pub use space::SpacePainting;
pub use tuning::AdapterInfo;
