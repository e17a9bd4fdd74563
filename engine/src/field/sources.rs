//! The constants of the array and its drive for the f32 evaluators, computed in f64.
//!
//! The f32 evaluators stay within 2e-5 of the peak of the f64 reference, in complex values. Three techniques make
//! this possible:
//!
//! - Phase is counted in turns and reduced by `t - round(t)`: shading languages guarantee nothing for the sine of a
//!   large angle.
//! - Sine, cosine and directivity are our own polynomials, identical in both evaluators.
//! - Every board is evaluated in its own coordinates (`Samples::seen_from`), and complex samples add. The elements
//!   of a flat board lie in z = 0, so a distance is r = z + ρ²/(r + z), and e^{-jkz} is common to all elements: it
//!   is applied once per sample with a phase reduced in f64, and f32 handles only the small second part. So distant
//!   planes are as accurate as near ones.
//!
//! The elements of a curved board have heights h and individual directions ([`Sources::tilts`], a second vector per
//! element, and no shared table): r = |z| + (ρ² + h² - 2zh)/(r + |z|). The image in a reflector is a board with
//! another pose, a gain, and the elements of its original. Cases beyond the polynomials (elements of more than four
//! wavelengths, extreme absorption) use the reference.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::acoustics::element::{self, NEAREST, Radiator};
use crate::acoustics::{Aperture, Element, Face, Layout};
use crate::drive::Drive;
use crate::field::{polynomial, samples::Samples};
use crate::scene::directivity as table;

pub(crate) use crate::scatter::{COSINE, SINE};

/// Largest error, in f32, of [`Wave::directivity`], and of [`Wave::decay`] relative to itself; beyond, the f32 evaluators decline.
const POLYNOMIAL_ERROR: f64 = 1e-6;
/// Limit of turns of a path beyond its height: f32 rounds longer paths to worse than a hundredth of a turn.
const MOST_TURNS: f64 = 65_536.0;
/// Limit of nodes of the exact piston in the evaluators, and the relative error of their choice.
pub const MOST_NODES: usize = 64;
const NODE_ERROR: f64 = 1e-7;

/// The sounding elements of a board and the constants of their waves, in the board's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Sources<'a> {
    pub wave: Wave,
    /// x (m), y (m), phase (turns, including the quarter turn of the transfer's j), amplitude (Pa·m, reduced by the
    /// absorption up to the nearest distance).
    pub elements: Vec<[f32; 4]>,
    /// z (m) and the direction of radiation; empty for a flat board.
    pub tilts: Vec<[f32; 4]>,
    /// Sample points.
    pub samples: Cow<'a, Samples>,
}

/// The constants of the wave that every element sends to some samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Wave {
    /// 1/λ, in f32 for distances and in f64 for [`Wave::turns`].
    pub turns_per_metre: f32,
    exact_turns_per_metre: f64,
    /// Strength of an element at full drive, as in [`Sources::elements`].
    strength: f64,
    /// The form of the directivity.
    pub form: Form,
    /// The polynomials of this form.
    pub directivity: [Polynomial<24>; 2],
    /// e^{-α(r - near)} in s = `decay_scale[0]` · r + `decay_scale[1]`, which runs from -1 at the nearest to 1 at the
    /// farthest distance that occurs.
    pub decay: Polynomial<16>,
    pub decay_scale: [f32; 2],
    /// Present for the exact piston.
    pub piston: Option<Piston>,
    /// Whether all elements lie in z = 0 and radiate along z.
    pub is_flat: bool,
}

/// How a directivity consists of two polynomials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The first in 2 sin²θ - 1.
    Round,
    /// Real and imaginary part in 2 cosθ - 1, sums of Chebyshev polynomials.
    Cosine,
    /// The product of the first in 2 (x/r)² - 1 and the second in 2 (y/r)² - 1.
    Rectangle,
}

/// Coefficients for s in [-1, 1], lowest first, zero-padded: of powers, or of Chebyshev polynomials.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial<const MOST: usize> {
    pub coefficients: [f32; MOST],
    /// Number of terms without padding.
    pub terms: usize,
}

