//! The program's errors as Python exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use sonoglyph::field::GpuError as OfGpu;
use sonoglyph::scene::KeyError;
use sonoglyph::scene::file::FileError;
use sonoglyph::solver::SolveError;

create_exception!(
    sonoglyph,
    SceneError,
    PyValueError,
    "A scene that makes no sense; `key` names the value, as in `target[1].radius`, or is None."
);
create_exception!(sonoglyph, FieldError, PyValueError, "A map or a volume that makes no sense.");
create_exception!(
    sonoglyph,
    GpuError,
    PyRuntimeError,
    "There is no GPU, or it was lost or refused the work."
);

/// A `SceneError` with its key.
fn scene(key: Option<&str>, message: String) -> PyErr {
    let error = SceneError::new_err(message);
    Python::attach(|py| match error.value(py).setattr("key", key) {
        Ok(()) => error,
        Err(failed) => failed,
    })
}

pub fn of_key(error: &KeyError) -> PyErr {
    scene(Some(&error.key()), error.to_string())
}

/// The error of a scene without a file, so without file name and line.
pub fn of_values(error: &FileError) -> PyErr {
    match error {
        FileError::Read { .. } => of_file(error),
        FileError::Syntax { key, message, .. } => {
            let named = key.as_ref().filter(|key| !message.contains(&format!("`{key}`")));
            let text = named.map_or_else(|| message.clone(), |key| format!("{key}: {message}"));
            scene(key.as_deref(), text)
        }
        FileError::Value { key, value, message, .. } => {
            let value = value.as_ref().map_or_else(String::new, |value| format!(" = {value}"));
            scene(Some(key), format!("{key}{value}: {message}"))
        }
    }
}

pub fn of_file(error: &FileError) -> PyErr {
    match error {
        FileError::Read { cause, .. } => match cause.kind() {
            std::io::ErrorKind::NotFound => pyo3::exceptions::PyFileNotFoundError::new_err(error.to_string()),
            _ => pyo3::exceptions::PyOSError::new_err(error.to_string()),
        },
        FileError::Syntax { key, .. } => scene(key.as_deref(), error.to_string()),
        FileError::Value { key, .. } => scene(Some(key), error.to_string()),
    }
}

pub fn of_solving(error: &SolveError) -> PyErr {
    match error {
        SolveError::Scene(error) => of_key(error),
        SolveError::SeveralFoci(_) => scene(Some("solver.method"), error.to_string()),
        SolveError::Skin(_) => scene(Some("solver.target"), error.to_string()),
        SolveError::Cancelled => pyo3::exceptions::PyKeyboardInterrupt::new_err(error.to_string()),
        SolveError::TooLarge { .. } => pyo3::exceptions::PyMemoryError::new_err(error.to_string()),
    }
}

pub fn of_field(error: &sonoglyph::field::FieldError) -> PyErr {
    match error {
        sonoglyph::field::FieldError::Gpu(error) => of_gpu(error),
        other => FieldError::new_err(other.to_string()),
    }
}

pub fn of_gpu(error: &OfGpu) -> PyErr {
    GpuError::new_err(error.to_string())
}
