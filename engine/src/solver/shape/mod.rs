//! Drives of shapes: even pressure along strokes, and low side lobes everywhere else on the plane.
//!
//! The first drive considers only the strokes: weighted Gerchberg-Saxton from equal phases along them ([`start`]),
//! then descent ([`crate::solver::descent`]). An [`objective`] that covers the whole radiated plane is then
//! optimised: a soft minimum of |p| along the strokes is maximised and a soft maximum of |p| elsewhere minimised,
//! at a strength held by a penalty, by limited-memory BFGS on the phases. *Elsewhere* is the [`region`]: the
//! scene's plane as far as the array radiates, independently of the displayed part, and quiet zones.
//!
//! On planes parallel to the array, samples at 1/S of the pitch form S² grids of the array's own pitch, and H to
//! each of them is a convolution ([`grid`]): one Fourier transform of the drive and S² inverse ones, over whole
//! SIMD rows, 0.06 ms for 9801 samples of 256 elements. Tilted planes, planes too distant for short transforms, and
//! quiet zones are tables in f32 ([`table`]); only their loud rows are evaluated, selected anew every eight steps.
//!
//! Five starts, two of them to the end, take about 100 ms. Areas are fitted as a [`picture`], from a field with
//! equal phases. There is one thread and no clock: the same calls give the same drives. Derivatives, grid and
//! figures are checked in f64.

mod fft;
mod figures;
mod further;
mod grid;
mod objective;
mod picture;
mod real;
mod region;
mod response;
mod samples;
mod start;
pub(crate) mod surroundings;
mod table;
#[cfg(test)]
mod tests;
mod wanted;

use std::f64::consts::TAU;
use std::time::Duration;

use num_complex::Complex64;
use strum::VariantArray;

use crate::scene::{Amplitudes, Focus, Plane};
use crate::solver::descent::{Descent, Function};
use crate::solver::iteration;
use crate::solver::problem::{Excitation, Problem};

use objective::{Loudness, Objective, Weights};
use start::Start;
use table::Table;
use wanted::Fineness;

pub use figures::figures;
pub use further::best_within;
pub use surroundings::{Surroundings, Zone, judged_plane};

/// Steps per call of [`Search::advance`], and calls, of each part of the schedule.
pub const COARSE: (usize, u32) = (20, 3);
const FINE: (usize, u32) = (25, 4);
const LAST: (usize, u32) = (25, 4);
/// Steps of another start, and of the best of these.
const TRIAL: usize = 25;
const TRIAL_REST: usize = 35;
/// Steps of a call that continues from a drive.
const FRAME: usize = 15;
/// Steps on the strokes alone: for the first drive, for other starts, and for the achievable strength of a moved
/// shape.
const FIRST_STEPS: usize = 25;
const OTHER_STEPS: usize = 10;
const MOVED_STEPS: usize = 8;
/// Steps between selections of table rows; also the window for detecting convergence within rounding.
const REFRESH: usize = 8;
const STALL: usize = 10;
/// Gain per step below which a descent ends.
const LEAST_GAIN: f64 = 1e-5;

/// Weights for the strokes alone: even and strong.
const STROKES: Weights = Weights {
    even: 2.0,
    quiet: 0.0,
    strong: 1.0,
    sharpness: 8,
    loudness: Loudness::Eight,
    picture: PICTURE,
    floor: 0.0,
};
/// Weight of the fit of areas.
const PICTURE: f64 = 10.0;
/// Steps of an area's first drive; then steps of one call, and calls of a single drive and of several in turn.
const AREA_FIRST: usize = 25;
const AREA: (usize, u32) = (20, 12);
const AREA_TURNS: u32 = 7;
/// Steps of one call with free amplitudes, and calls; the angle ψ (rad) that they start from, short of full drive, where
/// the slope is 0.
const FREE: (usize, u32) = (25, 12);
const SHORT: f64 = 0.4;
/// Tolerated loss of strength by free amplitudes at `quiet` = 1.
const FREE_COST: f64 = 0.5;

