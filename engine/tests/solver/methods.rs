//! The solver's methods and figures against direct implementations of their definitions.

use std::f64::consts::TAU;

use glam::{DVec3, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::scene::{Focus, Method, Motion, MotionPath, Pressures, Scene, Shape, Target};
use sonoglyph::solver::levels::Reached;
use sonoglyph::solver::{self, Limits, Problem, Warning, frames, warnings_of_foci};

const PLACES: [DVec3; 4] =
    [dvec3(-0.02, 0.004, 0.1), dvec3(-0.013, 0.004, 0.11), dvec3(0.02, 0.01, 0.12), dvec3(0.024, 0.008, 0.1)];
const TARGETS: [f64; 4] = [1.0, 0.5, 2.0, 1.5];

/// Foci with different targets, some of which interfere.
fn problem(aperture: &Aperture) -> Problem<'_> {
    let focus = |(&position, &target): (&DVec3, &f64)| Focus::new(position, target);
    Problem::new(aperture, PLACES.iter().zip(&TARGETS).map(focus).collect())
}

fn aperture() -> Aperture {
    let mut scene = Scene::default();
    scene.array.off = vec![7, 100];
    Aperture::new(&scene)
}

/// The excitation by a method after this number of iterations.
fn found(problem: &Problem<'_>, method: Method, iterations: u32) -> Vec<Complex64> {
    solver::excite(problem, method, iterations).unwrap().values
}

/// The same phases with these moduli.
fn with_moduli(values: &[Complex64], moduli: impl Iterator<Item = f64>) -> Vec<Complex64> {
    values.iter().zip(moduli).map(|(value, modulus)| value / value.norm() * modulus).collect()
}

fn assert_same(got: &[Complex64], expected: &[Complex64], what: &str) {
    let largest = expected.iter().map(|value| value.norm()).fold(0.0, f64::max);
    assert_eq!(got.len(), expected.len());
    for (n, (got, expected)) in got.iter().zip(expected).enumerate() {
        assert!((got - expected).norm() < 1e-9 * largest, "{what}, element {n}: {got} is not {expected}");
    }
}

fn spread(moduli: &[f64]) -> f64 {
    let mean = moduli.iter().sum::<f64>() / moduli.len() as f64;
    let variance = moduli.iter().map(|modulus| (modulus - mean).powi(2)).sum::<f64>() / moduli.len() as f64;
    variance.sqrt() / mean
}

fn relative(problem: &Problem<'_>, values: &[Complex64]) -> Vec<f64> {
    problem.transfer.pressure(values).iter().zip(TARGETS).map(|(p, target)| p.norm() / target).collect()
}

#[test]
fn near_and_distant_foci_have_equal_weight() {
    let mut scene = Scene::default();
    scene.medium.absorption = Some(0.0);
    let aperture = Aperture::new(&scene);
    // The distant one hears a millionth of the near one, in another direction.
    let transfer = aperture.transfer(&[dvec3(0.0, 0.0, 0.1), dvec3(6e4, 0.0, 8e4)]);
    let (rank, condition) = solver::rank_and_condition(&transfer);
    assert!(rank == 2 && condition < 1.5, "{rank}, {condition}");
}

#[test]
fn naive_is_phase_conjugation() {
    let aperture = aperture();
    let problem = problem(&aperture);
    assert_same(
        &found(&problem, Method::Naive, 0),
        &problem.transfer.back(&TARGETS.map(Complex64::from)),
        "naive",
    );
}

#[test]
fn gerchberg_saxton_alternates_between_foci_and_elements() {
    let aperture = aperture();
    let problem = problem(&aperture);
    let (transfer, ones) = (&problem.transfer, || std::iter::repeat(1.0));
    let mut u = with_moduli(&transfer.back(&TARGETS.map(Complex64::from)), ones());
    for iterations in 1..4 {
        let p = with_moduli(&transfer.pressure(&u), TARGETS.into_iter());
        u = with_moduli(&transfer.back(&p), ones());
        assert_same(&found(&problem, Method::Gs, iterations), &u, &format!("{iterations} iterations"));
    }
}

