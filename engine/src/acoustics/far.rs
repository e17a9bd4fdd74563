//! The far field: what the array radiates towards a direction, as towards a point at infinity.
//!
//! From an element at x the way to a point at the distance r towards the unit vector d is r - d·x for large r, so its
//! wave S D(θ)/r · j e^{-jk(r - d·x)} has the limit
//!
//! ```text
//! r e^{jkr} P = S D(θ) j e^{jk d·x}
//! ```
//!
//! with θ the angle between d and its normal. Without absorption, which would silence infinity, this is the pressure
//! (Pa) at 1 m of a point source that sounds alike. Images in reflectors radiate as elements do.

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::{aperture::Aperture, transfer::Transfer};
use crate::scene::Focus;

impl Aperture {
    /// The limit of r e^{jkr} P (Pa·m, peak) towards a direction, a unit vector, per unit of drive of each driven element.
    #[doc(hidden)]
    pub fn far_field(&self, direction: DVec3) -> Vec<Complex64> {
        let mut heard = vec![Complex64::ZERO; self.driven.len()];
        for face in &self.faces {
            // Elements of a flat board have one normal.
            let mut known: Option<(DVec3, Complex64)> = None;
            for column in face.among(&self.driven) {
                let n = self.driven[column] - face.first;
                let way = direction.dot(face.pose.world(face.layout.positions[n]));
                let normal = face.pose.world_direction(face.layout.normal(n));
                let own = match known {
                    Some((other, own)) if other == normal => own,
                    Some(_) | None => self.element.far(direction, normal) * face.gain,
                };
                known = Some((normal, own));
                heard[column] += own * Complex64::from_polar(1.0, self.element.wavenumber * way);
            }
        }
        heard
    }

    /// H for foci: a row per focus, of a direction with the far field at 1 m.
    #[doc(hidden)]
    pub fn transfer_to(&self, foci: &[Focus]) -> Transfer {
        let points: Vec<_> = foci.iter().map(|focus| focus.position).collect();
        let mut transfer = self.transfer(&points);
        for (row, focus) in foci.iter().enumerate().filter(|(_, focus)| focus.is_direction()) {
            for (column, heard) in self.far_field(focus.position).into_iter().enumerate() {
                transfer.set(row, column, heard);
            }
        }
        transfer
    }

    /// [`Aperture::pressures`] at foci.
    ///
    /// # Panics
    /// Other than a value per driven element and drive.
    #[doc(hidden)]
    pub fn pressures_of(&self, foci: &[Focus], drives: &[Complex64]) -> Vec<Complex64> {
        if foci.iter().any(Focus::is_direction) {
            return self.transfer_to(foci).in_turn(drives);
        }
        let points: Vec<_> = foci.iter().map(|focus| focus.position).collect();
        self.pressures(&points, drives)
    }
}
