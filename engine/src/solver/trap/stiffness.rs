//! The stiffness of traps in balance: the function whose minimum is the drive of traps.
//!
//! It is the negative soft minimum of the principal stiffnesses of all traps under the constraint that force and
//! weight are in balance at each, by the method of multipliers (Nocedal & Wright, Numerical Optimization, algorithm
//! 17.4): f = -softmin K + λ·c + μ/2 c·c, with the net forces c, and λ corrected by μc between descents.
//! [`Stiffness::balanced`] then removes the rest of c by the smallest change of phases.

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::acoustics::{PartialWaves, Transfer};
use crate::force::{Mode, Sphere, modes};
use crate::solver::cholesky::Factor;
use crate::solver::descent::{Function, dot};
use crate::solver::problem::Problem;

/// Sharpness of the soft minimum of stiffnesses.
const HARD: f64 = 12.0;
/// Weight of the pressures of foci beside traps.
const BESIDE: f64 = 1.0;
/// Weight of the square of net forces at first, and its growth if they do not fall to a quarter.
const PENALTY: f64 = 1.0;
const GROWTH: f64 = 4.0;
const MOST_PENALTY: f64 = 1e4;
/// Newton's steps to balance, at most, and the largest change of a phase (rad) in one of them.
const ROUNDS: usize = 20;
const LONGEST: f64 = 0.5;
/// Net forces in balance, in units of stiffness over wavenumber: a bead rests this part of a radian of the wave away.
const BALANCED: f64 = 1e-9;

/// Traps and foci beside them, as functions of the drive.
#[derive(Debug)]
pub struct Places<'a> {
    sphere: Sphere,
    /// N, towards -z.
    load: f64,
    wavenumber: f64,
    /// Every element's partial waves about each trap, in rows.
    columns: Vec<Transfer>,
    transfer: &'a Transfer,
    /// Foci that are not lobes, with the squares of their initial pressures.
    foci: Vec<(usize, f64)>,
}

impl<'a> Places<'a> {
    /// Places of a bead with this weight less buoyancy (N) in traps at these points (m), beside foci that keep the
    /// pressure of a first drive.
    pub fn new(
        problem: &'a Problem<'_>,
        (sphere, load): (Sphere, f64),
        traps: &[DVec3],
        foci: Vec<usize>,
        first: &[Complex64],
    ) -> Self {
        let aperture = problem.aperture;
        let order = sphere.order() + 1;
        let columns = traps.iter().map(|&at| aperture.partial_waves(order, (at, sphere.shell()))).collect();
        let foci = if foci.is_empty() {
            Vec::new()
        } else {
            let heard = problem.transfer.pressure(first);
            foci.into_iter().map(|i| (i, heard[i].norm_sqr())).collect()
        };
        let wavenumber = aperture.element.wavenumber;
        Self { sphere, load, wavenumber, columns, transfer: &problem.transfer, foci }
    }

    fn sounds(&self, u: &[Complex64]) -> Vec<PartialWaves> {
        let order = self.sphere.order() + 1;
        let of = |columns: &Transfer| PartialWaves::with(order, self.wavenumber, columns.pressure(u));
        self.columns.iter().map(of).collect()
    }

    /// Slope by the conjugate drive, from that by the sound at a trap.
    fn spread(&self, trap: usize, slope: &PartialWaves) -> Vec<Complex64> {
        self.columns[trap].back(slope.values())
    }

    /// N, of sound and weight at every trap.
    fn net(&self, sounds: &[PartialWaves]) -> Vec<f64> {
        let of = |sound: &PartialWaves| (self.sphere.force(sound) - DVec3::Z * self.load).to_array();
        sounds.iter().flat_map(of).collect()
    }

    /// Whether foci beside the traps nearly keep their initial pressures.
    pub fn keeps_foci(&self, u: &[Complex64]) -> bool {
        const LEAST: f64 = 0.8;
        if self.foci.is_empty() {
            return true;
        }
        let heard = self.transfer.pressure(u);
        self.foci.iter().all(|&(i, square)| heard[i].norm_sqr() >= LEAST * square)
    }

