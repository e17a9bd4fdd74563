//! The pipeline of a map: from drives to values, and from values to colours and contour lines, with the latest
//! result of each stage.
//!
//! Every stage keeps its result together with its inputs, compares these (`==`), and reruns only when they differ:
//! there are no flags and no invalidation calls. [`Work`] counts how often each ran; `engine/tests/field/stages.rs`
//! checks the table.
//!
//! | stage | inputs | result |
//! |---|---|---|
//! | plan (`site`) | array, medium, plane with its tolerance, parts of the sound; for a liquid its capillary length | sample positions, and whether the quantity is formed at pixels or cells |
//! | transfer (CPU) | the same | H from every element to every sample, one table for the pressure and one for its normal slope |
//! | superposition | the same, and the drives | H u at the samples, without silent elements |
//! | interpolation | the same, and the size in pixels or the cells | the parts of the sound there |
//! | forming | the same, the quantity, air and moment | one number per position, averaged over the drives |
//! | response | the same, and the liquid except light | the liquid's depth per cell |
//! | caustic | the response, refractive index, screen and direction of light, size | brightness per pixel, from rays between the cells |
//! | pixels | cells, envelope, size | values, their peak, and the error against f64 at 48 pixels and more beside elements |
//! | picture, contours | values, colours, range and scale; a level | colours; contour lines |
//!
//! *f64.* Samples are evaluated by the reference where f32 rounding exceeds the tolerance (by the measured error),
//! where f32 has no room for the elements, and next to the rim of an exact piston. If the error is still too large,
//! every pixel is evaluated: where the field is weak, window leakage dominates.
//!
//! *Skin.* The pressures of all frames at the cells become spectral lines, and these the skin's ([`skin`]).
//!
//! *Liquids.* The pressure at the cells becomes a depth ([`Tank`]), in f64 on the CPU. A moving surface is a
//! request with the depth of every cell and uses the same later stages.

mod bodies;
mod caustic;
mod depression;
mod force;
mod harmonic;
mod job;
mod kept;
mod lattice;
mod nodes;
mod on_cpu;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
mod on_gpu;
mod probes;
mod request;
mod samples;
mod scatter;
mod site;
mod skin;
mod weakest;
mod within;
mod work;

use job::Job;
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use crate::drive::Drive;
use crate::field::colouring::{Colouring, hatch};
use crate::field::contour::{self, Line};
use crate::field::gpu::Texture;
use crate::field::plan::{Costs, promised};
use crate::field::quantity::OF_BODIES;
use crate::field::vicinity::LeftOut;
use crate::field::{evaluator::Evaluator, gpu::Gpu};
use crate::gauge::Gauge;
use crate::scene::Spread;
use crate::surface::{Dent, Tank};
use force::OfBead;
use harmonic::OfVolume;
use kept::Kept;
use on_cpu::{Made, OnCpu};
use on_gpu::{OnGpu, Progress};
use probes::Probes;
use scatter::Scatter;
use site::{Frame, Site, SiteKey};
use skin::OfSkin;

pub use depression::Depression;
pub use request::{By, FieldError, MOST_PIXELS, Map, Pressed, Request};
pub use skin::SkinMotion;
pub use work::Work;

/// A map in colours.
#[derive(Debug)]
pub enum Picture<'a> {
    OnGpu(Texture),
    /// r, g, b, a of every pixel, row by row.
    OnCpu(&'a [[u8; 4]]),
}

/// The pipeline of one evaluator.
#[derive(Debug)]
pub struct Stages {
    /// Everything in f64, pixel by pixel.
    exact: bool,
    gpu: Option<OnGpu>,
    cpu: OnCpu,
    of_bead: OfBead,
    of_volume: OfVolume,
    scatter: Scatter,
    ground: Ground,
    /// Keyed by the relevant part of the request.
    map: Kept<Request, Map>,
    /// The request declined by the GPU.
    declined: Option<Request>,
    colours: Kept<(Request, Colouring), Vec<[u8; 4]>>,
    contours: Kept<(Request, f32), Vec<Line>>,
    /// Work of the last two stages; the others count their own.
    work: Work,
}

