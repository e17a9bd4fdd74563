//! Arrows over a map: the vectors behind its values in the plane, in f64.
//!
//! The particle velocity of a point runs on an ellipse. Its arrow lies along the major axis of the ellipse in the plane, or of
//! the mean ⟨v vᵀ⟩ of several drives in turn, is as long as the RMS of the velocity in the plane, and points to the side to
//! which energy flows: in a plane wave along the beam. The arrow of an intensity is the mean flow of energy, and that of a
//! potential or a force the radiation force on the bead.

use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::field::slope::SoundTransfer;
use crate::field::sound::{ALONG, Constants, PRESSURE, Sound};
use crate::field::{Quantity, Request};
use crate::force::Levitation;
use crate::scene::Bead;

/// Arrows along the longer side of a map.
const ALONG_SIDE: f64 = 21.0;
/// Quantile of length for the longest arrow: vectors are long close to the array.
const USUAL: f64 = 0.95;
/// Length of the longest arrow over the distance of neighbours.
const LONGEST: f64 = 0.9;

/// A kind of vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vector {
    /// Particle velocity, m/s RMS.
    Velocity,
    /// Mean flow of energy, W/m².
    Intensity,
    /// Radiation force on a bead, N.
    Force,
}

impl Vector {
    /// The vector behind a quantity.
    pub fn of(quantity: Quantity) -> Option<Self> {
        match quantity {
            Quantity::Velocity | Quantity::Speed => Some(Self::Velocity),
            Quantity::Intensity => Some(Self::Intensity),
            Quantity::Gorkov | Quantity::Force => Some(Self::Force),
            Quantity::Rms
            | Quantity::Phase
            | Quantity::Depression
            | Quantity::Instantaneous
            | Quantity::Radiation
            | Quantity::Caustic
            | Quantity::Harmonic
            | Quantity::Skin
            | Quantity::Felt => None,
        }
    }

    /// The vectors of drives in turn at points; of velocity and intensity their parts in the plane of two axes.
    pub fn at(
        self,
        (aperture, air, bead): (&Aperture, &Air, &Bead),
        drives: &[Drive],
        axes: [DVec3; 2],
        points: &[DVec3],
    ) -> Vec<DVec3> {
        if self == Self::Force {
            return Levitation::in_air(aperture, (air, bead), drives, 0.0).forces_at(points);
        }
        let constants = Constants::new(air, aperture.element.wavenumber, 0.0);
        let transfer = SoundTransfer::new(
            aperture,
            PRESSURE | ALONG,
            [axes[0], axes[1], axes[0].cross(axes[1])],
            points,
        );
        let mut moments = vec![Moments::default(); points.len()];
        for drive in drives {
            let sounds = transfer.sounds(&drive.excitation(&aperture.driven));
            moments.iter_mut().zip(sounds).for_each(|(moments, sound)| moments.add(sound, &constants));
        }
        let count = drives.len().max(1) as f64;
        let flat = |moments: &Moments| match self {
            Self::Velocity => moments.velocity(count),
            Self::Intensity | Self::Force => moments.flow / count,
        };
        moments.iter().map(flat).map(|way| axes[0] * way.x + axes[1] * way.y).collect()
    }
}

/// Sums over drives of v vᵀ (mean over time, m²/s²) and of the flow of energy (W/m²) in the plane.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    xx: f64,
    xy: f64,
    yy: f64,
    flow: DVec2,
}

impl Moments {
    fn add(&mut self, sound: Sound<f64>, constants: &Constants<f64>) {
        let [x, y] = [sound.x, sound.y].map(|slope| Complex64::I * slope * constants.of_velocity);
        self.xx += x.norm_sqr() / 2.0;
        self.yy += y.norm_sqr() / 2.0;
        self.xy += (x * y.conj()).re / 2.0;
        self.flow += DVec2::new((sound.p * x.conj()).re, (sound.p * y.conj()).re) / 2.0;
    }

    fn velocity(&self, count: f64) -> DVec2 {
        let angle = (2.0 * self.xy).atan2(self.xx - self.yy) / 2.0;
        let way = DVec2::from_angle(angle) * ((self.xx + self.yy) / count).sqrt();
        if way.dot(self.flow) < 0.0 { -way } else { way }
    }
}