/// Terms of the directivity that usual elements need: 1e-7 off at ka = 4.6. All 24 are 5e-7 off at ka = 20, and 2e-6 at ka = 26, since
/// terms of both signs grow with it, and f32 rounds them.
pub const FEW_DIRECTIVITY: usize = 7;
/// Terms of the decay sufficient for air: error 1e-6 for a loss of 2 dB between the nearest and the farthest
/// distance. All 16 reach 38 dB.
pub const FEW_DECAY: usize = 4;

/// Constants of the exact piston's integral.
#[derive(Clone, Debug, PartialEq)]
pub struct Piston {
    /// m
    pub radius: f32,
    /// cos ψ and 4 a sin²(ψ/2) at the nodes.
    pub nodes: Vec<[f32; 2]>,
}

impl<'a> Sources<'a> {
    /// The sources of every board and image under a drive, without silent elements. `None` if [`Wave::new`] declines.
    pub fn of_faces(aperture: &Aperture, drive: &Drive, samples: &'a Samples) -> Option<Vec<Self>> {
        let of_face = |face: &Face| {
            let samples = samples.seen_from(&face.pose);
            let wave = Wave::new(&aperture.element, &face.layout, &samples)?;
            let sounding = sounding(aperture, face, drive);
            let mut elements = wave.elements(face, &sounding, drive);
            elements.iter_mut().for_each(|[.., amplitude]| *amplitude *= face.gain as f32);
            Some(Self {
                elements,
                tilts: tilts(&face.layout, sounding.iter().map(|n| n - face.first)),
                wave,
                samples,
            })
        };
        aperture.faces.iter().map(of_face).collect()
    }

    /// Whether there are no [`Sources::beside_rims`].
    pub fn has_no_sample_beside_rims(&self) -> bool {
        self.beside_rims().is_empty()
    }

    /// The samples left to f64 near exact pistons: too close to a rim for [`MOST_NODES`], or so low that f32 rounds
    /// their height. All are within a fifth of a radius of the array.
    pub fn beside_rims(&self) -> Vec<usize> {
        let Some(piston) = &self.wave.piston else { return Vec::new() };
        let samples = &self.samples;
        let radius = f64::from(piston.radius);
        let ka = TAU * self.wave.exact_turns_per_metre * radius;
        let is_beside =
            |rho: f64, z: f64| element::piston_nodes(ka, rho / radius, z / radius, NODE_ERROR) > MOST_NODES;
        if !is_beside(radius, samples.bounds().0.z.max(NEAREST)) {
            return Vec::new();
        }
        let of_element = |point: DVec3, [x, y, ..]: [f32; 4]| {
            let rho = point.truncate().distance(DVec2::new(x.into(), y.into()));
            (rho - radius).abs() < radius && is_beside(rho, point.z)
        };
        let is_sample_beside = |&index: &usize| {
            let point = samples.point(index);
            let is_beside = || {
                is_beside(radius, point.z) && self.elements.iter().any(|&element| of_element(point, element))
            };
            point.z >= -NEAREST && (point.z < NEAREST || is_beside())
        };
        (0..samples.len()).into_par_iter().filter(is_sample_beside).collect()
    }
}

/// The sounding elements of a board under a drive, with their indices in the array.
pub fn sounding(aperture: &Aperture, face: &Face, drive: &Drive) -> Vec<usize> {
    let driven = &aperture.driven[face.among(&aperture.driven)];
    driven.iter().copied().filter(|&n| drive.amplitudes[n] != 0.0).collect()
}

/// [`Sources::tilts`] of these elements of a board.
pub fn tilts(layout: &Layout, elements: impl Iterator<Item = usize>) -> Vec<[f32; 4]> {
    let tilt = |n: usize| {
        let (z, normal) = (layout.positions[n].z, layout.normals[n]);
        [z, normal.x, normal.y, normal.z].map(|value| value as f32)
    };
    if layout.is_flat() { Vec::new() } else { elements.map(tilt).collect() }
}