/// Sites and frames, common to all evaluators.
#[derive(Debug, Default)]
struct Ground {
    /// The site, keyed by the request: a quantity that cannot be formed at cells is formed at the pixels.
    site: Kept<SiteKey, Option<(SiteKey, Site)>>,
    /// The request of the last refinement, so that maps do not depend on history.
    refined: Option<Request>,
    frame: Kept<FrameKey, Option<Framed>>,
    /// Excitations of the drives with these elements driven.
    excitations: Kept<Sounding, Arc<Vec<Vec<Complex64>>>>,
    work: Work,
}

/// A frame, pixels that do not count for the peak, probes, pixels within bodies, and skin of bodies.
type Framed = (Frame, LeftOut, Probes, Vec<usize>, OnSkin);

/// The places of [`within::skin`].
type OnSkin = Vec<Option<DVec3>>;

/// Drives and driven elements.
type Sounding = (Arc<[Drive]>, Vec<usize>);

/// The inputs of pixels and probes.
#[derive(Clone, Debug, PartialEq)]
struct FrameKey {
    site: SiteKey,
    size: (usize, usize),
    is_pressed: bool,
}

impl Ground {
    fn job<'a>(&'a mut self, request: &'a Request, exact: bool, costs: Costs) -> Result<Job<'a>, FieldError> {
        let is_pressed = request.quantity.declaration().is_pressed();
        let wanted = SiteKey::new(request, exact);
        let Self { site, refined, frame, excitations, work } = self;
        if refined.take_if(|refined| refined != request).is_some() {
            site.key = None;
        }
        let site = site.try_update(&wanted, |site| {
            work.plan += 1;
            let made = match Site::new(&wanted, costs) {
                Err(FieldError::TooNear | FieldError::TooManyCells) if !is_pressed => {
                    let key = SiteKey::by_pixels(request, exact);
                    let made = Site::new(&key, costs)?;
                    (key, made)
                }
                made => (wanted.clone(), made?),
            };
            *site = Some(made);
            Ok::<_, FieldError>(())
        })?;
        let (key, site) = site.as_ref().ok_or(FieldError::NoPlane)?;
        if let Some(filled) = site.cells.as_ref().filter(|_| request.quantity.declaration().of_skin) {
            OfSkin::check(request.drives.len(), &filled.cells)?;
        }
        let wanted = FrameKey { site: key.clone(), size: request.size, is_pressed };
        let frame = frame.update(&wanted, |made| {
            *made = Frame::new(key, site, request.size).map(|frame| {
                let left_out = frame.left_out(&key.setting.aperture);
                let of_skin = site.cells.as_ref().filter(|_| request.quantity.declaration().of_skin);
                let skin = of_skin.map_or_else(Vec::new, |filled| {
                    let points = filled.cells.points(site.axes);
                    within::skin(&key.setting.aperture, &points, site.axes[2])
                });
                // On the skin of bodies every cell is in f64 already.
                let is_compared = skin.is_empty();
                let probes = Probes::new(key, site, (request.size, &left_out), (is_pressed, is_compared));
                let within = frame.within(request, site.axes);
                (frame, left_out, probes, within, skin)
            });
        });
        let (frame, left_out, probes, within, skin) = frame.as_ref().ok_or(FieldError::NoPlane)?;
        let sounding = (request.counted(), request.aperture.driven.clone());
        let excitations = excitations.update(&sounding, |made| *made = request.excitations());
        Ok(Job { request, key, site, frame, left_out, probes, within, skin, excitations })
    }
}

impl Ground {
    /// Switches to finer samples, or to every pixel, after this relative error of cells; `false` if not needed, or
    /// impossible.
    fn refine(&mut self, request: &Request, exact: bool, costs: Costs, error: f64) -> bool {
        let times = error / promised(request.plane.tolerance);
        let Some((key, site)) = &self.site.value else { return false };
        if times <= 1.0 || site.cells.is_none() || key.is_direct() {
            return false;
        }
        let declaration = request.quantity.declaration();
        let is_root = declaration.is_root;
        // Roots fail where squares are interpolated, whatever the samples.
        let last = match (declaration.is_pressed(), is_root) {
            (true, _) => key.direct(),
            (false, true) => SiteKey::by_pixels(request, exact),
            (false, false) => SiteKey::by_pixels(request, exact).direct(),
        };
        let finer = if is_root { None } else { key.finer(times) };
        let Some((key, made)) =
            finer.into_iter().chain([last]).find_map(|key| Some((key.clone(), Site::new(&key, costs).ok()?)))
        else {
            return false;
        };
        self.work.plan += 1;
        self.site.value = Some((key, made));
        self.refined = Some(request.clone());
        true
    }
}

