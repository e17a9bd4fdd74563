//! Counters of stage runs, which show that no work is repeated.

/// How often each stage ran.
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
        Self {
            plan: self.plan - before.plan,
            transfer: self.transfer - before.transfer,
            superposition: self.superposition - before.superposition,
            interpolation: self.interpolation - before.interpolation,
            forming: self.forming - before.forming,
            response: self.response - before.response,
            caustic: self.caustic - before.caustic,
            picture: self.picture - before.picture,
            contours: self.contours - before.contours,
            read_back: self.read_back - before.read_back,
            allocations: self.allocations - before.allocations,
        }
    }
}
