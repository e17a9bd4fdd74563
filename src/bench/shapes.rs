//! `sonoglyph bench shapes`: time and quality of shapes as continuous strokes and as separate foci.

use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::bench::Report;
use crate::bench::drawings::{DRAWINGS, Drawing};
use crate::bench::time::{ROUNDS, Spent, Spread, Times};
use crate::drive::Drive;
use crate::picture::chart::{Chart, Series};
use crate::scene::{Amplitudes, Method, Sampling, Scene, outline};
use crate::solver::{self, Figures, Problem, SolveError, Surroundings, shape};
use crate::studio::trade::{self, Point};

/// Shapes of a short run.
const COUNT: usize = 3;
/// Frames of a drag, and the shape's displacement per frame (m).
const FRAMES: u32 = 10;
const STRIDE: f64 = 1e-3;

/// A way to find the drive of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Approach {
    /// The full search for strokes.
    Stroke,
    /// Separate foci, with their spacing in mm.
    Foci(u32, Method),
    /// Moving strokes, each frame starting from the previous one.
    Dragged,
}

const APPROACHES: [Approach; 7] = [
    Approach::Stroke,
    Approach::Foci(10, Method::Best),
    Approach::Foci(6, Method::Best),
    Approach::Foci(4, Method::Best),
    BASELINE,
    Approach::Foci(4, Method::Weighted),
    Approach::Dragged,
];
/// The baseline of time.
const BASELINE: Approach = Approach::Foci(4, Method::Wgs);

impl Approach {
    fn name(self) -> String {
        match self {
            Self::Stroke => "stroke".to_owned(),
            Self::Foci(distance, method) => format!("{}, foci {distance} mm apart", method.into_str()),
            Self::Dragged => "stroke, dragged".to_owned(),
        }
    }
}

/// Results of an approach for one shape.
#[derive(Debug)]
struct Record {
    drawing: &'static str,
    times: Times,
    figures: Figures,
    /// After a drag: side lobe over that of a full search.
    to_rest: Option<f64>,
}

/// Results of an approach for all shapes.
#[derive(Debug)]
struct Summary {
    approach: Approach,
    /// Mean over the shapes, round by round.
    times: Times,
    /// CPU time relative to the baseline.
    ratio: Spread,
    evenness: Extent,
    side_lobe: Extent,
    strength: Extent,
    to_rest: Option<Extent>,
    records: Vec<Record>,
}

/// Range and mean of a figure over the shapes.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    pub mean: f64,
    pub least: f64,
    pub most: f64,
}

impl Extent {
    pub fn of(values: &[f64]) -> Self {
        Self {
            mean: values.iter().sum::<f64>() / values.len() as f64,
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            most: values.iter().copied().fold(0.0, f64::max),
        }
    }

    fn json(&self) -> Value {
        json!({ "mean": self.mean, "least": self.least, "most": self.most })
    }
}

/// # Errors
/// A shape that cannot be solved.
pub fn run() -> anyhow::Result<Report> {
    on(&DRAWINGS[..COUNT])
}

/// # Errors
/// A shape that cannot be solved.
pub fn on(drawings: &[Drawing]) -> anyhow::Result<Report> {
    let (summaries, trades) = (measure(drawings)?, trades(drawings)?);
    let names: Vec<_> = drawings.iter().map(|drawing| drawing.name).collect();
    Ok(Report {
        header: vec![
            "drive",
            "CPU ms (wall)",
            "time ratio",
            "quartiles",
            "evenness (least)",
            "side lobe (most)",
            "strength (least)",
            "drag ratio (most)",
        ],
        rows: summaries.iter().map(row).chain(trades.iter().map(Trade::row)).collect(),
        notes: vec![
            format!(
                "Means over the shapes {}, in brackets the worst; 256 elements, plane z = 0.1 m. CPU ms of a full \
                 solve, medians of {ROUNDS} rounds. time ratio: CPU time relative to `{}`.",
                names.join(", "),
                BASELINE.name(),
            ),
            "evenness: least over mean of |p| along the strokes; side lobe: largest |p| outside the main lobes over that mean; \
             strength: mean over that of the strongest drive. Separate foci are evaluated along the same strokes."
                .to_owned(),
            format!(
                "dragged: the shape moves by {} mm per frame for {FRAMES} frames, each starting from the previous one; \
                 CPU ms of a frame. drag ratio: side lobe of the last frame over that of a full search there.",
                STRIDE * 1e3,
            ),
            "free: amplitudes beside phases (`amplitudes = \"free\"`), and uniform ones, by `quiet`.".to_owned(),
        ],
        charts: vec![
            ("shapes-side-lobe".to_owned(), chart(&summaries)),
            ("shapes-strength".to_owned(), trade_chart(&trades)),
        ],
        records: summaries.iter().flat_map(records).chain(trades.iter().map(Trade::json)).collect(),
    })
}

