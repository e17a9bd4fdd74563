//! Quality figures of a shape's drive, in f64 and on finer samples than the solver's.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::acoustics::Aperture;
use crate::scene::{Cover, Focus, Part, Plane};
use crate::solver::shape::grid::{Grid, Layout};
use crate::solver::shape::real::Waves;
use crate::solver::shape::region::{self, Area};
use crate::solver::shape::{Surroundings, strongest, wanted};
use crate::solver::{Problem, statistics};

/// Figures of a drive, independent of its scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Least over mean of |p|/target along the strokes and at the foci, 0 to 1.
    pub evenness: f64,
    /// Loudest over least of |p|/target there, dB.
    pub ripple_db: f64,
    /// The loudest |p| of the plane, farther than 8 mm (0.93 wavelengths, if that is more) from every focus and area,
    /// over the mean at the foci; 0 without such a point, or without sound at the foci.
    pub side_lobe: f64,
    /// m
    pub side_lobe_position: DVec3,
    /// Mean |p|/target relative to that of the strongest drive (`quiet` = 0).
    pub strength: f64,
    /// For areas, or a depression.
    pub areas: Option<AreaFigures>,
}

/// Figures of areas, over them and the 3.7 wavelengths around them: of |p|², or of a liquid's depression if
/// prescribed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaFigures {
    /// Mean inside over mean around.
    pub contrast: f64,
    /// Σ (s I - T)² / Σ T² with I the actual and T the target value and s the best scale: 0 to 1.
    pub error: f64,
}

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
    let drawn = drawn(problem, &surroundings.areas);
    let (side_lobe_position, loudest) =
        side_lobe(problem, &drawn, &surroundings.plane, u).unwrap_or_default();
    let at_mean = statistics::mean(at_foci.iter().copied());
    let strength = |u: &[Complex64]| {
        let played = u.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let relative: Vec<_> =
            problem.transfer.moduli(u).iter().zip(problem.targets()).map(|(p, target)| p / target).collect();
        statistics::mean(relative.iter().copied()) / played
    };
    Figures {
        evenness: least / mean,
        ripple_db: 20.0 * (most / least.max(1e-6 * most).max(f64::MIN_POSITIVE)).max(1.0).log10(),
        side_lobe: if at_mean > 0.0 { loudest / at_mean } else { 0.0 },
        side_lobe_position,
        strength: strength(u) / strength(&strongest(problem)).max(f64::MIN_POSITIVE),
        areas: areas(problem, surroundings, u),
    }
}

