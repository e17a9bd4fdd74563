//! Targets under their own modulations: the cycle of frames in which all envelopes repeat, and their values in every frame.
//!
//! A board has one envelope for all elements, so different envelopes of targets become frames: the common period of the
//! modulations and of the motion is cut into equal frames, at least 16 per period of the fastest modulation or one per sample
//! of a waveform, and at most one per period of the carrier; each lasts whole periods of it, if that is possible. A frame has the envelopes of its middle, so that holding a frame
//! until the next delays no envelope. Edges of a square wave fall between frames if a number of frames allows that.

use crate::scene::content::Scene;
use crate::scene::modulation::{Envelope, LONGEST, Modulation, common};
use crate::scene::motion::{Motion, MotionPath};
use crate::scene::outline;
use crate::scene::range::{Key, KeyError};

/// Time steps of an envelope per frame: 16 frames in a period.
const STEPS_PER_FRAME: f64 = 4.0;
/// Frames that edges of square waves may cost, as a factor.
const FOR_EDGES: u64 = 4;

/// A cycle in which all envelopes repeat.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// s
    pub period: f64,
    pub frames: u32,
    /// Cycles of the motion in it.
    pub rounds: u64,
}

/// The envelopes of a scene's foci.
#[derive(Clone, Debug)]
pub struct Envelopes {
    /// The envelope of every focus.
    pub of_foci: Vec<usize>,
    /// Its values, 0 to 1, frame by frame: as many as there are different envelopes.
    pub frames: Vec<Vec<f64>>,
}

/// The different modulations of visible targets.
fn different(scene: &Scene) -> Vec<&Modulation> {
    let mut all: Vec<&Modulation> = Vec::new();
    for target in scene.targets.iter().filter(|target| target.visible) {
        let own = scene.modulation_of(target);
        if !all.iter().any(|other| other.is_like(own)) {
            all.push(own);
        }
    }
    all
}

/// The common cycle of the envelopes and of a motion with this rate (1/s) and number of frames.
///
/// # Errors
/// No common period, as text.
pub fn fit(scene: &Scene, motion: Option<(f64, u32)>) -> Result<Fit, String> {
    let all = different(scene);
    let own = all.iter().filter(|own| !own.is_steady()).filter_map(|own| own.period());
    let mut periods: Vec<_> = own.chain(motion.map(|(rate, _)| 1.0 / rate)).collect();
    periods.sort_by(f64::total_cmp);
    let first = periods.pop().unwrap_or(1.0);
    let period =
        periods.into_iter().rev().try_fold(first, common).filter(|period| *period <= LONGEST.max(first));
    let Some(period) = period else {
        return Err(format!(
            "the modulations of the targets{} have no common period up to {LONGEST} s: take frequencies that are multiples of \
             one, as 160 and 200 Hz are of 40 Hz",
            if motion.is_some() { " and the motion" } else { "" }
        ));
    };
    let carrier = scene.array.frequency;
    let fastest = all.iter().map(|own| match own.shape {
        Envelope::Off => 0.0,
        Envelope::Sine | Envelope::Square | Envelope::Tones => own.step_rate() / STEPS_PER_FRAME,
        Envelope::File => own.step_rate(),
    });
    let wanted = (fastest.fold(0.0, f64::max).min(carrier) * period).ceil().max(1.0) as u64;
    let rounds = motion.map_or(1, |(rate, _)| (rate * period).round().max(1.0) as u64);
    let of_motion = motion.map_or(1, |(_, frames)| u64::from(frames).saturating_mul(rounds));
    let squares = all.iter().filter(|own| own.shape == Envelope::Square);
    let edges = squares.map(|own| (2.0 * own.frequency * period).round() as u64).fold(of_motion, multiple);
    let grain = if edges <= wanted.max(of_motion).saturating_mul(FOR_EDGES) { edges } else { of_motion };
    let least = wanted.div_ceil(grain).max(1);
    let frames = in_time(carrier * period, grain, least).saturating_mul(grain);
    Ok(Fit { period, frames: u32::try_from(frames).unwrap_or(u32::MAX), rounds })
}

