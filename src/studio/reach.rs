//! Reach of an array: the pressure, the steering angle and the grating lobes at its targets.
//!
//! A single focus at a point gets Σ|h_n|: every element at full drive and in phase. Elements `p` apart that are
//! steered to an angle θ are also in phase where sin θ' = sin θ - λ/p, a grating lobe, which exists if p > λ/(1 + sin
//! θ) (Steinberg, Principles of Aperture and Array System Design, 1976, chapter 5). Its level depends on the
//! elements' directivity and on the focal distance, since far lobes of a focused array are smeared: it is evaluated
//! on the circles through the focus about the array.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::{Aperture, Face};
use crate::scene::{ElementModel, Scene, Size, Target, outline};

/// Limit relative to the pressure of a single focus at the best distance.
const WEAK: f64 = 0.1;
/// Limit relative to an element's pressure on axis.
const SIDEWAYS: f64 = 0.5;
/// Limit relative to the pressure at the focus.
const LOUD_LOBE: f64 = 0.7;
/// Number of distances searched for the best, and their range in units of the array's wider side.
const DISTANCES: u32 = 40;
const NEAREST: f64 = 0.25;
const FARTHEST: f64 = 4.0;
/// Limit of examined targets.
const MOST_TARGETS: usize = 24;
/// Points on a quarter circle.
const QUARTER: i32 = 60;
/// Exclusion zone around the focus, in widths of the main lobe.
const MAIN_LOBE: f64 = 2.5;

/// A warning about a target, or about the array's sound there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The largest directivity of an element towards it.
    #[error(
        "{name} is beyond the steering range: even the nearest elements radiate only {:.0} % of their pressure on axis towards it",
        100.0 * .directivity
    )]
    Aside { name: String, directivity: f64 },
    /// A single focus there over one at the best distance, and that distance, m.
    #[error(
        "{name} is too far away: a single focus there reaches {:.1} % of the pressure that it reaches {:.0} mm in front of the array",
        100.0 * .pressure,
        .best * 1e3
    )]
    Far { name: String, pressure: f64, best: f64 },
    /// Distance from the array and the array's extent, m.
    #[error(
        "{name} is {distance:.1} m away from an array of {extent:.2} m: positions are metres, not millimetres"
    )]
    Metres { name: String, distance: f64, extent: f64 },
    /// m
    #[error(
        "The array spans {extent:.1} m, with elements of {:.1} mm radius {spacing:.1} m apart: lengths are metres, not \
         millimetres",
        1e3 * .radius
    )]
    Sparse { extent: f64, spacing: f64, radius: f64 },
    /// The pitch in wavelengths, and the lobe over the focus.
    #[error(
        "{name} is beyond the steering range: the elements are {pitch:.2} wavelengths apart, and a grating lobe reaches {:.0} \
         % of its pressure",
        100.0 * .lobe
    )]
    GratingLobe { name: String, pitch: f64, lobe: f64 },
    /// The board's number, from 1.
    #[error("Board {0} faces away from every target and contributes nothing")]
    TurnedAway(usize),
    /// Largest difference of a measured directivity from its table, relative to the axis.
    #[error("The smooth fit of `array.directivity` is up to {:.0} % of the amplitude at 0 degrees off its table", 100.0 * .0)]
    RoughFit(f64),
    /// Remainder of a truncated series of reflections, relative to the direct sound.
    #[error(
        "The reflections between the array's face and the reflectors converge slowly: the remainder after {faces} of them is up to \
         {rest:.1e} of the direct sound"
    )]
    CutShort { faces: usize, rest: f64 },
}

/// Warnings about a scene's targets out of the array's reach.
pub fn of_targets(scene: &Scene) -> Vec<Warning> {
    // What a body casts its shadow on is in the array's reach.
    let aperture = Aperture::new(scene).without_bodies();
    if aperture.driven.is_empty() {
        return Vec::new();
    }
    let rough = rough_fit(scene);
    let (best, distance) = best(&aperture);
    let size = Size::of(&scene.array.places());
    let sparse = sparse(scene, size);
    let is_sparse = sparse.is_some();
    let shown = || scene.targets.iter().enumerate().filter(|(_, target)| target.visible).take(MOST_TARGETS);
    let of_target = |(index, target): (usize, &Target)| {
        let slip = || far_in_metres(&aperture, index, target, size).filter(|_| !is_sparse);
        slip().or_else(|| warning(&aperture, index, target, (best, distance)))
    };
    let mut warnings: Vec<_> = sparse.into_iter().chain(shown().filter_map(of_target)).collect();
    let places: Vec<_> = shown().map(|(_, target)| outline::centre(&target.shape)).collect();
    warnings.extend(turned_away(&aperture, &places));
    warnings.extend(rough);
    warnings
}

