//! The promise of every map: the largest error of all its pixels is within the tolerance.
//!
//! Random maps of twelve classes, of all element models and quantities, by all evaluators, against f64 at every pixel.
//! `SONOGLYPH_MAPS=4711` or `=4000..5000` selects maps.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::sound::PRESSURE;
use sonoglyph::field::{Evaluator, Norm, Quantity, Request, Samples, Stages, reference};
use sonoglyph::scene::check::check;
use sonoglyph::scene::{Array, ElementModel, Medium, Plane, Scene, file};
use strum::VariantArray;

use crate::dice::Dice;
use crate::{STEP, evaluators, fast_evaluators, gpu, model, scattered};

const SEED: u64 = 0x0040_6B48_7A00_0002;
/// Maps of a default run, each by every evaluator: one of every class, element model and kind of tolerance.
const MAPS: usize = 120;
/// Error of direct evaluation, relative to the peak.
const EXACT: f64 = 2e-5;
/// Of any unit; smaller values underflow in f32.
const FAINTEST: f64 = 1e-15;

/// The difficulty of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, VariantArray)]
enum Class {
    Tilted,
    Grazing,
    Close,
    Far,
    Tiny,
    HugePitch,
    WideElements,
    OneElement,
    Nulls,
    Edges,
    LowFrequency,
    HighFrequency,
}

#[derive(Clone, Copy, Debug)]
enum Tolerance {
    Given(f64),
    Exact,
    /// A multiple of the error of f32: possibly finer than f32 can keep, which the map must then state.
    Tuned(f64),
}

struct Case {
    class: Class,
    tolerance: Tolerance,
    request: Request,
    scene: Scene,
}

impl Case {
    fn new(number: usize) -> Self {
        let mut dice = Dice::new(SEED, number);
        let classes = Class::VARIANTS;
        let class = classes[number % classes.len()];
        let models = ElementModel::VARIANTS;
        let element = models[number / classes.len() % models.len()];
        let tolerance = match number / (classes.len() * models.len()) % 5 {
            0 => Tolerance::Given(1e-2),
            1 => Tolerance::Given(1e-3),
            2 => Tolerance::Given(dice.one_of(&[1e-4, 1e-5])),
            3 => Tolerance::Exact,
            _ => Tolerance::Tuned(dice.magnitude(0.2, 4.0)),
        };
        let mut scene = scene(class, element, &mut dice);
        scene.plane.tolerance = match tolerance {
            Tolerance::Given(tolerance) => tolerance,
            Tolerance::Exact | Tolerance::Tuned(_) => 0.0,
        };
        check(&scene).unwrap_or_else(|error| panic!("map {number}: {error}"));
        let quantity = quantity(&scene, &mut dice);
        let declaration = quantity.declaration();
        let count = if declaration.has_mean && dice.of(0.3) { dice.whole(2, 3) } else { 1 };
        let drives = (0..count).map(|_| drive(class, &scene, &mut dice)).collect();
        let most = if element == ElementModel::ExactPiston { 44 } else { 180 };
        let most = if declaration.parts == PRESSURE { most } else { most / 2 };
        let size = (dice.whole(8, most) as usize, dice.whole(8, most) as usize);
        let moment = dice.between(-PI, PI);
        let request = Request { moment, ..Request::new(&scene, drives, quantity, size) };
        Self { class, tolerance, request, scene }
    }

