//! The promise of means: every pixel of a map of several drives is within the tolerance and within the stated error,
//! also where all drives are silent at one place.
//!
//! Random maps with null rings of wide pistons, common nodes and vortices, against f64 at every pixel.
//! `SONOGLYPH_MEANS=0..5000` selects maps.

use std::f64::consts::{PI, TAU};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::plan::promised;
use sonoglyph::field::sound::{Constants, PRESSURE, Sound};
use sonoglyph::field::{By, Evaluator, Quantity, Request, Samples, Stages, reference};
use sonoglyph::scene::{Array, Board, ElementModel, Plane, Reflector, Scene};

use crate::dice::Dice;
use crate::evaluators;
use crate::truth::numbers;

const SEED: u64 = 0x5eed;
/// Maps of a default run, one in eight of them by the reference, too.
const MAPS: usize = 240;
const BY_REFERENCE: usize = 8;

fn scene(number: usize, dice: &mut Dice) -> Scene {
    let class = number % 8;
    let element = match class {
        0 | 1 => ElementModel::Piston,
        _ => dice.one_of(&[
            ElementModel::Piston,
            ElementModel::Piston,
            ElementModel::Point,
            ElementModel::ExactPiston,
        ]),
    };
    let frequency = if dice.of(0.7) { 40e3 } else { dice.magnitude(2e4, 2e5) };
    let wavelength = 343.2 / frequency;
    let most = if element == ElementModel::ExactPiston { 3 } else { 12 };
    let (rows, columns) = match class {
        0 => (1, 1),
        1 => (dice.whole(1, 3), dice.whole(1, 3)),
        _ => (dice.whole(1, most), dice.whole(2, most)),
    };
    let radius = wavelength * if class < 2 { dice.between(0.8, 4.0) } else { dice.between(0.2, 0.7) };
    let pitch = (2.1 * radius).max(0.5 * wavelength) * dice.between(1.0, 1.3);
    let array =
        Array { rows, columns, pitch, element_radius: radius, frequency, element, ..Array::default() };
    let high = wavelength * dice.magnitude(1.5, 40.0);
    let half = 0.5 * pitch * DVec2::new(f64::from(columns), f64::from(rows));
    let centre = (half * DVec2::new(dice.between(-1.5, 1.5), dice.between(-1.5, 1.5))).extend(high);
    let vector =
        |dice: &mut Dice| DVec3::from_array([(); 3].map(|()| dice.between(-1.0, 1.0))).normalize_or(DVec3::X);
    let (x_axis, y_axis) = match dice.whole(0, 5) {
        0 => (vector(dice), vector(dice)),
        1 => (DVec3::X, DVec3::Z),
        _ => (DVec3::X, DVec3::Y),
    };
    let size = wavelength * DVec2::new(dice.magnitude(0.5, 25.0), dice.magnitude(0.5, 25.0));
    let tolerance = dice.one_of(&[1e-2, 1e-3, 1e-3, 3e-4, 1e-4, 1e-5, 0.0]);
    let plane = Plane { centre, x_axis, y_axis, size, tolerance };
    let mut boards = Vec::new();
    if class == 6 {
        let opposite = Board { at: DVec3::Z * high * 2.0, normal: DVec3::NEG_Z, ..Board::default() };
        boards = vec![Board::default(), opposite];
    }
    let mut reflectors = Vec::new();
    if class == 7 {
        let point = DVec3::Z * (high + size.length() * dice.between(0.5, 1.0));
        let coefficient = dice.one_of(&[1.0, -1.0, 0.5]);
        reflectors = vec![Reflector { point, normal: DVec3::NEG_Z, coefficient }];
    }
    Scene { array, plane, boards, reflectors, ..Scene::default() }
}