/// Strength and side lobe at one `quiet`, means over the shapes.
#[derive(Clone, Copy, Debug)]
struct Trade {
    amplitudes: Amplitudes,
    quiet: f64,
    strength: f64,
    side_lobe: f64,
}

/// The curves of both amplitudes, one after the other.
fn trades(drawings: &[Drawing]) -> Result<Vec<Trade>, SolveError> {
    let mut trades = Vec::new();
    for amplitudes in [Amplitudes::Uniform, Amplitudes::Free] {
        let of_one = |drawing: &Drawing| trade::curve(&drawing.scene(0.0, Sampling::Continuous), amplitudes);
        let curves = drawings.iter().map(of_one).collect::<Result<Vec<_>, _>>()?;
        let share = 1.0 / drawings.len() as f64;
        for (index, quiet) in trade::QUIET.into_iter().enumerate() {
            let mean =
                |of: fn(&Point) -> f64| share * curves.iter().map(|curve| of(&curve[index])).sum::<f64>();
            let (strength, side_lobe) = (mean(|point| point.strength), mean(|point| point.side_lobe));
            trades.push(Trade { amplitudes, quiet, strength, side_lobe });
        }
    }
    Ok(trades)
}

impl Trade {
    fn name(&self) -> &'static str {
        match self.amplitudes {
            Amplitudes::Uniform => "uniform",
            Amplitudes::Free => "free",
        }
    }

    fn row(&self) -> Vec<String> {
        let cell = |value: f64| format!("{value:.3}");
        let name = format!("{}, quiet {}", self.name(), self.quiet);
        let mut row = vec![name, "-".into(), "-".into(), "-".into(), "-".into()];
        row.extend([cell(self.side_lobe), cell(self.strength), "-".into()]);
        row
    }

    fn json(&self) -> Value {
        let Self { quiet, strength, side_lobe, .. } = self;
        json!({
            "drawing": "all", "amplitudes": self.name(),
            "quiet": quiet, "strength": strength, "side_lobe": side_lobe,
        })
    }
}

fn trade_chart(trades: &[Trade]) -> Chart {
    let series = |trades: &[Trade]| Series {
        name: format!("{} amplitudes", trades[0].name()),
        points: trades.iter().map(|it| (it.strength, it.side_lobe)).collect(),
    };
    Chart {
        title: "Side lobe against strength: shapes, 256 elements".to_owned(),
        x_label: "mean pressure over that of the strongest drive".to_owned(),
        y_label: "side lobe over the mean along the strokes".to_owned(),
        series: trades.chunk_by(|a, b| a.amplitudes == b.amplitudes).map(series).collect(),
        levels: Vec::new(),
    }
}

/// The approaches alternate, shape by shape.
fn measure(drawings: &[Drawing]) -> Result<Vec<Summary>, SolveError> {
    let mut all: Vec<Vec<Record>> = APPROACHES.map(|_| Vec::new()).into();
    for drawing in drawings {
        let mut rounds = Vec::new();
        for _ in 0..ROUNDS {
            let round = APPROACHES.into_iter().map(|approach| solve(drawing, approach));
            rounds.push(round.collect::<Result<Vec<_>, _>>()?);
        }
        for (index, records) in all.iter_mut().enumerate() {
            let times = rounds.iter().map(|round| round[index].0).collect();
            records.push(record(drawing, APPROACHES[index], times, &rounds[0][index].1)?);
        }
    }
    let mean =
        |records: &[Record]| Times::mean(&records.iter().map(|record| &record.times).collect::<Vec<_>>());
    let baseline =
        APPROACHES.iter().position(|&one| one == BASELINE).map_or_else(Times::default, |i| mean(&all[i]));
    let summary = |(approach, records): (Approach, Vec<Record>)| {
        let extent = |of: fn(&Record) -> f64| Extent::of(&records.iter().map(of).collect::<Vec<_>>());
        let times = mean(&records);
        let to_rest: Vec<_> = records.iter().filter_map(|record| record.to_rest).collect();
        Summary {
            approach,
            ratio: times.over(&baseline),
            times,
            evenness: extent(|record| record.figures.evenness),
            side_lobe: extent(|record| record.figures.side_lobe),
            strength: extent(|record| record.figures.strength),
            to_rest: (!to_rest.is_empty()).then(|| Extent::of(&to_rest)),
            records,
        }
    };
    Ok(APPROACHES.into_iter().zip(all).map(summary).collect())
}

/// Finds a drive, with its time; the time of a drag is that of a frame.
fn solve(drawing: &Drawing, approach: Approach) -> Result<(Spent, Drive), SolveError> {
    let scene = match approach {
        Approach::Stroke => drawing.scene(0.0, Sampling::Continuous),
        Approach::Foci(distance, method) => {
            let mut scene = drawing.scene(0.0, Sampling::Spacing(f64::from(distance) * 1e-3));
            scene.solver.method = method;
            scene
        }
        Approach::Dragged => return drag(drawing),
    };
    let (spent, solution) = Spent::once(|| solver::solve(&scene));
    Ok((spent, solution?.drive))
}