    /// Value and |P| of every pixel in f64, and the reference of relative errors.
    fn expected(&self) -> (Vec<(f64, f64)>, f64) {
        let Request { aperture, air, plane, drives, quantity, moment, size, .. } = &self.request;
        let (x, y) = plane.axes().unwrap();
        let pixels = Samples::on_plane(plane, size.0, size.1).unwrap();
        let points: Vec<_> = (0..pixels.len()).map(|index| pixels.point(index)).collect();
        let axes = [x, y, x.cross(y)];
        let has_slopes = quantity.declaration().parts != PRESSURE;
        let sounds = |drive| match has_slopes {
            true => model::sounds(aperture, drive, axes, &points),
            false => model::pressures(aperture, drive, &points),
        };
        let sounds: Vec<_> = drives.iter().map(sounds).collect();
        let pixel = |index: usize| {
            let of_drives = sounds.iter().map(|sounds| sounds[index]);
            let modulus = sounds[0][index].p.norm();
            (model::value(*quantity, air, aperture, *moment, of_drives), modulus)
        };
        let pixels: Vec<_> = (0..points.len()).map(pixel).collect();
        let is_of_pressure = quantity.declaration().norm == Norm::Pressure;
        let extent = |&(value, modulus): &(f64, f64)| if is_of_pressure { modulus } else { value.abs() };
        let peak = pixels.iter().map(extent).fold(0.0, f64::max);
        (pixels, peak)
    }
}

/// Any quantity, but none with slopes where a difference would reach through the array.
fn quantity(scene: &Scene, dice: &mut Dice) -> Quantity {
    let Plane { centre, size, .. } = scene.plane;
    let (x, y) = scene.plane.axes().unwrap();
    let lowest = centre.z - (x.z.abs() * size.x + y.z.abs() * size.y) / 2.0;
    let is_near = lowest < 1e-3 * Aperture::new(scene).wavelength();
    let quantities: Vec<_> = Quantity::ALL
        .into_iter()
        // Potentials and forces are tested in `force`.
        .filter(|quantity| !quantity.declaration().is_pressed() && quantity.declaration().has_formula())
        .filter(|quantity| !is_near || quantity.declaration().parts == PRESSURE)
        .collect();
    if dice.of(0.4) { Quantity::Instantaneous } else { dice.one_of(&quantities) }
}

fn scene(class: Class, element: ElementModel, dice: &mut Dice) -> Scene {
    use Class::*;
    let most = if element == ElementModel::ExactPiston { 4 } else { 9 };
    let (rows, columns) = match class {
        OneElement => (1, 1),
        _ => (dice.whole(1, most), dice.whole(2, most)),
    };
    let frequency = match class {
        LowFrequency => dice.magnitude(1e3, 1e4),
        HighFrequency => dice.magnitude(2e5, 1e6),
        _ => 40e3,
    };
    let wavelength = 343.2 / frequency;
    let radius = match class {
        WideElements => wavelength * dice.magnitude(0.8, 12.0),
        _ => wavelength * dice.between(0.1, 0.8),
    };
    let pitch = match class {
        HugePitch => dice.magnitude(0.05, 2.0),
        _ => (2.1 * radius).max(0.5 * wavelength) * dice.between(1.0, 1.4),
    };
    let array =
        Array { rows, columns, pitch, element_radius: radius, frequency, element, ..Array::default() };
    let array = Array {
        element_size: DVec2::new(2.0, dice.between(0.5, 2.0)) * radius,
        element_exponent: dice.one_of(&[0.0, 1.0, 2.0, 3.0, 0.7, 12.5]),
        directivity: Some("measured.csv".to_owned()),
        measured: evaluators::measured(),
        ..array
    };
    let half = 0.5 * pitch * DVec2::new(f64::from(columns), f64::from(rows));
    let aside =
        |dice: &mut Dice, part: f64| half * DVec2::new(dice.between(-part, part), dice.between(-part, part));
    let high = match class {
        Close => dice.magnitude(0.02, 2.0) * wavelength,
        Edges => dice.between(-0.5, 0.5) * wavelength,
        Far => dice.magnitude(1.0, 90.0),
        _ => dice.magnitude(1.5, 60.0) * wavelength,
    };
    let mut centre = aside(dice, 1.5).extend(high.clamp(-90.0, 90.0));
    if class == Far && dice.of(0.7) {
        centre = centre.with_x(dice.between(-90.0, 90.0)).with_y(dice.between(-90.0, 90.0));
    }
    centre = centre.clamp(DVec3::splat(-99.0), DVec3::splat(99.0));
    let number = |dice: &mut Dice| dice.between(-1.0, 1.0);
    let vector = |dice: &mut Dice| DVec3::new(number(dice), number(dice), number(dice));
    let (x_axis, y_axis) = match class {
        Tilted | Edges => (vector(dice), vector(dice)),
        Grazing => (DVec3::X, DVec3::new(number(dice) * 0.02, number(dice) * 0.02, 1.0)),
        _ if dice.of(0.2) => (DVec3::X, DVec3::Z),
        _ if dice.of(0.2) => (vector(dice).with_z(0.0), vector(dice).with_z(0.0)),
        _ => (DVec3::X, DVec3::Y),
    };
    let side = |dice: &mut Dice| match class {
        Tiny => dice.magnitude(1e-4, 0.3) * wavelength,
        Far => dice.magnitude(1.0, 2000.0) * wavelength,
        HugePitch => dice.magnitude(0.5, 100.0) * wavelength,
        _ => dice.magnitude(0.5, 20.0) * wavelength,
    };
    let mut size = DVec2::new(side(dice), side(dice)).min(DVec2::splat(90.0)).max(DVec2::splat(1e-6));
    if class == Grazing {
        // The lowest row touches the array.
        size.y = 2.0 * centre.z * dice.between(0.8, 1.1);
    }
    let plane = Plane { centre, x_axis, y_axis, size: size.min(DVec2::splat(99.0)), tolerance: 0.0 };
    let plane =
        if plane.axes().is_some() { plane } else { Plane { x_axis: DVec3::X, y_axis: DVec3::Y, ..plane } };
    Scene { array, plane, ..Scene::default() }
}

