//! Invalid numbers in a scene: its check refuses them, or the scene renders to finite numbers.

use glam::{DVec2, DVec3};
use sonoglyph::field::{Evaluator, FieldError, Quantity, Request, Stages};
use sonoglyph::scene::check::check;
use sonoglyph::scene::{
    Area, ElementModel, Envelope, Keyframe, Law, Listener, Modulation, Motion, MotionPath, Pressures,
    Sampling, Scene, Shape, Target, Tempo, Tone, Wave, Waveform, Zone, font, motion, outline,
};
use sonoglyph::solver::{self, SolveError};
use strum::VariantArray;

use crate::poison::{POISON, SIZES, panics};

type Put<T> = fn(&mut Scene, T);

/// Every number of a scene.
const NUMBERS: &[(&str, Put<f64>)] = &[
    ("medium.temperature", |s, x| s.medium.temperature = x),
    ("medium.humidity", |s, x| s.medium.humidity = x),
    ("medium.pressure", |s, x| s.medium.pressure = x),
    ("medium.sound_speed", |s, x| s.medium.sound_speed = Some(x)),
    ("medium.density", |s, x| s.medium.density = Some(x)),
    ("medium.absorption", |s, x| s.medium.absorption = Some(x)),
    ("array.pitch", |s, x| s.array.pitch = x),
    ("array.element_radius", |s, x| s.array.element_radius = x),
    ("array.element_radius", |s, x| {
        (s.array.element_radius, s.array.element) = (x, ElementModel::ExactPiston);
    }),
    ("array.frequency", |s, x| s.array.frequency = x),
    ("array.strength", |s, x| s.array.strength = x),
    ("target.at", |s, x| s.targets[0].shape = Shape::Point { at: DVec3::new(x, 0.0, 0.1) }),
    ("target.at", |s, x| s.targets[0].shape = Shape::Point { at: DVec3::new(0.0, 0.0, x) }),
    ("target.from", |s, x| s.targets[0].shape = Shape::Line { from: DVec3::new(x, 0.0, 0.1), to: DVec3::Z }),
    ("target.to", |s, x| s.targets[0].shape = Shape::Line { from: DVec3::Z, to: DVec3::new(0.0, x, 0.1) }),
    ("target.radius", |s, x| s.targets[0].shape = Shape::Circle { at: DVec3::Z, radius: x }),
    ("target.radius", |s, x| s.targets[0].shape = Shape::Polygon { at: DVec3::Z, radius: x, sides: 5 }),
    ("target.width", |s, x| s.targets[0].shape = Shape::Rectangle { at: DVec3::Z, width: x, height: 0.02 }),
    ("target.height", |s, x| s.targets[0].shape = Shape::Rectangle { at: DVec3::Z, width: 0.02, height: x }),
    ("target.size", |s, x| s.targets[0].shape = Shape::Triangle { at: DVec3::Z, size: x }),
    ("target.height", |s, x| {
        s.targets[0].shape = Shape::Text { text: "A".to_owned(), at: DVec3::Z, height: x };
    }),
    ("target.vertices", |s, x| {
        let vertices = vec![DVec3::Z, DVec3::new(x, 0.0, 0.1)];
        s.targets[0].shape = Shape::Path { vertices, closed: true };
    }),
    ("target.pressure", |s, x| s.targets[0].pressure = x),
    ("target.pressure", |s, x| (s.targets[0].pressure, s.solver.pressures) = (x, Pressures::Pascal)),
    ("target.pressures", |s, x| {
        let vertices = vec![DVec3::Z * 0.1, DVec3::Z * 0.12];
        s.targets[0].shape = Shape::Path { vertices, closed: false };
        s.targets[0].pressures = vec![x, 1.0];
    }),
    ("quiet.at", |s, x| s.quiet = vec![Zone::new(Area::Circle { radius: 0.01 }, DVec3::new(0.0, x, 0.1))]),
    ("quiet.radius", |s, x| s.quiet = vec![Zone::new(Area::Circle { radius: x }, DVec3::Z)]),
    ("quiet.radius", |s, x| s.quiet = vec![Zone::new(Area::Polygon { radius: x, sides: 5 }, DVec3::Z)]),
    ("quiet.width", |s, x| {
        s.quiet = vec![Zone::new(Area::Rectangle { width: x, height: 0.01 }, DVec3::Z)];
    }),
    ("quiet.weight", |s, x| {
        s.quiet = vec![Zone { weight: x, ..Zone::new(Area::Circle { radius: 0.01 }, DVec3::Z) }];
    }),
    ("solver.quiet", |s, x| s.solver.quiet = x),
    ("solver.search", |s, x| s.solver.search = x),
    ("target.spacing", |s, x| {
        s.targets[0].shape =
            Shape::Line { from: DVec3::new(-0.02, 0.0, 0.1), to: DVec3::new(0.02, 0.0, 0.1) };
        s.targets[0].sampling = Sampling::Spacing(x);
    }),
    ("target.angle", |s, x| {
        s.targets[0].shape = Shape::Triangle { at: DVec3::Z * 0.1, size: 0.02 };
        s.targets[0].angle = x;
    }),
    ("target.normal", |s, x| s.targets[0].normal = DVec3::new(x, 0.0, 1.0)),
    ("target.normal", |s, x| s.targets[0].normal = DVec3::new(0.0, 0.0, x)),
    ("plane.centre", |s, x| s.plane.centre.x = x),
    ("plane.centre", |s, x| s.plane.centre.z = x),
    ("plane.x_axis", |s, x| s.plane.x_axis = DVec3::new(x, 0.0, 0.0)),
    ("plane.y_axis", |s, x| s.plane.y_axis = DVec3::new(0.0, x, 0.0)),
    ("plane.size", |s, x| s.plane.size.x = x),
    ("plane.size", |s, x| s.plane.size = DVec2::splat(x)),
    ("plane.tolerance", |s, x| s.plane.tolerance = x),
    ("liquid.density", |s, x| s.liquid.density = Some(x)),
    ("liquid.surface_tension", |s, x| s.liquid.surface_tension = Some(x)),
    ("liquid.viscosity", |s, x| s.liquid.viscosity = Some(x)),
    ("liquid.gravity", |s, x| s.liquid.gravity = x),
    ("liquid.depth", |s, x| s.liquid.depth = x),
    ("modulation.frequency", |s, x| (s.modulation.shape, s.modulation.frequency) = (Envelope::Sine, x)),
    ("modulation.depth", |s, x| (s.modulation.shape, s.modulation.depth) = (Envelope::Sine, x)),
    ("modulation.tones[1].frequency", |s, x| tone(s, Tone { frequency: x, ..Tone::default() })),
    ("modulation.tones[1].depth", |s, x| tone(s, Tone { depth: x, ..Tone::default() })),
    ("modulation.tones[1].phase", |s, x| tone(s, Tone { phase: x, ..Tone::default() })),
    ("target.modulation.frequency", |s, x| own_modulation(s, x, 1.0)),
    ("target.modulation.depth", |s, x| own_modulation(s, 20e3, x)),
    ("motion.size", |s, x| (s.motion.path, s.motion.size, s.motion.frames) = (MotionPath::Circle, x, 3)),
    ("motion.rate", |s, x| s.motion.tempo = Tempo::Rate(x)),
    ("motion.speed", |s, x| s.motion.tempo = Tempo::Speed(x)),
    ("motion.speed", |s, x| {
        s.targets[0].shape = Shape::Circle { at: DVec3::Z * 0.1, radius: 0.01 };
        (s.motion.path, s.motion.tempo, s.motion.frames) = (MotionPath::Outline, Tempo::Speed(x), 3);
    }),
    ("target.motion.speed", |s, x| {
        let path = MotionPath::Circle;
        s.targets[0].motion = Some(Motion { path, tempo: Tempo::Speed(x), frames: 3, ..Motion::default() });
    }),
    ("motion.points", |s, x| {
        (s.motion.path, s.motion.points, s.motion.frames) =
            (MotionPath::Points, vec![DVec3::ZERO, DVec3::X * x], 3);
    }),
    ("motion.angle", |s, x| (s.motion.path, s.motion.angle, s.motion.frames) = (MotionPath::Line, x, 3)),
    ("motion.keyframes.time", |s, x| keyed(s, Keyframe::new(x, DVec3::ZERO))),
    ("motion.keyframes.at", |s, x| keyed(s, Keyframe::new(0.5, DVec3::X * x))),
    ("motion.keyframes.pressure", |s, x| {
        keyed(s, Keyframe { pressure: x, ..Keyframe::new(0.5, DVec3::ZERO) });
    }),
    ("listener.at", |s, x| s.listener = Some(Listener { at: DVec3::new(x, 0.0, 0.2) })),
];

