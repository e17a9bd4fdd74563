//! Tests of a search's schedule: what every stage weighs and hears, that values are current, and the end.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::scene::{Aim, Area, Focus, Sampling, Scene, Shape, Target, Turns, Zone, outline};
use crate::solver::Problem;
use crate::solver::descent::{Descent, Function};
use crate::solver::shape::objective::Loudness;
use crate::solver::shape::picture::Picture;
use crate::solver::shape::real::Waves;
use crate::solver::shape::{
    AREA, COARSE, FINE, LAST, OTHER_STEPS, Search, Stage, Surroundings, TRIAL, TRIAL_REST, descend, strokes,
    value,
};
use crate::solver::starts::scatter;

fn scene(fill: bool, quiet: f64, aim: Aim, tilt: f64) -> Scene {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (9, 8);
    let mut circle = Target::new(Shape::Circle { at: DVec3::new(0.0, 0.0, 0.1), radius: 0.015 });
    if fill {
        circle.sampling = Sampling::Fill;
    }
    scene.targets = vec![circle];
    (scene.solver.quiet, scene.solver.target, scene.plane.x_axis.z) = (quiet, aim, tilt);
    scene.solver.frames = Turns::Count(1);
    scene
}

/// Whether a number is another, up to rounding in f32.
fn is_close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-4 * (1.0 + a.abs())
}

/// After a call of this stage.
fn assert_consistent(search: &mut Search<'_>, stage: Stage, what: &str) {
    let what = format!("{what}, {stage:?}");
    for way in search.ways.iter().flatten() {
        // Rows of tables are chosen every few steps.
        if search.objective.quiet.iter().all(|quiet| !quiet.is_table()) {
            let value = search.objective.evaluate(&way.x, &mut vec![0.0; way.x.len()]);
            assert!(is_close(way.value, value), "{what}: {} is now {value}", way.value);
        }
    }
    let is_first = stage == Stage::First;
    let is_quiet = search.surroundings.quiet > 0.0;
    let has_areas = search.objective.picture.is_some();
    // Areas in the quiet plane share its samples.
    let is_shared = search.objective.picture.as_ref().is_some_and(Picture::is_quiet);
    assert_eq!(search.objective.quiet.is_empty(), is_shared || is_first || !is_quiet, "{what}");
    let (call, most, is_sharp) = match stage {
        Stage::Coarse(call) => (call, COARSE.1, false),
        Stage::Leader(call) | Stage::Rival(call) => (call, FINE.1, true),
        Stage::Last(call) => (call, LAST.1, true),
        Stage::Area(_, call) => (call, AREA.1, false),
        Stage::First | Stage::Other(_) => (0, 1, false),
        Stage::Moved | Stage::Going | Stage::Done => (0, 1, is_quiet && !has_areas),
    };
    assert!(call < most, "{what}");
    let weights = search.objective.weights;
    assert_eq!(matches!(weights.loudness, Loudness::Twelve), is_sharp, "{what}");
    assert_eq!(weights.quiet > 0.0, is_quiet && !is_first, "{what}");
    // Strokes keep a part of their strength.
    assert_eq!(weights.floor > 0.0, is_quiet && !is_first && !has_areas, "{what}");
}

/// The stages of a search until its end.
fn stages(search: &mut Search<'_>, what: &str) -> Vec<Stage> {
    let mut stages = Vec::new();
    loop {
        let (stage, before) = (search.stage(), search.steps);
        let found = search.advance();
        // The best of the other starts goes on for longer than a trial.
        if matches!(stage, Stage::Other(_)) && search.stage() == Stage::Leader(0) {
            let done = search.steps - before;
            assert!(done > OTHER_STEPS + TRIAL && done <= OTHER_STEPS + TRIAL + TRIAL_REST, "{what}: {done}");
        }
        if stage == Stage::Done {
            assert!(found.is_none(), "{what}");
            return stages;
        }
        assert_consistent(search, stage, what);
        stages.push(stage);
        assert!(stages.len() < 1000, "{what} does not end");
    }
}

