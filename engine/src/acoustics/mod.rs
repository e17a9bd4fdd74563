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

pub mod air;
mod aperture;
mod bessel;
mod clearance;
mod derivatives;
mod disk;
pub mod element;
mod emitters;
mod face;
mod jacobian;
mod row;
mod slopes;
mod transfer;

pub use air::{Air, viscosity};
pub use aperture::Aperture;
pub use clearance::Clearance;
pub use derivatives::{Along, Derivatives};
pub use element::Element;
pub use emitters::Emitters;
pub use face::{Face, Layout, Pose};
pub use jacobian::PhaseJacobian;
pub use transfer::{Phasors, Sums, Transfer};
