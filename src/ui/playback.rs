//! The displayed frame of a motion, and the displayed phase of a wave.

/// The displayed frame of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// `None` shows the scene at rest.
    pub frame: Option<usize>,
    pub playing: bool,
    /// Slowdown of the playback.
    pub slowness: f64,
    /// Part of a cycle, in [0, 1).
    pub part: f64,
    /// Whether playback repeats.
    pub loops: bool,
}

impl Default for Playback {
    fn default() -> Self {
        Self { frame: None, playing: false, slowness: 20.0, part: 0.0, loops: true }
    }
}

/// The phase of an instantaneous pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    pub playing: bool,
    /// Part of a period, in [0, 1).
    pub part: f64,
}
