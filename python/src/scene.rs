//! The class `Scene`, and the computations on it.

#![expect(clippy::needless_pass_by_value, reason = "paths come as values from Python")]

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec3, UVec3};
use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyType};
use rayon::prelude::*;
use serde_json::Value;
use sonoglyph::acoustics::{Aperture, response::responding};
use sonoglyph::drive::Drive;
use sonoglyph::field::Request;
use sonoglyph::field::volume::{Block, Lattice, MOST_POINTS, MOST_POINTS_ALONG};
use sonoglyph::force::Levitation;
use sonoglyph::gauge::Gauge;
use sonoglyph::scene::{self, DriveFile, DriveTable, FORMAT, Method, file, motion};
use sonoglyph::solver::{self, frames};
use sonoglyph::studio::response::Moving;
use sonoglyph::studio::{bodies, opening, output, probe, reach, space};
use strum::VariantNames;

use crate::convert::{places, rows};
use crate::evaluator::Cached;
use crate::map::{self, Map};
use crate::motion::Motion;
use crate::solution::{self, Solution};
use crate::{convert, drives, error, evaluator, work};

/// Pixels of a map along x, unless its size is given.
const WIDTH: usize = 256;

/// Width, or width and height.
#[derive(Clone, Copy, Debug, FromPyObject)]
pub enum Pixels {
    Width(usize),
    Both((usize, usize)),
}

/// A scene: targets, array, medium, plane, liquid and motion, in SI units. Immutable: `replace` makes a changed copy.
///
/// The keyword arguments are the tables of a scene file: dictionaries, or the package's classes (`Array`, `Plane`, ...); `target`,
/// `board`, `reflector`, `body` and `quiet` take lists of them, also as `targets`, `boards`, `reflectors`, `bodies`. Files named
/// by the scene are relative to `folder`, by default the current one.
#[pyclass(frozen, eq, module = "sonoglyph")]
#[derive(Debug)]
pub struct Scene {
    pub scene: Arc<scene::Scene>,
    folder: PathBuf,
    /// The drive of the scene itself, computed on demand.
    own: Mutex<Option<Arc<solver::Solution>>>,
}

impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        self.scene == other.scene
    }
}

impl Scene {
    fn new(scene: scene::Scene, folder: PathBuf) -> Self {
        Self { scene: Arc::new(scene), folder, own: Mutex::new(None) }
    }

    /// From the tables of a scene file.
    fn of_tables(mut tables: Value, folder: PathBuf) -> PyResult<Self> {
        if let Some(keys) = tables.as_object_mut() {
            *keys = std::mem::take(keys).into_iter().map(|(key, value)| (singular(key), value)).collect();
            keys.entry("format").or_insert_with(|| FORMAT.into());
        }
        let text = toml::to_string(&tables).map_err(|error| PyValueError::new_err(error.to_string()))?;
        Self::of_text(&text, folder)
    }

    fn of_text(text: &str, folder: PathBuf) -> PyResult<Self> {
        let scene = opening::parse(text, &folder.join("scene")).map_err(|error| error::of_values(&error))?;
        Ok(Self::new(scene, folder))
    }

    fn tables(&self) -> PyResult<Value> {
        let text = file::write(&self.scene);
        toml::from_str(&text).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The drives to play: the given ones, or the scene's own, of all frames if `frames`.
    fn played(
        slf: &Bound<'_, Self>,
        drive: Option<&Bound<'_, PyAny>>,
        frames: bool,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Drive>> {
        let this = slf.get();
        if let Some(drive) = drive {
            return drives::of(drive, &this.scene, &this.folder);
        }
        if frames && motion::moves(&this.scene) {
            return Ok(Self::frames(slf, progress)?.drives());
        }
        let known = this.own.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let solution = match known {
            Some(solution) => solution,
            None => {
                let scene = Arc::clone(&this.scene);
                let solution = Arc::new(solution::solved(slf.py(), progress, scene)?);
                *this.own.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&solution));
                solution
            }
        };
        Ok(solution.drives())
    }

