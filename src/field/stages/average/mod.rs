//! What sound does on average over the drives that are played one after the other: its mean-square pressure, the
//! pressure on a surface that reflects it, and the dent of a liquid.
//!
//! The complex pressure at the samples of a plan becomes its squares at [`Cells`], which hold twice the band; whatever is
//! linear in the squares (their mean, the dent) happens there, and the pixels are interpolated from that.

mod on_cpu;
mod on_gpu;

use glam::{DVec2, DVec3};
use num_complex::{Complex32, Complex64};

use crate::acoustics::{self, Aperture};
use crate::drive::Drive;
use crate::field::cells::Cells;
use crate::field::contour::Line;
use crate::field::interpolation::Resampling;
use crate::field::plan::Costs;
use crate::field::stages::contours;
use crate::field::stages::{
    By, FieldError, Kept, Setting, Stages, Work, check_drive, check_size, excitation, probed,
};
use crate::field::{Colouring, Gpu, Plan, Quantity};
use crate::scene::{Liquid, Plane};
use crate::surface::{Dent, Reflector, Tank};
use on_cpu::OnCpu;
use on_gpu::OnGpu;

/// What f32 keeps of a square.
const FINEST: f64 = 1e-6;
/// Capillary lengths from the plane to the walls: what lies beyond changes the dent by e^-14 of itself.
const TO_THE_WALLS: f64 = 14.0;

/// What is averaged.
#[derive(Clone, Debug, PartialEq)]
pub enum Mean {
    /// |P|² (Pa², peak).
    Square,
    /// Radiation pressure (Pa) on the plane as a reflecting surface.
    Radiation(Reflector),
    /// The depth (m) to which it presses a liquid whose surface the plane is.
    Dent(Reflector, Liquid),
}

impl Mean {
    /// What of a pixel is shown.
    pub fn quantity(&self) -> Quantity {
        match self {
            Self::Square => Quantity::MeanRms,
            Self::Radiation(_) => Quantity::Radiation,
            Self::Dent(..) => Quantity::Dent,
        }
    }

    fn reflector(&self) -> Option<Reflector> {
        match self {
            Self::Square => None,
            Self::Radiation(reflector) | Self::Dent(reflector, _) => Some(*reflector),
        }
    }

    /// m
    fn margin(&self) -> f64 {
        match self {
            Self::Square | Self::Radiation(_) => 0.0,
            Self::Dent(_, liquid) => TO_THE_WALLS * liquid.capillary_length(),
        }
    }
}

/// What an average is made from.
#[derive(Clone, Debug)]
pub struct Average<'a> {
    pub aperture: &'a Aperture,
    pub plane: &'a Plane,
    /// Each is played for the same time.
    pub drives: &'a [Drive],
    pub mean: Mean,
    /// The part of the steady radiation pressure that the envelope leaves, 0 to 1.
    pub part: f64,
    /// Pixels.
    pub width: usize,
    pub height: usize,
}

/// An average as a map. Its pixels stay where they were made; [`Stages::read_average`] gives them out.
#[derive(Clone, Debug)]
pub struct AverageMap {
    /// The largest value: Pa (RMS), Pa, or m.
    pub largest: f32,
    /// The largest deviation from the f64 reference at 48 pixels, relative to the largest value: of RMS pressure, or of
    /// radiation pressure, which a dent follows.
    pub error: f64,
    pub by: By,
    /// N that press on the plane; 0 where that was not asked for.
    pub force: f64,
    pub dent: Option<Dent>,
    /// The cells in which the dent is given.
    pub tank: Option<Tank>,
    /// How it was made, for people.
    pub how: String,
}

/// What the cells depend on.
#[derive(Clone, Debug, PartialEq)]
struct Basin {
    /// With the plane that is shown.
    setting: Setting,
    margin: f64,
    accuracy: f64,
    /// Slopes are wanted too.
    reflects: bool,
}

