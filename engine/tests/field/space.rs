//! Boards in any pose, curved arrays and reflectors: against an independent model, and under symmetries.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3, dvec3};
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::{Evaluator, Quantity, Request, Samples, Stages, reference};
use sonoglyph::scene::{Board, Elements, Placed, Plane, Reflector, Scene};

use crate::{STEP, fast_evaluators, scattered};

/// Position, normal and excitation of a piston.
struct Piston {
    at: DVec3,
    normal: DVec3,
    u: Complex64,
}

/// P by equation (1), element by element.
fn heard(scene: &Scene, pistons: &[Piston], point: DVec3) -> Complex64 {
    let wavenumber = TAU * scene.array.frequency / scene.medium.sound_speed.unwrap();
    let of = |piston: &Piston| {
        let way = point - piston.at;
        let height = way.dot(piston.normal);
        if height < 0.0 {
            return Complex64::ZERO;
        }
        let (r, across) = (way.length(), way.cross(piston.normal).length());
        let x = wavenumber * scene.array.element_radius * across / r;
        let directivity = if x < 1e-6 { 1.0 } else { 2.0 * libm::j1(x) / x };
        Complex64::i() * Complex64::cis(-wavenumber * r) * scene.array.strength * directivity / r * piston.u
    };
    pistons.iter().map(of).sum()
}

fn quiet_air() -> Scene {
    let mut scene = Scene::default();
    (scene.medium.sound_speed, scene.medium.absorption) = (Some(343.2), Some(0.0));
    scene
}

/// The elements of a grid centred at a point, with given axes.
fn grid([columns, rows]: [u32; 2], pitch: f64, at: DVec3, x: DVec3, y: DVec3) -> Vec<(DVec3, DVec3)> {
    let place = |i: u32, count: u32| (f64::from(i) - f64::from(count - 1) / 2.0) * pitch;
    let element =
        |row: u32, column: u32| (at + x * place(column, columns) + y * place(row, rows), x.cross(y));
    (0..rows).flat_map(|row| (0..columns).map(move |column| element(row, column))).collect()
}

fn playing(elements: &[(DVec3, DVec3)], drive: &Drive) -> Vec<Piston> {
    let u = drive.phases.iter().zip(&drive.amplitudes).map(|(phase, a)| Complex64::from_polar(*a, *phase));
    elements.iter().zip(u).map(|(&(at, normal), u)| Piston { at, normal, u }).collect()
}

/// The images of pistons in a plane, `coefficient` times as loud.
fn mirrored(pistons: &[Piston], Reflector { point, normal, coefficient }: &Reflector) -> Vec<Piston> {
    let n = normal.normalize_or_zero();
    let turned = |v: DVec3| v - 2.0 * n.dot(v) * n;
    let image = |piston: &Piston| Piston {
        at: *point + turned(piston.at - *point),
        normal: turned(piston.normal),
        u: *coefficient * piston.u,
    };
    pistons.iter().map(image).collect()
}

/// Irregular points in a box.
fn places(low: DVec3, high: DVec3) -> Vec<DVec3> {
    let part = |i: usize, step: f64| (i as f64 * step).fract();
    (1..40)
        .map(|i| low + (high - low) * dvec3(part(i, 0.754_877), part(i, 0.569_84), part(i, 0.618_034)))
        .collect()
}

/// All evaluators agree with the pistons: f64 to rounding, the others to 2e-5 of the peak.
fn assert_heard(what: &str, scene: &Scene, drive: &Drive, pistons: &[Piston], points: &[DVec3]) {
    let expected: Vec<_> = points.iter().map(|&point| heard(scene, pistons, point)).collect();
    let peak = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let aperture = Aperture::new(scene);
    let samples = Samples::at(points.to_vec());
    let in_f64 = reference::pressure(&aperture, drive, &samples);
    let by_rows = aperture.transfer(points).pressure(&drive.excitation(&aperture.driven));
    for (index, expected) in expected.iter().enumerate() {
        for p in [in_f64[index], by_rows[index]] {
            assert!(
                (p - expected).norm() < 1e-10 * peak,
                "{what}: {p} is not {expected} at {}",
                points[index]
            );
        }
    }
    for evaluator in fast_evaluators() {
        let field = evaluator.pressure(&aperture, drive, &samples).unwrap();
        for (p, expected) in field.iter().zip(&expected) {
            let wide = |p: &Complex32| Complex64::new(p.re.into(), p.im.into());
            let off = (wide(p) - expected).norm();
            assert!(off < 2e-5 * peak, "{what}, {evaluator:?}: {p} is not {expected}");
        }
    }
}