    fn request(
        slf: &Bound<'_, Self>,
        quantity: &str,
        drive: Option<&Bound<'_, PyAny>>,
        tolerance: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Request> {
        let quantity = map::quantity(quantity)?;
        let drives = Self::played(slf, drive, quantity.declaration().is_slow, progress)?;
        let mut request = Request::new(&slf.get().scene, drives, quantity, (1, 1));
        if let Some(tolerance) = tolerance {
            request.plane.tolerance = tolerance;
        }
        Ok(request)
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (*, folder=None, **tables))]
    fn of_keywords(folder: Option<PathBuf>, tables: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let tables = tables.map_or(Ok(Value::Object(Default::default())), |tables| convert::plain(tables))?;
        Self::of_tables(tables, folder.unwrap_or_default())
    }

    /// The scene of a TOML file.
    #[classmethod]
    fn load(_: &Bound<'_, PyType>, path: PathBuf) -> PyResult<Self> {
        let scene = opening::open(&path).map_err(|error| error::of_file(&error))?;
        Ok(Self::new(scene, path.parent().map(PathBuf::from).unwrap_or_default()))
    }

    /// The scene of a TOML text; files named by it are relative to `folder`.
    #[classmethod]
    #[pyo3(signature = (text, folder=None))]
    fn loads(_: &Bound<'_, PyType>, text: &str, folder: Option<PathBuf>) -> PyResult<Self> {
        Self::of_text(text, folder.unwrap_or_default())
    }

    /// The scene of the tables of a file as dictionaries and lists, as `to_dict` returns them.
    #[classmethod]
    #[pyo3(signature = (tables, folder=None))]
    fn from_dict(
        _: &Bound<'_, PyType>,
        tables: &Bound<'_, PyAny>,
        folder: Option<PathBuf>,
    ) -> PyResult<Self> {
        Self::of_tables(convert::plain(tables)?, folder.unwrap_or_default())
    }

    /// The scene as the text of a TOML file.
    fn dumps(&self) -> String {
        file::write(&self.scene)
    }

