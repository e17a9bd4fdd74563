//! `sonoglyph bench stability`: every solver method on ill-conditioned sets of foci.

use std::f64::consts::TAU;

use glam::DVec3;
use serde_json::json;
use strum::VariantArray;

use crate::acoustics::Aperture;
use crate::bench::time::{Spent, digits};
use crate::bench::{Report, foci};
use crate::drive::Drive;
use crate::scene::{Focus, Method, Scene};
use crate::solver::{self, Problem, Quality, SolveError};

/// Batches of eight starts of the long search, the baseline of strength.
const SEARCHES: usize = 25;
/// Limit of foci for that search.
const MOST_SEARCHED: usize = 64;

/// An ill-conditioned set.
struct Case {
    name: &'static str,
    aperture: Aperture,
    foci: Vec<Focus>,
}

struct Record {
    case: &'static str,
    foci: usize,
    method: Method,
    cpu: f64,
    /// All numbers are finite, and no element exceeds full drive.
    is_sound: bool,
    quality: Quality,
    rank: usize,
    condition: f64,
    /// Loss of the weakest focus relative to the strongest of 200 starts.
    loss: Option<f64>,
}

/// A thorough measurement has rows for all methods instead of `best` alone, a set of 1000 foci, and a long search as
/// the baseline of strength.
///
/// # Errors
/// A method that fails.
pub fn run(is_thorough: bool) -> anyhow::Result<Report> {
    let mut records = Vec::new();
    for case in cases(is_thorough) {
        let problem = Problem::new(&case.aperture, case.foci.clone());
        let is_searched = is_thorough && case.foci.len() <= MOST_SEARCHED;
        let strongest = is_searched.then(|| weakest(&problem, &solver::search(&problem, SEARCHES).values));
        for &method in Method::VARIANTS.iter().filter(|method| **method != Method::Focus) {
            records.push(measure(&case, &problem, method, strongest)?);
        }
    }
    let sound = records.iter().filter(|record| record.is_sound).count();
    let mut notes = vec![format!(
        "{sound} of {} solutions by all methods are valid: all numbers finite, and no element above full drive.",
        records.len()
    )];
    if is_thorough {
        notes.push(
            "loss: of the weakest focus, in pressure/target, relative to the strongest of 200 starts; negative if the \
             method is better."
                .to_owned(),
        );
    }
    Ok(Report {
        header: vec![
            "set",
            "M",
            "method",
            "CPU ms",
            "valid",
            "rank",
            "condition",
            "residual",
            "std/mean",
            "weakest Pa",
            "loss",
        ],
        rows: records.iter().filter(|record| is_thorough || record.method == Method::Best).map(row).collect(),
        notes,
        records: records.iter().map(json).collect(),
        charts: Vec::new(),
    })
}

fn measure(
    case: &Case,
    problem: &Problem<'_>,
    method: Method,
    strongest: Option<f64>,
) -> Result<Record, SolveError> {
    let mut excitation = solver::excite(problem, method, 0)?;
    let spent = Spent::on(|_| {
        excitation = solver::excite(problem, method, 0)?;
        Ok::<_, SolveError>(())
    })?;
    let Aperture { positions, driven, .. } = problem.aperture;
    let drive = Drive::uniform(positions.len(), driven, &excitation.values);
    let pressures = problem.transfer.pressure(&drive.excitation(driven));
    let quality = Quality::new(problem, &excitation, &pressures);
    let (rank, condition) = solver::rank_and_condition(&problem.transfer);
    let figures = [quality.mean_pressure, quality.min_pressure, quality.spread, quality.residual];
    let is_sound = drive.phases.iter().chain(&figures).all(|value| value.is_finite())
        && drive.amplitudes.iter().all(|amplitude| (0.0..=1.0).contains(amplitude))
        && excitation.values.iter().all(|u| u.is_finite());
    let loss = strongest.map(|strongest| 1.0 - weakest(problem, &excitation.values) / strongest);
    Ok(Record {
        case: case.name,
        foci: case.foci.len(),
        method,
        cpu: spent.cpu,
        is_sound,
        quality,
        rank,
        condition,
        loss,
    })
}

/// The smallest pressure/target of the uniform drive.
fn weakest(problem: &Problem<'_>, values: &[num_complex::Complex64]) -> f64 {
    let Aperture { positions, driven, .. } = problem.aperture;
    let drive = Drive::uniform(positions.len(), driven, values);
    let pressures = problem.transfer.pressure(&drive.excitation(driven));
    let relative = pressures.iter().zip(&problem.foci).map(|(p, focus)| p.norm() / focus.target);
    relative.fold(f64::INFINITY, f64::min)
}