impl Wave {
    /// The wave of elements in this layout, at samples in their coordinates. `None` for elements and absorption
    /// beyond f32's polynomials (a radius above about three and a half wavelengths, or more than about 38 dB between
    /// the nearest and the farthest distance), for paths beyond its range, and for an exact piston or a rectangle on a
    /// curved board.
    pub fn new(element: &Element, layout: &Layout, samples: &Samples) -> Option<Self> {
        let piston = match element.radiator() {
            Radiator::Disk(_) | Radiator::Rectangle(_) if !layout.is_flat() => return None,
            Radiator::Disk(radius) => Some(piston(element, radius, samples)),
            Radiator::Monopole
            | Radiator::Piston(_)
            | Radiator::Rectangle(_)
            | Radiator::Cosine(_)
            | Radiator::Measured => None,
        };
        let turns_per_metre = element.wavenumber / TAU;
        let (form, directivity) = directivity(element)?;
        let (near, far) = distances(layout, samples);
        if (far - near) * turns_per_metre > MOST_TURNS {
            return None;
        }
        let (middle, half) = ((far + near) / 2.0, (far - near) / 2.0);
        // The farthest point may be the only one, and must be as accurate as the nearest.
        let sought = |s: f64| (-element.attenuation * half * (1.0 + s)).exp();
        let allowed = |s: f64| POLYNOMIAL_ERROR * sought(s);
        let decay = Polynomial::fit(Basis::Powers, FEW_DECAY, sought, allowed)?;
        Some(Self {
            turns_per_metre: turns_per_metre as f32,
            exact_turns_per_metre: turns_per_metre,
            strength: element.strength * (-element.attenuation * near).exp(),
            form,
            directivity,
            decay,
            decay_scale: [(1.0 / half) as f32, (-middle / half) as f32],
            piston,
            is_flat: layout.is_flat(),
        })
    }

    /// Some elements of a board under a drive, by their indices in the array, in the format of [`Sources::elements`],
    /// without reflection factors.
    pub fn elements(&self, face: &Face, sounding: &[usize], drive: &Drive) -> Vec<[f32; 4]> {
        let element = |&n: &usize| {
            self.element(face.layout.positions[n - face.first], drive.amplitudes[n], drive.phases[n])
        };
        sounding.iter().map(element).collect()
    }

    /// The factor from the amplitudes of another wave's elements to this one's, for different nearest distances.
    pub fn gain_over(&self, other: &Self) -> f64 {
        if other.strength == 0.0 { 0.0 } else { self.strength / other.strength }
    }

    /// An element at a position (m) with an amplitude and a phase (rad), as in [`Sources::elements`].
    pub fn element(&self, position: DVec3, amplitude: f64, phase: f64) -> [f32; 4] {
        let turns = phase / TAU + 0.25;
        let amplitude = self.strength * amplitude;
        [position.x as f32, position.y as f32, (turns - turns.round()) as f32, amplitude as f32]
    }

    /// The fraction of a turn, in [-½, ½], of a path of `z` (m).
    pub fn turns(&self, z: f64) -> f32 {
        let turns = z * self.exact_turns_per_metre;
        (turns - turns.round()) as f32
    }
}

/// What the coefficients of a polynomial are of.
#[derive(Clone, Copy)]
enum Basis {
    Powers,
    /// Sums of Chebyshev polynomials amplify no rounding, even those of tables.
    Chebyshev,
}

/// The directivity of an element in f32, in its form; `None` if 24 terms do not meet it.
fn directivity(element: &Element) -> Option<(Form, [Polynomial<24>; 2])> {
    let fitted = |basis: Basis, sought: &dyn Fn(f64) -> f64| {
        Polynomial::fit(basis, FEW_DIRECTIVITY, sought, |_| POLYNOMIAL_ERROR)
    };
    let powers = |sought: &dyn Fn(f64) -> f64| fitted(Basis::Powers, sought);
    let chebyshev = |sought: &dyn Fn(f64) -> f64| fitted(Basis::Chebyshev, sought);
    let root = |s: f64| ((s + 1.0) / 2.0).max(0.0).sqrt();
    let none = || Polynomial { coefficients: [0.0; 24], terms: 1 };
    match element.radiator() {
        Radiator::Monopole | Radiator::Piston(_) | Radiator::Disk(_) => {
            Some((Form::Round, [powers(&|s| element.directivity(root(s)))?, none()]))
        }
        Radiator::Rectangle(size) => {
            let half = size * (element.wavenumber / 2.0);
            let along = |half: f64| powers(&|s| element::sinc(half * root(s)));
            Some((Form::Rectangle, [along(half.x)?, along(half.y)?]))
        }
        Radiator::Cosine(exponent) => {
            let power = chebyshev(&|s: f64| ((s + 1.0) / 2.0).max(0.0).powf(exponent))?;
            Some((Form::Cosine, [power, none()]))
        }
        Radiator::Measured => {
            let part = |part: usize| chebyshev(&|s| table::at(&element.measured, (s + 1.0) / 2.0)[part]);
            Some((Form::Cosine, [part(0)?, part(1)?]))
        }
    }
}