/// Plasencia et al. 2020: back-propagation divided by the power at each focus; the final step corrects the focal
/// moduli.
#[test]
fn gs_pat_iterates_on_foci_and_ends_with_a_correction() {
    let aperture = aperture();
    let problem = problem(&aperture);
    let transfer = &problem.transfer;
    let power: Vec<f64> = transfer.rows().map(|row| row.map(|h| h.norm_sqr()).sum()).collect();
    let back = |p: &[Complex64]| {
        transfer.back(&p.iter().zip(&power).map(|(p, power)| p / power).collect::<Vec<_>>())
    };
    let mut p = TARGETS.map(Complex64::from).to_vec();
    for iterations in 1..4 {
        p = with_moduli(&transfer.pressure(&back(&p)), TARGETS.into_iter());
        let made = transfer.pressure(&back(&p));
        let corrected: Vec<_> =
            made.iter().zip(TARGETS).map(|(made, target)| made * (target / made.norm()).powi(2)).collect();
        let expected = back(&corrected);
        assert_same(&found(&problem, Method::Gspat, iterations), &expected, &format!("{iterations}"));
    }
}

#[test]
fn the_greedy_search_ends_at_a_coordinatewise_optimum() {
    let aperture = aperture();
    let problem = problem(&aperture);
    let transfer = &problem.transfer;
    let u = found(&problem, Method::Greedy, 300);
    let turn = |step: usize| Complex64::from_polar(1.0, TAU * step as f64 / 16.0);
    assert!(u.iter().all(|u| (0..16).any(|step| (u - turn(step)).norm() < 1e-12)), "on 16 phases");
    // The search aims at the mean level of weighted iteration.
    let level = relative(&problem, &found(&problem, Method::Wgs, 20)).iter().sum::<f64>() / 4.0;
    let miss = |pressure: &dyn Fn(usize) -> Complex64| -> f64 {
        (0..4).map(|m| (pressure(m).norm() / TARGETS[m] - level).powi(2)).sum()
    };
    let made = transfer.pressure(&u);
    let reached = miss(&|m| made[m]);
    for (n, before) in u.iter().enumerate() {
        for step in 0..16 {
            let changed = miss(&|m| made[m] + transfer.at(m, n) * (turn(step) - before));
            assert!(changed >= reached * (1.0 - 1e-9), "element {n}, step {step}: {changed} < {reached}");
        }
    }
    let relative = relative(&problem, &u);
    assert!(relative.iter().all(|p| (p / level - 1.0).abs() < 0.12), "{relative:?} about {level}");
}

#[test]
fn a_longer_search_is_never_weaker() {
    let aperture = aperture();
    let problem = problem(&aperture);
    let weakest = |batches: usize| {
        relative(&problem, &solver::search(&problem, batches).values)
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    };
    let reached = [1, 2, 4, 8].map(weakest);
    assert!(reached.windows(2).all(|pair| pair[1] >= pair[0] * (1.0 - 1e-12)), "{reached:?}");
    let best =
        relative(&problem, &found(&problem, Method::Best, 0)).into_iter().fold(f64::INFINITY, f64::min);
    assert!(reached[3] > 0.98 * best, "{reached:?} and {best}");
}

/// Foci of grids, rings, a cube and an octahedron: 4 to 12 mm from one to the next, 0.1 to 0.2 m high.
fn symmetric_sets() -> Vec<(String, Vec<DVec3>)> {
    let grid = |columns: u32, rows: u32, apart: f64, height: f64| {
        let place = move |i: u32, count: u32| apart * (f64::from(i) - f64::from(count - 1) / 2.0);
        let row = move |j| (0..columns).map(move |i| dvec3(place(i, columns), place(j, rows), height));
        (0..rows).flat_map(row).collect::<Vec<_>>()
    };
    let ring = |count: u32, radius: f64, height: f64| {
        let at = |i: u32| (TAU * f64::from(i) / f64::from(count)).sin_cos();
        (0..count).map(at).map(|(sin, cos)| dvec3(radius * cos, radius * sin, height)).collect()
    };
    let mut sets: Vec<(String, Vec<DVec3>)> = Vec::new();
    for (columns, rows, apart, height) in [
        (2, 2, 8e-3, 0.12),
        (2, 4, 8e-3, 0.1),
        (3, 3, 5e-3, 0.12),
        (3, 3, 8e-3, 0.2),
        (3, 4, 6e-3, 0.15),
        (4, 4, 4e-3, 0.12),
        (4, 4, 12e-3, 0.15),
        (3, 7, 5e-3, 0.12),
        (5, 5, 4e-3, 0.2),
        (6, 6, 8e-3, 0.1),
    ] {
        let name = format!("{columns} x {rows}, {apart} m apart at {height} m");
        sets.push((name, grid(columns, rows, apart, height)));
    }
    for (count, radius, height) in
        [(4, 5.7e-3, 0.1), (5, 5.1e-3, 0.1), (6, 6e-3, 0.12), (8, 6.5e-3, 0.12), (10, 6.5e-3, 0.12)]
    {
        sets.push((format!("{count} on a ring of {radius} m at {height} m"), ring(count, radius, height)));
    }
    let cube = [0.116, 0.124].into_iter().flat_map(|height| grid(2, 2, 8e-3, height)).collect();
    sets.push(("a cube".to_owned(), cube));
    let tips = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let octahedron = tips.map(|axis| dvec3(0.0, 0.0, 0.1) + 8e-3 * axis).collect();
    sets.push(("an octahedron".to_owned(), octahedron));
    sets
}

