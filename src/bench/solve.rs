//! `sonoglyph bench solve`: time and quality of every solver method on random sets of foci.

use std::hint::black_box;

use glam::DVec3;
use serde_json::json;
use strum::VariantArray;

use crate::acoustics::Aperture;
use crate::bench::time::{ROUNDS, Spent, Spread, Times, digits};
use crate::bench::{Report, foci};
use crate::drive::Drive;
use crate::picture::chart::{Chart, Series};
use crate::scene::{Focus, Method, Scene};
use crate::solver::{self, Excitation, Problem, Quality, SolveError};

/// Foci per set, and sets of each size.
const SIZES: [usize; 2] = [8, 32];
const SETS: usize = 4;
/// Iterations of the published weighted Gerchberg-Saxton method, the baseline of time and quality.
const BASELINE_ITERATIONS: u32 = 200;

/// Sets of foci that are measured together.
#[derive(Debug)]
pub struct Workload {
    pub name: &'static str,
    pub aperture: Aperture,
    pub sets: Vec<Vec<Focus>>,
    /// Iterations of `best` in addition to its default.
    pub budgets: &'static [u32],
    /// Whether the bound is computed too, which takes longer than solving.
    pub is_judged: bool,
}

impl Workload {
    /// Random sets of foci, up to `depth` (m) above a plane.
    pub fn random(name: &'static str, foci: usize, depth: f64, sets: usize) -> Self {
        let sets = (0..sets).map(|set| foci::random(foci, depth, set as u64)).collect();
        Self { name, aperture: aperture(16), sets, budgets: &[], is_judged: true }
    }
}

/// A square array with `side` elements along a side, 10 mm apart, in air at 340 m/s.
pub fn aperture(side: u32) -> Aperture {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns, scene.array.pitch) = (side, side, 0.01);
    scene.medium.sound_speed = Some(340.0);
    Aperture::new(&scene)
}

#[derive(Debug)]
pub struct Record {
    pub workload: &'static str,
    pub elements: usize,
    pub foci: usize,
    pub method: String,
    /// Times of a solve including its transfer. A round is one set, or one repetition of a single set.
    pub times: Times,
    /// CPU time of the baseline over that of this method.
    ratio: Spread,
    /// Weakest focus relative to the baseline, set by set.
    strength: Spread,
    /// Means over the sets (Pa, peak), except the spread: the largest of all sets.
    mean: f64,
    weakest: f64,
    pub spread: f64,
    relative_to_single: f64,
    /// Smallest and mean guaranteed fraction of the bound, if the workload is judged.
    pub certified: Option<[f64; 2]>,
}

/// Solves a set, given its number and problem.
type Solve<'a> = Box<dyn Fn(usize, &Problem<'_>) -> Result<Excitation, SolveError> + 'a>;

/// A method with its results so far.
struct Candidate<'a> {
    solve: Solve<'a>,
    found: Found,
}

/// Time of a method, and quality of every set.
#[derive(Debug)]
pub struct Found {
    pub name: String,
    pub times: Times,
    pub qualities: Vec<Quality>,
}

/// # Errors
/// A method that fails.
pub fn run() -> anyhow::Result<Report> {
    let mut records = Vec::new();
    for foci in SIZES {
        records.extend(measure(&Workload::random("plane", foci, 0.0, SETS))?);
    }
    let charts = SIZES.map(|foci| (format!("solve-loss-{foci}"), loss(&records, foci))).into();
    Ok(report(&records, charts))
}

pub fn report(records: &[Record], charts: Vec<(String, Chart)>) -> Report {
    Report {
        header: vec![
            "foci", "elements", "M", "method", "CPU ms (wall)", "speed", "quartiles", "mean Pa", "weakest Pa",
            "to baseline", "std/mean", "to single", "of the bound", "least",
        ],
        rows: records.iter().map(row).collect(),
        notes: vec![
            format!(
                "CPU ms of a solve including its transfer, on one core: medians. speed: CPU time of the baseline, `wgs \
                 {BASELINE_ITERATIONS}`, over that of this method, measured alternately; to baseline: weakest focus \
                 relative to the baseline."
            ),
            "Pressures: peak, of the uniform drive, means over the sets; std/mean: the largest of all sets. of the \
             bound: guaranteed fraction of the upper bound, mean and least over the sets. `best, moved` starts from \
             the solution for foci 0.5 mm away."
                .to_owned(),
        ],
        charts,
        records: records.iter().map(json).collect(),
    }
}

