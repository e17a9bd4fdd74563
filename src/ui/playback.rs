//! The displayed moment of a motion or of waves, and the displayed phase of a wave of sound.

use crate::field::Quantity;
use crate::scene::{MotionPath, Scene, motion};

/// The displayed part of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Moment {
    /// The targets at their places in the scene.
    #[default]
    Rest,
    /// A frame of the motion, counted from 0.
    Frame(usize),
    /// The mean of all frames, as `render --frame mean` draws it.
    Mean,
    /// A picture of the waves that the sound makes on a liquid, counted from 0.
    Wave(usize),
}

impl Moment {
    /// The moment on which a scene opens: the mean, if only a whole cycle makes the picture, since foci run along strokes
    /// or targets take turns.
    pub fn opening(scene: &Scene) -> Self {
        let makes_picture = |path| matches!(path, MotionPath::Outline | MotionPath::Steps);
        let cycle = motion::cycle(scene).filter(|_| scene.has_drive());
        let is_made = cycle.is_some_and(|cycle| {
            cycle.groups.iter().any(|group| makes_picture(group.motion.path)) && cycle.frames > 1
        });
        if is_made { Self::Mean } else { Self::Rest }
    }

    /// The moment that a map of a quantity shows: liquids and the skin respond to the mean of a cycle, phases have no mean, and
    /// only liquids have waves.
    pub fn of(self, quantity: Quantity) -> Self {
        let declaration = quantity.declaration();
        match self {
            Self::Wave(_) if !declaration.of_liquid => Self::Rest.of(quantity),
            Self::Rest | Self::Frame(_) if declaration.of_skin => Self::Mean,
            Self::Rest if declaration.is_slow => Self::Mean,
            Self::Mean if !declaration.has_mean => Self::Rest,
            own @ (Self::Rest | Self::Frame(_) | Self::Mean | Self::Wave(_)) => own,
        }
    }

    /// The displayed frame of the motion.
    pub fn frame(self) -> Option<usize> {
        match self {
            Self::Frame(frame) => Some(frame),
            Self::Rest | Self::Mean | Self::Wave(_) => None,
        }
    }

    /// The frame or picture that plays, of a quantity.
    pub fn playing(self, quantity: Quantity) -> Option<usize> {
        match (self, self.of(quantity)) {
            (Self::Frame(index), _) | (_, Self::Wave(index)) => Some(index),
            (Self::Rest | Self::Mean | Self::Wave(_), Self::Rest | Self::Frame(_) | Self::Mean) => None,
        }
    }
}

/// The displayed moment, and how it moves on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    pub moment: Moment,
    pub playing: bool,
    /// Slowdown of the playback.
    pub slowness: f64,
    /// Part of a cycle, or of the time of waves, in [0, 1).
    pub part: f64,
    /// Whether playback repeats.
    pub loops: bool,
}

impl Default for Playback {
    fn default() -> Self {
        Self { moment: Moment::Rest, playing: false, slowness: 20.0, part: 0.0, loops: true }
    }
}

impl Playback {
    /// The playback of a scene that is opened.
    pub fn opening(scene: &Scene) -> Self {
        Self { moment: Moment::opening(scene), ..Self::default() }
    }
}

/// The phase of an instantaneous pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    pub playing: bool,
    /// Part of a period, in [0, 1).
    pub part: f64,
}
