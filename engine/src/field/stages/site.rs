//! The site of a quantity: pixels or cells, and the samples it requires.
//!
//! A single part of the sound of one drive is formed at the pixels. Squares of several drives or parts, and the
//! pressure on a liquid, are formed at *cells*, six per wavelength, since a square has twice the bandwidth and all
//! later steps (mean, depression, pixels) are linear: fewer complex numbers are interpolated. Squaring doubles
//! relative errors; where errors are differences of squares, the samples keep two fifths of the tolerance. Where
//! cells would be too close to the array, pixels are used, except for a liquid. A magnitude such as the intensity
//! is not band-limited: it is always formed at the pixels.

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::field::cells::Cells;
use crate::field::interpolation::Resampling;
use crate::field::plan::{Costs, Grid};
use crate::field::quantity::{ALONG, NORMAL, Norm, PRESSURE, Part};
use crate::field::slope::FINEST_IN_F32;
use crate::field::stages::request::{FieldError, Request, Setting};
use crate::field::stages::within;
use crate::field::vicinity::{LeftOut, Vicinity};
use crate::field::{plan::Plan, raster::Raster};
use crate::scene::Plane;

/// Accuracy of a square in f32.
const FINEST: f64 = 1e-6;
/// Error factor of refined samples relative to the required one; and the finest tolerance of f32 interpolation.
const FINER: f64 = 0.4;
const FINEST_SAMPLES: f64 = 2e-7;
/// The sound's part of the tolerance, if errors are differences of squares.
const SHARE: f64 = 0.4;
/// Pairs of a cell and an element that may be evaluated in f64.
const MOST_DIRECT: usize = 1 << 27;
/// Distance from the plane to the walls in capillary lengths: the outside changes the depression by a relative e^-14.
const TO_THE_WALLS: f64 = 14.0;

/// Distance (m) from the plane within which sound presses on the skin, too.
const BESIDE_SKIN: f64 = 0.04;

/// The inputs of a site.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SiteKey {
    /// Array with the displayed plane and the tolerance of the samples.
    pub(super) setting: Setting,
    /// Bit set of the parts of the sound.
    pub(super) parts: u8,
    by_cells: Option<ByCells>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct ByCells {
    /// m
    margin: f64,
    accuracy: f64,
    is_liquid: bool,
}

/// The samples of a plane, and the cells, if there are any.
#[derive(Debug)]
pub(super) struct Site {
    pub(super) plan: Plan,
    pub(super) cells: Option<Filled>,
    /// The plane's axes and its normal.
    pub(super) axes: [DVec3; 3],
}

/// Cells and their interpolation from the samples; without, each is evaluated.
#[derive(Debug)]
pub(super) struct Filled {
    pub(super) cells: Cells,
    pub(super) weights: Option<Weights>,
}

/// Weights from samples to a lattice, across and up, of values and of slopes.
#[derive(Debug)]
pub(super) struct Weights {
    values: [Resampling; 2],
    slopes: [Resampling; 2],
}

impl Weights {
    /// Slopes are left out if not needed.
    pub(super) fn new(grid: &Grid, parts: u8, places: [&mut dyn Iterator<Item = f64>; 2]) -> Self {
        let places = places.map(|places| places.collect::<Vec<_>>());
        let along = |axis: usize| places[axis].iter().copied();
        Self {
            values: [0, 1].map(|axis| grid.resampling(axis, along(axis))),
            slopes: [0, 1].map(|axis| match parts & ALONG {
                0 => Resampling::default(),
                _ => grid.slopes(axis, along(axis)),
            }),
        }
    }

