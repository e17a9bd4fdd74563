//! The argument `drive`: a solution, a motion, numbers per element, or a file of them.

use std::path::{Path, PathBuf};

use num_complex::Complex64;
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sonoglyph::drive::Drive;
use sonoglyph::scene::Scene;
use sonoglyph::studio::opening;

use crate::convert;
use crate::motion::Motion;
use crate::solution::Solution;

/// Drives in turn: of a solution, of all frames of a motion, or phases (rad) or complex excitations (of modulus 1 at most),
/// shape (elements,) or (drives, elements); or of a file, named relative to the folder.
///
/// # Errors
/// Another shape, numbers that are not finite, or errors of [`opening::read_drive`].
pub fn of(argument: &Bound<'_, PyAny>, scene: &Scene, folder: &Path) -> PyResult<Vec<Drive>> {
    let elements = scene.elements();
    if let Ok(path) = argument.extract::<PathBuf>() {
        let read = opening::read_drive(&folder.join(&path), path.display().to_string(), scene);
        let read = read.map_err(|error| PyValueError::new_err(format!("drive: {error}")))?;
        return Ok(read.table().map_or_else(Vec::new, |table| table.drives.clone()));
    }
    let drives = match (argument.cast::<Solution>(), argument.cast::<Motion>()) {
        (Ok(solution), _) => solution.get().solution.drives(),
        (_, Ok(motion)) => motion.get().drives(),
        (Err(_), Err(_)) => of_numbers(argument)?,
    };
    match drives.iter().find(|drive| drive.phases.len() != elements) {
        None => Ok(drives),
        Some(other) => Err(PyValueError::new_err(format!(
            "drive: it is of {} elements, and the scene has {elements}",
            other.phases.len()
        ))),
    }
}

fn of_numbers(argument: &Bound<'_, PyAny>) -> PyResult<Vec<Drive>> {
    /// Of a modulus in complex64.
    const ROUNDING: f64 = 1e-6;
    let array = argument.py().import("numpy")?.call_method1("atleast_2d", (argument,))?;
    let array = array.cast::<PyUntypedArray>()?;
    let &[_, elements] = array.shape() else {
        return Err(PyValueError::new_err("drive: an array of shape (elements,) or (drives, elements)"));
    };
    let kind: String = array.dtype().getattr("kind")?.extract()?;
    let drives: Vec<Drive> = if kind == "c" {
        let row = |row: &[Complex64]| Drive {
            amplitudes: row.iter().map(|u| u.norm()).collect(),
            phases: row.iter().map(|u| u.arg()).collect(),
        };
        convert::numbers::<Complex64>(array)?.chunks_exact(elements.max(1)).map(row).collect()
    } else {
        let row = |row: &[f64]| Drive { amplitudes: vec![1.0; row.len()], phases: row.to_vec() };
        convert::numbers::<f64>(array)?.chunks_exact(elements.max(1)).map(row).collect()
    };
    let is_played = |drive: &Drive| {
        drive.phases.iter().all(|phase| phase.is_finite())
            && drive.amplitudes.iter().all(|amplitude| (0.0..=1.0 + ROUNDING).contains(amplitude))
    };
    if drives.is_empty() || !drives.iter().all(is_played) {
        let what = "drive: phases must be finite, and excitations of modulus 1 at most";
        return Err(PyValueError::new_err(what));
    }
    let clamped = |mut drive: Drive| {
        drive.amplitudes.iter_mut().for_each(|amplitude| *amplitude = amplitude.min(1.0));
        drive
    };
    Ok(drives.into_iter().map(clamped).collect())
}
