//! Tests of modes: against roots of other equations, and of the boundary conditions.

use num_complex::Complex64;
use strum::VariantArray;

use super::*;
use crate::scene::LiquidName;

/// A liquid with ω² = 2 at q = 1, which is 100 deep, and with this n = ν.
fn deep(viscous: f64) -> Liquid {
    let one = Some(1.0);
    Liquid {
        density: one,
        surface_tension: one,
        viscosity: Some(viscous),
        gravity: 1.0,
        depth: 100.0,
        ..Liquid::default()
    }
}

/// The two roots s/n of Lamb's equation, the slower one first: all four roots x of (x² + 1)² - 4x + (ω/n)² by Durand's and
/// Kerner's iteration, and of these the ones with Re x > 0.
fn lamb(ratio: f64) -> [Complex64; 2] {
    let size = 1.0 + ratio.powf(0.25);
    let mut roots = [0, 1, 2, 3].map(|k| Complex64::from_polar(size, 0.4 + 1.6 * f64::from(k)));
    for _ in 0..400 {
        for i in 0..4 {
            let x = roots[i];
            let others: Complex64 = (0..4).filter(|&j| j != i).map(|j| x - roots[j]).product();
            roots[i] = x - ((x * x + 1.0).powi(2) - 4.0 * x + ratio) / others;
        }
    }
    let mut physical: Vec<_> = roots.iter().filter(|x| x.re > 0.0).map(|x| x * x - 1.0).collect();
    physical.sort_by(|s, t| t.re.total_cmp(&s.re));
    physical.try_into().expect("two roots with Re x > 0")
}

#[test]
fn the_two_roots_are_lambs_from_no_viscosity_to_creep() {
    let critical = 0.581_412_179_607_29_f64;
    let near = [-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3].map(|part| critical * (1.0 + part));
    let far = (-60..=120).map(|tenths| 10f64.powf(f64::from(tenths) / 10.0));
    for ratio in far.chain(near) {
        let viscous = (2.0 / ratio).sqrt();
        let mode = Mode::new(&deep(viscous), 1.0);
        let [slow, fast] = lamb(ratio);
        let damping = -viscous * (slow + fast).re / 2.0;
        let square = viscous * viscous * (slow * fast).re;
        assert!((mode.damping / damping - 1.0).abs() < 1e-8, "{ratio}: {mode:?} {damping}");
        assert!((mode.square / square - 1.0).abs() < 1e-8, "{ratio}: {mode:?} {square}");
        let swing = mode.square - mode.damping.powi(2);
        assert!(
            (mode.swing - swing).abs() < 1e-12 * (mode.square + mode.damping.powi(2)),
            "{ratio}: {mode:?}"
        );
        assert!((ratio / critical - 1.0).abs() < 1e-8 || (mode.swing > 0.0) == (ratio > critical), "{ratio}");
    }
}

#[test]
fn extremes_are_numbers() {
    let Mode { damping, square, swing } = Mode::new(&deep(0.0), 1.0);
    assert!(
        damping == 0.0 && (square - 2.0).abs() < 1e-12 && (swing - 2.0).abs() < 1e-12,
        "{square} {swing}"
    );
    assert_eq!(Mode::new(&deep(1.0), 0.0), Mode { damping: 0.0, square: 0.0, swing: 0.0 });
    for viscosity in [0.0, 5e-324, 1e-3, 1e4] {
        for depth in [5e-324, 1e-9, 1e-3, 100.0] {
            for q in [1e-6, 1.0, 1e3, 1e7] {
                let liquid =
                    Liquid { viscosity: Some(viscosity), density: Some(1.0), depth, ..Liquid::default() };
                let Mode { damping, square, swing } = Mode::new(&liquid, q);
                let is_sound = damping >= 0.0 && square > 0.0 && square.is_finite() && swing.is_finite();
                assert!(is_sound, "{viscosity} Pa·s, {depth} m, {q} 1/m: {damping} {square} {swing}");
            }
        }
    }
}

/// The slow rate of a mode that creeps, 1/s.
fn creep(mode: Mode) -> f64 {
    assert!(mode.swing < 0.0, "{mode:?}");
    mode.square / (mode.damping + (-mode.swing).sqrt())
}

#[test]
fn a_thick_liquid_levels_over_a_floor_as_orchard_says() {
    let q = 300.0f64;
    for depth in [1e-6, 1.66e-5, 1.67e-5, 1e-3, 3e-3, 1e-2, 0.1] {
        let liquid =
            Liquid { name: Some(LiquidName::Glycerol), viscosity: Some(1e4), depth, ..Liquid::default() };
        let restoring = liquid.density() * liquid.gravity + liquid.surface_tension() * q * q;
        let twice = 2.0 * q * depth;
        let orchard = (twice.sinh() - twice) / (twice.cosh() + 1.0 + twice * twice / 2.0);
        let rate = creep(Mode::new(&liquid, q));
        assert!((rate / (restoring / (2e4 * q) * orchard) - 1.0).abs() < 1e-7, "{depth} m: {rate}");
        let film = restoring * q * q * depth.powi(3) / 3e4;
        assert!(depth > 1e-6 || (rate / film - 1.0).abs() < 1e-4, "{rate} {film}");
    }
}

