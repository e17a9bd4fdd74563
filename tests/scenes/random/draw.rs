//! Scenes at random, from the whole range that a scene file allows.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use sonoglyph::acoustics::Air;
use sonoglyph::scene::{
    Amplitudes, Array, Easing, ElementModel, Envelope, Keyframe, Law, Liquid, LiquidName, Listener, Medium,
    Method, Modulation, Motion, MotionPath, Plane, Pressures, Sampling, Scene, Shape, Skin, Solver, Target,
    Tempo, Threshold,
};
use strum::VariantArray;

use crate::dice::Dice;
use crate::random::{space, traps};

/// Cells of a dent, six per wavelength and 14 capillary lengths beyond the plane on every side: as many as there is time for.
const MOST_CELLS: f64 = 3_000.0;

/// What kind of scene it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// What somebody might build.
    Usual,
    /// Every number from its smallest to its largest legal value, evenly in the logarithm.
    Wide,
    /// Usual scenes with boards and reflectors in space, or with a table of elements.
    Spatial,
    /// Like the usual ones, but for foci that no array can tell apart, reach or hear.
    Ill,
}

#[derive(Clone, Debug)]
pub struct Case {
    pub family: Family,
    pub scene: Scene,
    /// For what a test draws besides the scene.
    pub dice: Dice,
}

impl Case {
    pub fn new(seed: u64, number: usize) -> Self {
        let mut dice = Dice::new(seed, number);
        let family = match number % 10 {
            0 => Family::Ill,
            1 | 2 => Family::Wide,
            9 => Family::Spatial,
            _ => Family::Usual,
        };
        let scene = match family {
            Family::Wide => scene(&mut dice, number, true),
            Family::Usual if number % 40 == 7 => {
                let scene = scene(&mut dice, number, false);
                traps::trapped(&scene, &mut dice)
            }
            Family::Usual => scene(&mut dice, number, false),
            Family::Spatial => space::placed(&scene(&mut dice, number, false), &mut dice),
            Family::Ill => {
                let mut scene = scene(&mut dice, number, false);
                spoil(&mut scene, &mut dice, number / 10);
                scene
            }
        };
        Self { family, scene, dice }
    }
}

fn scene(dice: &mut Dice, number: usize, wide: bool) -> Scene {
    let medium = medium(dice, wide);
    let mut array = array(dice, number, wide);
    let wavelength = Air::new(&medium, array.frequency).sound_speed / array.frequency;
    if !wide {
        array.pitch = wavelength * dice.between(0.4, 1.6);
        array.element_radius = array.pitch * dice.between(0.1, 0.5);
        array.element_size *= array.element_radius;
    }
    if wide && array.element == ElementModel::ExactPiston && dice.of(0.9) {
        array.element_radius = array.element_radius.min(2.0 * wavelength);
    }
    if array.element == ElementModel::ExactPiston {
        array.element_radius = array.element_radius.min(3000.0 * wavelength);
    }
    let middle = focus(dice, &array, wavelength);
    let reach = wavelength * dice.between(0.5, 4.0);
    let plane = plane(dice, middle, wavelength, wide);
    let liquid = liquid(dice, plane.size, wavelength);
    let solver = solver(dice);
    let pressures = solver.pressures;
    let shapes = dice.whole(1, if array.elements() > 1000 { 2 } else { 4 });
    let mut targets: Vec<_> =
        (0..shapes).map(|_| target(dice, middle, reach.min(0.9 * middle.z), pressures)).collect();
    if solver.method == Method::Focus && dice.of(0.8) {
        targets = vec![Target::new(Shape::Point { at: middle })];
    }
    if dice.of(0.1) {
        targets.push(Target { visible: false, ..Target::new(Shape::Point { at: -middle }) });
    }
    let is_outline = |target: &Target| !matches!(target.shape, Shape::Point { .. });
    let outline = targets.iter().any(is_outline).then_some(reach);
    let way = reach.min(0.05 * middle.z);
    let motion = motion(dice, way, outline);
    if motion.path == MotionPath::Steps {
        targets.iter_mut().zip(0..).for_each(|(target, step)| target.step = target.visible.then_some(step));
    }
    // Others than the last outline, which foci may run along, and whose length the cycle may be of.
    let last = targets.iter().rposition(is_outline).unwrap_or(0);
    let is_timed = matches!(motion.tempo, Tempo::Rate(_));
    if is_timed && last > 0 && dice.of(0.1) {
        own_motion(dice, &motion, way, &mut targets[0]);
    }
    let listener = dice.of(0.2).then(|| Listener { at: (middle * 0.5).with_z(middle.z) });
    let modulation = Modulation {
        shape: dice.one_of(&[Envelope::Off, Envelope::Sine, Envelope::Square]),
        frequency: dice.magnitude(1.0, 1000.0),
        depth: dice.one_of(&[0.0, 0.3, 1.0]),
        law: dice.one_of(&[Law::Amplitude, Law::Power]),
        ..Modulation::default()
    };
    // Drawn beside, so that all other scenes stay what they were.
    let mut beside = dice.clone();
    let skin = beside.of(0.2).then(|| skin(&mut beside));
    Scene {
        medium,
        array,
        targets,
        solver,
        plane,
        liquid,
        skin,
        modulation,
        motion,
        listener,
        ..Scene::default()
    }
}

