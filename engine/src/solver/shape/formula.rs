//! Tests of the objective's value against its formula in plain f64, and of the phases that areas start from.

use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::scene::Scene;
use crate::solver::descent::Function;
use crate::solver::shape::STROKES;
use crate::solver::shape::grid::{Grid, Layout};
use crate::solver::shape::objective::{Loudness, Objective, Quiet, Weights};
use crate::solver::shape::picture::{Picture, Wanted};
use crate::solver::shape::samples::Samples;
use crate::solver::shape::table::Table;
use crate::solver::starts::scatter;

/// Of transfers to strokes and to the quiet region.
const SCALE: f64 = 1e-2;

fn array(rows: u32, columns: u32) -> Aperture {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (rows, columns);
    Aperture::new(&scene)
}

fn table(aperture: &Aperture, points: &[DVec3]) -> Table<f64> {
    let mut table = Table::new(aperture.driven.len());
    aperture.transfer(points).rows().for_each(|row| table.push(row, SCALE));
    table
}

/// The mean of |p|² over drives in turn, at every point.
fn intensities(aperture: &Aperture, phases: &[f64], points: &[DVec3]) -> Vec<f64> {
    let transfer = aperture.transfer(points);
    let played: Vec<_> = phases.iter().map(|&phase| SCALE * Complex64::cis(phase)).collect();
    let drives: Vec<_> = played.chunks(aperture.driven.len()).map(|u| transfer.pressure(u)).collect();
    let mean = |m: usize| drives.iter().map(|p| p[m].norm_sqr()).sum::<f64>() / drives.len() as f64;
    (0..points.len()).map(mean).collect()
}

/// The objective of intensities along a stroke, and of intensities elsewhere with their mask.
fn formula(weights: &Weights, along: &[f64], quiet: &[(f64, f64)]) -> f64 {
    let count = along.len() as f64;
    let mean = along.iter().sum::<f64>() / count;
    let sum = along.iter().map(|intensity| (mean / intensity).powi(weights.sharpness)).sum::<f64>();
    let even = (sum / count).ln() / (2.0 * f64::from(weights.sharpness));
    let q = match weights.loudness {
        Loudness::Eight => 8,
        Loudness::Twelve => 12,
    };
    let sum = quiet.iter().map(|(intensity, mask)| mask * (intensity / mean).powi(q)).sum::<f64>();
    let loud = sum.ln() / (2.0 * f64::from(q));
    let lack = (0.5 * (weights.floor / mean).ln()).max(0.0);
    weights.even * even + weights.quiet * loud - 0.5 * weights.strong * mean.ln() + 15.0 * lack * lack
}

#[test]
fn the_value_is_its_formula_on_grids_and_on_the_loud_rows_of_tables() {
    let aperture = array(5, 7);
    let stroke: Vec<_> = (0..9).map(|i| DVec3::new(2e-3 * f64::from(i), 1e-3, 0.05)).collect();
    let zone: Vec<_> = (0..19).map(|i| DVec3::new(-0.03, 4e-3 * f64::from(i), 0.06)).collect();
    let layout = Layout::new(&aperture, 0.05, DVec2::splat(0.05), 2);
    for (drives, loudness) in [(1, Loudness::Eight), (2, Loudness::Twelve), (3, Loudness::Eight)] {
        let weights = Weights { quiet: 0.7, strong: 0.4, floor: 1e3, loudness, ..STROKES };
        let mut objective = Objective::new(table(&aperture, &stroke), drives, weights);
        let phases: Vec<_> = (0..drives * aperture.driven.len()).map(|n| 6.0 * scatter(n)).collect();
        let along = intensities(&aperture, &phases, &stroke);
        let check = |objective: &mut Objective<f64>, quiet: &[(f64, f64)], what: &str| {
            let value = objective.evaluate(&phases, &mut vec![0.0; phases.len()]);
            let expected = formula(&weights, &along, quiet);
            assert!((value - expected).abs() < 1e-9, "{drives} drives, {what}: {value} is {expected}");
        };
        let rows: Vec<_> =
            intensities(&aperture, &phases, &zone).into_iter().map(|intensity| (intensity, 0.7)).collect();
        objective.quiet.push(Quiet::new(Samples::Table(table(&aperture, &zone)), vec![0.7; zone.len()]));
        check(&mut objective, &rows, "all rows");
        let loudest = rows.iter().map(|row| row.0).fold(0.0, f64::max);
        let loud: Vec<_> = rows.iter().copied().filter(|row| row.0 >= 0.16 * loudest).collect();
        assert!(loud.len() < rows.len() && loud.len() % 8 > 0, "{loud:?}");
        assert!(objective.refresh(&phases));
        check(&mut objective, &loud, "loud rows");
        let mut mask = vec![0.0; layout.len()];
        layout.places(aperture.pitch).for_each(|(index, _)| mask[index] = scatter(index));
        let (masks, places): (Vec<_>, Vec<_>) =
            layout.places(aperture.pitch).map(|(index, place)| (mask[index], place.extend(0.05))).unzip();
        let on_grid: Vec<_> = intensities(&aperture, &phases, &places).into_iter().zip(masks).collect();
        let grid = Samples::Grid(Box::new(Grid::new(&aperture, layout, SCALE)));
        objective.quiet = vec![Quiet::new(grid, mask)];
        check(&mut objective, &on_grid, "a grid");
    }
}

#[test]
fn areas_start_from_the_phases_of_their_back_propagated_field() {
    let aperture = array(4, 4);
    let points: Vec<_> = (0..6).map(|i| DVec3::new(4e-3 * f64::from(i), 1e-3, 0.05)).collect();
    let (brightness, weight): (Vec<_>, Vec<_>) = (0..6).map(|i| (scatter(i), scatter(i + 9))).unzip();
    let moduli = brightness.iter().zip(&weight).map(|(t, w): (&f64, &f64)| Complex64::from((t * w).sqrt()));
    let field = aperture.transfer(&points).back(&moduli.collect::<Vec<_>>());
    let mut objective = Objective::new(Table::new(16), 1, STROKES);
    let samples = Samples::Table(table(&aperture, &points));
    objective.picture = Some(Picture::new(samples, Wanted::new(brightness, weight), None));
    for (phase, b) in objective.start(0, 16).iter().zip(&field) {
        assert!((Complex64::cis(phase - b.arg()) - 1.0).norm() < 1e-9, "{phase}, not {}", b.arg());
    }
}
