//! The second harmonic: what finite amplitudes add to a sound at twice its frequency on the way.
//!
//! Westervelt's equation, ∇²p - p̈/c² = -β/(ρc⁴) ∂²(p²)/∂t², has for p = Re{P e^{jωt}} the source of 2ω in p² =
//! |P|²/2 + Re{P² e^{2jωt}}/2. In second order (quasi-linear: the harmonic takes nothing from the fundamental),
//!
//! ```text
//! ∇²P₂ + K²P₂ = q P²,    q = 2βk²/(ρc²),    K = 2k - jα₂
//! P₂(x) = -q ∫ P(x')² e^{-jKR}/(4πR) dV',    R = |x - x'|
//! ```
//!
//! with the absorption α₂ at 2f, and β = 1 + (γ - 1)/2 = 1.2 of air. A plane wave P e^{-jkx} gives |P₂| = βkx|P|²/(2ρc²),
//! the first term of Fubini's solution. P is the sound of the program with its own element model, before the boards;
//! an image in a rigid reflector is a board beyond it, in front of which the mirrored air sounds too: its integral is
//! the reflection of the harmonic. Other reflectors are refused ([`NoHarmonic`]).
//!
//! P₂ grows with the square of the drive, and P₂/P with the drive itself. It is right while it is small: at a ratio r
//! the fundamental loses about r²/2 of itself, and P₂ as much again.
//!
//! Two ways lead to it: [`at`] sums the integral itself for one loud point, in spherical coordinates about it, and
//! [`over`] marches plane waves of 2f through the air for all points of a plane. Tests compare both with each other
//! and with sums on lattices.

mod march;
mod point;
mod source;

pub use march::{MarchError, Overtone, Sampler, over};
pub use point::at;
pub use source::{NONLINEARITY, NoHarmonic, TOLERANCE};
