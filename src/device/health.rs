//! The state of a board and of its line.

use std::fmt;

use crate::device::statistics::Spread;

/// The board found at the other end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub baud: u32,
    /// Carrier (Hz) as reported by the board, or of its kind.
    pub carrier: f64,
    /// Frames of a motion in its store; 0 for streamed motions.
    pub slots: usize,
    /// Phase bits of the native device.
    pub phase_bits: Option<u8>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub enum State {
    #[default]
    Connecting,
    Ready,
    Lost(String),
}

/// Frames per second of a motion: requested by the scene, and played by the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRates {
    pub asked: f64,
    pub played: f64,
    /// Cycles per second as played: a board may store fewer frames of a cycle than the scene has.
    pub cycles: f64,
}

impl FrameRates {
    /// Whether the difference is noticeable.
    pub fn differ(self) -> bool {
        (self.played / self.asked - 1.0).abs() > 1e-3
    }
}

impl fmt::Display for FrameRates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Whole frames, except for low rates.
        let digits = usize::from(self.played.min(self.asked) < 10.0) * 2;
        write!(f, "{:.digits$} frames/s asked, {:.digits$} played", self.asked, self.played)
    }
}

/// The state of a link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    pub state: State,
    /// The wanted content is playing: of a motion, at least its first frame.
    pub in_place: bool,
    /// The emergency stop has silenced the board until the next wish.
    pub stopped: bool,
    /// Frame rates of the wanted motion.
    pub rates: Option<FrameRates>,
    /// The port accepted the final silence.
    pub silenced: bool,
    /// Frames that the board has accepted (native), or that were sent.
    pub frames: u64,
    pub bytes: u64,
    pub frames_per_second: f64,
    pub bytes_per_second: f64,
    /// Packets that were refused or did not arrive.
    pub refused: u64,
    /// Number of connections to the board: one more after every loss.
    pub found: u64,
    /// Time from a packet's last byte to its answer.
    pub round_trip: Option<Spread>,
    /// Time from a wish to the last byte of its frame on the line.
    pub latency: Option<Spread>,
    /// Half periods of a modulation by swaps.
    pub swaps: Option<Spread>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_rates_have_decimals_and_a_thousandth_is_no_difference() {
        let text = |asked, played| FrameRates { asked, played, cycles: 1.0 }.to_string();
        assert_eq!(text(64.0, 9.25), "64.00 frames/s asked, 9.25 played");
        assert_eq!(text(64.0, 10.0), "64 frames/s asked, 10 played");
        let differ = |played| FrameRates { asked: 100.0, played, cycles: 1.0 }.differ();
        assert!(!differ(99.95) && !differ(100.05) && differ(99.8) && differ(100.2));
    }
}
