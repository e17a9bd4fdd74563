//! The field of a scene for JavaScript: scene files in; map values, with timings, out.

use js_sys::{Float32Array, Function, Promise, Uint8ClampedArray};
use wasm_bindgen::prelude::{JsError, JsValue, wasm_bindgen};
use wasm_bindgen_futures::JsFuture;
use web_time::Instant;

use crate::drive::Drive;
use crate::field::gpu::adapter;
use crate::field::{Colouring, Evaluator, Quantity, Request, Stages};
use crate::picture::ColourMap;
use crate::scene::{Scene, file};
use crate::simd::Isa;
use crate::solver::{self, Solution};

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_name = setTimeout)]
    fn set_timeout(call: &Function, milliseconds: i32) -> JsValue;
}

/// Maps of successive scenes by one evaluator, which reuses unchanged results.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Field {
    stages: Stages,
    /// The solution of the previous scene, from which a drag continues.
    before: Option<Solution>,
}

/// The values of a map, row by row from the smallest y, with peak and error.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct FieldMap {
    pub values: Float32Array,
    /// r, g, b, a of each.
    pub colours: Uint8ClampedArray,
    /// The largest value.
    pub peak: f32,
    /// The estimated error relative to the f64 reference and the peak.
    pub error: f64,
    /// The method of evaluation, as text.
    pub how: String,
    /// ms
    pub solving: f64,
    pub mapping: f64,
    pub colouring: f64,
}

#[wasm_bindgen]
impl Field {
    /// Evaluator `cpu`, the browser's `gpu`, or `any-gpu`, including software GPUs.
    ///
    /// # Errors
    /// An unknown name, or a missing GPU.
    pub async fn open(evaluator: String) -> Result<Field, JsError> {
        console_error_panic_hook::set_once();
        let evaluator = match evaluator.as_str() {
            "cpu" => Evaluator::Cpu,
            "gpu" => Evaluator::Gpu(Box::new(adapter::open(false).await?)),
            "any-gpu" => Evaluator::Gpu(Box::new(adapter::open(true).await?)),
            other => return Err(JsError::new(&format!("evaluator `{other}`: must be cpu, gpu or any-gpu"))),
        };
        Ok(Self { stages: Stages::new(evaluator), before: None })
    }

    /// The evaluator.
    #[wasm_bindgen(getter)]
    pub fn evaluator(&self) -> String {
        let cpu = || format!("CPU, {}", Isa::best().name());
        self.stages.gpu().map_or_else(cpu, |gpu| gpu.info().to_string())
    }

    /// The map of a quantity on the scene's plane, of this size, for the scene's own drive at rest.
    ///
    /// # Errors
    /// An invalid or unsolvable scene, an invalid quantity or size, or a GPU failure.
    pub async fn map(
        &mut self,
        scene: String,
        quantity: String,
        width: usize,
        height: usize,
    ) -> Result<FieldMap, JsError> {
        let scene = parsed(&scene)?;
        let start = Instant::now();
        let solution = solver::solve(&scene)?;
        self.made(&scene, solution.drive, &quantity, (width, height), start).await
    }

    /// The same during a drag: solved within a frame, continuing from the previous scene.
    ///
    /// # Errors
    /// The errors of [`Field::map`].
    pub async fn drag(
        &mut self,
        scene: String,
        quantity: String,
        width: usize,
        height: usize,
    ) -> Result<FieldMap, JsError> {
        let scene = parsed(&scene)?;
        let start = Instant::now();
        let solution = solver::solve_on(&scene, self.before.as_ref())?;
        let drive = self.before.insert(solution).drive.clone();
        self.made(&scene, drive, &quantity, (width, height), start).await
    }

    /// The same for given phases (rad) and amplitudes, one per element.
    ///
    /// # Errors
    /// The errors of [`Field::map`], and a drive of another array.
    pub async fn of_drive(
        &mut self,
        scene: String,
        quantity: String,
        width: usize,
        height: usize,
        phases: Vec<f64>,
        amplitudes: Vec<f64>,
    ) -> Result<FieldMap, JsError> {
        let scene = parsed(&scene)?;
        let elements = Request::new(&scene, Vec::new(), Quantity::Rms, (1, 1)).aperture.positions.len();
        if [phases.len(), amplitudes.len()] != [elements; 2] {
            let given = format!("{} phases and {} amplitudes", phases.len(), amplitudes.len());
            return Err(JsError::new(&format!("{given}: must be {elements}, one of each element")));
        }
        let drive = Drive { amplitudes, phases };
        self.made(&scene, drive, &quantity, (width, height), Instant::now()).await
    }
}

impl Field {
    async fn made(
        &mut self,
        scene: &Scene,
        drive: Drive,
        quantity: &str,
        size: (usize, usize),
        start: Instant,
    ) -> Result<FieldMap, JsError> {
        let solved = Instant::now();
        let known = Quantity::ALL.into_iter().find(|known| known.declaration().name == quantity);
        let quantity = known.ok_or_else(|| JsError::new(&format!("there is no quantity `{quantity}`")))?;
        let request = Request::new(scene, vec![drive], quantity, size);
        while self.stages.poll(&request)?.is_none() {
            next_task().await;
        }
        let mapped = Instant::now();
        let table = ColourMap::default().suited_to(quantity.declaration().range).table();
        let colours = self.stages.colours(&request, &Colouring::new(quantity, table))?;
        let colours = Uint8ClampedArray::from(colours.as_flattened());
        let coloured = Instant::now();
        let map = self.stages.map(&request)?;
        let milliseconds = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
        Ok(FieldMap {
            values: Float32Array::from(&map.values[..]),
            colours,
            peak: map.peak,
            error: map.error,
            how: map.how.clone(),
            solving: milliseconds(start, solved),
            mapping: milliseconds(solved, mapped),
            colouring: milliseconds(mapped, coloured),
        })
    }
}

fn parsed(scene: &str) -> Result<Scene, JsError> {
    Ok(file::parse(scene, "scene.toml".as_ref())?)
}

/// Yields to the browser, so that its GPU can report.
async fn next_task() {
    let promise = Promise::new(&mut |resolve, _| {
        set_timeout(&resolve, 0);
    });
    // It is never rejected.
    let _ = JsFuture::from(promise).await;
}
