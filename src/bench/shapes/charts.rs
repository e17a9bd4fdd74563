//! Charts of `sonoglyph bench shapes`: what a drive is worth after so much time.

use crate::bench::shapes::{Extent, Record, Summary};
use crate::bench::time::Spent;
use crate::picture::chart::{Chart, Series};
use crate::solver::Figures;

/// A figure that is drawn.
struct Subject {
    name: &'static str,
    label: &'static str,
    /// Of one drive, and of all of them.
    of: fn(&Figures) -> f64,
    all: fn(&Summary) -> Extent,
    worst: fn(Extent) -> f64,
}

const SUBJECTS: [Subject; 3] = [
    Subject {
        name: "evenness",
        label: "evenness: least over mean along the strokes",
        of: |figures| figures.evenness,
        all: |summary| summary.evenness,
        worst: |extent| extent.least,
    },
    Subject {
        name: "side-lobe",
        label: "side lobe over the mean along the strokes",
        of: |figures| figures.side_lobe,
        all: |summary| summary.side_lobe,
        worst: |extent| extent.most,
    },
    Subject {
        name: "strength",
        label: "strength, of the strongest drive",
        of: |figures| figures.strength,
        all: |summary| summary.strength,
        worst: |extent| extent.least,
    },
];

/// `drawn`: of each drawing the records in their order, the search first.
pub fn charts(drawn: &[Vec<Record>], summaries: &[Summary]) -> Vec<(String, Chart)> {
    let chart = |subject: &Subject| Chart {
        title: format!("Time against {}: drawings, 256 elements", subject.name.replace('-', " ")),
        x_label: "CPU-ms since the start".to_owned(),
        y_label: subject.label.to_owned(),
        series: series(drawn, summaries, subject),
        levels: Vec::new(),
    };
    SUBJECTS.iter().map(|subject| (format!("shapes-{}", subject.name), chart(subject))).collect()
}

/// The search, a point for each call, and a point for each of the others.
fn series(drawn: &[Vec<Record>], summaries: &[Summary], subject: &Subject) -> Vec<Series> {
    let search = drawn.iter().map(|records| records.iter().filter(|record| record.work.is_search()));
    let searches: Vec<Vec<_>> = search.map(Iterator::collect).collect();
    let calls = searches.iter().map(Vec::len).max().unwrap_or_default();
    let over_calls = |name: &str, figure: fn(Extent, &Subject) -> f64| {
        let point = |call: usize| {
            // A search that ended earlier stays where it was.
            let reached: Vec<_> =
                searches.iter().filter_map(|calls| calls.get(call).or(calls.last())).collect();
            let spent: Vec<_> = reached.iter().map(|record| Spent::median(&record.spent)).collect();
            let values: Vec<_> = reached.iter().map(|record| (subject.of)(&record.figures)).collect();
            (1e3 * Spent::mean(&spent).cpu, figure(Extent::of(&values), subject))
        };
        Series { name: name.to_owned(), points: (0..calls).map(point).collect() }
    };
    let mut all = vec![
        over_calls("search, mean", |extent, _| extent.mean),
        over_calls("search, worst", |extent, subject| (subject.worst)(extent)),
    ];
    let others = summaries.iter().filter(|summary| !summary.work.is_search());
    all.extend(others.map(|summary| Series {
        name: summary.work.name(),
        points: vec![(summary.times.cpu_ms(), (subject.all)(summary).mean)],
    }));
    all
}