fn request(number: usize) -> Request {
    let mut dice = Dice::new(SEED, number);
    let scene = scene(number, &mut dice);
    let quantity = match dice.whole(0, 19) {
        _ if scene.array.element == ElementModel::ExactPiston => Quantity::Rms,
        0..=13 => Quantity::Rms,
        14 | 15 => Quantity::Velocity,
        16 | 17 => Quantity::Radiation,
        _ => Quantity::Intensity,
    };
    let aperture = Aperture::new(&scene);
    let Plane { centre, size, .. } = scene.plane;
    let (x, y) = scene.plane.axes().unwrap();
    let count = if dice.of(0.1) { dice.whole(6, 16) } else { dice.whole(2, 5) };
    let (kind, first_turn) = (dice.whole(0, 4), dice.between(0.0, TAU));
    let (wave, wavelength) = (aperture.element.wavenumber, aperture.wavelength());
    let drive = |frame: u32| {
        let turn = first_turn + TAU * f64::from(frame) / f64::from(count);
        let on_circle = centre + (x * turn.cos() + y * turn.sin()) * 0.3 * size.min_element().min(0.05);
        let above = centre + DVec3::Z * (0.25 * f64::from(frame) * wavelength);
        let phase = |at: &DVec3| match kind {
            0 | 1 => wave * on_circle.distance(*at),
            // Twin traps, all with the same node, and vortices with a common axis.
            2 => wave * above.distance(*at) + if at.x + 0.3 * at.y > 0.0 { 0.0 } else { PI },
            3 => wave * above.distance(*at) + (*at - centre).truncate().to_angle(),
            _ => dice.between(-PI, PI),
        };
        let phases: Vec<_> =
            aperture.positions.iter().map(phase).map(|phase| phase.rem_euclid(TAU)).collect();
        let amplitudes = phases.iter().map(|_| if dice.of(0.1) { dice.unit() } else { 1.0 }).collect();
        Drive { amplitudes, phases }
    };
    let drives = (0..count).map(drive).collect();
    let pixels = (dice.whole(20, 70) as usize, dice.whole(20, 70) as usize);
    Request::new(&scene, drives, quantity, pixels)
}

/// The value of every pixel in f64.
fn expected(request: &Request) -> Vec<f64> {
    let Request { aperture, air, plane, drives, quantity, size, part, .. } = request;
    let (x, y) = plane.axes().unwrap();
    let pixels = Samples::on_plane(plane, size.0, size.1).unwrap();
    let constants = Constants::new(air, aperture.element.wavenumber, 0.0);
    let declaration = quantity.declaration();
    let mut means = vec![[0.0; 3]; pixels.len()];
    for drive in drives.iter() {
        let sounds: Vec<Sound<f64>> = if declaration.parts == PRESSURE {
            let pressures = reference::pressure(aperture, drive, &pixels).into_iter();
            pressures.map(|p| Sound { p, ..Sound::default() }).collect()
        } else {
            let played = drive.excitation(&aperture.driven);
            let sound = |pixel: usize| {
                let at = pixels.point(pixel);
                let pressure = |offset: DVec3| aperture.pressures(&[at + offset], &played)[0];
                // Differences over thousandths of a wavelength: 1e-10 off.
                let step = 1e-3 * aperture.wavelength();
                let pair = |axis: DVec3, i: f64| pressure(axis * (i * step)) - pressure(-axis * (i * step));
                let along = |axis: DVec3| (8.0 * pair(axis, 1.0) - pair(axis, 2.0)) / (12.0 * step);
                Sound { p: pressure(DVec3::ZERO), x: along(x), y: along(y), n: along(x.cross(y)) }
            };
            (0..pixels.len()).map(sound).collect()
        };
        for (mean, sound) in means.iter_mut().zip(sounds) {
            // Of a vector the mean has the length.
            let own = match &declaration.flow {
                Some(flow) => (flow.exact)(sound, &constants),
                None => [(declaration.exact)(sound, &constants), 0.0, 0.0],
            };
            mean.iter_mut().zip(own).for_each(|(mean, own)| *mean += own / drives.len() as f64);
        }
    }
    let value = |mean: [f64; 3]| match declaration.flow {
        Some(_) => DVec3::from(mean).length(),
        None => mean[0],
    };
    means.into_iter().map(|mean| quantity.exact_value(part * value(mean))).collect()
}

