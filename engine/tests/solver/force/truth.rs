//! Forces in random scenes, against an independent sum over pistons and eighth-order differences.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::{Air, Aperture, Derivatives, Emitters};
use sonoglyph::drive::Drive;
use sonoglyph::force::Levitation;
use sonoglyph::scene::{Board, ElementModel, Elements, Placed, Reflector, Scene};

use crate::dice::Dice;

/// A scene of one or two boards, sometimes with a reflector, and an irregular drive.
fn scene(number: usize) -> (Scene, Drive, Dice) {
    let mut dice = Dice::new(0xBEAD, number);
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (dice.whole(1, 7), dice.whole(1, 7));
    scene.array.element_radius = dice.one_of(&[0.005, 0.0045, 0.012, 0.02]);
    scene.array.element = dice.one_of(&[ElementModel::Piston, ElementModel::Piston, ElementModel::Point]);
    scene.medium.absorption = dice.one_of(&[None, Some(0.0), Some(30.0)]);
    scene.bead.radius = dice.magnitude(5e-5, 8e-4);
    let turn = DQuat::from_euler(
        glam::EulerRot::XYZ,
        dice.between(-0.5, 0.5),
        dice.between(-0.5, 0.5),
        dice.between(-3.0, 3.0),
    );
    if dice.of(0.6) {
        let board = |normal: DVec3, at: DVec3| Board { at, normal: turn * normal, x_axis: turn * DVec3::X };
        scene.boards = vec![board(DVec3::Z, DVec3::ZERO)];
        if dice.of(0.7) {
            scene.boards.push(board(DVec3::NEG_Z, turn * DVec3::Z * 0.2));
        }
    }
    if dice.of(0.5) {
        let coefficient = dice.between(-1.0, 1.0);
        scene.reflectors =
            vec![Reflector { point: turn * DVec3::Y * 0.15, normal: turn * DVec3::NEG_Y, coefficient }];
    }
    if dice.of(0.3) {
        // A bowl.
        let of = |i: usize| {
            let (sin, cos) = (2.4 * i as f64).sin_cos();
            let radius = 0.004 * (i as f64 + 0.5).sqrt();
            let at = dvec3(radius * cos, radius * sin, 3.0 * radius * radius);
            Placed { at, normal: (DVec3::Z * 0.1 - at).normalize_or_zero() }
        };
        scene.array.placed = Elements::new((0..30).map(of).collect(), None);
        scene.array.file = Some("bowl.csv".to_owned());
    }
    let mut drive = Drive { amplitudes: Vec::new(), phases: Vec::new() };
    for _ in 0..scene.elements() {
        drive.amplitudes.push(dice.between(0.2, 1.0));
        drive.phases.push(dice.between(-PI, PI));
    }
    (scene, drive, dice)
}

/// Equation (1) over the boards and their images in the reflector.
fn heard(scene: &Scene, drive: &Drive, point: DVec3) -> Complex64 {
    let air = Air::new(&scene.medium, scene.array.frequency);
    let k = TAU * scene.array.frequency / air.sound_speed;
    let home = [Board::default()];
    let boards = if scene.boards.is_empty() { &home[..] } else { &scene.boards };
    let places: Vec<(DVec3, DVec3)> = match scene.array.placed.get() {
        Some(placed) => placed.iter().map(|it| (it.at, it.normal)).collect(),
        None => {
            let array = &scene.array;
            let place = |i: u32, count: u32| (f64::from(i) - f64::from(count - 1) / 2.0) * array.pitch;
            (0..array.rows * array.columns)
                .map(|n| {
                    let (row, column) = (n / array.columns, n % array.columns);
                    (dvec3(place(column, array.columns), place(row, array.rows), 0.0), DVec3::Z)
                })
                .collect()
        }
    };
    let mut sum = Complex64::ZERO;
    for (index, board) in boards.iter().enumerate() {
        let z = board.normal.normalize_or_zero();
        let x = (board.x_axis - z * z.dot(board.x_axis)).normalize_or_zero();
        let axes = DMat3::from_cols(x, z.cross(x), z);
        for (n, &(at, normal)) in places.iter().enumerate() {
            let n = index * places.len() + n;
            let u = Complex64::from_polar(drive.amplitudes[n], drive.phases[n]);
            let mut of = |at: DVec3, normal: DVec3, gain: f64| {
                let way = point - at;
                if way.dot(normal) < 0.0 {
                    return;
                }
                let (r, across) = (way.length(), way.cross(normal).length());
                let s = match scene.array.element {
                    ElementModel::Point | ElementModel::ExactPiston => 0.0,
                    ElementModel::Piston => k * scene.array.element_radius * across / r,
                };
                let directivity = if s < 1e-4 { 1.0 - s * s / 8.0 } else { 2.0 * libm::j1(s) / s };
                let decay = (-air.attenuation * r).exp();
                let wave =
                    Complex64::I * Complex64::cis(-k * r) * (scene.array.strength * directivity * decay / r);
                sum += gain * u * wave;
            };
            let (at, normal) = (board.at + axes * at, axes * normal);
            of(at, normal, 1.0);
            for mirror in &scene.reflectors {
                let up = mirror.normal.normalize_or_zero();
                let turned = |way: DVec3| way - up * (2.0 * up.dot(way));
                of(mirror.point + turned(at - mirror.point), turned(normal), mirror.coefficient);
            }
        }
    }
    sum
}

