//! Time and error of maps by evaluator, tolerance, size, array and kind of plane.

use indicatif::{ProgressBar, ProgressStyle};
use sonoglyph::bench::Report;
use sonoglyph::bench::field::{self, Group, Record, tolerance_name};
use sonoglyph::picture::chart::{Chart, Series};

const PLANES: [&str; 3] = ["parallel", "tilted", "vertical"];
/// 0 evaluates every pixel, the baseline of the others.
const TOLERANCES: [f64; 5] = [0.0, 1e-2, 1e-3, 1e-4, 1e-5];
const QUICK_TOLERANCES: [f64; 3] = [0.0, 1e-3, 1e-5];
const SIZES: [usize; 5] = [128, 256, 512, 1024, 2048];
const QUICK_SIZES: [usize; 2] = [256, 1024];
/// Pixels along a side of the chart of time against error.
const ERROR_SIZE: usize = 1024;
/// Elements along a side, and pixels along a side of their maps.
const ARRAYS: [u32; 4] = [16, 32, 64, 128];
const QUICK_ARRAYS: [u32; 2] = [16, 32];
const ARRAYS_SIZE: usize = 256;
/// Pixels and elements along a side of large maps on the GPU, and their tolerance.
const LARGE: [(usize, u32); 2] = [(4096, 16), (1024, 64)];
const LARGE_TOLERANCE: f64 = 1e-3;
/// Limits of pixel-element pairs for direct evaluation, in f32 and in f64.
const MOST_PAIRS: usize = 1_200_000_000;
const MOST_REFERENCE_PAIRS: usize = 270_000_000;

pub fn run(quick: bool) -> anyhow::Result<Report> {
    let groups = groups(quick, &field::evaluators());
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg} {eta}")?;
    let bar = ProgressBar::new(groups.len() as u64).with_style(style);
    let mut records = Vec::new();
    for group in groups {
        let Group { evaluator, size, array, plane, .. } = group;
        bar.set_message(format!("{evaluator} {size}x{size} px, {array}x{array} elements, {plane}"));
        records.extend(field::measure(&group)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let charts = charts(&records);
    Ok(field::report(&records, charts))
}

/// The groups without duplicates and without those that are too slow.
fn groups(quick: bool, evaluators: &[&'static str]) -> Vec<Group> {
    let (planes, tolerances, sizes, arrays) = if quick {
        (&PLANES[..1], &QUICK_TOLERANCES[..], &QUICK_SIZES[..], &QUICK_ARRAYS[..])
    } else {
        (&PLANES[..], &TOLERANCES[..], &SIZES[..], &ARRAYS[..])
    };
    let mut groups: Vec<Group> = Vec::new();
    for &plane in planes {
        let by_size = sizes.iter().map(|&size| (16, size));
        for (array, size) in by_size.chain(arrays.iter().map(|&array| (array, ARRAYS_SIZE))) {
            for &evaluator in evaluators {
                let tolerances = measured(tolerances, evaluator, size * size * (array * array) as usize);
                let group = Group { evaluator, size, array, plane, tolerances };
                if !group.tolerances.is_empty() && !groups.contains(&group) {
                    groups.push(group);
                }
            }
        }
    }
    if evaluators.contains(&"gpu") {
        groups.extend(LARGE.map(|(size, array)| Group {
            evaluator: "gpu",
            size,
            array,
            plane: "parallel",
            tolerances: vec![LARGE_TOLERANCE],
        }));
    }
    groups
}

/// The tolerances that are measured for maps with this number of pixel-element pairs.
fn measured(tolerances: &[f64], evaluator: &str, pairs: usize) -> Vec<f64> {
    let most = if evaluator == "reference" { MOST_REFERENCE_PAIRS } else { MOST_PAIRS };
    let is_measured =
        |tolerance: f64| if tolerance == 0.0 { pairs <= most } else { evaluator != "reference" };
    tolerances.iter().copied().filter(|&tolerance| is_measured(tolerance)).collect()
}

fn charts(records: &[Record]) -> Vec<(String, Chart)> {
    let on_plane = |is_shown: fn(&Record) -> bool| -> Vec<&Record> {
        records.iter().filter(|record| record.plane == "parallel" && is_shown(record)).collect()
    };
    let chart = |title: String, x_label: &str, series: Vec<Series>| Chart {
        title,
        x_label: x_label.to_owned(),
        y_label: "CPU-ms for a new drive".to_owned(),
        series,
        levels: Vec::new(),
    };
    let of_pixels =
        series(&on_plane(|record| record.array == 16), |record| (record.size * record.size) as f64);
    let of_elements =
        series(&on_plane(|record| record.size == ARRAYS_SIZE), |record| f64::from(record.array).powi(2));
    vec![
        ("field-error".to_owned(), field::by_error(records, ERROR_SIZE)),
        (
            "field-pixels".to_owned(),
            chart(
                "Time against pixels: 256 elements, plane parallel to the array".to_owned(),
                "pixels",
                of_pixels,
            ),
        ),
        (
            "field-elements".to_owned(),
            chart(
                format!(
                    "Time against elements: {ARRAYS_SIZE} x {ARRAYS_SIZE} pixels, plane parallel to the array"
                ),
                "elements",
                of_elements,
            ),
        ),
    ]
}

/// A series per evaluator and tolerance.
fn series(records: &[&Record], x: impl Fn(&Record) -> f64) -> Vec<Series> {
    let mut all = Vec::new();
    for evaluator in ["reference", "cpu", "gpu"] {
        for tolerance in QUICK_TOLERANCES {
            let chosen = records
                .iter()
                .filter(|record| (record.evaluator, record.tolerance) == (evaluator, tolerance));
            let points = chosen.map(|record| (x(record), record.new_drive.cpu_ms())).collect();
            all.push(Series { name: format!("{evaluator}, {}", tolerance_name(tolerance)), points });
        }
    }
    all
}