#[test]
fn best_of_symmetric_foci_is_the_best_of_methods() {
    let aperture = Aperture::new(&Scene::default());
    for (name, places) in symmetric_sets() {
        let foci = places.iter().map(|&position| Focus::new(position, 1.0)).collect();
        let problem = Problem::new(&aperture, foci);
        let weakest = |values: &[Complex64]| {
            let played = with_moduli(values, std::iter::repeat(1.0));
            problem.transfer.pressure(&played).iter().map(|p| p.norm()).fold(f64::INFINITY, f64::min)
        };
        let best = weakest(&found(&problem, Method::Best, 0));
        for method in [Method::Wgs, Method::Gs, Method::Gspat, Method::Greedy] {
            let other = weakest(&found(&problem, method, 0));
            assert!(best > 0.99 * other, "{name}: {best} Pa, and {method:?} has {other} Pa");
        }
        let searched = weakest(&solver::search(&problem, 12).values);
        assert!(best > 0.99 * searched, "{name}: {best} Pa, and a search finds {searched} Pa");
        // Moved, too, they keep it.
        let moved = places.iter().map(|&at| Focus::new(at + dvec3(5e-4, 2e-4, 0.0), 1.0)).collect();
        let moved = Problem::new(&aperture, moved);
        let before = solver::excite(&problem, Method::Best, 0).unwrap();
        let after = solver::excite_from(&moved, &before).values;
        let kept = moved.transfer.pressure(&after).iter().map(|p| p.norm()).fold(f64::INFINITY, f64::min);
        assert!(kept > 0.95 * best, "{name}: {kept} of {best} Pa after a move");
    }
}

#[test]
fn figures_follow_their_definitions() {
    let target = |(&at, &pressure): (&DVec3, &f64)| Target { pressure, ..Target::new(Shape::Point { at }) };
    let mut scene = Scene { targets: PLACES.iter().zip(&TARGETS).map(target).collect(), ..Scene::default() };
    for method in [Method::Naive, Method::Pinv, Method::Gs] {
        scene.solver.method = method;
        let aperture = Aperture::new(&scene);
        let problem = problem(&aperture);
        let solution = solver::solve(&scene).unwrap();
        let free = found(&problem, method, 0);
        let played = solution.drive.excitation(&aperture.driven);
        let moduli: Vec<_> = problem.transfer.pressure(&played).iter().map(|p| p.norm()).collect();
        let near = |got: f64, expected: f64, what: &str| {
            assert!((got - expected).abs() < 1e-9 * expected + 1e-12, "{method:?} {what}: {got}, {expected}");
        };
        let quality = &solution.quality;
        near(quality.mean_pressure, moduli.iter().sum::<f64>() / 4.0, "mean");
        near(quality.min_pressure, moduli.iter().copied().fold(f64::INFINITY, f64::min), "weakest");
        near(quality.spread, spread(&relative(&problem, &played)), "spread");
        let reached = Reached::new(&problem, &solution.drive);
        near(reached.mean_pressure, quality.mean_pressure, "mean of the drive");
        near(reached.spread, quality.spread, "spread of the drive");
        let relative = relative(&problem, &played);
        let weakest = relative.iter().copied().fold(f64::INFINITY, f64::min);
        near(reached.weakest, weakest, "weakest of the drive");
        near(quality.evenness, weakest / relative.iter().sum::<f64>() * 4.0, "evenness");
        let largest = free.iter().map(|u| u.norm_sqr()).fold(0.0, f64::max);
        near(
            quality.efficiency,
            free.iter().map(|u| u.norm_sqr()).sum::<f64>() / 256.0 / largest,
            "efficiency",
        );
        // Relative to a time-of-flight focus with this focus' share of the power.
        let alone = problem.transfer.rows().map(|row| row.map(|h| h.norm()).sum::<f64>());
        let parts: f64 = moduli.iter().zip(alone).map(|(p, alone)| p / (alone / 2.0)).sum();
        near(quality.relative_to_single, parts / 4.0, "relative to single");
        // At the scale of the targets that fits the moduli best, since an excitation may have any.
        let made = problem.transfer.pressure(&free);
        let power: f64 = TARGETS.iter().map(|target| target * target).sum();
        let scale = power / made.iter().zip(TARGETS).map(|(p, target)| p.norm() * target).sum::<f64>();
        // The pseudo-inverse prescribes phases, too.
        let has_phases = method == Method::Pinv;
        let off = |(p, target): (&Complex64, f64)| {
            let off =
                if has_phases { p * scale - target } else { Complex64::from(p.norm() * scale - target) };
            off.norm_sqr()
        };
        let residual = (made.iter().zip(TARGETS).map(off).sum::<f64>() / power).sqrt();
        if has_phases {
            assert!(quality.residual < 1e-12 && residual < 1e-12, "{residual}, {quality:?}");
        } else {
            near(quality.residual, residual, "residual");
        }
    }
}