/// A search for the drive of a shape that can be continued until it converges.
#[derive(Debug)]
pub struct Search<'a> {
    problem: &'a Problem<'a>,
    surroundings: Surroundings,
    objective: Objective<f32>,
    /// Scale of transfers, so that pressures are near 1.
    scale: f64,
    /// M of the strongest drive.
    strongest: f64,
    /// Descents from equal phases, and from the best other start.
    ways: [Option<Descent>; 2],
    /// Index of the better descent.
    leader: usize,
    stage: Stage,
    /// u of the driven elements of the last result, drive after drive.
    given: Option<Vec<Complex64>>,
    steps: usize,
}

/// The next action of [`Search::advance`]; numbers count calls and starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The strokes alone.
    First,
    /// Descent on coarse samples of the surroundings.
    Coarse(u32),
    /// Another start.
    Other(usize),
    /// Descents on fine samples, from the better start and from the other.
    Leader(u32),
    Rival(u32),
    Last(u32),
    /// Areas, by this number of drives in turn.
    Area(usize, u32),
    /// Amplitudes beside phases.
    Free(u32),
    /// Continues from a drive.
    Moved,
    Going,
    Done,
}

impl<'a> Search<'a> {
    /// The problem's foci are samples of strokes, a quarter of a wavelength apart, and separate foci.
    pub fn new(problem: &'a Problem<'a>, surroundings: &Surroundings) -> Self {
        let has_areas = !surroundings.areas.is_empty() || surroundings.liquid.is_some();
        let is_stroke = |focus: &Focus| !has_areas || (surroundings.liquid.is_none() && !focus.is_of_area());
        let (table, scale) = strokes(problem, is_stroke);
        let surroundings = surroundings.clone();
        let mut objective = Objective::new(table, *problem.drives.start(), STROKES);
        objective.picture = wanted::picture(problem, &surroundings, Fineness::Solver, scale);
        if objective.picture.is_some() {
            objective.set_drives(1);
        }
        let stage = if objective.is_empty() { Stage::Done } else { Stage::First };
        let (ways, given) = ([None, None], None);
        Self {
            problem,
            surroundings,
            objective,
            scale,
            strongest: 0.0,
            ways,
            leader: 0,
            stage,
            given,
            steps: 0,
        }
    }

    /// Continues from u of the driven elements of a similar problem: each call takes the time of a frame.
    pub fn from(problem: &'a Problem<'a>, surroundings: &Surroundings, before: &[Complex64]) -> Self {
        let mut search = Self::new(problem, surroundings);
        let drives = before.len() / problem.aperture.driven.len().max(1);
        let is_whole = before.len() == drives * problem.aperture.driven.len();
        let is_drive = is_whole && problem.drives.contains(&drives) && before.iter().all(|u| u.is_finite());
        if is_drive {
            search.objective.set_drives(drives);
        }
        if is_drive && matches!(search.stage, Stage::First) {
            search.stage = Stage::Moved;
        }
        let given = |&u: &Complex64| if search.may_be_free() { u } else { iteration::phase(u) };
        search.given = is_drive.then(|| before.iter().map(given).collect());
        search
    }

    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Whether the last drives are better than all before, and others follow: further drives join them, or have joined.
    pub fn is_under_way(&self) -> bool {
        matches!(self.stage, Stage::Area(2.., _))
    }

