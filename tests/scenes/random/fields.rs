//! What holds of every field: both evaluators are right, sums are linear, and neither mirrors nor shifts change anything.

use std::f64::consts::{FRAC_PI_2, SQRT_2, TAU};

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::{Aperture, Element};
use sonoglyph::drive::Drive;
use sonoglyph::field::plan::Costs;
use sonoglyph::field::{
    By, Map, Plan, Quantity, Request, Samples, Sources, Stages, cpu, promised, reference,
};
use sonoglyph::scene::{ElementModel, Plane, Scene};
use sonoglyph::simd::Isa;

use crate::dice::Dice;
use crate::random::oracle::{NEAREST, Oracle};
use crate::random::solving::{DISK, Moved, Solved, rounding};
use crate::random::tally::{count, within};

/// Pixels of a map that are compared with the reference, the loudest besides, and those of them also with the oracle.
const COMPARED: usize = 20;
const BY_ORACLE: usize = 3;
/// What the oracle's slopes are off, of what would arrive if no waves cancelled: 7e-6 where waves are plane, and more near sources.
const OF_SLOPES: f64 = 5e-5;
/// Radii of an element per distance: of a far field that is nearer, the oracle's differences are too coarse.
pub const WIDEST: f64 = 0.3;
/// Pa, m/s or W/m², below which squares are less than f32 can hold.
const FAINTEST: f64 = 1e-18;
/// Pa, above which squares of what it moves may be more than f32 can hold.
const LOUDEST: f64 = 1e7;
/// What f32 leaves of a number: 2⁻²⁴.
const F32: f64 = 6e-8;

/// The evaluators of one thread, each with what it made for the scene before.
#[derive(Debug)]
pub struct Evaluators {
    pub cpu: Stages,
    pub gpu: Option<Stages>,
}

/// What the polynomials of f32 are off, of what elements would send that send as much to all sides, and what the 64 nodes of the
/// exact piston leave out.
pub const POLYNOMIALS: f64 = 5e-6;

/// Relative to the sum of moduli, what f32 leaves of the sum at a point besides: thirty-two roundings of the way across, in turns, the
/// way from the origin included since places are rounded too; and of the exact piston's terms eight roundings, each as many times as
/// large as their sum as the way across is wider than the disk.
pub fn f32_rounding(solved: &Solved, point: DVec3) -> f64 {
    let Solved { scene, oracle, .. } = solved;
    let across = oracle.across(point) / oracle.wavelength();
    let deep = if oracle.height(point) < 2.0 * oracle.wavelength() { 3.0 } else { 1.0 };
    let disk = match scene.array.element {
        ElementModel::ExactPiston => across * oracle.wavelength() / scene.array.element_radius,
        ElementModel::Piston
        | ElementModel::Point
        | ElementModel::Rectangle
        | ElementModel::Cosine
        | ElementModel::Measured => 0.0,
    };
    deep * (32.0 * F32 * TAU * (across + 1.0) + 8.0 * F32 * disk)
}

/// Pa, what an f32 evaluator may be off at a point.
pub fn f32_error(solved: &Solved, drive: &Drive, point: DVec3) -> f64 {
    f32_rounding(solved, point) * moduli(solved, drive, point)
        + POLYNOMIALS * undirected(solved, drive, point)
}

/// Σ |H u| at a point.
pub fn moduli(solved: &Solved, drive: &Drive, point: DVec3) -> f64 {
    let transfer = solved.aperture.transfer(&[point]);
    let u = drive.excitation(&solved.aperture.driven);
    transfer.row(0).zip(u).map(|(h, u)| (h * u).norm()).sum()
}

/// The same of elements that send to all sides what they send straight ahead. Where far fields have their nulls, and of large elements
/// nearly everywhere, that is much more, and a directivity in f32 is as far off as where it is 1.
fn undirected(solved: &Solved, drive: &Drive, point: DVec3) -> f64 {
    let Solved { scene, aperture, .. } = solved;
    let ahead = match scene.array.element {
        ElementModel::Piston | ElementModel::Rectangle | ElementModel::Cosine | ElementModel::Measured => {
            let element = Element { model: ElementModel::Point, ..aperture.element };
            Aperture { element, ..aperture.clone() }
        }
        ElementModel::Point | ElementModel::ExactPiston => aperture.clone(),
    };
    let u = drive.excitation(&ahead.driven);
    ahead.transfer(&[point]).row(0).zip(u).map(|(h, u)| (h * u).norm()).sum()
}

