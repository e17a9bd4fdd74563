//! Tests of the objective: derivatives against central differences, and fields known to be feasible.

use glam::{DVec2, DVec3};

use super::*;
use crate::acoustics::Aperture;
use crate::scene::{Array, Liquid, Scene};
use crate::solver::descent::Descent;
use crate::solver::shape::grid::{Grid, Layout};
use crate::solver::shape::picture::Wanted;
use crate::solver::shape::response::Response;
use crate::solver::starts::scatter;

fn scaled<T: Real>(aperture: &Aperture, points: &[DVec3], scale: f64) -> Table<T> {
    let mut table = Table::new(aperture.driven.len());
    aperture.transfer(points).rows().for_each(|row| table.push(row, scale));
    table
}

/// A few samples of a stroke, and a quiet grid and table.
fn objective<T: Real>(aperture: &Aperture, drives: usize, weights: Weights) -> Objective<T> {
    const SCALE: f64 = 1e-2;
    let stroke: Vec<_> = (0..9).map(|i| DVec3::new(2e-3 * f64::from(i), 1e-3, 0.05)).collect();
    let mut objective = Objective::new(scaled(aperture, &stroke, SCALE), drives, weights);
    let layout = Layout::new(aperture, 0.05, DVec2::splat(0.05), 2);
    let mut mask = vec![T::default(); layout.len()];
    layout.places(aperture.pitch).for_each(|(index, _)| mask[index] = T::of(scatter(index)));
    let grid = Samples::Grid(Box::new(Grid::new(aperture, layout, SCALE)));
    objective.quiet.push(Quiet::new(grid, mask));
    let zone: Vec<_> = (0..19).map(|i| DVec3::new(-0.03, 2e-3 * f64::from(i), 0.06)).collect();
    let zone = Samples::Table(scaled(aperture, &zone, 2.0 * SCALE));
    objective.quiet.push(Quiet::new(zone, vec![T::of(0.7); 19]));
    objective
}

fn check_strokes<T: Real>(step: f64, most: f64) {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns, scene.array.off) = (5, 7, vec![3, 11]);
    let aperture = Aperture::new(&scene);
    let alone = Weights {
        even: 2.0,
        quiet: 0.0,
        strong: 1.0,
        sharpness: 8,
        loudness: Loudness::Eight,
        picture: 0.0,
        floor: 0.0,
    };
    let all = Weights { even: 1.5, quiet: 1.0, strong: 0.0, sharpness: 16, ..alone };
    let kept = Weights { loudness: Loudness::Twelve, floor: 1e3, quiet: 0.4, ..all };
    for (drives, weights, is_free) in [
        (1, alone, false),
        (1, all, false),
        (1, kept, false),
        (3, kept, false),
        (1, kept, true),
        (3, kept, true),
    ] {
        // Angles of amplitudes follow the phases.
        let unknowns = drives * aperture.driven.len() * if is_free { 2 } else { 1 };
        let phases: Vec<_> = (0..unknowns).map(|n| 6.0 * scatter(n)).collect();
        let mut objective = objective::<T>(&aperture, drives, weights);
        objective.is_free = is_free;
        let mut gradient = vec![0.0; phases.len()];
        objective.evaluate(&phases, &mut gradient);
        let largest = gradient.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        for n in 0..phases.len() {
            let mut at = |by: f64| {
                let mut moved = phases.clone();
                moved[n] += by;
                objective.evaluate(&moved, &mut vec![0.0; phases.len()])
            };
            let expected = (at(step) - at(-step)) / (2.0 * step);
            let off = (gradient[n] - expected).abs() / largest;
            assert!(off < most, "{drives} drives, {weights:?}, element {n}: off by {off:e}");
        }
    }
}

#[test]
fn gradients_along_strokes_are_central_differences() {
    check_strokes::<f64>(1e-5, 1e-6);
    check_strokes::<f32>(1e-2, 3e-3);
}

const SCALE: f64 = 1e-2;
const ALONE: Weights = Weights {
    even: 1.5,
    quiet: 0.0,
    strong: 0.0,
    sharpness: 8,
    loudness: Loudness::Eight,
    picture: 3.0,
    floor: 0.0,
};