/// Time against loss of random sets on a plane: a series per method with all its iteration counts, sorted by time.
pub fn loss(records: &[Record], foci: usize) -> Chart {
    let sets = records.iter().filter(|record| (record.workload, record.foci) == ("plane", foci));
    let point =
        |record: &Record| (1.0 - record.certified.map_or(f64::NAN, |parts| parts[1]), record.times.cpu_ms());
    let mut series = by_method(sets, |record| family(&record.method), point);
    series.iter_mut().for_each(|series| series.points.sort_by(|a, b| a.1.total_cmp(&b.1)));
    Chart {
        title: format!("Time against loss: {foci} random foci on a plane, 256 elements"),
        x_label: "1 - guaranteed fraction of the upper bound, mean".to_owned(),
        y_label: "CPU-ms per solve".to_owned(),
        series,
        levels: Vec::new(),
    }
}

/// A series per name of records.
pub fn by_method<'a>(
    records: impl Iterator<Item = &'a Record>,
    name: impl Fn(&'a Record) -> &'a str,
    point: impl Fn(&'a Record) -> (f64, f64),
) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for record in records {
        match all.iter_mut().find(|series| series.name == name(record)) {
            Some(series) => series.points.push(point(record)),
            None => all.push(Series { name: name(record).to_owned(), points: vec![point(record)] }),
        }
    }
    all
}

/// Method without its iteration count: `best 60` is `best`, but `best, moved` is another method.
fn family(method: &str) -> &str {
    match method.split_once(' ') {
        Some((name, _)) if !name.ends_with(',') => name,
        Some(_) | None => method,
    }
}

/// # Errors
/// A method that fails.
pub fn measure(workload: &Workload) -> Result<Vec<Record>, SolveError> {
    let Workload { name, aperture, sets, is_judged, .. } = workload;
    let problems: Vec<_> = sets.iter().map(|foci| Problem::new(aperture, foci.clone())).collect();
    let mut candidates = candidates(workload)?;
    // A single set is solved repeatedly.
    for (set, foci) in sets.iter().enumerate().cycle().take(sets.len().max(ROUNDS)) {
        for Candidate { solve, found } in &mut candidates {
            found.times.push(Spent::on(|_| {
                let problem = Problem::new(aperture, foci.clone());
                let excitation = solve(set, &problem)?;
                black_box(Drive::uniform(aperture.positions.len(), &aperture.driven, &excitation.values));
                Ok::<_, SolveError>(())
            })?);
        }
    }
    for Candidate { solve, found } in &mut candidates {
        for (set, problem) in problems.iter().enumerate() {
            found.qualities.push(quality(problem, &solve(set, problem)?));
        }
    }
    let bounds = is_judged.then(|| problems.iter().map(solver::bound).collect::<Vec<_>>());
    let place = (*name, aperture.positions.len(), sets[0].len());
    let found: Vec<_> = candidates.into_iter().map(|candidate| candidate.found).collect();
    Ok(records(place, &found, bounds.as_deref()))
}

/// Starts with the baseline.
fn candidates(workload: &Workload) -> Result<Vec<Candidate<'_>>, SolveError> {
    let candidate = |name: String, method: Method, iterations: u32| {
        let solve: Solve<'_> = Box::new(move |_, problem| solver::excite(problem, method, iterations));
        Candidate { solve, found: Found::of(name) }
    };
    let mut all = vec![candidate(format!("wgs {BASELINE_ITERATIONS}"), Method::Wgs, BASELINE_ITERATIONS)];
    for &method in Method::VARIANTS.iter().filter(|method| **method != Method::Focus) {
        all.push(candidate(method.into_str().to_owned(), method, 0));
    }
    all.extend(
        workload.budgets.iter().map(|&budget| candidate(format!("best {budget}"), Method::Best, budget)),
    );
    if workload.is_judged {
        all.push(moved(workload)?);
    }
    Ok(all)
}