impl<const MOST: usize> Polynomial<MOST> {
    /// Chebyshev interpolation with `few` terms or the maximum, or `None` if neither is within `allowed`.
    fn fit(
        basis: Basis,
        few: usize,
        sought: impl Fn(f64) -> f64,
        allowed: impl Fn(f64) -> f64,
    ) -> Option<Self> {
        let fitted = |terms: usize| {
            let all = match basis {
                Basis::Powers => polynomial::fit(&sought, terms),
                Basis::Chebyshev => polynomial::chebyshev(&sought, terms),
            };
            let mut coefficients = [0.0; MOST];
            coefficients.iter_mut().zip(all).for_each(|(to, from)| *to = from as f32);
            Self { coefficients, terms }
        };
        let at = |fitted: &Self, s: f32| match basis {
            Basis::Powers => fitted.at(s),
            Basis::Chebyshev => fitted.chebyshev_at(s),
        };
        let is_near = |fitted: &Self| {
            (0..=200).all(|i| {
                let s = f64::from(i) / 100.0 - 1.0;
                (f64::from(at(fitted, s as f32)) - sought(s)).abs() < allowed(s)
            })
        };
        Some(fitted(few)).filter(is_near).or_else(|| Some(fitted(MOST)).filter(is_near))
    }

    /// The value of a sum of Chebyshev polynomials, by Clenshaw's rule, that the evaluators compute.
    fn chebyshev_at(&self, s: f32) -> f32 {
        let (mut now, mut before) = (0.0, 0.0);
        for coefficient in self.coefficients[1..self.terms].iter().rev() {
            (now, before) = (2.0 * s * now + (coefficient - before), now);
        }
        s * now + (self.coefficients[0] - before)
    }

    /// The value that the evaluators compute, rounding included.
    fn at(&self, s: f32) -> f32 {
        self.coefficients[..self.terms].iter().rev().fold(0.0, |sum, coefficient| sum * s + coefficient)
    }
}

/// Bounds of every distance (m) between an element and a sample.
fn distances(layout: &Layout, samples: &Samples) -> (f64, f64) {
    let (low, high) = samples.bounds();
    let (first, last) = layout.bounds();
    let far = (high - first).abs().max((low - last).abs()).length();
    let near = if layout.is_flat() { low.z.max(0.0) } else { 0.0 };
    // A single point straight above a single element still needs a range to scale by.
    (near, far.max(near + 0.01))
}

