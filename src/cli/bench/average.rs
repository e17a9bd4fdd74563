//! The second part of `sonoglyph bench field`: dents and averages beside the picture of one field.

use std::f64::consts::TAU;

use comfy_table::{CellAlignment, Table};
use glam::{DVec2, DVec3};
use serde_json::json;

use crate::acoustics::{Air, Aperture};
use crate::cli::bench::{Report, Spent};
use crate::drive::Drive;
use crate::field::gpu::adapter;
use crate::field::{Average, Colouring, Evaluator, FieldError, Mean, Quantity, Stages, Wanted};
use crate::picture::ColourMap;
use crate::scene::{Plane, Scene};
use crate::surface::Reflector;

/// Frames of a round whose mean is taken.
const FRAMES: usize = 64;
const TOLERANCES: [f64; 2] = [1e-3, 1e-4];

struct Record {
    evaluator: &'static str,
    picture: &'static str,
    frames: usize,
    size: usize,
    tolerance: f64,
    spent: Spent,
    error: f64,
    /// CPU time over that of the field's picture of the same size.
    ratio: f64,
}

pub fn run(quick: bool) -> Result<Report, FieldError> {
    let mut records = Vec::new();
    let tolerances = if quick { &TOLERANCES[..1] } else { &TOLERANCES[..] };
    for evaluator in ["cpu", "gpu"] {
        for &tolerance in tolerances {
            let stages = match (evaluator, adapter::open_best(true)) {
                ("cpu", _) => Stages::new(Evaluator::Cpu),
                (_, Ok(gpu)) => Stages::new(Evaluator::Gpu(Box::new(gpu))),
                (_, Err(_)) => continue,
            };
            measure(evaluator, stages, tolerance, &mut records)?;
        }
    }
    Ok(Report {
        table: table(&records),
        notes: vec![format!(
            "A new drive up to its colours, of a plane of 0.2 m; {FRAMES} frames are a focus on its way along a circle. x: CPU \
             time over that of the picture of one field of the same size, in the same run."
        )],
        records: records.iter().map(json).collect(),
        charts: Vec::new(),
    })
}

fn measure(
    evaluator: &'static str,
    mut stages: Stages,
    tolerance: f64,
    records: &mut Vec<Record>,
) -> Result<(), FieldError> {
    let plane = Plane { size: DVec2::splat(0.2), tolerance, ..Plane::default() };
    let scene = Scene { plane, ..Scene::default() };
    let aperture = Aperture::new(&scene);
    let reflector = Reflector::new(&Air::new(&scene.medium, scene.array.frequency), scene.array.frequency);
    // Two rounds, so that every run has new drives.
    let drives = [0.0, 0.5].map(|turned| round(&aperture, turned));
    for (size, frames, mean) in [
        (512, 1, None),
        (512, 1, Some(Mean::Radiation(reflector))),
        (512, 1, Some(Mean::Dent(reflector, scene.liquid.clone()))),
        (1024, 1, None),
        (1024, FRAMES, Some(Mean::Square)),
        (1024, FRAMES, Some(Mean::Dent(reflector, scene.liquid.clone()))),
    ] {
        let quantity = mean.as_ref().map_or(Quantity::Rms, Mean::quantity);
        let colouring = Colouring::new(quantity, ColourMap::Inferno.table());
        let mut error = 0.0;
        let mut draw = |i: usize| {
            let drives = &drives[i % 2][..frames];
            let plane = &scene.plane;
            match &mean {
                None => {
                    let wanted =
                        Wanted { aperture: &aperture, plane, drive: &drives[0], width: size, height: size };
                    stages.colours(&wanted, &colouring)?;
                    error = stages.map(&wanted)?.error;
                }
                Some(mean) => {
                    let wanted = Average {
                        aperture: &aperture,
                        plane,
                        drives,
                        mean: mean.clone(),
                        part: 1.0,
                        width: size,
                        height: size,
                    };
                    stages.average_colours(&wanted, &colouring)?;
                    error = stages.average(&wanted)?.error;
                }
            }
            Ok::<_, FieldError>(())
        };
        draw(1)?;
        let spent = Spent::on(&mut draw)?;
        let of_field = records.iter().rev().find(|record| record.picture == "field" && record.size == size);
        let picture = match mean {
            None => "field",
            Some(Mean::Square) => "mean RMS pressure",
            Some(Mean::Radiation(_)) => "radiation pressure",
            Some(Mean::Dent(..)) => "dent of water",
        };
        let ratio = of_field.filter(|_| picture != "field").map_or(1.0, |field| spent.cpu / field.spent.cpu);
        records.push(Record { evaluator, picture, frames, size, tolerance, spent, error, ratio });
    }
    Ok(())
}

/// The drives of a focus on its way along a circle.
fn round(aperture: &Aperture, turned: f64) -> Vec<Drive> {
    let drive = |frame: usize| {
        let (sin, cos) = (TAU * (frame as f64 + turned) / FRAMES as f64).sin_cos();
        let focus = DVec3::new(0.02 * cos, 0.02 * sin, 0.1);
        let phase = |position: &DVec2| aperture.element.wavenumber * focus.distance(position.extend(0.0));
        let phases: Vec<_> = aperture.positions.iter().map(phase).collect();
        Drive { amplitudes: vec![1.0; phases.len()], phases }
    };
    (0..FRAMES).map(drive).collect()
}

fn table(records: &[Record]) -> Table {
    let mut table = Table::new();
    table.set_header([
        "evaluator",
        "picture",
        "frames",
        "pixels",
        "tolerance",
        "CPU ms (wall)",
        "error",
        "x",
    ]);
    for record in records {
        table.add_row([
            record.evaluator.to_owned(),
            record.picture.to_owned(),
            record.frames.to_string(),
            format!("{0}x{0}", record.size),
            format!("{:.0e}", record.tolerance),
            format!("{:.1} ({:.1})", record.spent.cpu * 1e3, record.spent.wall * 1e3),
            format!("{:.1e}", record.error),
            format!("{:.1}", record.ratio),
        ]);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn json(record: &Record) -> serde_json::Value {
    json!({
        "evaluator": record.evaluator,
        "picture": record.picture,
        "frames": record.frames,
        "width": record.size,
        "height": record.size,
        "tolerance": record.tolerance,
        "cpu_ms": record.spent.cpu * 1e3,
        "wall_ms": record.spent.wall * 1e3,
        "error": record.error,
        "ratio_to_field": record.ratio,
    })
}
