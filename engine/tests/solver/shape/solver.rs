//! Drives of shapes, measured in f64: even strokes and low side lobes, for any targets.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, dvec2, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::scene::{
    self, Aim, Area, ElementModel, Focus, Method, Plane, Sampling, Scene, Shape, Target, Turns, outline,
};
use sonoglyph::solver::shape::{self, Search, Surroundings, Zone, figures};
use sonoglyph::solver::{self, Problem, Warning};

type Strokes = Vec<Vec<DVec2>>;

fn curve(count: usize, place: impl Fn(f64) -> DVec2) -> Strokes {
    vec![(0..=count).map(|i| place(i as f64 / count as f64)).collect()]
}

/// Letters, and figures with and without corners, open and closed; m.
fn drawings() -> Vec<(&'static str, Strokes)> {
    let mm = |points: &[(f64, f64)]| points.iter().map(|&(x, y)| dvec2(x, y) * 1e-3).collect::<Vec<_>>();
    let ring = |radius: f64, turn: f64| DVec2::from_angle(TAU * turn) * radius;
    vec![
        ("K", vec![mm(&[(-12.0, -18.0), (-12.0, 18.0)]), mm(&[(12.0, 18.0), (-12.0, 0.0), (12.0, -18.0)])]),
        ("T", vec![mm(&[(-16.0, 18.0), (16.0, 18.0)]), mm(&[(0.0, 18.0), (0.0, -18.0)])]),
        ("ellipse", curve(90, |t| ring(0.018, t) * dvec2(1.3, 0.8))),
        ("pentagon", curve(5, |t| ring(0.02, t + 0.25))),
        ("wave", curve(60, |t| dvec2(0.05 * (t - 0.5), 0.01 * (TAU * t).sin()))),
    ]
}

/// Points at most `spacing` (m) apart along strokes.
fn sampled(strokes: &Strokes, spacing: f64) -> Vec<DVec2> {
    let mut places: Vec<DVec2> = Vec::new();
    for pair in strokes.iter().flat_map(|stroke| stroke.windows(2)) {
        let parts = (pair[0].distance(pair[1]) / spacing).ceil() as usize;
        places.extend((0..=parts).map(|part| pair[0].lerp(pair[1], part as f64 / parts as f64)));
    }
    let mut kept: Vec<DVec2> = Vec::new();
    for place in places {
        if kept.iter().all(|other| other.distance(place) > 1e-9) {
            kept.push(place);
        }
    }
    kept
}

fn foci(strokes: &Strokes, spacing: f64) -> Vec<Focus> {
    let focus = |place: DVec2| Focus::new(place.extend(0.1), 1.0);
    sampled(strokes, spacing).into_iter().map(focus).collect()
}

fn surroundings(quiet: f64) -> Surroundings {
    Surroundings::of_plane(Plane::default(), quiet)
}

/// |p| by equation (1) of Long et al. 2022 with absorption, per unit of strength.
pub fn heard(aperture: &Aperture, at: DVec3, u: &[Complex64]) -> f64 {
    let element = &aperture.element;
    let wave = |(&n, u): (&usize, &Complex64)| {
        let away = at - aperture.positions[n];
        let (r, x) =
            (away.length(), element.wavenumber * element.radius * away.truncate().length() / away.length());
        let directivity = if x < 1e-6 { 1.0 } else { 2.0 * libm::j1(x) / x };
        let loss = (-element.attenuation * r).exp();
        u * Complex64::from_polar(directivity / r * loss, -element.wavenumber * r)
    };
    aperture.driven.iter().zip(u).map(wave).sum::<Complex64>().norm()
}

struct Judged {
    evenness: f64,
    side_lobe: f64,
    mean: f64,
}

/// Strokes every 0.5 mm; side lobes every 2.5 mm of 30 x 30 cm, more than 8 mm from the strokes.
fn judge(aperture: &Aperture, strokes: &Strokes, u: &[Complex64]) -> Judged {
    let places = sampled(strokes, 0.5e-3);
    let along: Vec<_> = places.iter().map(|place| heard(aperture, place.extend(0.1), u)).collect();
    let mean = along.iter().sum::<f64>() / along.len() as f64;
    let plane = (0..121 * 121).map(|i| dvec2(f64::from(i % 121), f64::from(i / 121)) * 2.5e-3 - 0.15);
    let elsewhere = plane.filter(|at| places.iter().all(|place| place.distance(*at) > 8e-3));
    let loudest = elsewhere.map(|at| heard(aperture, at.extend(0.1), u)).fold(0.0, f64::max);
    Judged {
        evenness: along.iter().copied().fold(f64::INFINITY, f64::min) / mean,
        side_lobe: loudest / mean,
        mean,
    }
}

