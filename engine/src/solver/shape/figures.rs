//! Quality figures of a shape's drive, in f64 and on finer samples than the solver's.

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::{Evaluator, Stages, side_lobe};
use crate::scene::Focus;
use crate::solver::shape::real::Waves;
use crate::solver::shape::wanted::Fineness;
use crate::solver::shape::{Surroundings, strongest, wanted};
use crate::solver::shape_figures::{AreaFigures, Figures};
use crate::solver::{problem::Problem, statistics};

/// The figures of drives in turn, u of the driven elements to any scale, drive after drive, over the radiated part of
/// the plane. |p| is the root mean square over all drives.
///
/// # Panics
/// Other than a value per driven element and drive.
pub fn figures(problem: &Problem<'_>, surroundings: &Surroundings, u: &[Complex64]) -> Figures {
    let aperture = problem.aperture;
    let at_foci = problem.transfer.moduli(u);
    let (between, wanted): (Vec<_>, Vec<_>) =
        between(&problem.foci, aperture.wavelength()).into_iter().unzip();
    let relative: Vec<_> = (at_foci.iter().zip(problem.targets()))
        .map(|(p, target)| p / target)
        .chain(moduli(aperture, &between, u).iter().zip(&wanted).map(|(p, wanted)| p / wanted))
        .collect();
    let (least, most) =
        relative.iter().fold((f64::INFINITY, 0.0f64), |(least, most), &p| (least.min(p), most.max(p)));
    let mean = statistics::mean(relative.iter().copied()).max(f64::MIN_POSITIVE);
    let mut stages = Stages::new(Evaluator::Cpu);
    let drives = drives(aperture, u);
    let lobe = side_lobe(&mut stages, aperture, &surroundings.plane, &drives, &problem.foci).ok();
    let strength = |u: &[Complex64]| {
        let played = u.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let relative: Vec<_> =
            problem.transfer.moduli(u).iter().zip(problem.targets()).map(|(p, target)| p / target).collect();
        statistics::mean(relative.iter().copied()) / played
    };
    let own = strength(u);
    Figures {
        evenness: least / mean,
        ripple_db: 20.0 * (most / least.max(1e-6 * most).max(f64::MIN_POSITIVE)).max(1.0).log10(),
        side_lobe: lobe.map_or(0.0, |lobe| lobe.part),
        side_lobe_position: lobe.map_or(DVec3::ZERO, |lobe| lobe.position),
        strength: own / own.max(strength(&strongest(problem))).max(f64::MIN_POSITIVE),
        areas: areas(problem, surroundings, u),
    }
}

/// The drives of u, the loudest element of all at full drive.
fn drives(aperture: &Aperture, u: &[Complex64]) -> Vec<Drive> {
    let largest = u.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let scaled: Vec<_> = u.iter().map(|u| u / largest).collect();
    let (elements, driven) = (aperture.positions.len(), &aperture.driven);
    scaled.chunks(driven.len().max(1)).map(|u| Drive::of(elements, driven, u)).collect()
}

/// Figures of areas; of a silent drive, the worst values.
fn areas(problem: &Problem<'_>, surroundings: &Surroundings, u: &[Complex64]) -> Option<AreaFigures> {
    let most = problem.transfer.rows().map(|row| row.map(|h| h.norm()).sum::<f64>()).fold(0.0, f64::max);
    let mut picture = wanted::picture::<f64>(problem, surroundings, Fineness::Figures, 1.0 / most)?;
    let largest = u.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let elements = problem.aperture.driven.len();
    let played = |u: &[Complex64]| {
        let mut played = Waves::zeros(elements.next_multiple_of(wanted::PADDING));
        for (n, u) in u.iter().enumerate() {
            (played.re[n], played.im[n]) = (u.re / largest, u.im / largest);
        }
        played
    };
    let played: Vec<_> = u.chunks(elements).map(played).collect();
    Some(match picture.hear(&played) {
        Some(fit) => AreaFigures { contrast: picture.contrast().unwrap_or(0.0), error: fit.error.max(0.0) },
        None => AreaFigures { contrast: 0.0, error: 1.0 },
    })
}

