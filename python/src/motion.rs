//! The drives of all frames of a motion.

use std::sync::Arc;

use numpy::{Complex64 as Complex, IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use sonoglyph::drive::Drive;
use sonoglyph::solver::frames::{Frame, Sequence};
use sonoglyph::studio::response::Moving;

use crate::convert;

/// The drives of all frames of a motion: the result of `Scene.frames`. As a `drive` of other calls it stands for the mean over all frames.
#[pyclass(frozen, module = "sonoglyph")]
#[derive(Debug)]
pub struct Motion {
    sequence: Arc<Sequence>,
    /// Frames per second; 0 for a scene at rest.
    rate: f64,
    moving: Option<Moving>,
}

impl Motion {
    pub fn new(sequence: Arc<Sequence>, rate: f64, moving: Option<Moving>) -> Self {
        Self { sequence, rate, moving }
    }

    pub fn drives(&self) -> Vec<Drive> {
        self.sequence.frames.iter().map(|frame| frame.drive.clone()).collect()
    }

    fn table<'py>(
        &self,
        py: Python<'py>,
        row: impl Fn(&Drive) -> &[f64],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let frames = &self.sequence.frames;
        let all: Vec<f64> = frames.iter().flat_map(|frame| row(&frame.drive).iter().copied()).collect();
        let elements = all.len() / frames.len().max(1);
        all.into_pyarray(py).reshape([frames.len(), elements])
    }
}

#[pymethods]
impl Motion {
    /// Phases, rad; float64, shape (frames, elements).
    #[getter]
    fn phases<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |drive| &drive.phases)
    }

    /// Amplitudes, 0 to 1; float64, shape (frames, elements).
    #[getter]
    fn amplitudes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |drive| &drive.amplitudes)
    }

    /// When each frame begins, s; float64, shape (frames,).
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let seconds = |frame| if self.rate > 0.0 { f64::from(frame) / self.rate } else { 0.0 };
        (0..self.sequence.frames.len() as u32).map(seconds).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Focal points of every frame, m, of directions unit vectors: a list of float64, shape (foci, 3).
    #[getter]
    fn foci<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        let places = |frame: &Frame| {
            let all: Vec<_> = frame.foci.iter().flat_map(|focus| focus.position.to_array()).collect();
            all.into_pyarray(py).reshape([frame.foci.len(), 3])
        };
        self.sequence.frames.iter().map(places).collect()
    }

    /// Complex pressures at the focal points of every frame, Pa (peak): a list of complex128, shape (foci,).
    #[getter]
    fn pressures<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray1<Complex>>> {
        self.sequence.frames.iter().map(|frame| PyArray1::from_slice(py, &frame.pressures)).collect()
    }

    /// Frames per second; 0 for a scene at rest.
    #[getter]
    fn rate(&self) -> f64 {
        self.rate
    }

    /// What elements with a response keep of the pressure, as `sonoglyph solve --motion --json` writes it: a dictionary, or None.
    #[getter]
    fn response<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.moving.map(|moving| convert::python(py, &moving.json())).transpose()
    }

    /// Time spent on finding all drives, s.
    #[getter]
    fn seconds(&self) -> f64 {
        self.sequence.seconds
    }

    fn __len__(&self) -> usize {
        self.sequence.frames.len()
    }

    fn __repr__(&self) -> String {
        let count = self.sequence.frames.len();
        format!("<sonoglyph.Motion: {count} frames, {:.1} per second>", self.rate)
    }
}
