//! A hidden board: its elements, its air and the pose of a scan differ from their model, as a seed says.
//!
//! It is for trying measurements without hardware: they must find this truth from readings alone. Every part of it has
//! random numbers of its own, so that no part depends on what else is asked of the board.

use std::f64::consts::{PI, TAU};

use fastrand::Rng;

use crate::drive::Drive;
use crate::scene::{Medium, Scene};

/// RMS deviation of a gain from 1.
const GAIN: f64 = 0.1;
/// rad, RMS, of an element.
const PHASE: f64 = 0.44;
/// RMS, of the speed of sound, relative to the model's.
const SPEED: f64 = 2e-3;
/// m, RMS, by which the scan is displaced along each axis.
const SHIFT: f64 = 0.5e-3;
/// degrees, RMS, by which the scan is tilted about x and about y.
const TILT: f64 = 0.2;
/// Smallest number of elements of which some are dead or reversed.
const FEWEST: usize = 16;
/// Elements with exchanged terminals.
const REVERSED: usize = 2;

/// The deviations of a board, its air and a scan from their model.
#[derive(Clone, Debug, PartialEq)]
pub struct Hidden {
    seed: u64,
    /// Amplitude of each element at full drive, relative to the model's; 0 of the dead one.
    pub gains: Vec<f64>,
    /// rad, of each element, with the half turn of the reversed ones.
    pub phases: Vec<f64>,
    pub dead: Option<usize>,
    pub reversed: Vec<usize>,
    /// Speed of sound, relative to the model's.
    pub speed: f64,
    /// m, by which the scan is displaced along x, y and z.
    pub shift: [f64; 3],
    /// rad, by which the scan is turned about x and then about y, through the mean of its positions.
    pub tilts: [f64; 2],
}

/// A purpose with random numbers of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    Elements,
    Defects,
    Air,
    Pose,
    /// Places of the microphone about its nominal positions.
    Places,
    /// Phase of the microphone's reference.
    Reference,
    /// Noise in the readings of this drive.
    Noise(u64),
}

impl Stream {
    fn number(self) -> u64 {
        match self {
            Self::Elements => 0,
            Self::Defects => 1,
            Self::Air => 2,
            Self::Pose => 3,
            Self::Places => 4,
            Self::Reference => 5,
            Self::Noise(drive) => drive.wrapping_add(6),
        }
    }
}

/// A normal random number of variance 1 (Box and Muller).
pub fn normal(chance: &mut Rng) -> f64 {
    let radius = (-2.0 * (1.0 - chance.f64()).ln()).sqrt();
    radius * (TAU * chance.f64()).cos()
}

/// The random numbers of a seed for a purpose.
fn random(seed: u64, stream: Stream) -> Rng {
    /// An odd number without pattern: seeds and purposes that follow each other give unrelated numbers.
    const STEP: u64 = 0x9E37_79B9_7F4A_7C15;
    let own = seed.wrapping_add(stream.number().wrapping_add(1).wrapping_mul(STEP));
    Rng::with_seed(Rng::with_seed(own).u64(..))
}

impl Hidden {
    /// The truth of a seed for a board of so many elements.
    pub fn new(seed: u64, elements: usize) -> Self {
        let mut chance = random(seed, Stream::Elements);
        let (mut gains, mut phases): (Vec<_>, Vec<_>) =
            (0..elements).map(|_| (1.0 + GAIN * normal(&mut chance), PHASE * normal(&mut chance))).unzip();
        let mut order: Vec<_> = (0..elements).collect();
        random(seed, Stream::Defects).shuffle(&mut order);
        let (dead, reversed) = match order.split_first() {
            Some((&dead, others)) if elements >= FEWEST => (Some(dead), others[..REVERSED].to_vec()),
            _ => (None, Vec::new()),
        };
        dead.iter().for_each(|&element| gains[element] = 0.0);
        reversed.iter().for_each(|&element| phases[element] += PI);
        let speed = 1.0 + SPEED * normal(&mut random(seed, Stream::Air));
        let mut pose = random(seed, Stream::Pose);
        let shift = [0, 1, 2].map(|_| SHIFT * normal(&mut pose));
        let tilts = [0, 1].map(|_| TILT.to_radians() * normal(&mut pose));
        Self { seed, gains, phases, dead, reversed, speed, shift, tilts }
    }

