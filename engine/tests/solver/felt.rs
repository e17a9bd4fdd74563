//! Strokes that are felt evenly, judged by the motion of the skin along them.

use glam::{DVec2, DVec3};
use sonoglyph_engine::drive::Drive;
use sonoglyph_engine::field::{Evaluator, Quantity, Request, Stages};
use sonoglyph_engine::scene::{
    Aim, Envelope, Modulation, Motion, MotionPath, Scene, Shape, Target, Tempo, motion, outline,
};
use sonoglyph_engine::solver::{self, frames};

const AT: DVec3 = DVec3::new(0.0, 0.0, 0.1);

/// Level (dB) at places of the default plane.
fn levels(scene: &Scene, drives: Vec<Drive>, places: &[DVec3]) -> Vec<f64> {
    let request = Request::new(scene, drives, Quantity::Felt, (64, 64));
    let mut stages = Stages::new(Evaluator::Cpu);
    let places: Vec<_> = places.iter().map(|place| DVec2::new(place.x, place.y)).collect();
    let motion = stages.skin(&request).unwrap().at(&places);
    let level = |lines: &Vec<sonoglyph_engine::scene::SpectralLine>| {
        let felt = lines
            .iter()
            .filter(|line| line.frequency > 0.0)
            .map(|line| (line.amplitude / request.skin.threshold_at(line.frequency)).powi(2));
        10.0 * felt.sum::<f64>().log10()
    };
    motion.iter().map(level).collect()
}

/// Mean and standard deviation.
fn figures(values: &[f64]) -> [f64; 2] {
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        sum / count
    };
    let middle = mean(&mut values.iter().copied());
    [middle, mean(&mut values.iter().map(|value| (value - middle).powi(2))).sqrt()]
}

fn text(text: &str, height: f64) -> Target {
    Target::new(Shape::Text { text: text.to_owned(), at: AT, height })
}

/// Foci along the outline of a target.
fn running(target: Target, foci: u32) -> Scene {
    let motion = Motion { path: MotionPath::Outline, foci, tempo: Tempo::Speed(6.0), ..Motion::default() };
    Scene { targets: vec![target], motion, ..Scene::default() }
}

fn still(target: Target) -> Scene {
    let modulation = Modulation { shape: Envelope::Sine, ..Modulation::default() };
    Scene { targets: vec![target], modulation, ..Scene::default() }
}

/// Mean and standard deviation of the level along the strokes, where the solver has foci.
fn along(scene: &Scene) -> [f64; 2] {
    let (drives, places): (Vec<_>, Vec<_>) = if motion::moves(scene) {
        let frames = frames::follow(scene).unwrap().frames;
        let places =
            motion::frames(scene).unwrap().into_iter().flatten().map(|focus| focus.position).collect();
        (frames.into_iter().map(|frame| frame.drive).collect(), places)
    } else {
        let places = outline::foci(scene).unwrap().iter().map(|focus| focus.position).collect();
        (solver::solve(scene).unwrap().drives(), places)
    };
    figures(&levels(scene, drives, &places))
}

fn evenly(mut scene: Scene) -> Scene {
    scene.solver.target = Aim::Felt;
    scene
}

#[test]
fn strokes_in_motion_are_felt_evenly() {
    let line = Target::new(Shape::Line { from: AT - DVec3::X * 0.02, to: AT + DVec3::X * 0.02 });
    for scene in [running(text("H", 0.04), 1), running(line, 1)] {
        let [_, before] = along(&scene);
        let [_, after] = along(&evenly(scene));
        assert!(before > 1.2 && after < 1.0, "{before} dB, then {after} dB");
    }
}

#[test]
fn half_the_pressure_is_felt_12_db_less() {
    let at = [-0.03, 0.03].map(|x| AT + DVec3::X * x);
    let [loud, faint] = at.map(|at| Target::new(Shape::Point { at }));
    let mut scene = evenly(still(loud));
    scene.targets.push(Target { pressure: 0.5, ..faint });
    let levels = levels(&scene, solver::solve(&scene).unwrap().drives(), &at);
    assert!((levels[0] - levels[1] - 12.04).abs() < 1.0, "{levels:?}");
}