#[test]
fn as_many_foci_as_elements_may_be_dependent() {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (2, 2);
    let aperture = Aperture::new(&scene);
    let limits = |places: [DVec3; 4]| {
        let foci = places.map(|position| Focus::new(position, 1.0)).to_vec();
        let problem = Problem::new(&aperture, foci);
        let limits = Limits::new(&problem);
        (limits.rank, limits.warning(&problem))
    };
    assert_eq!(limits(PLACES), (4, None));
    let [a, b, c, _] = PLACES;
    let (rank, warning) = limits([a, b, c, a]);
    assert!(
        rank == 3 && warning.is_some_and(|text| text.to_string().contains("4 foci have only 3")),
        "rank {rank}"
    );
}

#[test]
fn one_focus_reaches_its_bound_and_rounding_never_exceeds_it() {
    for place in PLACES {
        let mut scene = Scene { targets: vec![Target::new(Shape::Point { at: place })], ..Scene::default() };
        scene.solver.method = Method::Focus;
        let solution = solver::solve(&scene).unwrap();
        let aperture = Aperture::new(&scene);
        let bound = solver::bound(&Problem::new(&aperture, solution.foci.clone()));
        let certified = solution.certified(bound);
        assert!(certified <= 1.0 && certified > 1.0 - 1e-11, "{certified}");
    }
}

#[test]
fn a_turned_solution_has_the_pressures_of_its_drive() {
    let target = |&at: &DVec3| Target::new(Shape::Point { at });
    let scene = |places: &[DVec3]| Scene { targets: places.iter().map(target).collect(), ..Scene::default() };
    let [before, after] = [&PLACES[..2], &PLACES[1..3]].map(|places| solver::solve(&scene(places)).unwrap());
    let turned = after.clone().turned_to(&before);
    let aperture = Aperture::new(&scene(&PLACES));
    let made = aperture.transfer(&PLACES[1..3]).pressure(&turned.drive.excitation(&aperture.driven));
    assert_same(&turned.pressures, &made, "pressures");
    assert!((turned.pressures[0] - after.pressures[0]).norm() > 1.0, "not turned at all");
}

#[test]
fn targets_that_no_sound_reaches_are_too_loud() {
    let at = dvec3(0.0, 0.0, 10.0);
    let mut scene = Scene { targets: vec![Target::new(Shape::Point { at })], ..Scene::default() };
    // 10 000 dB on the way: no number of f64 is that small.
    scene.medium.absorption = Some(1e3);
    scene.solver.pressures = Pressures::Pascal;
    for method in [Method::Best, Method::Pinv, Method::Weighted, Method::Gs] {
        scene.solver.method = method;
        let solution = solver::solve(&scene).unwrap();
        assert_eq!((solution.quality.mean_pressure, solution.turned_down), (0.0, 1.0), "{method:?}");
        let is_too_loud = |warning: &Warning| matches!(warning, Warning::TooLoud { .. });
        assert!(solution.warnings.iter().any(is_too_loud), "{method:?}: {:?}", solution.warnings);
    }
}

