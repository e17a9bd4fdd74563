//! Keyframes: offsets, pressures, turns and phases at times within a cycle, and the interpolation between them.

use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};

use glam::DVec3;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::motion::pose::Pose;
use crate::scene::solver::is_zero;

/// Position, pressure, turn and phase of a target at a time within a repetition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Part of a repetition, in [0, 1).
    pub time: f64,
    /// Offset from the target's position, m.
    #[serde(default)]
    pub at: DVec3,
    /// Factor on the target pressure.
    #[serde(default = "unchanged", skip_serializing_if = "is_unchanged")]
    pub pressure: f64,
    /// Turn (rad) about the target's normal, beside the target's own angle; 2π is a full turn.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub angle: f64,
    /// Phase (rad) added to the signature of a trap: to its opposite part, of a vortex to its phase.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub phase: f64,
    /// On the way to the next.
    #[serde(default, skip_serializing_if = "Easing::is_linear")]
    pub easing: Easing,
}

fn unchanged() -> f64 {
    1.0
}

fn is_unchanged(pressure: &f64) -> bool {
    *pressure == 1.0
}

/// The interpolation from a keyframe to the next.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames,
)]
#[strum(serialize_all = "kebab-case", const_into_str)]
pub enum Easing {
    /// At constant speed.
    #[default]
    Linear,
    /// From rest to rest: 3t² - 2t³.
    Smooth,
    /// Constant until the next keyframe, then a jump.
    Hold,
}

impl Easing {
    fn is_linear(&self) -> bool {
        *self == Self::Linear
    }

    /// The fraction of the way after a fraction of the time.
    fn ease(self, part: f64) -> f64 {
        match self {
            Self::Linear => part,
            Self::Smooth => part * part * (3.0 - 2.0 * part),
            Self::Hold => 0.0,
        }
    }
}

impl Keyframe {
    pub fn new(time: f64, at: DVec3) -> Self {
        Self { time, at, pressure: 1.0, angle: 0.0, phase: 0.0, easing: Easing::Linear }
    }

    fn pose(&self) -> Pose {
        Pose { at: self.at, pressure: self.pressure, angle: self.angle, phase: self.phase }
    }
}

/// The pose after a part of a repetition, in [0, 1), from keyframes in the order of their times. The last is followed by
/// the first, a repetition later; the turn that closes the cycle is the shorter one, so that a full turn goes on.
pub(super) fn between(keyframes: &[Keyframe], part: f64) -> Pose {
    let (Some(first), Some(last)) = (keyframes.first(), keyframes.last()) else {
        return Pose::AT_REST;
    };
    let next = keyframes.partition_point(|keyframe| keyframe.time <= part);
    let (from, passed) = match next.checked_sub(1) {
        Some(before) => (&keyframes[before], part - keyframes[before].time),
        None => (last, part + 1.0 - last.time),
    };
    let (to, taken) = match keyframes.get(next) {
        Some(to) if next > 0 => (to, to.time - from.time),
        Some(to) => (to, to.time + 1.0 - from.time),
        None => (first, first.time + 1.0 - from.time),
    };
    let is_closing = next == 0 || next == keyframes.len();
    let to = if is_closing { closing(keyframes, last) } else { to.pose() };
    from.pose().lerp(to, from.easing.ease(passed / taken))
}

/// The first pose as it follows the last: turn and phase by the shorter way, or on in the same direction after half a
/// turn.
fn closing(keyframes: &[Keyframe], last: &Keyframe) -> Pose {
    /// rad: typed half turns.
    const ROUNDED: f64 = 0.01;
    let first = keyframes.first().unwrap_or(last).pose();
    let before = keyframes.len().checked_sub(2).map_or(first, |before| keyframes[before].pose());
    let close = |from: f64, to: f64, before: f64| {
        let short = to - from - TAU * ((to - from) / TAU).round();
        let is_half = short.abs() > PI - ROUNDED;
        let is_back = (from - before) * short < 0.0;
        from + if is_half && is_back { short + TAU.copysign(from - before) } else { short }
    };
    let angle = close(last.angle, first.angle, before.angle);
    Pose { angle, phase: close(last.phase, first.phase, before.phase), ..first }
}

/// Length of a repetition (m), without jumps.
pub(super) fn length(keyframes: &[Keyframe]) -> f64 {
    let next = keyframes.iter().cycle().skip(1);
    let way = |(from, to): (&Keyframe, &Keyframe)| match from.easing {
        Easing::Linear | Easing::Smooth => from.at.distance(to.at),
        Easing::Hold => 0.0,
    };
    keyframes.iter().zip(next).map(way).sum()
}