impl Stages {
    pub fn new(evaluator: Evaluator) -> Self {
        Self {
            exact: matches!(evaluator, Evaluator::Reference),
            gpu: if let Evaluator::Gpu(gpu) = evaluator { Some(OnGpu::new(*gpu)) } else { None },
            cpu: OnCpu::default(),
            of_bead: OfBead::default(),
            of_volume: OfVolume::default(),
            scatter: Scatter::default(),
            ground: Ground::default(),
            map: Kept::default(),
            declined: None,
            colours: Kept::default(),
            contours: Kept::default(),
            work: Work::default(),
        }
    }

    /// Reports the progress of the samples of all drives.
    pub fn show_progress(&mut self, progress: Gauge) {
        self.cpu.progress = progress;
    }

    /// Drops every result, keeping memory and counters.
    pub fn forget(&mut self) {
        self.ground = Ground { work: self.ground.work, ..Ground::default() };
        self.map.key = None;
        self.declined = None;
        self.colours.key = None;
        self.contours.key = None;
        self.cpu.forget();
        self.of_bead.forget();
        self.scatter.forget();
        if let Some(gpu) = &mut self.gpu {
            gpu.forget();
        }
    }

    /// The run counts of all stages.
    pub fn work(&self) -> Work {
        let of_gpu = self.gpu.as_ref().map(OnGpu::work).unwrap_or_default();
        self.work + self.ground.work + self.cpu.work() + self.of_bead.work + self.of_volume.work + of_gpu
    }

