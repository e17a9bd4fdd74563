//! The native part of the Python package: scenes, solutions, maps, motions and forces. `sonoglyph/__init__.py` exports them.

mod convert;
mod drives;
mod error;
mod evaluator;
mod map;
mod motion;
mod scene;
mod solution;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::error::{FieldError, GpuError, SceneError};
    #[pymodule_export]
    use crate::map::Map;
    #[pymodule_export]
    use crate::motion::Motion;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::solution::Solution;

    /// The available evaluators and their hardware.
    #[pyfunction]
    fn evaluators() -> Vec<(&'static str, String)> {
        crate::evaluator::available()
    }
}
