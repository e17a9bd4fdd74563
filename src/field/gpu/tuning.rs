//! How work is cut for a kind of adapter. What suits a program that plays GPU on the CPU starves a real one.

use crate::field::gpu::adapter::Kind;

/// The shape of the work on an adapter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Samples that an invocation of the field computes: eight, or four. Software drivers take the time to read an element,
    /// real ones need many invocations.
    pub eight_samples: bool,
    /// Interpolation makes one pixel per invocation, and not 16 on each of 4 lines.
    pub single_pixels: bool,
    /// Workgroups of the passes that walk over all pixels.
    pub walking_groups: u32,
    /// Rounds of loops in one invocation, at most.
    pub most_rounds: u32,
    /// Samples times elements in one submission, so that no driver thinks that the device hangs.
    pub most_pairs: u64,
}

impl Tuning {
    /// llvmpipe leaves a shader's loops after 65 535 rounds of them in all, and says nothing.
    pub const SOFTWARE: Self = Self {
        eight_samples: true,
        single_pixels: false,
        walking_groups: 256,
        most_rounds: 1 << 15,
        most_pairs: 1 << 31,
    };
    pub const INTEGRATED: Self = Self {
        eight_samples: false,
        single_pixels: true,
        walking_groups: 1024,
        most_rounds: 1 << 20,
        most_pairs: 1 << 33,
    };
    pub const DISCRETE: Self = Self { walking_groups: 8192, most_pairs: 1 << 36, ..Self::INTEGRATED };

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
}