/// The warning about a directivity that is too rough for its fit.
fn rough_fit(scene: &Scene) -> Option<Warning> {
    /// Limit relative to the amplitude at 0°.
    const ROUGH: f64 = 0.02;
    let measured = scene.array.measured.get().filter(|_| scene.array.element == ElementModel::Measured)?;
    (measured.residual > ROUGH).then_some(Warning::RoughFit(measured.residual))
}

/// The warning about an array in millimetres, by its size.
fn sparse(scene: &Scene, Size { extent, spacing }: Size) -> Option<Warning> {
    /// Element radii, wavelengths, and m.
    const APART: f64 = 100.0;
    const WAVELENGTHS: f64 = 20.0;
    const WIDEST: f64 = 10.0;
    let radius = scene.array.element_radius;
    let is_sparse = spacing > APART * radius && spacing > WAVELENGTHS * scene.wavelength();
    (is_sparse || extent > WIDEST).then_some(Warning::Sparse { extent, spacing, radius })
}

/// The warning about a target in millimetres, by its distance.
fn far_in_metres(aperture: &Aperture, index: usize, target: &Target, size: Size) -> Option<Warning> {
    /// m, and widths of the array.
    const FAR: f64 = 8.0;
    const WIDTHS: f64 = 20.0;
    let at = outline::centre(&target.shape);
    let distance = aperture.positions.iter().map(|place| place.distance(at)).fold(f64::INFINITY, f64::min);
    let is_far = distance > FAR && distance > WIDTHS * size.extent;
    is_far.then(|| Warning::Metres { name: name(index, target), distance, extent: size.extent })
}

fn name(index: usize, target: &Target) -> String {
    match target.name.as_str() {
        "" => format!("Target {}", index + 1),
        name => format!("Target {} ({name})", index + 1),
    }
}

/// Boards without sound at any target.
fn turned_away(aperture: &Aperture, places: &[DVec3]) -> Vec<Warning> {
    if aperture.boards().count() < 2 || places.is_empty() {
        return Vec::new();
    }
    let hears = |board: &Face, place: DVec3| {
        let mut elements = board.elements();
        elements.any(|n| aperture.normals[n].dot(place - aperture.positions[n]) > 0.0)
    };
    let away =
        aperture.boards().enumerate().filter(|(_, board)| !places.iter().any(|&place| hears(board, place)));
    away.map(|(index, _)| Warning::TurnedAway(index + 1)).collect()
}

/// The warning about a series of reflections truncated too early.
pub fn cut_short(aperture: &Aperture) -> Option<Warning> {
    /// Limit relative to the boards' own sound.
    const LOUD: f64 = 1e-9;
    let rest = aperture.remainder;
    (rest > LOUD).then_some(Warning::CutShort { faces: aperture.faces.len(), rest })
}

fn warning(
    aperture: &Aperture,
    index: usize,
    target: &Target,
    (best, distance): (f64, f64),
) -> Option<Warning> {
    let at = outline::centre(&target.shape);
    if at.z <= 0.0 {
        return None;
    }
    let name = name(index, target);
    let directivity = straightest(aperture, at);
    if directivity < SIDEWAYS {
        return Some(Warning::Aside { name, directivity });
    }
    let loud = single_focus(aperture, at);
    if loud < WEAK * best {
        return Some(Warning::Far { name, pressure: loud / best, best: distance });
    }
    let lobe = grating_lobe(aperture, at).filter(|lobe| *lobe > LOUD_LOBE)?;
    Some(Warning::GratingLobe { name, pitch: aperture.pitch / aperture.wavelength(), lobe })
}

/// |P| (Pa) of a single focus.
fn single_focus(aperture: &Aperture, at: DVec3) -> f64 {
    aperture.transfer(&[at]).row(0).map(|wave| wave.norm()).sum()
}

/// The largest directivity of any element towards a point.
fn straightest(aperture: &Aperture, at: DVec3) -> f64 {
    let of_board = |board: &Face| {
        let (at, layout) = (board.pose.local(at), &board.layout);
        let driven = aperture.driven.iter().filter(|n| board.elements().contains(n)).map(|n| n - board.first);
        let loudness =
            |n: usize| aperture.element.loudness(at - layout.positions[n], layout.normal(n), layout.aside(n));
        driven.map(loudness).fold(0.0, f64::max)
    };
    aperture.boards().map(of_board).fold(0.0, f64::max)
}

