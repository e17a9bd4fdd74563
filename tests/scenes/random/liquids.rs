//! What holds of every dent: it bears the radiation pressure, displaces what that weighs, and goes with the square of the drive.

use std::f64::consts::PI;

use glam::DVec3;
use sonoglyph::drive::Drive;
use sonoglyph::field::cells::Cells;
use sonoglyph::field::{By, Depression, FieldError, Quantity, Request, Samples, Stages};
use sonoglyph::scene::ElementModel;
use sonoglyph::surface::{Dent, Tank};

use crate::dice::Dice;
use crate::random::fields::{Evaluators, WIDEST, f32_error, moduli};
use crate::random::oracle::density_and_tension;
use crate::random::solving::Solved;
use crate::random::tally::{count, within};

/// Cells of a plane on which the radiation pressure of thousands of scenes is formed.
const MOST_CELLS: usize = 30_000;
const SIZE: (usize, usize) = (24, 18);
/// The finest tolerance of what is formed at cells.
const FINEST: f64 = 1e-6;

/// The depression of the scene's liquid, as it is asked for.
struct Asked<'a> {
    solved: &'a Solved,
    request: Request,
    /// Pa: what the two parts of the radiation pressure come to where they do not cancel. Along a beam, on a plane that sound only
    /// grazes, they do, and the tolerance is of them.
    parts: f64,
}

/// A pressed liquid, and who made its map.
struct Made {
    tank: Tank,
    /// Under the part of the pressure that the envelope leaves.
    dent: Dent,
    /// Its figures on the plane.
    depression: Depression,
    by: By,
    error: f64,
}

/// Pa, below which squares are less than f32 can hold.
const FAINTEST: f64 = 1e-14;

/// Every invariant of the radiation pressure and the dent on the scene's plane, on which the largest |P| is `peak` (Pa).
pub fn hold(evaluators: &mut Evaluators, solved: &Solved, peak: f64, dice: &mut Dice) {
    let scene = &solved.scene;
    if peak < FAINTEST {
        return count("averages left out: too faint for squares in f32");
    }
    let radius = solved.oracle.radius;
    if matches!(scene.array.element, ElementModel::Piston | ElementModel::Rectangle)
        && radius > WIDEST * solved.oracle.height(scene.plane.centre)
    {
        return count("averages left out: elements wider than they are far away");
    }
    let cells = Cells::new(&solved.aperture, &scene.plane, 0.0, FINEST);
    if cells.as_ref().is_some_and(|cells| cells.count() > MOST_CELLS) {
        return count("averages left out: more cells than there is time for");
    }
    let request = |quantity| Request::new(scene, vec![solved.solution.drive.clone()], quantity, SIZE);
    let (x, y) = scene.plane.axes().unwrap();
    let is_level = x.cross(y).z.abs() > 1.0 - 1e-9;
    let square = peak * peak / (solved.oracle.density * solved.oracle.sound_speed.powi(2));
    let parts = 2.0 * scene.modulation.mean_square() * square;
    let radiation = Asked { solved, request: request(Quantity::Radiation), parts };
    let at_cells = radiation_is_the_models(&mut evaluators.cpu, &radiation, [x, y], dice);
    if let Some(gpu) = evaluators.gpu.as_mut().filter(|_| !at_cells) {
        radiation_is_the_models(gpu, &radiation, [x, y], dice);
    }
    let dent = Asked { request: request(Quantity::Depression), ..radiation };
    if !is_level {
        assert_eq!(evaluators.cpu.map(&dent.request).err(), Some(FieldError::NotLevel));
        return count("radiation on tilted planes");
    }
    // Exact radiation pressures, and those that cells do not keep, are formed at the pixels, wherever the plane is.
    let refused = if at_cells { None } else { evaluators.cpu.map(&dent.request).err() };
    if let Some(refused) = refused {
        assert_eq!(refused == FieldError::TooManyCells, cells.is_none(), "{refused:?}");
        assert!(cells.is_none() || refused == FieldError::TooNear, "{refused:?}");
        return count("dents refused: radiation pressure is formed at the pixels");
    }
    let Some(made) = pressed(&mut evaluators.cpu, &dent) else {
        return count("dents refused: the plane is too near");
    };
    count("dents");
    it_displaces_what_the_pressure_weighs(solved, &made, 1e-9);
    it_bears_the_radiation_pressure(&dent, &made, [x, y], dice);
    // By turns.
    if dice.of(0.5) {
        return it_goes_with_the_square_of_the_drive(evaluators, &dent, &made);
    }
    if let Some(gpu) = &mut evaluators.gpu {
        let by_gpu = pressed(gpu, &dent).unwrap();
        it_displaces_what_the_pressure_weighs(solved, &by_gpu, 1e-5);
        let most = depth_error(&dent, &made);
        // Both are off; what depths on the whole surface are off is known from a few cells, and one scene in 10 000 is off a little more.
        within("a dent by stages with a GPU", furthest(&by_gpu, &made, 1.0), 2.2 * most);
        count(&format!("dents by {:?}, asked of the GPU", by_gpu.by));
    }
}

