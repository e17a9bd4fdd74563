//! Paints a map as a texture on its device.

use wgpu::{BindingResource, TextureUsages};

use crate::field::colouring::{Colouring, SMALLEST, Scale};
use crate::field::gpu::Gpu;
use crate::field::gpu::device::Step;
use crate::field::gpu::program::{PictureParams, Program};
use crate::field::gpu::tuning::WORKGROUP;

/// A picture on the GPU, r, g, b, a in 8 bits each; of a map row 0 is at the smallest y, of space at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    view: wgpu::TextureView,
    /// Width and height in pixels.
    pub size: (usize, usize),
}

impl Texture {
    pub(super) fn new(view: wgpu::TextureView, size: (usize, usize)) -> Self {
        Self { view, size }
    }

    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }
}

/// The values of a map and their peak, to be painted.
pub(super) struct Source<'a> {
    pub(super) values: &'a wgpu::Buffer,
    pub(super) peak: &'a wgpu::Buffer,
    pub(super) size: (usize, usize),
}

/// The painting pass with its texture.
#[derive(Debug)]
pub(super) struct Painting {
    texture: Texture,
    step: Step,
    scale: Scale,
    colours: wgpu::Texture,
    params: wgpu::Buffer,
    /// The colours and the run of the current picture.
    painted: Option<(Colouring, u64)>,
}

impl Painting {
    pub(super) fn new(gpu: &Gpu, source: &Source<'_>, scale: Scale) -> Self {
        let size = source.size;
        let picture = texture(gpu, "map", size, TextureUsages::STORAGE_BINDING);
        let view = picture.create_view(&Default::default());
        let colours = texture(gpu, "colours", (256, 1), TextureUsages::COPY_DST);
        let params = gpu.params(&[0; size_of::<PictureParams>()]);
        let (width, height) = (size.0 as u32, size.1 as u32);
        let step = gpu.step(
            Program::Picture(scale),
            &[
                (0, params.as_entire_binding()),
                (1, source.values.as_entire_binding()),
                (2, source.peak.as_entire_binding()),
                (3, BindingResource::TextureView(&colours.create_view(&Default::default()))),
                (4, BindingResource::TextureView(&view)),
            ],
            (width.div_ceil(WORKGROUP), height),
        );
        Self { texture: Texture { view, size }, step, scale, colours, params, painted: None }
    }

    pub(super) fn scale(&self) -> Scale {
        self.scale
    }

    /// The picture of a `run`, and whether it was repainted.
    pub(super) fn paint(&mut self, gpu: &Gpu, colouring: &Colouring, run: u64) -> (Texture, bool) {
        let before = self.painted.as_ref();
        if before.is_some_and(|(painted, of)| painted == colouring && *of == run) {
            return (self.texture.clone(), false);
        }
        if before.is_none_or(|(painted, _)| painted != colouring) {
            let line = colouring.line();
            let params = PictureParams {
                width: self.texture.size.0 as u32,
                zero: line.zero,
                spread: line.spread,
                full: line.full.map_or(0.0, |full| full.max(SMALLEST)),
            };
            gpu.queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
            gpu.queue.write_texture(
                self.colours.as_image_copy(),
                bytemuck::cast_slice(&colouring.table),
                wgpu::TexelCopyBufferLayout::default(),
                self.colours.size(),
            );
        }
        let mut encoder = gpu.encoder();
        self.step.run(&mut encoder.begin_compute_pass(&Default::default()));
        gpu.submit(encoder);
        self.painted = Some((colouring.clone(), run));
        (self.texture.clone(), true)
    }
}

/// A texture of colours that programs read or write, and others may copy or draw.
pub(super) fn texture(
    gpu: &Gpu,
    label: &str,
    (width, height): (usize, usize),
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.count(|traffic| traffic.allocations += 1);
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
