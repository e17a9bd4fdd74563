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
    for scene in [running(text("H", 0.04), 1), running(line, 1), still(text("H", 0.04))] {
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

#[test]
fn twenty() {
    let line = |length: f64| {
        Target::new(Shape::Line { from: AT - DVec3::X * length / 2.0, to: AT + DVec3::X * length / 2.0 })
    };
    let circle = |radius| Target::new(Shape::Circle { at: AT, radius });
    let square = |side| Target::new(Shape::Rectangle { at: AT, width: side, height: side });
    let mut all: Vec<(String, Scene)> = Vec::new();
    for (name, target) in [
        ("H 40", text("H", 0.04)),
        ("S 40", text("S", 0.04)),
        ("A 30", text("A", 0.03)),
        ("8 40", text("8", 0.04)),
        ("HIT 30", text("HIT", 0.03)),
        ("E 50", text("E", 0.05)),
        ("circle 12", circle(0.012)),
        ("circle 20", circle(0.02)),
        ("circle 30", circle(0.03)),
        ("square 30", square(0.03)),
        ("square 50", square(0.05)),
        ("line 20", line(0.02)),
        ("line 40", line(0.04)),
        ("line 60", line(0.06)),
        ("triangle 40", Target::new(Shape::Triangle { at: AT, size: 0.04 })),
    ] {
        all.push((format!("{name} motion"), running(target, 1)));
    }
    all.push(("H 40 motion, 2 foci".into(), running(text("H", 0.04), 2)));
    all.push(("HIT 30 motion, 3 foci".into(), running(text("HIT", 0.03), 3)));
    for (name, target) in [
        ("H 40", text("H", 0.04)),
        ("circle 20", circle(0.02)),
        ("square 40", square(0.04)),
        ("line 40", line(0.04)),
        ("S 40", text("S", 0.04)),
    ] {
        all.push((format!("{name} AM"), still(target)));
    }
    for (name, scene) in all {
        let start = std::time::Instant::now();
        let before = along(&scene);
        let middle = start.elapsed();
        let after = along(&evenly(scene));
        println!(
            "{name:24} {:6.2} dB, std {:.2}   even: {:6.2} dB, std {:.2}   {:.1} {:.1} s",
            before[0],
            before[1],
            after[0],
            after[1],
            middle.as_secs_f64(),
            (start.elapsed() - middle).as_secs_f64()
        );
    }
}
