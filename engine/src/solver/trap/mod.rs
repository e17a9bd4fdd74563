//! Drives for traps, alone or beside foci: first drives of several kinds, then maximisation of the smallest stiffness
//! under the balance of force and weight.

mod starts;
mod stiffness;
pub(crate) mod traps;

use crate::gauge::Gauge;
use crate::solver::descent::Descent;
use crate::solver::iteration;
use crate::solver::problem::{Excitation, Problem};
use num_complex::Complex64;
use rayon::prelude::*;
use std::cmp::Ordering;
use stiffness::{Places, Stiffness, phasors};
use web_time::{Duration, Instant};

pub use starts::signature;
use traps::Kinds;
pub use traps::Traps;

/// Steps of a descent between corrections of the multipliers.
const STEPS: usize = 20;

/// Corrections of every start (and of phases that settled into balance), of the best few, and of the best; and how many
/// the best few are.
const EACH: usize = 2;

const MORE: usize = 3;

const LAST: usize = 5;

const FEW: usize = 3;

/// Corrections of a drive that goes on from a frame before.
const ONWARD: usize = 2;

/// Scattered starts of a trap before a single board.
const SCATTERED: usize = 3;

/// Steps towards stiffness where nothing carries the bead: while some trap pushes it away, and otherwise.
const PATIENCE: usize = 400;

const YIELDING: usize = 60;

/// The functions of a drive whose minimum is that of the traps; foci beside them keep their pressure of a first drive.
fn places<'a>(traps: &Traps, problem: &'a Problem<'_>, first: &[Complex64]) -> Places<'a> {
    let is_lobe = |i: &usize| traps.traps.iter().any(|trap| trap.foci.contains(i));
    let foci = (0..problem.foci.len()).filter(|i| !is_lobe(i)).collect();
    let at: Vec<_> = traps.traps.iter().map(|trap| trap.at).collect();
    Places::new(problem, (traps.sphere, traps.load), &at, foci, first)
}

/// The drive of traps with the largest smallest stiffness in balance of force and weight at every trap, from several
/// starts; where no start leads to balance, the stiffest out of it.
pub fn best(problem: &Problem<'_>, traps: &Traps, time: Duration) -> Excitation {
    if traps.kinds != Kinds::First {
        return of_kind(problem, traps, &[]);
    }
    let (begun, gauge) = (Instant::now(), Gauge::current());
    let named = signature(problem, traps);
    let places = places(traps, problem, &named);
    let elements = named.len();
    let mut starts = vec![named];
    let is_between = traps.traps.iter().any(|trap| starts::is_between(problem.aperture, trap));
    let is_alone = traps.traps.len() == 1 && traps.traps[0].foci.len() == problem.foci.len();
    let tries_all = is_alone && !is_between;
    if tries_all {
        starts.extend(starts::others(problem, traps));
        starts.extend((0..SCATTERED).map(|number| starts::scattered(elements, number)));
    } else if is_alone {
        starts.extend(starts::standing(problem, traps));
    }
    // Constraints of many traps slow a descent down; beside each other stiff traps are nearly in balance.
    let mut best = if is_alone { climb(&places, &starts) } else { settled(&places, &starts[0]) };
    if !best.found.holds() && !is_alone {
        best = best.or(climb(&places, &starts));
    }
    if !best.found.holds() && !tries_all {
        best = best.or(climb(&places, &starts::others(problem, traps).collect::<Vec<_>>()));
    }
    let mut number = SCATTERED;
    while gauge.lasts(begun.elapsed(), time) {
        let before = best.found.weakest;
        best.go(LAST);
        // A start is given up when a further descent no longer gains a thousandth.
        if best.found.weakest <= before + 1e-3 * before.abs() {
            let mut other = Climb::new(&places, &starts::scattered(elements, number));
            other.go(EACH + MORE + LAST);
            best = best.or(other);
            number += 1;
        }
    }
    if !best.found.holds() {
        best = stiffest(&places, &starts[0]);
    }
    best.into_excitation()
}