fn medium(dice: &mut Dice, wide: bool) -> Medium {
    if wide {
        return Medium {
            temperature: dice.between(-50.0, 100.0),
            humidity: dice.between(0.0, 100.0),
            pressure: dice.magnitude(1e3, 1e6),
            sound_speed: dice.of(0.5).then(|| dice.magnitude(1.0, 1e4)),
            density: dice.of(0.5).then(|| dice.magnitude(1e-3, 1e4)),
            absorption: dice.of(0.5).then(|| dice.magnitude(1e-3, 1e3)),
        };
    }
    Medium {
        temperature: dice.between(-10.0, 40.0),
        humidity: dice.between(10.0, 90.0),
        pressure: dice.between(8e4, 1.05e5),
        sound_speed: dice.of(0.2).then(|| dice.between(300.0, 360.0)),
        density: dice.of(0.2).then(|| dice.between(1.0, 1.4)),
        absorption: dice.of(0.3).then(|| dice.one_of(&[0.0, 1.3, 20.0])),
    }
}

fn array(dice: &mut Dice, number: usize, wide: bool) -> Array {
    // Dice of their own: other scenes stay as they were.
    let mut own = Dice::new(0xE1E, number);
    let element = match dice.whole(0, 9) {
        0 | 1 => ElementModel::ExactPiston,
        2 | 3 => ElementModel::Point,
        4 => ElementModel::Rectangle,
        5 => ElementModel::Cosine,
        _ => ElementModel::Piston,
    };
    let (rows, columns) = match number % 100 {
        // An integral for every element and point.
        _ if element == ElementModel::ExactPiston && wide => (1, dice.whole(1, 2)),
        _ if element == ElementModel::ExactPiston => (dice.whole(1, 4), dice.whole(1, 4)),
        // More elements than fit into a uniform buffer, boards' own, and rows and columns that differ.
        13 if number % 5000 == 13 => (65, 64),
        14 => (16, 32),
        3 | 33 | 63 => (16, 16),
        4..=8 => (8, 8),
        _ => (dice.whole(1, 9), dice.whole(1, 9)),
    };
    let elements = rows * columns;
    let off = if dice.of(0.3) && elements > 1 {
        (0..dice.whole(1, elements / 2)).map(|_| dice.whole(0, elements - 1) as usize).collect()
    } else {
        Vec::new()
    };
    Array {
        rows,
        columns,
        pitch: if wide { dice.magnitude(1e-4, 1.0) } else { 0.0105 },
        element_radius: if wide { dice.magnitude(1e-5, 0.5) } else { 0.005 },
        frequency: if wide {
            dice.magnitude(1e3, 1e6) * own.one_of(&[1.0, 1.0, 1.0, 20.0])
        } else {
            dice.between(20e3, 80e3)
        },
        strength: if wide { dice.magnitude(1e-9, 1e6) } else { dice.between(0.5, 8.0) },
        element,
        element_size: if wide {
            DVec2::new(own.magnitude(1e-5, 0.5), own.magnitude(1e-5, 0.5))
        } else {
            DVec2::new(2.0, own.between(0.5, 2.0))
        },
        element_exponent: own.one_of(&[0.0, 0.5, 1.0, 2.0, 3.0, 9.3]),
        off,
        ..Array::default()
    }
}

