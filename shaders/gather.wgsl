// What the panels want to know of a map: the parts of the sound at the probes, one part after the other, and the peak at the end.

struct GatherParams {
    // Values in a part, probes, and probes times parts.
    count: u32,
    probes: u32,
    gathered: u32,
}

@group(0) @binding(0) var<uniform> params: GatherParams;
@group(0) @binding(1) var<storage, read> parts: array<vec2f>;
@group(0) @binding(2) var<storage, read> places: array<u32>;
// Bits of a float.
@group(0) @binding(3) var<storage, read> peak: u32;
@group(0) @binding(4) var<storage, read_write> gathered: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn gather_main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i < params.gathered {
        gathered[i] = parts[(i / params.probes) * params.count + places[i % params.probes]];
    } else if i == params.gathered {
        gathered[i] = vec2f(bitcast<f32>(peak), 0.0);
    }
}