impl Basin {
    fn points_per_probe(&self) -> usize {
        if self.reflects { 5 } else { 1 }
    }
}

/// What the squares depend on.
#[derive(Clone, Debug, PartialEq)]
struct Sounding {
    basin: Basin,
    excitations: Vec<Vec<Complex64>>,
    reflector: Option<Reflector>,
}

/// What the pixels depend on.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    sounding: Sounding,
    mean: Mean,
    part: f64,
    size: (usize, usize),
}

/// The cells with what fills them.
#[derive(Debug)]
struct Filled {
    cells: Cells,
    plan: Plan,
    /// From samples to cells, of values and of slopes, across and up.
    values: [Resampling; 2],
    slopes: [Resampling; 2],
}

/// From cells to pixels, and what the pixels are compared with.
#[derive(Debug)]
struct Frame {
    across: Resampling,
    up: Resampling,
    probes: Vec<usize>,
    /// To each probe, and where there is a reflector to four points around it: a hair before and behind it along each axis.
    transfer: acoustics::Transfer,
}

/// Mean squares at the cells: |P|² (Pa²), and radiation pressure (Pa; 0 where nobody asked).
type Squares = Vec<[f64; 2]>;

/// The stages with what each made last.
#[derive(Debug, Default)]
pub(super) struct Averaging {
    filled: Kept<Basin, Option<Filled>>,
    tank: Kept<Basin, Option<Tank>>,
    frame: Kept<(Basin, (usize, usize)), Option<Frame>>,
    cpu: OnCpu,
    gpu: OnGpu,
    map: Kept<Drawn, Option<AverageMap>>,
    picture: Kept<(Drawn, Colouring), Vec<[u8; 4]>>,
    contours: Kept<(Drawn, f32), Vec<Line>>,
}

/// Everything that a stage may need.
struct Job<'a> {
    wanted: &'a Average<'a>,
    drawn: &'a Drawn,
    filled: &'a Filled,
    tank: Option<&'a Tank>,
    frame: &'a Frame,
}

/// What a map is described by.
struct Made {
    /// The largest value of the pixels.
    largest: f32,
    /// The pixels at the probes.
    at_probes: Vec<Complex32>,
    squares: Squares,
    dent: Option<Dent>,
}

impl Stages {
    /// Brings an average up to date.
    ///
    /// # Errors
    /// The plane is none, comes too near to the array, or (for a liquid) is not level; there are no drives, or none of this array, or
    /// no pixels; or the GPU failed.
    pub fn average(&mut self, wanted: &Average<'_>) -> Result<&AverageMap, FieldError> {
        let gpu = self.gpu.as_ref().map(|gpu| &gpu.gpu);
        self.averaging.map(wanted, self.exact, gpu, &mut self.work)
    }

    /// The values of every pixel, row by row: Pa (RMS), Pa, or m.
    ///
    /// # Errors
    /// As [`Stages::average`].
    pub fn read_average(&mut self, wanted: &Average<'_>) -> Result<Vec<f32>, FieldError> {
        let by = self.average(wanted)?.by;
        let quantity = wanted.mean.quantity();
        let shown = |values: &[Complex32]| values.iter().map(|&value| quantity.of(value)).collect();
        let Averaging { cpu, gpu, .. } = &self.averaging;
        match &self.gpu {
            Some(on_gpu) if by == By::Gpu => Ok(shown(&on_gpu.gpu.read(&gpu.pixels)?)),
            _ => Ok(shown(&cpu.pixels)),
        }
    }

    /// The pixels of another shape of the same surface, m, from its depth (m) in every cell of the map's tank.
    ///
    /// # Errors
    /// As [`Stages::average`].
    pub fn read_shape(&mut self, wanted: &Average<'_>, depth: &[f64]) -> Result<Vec<f32>, FieldError> {
        self.average(wanted)?;
        let Averaging { frame, filled, cpu, .. } = &mut self.averaging;
        let (Some(frame), Some(filled)) = (&frame.value, &filled.value) else {
            return Err(FieldError::NoPlane);
        };
        let size = wanted.width * wanted.height;
        let shape = cpu.shape(depth, filled.cells.counts[0], [&frame.across, &frame.up], size);
        Ok(shape.iter().map(|value| value.re).collect())
    }