fn keyed(scene: &mut Scene, keyframe: Keyframe) {
    let keyframes = vec![Keyframe::new(0.0, DVec3::ZERO), keyframe];
    scene.motion = Motion { path: MotionPath::Keyframes, keyframes, frames: 3, ..Motion::default() };
}

fn tone(scene: &mut Scene, tone: Tone) {
    (scene.modulation.shape, scene.modulation.tones) = (Envelope::Tones, vec![tone]);
}

/// A modulation of a target beside another that has none.
fn own_modulation(scene: &mut Scene, frequency: f64, depth: f64) {
    scene.targets.push(Target::new(Shape::Point { at: DVec3::new(-0.01, 0.0, 0.1) }));
    let shape = Envelope::Sine;
    scene.targets[0].modulation = Some(Modulation { shape, frequency, depth, ..Modulation::default() });
}

fn small() -> Scene {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (3, 4);
    scene.targets = vec![Target::new(Shape::Point { at: DVec3::new(0.01, 0.0, 0.1) })];
    scene.plane.size = DVec2::splat(0.04);
    scene
}

#[test]
fn any_number_in_a_scene_is_refused_or_renders() {
    let mut stages = Stages::new(Evaluator::Cpu);
    for (key, put) in NUMBERS {
        for poison in POISON {
            let mut scene = small();
            put(&mut scene, poison);
            match check(&scene).and_then(|()| motion::check(&scene)) {
                Err(error) => {
                    let name = key.rsplit('.').next().unwrap();
                    assert!(
                        error.to_string().contains(name) || *key == "target.at",
                        "{key} = {poison}: {error}"
                    );
                }
                Ok(()) => {
                    assert!(poison.is_finite(), "{key} = {poison} is accepted");
                    renders(&mut stages, &scene, &format!("{key} = {poison:e}"));
                }
            }
        }
    }
}

