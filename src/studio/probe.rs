//! The sound of an unmodulated drive at single points, in f64.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::field::Quantity;
use crate::field::slope::SoundTransfer;
use crate::field::sound::Constants;
use crate::force::Levitation;
use crate::scene::{Bead, Focus, Scene, Spread};

/// Pa, RMS: 0 dB.
const REFERENCE: f64 = 20e-6;
/// Consensus limit (dB) for an ear between 25 and 50 kHz for less than 4 hours (Howard, Hansen and Zander, 2004).
pub const LIMIT: f64 = 110.0;

/// The warning about points in millimetres, by their distance from the array.
pub fn slip(scene: &Scene, points: &[DVec3]) -> Option<String> {
    /// m, and radii of the arrays.
    const FAR: f64 = 3.0;
    const RADII: f64 = 20.0;
    let aperture = Aperture::new(scene);
    let centre = aperture.positions.iter().sum::<DVec3>() / aperture.positions.len().max(1) as f64;
    let radius = aperture.positions.iter().map(|place| place.distance(centre)).fold(0.0, f64::max);
    let far = points.iter().map(|point| point.distance(centre));
    let count = far.clone().filter(|distance| *distance > FAR.max(RADII * radius)).count();
    // A far field may be asked for beside the near one.
    (2 * count > points.len()).then(|| {
        format!(
            "{count} of {} points are far from the array, up to {:.1} m: if they are millimetres, name the unit in the first \
             line, as in `x [mm],y [mm],z [mm]`; if metres, `x [m]`",
            points.len(),
            far.fold(0.0, f64::max)
        )
    })
}

/// The sound at one point; for several drives in turn, the modulus is the root mean square and the phase that of the
/// first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// m
    pub position: DVec3,
    /// Pa, peak.
    pub pressure: Complex64,
}

/// The sound of drives in turn at points in front of the array.
pub fn readings(aperture: &Aperture, drives: &[Drive], points: &[DVec3]) -> Vec<Reading> {
    let pressures = pressures(aperture, drives, points);
    points.iter().zip(pressures).map(|(&position, pressure)| Reading { position, pressure }).collect()
}

/// The sound of drives in turn at foci, towards directions at 1 m.
pub fn readings_of(aperture: &Aperture, drives: &[Drive], foci: &[Focus]) -> Vec<Reading> {
    let played: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
    let pressures = aperture.pressures_of(foci, &played);
    foci.iter()
        .zip(pressures)
        .map(|(focus, pressure)| Reading { position: focus.position, pressure })
        .collect()
}

/// The pressures of [`readings`].
pub fn pressures(aperture: &Aperture, drives: &[Drive], points: &[DVec3]) -> Vec<Complex64> {
    let played: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
    aperture.pressures(points, &played)
}

/// The same at one point.
pub fn reading(aperture: &Aperture, drives: &[Drive], position: DVec3) -> Reading {
    readings(aperture, drives, &[position])[0]
}

/// The values of a map at points of its plane, whose axes and normal these are; `moment` (rad) is that of an
/// instantaneous pressure. Empty for quantities that depend on more than the points; for several drives in turn, and
/// over a spread of elements, their mean or, without a mean, the first.
pub fn values(
    (aperture, air, bead, spread): (&Aperture, &Air, &Bead, Spread),
    drives: &[Drive],
    (quantity, moment): (Quantity, f64),
    axes: [DVec3; 3],
    points: &[DVec3],
) -> Vec<f64> {
    let declaration = quantity.declaration();
    if declaration.is_pressed() || declaration.of_volume {
        return Vec::new();
    }
    if declaration.of_bead {
        let levitation = Levitation::in_air(aperture, (air, bead), drives, 0.0);
        if quantity == Quantity::Force {
            return levitation.forces_at(points).into_iter().map(DVec3::length).collect();
        }
        return points.par_iter().map(|&point| levitation.potential(point)).collect();
    }
    let constants = Constants::new(air, aperture.element.wavenumber, moment);
    let drives = if declaration.has_mean { drives } else { &drives[..1] };
    let sound = SoundTransfer::new(aperture, declaration.parts, axes, points);
    let excitations: Vec<_> = drives.iter().map(|drive| drive.excitation(&aperture.driven)).collect();
    let means = sound.means_of_arrays(&excitations, spread, (quantity, &constants));
    means.into_iter().map(|mean| quantity.exact_value(mean)).collect()
}

/// The sound of the mean square of all, with the phase of the first.
pub fn mean(drives: &[Vec<Complex64>]) -> Vec<Complex64> {
    if let [one] = drives {
        return one.clone();
    }
    let modulus = |index: usize| {
        let squares = drives.iter().map(|pressures| pressures[index].norm_sqr()).sum::<f64>();
        (squares / drives.len() as f64).sqrt()
    };
    let first = drives.iter().take(1).flatten().enumerate();
    first.map(|(index, p)| Complex64::from_polar(modulus(index), p.arg())).collect()
}

/// A row per point: where it is, and its pressure.
pub fn pressures_csv(points: &[DVec3], pressures: &[Complex64]) -> String {
    let of = |(&position, &pressure): (&DVec3, &Complex64)| {
        let rms = Reading { position, pressure }.rms();
        row(position.to_array().into_iter().chain([pressure.re, pressure.im, rms]))
    };
    "x,y,z,re,im,rms\n".to_owned() + &points.iter().zip(pressures).map(of).collect::<String>()
}