/// The same from another drive, of a frame before: the phases change as little as balance and stiffness allow.
pub fn best_from(problem: &Problem<'_>, traps: &Traps, before: &[Complex64]) -> Excitation {
    if traps.kinds != Kinds::First {
        return of_kind(problem, traps, before);
    }
    let start: Vec<_> = before.iter().map(|u| iteration::phase(*u)).collect();
    let places = places(traps, problem, &start);
    let mut onward = Climb::new(&places, &start);
    onward.go(ONWARD);
    if onward.found.holds() { onward.into_excitation() } else { best(problem, traps, Duration::ZERO) }
}

/// The drive of the kinds that the scene names, with the nearest phases in balance if they hold the bead. It changes
/// continuously with the angles of the traps.
fn of_kind(problem: &Problem<'_>, traps: &Traps, before: &[Complex64]) -> Excitation {
    let named = starts::onward(problem, traps, before);
    let places = places(traps, problem, &named);
    let x: Vec<_> = named.iter().map(|u| u.arg()).collect();
    let balanced = || Stiffness::new(&places, &named).balanced(&x).map(|x| Found::new(&places, x, true));
    let balanced = if traps.kinds == Kinds::Balanced { balanced() } else { None };
    let values = balanced.filter(Found::holds).map_or(named, |found| phasors(&found.x));
    Excitation { values, iterations: 0, residual: None, weights: None }
}

/// The best of several starts: all for a short way, a few for a longer one, and one to the end.
fn climb<'a>(places: &'a Places<'a>, starts: &[Vec<Complex64>]) -> Climb<'a> {
    let mut climbs: Vec<_> = starts.par_iter().map(|start| Climb::new(places, start)).collect();
    for (corrections, kept) in [(EACH, FEW), (MORE, 1), (LAST, 1)] {
        if climbs.len() > kept || corrections == LAST {
            climbs.par_iter_mut().for_each(|climb| climb.go(corrections));
            climbs.sort_by(|a, b| b.found.order(&a.found));
            climbs.truncate(kept);
        }
    }
    climbs.swap_remove(0)
}

/// The stiffest drive without balance, from a start and no less stiff than it.
fn stiffest<'a>(places: &'a Places<'a>, start: &[Complex64]) -> Climb<'a> {
    /// Steps between looks at the true stiffness.
    const LOOK: usize = 10;
    let mut climb = Climb::new(places, start);
    climb.function = climb.function.yielding();
    climb.descent.renew(&mut climb.function);
    loop {
        let most = if climb.found.weakest <= 0.0 { PATIENCE } else { YIELDING };
        let goes_on = (0..LOOK).all(|_| climb.step());
        climb.found.raise(Found::new(places, climb.descent.x.clone(), false));
        if !goes_on || climb.steps >= most {
            return climb;
        }
    }
}

/// The stiffest drive without balance, then the balanced phases nearest to it, and from there with its multipliers.
fn settled<'a>(places: &'a Places<'a>, start: &[Complex64]) -> Climb<'a> {
    let mut climb = stiffest(places, start);
    if let Some(x) = climb.function.balanced(&climb.found.x) {
        climb.function.estimate(&x);
        climb.descent = Descent::new(x.clone(), &mut climb.function);
        climb.found.raise(Found::new(places, x, true));
        climb.go(EACH);
    }
    climb
}

/// A start on its way.
#[derive(Debug)]
struct Climb<'a> {
    places: &'a Places<'a>,
    function: Stiffness<'a>,
    descent: Descent,
    steps: usize,
    /// The best on the way.
    found: Found,
}

impl<'a> Climb<'a> {
    fn new(places: &'a Places<'a>, start: &[Complex64]) -> Self {
        let mut function = Stiffness::new(places, start);
        let x: Vec<_> = start.iter().map(|u| u.arg()).collect();
        let found = Found::new(places, x.clone(), false);
        Self { places, descent: Descent::new(x, &mut function), function, steps: 0, found }
    }

    fn step(&mut self) -> bool {
        self.steps += 1;
        self.descent.step(&mut self.function)
    }

    /// Descents with a correction of the multipliers after each, and the balanced phases nearest to the last.
    fn go(&mut self, corrections: usize) {
        for _ in 0..corrections {
            let _ = (0..STEPS).all(|_| self.step());
            self.function.correct(&self.descent.x);
            self.descent.renew(&mut self.function);
        }
        if let Some(x) = self.function.balanced(&self.descent.x) {
            self.found.raise(Found::new(self.places, x, true));
        }
    }