fn wide(p: Complex32) -> Complex64 {
    Complex64::new(p.re.into(), p.im.into())
}

/// The map of a drive on the scene's plane, by one evaluator, against f64; its pixels, and how far each may be off (Pa).
fn map(
    stages: &mut Stages,
    solved: &Solved,
    drive: &Drive,
    (width, height): (usize, usize),
    dice: &mut Dice,
) -> (Vec<Complex32>, By) {
    let Solved { scene, aperture, .. } = solved;
    // Of a wave Re{P e^{jωt}}: Re P at the moment 0, and Im P a quarter of a period before it.
    let request = Request::new(scene, vec![drive.clone()], Quantity::Instantaneous, (width, height));
    let map = stages.map(&request).unwrap().clone();
    let before = stages.map(&Request { moment: -FRAC_PI_2, ..request }).unwrap();
    assert_eq!((before.by, before.peak), (map.by, map.peak), "a moment decides on nothing");
    let field: Vec<_> =
        map.values.iter().zip(&before.values).map(|(&re, &im)| Complex32::new(re, im)).collect();
    assert_eq!(field.len(), width * height);
    assert!(field.iter().all(|p| p.is_finite()), "{map:?}");
    let loudest = (0..field.len()).max_by(|&a, &b| field[a].norm().total_cmp(&field[b].norm())).unwrap();
    let peak = f64::from(field[loudest].norm());
    within("loudest pixel of a map", (f64::from(map.loudest) - peak).abs(), 1e-6 * peak + FAINTEST);
    // A silent map has the peak 0, and others that of its pixels away from elements.
    assert!(map.peak == map.loudest || map.near > 0 || f64::from(map.loudest) <= map.rounding, "{map:?}");
    let peak = f64::from(map.peak);

    count_fallbacks(solved, &map);

    let pixels = Samples::on_plane(&scene.plane, width, height).unwrap();
    let chosen: Vec<_> = std::iter::once(loudest)
        .chain((1..COMPARED).map(|_| dice.whole(0, field.len() as u32 - 1) as usize))
        .collect();
    let points: Vec<_> = chosen.iter().map(|&pixel| pixels.point(pixel)).collect();
    let expected = reference::pressure(aperture, drive, &Samples::at(points.clone()));
    for (&pixel, expected) in chosen.iter().zip(&expected) {
        let off = (wide(field[pixel]) - expected).norm();
        let most = match map.by {
            // f64, made f32 in the end.
            By::Reference => 2.0 * F32 * expected.norm(),
            By::Cpu | By::CpuInF64 | By::Gpu => {
                (promised(scene.plane.tolerance) + 4.0 * F32) * peak.max(expected.norm())
            }
        };
        within(&format!("map by {:?}", map.by), off, most + map.rounding + 1e-36);
    }
    for (&point, expected) in points.iter().zip(&expected).take(BY_ORACLE) {
        reference_is_the_model(solved, drive, point, *expected);
    }
    (field, map.by)
}

/// Maps whose first attempt missed the tolerance: right in the end, however wrong that attempt was.
fn count_fallbacks(Solved { scene, aperture, .. }: &Solved, map: &Map) {
    let plan = Plan::new(aperture, &scene.plane, Costs::CPU);
    if plan.is_none_or(|plan| plan.double) {
        return;
    }
    count("maps planned in f32");
    if map.by == By::CpuInF64 {
        count("maps in f64 after f32");
    }
    if map.how.contains("samples do not keep the tolerance") {
        count("maps at every pixel after samples");
    }
}

fn reference_is_the_model(solved: &Solved, drive: &Drive, point: DVec3, got: Complex64) {
    let Solved { scene, oracle, .. } = solved;
    if (oracle.height(point) - NEAREST).abs() < 1e-12 {
        return;
    }
    let Some((expected, moduli)) = oracle.pressure(drive, point) else { return };
    let exact = scene.array.element == ElementModel::ExactPiston;
    let distance = point.length() + oracle.reach;
    let rounding = if exact { DISK } else { rounding(oracle, distance) };
    within("the f64 reference", (expected - got).norm(), rounding * moduli + f64::MIN_POSITIVE);
}