    /// N/m, the principal stiffnesses of all traps.
    pub fn stiffnesses(&self, u: &[Complex64]) -> Vec<f64> {
        let of = |sound: PartialWaves| {
            let stiffness = self.sphere.stiffness(&sound);
            modes(&((stiffness + stiffness.transpose()) * 0.5)).map(|mode| mode.stiffness)
        };
        self.sounds(u).into_iter().flat_map(of).collect()
    }
}

/// The function to minimise, on phases.
#[derive(Clone, Debug)]
pub struct Stiffness<'a> {
    places: &'a Places<'a>,
    /// N/m, of the first drive: the unit.
    unit: f64,
    /// λ and μ, of net forces in units of stiffness over wavenumber.
    multipliers: Vec<f64>,
    penalty: f64,
    /// The largest net force at the last correction.
    largest: f64,
}

impl<'a> Stiffness<'a> {
    pub fn new(places: &'a Places<'a>, start: &[Complex64]) -> Self {
        let all = places.stiffnesses(start);
        let mean = all.iter().map(|stiffness| stiffness.abs()).sum::<f64>() / all.len() as f64;
        Self {
            places,
            unit: mean.max(f64::MIN_POSITIVE),
            multipliers: vec![0.0; all.len()],
            penalty: PENALTY,
            largest: f64::INFINITY,
        }
    }

    /// The same with a small penalty instead of the constraint, for beads too heavy for any drive.
    pub fn yielding(self) -> Self {
        /// Weight of the square of net forces.
        const COUNTS: f64 = 0.02;
        Self { penalty: 2.0 * COUNTS, ..self }
    }

    /// 1/N: from net forces to their unit.
    fn per_force(&self) -> f64 {
        self.places.wavenumber / self.unit
    }

    /// Corrects the multipliers by the net forces that are left.
    pub fn correct(&mut self, x: &[f64]) {
        let scale = self.per_force();
        let net = self.places.net(&self.places.sounds(&phasors(x)));
        let largest = net.iter().fold(0.0, |most: f64, net| most.max((net * scale).abs()));
        for (multiplier, net) in self.multipliers.iter_mut().zip(&net) {
            *multiplier += self.penalty * net * scale;
        }
        if largest > self.largest / GROWTH {
            self.penalty = (self.penalty * GROWTH).min(MOST_PENALTY);
        }
        self.largest = largest;
    }

    /// The multipliers with which phases in balance are nearest to a minimum, by least squares, and the first penalty
    /// (Nocedal & Wright, equation 18.22).
    pub fn estimate(&mut self, x: &[f64]) {
        let places = self.places;
        let u = phasors(x);
        let rows = self.jacobian(&u, &places.sounds(&u));
        self.multipliers.fill(0.0);
        self.penalty = PENALTY;
        self.largest = f64::INFINITY;
        let mut gradient = vec![0.0; x.len()];
        self.evaluate(x, &mut gradient);
        let against: Vec<_> = rows.iter().map(|row| -dot(row, &gradient)).collect();
        if let Some(factor) = normal(&rows) {
            let scale = self.per_force();
            self.multipliers = factor.solve(&against).iter().map(|own| own / scale).collect();
        }
    }

    /// The nearest phases at which force and weight are in balance at every trap, by Newton's steps of least length;
    /// `None` where they lead to no balance.
    pub fn balanced(&self, x: &[f64]) -> Option<Vec<f64>> {
        let places = self.places;
        let scale = self.per_force();
        let mut x = x.to_vec();
        for _ in 0..ROUNDS {
            let u = phasors(&x);
            let sounds = places.sounds(&u);
            let net = places.net(&sounds);
            if !net.iter().all(|net| net.is_finite()) {
                return None;
            }
            if net.iter().all(|net| (net * scale).abs() < BALANCED) {
                return Some(x);
            }
            let rows = self.jacobian(&u, &sounds);
            let back = normal(&rows)?.solve(&net);
            let mut step = vec![0.0; x.len()];
            for (row, back) in rows.iter().zip(&back) {
                step.iter_mut().zip(row).for_each(|(step, slope)| *step -= back * slope);
            }
            let longest = step.iter().fold(0.0, |most: f64, step| most.max(step.abs()));
            let part = if longest > LONGEST { LONGEST / longest } else { 1.0 };
            x.iter_mut().zip(&step).for_each(|(x, step)| *x += part * step);
        }
        None
    }