    /// The GPU, if any.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_ref().map(OnGpu::gpu)
    }

    fn costs(&self) -> Costs {
        if self.gpu.is_some() { Costs::GPU } else { Costs::CPU }
    }

    /// Updates the map. Blocks on the GPU, if one is used, which is refused in a browser.
    ///
    /// # Errors
    /// An invalid request, a plane unsuitable for the quantity, or a GPU failure.
    pub fn map(&mut self, request: &Request) -> Result<&Map, FieldError> {
        self.advance(&request.relevant()?, true)?;
        Ok(&self.map.value)
    }

    /// The map by value, if possible in this memory: requesting it again recomputes it from the earlier stages.
    ///
    /// # Errors
    /// The errors of [`Stages::map`].
    pub fn take_map(&mut self, request: &Request, memory: Vec<f32>) -> Result<Map, FieldError> {
        if self.map.key.is_none() {
            self.map.value.values = memory;
        }
        self.map(request)?;
        self.map.key = None;
        Ok(std::mem::take(&mut self.map.value))
    }

    /// Whether the map of this request is the newest.
    #[doc(hidden)]
    pub fn has(&self, request: &Request) -> bool {
        request.relevant().is_ok_and(|request| self.map.is_of(&request))
    }

    /// Takes over a map that other stages made of this request.
    ///
    /// # Errors
    /// An invalid request.
    #[doc(hidden)]
    pub fn keep(&mut self, request: &Request, map: Map) -> Result<(), FieldError> {
        (self.map.key, self.map.value) = (Some(request.relevant()?), map);
        Ok(())
    }

    /// The map, if available; otherwise starts it, without blocking on a GPU. To be polled from a frame or timer of a
    /// browser.
    ///
    /// # Errors
    /// The errors of [`Stages::map`].
    pub fn poll(&mut self, request: &Request) -> Result<Option<&Map>, FieldError> {
        let is_there = self.advance(&request.relevant()?, false)?;
        Ok(is_there.then_some(&self.map.value))
    }

    /// Whether the map of a relevant request is available.
    fn advance(&mut self, request: &Request, wait: bool) -> Result<bool, FieldError> {
        let costs = self.costs();
        let Self { gpu, cpu, of_bead, of_volume, scatter, ground, map, declined, exact, .. } = self;
        if map.is_of(request) {
            return Ok(true);
        }
        if !request.quantity.declaration().has_formula() {
            map.key = None;
            // A page cannot wait for its GPU.
            let gpu = gpu.as_ref().map(OnGpu::gpu).filter(|_| !cfg!(target_arch = "wasm32"));
            map.value = match request.quantity.declaration().of_volume {
                true => of_volume.map(request, *exact, gpu, &cpu.progress)?,
                false => of_bead.map(request, *exact, gpu, &cpu.progress)?,
            };
            if cpu.progress.is_cancelled() {
                return Err(FieldError::Cancelled);
            }
            map.key = Some(request.clone());
            return Ok(true);
        }
        // The map of equal elements comes first.
        let (wanted, request) = (request, &Request { spread: Spread::default(), ..request.clone() });
        let job = ground.job(request, *exact, costs)?;
        let progress = match gpu {
            Some(gpu) if declined.as_ref() != Some(request) && request.aperture.bodies.is_empty() => {
                gpu.map(&job, wait)?
            }
            Some(_) | None => Progress::Declined,
        };
        map.value = match progress {
            // The map before stays until then.
            Progress::UnderWay => return Ok(false),
            Progress::Made(made) => made,
            Progress::Declined => {
                map.key = None;
                let values = std::mem::take(&mut map.value.values);
                let gpu = gpu.as_ref().map(OnGpu::gpu);
                let mut made = job.by_cpu((cpu, gpu), *exact, values)?;
                while ground.refine(request, *exact, costs, made.error) {
                    let job = ground.job(request, *exact, costs)?;
                    made = job.by_cpu((cpu, gpu), *exact, made.values)?;
                }
                made
            }
        };
        if wanted.is_of_many_arrays() {
            scatter.add(wanted, *exact, &mut map.value);
        }
        map.key = Some(wanted.clone());
        Ok(true)
    }

    /// The map as a picture: on the GPU if possible, otherwise as colours r, g, b, a of every pixel, row by row.
    /// Never blocks on a GPU.
    ///
    /// # Errors
    /// The errors of [`Stages::map`].
    #[doc(hidden)]
    pub fn picture(&mut self, request: &Request, colouring: &Colouring) -> Result<Picture<'_>, FieldError> {
        let request = request.relevant()?;
        let costs = self.costs();
        let Self { gpu, ground, declined, exact, .. } = self;
        if let Some(gpu) = gpu
            && declined.as_ref() != Some(&request)
            && is_coloured_on_gpu(&request)
        {
            let job = ground.job(&request, *exact, costs)?;
            if let Some(texture) = gpu.picture(&job, colouring)? {
                return Ok(Picture::OnGpu(texture));
            }
            *declined = Some(request.clone());
        }
        self.colours(&request, colouring).map(Picture::OnCpu)
    }

    /// The map possibly without its values; `None` while pending on the GPU. The number is the GPU time (s), if
    /// measurable.
    ///
    /// # Errors
    /// The errors of [`Stages::map`].
    pub fn figures(&mut self, request: &Request) -> Result<Option<(Map, Option<f64>)>, FieldError> {
        let request = request.relevant()?;
        let costs = self.costs();
        let Self { gpu, ground, map, declined, exact, .. } = self;
        if map.is_of(&request) {
            return Ok(Some((map.value.without_values(), None)));
        }
        let declines = !is_coloured_on_gpu(&request) || declined.as_ref() == Some(&request);
        let Some(gpu) = gpu.as_mut().filter(|_| !declines) else { return Ok(None) };
        let job = ground.job(&request, *exact, costs)?;
        let figures = gpu.figures(&job)?;
        // The next picture is computed on the CPU.
        if figures.as_ref().is_some_and(|(map, _)| job.is_too_far_off(map.error)) {
            *declined = Some(request);
            return Ok(None);
        }
        Ok(figures)
    }

    /// The map as colours r, g, b, a of every pixel, row by row; updates the map first.
    ///
    /// # Errors
    /// The errors of [`Stages::map`].
    pub fn colours(&mut self, request: &Request, colouring: &Colouring) -> Result<&[[u8; 4]], FieldError> {
        let key = (request.relevant()?, colouring.clone());
        self.advance(&key.0, true)?;
        let Self { map, colours, work, .. } = self;
        Ok(colours.update(&key, |colours| {
            work.picture += 1;
            colouring.colours(&map.value.values, map.value.peak, colours);
            if map.value.within > 0 {
                hatch(&map.value.values, map.value.width, colours);
            }
        }))
    }

    /// The contour lines at this fraction of the peak; updates the map first.
    ///
    /// # Errors
    /// The errors of [`Stages::map`].
    pub fn contours(&mut self, request: &Request, part: f32) -> Result<&[Line], FieldError> {
        let key = (request.relevant()?, part);
        self.advance(&key.0, true)?;
        let Self { map, contours, work, .. } = self;
        Ok(contours.update(&key, |lines| {
            work.contours += 1;
            let Map { values, width, peak, .. } = &map.value;
            lines.clear();
            if *peak > 0.0 {
                *lines = contour::lines(values, *width, part * peak, |value| *value);
            }
        }))
    }

    /// Whether the GPU has declined this map, leaving it to the CPU.
    #[doc(hidden)]
    pub fn has_declined(&self, request: &Request) -> bool {
        self.declined
            .as_ref()
            .is_some_and(|declined| request.relevant().is_ok_and(|request| request == *declined))
    }

    /// The radiation pressure of equal elements on a map's plane, after an update; for a moving surface, its shape instead of that at
    /// rest.
    ///
    /// # Errors
    /// The errors of [`Stages::map`].
    pub fn pressed(&mut self, request: &Request) -> Result<Pressed, FieldError> {
        let request = Request { spread: Spread::default(), ..request.relevant()? };
        self.advance(&request, true)?;
        let by = self.map.value.by;
        let costs = self.costs();
        let Self { cpu, ground, map, exact, .. } = self;
        let job = ground.job(&request, *exact, costs)?;
        Ok(cpu.pressed(&job, &map.value.values, is_double(by)))
    }

    /// The cells of a liquid, and its surface at rest under steady sound, ignoring the envelope.
    ///
    /// # Errors
    /// The errors of [`Stages::map`]; a quantity without a liquid has no surface.
    pub fn surface(&mut self, request: &Request) -> Result<(&Tank, &Dent), FieldError> {
        let request = request.relevant()?;
        let costs = self.costs();
        let Self { cpu, ground, exact, .. } = self;
        let job = ground.job(&request, *exact, costs)?;
        let double = *exact || job.site.plan.double;
        cpu.surface(&job, double).ok_or(FieldError::NotLevel)
    }

    /// The motion of the skin on the plane, for a request of a quantity of the skin; of all channels, with its mean.
    ///
    /// # Errors
    /// The errors of [`Stages::map`]; a quantity without a skin has no motion.
    #[doc(hidden)]
    pub fn skin(&mut self, request: &Request) -> Result<&SkinMotion, FieldError> {
        let request = request.relevant()?;
        let costs = self.costs();
        let Self { cpu, ground, exact, .. } = self;
        let job = ground.job(&request, *exact, costs)?;
        let double = *exact || job.site.plan.double;
        cpu.skin(&job, double).ok_or(FieldError::NoPlane)
    }
}

