//! The stages on the GPU. Only requested results are read back: figures for panels, or the values of all pixels.

use num_complex::Complex64;

use crate::field::gpu::chain::Interpolated;
use crate::field::gpu::{Chain, Gathered, Shape, Texture};
use crate::field::quantity::{Constants, Part, Quantity};
use crate::field::stages::job::Job;
use crate::field::stages::kept::Kept;
use crate::field::stages::probes::AtProbes;
use crate::field::stages::site::{Frame, SiteKey};
use crate::field::stages::{By, Map, Work};
use crate::field::{colouring::Colouring, gpu::Gpu, gpu_report::GpuError};

#[derive(Debug)]
pub(super) struct OnGpu {
    gpu: Gpu,
    chain: Kept<ChainKey, Option<Chain>>,
    /// The state on the GPU.
    formed: Option<Formed>,
    work: Work,
}

/// The inputs of the passes.
#[derive(Clone, Debug, PartialEq)]
struct ChainKey {
    site: SiteKey,
    quantity: Quantity,
    size: (usize, usize),
}

/// The inputs of the values.
#[derive(Clone, Debug, PartialEq)]
struct Formed {
    excitation: Vec<Complex64>,
    constants: Constants<f64>,
    part: f64,
}

/// State of a map on the GPU.
pub(super) enum Progress {
    /// Insufficient memory, or f32 does not keep the tolerance.
    Declined,
    UnderWay,
    Made(Map),
}

impl OnGpu {
    pub(super) fn new(gpu: Gpu) -> Self {
        Self { gpu, chain: Kept::default(), formed: None, work: Work::default() }
    }

    pub(super) fn work(&self) -> Work {
        let traffic = self.gpu.traffic();
        Work { read_back: traffic.read_back, allocations: traffic.allocations, ..self.work }
    }

    pub(super) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    pub(super) fn forget(&mut self) {
        self.chain.key = None;
        self.formed = None;
    }

    /// Updates the values on the GPU; `false` if it declines.
    fn form(&mut self, job: &Job<'_>) -> Result<bool, GpuError> {
        let [drive] = &job.request.counted()[..] else { return Ok(false) };
        let Frame::Pixels { raster, weights } = job.frame else { return Ok(false) };
        if job.site.plan.double {
            return Ok(false);
        }
        let request = job.request;
        let key = ChainKey { site: job.key.clone(), quantity: request.quantity, size: request.size };
        let Self { gpu, chain, formed, work } = self;
        if !chain.is_of(&key) {
            *formed = None;
        }
        chain.update(&key, |chain| {
            let grid = job.site.plan.grid.as_ref().zip(weights.as_ref());
            let interpolated = grid.map(|(grid, weights)| {
                let weights = Part::of(job.key.parts).map(|part| weights.of(part)).collect();
                let heard = grid.heard.iter().map(|(number, _)| *number).collect();
                Interpolated { rows: raster.interpolated.clone(), heard, samples: &grid.samples, weights }
            });
            let direct = raster.direct().map(|rows| (rows.start, raster.pixel_rows(rows)));
            let shape = Shape {
                aperture: &job.key.setting.aperture,
                quantity: request.quantity,
                size: request.size,
                interpolated,
                direct: direct.collect(),
                left_out: job.left_out,
                normal: job.site.axes[2],
                probes: &job.probes.places,
            };
            *chain = Chain::new(gpu, &shape);
        });
        let Some(chain) = &mut chain.value else { return Ok(false) };
        let wanted = Formed {
            excitation: job.excitations[0].clone(),
            constants: request.constants(),
            part: request.part,
        };
        if formed.as_ref() != Some(&wanted) {
            let is_new = formed.as_ref().is_none_or(|formed| formed.excitation != wanted.excitation);
            if is_new {
                work.superposition += 1;
                work.interpolation += u64::from(weights.is_some());
            }
            work.forming += 1;
            let drive = is_new.then_some((&request.aperture, drive));
            chain.run(gpu, drive, &wanted.constants.narrow(), wanted.part as f32);
            *formed = Some(wanted);
        }
        gpu.check()?;
        Ok(true)
    }