/// Mean time of a frame after the drive at rest, and the last drive.
fn drag(drawing: &Drawing) -> Result<(Spent, Drive), SolveError> {
    let mut before = solver::solve(&drawing.scene(0.0, Sampling::Continuous))?;
    let mut frames = Vec::new();
    for frame in 1..=FRAMES {
        let scene = drawing.scene(f64::from(frame) * STRIDE, Sampling::Continuous);
        let (spent, found) = Spent::once(|| solver::solve_on(&scene, Some(&before)));
        before = found?;
        frames.push(spent);
    }
    Ok((Spent::mean(&frames), before.drive))
}

fn record(drawing: &Drawing, approach: Approach, times: Times, drive: &Drive) -> Result<Record, SolveError> {
    let moved = if approach == Approach::Dragged { f64::from(FRAMES) * STRIDE } else { 0.0 };
    let scene = drawing.scene(moved, Sampling::Continuous);
    let found = figures(&scene, drive)?;
    let to_rest = match approach {
        Approach::Stroke | Approach::Foci(..) => None,
        Approach::Dragged => {
            let rest = figures(&scene, &solver::solve(&scene)?.drive)?;
            Some(found.side_lobe / rest.side_lobe)
        }
    };
    Ok(Record { drawing: drawing.name, times, figures: found, to_rest })
}

/// Figures of any drive along a scene's strokes.
///
/// # Errors
/// Strokes without samples.
pub fn figures(scene: &Scene, drive: &Drive) -> Result<Figures, SolveError> {
    let aperture = Aperture::new(scene);
    let problem = Problem::of_scene(scene, &aperture, outline::foci(scene)?);
    Ok(shape::figures(
        &problem,
        &Surroundings::new(scene, &problem.foci),
        &drive.excitation(&aperture.driven),
    ))
}

fn row(summary: &Summary) -> Vec<String> {
    let pair = |mean: f64, worst: f64| format!("{mean:.3} ({worst:.3})");
    let Summary { evenness, side_lobe, strength, .. } = summary;
    vec![
        summary.approach.name(),
        summary.times.text(),
        summary.ratio.text(),
        summary.ratio.quartiles_text(),
        pair(evenness.mean, evenness.least),
        pair(side_lobe.mean, side_lobe.most),
        pair(strength.mean, strength.least),
        summary.to_rest.map_or("-".to_owned(), |to_rest| pair(to_rest.mean, to_rest.most)),
    ]
}

/// Records of all shapes together, and of each.
fn records(summary: &Summary) -> Vec<Value> {
    let drive = summary.approach.name();
    let of_one = |record: &Record| {
        json!({
            "drawing": record.drawing,
            "drive": drive,
            "time": record.times.json(),
            "evenness": record.figures.evenness,
            "side_lobe": record.figures.side_lobe,
            "strength": record.figures.strength,
        })
    };
    let all = json!({
        "drawing": "all",
        "drive": drive,
        "time": summary.times.json(),
        "time_ratio": summary.ratio.json(),
        "evenness": summary.evenness.json(),
        "side_lobe": summary.side_lobe.json(),
        "strength": summary.strength.json(),
        "side_lobe_to_rest": summary.to_rest.map(|to_rest| to_rest.json()),
    });
    std::iter::once(all).chain(summary.records.iter().map(of_one)).collect()
}

fn chart(summaries: &[Summary]) -> Chart {
    let series = |summary: &Summary| Series {
        name: summary.approach.name(),
        points: vec![(summary.side_lobe.mean, summary.times.cpu_ms())],
    };
    Chart {
        title: "Time against side lobe: shapes, 256 elements".to_owned(),
        x_label: "side lobe over the mean along the strokes, mean over the shapes".to_owned(),
        y_label: "CPU-ms per solve".to_owned(),
        series: summaries.iter().map(series).collect(),
        levels: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_are_more_even_than_foci_with_smaller_side_lobes() {
        let triangle = DRAWINGS.iter().find(|drawing| drawing.name == "triangle").unwrap();
        let summaries = measure(std::slice::from_ref(triangle)).unwrap();
        let of = |approach: Approach| summaries.iter().find(|summary| summary.approach == approach).unwrap();
        assert_eq!(of(BASELINE).ratio.quartiles, [1.0; 2]);
        // Sparse foci leave beads, dense foci side lobes.
        let (stroke, sparse, dense) =
            (of(Approach::Stroke), of(Approach::Foci(10, Method::Best)), of(Approach::Foci(4, Method::Best)));
        assert!(sparse.evenness.least < 0.5 && stroke.evenness.least > 0.8, "{summaries:?}");
        assert!(stroke.side_lobe.most < dense.side_lobe.most, "{summaries:?}");
        let dragged = of(Approach::Dragged);
        assert!(dragged.evenness.least > 0.8 && dragged.to_rest.unwrap().most < 1.3, "{summaries:?}");
    }
}