/// Whether the samples of such a map are in f64.
fn is_double(by: By) -> bool {
    match by {
        By::Reference | By::CpuInF64 => true,
        By::Cpu | By::Gpu => false,
    }
}

impl Job<'_> {
    /// The map by the CPU, with what bodies scatter by a GPU if there is one; in f64 where f32 does not keep the tolerance, and pixel by pixel where samples do not.
    fn by_cpu(
        &self,
        (cpu, gpu): (&mut OnCpu, Option<&Gpu>),
        exact: bool,
        mut values: Vec<f32>,
    ) -> Result<Map, FieldError> {
        let mut make = |job: &Job<'_>, by: By, values: &mut Vec<f32>| {
            let mut made = cpu.values((job, gpu), is_double(by), values);
            let sounding = (job.request, &job.excitations[..]);
            let rounding = if is_double(by) { job.probes.rounding(sounding) } else { 0.0 };
            if rounding > 0.0 && f64::from(made.relative_to) <= rounding {
                // Light on a level surface is undisturbed.
                let is_light = job.request.quantity.declaration().of_light;
                let (peak, left_out) = (if is_light { made.peak } else { 0.0 }, made.peak.max(made.left_out));
                made = Made { peak, left_out, rounding, ..made };
                return (0.0, made, by);
            }
            (job.probes.error(sounding, &made.at_probes, made.relative_to), made, by)
        };
        let all_of_it = |job: &Job<'_>, (error, made, by): (f64, Made, By), values| {
            let Made { peak, left_out, rounding, .. } = made;
            Map { rounding, ..job.described(values, [peak, left_out], error, by) }
        };
        let made = if exact {
            make(self, By::Reference, &mut values)
        } else {
            let mut made = if self.site.plan.double {
                make(self, By::CpuInF64, &mut values)
            } else {
                make(self, By::Cpu, &mut values)
            };
            // Roots of squares at cells are off by their interpolation: f64 does not mend them.
            let is_root = self.request.quantity.declaration().is_root && self.site.cells.is_some();
            if made.2 == By::Cpu && !is_root && self.is_too_far_off(made.0) {
                made = make(self, By::CpuInF64, &mut values);
            }
            made
        };
        let is_interpolated = match self.frame {
            Frame::Pixels { weights, .. } => weights.is_some(),
            Frame::Cells { .. } => false,
        };
        if !(is_interpolated && self.is_too_far_off(made.0)) {
            return Ok(all_of_it(self, made, values));
        }
        // Where the field is weak, window leakage dominates.
        let plan = self.site.plan.direct("samples do not keep the tolerance");
        let key = self.key.direct();
        let site = Site { plan, cells: None, axes: self.site.axes };
        let frame = Frame::new(&key, &site, self.request.size).ok_or(FieldError::NoPlane)?;
        let job = Job { key: &key, site: &site, frame: &frame, ..*self };
        // If f64 does not help, f32 is not the cause.
        let mut made = make(&job, if self.site.plan.double { made.2 } else { By::Cpu }, &mut values);
        if made.2 == By::Cpu && job.is_too_far_off(made.0) {
            made = make(&job, By::CpuInF64, &mut values);
        }
        Ok(all_of_it(&job, made, values))
    }

    /// Rounding in f32 is relative to the single waves; if they cancel, the peak is smaller.
    fn is_too_far_off(&self, error: f64) -> bool {
        let tolerance = promised(self.request.plane.tolerance);
        let is_open = self.request.aperture.bodies.is_empty() || self.key.is_direct();
        error > if is_open { tolerance } else { tolerance.max(OF_BODIES) }
    }

    /// The map with the largest magnitudes of the pixels that count for the peak, and of the others.
    fn described(&self, values: Vec<f32>, [peak, left_out]: [f32; 2], error: f64, by: By) -> Map {
        let (width, height) = self.request.size;
        let plan = &self.site.plan;
        let (evaluated, how) = match (self.frame, &self.site.cells) {
            (Frame::Pixels { raster, .. }, _) => (raster.evaluated(plan), raster.describe(plan)),
            (Frame::Cells { .. }, cells) => {
                let direct = cells.as_ref().map_or(0, |filled| filled.cells.count());
                let sampled = plan.grid.as_ref().map_or(direct, |grid| grid.samples.len());
                let cells = cells.as_ref().map_or_else(String::new, |filled| {
                    let ([columns, rows], step) = (filled.cells.counts, filled.cells.step);
                    format!("; squares at {columns} x {rows} cells of {:.2} mm", step * 1e3)
                });
                (sampled, format!("{}{cells}", plan.reason))
            }
        };
        let (near, within, loudest) = (self.left_out.near, self.within.len(), peak.max(left_out));
        Map { width, height, values, peak, loudest, near, within, rounding: 0.0, error, evaluated, by, how }
    }
}

/// Whether a map is finished on the GPU: neither a vector nor a mean over arrays, whose values are made on the CPU.
fn is_coloured_on_gpu(request: &Request) -> bool {
    request.quantity.declaration().has_formula()
        && !request.is_of_many_arrays()
        && request.aperture.bodies.is_empty()
}