    /// Starts a map's values, or checks for them, and may `wait`.
    pub(super) fn map(&mut self, job: &Job<'_>, wait: bool) -> Result<Progress, GpuError> {
        if !self.form(job)? {
            return Ok(Progress::Declined);
        }
        let Self { gpu, chain, .. } = self;
        let Some(chain) = &mut chain.value else { return Ok(Progress::Declined) };
        let Some((values, figures)) = chain.values(gpu, wait)? else { return Ok(Progress::UnderWay) };
        let error = error(job, &figures);
        if job.is_too_far_off(error) {
            return Ok(Progress::Declined);
        }
        Ok(Progress::Made(job.described(values, figures.largest, error, By::Gpu)))
    }

    /// The map in colours on the GPU; `None` if it declines.
    pub(super) fn picture(
        &mut self,
        job: &Job<'_>,
        colouring: &Colouring,
    ) -> Result<Option<Texture>, GpuError> {
        let most = self.gpu.device().limits().max_texture_dimension_2d as usize;
        let (width, height) = job.request.size;
        if width.max(height) > most || !self.form(job)? {
            return Ok(None);
        }
        let Self { gpu, chain, work, .. } = self;
        let Some(chain) = &mut chain.value else { return Ok(None) };
        let (texture, is_new) = chain.paint(gpu, colouring);
        work.picture += u64::from(is_new);
        gpu.check()?;
        Ok(Some(texture))
    }

    /// A map without its values, once its figures have been read back; never blocks.
    pub(super) fn figures(&mut self, job: &Job<'_>) -> Result<Option<(Map, Option<f64>)>, GpuError> {
        if !self.form(job)? {
            return Ok(None);
        }
        let Self { gpu, chain, .. } = self;
        let Some(chain) = &mut chain.value else { return Ok(None) };
        let Some(figures) = chain.figures(gpu)? else { return Ok(None) };
        let map = job.described(Vec::new(), figures.largest, error(job, &figures), By::Gpu);
        Ok(Some((map, figures.seconds)))
    }
}

fn error(job: &Job<'_>, figures: &Gathered) -> f64 {
    let (quantity, constants) = (job.request.quantity, job.request.constants().narrow());
    let factor = job.request.part as f32;
    let value = |sound| {
        let mean = quantity.of(sound, &constants);
        if quantity.declaration().is_root { mean } else { factor * mean }
    };
    let values = figures.sounds.iter().map(|&sound| value(sound)).collect();
    let at_probes = AtProbes { values, sounds: Some(vec![figures.sounds.clone()]), elsewhere: 0.0 };
    job.probes.error((job.request, job.excitations), &at_probes, figures.largest[0])
}

#[cfg(test)]
mod tests {

    use glam::{DVec2, dvec3};

    use super::*;
    use crate::drive::Drive;
    use crate::field::gpu::adapter;
    use crate::field::stages::{Picture, Request};
    use crate::field::{evaluator::Evaluator, stages::Stages};
    use crate::requirement::found;
    use crate::scene::{Array, Plane, Scene};

    fn on_gpu() -> Option<Stages> {
        found("gpu", adapter::open_best(true)).map(|gpu| Stages::new(Evaluator::Gpu(Box::new(gpu))))
    }

    fn request(plane: Plane, quantity: Quantity, size: (usize, usize)) -> Request {
        let array = Array { columns: 4, rows: 4, ..Array::default() };
        let drive = Drive { amplitudes: vec![1.0; 16], phases: (0..16).map(|n| f64::from(n * n)).collect() };
        Request::new(&Scene { array, plane, ..Scene::default() }, vec![drive], quantity, size)
    }

    fn level() -> Plane {
        Plane { centre: dvec3(0.004, -0.002, 0.1), size: DVec2::new(0.06, 0.05), ..Plane::default() }
    }

    #[test]
    fn a_picture_larger_than_a_texture_is_made_on_the_cpu() {
        let Some(mut stages) = on_gpu() else { return };
        let most = stages.gpu().unwrap().device().limits().max_texture_dimension_2d as usize;
        let colouring = Colouring::new(Quantity::Rms, [[0; 4]; 256]);
        for (size, is_on_gpu) in [((8, 8), true), ((1, most + 1), false), ((most + 1, 1), false)] {
            let request = request(level(), Quantity::Rms, size);
            let picture = stages.picture(&request, &colouring).unwrap();
            assert_eq!(matches!(picture, Picture::OnGpu(_)), is_on_gpu, "{size:?}");
        }
    }
}
