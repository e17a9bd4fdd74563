//! The stages of a map with what each made last: plan, transfer, superposition, interpolation, picture.
//!
//! Every stage keeps its result together with the values that it was made from, and runs again only when they differ.
//! [`Work`] counts how often each ran.

mod average;
mod contours;
mod on_cpu;
mod on_gpu;

use std::convert::Infallible;

use num_complex::{Complex32, Complex64};

use crate::acoustics::{self, Aperture};
use crate::drive::Drive;
use crate::field::contour::Line;
use crate::field::plan::Costs;
use crate::field::{self, Colouring, Evaluator, Gpu, GpuError, Plan, Quantity, Raster, Samples};
use crate::scene::Plane;
use average::Averaging;
use on_cpu::OnCpu;
use on_gpu::OnGpu;

pub use average::{Average, AverageMap, Mean};

/// Pixels that a map may have.
pub const MOST_PIXELS: usize = 1 << 26;
/// Pixels at which the reached error is measured.
pub const PROBES: usize = 48;
/// Errors are spread so evenly that the largest of all pixels is less than this times the largest of [`PROBES`].
const PROBE_MARGIN: f64 = 2.0;

/// How often each stage ran.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    pub plan: u64,
    /// Tables of the transfer to the samples.
    pub transfer: u64,
    /// Sums over the elements, at the samples or at pixels.
    pub superposition: u64,
    pub interpolation: u64,
    /// Squares of the pressure at the cells, per drive.
    pub squares: u64,
    pub dent: u64,
    pub picture: u64,
    /// Contour lines.
    pub contours: u64,
}

impl Work {
    /// What was done after `before`.
    pub fn since(self, before: Self) -> Self {
        Self {
            plan: self.plan - before.plan,
            transfer: self.transfer - before.transfer,
            superposition: self.superposition - before.superposition,
            interpolation: self.interpolation - before.interpolation,
            squares: self.squares - before.squares,
            dent: self.dent - before.dent,
            picture: self.picture - before.picture,
            contours: self.contours - before.contours,
        }
    }
}

/// What a map is made from.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    pub aperture: &'a Aperture,
    pub plane: &'a Plane,
    pub drive: &'a Drive,
    /// Pixels.
    pub width: usize,
    pub height: usize,
}

/// A map, and how well it keeps the tolerance. Its pixels stay where they were made; [`Stages::read`] gives them out.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    pub width: usize,
    pub height: usize,
    /// The largest |P|, Pa.
    pub peak: f32,
    /// The largest deviation from the f64 reference at 48 pixels, relative to the peak. The largest of all pixels can be
    /// several times that: six times was seen.
    pub error: f64,
    /// Points at which the waves of the elements were added up.
    pub evaluated: usize,
    pub by: By,
    /// How it was made, for people.
    pub how: String,
}

/// Who made a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// In f64, each pixel for itself.
    Reference,
    Cpu,
    /// By the CPU with samples in f64, since f32 does not keep the tolerance or has no room for such elements.
    CpuInF64,
    Gpu,
}

/// Why there is no map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
    #[error("a map of {0} x {1} pixels: it has one at least, and {MOST_PIXELS} at most")]
    NoPixels(usize, usize),
    #[error("the drive does not give every element of the array an amplitude and a phase that are numbers")]
    NoDrive,
    #[error("a mean needs a drive, and of the envelope a part from 0 to 1")]
    NoMean,
    #[error(
        "the plane is none: its axes span none, or its centre, size or tolerance are beyond what a scene has"
    )]
    NoPlane,
    #[error(
        "the plane comes nearer than a wavelength to the array: averages, radiation pressure and dents are of a plane that \
         stays clear of it"
    )]
    TooNear,
    #[error(
        "a liquid's surface is level: its plane lies parallel to the array, `x_axis` and `y_axis` without a part along z"
    )]
    NotLevel,
    #[error(
        "the plane and what a dent needs around it, 14 capillary lengths √(σ/ρg), are too wide: take a smaller plane, or a \
         liquid with less tension or more weight"
    )]
    TooManyCells,
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// What the plan and the transfer depend on: where the elements and the plane are, in what medium.
#[derive(Clone, Debug, PartialEq)]
struct Setting {
    /// With every element driven: which of them are makes no difference here.
    aperture: Aperture,
    plane: Plane,
}

