//! Work sizes per kind of adapter: values that suit software adapters starve hardware.
//!
//! On llvmpipe an element is read once for eight samples and an invocation makes up to 64 pixels; other adapters
//! get four samples and four pixels per invocation. A map has some 10 000 samples, too few to fill a hardware GPU,
//! so there 32 invocations divide the elements of the same samples and add their sums (`shaders/slices.wgsl`).

/// Invocations in a workgroup, except of the field in slices.
pub const WORKGROUP: u32 = 64;
/// Limit of invocations in a workgroup on all adapters.
pub const LARGEST_WORKGROUP: u32 = 256;
/// Limit of workgroups per axis of a dispatch on all adapters.
pub const MOST_GROUPS: u32 = 65_535;

/// The shape of the work on an adapter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Whether an invocation computes eight samples instead of four. Software drivers are limited by reading
    /// elements, hardware needs many invocations.
    pub eight_samples: bool,
    /// Invocations that divide the elements of the same samples: a power of two. A map has fewer samples than hardware
    /// runs invocations.
    pub slices: u32,
    /// Whether interpolation makes many pixels per invocation, for the same reasons.
    pub large_blocks: bool,
    /// Rounds of loops in one invocation, at most.
    pub most_rounds: u32,
    /// Whether 3D pictures are drawn here: software adapters are slower than the CPU renderer.
    pub draws_space: bool,
    /// Samples times elements in one submission, so that no driver thinks that the device hangs.
    pub most_pairs: u64,
}

impl Tuning {
    /// llvmpipe silently exits a shader's loops after 65 535 iterations in total.
    pub const SOFTWARE: Self = Self {
        eight_samples: true,
        slices: 1,
        large_blocks: true,
        most_rounds: 1 << 15,
        draws_space: false,
        most_pairs: 1 << 31,
    };
    pub const INTEGRATED: Self = Self {
        eight_samples: false,
        slices: 32,
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

    /// Invocations with different samples in a workgroup of the field.
    pub fn lanes(&self) -> u32 {
        if self.slices == 1 { WORKGROUP } else { LARGEST_WORKGROUP / self.slices }
    }

    /// Samples of a workgroup of the field.
    pub fn samples_together(&self) -> u32 {
        self.lanes() * if self.eight_samples { 8 } else { 4 }
    }

    /// Pixels per line, and lines, per invocation of the interpolation for this number of parts: a single part leaves
    /// registers for more lines.
    pub fn block(&self, parts: u8) -> [usize; 2] {
        match (self.large_blocks, parts.count_ones()) {
            (true, 1) => [16, 4],
            (true, _) => [16, 1],
            (false, _) => [4, 1],
        }
    }
}

/// Description of an adapter for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterInfo {
    pub name: String,
    /// Vulkan, Metal, Dx12 or BrowserWebGpu.
    pub backend: String,
    pub driver: String,
    pub kind: Kind,
}

/// Kinds of adapter, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Discrete,
    Integrated,
    Virtual,
    Other,
    /// A software adapter on the CPU: correct, but slower than our own CPU evaluator.
    Software,
}

impl AdapterInfo {
    pub(super) fn new(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        // Browsers may hide the name.
        let name = if info.name.is_empty() { "WebGPU".to_owned() } else { info.name };
        Self {
            name,
            backend: format!("{:?}", info.backend),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            kind: match info.device_type {
                wgpu::DeviceType::DiscreteGpu => Kind::Discrete,
                wgpu::DeviceType::IntegratedGpu => Kind::Integrated,
                wgpu::DeviceType::VirtualGpu => Kind::Virtual,
                wgpu::DeviceType::Other => Kind::Other,
                wgpu::DeviceType::Cpu => Kind::Software,
            },
        }
    }
}

impl std::fmt::Display for AdapterInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = match self.kind {
            Kind::Discrete => "discrete GPU",
            Kind::Integrated => "integrated GPU",
            Kind::Virtual => "virtual GPU",
            Kind::Other => "other adapter",
            Kind::Software => "software adapter",
        };
        write!(f, "{} ({kind}, {}, {})", self.name, self.backend, self.driver)
    }
}