    /// Across and up.
    pub(super) fn of(&self, part: Part) -> [&Resampling; 2] {
        match part {
            Part::Pressure | Part::Normal => [&self.values[0], &self.values[1]],
            Part::AlongX => [&self.slopes[0], &self.values[1]],
            Part::AlongY => [&self.values[0], &self.slopes[1]],
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.values[1].len()
    }
}

impl SiteKey {
    /// Pressures on liquids, and in maps that are not exact squares of several drives or parts, are formed at cells;
    /// everything else at the pixels.
    pub(super) fn new(request: &Request, exact: bool) -> Self {
        let declaration = request.quantity.declaration();
        let is_direct = exact || request.plane.tolerance == 0.0;
        let is_sum = request.drives.len() > 1 || declaration.parts.count_ones() > 1;
        let by_cells = declaration.is_square && (declaration.is_pressed() || (is_sum && !is_direct));
        // Squares cannot be interpolated across the surfaces of bodies.
        let is_open = request.aperture.bodies.is_empty();
        if by_cells && !is_open && declaration.is_pressed() {
            return Self::by_cells(request, exact).direct();
        }
        let by_cells = by_cells && is_open;
        if by_cells { Self::by_cells(request, exact) } else { Self::by_pixels(request, exact) }
    }

    /// The site at the pixels in any case.
    pub(super) fn by_pixels(request: &Request, exact: bool) -> Self {
        let share = match request.quantity.declaration().norm {
            Norm::Value | Norm::Pressure => 1.0,
            Norm::Difference => SHARE,
        };
        let tolerance = if exact { 0.0 } else { share * request.plane.tolerance };
        Self::with(request, tolerance, None)
    }

    fn by_cells(request: &Request, exact: bool) -> Self {
        let declaration = request.quantity.declaration();
        let wanted = if exact { 0.0 } else { request.plane.tolerance };
        // Invalid tolerances are passed on for the plan to refuse.
        let tolerance = if (0.0..FINEST).contains(&wanted) { FINEST } else { wanted };
        // A square with an error of a millionth of the largest has a root with an error of a thousandth near 0:
        // the rest of the way is mended pixel by pixel.
        let accuracy = match (declaration.of_skin, declaration.is_root) {
            // Levels are read far below the largest.
            (true, _) => tolerance.powi(2).max(1e-8),
            (false, true) => tolerance.powf(1.5).max(1e-8),
            (false, false) => tolerance,
        };
        let is_liquid = declaration.of_liquid;
        let margin = match (is_liquid, declaration.of_skin) {
            (true, _) => TO_THE_WALLS * request.liquid.capillary_length(),
            (false, true) => BESIDE_SKIN,
            (false, false) => 0.0,
        };
        Self::with(request, tolerance, Some(ByCells { margin, accuracy, is_liquid }))
    }

    /// The same without samples: pixel by pixel, or cell by cell.
    pub(super) fn direct(&self) -> Self {
        let mut direct = self.clone();
        direct.setting.plane.tolerance = 0.0;
        direct
    }

    pub(super) fn is_direct(&self) -> bool {
        self.setting.plane.tolerance == 0.0
    }

    /// The same cells from finer samples, after an error `times` the promised one; `None` beyond the accuracy of f32
    /// interpolation. For small differences of squares, sample errors are amplified.
    pub(super) fn finer(&self, times: f64) -> Option<Self> {
        let mut finer = self.clone();
        finer.setting.plane.tolerance *= FINER / times;
        (self.by_cells.is_some() && finer.setting.plane.tolerance >= FINEST_SAMPLES).then_some(finer)
    }

