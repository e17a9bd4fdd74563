//! Foci and strokes that are felt evenly: target pressures scaled by what the skin does.
//!
//! The skin's motion follows |p|², so a place whose level is x dB too low needs 10^(x/40) of its target pressure. Levels depend on
//! pressures elsewhere, too, since the skin carries waves: rounds of solving, measuring and scaling converge, because most of a level
//! is due to its own place. A place is judged by the spectral lines of all frames under the scene's modulation, and foci of
//! half the target pressure are to be felt 12 dB less.
//!
//! Areas keep their prescribed |p|², and traps their forces.

use glam::{DVec2, DVec3};

use crate::drive::Drive;
use crate::field::{Evaluator, FieldError, Quantity, Request, Stages};
use crate::scene::{Focus, Part, Plane, Scene, SpectralLine};
use crate::solver::statistics;

/// Rounds of measuring; all but the last scale.
const ROUNDS: usize = 5;
/// Standard deviation (dB) of levels that are even: less is not noticed, and costs strength.
const EVEN: f64 = 0.7;
/// Limit of a step (dB).
const STEP: f64 = 12.0;
/// Least target pressure, in parts of the largest: 40 dB.
const LEAST: f64 = 0.1;
/// Power of the least level, -100 dB.
const FLOOR: f64 = 1e-10;
/// m, of the plane around the foci.
const MARGIN: f64 = 0.02;

/// The levelling of a scene's foci, round by round.
pub struct Levelling<'a> {
    scene: &'a Scene,
    stages: Stages,
    /// Level (dB) that every focus is to have above that of pressure 1, frame by frame.
    wanted: Vec<Vec<f64>>,
    rounds: usize,
    /// Standard deviation (dB) of the most even round, and its foci.
    best: (f64, Vec<Vec<Focus>>),
}

impl<'a> Levelling<'a> {
    /// For a scene whose target is what is felt, and otherwise without rounds.
    pub fn of(scene: &'a Scene) -> Self {
        let rounds = if scene.aims_at_felt() { ROUNDS } else { 0 };
        let best = (f64::INFINITY, Vec::new());
        Self { scene, stages: Stages::new(Evaluator::Cpu), wanted: Vec::new(), rounds, best }
    }

    /// The foci of all frames with other target pressures; `None` if these drives of theirs are felt evenly, or rounds are used up.
    ///
    /// # Errors
    /// A plane without a map of what is felt.
    pub fn next(
        &mut self,
        frames: &[Vec<Focus>],
        drives: impl FnOnce() -> Vec<Drive>,
    ) -> Result<Option<Vec<Vec<Focus>>>, FieldError> {
        let Some(left) = self.rounds.checked_sub(1) else { return Ok(None) };
        self.rounds = left;
        if self.wanted.is_empty() {
            let wanted = |focus: &Focus| 40.0 * focus.target.log10();
            self.wanted = frames.iter().map(|foci| foci.iter().map(wanted).collect()).collect();
        }
        let places: Vec<_> = frames.iter().flatten().map(|focus| focus.position).collect();
        let levels = self.levels(&places, drives())?;
        let wanted = self.wanted.iter().flatten();
        let excess: Vec<_> = levels.iter().zip(wanted).map(|(level, wanted)| level - wanted).collect();
        let scaled: Vec<_> = frames
            .iter()
            .flatten()
            .zip(&excess)
            .filter(|(focus, _)| is_scaled(focus))
            .map(|(_, excess)| *excess)
            .collect();
        if scaled.is_empty() {
            return Ok(None);
        }
        let mean = statistics::mean(scaled.iter().copied());
        let uneven = statistics::mean(scaled.iter().map(|excess| (excess - mean).powi(2))).sqrt();
        if uneven < self.best.0 {
            self.best = (uneven, frames.to_vec());
        }
        if uneven <= EVEN {
            return Ok(None);
        }
        // Rounds need not improve: the most even one is played.
        if left == 0 {
            let (least, foci) = std::mem::take(&mut self.best);
            return Ok((least < uneven).then_some(foci));
        }
        let mut excess = excess.into_iter();
        let mut levelled = frames.to_vec();
        for focus in levelled.iter_mut().flatten() {
            let low = mean - excess.next().unwrap_or(mean);
            if is_scaled(focus) {
                focus.target *= 10f64.powf(low.clamp(-STEP, STEP) / 40.0);
            }
        }
        let loudest = |frames: &[Vec<Focus>]| {
            let scaled = frames.iter().flatten().filter(|focus| is_scaled(focus));
            scaled.map(|focus| focus.target).fold(0.0, f64::max)
        };
        let (before, now) = (loudest(frames), loudest(&levelled));
        for focus in levelled.iter_mut().flatten().filter(|focus| is_scaled(focus)) {
            focus.target = (focus.target / now).max(LEAST) * before;
        }
        Ok(Some(levelled))
    }

    /// The level (dB over threshold) at places under the drives of all frames.
    fn levels(&mut self, places: &[DVec3], drives: Vec<Drive>) -> Result<Vec<f64>, FieldError> {
        let Self { scene, stages, .. } = self;
        let (x, y) = scene.plane.axes().ok_or(FieldError::NoPlane)?;
        let on_plane = |place: &DVec3| {
            let place = *place - scene.plane.centre;
            DVec2::new(place.dot(x), place.dot(y))
        };
        let places: Vec<_> = places.iter().map(on_plane).collect();
        let half = places.iter().fold(DVec2::ZERO, |half, place| half.max(place.abs()));
        let size = 2.0 * (half + MARGIN);
        let plane = Plane { size, ..scene.plane.clone() };
        let request = Request { plane, ..Request::new(scene, drives, Quantity::Felt, (64, 64)) };
        let motion = stages.skin(&request)?;
        let level = |lines: Vec<SpectralLine>| 10.0 * request.skin.felt(&lines).max(FLOOR).log10();
        Ok(motion.at(&places).into_iter().map(level).collect())
    }
}

/// Whether a focus is of a point or a stroke.
fn is_scaled(focus: &Focus) -> bool {
    match focus.part {
        Part::Point | Part::Stroke => true,
        Part::Area(_) | Part::Trap(_) | Part::Direction => false,
    }
}