/// The arrows of a map, tail and tip in m from the middle of its plane along its axes; roots of lengths, so that weak
/// vectors have a direction, too.
pub fn arrows(request: &Request) -> Vec<[DVec2; 2]> {
    let Some(vector) = Vector::of(request.quantity) else { return Vec::new() };
    let Some((x, y)) = request.plane.axes() else { return Vec::new() };
    let size = request.plane.size;
    let apart = size.max_element() / ALONG_SIDE;
    let [columns, rows] = (size / apart).to_array().map(|count| count.floor().max(1.0) as usize);
    let middle = DVec2::new(columns as f64 - 1.0, rows as f64 - 1.0) / 2.0;
    let place =
        |index: usize| (DVec2::new((index % columns) as f64, (index / columns) as f64) - middle) * apart;
    let places: Vec<_> = (0..columns * rows).map(place).collect();
    let points: Vec<_> = places.iter().map(|at| request.plane.centre + x * at.x + y * at.y).collect();
    let Request { aperture, air, bead, drives, .. } = request;
    let vectors = vector.at((aperture, air, bead), drives, [x, y], &points);
    let flat: Vec<_> = vectors.iter().map(|way| DVec2::new(way.dot(x), way.dot(y))).collect();
    let usual = usual(&flat);
    let arrow = |(at, way): (&DVec2, &DVec2)| {
        let half = way.normalize_or_zero() * (LONGEST * apart * part(*way, usual) / 2.0);
        [*at - half, *at + half]
    };
    places.iter().zip(&flat).filter(|(_, way)| way.is_finite() && usual > 0.0).map(arrow).collect()
}

/// The length of the longest arrow: only a few vectors are longer.
pub fn usual(vectors: &[DVec2]) -> f64 {
    let mut sizes: Vec<_> = vectors.iter().map(|way| way.length()).filter(|size| size.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get((sizes.len() as f64 * USUAL) as usize).copied().unwrap_or(0.0)
}

/// The length of an arrow, relative to the longest.
pub fn part(way: DVec2, usual: f64) -> f64 {
    (way.length() / usual).min(1.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Medium, Plane, Scene, Shape, Target};
    use crate::solver;

    #[test]
    fn arrows_of_a_plane_wave_point_along_the_beam() {
        let way = DVec3::new(0.2, 0.0, 1.0).normalize_or_zero();
        let target = Target::new(Shape::Direction { direction: way });
        let plane = Plane {
            centre: way * 3.0,
            x_axis: DVec3::X,
            y_axis: DVec3::Z,
            size: DVec2::splat(0.1),
            ..Plane::default()
        };
        let medium = Medium { absorption: Some(0.0), ..Medium::default() };
        let scene = Scene { targets: vec![target], plane, medium, ..Scene::default() };
        let solution = solver::solve(&scene).unwrap();
        let of = |quantity| Request::new(&scene, solution.drives(), quantity, (1, 1));
        for quantity in [Quantity::Velocity, Quantity::Speed, Quantity::Intensity] {
            let arrows = arrows(&of(quantity));
            assert_eq!(arrows.len(), 21 * 21);
            for [tail, tip] in arrows {
                let along = (tip - tail).normalize_or_zero();
                assert!(along.dot(DVec2::new(way.x, way.z)) > 0.999, "{quantity:?}: {along}");
            }
        }
        // In the middle |v| = |p|/ρc, to the order of 1/kr.
        let Request { aperture, air, bead, drives, .. } = of(Quantity::Velocity);
        let axes = [DVec3::X, DVec3::Z];
        let at = |vector: Vector| vector.at((&aperture, &air, &bead), &drives, axes, &[way * 3.0])[0];
        let played = solution.drive.excitation(&aperture.driven);
        let rms = aperture.pressures(&[way * 3.0], &played)[0].norm() / 2f64.sqrt();
        let impedance = air.density * air.sound_speed;
        assert!((at(Vector::Velocity).length() * impedance / rms - 1.0).abs() < 1e-3);
        assert!((at(Vector::Intensity).length() * impedance / (rms * rms) - 1.0).abs() < 1e-3);
    }
}
