//! Charts of `sonoglyph bench field`: time against error, pixels and elements.

use crate::bench::field::{Record, TOLERANCES};
use crate::picture::chart::{Chart, Level, Series};

/// Pixels along a side of the maps whose time stands against their error.
const SIZE: usize = 1024;

/// `arrays_size`: pixels along a side of the maps that several arrays were measured with.
pub fn charts(records: &[Record], arrays_size: usize) -> Vec<(String, Chart)> {
    let on_plane: Vec<_> = records.iter().filter(|record| record.plane == "parallel").collect();
    let usual: Vec<_> = on_plane.iter().copied().filter(|record| record.array == 16).collect();
    let wide = |size: usize| format!("{size} x {size} pixels, plane parallel to the array");
    let chart = |title: String, x_label: &str, series, levels| Chart {
        title,
        x_label: x_label.to_owned(),
        y_label: "CPU-ms for a new drive".to_owned(),
        series,
        levels,
    };
    vec![
        (
            "field-error".to_owned(),
            chart(
                format!("Time against error: 256 elements, {}", wide(SIZE)),
                "error, of the peak",
                by_error(&usual),
                reference(&usual),
            ),
        ),
        (
            "field-pixels".to_owned(),
            chart(
                "Time against pixels: 256 elements, plane parallel to the array".to_owned(),
                "pixels",
                by(&usual, |record| (record.size * record.size) as f64),
                Vec::new(),
            ),
        ),
        (
            "field-elements".to_owned(),
            chart(
                format!("Time against elements: {}", wide(arrays_size)),
                "elements",
                by(
                    &on_plane.iter().copied().filter(|record| record.size == arrays_size).collect::<Vec<_>>(),
                    |record| f64::from(record.array).powi(2),
                ),
                Vec::new(),
            ),
        ),
    ]
}

pub fn tolerance_name(tolerance: f64) -> String {
    if tolerance == 0.0 { "exact".to_owned() } else { format!("{tolerance:.0e}") }
}

/// A series per evaluator, a point per tolerance, from the finest to the coarsest: samples may be nearer than every pixel in f32.
fn by_error(records: &[&Record]) -> Vec<Series> {
    let series = |evaluator: &str| {
        let is_chosen = |record: &&&Record| record.evaluator == evaluator && record.size == SIZE;
        let mut chosen: Vec<_> = records.iter().filter(is_chosen).collect();
        chosen.sort_by(|a, b| a.tolerance.total_cmp(&b.tolerance));
        let points = chosen.iter().map(|record| (record.error, record.new_drive.cpu_ms())).collect();
        Series { name: evaluator.to_owned(), points }
    };
    ["cpu", "gpu"].map(series).into()
}

/// The f64 reference has no error to be drawn at.
fn reference(records: &[&Record]) -> Vec<Level> {
    let slow = records.iter().filter(|record| record.evaluator == "reference" && record.size == SIZE);
    slow.map(|record| Level { name: "f64 reference".to_owned(), y: record.new_drive.cpu_ms() }).collect()
}

/// A series per evaluator and tolerance.
fn by(records: &[&Record], x: impl Fn(&Record) -> f64) -> Vec<Series> {
    let mut all = Vec::new();
    for evaluator in ["reference", "cpu", "gpu"] {
        for tolerance in TOLERANCES.into_iter().filter(|tolerance| [0.0, 1e-3, 1e-5].contains(tolerance)) {
            let chosen = |record: &&&Record| (record.evaluator, record.tolerance) == (evaluator, tolerance);
            let points = records.iter().filter(chosen).map(|record| (x(record), record.new_drive.cpu_ms()));
            let name = format!("{evaluator}, {}", tolerance_name(tolerance));
            all.push(Series { name, points: points.collect() });
        }
    }
    all
}
