//! The second harmonic at a loud point: the integral in spherical coordinates about it.
//!
//! dV/(4πR) = R dR dΩ/4π has no singularity, and towards the elements P² e^{-jKR} hardly turns, since every wave of a
//! focus is in phase with its harmonic. So shells are as thick as this allows, and only the directions of elements
//! count on far ones; elsewhere the product turns twice per wavelength, and fades within some wavelengths. A ray ends
//! in the plane of the element that it comes nearest to.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::{Air, Aperture};
use crate::field::harmonic::source::{self, NEAREST, NoHarmonic};

/// Distance in wavelengths within which every direction counts, by halves from the middle on.
const AROUND: f64 = 2.4;
/// Mean distances of nodes along a ray, in wavelengths: around the point, and farther away.
const FINE: f64 = 0.105;
const COARSE: f64 = 0.3;
/// Directions on a half circle: at the point, and more of them per wavelength of distance.
const FEWEST: f64 = 7.0;
const PER_WAVELENGTH: f64 = 3.0;
/// Distance (wavelengths) from which on there are no more of them: beams towards a focus are smooth.
const SMOOTH: f64 = 7.0;
/// Distance from elements (wavelengths) up to which their rays are followed.
const BESIDE: f64 = 1.2;
/// Gauss-Legendre nodes and weights on [-1, 1].
const NODES: [f64; 4] =
    [-0.861_136_311_594_052_6, -0.339_981_043_584_856_3, 0.339_981_043_584_856_3, 0.861_136_311_594_052_6];
const WEIGHTS: [f64; 4] =
    [0.347_854_845_137_453_86, 0.652_145_154_862_546_1, 0.652_145_154_862_546_1, 0.347_854_845_137_453_86];

/// An element as the point has it.
struct Seen {
    /// Unit vector from the point.
    direction: DVec3,
    /// m
    distance: f64,
    /// Direction of radiation.
    normal: DVec3,
    /// Cosine of the angle up to which rays belong to it.
    cosine: f64,
}

/// Complex pressure (Pa, peak) of the second harmonic at a point near a maximum of the sound of one drive, given by u
/// of every driven element. Along beams and beside foci waves of other phases count more, and [`crate::field::harmonic::over`] is
/// better.
///
/// # Errors
/// Reflectors that are not rigid.
pub fn at(
    aperture: &Aperture,
    air: &Air,
    excitation: &[Complex64],
    point: DVec3,
) -> Result<Complex64, NoHarmonic> {
    source::check(aperture)?;
    let second = Complex64::new(air.attenuation_of_second, 2.0 * aperture.element.wavenumber);
    let nodes = nodes(aperture, point);
    let places: Vec<_> = nodes.iter().map(|(place, _, _)| *place).collect();
    let pressures = aperture.pressures(&places, excitation);
    let of_node =
        |(&(_, weight, r), p): (&(DVec3, f64, f64), Complex64)| p * p * (-second * r).exp() * (weight * r);
    let sum: Complex64 = nodes.iter().zip(pressures).map(of_node).sum();
    Ok(sum * (-source::source(aperture, air) / (4.0 * PI)))
}

/// Places, their weights (m·sr), and their distances (m).
fn nodes(aperture: &Aperture, point: DVec3) -> Vec<(DVec3, f64, f64)> {
    let wavelength = aperture.wavelength();
    let elements: Vec<_> = source::elements(aperture)
        .into_iter()
        .filter_map(|(position, normal)| {
            let distance = position.distance(point);
            let direction = (position - point).try_normalize()?;
            let beside = (BESIDE * wavelength / distance).min(1.0).asin();
            Some(Seen { direction, distance, normal, cosine: beside.cos() })
        })
        .collect();
    let axis = elements.iter().map(|it| it.direction).sum::<DVec3>().try_normalize().unwrap_or(DVec3::NEG_Z);
    let (x, y) = axis.any_orthonormal_pair();
    let far = elements.iter().map(|it| it.distance).fold(0.0, f64::max) + wavelength;
    let around = AROUND * wavelength;
    let panels = |from: f64, to: f64, node: f64| {
        let count = ((to - from) / (node * wavelength * NODES.len() as f64)).ceil().max(0.0);
        let width = (to - from) / count.max(1.0);
        (0..count as usize).map(move |i| (from + width * i as f64, from + width * (i + 1) as f64))
    };
    let mut nodes = Vec::new();
    for (index, (start, end)) in panels(0.0, around, FINE).chain(panels(around, far, COARSE)).enumerate() {
        let middle = (f64::midpoint(start, end) / wavelength).min(SMOOTH);
        let polar = (FEWEST + PER_WAVELENGTH * middle).ceil();
        for i in 0..polar as usize {
            let angle = PI * (i as f64 + 0.5) / polar;
            let (sine, cosine) = angle.sin_cos();
            let azimuths = (FEWEST + 2.0 * PER_WAVELENGTH * middle * sine).ceil();
            let solid = fejer(angle, polar as usize) * TAU / azimuths;
            for j in 0..azimuths as usize {
                // Neighbouring rings and shells do not begin at the same angle.
                let turn = (j as f64 + 0.5 * (i + index) as f64 + 0.123 * index as f64) / azimuths;
                let (sin, cos) = (TAU * turn).sin_cos();
                let direction = axis * cosine + (x * cos + y * sin) * sine;
                let ray =
                    Ray { start, end, is_beam: false }.among(&elements, direction, NEAREST * wavelength);
                let half = (ray.end - ray.start) / 2.0;
                if half <= 0.0 || (!ray.is_beam && start >= around) {
                    continue;
                }
                for (node, weight) in NODES.iter().zip(WEIGHTS) {
                    let r = f64::midpoint(ray.start, ray.end) + half * node;
                    let fade = if ray.is_beam { 1.0 } else { fade(r / around) };
                    nodes.push((point + direction * r, weight * half * solid * fade, r));
                }
            }
        }
    }
    nodes
}

/// Fejér's weight of the angle in ∫ sin θ dθ from 0 to π by `count` midpoints: exact for that many cosines.
fn fejer(angle: f64, count: usize) -> f64 {
    let term = |j: usize| (2.0 * j as f64 * angle).cos() / (4 * j * j - 1) as f64;
    (1.0 - 2.0 * (1..=count / 2).map(term).sum::<f64>()) * 2.0 / count as f64
}

/// From 1 at the half to 0.
fn fade(part: f64) -> f64 {
    if part < 0.5 { 1.0 } else { (PI * (part - 0.5)).cos().powi(2) }
}

/// Part of a ray, m from the point.
struct Ray {
    start: f64,
    end: f64,
    /// Whether it leads to an element.
    is_beam: bool,
}

impl Ray {
    /// The part before the plane of the element that the ray comes nearest to.
    fn among(self, elements: &[Seen], direction: DVec3, clear: f64) -> Self {
        let nearest =
            elements.iter().map(|it| (it, it.direction.dot(direction))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((element, cosine)) = nearest else { return self };
        let (height, towards) =
            (-element.direction.dot(element.normal) * element.distance, -direction.dot(element.normal));
        let end = if towards > 1e-9 { ((height - clear) / towards).min(self.end) } else { self.end };
        Self { end, is_beam: cosine >= element.cosine, ..self }
    }
}