fn tilted_boards() -> (Scene, Vec<(DVec3, DVec3)>) {
    let mut scene = quiet_air();
    (scene.array.columns, scene.array.rows) = (7, 5);
    let mut elements = Vec::new();
    for (at, normal, x_axis) in [
        (dvec3(-0.1, 0.01, 0.03), dvec3(0.8, 0.1, 0.6), dvec3(0.3, 0.9, 0.2)),
        (dvec3(0.0, 0.0, 0.3), dvec3(0.0, 0.0, -2.0), dvec3(1.0, 0.0, 0.0)),
    ] {
        let z = normal.normalize_or_zero();
        let x = (x_axis - z * z.dot(x_axis)).normalize_or_zero();
        elements.extend(grid([7, 5], scene.array.pitch, at, x, z.cross(x)));
        scene.boards.push(Board { at, normal, x_axis });
    }
    (scene, elements)
}

/// Elements on a sphere of 12 cm, all facing its centre.
pub fn bowl(count: usize) -> (Scene, Vec<(DVec3, DVec3)>) {
    let middle = dvec3(0.0, 0.0, 0.12);
    let element = |i: usize| {
        let (sin, cos) = (0.15 + 0.84 * i as f64 / count as f64).sin_cos();
        let (y, x) = (2.4 * i as f64).sin_cos();
        let at = middle + 0.12 * dvec3(sin * x, sin * y, -cos);
        (at, (middle - at).normalize_or_zero())
    };
    let elements: Vec<_> = (0..count).map(element).collect();
    let mut scene = quiet_air();
    scene.array.file = Some("bowl.csv".to_owned());
    let placed = elements.iter().map(|&(at, normal)| Placed { at, normal }).collect();
    scene.array.placed = Elements::new(placed, None);
    (scene, elements)
}

/// Two bowls, face to face.
fn two_bowls() -> (Scene, Vec<(DVec3, DVec3)>) {
    let (scene, elements) = bowl(60);
    let turn = DQuat::from_rotation_x(0.3);
    let opposite = Board { at: dvec3(0.0, 0.02, 0.3), normal: turn * DVec3::NEG_Z, x_axis: DVec3::X };
    let axes = opposite.axes().unwrap();
    let again = elements.iter().map(|&(at, normal)| (opposite.at + axes * at, axes * normal));
    let elements: Vec<_> = elements.iter().copied().chain(again).collect();
    (Scene { boards: vec![Board::default(), opposite], ..scene }, elements)
}

#[test]
fn boards_and_bowls_radiate_from_their_poses() {
    let region = || places(dvec3(-0.05, -0.06, 0.08), dvec3(0.05, 0.06, 0.26));
    let (scene, elements) = tilted_boards();
    let drive = scattered(70, STEP);
    assert_heard("two boards", &scene, &drive, &playing(&elements, &drive), &region());
    let (scene, elements) = bowl(60);
    let drive = scattered(60, STEP);
    assert_heard("a bowl", &scene, &drive, &playing(&elements, &drive), &region());
    let (scene, elements) = two_bowls();
    let drive = scattered(120, STEP);
    assert_heard("two bowls", &scene, &drive, &playing(&elements, &drive), &region());
}

