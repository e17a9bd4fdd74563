// Values where the sound is known at the pixels.

struct DirectParams {
    columns: u32,
    // Total number of sounds.
    count: u32,
    first_pixel: u32,
}

@group(0) @binding(0) var<uniform> params: DirectParams;
// Parts of the sound in sequence.
@group(0) @binding(1) var<storage, read> parts: array<vec2f>;
// A bit for each, set if it does not count for the peak.
@group(0) @binding(2) var<storage, read> left_out: array<u32>;

fn part(place: u32, i: u32) -> vec2f {
    if place == NOWHERE {
        return vec2f(0.0);
    }
    return parts[place * params.count + i];
}

@compute @workgroup_size(WORKGROUP)
fn direct_main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < params.columns {
        let i = id.y * params.columns + id.x;
        let sound = Sound(part(PRESSURE, i), part(ALONG_X, i), part(ALONG_Y, i), part(NORMAL, i));
        finish(put(params.first_pixel + i, sound), (left_out[i / 32u] >> (i % 32u)) & 1u);
    }
}
