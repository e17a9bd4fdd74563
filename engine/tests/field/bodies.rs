//! The total sound of elements and bodies: against published series, plates and themselves.

use glam::{DVec2, DVec3, dvec3};
use num_complex::Complex64;
use sonoglyph_engine::acoustics::{Air, Aperture};
use sonoglyph_engine::drive::Drive;
use sonoglyph_engine::field::{Evaluator, Quantity, Request, Samples, Stages, reference};
use sonoglyph_engine::force::Levitation;
use sonoglyph_engine::scene::{
    Array, Board, Body, BodyKind, ElementModel, Envelope, Medium, Modulation, Plane, Reflector, Scene, Skin,
};

const K: f64 = 732.274_780;

/// A point source of 1 Pa·m at a height (m) above the origin that faces down, in air without absorption.
fn source(height: f64, bodies: Vec<Body>) -> Scene {
    let array =
        Array { rows: 1, columns: 1, element: ElementModel::Point, strength: 1.0, ..Array::default() };
    let medium = Medium {
        absorption: Some(0.0),
        sound_speed: Some(2.0 * std::f64::consts::PI * 40e3 / K),
        ..Medium::default()
    };
    let board = Board { at: DVec3::Z * height, normal: DVec3::NEG_Z, ..Board::default() };
    Scene { array, medium, boards: vec![board], bodies, ..Scene::default() }
}

fn sphere(at: DVec3, radius: f64) -> Body {
    Body { kind: BodyKind::Sphere, at, radius, ..Body::default() }
}

#[test]
fn a_rigid_sphere_scatters_as_its_series() {
    // shared figures for a source at (0, 0, 0.1): scattered pressures, independent of this program.
    let cases = [
        (
            0.008,
            [
                (dvec3(0.0, 0.0, 0.028), (1.749335, -0.178972)),
                (dvec3(0.0, 0.03, 0.0), (0.755991, 1.063094)),
                (dvec3(0.03, 0.0, 0.03), (0.643117, 0.802782)),
                (dvec3(0.0, 0.0, -0.028), (1.884314, -8.052719)),
            ],
        ),
        (
            0.02,
            [
                (dvec3(0.0, 0.0, 0.04), (-2.470324, 2.932387)),
                (dvec3(0.0, 0.03, 0.0), (-2.657950, 0.116625)),
                (dvec3(0.03, 0.0, 0.03), (-2.919723, -1.246195)),
                (dvec3(0.0, 0.0, -0.04), (7.075475, -1.204003)),
            ],
        ),
    ];
    for (radius, points) in cases {
        let aperture = Aperture::new(&source(0.1, vec![sphere(DVec3::ZERO, radius)]));
        let alone = Aperture::new(&source(0.1, Vec::new()));
        for (at, (re, im)) in points {
            let [total, incident] = [&aperture, &alone].map(|it| it.pressures(&[at], &[Complex64::ONE])[0]);
            // Elements are a quarter turn ahead of e^{-jkR}/R.
            let scattered = (total - incident) * Complex64::new(0.0, -1.0);
            assert!((scattered - Complex64::new(re, im)).norm() < 2e-6, "{radius} {at}: {scattered}");
            let row = aperture.transfer(&[at]).at(0, 0);
            assert!((row - total).norm() < 1e-9 * total.norm(), "{radius} {at}: {row}, not {total}");
        }
        assert!(aperture.pressures(&[DVec3::Z * (0.5 * radius)], &[Complex64::ONE])[0].re.is_nan());
    }
}

#[test]
fn a_map_is_the_reference_outside_and_nothing_within() {
    let capsule = Body {
        kind: BodyKind::Capsule,
        at: dvec3(0.004, 0.0, 0.09),
        x_axis: dvec3(1.0, 1.0, 0.0),
        radius: 0.006,
        length: 0.03,
        ..Body::default()
    };
    let scene = Scene {
        array: Array { rows: 6, columns: 6, ..Array::default() },
        plane: Plane {
            centre: dvec3(0.0, 0.0, 0.09),
            size: DVec2::splat(0.06),
            x_axis: DVec3::X,
            y_axis: dvec3(0.0, 0.6, 0.8),
            ..Plane::default()
        },
        bodies: vec![capsule, sphere(dvec3(-0.015, -0.01, 0.085), 0.005)],
        ..Scene::default()
    };
    let phases = (0..36).map(|n| f64::from(n * n) * 0.37 % 6.0).collect();
    let drive = Drive { amplitudes: vec![1.0; 36], phases };
    let aperture = Aperture::new(&scene);
    let size = (90, 80);
    let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
    for quantity in [Quantity::Rms, Quantity::Intensity] {
        let request = Request::new(&scene, vec![drive.clone()], quantity, size);
        let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
        let exact = Stages::new(Evaluator::Reference).map(&request).unwrap().clone();
        let within = exact.values.iter().filter(|value| value.is_nan()).count();
        assert!((150..1500).contains(&within), "{within}");
        for (pixel, (value, exact)) in map.values.iter().zip(&exact.values).enumerate() {
            assert_eq!(value.is_nan(), aperture.bodies.contains(pixels.point(pixel)), "{pixel}");
            assert_eq!(value.is_nan(), exact.is_nan(), "{pixel}");
            let off = (value - exact).abs();
            assert!(value.is_nan() || off < 2e-3 * map.peak, "{quantity:?} {pixel}: {value}, not {exact}");
        }
        assert!(map.error < 2e-3, "{quantity:?}: {}", map.error);
    }
    let field = reference::pressure(&aperture, &drive, &pixels);
    assert!(field.iter().any(|p| p.re.is_nan()));
}

