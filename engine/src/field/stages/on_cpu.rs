//! The stages on the CPU.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::field::gpu::Gpu;
use crate::field::interpolation::{Between, Resampling, interpolate};
use crate::field::plan::F32_ERROR;
use crate::field::quantity::{Declaration, Norm, PRESSURE, Part, Sound};
use crate::field::slope::{SoundTransfer, part_on_cpu};
use crate::field::stages::bodies::{self, Band, Places};
use crate::field::stages::caustic::Caustic;
use crate::field::stages::depression::Depression;
use crate::field::stages::job::{FormedKey, Job};
use crate::field::stages::kept::Kept;
use crate::field::stages::lattice::{Lattice, RUN, Share};
use crate::field::stages::probes::AtProbes;
use crate::field::stages::request::{Pressed, Request};
use crate::field::stages::samples::{Samples, Superposition, sampled};
use crate::field::stages::site::{Filled, Frame, SiteKey, Weights};
use crate::field::stages::skin::{FLOOR, OfSkin, Purpose, SkinMotion};
use crate::field::stages::{Work, weakest};
use crate::field::{self, raster::Raster};
use crate::gauge::Gauge;
use crate::scene::Liquid;
use crate::simd::larger;
use crate::surface::{Dent, Tank};

/// Drives with samples in memory at the same time.
const TOGETHER: usize = 64;
/// Number of shares of the drives for parallel work, and limit of their cells in total. It is independent of the
/// threads, so that sums are, too.
const SHARES: usize = 8;
const MOST_SHARED_CELLS: usize = 1 << 22;
/// Pixels with sound in memory at the same time.
const BAND: usize = 1 << 22;
/// Bytes that are reused for another site.
const MOST_REUSED: usize = 64 << 20;

#[derive(Debug, Default)]
pub(super) struct OnCpu {
    /// Site of the latest map.
    site: Option<SiteKey>,
    superposition: Superposition,
    /// Samples of a single drive, in f64 or not.
    samples: Kept<SampledKey, Samples>,
    /// Its sound at the pixels, if it fits one band.
    at_pixels: Kept<(SampledKey, (usize, usize)), Lattice>,
    /// Where bodies are heard in some rows of pixels.
    places: Kept<PlacesKey, Places>,
    shares: Vec<Share>,
    /// Means of the formula over the drives, per cell.
    cells: Kept<FormedKey, Vec<f64>>,
    tank: Kept<SiteKey, Option<Tank>>,
    response: Kept<(FormedKey, Liquid), Dent>,
    skin: OfSkin,
    caustic: Caustic,
    between: Between,
    work: Work,
    /// Progress over the samples of all drives.
    pub(super) progress: Gauge,
}

/// A site, the size of its map, and the first and last row of a band of pixels.
type PlacesKey = (SiteKey, (usize, usize), (usize, usize));

/// The inputs of a drive's samples.
#[derive(Clone, Debug, PartialEq)]
struct SampledKey {
    site: SiteKey,
    excitation: Vec<Complex64>,
    double: bool,
}

/// The results, and those for comparison with the reference.
pub(super) struct Made {
    pub(super) peak: f32,
    /// The largest magnitude of the pixels that do not count for the peak.
    pub(super) left_out: f32,
    /// The bound of rounding that all values stay below, of a silent map.
    pub(super) rounding: f64,
    pub(super) at_probes: AtProbes,
    /// Reference of the relative error.
    pub(super) relative_to: f32,
}

impl OnCpu {
    pub(super) fn forget(&mut self) {
        let old = std::mem::take(self);
        let Self {
            site, mut superposition, mut samples, mut at_pixels, shares, mut skin, between, work, ..
        } = old;
        superposition.forget();
        skin.forget();
        (samples.key, at_pixels.key) = (None, None);
        *self =
            Self { site, superposition, samples, at_pixels, shares, skin, between, work, ..Self::default() };
    }