/// Figures of areas; of a silent drive, the worst values.
fn areas(problem: &Problem<'_>, surroundings: &Surroundings, u: &[Complex64]) -> Option<AreaFigures> {
    let most = problem.transfer.rows().map(|row| row.map(|h| h.norm()).sum::<f64>()).fold(0.0, f64::max);
    let mut picture = wanted::picture::<f64>(problem, surroundings, true, 1.0 / most)?;
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

/// Foci, with dense samples in place of those of areas, so that distances are measured from the whole areas.
fn drawn(problem: &Problem<'_>, areas: &[Cover]) -> Vec<Focus> {
    /// Spacing of samples in wavelengths, and their limit.
    const SPACING: f64 = 0.125;
    const MOST: f64 = 4096.0;
    let size = areas.iter().map(|cover| 4.0 * cover.half.element_product()).sum::<f64>();
    let spacing = (SPACING * problem.aperture.wavelength()).max((size / MOST).sqrt());
    let separate = problem.foci.iter().filter(|focus| !focus.is_of_area()).copied();
    let patches = areas.iter().flat_map(|cover| cover.patches(spacing));
    let of_areas = patches.map(|patch| Focus { position: patch.at, target: 1.0, part: Part::Area(0) });
    separate.chain(of_areas).collect()
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

/// The loudest undrawn point of the plane, and |p| (Pa) there.
fn side_lobe(problem: &Problem<'_>, drawn: &[Focus], plane: &Plane, u: &[Complex64]) -> Option<(DVec3, f64)> {
    /// m, and wavelengths.
    const NEAREST: f64 = 8e-3;
    const NEAREST_WAVES: f64 = 0.93;
    /// Threshold relative to the loudest sample, and limit of starting points for the search of the maximum.
    const LOUD: f64 = 0.8;
    const MOST: usize = 48;
    let (aperture, foci) = (problem.aperture, drawn);
    let (x, y) = plane.axes()?;
    let nearest = (NEAREST_WAVES * aperture.wavelength()).max(NEAREST);
    let (samples, spacing) = match Area::new(problem, plane, true)? {
        Area::Grid(layout) => (heard(aperture, drawn, &layout, u, nearest), layout.spacing(aperture.pitch)),
        Area::Points { points, spacing } => {
            let points: Vec<_> =
                points.into_iter().filter(|&point| region::distance(point, foci) > nearest).collect();
            let heard = moduli(aperture, &points, u);
            (points.into_iter().zip(heard).collect::<Vec<_>>(), spacing)
        }
    };
    let at_edge = edge(foci, plane.centre, [x, y], nearest);
    let heard = moduli(aperture, &at_edge, u);
    let samples: Vec<_> = samples.into_iter().chain(at_edge.into_iter().zip(heard)).collect();
    let loudest = samples.iter().map(|(_, p)| *p).fold(0.0, f64::max);
    let mut loud: Vec<_> = samples.into_iter().filter(|(_, p)| *p >= LOUD * loudest).collect();
    loud.sort_by(|a, b| b.1.total_cmp(&a.1));
    let refined = |&(place, _): &(DVec3, f64)| {
        let mut best = (place, moduli(aperture, &[place], u)[0]);
        let mut step = 0.5 * spacing;
        while step > 0.02 * spacing {
            let sides = [x, -x, y, -y, x + y, x - y, y - x, -x - y].map(|side| best.0 + side * step);
            let sides: Vec<_> =
                sides.into_iter().filter(|&place| region::distance(place, foci) > nearest).collect();
            let louder =
                sides.iter().copied().zip(moduli(aperture, &sides, u)).max_by(|a, b| a.1.total_cmp(&b.1));
            match louder {
                Some(louder) if louder.1 > best.1 => best = louder,
                _ => step *= 0.5,
            }
        }
        best
    };
    // One point of every lobe.
    let apart = 0.4 * aperture.wavelength();
    let mut places: Vec<(DVec3, f64)> = Vec::new();
    for loud in loud {
        if places.len() < MOST && places.iter().all(|place| place.0.distance(loud.0) > apart) {
            places.push(loud);
        }
    }
    places.iter().map(refined).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Points of the plane just farther than `nearest` (m) from the foci, on the flank of the drawing: up to the next
/// sample it may fall by more than a side lobe does.
fn edge(foci: &[Focus], centre: DVec3, [x, y]: [DVec3; 2], nearest: f64) -> Vec<DVec3> {
    /// Around a focus, and around all of them at most.
    const DIRECTIONS: usize = 16;
    const MOST: usize = 2048;
    let around = |focus: &Focus| {
        let away = (focus.position - centre).dot(x.cross(y));
        let on_plane = focus.position - x.cross(y) * away;
        let radius = 1.001 * (nearest * nearest - away * away).max(0.0).sqrt();
        (0..DIRECTIONS).map(move |direction| {
            let (sin, cos) = (TAU * direction as f64 / DIRECTIONS as f64).sin_cos();
            on_plane + (x * cos + y * sin) * radius
        })
    };
    let every = (foci.len() * DIRECTIONS).div_ceil(MOST);
    let places = foci.iter().flat_map(around).step_by(every);
    places.filter(|&place| region::distance(place, foci) > nearest).collect()
}

/// Points farther than `nearest` (m) from every focus, and |p| (Pa) there, in f32.
fn heard(
    aperture: &Aperture,
    drawn: &[Focus],
    layout: &Layout,
    u: &[Complex64],
    nearest: f64,
) -> Vec<(DVec3, f64)> {
    let largest = u.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
    // Scaled to an element's field, so that f32 holds squares.
    let scale = layout.height / aperture.element.strength.max(f64::MIN_POSITIVE);
    let mut grid = Grid::<f32>::new(aperture, *layout, scale);
    let mut squares = vec![0.0; layout.len()];
    let elements = aperture.driven.len();
    for u in u.chunks(elements) {
        let played = Waves {
            re: u.iter().map(|u| (u.re / largest) as f32).collect(),
            im: u.iter().map(|u| (u.im / largest) as f32).collect(),
        };
        let mut field = Waves::zeros(layout.len());
        grid.forward(&played, &mut field);
        squares.iter_mut().enumerate().for_each(|(index, sum)| *sum += field.square(index));
    }
    let drives = (u.len() / elements) as f64;
    let distances = region::distances(layout, aperture.pitch, drawn, 1.1 * nearest);
    let places = layout.places(aperture.pitch).filter(|(index, _)| distances[*index] > nearest);
    places
        .map(|(index, place)| {
            let modulus = (squares[index] / drives).sqrt();
            (place.extend(layout.height), modulus * largest / scale)
        })
        .collect()
}

#[cfg(test)]
mod lobes;

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::scene::{Sampling, Scene, Shape, Target, outline};
    use crate::solver::starts::scatter;

    #[test]
    fn areas_are_drawn_by_samples_an_eighth_of_a_wavelength_apart() {
        let middle = DVec3::new(0.01, 0.0, 0.1);
        let area = Target {
            sampling: Sampling::Fill,
            ..Target::new(Shape::Rectangle { at: middle, width: 0.03, height: 0.02 })
        };
        let beside = DVec3::new(-0.03, 0.0, 0.1);
        let targets = vec![area, Target::new(Shape::Point { at: beside })];
        let scene = Scene { targets, ..Scene::default() };
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let drawn = drawn(&problem, &problem.surroundings.as_ref().unwrap().areas);
        assert!(drawn.len() < 1000, "{}", drawn.len());
        assert_eq!(drawn.iter().filter(|focus| focus.position == beside).count(), 1);
        for i in 0..=30 {
            for j in 0..=20 {
                let at = middle + DVec3::new(1e-3 * f64::from(i - 15), 1e-3 * f64::from(j - 10), 0.0);
                let far = drawn.iter().map(|focus| focus.position.distance(at)).fold(f64::INFINITY, f64::min);
                assert!(far < 0.1 * aperture.wavelength(), "{at} is {far} m from every sample");
            }
        }
    }

    #[test]
    fn figures_do_not_depend_on_the_scale_of_the_drive() {
        let ends = [DVec3::new(-0.02, 0.0, 0.1), DVec3::new(0.02, 0.0, 0.1)];
        let line =
            Target { sampling: Sampling::Whole, ..Target::new(Shape::Line { from: ends[0], to: ends[1] }) };
        let scene = Scene { targets: vec![line], ..Scene::default() };
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let surroundings = Surroundings::of_plane(scene.plane.clone(), 0.0);
        let u = strongest(&problem);
        let figures = |scale: f64| {
            let scaled: Vec<_> = u.iter().map(|u| u * scale).collect();
            figures(&problem, &surroundings, &scaled)
        };
        let alone = figures(1.0);
        for scale in [1.0 / 1024.0, 1024.0] {
            let scaled = figures(scale);
            assert!((scaled.side_lobe / alone.side_lobe - 1.0).abs() < 1e-9, "{scaled:?}, not {alone:?}");
            assert_eq!(scaled.side_lobe_position, alone.side_lobe_position);
            assert!((scaled.evenness / alone.evenness - 1.0).abs() < 1e-9, "{scaled:?}, not {alone:?}");
            assert!((scaled.strength / alone.strength - 1.0).abs() < 1e-9, "{scaled:?}, not {alone:?}");
        }
    }

    #[test]
    fn the_edge_lies_on_the_plane_around_foci_beside_it() {
        let (centre, axes) = (DVec3::Z * 0.1, [DVec3::X, DVec3::new(0.0, 0.8, 0.6)]);
        let normal = axes[0].cross(axes[1]);
        let at = |x: f64, away: f64| centre + axes[0] * x + normal * away;
        let focus = |position| Focus { position, target: 1.0, part: Part::Point };
        let foci = [at(0.0, 0.003), at(0.004, -0.002), at(0.04, 0.0)].map(focus);
        let places = edge(&foci, centre, axes, 0.005);
        assert!(places.len() > 24, "{}", places.len());
        for place in places {
            assert!(normal.dot(place - centre).abs() < 1e-12, "{place}");
            let nearest =
                foci.iter().map(|focus| focus.position.distance(place)).fold(f64::INFINITY, f64::min);
            assert!(nearest > 0.005 && nearest < 0.00502, "{place}: {nearest}");
        }
    }

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
        let problem = Problem { drives: 2, ..Problem::new(&aperture, foci) };
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

    #[test]
    fn samples_of_drives_in_turn_are_heard_as_their_root_mean_square() {
        let aperture = array(4, 5);
        let layout = Layout::new(&aperture, 0.06, DVec2::splat(0.03), 2);
        let drawn = [Focus::new(DVec3::Z * 0.06, 1.0)];
        for drives in 1..=3 {
            let u = scattered(&aperture, drives);
            let heard = heard(&aperture, &drawn, &layout, &u, 8e-3);
            let loudest = heard.iter().map(|(_, p)| *p).fold(0.0, f64::max);
            assert!(heard.len() > 100, "{}", heard.len());
            for (at, p) in heard {
                assert!(at.distance(drawn[0].position) > 8e-3, "{at} is drawn");
                let expected = heard_at(&aperture, at, &u);
                assert!((p - expected).abs() < 1e-4 * loudest, "{drives} drives, {at}: {p} is {expected}");
            }
        }
    }

    #[test]
    fn the_side_lobe_is_a_maximum_between_samples() {
        let aperture = array(8, 8);
        let focus = DVec3::new(0.03, 0.0, 0.1);
        let problem = Problem::new(&aperture, vec![Focus::new(focus, 1.0)]);
        let u: Vec<_> = problem.transfer.row(0).map(|h| Complex64::cis(-h.arg())).collect();
        let plane = Plane { centre: DVec3::Z * 0.1, ..Plane::default() };
        let figures = figures(&problem, &Surroundings::of_plane(plane, 0.0), &u);
        let at = figures.side_lobe_position;
        let loudest = heard_at(&aperture, at, &u);
        let expected = loudest / heard_at(&aperture, focus, &u);
        assert!((figures.side_lobe - expected).abs() < 1e-9, "{} is {expected}", figures.side_lobe);
        // A grating lobe, far from the edge of the drawing.
        assert!(at.distance(focus) > 0.02, "{at}");
        for direction in 0..16 {
            let (sin, cos) = (TAU * f64::from(direction) / 16.0).sin_cos();
            let beside = heard_at(&aperture, at + 2e-4 * DVec3::new(cos, sin, 0.0), &u);
            assert!(beside <= loudest, "{direction}: {beside} beside {loudest}");
        }
    }

    #[test]
    fn strengths_of_two_drives_compare_as_their_mean_pressures_over_targets() {
        let aperture = array(4, 5);
        let focus = |(x, target)| Focus::new(DVec3::new(x, 0.0, 0.1), target);
        let foci: Vec<_> = [(-0.02, 1.0), (0.0, 3.0), (0.03, 0.5)].into_iter().map(focus).collect();
        let problem = Problem::new(&aperture, foci.clone());
        let surroundings = Surroundings::of_plane(Plane::default(), 0.0);
        let some = scattered(&aperture, 1);
        let to_last: Vec<_> = problem.transfer.row(2).map(|h| 0.3 * Complex64::cis(-h.arg())).collect();
        let strengths = [&some, &to_last].map(|u| {
            let heard = foci.iter().map(|focus| heard_at(&aperture, focus.position, u) / focus.target);
            (figures(&problem, &surroundings, u).strength, statistics::mean(heard) / u[0].norm())
        });
        let [(one, expected_one), (other, expected_other)] = strengths;
        let error = one / other / (expected_one / expected_other) - 1.0;
        assert!(error.abs() < 1e-9 && one > 0.0, "{strengths:?}");
    }

    #[test]
    fn figures_of_areas_do_not_depend_on_the_scale_of_the_drive() {
        let shape = Shape::Rectangle { at: DVec3::Z * 0.1, width: 0.02, height: 0.012 };
        let area = Target { sampling: Sampling::Fill, ..Target::new(shape) };
        let mut scene = Scene { targets: vec![area], ..Scene::default() };
        (scene.array.rows, scene.array.columns) = (4, 4);
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let of = |scale: f64| {
            let u: Vec<_> = scattered(&aperture, 1).iter().map(|u| u * scale).collect();
            areas(&problem, problem.surroundings.as_ref().unwrap(), &u).unwrap()
        };
        let alone = of(1.0);
        assert!(alone.contrast > 0.0 && alone.error < 1.0, "{alone:?}");
        for scale in [1e-3, 1e3] {
            let scaled = of(scale);
            assert!((scaled.contrast / alone.contrast - 1.0).abs() < 1e-9, "{scaled:?}, not {alone:?}");
            assert!((scaled.error / alone.error - 1.0).abs() < 1e-9, "{scaled:?}, not {alone:?}");
        }
    }

    #[test]
    fn figures_of_areas_do_not_depend_on_the_strength_of_elements() {
        let at = DVec3::new(0.005, 0.0, 0.06);
        let shape = Shape::Rectangle { at, width: 0.02, height: 0.015 };
        let target = Target { sampling: Sampling::Fill, ..Target::new(shape) };
        let mut scene = Scene { targets: vec![target], ..Scene::default() };
        (scene.array.rows, scene.array.columns) = (4, 5);
        let of = |strength: f64| {
            let mut aperture = Aperture::new(&scene);
            aperture.element.strength = strength;
            let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
            areas(&problem, problem.surroundings.as_ref().unwrap(), &scattered(&aperture, 1)).unwrap()
        };
        let usual = of(1.0);
        for strength in [1e-60, 1e60] {
            let own = of(strength);
            let what = format!("{strength:e}: {own:?}, not {usual:?}");
            assert!((own.contrast / usual.contrast - 1.0).abs() < 1e-9, "{what}");
            assert!((own.error / usual.error - 1.0).abs() < 1e-9, "{what}");
        }
    }
}