/// `None` where the plane is too near.
fn pressed(stages: &mut Stages, Asked { request, .. }: &Asked<'_>) -> Option<Made> {
    let map = match stages.map(request) {
        Err(FieldError::TooNear) => return None,
        other => other.unwrap(),
    };
    let (by, error) = (map.by, map.error);
    assert!(map.values.iter().all(|depth| depth.is_finite()), "{map:?}");
    let pressed = stages.pressed(request).unwrap();
    assert!(pressed.force.is_finite(), "{pressed:?}");
    let (tank, dent) = stages.surface(request).unwrap();
    let part = request.part;
    let dent = Dent {
        depth: dent.depth.iter().map(|depth| part * depth).collect(),
        volume: part * dent.volume,
        force: part * dent.force,
    };
    Some(Made { tank: tank.clone(), dent, depression: pressed.depression.unwrap(), by, error })
}

/// What the pressure (Pa) may be off: the tolerance, of its largest value, which the squares of pressure and slope make; and what f32
/// leaves of the squares. A map whose own error is more than the tolerance says so: where much is absorbed on the way across the
/// plane, what is sampled beside it is many times as loud.
fn pressure_error(solved: &Solved, error: f64, largest: f64, point: DVec3) -> f64 {
    let tolerance = solved.scene.plane.tolerance.max(FINEST);
    error.max(tolerance) * largest + square_error(solved, point)
}

/// What f32 leaves of the radiation pressure at a point (Pa): of a square twice what it leaves of its root, of two parts. Its root is
/// what arrives there, whatever of it cancels.
fn square_error(solved: &Solved, point: DVec3) -> f64 {
    let Solved { scene, oracle, solution, .. } = solved;
    let per_square = scene.modulation.mean_square() / (oracle.density * oracle.sound_speed.powi(2));
    let arriving = moduli(solved, &solution.drive, point);
    4.0 * per_square * arriving * f32_error(solved, &solution.drive, point) + 1e-37
}

/// Whether it was formed at cells.
fn radiation_is_the_models(
    stages: &mut Stages,
    asked: &Asked<'_>,
    axes: [DVec3; 2],
    dice: &mut Dice,
) -> bool {
    let Asked { solved, request, parts } = asked;
    let Solved { scene, oracle, .. } = solved;
    let map = stages.map(request).unwrap().clone();
    assert!(map.values.iter().all(|pressure| pressure.is_finite()), "{map:?}");
    let at_cells = map.how.contains("cells");
    count(&format!("radiation at {} by {:?}", if at_cells { "cells" } else { "pixels" }, map.by));
    if !at_cells {
        let area = scene.plane.size.x * scene.plane.size.y / map.values.len() as f64;
        let sum = |of: fn(f64) -> f64| map.values.iter().map(|&value| of(value.into())).sum::<f64>() * area;
        let force = stages.pressed(request).unwrap().force;
        within(
            "force on a plane",
            (force - sum(|value| value)).abs(),
            1e-9 * sum(f64::abs) + f64::MIN_POSITIVE,
        );
    }
    let part = scene.modulation.mean_square();
    let pixels = Samples::on_plane(&scene.plane, SIZE.0, SIZE.1).unwrap();
    let largest = f64::from(map.values.iter().copied().fold(0.0, f32::max)).max(*parts);
    for _ in 0..4 {
        let pixel = dice.whole(0, map.values.len() as u32 - 1) as usize;
        let point = pixels.point(pixel);
        // Slopes nearer to the array than that are those a little further away.
        if !at_cells && oracle.height(point) < 0.5 * oracle.wavelength() {
            continue;
        }
        let Some((expected, of_pressure)) = oracle.radiation(&request.drives[0], point, axes) else {
            continue;
        };
        // The oracle's differences are off by (k h)²/6 = 7e-6 of the gradient.
        let most = pressure_error(solved, map.error, largest, point) + 5e-5 * part * of_pressure;
        within("radiation pressure", (f64::from(map.values[pixel]) - part * expected).abs(), most);
    }
    at_cells
}

