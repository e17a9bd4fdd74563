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
                let [normal, aside] =
                    [face.layout.normal(n), face.layout.aside(n)].map(|own| face.pose.world_direction(own));
                let own = match known {
                    Some((other, own)) if other == normal => own,
                    Some(_) | None => self.element.far(direction, normal, aside) * face.gain,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Array, Board, ElementModel, Medium, Reflector, Scene};

    #[test]
    fn a_direction_is_a_point_far_away() {
        /// m
        const FAR: f64 = 1e6;
        let array = Array { rows: 3, columns: 4, ..Array::default() };
        let medium = Medium { absorption: Some(0.0), ..Medium::default() };
        let tilted =
            Board { at: DVec3::new(0.1, 0.0, 0.02), normal: DVec3::new(-0.5, 0.2, 1.0), ..Board::default() };
        let floor = Reflector { point: DVec3::NEG_Z * 0.3, normal: DVec3::Z, ..Reflector::default() };
        let scenes = [(vec![], vec![]), (vec![Board::default(), tilted], vec![floor])];
        for (boards, reflectors) in scenes {
            for element in [ElementModel::Point, ElementModel::Piston, ElementModel::ExactPiston] {
                let array = Array { element, ..array.clone() };
                let scene = Scene {
                    array,
                    medium: medium.clone(),
                    boards: boards.clone(),
                    reflectors: reflectors.clone(),
                    ..Scene::default()
                };
                let aperture = Aperture::new(&scene);
                for way in [DVec3::Z, DVec3::new(0.3, -0.2, 1.0), DVec3::new(-0.9, 0.4, 0.2)] {
                    let way = way.normalize_or_zero();
                    let there = aperture.transfer(&[way * FAR]);
                    let turn = Complex64::from_polar(FAR, aperture.element.wavenumber * FAR);
                    for (heard, far) in there.row(0).zip(aperture.far_field(way)) {
                        let off = (heard * turn - far).norm();
                        // The front is curved by k x²/2r.
                        assert!(
                            off < 1e-3 * aperture.element.strength,
                            "{element:?} {way}: {}, not {far}",
                            heard * turn
                        );
                    }
                }
            }
        }
    }
}
