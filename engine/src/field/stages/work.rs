//! Counters of stage runs, which show that no work is repeated.

use std::ops::Add;

/// Number of runs of each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    pub plan: u64,
    /// Tables of the transfer to the samples.
    pub transfer: u64,
    /// Sums over the elements, at the samples or at pixels.
    pub superposition: u64,
    pub interpolation: u64,
    /// Values of the formula at pixels or cells, per drive.
    pub forming: u64,
    /// Answers of a liquid.
    pub response: u64,
    /// Light on a screen.
    pub caustic: u64,
    pub picture: u64,
    /// Contour lines.
    pub contours: u64,
    /// Bytes read back from the GPU.
    pub read_back: u64,
    /// Buffers, textures and bind groups created on it.
    pub allocations: u64,
}

impl Work {
    /// The work done since `before`.
    pub fn since(self, before: Self) -> Self {
        self.with(before, |own, other| own - other)
    }

    fn with(self, other: Self, each: fn(u64, u64) -> u64) -> Self {
        Self {
            plan: each(self.plan, other.plan),
            transfer: each(self.transfer, other.transfer),
            superposition: each(self.superposition, other.superposition),
            interpolation: each(self.interpolation, other.interpolation),
            forming: each(self.forming, other.forming),
            response: each(self.response, other.response),
            caustic: each(self.caustic, other.caustic),
            picture: each(self.picture, other.picture),
            contours: each(self.contours, other.contours),
            read_back: each(self.read_back, other.read_back),
            allocations: each(self.allocations, other.allocations),
        }
    }
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.with(other, |own, other| own + other)
    }
}
