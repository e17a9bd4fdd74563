//! The class `Solution`: a drive, its foci and its figures.

use std::sync::{Arc, OnceLock};

use numpy::{Complex64 as Complex, IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::Value;
use sonoglyph::acoustics::{Aperture, response::responding};
use sonoglyph::scene::{self, ElementModel};
use sonoglyph::solver::{self, Limits, Problem, room};
use sonoglyph::studio::bodies;
use sonoglyph::studio::felt::{Felt, Unknown};
use sonoglyph::studio::json;
use sonoglyph::studio::nonlinear::Nonlinear;

use crate::convert;
use crate::error;
use crate::map::Map;
use crate::scene::{Pixels, Scene};
use crate::work;

/// The function and arguments that rebuild a pickled solution.
type Pickled<'py> = (Bound<'py, PyAny>, (Py<Scene>, Bound<'py, PyBytes>));

/// The result of `Scene.solve`: the drive and its figures.
///
/// As a `drive` of other calls it is played unchanged; several drives (`solver.frames`) are played in turn.
#[pyclass(frozen, module = "sonoglyph")]
#[derive(Debug)]
pub struct Solution {
    pub solution: Arc<solver::Solution>,
    pub scene: Py<Scene>,
    /// Computed on demand: the limits of foci and array take as long as the solution itself.
    quality: OnceLock<Value>,
    /// Likewise.
    felt: OnceLock<Value>,
}

/// Solves a scene.
///
/// # Errors
/// Those of the solver, and of [`work::run`].
pub fn solved(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    scene: Arc<scene::Scene>,
) -> PyResult<solver::Solution> {
    let is_brief = is_brief(&scene);
    let solved = work::run(py, progress, is_brief, move |_| solver::solve(&scene))?;
    solved.map_err(|error| error::of_solving(&error))
}

/// Whether a scene is surely solved within [`work::BRIEF`]: few points for a usual array.
fn is_brief(scene: &scene::Scene) -> bool {
    const FEW: usize = 16;
    const MOST_PAIRS: usize = 1 << 14;
    let scene::Solver { iterations, search, frames, .. } = scene.solver;
    let points = scene.targets.len();
    points <= FEW
        && points * scene.elements() <= MOST_PAIRS
        && scene.targets.iter().all(|target| target.shape.is_point())
        && (scene.quiet.is_empty() && scene.reflectors.is_empty() && !scene.aims_at_depression())
        && (iterations <= 100 && search == 0.0 && !frames.are_several())
        && scene.array.element != ElementModel::ExactPiston
}

impl Solution {
    pub fn new(solution: Arc<solver::Solution>, scene: Py<Scene>) -> Self {
        Self { solution, scene, quality: OnceLock::new(), felt: OnceLock::new() }
    }

    fn judged(&self) -> PyResult<Value> {
        let scene = &self.scene.get().scene;
        let mut solution = (*self.solution).clone();
        if solution.foci.is_empty() {
            return Ok(json::solution(&solution, None)["quality"].take());
        }
        let _room = room::of_limits(scene, solution.foci.len()).map_err(|error| error::of_solving(&error))?;
        let aperture = Aperture::new(scene);
        let problem = Problem::of_scene(scene, &aperture, solution.foci.clone());
        solution.judge(scene, &problem);
        Ok(json::solution(&solution, Some(&Limits::new(&problem)))["quality"].take())
    }
}

#[pymethods]
impl Solution {
    /// Phases, rad, in (-π, π]; float64, shape (elements,).
    #[getter]
    fn phases<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.solution.drive.phases)
    }

    /// Amplitudes, 0 to 1; float64, shape (elements,).
    #[getter]
    fn amplitudes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.solution.drive.amplitudes)
    }

    /// u = amplitude · exp(j phase) of all drives in turn; complex128, shape (drives, elements).
    #[getter]
    fn excitations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<Complex>>> {
        let drives = self.solution.drives();
        let polar = |(&amplitude, &phase): (&f64, &f64)| Complex::from_polar(amplitude, phase);
        let all: Vec<_> =
            drives.iter().flat_map(|drive| drive.amplitudes.iter().zip(&drive.phases).map(polar)).collect();
        let elements = all.len() / drives.len();
        all.into_pyarray(py).reshape([drives.len(), elements])
    }

    /// Focal points, m, of directions unit vectors; float64, shape (foci, 3).
    #[getter]
    fn foci<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let foci = &self.solution.foci;
        let places: Vec<_> = foci.iter().flat_map(|focus| focus.position.to_array()).collect();
        places.into_pyarray(py).reshape([foci.len(), 3])
    }

    /// Target pressures: ratios, or Pa (peak) with `solver.pressures = "pascal"`; float64, shape (foci,).
    #[getter]
    fn targets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.solution.foci.iter().map(|focus| focus.target).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Complex pressures at the focal points, Pa (peak); complex128, shape (foci,).
    #[getter]
    fn pressures<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex>> {
        PyArray1::from_slice(py, &self.solution.pressures)
    }

    /// The figures that `sonoglyph solve --json` writes under `quality`, as a dictionary: pressures in Pa (peak), the rest fractions.
    #[getter]
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if self.quality.get().is_none() {
            // Another thread may have stored it first.
            let _ = self.quality.set(py.detach(|| self.judged())?);
        }
        convert::python(py, self.quality.get().unwrap_or(&Value::Null))
    }

    /// The figures beyond linear theory that `sonoglyph solve --json` writes under `nonlinear`, as a dictionary; `None` without
    /// sound at foci, and with reflectors that are not rigid.
    #[getter]
    fn nonlinear<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let scene = &self.scene.get().scene;
        let found = py.detach(|| Nonlinear::of_solution(scene, &Aperture::new(scene), &self.solution));
        convert::python(py, &found.map_or(Value::Null, |found| json::nonlinear(&found)))
    }

    /// The bodies as `sonoglyph solve --json` writes them under `bodies`, a dictionary each: `force` (N), `torque` (N m, about
    /// `at`), `error` of the sound that it scatters, `triangles` (0 of a sphere).
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let scene = &self.scene.get().scene;
        let all = py.detach(|| {
            let drives = responding(scene, self.solution.drives(), false);
            bodies::json(&bodies::pushed(scene, &Aperture::new(scene), &drives))
        });
        convert::python(py, &all)
    }

    /// What a hand feels, as `sonoglyph solve --json` writes it under `felt`, as a dictionary: levels in dB over threshold; `None`
    /// for scenes without a skin.
    #[getter]
    fn felt<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let scene = &self.scene.get().scene;
        if scene.skin.is_none() {
            return Ok(None);
        }
        if self.felt.get().is_none() {
            let felt =
                py.detach(|| Felt::of_solution(scene, &self.solution)).map_err(|error| match error {
                    Unknown::Solve(error) => error::of_solving(&error),
                    Unknown::Field(error) => error::of_field(&error),
                })?;
            // Another thread may have stored it first.
            let _ = self.felt.set(felt.json());
        }
        self.felt.get().map(|felt| convert::python(py, felt)).transpose()
    }

    /// The method's name, or `drive` if the scene names a file of drives.
    #[getter]
    fn method(&self) -> &'static str {
        self.solution.method_name()
    }

    #[getter]
    fn iterations(&self) -> u32 {
        self.solution.iterations
    }

    /// Time spent in the method, s.
    #[getter]
    fn seconds(&self) -> f64 {
        self.solution.seconds
    }

    /// Warnings about the drive, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.solution.warnings.iter().map(ToString::to_string).collect()
    }

    /// The solved scene.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// `Scene.map` of this drive.
    #[pyo3(signature = (quantity="rms", size=None, *, evaluator="auto", tolerance=None, progress=None))]
    fn map(
        slf: &Bound<'_, Self>,
        quantity: &str,
        size: Option<Pixels>,
        evaluator: &str,
        tolerance: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Map> {
        let scene = slf.get().scene.bind(slf.py());
        Scene::map(scene, quantity, size, Some(slf.as_any()), evaluator, tolerance, progress)
    }

    /// `Scene.field` of this drive.
    #[pyo3(signature = (quantity="rms", size=None, *, evaluator="auto", tolerance=None, progress=None))]
    fn field<'py>(
        slf: &Bound<'py, Self>,
        quantity: &str,
        size: Option<Pixels>,
        evaluator: &str,
        tolerance: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        Self::map(slf, quantity, size, evaluator, tolerance, progress)?.into_values(slf.py())
    }

    fn __repr__(&self) -> String {
        let quality = &self.solution.quality;
        let warnings = match self.solution.warnings.len() {
            0 => String::new(),
            1 => ", 1 warning".to_owned(),
            count => format!(", {count} warnings"),
        };
        format!(
            "<sonoglyph.Solution by {}: {} foci, mean {:.0} Pa, least {:.0} Pa (peak), {} elements, {:.1} ms{warnings}>",
            self.solution.method_name(),
            self.solution.foci.len(),
            quality.mean_pressure,
            quality.min_pressure,
            self.solution.drive.phases.len(),
            self.solution.seconds * 1e3,
        )
    }

    /// The picture in notebooks: the RMS pressure on the scene's plane.
    fn _repr_png_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyBytes>> {
        let map = Self::map(slf, "rms", Some(Pixels::Width(360)), "auto", None, None)?;
        map.png(slf.py(), "inferno")
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Pickled<'py>> {
        let this = slf.get();
        let packed = postcard::to_allocvec(&*this.solution);
        let packed = packed.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let build = slf.get_type().getattr("_of_bytes")?;
        Ok((build, (this.scene.clone_ref(slf.py()), PyBytes::new(slf.py(), &packed))))
    }

    #[staticmethod]
    fn _of_bytes(scene: Py<Scene>, bytes: &[u8]) -> PyResult<Self> {
        let solution = postcard::from_bytes(bytes);
        let solution = solution.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Self::new(Arc::new(solution), scene))
    }
}