/// `best` with a warm start from the solution for foci 0.5 mm away.
fn moved(workload: &Workload) -> Result<Candidate<'_>, SolveError> {
    let moved = |focus: &Focus| Focus { position: focus.position + 0.0005 * DVec3::X, ..*focus };
    let mut before = Vec::new();
    for foci in &workload.sets {
        let problem = Problem::new(&workload.aperture, foci.iter().map(moved).collect());
        before.push(solver::excite(&problem, Method::Best, 0)?);
    }
    let solve: Solve<'_> = Box::new(move |set, problem| Ok(solver::excite_from(problem, &before[set])));
    Ok(Candidate { solve, found: Found::of("best, moved".to_owned()) })
}

impl Found {
    fn of(name: String) -> Self {
        Self { name, times: Times::default(), qualities: Vec::new() }
    }
}

/// Records of a workload's name, element count and focus count; the first method is the baseline.
pub fn records(
    (workload, elements, foci): (&'static str, usize, usize),
    found: &[Found],
    bounds: Option<&[f64]>,
) -> Vec<Record> {
    let baseline = &found[0];
    let record = |Found { name, times, qualities }: &Found| {
        let count = qualities.len() as f64;
        let average = |of: fn(&Quality) -> f64| qualities.iter().map(of).sum::<f64>() / count;
        let strength = qualities
            .iter()
            .zip(&baseline.qualities)
            .map(|(own, other)| own.min_pressure / other.min_pressure);
        let certified = |bounds: &[f64]| {
            let parts = qualities.iter().zip(bounds).map(|(quality, bound)| quality.min_pressure / bound);
            [parts.clone().fold(f64::INFINITY, f64::min), parts.sum::<f64>() / count]
        };
        Record {
            workload,
            elements,
            foci,
            method: name.clone(),
            times: times.clone(),
            ratio: baseline.times.over(times),
            strength: Spread::of(strength.collect()),
            mean: average(|quality| quality.mean_pressure),
            weakest: average(|quality| quality.min_pressure),
            spread: qualities.iter().map(|quality| quality.spread).fold(0.0, f64::max),
            relative_to_single: average(|quality| quality.relative_to_single),
            certified: bounds.map(certified),
        }
    };
    found.iter().map(record).collect()
}

/// Quality of the uniform drive.
pub fn quality(problem: &Problem<'_>, excitation: &Excitation) -> Quality {
    let Aperture { positions, driven, .. } = problem.aperture;
    let drive = Drive::uniform(positions.len(), driven, &excitation.values);
    Quality::new(problem, excitation, &problem.transfer.pressure(&drive.excitation(driven)))
}

fn row(record: &Record) -> Vec<String> {
    let certified = |i: usize| record.certified.map_or("-".to_owned(), |parts| format!("{:.3}", parts[i]));
    vec![
        record.workload.to_owned(),
        record.elements.to_string(),
        record.foci.to_string(),
        record.method.clone(),
        record.times.text(),
        record.ratio.text(),
        record.ratio.quartiles_text(),
        digits(record.mean),
        digits(record.weakest),
        record.strength.text(),
        format!("{:.1e}", record.spread),
        format!("{:.3}", record.relative_to_single),
        certified(1),
        certified(0),
    ]
}

fn json(record: &Record) -> serde_json::Value {
    json!({
        "workload": record.workload,
        "elements": record.elements,
        "foci": record.foci,
        "method": record.method,
        "time": record.times.json(),
        "time_ratio": record.ratio.json(),
        "strength_ratio": record.strength.json(),
        "mean_pressure": record.mean,
        "min_pressure": record.weakest,
        "spread": record.spread,
        "relative_to_single": record.relative_to_single,
        "certified_least": record.certified.map(|parts| parts[0]),
        "certified_mean": record.certified.map(|parts| parts[1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_compared_with_the_baseline_and_stay_below_the_bound() {
        let records = measure(&Workload::random("plane", 4, 0.0, 2)).unwrap();
        let of = |method: &str| records.iter().find(|record| record.method == method).unwrap();
        assert_eq!(of("wgs 200").ratio.quartiles, [1.0; 2]);
        assert_eq!(of("wgs 200").strength.quartiles, [1.0; 2]);
        assert!(of("best").strength.median > of("naive").strength.median, "{records:?}");
        for record in &records {
            let [least, mean] = record.certified.unwrap();
            assert!(0.0 < least && least <= mean && mean <= 1.0 + 1e-9, "{record:?}");
        }
    }

    #[test]
    fn iterations_do_not_change_the_method() {
        assert_eq!(
            ["best", "best 60", "best, moved", "wgs 200"].map(family),
            ["best", "best", "best, moved", "wgs"]
        );
    }
}
