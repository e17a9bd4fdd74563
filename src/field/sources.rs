//! What the f32 evaluators need to know of the array and its drive, with every constant found in f64.
//!
//! Phase is counted in turns and reduced by `t - round(t)`: shading languages promise nothing for the sine of a large
//! angle. Sine, cosine and directivity are polynomials of our own, so that both evaluators mean the same thing.
//!
//! All elements lie in z = 0, so a distance is r = z + ρ²/(r + z), and e^{-jkz} is common to all elements: it is applied
//! once per sample with a phase reduced in f64, and f32 sees the small second part alone. That keeps far planes as
//! exact as near ones.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::acoustics::Aperture;
use crate::acoustics::element::{self, NEAREST, SMALLEST_DISK};
use crate::drive::Drive;
use crate::field::{Samples, polynomial};
use crate::scene::ElementModel;

/// Coefficients of sin(πf)/f in f², |f| ≤ ½, lowest first; 7e-9 off before rounding.
pub const SINE: [f32; 5] = [std::f32::consts::PI, -5.167_71, 2.550_077_4, -0.598_290_4, 0.077_655_91];
/// Coefficients of cos(πf) in f², |f| ≤ ½, lowest first; 1e-9 off before rounding.
pub const COSINE: [f32; 6] = [1.0, -4.934_802, 4.058_711_5, -1.335_24, 0.235_074_37, -0.024_627_112];

/// Largest error of [`Wave::directivity`] and [`Wave::decay`]; beyond, the f32 evaluators decline.
const POLYNOMIAL_ERROR: f64 = 1e-6;
/// Nodes of the exact piston that the evaluators have room for, and the relative error they are chosen for.
pub const MOST_NODES: usize = 64;
const NODE_ERROR: f64 = 1e-7;

/// The sounding elements and the constants of their waves.
#[derive(Clone, Debug, PartialEq)]
pub struct Sources {
    pub wave: Wave,
    /// x (m), y (m), phase (turns, the quarter turn of the transfer's j included), amplitude (Pa·m, what is lost up to
    /// the nearest distance taken off).
    pub elements: Vec<[f32; 4]>,
}

/// The constants of the wave that every element sends to some samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Wave {
    /// 1/λ, as f32 has it for distances and as f64 has it for [`Wave::turns`].
    pub turns_per_metre: f32,
    exact_turns_per_metre: f64,
    /// Of an element at full drive, as in [`Sources::elements`].
    strength: f64,
    /// D in s = 2 sin²θ - 1.
    pub directivity: Polynomial<24>,
    /// e^{-α(r - near)} in s = `decay_scale[0]` · r + `decay_scale[1]`, which runs from -1 at the nearest to 1 at the
    /// farthest distance that occurs.
    pub decay: Polynomial<16>,
    pub decay_scale: [f32; 2],
    /// Present for the exact piston.
    pub piston: Option<Piston>,
}

/// Coefficients for s in [-1, 1], lowest first, padded with zeros up to the room that there is.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial<const MOST: usize> {
    pub coefficients: [f32; MOST],
    /// How many of them are not padding.
    pub terms: usize,
}

/// Terms of the directivity that usual elements need: 5e-8 off at ka = 4.6. With all 24 it is so up to ka = 26.
pub const FEW_DIRECTIVITY: usize = 7;
/// Terms of the decay that air needs: 1e-7 off where 2.4 dB are lost between the nearest and the farthest distance.
pub const FEW_DECAY: usize = 4;

/// Constants of the exact piston's integral.
#[derive(Clone, Debug, PartialEq)]
pub struct Piston {
    /// m
    pub radius: f32,
    /// cos ψ and 4 a sin²(ψ/2) at the nodes.
    pub nodes: Vec<[f32; 2]>,
}

