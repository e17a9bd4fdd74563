//! Pictures on the GPU have the colours of the CPU.

use sonoglyph::field::gpu::Texture;
use sonoglyph::field::{Colouring, Evaluator, Gpu, Picture, Quantity, Request, Scale, Stages};
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Plane, Scene};

use crate::{STEP, gpu, scattered};

/// r, g, b, a of every texel, row by row.
pub fn texels(gpu: &Gpu, texture: &Texture) -> Vec<[u8; 4]> {
    let (width, height) = texture.size;
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
    let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: (row * height) as u64,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row as u32), rows_per_image: None };
    let texture = texture.view().texture();
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    gpu.queue().submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = buffer.get_mapped_range(..).unwrap();
    let texel = |bytes: &[u8]| [bytes[0], bytes[1], bytes[2], bytes[3]];
    bytes.chunks(row).flat_map(|row| row[..4 * width].chunks(4).map(texel)).collect()
}

/// The texels of a picture painted on the GPU.
pub fn painted(stages: &mut Stages, request: &Request, colouring: &Colouring) -> Vec<[u8; 4]> {
    let Picture::OnGpu(texture) = stages.picture(request, colouring).unwrap() else {
        panic!("{:?} is not painted on the GPU", request.quantity)
    };
    assert_eq!(texture.size, request.size);
    texels(stages.gpu().unwrap(), &texture)
}

#[test]
fn the_gpu_colours_a_map_like_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let scene = Scene { plane: Plane { tolerance: 0.0, ..Plane::default() }, ..Scene::default() };
    let request = |quantity| Request {
        moment: 0.7,
        ..Request::new(&scene, vec![scattered(256, STEP)], quantity, (61, 43))
    };
    for (quantity, map, scale) in [
        (Quantity::Rms, ColourMap::Inferno, Scale::Linear),
        (Quantity::Rms, ColourMap::Inferno, Scale::Logarithmic),
        (Quantity::Phase, ColourMap::Cyclic, Scale::Linear),
        (Quantity::Instantaneous, ColourMap::Grey, Scale::Linear),
    ] {
        let request = request(quantity);
        let map_ = stages.map(&request).unwrap().clone();
        for full in [None, Some(0.5 * map_.peak)] {
            let colouring = Colouring { full, scale, ..Colouring::new(quantity, map.table()) };
            let got = painted(&mut stages, &request, &colouring);
            let mut expected = Vec::new();
            colouring.colours(&map_.values, map_.peak, &mut expected);
            assert_eq!(got.len(), expected.len());
            // At a step of the colour table rounding may go either way.
            let place =
                |pixel: &[u8; 4]| colouring.table.iter().position(|colour| colour == pixel).unwrap() as i32;
            let mut other = 0;
            for (got, expected) in got.iter().zip(&expected) {
                let apart = (place(got) - place(expected)).rem_euclid(256);
                assert!(apart.min(256 - apart) <= 1, "{quantity:?}: {got:?}, not {expected:?}");
                other += usize::from(apart != 0);
            }
            assert!(other * 50 < got.len(), "{quantity:?} {scale:?}: {other} of {} pixels", got.len());
        }
    }
}

#[test]
fn a_picture_allocates_its_textures_once() {
    let Some(gpu) = gpu() else { return };
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let mut scene = Scene { plane: Plane { tolerance: 0.0, ..Plane::default() }, ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (2, 2);
    let request = Request::new(&scene, vec![scattered(4, STEP)], Quantity::Rms, (9, 7));
    stages.map(&request).unwrap();
    let mut allocated = |map: ColourMap| {
        let before = stages.work().allocations;
        stages.picture(&request, &Colouring::new(Quantity::Rms, map.table())).unwrap();
        stages.work().allocations - before
    };
    // One for the pixels and one for the colours, and their parameters.
    assert!(allocated(ColourMap::Grey) >= 3);
    assert_eq!(allocated(ColourMap::Inferno), 0);
}