#[test]
fn every_stage_weighs_and_hears_what_it_is_for() {
    for fill in [false, true] {
        for quiet in [0.0, 0.5] {
            for (aim, tilt) in [(Aim::Pressure, 0.0), (Aim::Pressure, 0.01), (Aim::Depression, 0.0)] {
                let scene = scene(fill, quiet, aim, tilt);
                let what = format!("fill {fill}, quiet {quiet}, {aim:?}, tilt {tilt}");
                let aperture = Aperture::new(&scene);
                let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
                let surroundings = Surroundings::new(&scene, &problem.foci);
                let mut search = Search::new(&problem, &surroundings);
                let stages = stages(&mut search, &what);
                let has_areas = fill || aim == Aim::Depression;
                assert_eq!(search.objective.has_strokes(), !has_areas, "{what}");
                let is_through = |wanted: Stage| stages.contains(&wanted);
                assert_eq!(is_through(Stage::Area(1, 0)), has_areas, "{what}: {stages:?}");
                assert_eq!(is_through(Stage::Last(0)), quiet > 0.0 && !has_areas, "{what}: {stages:?}");
                let found = search.give().values;
                let mut moved = Search::from(&problem, &surroundings, &found);
                let again = self::stages(&mut moved, &format!("{what}, moved"));
                assert_eq!(again[0], Stage::Moved, "{what}");
                assert!(again[1..].iter().all(|&stage| stage == Stage::Going), "{what}: {again:?}");
            }
        }
    }
}

#[test]
fn a_descent_that_still_gains_gets_all_calls_of_its_stage() {
    type Call = fn(u32) -> Stage;
    let of_strokes: &[(Call, u32, Stage)] = &[
        (Stage::Coarse, COARSE.1, Stage::Other(0)),
        (Stage::Leader, FINE.1, Stage::Rival(0)),
        (Stage::Rival, FINE.1, Stage::Last(0)),
        (Stage::Last, LAST.1, Stage::Done),
        (|_| Stage::Going, 1, Stage::Going),
    ];
    let of_areas: &[(Call, u32, Stage)] =
        &[(|call| Stage::Area(1, call), AREA.1, Stage::Done), (|_| Stage::Going, 1, Stage::Going)];
    for (fill, kinds) in [(false, of_strokes), (true, of_areas)] {
        let scene = scene(fill, 0.5, Aim::Pressure, 0.0);
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let mut search = Search::new(&problem, &Surroundings::new(&scene, &problem.foci));
        search.advance();
        for &(stage, calls, after) in kinds {
            for call in 0..calls {
                // Descents that have just begun.
                for way in &mut search.ways {
                    let phases = (0..aperture.driven.len()).map(|n| TAU * scatter(n)).collect();
                    *way = Some(Descent::new(phases, &mut search.objective));
                }
                search.stage = stage(call);
                search.advance();
                let next = if call + 1 < calls { stage(call + 1) } else { after };
                assert_eq!(search.stage, next, "after {:?}", stage(call));
            }
        }
    }
}

#[test]
fn of_all_common_phases_that_of_the_least_harm_by_rounding_is_taken() {
    let scene = scene(false, 0.5, Aim::Pressure, 0.0);
    let aperture = Aperture::new(&scene);
    let focus = |x: f64| Focus::new(DVec3::new(x, 0.0, 0.1), 1.0);
    let problem = Problem::new(&aperture, vec![focus(0.0), focus(0.02), focus(-0.03)]);
    let mut search = Search::new(&problem, &Surroundings::of_plane(scene.plane.clone(), 0.5));
    let found = std::iter::from_fn(|| search.advance()).last().unwrap();
    let turned = search.turned_for_rounding(found.clone());
    let step = TAU / 16.0;
    let mut harm = |turn: f64| {
        let rounded: Vec<_> = found.values.iter().map(|u| ((u.arg() + turn) / step).round() * step).collect();
        search.objective.evaluate(&rounded, &mut vec![0.0; rounded.len()])
    };
    let by = (turned.values[0] * found.values[0].conj()).arg();
    let taken = harm(by);
    for turn in 0..32 {
        let other = harm(step * f64::from(turn) / 32.0);
        assert!(taken <= other + 1e-6, "{turn}: {other}, and {taken}");
    }
}