    /// Goes to the site of a job. The memory that a very large one took is given back: the next may be small, or need
    /// none of it.
    fn enter(&mut self, site: &SiteKey) {
        if self.site.as_ref() == Some(site) {
            return;
        }
        if self.bytes() > MOST_REUSED {
            let Self { superposition, work, progress, .. } = std::mem::take(self);
            *self = Self { superposition, work, progress, ..Self::default() };
        }
        self.site = Some(site.clone());
    }

    /// Bytes of the values at pixels and cells, and of those between.
    fn bytes(&self) -> usize {
        let of_cells =
            (self.cells.value.capacity() + self.response.value.depth.capacity()) * size_of::<f64>();
        let of_shares: usize = self.shares.iter().map(Share::bytes).sum();
        self.at_pixels.value.bytes() + self.between.bytes() + self.skin.bytes() + of_cells + of_shares
    }

    pub(super) fn work(&self) -> Work {
        self.work + self.superposition.work
    }

    /// Computes the values of all pixels.
    pub(super) fn values(
        &mut self,
        (job, gpu): (&Job<'_>, Option<&Gpu>),
        double: bool,
        values: &mut Vec<f32>,
    ) -> Made {
        self.enter(job.key);
        let (width, height) = job.request.size;
        values.resize(width * height, 0.0);
        let made = match job.frame {
            Frame::Pixels { raster, weights: None } if double && (has_differences(job) || is_mean(job)) => {
                self.work.superposition += 1;
                self.work.forming += 1;
                in_f64(job, raster, values, &self.progress)
            }
            Frame::Pixels { raster, weights } => {
                self.by_pixels((job, gpu), (raster, weights.as_ref()), double, values)
            }
            Frame::Cells { to_pixels } => self.by_cells(job, to_pixels, double, values),
        };
        job.within.iter().for_each(|pixel| values[*pixel] = f32::NAN);
        made
    }

    /// Forms values from the sound at the pixels.
    fn by_pixels(
        &mut self,
        (job, gpu): (&Job<'_>, Option<&Gpu>),
        (raster, weights): (&Raster, Option<&Weights>),
        double: bool,
        values: &mut [f32],
    ) -> Made {
        let request = job.request;
        let (parts, constants) = (job.key.parts, request.constants().narrow());
        let declaration = request.quantity.declaration();
        let drives = request.counted();
        let factor = request.part as f32 / drives.len() as f32;
        let rows_together = (BAND / raster.width).max(1);
        let mut sounds = vec![vec![Sound::default(); job.probes.places.len()]; drives.len()];
        let is_of_pressure = declaration.norm == Norm::Pressure;
        let (mut loudest, mut largest) = ([0.0f32; 2], 0.0f32);
        if drives.len() > 1 {
            values.fill(0.0);
        }
        // Of a vector the mean has the length, not the mean of lengths.
        let flow = declaration.flow.filter(|_| drives.len() > 1);
        let mut flows = vec![[0.0f32; 3]; flow.map_or(0, |_| values.len())];
        for (drive, excitation) in job.excitations.iter().enumerate() {
            let of_drive = self.progress.part(drive..drive + 1, drives.len());
            of_drive.tell(0, 1);
            let key = SampledKey { site: job.key.clone(), excitation: excitation.clone(), double };
            for first in (0..raster.height).step_by(rows_together) {
                let rows = first..raster.height.min(first + rows_together);
                let pixels = rows.start * raster.width..rows.end * raster.width;
                let lattice_key = (key.clone(), request.size);
                if rows != (0..raster.height) || !self.at_pixels.is_of(&lattice_key) {
                    self.at_pixels.key = None;
                    of_drive.lead(|| {
                        self.fill_pixels((job, gpu), drive, &key, (raster, weights), rows.clone());
                    });
                    self.at_pixels.key = (rows == (0..raster.height)).then_some(lattice_key);
                }
                let lattice = &self.at_pixels.value;
                self.work.forming += 1;
                if let Some(flow) = flow {
                    let runs = flows[pixels.clone()].par_chunks_mut(RUN).enumerate().with_min_len(4);
                    runs.for_each(|(run, flows)| {
                        let sounds = lattice.sounds(parts, run * RUN..run * RUN + flows.len());
                        (flow.add)(sounds, &constants, flows);
                    });
                    continue;
                }
                let of_run = |(run, values): (usize, &mut [f32])| {
                    let places = run * RUN..run * RUN + values.len();
                    let sounds = lattice.sounds(parts, places);
                    if drives.len() == 1 {
                        (declaration.formula)(sounds, &constants, values);
                        return finish(values, factor, declaration.ending());
                    }
                    let mut of_drive = [0.0; RUN];
                    let of_drive = &mut of_drive[..values.len()];
                    (declaration.formula)(sounds, &constants, of_drive);
                    values.iter_mut().zip(of_drive).for_each(|(value, of_drive)| *value += *of_drive);
                    0.0
                };
                let runs = values[pixels.clone()].par_chunks_mut(RUN).enumerate().with_min_len(4);
                largest = largest.max(runs.map(of_run).reduce(|| 0.0, f32::max));
                for (sound, place) in sounds[drive].iter_mut().zip(&job.probes.places) {
                    if pixels.contains(place) {
                        *sound = lattice.sound(parts, place - pixels.start);
                    }
                }
                if is_of_pressure {
                    for (run, is_near) in job.left_out.split(pixels.clone()) {
                        let run = run.start - pixels.start..run.end - pixels.start;
                        let most = &mut loudest[usize::from(is_near)];
                        *most = most.max(field::peak(&lattice.0[0][run]));
                    }
                }
            }
        }
        let length = |[x, y, n]: [f32; 3]| (x * x + y * y + n * n).sqrt();
        values.iter_mut().zip(flows).for_each(|(value, flow)| *value = length(flow));
        if drives.len() > 1 {
            let runs = values.par_chunks_mut(RUN).with_min_len(16);
            let finished = runs.map(|values| finish(values, factor, declaration.ending()));
            largest = finished.reduce(|| 0.0, f32::max);
        }
        self.progress.tell(1, 1);
        let [peak, left_out] = match (is_of_pressure, job.left_out.is_empty()) {
            (true, _) => loudest,
            (false, true) => [largest, 0.0],
            (false, false) => job.left_out.largest(values),
        };
        let elsewhere = match is_mean(job) {
            true => weakest::off_at_loudest(job, values).max(rounding(parts, double) * f64::from(peak)),
            false => 0.0,
        };
        let at_probes = AtProbes {
            values: at(values, &job.probes.places),
            sounds: flow.is_none().then_some(sounds),
            elsewhere,
        };
        Made { peak, left_out, rounding: 0.0, at_probes, relative_to: peak }
    }

    /// The sound of a drive at some rows of pixels.
    fn fill_pixels(
        &mut self,
        (job, gpu): (&Job<'_>, Option<&Gpu>),
        drive: usize,
        key: &SampledKey,
        (raster, weights): (&Raster, Option<&Weights>),
        rows: Range<usize>,
    ) {
        self.fill_pixels_by_elements(job, drive, key, (raster, weights), rows.clone());
        if !job.key.setting.aperture.bodies.is_empty() {
            let band = Band { raster, weights, rows: (rows.start, rows.end) };
            let key = (job.key.clone(), job.request.size, band.rows);
            let is_again = self.places.is_of(&key);
            self.places.update(&key, |places| *places = Places::new(job, band));
            let places = &mut self.places.value;
            if is_again && job.key.parts == PRESSURE && !key.0.is_direct() {
                places.tabulate(job);
            }
            bodies::add((job, gpu), drive, (places, band), &mut self.at_pixels.value);
        }
    }

    /// The same without bodies.
    fn fill_pixels_by_elements(
        &mut self,
        job: &Job<'_>,
        drive: usize,
        key: &SampledKey,
        (raster, weights): (&Raster, Option<&Weights>),
        rows: Range<usize>,
    ) {
        let parts = job.key.parts;
        let Self { superposition, samples, at_pixels, between, work, .. } = self;
        let width = raster.width;
        let within = |some: Range<usize>| some.start.max(rows.start)..some.end.min(rows.end);
        at_pixels.value.resize(parts, rows.len() * width);
        let of = |rows_: &Range<usize>| (rows_.start - rows.start) * width..(rows_.end - rows.start) * width;
        let axes = job.site.axes;
        for direct in raster.direct().map(within).filter(|rows| !rows.is_empty()) {
            work.superposition += 1;
            let places = raster.pixel_rows(direct.clone());
            for (part, values) in Part::of(parts).zip(&mut at_pixels.value.0) {
                let sound = part_on_cpu(
                    &job.request.aperture.without_bodies(),
                    &job.request.drives[drive],
                    &places,
                    part,
                    axes,
                    key.double,
                );
                values[of(&direct)].copy_from_slice(&sound);
            }
        }
        let interpolated = within(raster.interpolated.clone());
        let (Some(grid), Some(weights)) = (&job.site.plan.grid, weights) else { return };
        if interpolated.is_empty() {
            return;
        }
        let samples = samples.update(key, |samples| {
            *samples = sampled(superposition, job, grid, drive..drive + 1, key.double).swap_remove(0);
        });
        work.interpolation += 1;
        let first = raster.interpolated.start;
        for (part, values) in Part::of(parts).zip(&mut at_pixels.value.0) {
            let [across, up] = weights.of(part);
            let some;
            let up = if interpolated.len() == weights.rows() {
                up
            } else {
                some = up.part(interpolated.start - first..interpolated.end - first);
                &some
            };
            let columns = grid.samples.columns.len();
            interpolate(samples.of(part), columns, across, up, between, &mut values[of(&interpolated)]);
        }
    }

    /// Interpolates values from the cells, which contain the mean of the formula or a liquid's response to it.
    fn by_cells(
        &mut self,
        job: &Job<'_>,
        [across, up]: &[Resampling; 2],
        double: bool,
        values: &mut [f32],
    ) -> Made {
        let Some(filled) = &job.site.cells else { unreachable!("pixels of cells without cells") };
        let key = FormedKey::new(job, double);
        self.fill_cells(job, filled, &key);
        let part = job.request.part;
        let declaration = job.request.quantity.declaration();
        let is_pressed = self.response(job, filled, &key).is_some();
        let is_moment = job.request.depth.is_some() && declaration.is_pressed();
        let powers = (declaration.of_skin && !is_moment).then(|| self.powers(job, filled));
        let (shown, part) = match (&job.request.depth, &powers) {
            (Some(depth), _) if is_moment => (&depth[..], 1.0),
            (_, Some(powers)) => (&powers[..], 1.0),
            (_, None) if is_pressed => (&self.response.value.depth[..], part),
            (_, None) => (&self.cells.value[..], part),
        };
        self.work.interpolation += 1;
        let mut elsewhere = 0.0;
        if declaration.of_light {
            self.work.caustic += 1;
            self.caustic.cast(job, &filled.cells, (shown, part), values);
        } else {
            let cells: Vec<_> = shown.iter().map(|&value| (value * part) as f32).collect();
            interpolate(&cells, filled.cells.counts[0], across, up, &mut self.between, values);
            if declaration.is_root {
                elsewhere = weakest::mend(job, (&cells, filled.cells.counts[0]), [across, up], values);
            }
        }
        let runs = values.par_chunks_mut(RUN).with_min_len(16);
        let ending = if is_moment { Ending::Sum } else { declaration.ending() };
        let finished = runs.map(|values| finish(values, 1.0, ending));
        let peak = finished.reduce(|| f32::NEG_INFINITY, f32::max);
        if !declaration.is_pressed() {
            elsewhere = weakest::off_at_loudest(job, values).max(elsewhere);
        }
        let means = &self.cells.value;
        let places = &job.probes.places;
        let (values, relative_to) = if declaration.is_pressed() {
            let largest = means.iter().fold(0.0f64, |most, mean| most.max(mean.abs()));
            (places.iter().map(|&place| means[place] as f32).collect(), largest as f32)
        } else {
            (at(values, places), peak)
        };
        // Cells are farther than a wavelength from all elements.
        let at_probes = AtProbes { values, sounds: None, elsewhere };
        Made { peak, left_out: 0.0, rounding: 0.0, at_probes, relative_to }
    }

    /// The mean of the formula over the drives, at every cell.
    fn fill_cells(&mut self, job: &Job<'_>, filled: &Filled, key: &FormedKey) {
        let Self { superposition, shares, cells, skin, progress, work, .. } = self;
        let mut each = job.request.quantity.declaration().of_skin.then(Vec::new);
        if cells.is_of(key) && each.is_some() && !skin.pressures.is_of(key) {
            cells.key = None;
        }
        cells.update(key, |cells| {
            let Some(grid) = &job.site.plan.grid else {
                work.superposition += 1;
                work.forming += 1;
                let points = filled.cells.points(job.site.axes);
                if let Some(each) = &mut each {
                    let of_drive =
                        |drive| job.pressing(drive, &points).into_iter().map(|value| value as f32).collect();
                    each.extend((0..job.excitations.len()).map(|drive| of_drive(drive..drive + 1)));
                    *cells = mean(each);
                    return;
                }
                *cells = job.pressing(0..job.excitations.len(), &points);
                return;
            };
            cells.clear();
            cells.resize(filled.cells.count(), 0.0);
            let most = (MOST_SHARED_CELLS / cells.len()).clamp(1, SHARES);
            let count = job.excitations.len();
            for first in (0..count).step_by(TOGETHER) {
                let drives = first..count.min(first + TOGETHER);
                let of_these = progress.part(drives.clone(), count);
                of_these.tell(0, 1);
                let samples = of_these.lead(|| sampled(superposition, job, grid, drives, key.double));
                work.forming += samples.len() as u64;
                if let Some(each) = &mut each {
                    let of_share = samples.len().div_ceil(SHARES);
                    shares.resize_with(SHARES, Share::default);
                    let forming =
                        samples.par_chunks(of_share).zip(&mut *shares).flat_map_iter(|(some, share)| {
                            some.iter().map(|sample| {
                                share.sum(job, filled, std::slice::from_ref(sample));
                                share.sums.iter().map(|&value| value as f32).collect::<Vec<_>>()
                            })
                        });
                    each.par_extend(forming);
                    continue;
                }
                let of_share = samples.len().div_ceil(most);
                shares.resize_with(samples.len().div_ceil(of_share), Share::default);
                let filling = samples.par_chunks(of_share).zip(&mut *shares);
                filling.for_each(|(samples, share)| share.sum(job, filled, samples));
                for share in &*shares {
                    cells.iter_mut().zip(&share.sums).for_each(|(cell, sum)| *cell += sum);
                }
            }
            progress.tell(count, count);
            if let Some(each) = &each {
                *cells = mean(each);
                return;
            }
            let share = 1.0 / count as f64;
            cells.iter_mut().for_each(|cell| *cell *= share);
        });
        if let Some(each) = each.filter(|each| !each.is_empty()) {
            (skin.pressures.key, skin.pressures.value) = (Some(key.clone()), each);
        }
    }

    /// The motion of the skin as far as the map's quantity needs it: at every cell the sum of its lines' powers.
    fn powers(&mut self, job: &Job<'_>, filled: &Filled) -> Vec<f64> {
        let Request { quantity, channel, skin, course, plane, .. } = job.request;
        let purpose = match quantity.declaration().is_level() {
            true => Purpose::Feeling(*channel),
            false => Purpose::Displacement(*channel),
        };
        let (motion, made) = self.skin.motion(&filled.cells, plane.size, (skin, course), purpose);
        self.work.response += u64::from(made > 0);
        let powers = motion.powers(|frequency| purpose.weight(skin, frequency));
        powers.map_or_else(|| vec![0.0; filled.cells.count()], |(_, powers)| motion.widened(&powers))
    }

    /// The motion of the skin with all that counts for any quantity, and its mean.
    pub(super) fn skin(&mut self, job: &Job<'_>, double: bool) -> Option<&SkinMotion> {
        self.enter(job.key);
        let filled = job.site.cells.as_ref().filter(|_| job.request.quantity.declaration().of_skin)?;
        self.fill_cells(job, filled, &FormedKey::new(job, double));
        let Request { skin, course, plane, .. } = job.request;
        Some(self.skin.motion(&filled.cells, plane.size, (skin, course), Purpose::All).0)
    }

    /// The liquid's response to a steady pressure, for quantities that show it.
    fn response(&mut self, job: &Job<'_>, filled: &Filled, key: &FormedKey) -> Option<&Dent> {
        if !job.request.quantity.declaration().of_liquid {
            return None;
        }
        let Self { tank, response, cells, work, .. } = self;
        let tank = tank.update(job.key, |tank| *tank = Some(filled.cells.tank())).as_ref()?;
        let liquid = job.request.liquid.in_the_dark();
        Some(response.update(&(key.clone(), liquid.clone()), |dent| {
            work.response += 1;
            *dent = tank.dent(&liquid, &cells.value);
        }))
    }

    /// The cells of a liquid, and the surface at rest under the steady sound.
    pub(super) fn surface(&mut self, job: &Job<'_>, double: bool) -> Option<(&Tank, &Dent)> {
        self.enter(job.key);
        let filled = job.site.cells.as_ref()?;
        let key = FormedKey::new(job, double);
        self.fill_cells(job, filled, &key);
        self.response(job, filled, &key)?;
        Some((self.tank.value.as_ref()?, &self.response.value))
    }

    /// The radiation pressure on the plane, from the cells or, without cells, from the pixels.
    pub(super) fn pressed(&mut self, job: &Job<'_>, values: &[f32], double: bool) -> Pressed {
        let (size, part) = (job.request.plane.size, job.request.part);
        let Some(filled) = &job.site.cells else {
            let area = size.x * size.y / values.len() as f64;
            let sum: f64 = values.iter().map(|&value| f64::from(value)).sum();
            return Pressed { size, force: sum * area, depression: None, light: None };
        };
        let key = FormedKey::new(job, double);
        self.fill_cells(job, filled, &key);
        let force = part * filled.cells.integral(size, self.cells.value.iter().copied());
        let depression = self.response(job, filled, &key).map(|dent| match &job.request.depth {
            Some(depth) => Depression::new(&filled.cells, size, depth),
            None => Depression::new(&filled.cells, size, &dent.depth).times(part),
        });
        let light = job.request.quantity.declaration().of_light.then(|| self.caustic.light());
        Pressed { size, force, depression, light }
    }
}

/// Whether values are differences of larger terms, which f32 rounds.
fn has_differences(job: &Job<'_>) -> bool {
    job.request.quantity.declaration().norm == Norm::Difference
}

/// Whether values are means over several drives, which share their waves in f64.
fn is_mean(job: &Job<'_>) -> bool {
    job.excitations.len() > 1
}

/// Rounding error of f32 anywhere on a map, relative to its peak: differences lose more than sums.
fn rounding(parts: u8, double: bool) -> f64 {
    match (double, parts) {
        (true, _) => 0.0,
        (false, PRESSURE) => 2.0 * F32_ERROR,
        (false, _) => 8.0 * F32_ERROR,
    }
}

/// Every pixel in f64, up to its value.
fn in_f64(job: &Job<'_>, raster: &Raster, values: &mut [f32], progress: &Gauge) -> Made {
    let quantity = job.request.quantity;
    let pixels = raster.pixels();
    progress.tell(0, 1);
    let means =
        progress.lead(|| job.means(0..job.excitations.len(), pixels.len(), |pixel| pixels.point(pixel)));
    progress.tell(1, 1);
    for (value, mean) in values.iter_mut().zip(means) {
        *value = quantity.exact_value(job.request.part * mean) as f32;
    }
    let [peak, left_out] = job.left_out.largest(values);
    let at_probes = AtProbes { values: at(values, &job.probes.places), ..AtProbes::default() };
    Made { peak, left_out, rounding: 0.0, at_probes, relative_to: peak }
}

impl Job<'_> {
    /// The mean of the formula over some of the drives at points, in f64.
    pub(super) fn means(
        &self,
        drives: Range<usize>,
        count: usize,
        point: impl Fn(usize) -> DVec3 + Sync,
    ) -> Vec<f64> {
        /// Points processed together.
        const TOGETHER: usize = 32;
        let (quantity, constants) = (self.request.quantity, self.request.constants());
        let counter = Gauge::current().count(count);
        let of_run = |run: usize| {
            let run = run * TOGETHER..count.min((run + 1) * TOGETHER);
            let points: Vec<_> = run.inspect(|_| counter.add()).map(&point).collect();
            let aperture = &self.key.setting.aperture;
            let sound = SoundTransfer::new(aperture, self.key.parts, self.site.axes, &points);
            sound.means(&self.excitations[drives.clone()], (quantity, &constants))
        };
        (0..count.div_ceil(TOGETHER)).into_par_iter().flat_map_iter(of_run).collect()
    }
}

impl Job<'_> {
    /// The mean over some of the drives of what presses at cells. Nothing does within a body. On a body's skin it is |p|²/(4ρc²)
    /// of the total pressure, which is twice what a plane's formula expects; beside it there is no skin.
    fn pressing(&self, drives: Range<usize>, cells: &field::samples::Samples) -> Vec<f64> {
        if self.skin.is_empty() {
            let means = self.means(drives, cells.len(), |cell| cells.point(cell));
            return means.into_iter().map(|mean| if mean.is_nan() { 0.0 } else { mean }).collect();
        }
        let touched: Vec<_> = (0..cells.len()).filter_map(|cell| Some((cell, self.skin[cell]?))).collect();
        let points: Vec<_> = touched.iter().map(|(_, at)| *at).collect();
        let mut all = vec![0.0; cells.len()];
        let part = self.request.constants().of_pressure / 4.0 / drives.len().max(1) as f64;
        for drive in drives {
            let pressures = self.key.setting.aperture.pressures(&points, &self.excitations[drive]);
            for ((cell, _), p) in touched.iter().zip(pressures).filter(|(_, p)| !p.is_nan()) {
                all[*cell] += part * p.norm_sqr();
            }
        }
        all
    }
}

/// The mean over all frames, at every cell.
fn mean(frames: &[Vec<f32>]) -> Vec<f64> {
    let mut sums = vec![0.0; frames.first().map_or(0, Vec::len)];
    for frame in frames {
        sums.iter_mut().zip(frame).for_each(|(sum, value)| *sum += f64::from(*value));
    }
    sums.iter_mut().for_each(|sum| *sum /= frames.len() as f64);
    sums
}

/// How sums of the formula become values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    Sum,
    Root,
    /// dB
    Level,
}