/// 33 elements.
fn small() -> Array {
    Array { rows: 5, columns: 7, off: vec![3, 11], ..Array::default() }
}

fn table(aperture: &Aperture, points: &[DVec3]) -> Table<f64> {
    let mut table = Table::new(aperture.driven.len());
    aperture.transfer(points).rows().for_each(|row| table.push(row, SCALE));
    table
}

/// A ring of some brightness on a grid, with its surroundings.
fn on_grid<T: Real>(aperture: &Aperture, liquid: Option<&Liquid>) -> Picture<T> {
    let layout = Layout::new(aperture, 0.05, DVec2::splat(0.04), 2);
    let (mut brightness, mut weight) = (vec![T::default(); layout.len()], vec![T::default(); layout.len()]);
    for (index, place) in layout.places(aperture.pitch) {
        let is_ring = (place.length() - 0.015).abs() < 0.006;
        brightness[index] = T::of(if is_ring { 0.3 + 0.7 * scatter(index) } else { 0.0 });
        weight[index] = T::of(if place.length() < 0.035 { 1.0 } else { 0.0 });
    }
    let response = liquid.map(|liquid| Response::new(liquid, &layout, aperture.pitch));
    let grid = Samples::Grid(Box::new(Grid::new(aperture, layout, SCALE)));
    Picture::new(grid, Wanted::new(brightness, weight), response)
}

fn check(objective: &mut Objective<f64>, elements: usize, what: &str) {
    for is_free in [false, true] {
        objective.is_free = is_free;
        check_unknowns(objective, if is_free { 2 * elements } else { elements }, what);
    }
}

fn check_unknowns(objective: &mut Objective<f64>, elements: usize, what: &str) {
    const STEP: f64 = 1e-5;
    let phases: Vec<_> = (0..elements).map(|n| 6.0 * scatter(n)).collect();
    let mut gradient = vec![0.0; elements];
    let value = objective.evaluate(&phases, &mut gradient);
    assert!(value.is_finite(), "{what}");
    let largest = gradient.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
    for n in 0..elements {
        let mut at = |by: f64| {
            let mut moved = phases.clone();
            moved[n] += by;
            objective.evaluate(&moved, &mut vec![0.0; elements])
        };
        let expected = (at(STEP) - at(-STEP)) / (2.0 * STEP);
        let off = (gradient[n] - expected).abs() / largest;
        assert!(off < 1e-6, "{what}, element {n}: off by {off:e}");
    }
}

#[test]
fn gradients_of_areas_are_central_differences() {
    let aperture = Aperture::new(&Scene { array: small(), ..Scene::default() });
    let stroke: Vec<_> = (0..9).map(|i| DVec3::new(2e-3 * f64::from(i), 1e-3, 0.05)).collect();
    let elsewhere: Vec<_> = (0..19).map(|i| DVec3::new(-0.05, 2e-3 * f64::from(i), 0.06)).collect();
    let scattered: Vec<_> =
        (0..40).map(|i| DVec3::new(0.03, 0.0, 0.05) * scatter(i) + DVec3::Z * 0.03).collect();
    for (name, liquid, drives) in
        [("pressure", None, 1), ("pressure", None, 2), ("depression", Some(Liquid::default()), 1)]
    {
        for strokes in [&stroke[..], &[]] {
            for quiet in [0.0, 0.4] {
                let what =
                    format!("{name}, {drives} drives, {} samples of strokes, quiet {quiet}", strokes.len());
                let weights = Weights { quiet, ..ALONE };
                let mut objective = Objective::new(table(&aperture, strokes), drives, weights);
                objective.picture = Some(on_grid(&aperture, liquid.as_ref()));
                let far = Samples::Table(table(&aperture, &elsewhere));
                objective.quiet.push(Quiet::new(far, vec![0.7; elsewhere.len()]));
                check(&mut objective, drives * aperture.driven.len(), &what);
            }
        }
    }
    let wanted: Vec<_> = (0..40).map(scatter).collect();
    let mut objective = Objective::new(table(&aperture, &[]), 1, ALONE);
    let samples = Samples::Table(table(&aperture, &scattered));
    objective.picture = Some(Picture::new(samples, Wanted::new(wanted, vec![1.0; 40]), None));
    check(&mut objective, aperture.driven.len(), "a table");
}