    /// The slopes of all net forces by phases, a row per component.
    fn jacobian(&self, u: &[Complex64], sounds: &[PartialWaves]) -> Vec<Vec<f64>> {
        let places = self.places;
        let of = |(trap, sound): (usize, &PartialWaves)| {
            let slope = |axis| places.sphere.response(sound, axis);
            DVec3::AXES.map(|axis| by_phases(&places.spread(trap, &slope(axis)), u))
        };
        sounds.iter().enumerate().flat_map(of).collect()
    }
}

/// The products of rows with each other. Dependent rows would leave the matrix singular.
fn normal(rows: &[Vec<f64>]) -> Option<Factor> {
    let trace = rows.iter().map(|row| dot(row, row)).sum::<f64>();
    let entry = |i: usize, j: usize| dot(&rows[i], &rows[j]) + if i == j { 1e-13 * trace } else { 0.0 };
    Factor::new(rows.len(), entry)
}

/// e^{jx}
pub fn phasors(x: &[f64]) -> Vec<Complex64> {
    x.iter().map(|phase| Complex64::cis(*phase)).collect()
}

/// The slope by each phase, of slopes by conjugate drives.
fn by_phases(slopes: &[Complex64], u: &[Complex64]) -> Vec<f64> {
    slopes.iter().zip(u).map(|(slope, u)| (slope.conj() * Complex64::I * u).re).collect()
}