    /// An average as colours r, g, b, a of every pixel, row by row.
    ///
    /// # Errors
    /// As [`Stages::average`].
    pub fn average_colours(
        &mut self,
        wanted: &Average<'_>,
        colouring: &Colouring,
    ) -> Result<&[[u8; 4]], FieldError> {
        let AverageMap { by, largest, .. } = *self.average(wanted)?;
        let key = (Drawn::new(wanted, self.exact)?, colouring.clone());
        let Self { averaging: Averaging { picture, cpu, gpu, .. }, gpu: on_gpu, work, .. } = self;
        let colours = picture.try_update(&key, |colours| {
            work.picture += 1;
            match on_gpu {
                Some(on_gpu) if by == By::Gpu => {
                    on_gpu.gpu.colours(&gpu.pixels, colouring, largest, colours)?;
                }
                _ => colouring.colours(&cpu.pixels, largest, colours),
            }
            Ok::<_, FieldError>(())
        })?;
        Ok(colours)
    }

    /// The lines on which an average is this part of its largest number.
    ///
    /// # Errors
    /// As [`Stages::average`].
    pub fn average_contours(&mut self, wanted: &Average<'_>, part: f32) -> Result<&[Line], FieldError> {
        let AverageMap { by, largest, .. } = *self.average(wanted)?;
        let key = (Drawn::new(wanted, self.exact)?, part);
        let Self { averaging: Averaging { contours, cpu, gpu, .. }, gpu: on_gpu, work, .. } = self;
        let lines = contours.try_update(&key, |lines| {
            work.contours += 1;
            let of = |pixels: &[Complex32]| {
                contours::of_pixels(pixels, wanted.width, wanted.mean.quantity(), part * largest)
            };
            *lines = match on_gpu {
                Some(on_gpu) if by == By::Gpu => of(&on_gpu.gpu.read(&gpu.pixels)?),
                _ => of(&cpu.pixels),
            };
            Ok::<_, FieldError>(())
        })?;
        Ok(lines)
    }
}

impl Averaging {
    pub(super) fn forget(&mut self) {
        self.filled.key = None;
        self.frame.key = None;
        self.map.key = None;
        self.picture.key = None;
        self.contours.key = None;
        self.cpu.forget();
        self.gpu.forget();
    }

    fn map(
        &mut self,
        wanted: &Average<'_>,
        exact: bool,
        gpu: Option<&Gpu>,
        work: &mut Work,
    ) -> Result<&AverageMap, FieldError> {
        check_size(wanted.width, wanted.height)?;
        wanted.drives.iter().try_for_each(|drive| check_drive(wanted.aperture, drive))?;
        if wanted.drives.is_empty() || !(0.0..=1.0).contains(&wanted.part) {
            return Err(FieldError::NoMean);
        }
        let drawn = Drawn::new(wanted, exact)?;
        let Self { filled, tank, frame, cpu, gpu: on_gpu, map, .. } = self;
        let map = map.try_update(&drawn, |map| {
            let basin = &drawn.sounding.basin;
            let filled = filled.try_update(basin, |filled| {
                work.plan += 1;
                *filled = Some(Filled::new(basin, if gpu.is_some() { Costs::GPU } else { Costs::CPU })?);
                Ok::<_, FieldError>(())
            })?;
            let filled = filled.as_ref().ok_or(FieldError::NoPlane)?;
            let tank = match &wanted.mean {
                Mean::Dent(..) => tank.update(basin, |tank| *tank = Some(filled.cells.tank())).as_ref(),
                Mean::Square | Mean::Radiation(_) => None,
            };
            let frame = frame.update(&(basin.clone(), drawn.size), |frame| {
                *frame = Frame::new(basin, &filled.cells, drawn.size);
            });
            let frame = frame.as_ref().ok_or(FieldError::NoPlane)?;
            let job = Job { wanted, drawn: &drawn, filled, tank, frame };
            *map = Some(job.run(exact, gpu, on_gpu, cpu, work)?);
            Ok::<_, FieldError>(())
        })?;
        map.as_ref().ok_or(FieldError::NoPlane)
    }
}

