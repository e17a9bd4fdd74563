//! `sonoglyph bench shapes`: drives of drawings as continuous strokes, beside separate foci on the same drawings.

use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::bench::Report;
use crate::bench::drawings::{DRAWINGS, Drawing};
use crate::bench::time::{ROUNDS, Spent, Spread, Times};
use crate::drive::Drive;
use crate::picture::chart::{Chart, Series};
use crate::scene::{Method, Sampling, Scene, outline};
use crate::solver::{self, Figures, Problem, SolveError, Surroundings, shape};

/// Drawings that are measured.
const COUNT: usize = 3;
/// Frames of a drag, and how far (m) the drawing moves in each.
const FRAMES: u32 = 10;
const STRIDE: f64 = 1e-3;

/// How a drive is found.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Work {
    /// The whole search for strokes.
    Stroke,
    /// For separate foci so many mm apart.
    Foci(u32, Method),
    /// For strokes that move: going on from the frame before.
    Dragged,
}

const WORKS: [Work; 7] = [
    Work::Stroke,
    Work::Foci(10, Method::Best),
    Work::Foci(6, Method::Best),
    Work::Foci(4, Method::Best),
    BASELINE,
    Work::Foci(4, Method::Weighted),
    Work::Dragged,
];
/// Of time.
const BASELINE: Work = Work::Foci(4, Method::Wgs);

impl Work {
    fn name(self) -> String {
        match self {
            Self::Stroke => "stroke".to_owned(),
            Self::Foci(distance, method) => format!("{}, foci {distance} mm apart", method.into_str()),
            Self::Dragged => "stroke, dragged".to_owned(),
        }
    }
}

/// What a work made of a drawing.
#[derive(Debug)]
struct Record {
    drawing: &'static str,
    times: Times,
    figures: Figures,
    /// Its side lobe over that of a whole search, after a drag.
    to_rest: Option<f64>,
}

/// What a work made of all drawings.
#[derive(Debug)]
struct Summary {
    work: Work,
    /// Mean over the drawings, round by round.
    times: Times,
    /// CPU time over the baseline's.
    ratio: Spread,
    evenness: Extent,
    side_lobe: Extent,
    strength: Extent,
    to_rest: Option<Extent>,
    records: Vec<Record>,
}

/// Of a figure over the drawings.
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
/// A drawing that cannot be solved.
pub fn run() -> anyhow::Result<Report> {
    on(&DRAWINGS[..COUNT])
}

/// # Errors
/// A drawing that cannot be solved.
pub fn on(drawings: &[Drawing]) -> anyhow::Result<Report> {
    let summaries = measure(drawings)?;
    let names: Vec<_> = drawings.iter().map(|drawing| drawing.name).collect();
    Ok(Report {
        header: vec![
            "drive",
            "CPU ms (wall)",
            "x",
            "quartiles",
            "evenness (least)",
            "side lobe (most)",
            "strength (least)",
            "to rest (most)",
        ],
        rows: summaries.iter().map(row).collect(),
        notes: vec![
            format!(
                "Means over the drawings, and the worst of them in brackets: {}; 256 elements, plane z = 0.1 m. CPU ms of a whole \
                 solve, medians of {ROUNDS} rounds. x: CPU time over that of `{}`.",
                names.join(", "),
                BASELINE.name(),
            ),
            "evenness: least over mean of |p| along the strokes; side lobe: the loudest place beside them over that mean; strength: \
             mean over that of the strongest drive. Separate foci are judged along the strokes too."
                .to_owned(),
            format!(
                "dragged: the drawing moves by {} mm a frame for {FRAMES} frames, each going on from the one before; CPU ms of a \
                 frame. to rest: the last frame's side lobe over that of a whole search there.",
                STRIDE * 1e3,
            ),
        ],
        charts: vec![("shapes-side-lobe".to_owned(), chart(&summaries))],
        records: summaries.iter().flat_map(records).collect(),
    })
}

