//! Drives for traps, alone or beside foci: a first drive by signature or by lobes with prescribed phases, then
//! maximisation of the smallest stiffness.

use web_time::{Duration, Instant};

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::{Air, Aperture, Derivatives, Emitters, Transfer};
use crate::force::{Sphere, modes};
use crate::gauge::{self, Gauge};
use crate::scene::{Focus, Part, Scene, Shape, Trap};
use crate::solver::descent::{Descent, Function};
use crate::solver::{Excitation, Problem, iteration};

/// Steps of the descent without and with further time.
const STEPS: usize = 60;
const MOST_STEPS: usize = 5000;
/// Steps while some trap pushes its bead away.
const PATIENCE: usize = 400;
/// Weighted Gerchberg-Saxton's steps on lobes.
const ITERATIONS: usize = 60;
/// Sharpness of the soft minimum of stiffnesses.
const HARD: f64 = 12.0;
/// Weight of the pressures of foci beside traps.
const BESIDE: f64 = 1.0;

/// The traps of a scene, and the bead.
#[derive(Clone, Debug)]
pub struct Traps {
    sphere: Sphere,
    /// N, towards -z.
    load: f64,
    traps: Vec<Wanted>,
}

/// One of them.
#[derive(Clone, Debug)]
struct Wanted {
    trap: Trap,
    charge: i32,
    at: DVec3,
    /// From the trap's axes to the scene's.
    turn: glam::DQuat,
    /// Its lobes among the foci.
    foci: std::ops::Range<usize>,
    phases: Vec<f64>,
}

impl Traps {
    /// The traps whose lobes are foci; `None` without traps.
    pub fn of_scene(scene: &Scene, aperture: &Aperture, foci: &[Focus]) -> Option<Self> {
        let air = Air::new(&scene.medium, scene.array.frequency);
        let mut traps: Vec<Wanted> = Vec::new();
        let mut start = 0;
        while start < foci.len() {
            let Part::Trap(index) = foci[start].part else {
                start += 1;
                continue;
            };
            let target = &scene.targets[index];
            let Shape::Trap { trap, charge, .. } = target.shape else {
                start += 1;
                continue;
            };
            let lobes = trap.lobes(charge, aperture.wavelength());
            let range = start..(start + lobes.len()).min(foci.len());
            let turn = target.turn();
            // Motions move the lobes; the trap moves with them.
            let places = range.clone().zip(&lobes).map(|(i, lobe)| foci[i].position - turn * lobe.at);
            let at = places.sum::<DVec3>() / range.len() as f64;
            let phases = lobes.iter().map(|lobe| lobe.phase).collect();
            start = range.end;
            traps.push(Wanted { trap, charge, at, turn, foci: range, phases });
        }
        let sphere = Sphere::new(&scene.bead, &air, aperture.element.wavenumber);
        (!traps.is_empty()).then(|| Self { sphere, load: sphere.load(scene.liquid.gravity), traps })
    }

    /// The weakest stiffness (N/m) of each trap under a drive.
    pub fn weakest(&self, aperture: &Aperture, excitation: &[Complex64]) -> Vec<f64> {
        let emitters = Emitters::new(aperture, excitation);
        let of = |trap: &Wanted| {
            let stiffness = self.sphere.stiffness(&emitters.derivatives(trap.at));
            modes(&((stiffness + stiffness.transpose()) * 0.5))[0].stiffness
        };
        self.traps.iter().map(of).collect()
    }
}

/// The first drive: for a single trap its signature on focusing phases, for several their lobes with prescribed
/// phases.
pub fn signature(problem: &Problem<'_>, traps: &Traps) -> Vec<Complex64> {
    match &traps.traps[..] {
        [alone] if alone.foci.len() == problem.foci.len() && !needs_lobes(problem.aperture, alone) => {
            by_signature(problem.aperture, alone)
        }
        _ => by_lobes(problem, traps),
    }
}

/// With all elements on one side, a standing wave cannot be made by a phase difference between sides.
fn needs_lobes(aperture: &Aperture, trap: &Wanted) -> bool {
    let above = |&n: &usize| (trap.turn.inverse() * (aperture.positions[n] - trap.at)).z > 0.0;
    let count = aperture.driven.iter().filter(|n| above(n)).count();
    trap.trap == Trap::Standing && (count == 0 || count == aperture.driven.len())
}