    /// The best drive so far, with its common phase matched to the previous one: first that of the strokes alone,
    /// then one after every few steps, which is unchanged if they were spent on another start. `None` after
    /// convergence.
    pub fn advance(&mut self) -> Option<Excitation> {
        let before = self.steps;
        match self.stage {
            Stage::First => self.first(),
            Stage::Coarse(call) => self.coarse(call),
            Stage::Other(start) => self.other(start),
            Stage::Leader(call) => {
                if call == 0 {
                    self.refine();
                }
                let goes_on = self.run(self.leader, FINE.0) && call + 1 < FINE.1;
                self.stage = if goes_on { Stage::Leader(call + 1) } else { Stage::Rival(0) };
            }
            Stage::Rival(call) => self.rival(call),
            Stage::Last(call) => {
                let goes_on = self.run(self.leader, LAST.0) && call + 1 < LAST.1;
                self.stage = if goes_on { Stage::Last(call + 1) } else { Stage::Done };
            }
            Stage::Area(drive, call) => self.area(drive, call),
            Stage::Free(call) => {
                if call == 0 {
                    self.free(self.leader);
                }
                let goes_on = self.run(self.leader, FREE.0) && call + 1 < FREE.1;
                self.stage = if goes_on { Stage::Free(call + 1) } else { Stage::Done };
            }
            Stage::Moved => self.moved(),
            Stage::Going => {
                if !self.run(0, FRAME) {
                    self.stage = Stage::Done;
                }
            }
            Stage::Done if self.steps == 0 && self.given.is_none() => return Some(self.silent()),
            Stage::Done => return None,
        }
        if self.stage == Stage::Done && self.may_be_free() && !self.objective.is_free {
            self.stage = Stage::Free(0);
        }
        (self.steps > before).then(|| self.give())
    }

    /// Whether amplitudes are to be found, too. At full strength they win nothing.
    fn may_be_free(&self) -> bool {
        self.surroundings.amplitudes == Amplitudes::Free && self.is_quiet()
    }

    /// Makes the amplitudes of a way unknowns, for less strength.
    fn free(&mut self, way: usize) {
        let Some(Descent { mut x, .. }) = self.ways[way].take() else { return };
        if !self.objective.is_free {
            self.set_floor(&x);
            self.objective.is_free = true;
        }
        x.extend(vec![SHORT; x.len()]);
        self.objective.refresh(&x);
        self.ways[way] = Some(Descent::new(x, &mut self.objective));
    }

    /// Sets the strength that free amplitudes keep: of the strongest drive or, of areas, of these phases at full drive.
    fn set_floor(&mut self, phases: &[f64]) {
        let kept = 1.0 - FREE_COST * self.surroundings.quiet.min(1.0);
        let full = if self.strongest > 0.0 { self.strongest } else { self.objective.level(phases) };
        self.objective.weights.floor = kept * kept * full;
    }

    /// The field is zero wherever targets are: any drive is equally good.
    fn silent(&mut self) -> Excitation {
        let values = vec![Complex64::ONE; self.problem.drives.start() * self.problem.aperture.driven.len()];
        self.given = Some(values.clone());
        Excitation { values, iterations: 0, residual: None, weights: None }
    }

    fn first(&mut self) {
        if self.objective.picture.is_some() {
            self.ways[0] = Some(self.begun(0, AREA_FIRST));
            self.stage = Stage::Area(1, 0);
            return;
        }
        let way = self.begun(0, FIRST_STEPS);
        self.strongest = self.objective.level(&way.x);
        self.ways[0] = Some(way);
        self.stage = if self.is_quiet() { Stage::Coarse(0) } else { Stage::Done };
    }

    fn coarse(&mut self, call: u32) {
        if call == 0 {
            self.hear(false);
            if !self.objective.is_quiet() {
                self.stage = Stage::Done;
                return;
            }
            self.objective.weights = self.weights(Loudness::Eight);
            self.renew(0);
        }
        let goes_on = self.run(0, COARSE.0) && call + 1 < COARSE.1;
        self.stage = if goes_on { Stage::Coarse(call + 1) } else { Stage::Other(0) };
    }