/// ∂f/∂x by eighth-order differences.
fn slope<T: Copy + std::ops::Sub<Output = T> + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>>(
    step: f64,
    f: impl Fn(f64) -> T,
) -> T {
    let pair = |i: f64, weight: f64| (f(i * step) - f(-i * step)) * (weight / step);
    pair(1.0, 0.8) + pair(2.0, -0.2) + pair(3.0, 4.0 / 105.0) + pair(4.0, -1.0 / 280.0)
}

const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

/// A point in front of the boards, far from every element.
fn place(dice: &mut Dice) -> DVec3 {
    dvec3(dice.between(-0.03, 0.03), dice.between(-0.03, 0.03), dice.between(0.06, 0.14))
}

#[test]
fn forces_agree_with_the_formulae_by_differences() {
    for number in 0..25 {
        let (scene, drive, mut dice) = scene(number);
        let aperture = Aperture::new(&scene);
        let levitation = Levitation::new(&scene, &aperture, std::slice::from_ref(&drive));
        let point = place(&mut dice);
        let air = Air::new(&scene.medium, scene.array.frequency);
        let k = aperture.element.wavenumber;
        // U and F from the formulae, with slopes by differences.
        let p = |at: DVec3| heard(&scene, &drive, at);
        let step = 3e-4;
        let slopes = |at: DVec3| AXES.map(|axis| slope(step, |h| p(at + axis * h)));
        let (rho, c, a) = (air.density, air.sound_speed, scene.bead.radius);
        let kappa = 1.0 / (rho * c * c);
        let own = 1.0 / (scene.bead.density() * scene.bead.sound_speed().powi(2));
        let (f1, f2) =
            (1.0 - own / kappa, 2.0 * (scene.bead.density() - rho) / (2.0 * scene.bead.density() + rho));
        let volume = 4.0 / 3.0 * PI * a.powi(3);
        let potential = |at: DVec3| {
            let squares: f64 = slopes(at).iter().map(|slope| slope.norm_sqr()).sum();
            volume
                * (f1 * kappa / 4.0 * p(at).norm_sqr() - 3.0 * f2 / (8.0 * rho * (k * c).powi(2)) * squares)
        };
        let ka = k * a;
        let first =
            Complex64::new(2.0 / 3.0 * ka.powi(3) * f1, -2.0 / 9.0 * ka.powi(6) * (f1 * f1 + f1 * f2));
        let second = Complex64::new(-ka.powi(3) * f2, -ka.powi(6) / 6.0 * f2 * f2);
        let (first, second) = (-PI * kappa / k.powi(3) * first, -PI * kappa / k.powi(5) * second);
        let force = |at: DVec3| {
            let (pressure, own) = (p(at), slopes(at));
            let along = |q: usize| {
                let bent = slopes_of(step, slopes, at, AXES[q]);
                let inner: Complex64 = (0..3).map(|i| own[i] * bent[i].conj()).sum();
                (first.conj() * pressure * own[q].conj() + second.conj() * inner).re
            };
            DVec3::from_array([0, 1, 2].map(along))
        };
        let forces = levitation.forces(point);
        let scale = volume
            * kappa
            * p(point).norm_sqr().max(slopes(point).iter().map(|s| s.norm_sqr()).sum::<f64>() / (k * k));
        let off = (forces.gorkov - potential(point)).abs() / scale;
        assert!(off < 1e-7, "{number}: U off by {off:e}");
        let off = (forces.force - force(point)).length() / (scale * k);
        assert!(off < 1e-6, "{number}: F off by {off:e}");
        assert!((levitation.force(point) - forces.force).length() < 1e-12 * scale * k);
        // K is minus the gradient of the force; for large beads it is not symmetric.
        for (j, axis) in AXES.into_iter().enumerate() {
            let column = slope(1e-4, |h| levitation.force(point + axis * h)) * -1.0;
            let off = (column - forces.stiffness.col(j)).length() / (scale * k * k);
            assert!(off < 1e-8, "{number}: K off by {off:e}");
        }
    }
}

