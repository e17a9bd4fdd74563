//! From elements to points: the array's geometry, the air, and the transfer between them, in f64.
//!
//! ```
//! use glam::dvec3;
//! use sonoglyph::acoustics::Aperture;
//! use sonoglyph::scene::Scene;
//!
//! // What each of 256 elements sends to a point (m), Pa (peak) at full drive; in phase they add up.
//! let transfer = Aperture::new(&Scene::default()).transfer(&[dvec3(0.0, 0.0, 0.1)]);
//! let loudest: f64 = transfer.row(0).map(|h| h.norm()).sum();
//! assert!(loudest > 4000.0 && transfer.elements == 256);
//! ```

mod air;
mod aperture;
mod clearance;
#[doc(hidden)]
pub mod course;
mod disk;
pub(crate) mod element;
mod emitters;
mod ensemble;
mod face;
mod far;
mod jacobian;
mod normal;
mod partial;
#[doc(hidden)]
pub mod response;
mod row;
mod scattering;
mod slopes;
mod total;
mod transfer;

pub use air::{Air, absorption, viscosity};
pub use aperture::Aperture;
#[doc(hidden)]
pub use clearance::Clearance;
pub use element::Element;
#[doc(hidden)]
pub use element::{directivity, piston_nodes};
#[doc(hidden)]
pub use ensemble::Ensemble;
pub(crate) use ensemble::Moments;
pub use face::Face;
pub(crate) use face::{Layout, Pose};
pub(crate) use jacobian::PhaseJacobian;
#[doc(hidden)]
pub use partial::PartialWaves;
pub(crate) use partial::{Coupling, MOST as MOST_ORDER, couplings};
#[doc(hidden)]
pub use scattering::Scattering;
pub use transfer::Transfer;
pub(crate) use transfer::{Phasors, Sums};
