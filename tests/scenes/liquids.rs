//! What holds of every dent: it bears the radiation pressure, displaces what that weighs, and goes with the square of the drive.

use std::f64::consts::PI;

use glam::DVec3;
use sonoglyph::acoustics::Air;
use sonoglyph::drive::Drive;
use sonoglyph::field::cells::Cells;
use sonoglyph::field::{Average, AverageMap, FieldError, Mean, Samples, Stages};
use sonoglyph::scene::ElementModel;
use sonoglyph::surface::Reflector;

use crate::dice::Dice;
use crate::fields::{Evaluators, f32_error, moduli};
use crate::oracle::density_and_tension;
use crate::solving::Solved;
use crate::tally::{count, within};

/// Cells of a plane on which a scene of thousands is averaged.
const MOST_CELLS: usize = 30_000;
const SIZE: (usize, usize) = (24, 18);
/// The finest tolerance of an average.
const FINEST: f64 = 1e-6;

/// A drive on the scene's plane: the mean of some drives, as it is asked for.
struct Asked<'a> {
    solved: &'a Solved,
    drives: &'a [Drive],
    mean: Mean,
    /// Pa: what the two parts of the radiation pressure come to where they do not cancel. Along a beam, on a plane that sound only
    /// grazes, they do, and the tolerance is of them.
    parts: f64,
}

impl Asked<'_> {
    fn of<T>(&self, read: impl FnOnce(&Average<'_>) -> T) -> T {
        read(&Average {
            aperture: &self.solved.aperture,
            plane: &self.solved.scene.plane,
            drives: self.drives,
            mean: self.mean.clone(),
            part: self.solved.scene.modulation.mean_square(),
            width: SIZE.0,
            height: SIZE.1,
        })
    }
}

/// Radii of an element per distance: of a far field that is nearer, the oracle's differences are too coarse.
const WIDEST: f64 = 0.3;
/// Pa, below which squares are less than f32 can hold.
const FAINTEST: f64 = 1e-14;

/// Every invariant of the radiation pressure and the dent on the scene's plane, on which the largest |P| is `peak` (Pa).
pub fn hold(evaluators: &mut Evaluators, solved: &Solved, peak: f64, dice: &mut Dice) {
    let scene = &solved.scene;
    if peak < FAINTEST {
        return count("averages left out: too faint for squares in f32");
    }
    let radius = solved.aperture.element.radius;
    if scene.array.element == ElementModel::Piston && radius > WIDEST * scene.plane.centre.z {
        return count("averages left out: elements wider than they are far away");
    }
    let Some(cells) = Cells::new(&solved.aperture, &scene.plane, 0.0, FINEST) else {
        return count("averages refused: too many cells");
    };
    if cells.len() > MOST_CELLS {
        return count("averages left out: more cells than there is time for");
    }
    let reflector = Reflector::new(&Air::new(&scene.medium, scene.array.frequency), scene.array.frequency);
    let drives = std::slice::from_ref(&solved.solution.drive);
    let (x, y) = scene.plane.axes().unwrap();
    let is_level = x.cross(y).z.abs() > 1.0 - 1e-9;
    let square = peak * peak / (solved.oracle.density * solved.oracle.sound_speed.powi(2));
    let parts = 2.0 * scene.modulation.mean_square() * square;
    let dent = Asked { solved, drives, mean: Mean::Dent(reflector, scene.liquid.clone()), parts };
    if !is_level {
        assert_eq!(dent.of(|wanted| evaluators.cpu.average(wanted).err()), Some(FieldError::NotLevel));
    }
    let radiation = Asked { mean: Mean::Radiation(reflector), ..dent };
    match radiation.of(|wanted| evaluators.cpu.read_average(wanted)) {
        Err(FieldError::TooNear) => return count("averages refused: the plane is too near"),
        Err(error) => panic!("{error}"),
        Ok(pressures) => radiation_is_the_models(solved, &pressures, parts, [x, y], dice),
    }
    if !is_level {
        return count("radiation on tilted planes");
    }
    let dent = Asked { mean: Mean::Dent(reflector, scene.liquid.clone()), ..radiation };
    let Some(map) = made(&mut evaluators.cpu, &dent) else {
        return count("dents refused: the plane is too near");
    };
    count("dents");
    it_displaces_what_the_pressure_weighs(solved, &map, 1e-9);
    it_bears_the_radiation_pressure(&dent, &map, [x, y], dice);
    // By turns.
    if dice.of(0.5) {
        return it_goes_with_the_square_of_the_drive(evaluators, &dent, &map);
    }
    if let Some(gpu) = &mut evaluators.gpu {
        let by_gpu = made(gpu, &dent).unwrap();
        it_displaces_what_the_pressure_weighs(solved, &by_gpu, 1e-5);
        let most = depth_error(&dent, &map);
        within("a dent by the GPU", furthest(&by_gpu, &map, 1.0), 2.0 * most);
        count(&format!("dents by {:?}, asked of the GPU", by_gpu.by));
    }
}

fn made(stages: &mut Stages, dent: &Asked<'_>) -> Option<AverageMap> {
    let map = match dent.of(|wanted| stages.average(wanted).cloned()) {
        Err(FieldError::TooNear) => return None,
        other => other.unwrap(),
    };
    let pixels = dent.of(|wanted| stages.read_average(wanted)).unwrap();
    assert!(pixels.iter().all(|depth| depth.is_finite()) && map.force.is_finite(), "{map:?}");
    Some(map)
}