/// Focused on the plane, irregular, or with elements that cancel there.
fn drive(class: Class, scene: &Scene, dice: &mut Dice) -> Drive {
    use Class::*;
    let aperture = Aperture::new(scene);
    let wave = aperture.element.wavenumber;
    let focus = scene.plane.centre;
    let phases = aperture.positions.iter().enumerate().map(|(n, at)| match class {
        Nulls => {
            // One half of the elements against the other, seen from the plane's centre.
            let own = wave * focus.distance(*at);
            own + if n % 2 == 0 { 0.0 } else { PI }
        }
        _ if n == 0 || dice.of(0.001) => dice.between(-PI, PI),
        _ => wave * focus.distance(*at),
    });
    let mut phases: Vec<f64> = phases.map(|phase| (phase / TAU).fract() * TAU).collect();
    if dice.of(0.4) && class != Nulls {
        phases = phases.iter().map(|_| dice.between(-PI, PI)).collect();
    }
    let amplitudes = phases.iter().map(|_| if dice.of(0.1) { dice.unit() } else { 1.0 }).collect();
    Drive { amplitudes, phases }
}

/// The errors of one map by one evaluator, relative to its peak or to a larger pixel itself.
struct Reached {
    wanted: f64,
    truly: f64,
    said: f64,
    by: String,
}

/// The rounding error of the model's own differences, where squares almost cancel: f64 rounds the phase of a long path.
fn judge(request: &Request, pixels: &[(f64, f64)]) -> f64 {
    const HAIR: f64 = 1e-4 * TAU;
    let Request { aperture, air, plane, quantity, .. } = request;
    if *quantity != Quantity::Radiation {
        return 0.0;
    }
    let way = plane.centre.length() + plane.size.length();
    let loudest = pixels.iter().map(|pixel| pixel.1).fold(0.0, f64::max);
    let rounded = 2.0 * f64::EPSILON * aperture.element.wavenumber * way / HAIR;
    rounded * 2.0 * loudest * loudest / (air.density * air.sound_speed.powi(2))
}