pub fn assert_playable(u: &[Complex64], elements: usize, what: &str) {
    assert_eq!(u.len(), elements, "{what}");
    assert!(u.iter().all(|u| (u.norm() - 1.0).abs() < 1e-12), "{what}: {u:?}");
}

#[test]
fn strokes_are_even_with_low_side_lobes() {
    let aperture = Aperture::new(&Scene::default());
    for (name, strokes) in drawings() {
        let problem = Problem::new(&aperture, foci(&strokes, 2.1e-3)).with_surroundings(surroundings(0.5));
        let surroundings = problem.surroundings.as_ref().unwrap();
        let first = Search::new(&problem, surroundings).advance().unwrap();
        let first = judge(&aperture, &strokes, &first.values);
        assert!(first.evenness > 0.82, "{name}: at first {}", first.evenness);
        let drive = solver::excite(&problem, Method::Best, 0).unwrap();
        assert_playable(&drive.values, 256, name);
        let judged = judge(&aperture, &strokes, &drive.values);
        assert!(judged.evenness > 0.86, "{name}: {}", judged.evenness);
        assert!(
            judged.side_lobe < 0.57 && judged.side_lobe < 0.8 * first.side_lobe,
            "{name}: {}",
            judged.side_lobe
        );
        let spaced = Problem::new(&aperture, foci(&strokes, 4e-3));
        let strong = solver::excite(&spaced, Method::Best, 0).unwrap().values;
        let strength = judged.mean / judge(&aperture, &strokes, &strong).mean;
        assert!(strength > 0.8, "{name}: {strength}");

        let figures = figures(&problem, surroundings, &drive.values);
        let twice = Problem { drives: 2..=2, ..Problem::new(&aperture, problem.foci.clone()) };
        let again = shape::figures(&twice, surroundings, &[&drive.values[..], &drive.values].concat());
        for (one, other) in [(figures.side_lobe, again.side_lobe), (figures.evenness, again.evenness)] {
            assert!((one / other - 1.0).abs() < 1e-5, "{name}, the same drive twice: {figures:?}, {again:?}");
        }
        assert!((figures.evenness - judged.evenness).abs() < 0.03, "{name}: {figures:?}");
        let side_lobe = figures.side_lobe / judged.side_lobe;
        assert!((0.98..1.06).contains(&side_lobe), "{name}: {figures:?}, {} judged", judged.side_lobe);
        assert!((figures.strength / (judged.mean / first.mean) - 1.0).abs() < 0.02, "{name}: {figures:?}");
        let there = heard(&aperture, figures.side_lobe_position, &drive.values) / judged.mean;
        assert!((there / figures.side_lobe - 1.0).abs() < 0.03, "{name}: {figures:?}, {there} there");
    }
}

#[test]
fn lower_side_lobes_cost_strength() {
    let aperture = Aperture::new(&Scene::default());
    let strokes = &drawings()[0].1;
    let problem = Problem::new(&aperture, foci(strokes, 2.1e-3));
    let judged = [0.0, 0.05, 0.5, 1.0]
        .map(|quiet| judge(&aperture, strokes, &shape::best(&problem, &surroundings(quiet)).values));
    for pair in judged.windows(2) {
        assert!(pair[1].mean < pair[0].mean && pair[1].side_lobe < pair[0].side_lobe);
    }
    let strongest = Search::new(&problem, &surroundings(0.0)).advance().unwrap().values;
    let best = shape::best(&problem, &surroundings(0.0)).values;
    let turn = best[0] / strongest[0];
    let off = best.iter().zip(&strongest).map(|(best, strongest)| (best - strongest * turn).norm());
    assert!(off.fold(0.0, f64::max) < 1e-12, "they differ by more than a common phase");
}

