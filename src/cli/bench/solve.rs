//! `sonoglyph bench solve`: every method on rings, helices and random sets of foci.

use std::f64::consts::TAU;
use std::hint::black_box;

use comfy_table::{CellAlignment, Table};
use glam::DVec3;
use serde_json::json;

use crate::acoustics::Aperture;
use crate::cli::bench::{Report, Spent, median};
use crate::drive::Drive;
use crate::picture::chart::{Chart, Series};
use crate::scene::{Focus, Method, Motion, MotionPath, Sampling, Scene, Shape, Target, motion};
use crate::solver::{self, Excitation, Problem, Quality, SolveError, frames};

const RADIUS: f64 = 0.03;
const SIZES: [usize; 8] = [1, 2, 4, 5, 8, 16, 32, 64];
const QUICK_SIZES: [usize; 2] = [8, 32];
const RANDOM_SIZES: [usize; 4] = [2, 8, 16, 32];
const RANDOM_SETS: usize = 30;
const QUICK_RANDOM_SETS: usize = 3;
/// Iterations of weighted Gerchberg-Saxton as published, the baseline of quality.
const BASELINE_ITERATIONS: u32 = 200;

/// Iterations of `best` besides its own default.
const BUDGETS: [u32; 3] = [5, 60, 200];

/// Sets of foci that are measured together.
struct Workload {
    name: &'static str,
    aperture: Aperture,
    sets: Vec<Vec<Focus>>,
}

struct Record {
    workload: &'static str,
    elements: usize,
    foci: usize,
    method: String,
    /// Of one whole solve, transfer included, s: the median over the sets.
    cpu: f64,
    wall: f64,
    /// Means over the sets (Pa, peak), but for the spread, which is the largest.
    mean: f64,
    weakest: f64,
    spread: f64,
    relative_to_single: f64,
    /// Smallest and mean.
    certified: [f64; 2],
}

pub fn run(quick: bool) -> Result<Report, SolveError> {
    let mut records = Vec::new();
    for workload in workloads(quick) {
        let problems: Vec<_> =
            workload.sets.iter().map(|foci| Problem::new(&workload.aperture, foci.clone())).collect();
        let bounds: Vec<_> = problems.iter().map(solver::bound).collect();
        let mut candidates: Vec<(String, Method, u32)> = Method::ALL
            .into_iter()
            .filter(|&method| method != Method::Focus)
            .map(|method| (method.name().to_owned(), method, 0))
            .collect();
        candidates.push((format!("wgs {BASELINE_ITERATIONS}"), Method::Wgs, BASELINE_ITERATIONS));
        candidates.extend(BUDGETS.map(|budget| (format!("best {budget}"), Method::Best, budget)));
        for (name, method, iterations) in candidates {
            let solve = |problem: &Problem<'_>| solver::excite(problem, method, iterations);
            records.push(measure(&workload, &problems, &bounds, name, solve)?);
        }
        records.push(measure_moved(&workload, &problems, &bounds)?);
    }
    let [searched, followed] = measure_frames()?;
    let part = followed.cpu / searched.cpu;
    records.extend([searched, followed]);
    Ok(Report {
        table: table(&records),
        notes: vec![
            "One whole solve, transfer included, on one core: medians. Pressures are those of the uniform drive, means over \
             the sets; spread is the largest of all sets."
                .to_owned(),
            format!(
                "helix and ring: radius {:.0} mm; plane and cube: {} random sets. `best, moved` goes on from foci that stood \
                 0.5 mm away.",
                RADIUS * 1e3,
                if quick { QUICK_RANDOM_SETS } else { RANDOM_SETS }
            ),
            format!(
                "moving: 64 frames of a ring of 8 foci that moves along a circle, times per frame; following takes {part:.2} of \
                 searching for each."
            ),
        ],
        charts: charts(&records),
        records: records.iter().map(json).collect(),
    })
}

