//! `sonoglyph bench field`: every evaluator, tolerance, size, array and kind of plane.

use comfy_table::{CellAlignment, Table};
use glam::{DVec2, DVec3};
use indicatif::{ProgressBar, ProgressStyle};
use num_complex::Complex64;
use serde_json::json;

use crate::acoustics::Aperture;
use crate::cli::bench::{Report, Spent};
use crate::cli::note;
use crate::drive::Drive;
use crate::field::gpu::adapter;
use crate::field::{Colouring, Evaluator, FieldError, Quantity, Samples, Stages, Wanted, reference};
use crate::picture::ColourMap;
use crate::picture::chart::{Chart, Series};
use crate::scene::{Plane, Scene};

const PLANES: [&str; 3] = ["parallel", "tilted", "vertical"];
const TOLERANCES: [f64; 5] = [0.0, 1e-2, 1e-3, 1e-4, 1e-5];
const QUICK_TOLERANCES: [f64; 3] = [0.0, 1e-3, 1e-5];
const SIZES: [usize; 5] = [128, 256, 512, 1024, 2048];
const QUICK_SIZES: [usize; 2] = [256, 1024];
const ARRAYS: [u32; 3] = [16, 32, 64];
/// Pairs of pixel and element beyond which direct evaluation is not waited for, and the same for f64.
const MOST_PAIRS: usize = 1_200_000_000;
const MOST_REFERENCE_PAIRS: usize = 20_000_000;
/// Pixels at which the error is measured.
const CHECKED: usize = 500;

#[derive(Clone, Debug)]
struct Case {
    evaluator: &'static str,
    tolerance: f64,
    size: usize,
    array: u32,
    plane: &'static str,
}

#[derive(Clone, Debug)]
struct Record {
    case: Case,
    cold: Spent,
    new_plane: Spent,
    new_drive: Spent,
    new_colours: Spent,
    error: f64,
    evaluated: usize,
    pairs_per_second: f64,
    /// CPU time of the exact map's new drive over this one's, and of its new plane over this one's.
    ratios: Option<[f64; 2]>,
}

pub fn run(quick: bool) -> anyhow::Result<Report> {
    let has_gpu = match adapter::open_best(true) {
        Ok(gpu) => {
            note(&format!("the GPU evaluator runs on {}", gpu.info()));
            true
        }
        Err(error) => {
            note(&format!("{error}; the CPU evaluators alone are measured"));
            false
        }
    };
    let cases = cases(quick, has_gpu);
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg} {eta}");
    let bar = ProgressBar::new(cases.len() as u64).with_style(style.unwrap_or(ProgressStyle::default_bar()));
    let mut records: Vec<Record> = Vec::new();
    for case in cases {
        bar.set_message(format!(
            "{} {} {1}x{1} px, {2}x{2} elements, {3}",
            case.evaluator, case.size, case.array, case.plane
        ));
        let mut record = measure(case)?;
        let is_baseline = |other: &&Record| {
            let (a, b) = (&other.case, &record.case);
            let same = (a.evaluator, a.size, a.array, a.plane) == (b.evaluator, b.size, b.array, b.plane);
            same && a.tolerance == 0.0
        };
        if let Some(direct) = records.iter().find(is_baseline) {
            record.ratios = Some([
                direct.new_drive.cpu / record.new_drive.cpu,
                direct.new_plane.cpu / record.new_plane.cpu,
            ]);
        }
        records.push(record);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Report {
        table: table(&records),
        notes: vec![
            "CPU-ms (wall ms) of the whole process, medians. cold: nothing kept; new plane, new drive: up to the pixels' \
             pressure and its measured error; colours: the picture of it."
                .to_owned(),
            format!("error: the largest of {CHECKED} pixels against f64, of the map's peak. Mpairs/s: pixels times elements \
                     per wall second of a new drive."),
            "drive x, plane x: how many times the CPU time of the exact map, for a new drive and a new plane.".to_owned(),
        ],
        records: records.iter().map(json).collect(),
        charts: charts(&records),
    })
}

/// Exact maps stand before what is measured against them.
fn cases(quick: bool, has_gpu: bool) -> Vec<Case> {
    let (planes, tolerances, sizes, arrays) = if quick {
        (&PLANES[..1], &QUICK_TOLERANCES[..], &QUICK_SIZES[..], &ARRAYS[..1])
    } else {
        (&PLANES[..], &TOLERANCES[..], &SIZES[..], &ARRAYS[..])
    };
    let mut cases = Vec::new();
    for &plane in planes {
        for &array in arrays {
            for &size in sizes {
                for evaluator in ["reference", "cpu", "gpu"] {
                    for &tolerance in tolerances {
                        let pairs = size * size * (array * array) as usize;
                        let is_measured = match (evaluator, tolerance == 0.0) {
                            ("reference", exact) => exact && pairs <= MOST_REFERENCE_PAIRS,
                            ("gpu", _) if !has_gpu => false,
                            (_, true) => pairs <= MOST_PAIRS,
                            _ => true,
                        };
                        if is_measured {
                            cases.push(Case { evaluator, tolerance, size, array, plane });
                        }
                    }
                }
            }
        }
    }
    cases
}