/// Maps of velocity and intensity against differences of the oracle's pressure.
fn flow_is_the_models(stages: &mut Stages, solved: &Solved, size: (usize, usize), dice: &mut Dice) {
    let Solved { scene, oracle, solution, .. } = solved;
    let drive = &solution.drive;
    let (x, y) = scene.plane.axes().unwrap();
    // Only one of them in every scene: each needs slopes.
    let is_velocity = dice.of(0.5);
    let quantity = if is_velocity { Quantity::Velocity } else { Quantity::Intensity };
    let map = stages.map(&Request::new(scene, vec![drive.clone()], quantity, size)).unwrap();
    assert!(map.values.iter().all(|value| value.is_finite() && *value >= 0.0), "{map:?}");
    let largest = (0..map.values.len()).max_by(|&a, &b| map.values[a].total_cmp(&map.values[b])).unwrap();
    assert_eq!(map.loudest, map.values[largest], "{quantity:?}");
    count(&format!("{} by {:?}", quantity.declaration().words, map.by));
    let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
    let impedance = oracle.density * oracle.sound_speed;
    let chosen = (1..BY_ORACLE).map(|_| dice.whole(0, map.values.len() as u32 - 1) as usize);
    for pixel in std::iter::once(largest).chain(chosen) {
        let point = pixels.point(pixel);
        let height = oracle.height(point);
        let is_far_field = matches!(scene.array.element, ElementModel::Piston | ElementModel::Rectangle);
        let is_wide = is_far_field && oracle.radius > WIDEST * height;
        if height < 0.5 * oracle.wavelength() || is_wide {
            continue;
        }
        let arriving = moduli(solved, drive, point);
        let (expected, all) = if is_velocity {
            (oracle.rms_velocity(drive, point, x.cross(y)), arriving / impedance / SQRT_2)
        } else {
            (oracle.intensity(drive, point), arriving * arriving / impedance)
        };
        let Some(expected) = expected else { continue };
        let off = (f64::from(map.values[pixel]) - expected).abs();
        let most = promised(scene.plane.tolerance) * f64::from(map.peak).max(expected)
            + (OF_SLOPES + f32_rounding(solved, point)) * all;
        within(&format!("{} by {:?}", quantity.declaration().name, map.by), off, most + FAINTEST);
    }
}

/// Every invariant of the field of a solved scene; the largest |P| (Pa) on its plane.
pub fn hold(evaluators: &mut Evaluators, solved: &Solved, dice: &mut Dice) -> f64 {
    let Solved { solution, .. } = solved;
    let size = (dice.whole(1, 40) as usize, dice.whole(1, 40) as usize);
    let (by_cpu, by) = map(&mut evaluators.cpu, solved, &solution.drive, size, dice);
    count(&format!("maps by {by:?}, asked of the CPU"));
    if let Some(gpu) = &mut evaluators.gpu {
        let (_, by) = map(gpu, solved, &solution.drive, size, dice);
        count(&format!("maps by {by:?}, asked of the GPU"));
    }
    let peak = by_cpu.iter().map(|p| f64::from(p.norm())).fold(0.0, f64::max);
    if peak > LOUDEST {
        count("flow left out: too loud for squares in f32");
    } else {
        flow_is_the_models(&mut evaluators.cpu, solved, size, dice);
        if let Some(gpu) = &mut evaluators.gpu {
            flow_is_the_models(gpu, solved, size, dice);
        }
    }
    let points = places(solved, dice);
    sums_are_linear(evaluators, solved, &points, dice);
    a_turn_changes_no_modulus(evaluators, solved, &by_cpu, size, dice);
    elements_and_points_change_places(solved, dice);
    peak
}

/// On the plane and off it, and in the plane of no element.
fn places(Solved { scene, oracle, .. }: &Solved, dice: &mut Dice) -> Vec<DVec3> {
    let Plane { centre, size, .. } = &scene.plane;
    let mut place = || {
        let at = DVec3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-1.0, 1.0));
        let at = *centre + at * size.max_element();
        if scene.is_home() { at.with_z(at.z.abs().max(10.0 * NEAREST)) } else { at }
    };
    let mut off_all_faces = || (0..100).map(|_| place()).find(|&at| oracle.height(at) > 9.0 * NEAREST);
    (0..17).filter_map(|_| off_all_faces()).collect()
}