fn slopes_of(step: f64, slopes: impl Fn(DVec3) -> [Complex64; 3], at: DVec3, axis: DVec3) -> [Complex64; 3] {
    [0, 1, 2].map(|i| slope(step, |h| slopes(at + axis * h)[i]))
}

#[test]
fn derivatives_are_those_of_the_transfer() {
    for number in 0..60 {
        let (mut scene, drive, mut dice) = scene(number);
        if number % 3 == 0 {
            scene.array.element = ElementModel::ExactPiston;
        }
        let aperture = Aperture::new(&scene);
        let excitation = drive.excitation(&aperture.driven);
        let emitters = Emitters::new(&aperture, &excitation);
        let point = place(&mut dice);
        let all = emitters.derivatives(point);
        let p = aperture.transfer(&[point]).pressure(&excitation)[0];
        let scale: f64 = aperture.transfer(&[point]).row(0).map(|h| h.norm()).sum();
        assert!((all.pressure() - p).norm() < 1e-10 * scale, "{number}: {} for {p}", all.pressure());
        let k = aperture.element.wavenumber;
        let step = 1.5e-4;
        for (i, axis) in AXES.into_iter().enumerate() {
            let beside: Vec<Derivatives> =
                (-4..=4).map(|n| emitters.derivatives(point + axis * (step * f64::from(n)))).collect();
            let along = |of: &dyn Fn(&Derivatives) -> Complex64| {
                slope(step, |h| of(&beside[((h / step).round() + 4.0) as usize]))
            };
            let assert_near = |order: i32, own: Complex64, difference: Complex64| {
                let off = (own - difference).norm() / (scale * k.powi(order));
                assert!(off < 1e-9, "{number}, {:?}: order {order} off by {off:e}", scene.array.element);
            };
            assert_near(1, all.slope(i), along(&|it| it.pressure()));
            for j in 0..3 {
                assert_near(2, all.second(i, j), along(&|it| it.slope(j)));
                for l in 0..3 {
                    assert_near(3, all.third(i, j, l), along(&|it| it.second(j, l)));
                }
            }
        }
    }
}

#[test]
fn exact_pistons_are_right_close_to_an_element() {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns, scene.array.element) = (2, 2, ElementModel::ExactPiston);
    let aperture = Aperture::new(&scene);
    let excitation = vec![Complex64::ONE; 4];
    let emitters = Emitters::new(&aperture, &excitation);
    let radius = scene.array.element_radius;
    for (across, height) in [(0.4, 0.1), (0.7, 0.15), (0.9, 0.3), (1.05, 0.12), (0.0, 0.1)] {
        let point = aperture.positions[2] + DVec3::new(across, 0.0, height) * radius;
        let transfer = aperture.transfer(&[point]);
        let scale: f64 = transfer.row(0).map(|h| h.norm()).sum();
        let off = (emitters.derivatives(point).pressure() - transfer.pressure(&excitation)[0]).norm() / scale;
        assert!(off < 1e-10, "{across} and {height} radii from its centre: off by {off:e}");
    }
}