fn reached(stages: &mut Stages, case: &Case, expected: &(Vec<(f64, f64)>, f64), tolerance: f64) -> Reached {
    let mut request = case.request.clone();
    request.plane.tolerance = tolerance;
    let map = stages.map(&request).unwrap();
    let (pixels, peak) = expected;
    // Pixels next to elements do not count for the peak, and their errors are relative to themselves.
    let peak = if map.near > 0 { f64::from(map.peak) } else { *peak };
    let is_of_pressure = request.quantity.declaration().norm == Norm::Pressure;
    let off = |(&got, &(value, modulus)): (&f32, &(f64, f64))| {
        let got = f64::from(got);
        let own = if is_of_pressure { modulus } else { value.abs() };
        let off = if request.quantity == Quantity::Phase {
            modulus * (Complex64::cis(got) - Complex64::cis(value)).norm()
        } else {
            (got - value).abs()
        };
        // `max` ignores NaN.
        if off.is_nan() { f64::INFINITY } else { off * (peak / own).min(1.0) }
    };
    let off = map.values.iter().zip(pixels).map(off).fold(0.0, f64::max);
    // f32 has no smaller squares.
    let truly = if peak < FAINTEST { 0.0 } else { off / peak };
    let wanted = if tolerance == 0.0 { EXACT } else { tolerance } + judge(&request, pixels) / peak;
    Reached { wanted, truly, said: map.error, by: format!("{:?}", map.by) }
}

/// Distant planes at high frequencies, slow media and distant points: in f32 they would be off by 10 % to a factor of
/// 1e8.
#[test]
fn exact_maps_and_points_are_right_beyond_the_range_of_f32() {
    let array =
        Array { rows: 4, columns: 4, frequency: 1e6, element_radius: 1e-4, pitch: 2e-3, ..Array::default() };
    let far = |at: DVec3| Plane { centre: at, size: DVec2::splat(0.5), tolerance: 0.0, ..Plane::default() };
    let medium = |sound_speed| Medium { sound_speed, absorption: Some(0.0), ..Medium::default() };
    let scene = |array: Array, at: DVec3, sound_speed| Scene {
        medium: medium(sound_speed),
        array,
        plane: far(at),
        ..Scene::default()
    };
    let scenes = [
        scene(array.clone(), DVec3::new(40.0, -60.0, 60.0), None),
        scene(Array { frequency: 2e5, ..array.clone() }, DVec3::new(1.4, -1.4, 1.4), None),
        scene(Array { element: ElementModel::Point, frequency: 4e4, ..array }, DVec3::Z, Some(1.0)),
    ];
    for scene in scenes {
        check(&scene).unwrap();
        let aperture = Aperture::new(&scene);
        let drive = scattered(16, STEP);
        let size = (40, 30);
        let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
        let truth = |samples: &Samples| reference::pressure(&aperture, &drive, samples);
        let expected = truth(&pixels);
        let peak = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
        for evaluator in fast_evaluators() {
            for beyond in [DVec3::new(2e5, 3e4, 1e5), DVec3::new(-9e5, 9e5, 3.0), DVec3::new(30.0, 0.0, 20.0)]
            {
                let samples = Samples::at(vec![beyond]);
                let got = evaluator.pressure(&aperture, &drive, &samples).unwrap()[0];
                let expected = truth(&samples)[0];
                let off = (Complex64::new(got.re.into(), got.im.into()) - expected).norm();
                assert!(off <= EXACT * expected.norm(), "{beyond}: {got}, not {expected}");
            }
            let request = Request::new(&scene, vec![drive.clone()], Quantity::Instantaneous, size);
            let map = Stages::new(evaluator).map(&request).unwrap().clone();
            let off = map.values.iter().zip(&expected).map(|(&got, p)| (f64::from(got) - p.re).abs());
            let off = off.fold(0.0, f64::max) / peak;
            assert!(off <= EXACT && map.error <= EXACT, "{off:e}, stated {:e} by {:?}", map.error, map.by);
        }
    }
}

