//! A quantity on the scene's plane.

use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::ndarray::Array2;
use numpy::{PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sonoglyph::field::{self, Colouring, Quantity, hatch};
use sonoglyph::picture::{ColourMap, Picture, export};
use sonoglyph::scene::Plane;
use sonoglyph::studio::map;

/// # Errors
/// A name unknown to the command line's `--quantity` for maps.
pub fn quantity(name: &str) -> PyResult<Quantity> {
    let wanted = if name == "dent" { "depression" } else { name };
    let known = |quantity: &Quantity| quantity.declaration().name == wanted;
    Quantity::ALL.into_iter().find(known).ok_or_else(|| {
        let names: Vec<_> = Quantity::ALL.iter().map(|quantity| quantity.declaration().name).collect();
        PyValueError::new_err(format!("quantity = {name:?}: must be one of {}", names.join(", ")))
    })
}

/// Memory of freed maps: fresh memory costs a tenth of a map's time.
static SPARE: Mutex<Vec<Vec<f32>>> = Mutex::new(Vec::new());
/// Limits of spare memories, and of values in one of them.
const MOST_SPARE: usize = 2;
const MOST_SPARE_VALUES: usize = 1 << 22;

fn spare() -> MutexGuard<'static, Vec<Vec<f32>>> {
    SPARE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Memory for a map: that of a freed one of about its size, or none.
pub fn memory((width, height): (usize, usize)) -> Vec<f32> {
    let pixels = width.saturating_mul(height);
    let fits = |memory: &Vec<f32>| (pixels..=pixels.saturating_mul(2)).contains(&memory.capacity());
    let mut spare = spare();
    let found = spare.iter().position(fits);
    found.map(|at| spare.swap_remove(at)).unwrap_or_default()
}

/// The values of a NumPy array, whose memory serves a later map.
#[pyclass(frozen)]
struct Values(Array2<f32>);

impl Drop for Values {
    fn drop(&mut self) {
        let (memory, _) = std::mem::take(&mut self.0).into_raw_vec_and_offset();
        if memory.capacity() <= MOST_SPARE_VALUES {
            let mut spare = spare();
            spare.truncate(MOST_SPARE - 1);
            spare.insert(0, memory);
        }
    }
}

/// The values as a NumPy array, without a copy.
#[expect(
    unsafe_code,
    reason = "the array keeps its base `Values`, which neither moves nor drops its memory before"
)]
fn array(py: Python<'_>, shape: [usize; 2], values: Vec<f32>) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let values = Array2::from_shape_vec(shape, values);
    let values = values.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let values = Bound::new(py, Values(values))?;
    Ok(unsafe { PyArray2::borrow_from_array(&values.get().0, values.clone().into_any()) })
}

fn colours(name: &str) -> PyResult<ColourMap> {
    let known = |map: &ColourMap| map.into_str() == name;
    ColourMap::OF_AMOUNTS.into_iter().find(known).ok_or_else(|| {
        let names: Vec<_> = ColourMap::OF_AMOUNTS.iter().map(|map| map.into_str()).collect();
        PyValueError::new_err(format!("colours = {name:?}: must be one of {}", names.join(", ")))
    })
}

/// The values of a quantity on a plane, with peak, error and extent.
///
/// `numpy.asarray(map)` is `map.values`.
#[pyclass(frozen, module = "sonoglyph")]
#[derive(Debug)]
pub struct Map {
    values: Py<PyArray2<f32>>,
    quantity: Quantity,
    plane: Plane,
    peak: f32,
    error: f64,
    /// Its range in words.
    summary: String,
    how: String,
}

impl Map {
    /// The values, without a copy.
    pub fn new(py: Python<'_>, quantity: Quantity, plane: Plane, made: field::Map) -> PyResult<Self> {
        let summary = map::summary(quantity, &made);
        let field::Map { width, height, values, peak, error, how, .. } = made;
        let values = array(py, [height, width], values)?.unbind();
        Ok(Self { values, quantity, plane, peak, error, summary, how })
    }

    pub fn into_values(self, py: Python<'_>) -> PyResult<Bound<'_, PyArray2<f32>>> {
        Ok(self.values.into_bound(py))
    }
}

#[pymethods]
impl Map {
    /// float32, shape (height, width), row 0 at the smallest y; in `unit`.
    #[getter]
    fn values(&self, py: Python<'_>) -> Py<PyArray2<f32>> {
        self.values.clone_ref(py)
    }

    /// The quantity's name.
    #[getter]
    fn quantity(&self) -> &'static str {
        self.quantity.declaration().name
    }

    /// The unit of the values.
    #[getter]
    fn unit(&self) -> &'static str {
        self.quantity.declaration().unit.symbol()
    }

    /// The largest value a wavelength or more from every element, in `unit`; of a phase the largest |p|, Pa (peak); 0 if all
    /// values are below rounding. The error is relative to it, or to a larger value nearer to elements.
    #[getter]
    fn peak(&self) -> f32 {
        self.peak
    }

    /// Estimate of the largest error relative to `peak`, from a comparison with f64 at some pixels.
    #[getter]
    fn error(&self) -> f64 {
        self.error
    }

    /// The method of evaluation, in words.
    #[getter]
    fn how(&self) -> &str {
        &self.how
    }

    /// (left, right, bottom, top) in m along the plane's own axes, about its centre: matplotlib's `extent`, with `origin="lower"`.
    #[getter]
    fn extent(&self) -> (f64, f64, f64, f64) {
        let half = self.plane.size / 2.0;
        (-half.x, half.x, -half.y, half.y)
    }

    /// The map in colours, as the bytes of a PNG file.
    #[pyo3(signature = (colours="inferno"))]
    pub fn png<'py>(&self, py: Python<'py>, colours: &str) -> PyResult<Bound<'py, PyBytes>> {
        let colours = self::colours(colours)?;
        let values = self.values.bind(py).try_readonly()?;
        let (shape, values) = (values.as_array().dim(), values.to_vec()?);
        let bytes = py.detach(|| {
            let colouring = Colouring::new(self.quantity, map::colours(self.quantity, colours).table());
            let mut rgba = Vec::new();
            colouring.colours(&values, self.peak, &mut rgba);
            hatch(&values, shape.1, &mut rgba);
            export::png(&Picture::from_field_order(shape.1, shape.0, rgba.as_flattened()))
        });
        Ok(PyBytes::new(py, &bytes.map_err(|error| PyValueError::new_err(error.to_string()))?))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py, "inferno")
    }

    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let values = self.values.bind(py).as_any();
        match (dtype, copy) {
            (Some(dtype), _) => values.call_method1("astype", (dtype,)),
            (None, Some(true)) => values.call_method0("copy"),
            (None, Some(false) | None) => Ok(values.clone()),
        }
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = self.values.bind(py).dims();
        Ok(format!(
            "<sonoglyph.Map of {}: {} x {} pixels, {}, error up to {:.1e} of the peak>",
            self.quantity.declaration().words,
            shape[1],
            shape[0],
            self.summary,
            self.error,
        ))
    }
}
