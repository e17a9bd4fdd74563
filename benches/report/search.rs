//! Convergence of the search for a shape's drive: figures against time, call by call.

use serde_json::json;
use sonoglyph::acoustics::Aperture;
use sonoglyph::bench::Report;
use sonoglyph::bench::drawings::Drawing;
use sonoglyph::bench::shapes::{Extent, figures};
use sonoglyph::bench::time::{ROUNDS, Spent, Times};
use sonoglyph::drive::Drive;
use sonoglyph::picture::chart::{Chart, Series};
use sonoglyph::scene::{Sampling, Scene, outline};
use sonoglyph::solver::{Figures, Problem, Search, SolveError, Surroundings};

/// State of a search after one of its calls.
struct Reached {
    /// Name of the call's stage in the program.
    stage: String,
    steps: u32,
    /// Time since the start of the search, per round.
    spent: Vec<Spent>,
    figures: Figures,
}

/// A figure in a chart: name, definition, value, and whether larger values are worse.
type Figure = (&'static str, &'static str, fn(&Figures) -> f64, bool);

const FIGURES: [Figure; 3] = [
    ("evenness", "least over mean along the strokes", |figures| figures.evenness, false),
    (
        "side lobe",
        "largest |p| outside the main lobes over the mean along the strokes",
        |figures| figures.side_lobe,
        true,
    ),
    ("strength", "mean over that of the strongest drive", |figures| figures.strength, false),
];

pub fn run(drawings: &[Drawing]) -> anyhow::Result<Report> {
    let mut rows = Vec::new();
    let mut records = Vec::new();
    let mut searches = Vec::new();
    for drawing in drawings {
        let calls = measure(&drawing.scene(0.0, Sampling::Continuous))?;
        for (index, Reached { stage, steps, spent, figures }) in calls.iter().enumerate() {
            let times: Times = spent.iter().copied().collect();
            let mut row = vec![
                drawing.name.to_owned(),
                (index + 1).to_string(),
                stage.clone(),
                steps.to_string(),
                times.text(),
            ];
            row.extend(FIGURES.map(|(_, _, of, _)| format!("{:.3}", of(figures))));
            rows.push(row);
            records.push(json!({
                "drawing": drawing.name, "call": index + 1, "stage": stage, "steps": steps, "time": times.json(),
                "evenness": figures.evenness, "side_lobe": figures.side_lobe, "strength": figures.strength,
            }));
        }
        searches.push(calls);
    }
    Ok(Report {
        header: vec![
            "drawing",
            "call",
            "stage",
            "steps",
            "CPU ms (wall)",
            "evenness",
            "side lobe",
            "strength",
        ],
        rows,
        notes: vec![format!(
            "CPU ms since the start, including foci and transfer, medians of {ROUNDS} rounds; 256 elements, plane z = \
             0.1 m."
        )],
        records,
        charts: FIGURES
            .map(|figure| (format!("search-{}", figure.0.replace(' ', "-")), chart(&searches, figure)))
            .into(),
    })
}

/// Runs a search call by call.
fn measure(scene: &Scene) -> Result<Vec<Reached>, SolveError> {
    let mut calls: Vec<Reached> = Vec::new();
    for _ in 0..ROUNDS {
        let aperture = Aperture::new(scene);
        let mut total = Spent::default();
        let (spent, foci) = Spent::once(|| outline::foci(scene));
        total += spent;
        let foci = foci?;
        let (spent, problem) = Spent::once(|| Problem::of_scene(scene, &aperture, foci));
        total += spent;
        let (spent, mut search) =
            Spent::once(|| Search::new(&problem, &Surroundings::new(scene, &problem.foci)));
        total += spent;
        for call in 0.. {
            let stage = format!("{:?}", search.stage());
            let (spent, found) = Spent::once(|| search.advance());
            total += spent;
            let Some(found) = found else { break };
            match calls.get_mut(call) {
                Some(reached) => reached.spent.push(total),
                None => {
                    let drive = Drive::uniform(aperture.positions.len(), &aperture.driven, &found.values);
                    let figures = figures(scene, &drive)?;
                    calls.push(Reached { stage, steps: found.iterations, spent: vec![total], figures });
                }
            }
        }
    }
    Ok(calls)
}

fn chart(searches: &[Vec<Reached>], (name, what, of, is_bad): Figure) -> Chart {
    let calls = searches.iter().map(Vec::len).max().unwrap_or_default();
    let series = |name: &str, one: &dyn Fn(Extent) -> f64| {
        let point = |call: usize| {
            // A search that has ended keeps its last state.
            let reached: Vec<_> =
                searches.iter().filter_map(|calls| calls.get(call).or(calls.last())).collect();
            let spent: Vec<_> = reached.iter().map(|reached| Spent::median(&reached.spent)).collect();
            let values: Vec<_> = reached.iter().map(|reached| of(&reached.figures)).collect();
            (1e3 * Spent::mean(&spent).cpu, one(Extent::of(&values)))
        };
        Series { name: name.to_owned(), points: (0..calls).map(point).collect() }
    };
    Chart {
        title: format!("Search for shapes: {name} against time, 256 elements"),
        x_label: "CPU-ms since the start".to_owned(),
        y_label: what.to_owned(),
        series: vec![
            series("mean", &|extent| extent.mean),
            series("worst", &|extent| if is_bad { extent.most } else { extent.least }),
        ],
        levels: Vec::new(),
    }
}