    /// Areas from one start: others end as well. After its first call all other drives in turn join it.
    fn area(&mut self, drives: usize, call: u32) {
        let all = *self.problem.drives.end();
        if call == 0 && drives > 1 {
            self.join(drives);
        } else if call == 0 && self.is_quiet() {
            self.hear(false);
            self.objective.weights = self.weights(Loudness::Eight);
            self.renew(0);
        }
        let goes_on = self.run(0, AREA.0);
        let calls = if drives > 1 { AREA_TURNS } else { AREA.1 };
        self.stage = if drives < all {
            Stage::Area(all, 0)
        } else if goes_on && call + 1 < calls {
            Stage::Area(drives, call + 1)
        } else {
            Stage::Done
        };
    }

    /// Further drives join those before, each from a start of its own.
    fn join(&mut self, drives: usize) {
        let Some(Descent { mut x, .. }) = self.ways[0].take() else { return };
        let elements = self.problem.aperture.driven.len();
        self.objective.set_drives(1);
        for drive in x.len() / elements..drives {
            x.extend(self.objective.start(drive, elements));
        }
        self.objective.set_drives(drives);
        self.ways[0] = Some(Descent::new(x, &mut self.objective));
    }

    /// Tries another start; after the last of them the best is continued as long as the first was.
    fn other(&mut self, start: usize) {
        let weights = self.objective.weights;
        let way = self.begun(start + 1, OTHER_STEPS);
        self.objective.weights = weights;
        let best = self.ways[1].replace(way);
        self.renew(1);
        self.run(1, TRIAL);
        if value(&best) <= value(&self.ways[1]) {
            self.ways[1] = best;
        }
        if start + 2 < Start::VARIANTS.len() {
            self.stage = Stage::Other(start + 1);
            return;
        }
        self.run(1, TRIAL_REST);
        self.leader = usize::from(value(&self.ways[1]) < value(&self.ways[0]));
        self.stage = Stage::Leader(0);
    }

    /// Finer samples and a sharper maximum, for both ways.
    fn refine(&mut self) {
        self.hear(true);
        self.objective.weights = self.weights(Loudness::Twelve);
        self.renew(0);
        self.renew(1);
    }

    fn rival(&mut self, call: u32) {
        let rival = 1 - self.leader;
        if self.run(rival, FINE.0) && call + 1 < FINE.1 {
            self.stage = Stage::Rival(call + 1);
            return;
        }
        if value(&self.ways[rival]) < value(&self.ways[self.leader]) {
            self.leader = rival;
        }
        self.stage = Stage::Last(0);
    }

    /// The first steps from the given drive; the achievable strength of this shape is estimated anew.
    fn moved(&mut self) {
        let phases = self.given.iter().flatten().map(|u| u.arg()).collect();
        if self.is_quiet() {
            let has_areas = self.objective.picture.is_some();
            if !has_areas {
                let strong = self.begun(0, MOVED_STEPS);
                self.strongest = self.objective.level(&strong.x);
            }
            self.hear(!has_areas);
            self.objective.weights = self.weights(if has_areas { Loudness::Eight } else { Loudness::Twelve });
        }
        let mut x: Vec<f64> = phases;
        if self.may_be_free() {
            self.set_floor(&x);
            self.objective.is_free = true;
            // At full drive the slope is 0.
            x.extend(self.given.iter().flatten().map(|u| u.norm().min(1.0).acos().max(0.5 * SHORT)));
        }
        self.ways[0] = Some(Descent::new(x, &mut self.objective));
        self.stage = if self.run(0, FRAME) { Stage::Going } else { Stage::Done };
    }

    fn is_quiet(&self) -> bool {
        self.surroundings.quiet > 0.0
    }