/// The peak is 0: the relative error must not become NaN.
#[test]
fn a_silent_map_has_no_error() {
    let mut scene = Scene::default();
    scene.medium.absorption = Some(1e3);
    scene.plane.centre = DVec3::new(0.0, 0.0, 90.0);
    for evaluator in evaluators() {
        let request = Request::new(&scene, vec![scattered(256, STEP)], Quantity::Rms, (20, 20));
        let mut stages = Stages::new(evaluator);
        let map = stages.map(&request).unwrap();
        assert_eq!((map.peak, map.error), (0.0, 0.0), "{:?}", map.by);
    }
}

/// The maps named by a variable, or the first `count`.
pub fn numbers(variable: &str, count: usize) -> Range<usize> {
    let Ok(named) = std::env::var(variable) else { return 0..count };
    let number =
        |text: &str| text.parse::<usize>().expect("a variable of maps is a number or a range, 40..50");
    match named.split_once("..") {
        Some((first, end)) => number(first)..number(end),
        None => number(&named)..number(&named) + 1,
    }
}

#[test]
fn the_largest_error_of_all_pixels_is_within_the_tolerance() {
    let numbers = numbers("SONOGLYPH_MAPS", MAPS);
    let next = AtomicUsize::new(numbers.start);
    let all = Mutex::new(BTreeMap::<_, Vec<(f64, f64)>>::new());
    let failures = Mutex::new(Vec::new());
    let work = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| {
            let mut evaluators = vec![Stages::new(Evaluator::Cpu), Stages::new(Evaluator::Reference)];
            evaluators.extend(gpu().map(|gpu| Stages::new(Evaluator::Gpu(Box::new(gpu)))));
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= numbers.end {
                    return;
                }
                let case = Case::new(number);
                let expected = case.expected();
                let tolerance = match case.tolerance {
                    Tolerance::Given(tolerance) => tolerance,
                    Tolerance::Exact => 0.0,
                    Tolerance::Tuned(factor) => {
                        let f32 = reached(&mut evaluators[0], &case, &expected, 0.0).truly;
                        (factor * f32).clamp(2e-6, 1.0)
                    }
                };
                for (index, stages) in evaluators.iter_mut().enumerate() {
                    let got = reached(stages, &case, &expected, tolerance);
                    let Reached { wanted, truly, said, ref by } = got;
                    let key = (case.class, by.clone(), index);
                    all.lock().unwrap().entry(key).or_default().push((truly / wanted, truly / said.max(1e-300)));
                    let is_tuned = matches!(case.tolerance, Tolerance::Tuned(_));
                    if truly > wanted && !(is_tuned && said > wanted) {
                        let line = format!(
                            "{number} {:?} {:?} {:?} {:?} of {} {by} {:?}: {truly:.2e} of {wanted:.2e}, said {said:.2e}",
                            case.class,
                            case.scene.array.element,
                            case.tolerance,
                            case.request.quantity,
                            case.request.drives.len(),
                            case.request.size
                        );
                        eprintln!("{line}");
                        failures.lock().unwrap().push((number, line));
                    }
                }
            }
        });
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    for (key, ratios) in all.into_inner().unwrap() {
        let worst = |of: fn(&(f64, f64)) -> f64| ratios.iter().map(of).fold(0.0, f64::max);
        println!(
            "{key:?}: {} maps, true/tolerance {:.2}, true/stated {:.2}",
            ratios.len(),
            worst(|r| r.0),
            worst(|r| r.1)
        );
    }
    let mut failures = failures.into_inner().unwrap();
    failures.sort();
    for (number, line) in failures.iter().take(2) {
        println!("# {line}\n{}", file::write(&Case::new(*number).scene));
    }
    let lines: Vec<_> = failures.into_iter().map(|(_, line)| line).collect();
    assert!(lines.is_empty(), "{} maps exceed their tolerance\n{}", lines.len(), lines.join("\n"));
}
