// Values of a quantity from the parts of the sound, and the largest of them, so that a picture can be scaled without reading
// anything back. `src/field/quantity.rs` declares the formula; `sound`, `formula` and `extent` are written by
// `src/field/gpu/program.rs` from that.

struct FormParams {
    count: u32,
    invocations: u32,
    // 1/(ρc²), 1/(ρω²) and 1/(ρω).
    of_pressure: f32,
    of_gradient: f32,
    of_velocity: f32,
    // On the formula.
    factor: f32,
    // e^(jωt) of an instantaneous pressure.
    turn: vec2f,
}

// Pressure, and its slopes along the plane's axes and its normal.
struct Sound {
    p: vec2f,
    x: vec2f,
    y: vec2f,
    n: vec2f,
}

@group(0) @binding(0) var<uniform> c: FormParams;
// One part of the sound after the other.
@group(0) @binding(1) var<storage, read> parts: array<vec2f>;
@group(0) @binding(2) var<storage, read_write> values: array<f32>;
// Bits of a float that is not negative: they order as the float does.
@group(0) @binding(3) var<storage, read_write> peak: atomic<u32>;

@compute @workgroup_size(WORKGROUP)
fn form_main(@builtin(global_invocation_id) id: vec3u) {
    var largest = 0.0;
    for (var i = id.x; i < c.count; i += c.invocations) {
        let s = sound(i);
        let mean = c.factor * formula(s);
        let value = select(mean, sqrt(max(mean, 0.0)), IS_ROOT);
        values[i] = value;
        largest = max(largest, extent(s, value));
    }
    atomicMax(&peak, bitcast<u32>(largest));
}