impl Function for Stiffness<'_> {
    fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let places = self.places;
        let u = phasors(x);
        let sounds = places.sounds(&u);
        let of_trap = |sound: &PartialWaves| {
            let stiffness = places.sphere.stiffness(sound);
            modes(&((stiffness + stiffness.transpose()) * 0.5))
        };
        let modes: Vec<[Mode; 3]> = sounds.iter().map(of_trap).collect();
        let all = || modes.iter().flatten().map(|mode| mode.stiffness / self.unit);
        let lowest = all().fold(f64::INFINITY, f64::min);
        let share = |value: f64| (-HARD * (value - lowest)).exp();
        let sum: f64 = all().map(share).sum();
        let mut value = -(lowest - sum.ln() / HARD);
        let scale = self.per_force();
        let mut slopes = Vec::with_capacity(sounds.len());
        for (trap, (sound, modes)) in sounds.iter().zip(&modes).enumerate() {
            let mut of_stiffness = DMat3::ZERO;
            for Mode { stiffness, direction: v } in modes {
                let part = share(stiffness / self.unit) / sum;
                of_stiffness -= DMat3::from_cols(*v * v.x, *v * v.y, *v * v.z) * (part / self.unit);
            }
            let net = (places.sphere.force(sound) - DVec3::Z * places.load) * scale;
            let mut of_force = DVec3::ZERO;
            for axis in 0..3 {
                let multiplier = self.multipliers[3 * trap + axis];
                value += multiplier * net[axis] + 0.5 * self.penalty * net[axis] * net[axis];
                of_force[axis] = (multiplier + self.penalty * net[axis]) * scale;
            }
            slopes.push(places.sphere.gradient(sound, of_stiffness, of_force));
        }
        let mut turned = vec![Complex64::ZERO; u.len()];
        for (trap, slope) in slopes.iter().enumerate() {
            turned.iter_mut().zip(places.spread(trap, slope)).for_each(|(sum, own)| *sum += own);
        }
        if !places.foci.is_empty() {
            let heard = places.transfer.pressure(&u);
            let mut back = vec![Complex64::ZERO; heard.len()];
            for &(i, square) in &places.foci {
                let off = (heard[i].norm_sqr() / square.max(f64::MIN_POSITIVE) - 1.0).min(0.0);
                value += BESIDE * off * off;
                back[i] = heard[i] * (4.0 * BESIDE * off / square.max(f64::MIN_POSITIVE));
            }
            turned.iter_mut().zip(places.transfer.back(&back)).for_each(|(sum, own)| *sum += own);
        }
        gradient.copy_from_slice(&by_phases(&turned, &u));
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::{Bead, Board, Scene, Shape, Target, Trap, outline};
    use crate::solver::trap::tests::before_board;
    use crate::solver::trap::{Traps, places, signature};

    /// A function at some phases beside its start.
    fn beside_start<T>(scene: &Scene, try_out: impl Fn(&mut Stiffness<'_>, Vec<f64>) -> T) -> T {
        let aperture = Aperture::new(scene);
        let problem = Problem::of_scene(scene, &aperture, outline::foci(scene).unwrap());
        let traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let places = places(traps, &problem, &start);
        let x = start.iter().enumerate().map(|(n, u)| u.arg() + 0.3 * (n as f64).sin()).collect();
        try_out(&mut Stiffness::new(&places, &start), x)
    }

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
        beside_start(&scene, |function, x| {
            // The focus is weaker than at the start, which counts.
            let (i, square) = function.places.foci[0];
            let part = function.places.transfer.pressure(&phasors(&x))[i].norm_sqr() / square;
            assert!(part < 0.99, "{part}");
            function.correct(&x);
            assert!(function.multipliers.iter().all(|multiplier| *multiplier != 0.0), "{function:?}");
            let (mut gradient, mut unused) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            function.evaluate(&x, &mut gradient);
            for n in [0, 7, 21, 39] {
                let mut at = |step: f64| {
                    let mut x = x.clone();
                    x[n] += step;
                    function.evaluate(&x, &mut unused)
                };
                let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
                let own = gradient[n];
                assert!((slope - own).abs() < 1e-6 * (1.0 + slope.abs()), "{n}: {slope}, not {own}");
            }
        });
    }

    #[test]
    fn balanced_phases_carry_the_weight_at_every_trap() {
        let mut scene = before_board(Trap::Twin);
        (scene.array.rows, scene.array.columns, scene.array.strength) = (8, 8, 6.0);
        scene.bead.radius = 0.001;
        beside_start(&scene, |function, x| {
            let places = function.places;
            let net = |x: &[f64]| places.net(&places.sounds(&phasors(x)));
            assert!(net(&x).iter().any(|net| net.abs() > 0.1 * places.load), "{:?}", net(&x));
            let balanced = function.balanced(&x).expect("a balance");
            assert!(net(&balanced).iter().all(|net| net.abs() < 1e-6 * places.load), "{:?}", net(&balanced));
        });
    }

    #[test]
    fn estimated_multipliers_leave_no_slope_towards_other_forces() {
        let mut scene = before_board(Trap::Twin);
        (scene.array.rows, scene.array.columns, scene.array.strength) = (8, 8, 6.0);
        scene.bead.radius = 0.001;
        beside_start(&scene, |function, x| {
            let x = function.balanced(&x).expect("a balance");
            let rows = function.jacobian(&phasors(&x), &function.places.sounds(&phasors(&x)));
            let mut steepest = || {
                let mut gradient = vec![0.0; x.len()];
                function.evaluate(&x, &mut gradient);
                let of = |row: &Vec<f64>| {
                    dot(row, &gradient).abs() / (dot(row, row) * dot(&gradient, &gradient)).sqrt()
                };
                let steepest = rows.iter().map(of).fold(0.0, f64::max);
                function.estimate(&x);
                steepest
            };
            let [before, after] = [steepest(), steepest()];
            assert!(before > 0.01 && after < 1e-6, "{before}, {after}");
        });
    }

    #[test]
    fn no_phases_balance_a_bead_that_is_too_heavy() {
        let mut scene = before_board(Trap::Twin);
        scene.bead.density = Some(1e5);
        beside_start(&scene, |function, x| assert_eq!(function.balanced(&x), None));
    }

    #[test]
    fn a_focus_that_no_element_reaches_is_kept() {
        let mut scene = before_board(Trap::Twin);
        scene.targets.push(Target::new(Shape::Point { at: DVec3::new(0.01, 0.0, 0.05) }));
        let aperture = Aperture::new(&scene);
        let mut foci = outline::foci(&scene).unwrap();
        // Behind the array.
        foci.last_mut().unwrap().position.z = -0.05;
        let problem = Problem::of_scene(&scene, &aperture, foci);
        let traps: &Traps = problem.traps.as_ref().unwrap();
        let start = signature(&problem, traps);
        let places = places(traps, &problem, &start);
        assert!(matches!(places.foci[..], [(_, square)] if square == 0.0), "{:?}", places.foci);
        assert!(places.keeps_foci(&start));
    }
}
