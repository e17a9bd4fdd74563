//! Tests of a search's schedule: what every stage weighs and hears, that values are current, and the end.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::scene::{Aim, Focus, Sampling, Scene, Shape, Target, outline};
use crate::solver::Problem;
use crate::solver::descent::{Descent, Function};
use crate::solver::shape::objective::Loudness;
use crate::solver::shape::{
    AREA, COARSE, FINE, LAST, OTHER_STEPS, Search, Stage, Surroundings, TRIAL, TRIAL_REST,
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
    assert_eq!(search.objective.quiet.is_empty(), is_first || !is_quiet, "{what}");
    let has_areas = search.objective.picture.is_some();
    let (call, most, is_sharp) = match stage {
        Stage::Coarse(call) => (call, COARSE.1, false),
        Stage::Leader(call) | Stage::Rival(call) => (call, FINE.1, true),
        Stage::Last(call) => (call, LAST.1, true),
        Stage::Area(call) => (call, AREA.1, false),
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
                assert_eq!(is_through(Stage::Area(0)), has_areas, "{what}: {stages:?}");
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
        &[(Stage::Area, AREA.1, Stage::Done), (|_| Stage::Going, 1, Stage::Going)];
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
