//! Tests of a search: its common phase, and its end where nothing is heard.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::scene::{Aim, Focus, Sampling, Scene, Shape, Target, Turns, outline};
use crate::solver::descent::Function;
use crate::solver::problem::Problem;
use crate::solver::shape::{Search, Stage, Surroundings};

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

#[test]
fn common_phase_does_least_harm_by_rounding() {
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

fn with_search(scene: &Scene, work: impl FnOnce(&mut Search<'_>)) {
    let aperture = Aperture::new(scene);
    let problem = Problem::of_scene(scene, &aperture, outline::foci(scene).unwrap());
    work(&mut Search::new(&problem, &Surroundings::new(scene, &problem.foci)));
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
