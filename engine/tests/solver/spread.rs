//! Elements that differ at random: the closed forms of every figure against arrays that were drawn.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::{Aperture, Ensemble, Transfer};
use sonoglyph::field::{Evaluator, SideLobe, Stages};
use sonoglyph::scene::{Array, Method, Plane, Scene, Shape, Solver, Spread, Target};
use sonoglyph::solver::{self, Problem, Ranges};

use crate::dice::Dice;

const DRAWS: usize = 2000;
/// Draws for side lobes, over a window of 100 mm in steps of 1.25 mm, of the larger spread: they take most of the time.
const FEWER: usize = 400;
const SIDE: usize = 81;
const WINDOW: f64 = 0.1;

/// The factors of the elements of one array.
fn draw(dice: &mut Dice, elements: usize, spread: Spread) -> Vec<Complex64> {
    let mut pair = || {
        let radius = (-2.0 * (1.0 - dice.unit()).ln()).sqrt();
        let angle = TAU * dice.unit();
        (radius * angle.cos(), radius * angle.sin())
    };
    let factor = |(gain, phase)| Complex64::from_polar(1.0 + spread.gain * gain, spread.phase * phase);
    (0..elements).map(|_| factor(pair())).collect()
}

fn moduli(transfer: &Transfer, u: &[Complex64]) -> Vec<f64> {
    transfer.pressure(u).iter().map(|p| p.norm()).collect()
}

fn ring() -> Vec<DVec3> {
    let at = |n: usize| 0.02 * DVec2::from_angle(TAU * n as f64 / 8.0);
    (0..8).map(|n| at(n).extend(0.1)).collect()
}

fn square() -> Vec<DVec3> {
    let at = |n: usize| {
        let along = 0.015 * (n % 4) as f64 - 0.03;
        let [x, y] = [[along, -0.03], [0.03, along], [-along, 0.03], [-0.03, -along]][n / 4];
        dvec3(x, y, 0.1)
    };
    (0..16).map(at).collect()
}

fn scene(foci: &[DVec3], spread: Spread) -> Scene {
    Scene {
        array: Array { spread, ..Array::default() },
        targets: foci.iter().map(|&at| Target::new(Shape::Point { at })).collect(),
        solver: Solver { method: Method::Wgs, iterations: 200, ..Solver::default() },
        plane: Plane { size: DVec2::splat(WINDOW), ..Plane::default() },
        ..Scene::default()
    }
}

/// 5, 50 and 95 % of what was drawn.
fn quantiles(mut drawn: Vec<f64>) -> [f64; 3] {
    drawn.sort_by(f64::total_cmp);
    [0.05, 0.5, 0.95].map(|level| drawn[(level * drawn.len() as f64) as usize])
}

/// Cells of the window that are outside the main lobes: where paths differ by a third of a wavelength, rms.
fn outside(aperture: &Aperture, transfer: &Transfer, foci: &[DVec3]) -> Vec<Option<DVec3>> {
    let place = |n: usize| WINDOW * (n as f64 / (SIDE - 1) as f64 - 0.5);
    let is_outside = |&at: &DVec3| {
        foci.iter().zip(transfer.rows()).all(|(focus, row)| {
            let paths = aperture.positions.iter().map(|it| it.distance(at) - it.distance(*focus));
            let mut sums = [0.0; 3];
            for (path, weight) in paths.zip(row.map(|h| h.norm())) {
                sums[0] += weight;
                sums[1] += weight * path;
                sums[2] += weight * path * path;
            }
            let mean = sums[1] / sums[0];
            (sums[2] / sums[0] - mean * mean).max(0.0).sqrt() >= aperture.wavelength() / 3.0
        })
    };
    (0..SIDE * SIDE).map(|i| Some(dvec3(place(i % SIDE), place(i / SIDE), 0.1)).filter(is_outside)).collect()
}

/// The loudest local maximum outside.
fn loudest(moduli: &[f64], outside: &[Option<DVec3>]) -> f64 {
    let is_maximum = |i: usize| {
        let (x, y) = (i % SIDE, i / SIDE);
        (y.saturating_sub(1)..(y + 2).min(SIDE))
            .all(|y| (x.saturating_sub(1)..(x + 2).min(SIDE)).all(|x| moduli[y * SIDE + x] <= moduli[i]))
    };
    let maxima = (0..moduli.len()).filter(|&i| outside[i].is_some() && is_maximum(i));
    maxima.map(|i| moduli[i]).fold(0.0, f64::max)
}

