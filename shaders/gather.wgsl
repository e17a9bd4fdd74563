// The results of a map for panels: the parts of the sound at the probes in sequence, and the largest extents at the end.

struct GatherParams {
    // Probes computed here, and those of the whole map.
    probes: u32,
    all: u32,
    parts: u32,
    // The part with the weights of slopes.
    sloped: u32,
    // Number of samples of a sound, their stride, and the stride of parts.
    taps: u32,
    tap_stride: u32,
    part_stride: u32,
}

@group(0) @binding(0) var<uniform> params: GatherParams;
@group(0) @binding(1) var<storage, read> samples: array<vec2f>;
// For every probe its index, its first sample, and the bits of its weights, of values and of slopes.
@group(0) @binding(2) var<storage, read> probes: array<u32>;
// Bits of floats: the peak, and the largest of the pixels that do not count for it.
@group(0) @binding(3) var<storage, read> peak: vec2u;
@group(0) @binding(4) var<storage, read_write> gathered: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn gather_main(@builtin(global_invocation_id) id: vec3u) {
    if id.x == 0u {
        gathered[params.parts * params.all] = bitcast<vec2f>(peak);
    }
    if id.x >= params.parts * params.probes {
        return;
    }
    let part = id.x / params.probes;
    let probe = (id.x % params.probes) * (2u + 2u * params.taps);
    var weight = probe + 2u + select(0u, params.taps, part == params.sloped);
    var at = probes[probe + 1u] + part * params.part_stride;
    var sum = vec2f(0.0);
    // Not on uniforms alone, as in the field's.
    let taps = params.taps + id.z;
    for (var tap = 0u; tap < taps; tap++) {
        sum += bitcast<f32>(probes[weight]) * samples[at];
        weight++;
        at += params.tap_stride;
    }
    gathered[part * params.all + probes[probe]] = sum;
}
