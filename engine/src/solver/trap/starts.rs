//! First drives of traps: by signature, by lobes with prescribed phases, or scattered.

use std::f64::consts::{FRAC_PI_4, TAU};
use std::ops::Range;

use glam::{DQuat, DVec3};
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::gauge;
use crate::scene::Trap;
use crate::solver::starts::scatter;
use crate::solver::trap::Traps;
use crate::solver::trap::traps::Wanted;
use crate::solver::{iteration, problem::Problem};

/// Weighted Gerchberg-Saxton's steps on lobes.
const ITERATIONS: usize = 60;
/// Kinds of traps, with charge and angle (rad) about the axis, that are tried beside those that the scene names.
const KINDS: [(Trap, i32, f64); 7] = [
    (Trap::Twin, 1, 0.0),
    (Trap::Twin, 1, FRAC_PI_4),
    (Trap::Vortex, 1, 0.0),
    (Trap::Vortex, 2, 0.0),
    (Trap::Bottle, 1, 0.0),
    (Trap::Focus, 1, 0.0),
    (Trap::Standing, 1, 0.0),
];

/// The first drive of the kinds that the scene names: for a single trap its signature on focusing phases, for several
/// their lobes with prescribed phases.
pub fn signature(problem: &Problem<'_>, traps: &Traps) -> Vec<Complex64> {
    of(problem, &traps.traps, None)
}

/// The drive of the kinds that the scene names, of traps that turn; it continues from another drive, if that is not
/// empty.
pub fn onward(problem: &Problem<'_>, traps: &Traps, before: &[Complex64]) -> Vec<Complex64> {
    of(problem, &traps.traps, Some(before))
}

/// First drives of other kinds than the scene's.
pub fn others(problem: &Problem<'_>, traps: &Traps) -> impl Iterator<Item = Vec<Complex64>> {
    let is_named = move |(trap, charge, angle): &(Trap, i32, f64)| {
        *angle == 0.0 && traps.traps.iter().all(|own| own.trap == *trap && own.charge == *charge)
    };
    let all_of = move |(trap, charge, angle): (Trap, i32, f64)| {
        let of = |own: &Wanted| Wanted {
            trap,
            charge,
            turn: own.turn * DQuat::from_rotation_z(angle),
            ..own.clone()
        };
        let wanted: Vec<_> = traps.traps.iter().map(of).collect();
        self::of(problem, &wanted, None)
    };
    KINDS.into_iter().filter(move |kind| !is_named(kind)).map(all_of)
}

/// The first drive of standing waves, if the scene names others.
pub fn standing(problem: &Problem<'_>, traps: &Traps) -> Option<Vec<Complex64>> {
    let is_named = traps.traps.iter().all(|trap| trap.trap == Trap::Standing);
    let wanted: Vec<_> =
        traps.traps.iter().map(|own| Wanted { trap: Trap::Standing, ..own.clone() }).collect();
    (!is_named).then(|| of(problem, &wanted, None))
}

/// Whether elements face the trap from both sides.
pub(super) fn is_between(aperture: &Aperture, trap: &Wanted) -> bool {
    let above = |&n: &usize| (trap.turn.inverse() * (aperture.positions[n] - trap.at)).z > 0.0;
    let count = aperture.driven.iter().filter(|n| above(n)).count();
    count != 0 && count != aperture.driven.len()
}

/// A first drive of phases without order, another for every number.
pub fn scattered(elements: usize, number: usize) -> Vec<Complex64> {
    // Squares, whose golden parts have no order among neighbours, unlike those of the numbers.
    (0..elements).map(|n| Complex64::cis(TAU * scatter((n + 1) * (n + 1) * (number + 1)))).collect()
}

fn of(problem: &Problem<'_>, traps: &[Wanted], before: Option<&[Complex64]>) -> Vec<Complex64> {
    match traps {
        [alone] if alone.foci.len() == problem.foci.len() && !needs_lobes(problem.aperture, alone) => {
            by_signature(problem.aperture, alone, before.is_some())
        }
        _ => by_lobes(problem, traps, before.unwrap_or_default()),
    }
}

/// With all elements on one side, a standing wave cannot be made by a phase difference between sides.
fn needs_lobes(aperture: &Aperture, trap: &Wanted) -> bool {
    trap.trap == Trap::Standing && !is_between(aperture, trap)
}

