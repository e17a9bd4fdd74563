//! `sonoglyph bench field`: time and error of maps, by evaluator and tolerance.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DVec2, DVec3};
use num_complex::Complex64;
use serde_json::json;

use crate::acoustics::Aperture;
use crate::bench::Report;
use crate::bench::time::{ROUNDS, Spent, Spread, Times, median};
use crate::drive::Drive;
use crate::field::gpu::adapter;
use crate::field::{
    self, Colouring, Evaluator, FieldError, Map, Picture, Quantity, Request, Samples, Stages,
};
use crate::picture::ColourMap;
use crate::picture::chart::{Chart, Level, Series};
use crate::scene::{Plane, Scene};
use crate::studio::output::note;

/// 0 evaluates every pixel, the baseline of the others.
const TOLERANCES: [f64; 4] = [0.0, 1e-2, 1e-3, 1e-5];
/// Pixels along a side of the maps: the default of `sonoglyph render`.
const SIZE: usize = 512;
/// Pixels compared with the reference.
const CHECKED: usize = 500;

/// Maps that differ in tolerance only, the exact one first; their measurements alternate.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// `reference`, `cpu` or `gpu`.
    pub evaluator: &'static str,
    /// Pixels along a side.
    pub size: usize,
    /// Elements along a side.
    pub array: u32,
    /// `parallel` to the array, `tilted` or `vertical`.
    pub plane: &'static str,
    pub tolerances: Vec<f64>,
}

#[derive(Clone, Debug)]
pub struct Record {
    pub evaluator: &'static str,
    pub size: usize,
    pub array: u32,
    pub plane: &'static str,
    pub tolerance: f64,
    cold: Times,
    new_plane: Times,
    pub new_drive: Times,
    error: f64,
    evaluated: usize,
    /// Median on the GPU, ms.
    gpu_ms: Option<f64>,
    /// CPU time of the exact map over that of this one, for a new drive and for a new plane.
    ratios: Option<[Spread; 2]>,
}

/// # Errors
/// An evaluator that fails.
pub fn run() -> anyhow::Result<Report> {
    let mut records = Vec::new();
    for evaluator in evaluators() {
        let tolerances = if evaluator == "reference" { &TOLERANCES[..1] } else { &TOLERANCES };
        let group =
            Group { evaluator, size: SIZE, array: 16, plane: "parallel", tolerances: tolerances.into() };
        records.extend(measure(&group)?);
    }
    Ok(report(&records, vec![("field-error".to_owned(), by_error(&records, SIZE))]))
}

/// The evaluators of this machine.
pub fn evaluators() -> Vec<&'static str> {
    let mut all = vec!["reference", "cpu"];
    match adapter::open_best(true) {
        Ok(gpu) => {
            note(&format!("the GPU evaluator runs on {}", gpu.info()));
            all.push("gpu");
        }
        Err(error) => note(&format!("{error}; only CPU evaluators are measured")),
    }
    all
}

pub fn report(records: &[Record], charts: Vec<(String, Chart)>) -> Report {
    Report {
        header: vec![
            "evaluator", "plane", "elements", "pixels", "tolerance", "cold", "new plane", "new drive", "error",
            "samples", "GPU ms", "drive speed", "quartiles", "plane speed",
        ],
        rows: records.iter().map(row).collect(),
        notes: vec![
            "cold, new plane, new drive: median CPU-ms (wall ms) of the process for a map without cached stages, after \
             a change of the plane, and after a change of the drive, up to values and measured error; on a GPU up to \
             texture and error. GPU ms: duration of the map's passes, by GPU timestamps."
                .to_owned(),
            format!("error: largest deviation from f64 at {CHECKED} pixels, relative to the map's peak."),
            format!(
                "drive speed, plane speed: CPU time of the exact map over that of this one, for a new drive (with \
                 quartiles) and a new plane; medians over {ROUNDS} rounds in which the maps alternate."
            ),
        ],
        charts,
        records: records.iter().map(json).collect(),
    }
}

fn evaluator(name: &str) -> Result<Evaluator, FieldError> {
    Ok(match name {
        "reference" => Evaluator::Reference,
        "gpu" => Evaluator::Gpu(Box::new(adapter::open_best(true)?)),
        _ => Evaluator::Cpu,
    })
}

fn scene(group: &Group, tolerance: f64) -> Scene {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (group.array, group.array);
    let plane = Plane { size: DVec2::splat(0.2), tolerance, ..Plane::default() };
    scene.plane = match group.plane {
        "tilted" => Plane { x_axis: DVec3::new(1.0, 0.2, 0.1), y_axis: DVec3::new(0.0, 1.0, 0.3), ..plane },
        "vertical" => Plane { y_axis: DVec3::Z, centre: DVec3::new(0.0, 0.0, 0.125), ..plane },
        _ => plane,
    };
    scene
}

