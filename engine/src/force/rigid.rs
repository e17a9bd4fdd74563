//! Radiation force and torque on bodies, from the total sound at their surfaces.
//!
//! The mean flux of momentum through a surface just outside is, with v = j∇p/(ρω),
//!
//! F = -∮ ((|p|²/(4ρc²) - ρ|v|²/4) n + ½ρ Re(v (v·n)*)) dS,
//!
//! T = -∮ (x - at) × (...) dS (L. P. Gor'kov, Sov. Phys. Dokl. 6, 773, 1962, before his limit of small spheres). On a rigid
//! surface v·n = 0; one of the admittance β has v·n = -βp/(ρc). Bodies do not give way.

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::scatter::Patch;

/// The mean push of sound on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Push {
    /// N
    pub force: DVec3,
    /// N m, about the body's place.
    pub torque: DVec3,
    /// N, the sum of the magnitudes whose vectors make up the force: pressures on a body mostly cancel.
    pub gross: f64,
}

impl Push {
    /// The pushes on all bodies, the mean over drives.
    pub fn on_bodies(aperture: &Aperture, air: &Air, drives: &[Drive]) -> Vec<Self> {
        let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
        let mut means = vec![Self::default(); bodies.places().count()];
        for drive in drives {
            let Some((bodies, answer)) = aperture.answer(&drive.excitation(&aperture.driven)) else {
                continue;
            };
            let part = 1.0 / drives.len() as f64;
            for ((mean, at), patches) in means.iter_mut().zip(bodies.places()).zip(bodies.patches(&answer)) {
                let own = Self::of(&patches, at, (air, aperture.element.wavenumber));
                mean.force += own.force * part;
                mean.torque += own.torque * part;
                mean.gross += own.gross * part;
            }
        }
        means
    }

    /// The flux of momentum through a closed surface inwards, about a place (m), at a wavenumber (rad/m).
    pub(crate) fn of(patches: &[Patch], about: DVec3, (air, wavenumber): (&Air, f64)) -> Self {
        let unit = 0.25 / (air.density * air.sound_speed * air.sound_speed);
        let of_patch = |patch: &Patch| {
            let (p, gradient) = patch.sound;
            // v and v·n in Pa/m; (ρω)² ρ = ρc² k².
            let along: Complex64 =
                gradient.iter().zip(patch.normal.to_array()).map(|(slope, n)| slope * n).sum();
            let square: f64 = gradient.iter().map(|slope| slope.norm_sqr()).sum();
            let carried: DVec3 = gradient.map(|slope| (slope * along.conj()).re).into();
            let k2 = wavenumber * wavenumber;
            let normal = patch.normal * (p.norm_sqr() - square / k2);
            let force = (normal + carried * (2.0 / k2)) * (-unit * patch.area);
            Self { force, torque: (patch.at - about).cross(force), gross: force.length() }
        };
        patches
            .par_chunks(256)
            .map(|some| some.iter().map(of_patch).fold(Self::default(), Self::plus))
            .collect::<Vec<_>>()
            .into_iter()
            .fold(Self::default(), Self::plus)
    }