fn by_signature(aperture: &Aperture, trap: &Wanted, is_gradual: bool) -> Vec<Complex64> {
    let place = |n: usize| trap.turn.inverse() * (aperture.positions[n] - trap.at);
    let mut radii: Vec<_> = aperture.driven.iter().map(|&n| place(n).truncate().length()).collect();
    radii.sort_by(f64::total_cmp);
    // Rounding must not exclude elements of a ring.
    let radius = radii[(radii.len() - 1) / 2] * (1.0 + 1e-9);
    let of = |&n: &usize| {
        let phase = aperture.element.wavenumber * place(n).length();
        let signature = if is_gradual { Trap::gradual_signature } else { Trap::signature };
        Complex64::cis(phase + signature(trap.trap, trap.charge, trap.phase, place(n), radius))
    };
    aperture.driven.iter().map(of).collect()
}

/// Weighted Gerchberg-Saxton with one free phase per trap, common to its lobes; at first that of a drive before, if
/// there is one.
fn by_lobes(problem: &Problem<'_>, traps: &[Wanted], before: &[Complex64]) -> Vec<Complex64> {
    let is_lobe = |i: &usize| traps.iter().any(|trap| trap.foci.contains(i));
    // Points with their targets and phases, trap by trap and then focus by focus.
    let (mut places, mut targets, mut fixed): (Vec<DVec3>, Vec<f64>, Vec<f64>) = Default::default();
    let mut groups: Vec<Range<usize>> = Vec::new();
    for trap in traps {
        let lobes = trap.trap.lobes(trap.charge, problem.aperture.wavelength());
        groups.push(places.len()..places.len() + lobes.len());
        places.extend(lobes.iter().map(|lobe| trap.at + trap.turn * lobe.at));
        targets.extend(lobes.iter().map(|_| problem.foci[trap.foci.start].target));
        fixed.extend(lobes.iter().map(|lobe| trap.trap.shifted(trap.phase, lobe.phase)));
    }
    for i in (0..problem.foci.len()).filter(|i| !is_lobe(i)) {
        groups.push(places.len()..places.len() + 1);
        places.push(problem.foci[i].position);
        targets.push(problem.foci[i].target);
        fixed.push(0.0);
    }
    let transfer = problem.aperture.transfer(&places);
    let mut weights = targets.clone();
    // Neighbours that start a golden angle apart help each other more often than in phase.
    let mut free: Vec<f64> = (0..groups.len()).map(|i| 2.4 * i as f64).collect();
    let align = |free: &mut Vec<f64>, heard: &[Complex64], weights: &[f64]| {
        for (group, phase) in groups.iter().zip(free) {
            let common: Complex64 =
                group.clone().map(|i| heard[i] * Complex64::cis(-fixed[i]) * weights[i]).sum();
            *phase = common.arg();
        }
    };
    if !before.is_empty() {
        align(&mut free, &transfer.pressure(before), &weights);
    }
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
        align(&mut free, &heard, &weights);
        let relative: Vec<_> = heard.iter().zip(&targets).map(|(p, target)| p.norm() / target).collect();
        let mean = relative.iter().sum::<f64>() / relative.len() as f64;
        for (weight, relative) in weights.iter_mut().zip(&relative) {
            *weight *= (mean / relative).sqrt().min(2.0);
        }
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Board, outline};
    use crate::solver::trap::tests::before_board;

    #[test]
    fn only_a_standing_wave_with_all_elements_on_one_side_needs_its_lobes() {
        let above = Board { at: DVec3::Z * 0.1, normal: DVec3::NEG_Z, ..Board::default() };
        for (trap, boards, expected) in [
            (Trap::Standing, vec![Board::default()], true),
            (Trap::Standing, vec![above.clone()], true),
            (Trap::Standing, vec![Board::default(), above], false),
            (Trap::Twin, vec![Board::default()], false),
        ] {
            let scene = crate::scene::Scene { boards, ..before_board(trap) };
            let aperture = Aperture::new(&scene);
            let traps = Traps::of_scene(&scene, &aperture, &outline::foci(&scene).unwrap()).unwrap();
            assert_eq!(needs_lobes(&aperture, &traps.traps[0]), expected, "{trap:?}, {:?}", scene.boards);
        }
    }
}