/// A focus on the plane, off its centre.
fn drive(aperture: &Aperture, shift: f64) -> Drive {
    let focus = DVec3::new(0.02 + shift, -0.01, 0.1);
    let phase = |position: &DVec3| aperture.element.wavenumber * focus.distance(*position);
    let phases: Vec<_> = aperture.positions.iter().map(phase).collect();
    Drive { amplitudes: vec![1.0; phases.len()], phases }
}

/// One map of a group, with its state between the rounds.
struct Case {
    tolerance: f64,
    scene: Scene,
    plane: Plane,
    drives: [Drive; 2],
    size: usize,
    stages: Stages,
    cold: Times,
    new_plane: Times,
    new_drive: Times,
    /// s of every map, if the GPU has timestamps.
    on_gpu: Vec<f64>,
}

/// # Errors
/// An evaluator that fails.
pub fn measure(group: &Group) -> Result<Vec<Record>, FieldError> {
    if group.evaluator == "reference" {
        return Ok(vec![reference(group)?]);
    }
    let mut cases = Vec::new();
    for &tolerance in &group.tolerances {
        cases.push(Case::new(group, tolerance)?);
    }
    for _ in 0..ROUNDS {
        for case in &mut cases {
            case.round()?;
        }
    }
    let exact = cases
        .first()
        .filter(|case| case.tolerance == 0.0)
        .map(|case| (case.new_drive.clone(), case.new_plane.clone()));
    cases.into_iter().map(|case| case.record(group, exact.as_ref())).collect()
}

/// The reference is slow and caches nothing: a single run serves for all times.
fn reference(group: &Group) -> Result<Record, FieldError> {
    let mut case = Case::unmeasured(group, 0.0)?;
    let (spent, done) = Spent::once(|| case.map(0));
    done?;
    for times in [&mut case.cold, &mut case.new_plane, &mut case.new_drive] {
        times.push(spent);
    }
    case.record(group, None)
}

impl Case {
    /// The first map opens the device and compiles its programs, outside the measurement.
    fn new(group: &Group, tolerance: f64) -> Result<Self, FieldError> {
        let mut case = Self::unmeasured(group, tolerance)?;
        case.map(0)?;
        Ok(case)
    }

    fn unmeasured(group: &Group, tolerance: f64) -> Result<Self, FieldError> {
        let scene = scene(group, tolerance);
        let aperture = Aperture::new(&scene);
        Ok(Self {
            tolerance,
            drives: [drive(&aperture, 0.0), drive(&aperture, 0.005)],
            plane: scene.plane.clone(),
            scene,
            size: group.size,
            stages: Stages::new(evaluator(group.evaluator)?),
            cold: Times::default(),
            new_plane: Times::default(),
            new_drive: Times::default(),
            on_gpu: Vec::new(),
        })
    }

    fn request(&self, drive: usize) -> Request {
        let drives = vec![self.drives[drive % 2].clone()];
        let request = Request::new(&self.scene, drives, Quantity::Rms, (self.size, self.size));
        Request { plane: self.plane.clone(), ..request }
    }

    /// Makes the map; on a GPU, the window's texture and the map's figures.
    fn map(&mut self, drive: usize) -> Result<(), FieldError> {
        let request = self.request(drive);
        if self.stages.gpu().is_none() {
            return self.stages.map(&request).map(|_| ());
        }
        let colouring = Colouring::new(Quantity::Rms, ColourMap::Inferno.table());
        if let Picture::OnCpu(_) = self.stages.picture(&request, &colouring)? {
            return Ok(());
        }
        while !self.stages.has_declined(&request) {
            if let Some((_, seconds)) = self.stages.figures(&request)? {
                self.on_gpu.extend(seconds);
                return Ok(());
            }
            if let Some(gpu) = self.stages.gpu() {
                gpu.wait()?;
            }
        }
        // Its figures showed a larger error than the tolerance.
        self.stages.map(&request).map(|_| ())
    }

    fn round(&mut self) -> Result<(), FieldError> {
        let spent = Spent::on(|_| {
            self.stages.forget();
            self.map(0)
        })?;
        self.cold.push(spent);
        let spent = Spent::on(|i| {
            self.plane.centre.z += if i % 2 == 0 { 1e-4 } else { -1e-4 };
            self.map(0)
        })?;
        self.new_plane.push(spent);
        let spent = Spent::on(|i| self.map(i + 1))?;
        self.new_drive.push(spent);
        Ok(())
    }