/// The determinant of the boundary conditions at s, in two ways of which one is well-conditioned: with the vertical speed
/// A (cosh q(z + d) - cosh xq(z + d)) + B (sinh q(z + d) - sinh xq(z + d) / x), at rest on the floor, if vorticity fills the
/// liquid; and else with the four speeds e^{qz}, e^{-q(z + d)}, e^{xqz} and e^{-xq(z + d)}.
fn determinant(restoring: f64, n: f64, depth: f64, s: Complex64, fills: bool) -> Complex64 {
    let (x, one) = ((s / n + 1.0).sqrt(), Complex64::from(1.0));
    if fills {
        let [(cosh, sinh), (cosh_x, sinh_x)] = [one, x].map(|x| ((x * depth).cosh(), (x * depth).sinh()));
        let shear = [2.0 * cosh - (x * x + 1.0) * cosh_x, 2.0 * sinh - (x * x + 1.0) * sinh_x / x];
        let speed = [cosh - cosh_x, sinh - sinh_x / x];
        let (slope, pressure) = ([sinh - x * sinh_x, cosh - cosh_x], [sinh, cosh]);
        let normal = [0, 1].map(|i| restoring / s * speed[i] + s * pressure[i] + 2.0 * n * slope[i]);
        return shear[0] * normal[1] - shear[1] * normal[0];
    }
    let (a, b) = (Complex64::from((-depth).exp()), (-x * depth).exp());
    let (weight, shear) = (restoring / s, x * x + 1.0);
    let floor = [[a, one, b, one], [a, -one, x * b, -x]];
    let surface = [
        [2.0 * one, 2.0 * a, shear, shear * b],
        [weight + s + 2.0 * n, (weight - s - 2.0 * n) * a, weight + 2.0 * n * x, (weight - 2.0 * n * x) * b],
    ];
    let minor =
        |rows: &[[Complex64; 4]; 2], i: usize, j: usize| rows[0][i] * rows[1][j] - rows[0][j] * rows[1][i];
    let pairs = [([0, 1], [2, 3]), ([2, 0], [1, 3]), ([0, 3], [1, 2])];
    let both = pairs.into_iter().flat_map(|(own, other)| [(own, other), (other, own)]);
    both.map(|([i, j], [k, l])| minor(&floor, i, j) * minor(&surface, k, l)).sum()
}

/// Distance of s from a root, relative to s, by Newton's step.
fn distance(liquid: &Liquid, q: f64, s: Complex64) -> f64 {
    let n = liquid.viscosity() / liquid.density() * q * q;
    let restoring = liquid.gravity * q + liquid.surface_tension() * q.powi(3) / liquid.density();
    let depth = q * liquid.depth;
    let fills = (s / n + 1.0).sqrt().re * depth < 3.0;
    let determinant = |s: Complex64| determinant(restoring, n, depth, s, fills);
    let by = s * 1e-5;
    let slope = (determinant(s + by) - determinant(s - by)) / (2.0 * by);
    (determinant(s) / slope / s).norm()
}

#[test]
fn modes_over_any_floor_are_roots_of_the_boundary_conditions() {
    let named = |&name: &LiquidName| Liquid { name: Some(name), ..Liquid::default() };
    let oil = Liquid {
        density: Some(975.0),
        surface_tension: Some(0.0205),
        viscosity: Some(9.75),
        ..Liquid::default()
    };
    let liquids = LiquidName::VARIANTS.iter().map(named).chain([oil]);
    let mut kinds = [0; 2];
    for liquid in liquids {
        for depth in [1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.2, 1.0] {
            for part in -20..=20 {
                let q = 10f64.powf(f64::from(part) / 20.0) / liquid.capillary_length();
                let liquid = Liquid { depth, ..liquid.clone() };
                let mode = Mode::new(&liquid, q);
                let s = mode.rates().map_or_else(
                    || Complex64::new(-mode.damping, mode.swing.sqrt()),
                    |[slow, _]| Complex64::from(-slow),
                );
                let off = distance(&liquid, q, s);
                assert!(off < 1e-6, "{:?} {depth} m, {q} 1/m: {s} {off:e}", liquid.name);
                kinds[usize::from(mode.swing < 0.0)] += 1;
            }
        }
    }
    assert!(kinds.iter().all(|&count| count > 100), "waves and creep: {kinds:?}");
}