fn by_signature(aperture: &Aperture, trap: &Wanted) -> Vec<Complex64> {
    let place = |n: usize| trap.turn.inverse() * (aperture.positions[n] - trap.at);
    let mut radii: Vec<_> = aperture.driven.iter().map(|&n| place(n).truncate().length()).collect();
    radii.sort_by(f64::total_cmp);
    // Rounding must not exclude elements of a ring.
    let radius = radii[(radii.len() - 1) / 2] * (1.0 + 1e-9);
    let of = |&n: &usize| {
        let phase = aperture.element.wavenumber * place(n).length();
        Complex64::cis(phase + trap.trap.signature(trap.charge, place(n), radius))
    };
    aperture.driven.iter().map(of).collect()
}

/// Weighted Gerchberg-Saxton with one free phase per trap, common to its lobes.
fn by_lobes(problem: &Problem<'_>, traps: &Traps) -> Vec<Complex64> {
    let transfer = &problem.transfer;
    let targets = problem.targets();
    let mut fixed = vec![0.0; targets.len()];
    let mut groups: Vec<std::ops::Range<usize>> = traps.traps.iter().map(|trap| trap.foci.clone()).collect();
    for trap in &traps.traps {
        fixed[trap.foci.clone()].copy_from_slice(&trap.phases);
    }
    let is_lobe = |i: usize| traps.traps.iter().any(|trap| trap.foci.contains(&i));
    groups.extend((0..targets.len()).filter(|&i| !is_lobe(i)).map(|i| i..i + 1));
    let mut weights = targets.clone();
    // Neighbours that start a golden angle apart help each other more often than in phase.
    let mut free: Vec<f64> = (0..groups.len()).map(|i| 2.4 * i as f64).collect();
    let mut u = Vec::new();
    for _ in (0..ITERATIONS).take_while(|_| !gauge::is_cancelled()) {
        let mut wanted = vec![Complex64::ZERO; targets.len()];
        for (group, phase) in groups.iter().zip(&free) {
            for i in group.clone() {
                wanted[i] = Complex64::from_polar(weights[i], fixed[i] + phase);
            }
        }
        u = transfer.back(&wanted).into_iter().map(iteration::phase).collect();
        let heard = transfer.pressure(&u);
        for (group, phase) in groups.iter().zip(&mut free) {
            let common: Complex64 =
                group.clone().map(|i| heard[i] * Complex64::cis(-fixed[i]) * weights[i]).sum();
            *phase = common.arg();
        }
        let relative: Vec<_> = heard.iter().zip(&targets).map(|(p, target)| p.norm() / target).collect();
        let mean = relative.iter().sum::<f64>() / relative.len() as f64;
        for (weight, relative) in weights.iter_mut().zip(&relative) {
            *weight *= (mean / relative).sqrt().min(2.0);
        }
    }
    u
}

/// The drive of traps: from their signature to a larger smallest stiffness, never a smaller one.
pub fn best(problem: &Problem<'_>, traps: &Traps, time: Duration) -> Excitation {
    stiffen(problem, traps, &signature(problem, traps), time)
}

/// The same from another drive, of a frame before.
pub fn best_from(problem: &Problem<'_>, traps: &Traps, before: &[Complex64]) -> Excitation {
    let from: Vec<_> = before.iter().map(|u| iteration::phase(*u)).collect();
    let onward = stiffen(problem, traps, &from, Duration::ZERO);
    let anew = best(problem, traps, Duration::ZERO);
    let weakest = |it: &Excitation| least(&traps.weakest(problem.aperture, &it.values));
    // Continuing avoids phase jumps, and is abandoned if its result is worse.
    if weakest(&onward) < 0.9 * weakest(&anew) { anew } else { onward }
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn stiffen(problem: &Problem<'_>, traps: &Traps, start: &[Complex64], time: Duration) -> Excitation {
    let (begun, gauge) = (Instant::now(), Gauge::current());
    let weakest = |u: &[Complex64]| least(&traps.weakest(problem.aperture, u));
    let mut function = Stiffness::new(problem, traps, start);
    let phases: Vec<_> = start.iter().map(|u| u.arg()).collect();
    let (mut best, mut value) = (start.to_vec(), weakest(start));
    let mut descent = Descent::new(phases, &mut function);
    let mut steps = 0;
    loop {
        let most = match value {
            _ if gauge.lasts(begun.elapsed(), time) => MOST_STEPS,
            value if value <= 0.0 => PATIENCE,
            _ => STEPS,
        };
        let goes_on = steps < most && descent.step(&mut function);
        steps += 1;
        if steps % 10 == 0 || !goes_on {
            let u: Vec<_> = descent.x.iter().map(|phase| Complex64::cis(*phase)).collect();
            let own = weakest(&u);
            if own > value && function.keeps_foci(problem, &u) {
                (best, value) = (u, own);
            }
        }
        if !goes_on {
            break;
        }
    }
    Excitation { values: best, iterations: steps as u32, residual: None, weights: None }
}

/// The negative soft minimum of all stiffnesses of all traps, with penalties for net forces at the traps and for weak
/// foci.
struct Stiffness<'a> {
    traps: &'a Traps,
    /// Of every trap, per element.
    columns: Vec<Vec<Derivatives>>,
    /// N/m, of the first drive: the unit.
    unit: f64,
    wavenumber: f64,
    transfer: &'a Transfer,
    /// Foci that are not lobes, with the squares of their initial pressures.
    foci: Vec<(usize, f64)>,
}