    /// `exact` has the times of the exact map for a new drive and a new plane.
    fn record(mut self, group: &Group, exact: Option<&(Times, Times)>) -> Result<Record, FieldError> {
        let request = self.request(0);
        let map = self.stages.map(&request)?;
        Ok(Record {
            evaluator: group.evaluator,
            size: group.size,
            array: group.array,
            plane: group.plane,
            tolerance: self.tolerance,
            error: error(&request, map),
            evaluated: map.evaluated,
            gpu_ms: (!self.on_gpu.is_empty()).then(|| 1e3 * median(&self.on_gpu)),
            ratios: exact.map(|(drive, plane)| [drive.over(&self.new_drive), plane.over(&self.new_plane)]),
            cold: self.cold,
            new_plane: self.new_plane,
            new_drive: self.new_drive,
        })
    }
}

/// The largest deviation from the reference, relative to the peak.
fn error(request: &Request, map: &Map) -> f64 {
    let Some(pixels) = Samples::on_plane(&request.plane, map.width, map.height) else { return f64::NAN };
    let values = &map.values;
    let chosen: Vec<_> = (0..values.len()).step_by((values.len() / CHECKED).max(1) | 1).collect();
    let points = Samples::at(chosen.iter().map(|&pixel| pixels.point(pixel)).collect());
    let expected = field::reference::pressure(&request.aperture, &request.drives[0], &points);
    let off = |(&pixel, expected): (&usize, &Complex64)| {
        (f64::from(values[pixel]) - expected.norm() * FRAC_1_SQRT_2).abs()
    };
    chosen.iter().zip(&expected).map(off).fold(0.0, f64::max) / f64::from(map.peak)
}

pub fn tolerance_name(tolerance: f64) -> String {
    if tolerance == 0.0 { "exact".to_owned() } else { format!("{tolerance:.0e}") }
}

/// A series per evaluator in order of the tolerance, since errors need not grow with it.
pub fn by_error(records: &[Record], size: usize) -> Chart {
    let of = |evaluator: &str| {
        let is_chosen = |record: &&Record| {
            (record.evaluator, record.size, record.array, record.plane) == (evaluator, size, 16, "parallel")
        };
        let mut chosen: Vec<_> = records.iter().filter(is_chosen).collect();
        chosen.sort_by(|a, b| a.tolerance.total_cmp(&b.tolerance));
        chosen
    };
    let series = |evaluator: &str| Series {
        name: evaluator.to_owned(),
        points: of(evaluator).iter().map(|record| (record.error, record.new_drive.cpu_ms())).collect(),
    };
    // The f64 reference has no error.
    let level = |record: &Record| Level { name: "f64 reference".to_owned(), y: record.new_drive.cpu_ms() };
    Chart {
        title: format!(
            "Time against error: 256 elements, {size} x {size} pixels, plane parallel to the array"
        ),
        x_label: "error relative to the peak".to_owned(),
        y_label: "CPU-ms for a new drive".to_owned(),
        series: ["cpu", "gpu"].map(series).into(),
        levels: of("reference").into_iter().map(level).collect(),
    }
}

fn row(record: &Record) -> Vec<String> {
    let ratio = |i: usize| record.ratios.map_or("-".to_owned(), |ratios| ratios[i].text());
    let quartiles = record.ratios.map_or("-".to_owned(), |ratios| ratios[0].quartiles_text());
    vec![
        record.evaluator.to_owned(),
        record.plane.to_owned(),
        format!("{0}x{0}", record.array),
        format!("{0}x{0}", record.size),
        tolerance_name(record.tolerance),
        record.cold.text(),
        record.new_plane.text(),
        record.new_drive.text(),
        format!("{:.1e}", record.error),
        record.evaluated.to_string(),
        record.gpu_ms.map_or("-".to_owned(), |ms| format!("{ms:.2}")),
        ratio(0),
        quartiles,
        ratio(1),
    ]
}

fn json(record: &Record) -> serde_json::Value {
    json!({
        "evaluator": record.evaluator,
        "plane": record.plane,
        "elements": record.array * record.array,
        "width": record.size,
        "height": record.size,
        "tolerance": record.tolerance,
        "cold": record.cold.json(),
        "new_plane": record.new_plane.json(),
        "new_drive": record.new_drive.json(),
        "error": record.error,
        "evaluated": record.evaluated,
        "gpu_ms": record.gpu_ms,
        "new_drive_ratio": record.ratios.map(|ratios| ratios[0].json()),
        "new_plane_ratio": record.ratios.map(|ratios| ratios[1].json()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_keep_their_tolerance_and_are_compared_with_the_exact_one() {
        let tolerances = vec![0.0, 1e-3];
        let group = Group { evaluator: "cpu", size: 160, array: 16, plane: "tilted", tolerances };
        let records = measure(&group).unwrap();
        assert!(records[0].error < 2e-5 && records[1].error < 1e-3, "{records:?}");
        assert!(records[1].evaluated < records[0].evaluated, "{records:?}");
        assert_eq!(records[0].ratios.unwrap()[0].quartiles, [1.0; 2]);
        assert!(records[1].ratios.unwrap()[0].median > 0.0, "{records:?}");
    }
}