#[test]
fn ranges_of_figures_are_those_of_drawn_arrays() {
    let place = |n: usize| WINDOW * (n as f64 / (SIDE - 1) as f64 - 0.5);
    for (name, foci) in [("one", vec![DVec3::Z * 0.1]), ("ring", ring()), ("square", square())] {
        for degrees in [10.0f64, 25.2] {
            let spread = Spread { gain: 0.1, phase: degrees.to_radians() };
            let scene = scene(&foci, spread);
            let aperture = Aperture::new(&scene);
            let mut solution = solver::solve(&scene).unwrap();
            let problem = Problem::of_scene(&scene, &aperture, solution.foci.clone());
            solution.judge(&scene, &problem);
            let figures = solution.figures.unwrap();
            let lobe = SideLobe {
                position: figures.side_lobe_position,
                pressure: figures.side_lobe * solution.quality.mean_pressure,
                part: figures.side_lobe,
            };
            let mut stages = Stages::new(Evaluator::Cpu);
            let ranges = Ranges::new(&scene, &problem, (&solution, Some(&lobe)), &mut stages).unwrap();

            let u = solution.drive.excitation(&aperture.driven);
            let points: Vec<_> =
                (0..SIDE * SIDE).map(|i| dvec3(place(i % SIDE), place(i / SIDE), 0.1)).collect();
            let (window, outside) =
                (aperture.transfer(&points), outside(&aperture, &problem.transfer, &foci));
            let mut drawn: [Vec<f64>; 5] = Default::default();
            let mut dice = Dice::seeded(0x5eed);
            for number in 0..DRAWS {
                let factors = draw(&mut dice, u.len(), spread);
                let played: Vec<_> = u.iter().zip(factors).map(|(u, factor)| u * factor).collect();
                let at_foci = moduli(&problem.transfer, &played);
                let mean = at_foci.iter().sum::<f64>() / at_foci.len() as f64;
                let least = at_foci.iter().copied().fold(f64::INFINITY, f64::min);
                let square = at_foci.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / at_foci.len() as f64;
                for (drawn, value) in drawn.iter_mut().zip([mean, least, square.sqrt() / mean, least / mean])
                {
                    drawn.push(value);
                }
                if number < FEWER && degrees > 20.0 {
                    drawn[4].push(loudest(&moduli(&window, &played), &outside) / mean);
                }
            }
            let nominal = solution.quality.mean_pressure;
            let [mean, least, uniformity, evenness, side_lobe] = drawn;
            let mean_drawn = mean.iter().sum::<f64>() / mean.len() as f64;
            assert!(
                (ranges.mean_pressure[1] - mean_drawn).abs() < 0.003 * nominal,
                "{name}, {degrees}°: mean"
            );
            let all = [
                (
                    "mean",
                    ranges.mean_pressure.map(|p| p / nominal),
                    mean.iter().map(|p| p / nominal).collect(),
                    0.003,
                ),
                (
                    "weakest",
                    ranges.min_pressure.map(|p| p / nominal),
                    least.iter().map(|p| p / nominal).collect(),
                    0.006,
                ),
                ("uniformity", ranges.spread, uniformity, 0.006),
                ("evenness", ranges.evenness, evenness, 0.006),
                ("side lobe", ranges.side_lobe.unwrap(), side_lobe, 0.018),
            ];
            for (figure, closed, drawn, most) in all.into_iter().filter(|all| !all.2.is_empty()) {
                let drawn = quantiles(drawn);
                let off = closed.iter().zip(drawn).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < most, "{name}, {degrees}°, {figure}: {closed:.4?}, drawn {drawn:.4?}");
            }
        }
    }
}

#[test]
fn pressures_beside_foci_have_rician_quantiles() {
    let spread = Spread { gain: 0.2, phase: 0.5 };
    let aperture = Aperture::new(&Scene::default());
    let focus = DVec3::Z * 0.1;
    let u: Vec<_> = aperture.transfer(&[focus]).row(0).map(|h| (h / h.norm()).conj()).collect();
    // The focus, its slope, a side lobe, and nearly silent places.
    let places = [0.0, 0.003, 0.0047, 0.011, 0.021, 0.043].map(|x| focus + DVec3::X * x);
    let transfer = aperture.transfer(&places);
    let ensemble = Ensemble::new(&transfer, &u, spread);
    let mut dice = Dice::seeded(7);
    let mut drawn = vec![Vec::new(); places.len()];
    for _ in 0..DRAWS {
        let factors = draw(&mut dice, u.len(), spread);
        let played: Vec<_> = u.iter().zip(factors).map(|(u, factor)| u * factor).collect();
        drawn.iter_mut().zip(moduli(&transfer, &played)).for_each(|(drawn, p)| drawn.push(p));
    }
    let peak = moduli(&transfer, &u)[0];
    for ((closed, drawn), place) in ensemble.quantiles().zip(drawn).zip(places) {
        let drawn = quantiles(drawn);
        let off = closed.iter().zip(drawn).map(|(a, b)| (a - b).abs() / peak);
        assert!(off.fold(0.0, f64::max) < 0.006, "{place}: {closed:?}, drawn {drawn:?}");
    }
}