/// The largest pressure (Pa) of a single focus in front of the array's centre, and its distance (m).
fn best(aperture: &Aperture) -> (f64, f64) {
    let Some((board, (low, high))) =
        aperture.boards().find_map(|board| Some((board, aperture.extent(board)?)))
    else {
        return (0.0, 0.0);
    };
    let side = (high - low).truncate().max_element().max(aperture.pitch);
    let middle = (low + high) / 2.0;
    let distance = |i: u32| {
        let part = f64::from(i) / f64::from(DISTANCES - 1);
        (side * NEAREST * (FARTHEST / NEAREST).powf(part)).max(aperture.wavelength())
    };
    let loudness =
        |i: u32| (single_focus(aperture, board.pose.world(middle + DVec3::Z * distance(i))), distance(i));
    (0..DISTANCES).map(loudness).fold((0.0, 0.0), |best, it| if it.0 > best.0 { it } else { best })
}

/// The largest grating lobe of a single focus, relative to |P| at the focus, on the circles through it about the
/// array's centre along both of the array's axes. `None` without a grating lobe outside the main lobe.
fn grating_lobe(aperture: &Aperture, at: DVec3) -> Option<f64> {
    aperture.lattice()?;
    let (low, high) = aperture.extent(&aperture.faces[0])?;
    let middle = (low + high) / 2.0;
    let away = at - middle;
    let sine = away.truncate().length() / away.length();
    if aperture.pitch * (1.0 + sine) <= aperture.wavelength() {
        return None;
    }
    let apart = MAIN_LOBE * aperture.resolution()(at);
    let radius = away.length();
    let on_circle = |i: i32, is_across: bool| {
        let angle = FRAC_PI_2 * f64::from(i) / f64::from(QUARTER);
        let along = radius * angle.sin();
        let other = if is_across { away.y } else { away.x };
        let height = (radius * radius - along * along - other * other).sqrt();
        middle + if is_across { DVec3::new(along, other, height) } else { DVec3::new(other, along, height) }
    };
    let places: Vec<_> = [true, false]
        .into_iter()
        .flat_map(|is_across| (1 - QUARTER..QUARTER).map(move |i| (i, is_across)))
        .map(|(i, is_across)| on_circle(i, is_across))
        .filter(|place| place.z > aperture.wavelength() && place.distance(at) > apart)
        .collect();
    let steered: Vec<Complex64> = aperture
        .transfer(&[at])
        .row(0)
        .map(|wave| wave.conj() / wave.norm().max(f64::MIN_POSITIVE))
        .collect();
    let lobes = aperture.pressures(&places, &steered);
    let loudest = lobes.iter().map(|pressure| pressure.norm()).fold(0.0, f64::max);
    (loudest > 0.0).then(|| loudest / single_focus(aperture, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Shape;

    fn said(at: DVec3) -> Vec<String> {
        let scene = Scene { targets: vec![Target::new(Shape::Point { at })], ..Scene::default() };
        of_targets(&scene).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_target_far_away_or_far_aside_is_named() {
        assert_eq!(said(DVec3::new(0.02, -0.01, 0.1)), Vec::<String>::new());
        assert_eq!(said(DVec3::new(0.0, 0.0, 0.4)), Vec::<String>::new());
        assert_eq!(said(DVec3::new(0.003, 0.0, 0.07)), Vec::<String>::new(), "near the array is not aside");
        let far = said(DVec3::Z * 5.0);
        assert!(far.len() == 1 && far[0].starts_with("Target 1 is too far away"), "{far:?}");
        let aside = said(DVec3::new(0.4, 0.0, 0.1));
        assert!(aside.len() == 1 && aside[0].contains("beyond the steering range"), "{aside:?}");
        let steered = said(DVec3::new(0.3, 0.0, 0.45));
        assert!(steered.len() == 1 && steered[0].contains("grating lobe"), "{steered:?}");
        assert!(said(DVec3::Z * -0.1).is_empty(), "what lies behind the array is refused elsewhere");
    }

    #[test]
    fn hidden_targets_are_not_named() {
        let mut target = Target::new(Shape::Point { at: DVec3::Z * 5.0 });
        target.visible = false;
        assert!(of_targets(&Scene { targets: vec![target], ..Scene::default() }).is_empty());
    }
}