#[test]
fn reflectors_add_images_and_a_liquid_a_series_of_them() {
    let mut scene = quiet_air();
    (scene.array.columns, scene.array.rows) = (9, 6);
    let drive = scattered(54, STEP);
    let direct = || playing(&grid([9, 6], 0.0105, DVec3::ZERO, DVec3::X, DVec3::Y), &drive);
    scene.reflectors = vec![
        Reflector { point: dvec3(0.1, 0.0, 0.0), normal: dvec3(-1.0, 0.0, 0.1), coefficient: -0.6 },
        Reflector { point: dvec3(0.0, 0.0, 0.25), normal: dvec3(0.1, 0.05, -2.0), coefficient: 1.0 },
    ];
    let mut pistons = direct();
    scene.reflectors.iter().for_each(|it| pistons.extend(mirrored(&direct(), it)));
    assert_heard(
        "walls",
        &scene,
        &drive,
        &pistons,
        &places(dvec3(-0.08, -0.08, 0.02), dvec3(0.08, 0.08, 0.2)),
    );

    scene.reflectors.clear();
    scene.plane.centre.z = 0.1;
    scene.liquid.reflects = true;
    for reflectivity in [0.0, 0.6, -0.4] {
        scene.array.reflectivity = reflectivity;
        let mut pistons = Vec::new();
        for times in 0..80 {
            let gain = (reflectivity * 0.9994f64).powi(times);
            for up in [true, false] {
                let (z, normal, gain) = match up {
                    true => (-0.2 * f64::from(times), DVec3::Z, gain),
                    false => (0.2 * f64::from(times + 1), DVec3::NEG_Z, 0.9994 * gain),
                };
                pistons.extend(direct().into_iter().map(|it| Piston {
                    at: it.at.with_z(z),
                    normal,
                    u: gain * it.u,
                }));
            }
        }
        let region = places(dvec3(-0.08, -0.08, 0.002), dvec3(0.08, 0.08, 0.1));
        assert_heard(&format!("a liquid, {reflectivity}"), &scene, &drive, &pistons, &region);
        // Nor are there images that nobody hears: those left out are together near 1e-13 of the board.
        let pairs = Aperture::new(&scene).faces.len() as i32 / 2;
        let of_rest = |first: i32| -> f64 {
            let both = (reflectivity * 0.9994f64).abs();
            (first..first + 200).map(|times| both.powi(times) / f64::from(2 * times + 1)).sum()
        };
        let (left_out, with_the_last) = (of_rest(pairs), of_rest(pairs - 1));
        assert!(left_out < 1e-13 && (pairs == 1 || with_the_last > 3e-14), "{pairs}: {with_the_last:e}");
    }
}

#[test]
fn a_rigid_wall_has_no_slope_and_a_soft_one_no_sound() {
    let mut scene = quiet_air();
    let wall = Reflector { point: dvec3(0.11, 0.0, 0.02), normal: dvec3(-1.0, 0.2, -0.3), coefficient: 1.0 };
    let (drive, n) = (scattered(256, STEP), wall.normal.normalize_or_zero());
    let at = |point: DVec3| point - n * n.dot(point - wall.point);
    for coefficient in [1.0, -1.0] {
        scene.reflectors = vec![Reflector { coefficient, ..wall.clone() }];
        let aperture = Aperture::new(&scene);
        for point in places(dvec3(0.0, -0.05, 0.05), dvec3(0.1, 0.05, 0.15)) {
            let step = 1e-4;
            let around = [at(point) + n * step, at(point), at(point) - n * step].to_vec();
            let p = reference::pressure(&aperture, &drive, &Samples::at(around));
            let off = if coefficient > 0.0 { (p[0] - p[2]).norm() } else { p[1].norm() };
            let alone =
                reference::pressure(&Aperture::new(&quiet_air()), &drive, &Samples::at(vec![at(point)]));
            // The field is even in the distance: its differences are only rounding.
            assert!(off < 1e-12 * (1.0 + alone[0].norm()), "{coefficient}: {off} of {}", alone[0].norm());
        }
    }
}