/// Somewhere in front of the array, from a wavelength away to as far as a scene reaches.
fn focus(dice: &mut Dice, array: &Array, wavelength: f64) -> DVec3 {
    let half = DVec2::new(array.columns.into(), array.rows.into()) * array.pitch / 2.0;
    let across = half * DVec2::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0));
    let high = dice.magnitude(1.5, 40.0) * wavelength;
    across.clamp(DVec2::splat(-40.0), DVec2::splat(40.0)).extend(high.clamp(1e-4, 40.0))
}

fn plane(dice: &mut Dice, middle: DVec3, wavelength: f64, wide: bool) -> Plane {
    let number = |dice: &mut Dice| dice.between(-1.0, 1.0);
    let mut vector = || DVec3::new(number(dice), number(dice), number(dice));
    let (one, other) = (vector(), vector());
    let (x_axis, y_axis) = match dice.whole(0, 9) {
        0..=3 => (DVec3::X, DVec3::Y),
        4 => (-DVec3::Y, DVec3::X * 3.0),
        5 => (one.with_z(0.0), other.with_z(0.0)),
        6 => (DVec3::X, DVec3::Z),
        7 => (DVec3::Z * 0.01, DVec3::Y),
        _ => (one, other),
    };
    let side = |dice: &mut Dice| (dice.magnitude(0.3, 10.0) * wavelength).min(if wide { 50.0 } else { 0.5 });
    let tolerance = match dice.whole(0, 9) {
        0 => 0.0,
        1 if wide => dice.magnitude(1e-7, 1.0),
        _ => dice.magnitude(1e-5, 1e-2),
    };
    let centre = if dice.of(0.05) { middle.with_z(0.0) } else { middle };
    let plane = Plane { centre, x_axis, y_axis, size: DVec2::new(side(dice), side(dice)), tolerance };
    if plane.axes().is_some() { plane } else { Plane { x_axis: DVec3::X, y_axis: DVec3::Y, ..plane } }
}

fn skin(dice: &mut Dice) -> Skin {
    let known: &str = dice.one_of(Threshold::VARIANTS).into();
    Skin {
        wave_speed: dice.magnitude(0.5, 100.0),
        viscosity: dice.magnitude(0.01, 1e3),
        density: dice.magnitude(100.0, 1e4),
        depth: dice.of(0.5).then(|| dice.magnitude(5e-4, 0.1)),
        threshold: known.to_owned(),
        ..Skin::default()
    }
}

/// Any, as far as the dent has no more than [`MOST_CELLS`].
fn liquid(dice: &mut Dice, size: DVec2, wavelength: f64) -> Liquid {
    let cells = |liquid: &Liquid| {
        let sides = (size + 28.0 * liquid.capillary_length()) * 6.0 / wavelength;
        sides.x * sides.y
    };
    for _ in 0..30 {
        let named = Liquid {
            name: Some(dice.one_of(LiquidName::VARIANTS)),
            gravity: dice.between(1.0, 20.0),
            depth: dice.magnitude(1e-3, 1.0),
            ..Liquid::default()
        };
        let given = Liquid {
            density: Some(dice.magnitude(1.0, 1e5)),
            surface_tension: dice.of(0.8).then(|| dice.magnitude(1e-6, 10.0)),
            viscosity: Some(dice.magnitude(1e-6, 1e4)),
            gravity: dice.magnitude(1e-3, 1e3),
            ..named.clone()
        };
        if let Some(liquid) = [named, given].into_iter().find(|liquid| cells(liquid) < MOST_CELLS) {
            return liquid;
        }
    }
    Liquid { density: Some(1e5), surface_tension: Some(1e-6), gravity: 1e3, ..Liquid::default() }
}

fn solver(dice: &mut Dice) -> Solver {
    Solver {
        method: if dice.of(0.2) { Method::Best } else { dice.one_of(Method::VARIANTS) },
        iterations: dice.one_of(&[0, 0, 0, 1, 3, 12]),
        pressures: dice.one_of(&[Pressures::Relative, Pressures::Relative, Pressures::Pascal]),
        amplitudes: dice.one_of(&[Amplitudes::Uniform, Amplitudes::Uniform, Amplitudes::Free]),
        ..Solver::default()
    }
}

