//! GPU adapters: enumeration and selection.

use crate::field::gpu::device::Gpu;
use crate::field::gpu::tuning::{AdapterInfo, Kind};
use crate::field::gpu_report::GpuError;

/// Interfaces that compute. Without OpenGL, which offers the same adapters with half of their limits; closing it beside
/// Vulkan devices of other threads deadlocked NVIDIA's driver (580.159).
const BACKENDS: wgpu::Backends = wgpu::Backends::PRIMARY;

#[cfg(not(target_arch = "wasm32"))]
const NONE: &str = "no graphics driver offers one";

#[cfg(target_arch = "wasm32")]
const NONE: &str = "the browser offers none by WebGPU";

/// Every adapter that a driver offers, the best first.
#[cfg(not(target_arch = "wasm32"))]
pub fn adapters() -> Vec<AdapterInfo> {
    pollster::block_on(found(&instance())).iter().map(|(info, _)| info.clone()).collect()
}

/// Opens the best hardware adapter or, if `software` is allowed, the best of all.
///
/// # Errors
/// A missing or faulty adapter.
#[cfg(not(target_arch = "wasm32"))]
pub fn open_best(software: bool) -> Result<Gpu, GpuError> {
    pollster::block_on(open(software))
}

/// The same without blocking: a browser answers between two tasks of the page.
///
/// # Errors
/// The errors of [`best`].
pub async fn open(software: bool) -> Result<Gpu, GpuError> {
    let (_, adapter) = find(software).await?;
    Gpu::open(&adapter).await
}

/// The best hardware adapter or, if `software` is allowed, the best of all, with its instance.
///
/// # Errors
/// There is none.
#[cfg(not(target_arch = "wasm32"))]
pub fn best(software: bool) -> Result<(wgpu::Instance, wgpu::Adapter), GpuError> {
    pollster::block_on(find(software))
}

async fn find(software: bool) -> Result<(wgpu::Instance, wgpu::Adapter), GpuError> {
    let instance = instance();
    let found = found(&instance).await;
    let usable = found.iter().find(|(info, _)| software || info.kind != Kind::Software);
    match (usable, found.first()) {
        (Some((_, adapter)), _) => Ok((instance, adapter.clone())),
        (None, Some((info, _))) => Err(GpuError::NoAdapter(format!("there is only {}", info.name))),
        (None, None) => Err(GpuError::NoAdapter(NONE.to_owned())),
    }
}

fn instance() -> wgpu::Instance {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    wgpu::Instance::new(wgpu::InstanceDescriptor { backends: descriptor.backends & BACKENDS, ..descriptor })
}

async fn found(instance: &wgpu::Instance) -> Vec<(AdapterInfo, wgpu::Adapter)> {
    let mut found: Vec<_> =
        offered(instance).await.into_iter().map(|adapter| (AdapterInfo::new(&adapter), adapter)).collect();
    found.sort_by_key(|(info, _)| info.kind);
    found
}

#[cfg(not(target_arch = "wasm32"))]
async fn offered(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    instance.enumerate_adapters(BACKENDS).await
}

/// A browser offers one adapter at a time, and the fast one only on request.
#[cfg(target_arch = "wasm32")]
async fn offered(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let power_preference = wgpu::PowerPreference::HighPerformance;
    let options = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
    instance.request_adapter(&options).await.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requirement::found;

    #[test]
    fn the_best_of_all_listed_adapters_is_opened() {
        let Some(gpu) = found("gpu", open_best(true)) else { return };
        let all = adapters();
        assert!(all.is_sorted_by_key(|info| info.kind), "{all:?}");
        assert_eq!(all.first(), Some(gpu.info()));
    }
}
