//! The limits of every number in a scene, and their checks.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::scene::array::{Array, ElementModel, Spread};
use crate::scene::content::{Listener, Scene};
use crate::scene::modulation::{Envelope, Modulation};
use crate::scene::modulation::{MOST_TONES, frequencies};
use crate::scene::motion::{Keyframe, Motion, MotionPath, Tempo};
use crate::scene::range::{Key, KeyError, count, direction, finite, length, point, refuse, within};
use crate::scene::response::Response;
use crate::scene::shape::{Shape, ShapeKey, ShapeValue};
use crate::scene::skin::Skin;
use crate::scene::solver::{Pressures, Solver};
use crate::scene::space::Front;
use crate::scene::target::{Sampling, Target};
use crate::scene::zone::{Area, Zone};
use crate::scene::{
    bodies, liquid::Liquid, medium::Medium, motion, plane::Plane, space, trap::Trap, turns::Turns,
};

pub use crate::scene::space::MOST_ELEMENTS;

/// Limit of focal points per scene; the solver's work grows with its cube.
pub const MOST_FOCI: usize = 1024;
/// Limit of targets per scene, over all steps.
pub const MOST_TARGETS: usize = 10_000;
/// Limit of letters in the name of a target or a group.
pub const MOST_LETTERS: usize = 64;
/// Limit of quiet zones per scene.
pub const MOST_ZONES: usize = 64;
/// The largest ka of an exact piston: its integral needs some 50 000 nodes per point.
const WIDEST_DISK: f64 = 2e4;
/// Target pressures, relative or in Pa (peak).
const LEAST_PRESSURE: f64 = 1e-6;
const MOST_PRESSURE: f64 = 1e9;
/// Repetitions per second of a motion.
pub(crate) const RATES: std::ops::RangeInclusive<f64> = 1e-6..=1e5;
/// Factors of keyframes on target pressures.
pub const FACTORS: std::ops::RangeInclusive<f64> = 1e-3..=1e3;
/// Limit of a keyframe's angle and phase, rad.
const MOST_TURN: f64 = 1e4;
/// Limit of keyframes of one motion.
const MOST_KEYFRAMES: usize = 1024;
/// Limit of iterations: a thousand times the need of any method.
const MOST_ITERATIONS: u64 = 100_000;
/// Rounding error of a sum of decimal numbers.
const ROUNDING: f64 = 1e-9;
/// Limit of drives in turn: more do not lower the side lobes of the mean.
const MOST_TURNS: u64 = 32;
/// s of search.
const LONGEST_SEARCH: f64 = 3600.0;
/// Sine of the largest angle at which a plane counts as horizontal.
const LEVEL: f64 = 1e-9;

/// Checks every number of the scene.
///
/// # Errors
/// The first key whose value is outside its limits.
pub fn check(scene: &Scene) -> Result<(), KeyError> {
    medium(&scene.medium).map_err(|e| e.under(&["medium".into()]))?;
    array(&scene.array).and_then(|()| disk(scene)).map_err(|e| e.under(&["array".into()]))?;
    off(scene).map_err(|e| e.under(&["array".into()]))?;
    if !scene.array.lacks_elements() {
        scene.drive.check(scene.elements())?;
    }
    if scene.targets.len() > MOST_TARGETS {
        let message =
            format!("{} are more than the {MOST_TARGETS} that a scene may have", scene.targets.len());
        return refuse("target", message);
    }
    for (index, target) in scene.targets.iter().enumerate() {
        self::target(target, scene.solver.pressures, scene.array.frequency)
            .map_err(|e| e.under(&["target".into(), index.into()]))?;
    }
    if scene.quiet.len() > MOST_ZONES {
        let message = format!("{} are more than the {MOST_ZONES} that a scene may have", scene.quiet.len());
        return refuse("quiet", message);
    }
    let front = scene.front();
    for (index, zone) in scene.quiet.iter().enumerate() {
        self::zone(zone, &front).map_err(|e| e.under(&["quiet".into(), index.into()]))?;
    }
    solver(&scene.solver).map_err(|e| e.under(&["solver".into()]))?;
    plane(&scene.plane).map_err(|e| e.under(&["plane".into()]))?;
    aim(scene).and_then(|()| felt(scene)).map_err(|e| e.under(&["solver".into()]))?;
    liquid(&scene.liquid).map_err(|e| e.under(&["liquid".into()]))?;
    scene.bead.check().map_err(|e| e.under(&["bead".into()]))?;
    scene.skin.as_ref().map_or(Ok(()), Skin::check).map_err(|e| e.under(&["skin".into()]))?;
    space::check(scene)?;
    bodies::check(scene)?;
    modulation(&scene.modulation, scene.array.frequency).map_err(|e| e.under(&["modulation".into()]))?;
    motion(&scene.motion).map_err(|e| e.under(&["motion".into()]))?;
    let audible = |it| listener(it, &front).map_err(|e| e.under(&["listener".into()]));
    scene.listener.as_ref().map_or(Ok(()), audible)
}