    /// Random numbers of this board for a purpose, the same at every call.
    pub fn chance(&self, stream: Stream) -> Rng {
        random(self.seed, stream)
    }

    /// The drive of model elements that sounds like this drive of the hidden ones.
    pub fn sound(&self, mut drive: Drive) -> Drive {
        drive.amplitudes.iter_mut().zip(&self.gains).for_each(|(amplitude, gain)| *amplitude *= gain);
        drive.phases.iter_mut().zip(&self.phases).for_each(|(phase, own)| *phase += own);
        drive
    }

    /// The scene with the board's own speed of sound.
    pub fn scene(&self, scene: &Scene) -> Scene {
        let sound_speed = Some(self.sound_speed(scene));
        Scene { medium: Medium { sound_speed, ..scene.medium.clone() }, ..scene.clone() }
    }

    /// m/s
    fn sound_speed(&self, scene: &Scene) -> f64 {
        scene.medium.speed_of_sound() * self.speed
    }

    /// The real places (m) of a scan's nominal positions.
    pub fn places(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let count = positions.len().max(1) as f64;
        let middle = [0, 1, 2].map(|axis| positions.iter().map(|at| at[axis]).sum::<f64>() / count);
        let [(sin_x, cos_x), (sin_y, cos_y)] = self.tilts.map(f64::sin_cos);
        let place = |at: &[f64; 3]| {
            let [x, y, z] = [0, 1, 2].map(|axis| at[axis] - middle[axis]);
            let (y, z) = (y * cos_x - z * sin_x, y * sin_x + z * cos_x);
            let turned = [x * cos_y + z * sin_y, y, z * cos_y - x * sin_y];
            [0, 1, 2].map(|axis| turned[axis] + middle[axis] + self.shift[axis])
        };
        positions.iter().map(place).collect()
    }