fn any_drive(elements: usize, dice: &mut Dice) -> Drive {
    Drive {
        amplitudes: (0..elements).map(|_| dice.unit()).collect(),
        phases: (0..elements).map(|_| dice.between(-TAU / 2.0, TAU / 2.0)).collect(),
    }
}

/// The pressures of a drive by every evaluator in f32, without the fallback to f64, which would hide its errors.
fn in_f32(
    evaluators: &Evaluators,
    aperture: &Aperture,
    drive: &Drive,
    samples: &Samples,
    isa: Isa,
) -> Vec<(&'static str, Vec<Complex32>)> {
    let Some(faces) = Sources::of_faces(aperture, drive, samples) else { return Vec::new() };
    count("points in f32");
    let gpu = evaluators.gpu.as_ref().and_then(Stages::gpu);
    let gpu = gpu.filter(|_| faces.iter().all(Sources::has_no_sample_beside_rims));
    let by_gpu = gpu.map(|gpu| ("GPU", gpu.pressure(&faces).unwrap()));
    [("CPU", cpu::pressure_with(isa, &faces, samples.len()))].into_iter().chain(by_gpu).collect()
}

/// The field of a u + b v is a times that of u and b times that of v, in f64 and in f32.
fn sums_are_linear(evaluators: &Evaluators, solved: &Solved, points: &[DVec3], dice: &mut Dice) {
    let Solved { aperture, oracle, solution, .. } = solved;
    let all: Vec<_> = (0..aperture.positions.len()).collect();
    let (u, v) = (&solution.drive, any_drive(all.len(), dice));
    let (a, b) = (
        Complex64::from_polar(0.6, dice.between(0.0, TAU)),
        Complex64::from_polar(0.4, dice.between(0.0, TAU)),
    );
    let mixed: Vec<_> =
        u.excitation(&all).iter().zip(v.excitation(&all)).map(|(u, v)| a * u + b * v).collect();
    let mixed = Drive::of(all.len(), &all, &mixed);
    let samples = Samples::at(points.to_vec());
    let of = |drive: &Drive| reference::pressure(aperture, drive, &samples);
    let (of_u, of_v, of_mixed) = (of(u), of(&v), of(&mixed));
    let isa = dice.one_of(&Isa::available());
    let [u_in_f32, v_in_f32, mixed_in_f32] =
        [u, &v, &mixed].map(|drive| in_f32(evaluators, aperture, drive, &samples, isa));
    for (i, &point) in points.iter().enumerate() {
        let scale = [u, &v].map(|drive| moduli(solved, drive, point)).iter().sum::<f64>();
        let in_f32 = [u, &v].map(|drive| f32_error(solved, drive, point)).iter().sum::<f64>();
        let off = (a * of_u[i] + b * of_v[i] - of_mixed[i]).norm();
        within("linear, in f64", off, rounding(oracle, 0.0) * scale + f64::MIN_POSITIVE);
        let most = in_f32 + 1e-37;
        for (((by, u), (_, v)), (_, mixed)) in u_in_f32.iter().zip(&v_in_f32).zip(&mixed_in_f32) {
            let [u, v, mixed] = [u, v, mixed].map(|field| wide(field[i]));
            within(&format!("linear, by the {by}"), (a * u + b * v - mixed).norm(), most);
            within(&format!("a point by the {by}"), (mixed - of_mixed[i]).norm(), most);
        }
    }
}

fn turned(drive: &Drive, angle: f64) -> Drive {
    let turn = |phase: &f64| {
        let turns = (phase + angle) / TAU;
        TAU * (turns - turns.round())
    };
    Drive { amplitudes: drive.amplitudes.clone(), phases: drive.phases.iter().map(turn).collect() }
}

