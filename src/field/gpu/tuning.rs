//! Work sizes per kind of adapter: values that suit software adapters starve hardware.

use crate::field::gpu::adapter::Kind;

/// The shape of the work on an adapter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Samples that an invocation of the field computes: eight, or four. Software drivers take the time to read an element,
    /// real ones need many invocations.
    pub eight_samples: bool,
    /// Interpolation makes many pixels per invocation, or a few, for the same reasons.
    pub large_blocks: bool,
    /// Rounds of loops in one invocation, at most.
    pub most_rounds: u32,
    /// Pictures of space are drawn here: what plays GPU takes longer for them than the CPU itself.
    pub draws_space: bool,
    /// Samples times elements in one submission, so that no driver thinks that the device hangs.
    pub most_pairs: u64,
}

impl Tuning {
    /// llvmpipe leaves a shader's loops after 65 535 rounds of them in all, and says nothing.
    pub const SOFTWARE: Self = Self {
        eight_samples: true,
        large_blocks: true,
        most_rounds: 1 << 15,
        draws_space: false,
        most_pairs: 1 << 31,
    };
    pub const INTEGRATED: Self = Self {
        eight_samples: false,
        large_blocks: false,
        most_rounds: 1 << 20,
        draws_space: true,
        most_pairs: 1 << 33,
    };
    pub const DISCRETE: Self = Self { most_pairs: 1 << 36, ..Self::INTEGRATED };

    pub fn of(kind: Kind) -> Self {
        match kind {
            Kind::Discrete => Self::DISCRETE,
            Kind::Integrated | Kind::Virtual | Kind::Other => Self::INTEGRATED,
            Kind::Software => Self::SOFTWARE,
        }
    }

    /// Samples of a workgroup of the field.
    pub fn samples_per_invocation(&self) -> u32 {
        if self.eight_samples { 8 } else { 4 }
    }

    /// Pixels of a line and lines that an invocation of the interpolation makes of so many parts of the sound: what is alone leaves
    /// room for more lines.
    pub fn block(&self, parts: u8) -> [usize; 2] {
        match (self.large_blocks, parts.count_ones()) {
            (true, 1) => [16, 4],
            (true, _) => [16, 1],
            (false, _) => [4, 1],
        }
    }
}