#[test]
fn every_pixel_of_a_mean_is_within_its_stated_error() {
    let numbers = numbers("SONOGLYPH_MEANS", MAPS);
    let next = AtomicUsize::new(numbers.start);
    let all = Mutex::new(Vec::new());
    let work = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| {
            let mut evaluators = [Evaluator::Cpu, Evaluator::Reference].map(Stages::new);
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= numbers.end {
                    return;
                }
                let request = request(number);
                let expected = expected(&request);
                let peak = expected.iter().fold(0.0f64, |most, value| most.max(value.abs()));
                let count = if number.is_multiple_of(BY_REFERENCE) { 2 } else { 1 };
                for stages in &mut evaluators[..count] {
                    let map = stages.map(&request).unwrap();
                    let off = |(got, expected): (&f32, &f64)| (f64::from(*got) - expected).abs();
                    // `max` ignores NaN.
                    let off = map.values.iter().zip(&expected).map(off);
                    let off = off.fold(0.0, |most, off| if off <= most { most } else { off }) / peak;
                    let wanted = promised(request.plane.tolerance);
                    let is_right = off <= map.error && (off <= wanted || map.error > wanted);
                    let line = format!(
                        "{number} {:?} of {} {:?} {:?} {:e}: {off:.2e}, stated {:.2e} by {:?}, {}",
                        request.quantity,
                        request.drives.len(),
                        request.aperture.element.model,
                        request.size,
                        request.plane.tolerance,
                        map.error,
                        map.by,
                        map.how
                    );
                    all.lock().unwrap().push((
                        is_right,
                        off / wanted,
                        off / map.error,
                        map.error / wanted,
                        line,
                    ));
                }
            }
        });
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    let all = all.into_inner().unwrap();
    let worst = |of: fn(&(bool, f64, f64, f64, String)) -> f64| all.iter().map(of).fold(0.0, f64::max);
    println!("true/tolerance {:.2}, true/stated {:.2}", worst(|map| map.1), worst(|map| map.2));
    println!(
        "{} of {} state an error above their tolerance",
        all.iter().filter(|map| map.3 > 1.0).count(),
        all.len()
    );
    let wrong: Vec<_> = all.iter().filter(|map| !map.0).map(|map| &map.4[..]).collect();
    assert!(wrong.is_empty(), "{} maps\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_ring_where_all_drives_are_silent_is_not_zero() {
    const SIZE: (usize, usize) = (300, 300);
    let array = Array { rows: 1, columns: 1, element_radius: 0.014, ..Array::default() };
    let plane =
        Plane { centre: DVec3::new(0.012, 0.005, 0.03), size: DVec2::splat(0.06), ..Plane::default() };
    let drives: Vec<_> =
        (0..5).map(|n| Drive { amplitudes: vec![1.0], phases: vec![f64::from(n)] }).collect();
    let mut stages: Vec<_> = evaluators().into_iter().map(Stages::new).collect();
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 0.0] {
        let plane = Plane { tolerance, ..plane.clone() };
        let scene = Scene { array: array.clone(), plane, ..Scene::default() };
        let request = Request::new(&scene, drives.clone(), Quantity::Rms, SIZE);
        let expected = expected(&request);
        let peak = expected.iter().copied().fold(0.0, f64::max);
        for stages in &mut stages {
            let map = stages.map(&request).unwrap();
            let off = map.values.iter().zip(&expected).map(|(&got, value)| (f64::from(got) - value).abs());
            let off = off.fold(0.0, f64::max) / peak;
            let name = format!("{tolerance:e} by {:?}: {off:.2e} of {:.2e}, {}", map.by, map.error, map.how);
            assert!(off <= map.error && map.error <= promised(tolerance), "{name}");
            assert!(map.values.iter().all(|value| *value > 0.0), "{name}");
            let is_direct = tolerance == 0.0 || map.by == By::Reference;
            assert_eq!(map.evaluated == SIZE.0 * SIZE.1, is_direct, "{name}");
        }
    }
}
