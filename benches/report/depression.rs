//! Time of depressions and of means over a cycle, relative to a pressure map, by error and pixels.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde_json::json;

use sonoglyph::acoustics::Aperture;
use sonoglyph::bench::Report;
use sonoglyph::bench::field::tolerance_name;
use sonoglyph::bench::time::{ROUNDS, Spent, Spread, Times};
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Colouring, Evaluator, FieldError, Quantity, Request, Stages};
use sonoglyph::picture::ColourMap;
use sonoglyph::picture::chart::{Chart, Series};
use sonoglyph::scene::{Plane, Scene};
use sonoglyph::studio::map;

/// Frames of a cycle, for the means over it.
const FRAMES: usize = 64;
const TOLERANCES: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];
const QUICK_TOLERANCES: [f64; 2] = [1e-3, 1e-5];
/// A scene's default tolerance, for the measurements by pixels.
const TOLERANCE: f64 = 1e-3;
/// Pixels along a side: of the measurements by error, and by pixels.
const SIZE: usize = 512;
const SIZES: [usize; 4] = [256, 512, 1024, 2048];
const QUICK_SIZES: [usize; 2] = [512, 1024];

const FIELD: &str = "field";
const DEPRESSION: &str = "depression";

#[derive(Debug)]
struct Record {
    evaluator: &'static str,
    picture: &'static str,
    frames: usize,
    size: usize,
    tolerance: f64,
    times: Times,
    error: f64,
    /// CPU time relative to the pressure map.
    ratio: Spread,
}

pub fn run(quick: bool) -> anyhow::Result<Report> {
    let mut records = Vec::new();
    let (tolerances, sizes) =
        if quick { (&QUICK_TOLERANCES[..], &QUICK_SIZES[..]) } else { (&TOLERANCES[..], &SIZES[..]) };
    let has_gpu = adapter::open_best(true).is_ok();
    for evaluator in ["cpu", "gpu"].into_iter().filter(|&evaluator| evaluator == "cpu" || has_gpu) {
        for &tolerance in tolerances {
            records.extend(measure(evaluator, SIZE, tolerance)?);
        }
        for &size in sizes.iter().filter(|&&size| size != SIZE) {
            records.extend(measure(evaluator, size, TOLERANCE)?);
        }
    }
    Ok(Report {
        header: vec![
            "evaluator",
            "picture",
            "frames",
            "pixels",
            "tolerance",
            "CPU ms (wall)",
            "error",
            "time ratio",
            "quartiles",
        ],
        rows: records.iter().map(row).collect(),
        notes: vec![format!(
            "From a new drive to colours, on a plane of 0.2 m; depressions of water; {FRAMES} frames of a focus that \
             moves along a circle. time ratio: CPU time relative to one pressure map of this size, over {ROUNDS} \
             rounds in which they alternate."
        )],
        charts: charts(&records),
        records: records.iter().map(json).collect(),
    })
}

/// A picture, with its state between the rounds.
struct Case {
    name: &'static str,
    quantity: Quantity,
    frames: usize,
    stages: Stages,
    times: Times,
    error: f64,
}

impl Case {
    /// Draws from a new drive to colours.
    fn draw(&mut self, view: &View, run: usize) -> Result<(), FieldError> {
        let View { scene, cycles, size } = view;
        let drives = cycles[run % 2][..self.frames].to_vec();
        let request = Request { part: 1.0, ..Request::new(scene, drives, self.quantity, (*size, *size)) };
        let colouring =
            Colouring::new(self.quantity, map::colours(self.quantity, ColourMap::Inferno).table());
        self.stages.colours(&request, &colouring)?;
        self.error = self.stages.map(&request)?.error;
        Ok(())
    }
}

/// The scene of the pictures.
struct View {
    scene: Scene,
    /// Drives of two cycles, so that every run has new drives.
    cycles: [Vec<Drive>; 2],
    size: usize,
}

