//! `sonoglyph bench solve`: every method on rings, helices, random sets and more and more foci and elements.

mod charts;

use std::hint::black_box;

use glam::DVec3;
use serde_json::json;

use crate::acoustics::Aperture;
use crate::bench::time::{ROUNDS, Spent, Spread, Times, digits};
use crate::bench::{Report, foci};
use crate::drive::Drive;
use crate::scene::{Focus, Method, Motion, MotionPath, Sampling, Scene, Shape, Target, motion};
use crate::solver::{self, Excitation, Problem, Quality, SolveError, frames};

const SIZES: [usize; 8] = [1, 2, 4, 5, 8, 16, 32, 64];
const QUICK_SIZES: [usize; 2] = [8, 32];
const RANDOM_SIZES: [usize; 4] = [2, 8, 16, 32];
const RANDOM_SETS: usize = 20;
/// Foci before 256 elements, and elements along a side behind 32 foci.
const COUNTS: [usize; 10] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const QUICK_COUNTS: [usize; 3] = [1, 10, 100];
const SIDES: [u32; 4] = [16, 32, 64, 128];
const QUICK_SIDES: [u32; 2] = [16, 64];
/// Iterations of weighted Gerchberg-Saxton as published, the baseline of time and quality.
const BASELINE_ITERATIONS: u32 = 200;

/// Iterations of `best` besides its own default.
const BUDGETS: [u32; 3] = [5, 60, 200];

/// Foci spread over a disc, ever more of them or of the elements: what methods cost, not how good they are.
pub const SCALING: &str = "disc";

/// Sets of foci that are measured together.
struct Workload {
    name: &'static str,
    aperture: Aperture,
    sets: Vec<Vec<Focus>>,
}

#[derive(Debug)]
pub struct Record {
    pub workload: &'static str,
    pub elements: usize,
    pub foci: usize,
    pub method: String,
    /// Of one whole solve, transfer included; a round is a set, or one of several with the only set.
    pub times: Times,
    /// CPU time of the baseline over this.
    ratio: Spread,
    /// The weakest focus over the baseline's, set by set.
    strength: Spread,
    /// Means over the sets (Pa, peak), but for the spread, which is the largest.
    mean: f64,
    weakest: f64,
    pub spread: f64,
    relative_to_single: f64,
    /// Smallest and mean; of no scaling.
    pub certified: Option<[f64; 2]>,
}

/// From a set's number and its problem.
type Solve<'a> = Box<dyn Fn(usize, &Problem<'_>) -> Result<Excitation, SolveError> + 'a>;

/// A method with its iterations, and what it has taken and found.
struct Candidate<'a> {
    name: String,
    solve: Solve<'a>,
    times: Times,
    qualities: Vec<Quality>,
}

pub fn run(quick: bool) -> anyhow::Result<Report> {
    let mut records = Vec::new();
    for workload in workloads(quick) {
        records.extend(measure(&workload)?);
    }
    records.extend(measure_frames()?);
    Ok(Report {
        header: vec![
            "foci", "elements", "M", "method", "CPU ms (wall)", "x", "quartiles", "mean Pa", "weakest Pa", "to baseline",
            "spread", "to single", "certified", "least",
        ],
        rows: records.iter().map(row).collect(),
        notes: vec![
            format!(
                "One whole solve, transfer included, on one core: medians. x: how many times faster than the baseline, `wgs \
                 {BASELINE_ITERATIONS}`, which takes turns with the others; to baseline: the weakest focus over the baseline's."
            ),
            "Pressures are those of the uniform drive, means over the sets; spread is the largest of all sets. certified: the \
             part of what no drive can exceed that the weakest focus surely has, mean and least over the sets."
                .to_owned(),
            format!(
                "helix and ring: radius {:.0} mm; plane and cube: {RANDOM_SETS} random sets; {SCALING}: foci all over a disc of \
                 5 cm. `best, moved` goes on from foci that stood 0.5 mm away.",
                foci::RADIUS * 1e3,
            ),
            "moving: 64 frames of a ring of 8 foci that moves along a circle, times per frame; x is over searching for each."
                .to_owned(),
        ],
        charts: charts::charts(&records),
        records: records.iter().map(json).collect(),
    })
}