fn medium(medium: &Medium) -> Result<(), KeyError> {
    within("temperature", medium.temperature, -50.0, 100.0, "°C")?;
    within("humidity", medium.humidity, 0.0, 100.0, "%")?;
    within("pressure", medium.pressure, 1e3, 1e6, "Pa")?;
    if let Some(sound_speed) = medium.sound_speed {
        within("sound_speed", sound_speed, 1.0, 1e4, "m/s")?;
    }
    if let Some(density) = medium.density {
        within("density", density, 1e-3, 1e4, "kg/m³")?;
    }
    if let Some(absorption) = medium.absorption {
        within("absorption", absorption, 0.0, 1e5, "dB/m")?;
    }
    Ok(())
}

fn array(array: &Array) -> Result<(), KeyError> {
    count("rows", u64::from(array.rows), 1, MOST_ELEMENTS)?;
    count("columns", u64::from(array.columns), 1, MOST_ELEMENTS)?;
    let elements = u64::from(array.rows) * u64::from(array.columns);
    if elements > MOST_ELEMENTS {
        return refuse(
            "rows",
            format!("{elements} elements are more than the {MOST_ELEMENTS} that an array may have"),
        );
    }
    length("pitch", array.pitch)?;
    length("element_radius", array.element_radius)?;
    element(array)?;
    within("frequency", array.frequency, 1e3, 20e6, "Hz")?;
    within("strength", array.strength, 1e-9, 1e6, "Pa·m")?;
    within("reflectivity", array.reflectivity, -1.0, 1.0, "(0: none, 1: rigid)")?;
    spread(&array.spread).map_err(|e| e.under(&["spread".into()]))?;
    match array.response {
        None | Some(Response::Preset(_)) => Ok(()),
        Some(Response::Pole(pole)) => {
            let under = |e: KeyError| e.under(&["response".into()]);
            within("resonance", pole.resonance, 1e3, 20e6, "Hz").map_err(under)?;
            within("tau", pole.tau, 1e-6, 0.1, "s").map_err(under)
        }
    }
}

/// Checks the keys of the element's model.
fn element(array: &Array) -> Result<(), KeyError> {
    for (axis, name) in ["width", "height"].into_iter().enumerate() {
        length(name, array.element_size[axis])
            .map_err(|e| KeyError::new([Key::from("element_size")], format!("{name}: {}", e.message)))?;
    }
    within("element_exponent", array.element_exponent, 0.0, 1e3, "(0: the same in every direction)")?;
    if array.element == ElementModel::Measured && array.directivity.is_none() {
        let message = "`element = \"measured\"` needs the name of a table with `angle` and `amplitude`";
        return refuse("directivity", message);
    }
    Ok(())
}

fn spread(spread: &Spread) -> Result<(), KeyError> {
    within("gain", spread.gain, 0.0, 1.0, "of the mean gain, rms")?;
    within("phase", spread.phase, 0.0, PI, "rad, rms")
}

