//! Plane standing and travelling waves, with the series of the force on a sphere.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use num_complex::Complex64;
use sonoglyph::acoustics::{Air, PartialWaves};
use sonoglyph::force::Sphere;
use sonoglyph::scene::{Bead, Material};

use crate::force::still_air;

/// Spherical Bessel function by its power series.
fn first(n: usize, x: f64) -> f64 {
    let leading: f64 = (0..n).map(|i| x / (2 * i + 3) as f64).product();
    let (mut term, mut sum) = (1.0, 0.0);
    for i in 1..200 {
        sum += term;
        term *= -x * x / (2 * i * (2 * n + 2 * i + 1)) as f64;
    }
    leading * sum
}

/// The second kind, upwards.
fn second(n: usize, x: f64) -> f64 {
    let (mut before, mut this) = (x.sin() / x, -x.cos() / x);
    for i in 0..n {
        (before, this) = (this, (2 * i + 1) as f64 / x * this - before);
    }
    this
}

fn slope(f: impl Fn(usize) -> f64, n: usize, x: f64) -> f64 {
    n as f64 / x * f(n) - f(n + 1)
}

/// Scattering coefficients of a fluid sphere (e^{-jωt}).
fn scattered(n: usize, ka: f64, bead: &Bead, air: &Air) -> Complex64 {
    let within = ka * air.sound_speed / bead.sound_speed();
    let gamma = air.density * air.sound_speed / (bead.density() * bead.sound_speed());
    let (j, j_within) = (first(n, ka), first(n, within));
    let (slope_j, slope_y) = (slope(|n| first(n, ka), n, ka), slope(|n| second(n, ka), n, ka));
    let slope_within = slope(|n| first(n, within), n, within);
    let h = Complex64::new(j, second(n, ka));
    let above = gamma * slope_within * j - j_within * slope_j;
    above / (j_within * Complex64::new(slope_j, slope_y) - gamma * slope_within * h)
}

fn bead_of(ka: f64, material: Material) -> (Bead, Air, f64) {
    let scene = still_air();
    let air = Air::new(&scene.medium, 40e3);
    let k = TAU * 40e3 / air.sound_speed;
    (Bead { radius: ka / k, material, ..Bead::default() }, air, k)
}

const SIZES: [f64; 9] = [0.005, 0.05, 0.1, 0.366, 0.732, 1.5, 2.0, 3.3, 5.0];

#[test]
fn a_standing_wave_has_the_force_of_its_series() {
    for (ka, material) in SIZES.map(|ka| (ka, Material::Eps)).into_iter().chain([(0.4, Material::Water)]) {
        let (bead, air, k) = bead_of(ka, material);
        let sphere = Sphere::new(&bead, &air, k);
        // Hasegawa, JASA 65:32 (1979), per area and mean energy density.
        let s = |n: usize| scattered(n, ka, &bead, &air);
        let term = |n: usize| {
            let (own, next) = (s(n), s(n + 1));
            let sign = if n.is_multiple_of(2) { -1.0 } else { 1.0 };
            sign * (n + 1) as f64 * (own.im * (1.0 + 2.0 * next.re) - next.im * (1.0 + 2.0 * own.re))
        };
        let series: f64 = 4.0 / (ka * ka) * (0..16).map(term).sum::<f64>();
        let energy = 2000f64.powi(2) / (4.0 * air.density * air.sound_speed.powi(2));
        let scale = PI * bead.radius.powi(2) * energy * series;
        let contrast = {
            let (rho, c) = (bead.density() / air.density, bead.sound_speed() / air.sound_speed);
            (1.0 - 1.0 / (rho * c * c)) / 3.0 + (rho - 1.0) / (2.0 * rho + 1.0)
        };
        if ka < 0.01 {
            let small = 4.0 * PI * contrast * k * bead.radius.powi(3) * energy;
            assert!(
                (scale / small - 1.0).abs() < 1e-4,
                "{ka}: {scale} N, and {small} N of a vanishing sphere"
            );
        }
        let largest = PI * bead.radius.powi(2) * energy * (8.0 / (ka * ka)) * s(0).norm().max(s(1).norm());
        for i in 0..6 {
            let z = 0.001 * f64::from(i) - 0.0027;
            let field = |at: &DVec3| Complex64::from_polar(2000.0, 0.4) * (k * at.z).cos();
            let waves = PartialWaves::new(sphere.order() + 6, k, (DVec3::Z * z, sphere.shell()), |points| {
                points.iter().map(field).collect()
            });
            let off = sphere.force(&waves) - DVec3::Z * scale * (2.0 * k * z).sin();
            assert!(off.length() < 1e-8 * largest, "{ka}, {material:?}: {off} of {scale}, {largest}");
            let stiffness = DMat3::from_diagonal(DVec3::Z * -2.0 * k * scale * (2.0 * k * z).cos());
            let off = sphere.stiffness(&waves) - stiffness;
            assert!(off.to_cols_array().iter().all(|off| off.abs() < 3e-8 * k * largest), "{ka}: {off}");
            // A standing wave has all of its force from the potential.
            let beside = |z: f64| {
                sphere.potential(&PartialWaves::new(
                    sphere.order() + 2,
                    k,
                    (DVec3::Z * z, sphere.shell()),
                    |points| points.iter().map(field).collect(),
                ))
            };
            let step = 2e-6;
            let descent = (beside(z - step) - beside(z + step)) / (2.0 * step);
            let force = scale * (2.0 * k * z).sin();
            assert!(
                (descent - force).abs() < 2e-5 * largest,
                "{ka}: {descent} N down the potential, {force}"
            );
        }
    }
}

#[test]
fn a_travelling_wave_has_the_force_of_its_series() {
    for (ka, material) in SIZES.map(|ka| (ka, Material::Eps)).into_iter().chain([(0.4, Material::Water)]) {
        let (bead, air, k) = bead_of(ka, material);
        let sphere = Sphere::new(&bead, &air, k);
        let s = |n: usize| scattered(n, ka, &bead, &air);
        let term = |n: usize| {
            let (own, next) = (s(n), s(n + 1));
            (n + 1) as f64 * (own.re + next.re + 2.0 * (own.re * next.re + own.im * next.im))
        };
        let series: f64 = -4.0 / (ka * ka) * (0..16).map(term).sum::<f64>();
        let energy = 1500f64.powi(2) / (2.0 * air.density * air.sound_speed.powi(2));
        let expected = PI * bead.radius.powi(2) * energy * series;
        let way = DVec3::new(0.48, -0.6, 0.64);
        let at = DVec3::new(0.01, 0.02, 0.1);
        let waves = PartialWaves::new(sphere.order() + 6, k, (at, sphere.shell()), |points| {
            points.iter().map(|at| Complex64::from_polar(1500.0, 1.1 - k * way.dot(*at))).collect()
        });
        let off = sphere.force(&waves) - way * expected;
        // Of the largest of the terms that cancel.
        let largest = PI * bead.radius.powi(2) * energy * (4.0 / (ka * ka)) * s(0).norm().max(s(1).norm());
        assert!(off.length() < 1e-8 * largest, "{ka}, {material:?}: {off} of {expected}, {largest}");
        let stiffness = sphere.stiffness(&waves);
        assert!(stiffness.to_cols_array().iter().all(|own| own.abs() < 1e-7 * k * largest), "{stiffness}");
    }
}