/// Works take turns, drawing by drawing.
fn measure(drawings: &[Drawing]) -> Result<Vec<Summary>, SolveError> {
    let mut all: Vec<Vec<Record>> = WORKS.map(|_| Vec::new()).into();
    for drawing in drawings {
        let mut played = Vec::new();
        for _ in 0..ROUNDS {
            played.push(WORKS.into_iter().map(|work| play(drawing, work)).collect::<Result<Vec<_>, _>>()?);
        }
        for (index, records) in all.iter_mut().enumerate() {
            let times = played.iter().map(|round| round[index].0).collect();
            records.push(judged(drawing, WORKS[index], times, &played[0][index].1)?);
        }
    }
    let mean =
        |records: &[Record]| Times::mean(&records.iter().map(|record| &record.times).collect::<Vec<_>>());
    let baseline =
        WORKS.iter().position(|&work| work == BASELINE).map_or_else(Times::default, |i| mean(&all[i]));
    let summary = |(work, records): (Work, Vec<Record>)| {
        let extent = |of: fn(&Record) -> f64| Extent::of(&records.iter().map(of).collect::<Vec<_>>());
        let times = mean(&records);
        let to_rest: Vec<_> = records.iter().filter_map(|record| record.to_rest).collect();
        Summary {
            work,
            ratio: times.over(&baseline),
            times,
            evenness: extent(|record| record.figures.evenness),
            side_lobe: extent(|record| record.figures.side_lobe),
            strength: extent(|record| record.figures.strength),
            to_rest: (!to_rest.is_empty()).then(|| Extent::of(&to_rest)),
            records,
        }
    };
    Ok(WORKS.into_iter().zip(all).map(summary).collect())
}

/// What it takes to find a drive, of a drag per frame, and the drive.
fn play(drawing: &Drawing, work: Work) -> Result<(Spent, Drive), SolveError> {
    let scene = match work {
        Work::Stroke => drawing.scene(0.0, Sampling::Continuous),
        Work::Foci(distance, method) => {
            let mut scene = drawing.scene(0.0, Sampling::Spacing(f64::from(distance) * 1e-3));
            scene.solver.method = method;
            scene
        }
        Work::Dragged => return drag(drawing),
    };
    let (spent, solution) = Spent::once(|| solver::solve(&scene));
    Ok((spent, solution?.drive))
}

/// The mean frame in which the drawing moves, from the drive at rest on, and the last drive.
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

fn judged(drawing: &Drawing, work: Work, times: Times, drive: &Drive) -> Result<Record, SolveError> {
    let moved = if work == Work::Dragged { f64::from(FRAMES) * STRIDE } else { 0.0 };
    let scene = drawing.scene(moved, Sampling::Continuous);
    let found = figures(&scene, drive)?;
    let to_rest = match work {
        Work::Stroke | Work::Foci(..) => None,
        Work::Dragged => {
            let rest = figures(&scene, &solver::solve(&scene)?.drive)?;
            Some(found.side_lobe / rest.side_lobe)
        }
    };
    Ok(Record { drawing: drawing.name, times, figures: found, to_rest })
}

/// Of a drive along a scene's strokes, whatever foci it was made for.
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
        summary.work.name(),
        summary.times.text(),
        summary.ratio.text(),
        summary.ratio.quartiles_text(),
        pair(evenness.mean, evenness.least),
        pair(side_lobe.mean, side_lobe.most),
        pair(strength.mean, strength.least),
        summary.to_rest.map_or("-".to_owned(), |to_rest| pair(to_rest.mean, to_rest.most)),
    ]
}

/// All drawings together, and each of them.
fn records(summary: &Summary) -> Vec<Value> {
    let drive = summary.work.name();
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
        name: summary.work.name(),
        points: vec![(summary.side_lobe.mean, summary.times.cpu_ms())],
    };
    Chart {
        title: "Time against side lobe: drawings, 256 elements".to_owned(),
        x_label: "side lobe over the mean along the strokes, mean of the drawings".to_owned(),
        y_label: "CPU-ms per solve".to_owned(),
        series: summaries.iter().map(series).collect(),
        levels: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_are_evener_and_quieter_beside_them_than_foci_on_the_same_drawing() {
        let triangle = DRAWINGS.iter().find(|drawing| drawing.name == "triangle").unwrap();
        let summaries = measure(std::slice::from_ref(triangle)).unwrap();
        let of = |work: Work| summaries.iter().find(|summary| summary.work == work).unwrap();
        assert_eq!(of(BASELINE).ratio.quartiles, [1.0; 2]);
        // Beads, and side lobes.
        let (stroke, sparse, dense) =
            (of(Work::Stroke), of(Work::Foci(10, Method::Best)), of(Work::Foci(4, Method::Best)));
        assert!(sparse.evenness.least < 0.5 && stroke.evenness.least > 0.8, "{summaries:?}");
        assert!(stroke.side_lobe.most < dense.side_lobe.most, "{summaries:?}");
        let dragged = of(Work::Dragged);
        assert!(dragged.evenness.least > 0.8 && dragged.to_rest.unwrap().most < 1.3, "{summaries:?}");
    }
}