fn evaluator(name: &str) -> Result<Evaluator, FieldError> {
    Ok(match name {
        "reference" => Evaluator::Reference,
        "gpu" => Evaluator::Gpu(Box::new(adapter::open_best(true)?)),
        _ => Evaluator::Cpu,
    })
}

fn scene(case: &Case) -> Scene {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (case.array, case.array);
    let plane = Plane { size: DVec2::splat(0.2), tolerance: case.tolerance, ..Plane::default() };
    scene.plane = match case.plane {
        "tilted" => Plane { x_axis: DVec3::new(1.0, 0.2, 0.1), y_axis: DVec3::new(0.0, 1.0, 0.3), ..plane },
        "vertical" => Plane { y_axis: DVec3::Z, centre: DVec3::new(0.0, 0.0, 0.125), ..plane },
        _ => plane,
    };
    scene
}

/// A focus on the plane, a little away from its centre.
fn drive(aperture: &Aperture, shift: f64) -> Drive {
    let focus = DVec3::new(0.02 + shift, -0.01, 0.1);
    let phase = |position: &DVec2| aperture.element.wavenumber * focus.distance(position.extend(0.0));
    let phases: Vec<_> = aperture.positions.iter().map(phase).collect();
    Drive { amplitudes: vec![1.0; phases.len()], phases }
}

fn measure(case: Case) -> Result<Record, FieldError> {
    let mut scene = scene(&case);
    let aperture = Aperture::new(&scene);
    let drives = [drive(&aperture, 0.0), drive(&aperture, 0.005)];
    let paint = |colours: ColourMap| Colouring::new(Quantity::Rms, colours.table());
    let colourings = [paint(ColourMap::Inferno), paint(ColourMap::Grey)];
    let map = |stages: &mut Stages, plane: &Plane, drive: usize| {
        let (width, height) = (case.size, case.size);
        let wanted = Wanted { aperture: &aperture, plane, drive: &drives[drive % 2], width, height };
        stages.map(&wanted).map(|_| ())
    };
    // Opening a device and compiling its programs is no part of a map.
    let mut stages = Stages::new(evaluator(case.evaluator)?);
    map(&mut stages, &scene.plane, 0)?;
    let cold = Spent::on(|_| {
        stages.forget();
        map(&mut stages, &scene.plane, 0)
    })?;
    let new_plane = Spent::on(|i| {
        scene.plane.centre.z += if i % 2 == 0 { 1e-4 } else { -1e-4 };
        map(&mut stages, &scene.plane, 0)
    })?;
    let new_drive = Spent::on(|i| map(&mut stages, &scene.plane, i + 1))?;
    let (width, height) = (case.size, case.size);
    let wanted = Wanted { aperture: &aperture, plane: &scene.plane, drive: &drives[0], width, height };
    stages.colours(&wanted, &colourings[0])?;
    let new_colours = Spent::on(|i| stages.colours(&wanted, &colourings[(i + 1) % 2]).map(|_| ()))?;
    let map = stages.map(&wanted)?.clone();
    let field = stages.read(&wanted)?;
    let pairs = (field.len() * aperture.positions.len()) as f64;
    Ok(Record {
        error: error(&wanted, &field, map.peak),
        evaluated: map.evaluated,
        pairs_per_second: pairs / new_drive.wall,
        ratios: None,
        case,
        cold,
        new_plane,
        new_drive,
        new_colours,
    })
}

/// The largest deviation from the reference, relative to the peak (Pa).
fn error(wanted: &Wanted<'_>, field: &[num_complex::Complex32], peak: f32) -> f64 {
    let Some(pixels) = Samples::on_plane(wanted.plane, wanted.width, wanted.height) else { return f64::NAN };
    let chosen: Vec<_> = (0..field.len()).step_by((field.len() / CHECKED).max(1) | 1).collect();
    let points = Samples::at(chosen.iter().map(|&pixel| pixels.point(pixel)).collect());
    let expected = reference::pressure(wanted.aperture, wanted.drive, &points);
    let off = |(&pixel, expected): (&usize, &Complex64)| {
        (Complex64::new(field[pixel].re.into(), field[pixel].im.into()) - expected).norm()
    };
    chosen.iter().zip(&expected).map(off).fold(0.0, f64::max) / f64::from(peak)
}

