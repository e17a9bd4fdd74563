//! Which adapters there are, and which of them is worth using.

use crate::field::gpu::{Gpu, GpuError};

/// Interfaces that compute; a driver offers the same adapter through OpenGL too, without half of its limits.
pub const BACKENDS: wgpu::Backends =
    wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

/// What a user wants to know of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterInfo {
    pub name: String,
    /// Vulkan, Metal or Dx12.
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
    /// A program that plays GPU on the CPU: correct, and slower than our own CPU evaluator.
    Software,
}

impl AdapterInfo {
    pub(super) fn new(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        Self {
            name: info.name,
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

/// Every adapter that a driver offers, the best first.
#[cfg(not(target_arch = "wasm32"))]
pub fn adapters() -> Vec<AdapterInfo> {
    found(&instance()).iter().map(|(info, _)| info.clone()).collect()
}

/// Opens the best adapter that is not software, or, if `software` is welcome, the best of all.
///
/// # Errors
/// There is none, or it does not work.
#[cfg(not(target_arch = "wasm32"))]
pub fn open_best(software: bool) -> Result<Gpu, GpuError> {
    best(software).and_then(|(_, adapter)| Gpu::open(&adapter))
}

/// The best adapter that is not software, or, if `software` is welcome, the best of all, with the instance that found it.
///
/// # Errors
/// There is none.
#[cfg(not(target_arch = "wasm32"))]
pub fn best(software: bool) -> Result<(wgpu::Instance, wgpu::Adapter), GpuError> {
    let instance = instance();
    let found = found(&instance);
    let usable = found.iter().find(|(info, _)| software || info.kind != Kind::Software);
    match (usable, found.first()) {
        (Some((_, adapter)), _) => Ok((instance, adapter.clone())),
        (None, Some((info, _))) => Err(GpuError::NoAdapter(format!("there is only {}", info.name))),
        (None, None) => Err(GpuError::NoAdapter("no graphics driver offers one".to_owned())),
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
}

#[cfg(not(target_arch = "wasm32"))]
fn found(instance: &wgpu::Instance) -> Vec<(AdapterInfo, wgpu::Adapter)> {
    let adapters = pollster::block_on(instance.enumerate_adapters(BACKENDS));
    let mut found: Vec<_> =
        adapters.into_iter().map(|adapter| (AdapterInfo::new(&adapter), adapter)).collect();
    found.sort_by_key(|(info, _)| info.kind);
    found
}
