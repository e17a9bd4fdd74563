//! One line of a batch: solves its scene, computes limits and field, and forms the answer as JSON.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};

use anyhow::{Context, anyhow, bail};
use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::cli::batch::lines::Line;
use crate::drive::Drive;
use crate::echo;
use crate::field::{Map, Quantity, Request, Samples, Stages};
use crate::picture::numbers;
use crate::scene::{FORMAT, Method, Scene, file};
use crate::solver;
use crate::studio::findings::Findings;
use crate::studio::output::Files;
use crate::studio::{json, opening, output};

/// Limit of a field's pixels along y.
const MOST_ROWS: usize = 1 << 14;

/// Options of a batch.
#[derive(Debug)]
pub struct Task {
    /// Instead of the scene's.
    pub method: Option<Method>,
    /// Whether answers have figures besides the drive: bound, side lobe, widths and traps.
    pub limits: bool,
    /// Whether answers have statistics of the pressure on the scene's plane.
    pub field: bool,
    /// Folder for the values of fields.
    pub data: Option<PathBuf>,
    /// Pixels of a field along x.
    pub size: usize,
    /// Standard input and output, and the files named by lines so far.
    pub(super) files: Mutex<Files>,
    /// Held as a reader while a file is written.
    pub(super) writing: RwLock<()>,
}

impl Default for Task {
    /// Drives and limits, without fields.
    fn default() -> Self {
        let (files, writing) = (Mutex::default(), RwLock::default());
        Self { method: None, limits: true, field: false, data: None, size: 256, files, writing }
    }
}

impl Task {
    /// The answer to a line: [`Findings::json`] or an `error`, with the line's number and `id`.
    pub fn answer(&self, line: &Line, stages: &mut Stages) -> Value {
        let mut id = None;
        let mut answer = self.result(line, &mut id, stages).unwrap_or_else(
            |error| json!({ "error": echo::message(&format!("line {}: {error:#}", line.number)) }),
        );
        answer["line"] = line.number.into();
        if let Some(id) = id {
            answer["id"] = id;
        }
        answer
    }

    fn files(&self) -> MutexGuard<'_, Files> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Also sets `id`, even if the scene is invalid.
    fn result(&self, line: &Line, id: &mut Option<Value>, stages: &mut Stages) -> anyhow::Result<Value> {
        let text = line.text.as_ref().map_err(|error| anyhow!(error.clone()))?;
        if text.trim().is_empty() {
            bail!("the line is blank: a scene is an object, {{…}}");
        }
        // The line number is that of the input, not of its JSON, which has a single line.
        let misplaced = |error: serde_json::Error| {
            anyhow!(format!("invalid JSON: {error}").replace("line 1 column", "column"))
        };
        let mut tables: Value = serde_json::from_str(text.trim_end()).map_err(misplaced)?;
        let Some(keys) = tables.as_object_mut() else { bail!("a scene is an object, {{…}}") };
        *id = keys.remove("id");
        keys.entry("format").or_insert_with(|| FORMAT.into());
        let mut scene = file::from_tables(tables)?;
        opening::load(&mut scene, Path::new(""))?;
        self.files().reads_files_of(&scene)?;
        if let Some(method) = self.method {
            scene.solve_by(method);
        }
        let (solution, aperture) = (solver::solve(&scene)?, Aperture::new(&scene));
        let drives = solution.drives();
        let has_field = self.field || self.data.is_some();
        let (mut answer, warnings) = if self.limits {
            let findings = Findings::of_scene(&scene, stages, solution)?;
            (findings.json(&aperture), findings.warnings)
        } else {
            let mut answer = json::solution(&solution, None);
            if has_field {
                json::add_widths(&mut answer, &aperture, &solution);
            }
            (answer, solution.warnings.iter().map(ToString::to_string).collect())
        };
        if !warnings.is_empty() {
            answer["warnings"] = json!(warnings);
        }
        if has_field {
            answer["field"] = self.field(line.number, &scene, drives, stages)?;
        }
        Ok(answer)
    }