#[test]
fn a_dragged_shape_stays_even_and_quiet_without_jumps() {
    let aperture = Aperture::new(&Scene::default());
    let strokes = &drawings()[1].1;
    let at = |frame: usize| -> Strokes {
        let by = dvec2(0.8e-3, 0.6e-3) * frame as f64;
        strokes.iter().map(|stroke| stroke.iter().map(|place| place + by).collect()).collect()
    };
    let mut u = shape::best(&Problem::new(&aperture, foci(&at(0), 2.1e-3)), &surroundings(0.5)).values;
    for frame in 1..=10 {
        let problem = Problem::new(&aperture, foci(&at(frame), 2.1e-3));
        let next = shape::best_from(&problem, &surroundings(0.5), &u).values;
        let turn = u.iter().zip(&next).map(|(a, b)| a.conj() * b).sum::<Complex64>();
        assert!(turn.arg().abs() < 1e-9 && turn.re > 0.7 * 256.0, "frame {frame}: turned by {turn}");
        u = next;
        let judged = judge(&aperture, &at(frame), &u);
        assert!(judged.evenness > 0.8, "frame {frame}: {}", judged.evenness);
    }
    let problem = Problem::new(&aperture, foci(&at(10), 2.1e-3));
    let rest = judge(&aperture, &at(10), &shape::best(&problem, &surroundings(0.5)).values).side_lobe;
    let dragged = judge(&aperture, &at(10), &u).side_lobe;
    assert!(dragged < 1.2 * rest, "{dragged}, and {rest} at rest");
}

#[test]
fn any_number_of_threads_finds_the_same_drive() {
    let aperture = Aperture::new(&Scene::default());
    let problem = Problem::new(&aperture, foci(&drawings()[3].1, 2.1e-3));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shape::best(&problem, &surroundings(0.5)).values)
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn zones_and_turned_planes_get_quiet_too() {
    let mut scene = Scene::default();
    scene.array.off = vec![0, 17, 120, 255];
    let aperture = Aperture::new(&scene);
    let problem = Problem::new(&aperture, foci(&drawings()[1].1, 2.1e-3));
    let ear: Vec<_> =
        (0..30).map(|i| dvec3(0.03 + 2e-3 * f64::from(i % 6), 2e-3 * f64::from(i / 6), 0.16)).collect();
    let loudest = |u: &[Complex64]| ear.iter().map(|at| heard(&aperture, *at, u)).fold(0.0, f64::max);
    let alone = shape::best(&problem, &surroundings(0.5)).values;
    let zones = vec![Zone { points: ear.clone(), weight: 8.0 }, Zone { points: ear.clone(), weight: 0.0 }];
    let spared = shape::best(&problem, &Surroundings { zones, ..surroundings(0.5) }).values;
    assert_playable(&spared, 252, "a zone");
    assert!(loudest(&spared) < 0.6 * loudest(&alone), "{} and {}", loudest(&spared), loudest(&alone));

    // A turn about the normal gives the same plane; a tilted one is evaluated by a table.
    let turned = Plane { x_axis: dvec3(0.6, 0.8, 0.0), y_axis: dvec3(-0.8, 0.6, 0.0), ..Plane::default() };
    let tilted = Plane { x_axis: dvec3(1.0, 0.0, 0.02), ..Plane::default() };
    for plane in [turned, tilted] {
        let surroundings = Surroundings { plane, ..surroundings(0.5) };
        let u = shape::best(&problem, &surroundings).values;
        let [found, before] = [&u, &alone].map(|u| figures(&problem, &surroundings, u));
        assert!(found.side_lobe < 1.2 * before.side_lobe && found.evenness > 0.85, "{found:?}, {before:?}");
    }
}