/// Descents that have just begun.
fn begun(search: &mut Search<'_>) -> Descent {
    let elements = search.problem.aperture.driven.len();
    let phases = (0..elements).map(|n| TAU * scatter(n)).collect();
    Descent::new(phases, &mut search.objective)
}

fn with_search(scene: &Scene, work: impl FnOnce(&mut Search<'_>)) {
    let aperture = Aperture::new(scene);
    let problem = Problem::of_scene(scene, &aperture, outline::foci(scene).unwrap());
    work(&mut Search::new(&problem, &Surroundings::new(scene, &problem.foci)));
}

#[test]
fn foci_beside_areas_are_strokes_unless_a_depression_is_the_target() {
    for (fill, beside, aim, has_strokes) in [
        (false, false, Aim::Pressure, true),
        (true, false, Aim::Pressure, false),
        (true, true, Aim::Pressure, true),
        (false, true, Aim::Depression, false),
        (true, true, Aim::Depression, false),
    ] {
        let mut scene = scene(fill, 0.5, aim, 0.0);
        if beside {
            scene.targets.push(Target::new(Shape::Point { at: DVec3::new(-0.03, 0.0, 0.1) }));
        }
        with_search(&scene, |search| {
            let what = format!("fill {fill}, beside {beside}, {aim:?}");
            assert_eq!(search.objective.has_strokes(), has_strokes, "{what}");
            assert_eq!(search.objective.picture.is_some(), fill || aim == Aim::Depression, "{what}");
        });
    }
}

#[test]
fn where_targets_hear_nothing_a_search_is_over() {
    let mut scene = scene(false, 0.5, Aim::Pressure, 0.0);
    // 100 000 dB on the way: no number of f64 is that small.
    scene.medium.absorption = Some(1e6);
    with_search(&scene, |search| {
        assert_eq!(search.stage(), Stage::Done);
        let silent = search.advance().unwrap();
        assert!(silent.values.iter().all(|u| (u - 1.0).norm() < 1e-12), "{:?}", silent.values);
        assert!(search.advance().is_none());
    });
}

#[test]
fn a_plane_without_sound_gives_no_second_drive() {
    let scene = scene(false, 0.5, Aim::Pressure, 0.0);
    with_search(&scene, |search| {
        search.surroundings.plane.centre = DVec3::Z * -0.1;
        assert!(search.advance().is_some());
        assert_eq!(search.stage(), Stage::Coarse(0));
        assert!(search.advance().is_none());
        assert_eq!(search.stage(), Stage::Done);
    });
}

#[test]
fn side_lobes_count_from_the_second_call_on() {
    for fill in [false, true] {
        with_search(&scene(fill, 0.5, Aim::Pressure, 0.0), |search| {
            for call in 0..3 {
                let stage = search.stage();
                let is_of_area = matches!(stage, Stage::Area(..));
                assert_eq!(is_of_area, fill && call > 0, "call {call}: {stage:?}");
                assert!(search.advance().is_some());
                assert_consistent(search, stage, &format!("fill {fill}"));
            }
        });
    }
}

#[test]
fn other_drives_join_after_the_first_call_of_one() {
    let mut scene = scene(true, 0.5, Aim::Pressure, 0.0);
    scene.solver.frames = Turns::Count(3);
    with_search(&scene, |search| {
        let elements = search.problem.aperture.driven.len();
        let mut before = 0.0;
        for (drives, is_under_way) in [(1, false), (1, true), (3, true)] {
            let found = search.advance().unwrap().values;
            assert_eq!((found.len() / elements, search.is_under_way()), (drives, is_under_way));
            assert!(value(&search.ways[0]) < before || before == 0.0 || drives == 1);
            before = value(&search.ways[0]);
        }
    });
}

#[test]
fn another_start_gets_a_trial() {
    with_search(&scene(false, 0.5, Aim::Pressure, 0.0), |search| {
        assert!(search.advance().is_some() && search.advance().is_some());
        for start in 0..2 {
            search.stage = Stage::Other(start);
            let before = search.steps;
            search.advance();
            let done = search.steps - before;
            assert!(done > OTHER_STEPS && done <= OTHER_STEPS + TRIAL, "{start}: {done} steps");
            assert_eq!(search.stage(), Stage::Other(start + 1));
        }
    });
}

#[test]
fn after_the_rivals_last_call_the_better_of_both_leads() {
    with_search(&scene(false, 0.5, Aim::Pressure, 0.0), |search| {
        assert!(search.advance().is_some() && search.advance().is_some());
        let (good, poor) = (search.ways[0].take(), begun(search));
        for (leader, good_one) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            search.ways[good_one].clone_from(&good);
            search.ways[1 - good_one] = Some(poor.clone());
            (search.leader, search.stage) = (leader, Stage::Rival(FINE.1 - 1));
            search.advance();
            assert_eq!(search.stage(), Stage::Last(0));
            let (leads, other) = (value(&search.ways[search.leader]), value(&search.ways[1 - search.leader]));
            assert!(leads < other, "of {leader} and {good_one}: {leads}, not {other}");
        }
    });
}

