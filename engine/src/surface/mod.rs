//! A liquid's surface under steady or changing pressure, its depression, waves and caustics; and the skin's.
//!
//! The depression at rest is a division of cosine modes by ρg + σq². Waves advance the same modes, each with the
//! exact roots of its dispersion relation; a caustic is the light that the surface refracts to a screen.
//!
//! ```
//! use sonoglyph::scene::Liquid;
//! use sonoglyph::surface::Tank;
//!
//! // 1 Pa everywhere presses water down by p/(ρg), about 0.1 mm.
//! let tank = Tank::new([32, 32], [1e-3, 1e-3]);
//! let dent = tank.dent(&Liquid::default(), &[1.0; 32 * 32]);
//! assert!((dent.depth[0] - 1.0 / (998.2 * 9.80665)).abs() < 1e-9);
//! ```

pub(crate) mod caustic;
mod coverage;
pub(crate) mod dent;
mod dispersion;
#[doc(hidden)]
pub mod skin;
mod waves;

pub use caustic::Light;
#[doc(hidden)]
pub use caustic::{Rays, light};
pub use dent::{Dent, Tank};
#[doc(hidden)]
pub use dent::{STEEPEST, largest_drive};
pub use waves::{Rest, Stretch, Waves};
