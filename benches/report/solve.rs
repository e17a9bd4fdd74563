//! Solver methods on rings, helices and random sets, by number of foci and elements, and on frames of a motion.

use std::hint::black_box;

use glam::DVec3;
use sonoglyph::acoustics::Aperture;
use sonoglyph::bench::solve::{self, Found, Record, Workload, aperture, by_method, loss, quality};
use sonoglyph::bench::time::{ROUNDS, Spent, Times};
use sonoglyph::bench::{Report, foci};
use sonoglyph::drive::Drive;
use sonoglyph::picture::chart::Chart;
use sonoglyph::scene::{Focus, Method, Motion, MotionPath, Sampling, Scene, Shape, Target, motion};
use sonoglyph::solver::{self, Excitation, Problem, SolveError, frames};

const SIZES: [usize; 8] = [1, 2, 4, 5, 8, 16, 32, 64];
const QUICK_SIZES: [usize; 2] = [8, 32];
const RANDOM_SIZES: [usize; 4] = [2, 8, 16, 32];
const RANDOM_SETS: usize = 20;
/// Numbers of foci for 256 elements, and elements along a side for 32 foci.
const COUNTS: [usize; 10] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const QUICK_COUNTS: [usize; 3] = [1, 10, 100];
const SIDES: [u32; 4] = [16, 32, 64, 128];
const QUICK_SIDES: [u32; 2] = [16, 64];
/// Iterations of `best` in addition to its default.
const BUDGETS: [u32; 3] = [5, 60, 200];
/// Foci spread over a disc, for the time by number of foci and elements; not judged.
const SCALING: &str = "disc";

pub fn run(quick: bool) -> anyhow::Result<Report> {
    let mut records = Vec::new();
    for workload in workloads(quick) {
        records.extend(solve::measure(&workload)?);
    }
    records.extend(measure_frames()?);
    let charts = charts(&records);
    let mut report = solve::report(&records, charts);
    report.notes.push(format!(
        "helix and ring: radius {:.0} mm; plane and cube: {RANDOM_SETS} random sets; {SCALING}: foci spread over a \
         disc of radius 5 cm.",
        foci::RADIUS * 1e3,
    ));
    report.notes.push(
        "moving: 64 frames of a ring of 8 foci that moves along a circle, time per frame; speed relative to a search \
         per frame."
            .to_owned(),
    );
    Ok(report)
}

fn workloads(quick: bool) -> Vec<Workload> {
    let one = |name, side, foci, is_judged| Workload {
        name,
        aperture: aperture(side),
        sets: vec![foci],
        budgets: if is_judged { &BUDGETS } else { &[] },
        is_judged,
    };
    let random = |name, depth, count| Workload {
        budgets: &BUDGETS,
        ..Workload::random(name, count, depth, RANDOM_SETS)
    };
    let mut all = Vec::new();
    let (sizes, counts, sides) = if quick {
        all.extend(QUICK_SIZES.map(|count| random("plane", 0.0, count)));
        (&QUICK_SIZES[..], &QUICK_COUNTS[..], &QUICK_SIDES[..])
    } else {
        all.extend(RANDOM_SIZES.map(|count| random("plane", 0.0, count)));
        all.extend(RANDOM_SIZES.map(|count| random("cube", 0.1, count)));
        all.extend(SIZES.map(|count| one("ring", 16, foci::helix(count, 0.0), true)));
        all.push(one("helix", 32, foci::helix(32, 0.1), true));
        (&SIZES[..], &COUNTS[..], &SIDES[..])
    };
    all.extend(sizes.iter().map(|&count| one("helix", 16, foci::helix(count, 0.1), true)));
    all.extend(counts.iter().map(|&count| one(SCALING, 16, foci::disc(count), false)));
    all.extend(sides.iter().map(|&side| one(SCALING, side, foci::disc(32), false)));
    all
}

/// All frames of a moving ring: by a search per frame, and by continuation from the previous frame.
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
    let found = |name: &str, times: &Times, drives: &[Drive]| {
        let played = |(problem, drive): (&Problem<'_>, &Drive)| {
            let values = drive.excitation(&aperture.driven);
            quality(problem, &Excitation { values, iterations: 0, residual: None, weights: None })
        };
        Found {
            name: name.to_owned(),
            times: times.scaled(1.0 / foci.len() as f64),
            qualities: problems.iter().zip(drives).map(played).collect(),
        }
    };
    let bounds: Vec<_> = problems.iter().map(solver::bound).collect();
    let both = [found("best", &searching, &searched), found("best, followed", &following, &followed)];
    Ok(solve::records(("moving", elements, 8), &both, Some(&bounds)))
}

fn charts(records: &[Record]) -> Vec<(String, Chart)> {
    let mut charts: Vec<_> =
        [8, 32].map(|foci| (format!("solve-loss-{foci}"), loss(records, foci))).into_iter().collect();
    let scaling = |is_shown: fn(&Record) -> bool, x: fn(&Record) -> usize, title: &str, x_label: &str| {
        let shown = records.iter().filter(|record| record.workload == SCALING && is_shown(record));
        let mut series =
            by_method(shown, |record| &record.method, |record| (x(record) as f64, record.times.cpu_ms()));
        series.iter_mut().for_each(|series| series.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
        Chart {
            title: title.to_owned(),
            x_label: x_label.to_owned(),
            y_label: "CPU-ms per solve".to_owned(),
            series,
            levels: Vec::new(),
        }
    };
    charts.push((
        "solve-foci".to_owned(),
        scaling(
            |record| record.elements == 256,
            |record| record.foci,
            "Time against foci: spread over a disc, 256 elements",
            "foci",
        ),
    ));
    charts.push((
        "solve-elements".to_owned(),
        scaling(
            |record| record.foci == 32,
            |record| record.elements,
            "Time against elements: 32 foci on a disc",
            "elements",
        ),
    ));
    charts
}
