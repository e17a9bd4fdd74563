//! `sonoglyph bench shapes`: the search for the drive of a drawing, call by call, beside separate foci on the same drawing.

mod charts;
mod drawings;

use serde_json::json;

use crate::acoustics::Aperture;
use crate::bench::Report;
use crate::bench::time::{ROUNDS, Spent, Spread, Times};
use crate::drive::Drive;
use crate::scene::{Method, Sampling, Scene, outline};
use crate::solver::shape::{self, COARSE};
use crate::solver::{self, Figures, Problem, Search, SolveError, Stage, Surroundings};
use drawings::{DRAWINGS, Drawing, QUICK};

/// Distance (mm) and method of separate foci.
const FOCI: [(u32, Method); 5] =
    [(10, Method::Best), (6, Method::Best), (4, Method::Best), (4, Method::Wgs), (4, Method::Weighted)];
/// The baseline of time.
const BASELINE: Work = Work::Foci(3);
/// Frames of a drag, and how far (m) the drawing moves in each.
const FRAMES: u32 = 10;
const STRIDE: f64 = 1e-3;

/// What a row is about, in the order of the rows.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Work {
    /// What the search has after its first call.
    First,
    /// After so many calls on coarse samples.
    Coarse(u32),
    Starts,
    Finer,
    End,
    /// One of [`FOCI`].
    Foci(usize),
    /// Going on from the frame before.
    Dragged,
}

impl Work {
    /// Those of a run.
    fn all() -> Vec<Self> {
        let mut all = vec![Self::First];
        all.extend((1..=COARSE.1).map(Self::Coarse));
        all.extend([Self::Starts, Self::Finer, Self::End]);
        all.extend((0..FOCI.len()).map(Self::Foci));
        all.push(Self::Dragged);
        all
    }

    /// What a call of a search in this stage adds to.
    fn of(stage: Stage) -> Self {
        match stage {
            Stage::First => Self::First,
            Stage::Coarse(call) => Self::Coarse(call + 1),
            Stage::Other(_) => Self::Starts,
            Stage::Leader(_) | Stage::Rival(_) | Stage::Area(_) => Self::Finer,
            Stage::Last(_) | Stage::Done => Self::End,
            Stage::Moved | Stage::Going => Self::Dragged,
        }
    }

    /// Whether it is a part of the search.
    pub fn is_search(self) -> bool {
        self <= Self::End
    }

    pub fn name(self) -> String {
        match self {
            Self::First => "first drive".to_owned(),
            Self::Coarse(calls) => format!("{} steps", COARSE.0 * calls as usize),
            Self::Starts => "five starts".to_owned(),
            Self::Finer => "finer".to_owned(),
            Self::End => "end".to_owned(),
            Self::Foci(index) => {
                let (distance, method) = FOCI[index];
                format!("{}, foci {distance} mm apart", method.name())
            }
            Self::Dragged => "dragged".to_owned(),
        }
    }
}

/// A drive of a drawing, and what it took in one round.
struct Played {
    work: Work,
    steps: u32,
    /// Since the start of the search, or of the frame.
    spent: Spent,
    drive: Drive,
    /// m along x.
    moved: f64,
}

/// A drive of a drawing with its figures.
#[derive(Debug)]
pub struct Record {
    drawing: &'static str,
    pub work: Work,
    steps: u32,
    /// Of each round.
    spent: Vec<Spent>,
    pub figures: Figures,
    /// Its side lobe over that of a whole search, after a drag.
    to_rest: Option<f64>,
}

/// All drawings together.
#[derive(Debug)]
pub struct Summary {
    pub work: Work,
    /// Most of the drawings.
    steps: u32,
    /// Mean over the drawings, of each round.
    pub times: Times,
    /// CPU time over the baseline's.
    ratio: Spread,
    pub evenness: Extent,
    pub side_lobe: Extent,
    pub strength: Extent,
    to_rest: Option<Extent>,
}

/// Of a figure over the drawings.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    pub mean: f64,
    pub least: f64,
    pub most: f64,
}

impl Extent {
    fn of(values: &[f64]) -> Self {
        Self {
            mean: values.iter().sum::<f64>() / values.len() as f64,
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            most: values.iter().copied().fold(0.0, f64::max),
        }
    }

    fn json(&self) -> serde_json::Value {
        json!({ "mean": self.mean, "least": self.least, "most": self.most })
    }
}