#[test]
fn any_shape_has_a_playable_drive() {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (6, 9);
    let usual = Aperture::new(&scene);
    let exact = {
        scene.array.element = ElementModel::ExactPiston;
        scene.array.off = (0..54).filter(|n| n % 5 == 0).collect();
        Aperture::new(&scene)
    };
    let lossy = {
        scene.array.element = ElementModel::Point;
        scene.medium.absorption = Some(60.0);
        Aperture::new(&scene)
    };
    let one = {
        (scene.array.rows, scene.array.columns, scene.array.off) = (1, 1, Vec::new());
        Aperture::new(&scene)
    };
    let line: Vec<_> = (0..20).map(|i| dvec3(2e-3 * f64::from(i) - 0.02, 0.0, 0.06)).collect();
    let carpet: Vec<_> =
        (0..900).map(|i| dvec3(f64::from(i % 30), f64::from(i / 30), 15.0) * 8e-3 - 0.12).collect();
    let carpet: Vec<_> = carpet.into_iter().map(|at| at.with_z(0.05)).collect();
    let off_plane: Vec<_> = line.iter().map(|at| dvec3(at.x, 0.01, 0.06 + at.x)).collect();
    let mixed: Vec<_> =
        line.iter().copied().chain([dvec3(0.0, 0.04, 0.06), dvec3(0.0, 0.04, 0.06)]).collect();
    let behind: Vec<_> = line.iter().map(|at| at.with_z(-0.05)).collect();
    let partly: Vec<_> = line.iter().copied().chain(behind.clone()).collect();
    let far = vec![dvec3(1e5, 0.0, 1e5)];
    let plane =
        |centre: DVec3, x_axis: DVec3, y_axis: DVec3| Plane { centre, x_axis, y_axis, ..Plane::default() };
    let planes = [
        plane(dvec3(0.0, 0.0, 0.06), DVec3::X, DVec3::Y),
        plane(dvec3(0.0, 0.0, 0.06), DVec3::X, DVec3::Z),
        plane(dvec3(0.0, 0.0, 1e-4), DVec3::X, DVec3::Y),
        plane(DVec3::ZERO, DVec3::X, DVec3::Y),
        plane(dvec3(0.0, 0.0, -0.1), DVec3::X, DVec3::Y),
        plane(dvec3(0.0, 0.0, 30.0), DVec3::X, DVec3::Y),
        plane(dvec3(0.0, 0.0, 0.06), DVec3::X, DVec3::X),
    ];
    let zones = vec![
        Zone { points: line.clone(), weight: 3.0 },
        Zone { points: behind.clone(), weight: 1.0 },
        Zone { points: vec![DVec3::NAN, dvec3(0.02, 0.03, 0.09)], weight: 1e3 },
        Zone { points: line.clone(), weight: f64::NAN },
    ];
    for (kind, aperture) in [&usual, &exact, &lossy, &one].into_iter().enumerate() {
        for (index, points) in [&line[..], &line[..1], &carpet, &off_plane, &mixed, &behind, &partly, &far]
            .into_iter()
            .enumerate()
        {
            let target = |i: usize| 10f64.powi(i as i32 % 3 - 1);
            let focus = |(i, &position): (usize, &DVec3)| Focus::new(position, target(i));
            let problem = Problem::new(aperture, points.iter().enumerate().map(focus).collect());
            // Half of the planes for each: every pair of the three meets.
            for (number, plane) in planes.iter().enumerate().skip((kind + index) % 2).step_by(2) {
                let what = format!("{} elements, points {index}, plane {number}", aperture.driven.len());
                let quiet = [0.5, 1.0, f64::NAN, 7.0][(index + number) % 4];
                let zones = if number % 2 == 0 { zones.clone() } else { Vec::new() };
                let surroundings = Surroundings { zones, ..Surroundings::of_plane(plane.clone(), quiet) };
                let mut search = Search::new(&problem, &surroundings);
                let mut last = search.advance().unwrap();
                let calls = if (index + number) % 3 == 0 { 6 } else { 1 };
                for _ in 0..calls {
                    assert_playable(&last.values, aperture.driven.len(), &what);
                    let Some(next) = search.advance() else { break };
                    last = next;
                }
                for before in [&last.values[..], &[], &vec![Complex64::ZERO; aperture.driven.len()]] {
                    let warm = shape::best_from(&problem, &surroundings, before);
                    assert_playable(&warm.values, aperture.driven.len(), &what);
                }
                let figures = figures(&problem, &surroundings, &last.values);
                for figure in [figures.evenness, figures.ripple_db, figures.side_lobe, figures.strength] {
                    assert!(figure.is_finite() && figure >= 0.0, "{what}: {figures:?}");
                }
                assert!(figures.side_lobe_position.is_finite(), "{what}: {figures:?}");
            }
        }
    }
}