impl Sources {
    /// What a drive makes of the array; silent elements are left out. `None` where [`Wave::new`] gives none.
    pub fn new(aperture: &Aperture, drive: &Drive, samples: &Samples) -> Option<Self> {
        let wave = Wave::new(aperture, samples)?;
        let sounding = aperture.driven.iter().filter(|&&n| drive.amplitudes[n] != 0.0);
        let elements = sounding
            .map(|&n| wave.element(aperture.positions[n], drive.amplitudes[n], drive.phases[n]))
            .collect();
        Some(Self { wave, elements })
    }
}

impl Wave {
    /// `None` for elements and absorption beyond f32's polynomials: a radius above four wavelengths, or more than about
    /// 40 dB between the nearest and the farthest distance; and for an exact piston that is no disk.
    pub fn new(aperture: &Aperture, samples: &Samples) -> Option<Self> {
        let element = &aperture.element;
        if element.model == ElementModel::ExactPiston && element.radius < SMALLEST_DISK {
            return None;
        }
        let turns_per_metre = element.wavenumber / TAU;
        let sought = |s: f64| element.directivity(((s + 1.0) / 2.0).max(0.0).sqrt());
        let directivity = Polynomial::fit(FEW_DIRECTIVITY, sought)?;
        let (near, far) = distances(aperture, samples);
        let (middle, half) = ((far + near) / 2.0, (far - near) / 2.0);
        let decay = Polynomial::fit(FEW_DECAY, |s| (-element.attenuation * half * (1.0 + s)).exp())?;
        Some(Self {
            turns_per_metre: turns_per_metre as f32,
            exact_turns_per_metre: turns_per_metre,
            strength: element.strength * (-element.attenuation * near).exp(),
            directivity,
            decay,
            decay_scale: [(1.0 / half) as f32, (-middle / half) as f32],
            piston: (element.model == ElementModel::ExactPiston).then(|| piston(aperture, samples)),
        })
    }

    /// An element at a position (m) with an amplitude and a phase (rad), as in [`Sources::elements`].
    pub fn element(&self, position: DVec2, amplitude: f64, phase: f64) -> [f32; 4] {
        let turns = phase / TAU + 0.25;
        let amplitude = self.strength * amplitude;
        [position.x as f32, position.y as f32, (turns - turns.round()) as f32, amplitude as f32]
    }

    /// The part of a turn, in [-½, ½], in a way of `z` (m).
    pub fn turns(&self, z: f64) -> f32 {
        let turns = z * self.exact_turns_per_metre;
        (turns - turns.round()) as f32
    }
}

impl<const MOST: usize> Polynomial<MOST> {
    /// Chebyshev interpolation with `few` terms, with all there is room for, or `None` if neither is near enough.
    fn fit(few: usize, sought: impl Fn(f64) -> f64) -> Option<Self> {
        let fitting = |terms: usize| {
            let found = polynomial::fit(&sought, terms);
            let off = |i: usize| {
                let s = i as f64 / 100.0 - 1.0;
                (polynomial::evaluate(&found, s) - sought(s)).abs()
            };
            (0..=200).all(|i| off(i) < POLYNOMIAL_ERROR).then_some(found)
        };
        let found = fitting(few).or_else(|| fitting(MOST))?;
        let mut coefficients = [0.0; MOST];
        for (to, from) in coefficients.iter_mut().zip(&found) {
            *to = *from as f32;
        }
        Some(Self { coefficients, terms: found.len() })
    }
}

/// Bounds of every distance (m) between an element and a sample.
fn distances(aperture: &Aperture, samples: &Samples) -> (f64, f64) {
    let (low, high) = samples.bounds();
    let (first, last) = aperture.corners();
    let far = (high - first.extend(0.0)).abs().max((low - last.extend(0.0)).abs()).length();
    let near = low.z.max(0.0);
    // A single point straight above a single element still needs a range to scale by.
    (near, far.max(near + 0.01))
}