fn measure(evaluator: &'static str, size: usize, tolerance: f64) -> Result<Vec<Record>, FieldError> {
    let scene =
        Scene { plane: Plane { size: DVec2::splat(0.2), tolerance, ..Plane::default() }, ..Scene::default() };
    let cycles = [0.0, 0.5].map(|turned| cycle(&Aperture::new(&scene), turned));
    let view = View { scene, cycles, size };
    let mut cases = Vec::new();
    for (name, frames, quantity) in [
        (FIELD, 1, Quantity::Rms),
        ("radiation pressure", 1, Quantity::Radiation),
        (DEPRESSION, 1, Quantity::Depression),
        ("caustic", 1, Quantity::Caustic),
        ("mean RMS pressure", FRAMES, Quantity::Rms),
        (DEPRESSION, FRAMES, Quantity::Depression),
        ("intensity", 1, Quantity::Intensity),
        ("velocity", 1, Quantity::Velocity),
    ] {
        let stages = Stages::new(match evaluator {
            "gpu" => Evaluator::Gpu(Box::new(adapter::open_best(true)?)),
            _ => Evaluator::Cpu,
        });
        let mut case = Case { name, quantity, frames, stages, times: Times::default(), error: 0.0 };
        case.draw(&view, 1)?;
        cases.push(case);
    }
    for _ in 0..ROUNDS {
        for case in &mut cases {
            let spent = Spent::on(|run| case.draw(&view, run))?;
            case.times.push(spent);
        }
    }
    let field = cases[0].times.clone();
    let record = |case: Case| Record {
        evaluator,
        picture: case.name,
        frames: case.frames,
        size,
        tolerance,
        ratio: case.times.over(&field),
        times: case.times,
        error: case.error,
    };
    Ok(cases.into_iter().map(record).collect())
}

/// Drives of a focus that moves along a circle.
fn cycle(aperture: &Aperture, turned: f64) -> Vec<Drive> {
    let drive = |frame: usize| {
        let (sin, cos) = (TAU * (frame as f64 + turned) / FRAMES as f64).sin_cos();
        let focus = DVec3::new(0.02 * cos, 0.02 * sin, 0.1);
        let phase = |position: &DVec3| aperture.element.wavenumber * focus.distance(*position);
        let phases: Vec<_> = aperture.positions.iter().map(phase).collect();
        Drive { amplitudes: vec![1.0; phases.len()], phases }
    };
    (0..FRAMES).map(drive).collect()
}

fn row(record: &Record) -> Vec<String> {
    vec![
        record.evaluator.to_owned(),
        record.picture.to_owned(),
        record.frames.to_string(),
        format!("{0}x{0}", record.size),
        tolerance_name(record.tolerance),
        record.times.text(),
        format!("{:.1e}", record.error),
        record.ratio.text(),
        record.ratio.quartiles_text(),
    ]
}

fn json(record: &Record) -> serde_json::Value {
    json!({
        "evaluator": record.evaluator,
        "picture": record.picture,
        "frames": record.frames,
        "width": record.size,
        "height": record.size,
        "tolerance": record.tolerance,
        "time": record.times.json(),
        "error": record.error,
        "ratio_to_field": record.ratio.json(),
    })
}

fn charts(records: &[Record]) -> Vec<(String, Chart)> {
    let chart = |title: String, x_label: &str, series| Chart {
        title,
        x_label: x_label.to_owned(),
        y_label: "CPU-ms from a new drive to colours".to_owned(),
        series,
        levels: Vec::new(),
    };
    let side_by_side = |frames: &[(&str, usize)], place: &dyn Fn(&Record) -> Option<f64>| {
        let mut series = Vec::new();
        for evaluator in ["cpu", "gpu"] {
            for &(picture, frames) in frames {
                let is_shown = |record: &&Record| {
                    (record.evaluator, record.picture, record.frames) == (evaluator, picture, frames)
                };
                let point = |record: &Record| Some((place(record)?, record.times.cpu_ms()));
                let points = records.iter().filter(is_shown).filter_map(point).collect();
                let many = if frames > 1 { format!(" x {frames}") } else { String::new() };
                series.push(Series { name: format!("{evaluator}, {picture}{many}"), points });
            }
        }
        series
    };
    vec![
        (
            "depression-error".to_owned(),
            chart(
                format!("Time against error: depression and pressure, {SIZE} x {SIZE} pixels, 256 elements"),
                "error relative to the peak",
                side_by_side(&[(FIELD, 1), (DEPRESSION, 1), (DEPRESSION, FRAMES)], &|record| {
                    (record.size == SIZE).then_some(record.error)
                }),
            ),
        ),
        (
            "depression-pixels".to_owned(),
            chart(
                format!(
                    "Time against pixels: depression and pressure, 256 elements, tolerance {TOLERANCE:.0e}"
                ),
                "pixels",
                side_by_side(&[(FIELD, 1), (DEPRESSION, 1), (DEPRESSION, FRAMES)], &|record| {
                    (record.tolerance == TOLERANCE).then_some((record.size * record.size) as f64)
                }),
            ),
        ),
    ]
}
