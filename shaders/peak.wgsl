// The largest number that is shown of a field, so that a picture can be scaled without reading the field back.

struct PeakParams {
    count: u32,
    invocations: u32,
}

@group(0) @binding(0) var<uniform> params: PeakParams;
@group(0) @binding(1) var<storage, read> pressure: array<vec2f>;
// Bits of a float that is not negative: they order as the float does.
@group(0) @binding(2) var<storage, read_write> peak: atomic<u32>;

@compute @workgroup_size(WORKGROUP)
fn peak_main(@builtin(global_invocation_id) id: vec3u) {
    var largest = 0.0;
    for (var i = id.x; i < params.count; i += params.invocations) {
        largest = max(largest, shown(pressure[i]));
    }
    atomicMax(&peak, bitcast<u32>(largest));
}