    /// Weights with surroundings: most of the strength is kept.
    fn weights(&self, loudness: Loudness) -> Weights {
        /// Below this `quiet` the weight of side lobes decreases.
        const FULL: f64 = 0.25;
        /// Tolerated loss of strength at `quiet` = 1.
        const COST: f64 = 0.2;
        /// Factors on `quiet`² for areas, and on `quiet`³ for areas beside strokes.
        const AREAS: f64 = 2.2;
        const AREAS_AND_STROKES: f64 = 2.4;
        let wanted = self.surroundings.quiet.min(1.0);
        if self.objective.picture.is_some() {
            let quiet = match self.objective.has_strokes() {
                true => AREAS_AND_STROKES * wanted.powi(3),
                false => AREAS * wanted.powi(2),
            };
            return Weights { strong: 0.0, even: 1.5, sharpness: 16, quiet, loudness, ..STROKES };
        }
        let kept = 1.0 - COST * wanted;
        let floor = kept * kept * self.strongest;
        let quiet = (wanted / FULL).min(1.0);
        Weights { even: 1.5, quiet, strong: 0.0, sharpness: 16, loudness, floor, ..STROKES }
    }

    /// Samples of the surroundings; coarse ones are replaced by finer ones if available.
    fn hear(&mut self, finer: bool) {
        let Self { problem, surroundings, objective, scale, .. } = self;
        if finer && !objective.quiet.is_empty() && objective.quiet.iter().all(|quiet| quiet.is_table()) {
            return;
        }
        objective.quiet.clear();
        if !objective.is_quiet() {
            objective.quiet.extend(region::on_plane(problem, &surroundings.plane, finer, *scale));
        }
        objective.quiet.extend(region::in_zones(problem, &surroundings.zones, *scale));
    }

    /// Steps without the surroundings. Every drive in turn has a different start, the first has this one.
    fn begun(&mut self, start: usize, steps: usize) -> Descent {
        let samples: Vec<_> = self.problem.foci.iter().map(|focus| focus.position).collect();
        let phases = |drive: usize| {
            let phases = Start::phases(start + drive, &samples, &self.surroundings.plane);
            along(self.problem, &phases)
        };
        let phases = match self.objective.picture {
            Some(_) => self.objective.start(start, self.problem.aperture.driven.len()),
            None => (0..self.objective.drives()).flat_map(phases).collect(),
        };
        self.objective.weights = STROKES;
        let mut way = Descent::new(phases, &mut self.objective);
        self.steps += descend(&mut way, &mut self.objective, steps).0;
        way
    }

    /// A way under weights and samples that have changed.
    fn renew(&mut self, way: usize) {
        if let Some(way) = &mut self.ways[way] {
            self.objective.refresh(&way.x);
            *way = Descent::new(std::mem::take(&mut way.x), &mut self.objective);
        }
    }

    /// Steps of one of the descents; false after convergence.
    fn run(&mut self, way: usize, steps: usize) -> bool {
        let Some(way) = &mut self.ways[way] else { return false };
        let (done, goes_on) = descend(way, &mut self.objective, steps);
        self.steps += done;
        goes_on
    }

    /// The same drives with the common phase that minimises rounding errors on few levels: the field is unchanged.
    fn turned_for_rounding(&mut self, mut found: Excitation) -> Excitation {
        /// Levels of a coarse board; the choice suits finer ones, too.
        const LEVELS: f64 = 16.0;
        const TURNS: u32 = 32;
        const STEP: f64 = TAU / LEVELS;
        let unknowns = self.objective.unknowns(&found.values);
        let rounded = |angle: f64| {
            let mut x = unknowns.clone();
            let phases = &mut x[..found.values.len()];
            phases.iter_mut().for_each(|phase| *phase = ((*phase + angle) / STEP).round() * STEP);
            x
        };
        let mut slopes = vec![0.0; unknowns.len()];
        let mut harm = |angle: f64| self.objective.evaluate(&rounded(angle), &mut slopes);
        let angles = (0..TURNS).map(|turn| STEP * f64::from(turn) / f64::from(TURNS));
        let best = angles.map(|angle| (angle, harm(angle))).min_by(|a, b| a.1.total_cmp(&b.1));
        let turn = Complex64::cis(best.map_or(0.0, |best| best.0));
        found.values.iter_mut().for_each(|u| *u *= turn);
        found
    }