fn a_turn_changes_no_modulus(
    evaluators: &mut Evaluators,
    solved: &Solved,
    before: &[Complex32],
    (width, height): (usize, usize),
    dice: &mut Dice,
) {
    let Solved { scene, solution, .. } = solved;
    let drive = turned(&solution.drive, dice.between(0.0, TAU));
    let map = |stages: &mut Stages, drive| {
        let request = Request::new(scene, vec![drive], Quantity::Rms, (width, height));
        stages.map(&request).unwrap().clone()
    };
    let unturned = map(&mut evaluators.cpu, solution.drive.clone());
    let after = map(&mut evaluators.cpu, drive);
    // An error at the limit is mended for one of them alone.
    let alike = (unturned.by, &unturned.how) == (after.by, &after.how);
    let mended = if alike { 0.0 } else { 2.0 * promised(scene.plane.tolerance) };
    let pixels = Samples::on_plane(&scene.plane, width, height).unwrap();
    let peak = before.iter().map(|p| p.norm()).fold(0.0, f32::max);
    for _ in 0..6 {
        let pixel = dice.whole(0, before.len() as u32 - 1) as usize;
        let off = (f64::from(before[pixel].norm()) - SQRT_2 * f64::from(after.values[pixel])).abs();
        let point = pixels.point(pixel);
        let in_f32 = f32_error(solved, &solution.drive, point);
        // Interpolation is linear: a turn turns its error too.
        within("a turn of all phases", off, 2.0 * in_f32 + (2e-6 + mended) * f64::from(peak) + FAINTEST);
    }
}

/// A piston is the same all round: from element n to the place above element m it is as far, and as steep, as from m to the place
/// above n. That source and receiver at any two places may be exchanged holds of points alone: a piston's directivity stays behind.
fn elements_and_points_change_places(solved: &Solved, dice: &mut Dice) {
    let Solved { scene, aperture, oracle, .. } = solved;
    let element = |dice: &mut Dice| {
        aperture.positions[dice.whole(0, aperture.positions.len() as u32 - 1) as usize].with_z(0.0)
    };
    let (n, m) = (element(dice), element(dice));
    let up = DVec3::Z * dice.magnitude(1e-4, 40.0 * oracle.wavelength().max(1e-4));
    let there = aperture.element.transfer(m - n + up);
    let back = aperture.element.transfer(n - m + up);
    let distance = n.distance(m) + up.z;
    within(
        "reciprocity",
        (there - back).norm(),
        rounding(oracle, distance) * there.norm() + f64::MIN_POSITIVE,
    );
    if scene.array.element == ElementModel::Point {
        // At the same distance in any other direction.
        let distance = (m - n + up).length();
        let aside = DVec3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(0.1, 1.0));
        let elsewhere = aperture.element.transfer(aside.normalize_or(DVec3::Z) * distance);
        let most = rounding(oracle, distance) * there.norm() + f64::MIN_POSITIVE;
        if distance * 0.05 > NEAREST {
            within("reciprocity of points", (there - elsewhere).norm(), most);
        }
    }
}

/// The moved drive of the moved array makes the same field at the moved places, in f64 and on a map.
pub fn moves_change_no_field(evaluators: &mut Evaluators, solved: &Solved, moved: &Moved, dice: &mut Dice) {
    let Solved { scene, aperture, oracle, solution } = solved;
    let plane = Plane {
        centre: (moved.place)(scene.plane.centre),
        x_axis: (moved.direction)(scene.plane.x_axis),
        y_axis: (moved.direction)(scene.plane.y_axis),
        ..scene.plane.clone()
    };
    let drive = moved.drive(&solution.drive);
    let other = Solved {
        aperture: Aperture::new(&moved.scene),
        oracle: Oracle::new(&moved.scene),
        scene: Scene { plane, ..moved.scene.clone() },
        solution: solution.clone(),
    };
    let points = places(solved, dice);
    let there: Vec<_> = points.iter().map(|&point| (moved.place)(point)).collect();
    let before = reference::pressure(aperture, &solution.drive, &Samples::at(points.clone()));
    let after = reference::pressure(&other.aperture, &drive, &Samples::at(there));
    for ((&point, before), after) in points.iter().zip(&before).zip(&after) {
        let distance = point.length() + oracle.reach;
        let most = rounding(oracle, 4.0 * distance) * moduli(solved, &solution.drive, point);
        within("moved, in f64", (before - after).norm(), most + f64::MIN_POSITIVE);
    }
    let size = (dice.whole(1, 30) as usize, dice.whole(1, 30) as usize);
    map(&mut evaluators.cpu, &other, &drive, size, dice);
}