    /// Statistics of the RMS pressure on the scene's plane, and the file of its values.
    fn field(
        &self,
        number: u64,
        scene: &Scene,
        drives: Vec<Drive>,
        stages: &mut Stages,
    ) -> anyhow::Result<Value> {
        let shape = scene.plane.size.y / scene.plane.size.x;
        let (width, height) = (self.size, ((self.size as f64 * shape).round() as usize).clamp(1, MOST_ROWS));
        let request = Request::new(scene, drives, Quantity::Rms, (width, height));
        let Map { values: rms, peak, loudest, error, within, .. } = stages.map(&request)?;
        let at = rms.iter().position(|value| value == peak).unwrap_or(0);
        let outside = rms.iter().filter(|p| !p.is_nan()).map(|&p| f64::from(p).powi(2));
        let mean_square = outside.sum::<f64>() / (rms.len() - within).max(1) as f64;
        let place = Samples::on_plane(&scene.plane, width, height).context("no plane")?.point(at);
        let mut statistics = json!({
            "peak": peak, "at": place.to_array(), "loudest": loudest, "rms": mean_square.sqrt(),
            "error": error, "width": width, "height": height,
        });
        if let Some(folder) = &self.data {
            let path = folder.join(format!("{number}.npy"));
            self.files().spares(&path)?;
            let _writing = self.writing.read().unwrap_or_else(PoisonError::into_inner);
            output::write(&path, &numbers::npy(&[height as u64, width as u64], rms)?)?;
            statistics["file"] = json!(path);
        }
        Ok(statistics)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::SQRT_2;

    use super::*;
    use crate::field::Evaluator;

    fn answer(task: &Task, number: u64, text: &str) -> Value {
        task.answer(&Line { number, text: Ok(text.to_owned()) }, &mut Stages::new(Evaluator::Cpu))
    }

    #[test]
    fn an_invalid_line_is_answered_with_its_number_and_error() {
        for (text, part) in [
            (r#"{"target": [{"kind": "point", "at": [0, 0, -1]}]}"#, "target[1]: the focal point"),
            (r#"{"colour": 3}"#, "unknown field `colour`"),
            ("[1, 2\n", "invalid JSON: EOF while parsing a list at column 5"),
            ("[]", "a scene is an object"),
            (r#"{"array": {"pitch": 1e999}}"#, "invalid JSON"),
            (r#"{"format": 2}"#, "format: this program reads format 1"),
            (r#"{"format": 1}"#, "target: the scene has no target"),
        ] {
            let answer = answer(&Task::default(), 7, text);
            let error = answer["error"].as_str().unwrap();
            assert!(error.starts_with("line 7: ") && error.contains(part), "{error}: {part}");
            assert_eq!((answer["line"].as_u64(), answer.get("id")), (Some(7), None));
        }
        let unread = Line { number: 2, text: Err("not UTF-8".to_owned()) };
        let answer = Task::default().answer(&unread, &mut Stages::new(Evaluator::Cpu));
        assert_eq!(answer, json!({ "line": 2, "error": "line 2: not UTF-8" }));
    }

    #[test]
    fn an_id_of_any_type_is_returned() {
        for id in ["7", "\"left\"", "null", "[1,{\"a\":2.5}]"] {
            for scene in ["\"target\": [{}]", "\"target\": []", "\"colour\": 3"] {
                let answer = answer(&Task::default(), 1, &format!("{{\"id\": {id}, {scene}}}"));
                assert_eq!(answer["id"].to_string(), id, "{scene}");
                assert_eq!(answer.get("error").is_none(), scene.contains("{}"), "{answer}");
            }
        }
    }

    #[test]
    fn numbers_round_trip_exactly() {
        for z in [0.10188148857674413, 0.16794522192953779, 0.11442885696676837] {
            let answer = answer(&Task::default(), 1, &format!("{{\"target\": [{{\"at\": [0, 0, {z:?}]}}]}}"));
            let again: Value = serde_json::from_str(&answer.to_string()).unwrap();
            assert_eq!(again["foci"][0]["position"][2], z);
        }
    }

    #[test]
    fn the_field_of_a_single_focus_peaks_at_it() {
        let folder = tempfile::tempdir().unwrap();
        let task = Task { data: Some(folder.path().to_owned()), size: 101, ..Task::default() };
        let text =
            r#"{"target": [{"kind": "point", "at": [0.01, -0.02, 0.1]}], "plane": {"size": [0.1, 0.2]}}"#;
        let answer = answer(&task, 1, text);
        let field = &answer["field"];
        let pressure = answer["foci"][0]["pressure"].as_f64().unwrap() / SQRT_2;
        assert!((field["peak"].as_f64().unwrap() / pressure - 1.0).abs() < 0.02, "{field} {pressure}");
        let at: Vec<_> = field["at"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        assert!((at[0] - 0.01).abs() < 0.002 && (at[1] + 0.02).abs() < 0.002 && (at[2] - 0.1).abs() < 0.003);
        assert_eq!((field["width"].as_u64(), field["height"].as_u64()), (Some(101), Some(202)));
        let bytes = std::fs::read(folder.path().join("1.npy")).unwrap();
        assert!(bytes.len() > 4 * 101 * 202);
    }

    #[test]
    fn an_unwritable_file_is_an_error_of_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let task = Task { data: Some(folder.path().join("gone")), size: 8, ..Task::default() };
        let error = answer(&task, 3, r#"{"target": [{}]}"#)["error"].to_string();
        assert!(
            error.contains("line 3: ") && error.contains("3.npy: cannot write: its folder is not there"),
            "{error}"
        );
    }
}