/// The number of nodes for the sample nearest to a rim, if within the limit.
fn piston(element: &Element, a: f64, samples: &Samples) -> Piston {
    let k = element.wavenumber;
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
    use crate::scene::{ElementModel, Elements, Placed, Plane, Scene};

    fn aperture(ka: f64) -> Aperture {
        let mut aperture = Aperture::new(&Scene::default());
        aperture.element.radius = ka / aperture.element.wavenumber;
        aperture
    }

    fn wave(aperture: &Aperture) -> Option<Wave> {
        let samples = Samples::on_plane(&Plane::default(), 4, 4)?;
        Wave::new(&aperture.element, &aperture.faces[0].layout, &samples)
    }

    #[test]
    fn every_path_is_within_the_distances() {
        let samples = Samples::on_plane(&Plane::default(), 5, 5).unwrap();
        let flat = Aperture::new(&Scene::default());
        let mut bowl = Scene::default();
        let placed = |n: i32| {
            DVec3::new(0.01 * f64::from(n % 7 - 3), 0.01 * f64::from(n / 7 - 3), 0.002 * f64::from(n))
        };
        let placed =
            (0..49).map(placed).map(|at| Placed { at, normal: (DVec3::Z * 0.2 - at).normalize_or_zero() });
        bowl.array.placed = Elements::new(placed.collect(), None);
        bowl.array.file = Some("bowl.csv".to_owned());
        for aperture in [flat, Aperture::new(&bowl)] {
            let layout = &aperture.faces[0].layout;
            let (near, far) = distances(layout, &samples);
            let (low, high) = samples.bounds();
            for at in &layout.positions {
                for corner in [low, high, at.with_z(low.z)] {
                    assert!((near..=far).contains(&at.distance(corner)), "{at} {corner}: {near} to {far}");
                }
            }
        }
    }

    #[test]
    fn the_decay_is_right_where_little_is_left_too() {
        // 37 dB between the nearest distance and the farthest.
        let mut aperture = aperture(3.66);
        let samples = Samples::on_plane(&Plane::default(), 4, 4).unwrap();
        let (near, far) = distances(&aperture.faces[0].layout, &samples);
        aperture.element.attenuation = 4.26 / (far - near);
        let wave = wave(&aperture).unwrap();
        for i in 0..=1000 {
            let r = near + (far - near) * f64::from(i) / 1000.0;
            let s = r as f32 * wave.decay_scale[0] + wave.decay_scale[1];
            let expected = (-aperture.element.attenuation * (r - near)).exp();
            let got = f64::from(wave.decay.at(s));
            assert!((got / expected - 1.0).abs() < 2e-6, "{r} m: {got} for {expected}");
        }
    }

    #[test]
    fn f32_leaves_places_beside_rims_to_f64() {
        let mut aperture = aperture(3.66);
        aperture.element.model = ElementModel::ExactPiston;
        let (at, a) = (aperture.positions[40], aperture.element.radius);
        let above = |rho: f64, z: f64| at + DVec3::new(0.6 * rho, 0.8 * rho, z);
        let points = vec![
            above(a, 0.0),
            above(0.5 * a, 0.0),
            above(1.1 * a, 0.01 * a),
            above(a, 0.25 * a),
            above(0.95 * a, 0.1 * a),
            above(a, -0.1 * a),
        ];
        let samples = Samples::at(points);
        let drive = Drive { amplitudes: vec![1.0; 256], phases: vec![0.0; 256] };
        let beside =
            |aperture: &Aperture| Sources::of_faces(aperture, &drive, &samples).unwrap()[0].beside_rims();
        assert_eq!(beside(&aperture), [0, 1, 2, 4]);
        aperture.element.model = ElementModel::Piston;
        assert_eq!(beside(&aperture), [0; 0]);
    }

    #[test]
    fn the_directivity_is_met_in_f32() {
        for (ka, error) in [(3.66, 2e-7), (9.2, 5e-7), (20.0, 2e-6)] {
            let aperture = aperture(ka);
            let [directivity, _] = wave(&aperture).unwrap().directivity;
            for i in 0..=1000 {
                let sin = f64::from(i) / 1000.0;
                let s = (2.0 * sin * sin - 1.0) as f32;
                assert!(
                    (f64::from(directivity.at(s)) - aperture.element.directivity(sin)).abs() < error,
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
        let samples = Samples::at(vec![DVec3::Z]);
        assert_eq!(Sources::of_faces(&aperture, &drive, &samples).unwrap()[0].elements.len(), 252);
    }

    #[test]
    fn an_exact_piston_takes_nodes_as_its_nearest_sample_needs_them() {
        let mut aperture = aperture(3.66);
        aperture.element.model = ElementModel::ExactPiston;
        let drive = Drive { amplitudes: vec![1.0; 256], phases: vec![0.3; 256] };
        let u = drive.excitation(&aperture.driven);
        for (z, most) in [(0.1, 12), (0.02, 12), (0.003, 30)] {
            let points = [-0.01, 0.001, 0.03].map(|x| DVec3::new(x, -0.002, z)).to_vec();
            let expected = aperture.transfer(&points);
            let samples = Samples::at(points);
            let sources = Sources::of_faces(&aperture, &drive, &samples).unwrap();
            let nodes = sources[0].wave.piston.as_ref().unwrap().nodes.len();
            assert!(nodes <= most, "{z} m: {nodes} nodes");
            for (row, own) in crate::field::cpu::pressure(&sources, 3).into_iter().enumerate() {
                let expected = expected.row(row).zip(&u).map(|(h, u)| h * u).sum::<num_complex::Complex64>();
                let off = (f64::from(own.re) - expected.re).hypot(f64::from(own.im) - expected.im);
                let all: f64 = aperture.transfer(&[samples.point(row)]).row(0).map(|h| h.norm()).sum();
                assert!(off < 1e-5 * all, "{z} m: {own}, not {expected}");
            }
        }
    }
}