#[test]
fn quiet_samples_of_areas_count_as_separate_ones_do() {
    let aperture = Aperture::new(&Scene { array: small(), ..Scene::default() });
    let stroke: Vec<_> = (0..9).map(|i| DVec3::new(2e-3 * f64::from(i), 1e-3, 0.05)).collect();
    let zone: Vec<_> = (0..19).map(|i| DVec3::new(-0.05, 2e-3 * f64::from(i), 0.06)).collect();
    let layout = Layout::new(&aperture, 0.05, DVec2::splat(0.04), 2);
    let mut mask = vec![0.0; layout.len()];
    layout.places(aperture.pitch).for_each(|(index, _)| mask[index] = scatter(index));
    for (drives, loudness, strokes, zone) in [
        (1, Loudness::Eight, &[][..], &[][..]),
        (2, Loudness::Twelve, &stroke[..], &zone[..]),
        (3, Loudness::Eight, &[], &zone),
    ] {
        let weights = Weights { quiet: 0.4, loudness, ..ALONE };
        let count = drives * aperture.driven.len();
        let phases: Vec<_> = (0..count).map(|n| 6.0 * scatter(n)).collect();
        let of = |is_shared: bool| {
            let mut objective = Objective::new(table(&aperture, strokes), drives, weights);
            let mut picture = on_grid(&aperture, None);
            if is_shared {
                picture.be_quiet(mask.clone());
            } else {
                let grid = Samples::Grid(Box::new(Grid::new(&aperture, layout, SCALE)));
                objective.quiet.push(Quiet::new(grid, mask.clone()));
            }
            if !zone.is_empty() {
                let zone = Samples::Table(table(&aperture, zone));
                objective.quiet.push(Quiet::new(zone, vec![0.7; 19]));
            }
            objective.picture = Some(picture);
            let mut gradient = vec![0.0; count];
            (objective.evaluate(&phases, &mut gradient), gradient)
        };
        let [(shared, slopes), (separate, expected)] = [true, false].map(of);
        assert!((shared - separate).abs() < 1e-9, "{drives} drives: {shared} is {separate}");
        let largest = expected.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        for (slope, expected) in slopes.iter().zip(&expected) {
            assert!((slope - expected).abs() < 1e-9 * largest, "{drives} drives: {slope} is {expected}");
        }
    }
}

#[test]
fn a_field_that_a_drive_makes_is_found_again() {
    let aperture = Aperture::new(&Scene::default());
    let layout = Layout::new(&aperture, 0.1, DVec2::splat(0.05), 5);
    let mut grid = Grid::<f64>::new(&aperture, layout, SCALE);
    // Focused on a ring: its field is no result of any start.
    let mut known = Waves::zeros(256);
    for (n, position) in aperture.positions.iter().enumerate() {
        let away = (position.distance(DVec3::Z * 0.1) - 0.1) * aperture.element.wavenumber;
        let phase = away + 2.0 * (120.0 * position.x).sin() - (90.0 * position.y).cos();
        (known.re[n], known.im[n]) = (phase.cos(), phase.sin());
    }
    let mut field = Waves::zeros(layout.len());
    grid.forward(&known, &mut field);
    let mut brightness: Vec<_> = field.re.iter().zip(&field.im).map(|(re, im)| re * re + im * im).collect();
    let mut weight = vec![0.0; layout.len()];
    layout.places(aperture.pitch).for_each(|(index, _)| weight[index] = 1.0);
    brightness.iter_mut().zip(&weight).for_each(|(t, w)| *t *= w);
    let samples = Samples::Grid(Box::new(grid));
    let mut objective = Objective::new(Table::new(256), 1, Weights { picture: 1.0, ..ALONE });
    objective.picture = Some(Picture::new(samples, Wanted::new(brightness, weight), None));
    let start = objective.start(0, 256);
    let mut way = Descent::new(start, &mut objective);
    let before = way.value;
    for _ in 0..800 {
        if way.value < 1e-7 || !way.step(&mut objective) {
            break;
        }
    }
    assert!(before > 0.01 && way.value < 1e-6, "{before}, then {:e}", way.value);
}