pub fn run(quick: bool) -> anyhow::Result<Report> {
    let drawings = if quick { &DRAWINGS[..QUICK] } else { &DRAWINGS };
    let drawn = drawings.iter().map(measure).collect::<Result<Vec<_>, _>>()?;
    let summaries = summaries(&drawn);
    let names: Vec<_> = drawings.iter().map(|drawing| drawing.name).collect();
    Ok(Report {
        header: vec![
            "drive",
            "steps",
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
                "Means over the drawings, and the worst of them in brackets: {}; 256 elements, plane z = 0.1 m. CPU ms since the \
                 start, foci and transfer included, medians of {ROUNDS} rounds. x: CPU time over that of `{}`.",
                names.join(", "),
                BASELINE.name(),
            ),
            "evenness: least over mean of |p| along the strokes; side lobe: the loudest place beside them over that mean; strength: \
             over that of the strongest drive. Separate foci are judged along the strokes too."
                .to_owned(),
            format!(
                "dragged: the drawing moves by {} mm a frame for {FRAMES} frames, each going on from the one before; CPU ms of a \
                 frame. to rest: the last frame's side lobe over that of a whole search there.",
                STRIDE * 1e3,
            ),
        ],
        charts: charts::charts(&drawn, &summaries),
        records: summaries.iter().map(json_of_all).chain(drawn.iter().flatten().map(json_of_one)).collect(),
    })
}

/// Every call of the search, every set of foci, and every frame of the drag, in this order.
fn measure(drawing: &Drawing) -> Result<Vec<Record>, SolveError> {
    let mut records: Vec<Record> = Vec::new();
    for _ in 0..ROUNDS {
        let played = round(drawing)?;
        if records.is_empty() {
            records = played.iter().map(|played| judged(drawing, played)).collect::<Result<_, _>>()?;
        }
        for (record, played) in records.iter_mut().zip(&played) {
            record.spent.push(played.spent);
        }
    }
    let moved = f64::from(FRAMES) * STRIDE;
    let rest = solver::solve(&drawing.scene(moved, Sampling::Continuous))?.drive;
    let rest = figures(drawing, moved, &rest)?.side_lobe;
    if let Some(last) = records.last_mut() {
        last.to_rest = Some(last.figures.side_lobe / rest);
    }
    Ok(records)
}

/// All works on a drawing, once.
fn round(drawing: &Drawing) -> Result<Vec<Played>, SolveError> {
    let mut played = search(&drawing.scene(0.0, Sampling::Continuous))?;
    for (index, (distance, method)) in FOCI.into_iter().enumerate() {
        let scene = drawing.scene(0.0, Sampling::Spacing(f64::from(distance) * 1e-3));
        played.push(separate(&scene, method, Work::Foci(index))?);
    }
    played.extend(drag(drawing)?);
    Ok(played)
}

/// What every call of a search gives.
fn search(scene: &Scene) -> Result<Vec<Played>, SolveError> {
    let aperture = Aperture::new(scene);
    let mut total = Spent::default();
    let (spent, problem) =
        Spent::once(|| Ok::<_, SolveError>(Problem::of_scene(scene, &aperture, outline::foci(scene)?)));
    total += spent;
    let problem = problem?;
    let (spent, mut search) = Spent::once(|| Search::new(&problem, &Surroundings::new(scene, &problem.foci)));
    total += spent;
    let mut calls = Vec::new();
    loop {
        let work = Work::of(search.stage());
        let (spent, found) = Spent::once(|| search.advance());
        total += spent;
        let Some(found) = found else { return Ok(calls) };
        let drive = uniform(&aperture, &found.values);
        calls.push(Played { work, steps: found.iterations, spent: total, drive, moved: 0.0 });
    }
}

fn separate(scene: &Scene, method: Method, work: Work) -> Result<Played, SolveError> {
    let aperture = Aperture::new(scene);
    let (spent, found) = Spent::once(|| {
        let problem = Problem::of_scene(scene, &aperture, outline::foci(scene)?);
        solver::excite(&problem, method, 0)
    });
    let found = found?;
    let drive = uniform(&aperture, &found.values);
    Ok(Played { work, steps: found.iterations, spent, drive, moved: 0.0 })
}

/// Frames in which the drawing moves, from the drive at rest on.
fn drag(drawing: &Drawing) -> Result<Vec<Played>, SolveError> {
    let mut before = solver::solve(&drawing.scene(0.0, Sampling::Continuous))?;
    let mut frames = Vec::new();
    for frame in 1..=FRAMES {
        let moved = f64::from(frame) * STRIDE;
        let scene = drawing.scene(moved, Sampling::Continuous);
        let (spent, found) = Spent::once(|| solver::solve_on(&scene, Some(&before)));
        before = found?;
        let (work, steps, drive) = (Work::Dragged, before.iterations, before.drive.clone());
        frames.push(Played { work, steps, spent, drive, moved });
    }
    Ok(frames)
}

fn uniform(aperture: &Aperture, values: &[num_complex::Complex64]) -> Drive {
    Drive::uniform(aperture.positions.len(), &aperture.driven, values)
}

fn judged(drawing: &Drawing, played: &Played) -> Result<Record, SolveError> {
    Ok(Record {
        drawing: drawing.name,
        work: played.work,
        steps: played.steps,
        spent: Vec::new(),
        figures: figures(drawing, played.moved, &played.drive)?,
        to_rest: None,
    })
}