fn measure(
    workload: &Workload,
    problems: &[Problem<'_>],
    bounds: &[f64],
    method: String,
    solve: impl Fn(&Problem<'_>) -> Result<Excitation, SolveError>,
) -> Result<Record, SolveError> {
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    for foci in &workload.sets {
        let spent = Spent::on(|_| {
            let problem = Problem::new(&workload.aperture, foci.clone());
            let excitation = solve(&problem)?;
            let Aperture { positions, driven, .. } = &workload.aperture;
            black_box(Drive::uniform(positions.len(), driven, &excitation.values));
            Ok::<_, SolveError>(())
        })?;
        cpu.push(spent.cpu);
        wall.push(spent.wall);
    }
    let mut qualities = Vec::new();
    for problem in problems {
        qualities.push(quality(problem, &solve(problem)?));
    }
    let head = (workload.name, workload.aperture.positions.len(), workload.sets[0].len(), method);
    Ok(Record::new(head, Spent { cpu: median(cpu), wall: median(wall) }, &qualities, bounds))
}

impl Record {
    /// Of workload, elements, foci and method; a quality and a bound per set.
    fn new(
        (workload, elements, foci, method): (&'static str, usize, usize, String),
        spent: Spent,
        qualities: &[Quality],
        bounds: &[f64],
    ) -> Self {
        let count = qualities.len() as f64;
        let average = |of: fn(&Quality) -> f64| qualities.iter().map(of).sum::<f64>() / count;
        let certified: Vec<_> =
            qualities.iter().zip(bounds).map(|(quality, bound)| quality.min_pressure / bound).collect();
        Self {
            workload,
            elements,
            foci,
            method,
            cpu: spent.cpu,
            wall: spent.wall,
            mean: average(|quality| quality.mean_pressure),
            weakest: average(|quality| quality.min_pressure),
            spread: qualities.iter().map(|quality| quality.spread).fold(0.0, f64::max),
            relative_to_single: average(|quality| quality.relative_to_single),
            certified: [
                certified.iter().copied().fold(f64::INFINITY, f64::min),
                certified.iter().sum::<f64>() / count,
            ],
        }
    }
}

/// `best` with a warm start: from the solution for foci that stood 0.5 mm away.
fn measure_moved(
    workload: &Workload,
    problems: &[Problem<'_>],
    bounds: &[f64],
) -> Result<Record, SolveError> {
    let moved = |foci: &[Focus]| -> Vec<Focus> {
        foci.iter().map(|focus| Focus { position: focus.position + 0.0005 * DVec3::X, ..*focus }).collect()
    };
    let mut before = Vec::new();
    for foci in &workload.sets {
        let problem = Problem::new(&workload.aperture, moved(foci));
        before.push((foci.clone(), solver::excite(&problem, Method::Best, 0)?));
    }
    let solve = |problem: &Problem<'_>| {
        let known = before.iter().find(|(foci, _)| *foci == problem.foci);
        match known {
            Some((_, before)) => Ok(solver::excite_from(problem, before)),
            None => solver::excite(problem, Method::Best, 0),
        }
    };
    measure(workload, problems, bounds, "best, moved".to_owned(), solve)
}

/// All frames of a moving ring: each searched for alone, and each going on from the one before.
fn measure_frames() -> Result<[Record; 2], SolveError> {
    let ring = Shape::Circle { at: DVec3::new(0.0, 0.0, 0.1), radius: 0.02 };
    let scene = Scene {
        targets: vec![Target { sampling: Sampling::Points(8), ..Target::new(ring) }],
        motion: Motion { path: MotionPath::Circle, ..Motion::default() },
        ..Scene::default()
    };
    let foci = motion::frames(&scene)?;
    let count = foci.len() as f64;
    let aperture = Aperture::new(&scene);
    let elements = aperture.positions.len();
    let search = |foci: &Vec<Focus>| {
        let problem = Problem::new(&aperture, foci.clone());
        let excitation = solver::excite(&problem, Method::Best, 0)?;
        Ok::<_, SolveError>(Drive::uniform(elements, &aperture.driven, &excitation.values))
    };
    let searching =
        Spent::on(|_| foci.iter().try_for_each(|foci| search(foci).map(|drive| drop(black_box(drive)))))?;
    let following = Spent::on(|_| frames::follow(&scene).map(|sequence| drop(black_box(sequence))))?;
    let searched = foci.iter().map(search).collect::<Result<Vec<_>, _>>()?;
    let followed = frames::follow(&scene)?.frames.into_iter().map(|frame| frame.drive).collect();
    let record = |method: &str, spent: Spent, drives: Vec<Drive>| {
        let problems: Vec<_> = foci.iter().map(|foci| Problem::new(&aperture, foci.clone())).collect();
        let played = |(problem, drive): (&Problem<'_>, &Drive)| {
            let values = drive.excitation(&aperture.driven);
            quality(problem, &Excitation { values, iterations: 0, residual: None, weights: None })
        };
        let qualities: Vec<_> = problems.iter().zip(&drives).map(played).collect();
        let bounds: Vec<_> = problems.iter().map(solver::bound).collect();
        let spent = Spent { cpu: spent.cpu / count, wall: spent.wall / count };
        Record::new(("moving", elements, 8, method.to_owned()), spent, &qualities, &bounds)
    };
    Ok([record("best", searching, searched), record("best, followed", following, followed)])
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
    let sizes = if quick { &QUICK_SIZES[..] } else { &SIZES[..] };
    let mut workloads: Vec<_> = sizes.iter().map(|&count| one("helix", 16, helix(count, 0.1))).collect();
    if !quick {
        workloads.extend(sizes.iter().map(|&count| one("ring", 16, helix(count, 0.0))));
        workloads.push(one("helix", 32, helix(32, 0.1)));
    }
    let sets = if quick { QUICK_RANDOM_SETS } else { RANDOM_SETS };
    for (name, depth) in [("plane", 0.0), ("cube", 0.1)] {
        for count in RANDOM_SIZES {
            let sets = (0..sets).map(|set| random(count, depth, set as u64)).collect();
            workloads.push(Workload { name, aperture: aperture(16), sets });
        }
    }
    workloads
}

/// A ring at z = 0.15 m, or a turn of a helix that rises by `rise` (m) about it.
fn helix(count: usize, rise: f64) -> Vec<Focus> {
    let focus = |i: usize| {
        let part = i as f64 / count as f64;
        let (sin, cos) = (TAU * part).sin_cos();
        let z = 0.15 + rise * (part - 0.5);
        Focus { position: DVec3::new(RADIUS * cos, RADIUS * sin, z), target: 1.0 }
    };
    (0..count).map(focus).collect()
}

/// Foci in a square of 10 cm at z = 0.1 m, or up to `depth` (m) above it, no two nearer than a wavelength.
fn random(count: usize, depth: f64, seed: u64) -> Vec<Focus> {
    // SplitMix64 (Steele, Lea and Flood, 2014).
    let mut state = seed.wrapping_mul(0x1234_5678_9abc_def1);
    let mut unit = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut foci: Vec<Focus> = Vec::new();
    while foci.len() < count {
        let position = DVec3::new(0.1 * unit() - 0.05, 0.1 * unit() - 0.05, 0.1 + depth * unit());
        if foci.iter().all(|other| other.position.distance(position) > 0.0085) {
            foci.push(Focus { position, target: 1.0 });
        }
    }
    foci
}

fn table(records: &[Record]) -> Table {
    let mut table = Table::new();
    table.set_header([
        "foci",
        "elements",
        "M",
        "method",
        "CPU ms",
        "mean Pa",
        "weakest Pa",
        "spread",
        "to single",
        "certified",
        "least",
    ]);
    for record in records {
        table.add_row([
            record.workload.to_owned(),
            record.elements.to_string(),
            record.foci.to_string(),
            record.method.clone(),
            format!("{:.3}", record.cpu * 1e3),
            format!("{:.1}", record.mean),
            format!("{:.1}", record.weakest),
            format!("{:.1e}", record.spread),
            format!("{:.3}", record.relative_to_single),
            format!("{:.3}", record.certified[1]),
            format!("{:.3}", record.certified[0]),
        ]);
    }
    for column in [1, 2, 4, 5, 6, 7, 8, 9, 10] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn json(record: &Record) -> serde_json::Value {
    json!({
        "workload": record.workload,
        "elements": record.elements,
        "foci": record.foci,
        "method": record.method,
        "cpu_ms": record.cpu * 1e3,
        "wall_ms": record.wall * 1e3,
        "mean_pressure": record.mean,
        "min_pressure": record.weakest,
        "spread": record.spread,
        "relative_to_single": record.relative_to_single,
        "certified_least": record.certified[0],
        "certified_mean": record.certified[1],
    })
}

/// Time against what is certainly lost at the weakest focus, a point per method.
fn charts(records: &[Record]) -> Vec<(String, Chart)> {
    let series = |record: &Record| Series {
        name: record.method.clone(),
        points: vec![(record.cpu * 1e3, 1.0 - record.certified[1])],
    };
    [8, 32]
        .into_iter()
        .map(|foci| {
            let chosen = |record: &&Record| {
                record.workload == "plane" && record.foci == foci && record.certified[1] > 0.5
            };
            let chart = Chart {
                title: format!("Time against loss: {foci} random foci on a plane, 256 elements"),
                x_label: "CPU-ms per solve".to_owned(),
                y_label: "1 - certified part of the best any drive can do".to_owned(),
                series: records.iter().filter(chosen).map(series).collect(),
            };
            (format!("solve-{foci}"), chart)
        })
        .collect()
}