impl Job<'_> {
    /// By the GPU where there is one, else by the CPU, in f64 where f32 does not keep the tolerance.
    fn run(
        &self,
        exact: bool,
        gpu: Option<&Gpu>,
        on_gpu: &mut OnGpu,
        on_cpu: &mut OnCpu,
        work: &mut Work,
    ) -> Result<AverageMap, FieldError> {
        if exact {
            return Ok(self.described(By::Reference, self.on_cpu(on_cpu, true, work)));
        }
        let tolerance = self.wanted.plane.tolerance;
        let keeps = |map: &AverageMap| tolerance == 0.0 || map.error <= tolerance;
        if !self.filled.plan.double {
            let map = match gpu.map(|gpu| self.on_gpu(gpu, on_gpu, work)).transpose()?.flatten() {
                Some(made) => self.described(By::Gpu, made),
                None => self.described(By::Cpu, self.on_cpu(on_cpu, false, work)),
            };
            if keeps(&map) {
                return Ok(map);
            }
        }
        Ok(self.described(By::CpuInF64, self.on_cpu(on_cpu, true, work)))
    }

    fn described(&self, by: By, made: Made) -> AverageMap {
        let Made { largest, at_probes, squares, dent } = made;
        let Drawn { sounding, part, .. } = self.drawn;
        let Cells { counts: [columns, rows], step, .. } = self.filled.cells;
        let size = sounding.basin.setting.plane.size;
        AverageMap {
            largest,
            error: self.frame.error(sounding, *part, &at_probes, &squares),
            by,
            force: self.filled.cells.integral(size, squares.iter().map(|[_, radiation]| radiation * part)),
            dent,
            tank: self.tank.cloned(),
            how: format!(
                "{}; squares at {columns} x {rows} cells of {:.2} mm",
                self.filled.plan.reason,
                step * 1e3
            ),
        }
    }
}

impl Drawn {
    fn new(wanted: &Average<'_>, exact: bool) -> Result<Self, FieldError> {
        if let Mean::Dent(..) = wanted.mean {
            let (x, y) = wanted.plane.axes().ok_or(FieldError::NoPlane)?;
            if x.cross(y).z.abs() < 1.0 - 1e-9 {
                return Err(FieldError::NotLevel);
            }
        }
        let tolerance = match wanted.plane.tolerance {
            tolerance if tolerance > 0.0 && !exact => tolerance.max(FINEST),
            _ => FINEST,
        };
        // The root of a square that is off by a millionth of the largest is off by a thousandth where it should be 0; but windows
        // leak far less there than where they are worst.
        let accuracy = if wanted.mean == Mean::Square { tolerance.powf(1.5).max(1e-8) } else { tolerance };
        let setting = Setting::new(wanted.aperture, Plane { tolerance, ..wanted.plane.clone() });
        let excitations = wanted.drives.iter().map(|drive| excitation(wanted.aperture, drive)).collect();
        let reflector = wanted.mean.reflector();
        let basin = Basin { setting, margin: wanted.mean.margin(), accuracy, reflects: reflector.is_some() };
        Ok(Self {
            sounding: Sounding { basin, excitations, reflector },
            mean: wanted.mean.clone(),
            part: wanted.part,
            size: (wanted.width, wanted.height),
        })
    }
}

