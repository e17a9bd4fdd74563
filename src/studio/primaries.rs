//! Three primaries of touch: pressure, flutter and vibration, mixed by a slow circular motion and two tones of the radiation
//! pressure.
//!
//! A focus that circles a few times a second with a radius of some millimetres, in steps below 1 mm, is felt as nearly static
//! pressure (Morisaki 2022). Tones of 30 and 150 Hz are felt as flutter and vibration. The three together give six textures at
//! least (arXiv 2601.16767, 2026).

use crate::scene::motion;
use crate::scene::{Envelope, Law, Modulation, Motion, MotionPath, Scene, Tempo, Tone};

/// Largest radius of the circle, m.
const RADIUS: f64 = 4e-3;
/// Cycles per second of a new circle, and of all that are felt as pressure.
const RATE: f64 = 5.0;
const RATES: std::ops::RangeInclusive<f64> = 5.0..=15.0;
/// Frames of a circle: steps of 0.8 mm at most.
const FRAMES: u32 = 32;
/// Hz
pub const FLUTTER: f64 = 30.0;
pub const VIBRATION: f64 = 150.0;

/// Amounts of the primaries, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Radius of the circle relative to the largest.
    pub pressure: f64,
    /// Depths of the tones; together 1 at most.
    pub flutter: f64,
    pub vibration: f64,
}

impl Primaries {
    /// The amounts in a scene.
    pub fn of(scene: &Scene) -> Self {
        let Modulation { shape, tones, .. } = &scene.modulation;
        let depth = |frequency: f64| {
            let same = tones.iter().filter(|tone| *shape == Envelope::Tones && tone.frequency == frequency);
            same.fold(0.0, |sum, tone| sum + tone.depth)
        };
        let pressure = if is_pressure(&scene.motion) { scene.motion.size / (2.0 * RADIUS) } else { 0.0 };
        Self { pressure, flutter: depth(FLUTTER), vibration: depth(VIBRATION) }
    }

    /// Gives them to a scene. What does not differ stays as it is there; both tones replace any other modulation.
    pub fn apply(self, scene: &mut Scene) {
        let before = Self::of(scene);
        if self.pressure != before.pressure {
            scene.motion = circle(&scene.motion, self.pressure);
        }
        if (self.flutter, self.vibration) != (before.flutter, before.vibration) {
            let tones = [(FLUTTER, self.flutter), (VIBRATION, self.vibration)];
            let tones = tones.into_iter().filter(|(_, depth)| *depth > 0.0);
            let tones: Vec<_> =
                tones.map(|(frequency, depth)| Tone { frequency, depth, phase: 0.0 }).collect();
            let (shape, law) = if tones.is_empty() {
                (Envelope::Off, Law::default())
            } else {
                (Envelope::Tones, Law::Power)
            };
            scene.modulation = Modulation { shape, law, tones, ..scene.modulation.clone() };
        }
    }
}

/// Whether the motion of a scene, which pressure would replace, is another than its circle.
pub fn has_other_motion(scene: &Scene) -> bool {
    motion::moves(scene) && !is_pressure(&scene.motion)
}

fn is_pressure(motion: &Motion) -> bool {
    let is_slow = matches!(motion.tempo, Tempo::Rate(rate) if RATES.contains(&rate));
    motion.path == MotionPath::Circle && is_slow && motion.size <= 2.0 * RADIUS
}

/// The motion with a circle of this part of the largest radius, at the rate that it has.
fn circle(before: &Motion, part: f64) -> Motion {
    if part <= 0.0 {
        return Motion { size: Motion::default().size, path: MotionPath::None, ..before.clone() };
    }
    let (tempo, frames) = match is_pressure(before) {
        true => (before.tempo, before.frames.max(FRAMES)),
        false => (Tempo::Rate(RATE), FRAMES),
    };
    Motion {
        path: MotionPath::Circle,
        size: 2.0 * RADIUS * part,
        angle: 0.0,
        tempo,
        frames,
        ..before.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::check;

    #[test]
    fn a_scene_has_the_primaries_given_to_it() {
        let mut scene = crate::scene::file::parse(crate::studio::EXAMPLE, "hit.toml".as_ref()).unwrap();
        let before = scene.clone();
        for (pressure, flutter, vibration) in
            [(0.0, 0.4, 0.0), (1.0, 0.4, 0.6), (0.01, 0.0, 1.0), (0.5, 0.0, 0.0)]
        {
            let wanted = Primaries { pressure, flutter, vibration };
            wanted.apply(&mut scene);
            let found = Primaries::of(&scene);
            assert_eq!((found.flutter, found.vibration), (flutter, vibration));
            assert!((found.pressure - pressure).abs() < 1e-12);
            check::check(&scene).unwrap();
        }
        assert!(std::f64::consts::TAU * RADIUS / f64::from(scene.motion.frames) < 1e-3, "steps");
        Primaries { pressure: 0.0, flutter: 0.0, vibration: 0.0 }.apply(&mut scene);
        assert!(!motion::moves(&scene) && scene.modulation.shape == Envelope::Off);
        assert_eq!((scene.motion.size, scene.targets), (before.motion.size, before.targets));
    }
}