/// |p| (Pa) at points.
fn moduli(aperture: &Aperture, points: &[DVec3], u: &[Complex64]) -> Vec<f64> {
    aperture.pressures(points, u).into_iter().map(Complex64::norm).collect()
}

/// Points between neighbouring samples of a stroke, with target values.
fn between(foci: &[Focus], wavelength: f64) -> Vec<(DVec3, f64)> {
    /// Places for each pair.
    const PLACES: usize = 3;
    /// Wavelengths: samples farther apart are separate foci.
    const NEIGHBOURS: f64 = 0.27;
    let between = |from: &Focus, to: &Focus| {
        let (from, to) = (*from, *to);
        (1..=PLACES).map(move |place| {
            let part = place as f64 / (PLACES + 1) as f64;
            (from.position.lerp(to.position, part), from.target + (to.target - from.target) * part)
        })
    };
    let is_near = |from: &Focus, to: &Focus| from.position.distance(to.position) < NEIGHBOURS * wavelength;
    // At junctions of strokes, neighbours are not consecutive.
    let pairs = foci.iter().enumerate().flat_map(|(i, from)| foci[i + 1..].iter().map(move |to| (from, to)));
    pairs.filter(|(from, to)| is_near(from, to)).flat_map(|(from, to)| between(from, to)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Part, Plane, Scene};
    use crate::solver::starts::scatter;

    fn array(rows: u32, columns: u32) -> Aperture {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (rows, columns);
        Aperture::new(&scene)
    }

    /// Values of some drives in turn.
    fn scattered(aperture: &Aperture, drives: usize) -> Vec<Complex64> {
        (0..drives * aperture.driven.len()).map(|n| 2.0 * Complex64::cis(9.0 * scatter(n))).collect()
    }

    /// The root mean square of |p| over all drives.
    fn heard_at(aperture: &Aperture, at: DVec3, u: &[Complex64]) -> f64 {
        let transfer = aperture.transfer(&[at]);
        let squares: Vec<_> =
            u.chunks(aperture.driven.len()).map(|u| transfer.pressure(u)[0].norm_sqr()).collect();
        statistics::mean(squares.into_iter()).sqrt()
    }

    #[test]
    fn evenness_and_ripple_are_of_samples_and_of_quarters_between_neighbours() {
        let aperture = array(4, 5);
        let place = |x: f64| DVec3::new(1e-3 * x, 0.0, 0.06);
        let focus = |(x, target): (f64, f64)| Focus { position: place(x), target, part: Part::Stroke };
        // The last is no neighbour of the others.
        let foci = [(0.0, 1.0), (2.0, 3.0), (4.0, 2.0), (20.0, 0.5)].map(focus).to_vec();
        let problem = Problem { drives: 2..=2, ..Problem::new(&aperture, foci) };
        let u = scattered(&aperture, 2);
        let plane = Plane { centre: place(0.0), ..Plane::default() };
        let figures = figures(&problem, &Surroundings::of_plane(plane, 0.0), &u);
        let targets = [1.0, 1.5, 2.0, 2.5, 3.0, 2.75, 2.5, 2.25, 2.0];
        let along = (0..).map(|quarter| 0.5 * f64::from(quarter)).zip(targets).chain([(20.0, 0.5)]);
        let relative: Vec<_> = along.map(|(x, target)| heard_at(&aperture, place(x), &u) / target).collect();
        let least = relative.iter().copied().fold(f64::INFINITY, f64::min);
        let most = relative.iter().copied().fold(0.0, f64::max);
        let evenness = least / statistics::mean(relative.iter().copied());
        assert!((figures.evenness - evenness).abs() < 1e-9, "{} is {evenness}", figures.evenness);
        let ripple = 20.0 * (most / least).log10();
        assert!((figures.ripple_db - ripple).abs() < 1e-9, "{} dB is {ripple} dB", figures.ripple_db);
    }
}