/// A plate above 16 elements, and a rigid reflector in its place.
fn plate_and_image() -> [Scene; 2] {
    let plate = Body {
        kind: BodyKind::Palm,
        at: DVec3::Z * 0.06,
        size: dvec3(0.12, 0.12, 0.004),
        edge: Some(0.0022),
        ..Body::default()
    };
    let array = Array { rows: 4, columns: 4, ..Array::default() };
    let scene = |bodies: Vec<Body>, reflectors: Vec<Reflector>| Scene {
        array: array.clone(),
        bodies,
        reflectors,
        ..Scene::default()
    };
    let mirror = Reflector { point: DVec3::Z * 0.06, normal: DVec3::NEG_Z, coefficient: 1.0 };
    [scene(vec![plate], vec![]), scene(vec![], vec![mirror])]
}

#[test]
fn a_bead_below_a_plate_feels_its_image() {
    let [body, image] = plate_and_image();
    let drive = Drive { amplitudes: vec![1.0; 16], phases: vec![0.0; 16] };
    let points: Vec<_> =
        (0..24).map(|i| dvec3(0.0002 * f64::from(i), -0.001, 0.05 + 0.0003 * f64::from(i))).collect();
    let forces = |scene: &Scene| {
        let levitation = Levitation::new(scene, &Aperture::new(scene), std::slice::from_ref(&drive));
        (levitation.forces_at(&points), levitation.force(DVec3::Z * 0.0598))
    };
    let [(got, touching), (expected, _)] = [&body, &image].map(forces);
    let largest = expected.iter().map(|force| force.length()).fold(0.0, f64::max);
    for (got, expected) in got.iter().zip(&expected) {
        assert!(got.distance(*expected) < 0.06 * largest, "{got}, not {expected} of {largest}");
    }
    assert!(touching.is_nan(), "a bead of 0.5 mm has no force within 0.2 mm: {touching}");
}

#[test]
fn sound_presses_on_a_palm_as_on_the_plane() {
    let [mut palm, mut plane] = plate_and_image();
    plane.reflectors.clear();
    for scene in [&mut palm, &mut plane] {
        scene.plane = Plane { centre: DVec3::Z * 0.06, size: DVec2::splat(0.03), ..Plane::default() };
        scene.skin = Some(Skin::default());
        scene.modulation = Modulation { shape: Envelope::Sine, frequency: 200.0, ..Modulation::default() };
    }
    let drive = Drive { amplitudes: vec![1.0; 16], phases: vec![0.0; 16] };
    let map = |scene: &Scene| {
        let request = Request::new(scene, vec![drive.clone()], Quantity::Skin, (24, 24));
        Stages::new(Evaluator::Cpu).map(&request).unwrap().clone()
    };
    let [palm, plane] = [&palm, &plane].map(map);
    assert!(plane.peak > 0.0 && palm.within == 0, "{plane:?}");
    for (got, expected) in palm.values.iter().zip(&plane.values) {
        assert!((got - expected).abs() < 0.08 * plane.peak, "{got}, not {expected} of {}", plane.peak);
    }
}