/// Elements in `off` exist, and at least one other is wired and on.
fn off(scene: &Scene) -> Result<(), KeyError> {
    let (array, elements) = (&scene.array, scene.elements());
    if array.lacks_elements() {
        return Ok(());
    }
    for (position, &element) in array.off.iter().enumerate() {
        if element >= elements {
            return Err(KeyError::new(
                [Key::from("off"), Key::from(position)],
                format!("the elements are numbered 0 to {}", elements - 1),
            ));
        }
    }
    if array.lacks_wires() || !scene.driven().is_empty() {
        return Ok(());
    }
    match array.off.is_empty() {
        true => refuse("wiring", "no element is wired: at least one must be driven"),
        false => refuse("off", "every element that is wired is off: at least one must be driven"),
    }
}

fn label(key: &'static str, text: &str) -> Result<(), KeyError> {
    if text.chars().count() > MOST_LETTERS {
        return refuse(key, format!("longer than {MOST_LETTERS} letters"));
    }
    if text.chars().any(char::is_control) {
        return refuse(key, "holds a control character".to_owned());
    }
    Ok(())
}

fn disk(scene: &Scene) -> Result<(), KeyError> {
    let Scene { array, medium, .. } = scene;
    let widest = WIDEST_DISK * medium.speed_of_sound() / (TAU * array.frequency);
    if array.element != ElementModel::ExactPiston || array.element_radius <= widest {
        return Ok(());
    }
    let message = format!(
        "an exact piston may have at most {widest:.4} m at this frequency, {:.0} wavelengths: use `piston`, the far-field model",
        WIDEST_DISK / TAU
    );
    refuse("element_radius", message)
}

fn target(target: &Target, pressures: Pressures, carrier: f64) -> Result<(), KeyError> {
    shape(&target.shape)?;
    label("name", &target.name)?;
    label("group", &target.group)?;
    let unit = match pressures {
        Pressures::Relative => "relative to the other foci",
        Pressures::Pascal => "Pa (peak)",
    };
    if target.pressure <= 0.0 {
        let message = format!(
            "0 or less is no target: leave the target out, or give a number from {LEAST_PRESSURE} to {MOST_PRESSURE} \
             {unit}"
        );
        return refuse("pressure", message);
    }
    within("pressure", target.pressure, LEAST_PRESSURE, MOST_PRESSURE, unit)?;
    self::pressures(target)?;
    if !target.pressures.is_empty() && target.is_area() {
        return refuse("pressures", "an area has one pressure: leave `fill` or `stroke` out");
    }
    finite("angle", target.angle)?;
    direction("normal", target.normal)?;
    if let Some(own) = &target.motion {
        motion(own).and_then(|()| no_steps(own)).map_err(|e| e.under(&["motion".into()]))?;
    }
    if let Some(own) = &target.modulation {
        modulation(own, carrier).map_err(|e| e.under(&["modulation".into()]))?;
    }
    match target.sampling {
        Sampling::Whole | Sampling::Continuous => Ok(()),
        Sampling::Spacing(spacing) => length("spacing", spacing),
        Sampling::Points(points) => count("points", points as u64, 1, MOST_FOCI as u64),
        Sampling::Fill => target.shape.inside().or_else(|reason| refuse("fill", reason)),
        Sampling::Stroke(width) => length("stroke", width),
    }
}

/// Checks the pressures along a path.
fn pressures(target: &Target) -> Result<(), KeyError> {
    let given = target.pressures.len();
    if given == 0 {
        return Ok(());
    }
    if !target.shape.is_path() {
        return refuse("pressures", "only a path has one per vertex");
    }
    let asked = target.shape.clone().points().len();
    if given != asked {
        return refuse("pressures", format!("{given} pressures for {asked} vertices: give one for each"));
    }
    for (index, pressure) in target.pressures.iter().enumerate() {
        if !(LEAST_PRESSURE..=MOST_PRESSURE).contains(&(pressure * target.pressure)) {
            let message =
                format!("times `pressure`, must be a number from {LEAST_PRESSURE} to {MOST_PRESSURE}");
            return Err(KeyError::new([Key::from("pressures"), Key::from(index)], message));
        }
    }
    Ok(())
}

