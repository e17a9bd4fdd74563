//! Playback of a motion on a native board: from its own store, or streamed frame by frame.
//!
//! A motion is played from the device's store, with a number of frames that ends its cycle on time, or streamed if
//! the line carries more frames.

/// Tolerated relative deviation of a stored cycle's duration.
const CYCLE_TOLERANCE: f64 = 1e-2;
/// Part of the line's capacity for a stream: the rest is for retransmissions.
const LINE_SHARE: f64 = 0.9;
/// The least phase step of a cycle's ramps, 1/256 of a unit per period: at 1.5 units elements are 234 Hz off the carrier, which leaves a
/// T4010A1 0.91 of its amplitude. The step of single frames (3 units) leaves 0.80, but follows a hand sooner.
pub const GENTLE: u16 = 0x0180;
/// Most periods that a slot is played for.
const LONGEST_SLOT: f64 = 65_535.0;

/// The requirements of a motion, and the capabilities of board and line.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Frames of one cycle.
    pub frames: usize,
    /// Requested frames per second.
    pub rate: f64,
    /// Slots of the board's store.
    pub slots: usize,
    /// Hz
    pub carrier: f64,
    /// Frames per second that the line carries.
    pub line: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// `count` frames of a cycle, evenly chosen, are stored on the board and played for `divider` periods each.
    Stored { count: usize, divider: u16 },
    /// The due frame is sent.
    Streamed,
}

impl Motion {
    /// Stored if the board holds a full cycle; streamed if decimation would lose frames that the line can carry.
    pub fn way(&self) -> Way {
        let whole = self.frames <= self.slots;
        match self.stored() {
            Some(stored) if whole || self.rate > LINE_SHARE * self.line => stored,
            _ => Way::Streamed,
        }
    }

    /// Played frames per second.
    pub fn played(&self, way: Way) -> f64 {
        match way {
            Way::Stored { divider, .. } => self.carrier / f64::from(divider),
            Way::Streamed => self.rate.min(self.line),
        }
    }

    /// The number of frames that keeps the cycle within [`CYCLE_TOLERANCE`]; if none above half of the store does,
    /// the closest.
    fn stored(&self) -> Option<Way> {
        let cycle = self.carrier * self.frames as f64 / self.rate;
        let most = self.frames.min(self.slots);
        let counts = most.div_ceil(2).max(1)..=most;
        let nearest = counts.rev().filter_map(|count| {
            let divider = (cycle / count as f64).round();
            let miss = (divider * count as f64 / cycle - 1.0).abs();
            (1.0..=LONGEST_SLOT)
                .contains(&divider)
                .then_some((miss, Way::Stored { count, divider: divider as u16 }))
        });
        let mut best: Option<(f64, Way)> = None;
        for (miss, way) in nearest {
            if best.is_none_or(|(least, _)| miss < least) {
                best = Some((miss, way));
            }
            if miss <= CYCLE_TOLERANCE {
                break;
            }
        }
        best.map(|(_, way)| way)
    }
}

/// The frame of each of `count` slots, evenly chosen.
pub fn chosen(frames: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count).map(move |slot| slot * frames / count)
}