impl<'a> Stiffness<'a> {
    fn new(problem: &'a Problem<'_>, traps: &'a Traps, start: &[Complex64]) -> Self {
        let aperture = problem.aperture;
        let columns: Vec<Vec<_>> =
            traps.traps.iter().map(|trap| Emitters::columns(aperture, trap.at)).collect();
        let heard = problem.transfer.pressure(start);
        let is_lobe = |i: &usize| traps.traps.iter().any(|trap| trap.foci.contains(i));
        let foci = (0..heard.len()).filter(|i| !is_lobe(i)).map(|i| (i, heard[i].norm_sqr())).collect();
        let mut own = Self {
            traps,
            columns,
            unit: 1.0,
            wavenumber: aperture.element.wavenumber,
            transfer: &problem.transfer,
            foci,
        };
        let largest = |sound: Derivatives| {
            let stiffness = traps.sphere.stiffness(&sound);
            modes(&((stiffness + stiffness.transpose()) * 0.5)).map(|mode| mode.stiffness.abs())
        };
        let all: Vec<_> = own.sounds(start).into_iter().flat_map(largest).collect();
        own.unit = (all.iter().sum::<f64>() / all.len() as f64).max(f64::MIN_POSITIVE);
        own
    }

    fn sounds(&self, u: &[Complex64]) -> Vec<Derivatives> {
        let of = |columns: &Vec<Derivatives>| {
            let mut sum = Derivatives::default();
            columns.iter().zip(u).for_each(|(column, u)| sum += *column * *u);
            sum
        };
        self.columns.iter().map(of).collect()
    }

    /// Whether foci beside the traps nearly keep their initial pressures.
    fn keeps_foci(&self, problem: &Problem<'_>, u: &[Complex64]) -> bool {
        const LEAST: f64 = 0.8;
        let heard = problem.transfer.pressure(u);
        self.foci.iter().all(|&(i, square)| heard[i].norm_sqr() >= LEAST * square)
    }
}