/// What the pressure at the samples depends on.
#[derive(Clone, Debug, PartialEq)]
struct Sounding {
    setting: Setting,
    /// u of every element of the array; 0 for those that are off.
    excitation: Vec<Complex64>,
}

/// What the pixels' places depend on.
#[derive(Clone, Debug, PartialEq)]
struct Frame {
    setting: Setting,
    size: (usize, usize),
}

/// What the pixels depend on.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    sounding: Sounding,
    size: (usize, usize),
}

/// What the picture depends on.
#[derive(Clone, Debug, PartialEq)]
struct Painted {
    drawn: Drawn,
    by: By,
    colouring: Colouring,
}

/// Everything that a stage may need.
struct Job<'a> {
    wanted: Wanted<'a>,
    plan: &'a Plan,
    raster: &'a Raster,
    probes: &'a Probes,
    drawn: &'a Drawn,
}

/// A value and what it was made from.
#[derive(Clone, Debug)]
struct Kept<K, V> {
    key: Option<K>,
    value: V,
}

impl<K, V: Default> Default for Kept<K, V> {
    fn default() -> Self {
        Self { key: None, value: V::default() }
    }
}

impl<K: Clone + PartialEq, V> Kept<K, V> {
    /// The value for `key`, remade in place (its memory is worth keeping) if it was made from something else.
    fn update(&mut self, key: &K, remake: impl FnOnce(&mut V)) -> &V {
        let remake = |value: &mut V| {
            remake(value);
            Ok::<_, Infallible>(())
        };
        match self.try_update(key, remake) {
            Ok(value) => value,
        }
    }

    /// The same for what may fail; the value then belongs to nothing.
    fn try_update<E>(&mut self, key: &K, remake: impl FnOnce(&mut V) -> Result<(), E>) -> Result<&V, E> {
        if self.key.as_ref() != Some(key) {
            self.key = None;
            remake(&mut self.value)?;
            self.key = Some(key.clone());
        }
        Ok(&self.value)
    }
}

/// The stages of one evaluator.
#[derive(Debug)]
pub struct Stages {
    /// Everything in f64, pixel by pixel.
    exact: bool,
    gpu: Option<OnGpu>,
    cpu: OnCpu,
    plan: Kept<Setting, Option<Plan>>,
    raster: Kept<Frame, Option<(Raster, Probes)>>,
    map: Kept<Drawn, Option<Map>>,
    contours: Kept<(Drawn, Quantity, f32), Vec<Line>>,
    averaging: Averaging,
    work: Work,
}

impl Stages {
    pub fn new(evaluator: Evaluator) -> Self {
        Self {
            exact: matches!(evaluator, Evaluator::Reference),
            gpu: if let Evaluator::Gpu(gpu) = evaluator { Some(OnGpu::new(*gpu)) } else { None },
            cpu: OnCpu::default(),
            plan: Kept::default(),
            raster: Kept::default(),
            map: Kept::default(),
            contours: Kept::default(),
            averaging: Averaging::default(),
            work: Work::default(),
        }
    }

    /// Forgets every result, but for its memory and the work counted.
    pub fn forget(&mut self) {
        self.plan.key = None;
        self.raster.key = None;
        self.map.key = None;
        self.contours.key = None;
        self.averaging.forget();
        self.cpu.forget();
        if let Some(gpu) = &mut self.gpu {
            gpu.forget();
        }
    }

    /// How often each stage has run.
    pub fn work(&self) -> Work {
        self.work
    }