fn zone(zone: &Zone, front: &Front) -> Result<(), KeyError> {
    point("at", zone.at)?;
    match zone.area {
        Area::Circle { radius } => length("radius", radius)?,
        Area::Rectangle { width, height } => {
            length("width", width)?;
            length("height", height)?;
        }
        Area::Polygon { radius, sides } => {
            length("radius", radius)?;
            count("sides", u64::from(sides), 3, MOST_FOCI as u64)?;
        }
    }
    direction("normal", zone.normal)?;
    finite("angle", zone.angle)?;
    within("weight", zone.weight, 1e-6, 1e6, "(1: as much as the rest of the plane)")?;
    match front.outside(|up| Some(zone.lowest(up))) {
        None => Ok(()),
        Some(_) => refuse("at", format!("the zone reaches {}", front.behind())),
    }
}

fn solver(solver: &Solver) -> Result<(), KeyError> {
    count("iterations", solver.iterations.into(), 0, MOST_ITERATIONS)?;
    within("quiet", solver.quiet, 0.0, 1.0, "(0: the strongest drive, 1: the quietest elsewhere)")?;
    if let Turns::Count(frames) = solver.frames {
        count("frames", frames.into(), 1, MOST_TURNS)?;
    }
    search(solver.search)
}

/// Checks a time of search, s.
///
/// # Errors
/// A negative time, or more than an hour.
pub fn search(seconds: f64) -> Result<(), KeyError> {
    within("search", seconds, 0.0, LONGEST_SEARCH, "s")
}

/// What is felt moves, and has no pressure of its own.
fn felt(scene: &Scene) -> Result<(), KeyError> {
    if !scene.aims_at_felt() || scene.drive.is_named() {
        return Ok(());
    }
    if scene.solver.pressures == Pressures::Pascal {
        return refuse("target", "\"felt\" finds the pressures, and pressures = \"pascal\" prescribes them");
    }
    if scene.has_own_envelopes() {
        return refuse(
            "target",
            "\"felt\" levels targets that share one modulation: leave [target.modulation] out",
        );
    }
    if scene.envelope().shape == Envelope::Off && !motion::moves(scene) {
        return refuse("target", "steady sound is not felt: give [modulation] a shape, or [motion] a path");
    }
    Ok(())
}

/// The liquid's surface is horizontal, and the only board faces it.
fn aim(scene: &Scene) -> Result<(), KeyError> {
    if !scene.aims_at_depression() {
        return Ok(());
    }
    if !scene.is_home() || !scene.mirrors().is_empty() || !scene.bodies.is_empty() {
        let message =
            "a depression needs a single board of rows and columns in z = 0, without reflectors and bodies";
        return refuse("target", message);
    }
    let normal = scene.plane.axes().map_or(DVec3::Z, |(x, y)| x.cross(y));
    if normal.truncate().length() < LEVEL {
        return Ok(());
    }
    let message = "a depression needs a scene plane parallel to the array: `plane.x_axis` and `plane.y_axis` are not level";
    refuse("target", message)
}