/// At least so many multiples of a number of frames, and if possible as many as last whole periods of the carrier each, which
/// boards play in time.
fn in_time(periods: f64, grain: u64, least: u64) -> u64 {
    /// Multiples tried, as a factor on the least number.
    const MOST: u64 = 2;
    let whole = periods.round();
    let lasts = |times: &u64| (whole as u64).is_multiple_of(times.saturating_mul(grain));
    let fits = |_: &u64| (periods - whole).abs() < 1e-6 * periods;
    (least..=least.saturating_mul(MOST).min(least.saturating_add(10_000)))
        .filter(fits)
        .find(lasts)
        .unwrap_or(least)
}

/// The least common multiple; the first number for 0 and beyond all numbers.
fn multiple(a: u64, b: u64) -> u64 {
    let divisor = |mut a: u64, mut b: u64| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    match b {
        0 => a,
        _ => (a / divisor(a, b)).checked_mul(b).unwrap_or(a),
    }
}

/// The own modulation that an error is about: the first of a visible target.
pub fn key(scene: &Scene) -> Vec<Key> {
    let index = scene.targets.iter().position(|target| target.visible && target.modulation.is_some());
    vec![Key::from("target"), Key::from(index.unwrap_or(0)), Key::from("modulation")]
}

/// Checks what does not go with envelopes that differ.
///
/// # Errors
/// Traps, targets in turn, foci that run along outlines, or no common period.
pub fn check(scene: &Scene, motion: Option<(f64, u32)>) -> Result<(), KeyError> {
    if !scene.has_own_envelopes() {
        return Ok(());
    }
    let refuse = |message: String| Err(KeyError::new(key(scene), message));
    let shown = || scene.targets.iter().filter(|target| target.visible);
    if shown().any(|target| target.shape.is_trap()) {
        return refuse("a trap holds its bead under one modulation of all targets only".to_owned());
    }
    let all = shown().filter_map(|target| target.motion.as_ref()).chain([&scene.motion]);
    let has = |path: MotionPath| all.clone().any(|motion: &Motion| motion.path == path);
    if has(MotionPath::Outline) {
        return refuse(
            "foci that run along outlines (`path = \"outline\"`) share the modulation of the scene"
                .to_owned(),
        );
    }
    if has(MotionPath::Steps) {
        return refuse(
            "targets that take turns (`path = \"steps\"`) share the modulation of the scene".to_owned(),
        );
    }
    fit(scene, motion).map(drop).or_else(refuse)
}

/// The envelopes of the foci of targets at rest, or moved as a whole, in these frames of a period (s).
///
/// # Errors
/// Invalid focal points.
pub fn values(scene: &Scene, period: f64, frames: u32) -> Result<Envelopes, KeyError> {
    let (all, of_foci) = shares(scene)?;
    let at = |frame: u32| {
        let time = (f64::from(frame) + 0.5) / f64::from(frames) * period;
        all.iter().map(|own| own.envelope(time)).collect()
    };
    Ok(Envelopes { of_foci, frames: (0..frames).map(at).collect() })
}

/// The different modulations of visible targets, and which one each focus follows.
///
/// # Errors
/// Invalid focal points.
pub fn shares(scene: &Scene) -> Result<(Vec<&Modulation>, Vec<usize>), KeyError> {
    let all = different(scene);
    let targets: Vec<_> = scene.targets.iter().enumerate().filter(|(_, target)| target.visible).collect();
    let foci = outline::foci_of_targets(scene, &targets)?;
    let of_foci = foci.iter().zip(&targets).flat_map(|(foci, (_, target))| {
        let own = scene.modulation_of(target);
        let index = all.iter().position(|other| other.is_like(own)).unwrap_or(0);
        std::iter::repeat_n(index, foci.len())
    });
    let of_foci = of_foci.collect();
    Ok((all, of_foci))
}
