//! Tests of side lobes: of elements of any strength, of mirrored drives, and of lobes between samples.

use glam::DVec2;

use super::*;
use crate::scene::Scene;
use crate::solver::starts::scatter;

fn array(rows: u32, columns: u32) -> Aperture {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (rows, columns);
    Aperture::new(&scene)
}

#[test]
fn elements_of_any_strength_are_heard() {
    let layout = Layout::new(&array(4, 5), 0.06, DVec2::splat(0.03), 1);
    for strength in [1e-30, 1.0, 1e30] {
        let mut aperture = array(4, 5);
        aperture.element.strength = strength;
        let u: Vec<_> = (0..20).map(|n| 2.0 * Complex64::cis(9.0 * scatter(n))).collect();
        let heard = heard(&aperture, &[Focus::new(DVec3::Z * 0.06, 1.0)], &layout, &u, 8e-3);
        let loudest = heard.iter().map(|(_, p)| *p).fold(0.0, f64::max);
        assert!(loudest > 0.0, "{strength:e}");
        for (at, p) in heard {
            let error = (p - moduli(&aperture, &[at], &u)[0]).abs();
            assert!(error < 1e-4 * loudest, "{strength:e}, {at}: {p}");
        }
    }
}

/// A drive to the first of two places and, so many times as loud, to the second.
fn played(aperture: &Aperture, places: [DVec2; 2], part: f64) -> Vec<Complex64> {
    let transfer = aperture.transfer(&places.map(|place| place.extend(0.1)));
    transfer.back(&[Complex64::ONE, Complex64::from(part)])
}

/// 8 x 8 elements, or a strip of them along the diagonal, mirrored.
fn mirrored(mirror: DVec2, is_strip: bool) -> Aperture {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (8, 8);
    let is_off = |&n: &usize| {
        let (row, column) = (n / 8, n % 8);
        is_strip && column.abs_diff(if mirror.x * mirror.y > 0.0 { row } else { 7 - row }) > 1
    };
    scene.array.off = (0..64).filter(is_off).collect();
    Aperture::new(&scene)
}

#[test]
fn mirrored_drives_have_mirrored_side_lobes() {
    let far = DVec2::new(-0.06, -0.05);
    for first in [DVec2::new(0.031, 0.012), DVec2::new(0.004, 0.022), DVec2::new(0.017, 0.0345)] {
        for is_strip in [false, true] {
            let lobe = |mirror: DVec2| {
                let aperture = mirrored(mirror, is_strip);
                let places = [first, DVec2::new(-0.012, 0.041)].map(|place| place * mirror);
                let focus = Focus::new((far * mirror).extend(0.1), 1.0);
                let problem = Problem::new(&aperture, vec![focus]);
                let u = played(&aperture, places, 0.6);
                side_lobe(&problem, &problem.foci, &Plane::default(), &u).unwrap()
            };
            let (at, loudest) = lobe(DVec2::ONE);
            for (x, y) in [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                let mirror = DVec2::new(x, y);
                let ((other_at, other), expected) = (lobe(mirror), at.truncate() * mirror);
                let what = format!("{first}, strip: {is_strip}, {mirror}");
                assert!((other / loudest - 1.0).abs() < 1e-9, "{what}: {other}, not {loudest}");
                assert!(other_at.truncate().distance(expected) < 1e-9, "{what}: {other_at}");
            }
        }
    }
}

#[test]
fn the_loudest_lobe_counts_even_if_samples_of_another_are_louder() {
    let aperture = array(6, 6);
    let focus = DVec2::new(-0.06, -0.06);
    let problem = Problem::new(&aperture, vec![Focus::new(focus.extend(0.1), 1.0)]);
    let area = Area::new(&problem, &Plane::default(), true);
    let Some(Area::Grid(layout)) = area else { panic!("{area:?}") };
    // The first place is a sample, the second lies in the middle of four.
    let places = [DVec2::new(0.0315, 0.0), DVec2::new(-0.02975, 0.01575)];
    let u = played(&aperture, places, 1.045);
    let samples = heard(&aperture, &problem.foci, &layout, &u, 8e-3);
    let loudest = samples.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!(loudest.0.truncate().distance(places[0]) < 1e-6, "{loudest:?}");
    let (at, p) = side_lobe(&problem, &problem.foci, &Plane::default(), &u).unwrap();
    assert!(at.truncate().distance(places[1]) < 2e-3 && p > loudest.1, "{at}: {p}");
}

#[test]
fn side_lobes_are_as_loud_as_the_elements() {
    let lobe = |strength: f64| {
        let mut aperture = array(4, 4);
        aperture.element.strength = strength;
        let problem = Problem::new(&aperture, vec![Focus::new(DVec3::new(0.02, 0.0, 0.1), 1.0)]);
        let u: Vec<_> = (0..16).map(|n| Complex64::cis(9.0 * scatter(n))).collect();
        side_lobe(&problem, &problem.foci, &Plane::default(), &u)
    };
    let (expected_at, expected) = lobe(1.0).unwrap();
    // Of powers of two, so that nothing is rounded otherwise.
    for strength in [2f64.powi(-20), 2f64.powi(20)] {
        let (at, p) = lobe(strength).unwrap_or_else(|| panic!("{strength:e}: no lobe"));
        assert!((p / strength / expected - 1.0).abs() < 1e-9, "{strength:e}: {p}, not {expected}");
        assert!(at.distance(expected_at) < 1e-9, "{strength:e}: {at}, not {expected_at}");
    }
}