/// Solves and renders the scene; all pixels are numbers.
fn renders(stages: &mut Stages, scene: &Scene, name: &str) {
    let solution = match solver::solve(scene) {
        Ok(solution) => solution,
        Err(SolveError::Scene(_)) => return,
        Err(error) => panic!("{name}: {error}"),
    };
    assert!(solution.pressures.iter().all(|p| p.is_finite()), "{name}: {:?}", solution.pressures);
    assert!(solution.drive.phases.iter().chain(&solution.drive.amplitudes).all(|x| x.is_finite()), "{name}");
    for quantity in Quantity::ALL.into_iter().filter(|quantity| !quantity.declaration().of_volume) {
        let request = Request::new(scene, vec![solution.drive.clone()], quantity, (9, 7));
        match stages.map(&request) {
            Ok(map) => assert!(map.values.iter().all(|value| value.is_finite()), "{name}: {quantity:?}"),
            Err(FieldError::TooNear | FieldError::TooManyCells | FieldError::NotLevel)
                if quantity.declaration().is_pressed() => {}
            Err(error) => panic!("{name}: {quantity:?}: {error}"),
        }
    }
}

#[test]
fn excessive_counts_in_a_scene_are_refused() {
    let most = u32::MAX;
    let counts: [Put<u32>; 8] = [
        |s, n| s.array.rows = n,
        |s, n| s.array.columns = n,
        |s, n| (s.array.rows, s.array.columns) = (n, n),
        |s, n| s.array.off = vec![n as usize],
        |s, n| s.targets[0].shape = Shape::Polygon { at: DVec3::Z, radius: 0.01, sides: n },
        |s, n| s.targets[0].sampling = Sampling::Points(n as usize),
        |s, n| (s.motion.path, s.motion.frames) = (MotionPath::Circle, n),
        |s, n| (s.motion.path, s.motion.foci) = (MotionPath::Outline, n),
    ];
    for (index, put) in counts.iter().enumerate() {
        let mut scene = small();
        put(&mut scene, most);
        assert!(check(&scene).and_then(|()| motion::check(&scene)).is_err(), "count {index}");
        if ![3].contains(&index) {
            put(&mut scene, 0);
            assert!(check(&scene).is_err(), "count {index} = 0");
        }
    }
    let mut scene = small();
    scene.targets[0].step = Some(most);
    scene.motion.path = MotionPath::Steps;
    assert!(motion::check(&scene).is_err());
    assert!(outline::foci(&scene).is_err(), "the first step has no target");
}