/// As many nodes as the sample nearest to a rim needs.
fn piston(aperture: &Aperture, samples: &Samples) -> Piston {
    let (a, k) = (aperture.element.radius, aperture.element.wavenumber);
    let z = samples.bounds().0.z.max(NEAREST);
    let count = element::piston_nodes(k * a, 1.0, z / a, NODE_ERROR).min(MOST_NODES);
    let node = |i: usize| {
        let psi = PI * (i as f64 + 0.5) / count as f64;
        [psi.cos() as f32, (4.0 * a * (psi / 2.0).sin().powi(2)) as f32]
    };
    Piston { radius: a as f32, nodes: (0..count).map(node).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Plane, Scene};

    fn aperture(ka: f64) -> Aperture {
        let mut aperture = Aperture::new(&Scene::default());
        aperture.element.radius = ka / aperture.element.wavenumber;
        aperture
    }

    fn wave(aperture: &Aperture) -> Option<Wave> {
        Wave::new(aperture, &Samples::on_plane(&Plane::default(), 4, 4)?)
    }

    #[test]
    fn few_terms_serve_the_usual_element_and_more_the_large_one() {
        for (ka, expected) in [(3.66, Some(FEW_DIRECTIVITY)), (9.2, Some(24)), (20.0, Some(24)), (60.0, None)]
        {
            assert_eq!(wave(&aperture(ka)).map(|wave| wave.directivity.terms), expected, "ka = {ka}");
        }
    }

    #[test]
    fn strong_absorption_takes_more_terms_or_none() {
        for (attenuation, expected) in
            [(0.0, Some(FEW_DECAY)), (0.15, Some(FEW_DECAY)), (5.0, Some(16)), (500.0, None)]
        {
            let mut aperture = aperture(3.66);
            aperture.element.attenuation = attenuation;
            assert_eq!(wave(&aperture).map(|wave| wave.decay.terms), expected, "{attenuation} Np/m");
        }
    }

    #[test]
    fn every_distance_lies_in_the_decays_range() {
        let aperture = aperture(3.66);
        let plane = Plane {
            centre: glam::dvec3(0.3, -0.2, 0.05),
            y_axis: glam::dvec3(0.0, 1.0, 1.0),
            ..Plane::default()
        };
        let samples = Samples::on_plane(&plane, 9, 7).unwrap();
        let (near, far) = distances(&aperture, &samples);
        for index in 0..samples.len() {
            for position in &aperture.positions {
                let distance = samples.point(index).distance(position.extend(0.0));
                assert!((near..=far).contains(&distance), "{distance} is not in {near} to {far}");
            }
        }
    }

    #[test]
    fn the_directivity_is_met_in_f32() {
        for (ka, error) in [(3.66, 2e-7), (9.2, 5e-7), (20.0, 4e-6)] {
            let aperture = aperture(ka);
            let coefficients = wave(&aperture).unwrap().directivity.coefficients;
            for i in 0..=1000 {
                let sin = f64::from(i) / 1000.0;
                let s = (2.0 * sin * sin - 1.0) as f32;
                let got = coefficients.iter().rev().fold(0.0f32, |sum, c| sum.mul_add(s, *c));
                assert!(
                    (f64::from(got) - aperture.element.directivity(sin)).abs() < error,
                    "ka = {ka}, sin = {sin}"
                );
            }
        }
    }

    #[test]
    fn sine_and_cosine_are_met_in_f32() {
        let horner = |c: &[f32], z: f32| c.iter().rev().fold(0.0f32, |sum, c| sum.mul_add(z, *c));
        for i in -1000..=1000 {
            let f = i as f32 / 2000.0;
            let angle = PI * f64::from(f);
            assert!((f64::from(f * horner(&SINE, f * f)) - angle.sin()).abs() < 2e-7);
            assert!((f64::from(horner(&COSINE, f * f)) - angle.cos()).abs() < 2e-7);
        }
    }

    #[test]
    fn silent_elements_are_left_out() {
        let mut scene = Scene::default();
        scene.array.off = vec![0, 1, 2];
        let aperture = Aperture::new(&scene);
        let mut drive = Drive { amplitudes: vec![1.0; 256], phases: vec![0.0; 256] };
        drive.amplitudes[7] = 0.0;
        let samples = Samples::at(vec![glam::DVec3::Z]);
        assert_eq!(Sources::new(&aperture, &drive, &samples).unwrap().elements.len(), 252);
    }
}