    /// Writes the scene to a TOML file, atomically.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        output::write(&path, file::write(&self.scene).as_bytes())
            .map_err(|error| PyOSError::new_err(format!("{error:#}")))
    }

    /// The tables of the scene file, defaults included.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::python(py, &self.tables()?)
    }

    /// A changed copy of the scene. A table, given as a dictionary or class, replaces its own keys and keeps the others.
    #[pyo3(signature = (**tables))]
    fn replace(&self, tables: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut all = self.tables()?;
        let new = tables.map_or(Ok(Value::Null), |tables| convert::plain(tables))?;
        if let (Some(all), Value::Object(new)) = (all.as_object_mut(), new) {
            for (key, value) in new {
                let key = singular(key);
                match (all.get_mut(&key).and_then(Value::as_object_mut), value) {
                    (Some(before), Value::Object(values)) => before.extend(values),
                    (_, value) => {
                        all.insert(key, value);
                    }
                }
            }
        }
        Self::of_tables(all, self.folder.clone())
    }

    /// The positions of all elements, m; float64, shape (elements, 3).
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &Aperture::new(&self.scene).positions)
    }

    /// The directions of radiation of all elements; float64, shape (elements, 3).
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &Aperture::new(&self.scene).normals)
    }

    /// The wavelength of the carrier, m.
    #[getter]
    fn wavelength(&self) -> f64 {
        self.scene.wavelength()
    }

    /// Warnings about targets out of the array's reach, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        reach::of_targets(&self.scene).iter().map(ToString::to_string).collect()
    }

    /// Finds the drive.
    ///
    /// `method` (the scene's own by default): focus, pinv, weighted, naive, gs, gspat, wgs, greedy or best. `search`: time of a further search, s.
    /// With a `drive`, as of `field`, nothing is solved: the result has its figures.
    #[pyo3(signature = (method=None, *, drive=None, search=None, progress=None))]
    fn solve(
        slf: &Bound<'_, Self>,
        method: Option<&str>,
        drive: Option<&Bound<'_, PyAny>>,
        search: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Solution> {
        let mut scene = Arc::clone(&slf.get().scene);
        if let Some(drive) = drive {
            if method.is_some() || search.is_some() {
                return Err(PyValueError::new_err("drive: nothing is solved: leave method and search out"));
            }
            let drives = drives::of(drive, &scene, &slf.get().folder)?;
            let table = DriveTable { drives, rate: None, left_out: 0 };
            Arc::make_mut(&mut scene).drive = DriveFile::new("drive".to_owned(), table, None);
        }
        if let Some(name) = method {
            let method = name.parse().map_err(|_| {
                let names = Method::VARIANTS.join(", ");
                PyValueError::new_err(format!("method = {name:?}: must be one of {names}"))
            })?;
            Arc::make_mut(&mut scene).solve_by(method);
        }
        if let Some(search) = search {
            Arc::make_mut(&mut scene).solver.search = search;
            scene::check::check(&scene).map_err(|error| error::of_key(&error))?;
        }
        let solution = solution::solved(slf.py(), progress, scene)?;
        Ok(Solution::new(Arc::new(solution), slf.clone().unbind()))
    }

    /// A quantity on the scene's plane: float32, shape (H, W), row 0 at the smallest y, samples at pixel centres.
    ///
    /// `quantity`: rms (Pa), phase (rad), depression (m), radiation (Pa), intensity (W/m²), force (N), ... as the command line has
    /// them. `size`: W, or (W, H). `drive`: a `Solution`, a `Motion`, phases (rad) or complex excitations, shape (elements,) or (drives,
    /// elements); by default the scene's own. `evaluator`: auto, gpu, cpu or reference. `tolerance`: largest error relative to
    /// the peak, instead of the plane's.
    #[pyo3(signature = (quantity="rms", size=None, drive=None, *, evaluator="auto", tolerance=None, progress=None))]
    fn field<'py>(
        slf: &Bound<'py, Self>,
        quantity: &str,
        size: Option<Pixels>,
        drive: Option<&Bound<'_, PyAny>>,
        evaluator: &str,
        tolerance: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        Self::map(slf, quantity, size, drive, evaluator, tolerance, progress)?.into_values(slf.py())
    }

    /// Like `field`, with peak, error and extent.
    #[pyo3(signature = (quantity="rms", size=None, drive=None, *, evaluator="auto", tolerance=None, progress=None))]
    pub fn map(
        slf: &Bound<'_, Self>,
        quantity: &str,
        size: Option<Pixels>,
        drive: Option<&Bound<'_, PyAny>>,
        evaluator: &str,
        tolerance: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Map> {
        let backend = evaluator::named(evaluator)?;
        let mut request = Self::request(slf, quantity, drive, tolerance, progress)?;
        request.size = match size {
            Some(Pixels::Both(size)) => size,
            size => {
                let width = if let Some(Pixels::Width(width)) = size { width } else { WIDTH };
                let shape = request.plane.size.y / request.plane.size.x;
                (width, ((width as f64 * shape).round() as usize).max(1))
            }
        };
        let (quantity, plane) = (request.quantity, request.plane.clone());
        let evaluator = Cached::take(backend);
        let is_brief = evaluator.is_brief(&request);
        let memory = map::memory(request.size);
        let map = move |gauge: &Gauge| evaluator.map(&request, memory, gauge);
        Map::new(slf.py(), quantity, plane, work::run(slf.py(), progress, is_brief, map)??)
    }

    /// The depression of the liquid's surface on the scene's plane, m, positive downwards: `field("depression")`.
    #[pyo3(signature = (size=None, drive=None, *, evaluator="auto", tolerance=None, progress=None))]
    fn depression<'py>(
        slf: &Bound<'py, Self>,
        size: Option<Pixels>,
        drive: Option<&Bound<'_, PyAny>>,
        evaluator: &str,
        tolerance: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        Self::field(slf, "depression", size, drive, evaluator, tolerance, progress)
    }

    /// A quantity in a box, sampled at the centres of NX x NY x NZ equal cells: float32, shape (NZ, NY, NX).
    ///
    /// `box`: two opposite corners, m; by default a box around the scene.
    #[pyo3(signature = (counts, quantity="rms", r#box=None, drive=None, *, evaluator="auto", tolerance=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments")]
    fn volume<'py>(
        slf: &Bound<'py, Self>,
        counts: [u32; 3],
        quantity: &str,
        r#box: Option<[[f64; 3]; 2]>,
        drive: Option<&Bound<'_, PyAny>>,
        evaluator: &str,
        tolerance: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let backend = evaluator::named(evaluator)?;
        let mut request = Self::request(slf, quantity, drive, tolerance, progress)?;
        if request.quantity.declaration().of_liquid {
            return Err(PyValueError::new_err(format!("quantity = {quantity:?}: it has no volume")));
        }
        let points = counts.iter().map(|&count| u64::from(count)).product::<u64>();
        if counts.iter().any(|&count| !(1..=MOST_POINTS_ALONG).contains(&count)) || points > MOST_POINTS {
            return Err(PyValueError::new_err(format!(
                "counts = {counts:?}: from 1 to {MOST_POINTS_ALONG} along an axis, and at most {MOST_POINTS} in all"
            )));
        }
        let scene = Arc::clone(&slf.get().scene);
        let block = match r#box {
            Some([a, b]) => {
                let (a, b) = (DVec3::from_array(a), DVec3::from_array(b));
                if !((a - b).is_finite() && (a - b).abs().min_element() > 0.0) {
                    return Err(PyValueError::new_err(
                        "box: two opposite corners, metres apart along every axis",
                    ));
                }
                Block::between(a.min(b), a.max(b))
            }
            None => {
                let foci = scene::outline::foci(&scene).map_err(|error| error::of_key(&error))?;
                space::block_of(&scene, &request.aperture, &foci)
            }
        };
        let lattice = Lattice::of_cells(&block, UVec3::from_array(counts));
        let tolerance = request.plane.tolerance;
        request.size = (counts[0] as usize, counts[1] as usize);
        let volume = move |gauge: &Gauge| {
            let (mut values, mut layer) = (Vec::with_capacity(points as usize), Vec::new());
            for z in 0..counts[2] {
                request.plane = lattice.layer(z, tolerance);
                layer = Cached::take(backend).map(&request, layer, &Gauge::default())?.values;
                values.extend_from_slice(&layer);
                gauge.tell(z as usize + 1, counts[2] as usize);
            }
            PyResult::Ok(values)
        };
        let values = work::run(slf.py(), progress, false, volume)??;
        values.into_pyarray(slf.py()).reshape([counts[2], counts[1], counts[0]].map(|count| count as usize))
    }

    /// Complex pressures at points, Pa (peak), in f64; of several drives in turn the modulus is the root mean square.
    ///
    /// `points`: m, shape (..., 3); the result is complex128 of shape (...).
    #[pyo3(signature = (points, drive=None, *, progress=None))]
    fn pressure<'py>(
        slf: &Bound<'py, Self>,
        points: &Bound<'py, PyAny>,
        drive: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<Complex64>>> {
        let (points, shape) = places(points)?;
        let drives = responding(&slf.get().scene, Self::played(slf, drive, false, progress)?, false);
        let scene = Arc::clone(&slf.get().scene);
        let read = move |_: &Gauge| probe::pressures(&Aperture::new(&scene), &drives, &points);
        work::run(slf.py(), progress, false, read)?.into_pyarray(slf.py()).reshape(shape)
    }

    /// The transfer H from every element to points, Pa (peak) per unit of drive, including reflections: complex128, shape
    /// (points, elements), so that `H @ u` is `pressure`.
    fn transfer<'py>(
        slf: &Bound<'py, Self>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
        let (points, _) = places(points)?;
        let aperture = Aperture::new(&slf.get().scene);
        let elements = aperture.positions.len();
        let rows = |points: &[DVec3]| {
            let transfer = aperture.transfer(points);
            let mut all = vec![Complex64::default(); points.len() * elements];
            for (row, values) in all.chunks_exact_mut(elements).zip(transfer.rows()) {
                aperture.driven.iter().zip(values).for_each(|(&element, value)| row[element] = value);
            }
            all
        };
        let all: Vec<_> = slf.py().detach(|| points.par_chunks(64).flat_map_iter(rows).collect());
        all.into_pyarray(slf.py()).reshape([points.len(), elements])
    }

    /// The radiation force on the scene's bead at points (m, shape (..., 3)): a dictionary of `gorkov` (J, shape (...)), `force` (N,
    /// shape (..., 3), without weight) and `stiffness` (N/m, -dF/dx, shape (..., 3, 3)).
    #[pyo3(signature = (points, drive=None, *, progress=None))]
    fn force<'py>(
        slf: &Bound<'py, Self>,
        points: &Bound<'py, PyAny>,
        drive: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (points, shape) = places(points)?;
        let drives = responding(&slf.get().scene, Self::played(slf, drive, true, progress)?, false);
        let scene = Arc::clone(&slf.get().scene);
        let feel = move |_: &Gauge| {
            let levitation = Levitation::new(&scene, &Aperture::new(&scene), &drives);
            points.par_iter().map(|&point| levitation.forces(point)).collect::<Vec<_>>()
        };
        let py = slf.py();
        let all = work::run(py, progress, false, feel)?;
        let gorkov: Vec<_> = all.iter().map(|forces| forces.gorkov).collect();
        let force: Vec<_> = all.iter().flat_map(|forces| forces.force.to_array()).collect();
        let stiffness = |forces: &sonoglyph::force::Forces| forces.stiffness.transpose().to_cols_array();
        let stiffness: Vec<_> = all.iter().flat_map(stiffness).collect();
        let with = |more: &[usize]| [&shape[..], more].concat();
        let made = PyDict::new(py);
        made.set_item("gorkov", gorkov.into_pyarray(py).reshape(shape.clone())?)?;
        made.set_item("force", force.into_pyarray(py).reshape(with(&[3]))?)?;
        made.set_item("stiffness", stiffness.into_pyarray(py).reshape(with(&[3, 3]))?)?;
        Ok(made)
    }

    /// Radiation force and torque on every body, the mean of several drives: dictionaries as in `Solution.bodies`.
    #[pyo3(signature = (drive=None, *, progress=None))]
    fn body_forces<'py>(
        slf: &Bound<'py, Self>,
        drive: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let drives = responding(&slf.get().scene, Self::played(slf, drive, true, progress)?, false);
        let scene = Arc::clone(&slf.get().scene);
        let push = move |_: &Gauge| bodies::json(&bodies::pushed(&scene, &Aperture::new(&scene), &drives));
        convert::python(slf.py(), &work::run(slf.py(), progress, false, push)?)
    }

    /// Finds the drives of all frames of the scene's motion.
    #[pyo3(signature = (*, progress=None))]
    fn frames(slf: &Bound<'_, Self>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Motion> {
        let scene = Arc::clone(&slf.get().scene);
        let rate = motion::cycle(&scene).map_or(0.0, |cycle| cycle.frames_per_second());
        let follow = move |gauge: &Gauge| {
            let sequence = frames::follow_with(&scene, gauge)?;
            let moving = Moving::new(&scene, &sequence);
            Ok((Arc::new(sequence), moving))
        };
        let followed = work::run(slf.py(), progress, false, follow)?;
        let (sequence, moving) = followed.map_err(|error| error::of_solving(&error))?;
        Ok(Motion::new(sequence, rate, moving))
    }

    fn __repr__(&self) -> String {
        let scene = &self.scene;
        let shown = scene.targets.iter().filter(|target| target.visible).count();
        let (elements, kilohertz) = (scene.elements(), scene.array.frequency * 1e-3);
        format!("<sonoglyph.Scene: {shown} targets, {elements} elements at {kilohertz} kHz>")
    }

    /// The picture in notebooks: the RMS pressure on the scene's plane, if the scene can be solved.
    fn _repr_png_<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        match Self::map(slf, "rms", Some(Pixels::Width(360)), None, "auto", None, None) {
            Ok(map) => map.png(slf.py(), "inferno").map(Some),
            Err(error) if error.is_instance_of::<PyValueError>(slf.py()) => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String, PathBuf))> {
        let this = slf.get();
        Ok((slf.get_type().getattr("loads")?, (this.dumps(), this.folder.clone())))
    }
}

/// The key of the file for a keyword argument in plural.
fn singular(key: String) -> String {
    match key.as_str() {
        "targets" | "boards" | "reflectors" => key.trim_end_matches('s').to_owned(),
        "bodies" => "body".to_owned(),
        _ => key,
    }
}