    /// The GPU, if there is one.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_ref().map(|gpu| &gpu.gpu)
    }

    /// Brings the map up to date.
    ///
    /// # Errors
    /// The plane is none, there are no pixels or more than [`MOST_PIXELS`], the drive is not one of this array, or the GPU failed.
    pub fn map(&mut self, wanted: &Wanted<'_>) -> Result<&Map, FieldError> {
        check_size(wanted.width, wanted.height)?;
        check_drive(wanted.aperture, wanted.drive)?;
        let drawn = Drawn::new(wanted, self.exact);
        let Self { gpu, cpu, plan, raster, map, work, exact, .. } = self;
        let map = map.try_update(&drawn, |map| {
            let setting = &drawn.sounding.setting;
            let plan = plan.update(setting, |plan| {
                work.plan += 1;
                let costs = if gpu.is_some() { Costs::GPU } else { Costs::CPU };
                *plan = Plan::new(&setting.aperture, &setting.plane, costs);
            });
            let plan = plan.as_ref().ok_or(FieldError::NoPlane)?;
            let raster = raster.update(&drawn.frame(), |pixels| {
                *pixels = Raster::new(plan, drawn.size).map(|raster| {
                    let probes = Probes::new(&setting.aperture, &raster);
                    (raster, probes)
                });
            });
            let (raster, probes) = raster.as_ref().ok_or(FieldError::NoPlane)?;
            let job = Job { wanted: *wanted, plan, raster, probes, drawn: &drawn };
            let on_gpu = match gpu {
                Some(gpu) if !plan.double => job.on_gpu(gpu, work)?,
                _ => None,
            };
            let made = on_gpu.unwrap_or_else(|| job.on_cpu(cpu, *exact, work));
            let (width, height) = drawn.size;
            let mut described = (raster.evaluated(plan), raster.describe(plan));
            let Made { by, peak, error } = if job.grid().is_some() && job.is_too_far_off(made.error) {
                // Where there is but little of a field on the plane, what samples leave out is much of that.
                let plan = &plan.direct("samples do not keep the tolerance");
                let raster = &Raster::new(plan, drawn.size).ok_or(FieldError::NoPlane)?;
                described = (raster.evaluated(plan), raster.describe(plan));
                Job { plan, raster, ..job }.on_cpu(cpu, *exact, work)
            } else {
                made
            };
            let (evaluated, how) = described;
            *map = Some(Map { width, height, peak, error, evaluated, by, how });
            Ok::<_, FieldError>(())
        })?;
        map.as_ref().ok_or(FieldError::NoPlane)
    }

    /// Complex pressure (Pa, peak) of every pixel of the map, row by row; the map is brought up to date first.
    ///
    /// # Errors
    /// As [`Stages::map`].
    pub fn read(&mut self, wanted: &Wanted<'_>) -> Result<Vec<Complex32>, FieldError> {
        let by = self.map(wanted)?.by;
        match &self.gpu {
            Some(gpu) if by == By::Gpu => Ok(gpu.read()?),
            _ => Ok(self.cpu.field().to_vec()),
        }
    }

    /// The map as colours r, g, b, a of every pixel, row by row; it is brought up to date first.
    ///
    /// # Errors
    /// As [`Stages::map`].
    pub fn colours(&mut self, wanted: &Wanted<'_>, colouring: &Colouring) -> Result<&[[u8; 4]], FieldError> {
        let Map { by, peak, .. } = *self.map(wanted)?;
        let painted = Painted { drawn: Drawn::new(wanted, self.exact), by, colouring: colouring.clone() };
        match &mut self.gpu {
            Some(gpu) if by == By::Gpu => Ok(gpu.colours(&painted, peak, &mut self.work)?),
            _ => Ok(self.cpu.colours(&painted, peak, &mut self.work)),
        }
    }
}

/// Who made the pixels, the largest |P| (Pa), and the error.
struct Made {
    by: By,
    peak: f32,
    error: f64,
}