/// Inserts a keyframe, replacing one at the same time, and returns its index.
pub fn insert(keyframes: &mut Vec<Keyframe>, keyframe: Keyframe) -> usize {
    let place =
        keyframes.binary_search_by(|other| other.time.partial_cmp(&keyframe.time).unwrap_or(Ordering::Less));
    match place {
        Ok(index) => {
            keyframes[index] = keyframe;
            index
        }
        Err(index) => {
            keyframes.insert(index, keyframe);
            index
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyframes() -> Vec<Keyframe> {
        let at = DVec3::new;
        vec![
            Keyframe { pressure: 2.0, ..Keyframe::new(0.1, at(0.0, 0.0, 0.0)) },
            Keyframe { easing: Easing::Smooth, ..Keyframe::new(0.3, at(0.04, 0.0, 0.0)) },
            Keyframe { easing: Easing::Hold, ..Keyframe::new(0.5, at(0.04, 0.02, 0.01)) },
            Keyframe { pressure: 0.5, ..Keyframe::new(0.9, at(0.0, 0.02, 0.0)) },
        ]
    }

    #[test]
    fn the_way_between_keyframes_is_that_of_their_easings() {
        let keyframes = keyframes();
        for (part, at, pressure) in [
            // Linear: a quarter, half.
            (0.1, [0.0, 0.0, 0.0], 2.0),
            (0.15, [0.01, 0.0, 0.0], 1.75),
            (0.2, [0.02, 0.0, 0.0], 1.5),
            // Smooth: 3/16 - 2/64 = 5/32 of the way after a quarter of the time.
            (0.35, [0.04, 0.02 * 5.0 / 32.0, 0.01 * 5.0 / 32.0], 1.0),
            (0.4, [0.04, 0.01, 0.005], 1.0),
            // Held, and then elsewhere.
            (0.5, [0.04, 0.02, 0.01], 1.0),
            (0.899_999_999, [0.04, 0.02, 0.01], 1.0),
            (0.9, [0.0, 0.02, 0.0], 0.5),
            // Over the end of the repetition: from 0.9 to 1.1.
            (0.95, [0.0, 0.015, 0.0], 0.875),
            (0.0, [0.0, 0.01, 0.0], 1.25),
            (0.05, [0.0, 0.005, 0.0], 1.625),
        ] {
            let Pose { at: found, pressure: loud, .. } = between(&keyframes, part);
            assert!(found.distance(DVec3::from(at)) < 1e-9, "{part}: {found}");
            assert!((loud - pressure).abs() < 1e-7, "{part}: {loud}");
        }
        assert!(between(&keyframes[3..], 0.2).at.distance(keyframes[3].at) < 1e-15, "one stands still");
        assert_eq!(between(&[], 0.2).at, DVec3::ZERO);
        let ways = 0.04 + f64::hypot(0.02, 0.01) + 0.02;
        assert!((length(&keyframes) - ways).abs() < 1e-12);
    }

    #[test]
    fn a_turn_is_not_wrapped_and_closes_by_the_shorter_way() {
        /// Half a turn as people write it.
        const ROUNDED: f64 = PI - 1.6e-3;
        let turning = |angles: &[(f64, f64)]| -> Vec<_> {
            let of = |&(time, angle): &(f64, f64)| Keyframe { angle, ..Keyframe::new(time, DVec3::ZERO) };
            angles.iter().map(of).collect()
        };
        for (angles, part, wanted) in [
            (&[(0.0, 0.0), (0.5, TAU)][..], 0.25, PI),
            (&[(0.0, 0.0), (0.5, TAU)], 0.75, TAU),
            // On through the second half, also if the half turn is rounded.
            (&[(0.0, 0.0), (0.5, PI)], 0.75, 1.5 * PI),
            (&[(0.0, 0.0), (0.5, ROUNDED)], 0.75, (ROUNDED + TAU) / 2.0),
            (&[(0.0, 0.0), (0.5, -ROUNDED)], 0.75, -(ROUNDED + TAU) / 2.0),
            (&[(0.0, 0.0), (0.5, 1.0)], 0.75, 0.5),
            (&[(0.25, 0.5), (0.75, 4.0 * PI)], 0.0, 4.0 * PI + 0.25),
        ] {
            let angle = between(&turning(angles), part).angle;
            assert!((angle - wanted).abs() < 1e-12, "{angles:?} at {part}: {angle}");
        }
    }

    #[test]
    fn a_keyframe_goes_to_its_time() {
        let mut all = keyframes();
        assert_eq!(insert(&mut all, Keyframe::new(0.4, DVec3::X)), 2);
        assert_eq!(insert(&mut all, Keyframe::new(0.4, DVec3::Y)), 2);
        assert_eq!(insert(&mut all, Keyframe::new(0.95, DVec3::Z)), 5);
        assert_eq!(insert(&mut all, Keyframe::new(0.0, DVec3::Z)), 0);
        assert!(all.len() == 7 && all.is_sorted_by(|a, b| a.time < b.time));
    }
}