#[test]
fn moved_strokes_are_heard_on_finer_samples_and_moved_areas_on_their_own() {
    for fill in [false, true] {
        let scene = scene(fill, 0.5, Aim::Pressure, 0.0);
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let before: Vec<_> = (0..aperture.driven.len()).map(|n| Complex64::cis(TAU * scatter(n))).collect();
        let mut search = Search::from(&problem, &Surroundings::new(&scene, &problem.foci), &before);
        assert!(search.advance().is_some());
        assert_consistent(&mut search, Stage::Moved, &format!("fill {fill}"));
        let way = search.ways[0].clone().unwrap();
        let [coarse, fine] = [false, true].map(|finer| {
            search.hear(finer);
            search.objective.evaluate(&way.x, &mut vec![0.0; way.x.len()])
        });
        assert!(is_close(way.value, fine), "fill {fill}: {} is {fine}", way.value);
        // Areas have the samples that they share with the quiet plane.
        assert_eq!(is_close(way.value, coarse), fill, "{} and {coarse}", way.value);
    }
}

#[test]
fn strokes_give_up_a_fifth_of_their_strength_at_most() {
    with_search(&scene(false, 0.5, Aim::Pressure, 0.0), |search| {
        // M, a square.
        search.strongest = 7.0;
        for (quiet, expected) in [(0.1, 0.98), (0.5, 0.9), (1.0, 0.8), (3.0, 0.8)] {
            search.surroundings.quiet = quiet;
            let kept = (search.weights(Loudness::Eight).floor / 7.0).sqrt();
            assert!((kept - expected).abs() < 1e-12, "{quiet}: {kept}, not {expected}");
        }
    });
}

#[test]
fn a_common_phase_that_changes_is_taken_back() {
    with_search(&scene(false, 0.0, Aim::Pressure, 0.0), |search| {
        let found = search.advance().unwrap().values;
        for turn in [0.3, -1.2, 2.0] {
            search.ways[0].iter_mut().for_each(|way| way.x.iter_mut().for_each(|phase| *phase += turn));
            let again = search.give().values;
            let off = found.iter().zip(&again).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{turn} rad: off by {off}");
        }
    });
}

#[test]
fn a_descent_takes_all_its_steps_as_long_as_they_gain() {
    with_search(&scene(false, 0.0, Aim::Pressure, 0.0), |search| {
        for steps in [1, 5, 8, 10, 25] {
            let mut way = begun(search);
            assert_eq!(descend(&mut way, &mut search.objective, steps), (steps, true), "{steps} steps");
        }
        let mut way = begun(search);
        let calls = (0..200).take_while(|_| descend(&mut way, &mut search.objective, 25).1).count();
        assert!(calls < 200, "no end");
        // What ended gains hardly any more.
        let end = way.value;
        descend(&mut way, &mut search.objective, 25);
        assert!(end - way.value < 1e-2, "{end}, then {}", way.value);
    });
}

#[test]
fn side_lobes_of_areas_weigh_by_the_square_of_quiet() {
    with_search(&scene(true, 0.5, Aim::Pressure, 0.0), |search| {
        for (quiet, expected) in [(0.0, 0.0), (0.25, 0.0625), (0.5, 0.25), (1.0, 1.0), (3.0, 1.0)] {
            search.surroundings.quiet = quiet;
            let part = search.weights(Loudness::Eight).quiet / 2.2;
            assert!((part - expected).abs() < 1e-12, "{quiet}: {part}, not {expected}");
        }
    });
}

