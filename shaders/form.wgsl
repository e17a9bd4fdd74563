// The value of the sound at a pixel, and the maximum, so that a picture can be scaled without read-back.
// `engine/src/field/quantity.rs` declares the formula; `formula` and `extent` are generated from it by
// `engine/src/field/gpu/program.rs`.

struct FormParams {
    // 1/(ρc²), 1/(ρω²) and 1/(ρω).
    of_pressure: f32,
    of_gradient: f32,
    of_velocity: f32,
    // Factor on the formula.
    factor: f32,
    // e^(jωt) of an instantaneous pressure.
    turn: vec2f,
}

@group(0) @binding(3) var<uniform> c: FormParams;
@group(0) @binding(4) var<storage, read_write> values: array<f32>;
// Bits of non-negative floats, which are ordered like the floats: the largest extent of the pixels that count for the
// peak, and of the others.
@group(0) @binding(5) var<storage, read_write> peak: array<atomic<u32>, 2>;

// The extent of the stored value.
fn put(pixel: u32, sound: Sound) -> f32 {
    let mean = c.factor * formula(sound);
    let value = select(mean, sqrt(max(mean, 0.0)), IS_ROOT);
    values[pixel] = value;
    return extent(sound, value);
}

fn finish(largest: f32, whose: u32) {
    let bits = bitcast<u32>(largest);
    // Reading is cheap, while writes of all invocations serialise.
    if bits > atomicLoad(&peak[whose]) {
        atomicMax(&peak[whose], bits);
    }
}
