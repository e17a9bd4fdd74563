//! Forces in random scenes, against an independent sum over elements and over partial waves, and differences.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec2, DVec3, dvec3};
use num_complex::Complex64;
use sonoglyph::acoustics::{Air, Aperture};
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
    scene.array.element = dice.one_of(&[
        ElementModel::Piston,
        ElementModel::Piston,
        ElementModel::Point,
        ElementModel::Rectangle,
        ElementModel::Cosine,
    ]);
    scene.array.element_size = DVec2::new(dice.between(0.003, 0.012), 0.007);
    scene.array.element_exponent = dice.one_of(&[0.4, 1.0, 2.0, 7.5]);
    scene.medium.absorption = dice.one_of(&[None, Some(0.0), Some(30.0)]);
    scene.bead.radius = dice.magnitude(5e-5, 2e-3);
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
            let aside = DQuat::from_rotation_arc(DVec3::Z, normal) * DVec3::X;
            let mut of = |at: DVec3, [normal, aside]: [DVec3; 2], gain: f64| {
                let way = point - at;
                if way.dot(normal) < 0.0 {
                    return;
                }
                let (r, across) = (way.length(), way.cross(normal).length());
                let s = match scene.array.element {
                    ElementModel::Point
                    | ElementModel::ExactPiston
                    | ElementModel::Rectangle
                    | ElementModel::Cosine
                    | ElementModel::Measured => 0.0,
                    ElementModel::Piston => k * scene.array.element_radius * across / r,
                };
                let sinc = |x: f64| if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x };
                let half = scene.array.element_size * k / 2.0;
                let directivity = match scene.array.element {
                    ElementModel::Rectangle => {
                        sinc(half.x * way.dot(aside) / r) * sinc(half.y * way.dot(normal.cross(aside)) / r)
                    }
                    ElementModel::Cosine => (way.dot(normal) / r).powf(scene.array.element_exponent),
                    ElementModel::Point
                    | ElementModel::ExactPiston
                    | ElementModel::Measured
                    | ElementModel::Piston
                        if s < 1e-4 =>
                    {
                        1.0 - s * s / 8.0
                    }
                    ElementModel::Point
                    | ElementModel::ExactPiston
                    | ElementModel::Measured
                    | ElementModel::Piston => 2.0 * libm::j1(s) / s,
                };
                let decay = (-air.attenuation * r).exp();
                let wave =
                    Complex64::I * Complex64::cis(-k * r) * (scene.array.strength * directivity * decay / r);
                sum += gain * u * wave;
            };
            let (at, normal, aside) = (board.at + axes * at, axes * normal, axes * aside);
            of(at, [normal, aside], 1.0);
            for mirror in &scene.reflectors {
                let up = mirror.normal.normalize_or_zero();
                let turned = |way: DVec3| way - up * (2.0 * up.dot(way));
                of(
                    mirror.point + turned(at - mirror.point),
                    [turned(normal), turned(aside)],
                    mirror.coefficient,
                );
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

/// Associated Legendre function with Condon and Shortley's sign, times the norm of the harmonic.
fn legendre(n: usize, m: usize, x: f64) -> f64 {
    let mut first = (1..=m).map(|i| -((2 * i - 1) as f64) * (1.0 - x * x).sqrt()).product::<f64>();
    let (mut before, last) = (0.0, n);
    for i in m..last {
        let next = ((2 * i + 1) as f64 * x * first - (i + m) as f64 * before) / (i - m + 1) as f64;
        (before, first) = (first, next);
    }
    let ratio: f64 = (n - m + 1..=n + m).map(|i| 1.0 / i as f64).product();
    first * ((2 * n + 1) as f64 / (4.0 * PI) * ratio).sqrt()
}

/// Nodes and weights of Gauss's rule by Newton's steps from between Chebyshev's.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..20 {
            let (mut before, mut this) = (1.0, x);
            for n in 1..count {
                let n = n as f64;
                (before, this) = (this, ((2.0 * n + 1.0) * x * this - n * before) / (n + 1.0));
            }
            slope = count as f64 * (x * this - before) / (x * x - 1.0);
            x -= this / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// Scattering coefficients (e^{-jωt}) of a fluid sphere, by differences of explicit functions of low order.
fn scattered(n: usize, ka: f64, density: f64, speed: f64) -> Complex64 {
    let j = |x: f64| {
        let mut term = (0..n).map(|i| x / (2 * i + 3) as f64).product::<f64>();
        let mut sum = 0.0;
        for i in 1..60 {
            sum += term;
            term *= -x * x / (2 * i * (2 * n + 2 * i + 1)) as f64;
        }
        sum
    };
    let y = |x: f64| {
        let (mut before, mut this) = (x.sin() / x, -x.cos() / x);
        for i in 0..n {
            (before, this) = (this, (2 * i + 1) as f64 / x * this - before);
        }
        this
    };
    let within = ka / speed;
    let gamma = 1.0 / (density * speed);
    let step = |x: f64| 1e-3 * x;
    let (dj, dy) = (slope(step(ka), |h| j(ka + h)), slope(step(ka), |h| y(ka + h)));
    let d_within = slope(step(within), |h| j(within + h));
    let h = Complex64::new(j(ka), y(ka));
    (gamma * d_within * j(ka) - j(within) * dj) / (j(within) * Complex64::new(dj, dy) - gamma * d_within * h)
}

/// N, by the sums of complex harmonics up to an order, from the pressures on a sphere.
fn force_by_sums(scene: &Scene, drive: &Drive, point: DVec3, order: usize) -> DVec3 {
    let air = Air::new(&scene.medium, scene.array.frequency);
    let k = TAU * scene.array.frequency / air.sound_speed;
    let (x, around) = (0.4, 4 * order);
    let mut a = vec![vec![Complex64::ZERO; 2 * order + 1]; order + 1];
    for (z, weight) in gauss(2 * order) {
        for turn in 0..around {
            let angle = TAU * turn as f64 / around as f64;
            let across = (1.0 - z * z).sqrt();
            let way = dvec3(across * angle.cos(), across * angle.sin(), z);
            let p = heard(scene, drive, point + way * (x / k)).conj() * (weight * TAU / around as f64);
            for (n, row) in a.iter_mut().enumerate() {
                for m in 0..=n {
                    let norm = legendre(n, m, z);
                    row[order + m] += p * Complex64::cis(-(m as f64) * angle) * norm;
                    if m > 0 {
                        let sign = if m.is_multiple_of(2) { 1.0 } else { -1.0 };
                        row[order - m] += p * Complex64::cis(m as f64 * angle) * (sign * norm);
                    }
                }
            }
        }
    }
    for (n, row) in a.iter_mut().enumerate() {
        let leading: f64 = (0..n).map(|i| x / (2 * i + 3) as f64).product();
        let (mut term, mut sum) = (1.0, 0.0);
        for i in 1..30 {
            sum += term;
            term *= -x * x / (2 * i * (2 * n + 2 * i + 1)) as f64;
        }
        row.iter_mut().for_each(|value| *value /= leading * sum);
    }
    let of = |n: usize, m: i64| {
        if m.unsigned_abs() as usize > n { Complex64::ZERO } else { a[n][(order as i64 + m) as usize] }
    };
    let (density, speed) = (scene.bead.density() / air.density, scene.bead.sound_speed() / air.sound_speed);
    let s = |n: usize| scattered(n, k * scene.bead.radius, density, speed);
    let g = 1.0 / (4.0 * air.density * (air.sound_speed * k).powi(2));
    let (mut up, mut across) = (0.0, Complex64::ZERO);
    for n in 0..order {
        let psi = s(n) + s(n + 1).conj() + 2.0 * s(n) * s(n + 1).conj();
        let rest = ((2 * n + 1) * (2 * n + 3)) as f64;
        for m in -(n as i64)..=n as i64 {
            let (n, m_) = (n as f64, m as f64);
            let along = ((n + m_ + 1.0) * (n - m_ + 1.0) / rest).sqrt();
            let beside = ((n + m_ + 1.0) * (n + m_ + 2.0) / rest).sqrt();
            let n = n as usize;
            up += 2.0 * g * (along * psi * of(n, m) * of(n + 1, m).conj()).im;
            let pair =
                psi * of(n, m) * of(n + 1, m + 1).conj() + psi.conj() * of(n, -m).conj() * of(n + 1, -m - 1);
            across += Complex64::I * g * beside * pair;
        }
    }
    dvec3(across.re, across.im, up)
}

fn pressure(aperture: &Aperture, drive: &Drive, point: DVec3) -> Complex64 {
    aperture.pressures(&[point], &drive.excitation(&aperture.driven))[0]
}

#[test]
fn forces_and_stiffnesses_are_those_of_sums() {
    for number in 0..25 {
        let (scene, drive, mut dice) = scene(number);
        let aperture = Aperture::new(&scene);
        let levitation = Levitation::new(&scene, &aperture, std::slice::from_ref(&drive));
        // Behind the plane of an element of a bowl it is silent: no bead is both behind and before it.
        let is_away = |point: DVec3| {
            let elements = aperture.positions.iter().zip(&aperture.normals);
            elements.map(|(at, normal)| normal.dot(point - at).abs()).all(|height| height > 2e-3)
        };
        // An image is heard at a place as its element is at the place's image.
        let image = |mirror: &Reflector, point: DVec3| {
            point - mirror.normal.normalize_or_zero() * (2.0 * mirror.height(point))
        };
        let is_clear = |&point: &DVec3| {
            is_away(point) && scene.reflectors.iter().all(|mirror| is_away(image(mirror, point)))
        };
        let point = std::iter::repeat_with(|| place(&mut dice)).find(is_clear).unwrap();
        let (own, sum) = (pressure(&aperture, &drive, point), heard(&scene, &drive, point));
        let model = scene.array.element;
        assert!((own - sum).norm() < 1e-9 * sum.norm(), "{number}, {model:?}: P = {own}, not {sum}");
        let forces = levitation.forces(point);
        // Waves that obey the equation of sound are known to rounding, others as what they are near the bead.
        let is_exact = scene.array.element == ElementModel::Point && scene.medium.absorption == Some(0.0);
        let expected = force_by_sums(&scene, &drive, point, levitation.sphere.order());
        let k = aperture.element.wavenumber;
        let scale = (forces.gorkov.abs() * k).max(expected.length());
        let off = forces.force.distance(expected) / scale;
        assert!(off < if is_exact { 1e-5 } else { 2e-2 }, "{number}, {model:?}: F off by {off:e}");
        assert!(levitation.force(point).distance(forces.force) < 1e-6 * scale, "{number}");
        for (j, axis) in AXES.into_iter().enumerate() {
            let column = slope(1e-4, |h| levitation.force(point + axis * h)) * -1.0;
            let off = (column - forces.stiffness.col(j)).length() / (scale * k);
            assert!(off < 1e-6, "{number}: K off by {off:e}");
        }
    }
}