/// One target above a small array.
fn small_scene(shape: Shape) -> Scene {
    let mut scene = Scene { targets: vec![Target::new(shape)], ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (4, 4);
    scene
}

#[test]
fn zones_drives_in_turn_depressions_and_strokes_each_make_a_shape() {
    let at = DVec3::Z * 0.1;
    let zone = |scene: &mut Scene| {
        let area = Area::Circle { radius: 0.01 };
        scene.quiet = vec![scene::Zone { area, at, normal: DVec3::Z, angle: 0.0, weight: 1.0 }];
    };
    type Change<'a> = &'a dyn Fn(&mut Scene);
    let changes: [(&str, Change<'_>, bool); 5] = [
        ("a point", &|_| (), false),
        ("a zone", &zone, true),
        ("drives in turn", &|scene| scene.solver.frames = Turns::Count(2), true),
        ("a depression", &|scene| scene.solver.target = Aim::Depression, true),
        ("a stroke", &|scene| scene.targets = vec![Target::new(Shape::Circle { at, radius: 0.01 })], true),
    ];
    for (name, change, is_shape) in changes {
        let mut scene = small_scene(Shape::Point { at });
        change(&mut scene);
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        assert_eq!(problem.surroundings.is_some(), is_shape, "{name}");
    }
}

#[test]
fn only_best_takes_a_drags_first_calls() {
    let mut scene = small_scene(Shape::Circle { at: DVec3::Z * 0.1, radius: 0.01 });
    for method in [Method::Best, Method::Naive, Method::Gs] {
        scene.solver.method = method;
        let drag = solver::solve_on(&scene, None).unwrap();
        assert_eq!(drag.figures.is_none(), method == Method::Best, "{method:?}");
        if method != Method::Best {
            assert_eq!(drag.drive, solver::solve(&scene).unwrap().drive, "{method:?}");
        }
    }
}

#[test]
fn a_drags_frame_goes_on_from_drives_of_the_same_kind_alone() {
    let scene = small_scene(Shape::Circle { at: DVec3::Z * 0.1, radius: 0.01 });
    let mut wider = scene.clone();
    wider.array.columns = 5;
    let mut in_turn = scene.clone();
    in_turn.solver.frames = Turns::Count(2);
    let first = solver::solve_on(&scene, None).unwrap();
    for other in [&wider, &in_turn] {
        let before = solver::solve_on(other, None).unwrap();
        let next = solver::solve_on(&scene, Some(&before)).unwrap();
        assert_eq!(next.drive, first.drive, "{:?}", other.array);
    }
    let next = solver::solve_on(&scene, Some(&first)).unwrap();
    assert_ne!(next.drive, first.drive, "nothing is gone on from");
}

#[test]
fn best_warns_of_strokes_whose_sound_goes_elsewhere() {
    let at = DVec3::new(-0.03, 0.0, 0.1);
    let circle = Shape::Circle { at, radius: 0.01 };
    let [stroke, points] = [false, true].map(|is_separate| {
        let mut target = Target::new(circle.clone());
        if is_separate {
            target.sampling = Sampling::Points(8);
        }
        let mut scene = small_scene(Shape::Point { at: at + DVec3::Y * 0.03 });
        scene.targets.push(target);
        scene
    });
    for (name, scene, method, is_astray, is_warned) in [
        ("a stroke", &stroke, Method::Best, true, true),
        ("separate points", &points, Method::Best, true, false),
        ("another method", &stroke, Method::Naive, true, false),
        ("a drive to the targets", &stroke, Method::Best, false, false),
    ] {
        let mut scene = scene.clone();
        scene.solver.method = method;
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let mut solution = solver::solve(&scene).unwrap();
        if is_astray {
            // To a place on the other side.
            let aside = Problem::new(&aperture, vec![Focus::new(DVec3::new(0.05, 0.02, 0.1), 1.0)]);
            let values: Vec<_> = aside.transfer.row(0).map(|h| Complex64::cis(-h.arg())).collect();
            solution.drive = Drive::uniform(values.len(), &aperture.driven, &values);
        }
        (solution.figures, solution.warnings) = (None, Vec::new());
        solution.judge(&scene, &problem);
        let side_lobe = solution.figures.unwrap().side_lobe;
        assert_eq!(side_lobe > 2.0, is_astray, "{name}: {side_lobe}");
        let warnings = if is_warned { vec![Warning::OutOfReach(side_lobe)] } else { Vec::new() };
        assert_eq!(solution.warnings, warnings, "{name}");
    }
}
