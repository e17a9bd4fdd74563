//! Free amplitudes: lower side lobes and errors for strength, never above full drive.

use glam::{DVec3, dvec3};
use sonoglyph::scene::{Amplitudes, Area, Sampling, Scene, Shape, Solver, Target, Turns, Zone};
use sonoglyph::solver::{self, Figures, Solution};

fn scene(shape: Shape, fill: bool) -> Scene {
    let mut target = Target::new(shape);
    if fill {
        target.sampling = Sampling::Fill;
    }
    let solver = Solver { frames: Turns::Count(1), ..Solver::default() };
    Scene { targets: vec![target], solver, ..Scene::default() }
}

fn solved(scene: &Scene, amplitudes: Amplitudes, quiet: f64) -> (Solution, Figures) {
    let mut scene = scene.clone();
    (scene.solver.amplitudes, scene.solver.quiet) = (amplitudes, quiet);
    let solution = solver::solve(&scene).unwrap();
    let most = solution.drive.amplitudes.iter().copied().fold(0.0, f64::max);
    assert!((most - 1.0).abs() < 1e-12, "{most} of full drive");
    let figures = solution.figures.unwrap();
    (solution, figures)
}

const AT: DVec3 = DVec3::new(0.0, 0.0, 0.1);

#[test]
fn free_amplitudes_buy_low_side_lobes_with_strength() {
    for shape in [
        Shape::Circle { at: AT, radius: 0.02 },
        Shape::Line { from: dvec3(-0.02, 0.0, 0.1), to: dvec3(0.02, 0.0, 0.1) },
    ] {
        let scene = scene(shape, false);
        let (_, uniform) = solved(&scene, Amplitudes::Uniform, 1.0);
        let (_, free) = solved(&scene, Amplitudes::Free, 1.0);
        assert!(free.side_lobe < 0.87 * uniform.side_lobe, "{free:?}, {uniform:?}");
        assert!(free.strength > 0.48 && free.evenness > 0.95 * uniform.evenness, "{free:?}, {uniform:?}");
        // At full strength they win nothing, and are not sought.
        let (strongest, _) = solved(&scene, Amplitudes::Free, 0.0);
        assert!(strongest.drive.amplitudes.iter().all(|a| *a == 1.0));
    }
}

#[test]
fn free_amplitudes_lower_the_error_of_areas() {
    let scene = scene(Shape::Rectangle { at: AT, width: 0.04, height: 0.04 }, true);
    for quiet in [0.25, 1.0] {
        let error = |amplitudes| {
            let (_, figures) = solved(&scene, amplitudes, quiet);
            (figures.areas.unwrap().error, figures.side_lobe, figures.strength)
        };
        let (uniform, free) = (error(Amplitudes::Uniform), error(Amplitudes::Free));
        assert!(free.0 < 0.85 * uniform.0 && free.1 < 0.75 * uniform.1, "{quiet}: {free:?}, {uniform:?}");
        assert!(free.2 > 0.4 * uniform.2, "{quiet}: {free:?}, {uniform:?}");
    }
}

#[test]
fn a_drag_keeps_free_amplitudes() {
    let at = |x: f64| {
        let mut scene = scene(Shape::Circle { at: AT + x * DVec3::X, radius: 0.02 }, false);
        (scene.solver.amplitudes, scene.solver.quiet) = (Amplitudes::Free, 1.0);
        let area = Area::Circle { radius: 0.008 };
        scene.quiet =
            vec![Zone { area, at: dvec3(0.05, 0.03, 0.1), normal: DVec3::Z, angle: 0.0, weight: 1.0 }];
        scene
    };
    let mut before = solver::solve(&at(0.0)).unwrap();
    for frame in 1..=4 {
        before = solver::solve_on(&at(1e-3 * f64::from(frame)), Some(&before)).unwrap();
    }
    let rest = solver::solve(&at(4e-3)).unwrap();
    let least = |solution: &Solution| solution.drive.amplitudes.iter().copied().fold(1.0, f64::min);
    assert!(least(&before) < 0.5 && least(&rest) < 0.5, "{}, {}", least(&before), least(&rest));
    let strength = before.quality.mean_pressure / rest.quality.mean_pressure;
    assert!((0.8..1.25).contains(&strength), "{strength}");
}
