//! Conversion between Python values and ours: the plain values of a scene file, and points in arrays.

use glam::DVec3;
use numpy::{
    Element, IntoPyArray, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PyString};
use serde_json::{Map, Number, Value};

/// Deeper nesting is refused.
const DEEPEST: usize = 16;
/// Points evaluated at once.
const MOST_PLACES: usize = 50_000_000;

/// A value of a scene: numbers, strings, sequences (also of NumPy), mappings, paths and the package's own classes. `None` is left out
/// of tables.
///
/// # Errors
/// Any other type, with its key.
pub fn plain(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    value_at(value, "", 0)
}

fn value_at(value: &Bound<'_, PyAny>, key: &str, depth: usize) -> PyResult<Value> {
    let refused = |what: &str| {
        let place = if key.is_empty() { String::new() } else { format!("{key}: ") };
        PyTypeError::new_err(format!("{place}{what}"))
    };
    if depth > DEEPEST {
        return Err(refused("nested too deeply"));
    }
    if value.is_none() {
        return Ok(Value::Null);
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(value.extract::<bool>()?.into());
    }
    if value.is_instance_of::<PyInt>() {
        let number = value.extract::<i64>().map_err(|_| refused("the number is too large"))?;
        return Ok(number.into());
    }
    if value.is_instance_of::<PyFloat>() {
        let number = Number::from_f64(value.extract()?);
        return number.map(Value::Number).ok_or_else(|| refused("must be a finite number"));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(value.extract::<String>()?.into());
    }
    // The package's own classes.
    if let Ok(table) = value.call_method0("_table") {
        return value_at(&table, key, depth + 1);
    }
    if let Ok(path) = value.call_method0("__fspath__") {
        return Ok(path.extract::<String>()?.into());
    }
    // NumPy's arrays and scalars.
    if let Ok(list) = value.call_method0("tolist") {
        return value_at(&list, key, depth + 1);
    }
    if let Ok(table) = value.cast::<PyMapping>() {
        let mut entries = Map::new();
        for item in table.items()?.iter() {
            let (name, value): (String, Bound<'_, PyAny>) =
                item.extract().map_err(|_| refused("the keys of a table are texts"))?;
            let inner = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            let value = value_at(&value, &inner, depth + 1)?;
            if !value.is_null() {
                entries.insert(name, value);
            }
        }
        return Ok(Value::Object(entries));
    }
    let Ok(items) = value.try_iter() else {
        return Err(refused(&format!("a scene holds no {}", value.get_type().name()?)));
    };
    let items =
        items.enumerate().map(|(index, item)| value_at(&item?, &format!("{key}[{}]", index + 1), depth + 1));
    Ok(Value::Array(items.collect::<PyResult<_>>()?))
}

/// The inverse: dictionaries, lists, strings and numbers.
pub fn python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.into_pyobject(py)?.into_any(),
            None => number.as_f64().unwrap_or(f64::NAN).into_pyobject(py)?.into_any(),
        },
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Array(values) => {
            let values = values.iter().map(|value| python(py, value)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, values)?.into_any()
        }
        Value::Object(entries) => {
            let table = PyDict::new(py);
            for (name, value) in entries {
                table.set_item(name, python(py, value)?)?;
            }
            table.into_any()
        }
    })
}

/// Points (m) of any shape (..., 3), and the shape (...).
///
/// # Errors
/// Another shape, too many points, or a coordinate that is no usable number.
pub fn places(points: &Bound<'_, PyAny>) -> PyResult<(Vec<DVec3>, Vec<usize>)> {
    let array = points.py().import("numpy")?.call_method1("asarray", (points,))?;
    let array = array.cast::<PyUntypedArray>()?;
    let refused = |what: &str| Err(PyValueError::new_err(format!("points: {what}")));
    let Some((3, shape)) = array.shape().split_last().map(|(last, shape)| (*last, shape.to_vec())) else {
        return refused("an array of shape (..., 3), in metres");
    };
    if array.len() / 3 > MOST_PLACES {
        return refused("50 000 000 at most");
    }
    let flat = numbers::<f64>(array)?;
    if !flat.iter().all(|x| x.abs() <= 1e6) {
        return refused("every coordinate must be a number of metres from -1e6 to 1e6");
    }
    Ok((flat.as_chunks::<3>().0.iter().map(|&at| DVec3::from_array(at)).collect(), shape))
}

/// The numbers of an array in row order, of any strides, alignment, byte order and type that NumPy converts.
///
/// # Errors
/// An array of anything but numbers.
pub fn numbers<T: Element>(array: &Bound<'_, PyUntypedArray>) -> PyResult<Vec<T>> {
    let py = array.py();
    let packed = py.import("numpy")?.call_method1("require", (array, T::get_dtype(py), ["C", "A"]))?;
    Ok(packed.cast_into::<PyArrayDyn<T>>()?.to_vec()?)
}

/// An array of shape (n, 3).
pub fn rows<'py>(py: Python<'py>, values: &[DVec3]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<_> = values.iter().flat_map(|value| value.to_array()).collect();
    flat.into_pyarray(py).reshape([values.len(), 3])
}