/// The silencer's phase step (1/256 of a unit per period) with which delays settle within `divider` periods, at least
/// `least`.
pub fn phase_step(delays: &[Vec<u8>], divider: u16, least: u16) -> u16 {
    let turn = |a: u8, b: u8| u16::from(a.wrapping_sub(b).min(b.wrapping_sub(a)));
    let next = delays.iter().cycle().skip(1);
    let pairs = delays.iter().zip(next).flat_map(|(a, b)| a.iter().zip(b));
    let farthest = pairs.map(|(&a, &b)| turn(a, b)).max().unwrap_or(0);
    (farthest * 256).div_ceil(divider.max(1)).max(least)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::acoustics::response::Resonator;
    use crate::drive::Drive;
    use crate::scene::{Array, Response, Scene, Transducer};

    fn motion(frames: usize, rate: f64, line: f64) -> Motion {
        Motion { frames, rate, slots: 64, carrier: 40_000.0, line }
    }

    #[test]
    fn the_default_motion_is_stored_whole_and_on_time() {
        let motion = motion(64, 320.0, 740.0);
        assert_eq!(motion.way(), Way::Stored { count: 64, divider: 125 });
        assert_eq!(motion.played(motion.way()), 320.0);
    }

    #[test]
    fn a_stored_cycle_lasts_as_long_as_the_one_asked_for() {
        for (rounds, tolerance) in
            [(5.0, 1e-2), (40.0, 1e-2), (50.0, 1e-2), (100.0, 1e-2), (200.0, 1e-2), (300.0, 0.02)]
        {
            for frames in [2, 7, 64, 128, 1000] {
                let motion = motion(frames, rounds * frames as f64, 40.0);
                let Way::Stored { count, divider } = motion.way() else {
                    panic!("{rounds} x {frames}: streamed")
                };
                assert!(count <= 64.min(frames) && count >= 64.min(frames) / 2, "{count} of {frames}");
                let cycle = count as f64 * f64::from(divider) / 40_000.0;
                let tolerance = if frames < 60 { 0.1 } else { tolerance };
                assert!(
                    (cycle * rounds - 1.0).abs() <= tolerance,
                    "{rounds} x {frames}: {count} x {divider}"
                );
            }
        }
    }

    #[test]
    fn what_the_line_carries_is_not_thinned() {
        assert_eq!(motion(128, 128.0, 740.0).way(), Way::Streamed);
        assert!(matches!(motion(128, 2560.0, 170.0).way(), Way::Stored { count: 32..=64, .. }));
        // Slots cannot last so long.
        assert_eq!(motion(4, 0.01, 740.0).way(), Way::Streamed);
        assert_eq!(motion(4, 0.01, 740.0).played(Way::Streamed), 0.01);
    }

    #[test]
    fn frames_are_chosen_evenly() {
        assert!(chosen(64, 64).eq(0..64));
        for (frames, count) in [(128, 64), (100, 64), (65, 64), (7, 3)] {
            let chosen: Vec<_> = chosen(frames, count).chain([frames]).collect();
            let steps: Vec<_> = chosen.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(steps.iter().max().unwrap() - steps.iter().min().unwrap() <= 1, "{chosen:?}");
        }
    }

    #[test]
    fn delays_have_time_to_follow() {
        let least = 0x0300;
        assert_eq!(phase_step(&[vec![0, 10], vec![20, 250]], 100, least), least);
        // 20 units in 4 periods, and a half turn in one.
        assert_eq!(phase_step(&[vec![0, 10], vec![20, 250]], 4, least), 20 * 64);
        assert_eq!(phase_step(&[vec![0], vec![128]], 1, least), 128 * 256);
    }

    /// The least amplitude of an element that follows a half turn by this step (1/256 of a unit per period) and back.
    fn dip(step: u16) -> f64 {
        let array = Array { response: Some(Response::Preset(Transducer::T4010A1)), ..Array::default() };
        let resonator = Resonator::new(&Scene { array, ..Scene::default() }).unwrap();
        let ramp = |period: u32| f64::from((period * u32::from(step)).min(128 * 256)) / 256.0;
        let there = (0..400).map(ramp);
        let back = (0..400).map(|period| 128.0 - ramp(period));
        let drive =
            |units: f64| Drive { amplitudes: vec![1.0], phases: vec![units * TAU / 256.0] }.excitation(&[0]);
        let drives: Vec<_> = there.chain(back).map(drive).collect();
        let missing = resonator.missing(&drives, 1.0 / 40_000.0);
        let sounds = drives.iter().zip(missing).map(|(drive, missing)| (drive[0] + missing[0]).norm());
        sounds.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn slow_cycles_are_ramped_without_deep_dips() {
        let step = phase_step(&[vec![0], vec![128]], 400, GENTLE);
        assert!(dip(step) > 0.9, "{}", dip(step));
        assert!(dip(0x0300) < 0.82 && dip(u16::MAX) < 0.2, "the steps of single frames, and a jump");
    }
}