impl Declaration {
    fn ending(&self) -> Ending {
        match (self.is_level(), self.is_root || self.of_skin) {
            (true, _) => Ending::Level,
            (false, true) => Ending::Root,
            (false, false) => Ending::Sum,
        }
    }
}

/// The values at some places.
fn at(values: &[f32], places: &[usize]) -> Vec<f32> {
    places.iter().map(|&place| values[place]).collect()
}

/// Turns sums of the formula into values in place; returns the largest magnitude, of levels the largest.
fn finish(values: &mut [f32], factor: f32, ending: Ending) -> f32 {
    const LANES: usize = 16;
    let value = |sum: f32| match ending {
        Ending::Sum => factor * sum,
        Ending::Root => (factor * larger(sum, 0.0)).sqrt(),
        Ending::Level => 10.0 * larger(factor * sum, FLOOR as f32).log10(),
    };
    let size = |value: f32| if ending == Ending::Level { value } else { value.abs() };
    let mut largest = [f32::NEG_INFINITY; LANES];
    let (runs, rest) = values.as_chunks_mut::<LANES>();
    for run in runs {
        for (sum, largest) in run.iter_mut().zip(&mut largest) {
            *sum = value(*sum);
            *largest = larger(size(*sum), *largest);
        }
    }
    for sum in rest {
        *sum = value(*sum);
        largest[0] = larger(size(*sum), largest[0]);
    }
    largest.into_iter().fold(f32::NEG_INFINITY, f32::max)
}