#[test]
fn outlines_of_unchecked_targets_are_refused_or_finite() {
    let line = |to: DVec3| Shape::Line { from: DVec3::Z, to };
    let target = |sampling| Target { sampling, ..Target::new(line(DVec3::new(0.1, 0.0, 1.0))) };
    for poison in POISON {
        let count = outline::count(&[target(Sampling::Spacing(poison))]);
        assert!(count.is_err() || count.is_ok_and(|count| (2..=1024).contains(&count)), "{poison}");
        let far = outline::count(&[Target::new(line(DVec3::new(poison, poison, 1.0)))]);
        assert!(far.is_err() || far.is_ok_and(|count| count <= 1024), "{poison}");
        assert!(font::lay_out("A\u{e9}1", poison).is_ok());
        outline::strokes(&Target { angle: poison, normal: DVec3::splat(poison), ..target(Sampling::Whole) })
            .unwrap();
    }
    for points in SIZES {
        assert!(outline::count(&[target(Sampling::Points(points))]).is_err(), "{points} points");
    }
    assert_eq!(outline::count(&[]).unwrap(), 0);
    assert!(font::lay_out("\u{0}", 1.0).is_err());
}

#[test]
fn envelopes_and_paths_are_in_range() {
    let mut scene = small();
    let samples = Waveform { file: "a.wav".into(), rate: 3.0, values: vec![-1.0, 0.3, 1.0] };
    scene.modulation.wave = Wave::new(samples);
    scene.modulation.tones =
        vec![Tone { depth: 0.5, ..Tone::default() }, Tone { depth: 0.5, frequency: 1.5, phase: 9.0 }];
    for (shape, law) in
        Envelope::VARIANTS.iter().flat_map(|&shape| [(shape, Law::Amplitude), (shape, Law::Power)])
    {
        (scene.modulation.shape, scene.modulation.law) = (shape, law);
        for time in crate::poison::numbers().filter(|time| time.abs() <= 1e300) {
            assert!((0.0..=1.0).contains(&scene.modulation.envelope(time)), "{shape:?} at {time} s");
        }
        assert!((0.0..=1.0).contains(&scene.modulation.mean_square()));
    }
    for path in
        [MotionPath::Line, MotionPath::Circle, MotionPath::Square, MotionPath::Points, MotionPath::None]
    {
        scene.motion.path = path;
        for part in crate::poison::numbers().filter(|part| part.abs() <= 1e300) {
            let offset = scene.motion.offset(part);
            assert!(offset.length() <= scene.motion.size, "{path:?} at {part}: {offset}");
        }
    }
    scene.motion.path = MotionPath::Line;
    assert!(!panics(|| motion::cycle(&scene).map(|cycle| cycle.frames_per_second())));
}