#[test]
fn a_plane_gets_finer_samples_beside_zones_too() {
    let mut scene = scene(false, 0.5, Aim::Pressure, 0.0);
    let area = Area::Circle { radius: 5e-3 };
    let at = DVec3::new(0.05, 0.0, 0.15);
    scene.quiet = vec![Zone { area, at, normal: DVec3::Z, angle: 0.0, weight: 1.0 }];
    with_search(&scene, |search| {
        search.objective.weights = search.weights(Loudness::Eight);
        let phases = begun(search).x;
        let [coarse, fine] = [false, true].map(|finer| {
            search.hear(finer);
            let tables = search.objective.quiet.iter().filter(|quiet| quiet.is_table()).count();
            assert_eq!((search.objective.quiet.len(), tables), (2, 1));
            search.objective.evaluate(&phases, &mut vec![0.0; phases.len()])
        });
        assert!(!is_close(coarse, fine), "{coarse}, {fine}");
    });
}

#[test]
fn a_descent_goes_on_from_value_and_slopes_on_the_rows_that_it_chooses() {
    with_search(&scene(false, 0.5, Aim::Pressure, 0.01), |search| {
        search.hear(false);
        search.objective.weights = search.weights(Loudness::Eight);
        let elements = search.problem.aperture.driven.len();
        let other: Vec<_> = (0..elements).map(|n| TAU * scatter(3 * n)).collect();
        assert!(search.objective.refresh(&other));
        // On rows that are loud for other phases.
        let mut way = begun(search);
        search.objective.refresh(&way.x);
        let mut expected = begun(search);
        assert!(way.value < expected.value - 0.01, "{}, {}", way.value, expected.value);
        assert!(expected.step(&mut search.objective));
        search.objective.refresh(&other);
        assert_eq!(descend(&mut way, &mut search.objective, 1), (1, true));
        assert_eq!(way.x, expected.x);
    });
}

#[test]
fn at_the_focus_that_most_sound_reaches_for_its_target_all_elements_add_up_to_1() {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (4, 4);
    let aperture = Aperture::new(&scene);
    for unit in [1.0, 200.0] {
        let focus = |(x, target): (f64, f64)| Focus::new(DVec3::new(x, 0.01, 0.1), unit * target);
        let foci: Vec<_> = [(-0.03, 2.0), (0.0, 8.0), (0.05, 3.0)].into_iter().map(focus).collect();
        let problem = Problem::new(&aperture, foci);
        let (table, _) = strokes(&problem, |_| true);
        assert_eq!(table.points(), 3);
        let loudest = |m: usize| {
            let mut drive = table.excitation();
            for (n, h) in problem.transfer.row(m).enumerate() {
                let u = Complex64::cis(-h.arg());
                (drive.re[n], drive.im[n]) = (u.re as f32, u.im as f32);
            }
            let mut p = Waves::zeros(8);
            table.forward(&drive, &mut p);
            p.square(m).sqrt()
        };
        let most = (0..3).map(loudest).fold(0.0, f64::max);
        assert!((most - 1.0).abs() < 1e-5, "{unit}: {most}");
    }
}

#[test]
fn the_descent_of_areas_begins_anew_when_side_lobes_count() {
    let mut scene = scene(true, 1.0, Aim::Pressure, 0.0);
    (scene.array.rows, scene.array.columns) = (5, 4);
    with_search(&scene, |search| {
        assert!(search.advance().is_some());
        let before = search.ways[0].as_ref().unwrap().x.clone();
        assert_eq!(search.stage(), Stage::Area(1, 0));
        assert!(search.advance().is_some());
        let mut anew = Descent::new(before, &mut search.objective);
        descend(&mut anew, &mut search.objective, AREA.0);
        let way = search.ways[0].as_ref().unwrap();
        assert!(is_close(way.value, anew.value), "{}, not {}", way.value, anew.value);
        assert_eq!(way.x, anew.x);
    });
}