    fn plus(self, other: Self) -> Self {
        Self {
            force: self.force + other.force,
            torque: self.torque + other.torque,
            gross: self.gross + other.gross,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::{DVec2, dvec3};

    use super::*;
    use crate::force::Levitation;
    use crate::scene::{Array, Bead, Board, Body, BodyKind, ElementModel, Scene};
    use crate::special::gauss_legendre;

    /// Two boards of 4 x 4 that face each other beside the middle, in air that absorbs nothing, and a body.
    fn scene(body: Body) -> Scene {
        // Sound of points obeys the wave equation everywhere, that of far-field pistons does not.
        let element = ElementModel::Point;
        let array = Array { rows: 4, columns: 4, strength: 10.0, element, ..Array::default() };
        let above = Board { at: dvec3(0.01, 0.0, 0.09), normal: DVec3::NEG_Z, ..Board::default() };
        let mut scene = Scene { array, boards: vec![Board::default(), above], ..Scene::default() };
        scene.medium.absorption = Some(0.0);
        Scene { bodies: vec![body], ..scene }
    }

    fn drive(aperture: &Aperture) -> Drive {
        let focus = dvec3(0.002, 0.001, 0.043);
        let phases = aperture.positions.iter().map(|at| aperture.element.wavenumber * at.distance(focus));
        let amplitudes = (0..aperture.positions.len()).map(|n| 0.5 + 0.03 * (n % 16) as f64).collect();
        Drive { amplitudes, phases: phases.collect() }
    }

    /// The flux of momentum through a sphere around a body, of the total sound.
    fn through_sphere(aperture: &Aperture, air: &Air, drive: &Drive, (at, radius): (DVec3, f64)) -> Push {
        let (rings, around) = (40, 80);
        let excitation = drive.excitation(&aperture.driven);
        let mut patches = Vec::new();
        for (z, weight) in gauss_legendre(rings) {
            for turn in 0..around {
                let angle = TAU * f64::from(turn) / f64::from(around);
                let normal = (DVec2::from_angle(angle) * (1.0 - z * z).sqrt()).extend(z);
                let area = weight * TAU / f64::from(around) * radius * radius;
                patches.push((at + normal * radius, normal, area));
            }
        }
        let points: Vec<_> = patches.iter().map(|it| it.0).collect();
        let mut own = aperture.pressures_with_slopes(&points, &excitation);
        let scattered = aperture.scattered((&points, &DVec3::AXES), &excitation).unwrap();
        scattered.into_iter().enumerate().for_each(|(i, value)| own[i % 4][i / 4] += value);
        let patch = |(i, &(at, normal, area)): (usize, &(DVec3, DVec3, f64))| Patch {
            at,
            normal,
            area,
            sound: (own[0][i], [own[1][i], own[2][i], own[3][i]]),
        };
        let patches: Vec<_> = patches.iter().enumerate().map(patch).collect();
        assert!(
            (patches.iter().map(|it| it.area).sum::<f64>() / (4.0 * PI * radius * radius) - 1.0).abs() < 1e-9
        );
        Push::of(&patches, at, (air, aperture.element.wavenumber))
    }

    #[test]
    fn pushes_are_the_flux_through_a_sphere_around() {
        let at = dvec3(0.001, -0.002, 0.045);
        let sphere = Body { at, radius: 0.006, ..Body::default() };
        let soft = Body { coefficient: 0.4, ..sphere.clone() };
        let capsule = Body {
            kind: BodyKind::Capsule,
            normal: Some(dvec3(0.2, 0.3, 1.0)),
            radius: 0.003,
            length: 0.013,
            edge: Some(0.0012),
            ..sphere.clone()
        };
        let coarse = Body { edge: None, ..capsule.clone() };
        for (body, allowed) in [(sphere, 1e-6), (soft, 1e-6), (capsule, 0.01), (coarse, 0.02)] {
            let scene = scene(body.clone());
            let (aperture, air) = (Aperture::new(&scene), Air::new(&scene.medium, scene.array.frequency));
            let drive = drive(&aperture);
            let got = Push::on_bodies(&aperture, &air, std::slice::from_ref(&drive))[0];
            let expected = through_sphere(&aperture, &air, &drive, (at, 0.012));
            let name = format!("{:?} {}: {got:?}, not {expected:?}", body.kind, body.coefficient);
            let lever = 0.006 * got.gross;
            let off = got.force.distance(expected.force) / got.gross;
            println!("off: {off:e}, {:e}", got.torque.distance(expected.torque) / lever);
            assert!(off < allowed, "{name}");
            assert!(got.torque.distance(expected.torque) < allowed * lever, "{name}");
        }
    }

    #[test]
    fn a_small_body_is_pushed_as_a_heavy_bead() {
        let at = dvec3(0.001, -0.002, 0.045);
        let scene = scene(Body { at, radius: 0.0012, ..Body::default() });
        let (aperture, air) = (Aperture::new(&scene), Air::new(&scene.medium, scene.array.frequency));
        let drive = drive(&aperture);
        let got = Push::on_bodies(&aperture, &air, std::slice::from_ref(&drive))[0];
        let bead = Bead { density: Some(1e5), sound_speed: Some(1e5), radius: 0.0012, ..Bead::default() };
        let alone = aperture.without_bodies();
        let expected = Levitation::in_air(&alone, (&air, &bead), &[drive], 0.0).force(at);
        // A rigid body does not move; a bead of this density hardly does.
        assert!(got.force.distance(expected) < 2e-3 * expected.length(), "{got:?}, not {expected}");
        assert!(got.torque.length() < 1e-6 * 0.0012 * expected.length(), "{got:?}");
    }
}