/// What the pressure (Pa) may be off: the tolerance, of its largest value, which the squares of pressure and slope make; and what f32
/// leaves of the squares.
fn pressure_error(solved: &Solved, largest: f64, point: DVec3) -> f64 {
    solved.scene.plane.tolerance.max(FINEST) * largest + square_error(solved, point)
}

/// What f32 leaves of the radiation pressure at a point (Pa): of a square twice what it leaves of its root, of two parts. Its root is
/// what arrives there, whatever of it cancels.
fn square_error(solved: &Solved, point: DVec3) -> f64 {
    let Solved { scene, oracle, solution, .. } = solved;
    let per_square = scene.modulation.mean_square() / (oracle.density * oracle.sound_speed.powi(2));
    let arriving = moduli(solved, &solution.drive, point);
    4.0 * per_square * arriving * f32_error(solved, &solution.drive, point) + 1e-37
}

fn radiation_is_the_models(
    solved: &Solved,
    pressures: &[f32],
    parts: f64,
    axes: [DVec3; 2],
    dice: &mut Dice,
) {
    let Solved { scene, solution, .. } = solved;
    assert!(pressures.iter().all(|pressure| pressure.is_finite()));
    let part = scene.modulation.mean_square();
    let pixels = Samples::on_plane(&scene.plane, SIZE.0, SIZE.1).unwrap();
    let largest = f64::from(pressures.iter().copied().fold(0.0, f32::max)).max(parts);
    for _ in 0..4 {
        let pixel = dice.whole(0, pressures.len() as u32 - 1) as usize;
        let point = pixels.point(pixel);
        let Some((expected, of_pressure)) = solved.oracle.radiation(&solution.drive, point, axes) else {
            continue;
        };
        // The oracle's differences are off by (k h)²/6 = 7e-6 of the gradient.
        let most = pressure_error(solved, largest, point) + 5e-5 * part * of_pressure;
        within("radiation pressure", (f64::from(pressures[pixel]) - part * expected).abs(), most);
    }
}

/// ρ g V = F.
fn it_displaces_what_the_pressure_weighs(solved: &Solved, map: &AverageMap, rounding: f64) {
    let (density, _) = density_and_tension(&solved.scene.liquid);
    let (dent, tank) = (map.dent.as_ref().unwrap(), map.tank.as_ref().unwrap());
    let weight = density * solved.scene.liquid.gravity * dent.volume;
    let all: f64 = dent.depth.iter().map(|depth| depth.abs()).sum();
    let all = density * solved.scene.liquid.gravity * all * tank.step[0] * tank.step[1];
    within("displaced weight", (weight - dent.force).abs(), rounding * all + f64::MIN_POSITIVE);
    let deepest = dent.depth.iter().copied().fold(0.0, f64::max);
    assert_eq!(dent.deepest, deepest);
}

/// ρ g h - σ ∇²h is the pressure again: by the oracle's own modes at one cell in the plane.
fn it_bears_the_radiation_pressure(dent: &Asked<'_>, map: &AverageMap, axes: [DVec3; 2], dice: &mut Dice) {
    let Asked { solved, parts, .. } = *dent;
    let Solved { scene, oracle, solution, .. } = solved;
    let (density, tension) = density_and_tension(&scene.liquid);
    let (dent, tank) = (map.dent.as_ref().unwrap(), map.tank.as_ref().unwrap());
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
        let Some((expected, of_pressure)) = oracle.radiation(&solution.drive, point, axes) else { continue };
        let expected = scene.modulation.mean_square() * expected;
        let most = pressure_error(solved, largest, point) + 5e-5 * of_pressure + 1e-9 * largest;
        within("borne pressure", (borne[cell[1] * columns + cell[0]] - expected).abs(), most);
    }
}

/// What a depth (m) may be off: the tolerance, of what the parts of the pressure alone would press, and what f32 leaves of those.
fn depth_error(dent: &Asked<'_>, map: &AverageMap) -> f64 {
    let scene = &dent.solved.scene;
    let (density, _) = density_and_tension(&scene.liquid);
    let under_parts = dent.parts / (density * scene.liquid.gravity);
    let depths = map.dent.as_ref().unwrap().depth.iter();
    let deepest = depths.map(|depth| depth.abs()).fold(under_parts, f64::max);
    let rounding = square_error(dent.solved, scene.plane.centre) / (density * scene.liquid.gravity);
    scene.plane.tolerance.max(FINEST) * deepest + rounding + 1e-37
}

/// The largest difference of depths of the second times a factor, m.
fn furthest(one: &AverageMap, other: &AverageMap, times: f64) -> f64 {
    let (one, other) = (one.dent.as_ref().unwrap(), other.dent.as_ref().unwrap());
    assert_eq!(one.depth.len(), other.depth.len());
    one.depth.iter().zip(&other.depth).map(|(a, b)| (a - b * times).abs()).fold(0.0, f64::max)
}

fn it_goes_with_the_square_of_the_drive(evaluators: &mut Evaluators, dent: &Asked<'_>, map: &AverageMap) {
    const LESS: f64 = 0.7;
    let drive = &dent.drives[0];
    let amplitudes = drive.amplitudes.iter().map(|amplitude| LESS * amplitude).collect();
    let weaker = [Drive { amplitudes, phases: drive.phases.clone() }];
    let asked = Asked { drives: &weaker, mean: dent.mean.clone(), ..*dent };
    let weaker = made(&mut evaluators.cpu, &asked).unwrap();
    within("a weaker drive's dent", furthest(&weaker, map, LESS * LESS), depth_error(dent, map));
}
