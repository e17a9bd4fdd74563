//! Fourier and cosine transforms of any length, in f64.

use std::sync::Arc;

use num_complex::Complex64;
use rustdct::TransformType2And3;
use rustdct::algorithm::Type2And3ConvertToFft;
use rustdct::rustfft::Fft;

/// Cosine transforms of types 2 and 3 of a length, not normalised.
pub type Cosines = Arc<dyn TransformType2And3<f64>>;

/// The transforms of a length.
pub fn cosines(length: usize) -> Cosines {
    Arc::new(Type2And3ConvertToFft::new(plan(length)))
}

/// The coefficients of a repeated sequence of n values x: c_k = 1/n Σ x_i e^{-2πj k i/n}.
pub fn coefficients(mut values: Vec<Complex64>) -> Vec<Complex64> {
    let count = values.len();
    plan(count).process(&mut values);
    values.iter_mut().for_each(|value| *value /= count as f64);
    values
}

/// A Fourier transform of a length with e^{-2πj}, not normalised, of as many rows as a buffer has.
pub type Transform = Arc<dyn Fft<f64>>;

/// The transform of a length.
pub fn transform(length: usize) -> Transform {
    plan(length)
}

/// `FftPlanner` would add the kernels for SSE.
#[cfg(target_arch = "x86_64")]
fn plan(length: usize) -> Arc<dyn Fft<f64>> {
    use rustdct::rustfft::{FftPlannerAvx, FftPlannerScalar};
    match FftPlannerAvx::new() {
        Ok(mut planner) => planner.plan_fft_forward(length),
        Err(()) => FftPlannerScalar::new().plan_fft_forward(length),
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn plan(length: usize) -> Arc<dyn Fft<f64>> {
    use rustdct::rustfft::FftPlanner;
    FftPlanner::new().plan_fft_forward(length)
}
