//! Areas: filled shapes, pictures and depressions, measured in f64 by direct formulae.

use glam::{DVec2, DVec3, dvec2, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::{Evaluator, Quantity, Request, Stages};
use sonoglyph::scene::{
    Aim, Grey, Method, Pixels, Sampling, Scene, Shape, Target, Turns, check, motion, outline,
};
use sonoglyph::solver::{self, Problem, Solution, Surroundings, frames};

use crate::shape::solver::{assert_playable, heard};

const AT: DVec3 = dvec3(0.0, 0.0, 0.1);
/// Samples along a side of the measured window.
const SIDE: usize = 48;

/// An H, 45 mm high, with strokes 8 mm wide and leg axes 29 mm apart.
fn is_in_h(at: DVec2) -> bool {
    let at = at.abs();
    let is_leg = at.y <= 0.0225 && (at.x - 0.0145).abs() <= 0.004;
    is_leg || (at.y <= 0.004 && at.x <= 0.0145)
}

fn path(corners: &[(f64, f64)]) -> Target {
    let vertices = corners.iter().map(|&(x, y)| AT + dvec3(x, y, 0.0) * 1e-3).collect();
    Target { sampling: Sampling::Fill, ..Target::new(Shape::Path { vertices, closed: true }) }
}

fn letter() -> Target {
    let quarter = [(18.5, 22.5), (10.5, 22.5), (10.5, 4.0)];
    let corner = |(x, y): (f64, f64), (across, up): (f64, f64)| (x * across, y * up);
    let around = |signs: (f64, f64)| quarter.map(|at| corner(at, signs));
    let back = |signs: (f64, f64)| quarter.map(|at| corner(at, signs)).into_iter().rev();
    let corners: Vec<_> = around((1.0, 1.0))
        .into_iter()
        .chain(back((-1.0, 1.0)))
        .chain(around((-1.0, -1.0)))
        .chain(back((1.0, -1.0)))
        .collect();
    path(&corners)
}

fn scene(targets: Vec<Target>) -> Scene {
    let scene = Scene { targets, ..Scene::default() };
    check::check(&scene).unwrap();
    scene
}

/// u of the driven elements, drive after drive.
fn played(scene: &Scene, solution: &Solution) -> Vec<Complex64> {
    let driven = Aperture::new(scene).driven;
    solution.drives().iter().flat_map(|drive| drive.excitation(&driven)).collect()
}

/// The mean |p|² of drives in turn over 10 x 10 cm, row by row.
fn intensities(scene: &Scene, u: &[Complex64]) -> Vec<(DVec2, f64)> {
    let aperture = Aperture::new(scene);
    let place = |i: usize| (dvec2((i % SIDE) as f64, (i / SIDE) as f64) + 0.5) / (10.0 * SIDE as f64) - 0.05;
    let drives: Vec<_> = u.chunks(aperture.driven.len()).collect();
    let mean = |at: DVec2| {
        let squares = drives.iter().map(|u| heard(&aperture, at.extend(0.1), u).powi(2));
        squares.sum::<f64>() / drives.len() as f64
    };
    (0..SIDE * SIDE).map(place).map(|at| (at, mean(at))).collect()
}

/// The relative squared error of |p|², and the mean inside over the mean outside.
fn judge(samples: &[(DVec2, f64)], is_in: impl Fn(DVec2) -> bool) -> (f64, f64) {
    let (mut along, mut square, mut inside, mut around, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for &(at, intensity) in samples {
        square += intensity * intensity;
        if is_in(at) {
            (along, inside, count) = (along + intensity, inside + intensity, count + 1.0);
        } else {
            around += intensity;
        }
    }
    (1.0 - along * along / (square * count), inside / count / (around / (samples.len() as f64 - count)))
}

#[test]
fn a_filled_letter_fits_its_drawing_better_than_foci() {
    let scene_of_area = scene(vec![letter()]);
    let solution = solver::solve(&scene_of_area).unwrap();
    let u = played(&scene_of_area, &solution);
    assert_playable(&u, 256 * solution.drives().len(), "a letter");
    let (error, contrast) = judge(&intensities(&scene_of_area, &u), is_in_h);
    assert!(error < 0.105 && contrast > 20.0, "{error}, {contrast}");
    let figures = solution.figures.unwrap().areas.unwrap();
    // The samples here are entirely inside or outside; the solver weights those on edges.
    assert!((0.4 * error..error).contains(&figures.error), "{figures:?}, measured {error}");
    let expected = 0.85 * contrast..1.03 * contrast;
    assert!(expected.contains(&figures.contrast), "{figures:?}, measured {contrast}");

    let steps = (-6..=6).flat_map(|y| (-5..=5).map(move |x| dvec2(f64::from(x), f64::from(y)) * 4e-3));
    let point = |at: DVec2| Target::new(Shape::Point { at: at.extend(0.1) });
    let of_foci = scene(steps.filter(|at| is_in_h(*at)).map(point).collect());
    let foci = played(&of_foci, &solver::solve(&of_foci).unwrap());
    let by_foci = judge(&intensities(&of_foci, &foci), is_in_h).0;
    assert!(error < 0.7 * by_foci, "{error}, and {by_foci} by foci");
}

/// Areas at rest alone are heard as a mean.
#[test]
fn only_areas_at_rest_have_several_drives_by_default() {
    let circle = Target::new(Shape::Circle { at: AT, radius: 0.015 });
    let disc = Target { sampling: Sampling::Fill, ..circle.clone() };
    let of = |target: &Target, change: &dyn Fn(&mut Scene)| {
        let mut scene = Scene { targets: vec![target.clone()], ..Scene::default() };
        (scene.array.rows, scene.array.columns) = (8, 8);
        change(&mut scene);
        solver::solve(&scene).unwrap().drives().len()
    };
    let as_it_is = |_: &mut Scene| ();
    assert_eq!(of(&disc, &as_it_is), 6);
    assert_eq!(of(&circle, &as_it_is), 1, "a stroke");
    assert_eq!(of(&focus(0.0, 1.0), &as_it_is), 1, "a point");
    assert_eq!(of(&disc, &|scene| scene.motion.path = motion::MotionPath::Circle), 1, "in motion");
    assert_eq!(of(&disc, &|scene| scene.solver.method = Method::Wgs), 1, "another method");
    for count in [1, 2, 6] {
        assert_eq!(of(&disc, &|scene| scene.solver.frames = Turns::Count(count)), count as usize);
    }
}

#[test]
fn one_drive_comes_first_and_all_fit_better() {
    let scene = scene(vec![letter()]);
    let mut so_far = Vec::new();
    let last = solver::solve_with(&scene, &mut |found| so_far.push(found)).unwrap();
    let aperture = Aperture::new(&scene);
    let problem = Problem::of_scene(&scene, &aperture, last.foci.clone());
    let judged = |mut found: Solution| {
        assert!(found.figures.is_none());
        found.judge(&scene, &problem);
        (found.drives().len(), found.figures.unwrap().areas.unwrap().error)
    };
    let so_far: Vec<_> = so_far.into_iter().map(judged).collect();
    let last = (last.drives().len(), last.figures.unwrap().areas.unwrap().error);
    assert_eq!(so_far[0].0, 1, "{so_far:?}");
    assert!(so_far.len() > 2 && so_far[1..].iter().all(|found| found.0 == last.0), "{so_far:?}");
    assert!(so_far[1].1 < so_far[0].1 && last.1 < so_far[1].1, "{so_far:?}, then {last:?}");
}

#[test]
fn turned_moved_and_tilted_areas_fit_equally_well() {
    let corners = [(-12.0, -12.0), (14.0, -6.0), (2.0, 15.0)];
    let plain = path(&corners);
    let error = |scene: &Scene| {
        let solution = solver::solve(scene).unwrap();
        let elements = Aperture::new(scene).driven.len();
        assert_playable(&played(scene, &solution), elements * solution.drives().len(), "an area");
        solution.figures.unwrap().areas.unwrap().error
    };
    let at_rest = error(&scene(vec![plain.clone()]));
    let turned = error(&scene(vec![Target { angle: 1.0, ..plain.clone() }]));
    // Tilted areas are evaluated by a table.
    let tilt = |at: DVec3| at + DVec3::Z * 0.03 * at.x;
    let mut tilted = plain.clone();
    if let Shape::Path { vertices, .. } = &mut tilted.shape {
        vertices.iter_mut().for_each(|at| *at = tilt(*at));
    }
    let tilted = error(&scene(vec![tilted]));
    for (name, other) in [("turned", turned), ("tilted", tilted)] {
        assert!((other - at_rest).abs() < 0.25 * at_rest, "{name}: {other}, {at_rest} at rest");
    }

    let mut moving = scene(vec![plain]);
    (moving.motion.path, moving.motion.size, moving.motion.frames) = (motion::MotionPath::Circle, 0.02, 5);
    let aperture = Aperture::new(&moving);
    for frame in frames::follow(&moving).unwrap().frames {
        let problem = Problem::of_scene(&moving, &aperture, frame.foci.clone());
        let by = frame.foci[0].position - outline::foci(&moving).unwrap()[0].position;
        assert!((by.length() - 0.01).abs() < 1e-9, "{by}");
        let Surroundings { areas, .. } = problem.surroundings.as_ref().unwrap();
        assert!((areas[0].centre - by - dvec3(0.001, 0.0015, 0.1)).length() < 1e-3, "{:?}", areas[0].centre);
        let mut found = solver::solve(&moving).unwrap();
        (found.drive, found.figures) = (frame.drive, None);
        assert!(found.others.is_empty());
        found.judge(&moving, &problem);
        let error = found.figures.unwrap().areas.unwrap().error;
        assert!(error < 1.8 * at_rest, "{error} in motion, {at_rest} at rest");
    }
}

#[test]
fn strokes_and_areas_of_one_drawing_are_equally_loud() {
    let disc = Shape::Circle { at: AT - DVec3::X * 0.025, radius: 0.009 };
    let line = Shape::Line { from: AT + dvec3(0.02, -0.015, 0.0), to: AT + dvec3(0.02, 0.015, 0.0) };
    let mean = |pressure: f64| {
        let disc = Target { sampling: Sampling::Fill, pressure, ..Target::new(disc.clone()) };
        let scene = scene(vec![disc, Target::new(line.clone())]);
        let solution = solver::solve(&scene).unwrap();
        let (areas, strokes): (Vec<_>, Vec<_>) =
            solution.foci.iter().zip(&solution.pressures).partition(|(focus, _)| focus.is_of_area());
        let mean = |of: &[(_, &Complex64)]| of.iter().map(|(_, p)| p.norm()).sum::<f64>() / of.len() as f64;
        let along: Vec<_> = strokes.iter().map(|(_, p)| p.norm()).collect();
        let least = along.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least > 0.75 * mean(&strokes), "even: {along:?}");
        mean(&areas) / mean(&strokes)
    };
    for pressure in [1.0, 2.0] {
        let ratio = mean(pressure) / pressure;
        assert!((0.8..1.25).contains(&ratio), "{pressure}: {ratio}");
    }
}

fn focus(x: f64, pressure: f64) -> Target {
    Target { pressure, ..Target::new(Shape::Point { at: AT + dvec3(x, 0.0, 0.0) }) }
}

/// The depth follows the square of the pressure.
#[test]
fn foci_of_a_depression_are_dents_of_their_targets() {
    let mut scene = scene(vec![focus(0.02, 1.0), focus(-0.02, 0.5)]);
    scene.solver.target = Aim::Depression;
    let drives = solver::solve(&scene).unwrap().drives();
    let request = Request::new(&scene, drives, Quantity::Depression, (100, 100));
    let depth = Stages::new(Evaluator::Cpu).map(&request).unwrap().values.clone();
    let pixel = scene.plane.size / 100.0;
    let place = |i: usize| (dvec2((i % 100) as f64, (i / 100) as f64) - 49.5) * pixel;
    let deepest = |is_in: &dyn Fn(DVec2) -> bool| {
        depth
            .iter()
            .enumerate()
            .filter(|(i, _)| is_in(place(*i)))
            .map(|(_, depth)| *depth)
            .fold(0.0, f32::max)
    };
    let near = |x: f64| deepest(&|at| at.distance(dvec2(x, 0.0)) < 0.003);
    let (first, second) = (near(0.02), near(-0.02));
    let rest = deepest(&|at| (at.abs() - dvec2(0.02, 0.0)).length() > 0.012);
    let part = second / first;
    assert!((0.15..0.4).contains(&part) && rest < 0.4 * first, "{first}, {second}, {rest} m");
}

#[test]
fn a_depression_fits_better_as_the_target_than_by_pressure() {
    let errors = |targets: Vec<Target>| {
        [Aim::Depression, Aim::Pressure].map(|aim| {
            let mut scene = scene(targets.clone());
            scene.solver.target = aim;
            let mut solution = solver::solve(&scene).unwrap();
            scene.solver.target = Aim::Depression;
            solution.figures = None;
            let aperture = Aperture::new(&scene);
            solution.judge(&scene, &Problem::of_scene(&scene, &aperture, solution.foci.clone()));
            solution.figures.unwrap().areas.unwrap().error
        })
    };
    let corners = [(-20.0, -16.0), (20.0, -16.0), (20.0, 0.0), (0.0, 18.0), (-20.0, 0.0)];
    // Foci are discs as wide as strokes, λ/2, which is below the array's resolution.
    for (targets, part, most) in [
        (vec![path(&corners)], 0.9, 0.12),
        (vec![focus(0.0, 1.0)], 0.96, 0.62),
        (vec![focus(0.02, 1.0), focus(-0.02, 0.5)], 0.96, 0.65),
    ] {
        let [wanted, other] = errors(targets);
        assert!(wanted < part * other && wanted < most, "{wanted}, and {other} with the pressure as target");
    }

    let mut stroke =
        Scene { targets: vec![Target::new(Shape::Circle { at: AT, radius: 0.02 })], ..Scene::default() };
    stroke.solver.target = Aim::Depression;
    let figures = solver::solve(&stroke).unwrap().figures.unwrap();
    assert!(figures.areas.unwrap().error < 0.45, "{figures:?}");
    stroke.plane.x_axis = dvec3(1.0, 0.0, 0.1);
    let error = check::check(&stroke).unwrap_err().to_string();
    assert!(error.starts_with("solver.target: a depression needs a scene plane"), "{error}");
    stroke.plane.x_axis = DVec3::X;
    stroke.plane.centre.z = 0.12;
    let error = solver::solve(&stroke).unwrap_err().to_string();
    assert!(error.contains("z = 0.12 m, and a target reaches z = 0.1 m"), "{error}");
}

fn picture(brightness: impl Fn(usize, usize) -> f32) -> Target {
    let brightness = (0..60 * 40).map(|i| brightness(i % 60, i / 60)).collect();
    let pixels = Pixels::new(Grey { file: None, width: 60, height: 40, brightness });
    Target::new(Shape::Picture { file: "a.png".to_owned(), at: AT, width: 0.06, pixels })
}

#[test]
fn a_drag_continues_from_the_previous_drive() {
    let at = |x: f64| {
        let mut target = letter();
        if let Shape::Path { vertices, .. } = &mut target.shape {
            vertices.iter_mut().for_each(|at| at.x += x);
        }
        scene(vec![target])
    };
    let mut before = solver::solve(&at(0.0)).unwrap();
    for step in 1..=5 {
        let scene = at(1e-3 * f64::from(step));
        let next = solver::solve_on(&scene, Some(&before)).unwrap();
        let by = 1e-3 * f64::from(step);
        let (error, _) =
            judge(&intensities(&scene, &played(&scene, &next)), |at| is_in_h(at - dvec2(by, 0.0)));
        assert!(error < 0.15, "step {step}: {error}");
        before = next;
    }
    let cold = solver::solve_on(&at(0.0), None).unwrap();
    let (error, _) = judge(&intensities(&at(0.0), &played(&at(0.0), &cold)), is_in_h);
    assert!(error < 0.16, "at first: {error}");
}

#[test]
fn any_filled_target_has_a_playable_drive() {
    let disc =
        |radius: f64| Target { sampling: Sampling::Fill, ..Target::new(Shape::Circle { at: AT, radius }) };
    let point = Target::new(Shape::Point { at: AT + DVec3::Y * 0.02 });
    let upright = Target { normal: DVec3::X, ..disc(0.02) };
    let drawings = [
        vec![disc(1e-9)],
        vec![disc(1e-3)],
        vec![disc(0.1)],
        vec![disc(50.0)],
        vec![picture(|_, _| 1.0)],
        vec![picture(|x, y| if (x, y) == (30, 20) { 1e-3 } else { 0.0 })],
        vec![
            picture(|x, _| x as f32 / 59.0),
            point.clone(),
            Target::new(Shape::Circle { at: AT, radius: 0.01 }),
        ],
        vec![upright.clone()],
        vec![upright, disc(0.01), point],
        vec![disc(0.01), disc(0.01), Target { pressure: 1e6, ..disc(0.005) }],
        vec![Target {
            sampling: Sampling::Stroke(1e-6),
            ..Target::new(Shape::Circle { at: AT, radius: 0.02 })
        }],
    ];
    for (number, targets) in drawings.into_iter().enumerate() {
        let aims = [(0.5, Aim::Pressure), (0.0, Aim::Pressure), (1.0, Aim::Depression)];
        // A disc of 50 m has as many samples as there may be, and takes seconds each time, longest for a depression.
        let is_huge = matches!(targets[0].shape, Shape::Circle { radius, .. } if radius > 1.0);
        for (quiet, aim) in aims.into_iter().take(if is_huge { 1 } else { 3 }) {
            let mut scene = scene(targets.clone());
            (scene.array.rows, scene.array.columns, scene.array.off) = (6, 9, vec![0, 7]);
            (scene.solver.quiet, scene.solver.target) = (quiet, aim);
            let what = format!("drawing {number}, quiet {quiet}, {aim:?}");
            let solution = match solver::solve(&scene) {
                Ok(solution) => solution,
                Err(error) => {
                    assert!(
                        aim == Aim::Depression && error.to_string().contains("a target reaches"),
                        "{what}: {error}"
                    );
                    continue;
                }
            };
            assert_playable(&played(&scene, &solution), 52 * solution.drives().len(), &what);
            let figures = solution.figures.unwrap();
            for figure in [figures.evenness, figures.side_lobe, figures.strength] {
                assert!(figure.is_finite() && figure >= 0.0, "{what}: {figures:?}");
            }
            let areas = figures.areas.unwrap();
            assert!((0.0..=1.0).contains(&areas.error) && areas.contrast.is_finite(), "{what}: {areas:?}");
            for method in [Method::Naive, Method::Wgs] {
                scene.solver.method = method;
                assert_playable(&played(&scene, &solver::solve(&scene).unwrap()), 52, &what);
            }
        }
    }
}
