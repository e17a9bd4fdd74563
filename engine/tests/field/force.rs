//! Maps of potential and force of a bead, against those computed at every pixel.

use glam::{DVec3, dvec2, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::{By, Evaluator, Quantity, Request, Samples, Stages};
use sonoglyph::force::Levitation;
use sonoglyph::scene::{Board, ElementModel, Material, Plane, Scene};

use crate::{STEP, scattered, three_foci};

const SIZE: (usize, usize) = (90, 70);

/// N or J, at every pixel of a plane.
fn values(quantity: Quantity, scene: &Scene, drives: &[Drive], plane: &Plane) -> Vec<f64> {
    let levitation = Levitation::new(scene, &Aperture::new(scene), drives);
    let pixels = Samples::on_plane(plane, SIZE.0, SIZE.1).unwrap();
    let points: Vec<_> = (0..pixels.len()).map(|i| pixels.point(i)).collect();
    match quantity {
        Quantity::Gorkov => points.iter().map(|&point| levitation.potential(point)).collect(),
        other => {
            assert_eq!(other, Quantity::Force);
            levitation.forces_at(&points).into_iter().map(DVec3::length).collect()
        }
    }
}

#[test]
fn maps_of_beads_keep_their_tolerance_on_any_plane() {
    let (mut scene, drives) = three_foci();
    scene.bead.material = Material::Water;
    let level = scene.plane.clone();
    let upright = Plane { y_axis: DVec3::Z, centre: dvec3(0.0, 0.002, 0.1), ..level.clone() };
    let low = Plane { centre: dvec3(0.0, 0.0, 0.004), ..level.clone() };
    let to_the_array =
        Plane { y_axis: DVec3::Z, centre: dvec3(0.0, 0.002, 0.05), size: dvec2(0.08, 0.1), ..level.clone() };
    let tilted = Plane { x_axis: dvec3(1.0, 0.2, 0.4), y_axis: dvec3(0.0, 1.0, -0.5), ..level.clone() };
    // Its lowest corner is just clear of the array.
    let sloping = Plane {
        x_axis: dvec3(1.0, 0.0, 0.4),
        centre: dvec3(0.0, 0.0, 0.04),
        size: dvec2(0.1, 0.08),
        ..level.clone()
    };
    for (name, plane, drives, is_direct) in [
        ("level", level.clone(), &drives[..1], false),
        ("level, of drives that take turns", level, &drives[..], false),
        ("upright", upright, &drives[..1], false),
        ("tilted", tilted, &drives[..1], false),
        ("sloping", sloping, &drives[..1], false),
        ("near", low, &drives[..1], true),
        ("down to the array", to_the_array, &drives[..1], false),
    ] {
        let plane_width = plane.size.x;
        // Of points, the sound is a wave everywhere; that of pistons is smooth down to the array.
        let is_low = name == "down to the array";
        scene.array.element = if is_low { ElementModel::Piston } else { ElementModel::Point };
        scene.medium.absorption = Some(0.0);
        for (tolerance, (quantity, expected)) in [Quantity::Force, Quantity::Gorkov]
            .map(|quantity| (quantity, values(quantity, &scene, drives, &plane)))
            .into_iter()
            .flat_map(|of| [1e-2, 1e-3, 1e-4].map(|tolerance| (tolerance, of.clone())))
            // Maps of pistons have a limit of their own.
            .filter(|(tolerance, _)| !is_low || *tolerance == 1e-2)
        {
            let peak = expected.iter().fold(0.0f64, |most, value| most.max(value.abs()));
            let plane = Plane { tolerance, ..plane.clone() };
            let request = Request { plane, ..Request::new(&scene, drives.to_vec(), quantity, SIZE) };
            let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
            let off = map.values.iter().zip(&expected).map(|(&value, it)| (f64::from(value) - it).abs());
            let off = off.fold(0.0, f64::max) / peak;
            println!(
                "{quantity:?}, {name} {tolerance:e}: {off:.1e}, measured {:.1e}, {}",
                map.error, map.how
            );
            assert!(off < tolerance && map.error <= tolerance, "{name} {tolerance:e}: {off:e}, {}", map.how);
            assert!(off < 20.0 * map.error + 1e-5, "{name} {tolerance:e}: {off:e}, measured {:e}", map.error);
            assert_eq!(map.how.contains("at every pixel"), is_direct, "{name}: {}", map.how);
            let said: Vec<usize> = map.how.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            if let [columns, rows, near] = said[..] {
                assert_eq!(map.evaluated, columns * rows + near, "{name}: {}", map.how);
                let step: f64 =
                    map.how.split(" mm").next().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
                let width = 1e-3 * step * columns as f64;
                assert!(width > plane_width && width < 2.0 * plane_width, "{name}: {}", map.how);
                assert!(
                    (near > 0) == (name == "down to the array") && near < SIZE.0 * SIZE.1,
                    "{name}: {}",
                    map.how
                );
            }
        }
    }
}

#[test]
fn force_curves_run_from_one_end_to_the_other() {
    const REACH: f64 = 0.004;
    let (scene, drives) = three_foci();
    let levitation = Levitation::new(&scene, &Aperture::new(&scene), &drives[..1]);
    let at = dvec3(0.001, -0.002, 0.098);
    for (count, step) in [(1, 0.0), (2, 0.008), (9, 0.001)] {
        for (axis, curve) in
            [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(levitation.curves(at, REACH, count))
        {
            assert_eq!(curve.len(), count);
            for (i, [place, force]) in curve.into_iter().enumerate() {
                assert!((place + REACH - step * i as f64).abs() < 1e-12, "{axis}, {i} of {count}: {place}");
                let expected = levitation.force(at + axis * place).dot(axis);
                assert!(
                    (force - expected).abs() <= 1e-9 * expected.abs(),
                    "{axis}, {place}: {force}, {expected}"
                );
            }
        }
    }
}

#[test]
fn near_is_near_a_boards_own_place() {
    let (mut scene, drives) = three_foci();
    let below = Board { at: DVec3::Z * 0.05, ..Board::default() };
    let above = Board { at: DVec3::Z * 0.15, normal: DVec3::NEG_Z, ..Board::default() };
    for (board, height, is_direct) in [(&below, 0.054, true), (&below, 0.1, false), (&above, 0.1, false)] {
        scene.boards = vec![board.clone()];
        let plane = Plane { centre: DVec3::Z * height, ..scene.plane.clone() };
        let request = Request { plane, ..Request::new(&scene, drives[..1].to_vec(), Quantity::Force, SIZE) };
        let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
        assert_eq!(map.how.contains("at every pixel"), is_direct, "{board:?}, {height} m: {}", map.how);
    }
}

/// A few elements, an irregular drive of them, and a plane upright from just above the array.
fn small() -> (Scene, Drive) {
    let plane = Plane {
        y_axis: DVec3::Z,
        centre: dvec3(0.0, 0.002, 0.031),
        size: dvec2(0.02, 0.06),
        tolerance: 0.1,
        ..Plane::default()
    };
    let mut scene = Scene { plane, ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (3, 3);
    (scene, scattered(9, STEP))
}

#[test]
fn exact_force_maps_have_the_force_of_every_pixel_times_the_envelope() {
    let (mut scene, drive) = small();
    scene.plane.tolerance = 0.0;
    let expected = values(Quantity::Force, &scene, std::slice::from_ref(&drive), &scene.plane);
    for part in [1.0, 0.25] {
        let request = Request { part, ..Request::new(&scene, vec![drive.clone()], Quantity::Force, SIZE) };
        let map = Stages::new(Evaluator::Cpu).map(&request).unwrap().clone();
        assert_eq!(map.by, By::Reference);
        for (value, force) in map.values.iter().zip(&expected) {
            assert!((f64::from(*value) - part * force).abs() <= 1e-6 * part * force, "{value}, {force} N");
        }
    }
}
