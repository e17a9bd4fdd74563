// From values to colours: each is scaled and looked up in a table of 256 colours.

struct PictureParams {
    width: u32,
    // The index of 0 and the number of indices between it and `full`; on a logarithmic scale, the index of `full` and
    // the number of indices per octave.
    zero: f32,
    spread: f32,
    // The value of the last colour; 0 for the peak.
    full: f32,
}

@group(0) @binding(0) var<uniform> params: PictureParams;
@group(0) @binding(1) var<storage, read> values: array<f32>;
// Bits of a float.
@group(0) @binding(2) var<storage, read> peak: u32;
// A texture, since software drivers read textures faster than buffers.
@group(0) @binding(3) var colours: texture_2d<f32>;
@group(0) @binding(4) var picture: texture_storage_2d<rgba8unorm, write>;

fn place(value: f32, full: f32) -> f32 {
    if LOGARITHMIC {
        return params.zero + params.spread * log2(clamp(value / full, SMALLEST, 1.0));
    }
    return params.zero + value * (params.spread / full);
}

@compute @workgroup_size(WORKGROUP)
fn picture_main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < params.width {
        let full = max(select(params.full, bitcast<f32>(peak), params.full == 0.0), SMALLEST);
        let colour = clamp(place(values[id.y * params.width + id.x], full), 0.0, 255.0);
        textureStore(picture, id.xy, textureLoad(colours, vec2u(u32(colour + 0.5), 0u), 0));
    }
}