fn cases(is_thorough: bool) -> Vec<Case> {
    let foci_at = |points: &[DVec3]| -> Vec<Focus> {
        points.iter().map(|&position| Focus::new(position, 1.0)).collect()
    };
    let ring = |count: usize, radius: f64, z: f64| -> Vec<DVec3> {
        let point = |i: usize| {
            let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        };
        (0..count).map(point).collect()
    };
    let aperture = |change: fn(&mut Scene)| {
        let mut scene = Scene::default();
        change(&mut scene);
        Aperture::new(&scene)
    };
    let usual = || aperture(|_| ());
    let small = |rows: u32, columns: u32| {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (rows, columns);
        Aperture::new(&scene)
    };
    let at = DVec3::new(0.01, 0.0, 0.1);
    let wavelength = usual().wavelength();
    let mut unequal = foci_at(&ring(4, 0.02, 0.1));
    (unequal[0].target, unequal[2].target) = (1000.0, 1e-3);
    let case = |name, aperture, foci| Case { name, aperture, foci };
    let mut cases = vec![
        case("coincident", usual(), foci_at(&[at, at])),
        case("λ/1000 apart", usual(), foci_at(&[at, at + wavelength / 1000.0 * DVec3::X, at.with_x(-0.03)])),
        case("ring of 48", usual(), foci_at(&ring(48, 0.02, 0.1))),
        case("as many as elements", small(4, 4), foci_at(&ring(16, 0.03, 0.1))),
        case("more than elements", small(3, 3), foci_at(&ring(20, 0.03, 0.1))),
        case("one element", small(1, 1), foci_at(&ring(5, 0.02, 0.1))),
        case(
            "most elements off",
            aperture(|scene| scene.array.off = (3..256).collect()),
            foci_at(&ring(4, 0.02, 0.1)),
        ),
        case("targets 1 : 10⁶", usual(), unequal),
        case("1 mm away", usual(), foci_at(&ring(4, 0.02, 1e-3))),
        case("10 m away", usual(), foci_at(&ring(4, 0.5, 10.0))),
        case("20 kHz", aperture(|scene| scene.array.frequency = 20e3), foci_at(&ring(8, 0.02, 0.1))),
        case("1 MHz", aperture(|scene| scene.array.frequency = 1e6), foci_at(&ring(8, 0.02, 0.1))),
        case("scaled by 10⁻⁶", scaled(usual(), 1e-6), foci_at(&ring(8, 0.02e-6, 0.1e-6))),
        case("scaled by 10⁶", scaled(usual(), 1e6), foci_at(&ring(8, 0.02e6, 0.1e6))),
    ];
    if is_thorough {
        cases.push(case("1000 foci", usual(), foci::disc(1000)));
    }
    cases
}

/// Array and wave with all lengths times `scale`, without absorption.
fn scaled(mut aperture: Aperture, scale: f64) -> Aperture {
    aperture.element.wavenumber /= scale;
    aperture.element.radius *= scale;
    aperture.element.attenuation = 0.0;
    aperture.pitch *= scale;
    aperture.positions.iter_mut().for_each(|position| *position *= scale);
    for face in &mut aperture.faces {
        let mut layout = (*face.layout).clone();
        layout.positions.iter_mut().for_each(|position| *position *= scale);
        face.layout = layout.into();
    }
    aperture
}

fn row(record: &Record) -> Vec<String> {
    let quality = &record.quality;
    vec![
        record.case.to_owned(),
        record.foci.to_string(),
        record.method.into_str().to_owned(),
        digits(record.cpu * 1e3),
        if record.is_sound { "yes" } else { "NO" }.to_owned(),
        record.rank.to_string(),
        format!("{:.1e}", record.condition),
        format!("{:.1e}", quality.residual),
        format!("{:.1e}", quality.spread),
        format!("{:.3e}", quality.min_pressure),
        record.loss.map_or("-".to_owned(), |loss| format!("{:.1} %", 100.0 * loss)),
    ]
}

fn json(record: &Record) -> serde_json::Value {
    let quality = &record.quality;
    json!({
        "set": record.case,
        "foci": record.foci,
        "method": record.method.into_str(),
        "cpu_ms": record.cpu * 1e3,
        "sound": record.is_sound,
        "rank": record.rank,
        "condition": record.condition,
        "residual": quality.residual,
        "spread": quality.spread,
        "min_pressure": quality.min_pressure,
        "loss": record.loss,
    })
}