/// Checks the keys of a shape by their types.
fn shape(shape: &Shape) -> Result<(), KeyError> {
    let mut copy = shape.clone();
    for ShapeKey { name, value, .. } in copy.keys() {
        match value {
            ShapeValue::Point(at) => point(name, *at)?,
            ShapeValue::Vertices(vertices) => self::vertices(name, vertices)?,
            ShapeValue::Length(length) => self::length(name, *length)?,
            ShapeValue::Sides(sides) => count(name, u64::from(*sides), 3, MOST_FOCI as u64)?,
            ShapeValue::Letters(text) if text.trim().is_empty() => {
                return refuse(name, "the text is empty");
            }
            // Every letter has at least one focal point.
            ShapeValue::Letters(text) if text.chars().count() > MOST_FOCI => {
                return refuse(name, format!("a text may have at most {MOST_FOCI} characters"));
            }
            ShapeValue::File(file) if file.is_empty() => {
                return refuse(name, "there is no name of a picture");
            }
            ShapeValue::Charge(charge) => Trap::check(*charge)?,
            ShapeValue::Direction(direction) => self::direction(name, *direction)?,
            ShapeValue::Letters(_) | ShapeValue::File(_) | ShapeValue::Closed(_) | ShapeValue::Trap(_) => {}
        }
    }
    match copy.points()[..] {
        [&mut from, &mut to] if shape.is_line() && from == to => {
            refuse("to", "the line ends where it begins")
        }
        _ => Ok(()),
    }
}

fn vertices(key: &'static str, vertices: &[DVec3]) -> Result<(), KeyError> {
    if vertices.len() < 2 {
        return refuse(key, "a path needs at least two vertices");
    }
    if vertices.len() > MOST_FOCI {
        return refuse(key, format!("a path may have at most {MOST_FOCI} vertices"));
    }
    points(key, vertices)?;
    if vertices.windows(2).all(|pair| pair[0] == pair[1]) {
        return refuse(key, "the path has no length");
    }
    Ok(())
}

/// Checks a list of positions.
fn points(key: &'static str, points: &[DVec3]) -> Result<(), KeyError> {
    points.iter().enumerate().try_for_each(|(index, at)| {
        point(key, *at).map_err(|mut e| {
            e.path.push(index.into());
            e
        })
    })
}

fn plane(plane: &Plane) -> Result<(), KeyError> {
    point("centre", plane.centre)?;
    direction("x_axis", plane.x_axis)?;
    direction("y_axis", plane.y_axis)?;
    if plane.axes().is_none() {
        return refuse("y_axis", "lies along `x_axis`: the two do not span a plane");
    }
    for length in plane.size.to_array() {
        self::length("size", length)?;
    }
    within("tolerance", plane.tolerance, 0.0, 1.0, "of the map's peak")
}

fn liquid(liquid: &Liquid) -> Result<(), KeyError> {
    within("density", liquid.density(), 1.0, 1e5, "kg/m³")?;
    within("surface_tension", liquid.surface_tension(), 1e-6, 10.0, "N/m")?;
    within("viscosity", liquid.viscosity(), 0.0, 1e4, "Pa·s")?;
    within("gravity", liquid.gravity, 1e-3, 1e3, "m/s²")?;
    length("depth", liquid.depth)?;
    within("refractive_index", liquid.refractive_index(), 1.0, 4.0, "(1: light passes unbent)")?;
    length("screen", liquid.screen)
}

/// Checks a modulation of a carrier (Hz).
fn modulation(modulation: &Modulation, carrier: f64) -> Result<(), KeyError> {
    let unit = format!("Hz: half of the carrier, array.frequency = {carrier}");
    let (slowest, fastest) = frequencies(carrier).into_inner();
    let frequency = |frequency| within("frequency", frequency, slowest, fastest, &unit);
    let depth = |depth| within("depth", depth, 0.0, 1.0, "(0: none, 1: full)");
    frequency(modulation.frequency)?;
    depth(modulation.depth)?;
    let tones = &modulation.tones;
    if tones.len() > MOST_TONES {
        let message = format!("{} are more than the {MOST_TONES} that a modulation may have", tones.len());
        return refuse("tones", message);
    }
    let mut sum = 0.0;
    for (index, tone) in tones.iter().enumerate() {
        sum += tone.depth;
        let fits = || match sum <= 1.0 + ROUNDING {
            true => Ok(()),
            false => refuse(
                "depth",
                format!("with the tones before it depths add up to {sum}: 1 at most, silence"),
            ),
        };
        frequency(tone.frequency)
            .and_then(|()| depth(tone.depth))
            .and_then(|()| finite("phase", tone.phase))
            .and_then(|()| fits())
            .map_err(|e| e.under(&["tones".into(), index.into()]))?;
    }
    match modulation.shape {
        Envelope::Tones if tones.is_empty() => {
            refuse("tones", "`shape = \"tones\"` needs one at least: { frequency = 200, depth = 1 }")
        }
        Envelope::File if modulation.file.is_empty() => {
            refuse("file", "`shape = \"file\"` needs the name of a WAV file")
        }
        Envelope::Off | Envelope::Sine | Envelope::Square | Envelope::Tones | Envelope::File => Ok(()),
    }
}

