//! Charts of `sonoglyph bench solve`: time against loss and spread, and against foci and elements.

use crate::bench::solve::{Record, SCALING};
use crate::picture::chart::{Chart, Series};

/// Foci of the random sets that are drawn.
const RANDOM: [usize; 2] = [8, 32];

pub fn charts(records: &[Record]) -> Vec<(String, Chart)> {
    let mut charts = Vec::new();
    for foci in RANDOM {
        let sets: Vec<_> =
            records.iter().filter(|record| (record.workload, record.foci) == ("plane", foci)).collect();
        charts.push((
            format!("solve-loss-{foci}"),
            chart(
                format!("Time against loss: {foci} random foci on a plane, 256 elements"),
                "1 - certified part of the best possible, mean",
                methods(&sets, |record| 1.0 - record.certified.map_or(f64::NAN, |parts| parts[1])),
            ),
        ));
        charts.push((
            format!("solve-spread-{foci}"),
            chart(
                format!("Time against spread: {foci} random foci on a plane, 256 elements"),
                "spread of the focal pressures, largest of the sets",
                methods(&sets, |record| record.spread),
            ),
        ));
    }
    let scaling = |is_shown: fn(&Record) -> bool| -> Vec<_> {
        records.iter().filter(|record| record.workload == SCALING && is_shown(record)).collect()
    };
    charts.push((
        "solve-foci".to_owned(),
        chart(
            "Time against foci: a disc full of them, 256 elements".to_owned(),
            "foci",
            growing(&scaling(|record| record.elements == 256), |record| record.foci as f64),
        ),
    ));
    charts.push((
        "solve-elements".to_owned(),
        chart(
            "Time against elements: 32 foci on a disc".to_owned(),
            "elements",
            growing(&scaling(|record| record.foci == 32), |record| record.elements as f64),
        ),
    ));
    charts
}

fn chart(title: String, x_label: &str, series: Vec<Series>) -> Chart {
    Chart {
        title,
        x_label: x_label.to_owned(),
        y_label: "CPU-ms per solve".to_owned(),
        series,
        levels: Vec::new(),
    }
}

/// A series per method, whatever its iterations, in the order of time.
fn methods(records: &[&Record], x: impl Fn(&Record) -> f64) -> Vec<Series> {
    let mut all = series(records, |record| family(&record.method), x);
    for series in &mut all {
        series.points.sort_by(|a, b| a.1.total_cmp(&b.1));
    }
    all
}

/// A series per method and its iterations, from left to right.
fn growing(records: &[&Record], x: impl Fn(&Record) -> f64) -> Vec<Series> {
    let mut all = series(records, |record| &record.method, x);
    for series in &mut all {
        series.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    all
}

fn series(records: &[&Record], name: impl Fn(&Record) -> &str, x: impl Fn(&Record) -> f64) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for record in records {
        let point = (x(record), record.times.cpu_ms());
        let name = name(record);
        match all.iter_mut().find(|series| series.name == name) {
            Some(series) => series.points.push(point),
            None => all.push(Series { name: name.to_owned(), points: vec![point] }),
        }
    }
    all
}

/// `best 60` is `best` with other iterations; `best, moved` is not.
fn family(method: &str) -> &str {
    match method.split_once(' ') {
        Some((name, _)) if !name.ends_with(',') => name,
        _ => method,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_make_no_other_method() {
        assert_eq!(
            ["best", "best 60", "best, moved", "wgs 200"].map(family),
            ["best", "best", "best, moved", "wgs"]
        );
    }
}