    /// The truth as CSV with the columns `element`, `gain` and `phase` (rad), after comments with the speed of sound in
    /// a scene and the scan's pose.
    pub fn truth(&self, scene: &Scene) -> String {
        let ([x, y, z], [tilt_x, tilt_y]) = (self.shift, self.tilts);
        let comments = [
            ("sound_speed", self.sound_speed(scene), "m/s"),
            ("x", x, "m"),
            ("y", y, "m"),
            ("z", z, "m"),
            ("tilt_x", tilt_x, "rad"),
            ("tilt_y", tilt_y, "rad"),
        ];
        let mut text: String =
            comments.iter().map(|(name, value, unit)| format!("# {name} {value:?} {unit}\n")).collect();
        text += "element,gain,phase\n";
        for (element, (gain, phase)) in self.gains.iter().zip(&self.phases).enumerate() {
            text += &format!("{element},{gain:?},{phase:?}\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and standard deviation.
    fn spread(values: &[f64]) -> [f64; 2] {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
        [mean, square.sqrt()]
    }

    #[test]
    fn a_seed_has_one_truth() {
        let hidden = Hidden::new(7, 256);
        let _ = hidden.chance(Stream::Noise(0)).f64();
        assert_eq!(hidden, Hidden::new(7, 256));
        assert_eq!(hidden.chance(Stream::Places).f64(), Hidden::new(7, 9).chance(Stream::Places).f64());
        let other = Hidden::new(8, 256);
        assert!(
            hidden.gains[0] != other.gains[0] && hidden.speed != other.speed && hidden.shift != other.shift
        );
        // Air and pose do not depend on the number of elements.
        let few = Hidden::new(7, 9);
        assert_eq!((few.speed, few.shift, few.tilts), (hidden.speed, hidden.shift, hidden.tilts));
    }

    #[test]
    fn elements_spread_as_stated() {
        for seed in 0..8 {
            let hidden = Hidden::new(seed, 256);
            let own = |values: &[f64]| -> Vec<f64> {
                let is_sound = |n: &usize| Some(*n) != hidden.dead && !hidden.reversed.contains(n);
                (0..256).filter(is_sound).map(|n| values[n]).collect()
            };
            // Five standard errors of 253 elements.
            for (values, mean, deviation) in
                [(own(&hidden.gains), 1.0, GAIN), (own(&hidden.phases), 0.0, PHASE)]
            {
                let [own_mean, own_deviation] = spread(&values);
                let off = ((own_mean - mean) / deviation, own_deviation / deviation - 1.0);
                assert!(off.0.abs() < 0.32 && off.1.abs() < 0.23, "{seed}: {off:?}");
            }
        }
    }

    #[test]
    fn one_element_is_dead_and_two_others_are_reversed() {
        for seed in 0..50 {
            let hidden = Hidden::new(seed, FEWEST);
            let silent: Vec<_> = (0..FEWEST).filter(|&n| hidden.gains[n] == 0.0).collect();
            let [one, other] = hidden.reversed[..] else { panic!("{hidden:?}") };
            assert!(silent == [hidden.dead.unwrap()] && one != other && !silent.contains(&one), "{hidden:?}");
            assert!(!silent.contains(&other), "{hidden:?}");
            // Half a turn more than an array too small for defects, whose elements are the same.
            let few = Hidden::new(seed, FEWEST - 1);
            assert!(few.dead.is_none() && few.reversed.is_empty());
            for n in 0..FEWEST - 1 {
                let turn = if hidden.reversed.contains(&n) { PI } else { 0.0 };
                assert_eq!(hidden.phases[n], few.phases[n] + turn, "{seed} {n}");
            }
        }
    }

    #[test]
    fn air_and_pose_spread_as_stated() {
        let all: Vec<_> = (0..4000).map(|seed| Hidden::new(seed, 1)).collect();
        let of = |value: &dyn Fn(&Hidden) -> f64| spread(&all.iter().map(value).collect::<Vec<_>>());
        let near = |[mean, deviation]: [f64; 2], expected: f64| {
            let off = (mean / expected, deviation / expected - 1.0);
            assert!(off.0.abs() < 0.08 && off.1.abs() < 0.06, "{off:?}");
        };
        near(of(&|hidden| hidden.speed - 1.0), 2e-3);
        (0..3).for_each(|axis| near(of(&|hidden| hidden.shift[axis]), 0.5e-3));
        (0..2).for_each(|axis| near(of(&|hidden| hidden.tilts[axis].to_degrees()), 0.2));
    }

    #[test]
    fn a_pose_moves_the_scan_as_a_rigid_body() {
        let hidden = Hidden { tilts: [0.3, -0.2], ..Hidden::new(3, 1) };
        let positions = [[0.0, 0.0, 0.1], [0.04, -0.01, 0.12], [-0.03, 0.05, 0.15], [0.01, 0.02, 0.2]];
        let places = hidden.places(&positions);
        let distance =
            |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt();
        for (i, j) in [(0, 1), (0, 2), (1, 3), (2, 3)] {
            assert!((distance(places[i], places[j]) - distance(positions[i], positions[j])).abs() < 1e-14);
        }
        let mean = |all: &[[f64; 3]], axis: usize| all.iter().map(|at| at[axis]).sum::<f64>() / 4.0;
        for axis in 0..3 {
            assert!((mean(&places, axis) - mean(&positions, axis) - hidden.shift[axis]).abs() < 1e-15);
        }
        // A positive tilt about x lifts larger y; a positive tilt about y lowers larger x.
        let level = [[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, -0.1, 0.0]];
        let tilted = Hidden { tilts: [0.01, 0.02], shift: [0.0; 3], ..hidden }.places(&level);
        assert!((tilted[2][2] - 1e-3).abs() < 1e-6 && (tilted[0][2] + 2e-3).abs() < 1e-6, "{tilted:?}");
    }

    #[test]
    fn the_truth_names_every_element_and_the_pose() {
        let hidden = Hidden::new(7, 20);
        let scene = Scene::default();
        let text = hidden.truth(&scene);
        let speed = hidden.scene(&scene).medium.speed_of_sound();
        assert!(
            text.starts_with(&format!("# sound_speed {speed:?} m/s\n# x {:?} m\n", hidden.shift[0])),
            "{text}"
        );
        assert_eq!(text.lines().skip_while(|line| line.starts_with('#')).count(), 21);
        let dead = hidden.dead.unwrap();
        assert!(text.contains(&format!("\n{dead},0.0,{:?}\n", hidden.phases[dead])), "{text}");
    }
}
