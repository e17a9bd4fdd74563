//! Standing and travelling plane waves, with closed forms of the force.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use num_complex::Complex64;
use sonoglyph::acoustics::{Air, Derivatives};
use sonoglyph::force::Sphere;
use sonoglyph::scene::{Bead, Material};

use crate::force::still_air;

fn sphere(radius: f64, material: Material) -> (Sphere, Air, f64) {
    let scene = still_air();
    let air = Air::new(&scene.medium, 40e3);
    let k = TAU * 40e3 / air.sound_speed;
    (Sphere::new(&Bead { radius, material, ..Bead::default() }, &air, k), air, k)
}

/// cos(kz) and its derivatives.
fn standing(k: f64, z: f64, pressure: f64) -> Derivatives {
    Derivatives::of(|[x, y, n]| match (x, y) {
        (0, 0) => {
            (Complex64::cis(k * z) * (Complex64::I * k).powu(n)).re * Complex64::from_polar(pressure, 0.4)
        }
        _ => Complex64::ZERO,
    })
}

#[test]
fn a_standing_wave_has_its_closed_form() {
    for (radius, material) in [(0.0005, Material::Eps), (0.0001, Material::Water), (0.0003, Material::Silica)]
    {
        let (sphere, air, k) = sphere(radius, material);
        let energy = 2000f64.powi(2) / (4.0 * air.density * air.sound_speed.powi(2));
        let contrast = sphere.monopole / 3.0 + sphere.dipole / 2.0;
        let scale = 4.0 * PI * contrast * k * radius.powi(3) * energy;
        let base = 4.0 * PI * radius.powi(3) * energy;
        for i in 0..20 {
            let z = 0.001 * f64::from(i) - 0.007;
            let sound = standing(k, z, 2000.0);
            let off = sphere.force(&sound) - DVec3::Z * scale * (2.0 * k * z).sin();
            assert!(off.length() < 1e-12 * scale, "{off} of {scale}");
            let stiffness = DMat3::from_diagonal(DVec3::Z * -2.0 * k * scale * (2.0 * k * z).cos());
            let off = sphere.stiffness(&sound) - stiffness;
            assert!(off.to_cols_array().iter().all(|off| off.abs() < 1e-12 * 2.0 * k * scale), "{off}");
            let (cos2, sin2) = ((k * z).cos().powi(2), (k * z).sin().powi(2));
            let potential = base * (sphere.monopole / 3.0 * cos2 - sphere.dipole / 2.0 * sin2);
            assert!((sphere.potential(&sound) - potential).abs() < 1e-12 * base, "{z}");
        }
    }
}

#[test]
fn a_travelling_wave_pushes_by_its_scattering() {
    let (sphere, air, k) = sphere(0.0004, Material::Eps);
    let (f1, f2) = (sphere.monopole, sphere.dipole);
    let flow = 1500f64.powi(2) / (2.0 * air.density * air.sound_speed.powi(2));
    let expected =
        4.0 * PI / 9.0 * 0.0004f64.powi(2) * sphere.ka.powi(4) * flow * (f1 * f1 + f1 * f2 + 0.75 * f2 * f2);
    let way = DVec3::new(0.48, -0.6, 0.64);
    let sound = Derivatives::of(|orders| {
        let slope = |axis: usize| (-Complex64::I * k * way[axis]).powu(orders[axis]);
        Complex64::from_polar(1500.0, 1.1) * slope(0) * slope(1) * slope(2)
    });
    assert!((sphere.force(&sound) - way * expected).length() < 1e-12 * expected);
    let stiffness = sphere.stiffness(&sound);
    assert!(stiffness.to_cols_array().iter().all(|k| k.abs() < 1e-9 * expected), "{stiffness}");
}