/// ρ g V = F.
fn it_displaces_what_the_pressure_weighs(solved: &Solved, made: &Made, rounding: f64) {
    let (density, _) = density_and_tension(&solved.scene.liquid);
    let Made { dent, tank, depression, .. } = made;
    let weight = density * solved.scene.liquid.gravity * dent.volume;
    let all: f64 = dent.depth.iter().map(|depth| depth.abs()).sum();
    let all = density * solved.scene.liquid.gravity * all * tank.step[0] * tank.step[1];
    within("displaced weight", (weight - dent.force).abs(), rounding * all + f64::MIN_POSITIVE);
    let [columns, rows] = tank.counts;
    let half = solved.scene.plane.size / 2.0;
    let is_shown = |i: usize| {
        let place = |index: usize, count: usize, step: f64| (index as f64 + 0.5 - count as f64 / 2.0) * step;
        let (x, y) = (place(i % columns, columns, tank.step[0]), place(i / columns, rows, tank.step[1]));
        x.abs() <= half.x && y.abs() <= half.y
    };
    let shown = (0..dent.depth.len()).filter(|&i| is_shown(i)).map(|i| dent.depth[i]);
    let deepest = shown.fold(0.0, f64::max);
    // The window between cells leaves out some tolerances of the largest depth, wherever that is, and what rounding of faint squares
    // leaves from cell to cell, which the map's error tells, is no surface.
    let largest = dent.depth.iter().fold(0.0f64, |most, depth| most.max(depth.abs()));
    let most = 10.0 * solved.scene.plane.tolerance.max(FINEST).max(made.error) * largest + f64::MIN_POSITIVE;
    within("the deepest place above a cell", deepest - depression.deepest, most);
}

/// ρ g h - σ ∇²h is the pressure again: by the oracle's own modes at one cell in the plane.
fn it_bears_the_radiation_pressure(asked: &Asked<'_>, made: &Made, axes: [DVec3; 2], dice: &mut Dice) {
    let Asked { solved, ref request, parts } = *asked;
    let Solved { scene, oracle, .. } = solved;
    let (density, tension) = density_and_tension(&scene.liquid);
    let Made { dent, tank, error, .. } = made;
    let [columns, rows] = tank.counts;
    let mut modes = tank.modes(&dent.depth);
    for (index, mode) in modes.iter_mut().enumerate() {
        let q = |k: usize, count: usize, step: f64| PI * k as f64 / (count as f64 * step);
        let square = q(index % columns, columns, tank.step[0]).powi(2)
            + q(index / columns, rows, tank.step[1]).powi(2);
        *mode *= density * scene.liquid.gravity + tension * square;
    }
    let borne = tank.surface(modes);
    let largest = borne.iter().copied().fold(parts, f64::max);
    for _ in 0..3 {
        let part = || 0.5 + 0.4 * (dice.unit() - 0.5);
        let mut part = part;
        let cell = [(part() * columns as f64) as usize, (part() * rows as f64) as usize];
        let place =
            |axis: usize| (cell[axis] as f64 + 0.5 - tank.counts[axis] as f64 / 2.0) * tank.step[axis];
        let point = scene.plane.centre + axes[0] * place(0) + axes[1] * place(1);
        if place(0).abs() > scene.plane.size.x / 2.0 || place(1).abs() > scene.plane.size.y / 2.0 {
            continue;
        }
        let Some((expected, of_pressure)) = oracle.radiation(&request.drives[0], point, axes) else {
            continue;
        };
        let expected = scene.modulation.mean_square() * expected;
        let most = pressure_error(solved, *error, largest, point) + 5e-5 * of_pressure + 1e-9 * largest;
        within("borne pressure", (borne[cell[1] * columns + cell[0]] - expected).abs(), most);
    }
}

/// What a depth (m) may be off: the tolerance, of what the parts of the pressure alone would press, and what f32 leaves of those.
fn depth_error(dent: &Asked<'_>, made: &Made) -> f64 {
    let scene = &dent.solved.scene;
    let (density, _) = density_and_tension(&scene.liquid);
    let under_parts = dent.parts / (density * scene.liquid.gravity);
    let depths = made.dent.depth.iter();
    let deepest = depths.map(|depth| depth.abs()).fold(under_parts, f64::max);
    let rounding = square_error(dent.solved, scene.plane.centre) / (density * scene.liquid.gravity);
    scene.plane.tolerance.max(FINEST) * deepest + rounding + 1e-37
}

/// The largest difference of depths of the second times a factor, m.
fn furthest(one: &Made, other: &Made, times: f64) -> f64 {
    let (one, other) = (&one.dent.depth, &other.dent.depth);
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).map(|(a, b)| (a - b * times).abs()).fold(0.0, f64::max)
}

fn it_goes_with_the_square_of_the_drive(evaluators: &mut Evaluators, dent: &Asked<'_>, made: &Made) {
    const LESS: f64 = 0.7;
    let drive = &dent.request.drives[0];
    let amplitudes = drive.amplitudes.iter().map(|amplitude| LESS * amplitude).collect();
    let weaker = Drive { amplitudes, phases: drive.phases.clone() };
    let asked = Asked { request: Request { drives: [weaker].into(), ..dent.request.clone() }, ..*dent };
    let weaker = pressed(&mut evaluators.cpu, &asked).unwrap();
    within("a weaker drive's dent", furthest(&weaker, made, LESS * LESS), depth_error(dent, made));
}