    fn with(request: &Request, tolerance: f64, by_cells: Option<ByCells>) -> Self {
        let setting = Setting::new(&request.aperture, Plane { tolerance, ..request.plane.clone() });
        Self { setting, parts: request.quantity.declaration().parts, by_cells }
    }
}

impl Site {
    /// # Errors
    /// An invalid plane; for quantities that need cells, a plane that is too near, too wide or not level.
    pub(super) fn new(key: &SiteKey, costs: Costs) -> Result<Self, FieldError> {
        let Setting { aperture, plane } = &key.setting;
        let (x, y) = plane.axes().ok_or(FieldError::NoPlane)?;
        let axes = [x, y, x.cross(y)];
        let Some(ByCells { margin, accuracy, is_liquid }) = key.by_cells else {
            let mut plan = Plan::new(aperture, plane, costs).ok_or(FieldError::NoPlane)?;
            let is_coarse = plane.tolerance >= FINEST_IN_F32;
            let by_differences = key.parts & NORMAL != 0 || (key.parts != PRESSURE && plan.grid.is_none());
            plan.double |= by_differences && !is_coarse;
            return Ok(Self { plan, cells: None, axes });
        };
        if is_liquid && axes[2].z.abs() < 1.0 - 1e-9 {
            return Err(FieldError::NotLevel);
        }
        let cells = Cells::new(aperture, plane, margin, accuracy).ok_or(FieldError::TooManyCells)?;
        if key.is_direct() {
            if cells.count().saturating_mul(aperture.positions.len()) > MOST_DIRECT {
                return Err(FieldError::TooManyCells);
            }
            let reason = "every cell is evaluated: samples do not keep the tolerance".to_owned();
            let plan = Plan { plane: cells.plane.clone(), grid: None, double: true, reason };
            return Ok(Self { cells: Some(Filled { cells, weights: None }), plan, axes });
        }
        let values = cells.count() * key.parts.count_ones() as usize;
        let mut plan =
            Plan::new(aperture, &cells.plane, costs.for_values(values)).ok_or(FieldError::NoPlane)?;
        plan.double |= key.parts & NORMAL != 0 && cells.plane.tolerance < FINEST_IN_F32;
        let grid = plan.grid.as_ref().ok_or(FieldError::TooNear)?;
        // The outermost cells have their centres half a step inside.
        let (half, half_step) = (cells.plane.size.y / 2.0, cells.step / 2.0);
        if grid.covered.start > half_step - half || grid.covered.end < half - half_step {
            return Err(FieldError::TooNear);
        }
        let weights = Weights::new(grid, key.parts, [&mut cells.places(0), &mut cells.places(1)]);
        Ok(Self { cells: Some(Filled { cells, weights: Some(weights) }), plan, axes })
    }
}

/// The pixels of one size on a site.
#[derive(Debug)]
pub(super) enum Frame {
    /// The quantity is formed at them, from samples for interpolated pixels.
    Pixels { raster: Raster, weights: Option<Weights> },
    /// Pixels interpolated from the cells, across and up.
    Cells { to_pixels: [Resampling; 2] },
}

impl Frame {
    /// `None` for an invalid plane.
    pub(super) fn new(key: &SiteKey, site: &Site, (width, height): (usize, usize)) -> Option<Self> {
        let size = key.setting.plane.size;
        let column = |i: usize| size.x * ((i as f64 + 0.5) / width as f64 - 0.5);
        let row = |j: usize| size.y * ((j as f64 + 0.5) / height as f64 - 0.5);
        if let Some(Filled { cells, .. }) = &site.cells {
            let across = cells.resampling(0, (0..width).map(column));
            let up = cells.resampling(1, (0..height).map(row));
            return Some(Self::Cells { to_pixels: [across, up] });
        }
        let raster = Raster::new(&site.plan, (width, height))?;
        let rows = raster.interpolated.clone();
        let grid = site.plan.grid.as_ref().filter(|_| !rows.is_empty());
        let weights =
            grid.map(|grid| Weights::new(grid, key.parts, [&mut (0..width).map(column), &mut rows.map(row)]));
        Some(Self::Pixels { raster, weights })
    }

    /// The pixels of a request that are within bodies, on a plane with these axes and normal.
    pub(super) fn within(&self, request: &Request, axes: [DVec3; 3]) -> Vec<usize> {
        let Request { aperture, plane, size, quantity, .. } = request;
        match self {
            Self::Pixels { raster, .. } => within::within(aperture, raster),
            Self::Cells { .. } => {
                within::within_cells(aperture, (plane, axes), *size, quantity.declaration().of_skin)
            }
        }
    }

    /// The pixels that do not count for the peak; cells are farther than a wavelength from all elements.
    pub(super) fn left_out(&self, aperture: &Aperture) -> LeftOut {
        match self {
            Self::Pixels { raster, .. } => Vicinity::new(aperture).of(&raster.pixels()),
            Self::Cells { .. } => LeftOut::default(),
        }
    }
}
