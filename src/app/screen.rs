//! The device that draws the window with wgpu.

use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use egui::TextureId;

use crate::field::gpu::Texture;
use crate::field::{Evaluator, Gpu};

#[derive(Clone)]
pub struct Screen(RenderState);

impl Screen {
    /// The device of eframe's window, if drawn by wgpu.
    pub fn of(context: &eframe::CreationContext<'_>) -> Option<Self> {
        context.wgpu_render_state.clone().map(Self)
    }

    /// The field by the same device.
    pub fn evaluator(&self) -> Evaluator {
        let (device, queue) = (self.0.device.clone(), self.0.queue.clone());
        Evaluator::Gpu(Box::new(Gpu::on(&self.0.adapter, device, queue)))
    }

    /// The texture id of a picture on the device.
    pub fn register(&self, registered: &mut Option<(Texture, TextureId)>, texture: Texture) -> TextureId {
        let (filter, device) = (wgpu::FilterMode::Linear, &self.0.device);
        let id = match registered.take() {
            Some((known, id)) if known == texture => id,
            Some((_, id)) => {
                let mut renderer = self.0.renderer.write();
                renderer.update_egui_texture_from_wgpu_texture(device, texture.view(), filter, id);
                id
            }
            None => self.0.renderer.write().register_native_texture(device, texture.view(), filter),
        };
        *registered = Some((texture, id));
        id
    }
}