#[test]
fn a_rotation_of_the_whole_scene_rotates_the_field() {
    let (mut scene, _) = tilted_boards();
    scene.reflectors =
        vec![Reflector { point: dvec3(0.0, 0.3, 0.1), normal: dvec3(0.1, -1.0, 0.2), coefficient: 0.7 }];
    let drive = scattered(70, STEP);
    let points = places(dvec3(-0.05, -0.06, 0.08), dvec3(0.05, 0.06, 0.26));
    let (turn, shift) = (
        DMat3::from_quat(DQuat::from_axis_angle(dvec3(0.3, -0.5, 0.8).normalize_or_zero(), 1.1)),
        dvec3(0.2, -0.1, 0.05),
    );
    let mut turned = scene.clone();
    for board in &mut turned.boards {
        (board.at, board.normal, board.x_axis) =
            (turn * board.at + shift, turn * board.normal, turn * board.x_axis);
    }
    for reflector in &mut turned.reflectors {
        (reflector.point, reflector.normal) = (turn * reflector.point + shift, turn * reflector.normal);
    }
    let moved = points.iter().map(|point| turn * *point + shift).collect();
    let before = reference::pressure(&Aperture::new(&scene), &drive, &Samples::at(points));
    let after = reference::pressure(&Aperture::new(&turned), &drive, &Samples::at(moved));
    let peak = before.iter().map(|p| p.norm()).fold(0.0, f64::max);
    for (before, after) in before.iter().zip(&after) {
        assert!((before - after).norm() < 1e-12 * peak, "{before} is not {after}");
    }
}

/// Maps of boards keep their tolerance at every pixel, also on planes that cross a board or lie behind one.
#[test]
fn maps_of_boards_keep_their_tolerance() {
    const SIZE: (usize, usize) = (70, 50);
    let (boards, _) = tilted_boards();
    let (bowl, _) = bowl(60);
    let (bowls, _) = two_bowls();
    let mut facing = quiet_air();
    facing.boards =
        vec![Board::default(), Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, x_axis: DVec3::X }];
    let mut standing = quiet_air();
    standing.liquid.reflects = true;
    standing.array.reflectivity = 0.5;
    let section = Plane { y_axis: DVec3::Z, ..Plane::default() };
    for (what, scene, plane) in [
        ("two boards", &boards, Plane::default()),
        ("through two boards", &boards, Plane { centre: DVec3::Z * 0.15, ..section.clone() }),
        (
            "a bowl",
            &bowl,
            Plane { centre: DVec3::Z * 0.12, size: glam::DVec2::splat(0.05), ..section.clone() },
        ),
        (
            "between bowls",
            &bowls,
            Plane { centre: DVec3::Z * 0.15, size: glam::DVec2::splat(0.05), ..section.clone() },
        ),
        ("between boards", &facing, section.clone()),
        ("behind a board", &facing, Plane { centre: DVec3::Z * 0.25, ..Plane::default() }),
        ("between array and liquid", &standing, Plane { centre: DVec3::Z * 0.05, ..section }),
    ] {
        let drive = scattered(scene.elements(), STEP);
        let samples = Samples::on_plane(&plane, SIZE.0, SIZE.1).unwrap();
        let exact = reference::pressure(&Aperture::new(scene), &drive, &samples);
        let peak = exact.iter().map(|p| p.norm()).fold(0.0, f64::max) / 2f64.sqrt();
        for evaluator in fast_evaluators() {
            let name = format!("{what}, {evaluator:?}");
            let request = Request {
                plane: plane.clone(),
                ..Request::new(scene, vec![drive.clone()], Quantity::Rms, SIZE)
            };
            let map = Stages::new(evaluator).map(&request).unwrap().clone();
            for (value, p) in map.values.iter().zip(&exact) {
                let off = (f64::from(*value) - p.norm() / 2f64.sqrt()).abs();
                assert!(off <= 1.05e-3 * peak, "{name}: {off:e} of {peak} ({})", map.how);
            }
        }
    }
}

/// The incident wave at a reflecting liquid is half of the total: without the array's own reflections the depression
/// does not change.
#[test]
fn a_reflecting_surface_is_pressed_by_the_incident_wave() {
    let mut scene = quiet_air();
    let drive = vec![scattered(256, STEP)];
    let force = |scene: &Scene| {
        let request = Request::new(scene, drive.clone(), Quantity::Radiation, (64, 64));
        Stages::new(Evaluator::Cpu).pressed(&request).unwrap().force
    };
    let before = force(&scene);
    scene.liquid.reflects = true;
    let after = force(&scene);
    let expected = before * (1.9994f64 / 2.0).powi(2);
    assert!((after / expected - 1.0).abs() < 1e-6, "{before} becomes {after}");
    scene.array.reflectivity = 0.5;
    assert!((force(&scene) / expected - 1.0).abs() > 1e-3, "the array's reflections press, too");
}