fn table(records: &[Record]) -> Table {
    let mut table = Table::new();
    table.set_header([
        "evaluator",
        "plane",
        "elements",
        "pixels",
        "tolerance",
        "cold",
        "new plane",
        "new drive",
        "colours",
        "error",
        "samples",
        "Mpairs/s",
        "drive x",
        "plane x",
    ]);
    let ms = |spent: Spent| format!("{:.1} ({:.1})", spent.cpu * 1e3, spent.wall * 1e3);
    for record in records {
        let case = &record.case;
        let ratio = |i: usize| record.ratios.map_or("-".to_owned(), |ratios| format!("{:.1}", ratios[i]));
        table.add_row([
            case.evaluator.to_owned(),
            case.plane.to_owned(),
            format!("{0}x{0}", case.array),
            format!("{0}x{0}", case.size),
            if case.tolerance == 0.0 { "exact".to_owned() } else { format!("{:.0e}", case.tolerance) },
            ms(record.cold),
            ms(record.new_plane),
            ms(record.new_drive),
            ms(record.new_colours),
            format!("{:.1e}", record.error),
            record.evaluated.to_string(),
            format!("{:.0}", record.pairs_per_second / 1e6),
            ratio(0),
            ratio(1),
        ]);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn json(record: &Record) -> serde_json::Value {
    let case = &record.case;
    let ms = |spent: Spent| json!({ "cpu_ms": spent.cpu * 1e3, "wall_ms": spent.wall * 1e3 });
    json!({
        "evaluator": case.evaluator,
        "plane": case.plane,
        "elements": case.array * case.array,
        "width": case.size,
        "height": case.size,
        "tolerance": case.tolerance,
        "cold": ms(record.cold),
        "new_plane": ms(record.new_plane),
        "new_drive": ms(record.new_drive),
        "new_colours": ms(record.new_colours),
        "error": record.error,
        "evaluated": record.evaluated,
        "pairs_per_second": record.pairs_per_second,
        "new_drive_ratio": record.ratios.map(|ratios| ratios[0]),
        "new_plane_ratio": record.ratios.map(|ratios| ratios[1]),
    })
}

fn charts(records: &[Record]) -> Vec<(String, Chart)> {
    let largest = records.iter().map(|record| record.case.size).max().unwrap_or(0).min(1024);
    let series = |name: String, chosen: &dyn Fn(&Case) -> bool, place: &dyn Fn(&Record) -> (f64, f64)| {
        Series { name, points: records.iter().filter(|record| chosen(&record.case)).map(place).collect() }
    };
    let evaluators = ["cpu", "gpu"].into_iter().filter(|e| records.iter().any(|r| r.case.evaluator == *e));
    let ms = |record: &Record| record.new_drive.cpu * 1e3;
    let usual = |case: &Case, evaluator| case.evaluator == evaluator && case.plane == "parallel";
    let chart = |title: &str, x_label: &str, series| Chart {
        title: title.to_owned(),
        x_label: x_label.to_owned(),
        y_label: "CPU-ms for a new drive".to_owned(),
        series,
    };
    let mut by_error = Vec::new();
    let (mut by_size, mut by_array) = (Vec::new(), Vec::new());
    for evaluator in evaluators {
        let mut pareto = series(
            evaluator.to_owned(),
            &|case| usual(case, evaluator) && (case.size, case.array) == (largest, 16),
            &|record| (record.error, ms(record)),
        );
        pareto.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        by_error.push(pareto);
        for tolerance in [0.0, 1e-3, 1e-5] {
            let tolerance_name =
                if tolerance == 0.0 { "exact".to_owned() } else { format!("{tolerance:.0e}") };
            let name = format!("{evaluator}, {tolerance_name}");
            by_size.push(series(
                name.clone(),
                &|case| usual(case, evaluator) && case.array == 16 && case.tolerance == tolerance,
                &|record| (record.case.size as f64, ms(record)),
            ));
            by_array.push(series(
                name,
                &|case| usual(case, evaluator) && case.size == largest && case.tolerance == tolerance,
                &|record| (f64::from(record.case.array).powi(2), ms(record)),
            ));
        }
    }
    let wide = format!("{largest} x {largest} pixels of a plane parallel to the array");
    vec![
        (
            "field-error".to_owned(),
            chart(&format!("Time against error: 16 x 16 elements, {wide}"), "error, of the peak", by_error),
        ),
        (
            "field-pixels".to_owned(),
            chart("Time against size: 16 x 16 elements, parallel plane", "pixels along a side", by_size),
        ),
        ("field-elements".to_owned(), chart(&format!("Time against elements: {wide}"), "elements", by_array)),
    ]
}