#[test]
fn warnings_count_pairs_and_name_the_closest() {
    let aperture = aperture();
    let at = |millimetres: f64| Focus::new(dvec3(1e-3 * millimetres, 0.0, 0.1), 1.0);
    let warnings = |places: &[f64]| {
        let foci: Vec<_> = places.iter().map(|&place| at(place)).collect();
        warnings_of_foci(&aperture, &foci).iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(warnings(&[-30.0, 0.0, 30.0]), Vec::<String>::new());
    let close = warnings(&[0.0, 2.5, 1.0, 40.0]);
    let resolution = 1e3 * aperture.resolution()(at(1.75).position);
    assert!(close.len() == 1 && close[0].starts_with("3 pairs"), "{close:?}");
    assert!(close[0].contains("1.00 mm apart"), "{close:?}");
    assert!(close[0].contains(&format!("{resolution:.1}")), "{close:?}, {resolution} mm");
    let coincident = warnings(&[0.0, 40.0, 0.0]);
    assert!(coincident.len() == 1 && coincident[0].starts_with("1 pairs of foci coincide"), "{coincident:?}");
    let both = warnings(&[0.0, 1.0, 0.0]);
    assert!(both.len() == 2 && both[1].starts_with("2 pairs of foci are closer"), "{both:?}");
}

#[test]
fn the_common_phase_advances_by_the_same_part_from_frame_to_frame() {
    let focus = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / 3.0).sin_cos();
        Target::new(Shape::Point { at: dvec3(0.02 * cos, 0.02 * sin, 0.1) })
    };
    let motion = Motion { path: MotionPath::Circle, frames: 7, ..Motion::default() };
    let scene = Scene { targets: (0..3).map(focus).collect(), motion, ..Scene::default() };
    let aperture = Aperture::new(&scene);
    let sequence = frames::follow(&scene).unwrap();
    let played: Vec<_> =
        sequence.frames.iter().map(|frame| frame.drive.excitation(&aperture.driven)).collect();
    let step = |i: usize| {
        let next = &played[(i + 1) % played.len()];
        played[i].iter().zip(next).map(|(from, to)| from.conj() * to).sum::<Complex64>().arg()
    };
    let steps: Vec<_> = (0..played.len()).map(step).collect();
    assert!(steps.iter().all(|step| (step - steps[0]).abs() < 1e-6), "{steps:?}");
    assert!(steps[0].abs() <= TAU / 2.0 / played.len() as f64 + 1e-6, "{steps:?}");
}

#[test]
fn a_direction_gets_the_phases_of_a_plane_wave() {
    let way = dvec3(0.3, -0.2, 0.9).normalize_or_zero();
    let directed = Target::new(Shape::Direction { direction: way * 7.0 });
    for method in [Method::Focus, Method::Naive, Method::Pinv, Method::Best] {
        let mut scene = Scene { targets: vec![directed.clone()], ..Scene::default() };
        scene.solver.method = method;
        let solution = solver::solve(&scene).unwrap();
        let aperture = Aperture::new(&scene);
        let wave = |n: usize| -aperture.element.wavenumber * way.dot(aperture.positions[n]);
        let turn = solution.drive.phases[0] - wave(0);
        for (n, phase) in solution.drive.phases.iter().enumerate() {
            let off = (phase - wave(n) - turn).sin().abs() + 1.0 - (phase - wave(n) - turn).cos();
            assert!(off < 1e-9, "{method:?}, element {n}: {off} rad");
        }
        // All elements in phase, each with its directivity.
        let sin = way.cross(DVec3::Z).length();
        let expected = 256.0 * aperture.element.strength * aperture.element.directivity(sin);
        assert!((solution.pressures[0].norm() / expected - 1.0).abs() < 1e-9, "{method:?}");
    }
    // Beside a point, both are reached.
    let point = Target::new(Shape::Point { at: dvec3(-0.02, 0.0, 0.1) });
    let scene = Scene { targets: vec![Target { pressure: 0.1, ..directed }, point], ..Scene::default() };
    let solution = solver::solve(&scene).unwrap();
    let ratio = solution.pressures[0].norm() / solution.pressures[1].norm();
    assert!((ratio / 0.1 - 1.0).abs() < 0.02, "{ratio}");
}