/// A row per point: where it is, the potential (J), the force (N) and the symmetric part of the stiffness (N/m).
pub fn forces_csv(levitation: &Levitation, points: &[DVec3]) -> String {
    let rows = points.par_iter().map(|&point| {
        let forces = levitation.forces(point);
        let k = forces.symmetric();
        let stiffness = [k.x_axis.x, k.x_axis.y, k.x_axis.z, k.y_axis.y, k.y_axis.z, k.z_axis.z];
        row(point
            .to_array()
            .into_iter()
            .chain([forces.gorkov])
            .chain(forces.force.to_array())
            .chain(stiffness))
    });
    "x,y,z,gorkov,fx,fy,fz,kxx,kxy,kxz,kyy,kyz,kzz\n".to_owned() + &rows.collect::<String>()
}

/// A line of CSV, to the last digit.
fn row(values: impl Iterator<Item = f64>) -> String {
    values.map(|value| format!("{value:?}")).collect::<Vec<_>>().join(",") + "\n"
}

impl Reading {
    /// Pa
    pub fn peak(&self) -> f64 {
        self.pressure.norm()
    }

    /// Pa
    pub fn rms(&self) -> f64 {
        self.peak() * FRAC_1_SQRT_2
    }

    /// Sound pressure level, dB re 20 µPa.
    pub fn spl(&self) -> f64 {
        20.0 * (self.rms().max(f64::MIN_POSITIVE) / REFERENCE).log10()
    }

    /// rad, in (-π, π].
    pub fn phase(&self) -> f64 {
        self.pressure.arg()
    }

    /// The warning for a listener at this point.
    pub fn warning(&self) -> Option<String> {
        (self.spl() > LIMIT).then(|| {
            format!(
                "louder than {LIMIT:.0} dB at the listener, the exposure limit between 25 and 50 kHz for less than 4 hours: increase the \
                 distance, shield the array, or reduce the drive"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ElementModel, Scene};

    fn one_element() -> Aperture {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns, scene.array.element) = (1, 1, ElementModel::Point);
        scene.medium.absorption = Some(0.0);
        Aperture::new(&scene)
    }

    #[test]
    fn one_element_is_as_loud_as_its_strength_says() {
        let aperture = one_element();
        let drive = |amplitude: f64| [Drive { amplitudes: vec![amplitude], phases: vec![1.0] }];
        let read = |amplitude: f64, z: f64| reading(&aperture, &drive(amplitude), DVec3::Z * z);
        // 3.4 Pa·m at half a metre is 6.8 Pa peak and 4.81 Pa RMS.
        let near = read(1.0, 0.5);
        assert!(
            (near.peak() - 6.8).abs() < 1e-9 && (near.rms() - 6.8 / 2f64.sqrt()).abs() < 1e-9,
            "{near:?}"
        );
        assert!((near.spl() - 107.62).abs() < 0.01, "{near:?}");
        assert!((near.spl() - read(1.0, 5.0).spl() - 20.0).abs() < 1e-9, "ten times as far is 20 dB less");
        assert!((near.spl() - read(0.1, 0.5).spl() - 20.0).abs() < 1e-9, "a tenth of the drive is too");
        assert_eq!(near.warning(), None);
        let loud = read(1.0, 0.3);
        assert!(loud.warning().is_some_and(|text| text.contains("110 dB")), "{loud:?}");
        assert!(read(0.0, 0.5).spl().is_finite(), "silence is a number too");
    }

    #[test]
    fn a_reading_has_the_values_of_maps() {
        let (aperture, drives) = (one_element(), [Drive { amplitudes: vec![0.5], phases: vec![-0.4] }]);
        let air = Air::new(&crate::scene::Medium::default(), 40e3);
        let points = [0.2, 0.31].map(|z| DVec3::new(0.01, 0.0, z));
        let all = readings(&aperture, &drives, &points);
        for (read, &point) in all.iter().zip(&points) {
            assert_eq!((*read, read.position), (reading(&aperture, &drives, point), point));
            let value = |quantity, moment| {
                let axes = [DVec3::X, DVec3::Y, DVec3::Z];
                let of = (&aperture, &air, &Bead::default(), Spread::default());
                values(of, &drives, (quantity, moment), axes, &[point])[0]
            };
            assert!((value(Quantity::Rms, 0.7) - read.rms()).abs() < 1e-6 * read.rms());
            // The wave's crest passes when its phase and ωt make a whole turn.
            let crest = value(Quantity::Instantaneous, -value(Quantity::Phase, 0.0));
            assert!((crest - read.peak()).abs() < 1e-6 * read.peak(), "{read:?}");
            // A spherical wave carries |P|²/(2ρc), nearly all of it along the normal here.
            let intensity = read.peak().powi(2) / (2.0 * air.density * air.sound_speed);
            assert!((value(Quantity::Intensity, 0.0) / intensity - 1.0).abs() < 1e-3, "{read:?}");
            let speed = value(Quantity::Velocity, 0.0) * air.density * air.sound_speed;
            assert!((speed / read.rms() - 1.0).abs() < 3e-3, "{read:?}: {speed}");
        }
    }
}