impl Function for Stiffness<'_> {
    fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let sphere = &self.traps.sphere;
        let u: Vec<_> = x.iter().map(|phase| Complex64::cis(*phase)).collect();
        // Value and slope of each term, trap by trap.
        let mut terms: Vec<(usize, f64, Derivatives)> = Vec::new();
        let mut pushes: Vec<(usize, f64, Derivatives)> = Vec::new();
        for (trap, sound) in self.sounds(&u).into_iter().enumerate() {
            let stiffness = sphere.stiffness(&sound);
            for mode in modes(&((stiffness + stiffness.transpose()) * 0.5)) {
                let (value, slope) = sphere.stiffness_along(&sound, mode.direction);
                terms.push((trap, value / self.unit, slope));
            }
            // The net force drives the bead away from its position.
            for (axis, load) in [(DVec3::X, 0.0), (DVec3::Y, 0.0), (DVec3::Z, self.traps.load)] {
                let (value, slope) = sphere.force_along(&sound, axis);
                pushes.push((trap, (value - load) * self.wavenumber / self.unit, slope));
            }
        }
        let lowest = terms.iter().map(|(_, value, _)| *value).fold(f64::INFINITY, f64::min);
        let sum: f64 = terms.iter().map(|(_, value, _)| (-HARD * (value - lowest)).exp()).sum();
        let mut value = -(lowest - sum.ln() / HARD);
        let mut slopes = vec![Derivatives::default(); self.columns.len()];
        for (trap, own, slope) in &terms {
            let part = (-HARD * (own - lowest)).exp() / sum;
            slopes[*trap] += *slope * Complex64::from(-part / self.unit);
        }
        for (trap, push, slope) in &pushes {
            const COUNTS: f64 = 0.02;
            value += COUNTS * push * push;
            slopes[*trap] += *slope * Complex64::from(2.0 * COUNTS * push * self.wavenumber / self.unit);
        }
        let mut turned = vec![Complex64::ZERO; u.len()];
        for (slope, columns) in slopes.iter().zip(&self.columns) {
            turned.iter_mut().zip(columns).for_each(|(sum, column)| *sum += slope.product(column));
        }
        if !self.foci.is_empty() {
            let heard = self.transfer.pressure(&u);
            let mut back = vec![Complex64::ZERO; heard.len()];
            for &(i, square) in &self.foci {
                let off = (heard[i].norm_sqr() / square.max(f64::MIN_POSITIVE) - 1.0).min(0.0);
                value += BESIDE * off * off;
                back[i] = heard[i] * (4.0 * BESIDE * off / square.max(f64::MIN_POSITIVE));
            }
            for (sum, own) in turned.iter_mut().zip(self.transfer.back(&back)) {
                *sum += own.conj();
            }
        }
        for ((to, turned), u) in gradient.iter_mut().zip(turned).zip(&u) {
            *to = (turned * Complex64::I * u).re;
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Drive;
    use crate::force::Levitation;
    use crate::scene::{Bead, Board, Target, outline};

    #[test]
    fn the_gradient_is_that_of_the_value() {
        let mut scene = Scene { bead: Bead { radius: 3e-4, ..Bead::default() }, ..Scene::default() };
        (scene.array.rows, scene.array.columns) = (4, 5);
        scene.boards =
            vec![Board::default(), Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() }];
        let trap =
            |x: f64, trap: Trap| Target::new(Shape::Trap { at: DVec3::new(x, 0.0, 0.1), trap, charge: 1 });
        scene.targets = vec![trap(-0.02, Trap::Twin), trap(0.02, Trap::Vortex)];
        scene.targets.push(Target::new(Shape::Point { at: DVec3::new(0.0, 0.03, 0.11) }));
        let aperture = Aperture::new(&scene);
        let foci = outline::foci(&scene).unwrap();
        let problem = Problem::of_scene(&scene, &aperture, foci);
        let traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let mut function = Stiffness::new(&problem, traps, &start);
        let x: Vec<_> = start.iter().enumerate().map(|(n, u)| u.arg() + 0.3 * (n as f64).sin()).collect();
        let (mut gradient, mut unused) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        let value = function.evaluate(&x, &mut gradient);
        // The focus is weaker than at the start, which counts.
        let foci = std::mem::take(&mut function.foci);
        let without = function.evaluate(&x, &mut unused);
        let u: Vec<_> = x.iter().map(|phase| Complex64::cis(*phase)).collect();
        let part = problem.transfer.pressure(&u)[foci[0].0].norm_sqr() / foci[0].1;
        assert!(foci.len() == 1 && part < 0.99, "{foci:?} {part}");
        assert!(
            (value - without - BESIDE * (part - 1.0).powi(2)).abs() < 1e-9 * value.abs(),
            "{value} {without}"
        );
        function.foci = foci;
        for n in [0, 7, 21, 39] {
            let mut at = |step: f64| {
                let mut x = x.clone();
                x[n] += step;
                function.evaluate(&x, &mut unused)
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!(
                (slope - gradient[n]).abs() < 1e-6 * (1.0 + slope.abs()),
                "{n}: {slope}, not {}",
                gradient[n]
            );
        }
    }

    /// A board of 4 x 4 elements with a trap before it.
    fn before_board(trap: Trap) -> Scene {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (4, 4);
        scene.targets = vec![Target::new(Shape::Trap { at: DVec3::Z * 0.05, trap, charge: 1 })];
        scene
    }

    #[test]
    fn only_a_standing_wave_with_all_elements_on_one_side_needs_its_lobes() {
        let above = Board { at: DVec3::Z * 0.1, normal: DVec3::NEG_Z, ..Board::default() };
        for (trap, boards, expected) in [
            (Trap::Standing, vec![Board::default()], true),
            (Trap::Standing, vec![above.clone()], true),
            (Trap::Standing, vec![Board::default(), above], false),
            (Trap::Twin, vec![Board::default()], false),
        ] {
            let scene = Scene { boards, ..before_board(trap) };
            let aperture = Aperture::new(&scene);
            let traps = Traps::of_scene(&scene, &aperture, &outline::foci(&scene).unwrap()).unwrap();
            assert_eq!(needs_lobes(&aperture, &traps.traps[0]), expected, "{trap:?}, {:?}", scene.boards);
        }
    }

    #[test]
    fn the_phases_of_several_traps_do_not_depend_on_the_strength_of_elements() {
        let start = |strength: f64| {
            let mut scene = before_board(Trap::Twin);
            scene.array.strength = strength;
            let at = DVec3::new(0.015, 0.01, 0.06);
            scene.targets.push(Target::new(Shape::Trap { at, trap: Trap::Bottle, charge: 1 }));
            let aperture = Aperture::new(&scene);
            let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
            signature(&problem, problem.traps.as_ref().unwrap())
        };
        // By a power of two, so that nothing is rounded otherwise.
        for (strong, weak) in start(2.0).into_iter().zip(start(2f64.powi(-30))) {
            assert!((strong - weak).norm() < 1e-9, "{strong} and {weak}");
        }
    }

    #[test]
    fn the_weakest_stiffness_is_that_of_a_bead_in_the_trap() {
        let scene = before_board(Trap::Twin);
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let phases = start.iter().map(|u| u.arg()).collect();
        let bead = Levitation::new(&scene, &aperture, &[Drive { amplitudes: vec![1.0; 16], phases }]);
        let expected = modes(&bead.forces(DVec3::Z * 0.05).symmetric())[0].stiffness;
        let [own] = traps.weakest(&aperture, &start)[..] else { panic!("one trap") };
        assert!((own - expected).abs() < 1e-6 * expected.abs(), "{own}, not {expected} N/m");
    }

    #[test]
    fn a_focus_that_loses_a_fifth_of_its_power_is_not_kept() {
        let mut scene = before_board(Trap::Twin);
        scene.targets.push(Target::new(Shape::Point { at: DVec3::new(0.01, 0.0, 0.05) }));
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let function = Stiffness::new(&problem, traps, &start);
        let keeps = |power: f64| {
            let u: Vec<_> = start.iter().map(|u| u * power.sqrt()).collect();
            function.keeps_foci(&problem, &u)
        };
        assert_eq!([1.5, 1.0, 0.81, 0.79, 0.3, 0.0].map(keeps), [true, true, true, false, false, false]);
    }

    #[test]
    fn the_value_is_of_the_shape_of_the_field_and_not_of_its_strength() {
        let value = |strength: f64| {
            let mut scene = Scene::default();
            (scene.array.rows, scene.array.columns, scene.array.strength) = (4, 5, strength);
            let trap = Shape::Trap { at: DVec3::Z * 0.05, trap: Trap::Twin, charge: 1 };
            scene.targets = vec![Target::new(trap)];
            let aperture = Aperture::new(&scene);
            let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
            // Without the bead's weight, which does not grow with the field.
            let traps = Traps { load: 0.0, ..problem.traps.clone().unwrap() };
            let start = signature(&problem, &traps);
            let x: Vec<_> = start.iter().enumerate().map(|(n, u)| u.arg() + 0.3 * (n as f64).sin()).collect();
            Stiffness::new(&problem, &traps, &start).evaluate(&x, &mut vec![0.0; x.len()])
        };
        let [one, other] = [3.0, 3000.0].map(value);
        assert!((one - other).abs() < 1e-9 * one.abs(), "{one} and {other}");
    }

    #[test]
    fn a_focus_that_no_element_reaches_is_kept() {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (4, 4);
        let trap = Shape::Trap { at: DVec3::Z * 0.05, trap: Trap::Twin, charge: 1 };
        scene.targets =
            vec![Target::new(trap), Target::new(Shape::Point { at: DVec3::new(0.01, 0.0, 0.05) })];
        let aperture = Aperture::new(&scene);
        let mut foci = outline::foci(&scene).unwrap();
        // Behind the array.
        foci.last_mut().unwrap().position.z = -0.05;
        let problem = Problem::of_scene(&scene, &aperture, foci);
        let traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let function = Stiffness::new(&problem, traps, &start);
        assert!(matches!(function.foci[..], [(_, square)] if square == 0.0), "{:?}", function.foci);
        assert!(function.keeps_foci(&problem, &start));
    }

    #[test]
    fn a_net_force_counts_by_its_square() {
        let scene = before_board(Trap::Twin);
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let x: Vec<_> = start.iter().map(|u| u.arg()).collect();
        // N, of the first drive's stiffness at a distance of 1/k.
        let unit = Stiffness::new(&problem, traps, &start).unit / aperture.element.wavenumber;
        let value = |load: f64| {
            let traps = Traps { load: load * unit, ..traps.clone() };
            Stiffness::new(&problem, &traps, &start).evaluate(&x, &mut vec![0.0; x.len()])
        };
        let [one, two] = [1.0, 2.0].map(|load| value(load) + value(-load) - 2.0 * value(0.0));
        assert!(one > 0.01 && (two / one - 4.0).abs() < 1e-6, "{one}, and {two} of twice the load");
    }
}