#[test]
fn a_map_of_forces_is_exact_between_bodies() {
    let capsule = Body {
        kind: BodyKind::Capsule,
        at: dvec3(0.008, 0.0, 0.06),
        radius: 0.004,
        length: 0.016,
        ..Body::default()
    };
    let scene = Scene {
        array: Array { rows: 4, columns: 4, ..Array::default() },
        plane: Plane {
            centre: DVec3::Z * 0.06,
            size: DVec2::splat(0.05),
            y_axis: DVec3::Z,
            ..Plane::default()
        },
        bodies: vec![capsule, sphere(dvec3(-0.012, 0.0, 0.065), 0.005)],
        ..Scene::default()
    };
    let drive = Drive { amplitudes: vec![1.0; 16], phases: vec![0.0; 16] };
    let size = (24, 24);
    let request = Request::new(&scene, vec![drive.clone()], Quantity::Force, size);
    let start = std::time::Instant::now();
    let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
    println!("{} in {:?}, error {}", map.how, start.elapsed(), map.error);
    let pixels = Samples::on_plane(&scene.plane, size.0, size.1).unwrap();
    let aperture = Aperture::new(&scene);
    let levitation = Levitation::new(&scene, &aperture, &[drive]);
    for pixel in (0..576).step_by(3) {
        let (at, got) = (pixels.point(pixel), f64::from(map.values[pixel]));
        let expected = levitation.force(at).length();
        assert_eq!(got.is_nan(), expected.is_nan(), "{at}");
        let off = (got - expected).abs();
        assert!(got.is_nan() || off < 5e-3 * f64::from(map.peak), "{at}: {got}, not {expected}");
        assert!(!aperture.bodies.contains(at) || got.is_nan(), "{at}");
    }
    assert!(map.within > 5, "{}", map.within);
}

#[test]
fn a_large_plate_is_a_reflector() {
    let [body, image] = plate_and_image().map(|scene| Aperture::new(&scene));
    let points: Vec<_> = (0..40)
        .map(|i| {
            dvec3(0.0004 * f64::from(i) - 0.008, 0.005 - 0.0003 * f64::from(i), 0.045 + 0.0003 * f64::from(i))
        })
        .collect();
    let drive = [Complex64::ONE; 16];
    let [got, expected] = [&body, &image].map(|it| it.pressures(&points, &drive));
    let loudest = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
    for (got, expected) in got.iter().zip(&expected) {
        assert!((got - expected).norm() < 0.04 * loudest, "{got}, not {expected} of {loudest}");
    }
}

#[test]
fn two_bodies_and_a_mirror_hear_each_other() {
    // A sphere before a rigid mirror is one of two spheres between two sources.
    let at = dvec3(0.004, 0.0, 0.02);
    let mut half = source(0.1, vec![sphere(at, 0.006)]);
    half.reflectors = vec![Reflector { point: DVec3::ZERO, normal: DVec3::Z, coefficient: 1.0 }];
    let mut whole = source(0.1, vec![sphere(at, 0.006), sphere(dvec3(0.004, 0.0, -0.02), 0.006)]);
    whole.boards.push(Board { at: DVec3::Z * -0.1, normal: DVec3::Z, ..Board::default() });
    let [half, whole] = [half, whole].map(|scene| Aperture::new(&scene));
    for at in [dvec3(0.0, 0.0, 0.001), dvec3(0.02, 0.01, 0.03), dvec3(-0.01, 0.0, 0.012)] {
        let one = half.pressures(&[at], &[Complex64::ONE])[0];
        let both = whole.pressures(&[at], &[Complex64::ONE; 2])[0];
        assert!((one - both).norm() < 1e-4 * both.norm(), "{at}: {one}, not {both}");
        let row = half.transfer(&[at]).at(0, 0);
        assert!((one - row).norm() < 1e-4 * row.norm(), "{at}: {one}, not {row}");
    }
}

#[test]
fn bodies_absorb_no_energy() {
    // The power through a sphere around a rigid body in air without absorption is 0.
    let scene = source(
        0.1,
        vec![Body {
            kind: BodyKind::Capsule,
            at: DVec3::ZERO,
            radius: 0.005,
            length: 0.024,
            ..Body::default()
        }],
    );
    let aperture = Aperture::new(&scene);
    let air = Air::new(&scene.medium, 40e3);
    let (count, radius, step) = (2000, 0.02, 1e-6);
    let (mut power, mut incident) = (0.0, 0.0);
    for n in 0..count {
        let z = 1.0 - f64::from(2 * n + 1) / f64::from(count);
        let turn = f64::from(n) * 2.399_963_229_728_653;
        let normal = dvec3(turn.cos() * (1.0 - z * z).sqrt(), turn.sin() * (1.0 - z * z).sqrt(), z);
        let at = normal * radius;
        let p = aperture.pressures(&[at, at + normal * step, at - normal * step], &[Complex64::ONE]);
        let slope = (p[1] - p[2]) / (2.0 * step);
        let velocity = slope * Complex64::new(0.0, 1.0) / (air.density * K * air.sound_speed);
        let area = 4.0 * std::f64::consts::PI * radius * radius / f64::from(count);
        power += 0.5 * (p[0] * velocity.conj()).re * area;
        incident += p[0].norm_sqr() / (2.0 * air.density * air.sound_speed) * area;
    }
    assert!(power.abs() < 0.01 * incident, "{power} of {incident}");
}