impl Job<'_> {
    /// `None` where f32 does not keep the tolerance.
    fn on_gpu(&self, gpu: &mut OnGpu, work: &mut Work) -> Result<Option<Made>, GpuError> {
        if !gpu.pixels(self, work)? {
            return Ok(None);
        }
        let (peak, at_probes) = gpu.measure(&self.probes.pixels)?;
        let error = self.error(&at_probes, peak);
        Ok((!self.is_too_far_off(error)).then_some(Made { by: By::Gpu, peak, error }))
    }

    /// In f64 where f32 does not keep the tolerance.
    fn on_cpu(&self, cpu: &mut OnCpu, exact: bool, work: &mut Work) -> Made {
        let mut make = |by| {
            cpu.pixels(self, by != By::Cpu, work);
            let field = cpu.field();
            let peak = field::peak(field);
            let at_probes: Vec<_> = self.probes.pixels.iter().map(|&pixel| field[pixel]).collect();
            Made { by, peak, error: self.error(&at_probes, peak) }
        };
        match (exact, self.plan.double) {
            (true, _) => make(By::Reference),
            (false, true) => make(By::CpuInF64),
            (false, false) => {
                let made = make(By::Cpu);
                if self.is_too_far_off(made.error) { make(By::CpuInF64) } else { made }
            }
        }
    }

    /// Rounding in f32 is relative to what arrives, and where the elements cancel, the peak is less than that.
    fn is_too_far_off(&self, error: f64) -> bool {
        let tolerance = self.wanted.plane.tolerance;
        tolerance > 0.0 && PROBE_MARGIN * error > tolerance
    }

    /// The largest deviation of the values at the probes from the f64 reference, relative to `peak` (Pa).
    fn error(&self, at_probes: &[Complex32], peak: f32) -> f64 {
        let expected = self.probes.transfer.pressure(&self.drawn.sounding.excitation);
        let off = |(expected, got): (Complex64, &Complex32)| {
            (expected - Complex64::new(got.re.into(), got.im.into())).norm()
        };
        let largest = expected.into_iter().zip(at_probes).map(off).fold(0.0, f64::max);
        largest / f64::from(peak).max(f64::MIN_POSITIVE)
    }
}

impl Drawn {
    fn frame(&self) -> Frame {
        Frame { setting: self.sounding.setting.clone(), size: self.size }
    }

    fn new(wanted: &Wanted<'_>, exact: bool) -> Self {
        let mut plane = wanted.plane.clone();
        if exact {
            plane.tolerance = 0.0;
        }
        let setting = Setting::new(wanted.aperture, plane);
        let excitation = excitation(wanted.aperture, wanted.drive);
        Self { sounding: Sounding { setting, excitation }, size: (wanted.width, wanted.height) }
    }
}

impl Setting {
    fn new(aperture: &Aperture, plane: Plane) -> Self {
        let all = (0..aperture.positions.len()).collect();
        Self { aperture: Aperture { driven: all, ..aperture.clone() }, plane }
    }
}

fn check_size(width: usize, height: usize) -> Result<(), FieldError> {
    let is_map = width.checked_mul(height).is_some_and(|pixels| (1..=MOST_PIXELS).contains(&pixels));
    if is_map { Ok(()) } else { Err(FieldError::NoPixels(width, height)) }
}

/// What is no number would go unseen: no peak and no error is as large as a NaN.
fn check_drive(aperture: &Aperture, drive: &Drive) -> Result<(), FieldError> {
    let is_drive = |values: &[f64]| {
        values.len() == aperture.positions.len() && values.iter().all(|value| value.is_finite())
    };
    if is_drive(&drive.amplitudes) && is_drive(&drive.phases) { Ok(()) } else { Err(FieldError::NoDrive) }
}

/// u of every element of the array; 0 for those that are off.
fn excitation(aperture: &Aperture, drive: &Drive) -> Vec<Complex64> {
    let mut excitation = vec![Complex64::ZERO; aperture.positions.len()];
    for (&n, u) in aperture.driven.iter().zip(drive.excitation(&aperture.driven)) {
        excitation[n] = u;
    }
    excitation
}

/// The [`PROBES`] of so many pixels, spread without pattern.
fn probed(pixels: usize) -> Vec<usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    (1..=PROBES).map(|i| ((i as f64 * GOLDEN).fract() * pixels as f64) as usize).collect()
}

/// Pixels at which the error is measured, with their f64 transfer from every element.
#[derive(Clone, Debug)]
struct Probes {
    pixels: Vec<usize>,
    transfer: acoustics::Transfer,
}

impl Probes {
    fn new(aperture: &Aperture, raster: &Raster) -> Self {
        let pixels = probed(raster.len());
        let samples: Samples = raster.pixels();
        let points: Vec<_> = pixels.iter().map(|&pixel| samples.point(pixel)).collect();
        Self { pixels, transfer: aperture.transfer(&points) }
    }
}