/// A target of any kind within `reach` (m) of a place, with so few focal points that thousands are solved.
fn target(dice: &mut Dice, middle: DVec3, reach: f64, pressures: Pressures) -> Target {
    let place = |dice: &mut Dice| {
        let mut part = || dice.between(-0.5, 0.5);
        middle + DVec3::new(part(), part(), part()) * reach
    };
    let at = place(dice);
    let size = reach * dice.between(0.1, 0.5);
    let (shape, most) = match dice.whole(0, 12) {
        0..=4 => (Shape::Point { at }, 0),
        5 => (Shape::Line { from: at, to: place(dice) }, 4),
        6 => (Shape::Circle { at, radius: size / 2.0 }, 6),
        7 => (Shape::Rectangle { at, width: size, height: 0.6 * size }, 6),
        8 => (Shape::Triangle { at, size }, 5),
        9 => (Shape::Polygon { at, radius: size / 2.0, sides: dice.whole(3, 6) }, 8),
        10 => (Shape::Path { vertices: vec![at, place(dice), place(dice)], closed: dice.of(0.5) }, 5),
        _ => (Shape::Text { text: dice.one_of(&["I", "L", "T", "-"]).to_owned(), at, height: size }, 8),
    };
    let sampling = match (&shape, dice.whole(0, 9)) {
        (Shape::Point { .. }, _) => Sampling::Whole,
        (_, 0..=4) => Sampling::Points(most),
        (_, 5) => Sampling::Continuous,
        _ => Sampling::Spacing((size * dice.between(0.5, 3.0)).clamp(1e-9, 100.0)),
    };
    let is_turned = !matches!(shape, Shape::Point { .. });
    let is_flat = is_turned && !matches!(shape, Shape::Line { .. } | Shape::Path { .. });
    let pressure = match pressures {
        Pressures::Relative => dice.between(0.3, 2.0),
        Pressures::Pascal => dice.magnitude(1.0, 1e5),
    };
    let tilt = DVec3::new(dice.between(-0.3, 0.3), dice.between(-0.3, 0.3), 1.0);
    Target {
        pressure,
        sampling,
        angle: if is_turned && dice.of(0.3) { dice.between(-PI, TAU) } else { 0.0 },
        normal: if is_flat && dice.of(0.3) { tilt } else { DVec3::Z },
        ..Target::new(shape)
    }
}

/// A few frames, in one scene of eight; `outline` (m) is how long the drawing may be whose strokes foci run along.
fn motion(dice: &mut Dice, size: f64, outline: Option<f64>) -> Motion {
    use MotionPath::{Circle, FigureEight, Keyframes, Line, Outline, Points, Square, Steps, Triangle};
    if dice.of(0.875) {
        return Motion::default();
    }
    let path = dice.one_of(&[Line, Circle, Square, Triangle, FigureEight, Points, Steps, Outline, Outline]);
    // What came later to motions is drawn beside, so that all other scenes stay what they were.
    let mut beside = dice.clone();
    let path = match path {
        Outline if outline.is_none() => Line,
        Points if beside.of(0.5) => Keyframes,
        path => path,
    };
    let has_speed = path != Steps && dice.of(0.3);
    let tempo = match has_speed {
        true => {
            let speed = outline.unwrap_or(size).max(1e-9) * dice.magnitude(1e-2, 1e2);
            Tempo::Speed(speed.clamp(1e-6, 1e5))
        }
        false => Tempo::Rate(dice.magnitude(1e-6, 1e5)),
    };
    let points = if path == Points { vec![DVec3::ZERO, DVec3::X * size.max(1e-9)] } else { Vec::new() };
    let foci = if path == Outline { dice.whole(1, 4) } else { 1 };
    let angle = if beside.of(0.3) { beside.between(-PI, TAU) } else { 0.0 };
    let keyframes = if path == Keyframes { keyframes(&mut beside, size) } else { Vec::new() };
    Motion {
        path,
        size: size.max(1e-9),
        angle,
        tempo,
        frames: dice.whole(4, 9),
        points,
        keyframes,
        foci,
        lead: beside.of(0.3),
        ..Motion::default()
    }
}

