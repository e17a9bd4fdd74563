//! Renders 3D pictures on the GPU.

use std::sync::Arc;

use wgpu::{BindingResource, BufferUsages, TextureUsages};

use crate::field::gpu::painting::{Texture, texture};
use crate::field::gpu::program::{Program, Seen};
use crate::field::gpu::{Gpu, Reading};
use crate::field::gpu_report::GpuError;
use crate::field::volume::scenery::{Body, Shot};
use crate::field::volume::{Scenery, Volume};

/// Pixels along the side of a workgroup's block.
const BLOCK: u32 = 8;

/// Draws 3D pictures; keeps the field on the device while it is unchanged.
#[derive(Debug, Default)]
pub struct SpacePainting {
    field: Option<Field>,
    canvas: Option<(wgpu::Texture, Texture)>,
}

/// A field on the device.
#[derive(Debug)]
struct Field {
    of: Arc<Volume>,
    values: wgpu::Buffer,
    bricks: wgpu::Buffer,
}

impl SpacePainting {
    /// A picture, its top row first, with smooth edges or quickly. Without waiting for it.
    ///
    /// # Errors
    /// The device was lost, or has no room.
    pub fn paint(
        &mut self,
        gpu: &Gpu,
        (shot, scenery): (&Shot, &Scenery),
        volume: &Arc<Volume>,
        is_smooth: bool,
    ) -> Result<Texture, GpuError> {
        let most = gpu.device.limits().max_texture_dimension_2d as usize;
        let bytes = size_of_val(&volume.values[..]) as u64;
        if shot.size.0.max(shot.size.1) > most || bytes > gpu.buffer_limit {
            return Err(GpuError::Refused("the picture or its field is too large".to_owned()));
        }
        let storage = |label: &str, contents: &[u8]| {
            // An empty buffer cannot be bound.
            let contents = if contents.is_empty() { &[0; 64][..] } else { contents };
            gpu.filled(label, contents, BufferUsages::STORAGE)
        };
        let field = match self.field.take() {
            Some(field) if Arc::ptr_eq(&field.of, volume) => field,
            Some(_) | None => Field {
                of: Arc::clone(volume),
                values: storage("volume", bytemuck::cast_slice(&volume.values)),
                bricks: storage("bricks", bytemuck::cast_slice(&volume.bricks)),
            },
        };
        let canvas = match self.canvas.take() {
            Some(canvas) if canvas.1.size == shot.size => canvas,
            Some(_) | None => {
                let picture = texture(gpu, "space", shot.size, TextureUsages::STORAGE_BINDING);
                let view = picture.create_view(&Default::default());
                (picture, Texture::new(view, shot.size))
            }
        };
        let colours = texture(gpu, "colours", (256, 1), TextureUsages::COPY_DST);
        gpu.queue.write_texture(
            colours.as_image_copy(),
            bytemuck::cast_slice(&scenery.table),
            wgpu::TexelCopyBufferLayout::default(),
            colours.size(),
        );
        let seen = match shot.body {
            Body::Hidden => Seen::Nothing,
            Body::Surface(_) => Seen::Surface,
            Body::Projection => Seen::Projection,
        };
        let params = gpu.params(bytemuck::bytes_of(&shot.params));
        let things = storage("things", bytemuck::cast_slice(&shot.things));
        let tiles = storage("tiles", bytemuck::cast_slice(&shot.tiles));
        let step = gpu.step(
            Program::Volume(seen, is_smooth),
            &[
                (0, params.as_entire_binding()),
                (1, field.values.as_entire_binding()),
                (2, field.bricks.as_entire_binding()),
                (3, things.as_entire_binding()),
                (4, tiles.as_entire_binding()),
                (5, BindingResource::TextureView(&colours.create_view(&Default::default()))),
                (6, BindingResource::TextureView(canvas.1.view())),
            ],
            ((shot.size.0 as u32).div_ceil(BLOCK), (shot.size.1 as u32).div_ceil(BLOCK)),
        );
        let mut encoder = gpu.encoder();
        step.run(&mut encoder.begin_compute_pass(&Default::default()));
        gpu.submit(encoder);
        let picture = canvas.1.clone();
        (self.field, self.canvas) = (Some(field), Some(canvas));
        gpu.check()?;
        Ok(picture)
    }

    /// The colours r, g, b, a of the last picture, from the top left. Blocks.
    ///
    /// # Errors
    /// The device was lost, or has no room.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, GpuError> {
        let Some((picture, Texture { size: (width, height), .. })) = &self.canvas else {
            return Ok(Vec::new());
        };
        let stride = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
        let buffer = gpu.storage("picture", (stride * height) as u64);
        let mut encoder = gpu.encoder();
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride as u32),
                    rows_per_image: None,
                },
            },
            picture.size(),
        );
        let bytes = Reading::new(gpu, encoder, &buffer).wait(gpu)?;
        Ok(bytes.chunks_exact(stride).flat_map(|row| &row[..width * 4]).copied().collect())
    }
}