fn measure(workload: &Workload) -> Result<Vec<Record>, SolveError> {
    let Workload { name, aperture, sets } = workload;
    let problems: Vec<_> = sets.iter().map(|foci| Problem::new(aperture, foci.clone())).collect();
    let mut candidates = candidates(workload)?;
    // One set alone is solved again and again.
    for (set, foci) in sets.iter().enumerate().cycle().take(sets.len().max(ROUNDS)) {
        for Candidate { solve, times, .. } in &mut candidates {
            times.push(Spent::on(|_| {
                let problem = Problem::new(aperture, foci.clone());
                let excitation = solve(set, &problem)?;
                black_box(Drive::uniform(aperture.positions.len(), &aperture.driven, &excitation.values));
                Ok::<_, SolveError>(())
            })?);
        }
    }
    for Candidate { solve, qualities, .. } in &mut candidates {
        for (set, problem) in problems.iter().enumerate() {
            qualities.push(quality(problem, &solve(set, problem)?));
        }
    }
    let bounds = (*name != SCALING).then(|| problems.iter().map(solver::bound).collect::<Vec<_>>());
    let place = (*name, aperture.positions.len(), sets[0].len());
    Ok(records(place, &candidates, bounds.as_deref()))
}

/// The baseline first.
fn candidates(workload: &Workload) -> Result<Vec<Candidate<'_>>, SolveError> {
    let candidate = |name: String, method: Method, iterations: u32| Candidate {
        name,
        solve: Box::new(move |_, problem| solver::excite(problem, method, iterations)),
        times: Times::default(),
        qualities: Vec::new(),
    };
    let mut all = vec![candidate(format!("wgs {BASELINE_ITERATIONS}"), Method::Wgs, BASELINE_ITERATIONS)];
    for method in Method::ALL.into_iter().filter(|&method| method != Method::Focus) {
        all.push(candidate(method.name().to_owned(), method, 0));
    }
    if workload.name != SCALING {
        all.extend(BUDGETS.map(|budget| candidate(format!("best {budget}"), Method::Best, budget)));
        all.push(moved(workload)?);
    }
    Ok(all)
}

/// `best` with a warm start: from the solution for foci that stood 0.5 mm away.
fn moved(workload: &Workload) -> Result<Candidate<'_>, SolveError> {
    let moved = |focus: &Focus| Focus { position: focus.position + 0.0005 * DVec3::X, ..*focus };
    let mut before = Vec::new();
    for foci in &workload.sets {
        let problem = Problem::new(&workload.aperture, foci.iter().map(moved).collect());
        before.push(solver::excite(&problem, Method::Best, 0)?);
    }
    Ok(Candidate {
        name: "best, moved".to_owned(),
        solve: Box::new(move |set, problem| Ok(solver::excite_from(problem, &before[set]))),
        times: Times::default(),
        qualities: Vec::new(),
    })
}

/// All frames of a moving ring: each searched for alone, and each going on from the one before.
fn measure_frames() -> anyhow::Result<Vec<Record>> {
    let ring = Shape::Circle { at: DVec3::new(0.0, 0.0, 0.1), radius: 0.02 };
    let scene = Scene {
        targets: vec![Target { sampling: Sampling::Points(8), ..Target::new(ring) }],
        motion: Motion { path: MotionPath::Circle, ..Motion::default() },
        ..Scene::default()
    };
    let foci = motion::frames(&scene)?;
    let aperture = Aperture::new(&scene);
    let elements = aperture.positions.len();
    let search = |foci: &Vec<Focus>| {
        let problem = Problem::new(&aperture, foci.clone());
        let excitation = solver::excite(&problem, Method::Best, 0)?;
        Ok::<_, SolveError>(Drive::uniform(elements, &aperture.driven, &excitation.values))
    };
    let (mut searching, mut following) = (Times::default(), Times::default());
    for _ in 0..ROUNDS {
        searching.push(Spent::on(|_| {
            foci.iter().try_for_each(|foci| search(foci).map(|drive| drop(black_box(drive))))
        })?);
        following.push(Spent::on(|_| frames::follow(&scene).map(|sequence| drop(black_box(sequence))))?);
    }
    let searched = foci.iter().map(search).collect::<Result<Vec<_>, _>>()?;
    let followed: Vec<_> = frames::follow(&scene)?.frames.into_iter().map(|frame| frame.drive).collect();
    let problems: Vec<_> = foci.iter().map(|foci| Problem::new(&aperture, foci.clone())).collect();
    let candidate = |name: &str, times: &Times, drives: &[Drive]| {
        let played = |(problem, drive): (&Problem<'_>, &Drive)| {
            let values = drive.excitation(&aperture.driven);
            quality(problem, &Excitation { values, iterations: 0, residual: None, weights: None })
        };
        Candidate {
            name: name.to_owned(),
            solve: Box::new(|_, problem| solver::excite(problem, Method::Best, 0)),
            times: times.scaled(1.0 / foci.len() as f64),
            qualities: problems.iter().zip(drives).map(played).collect(),
        }
    };
    let bounds: Vec<_> = problems.iter().map(solver::bound).collect();
    let candidates =
        [candidate("best", &searching, &searched), candidate("best, followed", &following, &followed)];
    Ok(records(("moving", elements, 8), &candidates, Some(&bounds)))
}