/// Some near the target's own place, of which two at least are apart.
fn keyframes(dice: &mut Dice, size: f64) -> Vec<Keyframe> {
    let size = size.max(1e-9);
    let count = dice.whole(2, 5);
    let (turns, shifts) = (dice.of(0.3), dice.of(0.1));
    let keyframe = |i: u32| Keyframe {
        time: (f64::from(i) + dice.between(0.0, 0.9)) / f64::from(count),
        at: DVec3::new(if i == 0 { size } else { -size * dice.unit() }, size * dice.unit(), 0.0),
        pressure: dice.magnitude(0.3, 1.0),
        angle: if turns { dice.between(-TAU, TAU) } else { 0.0 },
        phase: if shifts { dice.between(-PI, PI) } else { 0.0 },
        easing: if i == 0 { Easing::Linear } else { dice.one_of(Easing::VARIANTS) },
    };
    (0..count).map(keyframe).collect()
}

/// Gives a target a motion of its own, of as many rounds as the frames of the scene's leave room for.
fn own_motion(dice: &mut Dice, scene: &Motion, size: f64, target: &mut Target) {
    use MotionPath::{Circle, Line, None, Outline};
    let is_point = matches!(target.shape, Shape::Point { .. });
    let path = dice.one_of(&[None, Circle, Line, if is_point { None } else { Outline }]);
    let rate = match scene.tempo {
        Tempo::Rate(rate) if scene.path != None => rate * dice.between(0.3, 1.4),
        Tempo::Rate(_) | Tempo::Speed(_) | Tempo::Own => 3.0,
    };
    let tempo = Tempo::Rate(rate.clamp(1e-6, 1e5));
    let frames = dice.whole(3, 9);
    target.motion = Some(Motion { path, size: size.max(1e-9), tempo, frames, ..Motion::default() });
}

/// Makes a scene one in which foci are hopeless in one of these ways.
fn spoil(scene: &mut Scene, dice: &mut Dice, way: usize) {
    let point = |at: DVec3| Target::new(Shape::Point { at });
    let Array { pitch, rows, columns, .. } = scene.array;
    // The centre of element 0.
    let corner = -0.5 * pitch * DVec3::new(f64::from(columns - 1), f64::from(rows - 1), 0.0);
    let ahead = DVec3::new(0.3 * pitch, -0.2 * pitch, 8.0 * pitch);
    scene.motion = Motion::default();
    scene.targets.iter_mut().for_each(|target| (target.step, target.motion) = (None, None));
    match way % 14 {
        0 => scene.targets = vec![point(ahead); 3],
        1 => {
            scene.targets =
                vec![point(ahead), point(ahead + DVec3::X * 1e-7), point(ahead + DVec3::Y * 1e-12)];
        }
        2 => scene.targets.push(point(-ahead)),
        3 => scene.targets.push(point(corner)),
        4 => scene.targets = vec![point(corner.with_z(1e-6)), point(ahead)],
        5 => scene.targets = vec![point(corner.with_z(f64::MIN_POSITIVE)), point(corner.with_z(1e-300))],
        6 => (scene.array.rows, scene.array.columns, scene.array.off) = (1, 1, Vec::new()),
        7 => {
            let ring = Shape::Circle { at: ahead, radius: 2.0 * pitch };
            scene.targets.push(Target { sampling: Sampling::Points(24), ..Target::new(ring) });
            (scene.array.rows, scene.array.columns, scene.array.off) = (2, 3, vec![0]);
        }
        8 => {
            scene.targets = vec![point(ahead), point(ahead * 1.3), point(ahead * 1.7)];
            scene.targets[0].pressure = 1e-6;
            scene.targets[1].pressure = 1e9;
        }
        9 => scene.array.off = (1..scene.array.elements()).collect(),
        10 => scene.targets = vec![point(DVec3::splat(100.0)), point(ahead)],
        11 => match dice.whole(0, 1) {
            0 => scene.targets.clear(),
            _ => scene.targets.iter_mut().for_each(|target| target.visible = false),
        },
        // So far away in so thick a medium that nothing arrives.
        12 => {
            scene.medium.absorption = Some(1e3);
            scene.targets = vec![point(DVec3::Z * 99.0), point(DVec3::new(1.0, 0.0, 98.0))];
        }
        // Beside the array, in a null of the directivity or near it.
        _ => scene.targets = vec![point(DVec3::new(90.0, 0.0, 1e-3)), point(DVec3::new(-80.0, 1.0, 1e-9))],
    }
}