/// Of a drive along the drawing's strokes, whatever foci it was made for.
fn figures(drawing: &Drawing, moved: f64, drive: &Drive) -> Result<Figures, SolveError> {
    let scene = drawing.scene(moved, Sampling::Continuous);
    let aperture = Aperture::new(&scene);
    let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene)?);
    Ok(shape::figures(
        &problem,
        &Surroundings::new(&scene, &problem.foci),
        &drive.excitation(&aperture.driven),
    ))
}

/// A row for each work: of a search, what it has at its end.
fn summaries(drawn: &[Vec<Record>]) -> Vec<Summary> {
    let all = |work: Work| drawn.iter().flat_map(move |records| chosen(records, work)).collect::<Vec<_>>();
    let times = |work: Work| {
        let records = all(work);
        let spent = |round: usize| records.iter().map(|record| record.spent[round]).collect::<Vec<_>>();
        (0..ROUNDS).map(|round| Spent::mean(&spent(round))).collect::<Times>()
    };
    let baseline = times(BASELINE);
    let summary = |work: Work| {
        let records = all(work);
        let extent = |of: fn(&Figures) -> f64| {
            Extent::of(&records.iter().map(|record| of(&record.figures)).collect::<Vec<_>>())
        };
        let to_rest: Vec<_> = records.iter().filter_map(|record| record.to_rest).collect();
        let times = times(work);
        Summary {
            work,
            steps: records.iter().map(|record| record.steps).max().unwrap_or_default(),
            ratio: times.over(&baseline),
            times,
            evenness: extent(|figures| figures.evenness),
            side_lobe: extent(|figures| figures.side_lobe),
            strength: extent(|figures| figures.strength),
            to_rest: (!to_rest.is_empty()).then(|| Extent::of(&to_rest)),
        }
    };
    Work::all().into_iter().map(summary).collect()
}

/// A drawing's records of a work: of a search that skipped it, what it had before.
fn chosen(records: &[Record], work: Work) -> Vec<&Record> {
    if work.is_search() {
        records.iter().rfind(|record| record.work <= work).into_iter().collect()
    } else {
        records.iter().filter(|record| record.work == work).collect()
    }
}

fn row(summary: &Summary) -> Vec<String> {
    let pair = |mean: f64, worst: f64| format!("{mean:.3} ({worst:.3})");
    let Summary { evenness, side_lobe, strength, .. } = summary;
    vec![
        summary.work.name(),
        summary.steps.to_string(),
        summary.times.text(),
        summary.ratio.text(),
        summary.ratio.quartiles_text(),
        pair(evenness.mean, evenness.least),
        pair(side_lobe.mean, side_lobe.most),
        pair(strength.mean, strength.least),
        summary.to_rest.map_or("-".to_owned(), |to_rest| pair(to_rest.mean, to_rest.most)),
    ]
}

fn json_of_all(summary: &Summary) -> serde_json::Value {
    json!({
        "drawing": "all",
        "drive": summary.work.name(),
        "steps": summary.steps,
        "time": summary.times.json(),
        "time_ratio": summary.ratio.json(),
        "evenness": summary.evenness.json(),
        "side_lobe": summary.side_lobe.json(),
        "strength": summary.strength.json(),
        "side_lobe_to_rest": summary.to_rest.map(|to_rest| to_rest.json()),
    })
}

fn json_of_one(record: &Record) -> serde_json::Value {
    json!({
        "drawing": record.drawing,
        "drive": record.work.name(),
        "steps": record.steps,
        "time": record.spent.iter().copied().collect::<Times>().json(),
        "evenness": record.figures.evenness,
        "side_lobe": record.figures.side_lobe,
        "strength": record.figures.strength,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_ends_better_than_it_begins_and_than_foci_on_the_same_drawing() {
        let triangle = DRAWINGS.iter().find(|drawing| drawing.name == "triangle").unwrap();
        let drawn = vec![measure(triangle).unwrap()];
        let summaries = summaries(&drawn);
        let of = |work: Work| summaries.iter().find(|summary| summary.work == work).unwrap();
        let (first, end) = (of(Work::First), of(Work::End));
        assert!(end.steps > first.steps && end.times.cpu_ms() > first.times.cpu_ms(), "{summaries:?}");
        assert!(end.side_lobe.most < 0.8 * first.side_lobe.most, "{summaries:?}");
        assert_eq!(of(BASELINE).ratio.quartiles, [1.0; 2]);
        // Beads, and side lobes.
        let (sparse, dense) = (of(Work::Foci(0)), of(Work::Foci(2)));
        assert!(sparse.evenness.least < 0.5 && end.evenness.least > 0.8, "{summaries:?}");
        assert!(end.side_lobe.most < dense.side_lobe.most, "{summaries:?}");
        // Frames go on from the drive at rest, each where the drawing has come to.
        let frames = chosen(&drawn[0], Work::Dragged);
        assert_eq!(frames.len(), FRAMES as usize);
        let dragged = of(Work::Dragged);
        assert!(dragged.evenness.least > 0.8 && dragged.to_rest.unwrap().most < 1.3, "{summaries:?}");
    }
}