/// Of workload, elements and foci; the first candidate is the baseline.
fn records(
    (workload, elements, foci): (&'static str, usize, usize),
    candidates: &[Candidate<'_>],
    bounds: Option<&[f64]>,
) -> Vec<Record> {
    let baseline = &candidates[0];
    let record = |Candidate { name, times, qualities, .. }: &Candidate<'_>| {
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
    candidates.iter().map(record).collect()
}

fn quality(problem: &Problem<'_>, excitation: &Excitation) -> Quality {
    let Aperture { positions, driven, .. } = problem.aperture;
    let drive = Drive::uniform(positions.len(), driven, &excitation.values);
    Quality::new(problem, excitation, &problem.transfer.pressure(&drive.excitation(driven)))
}

fn workloads(quick: bool) -> Vec<Workload> {
    let aperture = |side: u32| {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns, scene.array.pitch) = (side, side, 0.01);
        scene.medium.sound_speed = Some(340.0);
        Aperture::new(&scene)
    };
    let one = |name, side, foci| Workload { name, aperture: aperture(side), sets: vec![foci] };
    let random = |name, depth, count| {
        let sets = (0..RANDOM_SETS).map(|set| foci::random(count, depth, set as u64)).collect();
        Workload { name, aperture: aperture(16), sets }
    };
    let mut all = Vec::new();
    let (sizes, counts, sides) = if quick {
        all.extend(QUICK_SIZES.map(|count| random("plane", 0.0, count)));
        (&QUICK_SIZES[..], &QUICK_COUNTS[..], &QUICK_SIDES[..])
    } else {
        all.extend(RANDOM_SIZES.map(|count| random("plane", 0.0, count)));
        all.extend(RANDOM_SIZES.map(|count| random("cube", 0.1, count)));
        all.extend(SIZES.map(|count| one("ring", 16, foci::helix(count, 0.0))));
        all.push(one("helix", 32, foci::helix(32, 0.1)));
        (&SIZES[..], &COUNTS[..], &SIDES[..])
    };
    all.extend(sizes.iter().map(|&count| one("helix", 16, foci::helix(count, 0.1))));
    all.extend(counts.iter().map(|&count| one(SCALING, 16, foci::disc(count))));
    all.extend(sides.iter().map(|&side| one(SCALING, side, foci::disc(32))));
    all
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
    fn methods_stand_beside_the_baseline_and_below_the_bound() {
        let sets = (0..2).map(|set| foci::random(4, 0.0, set)).collect();
        let workload = Workload { name: "plane", aperture: Aperture::new(&Scene::default()), sets };
        let records = measure(&workload).unwrap();
        let of = |method: &str| records.iter().find(|record| record.method == method).unwrap();
        assert_eq!(of("wgs 200").ratio.quartiles, [1.0; 2]);
        assert_eq!(of("wgs 200").strength.quartiles, [1.0; 2]);
        assert!(of("best").strength.median > of("naive").strength.median, "{records:?}");
        for record in &records {
            let [least, mean] = record.certified.unwrap();
            assert!(0.0 < least && least <= mean && mean <= 1.0 + 1e-9, "{record:?}");
        }
    }
}