fn motion(motion: &Motion) -> Result<(), KeyError> {
    length("size", motion.size)?;
    match motion.tempo {
        Tempo::Own => {}
        Tempo::Rate(rate) => within("rate", rate, *RATES.start(), *RATES.end(), "cycles per second")?,
        Tempo::Speed(speed) => within("speed", speed, 1e-6, 1e5, "m/s")?,
    }
    count("foci", motion.foci.into(), 1, MOST_FOCI as u64)?;
    // The upper limit depends on the array: see `motion::check`.
    let fewest = u64::from(motion.path != MotionPath::File);
    count("frames", u64::from(motion.frames), fewest, u64::from(u32::MAX))?;
    points("points", &motion.points)?;
    finite("angle", motion.angle)?;
    keyframes(&motion.keyframes)?;
    if motion.path == MotionPath::Keyframes && motion.keyframes.is_empty() {
        return refuse("keyframes", "`path = \"keyframes\"` needs one at least");
    }
    if motion.path == MotionPath::File && motion.file.is_empty() {
        return refuse("file", "`path = \"file\"` needs the name of a CSV or G-code file");
    }
    if motion.path == MotionPath::Points && motion.points.is_empty() {
        return refuse("points", "`path = \"points\"` needs the offsets to visit");
    }
    Ok(())
}

/// Increasing times, valid positions, positive pressures.
fn keyframes(keyframes: &[Keyframe]) -> Result<(), KeyError> {
    if keyframes.len() > MOST_KEYFRAMES {
        return refuse(
            "keyframes",
            format!("{} are more than the {MOST_KEYFRAMES} that a motion may have", keyframes.len()),
        );
    }
    let mut before = None;
    for (index, keyframe) in keyframes.iter().enumerate() {
        let check = || {
            let Keyframe { time, at, pressure, angle, phase, easing: _ } = *keyframe;
            if !(0.0..1.0).contains(&time) {
                return refuse("time", "must be a part of the cycle, from 0 to less than 1");
            }
            if before.is_some_and(|before| time <= before) {
                return refuse("time", "must be later than the previous keyframe");
            }
            point("at", at)?;
            within("pressure", pressure, *FACTORS.start(), *FACTORS.end(), "times the target's own")?;
            within("angle", angle, -MOST_TURN, MOST_TURN, "rad")?;
            within("phase", phase, -MOST_TURN, MOST_TURN, "rad")
        };
        check().map_err(|e: KeyError| e.under(&["keyframes".into(), index.into()]))?;
        before = Some(keyframe.time);
    }
    Ok(())
}

/// Checks the path of a target's own motion.
fn no_steps(own: &Motion) -> Result<(), KeyError> {
    if own.path != MotionPath::Steps {
        return Ok(());
    }
    refuse("path", "a single target cannot have steps: `path = \"steps\"` belongs to the scene's [motion]")
}

/// Checks the position of a listener.
///
/// # Errors
/// A point behind the array or outside the limits of scenes.
pub fn listener(listener: &Listener, front: &Front) -> Result<(), KeyError> {
    point("at", listener.at)?;
    if front.contains(listener.at) {
        return Ok(());
    }
    refuse("at", format!("{}, where no sound is modelled: give a point in front", front.behind()))
}
