//! Measured fields: the gains of all elements, and the bench, that explain the readings of a microphone.
//!
//! # Model
//! A reading at x_i under drive d is
//!
//! ```text
//! p_i = ⟨Σ_n H_n(x_i; θ) g_n u_dn⟩,
//! ```
//!
//! H the transfer of [`crate::acoustics`], g_n the complex gain of an element (0 dead, negative reversed), u the known drive,
//! ⟨⟩ the mean over the microphone's disk, and θ the bench ([`Bench`]): shift and tilt of the scan, speed of sound, radius of
//! the elements, diameter of the microphone. A microphone beside a lock-in amplifier reads p with an unknown constant phase,
//! any other its modulus. The phase common to all g is free.
//!
//! # Fit
//! Least squares over g and θ by Levenberg's and Marquardt's damping of Gauss-Newton steps ([`fit()`]): with complex readings and a
//! known bench the problem is linear, and one step solves it. With moduli the first guess g = 1 leads to the solution if the
//! drive is random: then every reading tells of all elements. Under a focus most readings are side lobes, whose phases the
//! guess does not know.
//!
//! # Bench
//! A parameter that is fitted although it is right costs accuracy of the others: shifts take the slope of the phases. One
//! that is wrong and not fitted leaves a residual. With v its column of the Jacobian less its projection on the others', r the
//! residual at the optimum without it and σ² the variance of the readings, freeing it would lower the sum of squares by
//! (r·v)²/(v·v), and (r·v)²/(v·v)/σ² is distributed as χ² of one degree of freedom if it is right. Parameters are freed in
//! order of this figure while it exceeds [`SIGNIFICANT`] (shifts across, and tilts, in pairs). Standard
//! errors of the bench are those with all its parameters unknown. Each parameter is also expected about its nominal value, normally with
//! [`Parameter::scatter`], which counts like a reading: of two that explain the same, such as radius and speed of sound for
//! one element's directivity, the likelier is chosen.
//!
//! # Errors
//! Standard errors are those of the inverse of JᵀJ, σ² from the sum of squares over readings less unknowns; before a scan
//! ([`plan`]), with σ from an assumed signal-to-noise ratio, they are the Cramér-Rao bound. Signal-to-noise is the root mean
//! square of the readings over that of the noise of p, complex: a modulus and both parts have 1/√2 of it.

mod bench;
mod depression;
mod equations;
mod fit;
mod forward;
pub mod plan;
mod scan;
mod state;

pub use bench::{Bench, Parameter};
pub use depression::{DepressionFit, fit_depression};
pub use fit::{Estimate, Fit, SIGNIFICANT, Search, Vague, fit};
pub use scan::{MeasureError, Readings, Scan};
pub use state::State;