impl Filled {
    fn new(basin: &Basin, costs: Costs) -> Result<Self, FieldError> {
        let Setting { aperture, plane } = &basin.setting;
        let cells =
            Cells::new(aperture, plane, basin.margin, basin.accuracy).ok_or(FieldError::TooManyCells)?;
        // A pressure, and where there is a reflector two slopes.
        let values = cells.len() * if basin.reflects { 3 } else { 1 };
        let plan = Plan::new(aperture, &cells.plane, costs.for_values(values)).ok_or(FieldError::NoPlane)?;
        let grid = plan.grid.as_ref().ok_or(FieldError::TooNear)?;
        let half = cells.plane.size.y / 2.0;
        if grid.covered.start > cells.step - half || grid.covered.end < half - cells.step {
            return Err(FieldError::TooNear);
        }
        let values = [0, 1].map(|axis| grid.resampling(axis, cells.places(axis)));
        let slopes = [0, 1].map(|axis| grid.slopes(axis, cells.places(axis)));
        Ok(Self { values, slopes, cells, plan })
    }
}

impl Frame {
    /// m, from a probe to its neighbours: far enough for f64, and much less than a wavelength.
    const HAIR: f64 = 1e-3;

    fn new(basin: &Basin, cells: &Cells, (width, height): (usize, usize)) -> Option<Self> {
        let Setting { aperture, plane } = &basin.setting;
        let DVec2 { x, y } = plane.size;
        let column = |i: usize| x * ((i as f64 + 0.5) / width as f64 - 0.5);
        let row = |j: usize| y * ((j as f64 + 0.5) / height as f64 - 0.5);
        let probes = probed(width * height);
        let (x_axis, y_axis) = plane.axes()?;
        let hair = Self::HAIR * aperture.wavelength();
        let around = |&pixel: &usize| {
            let place = plane.centre + x_axis * column(pixel % width) + y_axis * row(pixel / width);
            let directions = [DVec3::ZERO, x_axis, -x_axis, y_axis, -y_axis];
            directions.map(|direction| place + hair * direction).into_iter().take(basin.points_per_probe())
        };
        let points: Vec<_> = probes.iter().flat_map(around).collect();
        Some(Self {
            across: cells.resampling(0, (0..width).map(column)),
            up: cells.resampling(1, (0..height).map(row)),
            transfer: aperture.transfer(&points),
            probes,
        })
    }

    /// The largest deviation at the probes, relative to the largest value of all cells.
    fn error(&self, sounding: &Sounding, part: f64, at_probes: &[Complex32], squares: &Squares) -> f64 {
        let hair = 2.0 * Self::HAIR * sounding.basin.setting.aperture.wavelength();
        let mut expected = vec![0.0; self.probes.len()];
        for excitation in &sounding.excitations {
            let pressure = self.transfer.pressure(excitation);
            let around = pressure.chunks_exact(sounding.basin.points_per_probe());
            for (expected, around) in expected.iter_mut().zip(around) {
                let slope = |ahead: usize| (around[ahead] - around[ahead + 1]) / hair;
                *expected += match sounding.reflector {
                    None => around[0].norm_sqr(),
                    Some(reflector) => part * reflector.pressure(around[0], [slope(1), slope(3)]),
                } / sounding.excitations.len() as f64;
            }
        }
        let is_square = sounding.reflector.is_none();
        let shown = |value: f64| if is_square { value.max(0.0).sqrt() } else { value };
        let of_cell =
            |[square, radiation]: &[f64; 2]| shown(if is_square { *square } else { part * radiation });
        let largest = squares.iter().map(of_cell).fold(f64::MIN_POSITIVE, f64::max);
        let of_probe = |value: &Complex32| shown(f64::from(if is_square { value.re } else { value.im }));
        let off = |(expected, got): (&f64, &Complex32)| (shown(*expected) - of_probe(got)).abs();
        expected.iter().zip(at_probes).map(off).fold(0.0, f64::max) / largest
    }
}