    /// The better of two.
    fn or(self, other: Self) -> Self {
        if other.found.order(&self.found).is_gt() { other } else { self }
    }

    fn into_excitation(self) -> Excitation {
        Excitation {
            values: phasors(&self.found.x),
            iterations: self.steps as u32,
            residual: None,
            weights: None,
        }
    }
}

/// Phases, with their figures.
#[derive(Debug)]
struct Found {
    x: Vec<f64>,
    keeps_foci: bool,
    /// Force and weight are in balance at every trap.
    is_balanced: bool,
    /// N/m
    weakest: f64,
}

impl Found {
    fn new(places: &Places<'_>, x: Vec<f64>, is_balanced: bool) -> Self {
        let u = phasors(&x);
        let weakest = places.stiffnesses(&u).into_iter().fold(f64::INFINITY, f64::min);
        Self { keeps_foci: places.keeps_foci(&u), x, is_balanced, weakest }
    }

    fn holds(&self) -> bool {
        self.keeps_foci && self.is_balanced && self.weakest > 0.0
    }

    /// Order of drives by holding the beads, and then by stiffness.
    fn order(&self, other: &Self) -> Ordering {
        let rank = |found: &Self| (found.keeps_foci, found.holds());
        rank(self).cmp(&rank(other)).then(self.weakest.total_cmp(&other.weakest))
    }

    fn raise(&mut self, other: Self) {
        if other.order(self).is_gt() {
            *self = other;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acoustics::Aperture;
    use crate::drive::Drive;
    use crate::force::Levitation;
    use crate::force::modes;
    use crate::scene::{Bead, Target, outline};
    use crate::scene::{Scene, Shape, Trap};
    use glam::DVec3;

    /// A trap before a board of 4 x 4 elements.
    pub(super) fn before_board(trap: Trap) -> Scene {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (4, 4);
        scene.targets = vec![Target::new(Shape::Trap { at: DVec3::Z * 0.05, trap, charge: 1 })];
        scene
    }

    fn levitation(scene: &Scene, aperture: &Aperture, u: &[Complex64]) -> Levitation {
        Levitation::new(scene, aperture, &[Drive::of(aperture.positions.len(), &aperture.driven, u)])
    }

    #[test]
    fn the_weakest_stiffness_is_that_of_a_bead_in_the_trap() {
        let scene = before_board(Trap::Twin);
        let aperture = Aperture::new(&scene);
        let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
        let traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let bead = levitation(&scene, &aperture, &start);
        let expected = modes(&bead.forces(DVec3::Z * 0.05).symmetric())[0].stiffness;
        let [own] = traps.weakest(&aperture, &start)[..] else { panic!("one trap") };
        assert!((own - expected).abs() < 1e-6 * expected.abs(), "{own}, not {expected} N/m");
    }

    #[test]
    fn a_drive_that_goes_on_balances_with_little_change() {
        let mut scene = before_board(Trap::Twin);
        (scene.array.rows, scene.array.columns, scene.array.strength) = (8, 8, 6.0);
        scene.bead = Bead { radius: 0.001, ..Bead::default() };
        let aperture = Aperture::new(&scene);
        let at = |x: f64| DVec3::new(x, 0.0, 0.05);
        let solve = |x: f64, before: Option<&[Complex64]>| {
            let mut scene = scene.clone();
            scene.targets[0].shape = Shape::Trap { at: at(x), trap: Trap::Twin, charge: 1 };
            let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
            let traps = problem.traps.as_ref().unwrap();
            let found = match before {
                Some(before) => best_from(&problem, traps, before),
                None => best(&problem, traps, Duration::ZERO),
            };
            let net = levitation(&scene, &aperture, &found.values);
            let off = net.net(at(x)).length() / net.load;
            assert!(off < 1e-4, "{x}: {off} weights");
            assert!(traps.weakest(&aperture, &found.values)[0] > 0.0, "{x}");
            found.values
        };
        let mut before = solve(0.0, None);
        for i in 1..=8 {
            let onward = solve(5e-4 * f64::from(i), Some(&before));
            // Apart from a common phase.
            let along = onward.iter().zip(&before).map(|(u, v)| u * v.conj()).sum::<Complex64>();
            let alike = along.norm() / before.len() as f64;
            assert!(alike > 0.7, "step {i}: {alike}");
            before = onward;
        }
    }
}