    fn give(&mut self) -> Excitation {
        let way = self.ways[self.leader].iter();
        let mut values: Vec<_> = way.flat_map(|way| self.objective.excitation(&way.x)).collect();
        let elements = self.problem.aperture.driven.len();
        if let Some(before) = &self.given {
            for (before, values) in before.chunks(elements).zip(values.chunks_mut(elements)) {
                let ahead = before.iter().zip(&*values).map(|(from, to)| from.conj() * to).sum::<Complex64>();
                let back = Complex64::from_polar(1.0, -ahead.arg());
                values.iter_mut().for_each(|u| *u *= back);
            }
        }
        self.given = Some(values.clone());
        Excitation { values, iterations: self.steps as u32, residual: None, weights: None }
    }
}

/// Steps of a descent: their number, at least one, and whether more would gain.
fn descend(way: &mut Descent, objective: &mut Objective<f32>, steps: usize) -> (usize, bool) {
    let mut done = 0;
    while done < steps {
        let renewed = objective.refresh(&way.x);
        if renewed {
            way.renew(objective);
        }
        let part = (steps - done).min(if renewed { REFRESH } else { STALL });
        let before = way.value;
        for _ in 0..part {
            done += 1;
            if !way.step(objective) {
                return (done, false);
            }
        }
        if part >= REFRESH && before - way.value < LEAST_GAIN * part as f64 {
            return (done, false);
        }
    }
    (done, true)
}

/// The value reached by a descent.
fn value(way: &Option<Descent>) -> f64 {
    way.as_ref().map_or(f64::INFINITY, |way| way.value)
}

/// Phases of the elements from those along the strokes, by damped weighted Gerchberg-Saxton.
fn along(problem: &Problem<'_>, phases: &[f64]) -> Vec<f64> {
    const ITERATIONS: u32 = 10;
    iteration::weighted_from(problem, phases, ITERATIONS).iter().map(|u| u.arg()).collect()
}

/// The transfer to the foci of strokes over their targets, and a scale that brings it near 1; unreachable foci are
/// left out.
fn strokes(problem: &Problem<'_>, is_stroke: impl Fn(&Focus) -> bool) -> (Table<f32>, f64) {
    /// Relative to the best reachable focus, over its target.
    const FAINTEST: f64 = 1e-4;
    let targets = problem.targets();
    let mean = targets.iter().sum::<f64>() / targets.len() as f64;
    let heard = |row: usize| problem.transfer.row(row).map(|h| h.norm()).sum::<f64>() * mean / targets[row];
    let heard: Vec<_> = (0..targets.len()).map(heard).collect();
    let most = heard.iter().copied().filter(|heard| heard.is_finite()).fold(0.0, f64::max);
    let scale = 1.0 / most;
    let mut table = Table::new(problem.transfer.elements);
    if scale.is_finite() {
        let foci = problem.foci.iter().map(is_stroke).zip(&targets);
        for (row, (heard, (is_stroke, target))) in problem.transfer.rows().zip(heard.iter().zip(foci)) {
            if is_stroke && *heard >= FAINTEST * most {
                table.push(row, scale * mean / target);
            }
        }
    }
    (table, scale)
}

/// The strongest drives, for the strokes alone.
fn strongest(problem: &Problem<'_>) -> Vec<Complex64> {
    best(problem, &Surroundings::of_plane(Plane::default(), 0.0)).values
}

/// The drive at the end of a [`Search`].
pub fn best(problem: &Problem<'_>, surroundings: &Surroundings) -> Excitation {
    best_within(problem, surroundings, Duration::ZERO, &mut |_| {})
}

/// One call of a search continued from u of the driven elements: for a frame of a motion or of a drag.
pub fn best_from(problem: &Problem<'_>, surroundings: &Surroundings, before: &[Complex64]) -> Excitation {
    let mut search = Search::from(problem, surroundings, before);
    search.advance().unwrap_or_else(|| search.silent())
}
